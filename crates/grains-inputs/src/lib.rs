//! All that the program reads, as functions of any bytes.
//!
//! Each function takes bytes as the content of a file and answers whether they were accepted. It must neither panic nor run for
//! long, nor ask for more memory than [`LARGEST`] at once. The fuzzer (`scripts/fuzz`) calls them, and so does the test
//! `mpi-tests/corpus.rs` with the inputs that the fuzzer has kept.

mod cases;
mod folders;
mod geometry;
mod memory;
mod restart;
mod scripts;

pub use cases::{case, check, formula, table};
pub use folders::Folders;
pub use geometry::mesh;
pub use memory::{LARGEST, LimitedAllocator};
pub use restart::restart;
pub use scripts::{command, import, study};

/// A function of any bytes, with the folders it may read and write.
pub type Target = fn(&[u8], &Folders) -> bool;

/// The targets by their names.
pub const TARGETS: [(&str, Target); 9] = [
    ("case", case),
    ("check", check),
    ("command", command),
    ("formula", formula),
    ("import", import),
    ("mesh", mesh),
    ("restart", restart),
    ("study", study),
    ("table", table),
];

/// The bytes as text, if they are one.
fn text(bytes: &[u8]) -> Option<&str> {
    std::str::from_utf8(bytes).ok()
}
