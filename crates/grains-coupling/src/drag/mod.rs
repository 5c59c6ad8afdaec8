//! Drag laws: the force of a fluid on a particle that it passes, alone or in a crowd.
//!
//! Every law is one file with one function, the *resistance* F (-): the drag over that of Stokes at the superficial
//! slip,
//!
//! ```text
//! F_d = 3π μ d ε (u − v) F(Re, ε, shape),     Re = ρ d ε |u − v| / μ
//! ```
//!
//! with u the interstitial velocity of the fluid, v that of the particle, ε the void fraction and d the diameter of the
//! sphere of the particle's volume. F_d is the drag *without* the part of the pressure gradient, that of model A
//! ([`grains_fluid::MixtureModel`] says what model B makes of it; errata R16-38).
//!
//! To add a law: its file, its module and its line in `drag_laws!` below, a test. The case file and its schema take it from there.

mod beetstra;
mod di_felice;
mod ergun;
mod ganser;
mod gidaspow;
mod hoelzer_sommerfeld;
mod koch_hill;
mod schiller_naumann;
mod wen_yu;

use crate::ShapeFactors;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Relative step by which the growth of the resistance with Re is measured.
const STEP: f64 = 1e-4;

/// A Newtonian, incompressible fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fluid {
    /// Density ρ (kg/m³).
    pub density: f64,
    /// Dynamic viscosity μ (Pa s).
    pub viscosity: f64,
}

/// What the resistance of a particle depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// Reynolds number Re = ρ d ε |u − v| / μ of the superficial slip (-).
    pub reynolds: f64,
    /// Void fraction ε (-), in (0, 1].
    pub void_fraction: f64,
    /// Shape, and how it lies in the flow.
    pub shape: ShapeFactors,
}

/// Declares [`DragLaw`] with a variant, an entry of [`DragLaw::ALL`] and the file of the resistance per line.
macro_rules! drag_laws {
    ($($(#[$doc:meta])+ $law:ident => $file:ident,)+) => {
        /// A drag law.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        #[schemars(rename = "Drag")]
        pub enum DragLaw {
            $($(#[$doc])+ $law,)+
        }

        impl DragLaw {
            /// All laws.
            pub const ALL: &[Self] = &[$(Self::$law),+];

            /// Resistance F (-): drag over 3π μ d ε |u − v|.
            pub fn resistance(self, flow: &Flow) -> f64 {
                match self {
                    $(Self::$law => $file::resistance(flow),)+
                }
            }
        }
    };
}

drag_laws! {
    /// Beetstra et al. (2007).
    Beetstra => beetstra,
    /// Ergun (1952).
    Ergun => ergun,
    /// Wen and Yu (1966).
    WenYu => wen_yu,
    /// Ergun up to a void fraction of 0.8, Wen and Yu beyond.
    Gidaspow => gidaspow,
    /// Koch and Hill (2001).
    KochHill => koch_hill,
    /// Di Felice (1994).
    DiFelice => di_felice,
    /// Schiller and Naumann (1933): a lone sphere.
    SchillerNaumann => schiller_naumann,
    /// Hölzer and Sommerfeld (2008): any shape, as it lies in the flow.
    HoelzerSommerfeld => hoelzer_sommerfeld,
    /// Ganser (1993): any shape, as it lies in the flow.
    Ganser => ganser,
}

/// Drag coefficient of a particle, and how it grows with the slip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficient {
    /// β = F_d / |u − v| (N s/m).
    pub value: f64,
    /// d ln β / d ln |u − v| (-): 0 by Stokes, 1 by Newton.
    pub exponent: f64,
}

impl Fluid {
    /// Reynolds number ρ d ε |u − v| / μ (-) of a slip |u − v| (m/s) past a diameter d (m) at void fraction ε.
    pub fn reynolds(&self, diameter: f64, void_fraction: f64, slip: f64) -> f64 {
        self.density * diameter * void_fraction * slip / self.viscosity
    }
}

impl DragLaw {
    /// Whether the law looks at the shape of the particle and how it lies.
    pub fn depends_on_shape(self) -> bool {
        matches!(self, Self::HoelzerSommerfeld | Self::Ganser)
    }

    /// Drag coefficient β = 3π μ d ε F (N s/m) of a particle of diameter d (m), so that F_d = β (u − v) in model A.
    pub fn coefficient(self, fluid: &Fluid, diameter: f64, flow: &Flow) -> f64 {
        3.0 * PI * fluid.viscosity * diameter * flow.void_fraction * self.resistance(flow)
    }

    /// The same with its growth by a difference in Re, kept between the laws of Stokes and Newton.
    pub fn growing_coefficient(self, fluid: &Fluid, diameter: f64, flow: &Flow) -> Coefficient {
        let value = self.coefficient(fluid, diameter, flow);
        let faster = Flow { reynolds: flow.reynolds * (1.0 + STEP), ..*flow };
        // Without slip Ergun's law has none at void fraction 1, and nothing that could grow.
        let growth = if value > 0.0 { self.coefficient(fluid, diameter, &faster) / value - 1.0 } else { 0.0 };
        Coefficient { value, exponent: (growth / STEP).clamp(0.0, 1.0) }
    }
}
