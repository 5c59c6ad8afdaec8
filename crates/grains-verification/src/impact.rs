//! Head-on collisions.

use crate::Row;
use crate::scene::{Against, Ball, Scene};
use grains_contact::{ContactLaw, Damping, Elastic, Hertz, Linear, Normal, Tangential, effective_modulus};
use grains_geometry::Vec3;

const NO_FRICTION: Tangential = Tangential::Viscous { rate: 0.0 };

/// What a collision came to.
struct Course {
    restitution: f64,
    contact_time: f64,
    max_overlap: f64,
    max_force: f64,
}

/// Runs a collision in so many steps per contact.
fn collide(law: ContactLaw, ball: &Ball, against: Against, steps: f64) -> Course {
    let (mass, radius) = against.reduced(ball);
    let speed = -ball.velocity.z;
    let closing = if against == Against::Twin { 2.0 * speed } else { speed };
    let expected = law.collision(mass, radius, closing);
    let dt = expected.shortest_time / steps;
    // The bodies touch between two steps.
    let ball = Ball { gap: 3.37 * closing * dt, ..*ball };
    let mut scene = Scene::new(law, &ball, against, Vec3::zeros(), dt);
    let (mut last, mut touched) = ((scene.overlap(), speed), false);
    let mut course = Course { restitution: 0.0, contact_time: 0.0, max_overlap: 0.0, max_force: 0.0 };
    for step in 1..=(20.0 * steps * expected.contact_time / expected.shortest_time) as u64 {
        scene.step();
        let (overlap, velocity) = (scene.overlap(), -scene.ball().velocity.z);
        let time = step as f64 * dt;
        if overlap > 0.0 && last.0 <= 0.0 {
            touched = true;
            course.contact_time = -(time - overlap / closing);
        }
        course.max_overlap = course.max_overlap.max(overlap);
        course.max_force = course.max_force.max(ball.mass() * (last.1 - velocity) / dt);
        if touched && overlap <= 0.0 {
            course.contact_time += time - overlap / (velocity * closing / speed);
            break;
        }
        last = (overlap, velocity);
    }
    (0..3).for_each(|_| scene.step());
    course.restitution = scene.ball().velocity.z / speed;
    course
}

/// Materials after Chung and Ooi (2011).
const GLASS: (f64, f64, f64) = (4.8e10, 0.2, 2800.0);
const LIMESTONE: (f64, f64, f64) = (2.0e10, 0.25, 2500.0);
const ALUMINIUM_ALLOY: (f64, f64, f64) = (7.0e10, 0.3, 2699.0);
const MAGNESIUM_ALLOY: (f64, f64, f64) = (4.0e10, 0.35, 1800.0);
const ALUMINIUM_OXIDE: (f64, f64, f64) = (3.8e11, 0.23, 4000.0);

fn elastic((youngs_modulus, poissons_ratio, _): (f64, f64, f64)) -> Elastic {
    Elastic { youngs_modulus, poissons_ratio }
}

pub(crate) fn rows() -> Vec<Row> {
    [linear(), hertz(), restitution(), viscoelastic()].concat()
}

/// Contact time, depth and restitution of a spring and dashpot (reference rows A1a-A1f).
fn linear() -> Vec<Row> {
    let mut rows = Vec::new();
    for (stiffness, e, radius, density, speed) in
        [(1e5, 0.73, 1.5e-3, 2500.0, 1.0), (7.2e5, 0.75, 6.9e-3, 2500.0, 4.5)]
    {
        let law = ContactLaw::linear(stiffness, e, 0.0, NO_FRICTION);
        for against in [Against::Plane, Against::Twin] {
            let ball = ball(radius, density, if against == Against::Twin { 0.5 * speed } else { speed });
            let found = collide(law, &ball, against, 200.0);
            let exact = law.collision(against.reduced(&ball).0, radius, speed);
            let at = format!("k {stiffness:.1e} N/m, e {e}, {}", name(against));
            rows.push(
                Row::new(
                    "linear",
                    format!("contact time, {at}"),
                    "s",
                    [found.contact_time, exact.contact_time],
                )
                .within(1e-3),
            );
            rows.push(
                Row::new(
                    "linear",
                    format!("largest overlap, {at}"),
                    "m",
                    [found.max_overlap, exact.max_overlap],
                )
                .within(1e-3),
            );
        }
    }
    rows
}

fn ball(radius: f64, density: f64, speed: f64) -> Ball {
    Ball { radius, density, gap: 0.0, velocity: Vec3::new(0.0, 0.0, -speed), spin: Vec3::zeros() }
}

