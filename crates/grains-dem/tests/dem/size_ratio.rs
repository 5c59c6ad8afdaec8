//! A small sphere at rest on a large one.

use crate::common::setup;
use grains_contact::{ContactLaw, Hertz, Linear, Normal, Rolling, Tangential};
use grains_dem::{Dem, Kind, Motion, NewParticle, PrescribedMotion};
use grains_domain::SerialTransport;
use grains_geometry::{Rotation, Shape, Vec3};

const RADIUS: f64 = 1e-3;

/// Way (m) that a sphere goes in 0.2 s on the slope of a fixed one so many times as large.
fn way(normal: Normal, ratio: f64, tangent: f64) -> f64 {
    let stiffness_ratio = 2.0 / 7.0;
    let tangential = match normal {
        Normal::Hertz(_) => {
            Tangential::Mindlin { stiffness_ratio, damping_ratio: 0.5, memory: Default::default() }
        }
        _ => Tangential::Spring { stiffness_ratio, damping_ratio: 0.5 },
    };
    let law = ContactLaw::new(normal, 0.5, 0.5, tangential).with_rolling(Rolling::spring(0.2));
    let size = 4.0 * ratio * RADIUS;
    let mut setup = setup([size; 3], [false; 3], vec![Shape::sphere(RADIUS).unwrap()], law);
    setup.largest_radius = ratio * RADIUS;
    setup.parameters.dt = 4e-6;
    let fixed =
        PrescribedMotion { name: "large".into(), ids: 0..1, motion: Motion::Fixed, about_centres: false };
    setup.prescribed = vec![fixed];
    let mut dem = Dem::new(setup, 0).unwrap();
    let cos = 1.0 / (1.0 + tangent * tangent).sqrt();
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3);
    let effective = RADIUS * ratio / (1.0 + ratio);
    let overlap = match normal {
        Normal::Hertz(Hertz { modulus }) => {
            (0.75 * mass * 9.81 * cos / (modulus * effective.sqrt())).powf(2.0 / 3.0)
        }
        _ => mass * 9.81 * cos / 1e4,
    };
    let middle = Vec3::repeat(0.5 * size);
    let up = Vec3::new(tangent * cos, 0.0, cos);
    for (id, scale, position) in
        [(0, ratio, middle), (1, 1.0, middle + up * ((1.0 + ratio) * RADIUS - overlap))]
    {
        let record = NewParticle {
            id,
            kind: Kind { shape: 0, material: 0 },
            scale,
            position,
            orientation: Rotation::identity(),
            velocity: Vec3::zeros(),
            angular_velocity: Vec3::zeros(),
            temperature: 0.0,
        }
        .record(&dem);
        dem.insert(&record);
    }
    dem.announce_insertion();
    let place = |dem: &Dem| {
        let small = dem.particles.ids.iter().position(|&id| id == 1).unwrap();
        dem.particles.bodies[small].position
    };
    // One that has rolled off ends the run.
    let run = |dem: &mut Dem| (0..50_000).try_for_each(|_| dem.step(&SerialTransport));
    if run(&mut dem).is_err() {
        return f64::INFINITY;
    }
    let before = place(&dem);
    if run(&mut dem).is_err() { f64::INFINITY } else { (place(&dem) - before).norm() }
}

/// It stands where tan β < μ_r R/(r + R), without creeping, and rolls beyond.
#[test]
fn a_small_sphere_stands_on_a_large_one_without_creeping() {
    for normal in [Normal::from(Linear { stiffness: 1e4 }), Hertz { modulus: 1e8 }.into()] {
        for ratio in [2.0, 5.0, 20.0, 100.0] {
            let limit = 0.2 * ratio / (1.0 + ratio);
            let standing = way(normal, ratio, 0.9 * limit);
            assert!(standing < 1e-10, "{} {ratio}: {standing} m in 0.2 s", normal.name());
            let rolling = way(normal, ratio, 1.1 * limit);
            assert!(rolling > 1e-4, "{} {ratio}: {rolling} m in 0.2 s", normal.name());
        }
    }
}
