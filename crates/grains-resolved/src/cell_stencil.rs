//! The cell of velocities about a point, and multilinear interpolation in it.

use crate::solid_mask::Holders;
use grains_geometry::lanes::Number;

/// The cells of velocities about one point, or about several side by side.
#[derive(Clone, Copy)]
pub(crate) struct Cells<T> {
    /// Place in the arrays of the lowest corner.
    pub base: T,
    /// Place of the point between the lower and the upper corners (-).
    pub fractions: [T; 3],
    /// 1, or 0 where there is no such cell.
    pub is_there: T,
}

impl<T: Number> Cells<T> {
    /// The cell about one of the points, if there is one.
    #[inline(always)]
    pub fn stencil(&self, lane: usize) -> Option<Stencil> {
        let [x, y, z] = self.fractions;
        (self.is_there.lane(lane) != 0.0).then(|| Stencil {
            base: self.base.lane(lane) as usize,
            fractions: [x.lane(lane), y.lane(lane), z.lane(lane)],
        })
    }
}

/// Weights of the corners of a cell of velocities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stencil {
    /// Place in the arrays of the lowest corner.
    pub base: usize,
    /// Place of the point between the lower and the upper corners (-).
    pub fractions: [f64; 3],
}

impl Stencil {
    /// Places and weights of the corners that count.
    #[inline]
    pub fn corners(&self, strides: [usize; 3]) -> impl Iterator<Item = (usize, f64)> + '_ {
        (0..8).filter_map(move |corner| {
            let (mut place, mut weight) = (self.base, 1.0);
            for (a, (stride, fraction)) in strides.iter().zip(self.fractions).enumerate() {
                if corner >> a & 1 == 1 {
                    place += stride;
                    weight *= fraction;
                } else {
                    weight *= 1.0 - fraction;
                }
            }
            (weight != 0.0).then_some((place, weight))
        })
    }

    /// Multilinear interpolation of the values at the corners.
    #[inline]
    pub fn mean(&self, strides: [usize; 3], values: &[f64]) -> f64 {
        self.between(self.rows(strides).map(|row| [values[row], values[row + 1]]))
    }

    /// Weight of the corners in bodies (-).
    #[inline(always)]
    pub fn hidden(&self, strides: [usize; 3], holders: Holders) -> f64 {
        let [a, b, c, d] = self.rows(strides);
        // Maps of arrays would be calls of their own.
        let on = |row: usize| holders.mask.contains_edge(row);
        let solid = [on(a), on(b), on(c), on(d)];
        match solid.as_flattened().contains(&true) {
            true => self.between(solid.map(|row| row.map(|is_solid| f64::from(u8::from(is_solid))))),
            false => 0.0,
        }
    }

    /// Lower corners of the four edges along x.
    #[inline]
    fn rows(&self, [_, sy, sz]: [usize; 3]) -> [usize; 4] {
        [0, sy, sz, sy + sz].map(|offset| self.base + offset)
    }

    /// Multilinear interpolation of values on the four edges along x.
    #[inline]
    fn between(&self, edges: [[f64; 2]; 4]) -> f64 {
        let [x, y, z] = self.fractions;
        let between = |[low, high]: [f64; 2], t: f64| low + t * (high - low);
        let [a, b, c, d] = edges.map(|edge| between(edge, x));
        between([between([a, b], y), between([c, d], y)], z)
    }
}
