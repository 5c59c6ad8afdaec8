//! A step of one phase on one rank allocates nothing.

#![allow(clippy::unwrap_used)]
#![allow(unsafe_code)] // an allocator that counts

use grains_domain::SerialTransport;
use grains_fluid::{Boundaries, Condition, Flow, FlowSetup, Grid, Side};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering};

struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

// SAFETY: every call is handed on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_step_allocates_nothing() {
    for mixture in [None, Some(grains_fluid::MixtureModel::A)] {
        let lid = Condition::Wall { velocity: [1.0, 0.0, 0.0] };
        let grid = Grid::uniform([0.0; 3], [1.0; 3], [12, 10, 8], [false, false, true]).unwrap();
        let boundaries = Boundaries::default().with(1, Side::High, lid);
        let setup = FlowSetup { boundaries, mixture, ..FlowSetup::new(grid, 1.0, 0.01) };
        let mut flow = Flow::new(setup, &SerialTransport).unwrap();
        for _ in 0..3 {
            flow.step(0.01, &SerialTransport).unwrap();
        }
        let before = ALLOCATIONS.load(Ordering::Relaxed);
        for _ in 0..10 {
            flow.step(0.01, &SerialTransport).unwrap();
        }
        let allocated = ALLOCATIONS.load(Ordering::Relaxed) - before;
        // Coefficients of mixtures are averaged in a few short arrays per step.
        let allowed = if mixture.is_some() { 20 * 10 } else { 0 };
        assert!(allocated <= allowed, "{mixture:?}: {allocated}");
    }
}
