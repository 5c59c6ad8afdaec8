//! Bonds: the same bits on any ranks, skins and restarts, while they break; momentum and energy; chains; ledger; errors.

use crate::common::{Scene, State, lattice, law, merged, mixed_shapes, setup, state_of, wall};
use grains_contact::{BeamShear, Bond, Section, Strength};
use grains_dem::{
    BondKind, BondRadius, Bonded, Dem, Failure, Kind, Motion, NewParticle, PrescribedMotion, Shear, Skin,
    StepError, Surface,
};
use grains_domain::{Balance, SerialTransport, Transport};
use grains_geometry::{Rotation, Shape, Vec3};
use grains_testing::on_ranks;
use std::f64::consts::PI;

const YOUNG: f64 = 2e7;

/// Bonds of near particles of material 0, made at once, that never break.
fn bonds() -> BondKind {
    let section =
        Section { radius: f64::NAN, young: YOUNG, shear_modulus: 8e6, shear: BeamShear::Timoshenko };
    BondKind {
        bond: Bond { section, damping: 0.1, strength: Strength::UNBREAKABLE },
        radius: BondRadius::OverSmaller(0.7),
        time: 0.0,
        distance: 6e-4,
        bonded: Bonded::Materials([0, 0]),
    }
}

fn breakable(tensile: f64) -> BondKind {
    let mut kind = bonds();
    kind.bond.strength = Strength { tensile, shear: 1.5 * tensile };
    kind
}

/// A block of spheres, or of mixed shapes, bonded in flight, that hits a plane and breaks, in a box periodic along x.
fn block(shapes: Vec<Shape>, kind: BondKind) -> Scene {
    let kinds = shapes.len() as u16;
    let mut setup = setup([0.016, 0.02, 0.02], [true, false, false], shapes, law(true));
    setup.bonds = vec![kind];
    setup.overlap_limit = 0.9;
    let floor = Surface::Plane { point: Vec3::new(0.0, 0.0, 1e-3), normal: Vec3::z() };
    setup.walls = vec![wall("floor", floor, Motion::Fixed)];
    let mut particles = lattice([0.009, 0.005, 0.0025], [0.0169, 0.0148, 0.0125], 2e-3, kinds, 0.05);
    for p in &mut particles {
        p.velocity.z -= 4.0;
    }
    Scene { setup, particles }
}

/// Bonds there and broken after a number of steps on one rank.
fn count_after(scene: &Scene, steps: u64) -> [u64; 2] {
    let mut dem = scene.start([1; 3], 0);
    for _ in 0..steps {
        dem.step(&SerialTransport).unwrap();
    }
    dem.check_bonds(&SerialTransport).unwrap()
}

#[test]
fn bonded_blocks_break_in_the_same_way_on_any_ranks_skin_and_restart() {
    const STEPS: u64 = 700;
    let made_in_step = 21;
    let spheres = vec![Shape::sphere(1e-3).unwrap()];
    for (shapes, tensile) in [(spheres, 3e5), (mixed_shapes(0.9e-3), 3e5)] {
        let mut scene = block(shapes, breakable(tensile));
        scene.setup.bonds[0].time = made_in_step as f64 * scene.setup.parameters.dt;
        let [there, broken] = count_after(&scene, STEPS);
        assert!(there > 20 && broken > 20, "{there} bonds are there and {broken} broken");
        let alone = scene.run([1; 3], STEPS);
        for ranks in [[2, 1, 1], [1, 3, 1], [2, 2, 2]] {
            assert!(alone == scene.run(ranks, STEPS), "on {ranks:?}");
        }
        for stop in [made_in_step - 1, made_in_step, made_in_step + 1, 301] {
            let again = scene.run_with_restart([2, 1, 1], stop, [1, 1, 2], STEPS - stop);
            assert!(alone == again, "stopped at {stop}");
        }
        scene.setup.skin = Skin { min: 0.02, max: 0.02, ..scene.setup.skin };
        assert!(alone == scene.run([1; 3], STEPS), "with another skin");
        let min_width = [scene.setup.interaction_range(); 3];
        scene.setup.balance = Some(Balance { min_width, interval: 20, threshold: 1.05 });
        for ranks in [[2, 1, 1], [1, 2, 2]] {
            assert!(alone == scene.run(ranks, STEPS), "with borders that move, on {ranks:?}");
        }
    }
}

