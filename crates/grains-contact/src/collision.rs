//! Closed forms of one head-on collision: what a case will do before it runs.

use crate::ContactLaw;
use std::f64::consts::PI;

/// Duration and depth of a head-on collision under a linear spring and dashpot (thesis eqs 3.23-3.27).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollisionEstimate {
    /// Reduced mass m (kg).
    pub reduced_mass: f64,
    /// Undamped frequency ω0 = √(kn/m) (1/s).
    pub natural_frequency: f64,
    /// Damping rate γn = −ω0 ln en/√(π² + ln² en) (1/s).
    pub damping_rate: f64,
    /// Contact time Tc = π/√(ω0² − γn²) (s).
    pub contact_time: f64,
    /// Time of the largest overlap (s).
    pub time_of_largest_overlap: f64,
    /// Largest overlap per impact speed, δmax/v0 (s).
    pub overlap_per_speed: f64,
}

impl CollisionEstimate {
    /// Collision under `law` of two bodies of the given reduced mass (kg; M1 against a wall).
    pub fn new(law: &ContactLaw, reduced_mass: f64) -> Self {
        let natural_frequency = (law.normal_stiffness / reduced_mass).sqrt();
        let damping_rate = law.damping_rate(reduced_mass);
        let damped = (natural_frequency.powi(2) - damping_rate.powi(2)).sqrt();
        let time_of_largest_overlap = damped.atan2(damping_rate) / damped;
        Self {
            reduced_mass,
            natural_frequency,
            damping_rate,
            contact_time: PI / damped,
            time_of_largest_overlap,
            overlap_per_speed: (-damping_rate * time_of_largest_overlap).exp() / natural_frequency,
        }
    }

    /// Largest overlap (m) at an impact speed (m/s).
    pub fn max_overlap(&self, impact_speed: f64) -> f64 {
        self.overlap_per_speed * impact_speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Tangential;

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
            let law = ContactLaw::new(kn, e, 0.0, Tangential::Viscous { rate: 0.0 });
            let c = CollisionEstimate::new(&law, m);
            for (got, want) in [
                (c.damping_rate, gamma),
                (c.contact_time, tc),
                (c.time_of_largest_overlap, tmax),
                (c.max_overlap(v0), dmax),
            ] {
                assert!((got / want - 1.0).abs() < 2e-6, "{got} instead of {want}");
            }
        }
    }
}
