//! An allocator that counts, to show that a step allocates nothing.

#![allow(unsafe_code)] // an allocator

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

/// The allocator of the system, which counts the allocations of every thread: the program that runs tests has its own.
pub struct CountingAllocator;

impl CountingAllocator {
    /// Allocations of this thread so far.
    pub fn count(&self) -> u64 {
        COUNT.get()
    }

    fn add(&self) {
        COUNT.set(COUNT.get() + 1);
    }
}

// SAFETY: every call is handed on to the allocator of the system.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        self.add();
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        self.add();
        unsafe { System.realloc(pointer, layout, size) }
    }
}
