//! The state does not depend on the number of ranks, the decomposition, or a restart: bit for bit.

use crate::common::{Scene, assert_same, knobbly_shapes, lattice, law, mixed_shapes, setup, wall};
use grains_contact::{ImpulseScheme, Lubrication, Sharing};
use grains_dem::{CollisionModel, ExchangeStrategy, FaceContact, HardModel, Motion, Skin, Surface};
use grains_domain::{Balance, SerialTransport, Transport};
use grains_geometry::{Core, Mat3, SMOOTH_ANGLE, Shape, TriMesh, Vec3, WallMesh};
use grains_testing::on_ranks;
use std::sync::Arc;

const GRIDS: [[usize; 3]; 6] = [[2, 1, 1], [1, 3, 1], [2, 2, 1], [1, 1, 4], [2, 2, 2], [4, 1, 2]];

/// Bed of spheres of several sizes between a vibrating floor, a plane and a mesh hopper, settling.
fn silo() -> Scene {
    let mut setup = setup([0.04, 0.04, 0.06], [false; 3], vec![Shape::sphere(1.5e-3).unwrap()], law(true));
    let hopper = TriMesh::from_polygons(
        vec![
            Vec3::new(-0.001, -0.001, 0.02),
            Vec3::new(0.041, -0.001, 0.02),
            Vec3::new(0.041, 0.041, 0.02),
            Vec3::new(-0.001, 0.041, 0.02),
            Vec3::new(0.015, 0.015, 0.004),
            Vec3::new(0.025, 0.015, 0.004),
            Vec3::new(0.025, 0.025, 0.004),
            Vec3::new(0.015, 0.025, 0.004),
        ],
        &[vec![0, 1, 5, 4], vec![1, 2, 6, 5], vec![2, 3, 7, 6], vec![3, 0, 4, 7]],
    )
    .unwrap();
    let shake = Motion::Oscillation {
        amplitude: Vec3::new(2e-4, 1e-4, 1e-4),
        frequency: 60.0,
        phase: 0.3,
        start: 0.0,
        end: f64::INFINITY,
    };
    setup.walls = vec![
        wall("hopper", Surface::Mesh(Arc::new(WallMesh::new(&hopper, SMOOTH_ANGLE).unwrap())), shake.clone()),
        wall("floor", Surface::Plane { point: Vec3::new(0.0, 0.0, 0.002), normal: Vec3::z() }, shake),
    ];
    for (a, normal) in [(0, Vec3::x()), (0, -Vec3::x()), (1, Vec3::y()), (1, -Vec3::y())] {
        let mut point = Vec3::repeat(0.0005);
        if normal[a] < 0.0 {
            point[a] = 0.0395;
        }
        setup.walls.push(wall("side", Surface::Plane { point, normal }, Motion::Fixed));
    }
    let particles = lattice([0.001, 0.001, 0.022], [0.039, 0.039, 0.04], 3.2e-3, 1, 1.0);
    Scene { setup, particles }
}

/// Periodic shear of mixed cubes, cylinders, icosahedra and spheres.
fn shear(spring: bool) -> Scene {
    let mut setup = setup([0.03, 0.03, 0.03], [true; 3], mixed_shapes(1.4e-3), law(spring));
    setup.parameters.gravity = Vec3::new(3.0, -2.0, -9.81);
    let mut particles = lattice([0.0; 3], [0.03; 3], 3.0e-3, 4, 2.0);
    for p in &mut particles {
        p.velocity.x += 100.0 * (p.position.z - 0.015);
    }
    Scene { setup, particles }
}

/// Mixed shapes drifting over a floor in a box periodic along the floor: particles wrap while in contact.
fn drift() -> Scene {
    let mut setup = setup([0.03, 0.03, 0.03], [true, true, false], mixed_shapes(1.4e-3), law(true));
    setup.parameters.gravity = Vec3::new(4.0, 3.0, -30.0);
    let floor = Surface::Plane { point: Vec3::new(0.0, 0.0, 0.001), normal: Vec3::z() };
    setup.walls = vec![wall("floor", floor, Motion::Fixed)];
    let mut particles = lattice([0.0, 0.0, 0.001], [0.03, 0.03, 0.0072], 3.0e-3, 4, 0.5);
    for p in &mut particles {
        p.velocity += Vec3::new(2.0, -1.0, -0.5);
    }
    Scene { setup, particles }
}

