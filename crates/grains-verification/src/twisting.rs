//! A ball that spins about the normal.

use crate::Row;
use crate::scene::{Against, Ball, Scene};
use grains_contact::{ContactLaw, Hertz, Tangential, Twisting};
use grains_geometry::Vec3;
use std::f64::consts::PI;

pub(crate) fn rows() -> Vec<Row> {
    let (modulus, radius, friction, gravity) = (1e7, 2e-3, 0.4, 9.81);
    let ball = Ball { radius, density: 2500.0, gap: 0.0, velocity: Vec3::zeros(), spin: Vec3::z() * 20.0 };
    let weight = ball.mass() * gravity;
    let overlap = (0.75 * weight / (modulus * f64::sqrt(radius))).powf(2.0 / 3.0);
    let contact_radius = (radius * overlap).sqrt();
    let inertia = 0.4 * ball.mass() * radius * radius;
    let stiffness_ratio = 0.8;
    let law = |damping_ratio: f64| {
        let tangential = Tangential::Mindlin { stiffness_ratio, damping_ratio, memory: Default::default() };
        ContactLaw::new(Hertz { modulus }, 0.5, friction, tangential).with_twisting(Twisting::Marshall)
    };
    let dt = 2e-6;
    let pressed = Ball { gap: -overlap, ..ball };
    let fall = Vec3::new(0.0, 0.0, -gravity);
    // It slips: dω/dt = (2/3) a μ N/I.
    let mut scene = Scene::new(law(0.5), &pressed, Against::Plane, fall, dt);
    let mut after = |time: f64| {
        (0..(time / dt) as usize).for_each(|_| scene.step());
        scene.ball().angular_velocity.z
    };
    let (early, late) = (after(0.02), after(0.04));
    let exact = 2.0 / 3.0 * contact_radius * friction * weight / inertia;
    let slipping = Row::new(
        "twisting",
        "marshall: deceleration while it slips",
        "rad/s2",
        [(early - late) / 0.04, exact],
    )
    .within(2e-3);
    // It swings on the spring: ω² = k_t a²/(2 I), without a dashpot.
    let slow = Ball { spin: Vec3::z() * 1e-3, ..pressed };
    let mut scene = Scene::new(law(0.0), &slow, Against::Plane, fall, dt);
    let stiffness = stiffness_ratio * 2.0 * modulus * contact_radius;
    let exact = 2.0 * PI / (0.5 * stiffness * contact_radius * contact_radius / inertia).sqrt();
    let (mut crossings, mut last, mut step) = (Vec::new(), 1.0, 0_u32);
    while crossings.len() < 7 && step < 2_000_000 {
        scene.step();
        step += 1;
        let now = scene.ball().angular_velocity.z;
        if now * last < 0.0 {
            crossings.push(f64::from(step) * dt - dt * now / (now - last));
        }
        last = now;
    }
    let period = match crossings[..] {
        [first, .., last] => 2.0 * (last - first) / (crossings.len() - 1) as f64,
        _ => f64::NAN,
    };
    let swing =
        Row::new("twisting", "marshall: period of a swing on the spring", "s", [period, exact]).within(2e-3);
    vec![slipping, swing]
}
