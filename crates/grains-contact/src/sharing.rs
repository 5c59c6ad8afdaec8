//! Contacts that share one pair of bodies.

use crate::law::Coefficients;
use crate::normal::Response;
use crate::rolling::RollingCoefficients;

/// What a pair of bodies does with several contacts at once (thesis 3.2.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sharing {
    /// Forces are the gradient of one potential of all contacts: that of one contact of the norm of their overlaps,
    /// D = (Σ δ_i⁸)^(1/8). Continuous and conservative; N equal contacts are N^(1/4) times as stiff.
    #[default]
    Potential,
    /// Model A: forces add up, with the damping corrected for the number N of contacts, γ = γ1/√N
    /// (eq. 3.35 as corrected, errata R16-13); N contacts are N times as stiff.
    Sum,
    /// Model B: the mean of the forces (eq. 3.36), as stiff as one contact whatever N.
    Mean,
}

impl Coefficients {
    /// Coefficients of each of `count` contacts of one pair of bodies.
    #[inline(always)]
    pub fn shared(&self, count: usize, sharing: Sharing) -> Self {
        let n = count as f64;
        match sharing {
            _ if count == 1 => *self,
            Sharing::Potential => *self,
            // The tangential dashpot of a spring is a share of the normal one; a memoryless one has its own rate.
            Sharing::Sum => {
                let damping = 1.0 / n.sqrt();
                let tangential = if self.has_spring { damping } else { 1.0 };
                Self {
                    dashpot: self.dashpot * damping,
                    tangential_dashpot: self.tangential_dashpot * tangential,
                    mass: self.mass / n,
                    ..*self
                }
            }
            Sharing::Mean => self.weighted(1.0 / n, 1.0 / n),
        }
    }

    /// Coefficients of a contact of these weights in the normal and the tangential force of its pair of bodies.
    #[inline(always)]
    pub fn weighted(&self, normal: f64, tangential: f64) -> Self {
        let Response { elastic, jump, stiffness, pressing, .. } = self.response;
        let RollingCoefficients { stiffness: rolling_stiffness, dashpot: rolling_dashpot, .. } = self.rolling;
        Self {
            response: Response {
                elastic: elastic * normal,
                jump: jump * normal,
                stiffness: stiffness * normal,
                pressing: pressing * normal,
                ..self.response
            },
            dashpot: self.dashpot * normal,
            tangential_stiffness: self.tangential_stiffness * tangential,
            tangential_dashpot: self.tangential_dashpot * tangential,
            mass: self.mass * tangential,
            rolling: RollingCoefficients {
                stiffness: rolling_stiffness * tangential,
                dashpot: rolling_dashpot * tangential,
                ..self.rolling
            },
            ..*self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Approach, ContactLaw, Tangential};

    #[test]
    fn shared_contacts_keep_the_restitution_in_both_models() {
        let tangential = Tangential::Spring { stiffness_ratio: 0.5, damping_ratio: 0.5 };
        let approach = Approach { overlap: 1e-5, opening: 0.0, radius: 1e-3, dt: 1e-6 };
        let one = ContactLaw::linear(1e5, 0.6, 0.3, tangential).prepared().at(0.01, &approach, &mut 0.0);
        for n in [2, 7] {
            let sum = one.shared(n, Sharing::Sum);
            // Damping ratio γ/ω0 of n equal contacts together.
            let ratio = |c: &Coefficients, n: f64| n * c.dashpot / (n * c.response.stiffness).sqrt();
            assert!((ratio(&sum, n as f64) / ratio(&one, 1.0) - 1.0).abs() < 1e-14);
            let mean = one.shared(n, Sharing::Mean);
            assert!((mean.response.stiffness * n as f64 / one.response.stiffness - 1.0).abs() < 1e-15);
            assert!((ratio(&mean, n as f64) / ratio(&one, 1.0) - 1.0).abs() < 1e-14);
        }
    }
}
