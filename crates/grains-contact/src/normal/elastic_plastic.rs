//! Springs that load and unload along different lines.

use super::{Approach, NormalLaw, Response};

/// F = k1 δ on first loading and k2 (δ − δ0) on unloading, not below −kc δ (Walton and Braun 1986; Luding 2008).
///
/// The contact keeps its largest overlap δmax; δ0 = (1 − k1/k2) δmax. Without adhesion bodies part with √(k1/k2) of their speed,
/// whatever that is, and no dashpot is needed. Where the force has followed −kc δ, δmax is that of the line reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElasticPlastic {
    /// Stiffness on loading k1 (N/m).
    pub loading: f64,
    /// Stiffness on unloading k2 ≥ k1 (N/m).
    pub unloading: f64,
    /// Adhesive stiffness kc (N/m).
    pub adhesion: f64,
}

impl ElasticPlastic {
    /// The law that gives a restitution e without adhesion, k2 = k1/e².
    pub fn with_restitution(loading: f64, restitution: f64, adhesion: f64) -> Self {
        Self { loading, unloading: loading / (restitution * restitution), adhesion }
    }
}

impl NormalLaw for ElasticPlastic {
    const NAME: &'static str = "elastic_plastic";
    const KEEPS_MEMORY: bool = true;
    const DAMPING: f64 = 0.0;
    const HERTZIAN: bool = false;

    #[inline(always)]
    fn respond(&self, approach: &Approach, memory: &mut f64) -> Response {
        let overlap = approach.overlap;
        let Self { loading, unloading, adhesion } = *self;
        let hysteresis = unloading - loading;
        // δmax between the lines of loading and of adhesion through this overlap.
        let highest =
            if hysteresis > 0.0 { overlap * ((unloading + adhesion) / hysteresis) } else { overlap };
        let largest = memory.max(overlap).min(highest.max(overlap));
        *memory = largest;
        let elastic = unloading * overlap - hysteresis * largest;
        let contact_radius = (approach.radius * overlap).sqrt();
        Response {
            is_contact: true,
            elastic,
            jump: 0.0,
            stiffness: loading,
            pressing: elastic + adhesion * overlap,
            contact_radius,
            radii_around: [contact_radius; 2],
            margin: overlap,
        }
    }

    fn steepest(&self, _stiffness: f64) -> f64 {
        self.unloading.max(self.adhesion)
    }

    fn force_bound(&self, _radius: f64, overlap: f64) -> f64 {
        self.loading.max(self.adhesion) * overlap
    }
}
