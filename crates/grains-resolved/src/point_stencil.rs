//! The velocity at a point as a sum over 3 x 3 x 3 of the grid: products of weights along the axes.

/// Places and weights of the velocities about a point; along an axis with fewer than three the last weights are 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PointStencil {
    /// Place in the arrays of the lowest.
    pub first: u32,
    /// Weights along x, y and z (-).
    weights: [[f64; 3]; 3],
}

impl PointStencil {
    /// Weights along x, y and z (-) from the lowest place on.
    pub fn new(first: usize, weights: [[f64; 3]; 3]) -> Self {
        Self { first: first as u32, weights }
    }

    /// Σ w u.
    #[inline(always)]
    pub fn mean(&self, strides: [usize; 3], u: &[f64]) -> f64 {
        let [x, ..] = &self.weights;
        let of_line = |(first, weight): (usize, f64)| {
            let line = &u[first..][..3];
            weight * (x[0] * line[0] + x[1] * line[1] + x[2] * line[2])
        };
        self.lines(strides).into_iter().map(of_line).sum()
    }

    /// Adds w times a value to all places.
    #[inline(always)]
    pub fn spread(&self, strides: [usize; 3], value: f64, field: &mut [f64]) {
        let x = self.weights[0].map(|weight| weight * value);
        for (first, weight) in self.lines(strides) {
            field[first..][..3].iter_mut().zip(x).for_each(|(f, along_x)| *f += weight * along_x);
        }
    }

    /// First places of the nine lines along x, and their weights.
    #[inline(always)]
    fn lines(&self, [_, sy, sz]: [usize; 3]) -> [(usize, f64); 9] {
        let [_, y, z] = &self.weights;
        std::array::from_fn(|line| {
            let (j, k) = (line % 3, line / 3);
            (self.first as usize + j * sy + k * sz, y[j] * z[k])
        })
    }

    /// All places.
    #[inline(always)]
    pub fn places(&self, strides: [usize; 3]) -> impl Iterator<Item = usize> {
        self.lines(strides).into_iter().flat_map(|(first, _)| first..first + 3)
    }

    /// Σ w² (-).
    pub fn square(&self) -> f64 {
        self.weights.iter().map(|weights| weights.iter().map(|w| w * w).sum::<f64>()).product()
    }

    /// The weights with room on both sides.
    pub fn windows(&self) -> Windows {
        Windows(self.weights.map(|[a, b, c]| [0.0, 0.0, a, b, c, 0.0, 0.0]))
    }
}

/// Weights along x, y and z from two places before the lowest on.
pub(crate) struct Windows([[f64; 7]; 3]);

impl Windows {
    /// Σ w w' with a stencil whose lowest place is at most two from this one, by so many along the axes.
    #[inline(always)]
    pub fn overlap(&self, other: &PointStencil, apart: [i32; 3]) -> f64 {
        let along = |axis: usize| {
            let (window, weights) = (&self.0[axis][(2 + apart[axis]) as usize..][..3], &other.weights[axis]);
            window[0] * weights[0] + window[1] * weights[1] + window[2] * weights[2]
        };
        along(0) * along(1) * along(2)
    }
}

#[cfg(test)]
mod tests {
    use super::PointStencil;
    use crate::Subgrid;
    use crate::spectrum::Random;
    use grains_fluid::{FlowSetup, Grid};
    use grains_geometry::Vec3;

    #[test]
    fn stencils_give_polynomials_exactly_and_spread_the_way_they_interpolate() {
        let grid = Grid::uniform([0.0; 3], [6.0, 5.0, 8.0], [10; 3], [true; 3]).unwrap();
        let subgrid = Subgrid::new(&FlowSetup { halo: 3, ..FlowSetup::new(grid, 1.0, 1.0) }).unwrap();
        let strides = subgrid.layout.strides();
        let mut random = Random(5);
        for k in 0..300 {
            let component = k % 3;
            let point = Vec3::new(6.0 * random.next(), 5.0 * random.next(), 8.0 * random.next());
            let normal = Vec3::from_fn(|_, _| random.next() - 0.5);
            let outward = subgrid.outward_block(component, &point, &normal).unwrap();
            let about = subgrid.block_about(component, &point).unwrap();
            let [a, b] = [0, 1].map(|_| Vec3::from_fn(|_, _| random.next() - 0.5));
            let linear = |x: &Vec3| (0..3).map(|k| 1.0 + a[k] * x[k]).product::<f64>();
            let parabolic =
                |x: &Vec3| (0..3).map(|k| 1.0 + a[k] * x[k] + b[k] * x[k] * x[k]).product::<f64>();
            let field = |f: &dyn Fn(&Vec3) -> f64| -> Vec<f64> {
                (0..subgrid.layout.len()).map(|place| f(&subgrid.position(component, place))).collect()
            };
            let (lines, parabolas) = (field(&linear), field(&parabolic));
            assert!((about.mean(strides, &lines) - linear(&point)).abs() < 1e-9);
            assert!((outward.mean(strides, &parabolas) - parabolic(&point)).abs() < 1e-8);
            for stencil in [outward, about] {
                let mut spread = vec![0.0; subgrid.layout.len()];
                stencil.spread(strides, 0.7, &mut spread);
                let both: f64 = spread.iter().zip(&parabolas).map(|(w, u)| w * u).sum();
                assert!((both - 0.7 * stencil.mean(strides, &parabolas)).abs() < 1e-9);
                let square: f64 = spread.iter().map(|w| w * w).sum();
                assert!((square - 0.49 * stencil.square()).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn overlaps_are_sums_over_the_places_that_stencils_share() {
        let mut random = Random(3);
        let strides = [1, 12, 144];
        let mut met = 0;
        for _ in 0..2000 {
            let [a, b] = [0, 1].map(|_| {
                let at = [0, 1, 2].map(|_| (6.0 * random.next()) as i32);
                let weights = [0, 1, 2].map(|_| [0, 1, 2].map(|_| random.next() - 0.3));
                let place = at.iter().zip(strides).map(|(&i, stride)| i as usize * stride).sum();
                (at, PointStencil::new(place, weights))
            });
            let apart: [i32; 3] = std::array::from_fn(|k| b.0[k] - a.0[k]);
            if apart.iter().any(|d| d.abs() > 2) {
                continue;
            }
            let mut field = vec![0.0; 12 * 144];
            b.1.spread(strides, 1.0, &mut field);
            assert!((a.1.windows().overlap(&b.1, apart) - a.1.mean(strides, &field)).abs() < 1e-12);
            assert!((a.1.windows().overlap(&a.1, [0; 3]) - a.1.square()).abs() < 1e-12);
            met += 1;
        }
        assert!(met > 300);
    }
}
