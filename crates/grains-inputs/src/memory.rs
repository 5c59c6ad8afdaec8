//! An allocator with a limit, to find allocations that only a wrong input asks for.

#![allow(unsafe_code)] // an allocator

use std::alloc::{GlobalAlloc, Layout, System};

/// Largest allocation (bytes) of an input of some kilobytes.
pub const LARGEST: usize = 1 << 28;

/// The allocator of the system, which ends the process where more than [`LARGEST`] bytes are wanted at once.
pub struct LimitedAllocator;

fn check(size: usize) {
    if size > LARGEST {
        eprintln!("an allocation of {size} bytes");
        std::process::abort();
    }
}

// SAFETY: every call is handed on to the allocator of the system.
unsafe impl GlobalAlloc for LimitedAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        check(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        check(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        check(size);
        unsafe { System.realloc(pointer, layout, size) }
    }
}
