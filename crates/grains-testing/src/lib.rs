//! What the tests of several crates need: ranks that are threads of one process, and an allocator that counts.

mod allocations;
mod threads;

pub use allocations::CountingAllocator;
pub use threads::{ThreadTransport, on_ranks};
