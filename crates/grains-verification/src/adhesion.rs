//! Bodies that stick.

use crate::Row;
use crate::scene::{Against, Ball, Scene};
use grains_contact::{CohesionArea, ContactLaw, Dmt, Hertz, Jkr, Normal, Sjkr, Tangential, Tear};
use grains_geometry::Vec3;
use std::f64::consts::PI;

const RADIUS: f64 = 2.5e-3;
const MODULUS: f64 = 1e7;
/// Work of adhesion of two surfaces of 0.05 J/m².
const WORK: f64 = 0.1;

const NO_FRICTION: Tangential = Tangential::Viscous { rate: 0.0 };

/// Largest pull, the gap at which it ceased, and speed after over before, of a ball that meets a plane at a speed.
fn separate(normal: Normal, speed: f64, restitution: f64) -> [f64; 3] {
    let law = ContactLaw::new(normal, restitution, 0.0, NO_FRICTION);
    let ball = Ball {
        radius: RADIUS,
        density: 2500.0,
        gap: 0.0,
        velocity: Vec3::new(0.0, 0.0, -speed),
        spin: Vec3::zeros(),
    };
    let dt = law.collision(ball.mass(), RADIUS, speed).shortest_time / 4000.0;
    let ball = Ball { gap: 3.37 * speed * dt, ..ball };
    let mut scene = Scene::new(law, &ball, Against::Plane, Vec3::zeros(), dt);
    let (mut forces, mut last, mut before) = (Vec::new(), -speed, scene.overlap());
    for _ in 0..40_000 {
        scene.step();
        let velocity = scene.ball().velocity.z;
        let force = ball.mass() * (velocity - last) / dt;
        if force != 0.0 {
            forces.push((force, -before));
        }
        before = scene.overlap();
        last = velocity;
    }
    // The first and the last stand for more or less than a step.
    let lasting = forces.get(1..forces.len().saturating_sub(1)).unwrap_or_default();
    let [pull, gap] = lasting.iter().fold([0.0_f64; 2], |max, at| [max[0].max(-at.0), max[1].max(at.1)]);
    [pull, gap, last / speed]
}

/// Overlap (m) at which a ball comes to rest under its own adhesion.
fn rest(normal: Normal) -> f64 {
    let law = ContactLaw::new(normal, 0.3, 0.0, NO_FRICTION);
    let ball =
        Ball { radius: RADIUS, density: 2500.0, gap: -1e-9, velocity: Vec3::zeros(), spin: Vec3::zeros() };
    let mut scene = Scene::new(law, &ball, Against::Plane, Vec3::zeros(), 1e-6);
    (0..200_000).for_each(|_| scene.step());
    scene.overlap()
}

pub(crate) fn rows() -> Vec<Row> {
    let hertz = Hertz { modulus: MODULUS };
    let jkr = |tear: Tear| -> Normal { Jkr { modulus: MODULUS, work: WORK, tear }.into() };
    let mut rows = Vec::new();
    // (R γ²/E²)^(1/3), γ = w/2.
    let unit = (RADIUS * 0.25 * WORK * WORK / (MODULUS * MODULUS)).cbrt();
    let a0 = (4.5 * PI * WORK * RADIUS * RADIUS / MODULUS).cbrt();
    let energy = 0.5 * 2500.0 * 4.0 / 3.0 * PI * RADIUS.powi(3);
    for (tear, gap, name) in
        [(Tear::Displacement, 2.554_0, "torn by displacement"), (Tear::Load, 1.227_72, "torn by load")]
    {
        let [pull, found, e] = separate(jkr(tear), 0.03, 1.0);
        rows.push(
            Row::new("jkr", format!("pull-off force, {name}"), "N", [pull, 1.5 * PI * WORK * RADIUS])
                .within(2e-3),
        );
        rows.push(Row::new("jkr", format!("gap at the end, {name}"), "m", [found, gap * unit]).within(1e-2));
        let loss = loop_energy(tear);
        let exact = (1.0 - loss / (energy * 9e-4)).sqrt();
        rows.push(Row::new("jkr", format!("restitution at 30 mm/s, {name}"), "-", [e, exact]).within(2e-3));
    }
    rows.push(
        Row::new("jkr", "overlap at rest", "m", [rest(jkr(Tear::Displacement)), a0 * a0 / (3.0 * RADIUS)])
            .within(1e-4),
    );
    let [pull, _, e] = separate(Dmt { hertz, work: WORK }.into(), 0.03, 1.0);
    rows.push(Row::new("dmt", "pull-off force", "N", [pull, 2.0 * PI * WORK * RADIUS]).within(5e-3));
    rows.push(Row::new("dmt", "restitution at 30 mm/s", "-", [e, 1.0]).within(1e-3));
    let at_rest = (1.5 * PI * WORK * RADIUS / (MODULUS * RADIUS.sqrt())).powf(2.0 / 3.0);
    rows.push(
        Row::new("dmt", "overlap at rest", "m", [rest(Dmt { hertz, work: WORK }.into()), at_rest])
            .within(1e-4),
    );
    for (area, factor) in
        [(CohesionArea::Circle, 1.0), (CohesionArea::Lens, 2.0), (CohesionArea::DoubleLens, 4.0)]
    {
        let density = 2e4;
        let normal: Normal = Sjkr { hertz, energy_density: density, area }.into();
        // (4/3) E √(R δ) = factor π k R.
        let exact = (0.75 * factor * PI * density / MODULUS).powi(2) * RADIUS;
        rows.push(
            Row::new("sjkr", format!("overlap at rest, {area:?}"), "m", [rest(normal), exact]).within(1e-4),
        );
    }
    rows
}

/// Energy that is lost between touch and tear: −∫ F dδ from the end to δ = 0, in closed form of t = √(a/a0).
fn loop_energy(tear: Tear) -> f64 {
    let primitive = |t: f64| 4.0 / 3.0 * t.powi(7) - 0.5 * t.powi(4) - 8.0 / 15.0 * t.powi(10);
    let end: f64 = match tear {
        Tear::Displacement => 0.25,
        Tear::Load => 0.75,
    };
    let a0 = (2.0 * PI * WORK * RADIUS * RADIUS / MODULUS).cbrt();
    MODULUS * a0.powi(5) / (RADIUS * RADIUS) * (primitive(1.0) - primitive(end.cbrt()))
}
