//! Oblique impacts under the spring law: how the rebound converges to the solution of the equations of motion.

use crate::common::{setup, wall};
use grains_contact::{Collision, ContactLaw, Tangential};
use grains_dem::{Dem, Kind, Motion, NewParticle, Surface};
use grains_domain::SerialTransport;
use grains_geometry::{Rotation, Shape, Vec3};
use std::f64::consts::PI;

const RADIUS: f64 = 1.5e-3;
const DENSITY: f64 = 2500.0;
const NORMAL_STIFFNESS: f64 = 1e5;
const FRICTION: f64 = 0.3;

/// A ball hits at 1 m/s, an angle (rad) off the normal.
#[derive(Clone, Copy)]
struct Impact {
    restitution: f64,
    stiffness_ratio: f64,
    damping_ratio: f64,
    angle: f64,
}

impl Impact {
    fn law(&self) -> ContactLaw {
        let Self { restitution, stiffness_ratio, damping_ratio, .. } = *self;
        let tangential = Tangential::Spring { stiffness_ratio, damping_ratio };
        ContactLaw::linear(NORMAL_STIFFNESS, restitution, FRICTION, tangential)
    }

    fn mass() -> f64 {
        DENSITY * 4.0 / 3.0 * PI * RADIUS.powi(3)
    }

    fn collision(&self) -> Collision {
        self.law().collision(Self::mass(), RADIUS, 1.0)
    }
}

/// Velocity along the wall and away from it (m/s), and spin times radius (m/s), after an impact.
type Rebound = [f64; 3];

/// The rebound by the equations of motion, m dv/dt = F, I dω/dt = r F_t, dξ/dt = u while |F_t| ≤ μ kn δ, in steps so
/// short that their length does not matter.
fn exact(impact: &Impact) -> Rebound {
    const STEPS: f64 = 40_000.0;
    let (collision, mass) = (impact.collision(), Impact::mass());
    let dashpot = 2.0 * mass * impact.law().damping_rate(mass, NORMAL_STIFFNESS);
    let (stiffness, tangential_dashpot) =
        (impact.stiffness_ratio * NORMAL_STIFFNESS, impact.damping_ratio * dashpot);
    let inertia = 0.4 * mass * RADIUS * RADIUS;
    let dt = collision.contact_time / STEPS;
    // Overlap, its rate, velocity along the wall, spin, tangential displacement.
    type State = [f64; 5];
    let friction = |s: &State| {
        let [overlap, _, speed, spin, spring] = *s;
        let slip = speed - (RADIUS - 0.5 * overlap) * spin;
        let limit = FRICTION * NORMAL_STIFFNESS * overlap.max(0.0);
        (slip, (stiffness * spring + tangential_dashpot * slip).clamp(-limit, limit))
    };
    let slope = |s: &State| -> State {
        let (slip, force) = friction(s);
        let push = NORMAL_STIFFNESS * s[0] + dashpot * s[1];
        [s[1], -push / mass, -force / mass, (RADIUS - 0.5 * s[0]) * force / inertia, slip]
    };
    let along = |s: &State, rate: &State, dt: f64| -> State { std::array::from_fn(|k| s[k] + rate[k] * dt) };
    let mut state: State = [0.0, impact.angle.cos(), impact.angle.sin(), 0.0, 0.0];
    loop {
        let middle = along(&state, &slope(&state), 0.5 * dt);
        state = along(&state, &slope(&middle), dt);
        if state[0] <= 0.0 {
            return [state[2], -state[1], state[3] * RADIUS];
        }
        let (slip, force) = friction(&state);
        state[4] = (force - tangential_dashpot * slip) / stiffness;
    }
}

