//! The point nearest the origin of a simplex of up to four points.
//!
//! Gram-Schmidt instead of normal equations: a skinny triangle costs digits in proportion to its
//! aspect ratio, not to the square of it. The result is made orthogonal to the face a second time,
//! for the direction is what the support points, and so the certificate, are taken from.

use crate::Vec3;

/// Nearest point and its barycentric weights; vertices that do not carry it have weight zero.
#[derive(Clone, Copy)]
pub(crate) struct Nearest {
    pub point: Vec3,
    pub weights: [f64; 4],
}

impl Nearest {
    /// The nearer of two; the first at a tie.
    fn nearer(self, other: Self) -> Self {
        if other.point.norm_squared() < self.point.norm_squared() { other } else { self }
    }

    /// Weights moved from local to given vertex numbers.
    fn renumbered<const N: usize>(self, vertices: [usize; N]) -> Self {
        let mut weights = [0.0; 4];
        for (local, vertex) in vertices.into_iter().enumerate() {
            weights[vertex] = self.weights[local];
        }
        Self { point: self.point, weights }
    }
}

/// Below this sine of its angle a triangle counts as its edges: its normal would have no digits.
const FLAT: f64 = 1e-10;

/// Nearest point of the first `len` of the points; `None` if the origin is inside the tetrahedron.
#[inline(always)]
pub(super) fn nearest(len: usize, w: &[Vec3; 4]) -> Option<Nearest> {
    match len {
        1 => Some(Nearest { point: w[0], weights: [1.0, 0.0, 0.0, 0.0] }),
        2 => Some(on_segment(&w[0], &w[1])),
        3 => Some(on_triangle(&w[0], &w[1], &w[2])),
        _ => on_tetrahedron(w),
    }
}

#[inline]
fn on_segment(w0: &Vec3, w1: &Vec3) -> Nearest {
    let edge = w1 - w0;
    let inverse = 1.0 / edge.norm_squared();
    let t = -w0.dot(&edge) * inverse;
    // Coinciding ends give NaN.
    if t <= 0.0 || t.is_nan() {
        return Nearest { point: *w0, weights: [1.0, 0.0, 0.0, 0.0] };
    }
    if t >= 1.0 {
        return Nearest { point: *w1, weights: [0.0, 1.0, 0.0, 0.0] };
    }
    let rough = w0 + edge * t;
    let correction = -rough.dot(&edge) * inverse;
    let t = t + correction;
    Nearest { point: rough + edge * correction, weights: [1.0 - t, t, 0.0, 0.0] }
}

#[inline]
pub(crate) fn on_triangle(w0: &Vec3, w1: &Vec3, w2: &Vec3) -> Nearest {
    let (e1, e2) = (w1 - w0, w2 - w0);
    let inverse1 = 1.0 / e1.norm_squared();
    let slope = e1.dot(&e2) * inverse1;
    let across = e2 - e1 * slope;
    let across2 = across.norm_squared();
    // Coinciding corners give NaN.
    if across2 <= FLAT * FLAT * e2.norm_squared() || across2.is_nan() {
        return on_edges(w0, w1, w2, [0.0; 3]);
    }
    let inverse2 = 1.0 / across2;
    let coordinates = |x: &Vec3| (-x.dot(&e1) * inverse1, -x.dot(&across) * inverse2);
    let (along, aside) = coordinates(w0);
    let rough = w0 + e1 * along + across * aside;
    let (along_more, aside_more) = coordinates(&rough);
    let l2 = aside + aside_more;
    let l1 = along + along_more - slope * l2;
    let l0 = 1.0 - l1 - l2;
    if l0 > 0.0 && l1 > 0.0 && l2 > 0.0 {
        return Nearest { point: rough + e1 * along_more + across * aside_more, weights: [l0, l1, l2, 0.0] };
    }
    on_edges(w0, w1, w2, [l0, l1, l2])
}

/// Nearest of the edges opposite vertices whose weight is not positive; NaN, as squares of tiny edges give, is not.
fn on_edges(w0: &Vec3, w1: &Vec3, w2: &Vec3, weights: [f64; 3]) -> Nearest {
    let mut best = Nearest { point: Vec3::repeat(f64::INFINITY), weights: [0.0; 4] };
    let is_beyond = |vertex: usize| weights[vertex].max(0.0) == 0.0;
    if is_beyond(2) {
        best = best.nearer(on_segment(w0, w1));
    }
    if is_beyond(1) {
        best = best.nearer(on_segment(w0, w2).renumbered([0, 2]));
    }
    if is_beyond(0) {
        best = best.nearer(on_segment(w1, w2).renumbered([1, 2]));
    }
    best
}

/// The faces, each followed by the vertex opposite it.
const FACES: [[usize; 4]; 4] = [[0, 1, 3, 2], [1, 2, 3, 0], [0, 2, 3, 1], [0, 1, 2, 3]];

/// Nearest point of a tetrahedron; `None` if the origin is inside.
///
/// What rounding may have spoilt is looked at again: a skinny tetrahedron that seems to hold the origin or to be no nearer for its last
/// vertex, and a point that is not as near as one of the vertices.
fn on_tetrahedron(w: &[Vec3; 4]) -> Option<Nearest> {
    let found = on_faces(w, |[p, q, r]| (q - p).cross(&(r - p))).filter(|found| found.weights[3] > 0.0);
    if found.as_ref().is_some_and(|found| is_nearest(found, w)) {
        found
    } else {
        on_skinny_tetrahedron(w, found)
    }
}