/// The same over a wavy mesh without end and past boxes, one of them at a periodic face: elements of walls
/// come near and go, and are met through images.
fn drift_over_waves() -> Scene {
    const CELLS: usize = 8;
    let mut scene = drift();
    let length = 0.03;
    let step = length / CELLS as f64;
    let node = |k: usize, l: usize| {
        let (x, y) = ((k as f64 - 1.0) * step, (l as f64 - 1.0) * step);
        let wave = |x: f64| (std::f64::consts::TAU * x / length).sin();
        Vec3::new(x, y, 0.002 + 4e-4 * (wave(x) + wave(2.0 * y)))
    };
    let side = CELLS + 3;
    let vertices: Vec<Vec3> = (0..side * side).map(|n| node(n % side, n / side)).collect();
    let faces: Vec<Vec<usize>> = (0..(side - 1) * (side - 1))
        .map(|n| (n % (side - 1), n / (side - 1)))
        .map(|(k, l)| l * side + k)
        .flat_map(|n| {
            let row = side;
            [vec![n, n + 1, n + row + 1], vec![n, n + row + 1, n + row]]
        })
        .collect();
    let mesh = TriMesh::from_polygons(vertices, &faces).unwrap();
    let mut floor =
        wall("floor", Surface::Mesh(Arc::new(WallMesh::new(&mesh, SMOOTH_ANGLE).unwrap())), Motion::Fixed);
    floor.spans = [true, true, false];
    let block = |center: Vec3, half: Vec3| {
        let (core, bounding_radius) = (Core::Box(half), half.norm());
        wall(
            "block",
            Surface::Solid { core, rotation: Mat3::identity(), center, bounding_radius },
            Motion::Fixed,
        )
    };
    scene.setup.walls = vec![
        floor,
        block(Vec3::new(0.0285, 0.012, 0.003), Vec3::new(0.0014, 0.002, 0.002)),
        block(Vec3::new(0.014, 0.02, 0.003), Vec3::new(0.002, 0.0015, 0.002)),
    ];
    for p in &mut scene.particles {
        p.position.z += 0.005;
    }
    scene
}

#[test]
fn a_shaken_hopper_of_spheres_is_the_same_on_any_ranks() {
    let scene = silo();
    let reference = scene.run([1, 1, 1], 3000);
    for grid in GRIDS {
        assert_same(&reference, &scene.run(grid, 3000), &format!("grid {grid:?}"));
    }
}

#[test]
fn a_periodic_shear_of_mixed_shapes_is_the_same_on_any_ranks() {
    for spring in [true, false] {
        let scene = shear(spring);
        let reference = scene.run([1, 1, 1], 800);
        for grid in GRIDS {
            assert_same(&reference, &scene.run(grid, 800), &format!("spring {spring}, grid {grid:?}"));
        }
    }
}

/// A column of mixed shapes in a corner of a long box, which collapses.
fn dam() -> Scene {
    let mut setup = setup([0.06, 0.02, 0.05], [false, true, false], mixed_shapes(1.4e-3), law(true));
    setup.parameters.gravity = Vec3::new(0.0, 0.0, -30.0);
    let plane = |point, normal| wall("wall", Surface::Plane { point, normal }, Motion::Fixed);
    setup.walls = vec![
        plane(Vec3::new(0.0, 0.0, 0.001), Vec3::z()),
        plane(Vec3::new(0.001, 0.0, 0.0), Vec3::x()),
        plane(Vec3::new(0.059, 0.0, 0.0), -Vec3::x()),
    ];
    let particles = lattice([0.001, 0.0, 0.001], [0.016, 0.02, 0.025], 3.0e-3, 4, 0.5);
    Scene { setup, particles }
}

