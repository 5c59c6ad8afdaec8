//! Bodies that yield.

use crate::Row;
use crate::scene::{Against, Ball, Scene};
use grains_contact::{ContactLaw, ElasticPlastic, Tangential};
use grains_geometry::Vec3;

pub(crate) fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for (e, speed) in [(0.2, 0.1), (0.2, 3.0), (0.5, 0.1), (0.5, 3.0), (0.8, 3.0)] {
        let normal = ElasticPlastic::with_restitution(1e4, e, 0.0);
        let law = ContactLaw::new(normal, e, 0.0, Tangential::Viscous { rate: 0.0 });
        let radius = 2e-3;
        let velocity = Vec3::new(0.0, 0.0, -speed);
        let ball = Ball { radius, density: 2500.0, gap: 0.0, velocity, spin: Vec3::zeros() };
        let collision = law.collision(ball.mass(), radius, speed);
        let dt = collision.shortest_time / 100.0;
        let ball = Ball { gap: 3.37 * speed * dt, ..ball };
        let mut scene = Scene::new(law, &ball, Against::Plane, Vec3::zeros(), dt);
        let mut deepest = 0.0_f64;
        for _ in 0..(2.0 * collision.contact_time / dt) as usize {
            scene.step();
            deepest = deepest.max(scene.overlap());
        }
        let at = format!("k2/k1 = {:.2}, {speed} m/s", 1.0 / (e * e));
        rows.push(Row::new(
            "elastic_plastic",
            format!("restitution, {at}"),
            "-",
            [scene.ball().velocity.z / speed, e],
        ));
        let exact = speed * (ball.mass() / 1e4).sqrt();
        rows.push(
            Row::new("elastic_plastic", format!("largest overlap, {at}"), "m", [deepest, exact]).within(1e-3),
        );
    }
    rows
}
