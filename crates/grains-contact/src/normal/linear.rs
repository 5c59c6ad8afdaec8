//! The linear spring.

use super::{Approach, NormalLaw, Response};

/// F = kn δ (Cundall and Strack 1979; thesis eq. 3.18).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    /// Stiffness kn (N/m).
    pub stiffness: f64,
}

impl NormalLaw for Linear {
    const NAME: &'static str = "linear";
    const DAMPING: f64 = 2.0;
    const HERTZIAN: bool = false;

    #[inline(always)]
    fn respond(&self, approach: &Approach, _memory: &mut f64) -> Response {
        let elastic = self.stiffness * approach.overlap;
        let contact_radius = (approach.radius * approach.overlap.max(0.0)).sqrt();
        Response {
            is_contact: true,
            elastic,
            jump: 0.0,
            stiffness: self.stiffness,
            pressing: elastic,
            contact_radius,
            radii_around: [contact_radius; 2],
            margin: approach.overlap,
        }
    }

    fn force_bound(&self, _radius: f64, overlap: f64) -> f64 {
        self.stiffness * overlap
    }
}
