//! The velocity at a point as a sum over 3 x 3 x 3 of the grid: products of weights along the axes.

/// Places and weights of the velocities about a point; along an axis with fewer than three the last weights are 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PointStencil {
    /// Place in the arrays of the lowest.
    pub first: u32,
    /// Weights along x, y and z (-).
    pub weights: [[f64; 3]; 3],
}

impl PointStencil {
    /// Σ w u.
    #[inline]
    pub fn mean(&self, [_, sy, sz]: [usize; 3], u: &[f64]) -> f64 {
        let [x, y, z] = &self.weights;
        let mut sum = 0.0;
        for (k, wz) in z.iter().enumerate() {
            for (j, wy) in y.iter().enumerate() {
                let row = &u[self.first as usize + j * sy + k * sz..][..3];
                sum += wy * wz * (x[0] * row[0] + x[1] * row[1] + x[2] * row[2]);
            }
        }
        sum
    }

    /// Adds w times a value to all places.
    #[inline]
    pub fn spread(&self, [_, sy, sz]: [usize; 3], value: f64, field: &mut [f64]) {
        let [x, y, z] = &self.weights;
        for (k, wz) in z.iter().enumerate() {
            for (j, wy) in y.iter().enumerate() {
                let row = &mut field[self.first as usize + j * sy + k * sz..][..3];
                let value = wy * wz * value;
                row.iter_mut().zip(x).for_each(|(f, wx)| *f += wx * value);
            }
        }
    }

    /// The same places with the sizes of the weights.
    pub fn abs(&self) -> Self {
        Self { weights: self.weights.map(|w| w.map(f64::abs)), ..*self }
    }

    /// Σ w² (-).
    pub fn square(&self) -> f64 {
        self.weights.iter().map(|w| w.iter().map(|w| w * w).sum::<f64>()).product()
    }
}

#[cfg(test)]
mod tests {
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
}
