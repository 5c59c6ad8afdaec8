//! Hard collisions: closed forms of one impact, energy, rest, and the same bits on any ranks.

use crate::common::{Scene, lattice, setup, wall};
use grains_contact::{ContactLaw, ImpulseScheme};
use grains_dem::{
    CollisionModel, Dem, DemSetup, HardModel, Kind, Motion, NewParticle, ParticleRecord, Surface, Wall,
};
use grains_domain::SerialTransport;
use grains_geometry::{Rotation, Shape, Vec3};
use std::f64::consts::FRAC_PI_2;

const RADIUS: f64 = 1.5e-3;
const SCHEMES: [ImpulseScheme; 2] = [ImpulseScheme::Sequential, ImpulseScheme::Exact];

/// Definition with hard collisions, without walls and gravity.
fn hard(
    size: f64,
    shapes: Vec<Shape>,
    restitution: f64,
    friction: f64,
    dt: f64,
    scheme: ImpulseScheme,
) -> DemSetup {
    let law = ContactLaw::rigid(restitution, friction);
    let mut setup = setup([size; 3], [false; 3], shapes, law);
    setup.catalogue.contacts.set(0, 1, law);
    setup.parameters.gravity = Vec3::zeros();
    setup.parameters.dt = dt;
    setup.collisions = CollisionModel::Hard(HardModel { scheme, ..HardModel::new(&setup.parameters) });
    setup
}

/// Sets gravity, and the rest speed that goes with it.
fn with_gravity(mut setup: DemSetup, gravity: Vec3) -> DemSetup {
    setup.parameters.gravity = gravity;
    setup.collisions = CollisionModel::Hard(HardModel::new(&setup.parameters));
    setup
}

fn closed_box(lower: f64, upper: f64) -> Vec<Wall> {
    let plane = |a: usize, sign: f64| {
        let normal = Vec3::from_fn(|k, _| if k == a { sign } else { 0.0 });
        let point = Vec3::repeat(if sign > 0.0 { lower } else { upper });
        wall("side", Surface::Plane { point, normal }, Motion::Fixed)
    };
    (0..3).flat_map(|a| [plane(a, 1.0), plane(a, -1.0)]).collect()
}

fn particle(id: u64, position: Vec3, orientation: Rotation, velocity: Vec3) -> NewParticle {
    let (kind, scale) = (Kind { shape: 0, material: 0 }, 1.0);
    NewParticle {
        id,
        kind,
        scale,
        position,
        orientation,
        velocity,
        angular_velocity: Vec3::zeros(),
        temperature: 0.0,
    }
}

fn dem_of(setup: DemSetup, particles: Vec<NewParticle>) -> Dem {
    Scene { setup, particles }.start([1; 3], 0)
}

/// Steps until something has collided and parted again.
fn until_parted(dem: &mut Dem) {
    let mut collided = false;
    for _ in 0..10_000 {
        dem.refresh(&SerialTransport).unwrap();
        let before = dem.report.collisions;
        dem.add_forces(&SerialTransport);
        let collides = dem.report.collisions > before;
        dem.advance(&SerialTransport).unwrap();
        if collided && !collides {
            return;
        }
        collided |= collides;
    }
    panic!("nothing collided");
}

fn record_of(dem: &Dem, id: u64) -> ParticleRecord {
    let index = dem.particles.ids.iter().position(|&other| other == id).unwrap();
    dem.particles.record(index)
}

fn kinetic(dem: &Dem) -> f64 {
    let totals = dem.totals(&SerialTransport);
    totals.kinetic_translation + totals.kinetic_rotation
}

