//! Simplified adhesion: a pull by the area of contact.

use super::{Approach, Hertz, NormalLaw, Response};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Which area of two overlapping spheres pulls; codes differ by factors of two under one name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CohesionArea {
    /// π R* δ, that of Hertz' circle.
    Circle,
    /// 2π R* δ, that in which the spheres intersect (LIGGGHTS sjkr).
    Lens,
    /// 4π R* δ (LIGGGHTS sjkr2 between particles).
    DoubleLens,
}

/// F = Hertz − k A, A the area of contact.
///
/// Friction is a share of the Hertzian part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sjkr {
    /// Elastic part.
    pub hertz: Hertz,
    /// Cohesion energy density k (J/m³).
    pub energy_density: f64,
    /// Definition of the area.
    pub area: CohesionArea,
}

impl Sjkr {
    /// Pull per radius and overlap (N/m²).
    #[inline(always)]
    fn pull(&self) -> f64 {
        let areas = match self.area {
            CohesionArea::Circle => 1.0,
            CohesionArea::Lens => 2.0,
            CohesionArea::DoubleLens => 4.0,
        };
        areas * PI * self.energy_density
    }
}

impl NormalLaw for Sjkr {
    const NAME: &'static str = "sjkr";
    const DAMPING: f64 = Hertz::DAMPING;

    #[inline(always)]
    fn respond(&self, approach: &Approach, _memory: &mut f64) -> Response {
        let hertz = self.hertz.press(approach);
        let pull = self.pull() * approach.radius * approach.overlap;
        Response { elastic: hertz.elastic - pull, ..hertz }
    }

    fn force_bound(&self, radius: f64, overlap: f64) -> f64 {
        self.hertz.force_bound(radius, overlap) + self.pull() * radius * overlap
    }

    /// Where 2 E* a = k A/δ: (c R*)³/(12 (E*)² R*), c the pull per radius and overlap.
    fn pull_off(&self, radius: f64) -> f64 {
        (self.pull() * radius).powi(3) / (12.0 * self.hertz.modulus.powi(2) * radius)
    }
}