#[test]
fn bonds_across_the_images_of_a_sheared_box_have_the_same_bits() {
    let mut scene = block(vec![Shape::sphere(1e-3).unwrap()], breakable(5e4));
    scene.setup.global = grains_domain::GlobalBox::new([0.0; 3], [0.018; 3], [true; 3]);
    scene.setup.planes.clear();
    scene.setup.walls.clear();
    scene.setup.parameters.gravity = Vec3::zeros();
    scene.setup.shear = Some(Shear { flow: 0, gradient: 2, rate: 40.0 });
    scene.particles = lattice([0.0; 3], [0.018; 3], 2e-3, 1, 0.3);
    let [there, broken] = count_after(&scene, 600);
    assert!(there > 20 && broken > 20, "{there} bonds are there and {broken} broken");
    let alone = scene.run([1; 3], 600);
    assert!(alone == scene.run([1, 2, 2], 600));
}

/// Linear and angular momentum, and kinetic energy, on one rank.
fn totals(dem: &Dem) -> (Vec3, Vec3, f64) {
    let totals = dem.totals(&SerialTransport);
    (totals.momentum, totals.angular_momentum, totals.kinetic_translation + totals.kinetic_rotation)
}

#[test]
fn a_bonded_block_that_tumbles_keeps_its_momenta_and_makes_no_energy() {
    for shapes in [vec![Shape::sphere(1e-3).unwrap()], mixed_shapes(0.9e-3)] {
        let mut scene = block(shapes, bonds());
        scene.setup.global = grains_domain::GlobalBox::new([0.0; 3], [0.03; 3], [false; 3]);
        scene.setup.walls.clear();
        scene.setup.parameters.gravity = Vec3::zeros();
        let center = Vec3::repeat(0.015);
        let middle = scene.particles.iter().map(|p| p.position).sum::<Vec3>() / scene.particles.len() as f64;
        let spin = Vec3::new(60.0, 100.0, -40.0);
        for p in &mut scene.particles {
            p.position += center - middle;
            p.velocity += spin.cross(&(p.position - center));
            p.velocity.z += 4.0;
        }
        let mut dem = scene.start([1; 3], 0);
        dem.step(&SerialTransport).unwrap();
        let (momentum, angular, energy) = totals(&dem);
        // About a whole turn.
        for _ in 0..12_000 {
            dem.step(&SerialTransport).unwrap();
        }
        let (later, later_angular, later_energy) = totals(&dem);
        assert!((later - momentum).norm() < 1e-10 * energy.sqrt(), "{momentum} became {later}");
        let error = (later_angular - angular).norm() / angular.norm();
        assert!(error < 1e-5, "angular momentum changed by {error:e} of it");
        assert!(later_energy < energy, "{energy} J became {later_energy} J");
        let [there, broken] = dem.check_bonds(&SerialTransport).unwrap();
        assert!(there > 100 && broken == 0, "{there} bonds, {broken} broken");
    }
}

fn bead(id: u64, position: Vec3) -> NewParticle {
    NewParticle {
        id,
        kind: Kind { shape: 0, material: 0 },
        scale: 1.0,
        position,
        orientation: Rotation::identity(),
        velocity: Vec3::zeros(),
        angular_velocity: Vec3::zeros(),
        temperature: 0.0,
    }
}