#[cold]
#[inline(never)]
fn on_skinny_tetrahedron(w: &[Vec3; 4], found: Option<Nearest>) -> Option<Nearest> {
    let found = found.or_else(|| on_faces(w, normal_of_shortest))?;
    if is_nearest(&found, w) { Some(found) } else { on_faces(w, |_| Vec3::zeros()) }
}

/// Whether a point is as near as all vertices.
fn is_nearest(found: &Nearest, w: &[Vec3; 4]) -> bool {
    let squared = found.point.norm_squared();
    w.iter().all(|vertex| vertex.norm_squared() >= squared)
}

/// Normal of a triangle, of its two shorter edges: of two long ones side by side it would be turned by rounding.
fn normal_of_shortest([p, q, r]: [&Vec3; 3]) -> Vec3 {
    let edges = [q - p, r - q, p - r];
    let lengths = edges.map(|edge| edge.norm_squared());
    let longest = (1..3).fold(0, |best, k| if lengths[k] > lengths[best] { k } else { best });
    edges[(longest + 1) % 3].cross(&edges[(longest + 2) % 3])
}

/// The origin is inside if, seen from every face, it lies between the face and the opposite vertex.
///
/// Asking for "between", not just for the side, keeps rounding in a flat tetrahedron from closing it
/// around an origin that is off its plane. Faces without a normal are looked at in any case.
#[inline(always)]
fn on_faces(w: &[Vec3; 4], normal: impl Fn([&Vec3; 3]) -> Vec3) -> Option<Nearest> {
    let mut best: Option<Nearest> = None;
    for [i, j, k, opposite] in FACES {
        let normal = normal([&w[i], &w[j], &w[k]]);
        let (e1, e2) = (w[j] - w[i], w[k] - w[i]);
        let flat = normal.norm_squared() <= FLAT * FLAT * e1.norm_squared() * e2.norm_squared();
        let (origin, vertex) = (-normal.dot(&w[i]), normal.dot(&(w[opposite] - w[i])));
        let between = origin * vertex >= 0.0 && origin.abs() <= vertex.abs() && vertex != 0.0;
        if flat || !between {
            let face = on_triangle(&w[i], &w[j], &w[k]).renumbered([i, j, k]);
            best = Some(best.map_or(face, |nearest| nearest.nearer(face)));
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_reproduce_the_point_and_it_is_optimal() {
        let w = [
            Vec3::new(1.0, 0.3, 2.0),
            Vec3::new(-2.0, 0.5, 1.0),
            Vec3::new(0.4, -3.0, 1.5),
            Vec3::new(0.1, 0.2, 4.0),
        ];
        for len in 1..=4 {
            let n = nearest(len, &w).expect("the origin is outside");
            let sum: Vec3 = w.iter().zip(n.weights).map(|(w, l)| w * l).sum();
            assert!((sum - n.point).norm() < 1e-14);
            assert!((n.weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            for vertex in &w[..len] {
                assert!(n.point.dot(&(vertex - n.point)) > -1e-14);
            }
        }
    }

    #[test]
    fn an_origin_on_a_vertex_is_not_far_from_a_tetrahedron() {
        let w = [
            Vec3::new(0.0, 2.842170943040401e-14, -3.2693622818769086e-5),
            Vec3::new(321.49873712188895, -143.3624014531989, 9.106277808580058),
            Vec3::new(-328.53944835733256, -29.16482907522709, 15.481048889031001),
            Vec3::new(0.0, 2.842170943040401e-14, -5.329070518200751e-15),
        ];
        assert!(nearest(4, &w).is_none_or(|found| found.point.norm() < 1e-13));
    }

    #[test]
    fn doubled_corners_enclose_nothing() {
        let (p, q, r) = (Vec3::new(1.0, 0.0, 1.0), Vec3::new(-1.0, 1.0, 1.0), Vec3::new(-1.0, -1.0, 1.0));
        for w in [[p, q, r, r], [p, q, q, p], [p, p, p, p]] {
            let n = nearest(4, &w).expect("the origin is 1 off the plane");
            assert!(n.point.z == 1.0);
        }
    }

    #[test]
    fn edges_whose_squares_vanish_have_a_nearest_point() {
        let tip = |x: f64, y: f64| Vec3::new(x, y, 60.0);
        for scale in [1e-150, 1e-160, 1e-170] {
            let w = [
                tip(-1e-160, -6e-162),
                tip(-1.8 * scale, 1.04e-1 * scale),
                tip(-3e-178, -2e-179),
                tip(0.0, scale),
            ];
            for len in 1..=4 {
                let n = nearest(len, &w).expect("the origin is 60 off");
                assert!(n.point.z == 60.0 && n.weights.iter().any(|&weight| weight > 0.0));
            }
        }
    }

    #[test]
    fn flat_tetrahedron_off_the_origin_is_outside() {
        let w = [
            Vec3::new(-1.0, -1.0, 1e-3),
            Vec3::new(1.0, -1.0, 1e-3),
            Vec3::new(1.0, 1.0, 1e-3),
            Vec3::new(-1.0, 1.0, 1e-3 + 1e-19),
        ];
        let n = nearest(4, &w).expect("the origin is 1e-3 off the plane");
        assert!((n.point - Vec3::new(0.0, 0.0, 1e-3)).norm() < 1e-16);
    }
}
