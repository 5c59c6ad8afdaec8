//! Separating axis test of two oriented boxes (Gottschalk, Lin and Manocha 1996).

use crate::{Placement, Vec3};

/// Axes of the test: three of A, three of B, nine cross products.
const AXES: u8 = 15;
/// Squared sine of the angle of two edges below which their cross product is no axis of its own.
const PARALLEL: f64 = 1e-12;

/// Whether one of the 15 axes proves the boxes farther apart than `margin` (m).
///
/// Box A, of half edges `half_a` (m), is centred in its frame; box B, of half edges `half_b` (m) at
/// scale 1, is put there by `placement`. True is a proof; false may also mean boxes somewhat farther
/// apart than `margin` at a corner. `hint` is the axis tried first and becomes the axis found: it
/// changes the time, never the answer.
pub fn boxes_apart(half_a: &Vec3, half_b: &Vec3, placement: &Placement, margin: f64, hint: &mut u8) -> bool {
    let boxes = Boxes::new(half_a, half_b, placement, margin);
    let first = *hint % AXES;
    if boxes.apart_along(first) {
        return true;
    }
    match (0..AXES).find(|axis| *axis != first && boxes.apart_along(*axis)) {
        Some(axis) => {
            *hint = axis;
            true
        }
        None => false,
    }
}

struct Boxes<'a> {
    half_a: &'a Vec3,
    half_b: &'a Vec3,
    placement: &'a Placement,
    /// Scale of B and its square.
    scale: f64,
    scale2: f64,
    margin: f64,
}

impl<'a> Boxes<'a> {
    #[inline]
    fn new(half_a: &'a Vec3, half_b: &'a Vec3, placement: &'a Placement, margin: f64) -> Self {
        let scale2 = placement.matrix.column(0).norm_squared();
        Self { half_a, half_b, placement, scale: scale2.sqrt(), scale2, margin }
    }

    #[inline]
    fn apart_along(&self, axis: u8) -> bool {
        match axis as usize {
            i @ 0..3 => self.face_of_a(i),
            j @ 3..6 => self.face_of_b(j - 3),
            k => self.edges((k - 6) / 3, (k - 6) % 3),
        }
    }

    /// Axis e_i.
    #[inline]
    fn face_of_a(&self, i: usize) -> bool {
        let row = self.placement.matrix.row(i);
        let reach = self.half_a[i]
            + row[0].abs() * self.half_b.x
            + row[1].abs() * self.half_b.y
            + row[2].abs() * self.half_b.z;
        self.placement.translation[i].abs() - reach > self.margin
    }

    /// Axis c_j, column j of the matrix, of the length of the scale.
    #[inline]
    fn face_of_b(&self, j: usize) -> bool {
        let column = self.placement.matrix.column(j);
        let reach = self.half_a.x * column[0].abs()
            + self.half_a.y * column[1].abs()
            + self.half_a.z * column[2].abs()
            + self.half_b[j] * self.scale2;
        self.placement.translation.dot(&column).abs() - reach > self.margin * self.scale
    }

    /// Axis e_i × c_j; with orthogonal columns, |(e_i × c_j)·c_k| = scale |m_il| for l the third column.
    #[inline]
    fn edges(&self, i: usize, j: usize) -> bool {
        let (m, t) = (&self.placement.matrix, &self.placement.translation);
        let (p, q) = ((i + 1) % 3, (i + 2) % 3);
        let (k, l) = ((j + 1) % 3, (j + 2) % 3);
        let length2 = m[(p, j)] * m[(p, j)] + m[(q, j)] * m[(q, j)];
        let reach_a = self.half_a[p] * m[(q, j)].abs() + self.half_a[q] * m[(p, j)].abs();
        let reach_b = self.scale * (self.half_b[k] * m[(i, l)].abs() + self.half_b[l] * m[(i, k)].abs());
        let gap = (t[q] * m[(p, j)] - t[p] * m[(q, j)]).abs() - reach_a - reach_b;
        length2 > PARALLEL * self.scale2 && gap > 0.0 && gap * gap > self.margin * self.margin * length2
    }
}