/// A body a fraction of a step before it meets a floor, or another ball, at 1 m/s.
fn before(impact: &Impact, steps: f64, fraction: f64, meets: Meets) -> Dem {
    let law = impact.law();
    let ball = Shape::sphere(RADIUS).unwrap();
    let cube = Shape::cuboid(Vec3::repeat(2.0 * RADIUS), 0.05).unwrap();
    let mut setup = setup([0.05; 3], [false; 3], vec![ball, cube], law);
    setup.parameters.gravity = Vec3::zeros();
    setup.parameters.dt = impact.collision().contact_time / steps;
    setup.overlap_limit = 0.5;
    setup.catalogue.contacts.set(0, 1, law);
    let middle = Vec3::repeat(0.025);
    let velocity = Vec3::new(impact.angle.sin(), 0.0, -impact.angle.cos());
    let gap = Vec3::z() * (-velocity.z * setup.parameters.dt * fraction);
    let still = NewParticle {
        id: 0,
        kind: Kind { shape: 0, material: 0 },
        scale: 1.0,
        position: middle,
        orientation: Rotation::identity(),
        velocity: Vec3::zeros(),
        angular_velocity: Vec3::zeros(),
        temperature: 0.0,
    };
    let at = |height: f64| NewParticle { position: middle + Vec3::z() * height + gap, velocity, ..still };
    let particles = match meets {
        Meets::Floor => vec![at(RADIUS)],
        Meets::Ball => vec![at(2.0 * RADIUS), NewParticle { id: 1, ..still }],
        Meets::Corner => {
            let on_corner = Rotation::rotation_between(&Vec3::new(1.0, 0.8, 1.1), &-Vec3::z()).unwrap();
            let part = &setup.catalogue.shapes[1].parts[0];
            let height =
                part.core.support_value(&on_corner.inverse_transform_vector(&-Vec3::z())) + part.crust;
            vec![NewParticle { kind: Kind { shape: 1, material: 0 }, orientation: on_corner, ..at(height) }]
        }
    };
    if meets != Meets::Ball {
        setup.walls = vec![wall("floor", Surface::Plane { point: middle, normal: Vec3::z() }, Motion::Fixed)];
    }
    let mut dem = Dem::new(setup, 0).unwrap();
    for particle in particles {
        let record = particle.record(&dem);
        dem.insert(&record);
    }
    dem
}

/// What the first body meets.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Meets {
    Floor,
    Ball,
    /// A cube meets the floor with a corner.
    Corner,
}

/// The rebound that the solver finds at a number of steps per contact; the bodies meet a fraction of a step after one.
fn found(impact: &Impact, steps: f64, fraction: f64, meets: Meets) -> Rebound {
    let mut dem = before(impact, steps, fraction, meets);
    for _ in 0..(1.5 * steps) as usize + 4 {
        dem.step(&SerialTransport).unwrap();
    }
    let first = dem.particles.ids.iter().position(|&id| id == 0).unwrap();
    let body = &dem.particles.bodies[first];
    [body.velocity.x, body.velocity.z, body.angular_velocity.y * RADIUS]
}

/// Largest error of the velocities along the wall over angles of 1 to 89 degrees and phases of the first contact, over the
/// speed of the impact.
fn worst(steps: f64, case: Impact, angles: impl Iterator<Item = usize>) -> f64 {
    let mut worst = 0.0_f64;
    for degrees in angles {
        let impact = Impact { angle: (degrees as f64).to_radians(), ..case };
        let exact = exact(&impact);
        for phase in 0..5 {
            let got = found(&impact, steps, f64::from(phase) / 5.0 + 0.013, Meets::Floor);
            for k in [0, 2] {
                worst = worst.max((got[k] - exact[k]).abs());
            }
        }
    }
    worst
}

#[test]
fn friction_converges_with_order_two_at_all_angles() {
    for (restitution, stiffness_ratio, damping_ratio) in
        [(0.9, 2.0 / 7.0, 0.5), (0.98, 0.8, 0.0), (0.6, 2.0 / 7.0, 1.0)]
    {
        let case = Impact { restitution, stiffness_ratio, damping_ratio, angle: 0.0 };
        let errors = [20.0, 50.0, 100.0, 200.0].map(|steps| worst(steps, case, (1..90).step_by(4)));
        let said = errors.map(|e| format!("{e:.2e}"));
        println!(
            "e {restitution}, kt/kn {stiffness_ratio:.2}: {said:?} at 20, 50, 100, 200 steps per contact"
        );
        // An explicit rule of order one has 5e-2, 2e-2, 1e-2, and 5e-3.
        assert!(errors[0] < 2e-2 && errors[3] < 2e-4, "{said:?}");
        assert!(errors[1] / errors[3] > 10.0, "order below two: {said:?}");
    }
}

/// Bodies whose normal turns while they touch, and those that a hit beside the centre turns, against their own limit.
#[test]
fn friction_between_bodies_that_turn_converges_with_order_two() {
    let case = Impact { restitution: 0.8, stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.5, angle: 0.0 };
    for meets in [Meets::Ball, Meets::Corner] {
        let mut errors = [0.0_f64; 3];
        for degrees in (2..90).step_by(8) {
            let impact = Impact { angle: f64::from(degrees).to_radians(), ..case };
            let limit = found(&impact, 6400.0, 0.4, meets);
            for (error, steps) in errors.iter_mut().zip([50.0, 100.0, 200.0]) {
                for fraction in [0.02, 0.35, 0.7] {
                    let got = found(&impact, steps, fraction, meets);
                    (0..3).for_each(|k| *error = error.max((got[k] - limit[k]).abs()));
                }
            }
        }
        let said = errors.map(|e| format!("{e:.2e}"));
        println!("{said:?} at 50, 100, 200 steps per contact");
        assert!(errors[2] < 3e-4 && errors[0] / errors[2] > 10.0, "order below two: {said:?}");
    }
}
