//! Viscosity that varies: what makes it, and the field of it.
//!
//! ```text
//!  ∇·τ,   τ = 2 μ D,   D = ½ (∇u + ∇uᵀ),   γ̇ = √(2 D:D)
//!  μ = μ(γ̇)                          of a generalised Newtonian fluid ([`Rheology`])
//!  μ = μ₀ + ρ ν_t(∇u, Δ)             of large eddies ([`Turbulence`])
//! ```
//!
//! A field has values where stresses act, at centres (normal) and edges (shear). γ̇² is the sum of the squares of the rates that
//! lie at a place and the means of those of the other places about it: in a plane shear flow every edge knows its own rate
//! alone. The viscosity of a step is that of the velocity at its beginning; a restart needs no more than the velocity. Steps
//! are of first order in how fast the viscosity changes.
//!
//! To add a law: its file, its module, and its line in `rheologies!` or `turbulence_models!`; keys are the fields of its
//! structure. The case file, its schema and `check` take it from there.

mod bingham;
mod field;
mod herschel_bulkley;
mod power_law;
mod rates;
mod regularisation;
mod smagorinsky;
#[cfg(test)]
mod tests;
mod wale;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use bingham::Bingham;
pub(crate) use field::ViscosityField;
pub use herschel_bulkley::HerschelBulkley;
pub use power_law::PowerLaw;
pub use regularisation::Regularisation;
pub use smagorinsky::Smagorinsky;
pub use wale::Wale;

/// A value of a law that is out of range: key, value, what it must be.
pub type BadValue = (&'static str, f64, &'static str);

/// Refuses what is not positive and finite.
fn positive(key: &'static str, value: f64) -> Result<(), BadValue> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err((key, value, "positive and finite")) }
}

/// A law μ(γ̇) of a generalised Newtonian fluid, regularised: finite at γ̇ = 0.
trait RheologyLaw {
    /// μ (Pa s) at a rate γ̇ ≥ 0 (1/s).
    fn viscosity(&self, rate: f64) -> f64;
    /// Upper bound of μ (Pa s) at rest and at small rates.
    fn viscosity_at_rest(&self) -> f64;
    /// Lower bound of μ (Pa s).
    fn smallest_viscosity(&self) -> f64;
    /// μ (Pa s) without yield stress at a rate of 1/s.
    fn reference_viscosity(&self) -> f64;
    /// Yield stress (Pa).
    fn yield_stress(&self) -> f64;
    /// Refuses what makes no sense.
    fn check(&self) -> Result<(), BadValue>;

    /// μ times a factor, of squares γ̇² (1/s²), in place.
    fn apply(&self, factor: f64, squares: &mut [f64]) {
        squares.iter_mut().for_each(|square| *square = factor * self.viscosity(square.sqrt()));
    }
}

/// A model of the eddies smaller than the cells.
trait TurbulenceModel {
    /// Eddy viscosity ν_t (m²/s) of a gradient ∂u_a/∂x_b (1/s), the filter width Δ (m) and the distance (m) of the closest
    /// wall without slip.
    fn eddy_viscosity(&self, gradient: &[[f64; 3]; 3], width: f64, distance: f64) -> f64;
    /// Refuses what makes no sense.
    fn check(&self) -> Result<(), BadValue>;
}