/// Touching beads in a row along a direction, the first of them fixed, under gravity.
fn chain(count: u64, along: Vec3, kind: BondKind) -> (Scene, PrescribedMotion) {
    let mut setup = setup([0.03; 3], [false; 3], vec![Shape::sphere(1e-3).unwrap()], law(true));
    setup.bonds = vec![kind];
    setup.largest_radius = 1e-3;
    let place = |k: u64| Vec3::new(2e-3, 0.015, 0.028) + along * (2e-3 * k as f64);
    let particles = (0..count).map(|k| bead(k, place(k))).collect();
    let fixed =
        PrescribedMotion { name: "root".into(), ids: 0..1, motion: Motion::Fixed, about_centres: false };
    (Scene { setup, particles }, fixed)
}

fn settled((scene, fixed): &(Scene, PrescribedMotion), steps: u64) -> Dem {
    let mut scene = Scene { setup: scene.setup.clone(), particles: scene.particles.clone() };
    scene.setup.prescribed = vec![fixed.clone()];
    let mut dem = scene.start([1; 3], 0);
    for _ in 0..steps {
        dem.step(&SerialTransport).unwrap();
    }
    dem
}

#[test]
fn chains_hang_and_bend_as_beams_do() {
    const BEADS: u64 = 6;
    let mut kind = bonds();
    kind.bond.damping = 0.3;
    let (area, inertia) = (PI * 0.49e-6, PI * 0.49e-6 * 0.49e-6 / 4.0);
    let (length, shear_modulus) = (2e-3, kind.bond.section.shear_modulus);
    let end = |dem: &Dem| {
        let i = dem.particles.ids.iter().position(|&id| id == BEADS - 1).unwrap();
        dem.particles.bodies[i].position
    };
    for along in [-Vec3::z(), Vec3::x()] {
        let scene = chain(BEADS, along, kind.clone());
        let dem = settled(&scene, 250_000);
        let first = scene.0.particles[BEADS as usize - 1].position;
        let weight = dem.particles.bodies.iter().map(|body| body.mass).fold(0.0, f64::max) * 9.81;
        let moved = end(&dem) - first;
        let free = (BEADS - 1) as f64;
        let exact = if along.x == 0.0 {
            // Bond k bears the weight of all beads below it.
            weight * length / (YOUNG * area) * free * (free + 1.0) / 2.0
        } else {
            // Weights at the nodes of a cantilever: bending x² (3 L − x)/(6 E I), shear x/(κ G A).
            let span = free * length;
            let at = |k: f64| {
                let x = k * length;
                let bending = x * x * (3.0 * span - x) / (6.0 * YOUNG * inertia);
                weight * (bending + x / (0.9 * shear_modulus * area))
            };
            (1..BEADS).map(|k| at(k as f64)).sum::<f64>()
        };
        let error = -moved.z / exact - 1.0;
        assert!(error.abs() < 2e-3, "along {along}: {} m, exact {exact} m, {error:e} off", -moved.z);
    }
}

#[test]
fn a_bonded_pair_meets_like_any_other_once_its_bond_is_broken() {
    let mut scene = block(vec![Shape::sphere(1e-3).unwrap()], breakable(5e3));
    scene.setup.walls.clear();
    scene.setup.parameters.gravity = Vec3::zeros();
    let at = |x: f64| Vec3::new(0.008 + x, 0.01, 0.01);
    scene.particles = vec![bead(3, at(0.0)), bead(8, at(1.95e-3))];
    scene.particles[1].velocity.x = -0.2;
    let run = |scene: &Scene, steps: u64| {
        let mut dem = scene.start([1; 3], 0);
        let mut contacts = Vec::new();
        for _ in 0..steps {
            dem.step(&SerialTransport).unwrap();
            let mut touching = 0;
            dem.for_each_contact(|_| touching += 1);
            contacts.push(touching);
        }
        (dem.check_bonds(&SerialTransport).unwrap(), contacts)
    };
    // They overlap and are pressed together, but the bond bears it.
    let ([there, _], contacts) = run(&scene, 10);
    assert!(there == 1 && contacts.iter().all(|&n| n == 0), "{there} bonds, {contacts:?} contacts");
    // A bond that breaks at once by bending: from the next step on they are two spheres that overlap.
    scene.particles[1].velocity = Vec3::new(-0.2, 0.5, 0.0);
    let ([there, broken], contacts) = run(&scene, 10);
    assert!(there == 0 && broken == 1 && contacts.contains(&1), "{there} {broken} {contacts:?}");
}

