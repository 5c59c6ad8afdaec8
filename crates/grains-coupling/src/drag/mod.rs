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
//! ([`crate::Model`] says what model B makes of it; errata R16-38).

mod beetstra;
mod di_felice;
mod ergun;
mod ganser;
mod gidaspow;
mod hoelzer_sommerfeld;
mod schiller_naumann;
mod wen_yu;

use crate::ShapeFactors;
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

/// A drag law; one file each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DragLaw {
    /// Beetstra et al. (2007), fitted to lattice-Boltzmann simulations of spheres (thesis 5.16).
    Beetstra,
    /// Ergun (1952), packed beds.
    Ergun,
    /// Wen and Yu (1966), dilute beds.
    WenYu,
    /// Ergun up to a void fraction of 0.8, Wen and Yu beyond (Gidaspow 1994).
    Gidaspow,
    /// Di Felice (1994).
    DiFelice,
    /// A lone sphere (Schiller and Naumann 1933), whatever the void fraction.
    SchillerNaumann,
    /// Any shape, as it lies in the flow (Hölzer and Sommerfeld 2008), crowded as by Di Felice.
    HoelzerSommerfeld,
    /// Any shape, as it lies in the flow (Ganser 1993), crowded as by Di Felice.
    Ganser,
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
    /// All laws.
    pub const ALL: [Self; 8] = [
        Self::Beetstra,
        Self::Ergun,
        Self::WenYu,
        Self::Gidaspow,
        Self::DiFelice,
        Self::SchillerNaumann,
        Self::HoelzerSommerfeld,
        Self::Ganser,
    ];

    /// Whether the law looks at the shape of the particle and how it lies.
    pub fn minds_shape(self) -> bool {
        matches!(self, Self::HoelzerSommerfeld | Self::Ganser)
    }

    /// Resistance F (-): drag over 3π μ d ε |u − v|.
    pub fn resistance(self, flow: &Flow) -> f64 {
        let Flow { reynolds, void_fraction, shape } = *flow;
        match self {
            Self::Beetstra => beetstra::resistance(reynolds, void_fraction),
            Self::Ergun => ergun::resistance(reynolds, void_fraction),
            Self::WenYu => wen_yu::resistance(reynolds, void_fraction),
            Self::Gidaspow => gidaspow::resistance(reynolds, void_fraction),
            Self::DiFelice => di_felice::resistance(reynolds, void_fraction),
            Self::SchillerNaumann => schiller_naumann::resistance(reynolds, void_fraction),
            Self::HoelzerSommerfeld => {
                hoelzer_sommerfeld::resistance(reynolds, &shape)
                    * di_felice::crowding(reynolds, void_fraction)
            }
            Self::Ganser => {
                ganser::resistance(reynolds, &shape) * di_felice::crowding(reynolds, void_fraction)
            }
        }
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