#[test]
fn borders_that_move_to_the_work_change_no_bit() {
    const STEPS: u64 = 2000;
    let mut scene = dam();
    let reference = scene.run([1; 3], STEPS);
    let min_width = [scene.setup.interaction_range(); 3];
    scene.setup.balance = Some(Balance { min_width, interval: 20, threshold: 1.05 });
    for grid in [[2, 1, 1], [4, 1, 1], [3, 1, 2], [2, 2, 2]] {
        assert_same(&reference, &scene.run(grid, STEPS), &format!("grid {grid:?}"));
    }
    assert_same(&reference, &scene.run_with_restart([4, 1, 1], 907, [2, 1, 2], STEPS - 907), "restart");
    // All stand in one subdomain of four at first, and never again.
    let counts = on_ranks(4, |transport| {
        let mut dem = scene.start([4, 1, 1], transport.rank());
        let first = dem.particles.owned;
        for _ in 0..STEPS {
            dem.step(&transport).unwrap();
        }
        (first, dem.particles.owned, dem.report.moves)
    });
    assert!(counts[1..].iter().all(|c| c.0 <= counts[0].0 / 10), "{counts:?}");
    let mean = scene.particles.len() / 4;
    assert!(counts.iter().all(|c| (mean / 2..2 * mean).contains(&c.1) && c.2 > 2), "{counts:?}");
}

#[test]
fn a_restart_on_other_ranks_continues_the_very_same_run() {
    for (scene, steps) in [(silo(), 1500), (shear(true), 400), (drift(), 1000), (drift_over_waves(), 1500)] {
        let reference = scene.run([2, 1, 1], 2 * steps);
        for (first, second) in [([1, 1, 1], [2, 2, 1]), ([2, 2, 2], [1, 1, 1]), ([2, 1, 1], [1, 3, 1])] {
            let restarted = scene.run_with_restart(first, steps + 7, second, steps - 7);
            assert_same(&reference, &restarted, &format!("{first:?} then {second:?}"));
        }
    }
}

#[test]
fn the_skin_changes_when_lists_are_rebuilt_but_no_bit_of_the_state() {
    for (mut scene, steps) in
        [(silo(), 1500), (shear(true), 400), (drift(), 1000), (drift_over_waves(), 2500)]
    {
        let reference = scene.run([2, 1, 1], steps);
        for (min, max, horizon) in [(0.1, 0.2, 7.0), (0.01, 0.02, 60.0), (0.3, 0.4, 60.0)] {
            scene.setup.skin = Skin { min, max, horizon };
            assert_same(&reference, &scene.run([1, 1, 1], steps), &format!("skin {min} to {max}"));
        }
    }
}

/// The scene with composites and superellipsoids in place of its shapes.
#[test]
fn films_between_spheres_are_the_same_on_any_ranks_skin_and_restart() {
    let mut scene = silo();
    scene.setup.lubrication = Some(Lubrication { viscosity: 0.1, range: 8e-4, min_gap: 1e-3 });
    let alone = scene.run([1; 3], 300);
    assert_same(&alone, &scene.run([2, 2, 1], 300), "2 x 2 x 1 ranks");
    assert_same(&alone, &scene.run_with_restart([1, 2, 1], 140, [2, 1, 1], 160), "restart");
    let dry = silo().run([1; 3], 300);
    assert!(alone.iter().zip(&dry).any(|(a, b)| a != b), "films do something");
    scene.setup.skin = Skin { min: 0.1, max: 0.2, horizon: 20.0 };
    assert_same(&alone, &scene.run([1; 3], 300), "another skin");
}

fn knobbly(mut scene: Scene, faces: FaceContact, sharing: Sharing) -> Scene {
    let shapes = knobbly_shapes(1.4e-3);
    for (k, particle) in scene.particles.iter_mut().enumerate() {
        particle.kind.shape = (k % shapes.len()) as u16;
    }
    let catalogue = &mut scene.setup.catalogue;
    (catalogue.shapes, catalogue.faces, catalogue.sharing) = (shapes, faces, sharing);
    scene
}

