//! Distance of two convex cores by the algorithm of Gilbert, Johnson and Keerthi (1988).
//!
//! The set B − A of differences of points is searched for its point v nearest the origin: v is the
//! nearest point of a simplex of support points, and the support point in direction −v either proves
//! that nothing is nearer or joins the simplex. The proof is the duality gap: with w the support point,
//! v·w/|v| ≤ d(A, B) ≤ |v|. Every tolerance is relative to the size of the pair.
//!
//! Three measures make a warm query cheap: the simplex of the last step, kept as points of the bodies,
//! usually still is the answer and one support point certifies it; of flat faces that look at each other
//! the corner over a face or the edges that cross where the gap is smallest are found at once, of two
//! boxes in closed form; and for cylinders and superellipsoids the features that touch are solved as equations by
//! Newton's method, for support points alone would approach a curved surface slowly; those of two cylinders are guessed where no
//! simplex marks them, or others than those that touch. Bodies that do not touch need no query while a plane still parts them:
//! [`Core::support_value`].

mod boxes;
mod columns;
mod curved;
mod cylinders;
mod ellipsoids;
mod faces_and_edges;
pub(crate) mod nearest;
mod point;
mod polyhedra;
mod query;
mod search;
mod smooth;
mod start;
mod superellipsoids;

pub use boxes::{BoxQueries, BoxStart};
pub use cylinders::{CylinderMarks, CylinderQueries};
pub use ellipsoids::EllipsoidQueries;
pub use polyhedra::{PolyhedronQueries, PolyhedronStart};
pub(crate) use smooth::penetration as smooth_penetration;
pub use start::{StartForm, read_surfaces, write_surfaces};
pub use superellipsoids::SuperellipsoidQueries;

use crate::core::with_convex;
use crate::{Core, GjkError, Placement, Vec3};
use query::Query;

/// Pairs of points of the two cores that span the current simplex, kept from one step to the next.
///
/// Each is in coordinates of its own body, so any pairs of points of the bodies are a valid start. Of a
/// superellipsoid less an inset they may be points of the whole body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Simplex {
    /// Number of pairs in use, 0 to 4; 0 is a cold start.
    pub len: u8,
    /// Points of A in its frame (m).
    pub a: [Vec3; 4],
    /// Points of B in its own frame (m).
    pub b: [Vec3; 4],
}

/// Outcome of a distance query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Separation {
    /// The cores are proven farther apart than the cutoff.
    Beyond {
        /// Normal of a plane that proves it, from A to B, of any length, in the frame of A.
        axis: Vec3,
    },
    /// The cores are apart.
    Apart {
        /// Distance of the cores (m).
        distance: f64,
        /// Unit vector from A to B, in the frame of A (-).
        normal: Vec3,
        /// Point of A nearest B, in the frame of A (m).
        point_a: Vec3,
        /// Point of B nearest A, in the frame of A (m).
        point_b: Vec3,
    },
    /// The cores intersect, or their distance is below 1e-12 of the size of the pair.
    Meeting,
}

/// Iterations before the query gives up; ten is a usual number, a finely faceted hull may take forty.
const MAX_ITERATIONS: usize = 200;
/// Iterations without a smaller gap before the query gives up.
const PATIENCE: usize = 30;
/// Distance below which cores meet, relative to the size of the pair.
const MEETING: f64 = 1e-12;
/// Gap of upper and lower bound at which a query ends, relative to the size of the pair; on a curved
/// surface the normal is as good as its square root.
const TOLERANCE: f64 = 1e-14;
/// Gap still accepted when rounding stops progress.
const STALLED_TOLERANCE: f64 = 1e-10;
/// Rounding of a point, relative to the size; it turns a v of length d by this over d.
const ROUNDING: f64 = 1e-15;

/// Distance between core `a` and core `b` put at `placement` in the frame of `a`.
///
/// Answers `Beyond` as soon as a plane proves a gap wider than `cutoff` (m). `simplex` is the start and
/// is left as the start for the next step; the answer agrees to tolerance whatever it was.
///
/// # Errors
/// [`GjkError`] if the bounds have not closed at the iteration cap; never a made-up distance.
// Release builds compile it into every loop over pairs; test builds, which have debug assertions, compile it once.
#[cfg_attr(not(debug_assertions), inline)]
pub fn distance(
    a: &Core,
    b: &Core,
    placement: &Placement,
    cutoff: f64,
    simplex: &mut Simplex,
) -> Result<Separation, GjkError> {
    if let Some(answer) = point::closed_form(a, b, placement, cutoff) {
        return Ok(answer);
    }
    let query = Query { placement, cutoff };
    let answer = with_convex!(a, first => query.with_first(first, b, simplex));
    answer.map_err(|stall| GjkError::new("distance", (stall.gap, stall.iterations), (a, b, placement)))
}

/// Barycentric weights of the point nearest the origin of at most four points; the centre's if the
/// origin is inside.
pub(crate) fn nearest_weights(w: &[Vec3]) -> [f64; 4] {
    let points = std::array::from_fn(|i| w.get(i).copied().unwrap_or_else(Vec3::zeros));
    match nearest::nearest(w.len(), &points) {
        Some(found) => found.weights,
        None => [0.25; 4],
    }
}
