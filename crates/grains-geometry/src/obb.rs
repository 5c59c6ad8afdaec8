//! Separating axis test of two oriented boxes (Gottschalk, Lin and Manocha 1996).

use crate::{Mat3, Placement, Vec3};

/// Squared sine of the angle of two edges below which their cross product is no axis of its own.
const PARALLEL: f64 = 1e-12;

/// Whether one of the 15 axes proves the boxes farther apart than `margin` (m).
///
/// Box A, of half edges `half_a` (m), is centred in its frame; box B, of half edges `half_b` (m) at
/// scale 1, is put there by `placement`. True is a proof; false may also mean boxes somewhat farther
/// apart than `margin` at a corner.
pub fn boxes_apart(half_a: &Vec3, half_b: &Vec3, placement: &Placement, margin: f64) -> bool {
    let boxes = Boxes::new(half_a, half_b, placement, margin);
    (0..3).any(|axis| boxes.face_of_a(axis) || boxes.face_of_b(axis))
        || (0..3).any(|i| (0..3).any(|j| boxes.edges(i, j)))
}

struct Boxes<'a> {
    half_a: &'a Vec3,
    half_b: &'a Vec3,
    placement: &'a Placement,
    /// Absolute values of the matrix.
    reach: Mat3,
    /// Scale of B and its square.
    scale: f64,
    scale2: f64,
    margin: f64,
}

impl<'a> Boxes<'a> {
    #[inline(always)]
    fn new(half_a: &'a Vec3, half_b: &'a Vec3, placement: &'a Placement, margin: f64) -> Self {
        let scale2 = placement.matrix.column(0).norm_squared();
        Self {
            half_a,
            half_b,
            placement,
            reach: placement.matrix.abs(),
            scale: scale2.sqrt(),
            scale2,
            margin,
        }
    }

    /// Axis e_i.
    #[inline(always)]
    fn face_of_a(&self, i: usize) -> bool {
        let (m, half_b) = (&self.reach, self.half_b);
        let reach = self.half_a[i] + m[(i, 0)] * half_b.x + m[(i, 1)] * half_b.y + m[(i, 2)] * half_b.z;
        self.placement.translation[i].abs() - reach > self.margin
    }

    /// Axis c_j, column j of the matrix, of the length of the scale.
    #[inline(always)]
    fn face_of_b(&self, j: usize) -> bool {
        let (m, half_a) = (&self.reach, self.half_a);
        let reach =
            half_a.x * m[(0, j)] + half_a.y * m[(1, j)] + half_a.z * m[(2, j)] + self.half_b[j] * self.scale2;
        let along = self.placement.translation.dot(&self.placement.matrix.column(j));
        along.abs() - reach > self.margin * self.scale
    }

    /// Axis e_i × c_j; with orthogonal columns, |(e_i × c_j)·c_k| = scale |m_il| for l the third column.
    #[inline(always)]
    fn edges(&self, i: usize, j: usize) -> bool {
        let (m, r, t) = (&self.placement.matrix, &self.reach, &self.placement.translation);
        let (p, q) = ((i + 1) % 3, (i + 2) % 3);
        let (k, l) = ((j + 1) % 3, (j + 2) % 3);
        let length2 = m[(p, j)] * m[(p, j)] + m[(q, j)] * m[(q, j)];
        let reach_a = self.half_a[p] * r[(q, j)] + self.half_a[q] * r[(p, j)];
        let reach_b = self.scale * (self.half_b[k] * r[(i, l)] + self.half_b[l] * r[(i, k)]);
        let gap = (t[q] * m[(p, j)] - t[p] * m[(q, j)]).abs() - reach_a - reach_b;
        (length2 > PARALLEL * self.scale2) & (gap > 0.0) & (gap * gap > self.margin * self.margin * length2)
    }
}
