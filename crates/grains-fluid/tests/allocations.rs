//! A step of one phase on one rank allocates nothing.

#![allow(clippy::unwrap_used)]

use grains_domain::SerialTransport;
use grains_fluid::{Boundaries, Condition, Flow, FlowSetup, Grid, Side};
use grains_testing::CountingAllocator;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

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
        let before = ALLOCATOR.count();
        for _ in 0..10 {
            flow.step(0.01, &SerialTransport).unwrap();
        }
        let allocated = ALLOCATOR.count() - before;
        // Coefficients of mixtures are averaged in a few short arrays per step.
        let allowed = if mixture.is_some() { 20 * 10 } else { 0 };
        assert!(allocated <= allowed, "{mixture:?}: {allocated}");
    }
}