/// Declares [`Rheology`] with the structure and file of a law per line.
macro_rules! rheologies {
    ($($(#[$doc:meta])+ $law:ident,)+) => {
        /// How the viscosity of a generalised Newtonian fluid depends on the rate of shear.
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(tag = "kind", rename_all = "snake_case")]
        pub enum Rheology {
            $($(#[$doc])+ $law($law),)+
        }

        impl Rheology {
            fn law(&self) -> &dyn RheologyLaw {
                match self {
                    $(Self::$law(law) => law,)+
                }
            }
        }
    };
}

rheologies! {
    /// μ = K γ̇ⁿ⁻¹ (Ostwald and de Waele).
    PowerLaw,
    /// μ = μ_p + τ_y/γ̇ above the yield stress (Bingham 1922), regularised.
    Bingham,
    /// μ = K γ̇ⁿ⁻¹ + τ_y/γ̇ above the yield stress (Herschel and Bulkley 1926), regularised.
    HerschelBulkley,
}

/// Declares [`Turbulence`] with the structure and file of a model per line.
macro_rules! turbulence_models {
    ($($(#[$doc:meta])+ $model:ident,)+) => {
        /// What eddies smaller than the cells do.
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(tag = "kind", rename_all = "snake_case")]
        pub enum Turbulence {
            $($(#[$doc])+ $model($model),)+
        }

        impl Turbulence {
            fn model(&self) -> &dyn TurbulenceModel {
                match self {
                    $(Self::$model(model) => model,)+
                }
            }
        }
    };
}

turbulence_models! {
    /// ν_t = ℓ² γ̇, ℓ = min(C Δ, κ d) at a distance d from walls (Smagorinsky 1963).
    Smagorinsky,
    /// The wall-adapting model of Nicoud and Ducros (1999): ν_t falls with the cube of the distance from walls by itself.
    Wale,
}

impl Turbulence {
    /// Refuses what makes no sense.
    ///
    /// # Errors
    /// The first key whose value is out of range.
    pub fn check(&self) -> Result<(), BadValue> {
        self.model().check()
    }
}

impl Rheology {
    /// μ (Pa s) at a rate γ̇ (1/s), regularised.
    pub fn viscosity(&self, rate: f64) -> f64 {
        self.law().viscosity(rate)
    }

    /// Upper bound of μ (Pa s) at small rates: that of unyielded fluid.
    pub fn viscosity_at_rest(&self) -> f64 {
        self.law().viscosity_at_rest()
    }

    /// μ (Pa s) at a rate of 1/s without the part of the yield stress: the plastic viscosity of a Bingham fluid.
    pub fn reference_viscosity(&self) -> f64 {
        self.law().reference_viscosity()
    }

    /// Yield stress τ_y (Pa), 0 without.
    pub fn yield_stress(&self) -> f64 {
        self.law().yield_stress()
    }

    /// Rate (1/s) at which the regularised fluid creeps under its yield stress, where the ideal one is rigid: γ̇ of
    /// μ(γ̇) γ̇ = τ_y.
    pub fn creep_rate(&self) -> f64 {
        self.rate_under(self.yield_stress())
    }

    /// Rate γ̇ (1/s) at which the regularised fluid is sheared under a stress μ(γ̇) γ̇ ≥ 0 (Pa).
    pub fn rate_under(&self, stress: f64) -> f64 {
        let law = self.law();
        if stress <= 0.0 {
            return 0.0;
        }
        let [mut low, mut high] = [0.0, stress / law.reference_viscosity()];
        while law.viscosity(high) * high < stress && high.is_finite() {
            high *= 2.0;
        }
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if law.viscosity(middle) * middle < stress {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }

    /// Refuses what makes no sense.
    ///
    /// # Errors
    /// The first key whose value is out of range.
    pub fn check(&self) -> Result<(), BadValue> {
        self.law().check()
    }
}

/// What makes the viscosity of a flow vary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ViscosityLaw {
    /// The rate of shear.
    Rheology(Rheology),
    /// Eddies smaller than the cells, on top of the fluid's own viscosity.
    Turbulence(Turbulence),
}

impl ViscosityLaw {
    /// Lower bound of μ (Pa s), of a fluid with its own viscosity (Pa s).
    pub(crate) fn smallest_viscosity(&self, own: f64) -> f64 {
        match self {
            Self::Rheology(rheology) => rheology.law().smallest_viscosity(),
            Self::Turbulence(_) => own,
        }
    }

    /// Share of the viscous terms of the end of a step (-): ½ is Crank–Nicolson, of second order; 1 damps the stiff plugs of
    /// yield-stress fluids, whose viscosity is that of the beginning of the step anyhow.
    pub(crate) fn implicitness(&self) -> f64 {
        match self {
            Self::Rheology(_) => 1.0,
            Self::Turbulence(_) => 0.5,
        }
    }
}
