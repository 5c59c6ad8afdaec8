//! What one head-on collision will do, before a case runs.

use crate::law::ContactLaw;
use crate::normal::{Approach, Normal};
use std::f64::consts::PI;

/// Course of a head-on collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collision {
    /// Contact time (s); of bodies that stay together, that of one swing.
    pub contact_time: f64,
    /// Time of the largest overlap (s).
    pub time_of_largest_overlap: f64,
    /// What steps must resolve (s): the contact time, or half a swing on the steepest line of force where that is shorter.
    pub shortest_time: f64,
    /// Largest overlap (m).
    pub max_overlap: f64,
    /// Derivative of the repulsion dF/dδ there (N/m).
    pub stiffness: f64,
    /// Speed after over speed before (-); 0 if the bodies stay together.
    pub restitution: f64,
}

impl ContactLaw {
    /// Head-on collision of bodies of a reduced mass (kg; M1 against a wall) and an effective radius (m) at a speed (m/s).
    ///
    /// Of a linear spring and dashpot by closed form (thesis eqs 3.23-3.27), of other laws by integration.
    pub fn collision(&self, reduced_mass: f64, radius: f64, speed: f64) -> Collision {
        match (self.normal, self.damping) {
            (Normal::Linear(linear), crate::Damping::Restitution) => {
                self.closed_form(reduced_mass, linear.stiffness, speed)
            }
            _ => self.integrated(reduced_mass, radius, speed),
        }
    }

    /// With ω0 = √(kn/m) and γn = −ω0 ln en/√(π² + ln² en): Tc = π/√(ω0² − γn²).
    fn closed_form(&self, reduced_mass: f64, stiffness: f64, speed: f64) -> Collision {
        let natural = (stiffness / reduced_mass).sqrt();
        let damping = self.damping_rate(reduced_mass, stiffness);
        let damped = (natural * natural - damping * damping).sqrt();
        let time_of_largest_overlap = libm::atan2(damped, damping) / damped;
        Collision {
            contact_time: PI / damped,
            shortest_time: PI / damped,
            time_of_largest_overlap,
            stiffness,
            max_overlap: libm::exp(-damping * time_of_largest_overlap) / natural * speed,
            restitution: self.restitution,
        }
    }

    /// By the rule of Verlet, in steps of a small share of the time to the present stiffness.
    fn integrated(&self, reduced_mass: f64, radius: f64, speed: f64) -> Collision {
        /// Share of √(m/k) in a step, and steps after which it is given up.
        const SHARE: f64 = 2e-3;
        const MOST_STEPS: usize = 200_000;
        let law = self.prepared();
        let mut memory = 0.0;
        let mut force_and_stiffness = |overlap: f64, velocity: f64| {
            let approach = Approach { overlap, opening: -velocity, radius, dt: 0.0 };
            let now = law.at(reduced_mass, &approach, &mut memory);
            let response = now.response;
            (response.is_contact, now.dashpot * velocity + response.elastic, response.stiffness)
        };
        let (mut time, mut overlap, mut velocity) = (0.0, 0.0, speed);
        let mut deepest = (0.0, 0.0, 0.0);
        // The first way is free of force: the stiffness of a Hertzian contact grows from nothing.
        let scale = self.depth_scale(reduced_mass, radius, speed);
        let mut dt = 1e-3 * SHARE * scale / speed;
        let mut has_parted = false;
        for _ in 0..MOST_STEPS {
            overlap += velocity * dt;
            time += dt;
            let (is_contact, force, stiffness) = force_and_stiffness(overlap, velocity);
            let has_reach = self.normal.reach(radius) > 0.0;
            if !is_contact || (overlap <= 0.0 && !has_reach) {
                has_parted = true;
                break;
            }
            let was_parting = velocity < 0.0;
            velocity -= force / reduced_mass * dt;
            if was_parting && velocity >= 0.0 {
                break;
            }
            if overlap > deepest.1 {
                deepest = (time, overlap, stiffness);
            }
            let slow = (reduced_mass / stiffness.max(1e-6 * reduced_mass)).sqrt();
            dt = (SHARE * slow).min(SHARE * scale / speed);
        }
        let restitution = if has_parted { (-velocity / speed).max(0.0) } else { 0.0 };
        let steepest = self.normal.steepest(deepest.2);
        let is_steeper = steepest > deepest.2;
        let swing = if is_steeper { PI * (reduced_mass / steepest).sqrt() } else { f64::INFINITY };
        Collision {
            contact_time: time,
            shortest_time: time.min(swing),
            time_of_largest_overlap: deepest.0,
            max_overlap: deepest.1,
            stiffness: deepest.2,
            restitution,
        }
    }

