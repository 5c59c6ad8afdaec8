//! Penetration depth of two meeting cores by the expanding polytope algorithm (van den Bergen 2001).
//!
//! The polytope is inscribed in the set B − A. Its face nearest the origin bounds the depth from below,
//! the support plane parallel to it from above; as long as they differ the support point is added.
//! Face distances are signed, so the origin may be outside the first polytope or on its surface, as it
//! is for bodies that barely touch.

mod polytope;

use crate::convex::surface_points::{lattice, on_sphere};
use crate::gjk::{Separation, distance, nearest_weights, smooth_penetration};
use crate::{Core, GjkError, Placement, Simplex, Vec3, rotation_by};
use polytope::{Face, Polytope, Start, across, start};

/// How far, and which way, one core has to move to leave the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penetration {
    /// Smallest translation that separates the cores (m); rounding may make it a trifle negative.
    pub depth: f64,
    /// Unit vector from A to B: moving B by depth · normal separates the cores (-).
    pub normal: Vec3,
    /// Deepest point of A in B, in the frame of A (m).
    pub point_a: Vec3,
    /// Deepest point of B in A, in the frame of A (m): point A − depth · normal.
    pub point_b: Vec3,
}

/// Gap of the bounds at which the polytope is exact, relative to the size of the pair.
const TOLERANCE: f64 = 1e-14;
/// Gap at which a curved pair is handed over to [`polish`].
const CURVED_TOLERANCE: f64 = 1e-10;
/// Gap accepted when rounding in the normal of a skinny face has spoilt the surface.
const SPOILT_TOLERANCE: f64 = 1e-7;
/// Gap accepted when the polytope has all its vertices, before [`descend`]: bodies of revolution about one
/// common axis have a circle of equal depths and no end, a point in the middle of a ball has a sphere of them.
const CROWDED_TOLERANCE: f64 = 3e-2;
/// Normals, of the faces of a polytope with all its vertices or from all around, that begin a descent: those of smallest depth.
const DESCENTS: usize = 16;
/// Turns of B (rad) tried one after the other: edges parallel to rounding can spoil the surface, and a
/// turn too small to matter, undone by [`polish`], takes them apart.
const JOGGLES: [f64; 4] = [0.0, 1e-9, 1e-7, 1e-5];
/// Directions all around that [`searched`] begins with.
const DIRECTIONS: usize = 128;
/// Directions tried by [`descend`].
const MAX_TRIALS: usize = 400;
/// Support points before the search ends.
const MAX_VERTICES: usize = 600;
/// Distance of the probes of [`polish`] from the surface, relative to the size of the pair.
const PROBE: f64 = 1e-3;
/// Projections of [`polish`]; each gains a factor of about depth over radius of curvature.
const MAX_PROBES: usize = 20;

/// The pair of cores as the set B − A.
pub(crate) struct Difference<'a> {
    pub a: &'a Core,
    pub b: &'a Core,
    pub placement: &'a Placement,
    pub size: f64,
}

/// A point of the set B − A.
#[derive(Clone, Copy)]
pub(crate) struct Vertex {
    pub a: Vec3,
    pub w: Vec3,
}

impl<'a> Difference<'a> {
    fn new(a: &'a Core, b: &'a Core, placement: &'a Placement) -> Self {
        let scale = placement.matrix.column(0).norm();
        let size = a.radius() + b.radius() * scale + placement.translation.norm();
        Self { a, b, placement, size }
    }

    /// The point of B − A farthest along `direction`.
    pub fn support(&self, direction: &Vec3) -> Vertex {
        let a = self.a.support(&-direction);
        let b = self.b.support(&self.placement.matrix.tr_mul(direction));
        Vertex { a, w: self.placement.apply(&b) - a }
    }

    /// The penetration along a given normal, at a given point of A.
    fn facing(&self, normal: Vec3, point_a: Vec3) -> Penetration {
        let depth = -normal.dot(&self.support(&-normal).w);
        Penetration { depth, normal, point_a, point_b: point_a - normal * depth }
    }

