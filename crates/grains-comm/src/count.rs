//! Numbers as MPI counts them.

/// A number of values, or of messages, as MPI counts them.
///
/// # Panics
/// Ends the job if there are more than MPI can count (2³¹ − 1): a message of 16 GiB.
pub(crate) fn count(length: usize) -> i32 {
    i32::try_from(length).unwrap_or_else(|_| {
        panic!("{length} values are more than one MPI message can hold (2147483647): use more ranks")
    })
}
