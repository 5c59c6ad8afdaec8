//! The short form of Willett's force.

/// F = 2π R γ cos θ/(1 + 1.05 s + 2.5 s²), s = h √(R/V) (Willett et al. 2000).
///
/// For V/R³ below 1e-3 or so and small θ; 0.24 × 2π R γ too much at contact for V/R³ = 0.1 and θ = 40°. No logarithm. With s of half the gap, as in [`Willett`](crate::Willett), the same
/// reads 1 + 2.1 s + 10 s². MercuryDPM's `LiquidBridgeWillet` is this law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WillettShort {
    /// Cosine of the contact angle (-).
    cosine: f64,
}

impl WillettShort {
    /// The law for a contact angle θ (rad).
    pub fn new(contact_angle: f64) -> Self {
        Self { cosine: libm::cos(contact_angle) }
    }

    /// F/(2π R γ) (-) at a gap h (m), a volume V (m³) and a radius R (m).
    #[inline(always)]
    pub fn scaled_force(&self, gap: f64, volume: f64, radius: f64) -> f64 {
        let s = gap * (radius / volume).sqrt();
        self.cosine / (1.0 + (1.05 + 2.5 * s) * s)
    }
}