    fn curved(&self) -> bool {
        self.a.is_curved() || self.b.is_curved()
    }

    fn failure(&self, gap: f64, iterations: usize) -> GjkError {
        GjkError::new("penetration", (gap, iterations), (self.a, self.b, self.placement))
    }
}

/// Smallest translation that separates core `a` from core `b`, put at `placement` in the frame of `a`.
///
/// To be asked when [`distance`] answers `Meeting`; `simplex` is what that query left. Exact for
/// polyhedral cores; for curved ones exact to first order in the direction, thus in depth to rounding.
/// Of a pair too uneven for a polytope it is the smallest found all around. Allocates.
///
/// # Errors
/// [`GjkError`] if there is no depth, as for a placement of NaN.
pub fn penetration(
    a: &Core,
    b: &Core,
    placement: &Placement,
    simplex: &Simplex,
) -> Result<Penetration, GjkError> {
    let set = Difference::new(a, b, placement);
    if let (Core::Superellipsoid(first), Core::Superellipsoid(second)) = (a, b)
        && let Some((depth, normal, point_a)) =
            smooth_penetration(first, second, placement, set.size, simplex)
    {
        return Ok(Penetration { depth, normal, point_a, point_b: point_a - normal * depth });
    }
    let mut failure = None;
    for joggle in JOGGLES {
        let turn = rotation_by(&(Vec3::new(1.0, 2.0, 3.0) * joggle)).to_rotation_matrix();
        let turned = Placement { matrix: turn * placement.matrix, translation: placement.translation };
        let joggled = Difference { placement: if joggle > 0.0 { &turned } else { placement }, ..set };
        let vertices = match start(&joggled) {
            Start::Solid(vertices) => vertices,
            Start::Flat(normal) => return flat(&set, normal, simplex),
            Start::Thin => break,
        };
        match expand(&joggled, vertices) {
            Ok((found, gap)) if joggle == 0.0 && gap <= TOLERANCE * set.size => return Ok(found),
            Ok((found, _)) => return Ok(polish(&set, found)),
            Err(error) => failure = failure.or(Some(error)),
        }
    }
    let found = searched(&set);
    if found.depth.is_finite() {
        Ok(found)
    } else {
        Err(failure.unwrap_or_else(|| set.failure(f64::INFINITY, 0)))
    }
}

/// The smallest depth that [`polish`] finds from directions all around, for sets that are too thin for any polytope: all
/// faces are slivers where one body is a billionth of the other.
fn searched(set: &Difference) -> Penetration {
    let around = lattice(DIRECTIONS).map(on_sphere).chain(across(set, DESCENTS));
    let mut found: Vec<Penetration> =
        around.map(|normal| set.facing(normal, set.support(&-normal).a)).collect();
    found.sort_by(|p, q| p.depth.total_cmp(&q.depth));
    let polished = found[..DESCENTS].iter().map(|found| polish(set, *found));
    polished.fold(found[0], |best, next| if next.depth < best.depth { next } else { best })
}

/// Grows the polytope from four vertices; the answer and the gap of its bounds (m).
fn expand(set: &Difference, vertices: [Vertex; 4]) -> Result<(Penetration, f64), GjkError> {
    let tolerance = if set.curved() { CURVED_TOLERANCE } else { TOLERANCE } * set.size;
    let mut polytope = Polytope::new(vertices, set.size);
    loop {
        let count = polytope.vertices.len();
        let Some(number) = polytope.nearest_face() else {
            return Err(set.failure(f64::INFINITY, count));
        };
        let face = polytope.faces[number];
        let outward = face.normal;
        let farthest = set.support(&outward);
        let gap = outward.dot(&farthest.w) - face.distance;
        let crowded = count >= MAX_VERTICES;
        let known = polytope.vertices.iter().any(|v| v.w == farthest.w);
        if gap > tolerance && !crowded && !known && polytope.expand(farthest, number) {
            continue;
        }
        let accepted = if crowded { CROWDED_TOLERANCE } else { SPOILT_TOLERANCE } * set.size;
        if gap > accepted || gap.is_nan() {
            return Err(set.failure(gap, count));
        }
        let answer = |face: &Face| exposed(set, face.corners.map(|i| polytope.vertices[i]), face.normal);
        if !crowded {
            return Ok((answer(&face), gap));
        }
        let mut answers: Vec<Penetration> = polytope.exposed_faces().map(answer).collect();
        answers.sort_by(|p, q| p.depth.total_cmp(&q.depth));
        let descents = answers.into_iter().take(DESCENTS).map(|found| descend(set, found));
        let found = descents.reduce(|best, next| if next.depth < best.depth { next } else { best });
        return found.map(|found| (found, gap)).ok_or_else(|| set.failure(gap, count));
    }
}

