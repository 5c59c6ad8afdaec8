//! Corners on faces and edges on edges, the contacts of bodies with flat faces: they need no search.
//!
//! All of A lies behind the plane n·x = h of one of its faces, and no point of B is nearer to it than the support point p of
//! B against n. So d = n·p − h is a lower bound of the distance; and if p lies over the face, the foot of p belongs to A
//! and the bound is attained.
//!
//! Else, seen along the direction from one core to the other, the edges of the two faces that look at each other cross; where
//! their gap is smallest the points of two edges nearest each other are the answer, if no plane speaks against it. Bodies that
//! rock on their faces change between all these from step to step.

use super::query::Query;
use super::{MEETING, Separation, Simplex};
use crate::Vec3;
use crate::convex::{FacePlane, Support};

/// Corners of a face that edges are taken from; faces with more are left to the search.
const MOST_CORNERS: usize = 8;
/// Squared sine of the angle below which two edges count as parallel.
pub(super) const PARALLEL: f64 = 1e-8;

impl Query<'_> {
    /// The answer if the cores meet corner on face, or are beyond the cutoff across a face; `v` points about from A to B.
    ///
    /// The foot and the corner are left as the start for the next step.
    #[inline(always)]
    pub(super) fn corner_on_face<A: Support, B: Support>(
        &self,
        (a, b): (&A, &B),
        v: &Vec3,
        size: f64,
        simplex: &mut Simplex,
    ) -> Option<Separation> {
        let back = -self.placement.matrix.tr_mul(v);
        let (of_a, of_b) = (a.facing(v), b.facing(&back));
        // Which core has the face is not known: the one that looks more directly at the other comes first.
        let directness =
            |face: Option<FacePlane>, v: &Vec3| face.map_or(-1.0, |face| face.normal.dot(v).powi(2));
        let scale = self.placement.matrix.column(0).norm_squared();
        let is_a_first = directness(of_a, v) * scale >= directness(of_b, &back);
        let first =
            |simplex: &mut Simplex| of_a.and_then(|face| self.over_first((a, b), &face, size, simplex));
        let second =
            |simplex: &mut Simplex| of_b.and_then(|face| self.over_second((a, b), &face, size, simplex));
        if is_a_first {
            first(simplex).or_else(|| second(simplex))
        } else {
            second(simplex).or_else(|| first(simplex))
        }
    }

    /// A corner of B over a face of A.
    #[inline(always)]
    fn over_first<A: Support, B: Support>(
        &self,
        (a, b): (&A, &B),
        face: &FacePlane,
        size: f64,
        simplex: &mut Simplex,
    ) -> Option<Separation> {
        let corner = b.farthest(&-self.placement.matrix.tr_mul(&face.normal));
        let point = self.placement.apply(&corner);
        let distance = face.normal.dot(&point) - face.offset;
        if distance > self.cutoff {
            return Some(Separation::Beyond { axis: face.normal });
        }
        if !(distance > MEETING * size && a.is_below(face, &point)) {
            return None;
        }
        let foot = point - face.normal * distance;
        (simplex.len, simplex.a[0], simplex.b[0]) = (1, foot, corner);
        Some(Separation::Apart { distance, normal: face.normal, point_a: foot, point_b: point })
    }

    /// A corner of A over a face of B.
    #[inline(always)]
    fn over_second<A: Support, B: Support>(
        &self,
        (a, b): (&A, &B),
        face: &FacePlane,
        size: f64,
        simplex: &mut Simplex,
    ) -> Option<Separation> {
        let outwards = self.placement.matrix * face.normal;
        let squared = outwards.norm_squared();
        let (scale, inverse) = (squared.sqrt(), 1.0 / squared);
        let corner = a.farthest(&-outwards);
        let point = self.placement.matrix.tr_mul(&(corner - self.placement.translation)) * inverse;
        let height = face.normal.dot(&point) - face.offset;
        let (distance, normal) = (height * scale, outwards * (-scale * inverse));
        if distance > self.cutoff {
            return Some(Separation::Beyond { axis: normal });
        }
        if !(distance > MEETING * size && b.is_below(face, &point)) {
            return None;
        }
        (simplex.len, simplex.a[0], simplex.b[0]) = (1, corner, point - face.normal * height);
        Some(Separation::Apart { distance, normal, point_a: corner, point_b: corner + normal * distance })
    }

    /// The answer if the cores meet edge on edge, seen along `v`, about from A to B: of the edges about the two faces that
    /// look at each other, those that cross where the gap is smallest.
    #[inline(always)]
    pub(super) fn edge_on_edge<A: Support, B: Support>(
        &self,
        (a, b): (&A, &B),
        v: &Vec3,
        size: f64,
        simplex: &mut Simplex,
    ) -> Option<Separation> {
        let (mut of_a, mut of_b) = ([Vec3::zeros(); MOST_CORNERS], [Vec3::zeros(); MOST_CORNERS]);
        let a_corners = a.corners(&a.facing(v)?, &mut of_a)?;
        let b_corners = b.corners(&b.facing(&-self.placement.matrix.tr_mul(v))?, &mut of_b)?;
        // Seen along v: two coordinates across, the third along.
        let across = v.cross(&Vec3::ith(v.iamin(), 1.0));
        let aside = v.cross(&across);
        let seen = |p: &Vec3| [p.dot(&across), p.dot(&aside), p.dot(v)];
        let mut seen_a = [[0.0; 3]; MOST_CORNERS];
        let mut seen_b = [[0.0; 3]; MOST_CORNERS];
        (0..a_corners).for_each(|i| seen_a[i] = seen(&of_a[i]));
        (0..b_corners).for_each(|j| seen_b[j] = seen(&self.placement.apply(&of_b[j])));
        let next = |k: usize, corners: usize| if k + 1 == corners { 0 } else { k + 1 };
        let mut best = (f64::INFINITY, 0, 0);
        for i in 0..a_corners {
            let (p, q) = (seen_a[i], seen_a[next(i, a_corners)]);
            let u = [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
            for j in 0..b_corners {
                let (r, s) = (seen_b[j], seen_b[next(j, b_corners)]);
                let w = [s[0] - r[0], s[1] - r[1], s[2] - r[2]];
                let between = [r[0] - p[0], r[1] - p[1]];
                let inverse = 1.0 / (u[0] * w[1] - u[1] * w[0]);
                let on_a = (between[0] * w[1] - between[1] * w[0]) * inverse;
                let on_b = (between[0] * u[1] - between[1] * u[0]) * inverse;
                let gap = r[2] + on_b * w[2] - p[2] - on_a * u[2];
                let crosses = (0.0..=1.0).contains(&on_a) && (0.0..=1.0).contains(&on_b);
                if crosses && gap < best.0 {
                    best = (gap, i, j);
                }
            }
        }
        let (gap, i, j) = best;
        if gap == f64::INFINITY {
            return None;
        }
        let edges = ([of_a[i], of_a[next(i, a_corners)]], [of_b[j], of_b[next(j, b_corners)]]);
        self.crossing((a, b), edges, size, simplex)
    }

    /// The answer if an edge of A and one of B are nearest where they cross.
    #[inline(always)]
    fn crossing<A: Support, B: Support>(
        &self,
        (a, b): (&A, &B),
        ([a0, a1], [b0, b1]): ([Vec3; 2], [Vec3; 2]),
        size: f64,
        simplex: &mut Simplex,
    ) -> Option<Separation> {
        let (start, u, w) = (self.placement.apply(&b0) - a0, a1 - a0, self.placement.matrix * (b1 - b0));
        let normal = u.cross(&w);
        let squared = normal.norm_squared();
        if squared <= PARALLEL * u.norm_squared() * w.norm_squared() {
            return None;
        }
        let inverse = 1.0 / squared;
        let way = normal * (normal.dot(&start) * inverse);
        let [on_a, on_b] = [w, u].map(|edge| start.cross(&edge).dot(&normal) * inverse);
        let is_on = |t: f64| (0.0..=1.0).contains(&t);
        if !(is_on(on_a) && is_on(on_b) && way.norm_squared() > (MEETING * size).powi(2)) {
            return None;
        }
        let answer = self.certified(a, b, &way, a0 + u * on_a, size)?;
        // The triangle of the parallelogram of differences that holds the answer.
        let (middle_a, middle_b) = if on_a >= on_b { (a1, b0) } else { (a0, b1) };
        simplex.len = 3;
        (simplex.a[0], simplex.a[1], simplex.a[2]) = (a0, middle_a, a1);
        (simplex.b[0], simplex.b[1], simplex.b[2]) = (b0, middle_b, b1);
        Some(answer)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::convex::cuboid::Cuboid;
    use crate::gjk::distance;
    use crate::{ConvexHull, Core, Placement, Rotation};
    use std::f64::consts::TAU;

    /// Answers without a search, of how many queries, corner on face and edge on edge.
    #[derive(Default)]
    struct Tally {
        queries: usize,
        corners: usize,
        edges: usize,
    }

    /// Compares what both shortcuts say with the search between the same vertices without faces.
    fn compare<A: Support, B: Support>(
        (a, b): (&A, &B),
        (vertices_a, vertices_b): (&[Vec3], &[Vec3]),
        placement: &Placement,
        tally: &mut Tally,
    ) {
        let [bare_a, bare_b] = [vertices_a, vertices_b].map(|v| Core::polyhedron(v.to_vec()));
        let found = distance(&bare_a, &bare_b, placement, f64::INFINITY, &mut Simplex::default()).unwrap();
        let Separation::Apart { distance: wanted, normal: across, .. } = found else { return };
        let query = Query { placement, cutoff: f64::INFINITY };
        // About where the other is, as a step ago.
        let v = across + Vec3::new(0.01, -0.02, 0.015);
        tally.queries += 1;
        for is_edge in [false, true] {
            let mut simplex = Simplex::default();
            let answer = match is_edge {
                false => query.corner_on_face((a, b), &v, 4.0, &mut simplex),
                true => query.edge_on_edge((a, b), &v, 4.0, &mut simplex),
            };
            let Some(Separation::Apart { distance, normal, point_a, point_b }) = answer else { continue };
            tally.corners += usize::from(!is_edge);
            tally.edges += usize::from(is_edge);
            assert!((distance - wanted).abs() < 1e-12, "{distance} instead of {wanted}, edge {is_edge}");
            assert!((normal - across).norm() < 1e-8, "{normal} instead of {across}, edge {is_edge}");
            assert!((point_b - point_a - normal * distance).norm() < 1e-12);
            let reach = |points: &[Vec3], d: &Vec3| points.iter().map(|p| p.dot(d)).fold(f64::MIN, f64::max);
            assert!((reach(vertices_a, &normal) - point_a.dot(&normal)).abs() < 1e-11);
            // The start it leaves holds the answer.
            let start = (0..simplex.len as usize).map(|k| placement.apply(&simplex.b[k]) - simplex.a[k]);
            assert!(start.map(|w| w.dot(&normal)).all(|height| (height - distance).abs() < 1e-12));
        }
    }

    fn corners(half: &Vec3) -> Vec<Vec3> {
        let sign = |k: usize, a: usize| if k >> a & 1 == 0 { 1.0 } else { -1.0 };
        (0..8).map(|k| Vec3::new(sign(k, 0) * half.x, sign(k, 1) * half.y, sign(k, 2) * half.z)).collect()
    }

    #[test]
    fn corners_on_faces_and_edges_on_edges_are_what_the_search_finds() {
        let mut state = 1_u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let (half_a, half_b) = (Vec3::new(1.0, 0.8, 0.6), Vec3::new(0.5, 0.9, 0.7));
        let (box_a, box_b) = (corners(&half_a), corners(&half_b));
        let prism: Vec<Vec3> = (0..10)
            .map(|k| {
                let (sin, cos) = (TAU * f64::from(k % 5) / 5.0).sin_cos();
                Vec3::new(cos, sin, if k < 5 { -0.6 } else { 0.6 })
            })
            .collect();
        let hull = ConvexHull::new(&prism).unwrap();
        let Core::Polyhedron(solid) = Core::polyhedron_with_faces(hull.vertices.clone(), hull.faces.clone())
        else {
            unreachable!()
        };
        let [mut boxes, mut mixed] = [Tally::default(), Tally::default()];
        for k in 0..4000 {
            // Most lie almost face to face.
            let tilt = if k % 4 == 0 { 1.0 } else { 0.01 };
            let axis = Vec3::new(unit() - 0.5, unit() - 0.5, unit() - 0.5);
            let rotation =
                Rotation::from_scaled_axis(axis * tilt) * Rotation::from_scaled_axis(Vec3::z() * unit());
            let scale = [1.0, 0.7, 1.6][k % 3];
            let matrix = rotation.to_rotation_matrix().into_inner() * scale;
            let translation = Vec3::new(unit() - 0.5, unit() - 0.5, 0.62 + 1.1 * scale + 0.3 * unit());
            let placement = Placement { matrix, translation };
            let (a, b) = (Cuboid(half_a), Cuboid(half_b));
            compare((&a, &b), (&box_a, &box_b), &placement, &mut boxes);
            compare((&a, &*solid), (&box_a, &hull.vertices), &placement, &mut mixed);
            compare((&*solid, &b), (&hull.vertices, &box_b), &placement, &mut mixed);
        }
        for tally in [boxes, mixed] {
            let Tally { queries, corners, edges } = tally;
            assert!(corners > queries / 4 && edges > queries / 20, "{corners} and {edges} of {queries}");
            assert!(corners + edges > 4 * queries / 5, "{corners} and {edges} of {queries}");
        }
    }
}
