//! Elastic spheres.

use super::{Approach, NormalLaw, Response};

/// F = (4/3) E* a δ with a² = R* δ (Hertz 1882).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hertz {
    /// Effective modulus E* (Pa), 1/E* = (1 − ν1²)/E1 + (1 − ν2²)/E2.
    pub modulus: f64,
}

impl Hertz {
    /// Damping of a Hertzian contact, 2 √(5/6) √(m dF/dδ) per damping ratio: the bodies part with the restitution of the ratio at
    /// any speed (Antypov and Elliott 2011), where the last of the dashpot may pull.
    pub(super) const DAMPING: f64 = 1.825_741_858_350_553_8;

    /// Force, its derivative and the contact radii at an overlap that is not negative.
    #[inline(always)]
    pub(super) fn press(&self, approach: &Approach) -> Response {
        let &Approach { overlap, opening, radius, dt } = approach;
        let way = 0.5 * dt * opening;
        let root = |overlap: f64| (radius * overlap.max(0.0)).sqrt();
        let contact_radius = root(overlap);
        let stiffness = 2.0 * self.modulus * contact_radius;
        let elastic = (2.0 / 3.0) * stiffness * overlap;
        Response {
            is_contact: true,
            elastic,
            jump: 0.0,
            stiffness,
            pressing: elastic,
            contact_radius,
            radii_around: [root(overlap + way), root(overlap - way)],
            margin: overlap,
        }
    }
}

impl NormalLaw for Hertz {
    const NAME: &'static str = "hertz";
    const DAMPING: f64 = Self::DAMPING;

    #[inline(always)]
    fn respond(&self, approach: &Approach, _memory: &mut f64) -> Response {
        self.press(approach)
    }

    fn force_bound(&self, radius: f64, overlap: f64) -> f64 {
        4.0 / 3.0 * self.modulus * (radius * overlap).sqrt() * overlap
    }
}
