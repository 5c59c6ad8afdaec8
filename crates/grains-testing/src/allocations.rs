//! An allocator that counts, to show that a step allocates nothing.

#![allow(unsafe_code)] // an allocator

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering};

/// The allocator of the system, which counts allocations. It counts those of the whole process, so a test program that
/// uses it holds one test only.
pub struct CountingAllocator {
    count: AtomicU64,
}

impl CountingAllocator {
    /// For `#[global_allocator] static …`.
    #[allow(clippy::new_without_default)] // a static needs a const function
    pub const fn new() -> Self {
        Self { count: AtomicU64::new(0) }
    }

    /// Allocations so far.
    pub fn count(&self) -> u64 {
        self.count.load(Ordering::Relaxed)
    }
}

// SAFETY: every call is handed on to the allocator of the system.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        self.count.fetch_add(1, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        self.count.fetch_add(1, Ordering::Relaxed);
        unsafe { System.realloc(pointer, layout, size) }
    }
}
