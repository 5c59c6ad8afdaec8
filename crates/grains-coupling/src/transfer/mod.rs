//! Laws of heat and mass transfer between a particle and the fluid that passes it, alone or in a crowd.
//!
//! Every law is one file with one function, the Nusselt number Nu = h d/k (-); the Sherwood number k_c d/D is the same function of the
//! Schmidt number:
//!
//! ```text
//! Q = h A (T_f − T_p),   h = Nu k/d,   Re = ρ d ε |u − v|/μ,   Pr = μ c/k
//! ```
//!
//! with the area A of the particle, the diameter d of the sphere of its volume and the void fraction ε. Other shapes take
//! the numbers of the sphere and their own area.
//!
//! To add a law: its file, its module and its line in `transfer_laws!` below, a test. The case file and its schema take it from there.

mod deen;
mod gunn;
mod li_mason;
mod ranz_marshall;
mod sun;
mod tavassoli;

use crate::relaxation;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the transfer to a particle depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passing {
    /// Reynolds number Re = ρ d ε |u − v|/μ of the superficial slip (-).
    pub reynolds: f64,
    /// Prandtl number μ c/k, or Schmidt number μ/(ρ D) (-).
    pub prandtl: f64,
    /// Void fraction ε (-), in (0, 1].
    pub void_fraction: f64,
}

impl Passing {
    /// (7 − 10 ε + 5 ε²)(1 + a Re^0.2 Pr^⅓) + (1.33 + b ε + c ε²) Re^0.7 Pr^⅓, the form that Gunn (1978) gave.
    fn in_the_form_of_gunn(&self, [a, b, c]: [f64; 3]) -> f64 {
        let (eps, root) = (self.void_fraction, self.prandtl.cbrt());
        let still = 7.0 - 10.0 * eps + 5.0 * eps * eps;
        let moving = 1.33 + b * eps + c * eps * eps;
        still * (1.0 + a * self.reynolds.powf(0.2) * root) + moving * self.reynolds.powf(0.7) * root
    }
}

/// What a particle exchanges with a scalar φ of the fluid: the fluid gets K (φ_p − φ) per time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TransferLink {
    /// Coefficient K (m³/s).
    pub coefficient: f64,
    /// Value φ_p at which nothing is exchanged.
    pub value: f64,
}

impl TransferLink {
    /// That of a particle whose value φ_p follows what it gets, C dφ_p/dt = k (φ − φ_p), over a step Δt (s) of the fluid.
    ///
    /// ```text
    /// K = k E(k Δt/C),   E(x) = (1 − e^−x)/x
    /// ```
    ///
    /// is exact for a fluid that stays as it is. φ_p comes to lie between what it was and that of the fluid at the end of the step,
    /// however long this is. `coefficient` is k (m³/s), `capacity` C (m³).
    pub fn following(coefficient: f64, value: f64, capacity: f64, time_step: f64) -> Self {
        Self { coefficient: coefficient * relaxation(coefficient * time_step / capacity), value }
    }

    /// What the particle gets in a step Δt (s), the fluid being at `mean` under its kernel.
    pub fn gain(&self, mean: f64, time_step: f64) -> f64 {
        self.coefficient * (mean - self.value) * time_step
    }
}

/// Effectiveness η (-) of a particle with a first-order reaction inside: its rate over that without diffusion.
///
/// Of the generalised Thiele modulus Φ = V/A √(k/D) (-), exact for a sphere,
///
/// ```text
/// η = (3 Φ coth 3Φ − 1)/(3 Φ²)
/// ```
///
/// and within some per cent for other shapes (Aris 1957).
pub fn effectiveness(modulus: f64) -> f64 {
    let of_radius = 3.0 * modulus;
    if of_radius < 1e-2 {
        return 1.0 - of_radius * of_radius / 15.0;
    }
    (of_radius / of_radius.tanh() - 1.0) / (3.0 * modulus * modulus)
}

/// Declares [`TransferLaw`] with a variant, an entry of [`TransferLaw::ALL`] and the file of the number per line.
macro_rules! transfer_laws {
    ($($(#[$doc:meta])+ $law:ident => $file:ident,)+) => {
        /// A law of heat or mass transfer.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum TransferLaw {
            $($(#[$doc])+ $law,)+
        }

        impl TransferLaw {
            /// All laws.
            pub const ALL: &[Self] = &[$(Self::$law),+];

            /// Nusselt number h d/k, or Sherwood number k_c d/D (-).
            pub fn nusselt(self, passing: &Passing) -> f64 {
                match self {
                    $(Self::$law => $file::nusselt(passing),)+
                }
            }
        }
    };
}

transfer_laws! {
    /// Gunn (1978): beds of any void fraction, Re up to 1e5.
    Gunn => gunn,
    /// Ranz and Marshall (1952): a lone sphere.
    RanzMarshall => ranz_marshall,
    /// Li and Mason (2000): pneumatic transport.
    LiMason => li_mason,
    /// Deen et al. (2014), from resolved flows.
    Deen => deen,
    /// Tavassoli et al. (2015), from resolved flows.
    Tavassoli => tavassoli,
    /// Sun et al. (2015), from resolved flows.
    Sun => sun,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of `next-reference` B were computed from the formulas of the papers by another program.
    #[test]
    fn beds_have_the_numbers_of_the_papers() {
        let laws = [TransferLaw::Gunn, TransferLaw::Deen, TransferLaw::Tavassoli, TransferLaw::Sun];
        let rows = [
            (10.0, [9.011, 6.456, 6.384, 7.136]),
            (50.0, [14.874, 11.648, 12.040, 12.047]),
            (100.0, [19.766, 16.318, 17.191, 16.586]),
        ];
        for (reynolds, wanted) in rows {
            let passing = Passing { reynolds, prandtl: 1.0, void_fraction: 0.5 };
            for (law, wanted) in laws.into_iter().zip(wanted) {
                let found = law.nusselt(&passing);
                assert!((found - wanted).abs() < 6e-4, "{law:?} at {reynolds}: {found}, not {wanted}");
            }
        }
    }

    #[test]
    fn a_lone_sphere_at_rest_has_a_nusselt_number_of_two() {
        let still = Passing { reynolds: 0.0, prandtl: 0.7, void_fraction: 1.0 };
        for &law in TransferLaw::ALL {
            let found = law.nusselt(&still);
            assert!((found - 2.0).abs() < 0.02, "{law:?}: {found}");
        }
    }

    #[test]
    fn every_law_grows_with_the_slip_and_the_prandtl_number() {
        for &law in TransferLaw::ALL {
            for void_fraction in [0.4, 0.6, 0.9, 1.0] {
                let mut last = 0.0;
                for reynolds in [0.0, 0.1, 1.0, 10.0, 100.0, 190.0, 210.0, 1400.0, 1600.0] {
                    let at = |prandtl: f64| law.nusselt(&Passing { reynolds, prandtl, void_fraction });
                    let found = at(0.7);
                    assert!(
                        found >= 0.97 * last && found > 0.0,
                        "{law:?} {void_fraction} {reynolds}: {found}"
                    );
                    assert!(at(7.0) >= found, "{law:?} {void_fraction} {reynolds}");
                    last = found;
                }
            }
        }
    }
}
