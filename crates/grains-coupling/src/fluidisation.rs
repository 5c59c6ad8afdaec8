//! What a drag law says of a bed before it runs: pressure drop, minimum fluidisation, terminal velocity.

use crate::{CouplingError, DragLaw, Flow, Fluid, ShapeFactors};
use std::f64::consts::PI;

/// Roots are found to this relative accuracy.
const ACCURACY: f64 = 1e-14;
/// Halvings and doublings that reach any f64.
const MOST_STEPS: usize = 2200;

/// A bed of like particles in a fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bed {
    /// The fluid.
    pub fluid: Fluid,
    /// Density of the particles (kg/m³).
    pub solid_density: f64,
    /// Diameter of the sphere of a particle's volume (m).
    pub diameter: f64,
    /// Shape of the particles, and how they lie.
    pub shape: ShapeFactors,
    /// Void fraction ε (-).
    pub void_fraction: f64,
    /// Strength of gravity (m/s²).
    pub gravity: f64,
}

impl Bed {
    /// Archimedes number ρ (ρ_p − ρ) g d³/μ² (-).
    pub fn archimedes(&self) -> f64 {
        let Fluid { density, viscosity } = self.fluid;
        density * (self.solid_density - density) * self.gravity * self.diameter.powi(3) / viscosity.powi(2)
    }

    /// Pressure gradient (Pa/m) at a superficial velocity U (m/s): n F_d/ε, with n = 6 (1−ε)/(π d³), in both models.
    pub fn pressure_gradient(&self, law: DragLaw, superficial_velocity: f64) -> f64 {
        let slip = superficial_velocity / self.void_fraction;
        let reynolds = self.fluid.reynolds(self.diameter, self.void_fraction, slip);
        let drag = law.coefficient(&self.fluid, self.diameter, &self.flow(reynolds)) * slip;
        let number = 6.0 * (1.0 - self.void_fraction) / (PI * self.diameter.powi(3));
        number * drag / self.void_fraction
    }

    /// Pressure gradient (Pa/m) that carries the bed: (1 − ε)(ρ_p − ρ) g.
    pub fn buoyant_weight(&self) -> f64 {
        (1.0 - self.void_fraction) * (self.solid_density - self.fluid.density) * self.gravity
    }

    /// Superficial velocity (m/s) at which the drag carries the bed: F_d/ε = (ρ_p − ρ) V g, or Re F(Re) = ε Ar/18.
    ///
    /// Errors: particles not heavier than the fluid, other numbers out of range.
    pub fn minimum_fluidisation_velocity(&self, law: DragLaw) -> Result<f64, CouplingError> {
        self.check()?;
        let target = self.void_fraction * self.archimedes() / 18.0;
        let force = |reynolds: f64| reynolds * law.resistance(&self.flow(reynolds));
        let reynolds = rising_root(force, target);
        Ok(reynolds * self.fluid.viscosity / (self.fluid.density * self.diameter))
    }

    /// Speed (m/s) at which one particle settles alone: Re F(Re) = Ar/18 at ε = 1.
    ///
    /// Errors: as for [`Bed::minimum_fluidisation_velocity`].
    pub fn terminal_velocity(&self, law: DragLaw) -> Result<f64, CouplingError> {
        Self { void_fraction: 1.0, ..*self }.minimum_fluidisation_velocity(law)
    }

    /// Minimum fluidisation velocity (m/s) by the correlation of Wen and Yu (1966), which knows no void fraction:
    /// Re = √(33.7² + 0.0408 Ar) − 33.7.
    pub fn wen_yu_correlation(&self) -> f64 {
        let excess = 0.0408 * self.archimedes();
        let reynolds = excess / ((33.7 * 33.7 + excess).sqrt() + 33.7);
        reynolds * self.fluid.viscosity / (self.fluid.density * self.diameter)
    }

    fn flow(&self, reynolds: f64) -> Flow {
        Flow { reynolds, void_fraction: self.void_fraction, shape: self.shape }
    }

    fn check(&self) -> Result<(), CouplingError> {
        let positive = "positive and finite";
        let remedy = "give SI units";
        for (quantity, value) in [
            ("the density of the fluid (kg/m3)", self.fluid.density),
            ("the viscosity of the fluid (Pa s)", self.fluid.viscosity),
            ("the diameter of the particles (m)", self.diameter),
            ("gravity (m/s2)", self.gravity),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(CouplingError::OutOfRange { quantity, value, allowed: positive, remedy });
            }
        }
        if !(self.void_fraction > 0.0 && self.void_fraction <= 1.0) {
            return Err(CouplingError::OutOfRange {
                quantity: "the void fraction (-)",
                value: self.void_fraction,
                allowed: "in (0, 1]",
                remedy: "a random bed of spheres has about 0.4",
            });
        }
        if self.solid_density.partial_cmp(&self.fluid.density) != Some(std::cmp::Ordering::Greater) {
            return Err(CouplingError::NotHeavier { solid: self.solid_density, fluid: self.fluid.density });
        }
        Ok(())
    }
}

/// Where a rising function that is 0 at 0 reaches a positive `target`; at a jump across it, the place of the jump.
///
/// Bracketed by doubling, then halved on the logarithm and closed by the Illinois rule, which keeps the bracket.
fn rising_root(f: impl Fn(f64) -> f64, target: f64) -> f64 {
    let mut upper = 1.0;
    for _ in 0..MOST_STEPS {
        if f(upper) >= target {
            break;
        }
        upper *= 2.0;
    }
    let mut lower = upper / 2.0;
    for _ in 0..MOST_STEPS {
        if f(lower) < target || lower == 0.0 {
            break;
        }
        (upper, lower) = (lower, lower / 2.0);
    }
    let (mut below, mut above) = (f(lower) - target, f(upper) - target);
    let mut last = 0;
    for _ in 0..200 {
        let middle = ((lower * above - upper * below) / (above - below)).clamp(lower, upper);
        let value = f(middle) - target;
        if value < 0.0 {
            (lower, below) = (middle, value);
            above *= if last == -1 { 0.5 } else { 1.0 };
            last = -1;
        } else {
            (upper, above) = (middle, value);
            below *= if last == 1 { 0.5 } else { 1.0 };
            last = 1;
        }
        if upper - lower <= ACCURACY * upper || value == 0.0 {
            return middle;
        }
    }
    0.5 * (lower + upper)
}
