//! Stiffnesses of a beam of circular section.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

use super::Stress;

type Vec3 = Vector3<f64>;

/// What the stiffness of a beam against shear is made of.
///
/// A two-node beam whose ends move across it by Δ without turning bends as well as shears: Δ/Q = l/(κ G A) + l³/(12 E I).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BeamShear {
    /// Both (Timoshenko), with the shear factor κ = 0.9 of a circle: exact at the nodes for loads at the nodes.
    #[default]
    Timoshenko,
    /// l/(G A) alone (Potyondy and Cundall 2004, DIRT): for one element, bending across it is left out; a chain of N errs by 1/N².
    ShearOnly,
    /// l³/(12 E I) alone (Euler and Bernoulli): no shear; too stiff where l is a few radii.
    BendingOnly,
}

impl BeamShear {
    /// Shear factor κ of a circular section (-).
    pub const FACTOR: f64 = 0.9;
}

/// Circular section of a bond and its moduli.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Radius r (m); A = π r², I = π r⁴/4, J = 2 I.
    pub radius: f64,
    /// Young's modulus E (Pa).
    pub young: f64,
    /// Shear modulus G (Pa).
    pub shear_modulus: f64,
    /// What shear stiffness is made of.
    pub shear: BeamShear,
}

/// Stiffnesses of a bond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffness {
    /// Kn = E A/l (N/m).
    pub axial: f64,
    /// Ks = 1/(l/(κ G A) + l³/(12 E I)) (N/m), see [`BeamShear`].
    pub shear: f64,
    /// Kb = E I/l (N m).
    pub bending: f64,
    /// Kt = G J/l (N m).
    pub torsion: f64,
}

impl Section {
    /// A (m²).
    #[inline(always)]
    pub fn area(&self) -> f64 {
        PI * self.radius * self.radius
    }

    /// I (m⁴).
    #[inline(always)]
    pub fn second_moment(&self) -> f64 {
        0.25 * self.area() * self.radius * self.radius
    }

    /// Stiffnesses of a bond of this length (m).
    #[inline(always)]
    pub fn stiffness(&self, length: f64) -> Stiffness {
        let (area, moment) = (self.area(), self.second_moment());
        let (shears, bends) = match self.shear {
            BeamShear::Timoshenko => (1.0 / BeamShear::FACTOR, 1.0),
            BeamShear::ShearOnly => (1.0, 0.0),
            BeamShear::BendingOnly => (0.0, 1.0),
        };
        let shearing = shears * length / (self.shear_modulus * area);
        let bending = bends * length * length * length / (12.0 * self.young * moment);
        Stiffness {
            axial: self.young * area / length,
            shear: 1.0 / (shearing + bending),
            bending: self.young * moment / length,
            torsion: 2.0 * self.shear_modulus * moment / length,
        }
    }

    /// Largest stresses of a tension (N), a shear force (N) and a moment (N m) at mid-length, `direction` d the axis.
    ///
    /// σ = N/A + |Mb| r/I, τ = |T|/A + |Mt| r/J (Potyondy and Cundall 2004, eqs 17-18).
    #[inline(always)]
    pub fn stress(&self, tension: f64, shear: &Vec3, moment: &Vec3, direction: &Vec3) -> Stress {
        let (area, per_moment) = (self.area(), self.radius / self.second_moment());
        let torsion = moment.dot(direction);
        let bending = moment - direction * torsion;
        Stress {
            tensile: tension / area + bending.norm() * per_moment,
            shear: shear.norm() / area + 0.5 * torsion.abs() * per_moment,
        }
    }
}
