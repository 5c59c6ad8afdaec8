//! Attraction of dry surfaces at nanometres.

/// F = (A R*/6)(ρ/h² + 1/(h + c)²) − F(H), ρ = c/(c + 2 R*), h no smaller than h0, none from H on.
///
/// A is the Hamaker constant (J), c the radius of the asperities (m), h the gap between their tops and the other surface
/// (Hamaker 1937; Rumpf 1990, as in MFiX). Without asperities F = A R*/(6 h²): A R/(12 h²) of two equal spheres, A R/(6 h²) of
/// a sphere on a plane. Continuous everywhere: below h0 the force is that at h0, and the force at H is taken off all of it,
/// (h0/H)² of the greatest without asperities and more with them, where other codes jump: H well above c. A/(24π h0²) is the surface energy of MFiX's inner cut-off.
///
/// MFiX writes R = 2 R* and A R/12. The asperity term is half that of one asperity on a plane, A c/(6 h²) for c ≪ R (Rumpf): the
/// two sides share an asperity of their own radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VanDerWaals {
    /// Hamaker constant A (J).
    pub hamaker: f64,
    /// Radius of asperities c (m); 0 for smooth spheres.
    pub asperity: f64,
    /// Inner cut-off h0 (m), 0.4 nm or so (0.165 nm by Israelachvili); positive.
    pub inner: f64,
    /// Outer cut-off H (m), above h0.
    pub outer: f64,
}

impl VanDerWaals {
    /// A R*/6 (N m²) and ρ (-).
    #[inline(always)]
    fn scale(&self, effective_radius: f64) -> (f64, f64) {
        let share = self.asperity / (self.asperity + 2.0 * effective_radius);
        (self.hamaker * effective_radius / 6.0, share)
    }

    /// Force (N) without cut-offs, at a positive gap.
    #[inline(always)]
    fn bare(&self, gap: f64, effective_radius: f64) -> f64 {
        let (scale, share) = self.scale(effective_radius);
        let far = gap + self.asperity;
        scale * (share / (gap * gap) + 1.0 / (far * far))
    }

    /// Attraction (N) at a gap h (m), negative where bodies overlap; `effective_radius` R* (m), R1 against a wall.
    #[inline(always)]
    pub fn pull(&self, gap: f64, effective_radius: f64) -> f64 {
        let gap = gap.max(self.inner).min(self.outer);
        self.bare(gap, effective_radius) - self.bare(self.outer, effective_radius)
    }

    /// Work (J) of the attraction from a gap h (m) to the outer cut-off.
    pub fn work(&self, gap: f64, effective_radius: f64) -> f64 {
        let (scale, share) = self.scale(effective_radius);
        let from = gap.max(self.inner).min(self.outer);
        let bare = |gap: f64| scale * (share / gap + 1.0 / (gap + self.asperity));
        let beyond_inner =
            bare(from) - bare(self.outer) - self.bare(self.outer, effective_radius) * (self.outer - from);
        beyond_inner + (self.inner - gap).max(0.0) * self.pull(self.inner, effective_radius)
    }
}