/// Moves to the smallest depth nearby, by trials of directions ever nearer the best: one for a depth that hardly
/// changes from direction to direction, where [`polish`] crawls.
fn descend(set: &Difference, found: Penetration) -> Penetration {
    let mut best = set.facing(found.normal, found.point_a);
    let (mut reach, mut trials) = (0.1, 0);
    while reach > 1e-9 && trials < MAX_TRIALS {
        let aside = best.normal.cross(&Vec3::ith(best.normal.iamin(), 1.0)).normalize() * reach;
        let above = best.normal.cross(&aside);
        let mut moved = false;
        for step in [aside, -aside, above, -above] {
            let next = set.facing((best.normal + step).normalize(), best.point_a);
            trials += 1;
            if next.depth < best.depth {
                (best, moved) = (next, true);
                break;
            }
        }
        reach *= if moved { 1.5 } else { 0.5 };
    }
    best
}

/// The answer for the face with `corners` and outward normal: A is on the far side of it from B.
fn exposed(set: &Difference, corners: [Vertex; 3], outward: Vec3) -> Penetration {
    let depth = outward.dot(&set.support(&outward).w);
    let w = corners.map(|corner| corner.w);
    let weights = nearest_weights(&w);
    let point_a = corners.iter().zip(weights).map(|(corner, weight)| corner.a * weight).sum::<Vec3>();
    Penetration { depth, normal: -outward, point_a, point_b: point_a + outward * depth }
}

/// Penetration of a set without volume: the cores meet in their common plane.
fn flat(set: &Difference, normal: Vec3, simplex: &Simplex) -> Result<Penetration, GjkError> {
    let mut simplex = *simplex;
    if simplex.len == 0 {
        distance(set.a, set.b, set.placement, f64::INFINITY, &mut simplex)?;
    }
    let len = simplex.len as usize;
    let point_a = match (set.a, len) {
        // Queries with a point core need no simplex.
        (Core::Point, 0) => Vec3::zeros(),
        (_, 0) => set.placement.translation,
        _ => {
            let w: Vec<Vec3> = (0..len).map(|i| set.placement.apply(&simplex.b[i]) - simplex.a[i]).collect();
            let weights = nearest_weights(&w);
            (0..len).map(|i| simplex.a[i] * weights[i]).sum()
        }
    };
    let normal = if normal.dot(&set.placement.translation) < 0.0 { -normal } else { normal };
    Ok(set.facing(normal, point_a))
}

/// Moves to the nearby smallest depth on a curved surface or beside a skinny face: B is moved out a little farther than it has to
/// be and the normal of the distance taken for the next direction.
fn polish(set: &Difference, found: Penetration) -> Penetration {
    let mut best = set.facing(found.normal, found.point_a);
    let mut simplex = Simplex::default();
    for _ in 0..MAX_PROBES {
        let shift = best.normal * (best.depth + PROBE * set.size);
        let moved =
            Placement { matrix: set.placement.matrix, translation: set.placement.translation + shift };
        let Ok(Separation::Apart { normal, point_a, .. }) =
            distance(set.a, set.b, &moved, f64::INFINITY, &mut simplex)
        else {
            break;
        };
        let next = set.facing(normal, point_a);
        if next.depth >= best.depth {
            break;
        }
        let settled = best.depth - next.depth <= TOLERANCE * set.size;
        best = next;
        if settled {
            break;
        }
    }
    best
}
