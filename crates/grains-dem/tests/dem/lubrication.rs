//! Films of fluid between spheres and at walls against what the lubrication force integrates to.

use crate::common::{setup, wall};
use grains_contact::{ContactLaw, Lubrication, Tangential};
use grains_dem::{Dem, DemSetup, Kind, Motion, NewParticle, Surface};
use grains_domain::SerialTransport;
use grains_geometry::{Rotation, Shape, Vec3};
use std::f64::consts::PI;

const RADIUS: f64 = 1.5e-3;
const MASS: f64 = 2500.0 * 4.0 / 3.0 * PI * RADIUS * RADIUS * RADIUS;
const RANGE: f64 = 3e-4;
const LEAST: f64 = 1e-3;

/// Spheres alone in a box, and a floor at half its height if there is one of them only.
fn scene(viscosity: f64, particles: &[(Vec3, Vec3)]) -> Dem {
    let law = ContactLaw::linear(1e5, 0.9, 0.0, Tangential::Viscous { rate: 0.0 });
    let mut setup = setup([0.05; 3], [false; 3], vec![Shape::sphere(RADIUS).unwrap()], law);
    setup.parameters.gravity = Vec3::zeros();
    setup.parameters.dt = law.collision(MASS, RADIUS, 1.0).contact_time / 400.0;
    setup.lubrication = Some(Lubrication { viscosity, range: RANGE, min_gap: LEAST });
    if particles.len() == 1 {
        let floor = Surface::Plane { point: Vec3::repeat(0.025), normal: Vec3::z() };
        setup.catalogue.contacts.set(0, 1, law);
        setup.walls = vec![wall("floor", floor, Motion::Fixed)];
    }
    with_particles(setup, particles)
}

fn with_particles(setup: DemSetup, particles: &[(Vec3, Vec3)]) -> Dem {
    let mut dem = Dem::new(setup, 0).unwrap();
    for (id, &(position, velocity)) in (0..).zip(particles) {
        let (orientation, angular_velocity) = (Rotation::identity(), Vec3::zeros());
        let kind = Kind { shape: 0, material: 0 };
        let new = NewParticle {
            id,
            kind,
            scale: 1.0,
            position,
            orientation,
            velocity,
            angular_velocity,
            temperature: 0.0,
        };
        let record = new.record(&dem);
        dem.insert(&record);
    }
    dem
}

#[test]
fn a_film_at_a_wall_takes_the_speed_it_should_before_and_after_the_impact() {
    // m dv/dt = −6 π μ a² v (1/max(h, ε a) − 1/H): the speed falls by 6 π μ a²/m ln(H/(ε a)) both ways.
    for viscosity in [1e-3, 5e-3, 1e-2] {
        let loss = 6.0 * PI * viscosity * RADIUS * RADIUS / MASS * (RANGE / (LEAST * RADIUS)).ln();
        let start = Vec3::repeat(0.025) + Vec3::z() * (RADIUS + 1.5 * RANGE);
        let mut dem = scene(viscosity, &[(start, -Vec3::z())]);
        let (mut before, mut touched) = (0.0, false);
        for _ in 0..40_000 {
            let velocity = dem.particles.bodies[0].velocity.z;
            dem.step(&SerialTransport).unwrap();
            if dem.report.max_overlap == 0.0 && !touched {
                before = -velocity;
            }
            touched |= dem.report.max_overlap > 0.0;
            if touched && dem.particles.bodies[0].position.z > start.z {
                break;
            }
        }
        let after = dem.particles.bodies[0].velocity.z;
        let wanted = [1.0 - loss, 0.9 * (1.0 - loss) - loss];
        assert!((before - wanted[0]).abs() < 3e-3, "{viscosity}: {before} for {}", wanted[0]);
        assert!((after - wanted[1]).abs() < 5e-3, "{viscosity}: {after} for {}", wanted[1]);
    }
}

#[test]
fn a_thick_film_stops_two_spheres_before_they_touch() {
    let viscosity = 0.6;
    let lift = Vec3::z() * (RADIUS + 0.5 * RANGE);
    let middle = Vec3::repeat(0.025);
    let mut dem = scene(viscosity, &[(middle - lift, Vec3::z() * 0.5), (middle + lift, -Vec3::z() * 0.5)]);
    for _ in 0..20_000 {
        dem.step(&SerialTransport).unwrap();
        assert_eq!(dem.report.max_overlap, 0.0);
    }
    let [low, high] =
        [0, 1].map(|i| &dem.particles.bodies[dem.particles.ids.iter().position(|&id| id == i).unwrap()]);
    assert!((low.velocity + high.velocity).norm() < 1e-15, "momentum is kept");
    // (m/2) v₀ = 6 π μ (a/2)² (ln(H/h) − (H − h)/H): where they come to rest.
    let gap = (high.position - low.position).norm() - 2.0 * RADIUS;
    let reached = (RANGE / gap).ln() - (RANGE - gap) / RANGE;
    let wanted = 0.5 * MASS / (6.0 * PI * viscosity * 0.25 * RADIUS * RADIUS);
    assert!((reached / wanted - 1.0).abs() < 5e-3, "{reached} for {wanted}");
    assert!(low.velocity.norm() < 1e-6, "{}", low.velocity);
}

#[test]
fn films_of_any_thickness_are_stable_however_many_act_on_a_sphere() {
    // A row of spheres between two walls, all but touching, in a fluid that would stop them in a twentieth of a step.
    let gap = 2.0 * LEAST * RADIUS;
    let place = |k: usize| Vec3::new(0.025, 0.025, 0.02 + (2 * k + 1) as f64 * RADIUS + (k + 1) as f64 * gap);
    let row = [0, 1, 2].map(|k| (place(k), Vec3::z() * [0.02, -0.02, 0.01][k]));
    let mut dem = scene(1.0, &row);
    let rate = 6.0 * PI * RADIUS / LEAST / MASS * dem.setup.parameters.dt;
    dem.setup.lubrication = dem.setup.lubrication.map(|film| Lubrication { viscosity: 20.0 / rate, ..film });
    let top = 0.02 + 6.0 * RADIUS + 4.0 * gap;
    for (z, normal) in [(0.02, Vec3::z()), (top, -Vec3::z())] {
        let surface = Surface::Plane { point: Vec3::new(0.0, 0.0, z), normal };
        dem.setup.catalogue.contacts.set(
            0,
            1,
            ContactLaw::linear(1e5, 0.9, 0.0, Tangential::Viscous { rate: 0.0 }),
        );
        dem.setup.walls.push(wall("plate", surface, Motion::Fixed));
    }
    let mut dem = with_particles(dem.setup.clone(), &row);
    for step in 0..400 {
        dem.step(&SerialTransport).unwrap();
        let fastest = dem.particles.bodies.iter().map(|b| b.velocity.norm()).fold(0.0, f64::max);
        assert!(fastest <= 0.03, "step {step}: {fastest}");
        assert!(step < 100 || fastest < 1e-6, "step {step}: {fastest}");
    }
}