/// Two bodies at ±2 m/s with e = 0.4 leave at 0.8 m/s with 0.16 of their energy (reference A11).
#[test]
fn two_bodies_head_on_leave_with_the_set_restitution() {
    let middle = Vec3::repeat(0.025);
    let crossed = [Vec3::x_axis(), Vec3::y_axis()].map(|a| Rotation::from_axis_angle(&a, FRAC_PI_2));
    for (shape, turns) in [
        (Shape::sphere(RADIUS).unwrap(), [Rotation::identity(); 2]),
        (Shape::cylinder(RADIUS, 5.0 * RADIUS, 0.05).unwrap(), crossed),
    ] {
        for scheme in SCHEMES {
            for (e, ratio) in [(0.4, 0.16), (1.0, 1.0)] {
                let setup = hard(0.05, vec![shape.clone()], e, 0.3, 1e-5, scheme);
                let lift = Vec3::z() * (RADIUS + 3.3e-5);
                let mut dem = dem_of(
                    setup,
                    vec![
                        particle(7, middle - lift, turns[0], Vec3::z() * 2.0),
                        particle(3, middle + lift, turns[1], -Vec3::z() * 2.0),
                    ],
                );
                let before = kinetic(&dem);
                until_parted(&mut dem);
                let speed = record_of(&dem, 3).body.velocity;
                assert!((speed - Vec3::z() * (2.0 * e)).norm() < 1e-12, "{} {scheme:?}: {speed}", shape.name);
                assert!((record_of(&dem, 7).body.velocity + speed).norm() < 1e-12);
                assert!((kinetic(&dem) / before - ratio).abs() < 1e-12);
                assert_eq!(dem.report.collisions, 1);
            }
        }
    }
}

/// Unequal spheres are relocated by inverse mass: their centre of mass stays on its way.
#[test]
fn relocation_parts_the_bodies_and_keeps_the_centre_of_mass() {
    let setup = hard(0.05, vec![Shape::sphere(RADIUS).unwrap()], 0.5, 0.0, 1e-4, ImpulseScheme::Exact);
    let middle = Vec3::repeat(0.025);
    let one = particle(0, middle, Rotation::identity(), Vec3::x());
    let offset = Vec3::new(1.4, 0.2, 0.1) * RADIUS;
    let two = NewParticle { id: 1, scale: 0.5, position: middle + offset, velocity: -Vec3::x(), ..one };
    let mut dem = dem_of(setup, vec![one, two]);
    let center = |dem: &Dem| {
        let [a, b] = [0, 1].map(|id| record_of(dem, id).body);
        (a.position * a.mass + b.position * b.mass) / (a.mass + b.mass)
    };
    let start = center(&dem);
    dem.step(&SerialTransport).unwrap();
    let [a, b] = [0, 1].map(|id| record_of(&dem, id).body);
    let drift = (a.velocity * a.mass + b.velocity * b.mass) / (a.mass + b.mass) * 1e-4;
    assert!((center(&dem) - start - drift).norm() < 1e-16);
    // They touch after the relocation, and then part for one step.
    let apart = (b.position - a.position).norm() - a.radius - b.radius;
    assert!(apart > 0.0 && apart < 2e-4, "{apart}");
}

#[test]
fn a_ball_bounces_off_a_moving_wall_with_friction_as_the_closed_form_says() {
    let (e, wall_velocity) = (0.6, Vec3::new(0.3, 0.0, 0.2));
    for scheme in SCHEMES {
        for (mu, slope) in [(0.1, 2.0), (0.8, 0.5), (0.4, 1.1)] {
            let mut setup = hard(0.05, vec![Shape::sphere(RADIUS).unwrap()], e, mu, 1e-5, scheme);
            let floor = Surface::Plane { point: Vec3::repeat(0.02), normal: Vec3::z() };
            let motion = Motion::Translation { velocity: wall_velocity, start: 0.0, end: f64::INFINITY };
            setup.walls = vec![wall("floor", floor, motion)];
            let relative = Vec3::new(slope, 0.0, -1.0);
            let place = Vec3::new(0.025, 0.025, 0.02 + RADIUS + 4.7e-5);
            let mut dem =
                dem_of(setup, vec![particle(0, place, Rotation::identity(), relative + wall_velocity)]);
            until_parted(&mut dem);
            let body = record_of(&dem, 0).body;
            let lost = (mu * (1.0 + e)).min(2.0 / 7.0 * slope);
            let wanted = Vec3::new(slope - lost, 0.0, e) + wall_velocity;
            assert!(
                (body.velocity - wanted).norm() < 1e-12,
                "{scheme:?} {mu}: {} for {wanted}",
                body.velocity
            );
            assert!((body.angular_velocity - Vec3::y() * (2.5 * lost / RADIUS)).norm() < 1e-9);
        }
    }
}

