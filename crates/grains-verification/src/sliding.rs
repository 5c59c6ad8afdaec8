//! Oblique impacts that slide from beginning to end, and what a Mindlin spring keeps.

use crate::Row;
use crate::scene::{Against, Ball, Scene};
use grains_contact::{
    Approach, ContactLaw, Elastic, Encounter, Hertz, Memory, Tangential, effective_modulus,
    effective_shear_modulus,
};
use grains_geometry::Vec3;

/// Aluminium oxide on a plate of an aluminium alloy (Kharaz, Gorham and Salman 2001; Chung and Ooi 2011, tests 4 to 8).
const OXIDE: Elastic = Elastic { youngs_modulus: 3.8e11, poissons_ratio: 0.23 };
const FRICTION: f64 = 0.092;
const RESTITUTION: f64 = 0.98;

fn law(friction: f64, restitution: f64, memory: Memory) -> ContactLaw {
    let modulus = effective_modulus(OXIDE, OXIDE);
    let stiffness_ratio = 4.0 * effective_shear_modulus(OXIDE, OXIDE) / modulus;
    let tangential = Tangential::Mindlin {
        stiffness_ratio,
        damping_ratio: Tangential::equal_damping(stiffness_ratio),
        memory,
    };
    ContactLaw::new(Hertz { modulus }, restitution, friction, tangential)
}

/// The ball after an impact.
fn after(ball: &Ball) -> (Vec3, Vec3) {
    let law = law(FRICTION, RESTITUTION, Memory::ForceRescaled);
    let speed = -ball.velocity.z;
    let collision = law.collision(ball.mass(), ball.radius, speed);
    let dt = collision.contact_time / 200.0;
    let ball = Ball { gap: 3.37 * speed * dt, ..*ball };
    let mut scene = Scene::new(law, &ball, Against::Plane, Vec3::zeros(), dt);
    (0..300).for_each(|_| scene.step());
    (scene.ball().velocity, scene.ball().angular_velocity)
}

pub(crate) fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    // v_x after = v_x - μ (1 + e) v_n and ω after = ω + 5 μ (1 + e) v_n/(2 R), about y.
    let (radius, normal) = (2.5e-3, 3.9);
    let change = FRICTION * (1.0 + RESTITUTION) * normal;
    let ball = |along: f64, spin: f64| Ball {
        radius,
        density: 4000.0,
        gap: 0.0,
        velocity: Vec3::new(along, 0.0, -normal),
        spin: Vec3::y() * spin,
    };
    for degrees in [40.0_f64, 60.0, 80.0] {
        let along = normal * degrees.to_radians().tan();
        let (velocity, spin) = after(&ball(along, 0.0));
        let at = format!("after sliding impact at {degrees} degrees");
        let wanted = 2.5 * change / radius;
        rows.push(
            Row::new(
                "hertz mindlin",
                format!("speed along the plate {at}"),
                "m/s",
                [velocity.x, along - change],
            )
            .within(2e-3),
        );
        rows.push(Row::new("hertz mindlin", format!("spin {at}"), "rad/s", [spin.y, wanted]).within(4e-3));
    }
    for spin in [-2000.0, 2000.0] {
        let (velocity, after) = after(&ball(0.0, spin));
        let sign = f64::signum(spin);
        let at = format!("after a head-on impact with {spin} rad/s");
        rows.push(
            Row::new(
                "hertz mindlin",
                format!("speed along the plate {at}"),
                "m/s",
                [velocity.x, sign * change],
            )
            .within(4e-3),
        );
        rows.push(
            Row::new(
                "hertz mindlin",
                format!("spin {at}"),
                "rad/s",
                [after.y, spin - sign * 2.5 * change / radius],
            )
            .within(2e-3),
        );
    }
    rows.extend(memories());
    rows
}

/// Work of a closed cycle without slip beyond friction: pressed, sheared, half released, sheared back, released.
fn memories() -> Vec<Row> {
    let work = |memory: Memory| {
        let law = law(1e3, 1.0, memory).prepared();
        let (mut displacement, mut slipped, mut work) = (Vec3::zeros(), 0.0, 0.0);
        let (dt, steps) = (1e-9, 4000);
        let mut run = |from: f64, to: f64, slip: f64| {
            for k in 0..steps {
                let share = (f64::from(k) + 0.5) / f64::from(steps);
                let (overlap, time) = (from + (to - from) * share, f64::from(steps) * dt);
                let velocity = Vec3::new(slip / time, 0.0, -(to - from) / time);
                let encounter = Encounter { normal: Vec3::z(), overlap, velocity, spin: Vec3::zeros() };
                let approach = Approach::of(&encounter, 1e-3, dt);
                let now = law.at(1e-3, &approach, &mut 0.0);
                let force = now.force(&encounter, &mut displacement, dt).x;
                work += force * velocity.x * dt;
                slipped += velocity.x * dt;
            }
        };
        // The bodies gain what the contact gives: a positive sum of force on body 1 times slip is taken from them.
        run(1e-6, 1e-5, 0.0);
        run(1e-5, 1e-5, 1e-6);
        run(1e-5, 2e-6, 0.0);
        run(2e-6, 2e-6, -1e-6);
        run(2e-6, 1e-5, 0.0);
        run(1e-5, 1e-5, 0.0);
        work
    };
    let scale = 0.5 * 8.0 * effective_shear_modulus(OXIDE, OXIDE) * 1e-4 * 1e-12;
    // Sheared at a = 1e-4 m and back at 4.47e-5 m: ½ k ξ² of the first less what is left of it at the second.
    let ratio = (0.2_f64).sqrt();
    let exact = |memory: Memory| match memory {
        // The force falls with the radius, as its displacement stays: half of k ξ² at the smaller radius comes back.
        Memory::ForceRescaled | Memory::Displacement => 1.0 - ratio,
        Memory::Force => 1.0 - (2.0 - ratio),
        Memory::DisplacementRescaled => 1.0 - ratio * (2.0 * ratio - 1.0),
    };
    [Memory::ForceRescaled, Memory::Force, Memory::Displacement, Memory::DisplacementRescaled]
        .map(|memory| {
            let quantity = format!("loss of a cycle of load and shear, {memory:?}");
            Row::new("hertz mindlin", quantity, "-", [work(memory) / scale, exact(memory)])
                .within(2e-3)
                .of_scale(1.0)
        })
        .to_vec()
}
