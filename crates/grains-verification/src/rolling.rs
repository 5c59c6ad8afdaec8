//! Balls that roll, and balls that stand.

use crate::Row;
use crate::scene::{Against, Ball, Scene};
use grains_contact::{ContactLaw, Hertz, Linear, Normal, Rolling, Tangential};
use grains_geometry::Vec3;

const GRAVITY: f64 = 9.81;
const RADIUS: f64 = 2e-3;
const FRICTION: f64 = 0.1;
const STIFFNESS: f64 = 1e4;

/// A ball at rest on a slope of this tangent, that rolls at a speed (m/s); way and speed along it after a time (s).
fn roll(normal: Normal, rolling: Rolling, tangent: f64, speed: f64, time: f64) -> [f64; 2] {
    let tangential = Tangential::Spring { stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.5 };
    let law = ContactLaw::new(normal, 0.5, 0.5, tangential).with_rolling(rolling);
    let cos = 1.0 / (1.0 + tangent * tangent).sqrt();
    let gravity = Vec3::new(GRAVITY * tangent * cos, 0.0, -GRAVITY * cos);
    let ball = Ball {
        radius: RADIUS,
        density: 2500.0,
        gap: 0.0,
        velocity: Vec3::x() * speed,
        spin: Vec3::y() * (speed / RADIUS),
    };
    let weight = ball.mass() * GRAVITY * cos;
    let overlap = match normal {
        Normal::Hertz(Hertz { modulus }) => (0.75 * weight / (modulus * RADIUS.sqrt())).powf(2.0 / 3.0),
        _ => weight / STIFFNESS,
    };
    let dt = 5e-6;
    let mut scene = Scene::new(law, &Ball { gap: -overlap, ..ball }, Against::Plane, gravity, dt);
    (0..(time / dt) as usize).for_each(|_| scene.step());
    [scene.way().x, scene.ball().velocity.x]
}

pub(crate) fn rows() -> Vec<Row> {
    let friction = FRICTION;
    let linear: Normal = Linear { stiffness: STIFFNESS }.into();
    let hertz: Normal = Hertz { modulus: 1e8 }.into();
    let given = Rolling::Given { friction, stiffness: 4e3, dashpot: 1.0 };
    let rules = [
        ("spring", linear, Rolling::spring(friction)),
        ("spring", hertz, Rolling::spring(friction)),
        ("sds", linear, given),
        ("epsd2", linear, Rolling::Tangential { friction }),
        ("constant", linear, Rolling::Constant { friction }),
    ];
    let mut rows = Vec::new();
    for (name, normal, rolling) in rules {
        let on = normal.name();
        for tangent in [0.15, 0.3] {
            let sin = tangent / f64::sqrt(1.0 + tangent * tangent);
            let exact = 5.0 / 7.0 * GRAVITY * sin * (1.0 - FRICTION / tangent);
            // Between two times, as the ball begins by winding its springs.
            let [early, late] = [0.1, 0.2].map(|time| roll(normal, rolling, tangent, 0.0, time)[1]);
            let quantity = format!("{name} on {on}: acceleration on a slope of {tangent}");
            rows.push(Row::new("rolling", quantity, "m/s2", [(late - early) / 0.1, exact]));
        }
        let exact = 0.1 - 5.0 / 7.0 * FRICTION * GRAVITY * 0.1;
        let found = roll(normal, rolling, 0.0, 0.1, 0.1)[1];
        rows.push(Row::new(
            "rolling",
            format!("{name} on {on}: speed after 0.1 s on the flat"),
            "m/s",
            [found, exact],
        ));
        if matches!(rolling, Rolling::Spring { .. } | Rolling::Given { .. }) {
            let [at, later] = [0.3, 0.6].map(|time| roll(normal, rolling, 0.95 * FRICTION, 0.0, time)[0]);
            let quantity = format!("{name} on {on}: way in 0.3 s on a slope of 0.95 mu_r");
            rows.push(Row::new("rolling", quantity, "m", [later - at, 0.0]).within(1e-6).of_scale(RADIUS));
        }
    }
    rows
}