fn name(against: Against) -> &'static str {
    if against == Against::Plane { "plane" } else { "pair" }
}

/// Elastic impact of two spheres and of one on a plane (Chung and Ooi 2011, tests 1 and 2; Timoshenko and Goodier).
fn hertz() -> Vec<Row> {
    let mut rows = Vec::new();
    for (what, material, radius, speed, against) in [
        ("glass", GLASS, 0.01, 10.0, Against::Twin),
        ("limestone", LIMESTONE, 0.01, 10.0, Against::Twin),
        ("Al alloy", ALUMINIUM_ALLOY, 0.1, 0.2, Against::Plane),
        ("Mg alloy", MAGNESIUM_ALLOY, 0.1, 0.2, Against::Plane),
    ] {
        let body = elastic(material);
        let rigid = Elastic { youngs_modulus: 1e30, ..body };
        let modulus = effective_modulus(body, if against == Against::Twin { body } else { rigid });
        let law = ContactLaw::new(Hertz { modulus }, 1.0, 0.0, NO_FRICTION);
        let ball = ball(radius, material.2, speed);
        let found = collide(law, &ball, against, 200.0);
        let ((mass, reduced), closing) =
            (against.reduced(&ball), if against == Against::Twin { 2.0 * speed } else { speed });
        let depth = (15.0 * mass * closing * closing / (16.0 * modulus * reduced.sqrt())).powf(0.4);
        let force = 4.0 / 3.0 * modulus * reduced.sqrt() * depth.powf(1.5);
        let at = format!("{what}, {}", name(against));
        rows.extend([
            Row::new("hertz", format!("largest force, {at}"), "N", [found.max_force, force]).within(2e-3),
            Row::new(
                "hertz",
                format!("contact time, {at}"),
                "s",
                [found.contact_time, 2.943_275 * depth / closing],
            )
            .within(2e-3),
            Row::new("hertz", format!("largest overlap, {at}"), "m", [found.max_overlap, depth]).within(1e-3),
        ]);
    }
    rows
}

/// Restitution as asked for (Chung and Ooi 2011, test 3: aluminium oxide on a plate, e = 0 to 1).
fn restitution() -> Vec<Row> {
    let hertz = Hertz { modulus: effective_modulus(elastic(ALUMINIUM_OXIDE), elastic(ALUMINIUM_OXIDE)) };
    let laws: [(&'static str, Normal, f64); 2] =
        [("linear", Linear { stiffness: 1e5 }.into(), 1.0), ("hertz", hertz.into(), 3.9)];
    let mut rows = Vec::new();
    for (law, normal, speed) in laws {
        for e in [0.1, 0.3, 0.5, 0.7, 0.9, 1.0] {
            let ball = ball(2.5e-3, ALUMINIUM_OXIDE.2, speed);
            let found = collide(ContactLaw::new(normal, e, 0.0, NO_FRICTION), &ball, Against::Plane, 100.0);
            rows.push(Row::new(law, format!("restitution {e} asked for"), "-", [found.restitution, e]));
        }
    }
    rows
}

/// 1 − e = A (2/5) B(3/5, 3/2) · 3 k √δm³/(m v) for short times A, k = (4/3) E* √R* (first order of Ramírez et al. 1999).
fn viscoelastic() -> Vec<Row> {
    let (modulus, radius, density, speed): (f64, f64, f64, f64) = (1e9, 2e-3, 2500.0, 0.5);
    let ball = ball(radius, density, speed);
    let mass = ball.mass();
    let depth = (15.0 * mass * speed * speed / (16.0 * modulus * radius.sqrt())).powf(0.4);
    let stiffness = 4.0 / 3.0 * modulus * radius.sqrt();
    let beta = libm::tgamma(0.6) * libm::tgamma(1.5) / libm::tgamma(2.1);
    let per_time = 3.0 * stiffness * depth.powf(1.5) / (mass * speed) * 0.4 * beta;
    let time = 2e-3 / per_time;
    let law = ContactLaw::new(Hertz { modulus }, 0.9, 0.0, NO_FRICTION)
        .with_damping(Damping::Viscoelastic { time });
    let found = collide(law, &ball, Against::Plane, 800.0);
    vec![
        Row::new(
            "hertz",
            "loss 1 - e of viscoelastic bodies, first order in A",
            "-",
            [1.0 - found.restitution, 2e-3],
        )
        .within(1e-2),
    ]
}
