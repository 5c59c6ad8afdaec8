//! Separating axis test of two oriented boxes (Gottschalk, Lin and Manocha 1996).

use crate::{Mat3, Placement, Vec3};

/// Squared sine of the angle of two edges below which their cross product is no axis of its own.
const PARALLEL: f64 = 1e-12;

/// Axis along which the gap of two boxes is widest of all 15, in the frame of A, of any length and towards B; the way from centre to
/// centre where they overlap along all.
///
/// Box A, of half edges `half_a` (m), is centred in its frame; box B, of half edges `half_b` (m) at scale 1, is put there by `placement`.
/// `None` proves the boxes farther apart than `margin` (m); some axis may also mean boxes somewhat farther apart at a corner.
pub fn axis_of_widest_gap(half_a: &Vec3, half_b: &Vec3, placement: &Placement, margin: f64) -> Option<Vec3> {
    let boxes = Boxes::new(half_a, half_b, placement);
    let (mut widest, mut of) = (0.0, Axis::Centres);
    let mut is_beyond = |gap: f64, axis: Axis| {
        if gap > widest {
            (widest, of) = (gap, axis);
        }
        gap > margin
    };
    let is_apart = (0..3).any(|i| {
        is_beyond(boxes.along_face_of_a(i), Axis::OfA(i)) || is_beyond(boxes.along_face_of_b(i), Axis::OfB(i))
    }) || (0..3)
        .any(|i| (0..3).any(|j| is_beyond(boxes.across_edges(i, j), Axis::Edges(i, j))));
    (!is_apart).then(|| boxes.axis(of))
}

/// One of the axes that are looked at.
#[derive(Clone, Copy)]
enum Axis {
    Centres,
    OfA(usize),
    OfB(usize),
    Edges(usize, usize),
}

struct Boxes<'a> {
    half_a: &'a Vec3,
    half_b: &'a Vec3,
    placement: &'a Placement,
    /// Absolute values of the matrix.
    reach: Mat3,
    /// Scale of B, its square and its inverse.
    scale: f64,
    scale2: f64,
    inverse_scale: f64,
}

impl<'a> Boxes<'a> {
    #[inline(always)]
    fn new(half_a: &'a Vec3, half_b: &'a Vec3, placement: &'a Placement) -> Self {
        let scale2 = placement.matrix.column(0).norm_squared();
        let scale = scale2.sqrt();
        Self {
            half_a,
            half_b,
            placement,
            reach: placement.matrix.abs(),
            scale,
            scale2,
            inverse_scale: 1.0 / scale,
        }
    }

    /// Gap (m) along e_i.
    #[inline(always)]
    fn along_face_of_a(&self, i: usize) -> f64 {
        let (m, half_b) = (&self.reach, self.half_b);
        let reach = self.half_a[i] + m[(i, 0)] * half_b.x + m[(i, 1)] * half_b.y + m[(i, 2)] * half_b.z;
        self.placement.translation[i].abs() - reach
    }

    /// Gap (m) along c_j, column j of the matrix, of the length of the scale.
    #[inline(always)]
    fn along_face_of_b(&self, j: usize) -> f64 {
        let (m, half_a) = (&self.reach, self.half_a);
        let reach =
            half_a.x * m[(0, j)] + half_a.y * m[(1, j)] + half_a.z * m[(2, j)] + self.half_b[j] * self.scale2;
        let along = self.placement.translation.dot(&self.placement.matrix.column(j));
        (along.abs() - reach) * self.inverse_scale
    }

    /// Gap (m) along e_i × c_j, negative if the two are parallel; with orthogonal columns, |(e_i × c_j)·c_k| = scale |m_il| for l the
    /// third column.
    #[inline(always)]
    fn across_edges(&self, i: usize, j: usize) -> f64 {
        let (m, r, t) = (&self.placement.matrix, &self.reach, &self.placement.translation);
        let (p, q) = ((i + 1) % 3, (i + 2) % 3);
        let (k, l) = ((j + 1) % 3, (j + 2) % 3);
        let length2 = m[(p, j)] * m[(p, j)] + m[(q, j)] * m[(q, j)];
        let reach_a = self.half_a[p] * r[(q, j)] + self.half_a[q] * r[(p, j)];
        let reach_b = self.scale * (self.half_b[k] * r[(i, l)] + self.half_b[l] * r[(i, k)]);
        let gap = (t[q] * m[(p, j)] - t[p] * m[(q, j)]).abs() - reach_a - reach_b;
        // Of boxes that overlap along it nobody asks how far.
        if gap > 0.0 && length2 > PARALLEL * self.scale2 { gap / length2.sqrt() } else { -1.0 }
    }

    /// An axis towards B.
    fn axis(&self, axis: Axis) -> Vec3 {
        let Placement { matrix, translation } = self.placement;
        let along = match axis {
            Axis::Centres => return *translation,
            Axis::OfA(i) => Vec3::ith(i, 1.0),
            Axis::OfB(j) => matrix.column(j).into(),
            Axis::Edges(i, j) => Vec3::ith(i, 1.0).cross(&matrix.column(j)),
        };
        along * 1.0_f64.copysign(along.dot(translation))
    }
}
