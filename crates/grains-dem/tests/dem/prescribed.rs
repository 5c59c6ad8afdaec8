//! Particles of prescribed motion among free ones: poses, contacts as with bodies of infinite mass, momentum, and bits.

use crate::common::{Scene, assert_same, lattice, law, mixed_shapes, setup, wall};
use grains_contact::{ContactLaw, ImpulseScheme, Tangential};
use grains_dem::{
    CollisionModel, Dem, DemSetup, HardModel, Kind, Motion, MotionTable, NewParticle, PrescribedMotion, Skin,
    Surface,
};
use grains_domain::SerialTransport;
use grains_geometry::{Rotation, Shape, Vec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

const RADIUS: f64 = 1e-3;

fn particle(id: u64, shape: u16, position: Vec3, velocity: Vec3) -> NewParticle {
    NewParticle {
        id,
        kind: Kind { shape, material: 0 },
        scale: 1.0,
        position,
        orientation: Rotation::new(Vec3::new(0.3, -0.2, 0.5)),
        velocity,
        angular_velocity: Vec3::zeros(),
        temperature: 0.0,
    }
}

fn prescribe(ids: std::ops::Range<u64>, motion: Motion) -> PrescribedMotion {
    PrescribedMotion { name: "fixed".into(), ids, motion, about_centres: false }
}

fn oscillation(amplitude: Vec3) -> Motion {
    Motion::Oscillation { amplitude, frequency: 180.0, phase: 0.4, start: 0.0, end: f64::INFINITY }
}

fn rotation(point: Vec3, rate: f64) -> Motion {
    let axis = Vec3::new(1.0, 2.0, 2.0) / 3.0;
    Motion::Rotation { point, axis, rate, start: 0.0, end: f64::INFINITY }
}

fn start(setup: DemSetup, particles: Vec<NewParticle>) -> Dem {
    Scene { setup, particles }.start([1; 3], 0)
}

fn index(dem: &Dem, id: u64) -> usize {
    dem.particles.ids.iter().position(|&other| other == id).unwrap()
}

/// Poses are those of the motion at any time, in boxes that are periodic or not, whatever hits the bodies.
#[test]
fn prescribed_poses_are_kept_whatever_hits_the_bodies() {
    let size = 0.02;
    let middle = Vec3::repeat(0.5 * size);
    let drift = Motion::Translation { velocity: Vec3::new(3.0, -2.0, 1.0), start: 2e-4, end: 1.2e-3 };
    let rows =
        [(2e-4, 0.0), (6e-4, 1.3e-3), (1.2e-3, -4e-4)].map(|(t, x)| (t, Vec3::new(x, 0.5 * x, -x), 0.0));
    let motions = [
        (Motion::Fixed, false),
        (drift, false),
        (oscillation(Vec3::new(1e-3, 2e-3, 0.0)), false),
        (Motion::Table(Arc::new(MotionTable::new(&rows, Vec3::zeros(), Vec3::z()))), false),
        (rotation(middle, 300.0), false),
        (rotation(middle, 300.0), true),
    ];
    for (motion, about_centres) in motions {
        for periodic in [[false; 3], [true; 3]] {
            let mut setup = setup([size; 3], periodic, mixed_shapes(RADIUS), law(true));
            setup.outlets = [true; 6];
            setup.prescribed = vec![PrescribedMotion { about_centres, ..prescribe(0..4, motion.clone()) }];
            let place = |k: u64| middle + Vec3::new(3e-3 * (k as f64 - 1.5), 1e-3, -2e-3);
            let mut particles: Vec<_> =
                (0..4).map(|k| particle(k, k as u16, place(k), Vec3::zeros())).collect();
            // Free ones all around.
            for mut free in lattice([0.0; 3], [size; 3], 3e-3, 4, 3.0) {
                let is_near = |k: u64| (free.position - place(k)).norm() < 2.2 * RADIUS;
                free.id += 4;
                if !(0..4).any(is_near) {
                    particles.push(free);
                }
            }
            let mut dem = start(setup, particles);
            for _ in 0..500 {
                dem.step(&SerialTransport).unwrap();
                let (now, turned) = (motion.at(dem.time()), motion.turned_at(dem.time()));
                for k in 0..4 {
                    let i = index(&dem, k);
                    let body = dem.particles.bodies[i];
                    let first = motion.at(0.0);
                    let wanted = match about_centres {
                        true => place(k),
                        false => {
                            now.rotation * first.rotation.transpose() * (place(k) - first.translation)
                                + now.translation
                        }
                    };
                    let off = (body.position - wanted)
                        .map(|d| if periodic[0] { d - size * (d / size).round() } else { d });
                    let velocity = match about_centres {
                        true => Vec3::zeros(),
                        false => now.velocity_at(&wanted),
                    };
                    assert!(off.norm() < 1e-15, "{motion:?} {k}: off by {off:?}");
                    assert!((body.velocity - velocity).norm() < 1e-12, "{motion:?} {:?}", body.velocity);
                    assert_eq!(body.angular_velocity, now.angular_velocity);
                    if k > 0 {
                        let turn = turned * Rotation::new(Vec3::new(0.3, -0.2, 0.5));
                        let off = (dem.particles.orientations[i].coords - turn.coords).norm();
                        let off = off.min((dem.particles.orientations[i].coords + turn.coords).norm());
                        assert!(off < 1e-13, "{motion:?} {k}: turned off by {off:e}");
                    }
                }
            }
            let loads = dem.report.worst_overlap;
            assert!(loads > 0.0, "something must have been hit");
        }
    }
}

/// A sphere that hits a fixed body leaves it as a wall: with e times its speed, after the contact time of its whole mass.
#[test]
fn free_spheres_leave_fixed_ones_as_they_leave_walls() {
    let mass = 2500.0 * 4.0 / 3.0 * PI * RADIUS.powi(3);
    let tangential = Tangential::Spring { stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.5 };
    for (restitution, speed) in [(1.0, 0.0), (0.73, 0.0), (1.0, 0.25), (0.5, -0.6)] {
        let law = ContactLaw::linear(1e5, restitution, 0.3, tangential);
        let collision = law.collision(mass, RADIUS, 1.0);
        let mut setup = setup([0.02; 3], [false; 3], vec![Shape::sphere(RADIUS).unwrap()], law);
        setup.parameters.gravity = Vec3::zeros();
        setup.parameters.dt = collision.contact_time / 400.0;
        // The fixed one may move towards the free one, or away.
        let velocity = Vec3::z() * speed;
        setup.prescribed =
            vec![prescribe(7..8, Motion::Translation { velocity, start: 0.0, end: f64::INFINITY })];
        let middle = Vec3::repeat(0.01);
        let gap = 0.0337 * collision.contact_time;
        let above = middle + Vec3::z() * (2.0 * RADIUS + gap);
        let particles = vec![particle(7, 0, middle, Vec3::zeros()), particle(2, 0, above, -Vec3::z())];
        let mut dem = start(setup, particles);
        let energy = |dem: &Dem| {
            let totals = dem.totals(&SerialTransport);
            totals.kinetic_translation + totals.kinetic_rotation
        };
        let before = energy(&dem);
        let (mut steps, mut is_touching) = (0_u32, true);
        while is_touching || steps == 0 {
            dem.step(&SerialTransport).unwrap();
            is_touching = dem.report.max_overlap > 0.0 || steps == 0;
            steps += u32::from(dem.report.max_overlap > 0.0);
        }
        let after = dem.particles.bodies[index(&dem, 2)].velocity.z;
        let wanted = speed + restitution * (1.0 + speed);
        assert!((after - wanted).abs() < 5e-3 * (1.0 + speed), "{after} for {wanted}");
        let duration = f64::from(steps) * dem.setup.parameters.dt / collision.contact_time;
        assert!((duration - 1.0).abs() < 6e-3, "{duration} contact times");
        if restitution == 1.0 && speed == 0.0 {
            assert!((energy(&dem) / before - 1.0).abs() < 1e-6, "{before:e} J, then {:e} J", energy(&dem));
        }
    }
}

/// Bodies of any shape off their centres, at fixed bodies without damping and friction: energy is kept.
#[test]
fn energy_is_kept_by_elastic_impacts_of_any_shapes_on_fixed_ones() {
    let elastic = ContactLaw::linear(1e5, 1.0, 0.0, Tangential::Viscous { rate: 0.0 });
    let mut setup = setup([0.02; 3], [true; 3], mixed_shapes(RADIUS), elastic);
    setup.parameters.gravity = Vec3::zeros();
    setup.parameters.dt = 2e-7;
    setup.prescribed = vec![prescribe(0..16, Motion::Fixed)];
    let particles = lattice([0.0; 3], [0.02; 3], 3.2e-3, 4, 6.0);
    let mut dem = start(setup, particles);
    let energy = |dem: &Dem| {
        let totals = dem.totals(&SerialTransport);
        totals.kinetic_translation + totals.kinetic_rotation
    };
    let before = energy(&dem);
    let mut hits = 0;
    for _ in 0..20_000 {
        dem.refresh(&SerialTransport).unwrap();
        dem.add_forces(&SerialTransport);
        hits += (0..16).filter(|&k| dem.particles.loads[index(&dem, k)].force.norm() > 0.0).count();
        dem.advance(&SerialTransport).unwrap();
    }
    assert!(hits > 1000, "{hits} hits on fixed bodies");
    // Until the last contact has ended part of it is elastic.
    while dem.report.max_overlap > 0.0 {
        dem.step(&SerialTransport).unwrap();
    }
    assert!((energy(&dem) / before - 1.0).abs() < 5e-3, "{before:e} J, then {:e} J", energy(&dem));
}

/// What the free ones lose of momentum is what the fixed ones are loaded with, to rounding; and two fixed ones do nothing to
/// each other, nor a wall to them, however deep they are in.
#[test]
fn momentum_goes_to_the_fixed_bodies() {
    let mut setup = setup([0.02, 0.02, 0.06], [true, true, false], mixed_shapes(RADIUS), law(true));
    let floor = Surface::Plane { point: Vec3::new(0.0, 0.0, 2e-3), normal: Vec3::z() };
    setup.walls = vec![wall("floor", floor, Motion::Fixed)];
    let clump = 8;
    setup.prescribed = vec![
        prescribe(0..clump, Motion::Fixed),
        PrescribedMotion {
            name: "shaker".into(),
            ..prescribe(clump..clump + 1, oscillation(Vec3::x() * 1e-3))
        },
    ];
    let mut particles = lattice([0.0, 0.0, 5e-3], [0.02, 0.02, 0.02], 3e-3, 4, 1.0);
    for p in &mut particles {
        p.id += clump + 1;
        p.velocity.z -= 2.0;
    }
    // Held ones overlap by half, in the floor.
    for k in 0..=clump {
        let at = Vec3::new(3e-3 + 1e-3 * k as f64, 0.01, 2e-3);
        particles.push(particle(k, k as u16 % 4, at, Vec3::zeros()));
    }
    let mut dem = start(setup, particles);
    let momentum = |dem: &Dem| -> Vec3 {
        let free = |i: &usize| !dem.particles.bodies[*i].is_prescribed();
        let of = |i: usize| dem.particles.half_velocity[i] * dem.particles.bodies[i].mass;
        (0..dem.particles.owned).filter(free).map(of).sum()
    };
    let mass: f64 = dem.particles.bodies.iter().filter(|b| !b.is_prescribed()).map(|b| b.mass).sum();
    let (dt, gravity) = (dem.setup.parameters.dt, dem.setup.parameters.gravity);
    let (mut before, mut on_fixed) = (momentum(&dem), Vec3::zeros());
    for step in 0..3000 {
        dem.refresh(&SerialTransport).unwrap();
        dem.add_forces(&SerialTransport);
        let walls: Vec3 = dem.wall_loads(&SerialTransport).iter().map(|load| load.force).sum();
        let fixed: Vec3 = dem.prescribed_loads(&SerialTransport).iter().map(|load| load.force).sum();
        if step == 0 {
            assert_eq!((fixed, walls), (Vec3::zeros(), Vec3::zeros()), "fixed bodies that overlap");
        }
        on_fixed += fixed * dt;
        dem.advance(&SerialTransport).unwrap();
        let after = momentum(&dem);
        let off = after - before - (gravity * mass - walls - fixed) * dt;
        assert!(off.norm() < 1e-13 * (mass * 3.0), "step {step}: {off:?}");
        before = after;
    }
    assert!(on_fixed.norm() > 0.1 * mass, "{on_fixed:?} N s");
}

/// Free and fixed bodies, shaken and turning ones, spheres and others, in a box periodic along two axes.
fn mill(shapes: Vec<Shape>) -> Scene {
    let mut setup = setup([0.03; 3], [true, true, false], shapes, law(true));
    setup.parameters.gravity = Vec3::new(4.0, 3.0, -30.0);
    setup.overlap_limit = 0.6;
    let floor = Surface::Plane { point: Vec3::new(0.0, 0.0, 1e-3), normal: Vec3::z() };
    setup.walls = vec![wall("floor", floor, Motion::Fixed)];
    let away = Motion::Translation { velocity: Vec3::new(-2.0, 1.0, 0.0), start: 3e-4, end: 2.5e-3 };
    setup.prescribed = vec![
        prescribe(0..12, Motion::Fixed),
        prescribe(12..24, oscillation(Vec3::new(4e-4, 3e-4, 2e-4))),
        // About an axis near a periodic face.
        prescribe(24..36, rotation(Vec3::new(1e-3, 0.015, 0.01), 60.0)),
        PrescribedMotion { about_centres: true, ..prescribe(36..48, rotation(Vec3::zeros(), 200.0)) },
        prescribe(48..54, away),
    ];
    let kinds = setup.catalogue.shapes.len() as u16;
    Scene { setup, particles: lattice([0.0, 0.0, 1e-3], [0.03, 0.03, 0.02], 3e-3, kinds, 0.5) }
}

#[test]
fn held_and_driven_bodies_change_no_bit_with_ranks_skin_and_restart() {
    for (shapes, is_hard) in [
        (vec![Shape::sphere(1.4e-3).unwrap()], false),
        (mixed_shapes(1.4e-3), false),
        (mixed_shapes(1.4e-3), true),
    ] {
        let mut scene = mill(shapes);
        let mut steps = 900;
        if is_hard {
            let rates = &mut scene.setup.parameters;
            (rates.dt, steps) = (1e-5, 300);
            let model = HardModel { scheme: ImpulseScheme::Exact, ..HardModel::new(rates) };
            scene.setup.collisions = CollisionModel::Hard(model);
        }
        let wanted = scene.run([1; 3], steps);
        for grid in [[2, 1, 1], [1, 3, 1], [2, 2, 1], [2, 2, 2]] {
            assert_same(&wanted, &scene.run(grid, steps), &format!("{grid:?}"));
        }
        for (first, second, stop) in
            [([1; 3], [2, 2, 1], 7), ([2, 2, 2], [1; 3], 361), ([2, 1, 1], [1, 3, 1], 598)]
        {
            let stop = stop % steps;
            let found = scene.run_with_restart(first, stop, second, steps - stop);
            assert_same(&wanted, &found, &format!("{first:?} then {second:?}"));
        }
        scene.setup.skin = Skin { min: 0.1, max: 0.2, horizon: 7.0 };
        assert_same(&wanted, &scene.run([2, 1, 1], steps), "skin");
    }
}

/// Hard spheres leave fixed ones with e times their speed, and fixed ones do not move.
#[test]
fn hard_spheres_leave_fixed_ones_as_they_leave_walls() {
    for restitution in [1.0, 0.6] {
        let law = ContactLaw::rigid(restitution, 0.0);
        let mut setup = setup([0.02; 3], [false; 3], vec![Shape::sphere(RADIUS).unwrap()], law);
        setup.parameters.gravity = Vec3::zeros();
        setup.parameters.dt = 1e-5;
        setup.collisions = CollisionModel::Hard(HardModel::new(&setup.parameters));
        setup.prescribed = vec![prescribe(1..2, oscillation(Vec3::y() * 1e-12))];
        let middle = Vec3::repeat(0.01);
        let above = middle + Vec3::z() * 2.5 * RADIUS;
        let mut dem =
            start(setup, vec![particle(0, 0, above, -Vec3::z()), particle(1, 0, middle, Vec3::zeros())]);
        for _ in 0..100 {
            dem.step(&SerialTransport).unwrap();
        }
        let [free, fixed] = [0, 1].map(|id| dem.particles.bodies[index(&dem, id)]);
        assert!((free.velocity - Vec3::z() * restitution).norm() < 1e-8, "{:?}", free.velocity);
        assert!((fixed.position - middle).norm() < 3e-12, "{:?}", fixed.position);
        assert!((fixed.velocity.y - 1e-12 * 180.0 * TAU * (180.0 * TAU * 1e-3 + 0.4).cos()).abs() < 1e-20);
    }
}
