//! Capillary bridges of liquid between two bodies.
//!
//! The bridge pulls with F = 2π R γ f(h, V, R, θ): γ surface tension (N/m), θ contact angle (rad), h gap (m), V volume of the
//! liquid (m³), and R = 2 R1 R2/(R1 + R2) = 2 R* the radius of two equal spheres that stand for the pair (Derjaguin 1934):
//! R itself for equal spheres, 2 R1 for a sphere on a wall. For unequal radii that holds for little liquid, less so close to
//! contact and to rupture (Willett et al. 2000). While the bodies overlap, h = 0. One file holds one f.
//!
//! Codes differ. Washino's form in LIGGGHTS takes R* for R and pulls half as much. LIGGGHTS-PFM multiplies the logarithms of
//! Willett's fit by 2.3. LIGGGHTS' Soulié form takes √(R1 R2) outside and the larger radius inside. Derjaguin's R enters
//! V/R³ too: for unequal spheres a reduced volume of another code may be another.
//!
//! Bridges have one volume, or take it from films on their bodies and give it back ([`Supply`]).

mod films;
mod rabinovich;
mod rupture;
mod supply;
mod viscous;
mod willett;
mod willett_short;

pub use films::{Film, FilmAmount, film_thickness, sphere_radius};
pub use rabinovich::Rabinovich;
pub use rupture::Rupture;
pub use supply::{BridgeChange, BridgeEnd, FilmShare, FilmSupply, Formation, Supply, halves, whole_quanta};
pub use viscous::BridgeViscosity;
pub use willett::Willett;
pub use willett_short::WillettShort;

use std::f64::consts::PI;

/// Shape of the force of a bridge over its gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Capillary {
    /// See [`Willett`].
    Willett(Willett),
    /// See [`WillettShort`].
    WillettShort(WillettShort),
    /// See [`Rabinovich`].
    Rabinovich(Rabinovich),
}

impl Capillary {
    /// f = F/(2π R γ) (-) at a gap h (m) of a bridge of volume V (m³) between spheres of radius R (m); `gap` is not negative.
    #[inline(always)]
    pub fn scaled_force(&self, gap: f64, volume: f64, radius: f64) -> f64 {
        match self {
            Self::Willett(law) => law.scaled_force(gap, volume, radius),
            Self::WillettShort(law) => law.scaled_force(gap, volume, radius),
            Self::Rabinovich(law) => law.scaled_force(gap, volume, radius),
        }
    }
}

/// A liquid and the two surfaces that it wets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiquidBridge {
    /// Surface tension γ (N/m).
    pub surface_tension: f64,
    /// Contact angle θ (rad), from 0 to π/2.
    pub contact_angle: f64,
    /// Shape of the force over the gap.
    pub capillary: Capillary,
    /// Where the bridge breaks.
    pub rupture: Rupture,
    /// Resistance of the liquid to flow.
    pub viscosity: BridgeViscosity,
    /// When a bridge forms.
    pub formation: Formation,
    /// Where its liquid comes from.
    pub supply: Supply,
}

impl LiquidBridge {
    /// Attraction F = 2π R γ f (N) at a gap h (m), the value at h = 0 where the bodies overlap.
    ///
    /// `volume` V (m³); `effective_radius` R* = R1 R2/(R1 + R2) (m), R1 against a wall.
    #[inline(always)]
    pub fn pull(&self, gap: f64, volume: f64, effective_radius: f64) -> f64 {
        let radius = 2.0 * effective_radius;
        let scale = 2.0 * PI * radius * self.surface_tension;
        scale * self.capillary.scaled_force(gap.max(0.0), volume, radius)
    }

    /// Largest gap (m) over which a bridge of this volume (m³) holds.
    #[inline(always)]
    pub fn rupture_distance(&self, volume: f64, effective_radius: f64) -> f64 {
        self.rupture.distance(self.contact_angle, volume, 2.0 * effective_radius)
    }

    /// Bound of the attraction of bodies of this effective radius (m), whatever volume and gap: 1.2 × 2π R γ (N).
    pub fn force_bound(&self, effective_radius: f64) -> f64 {
        1.2 * 4.0 * PI * effective_radius * self.surface_tension
    }

    /// Work ∫ F dh (J) of the attraction from a gap `from` (m) to rupture.
    ///
    /// From h = 0 this is what a pair loses that meets by contact and parts; a bridge that forms where films touch has given
    /// the part up to that gap back on approach. Quadrature by Gauss's rule in √h, to 1e-9.
    pub fn work(&self, from: f64, volume: f64, effective_radius: f64) -> f64 {
        const PANELS: u32 = 64;
        let (low, high) = (from.max(0.0).sqrt(), self.rupture_distance(volume, effective_radius).sqrt());
        let width = (high - low).max(0.0) / f64::from(PANELS);
        let offset = 0.6_f64.sqrt();
        let mut work = 0.0;
        for panel in 0..PANELS {
            let middle = low + width * (f64::from(panel) + 0.5);
            for (at, weight) in [(-offset, 5.0), (0.0, 8.0), (offset, 5.0)] {
                let root = middle + 0.5 * width * at;
                work += weight * root * self.pull(root * root, volume, effective_radius);
            }
        }
        work * width / 9.0
    }
}
