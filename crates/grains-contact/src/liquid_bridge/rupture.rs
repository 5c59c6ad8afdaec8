//! The gap at which a bridge breaks.

use crate::cube_root::cube_root;

/// Gap beyond which no bridge holds, for a contact angle θ (rad) and a volume V (m³).
///
/// θ is in radians; with degrees the bracket would be tens of times too large.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rupture {
    /// (1 + θ/2) V^(1/3) (Lian, Thornton and Adams 1993).
    #[default]
    Lian,
    /// R (1 + θ/2)(V*^(1/3) + 0.1 V*^(2/3)), V* = V/R³ (Willett et al. 2000, equal spheres).
    Willett,
}

impl Rupture {
    /// The gap (m) between spheres of radius R (m).
    #[inline(always)]
    pub fn distance(&self, contact_angle: f64, volume: f64, radius: f64) -> f64 {
        let length = cube_root(volume);
        let second = match self {
            Self::Lian => 0.0,
            Self::Willett => 0.1 * length * length / radius,
        };
        (1.0 + 0.5 * contact_angle) * (length + second)
    }
}