#[test]
fn bonds_of_particles_that_leave_are_accounted_for() {
    let mut scene = block(vec![Shape::sphere(1e-3).unwrap()], bonds());
    scene.setup.walls.clear();
    scene.setup.outlets[4] = true;
    scene.setup.parameters.gravity = Vec3::new(0.0, 0.0, -2000.0);
    for ranks in [[1, 1, 1], [2, 1, 1], [1, 2, 2]] {
        let counts = on_ranks(ranks.iter().product(), |transport| {
            let mut dem = scene.start(ranks, transport.rank());
            let mut counts = Vec::new();
            for _ in 0..800 {
                dem.step(&transport).unwrap();
                counts.push((dem.check_bonds(&transport).unwrap(), dem.check_ledger(&transport).unwrap()));
            }
            counts
        });
        let [([first, _], _), ([last, broken], ledger)] = [counts[0][10], *counts[0].last().unwrap()];
        assert!(first > 100 && last < first / 2 && broken == 0, "{first} bonds, {last} are left");
        assert!(ledger.left > 10, "{ledger:?}");
    }
}

/// The failure of a scene within some steps.
fn failure(scene: &Scene, steps: u64) -> StepError {
    let mut dem = scene.start([1; 3], 0);
    for _ in 0..steps {
        if let Err(Failure::Here { error, .. }) = dem.step(&SerialTransport) {
            return error;
        }
    }
    panic!("nothing failed");
}

#[test]
fn what_cannot_be_bonded_is_named() {
    let scene = || block(vec![Shape::sphere(1e-3).unwrap()], bonds());
    let mut nobody = scene();
    nobody.setup.bonds[0].bonded = Bonded::Materials([1, 0]);
    assert!(matches!(failure(&nobody, 1), StepError::NothingBonded { kind: 0, .. }));
    let mut absent = scene();
    let near = {
        let mut dem = absent.start([1; 3], 0);
        dem.step(&SerialTransport).unwrap();
        let (lengths, packed) = dem.packed_history();
        // One without contacts with spheres and walls: the number of bonds, and the first partner.
        assert!(lengths[0] > 5 && packed[3] >= 1.0, "{packed:?}");
        let (id, partner) = (dem.particles.ids[0], packed[4] as u64);
        [id.min(partner), id.max(partner)]
    };
    absent.setup.bonds[0].bonded = Bonded::Pairs([near, [near[0], 99_999]].into());
    let error = failure(&absent, 1);
    let missing = [near[0], 99_999];
    assert!(
        matches!(&error, StepError::Unbonded { pair, missing: 1, pairs: 2, .. } if *pair == missing),
        "{error}"
    );
    absent.setup.bonds[0].bonded = Bonded::Pairs([near].into());
    assert_eq!(count_after(&absent, 5), [1, 0]);
    let mut stiff = scene();
    stiff.setup.bonds[0].bond.section.young *= 1e4;
    assert!(matches!(failure(&stiff, 1), StepError::StiffBond { .. }));
    let mut torn = scene();
    torn.particles.truncate(2);
    torn.setup.walls.clear();
    torn.particles[0].position = Vec3::new(0.008, 0.01, 0.01);
    torn.particles[1].position = Vec3::new(0.01, 0.01, 0.01);
    torn.particles[1].velocity = Vec3::new(0.0, 15.0, 0.0);
    torn.setup.bonds[0].bond.section.young *= 1e-2;
    torn.setup.bonds[0].bond.section.shear_modulus *= 1e-2;
    torn.setup.overlap_limit = 1e9;
    let error = failure(&torn, 2000);
    assert!(matches!(error, StepError::Overstretched { .. }), "{error}");
}