/// The load on the wall is what was exchanged over the step.
#[test]
fn a_wall_feels_the_weight_of_what_lies_on_it() {
    let setup = hard(0.05, vec![Shape::sphere(RADIUS).unwrap()], 0.5, 0.5, 1e-4, ImpulseScheme::Exact);
    let mut setup = with_gravity(setup, Vec3::new(0.0, 0.0, -9.81));
    setup.walls = closed_box(0.01, 0.04);
    let place = Vec3::new(0.025, 0.025, 0.01 + RADIUS);
    let mut dem = dem_of(setup, vec![particle(0, place, Rotation::identity(), Vec3::zeros())]);
    let weight = 9.81 * record_of(&dem, 0).body.mass;
    let mut felt = 0.0;
    for step in 0..200 {
        dem.refresh(&SerialTransport).unwrap();
        dem.add_forces(&SerialTransport);
        if step >= 100 {
            felt += dem.wall_loads(&SerialTransport)[4].force.z / 100.0;
        }
        dem.advance(&SerialTransport).unwrap();
    }
    assert!((felt / weight + 1.0).abs() < 0.02, "{felt} of {weight}");
    assert!((record_of(&dem, 0).body.position - place).norm() < 1e-6, "it stays where it is");
}

/// Reference A11: 50 cylinders in a closed box, e = 1, no friction.
#[test]
fn fifty_elastic_cylinders_keep_their_energy() {
    let shape = Shape::cylinder(RADIUS, 3.0 * RADIUS, 0.05).unwrap();
    let mut setup = hard(0.024, vec![shape], 1.0, 0.0, 2e-6, ImpulseScheme::Exact);
    setup.walls = closed_box(1e-3, 0.023);
    let mut particles = lattice([1e-3; 3], [0.023; 3], 5.5e-3, 1, 2.0);
    particles.truncate(50);
    particles.iter_mut().for_each(|p| p.angular_velocity = Vec3::zeros());
    let mut dem = dem_of(setup, particles);
    let start = kinetic(&dem);
    let (mut worst, mut steps) = (0.0_f64, 0);
    while dem.report.collisions < 2000 {
        dem.refresh(&SerialTransport).unwrap();
        let (before, count) = (kinetic(&dem), dem.report.collisions);
        dem.add_forces(&SerialTransport);
        let collisions = (dem.report.collisions - count).max(1) as f64;
        worst = worst.max((kinetic(&dem) / before - 1.0).abs() / collisions);
        dem.advance(&SerialTransport).unwrap();
        steps += 1;
        assert!(steps < 100_000, "{} collisions", dem.report.collisions);
    }
    let drift = kinetic(&dem) / start - 1.0;
    let totals = dem.totals(&SerialTransport);
    println!("{steps} steps: energy error per collision {worst:.1e}, drift with free rotation {drift:.1e}");
    assert!(worst < 1e-10, "{worst:e} per collision");
    assert!(drift.abs() < 1e-5, "{drift:e} in all");
    assert!(totals.kinetic_rotation > 0.2 * totals.kinetic_translation, "they have begun to turn");
    assert_eq!(dem.check_ledger(&SerialTransport).unwrap().inserted, 50);
    assert_eq!(totals.particles, 50);
}

/// A bed of each shape, poured into a box.
fn bed(shape: Shape, dt: f64) -> Scene {
    let setup = hard(0.03, vec![shape], 0.6, 0.4, dt, ImpulseScheme::Exact);
    let mut setup = with_gravity(setup, Vec3::new(0.0, 0.0, -9.81));
    setup.walls = closed_box(1e-3, 0.014);
    let particles = lattice([1e-3; 3], [0.014, 0.014, 0.0142], 3.2e-3, 1, 4.0);
    Scene { setup, particles }
}

/// A cube rests on one point, wanders, and now and then tips over: what it had is left at the end.
#[test]
fn beds_come_to_rest() {
    for shape in [Shape::sphere(RADIUS).unwrap(), Shape::cuboid(Vec3::repeat(0.9 * RADIUS), 0.05).unwrap()] {
        let name = shape.name.clone();
        let mut dem = bed(shape, 1e-5).start([1; 3], 0);
        let start = kinetic(&dem);
        let mut history = Vec::new();
        for step in 1..=50_000 {
            dem.step(&SerialTransport).unwrap();
            if step > 25_000 && step % 2500 == 0 {
                history.push(kinetic(&dem) / start);
            }
        }
        let report = dem.report;
        println!("{name}: {history:?}, overlap {:.1e}", report.max_overlap);
        let quiet = history.iter().filter(|&&share| share < 1e-6).count();
        assert!(quiet >= 8, "{name} comes to rest: {history:?}");
        assert!(history.iter().all(|&share| share < 1e-5), "{name}: no growth: {history:?}");
        assert!(report.max_overlap < 1e-3 && report.resting_collisions > 100_000, "{report:?}");
    }
}
