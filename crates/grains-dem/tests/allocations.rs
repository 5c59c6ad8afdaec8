//! A step that rebuilds no list allocates nothing.

#![allow(clippy::unwrap_used)]

#[allow(dead_code)] // it uses a part
#[path = "dem/common.rs"]
mod common;

use common::{Scene, lattice, law, mixed_shapes, setup, wall};
use grains_dem::{CollisionModel, HardModel, Loading, Motion, Shear, Surface};
use grains_domain::SerialTransport;
use grains_geometry::Vec3;
use grains_testing::CountingAllocator;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// Tests of one program run side by side: what one allocates the other must not count.
#[test]
fn a_step_between_rebuilds_allocates_nothing() {
    for is_hard in [false, true] {
        quiet_steps_allocate_nothing(is_hard);
    }
    quiet_steps_of_a_sheared_box_allocate_nothing();
}

fn quiet_steps_of_a_sheared_box_allocate_nothing() {
    let mut setup = setup([0.02; 3], [true; 3], mixed_shapes(1e-3), law(true));
    setup.planes.clear();
    setup.parameters.gravity = Vec3::zeros();
    setup.shear = Some(Shear { flow: 0, gradient: 2, rate: 5.0 });
    let mut dem = Scene { setup, particles: lattice([0.0; 3], [0.02; 3], 2.5e-3, 4, 0.5) }.start([1; 3], 0);
    let mut quiet = 0;
    for step in 0..6000 {
        let (before, rebuilds) = (ALLOCATOR.count(), dem.report.rebuilds);
        dem.step(&SerialTransport).unwrap();
        if step > 3000 && dem.report.rebuilds == rebuilds {
            assert_eq!(ALLOCATOR.count() - before, 0, "step {step}");
            quiet += 1;
        }
    }
    assert!(quiet > 1000, "{quiet} steps without rebuild");
}

fn quiet_steps_allocate_nothing(is_hard: bool) {
    let mut setup = setup([0.02; 3], [true, true, false], mixed_shapes(1e-3), law(true));
    let floor = Surface::Plane { point: Vec3::zeros(), normal: Vec3::z() };
    let lid = Surface::Plane { point: Vec3::new(0.0, 0.0, 0.0125), normal: -Vec3::z() };
    let load = Loading {
        axis: -Vec3::z(),
        force: 0.05,
        mass: 0.01,
        damping: 0.1,
        max_speed: 0.1,
        velocity: Vec3::x() * 0.01,
        start: 0.0,
        end: f64::INFINITY,
    };
    setup.walls = vec![wall("floor", floor, Motion::Fixed)];
    if !is_hard {
        setup.walls.push(wall("lid", lid, Motion::Loaded(load)));
    }
    if is_hard {
        setup.collisions = CollisionModel::Hard(HardModel::new(&setup.parameters));
    }
    let particles = lattice([0.0, 0.0, 0.001], [0.02, 0.02, 0.012], 2.2e-3, 4, 0.2);
    let mut dem = Scene { setup, particles }.start([1; 3], 0);
    let (mut quiet, mut contacts) = (0, 0);
    for step in 0..6000 {
        let (before, rebuilds) = (ALLOCATOR.count(), dem.report.rebuilds);
        dem.step(&SerialTransport).unwrap();
        let allocated = ALLOCATOR.count() - before;
        // Scratch space has grown to its size after a while.
        if step > 3000 && dem.report.rebuilds == rebuilds {
            assert_eq!(allocated, 0, "step {step}, hard {is_hard}");
            quiet += 1;
            contacts += usize::from(dem.report.max_overlap > 0.0);
        }
    }
    assert!(
        quiet > 1000 && contacts > if is_hard { 300 } else { 1000 },
        "{quiet} steps without rebuild, {contacts} with contacts"
    );
}
