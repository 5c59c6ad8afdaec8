//! The force of a bridge of cylindrical section.

use std::f64::consts::PI;

/// F = 2π R γ cos θ/(1 + h/2d), d = (h/2)(−1 + √(1 + 2V/(π R h²))) (Rabinovich et al. 2005; Lambert et al. 2008).
///
/// Written as 2π R γ cos θ (1 − h/√(h² + 2V/(π R))), the same without a division by h (Pitois et al. 2000). The derivative
/// of an energy, and in closed form: the work from h = 0 to H is 2π R γ cos θ (H + √c − √(H² + c)), c = 2V/(π R).
/// The pull of the surface along the rim, which Rabinovich adds, is left out as in other codes. For V/R³ up to 1e-2 or so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rabinovich {
    /// Cosine of the contact angle (-).
    cosine: f64,
}

impl Rabinovich {
    /// The law for a contact angle θ (rad).
    pub fn new(contact_angle: f64) -> Self {
        Self { cosine: libm::cos(contact_angle) }
    }

    /// F/(2π R γ) (-) at a gap h (m), a volume V (m³) and a radius R (m).
    #[inline(always)]
    pub fn scaled_force(&self, gap: f64, volume: f64, radius: f64) -> f64 {
        let depth = 2.0 * volume / (PI * radius);
        self.cosine * (1.0 - gap / (gap * gap + depth).sqrt())
    }
}
