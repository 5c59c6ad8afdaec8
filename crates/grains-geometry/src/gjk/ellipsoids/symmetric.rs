//! Symmetric matrices of three rows, without branches.

use crate::{Mat3, Vec3};

/// A symmetric matrix.
#[derive(Clone, Copy)]
pub(super) struct Symmetric {
    pub(super) diagonal: Vec3,
    /// Components yz, zx and xy.
    pub(super) beside: Vec3,
}

impl Symmetric {
    /// M diag(d) Mᵀ.
    #[inline(always)]
    pub(super) fn turned(d: &Vec3, matrix: &Mat3) -> Self {
        let row = |k: usize| Vec3::new(matrix[(k, 0)], matrix[(k, 1)], matrix[(k, 2)]);
        let [x, y, z] = [row(0), row(1), row(2)];
        let (dx, dy, dz) = (x.component_mul(d), y.component_mul(d), z.component_mul(d));
        Self {
            diagonal: Vec3::new(dx.dot(&x), dy.dot(&y), dz.dot(&z)),
            beside: Vec3::new(dy.dot(&z), dz.dot(&x), dx.dot(&y)),
        }
    }

    /// The matrix times a number.
    #[inline(always)]
    pub(super) fn scaled(&self, factor: f64) -> Self {
        Self { diagonal: self.diagonal * factor, beside: self.beside * factor }
    }

    /// Adds f v vᵀ.
    #[inline(always)]
    pub(super) fn add_square(&mut self, v: &Vec3, factor: f64) {
        let scaled = v * factor;
        self.diagonal += scaled.component_mul(v);
        self.beside += next(&scaled).component_mul(&last(v));
    }

    /// The matrix times a vector.
    #[inline(always)]
    pub(super) fn times(&self, v: &Vec3) -> Vec3 {
        // x: xy v_y + zx v_z.
        self.diagonal.component_mul(v)
            + last(&self.beside).component_mul(&next(v))
            + next(&self.beside).component_mul(&last(v))
    }

    /// Solution of m x = y by the adjugate; not a number if m is singular.
    #[inline(always)]
    pub(super) fn solution(&self, y: &Vec3) -> Vec3 {
        let Self { diagonal, beside } = self;
        let adjugate = Self {
            diagonal: next(diagonal).component_mul(&last(diagonal)) - beside.component_mul(beside),
            beside: next(beside).component_mul(&last(beside)) - diagonal.component_mul(beside),
        };
        let determinant =
            diagonal.x * adjugate.diagonal.x + beside.z * adjugate.beside.z + beside.y * adjugate.beside.y;
        adjugate.times(y) * (1.0 / determinant)
    }
}

/// (y, z, x).
#[inline(always)]
fn next(v: &Vec3) -> Vec3 {
    Vec3::new(v.y, v.z, v.x)
}

/// (z, x, y).
#[inline(always)]
fn last(v: &Vec3) -> Vec3 {
    Vec3::new(v.z, v.x, v.y)
}
