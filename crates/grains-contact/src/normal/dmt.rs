//! Stiff, small adhesive spheres.

use super::{Approach, Hertz, NormalLaw, Response};
use std::f64::consts::PI;

/// F = Hertz − 2π w R* (Derjaguin, Muller and Toporov 1975), while the surfaces touch.
///
/// Friction is a share of the Hertzian part. The pull is there at once where the contact begins and goes where it ends, so it
/// takes no energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dmt {
    /// Elastic part.
    pub hertz: Hertz,
    /// Work of adhesion w (J/m²), twice the surface energy of a material on itself.
    pub work: f64,
}

impl NormalLaw for Dmt {
    const NAME: &'static str = "dmt";
    const DAMPING: f64 = Hertz::DAMPING;

    #[inline(always)]
    fn respond(&self, approach: &Approach, _memory: &mut f64) -> Response {
        let hertz = self.hertz.press(approach);
        let pull = 2.0 * PI * self.work * approach.radius;
        Response { elastic: hertz.elastic - pull, jump: -pull, ..hertz }
    }

    fn force_bound(&self, radius: f64, overlap: f64) -> f64 {
        self.hertz.force_bound(radius, overlap) + self.pull_off(radius)
    }

    fn pull_off(&self, radius: f64) -> f64 {
        2.0 * PI * self.work * radius
    }
}