/// Two ways to the same bonds: by distance, and by a table of the same pairs.
#[test]
fn a_table_of_the_pairs_makes_the_same_bonds_as_their_distance() {
    let mut scene = block(vec![Shape::sphere(1e-3).unwrap()], breakable(2e6));
    let run = |scene: &Scene| -> State { merged(vec![state_of(&stepped(scene, 500))]) };
    let by_distance = run(&scene);
    let dem = stepped(&scene, 1);
    let mut pairs = Vec::new();
    let (lengths, packed) = dem.packed_history();
    let mut rest = &packed[..];
    for (&id, &length) in dem.particles.ids.iter().zip(&lengths) {
        let (row, after) = rest.split_at(length as usize);
        rest = after;
        assert_eq!(row[..3], [0.0, 0.0, -1.0], "nothing but bonds");
        pairs.extend(
            row[4..]
                .chunks_exact(9)
                .map(|bond| bond[0] as u64)
                .filter(|&other| id < other)
                .map(|other| [id, other]),
        );
    }
    pairs.sort_unstable();
    scene.setup.bonds[0].bonded = Bonded::Pairs(pairs.into());
    assert!(by_distance == run(&scene));
}

fn stepped(scene: &Scene, steps: u64) -> Dem {
    let mut dem = scene.start([1; 3], 0);
    for _ in 0..steps {
        dem.step(&SerialTransport).unwrap();
    }
    dem
}

/// Whether two spheres are within the distance of their bonds hangs on one rounding where they just touch: both ranks must find the
/// same.
#[test]
fn spheres_that_touch_across_a_border_are_bonded_on_both_of_its_sides_or_on_none() {
    let mut scene = block(vec![Shape::sphere(1e-3).unwrap()], BondKind { distance: 0.0, ..bonds() });
    scene.setup.global = grains_domain::GlobalBox::new([0.0; 3], [0.06; 3], [false; 3]);
    scene.setup.walls.clear();
    scene.particles.clear();
    for k in 0..144_u64 {
        let place = Vec3::new(0.03, 0.003 + 0.0049 * (k % 12) as f64, 0.003 + 0.0049 * (k / 12) as f64);
        let radii = [1 + k % 5, 2 + (k / 5) % 7].map(|tenths| tenths as f64 / 10.0);
        let ids = if k % 3 == 0 { [2 * k, 2 * k + 1] } else { [2 * k + 1, 2 * k] };
        for side in 0..2 {
            let away = if side == 0 { -radii[0] } else { radii[1] };
            let position = place + Vec3::x() * (away * 1e-3);
            let velocity = Vec3::new(0.0, 0.1, 0.02 * radii[side]);
            scene.particles.push(NewParticle { scale: radii[side], velocity, ..bead(ids[side], position) });
        }
    }
    scene.setup.parameters.dt = 1e-6;
    let [there, _] = count_after(&scene, 40);
    assert!(there > 20 && there < 144, "{there} bonds: some are, and some are not");
    let alone = scene.run([1; 3], 40);
    assert!(alone == scene.run([2, 1, 1], 40));
}

/// Who is bonded keeps the bond at a restart, however near particles must be to get one now.
#[test]
fn a_restart_with_a_shorter_distance_keeps_longer_bonds_on_any_ranks() {
    for outlets in [false, true] {
        let mut scene = block(vec![Shape::sphere(1e-3).unwrap()], breakable(3e5));
        scene.setup.outlets[5] = outlets;
        let stopped = scene.stop_after([2, 1, 1], 30);
        scene.setup.bonds[0].distance = 0.0;
        let alone = scene.go_on([1; 3], &stopped, 500);
        for ranks in [[2, 1, 1], [1, 3, 1], [2, 2, 2]] {
            assert!(alone == scene.go_on(ranks, &stopped, 500), "{ranks:?}, outlets {outlets}");
        }
    }
}
