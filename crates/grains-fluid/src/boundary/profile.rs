//! What inlets let in: profiles, flow rates, and parabolas across them.

use super::outline::tangents_of;
use super::{Boundaries, Condition, Outline};
use crate::Grid;
use std::fmt::{self, Debug, Formatter};
use std::sync::Arc;

/// A velocity (m/s) as a function of position (m) and time (s).
pub type VelocityFunction = Arc<dyn Fn([f64; 3], f64) -> [f64; 3] + Send + Sync>;

/// A velocity (m/s) as a function of position (m).
pub type SteadyVelocity = Arc<dyn Fn([f64; 3]) -> [f64; 3] + Send + Sync>;

/// A volume flow (m³/s) over time.
#[derive(Clone)]
pub enum FlowRate {
    /// The same at all times.
    Constant(f64),
    /// A function of time (s).
    Function(Arc<dyn Fn(f64) -> f64 + Send + Sync>),
}

impl FlowRate {
    /// The flow (m³/s) at a time (s).
    pub fn at(&self, time: f64) -> f64 {
        match self {
            FlowRate::Constant(rate) => *rate,
            FlowRate::Function(rate) => rate(time),
        }
    }
}

impl Debug for FlowRate {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            FlowRate::Constant(rate) => write!(f, "{rate}"),
            FlowRate::Function(_) => write!(f, "Function"),
        }
    }
}

/// Velocity over an inlet.
///
/// Parabolas are 0 on the edges: Π 6 s (1 − s) across a rectangle, 2 (1 − r²/R²) on a disc, and the flow through an annulus,
/// 1 − (r/R)² − (1 − κ²) ln(r/R)/ln κ with κ = R₀/R over its mean ½ (1 + κ² + (1 − κ²)/ln κ). Cells take their exact mean.
#[derive(Clone)]
pub enum Profile {
    /// The same velocity everywhere (m/s).
    Uniform([f64; 3]),
    /// A parabola of a mean normal speed (m/s, inwards) over what is open of the inlet.
    Parabolic {
        /// Mean speed into the box (m/s).
        mean: f64,
    },
    /// Any function of position and time, taken at the middle of a boundary cell, or of the parts into which edges of
    /// patches cut it: the flow rate is of second order in the width of the cells.
    Function(VelocityFunction),
    /// The same of a function of position alone.
    SteadyFunction(SteadyVelocity),
    /// A volume flow, normal to the face, through what is open of the inlet.
    FlowRate {
        /// Flow into the box (m³/s).
        rate: FlowRate,
        /// Whether it is distributed as a parabola, or else uniformly.
        is_parabolic: bool,
    },
}

impl Profile {
    /// Whether it changes in time.
    pub(crate) fn is_unsteady(&self) -> bool {
        matches!(self, Profile::Function(_) | Profile::FlowRate { rate: FlowRate::Function(_), .. })
    }

    /// Whether cells take a parabola.
    pub(super) fn is_parabolic(&self) -> bool {
        matches!(self, Profile::Parabolic { .. } | Profile::FlowRate { is_parabolic: true, .. })
    }

    /// Whether its size depends on the area that is open.
    pub(super) fn is_of_open_area(&self) -> bool {
        matches!(self, Profile::Parabolic { .. } | Profile::FlowRate { .. })
    }
}

impl Debug for Profile {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Profile::Uniform(velocity) => write!(f, "Uniform({velocity:?})"),
            Profile::Parabolic { mean } => write!(f, "Parabolic({mean})"),
            Profile::Function(_) => write!(f, "Function"),
            Profile::SteadyFunction(_) => write!(f, "SteadyFunction"),
            Profile::FlowRate { rate, is_parabolic } => write!(f, "FlowRate({rate:?}, {is_parabolic})"),
        }
    }
}

impl Condition {
    /// Whether it is an inlet over which the velocity is a parabola.
    pub(super) fn is_parabolic(&self) -> bool {
        matches!(self, Condition::Inlet { profile } if profile.is_parabolic())
    }
}

impl Boundaries {
    /// The parabola of a condition at a place (m) along the tangential axes of its face; its mean over the inlet is 1.
    pub(super) fn parabola(&self, grid: &Grid, condition: usize, at: [f64; 2]) -> f64 {
        let (axis, outline) = match condition.checked_sub(6).map(|k| &self.patches[k]) {
            Some(patch) => (patch.face.axis, Some(&patch.outline)),
            None => (condition / 2, None),
        };
        let tangents = tangents_of(axis);
        match outline {
            Some(Outline::Disc { center, radius, inner_radius }) => {
                let distance = (at[0] - center[tangents[0]]).hypot(at[1] - center[tangents[1]]);
                across_disc(distance / radius, inner_radius / radius)
            }
            // Polygons have none, which the check of the boundaries tells.
            Some(Outline::Polygon { .. }) => 1.0,
            Some(Outline::Rectangle { .. }) | None => {
                let factors = tangents.into_iter().zip(at).map(|(t, x)| {
                    let (axis, nodes) = (grid.axis(t), grid.axis(t).nodes());
                    let (begin, end) = (nodes[0], nodes[axis.cells()]);
                    let [lower, upper] = match outline {
                        Some(outline) => {
                            let bounds = outline.bounds([t, t])[0];
                            let [lower, upper] = bounds;
                            if axis.is_periodic() { bounds } else { [lower.max(begin), upper.min(end)] }
                        }
                        None if axis.is_periodic() => return 1.0,
                        None => [begin, end],
                    };
                    if !grid.is_active(t) {
                        return 1.0;
                    }
                    let s = ((x - lower) / (upper - lower)).clamp(0.0, 1.0);
                    6.0 * s * (1.0 - s)
                });
                factors.product()
            }
        }
    }
}

/// The parabola on a disc at s = r/R, or the flow through an annulus with a hole of κ = R₀/R.
fn across_disc(s: f64, hole: f64) -> f64 {
    if hole == 0.0 {
        return (2.0 * (1.0 - s * s)).max(0.0);
    }
    let slope = (1.0 - hole * hole) / hole.ln();
    let mean = 0.5 * (1.0 + hole * hole + slope);
    ((1.0 - s * s - slope * s.ln()) / mean).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::across_disc;

    #[test]
    fn the_mean_over_disc_and_annulus_is_one() {
        for hole in [0.0, 0.05, 0.3, 0.9] {
            let n = 20_000;
            let width = (1.0 - hole) / f64::from(n);
            let rings = (0..n).map(|k| hole + (f64::from(k) + 0.5) * width);
            let mean: f64 = rings.map(|s| across_disc(s, hole) * 2.0 * s * width).sum();
            assert!((mean / (1.0 - hole * hole) - 1.0).abs() < 1e-6, "{hole}: {mean}");
            assert!(across_disc(1.0, hole).abs() < 1e-12 && across_disc(hole.max(1e-9), hole).abs() < 2.1);
        }
    }
}
