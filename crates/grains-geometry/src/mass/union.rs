//! Mass properties of composites, and how good they are.

use super::{MassProperties, clip, principal_axes};
use crate::{ConvexHull, MassSource, Mat3, Part, Shape, ShapeError, Vec3};

/// Share by which the largest moment may exceed the sum of the others by rounding.
const TRIANGLE: f64 = 1e-9;
/// Error of volume and moments beyond which a union is refused.
const LARGEST_ERROR: f64 = 2e-3;

/// Of the union of convex bodies, whose size is about `size` (m): exact if all are polyhedra, whose hulls then are given,
/// else by chords through the parts with sharp edges.
///
/// Errors: an estimated error beyond 0.2 %.
pub(crate) fn union_mass(
    hulls: Option<&[ConvexHull]>,
    parts: &[Part],
    size: f64,
) -> Result<(MassProperties, MassSource), ShapeError> {
    if let Some(mass) = hulls.and_then(|hulls| clip::union(hulls, size)) {
        return Ok((mass, MassSource::Clipped));
    }
    let (mass, lines, error) = MassProperties::of_chords(parts);
    if error <= LARGEST_ERROR {
        return Ok((mass, MassSource::Chords { lines, error }));
    }
    Err(ShapeError::Unresolved { error, lines })
}

/// Principal axes and moments of a solid; refuses what no solid has: a volume or moment that is NaN, infinite or not
/// positive, a moment that exceeds the sum of the others.
pub(crate) fn principal_moments(mass: &MassProperties) -> Result<(Mat3, Vec3), ShapeError> {
    let (axes, inertia) = principal_axes(&mass.inertia);
    let mut sorted: [f64; 3] = inertia.into();
    sorted.sort_by(f64::total_cmp);
    let [x, y, z] = sorted;
    let positive = [mass.volume, x, y, z].iter().all(|m| *m > 0.0 && m.is_finite());
    if positive && z <= (x + y) * (1.0 + TRIANGLE) && mass.center.iter().all(|c| c.is_finite()) {
        return Ok((axes, inertia));
    }
    Err(ShapeError::Mass { volume: mass.volume, x, y, z })
}

/// The rule of chords on the parts beside the mass properties a shape keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassReport {
    /// Where the mass properties of the shape come from.
    pub source: MassSource,
    /// Lines per edge of the grid of chords (-).
    pub lines: u32,
    /// Relative difference from the grid of half as many (-).
    pub error: f64,
    /// Volume by chords less that of the shape, over that of the shape (-).
    pub volume_difference: f64,
    /// Largest such difference of a principal moment of inertia (-).
    pub inertia_difference: f64,
}

impl Shape {
    /// Compares the mass properties with those of chords through the parts.
    pub fn mass_report(&self) -> MassReport {
        let (mass, lines, error) = MassProperties::of_chords(&self.parts);
        let relative = |a: usize| mass.inertia[(a, a)] / self.inertia[a] - 1.0;
        // NaN is the worst.
        let worst = (0..3).map(relative).fold(0.0, |w: f64, r| if r.abs() <= w.abs() { w } else { r });
        MassReport {
            source: self.report.mass,
            lines,
            error,
            volume_difference: mass.volume / self.volume - 1.0,
            inertia_difference: worst,
        }
    }
}
