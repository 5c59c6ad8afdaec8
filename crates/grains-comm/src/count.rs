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

#[cfg(test)]
mod tests {
    use super::count;

    #[test]
    fn messages_beyond_the_largest_of_mpi_end_the_job_by_name() {
        assert_eq!(count(i32::MAX as usize), i32::MAX);
        for length in [1 << 31, 1 << 32, (1 << 32) + 5, usize::MAX] {
            let refused = std::panic::catch_unwind(|| count(length)).unwrap_err();
            let message = refused.downcast_ref::<String>().cloned().unwrap_or_default();
            assert!(message.contains(&length.to_string()) && message.contains("more ranks"), "{message}");
        }
    }
}
