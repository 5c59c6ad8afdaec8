//! Bridges of liquid, and van der Waals forces.

use crate::Row;
use crate::scene::{Against, Ball, Scene};
use grains_contact::{
    Attraction, BridgeViscosity, Capillary, ContactLaw, Formation, LiquidBridge, Rupture, Supply, Tangential,
    VanDerWaals, Willett,
};
use grains_geometry::Vec3;

const RADIUS: f64 = 1e-3;
const DENSITY: f64 = 2500.0;
const TENSION: f64 = 0.07;

fn bridge(volume: f64, formation: Formation) -> LiquidBridge {
    LiquidBridge {
        surface_tension: TENSION,
        contact_angle: 0.0,
        capillary: Capillary::Willett(Willett::new(0.0)),
        rupture: Rupture::Lian,
        viscosity: BridgeViscosity { viscosity: 0.0, min_gap: 0.01 },
        formation,
        supply: Supply::PerBridge(volume),
    }
}

/// Speed after over before of two balls that meet under a linear spring and this attraction, the energy of which takes a share
/// of that of the collision.
fn restitution(attraction: Attraction, work: f64, share: f64) -> f64 {
    let law =
        ContactLaw::linear(1e4, 1.0, 0.0, Tangential::Viscous { rate: 0.0 }).with_attraction(attraction);
    let ball =
        Ball { radius: RADIUS, density: DENSITY, gap: 0.0, velocity: Vec3::zeros(), spin: Vec3::zeros() };
    let closing = (2.0 * work / share / (0.5 * ball.mass())).sqrt();
    let reach = attraction.reach(0.5 * RADIUS);
    let collision = law.collision(0.5 * ball.mass(), 0.5 * RADIUS, closing);
    let dt = collision.contact_time / 400.0;
    let ball = Ball { gap: 1.2 * reach, velocity: Vec3::new(0.0, 0.0, -0.5 * closing), ..ball };
    let mut scene = Scene::new(law, &ball, Against::Twin, Vec3::zeros(), dt);
    let time = 8.0 * (collision.contact_time + 1.2 * reach / closing);
    (0..(time / dt) as usize).for_each(|_| scene.step());
    scene.ball().velocity.z / (0.5 * closing)
}

pub(crate) fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    // Young-Laplace by quadrature: V/R³, gaps over R, F/(2π R γ).
    let exact: [(f64, &[[f64; 2]]); 2] = [
        (1e-3, &[[0.0, 0.9361], [0.02, 0.3888], [0.05, 0.1283]]),
        (1e-2, &[[0.0, 0.8844], [0.02, 0.7050], [0.05, 0.4732], [0.1, 0.2514]]),
    ];
    for (volume, points) in exact {
        let liquid = bridge(volume * RADIUS.powi(3), Formation::Contact);
        for &[gap, force] in points {
            let pull = liquid.pull(gap * RADIUS, volume * RADIUS.powi(3), 0.5 * RADIUS);
            let found = pull / (2.0 * std::f64::consts::PI * RADIUS * TENSION);
            let quantity = format!("Willett beside Young-Laplace, V {volume} R3, h {gap} R");
            rows.push(Row::new("bridge", quantity, "-", [found, force]).within(0.03));
        }
    }
    for (volume, lian) in [(1e-3, 0.1), (1e-2, 0.215_443_469)] {
        let found = bridge(volume * RADIUS.powi(3), Formation::Contact)
            .rupture_distance(volume * RADIUS.powi(3), 0.5 * RADIUS);
        rows.push(
            Row::new("bridge", format!("rupture over R, V {volume} R3"), "-", [found / RADIUS, lian])
                .within(1e-8),
        );
    }
    for (formation, film) in [(Formation::Contact, 0.0), (Formation::Films, 1e-5)] {
        let (volume, share) = (1e-12, 0.4);
        let liquid = bridge(volume, formation);
        let work = liquid.work(2.0 * film, volume, 0.5 * RADIUS);
        let found = restitution(Attraction::LiquidBridge { bridge: liquid, film }, work, share);
        let quantity = format!("restitution of balls that make a bridge, {formation:?}");
        rows.push(Row::new("bridge", quantity, "-", [found, (1.0 - share).sqrt()]).within(2e-3));
    }
    let law = VanDerWaals { hamaker: 1e-12, asperity: 0.0, inner: 1e-6, outer: 5e-5 };
    for gap in [0.0, 2e-6, 1e-5] {
        let shown = law.pull(gap, 0.5 * RADIUS);
        let exact = |gap: f64| 1e-12 * 0.5 * RADIUS / (6.0 * gap * gap);
        let exact = exact(f64::max(gap, 1e-6)) - exact(5e-5);
        rows.push(
            Row::new("van_der_waals", format!("pull at a gap of {gap:e} m"), "N", [shown, exact])
                .within(1e-12),
        );
    }
    let found = restitution(Attraction::VanDerWaals(law), law.work(0.0, 0.5 * RADIUS), 0.5);
    rows.push(Row::new("van_der_waals", "restitution, as nothing is lost", "-", [found, 1.0]).within(2e-3));
    rows
}