#[test]
fn composites_and_superellipsoids_are_the_same_on_any_ranks_skin_and_restart() {
    for (mut scene, steps) in [
        (knobbly(shear(true), FaceContact::Point, Sharing::Mean), 400),
        (knobbly(shear(true), FaceContact::MultiPoint, Sharing::Potential), 400),
        (knobbly(shear(false), FaceContact::MultiPoint, Sharing::Sum), 400),
        (knobbly(drift_over_waves(), FaceContact::MultiPoint, Sharing::Potential), 3000),
    ] {
        let mut dem = scene.start([1; 3], 0);
        let mut contacts = 0;
        for _ in 0..steps / 10 {
            (0..10).for_each(|_| dem.step(&SerialTransport).unwrap());
            let (neighbours, walls) = dem.coordination();
            contacts += neighbours.iter().chain(&walls).sum::<u32>();
        }
        assert!(contacts > 200, "only {contacts} contacts in {} looks", steps / 10);
        let reference = scene.run([1, 1, 1], steps);
        for grid in [[2, 1, 1], [2, 2, 2], [1, 3, 1]] {
            assert_same(&reference, &scene.run(grid, steps), &format!("grid {grid:?}"));
        }
        let restarted = scene.run_with_restart([2, 1, 1], steps / 2 + 7, [1, 3, 1], steps / 2 - 7);
        assert_same(&reference, &restarted, "restart");
        scene.setup.skin = Skin { min: 0.1, max: 0.2, horizon: 7.0 };
        assert_same(&reference, &scene.run([2, 1, 1], steps), "skin");
    }
}

/// The scene with collisions by impulses, in longer steps.
fn hard(mut scene: Scene, scheme: ImpulseScheme, sweeps: u32) -> Scene {
    let rates = &mut scene.setup.parameters;
    rates.dt = 1e-5;
    scene.setup.collisions = CollisionModel::Hard(HardModel { scheme, sweeps, ..HardModel::new(rates) });
    scene
}

#[test]
fn hard_collisions_are_the_same_on_any_ranks() {
    use ImpulseScheme::{Exact, Sequential};
    for (scene, steps) in [
        (hard(silo(), Exact, 1), 800),
        (hard(shear(true), Exact, 2), 150),
        (hard(shear(true), Sequential, 1), 150),
        (hard(drift_over_waves(), Exact, 1), 1000),
        (hard(knobbly(shear(true), FaceContact::Point, Sharing::Mean), Exact, 1), 150),
    ] {
        let mut dem = scene.start([1; 3], 0);
        let reference = scene.run([1, 1, 1], steps);
        (0..steps).for_each(|_| dem.step(&SerialTransport).unwrap());
        let report = dem.report;
        assert!(report.collisions > 300 && report.rounds > 50, "{report:?}");
        for grid in [[2, 1, 1], [1, 3, 1], [2, 2, 2], [4, 1, 2]] {
            assert_same(&reference, &scene.run(grid, steps), &format!("grid {grid:?}"));
        }
        for (first, second) in [([1, 1, 1], [2, 2, 1]), ([2, 2, 2], [1, 3, 1])] {
            let restarted = scene.run_with_restart(first, steps / 2 + 7, second, steps / 2 - 7);
            assert_same(&reference, &restarted, &format!("{first:?} then {second:?}"));
        }
    }
}

#[test]
fn hard_collisions_do_not_depend_on_the_skin() {
    for (scene, steps) in [(silo(), 500), (shear(true), 150), (drift(), 600), (drift_over_waves(), 1000)] {
        let mut scene = hard(scene, ImpulseScheme::Exact, 1);
        let reference = scene.run([2, 1, 1], steps);
        for (min, max, horizon) in [(0.1, 0.2, 7.0), (0.01, 0.02, 60.0), (0.3, 0.4, 60.0)] {
            scene.setup.skin = Skin { min, max, horizon };
            assert_same(&reference, &scene.run([1, 1, 1], steps), &format!("skin {min} to {max}"));
        }
    }
}

#[test]
fn strategies_of_exchange_change_no_bit() {
    for mut scene in [silo(), drift()] {
        let serial = scene.run([1; 3], 250);
        for strategy in [
            ExchangeStrategy::AllGatherGlobal,
            ExchangeStrategy::AllGatherLocal,
            ExchangeStrategy::AllGatherLocalNonblocking,
            ExchangeStrategy::SendRecvLocalGeoloc,
        ] {
            scene.setup.exchange = strategy;
            for ranks in [[2, 2, 1], [1, 2, 2]] {
                assert_same(&serial, &scene.run(ranks, 250), &format!("{strategy:?} on {ranks:?}"));
            }
        }
    }
}