    /// Overlap (m) at which the force without the adhesion of bodies that just touch has the energy of the collision.
    fn depth_scale(&self, reduced_mass: f64, radius: f64, speed: f64) -> f64 {
        let energy = 0.5 * reduced_mass * speed * speed;
        let adhesion = self.normal.force_bound(radius, 0.0);
        let mut depth = radius;
        while (self.normal.force_bound(radius, depth) - adhesion) * depth > energy {
            depth *= 0.5;
        }
        depth
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Hertz, Jkr, Tangential, Tear};

    /// Rows A1a-A1f of the reference values: kn, e, m, v0, γ, Tc, tmax, δmax.
    #[test]
    fn closed_forms_reproduce_the_reference_rows() {
        let rows = [
            [1e5, 0.73, 1.767146e-5, 1.0, 7.498204e3, 4.197148e-5, 1.965185e-5, 1.147206e-5],
            [1e5, 0.73, 3.534292e-5, 1.0, 5.302031e3, 5.935664e-5, 2.779192e-5, 1.622394e-5],
            [7.2e5, 0.75, 1.720069e-3, 4.5, 1.865705e3, 1.541948e-4, 7.261541e-5, 1.920797e-4],
            [1e6, 0.62, 3.440138e-3, 4.5, 2.564792e3, 1.863838e-4, 8.423311e-5, 2.126549e-4],
            [1e5, 0.75, 1.767146e-5, 4.2, 6.859831e3, 4.193719e-5, 1.974960e-5, 4.875821e-5],
            [1e5, 0.75, 3.534292e-5, 4.2, 4.850633e3, 5.930815e-5, 2.793015e-5, 6.895452e-5],
        ];
        for [kn, e, m, v0, gamma, tc, tmax, dmax] in rows {
            let law = ContactLaw::linear(kn, e, 0.0, Tangential::Viscous { rate: 0.0 });
            let c = law.collision(m, 1e-3, v0);
            let pairs = [(c.contact_time, tc), (c.time_of_largest_overlap, tmax), (c.max_overlap, dmax)];
            for (got, want) in [&pairs[..], &[(law.damping_rate(m, kn), gamma)]].concat() {
                assert!((got / want - 1.0).abs() < 2e-6, "{got} instead of {want}");
            }
            let by_steps = law.integrated(m, 1e-3, v0);
            assert!((by_steps.contact_time / tc - 1.0).abs() < 2e-3, "{by_steps:?}");
            assert!((by_steps.restitution / e - 1.0).abs() < 5e-3, "{by_steps:?}");
        }
    }

    /// Hertz: δmax = (15 m v²/(16 E* √R*))^(2/5) and Tc = 2.94326 δmax/v.
    #[test]
    fn a_hertzian_collision_lasts_and_goes_as_deep_as_its_closed_form() {
        let (modulus, radius, mass): (f64, f64, f64) = (1e8, 1e-3, 1e-5);
        let law = ContactLaw::new(Hertz { modulus }, 1.0, 0.0, Tangential::Viscous { rate: 0.0 });
        for speed in [1e-3, 0.1, 10.0] {
            let depth = (15.0 * mass * speed * speed / (16.0 * modulus * radius.sqrt())).powf(0.4);
            let c = law.collision(mass, radius, speed);
            assert!((c.max_overlap / depth - 1.0).abs() < 1e-4, "{c:?} {depth}");
            assert!((c.contact_time * speed / depth / 2.943_26 - 1.0).abs() < 2e-3, "{c:?}");
            assert!((c.restitution - 1.0).abs() < 1e-3, "{c:?}");
        }
    }

    /// Bodies part from some speed on and stay together below it, and that speed goes with E*^(-1/3).
    #[test]
    fn adhesive_bodies_stay_together_below_one_speed() {
        let (mass, radius) = (5e-6, 5e-4);
        let parting = |modulus: f64| {
            let law = Jkr { modulus, work: 0.04, tear: Tear::Displacement };
            let law = ContactLaw::new(law, 0.7, 0.0, Tangential::Viscous { rate: 0.0 });
            let speeds: Vec<f64> = (0..60).map(|k| 1e-7 * 1.3_f64.powi(k)).collect();
            let parts = |speed: &f64| law.collision(mass, radius, *speed).restitution > 0.0;
            let first = speeds.iter().position(parts).unwrap();
            assert!(speeds[first..].iter().all(parts), "{modulus}: {:?}", &speeds[first..]);
            speeds[first]
        };
        let (soft, stiff) = (parting(1.7e6), parting(1.7e6 * 1e3));
        assert!((7.0..14.0).contains(&(soft / stiff)), "{soft} {stiff}");
    }
}
