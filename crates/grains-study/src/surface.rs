//! Response surfaces: polynomials of second order, fitted to a measure by least squares.

use nalgebra::{DMatrix, DVector};

/// Number of coefficients of a surface over some coordinates.
pub(crate) fn coefficients(dimensions: usize) -> usize {
    (dimensions + 1) * (dimensions + 2) / 2
}

/// 1, x_i and x_i x_j, in this order.
fn terms(x: &[f64]) -> DVector<f64> {
    let products = (0..x.len()).flat_map(|i| (i..x.len()).map(move |j| x[i] * x[j]));
    let all = std::iter::once(1.0).chain(x.iter().copied()).chain(products);
    DVector::from_iterator(coefficients(x.len()), all)
}

/// The surface of a measure over coordinates from −1 to 1.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    coefficients: DVector<f64>,
    /// (XᵀX)⁻¹, X the terms of all points.
    spread: DMatrix<f64>,
    /// Standard deviation of the points from the surface: scatter of runs and lack of fit.
    pub deviation: f64,
    /// Points in excess of coefficients.
    pub freedom: usize,
}

impl Surface {
    /// The surface of least squares through points with their values; none if they do not tell all coefficients and the
    /// scatter.
    pub fn fit(points: &[(&[f64], f64)]) -> Option<Self> {
        let dimensions = points.first()?.0.len();
        let count = coefficients(dimensions);
        let freedom = points.len().checked_sub(count).filter(|&freedom| freedom >= 2)?;
        let rows: Vec<DVector<f64>> = points.iter().map(|(x, _)| terms(x)).collect();
        let matrix = DMatrix::from_fn(points.len(), count, |row, column| rows[row][column]);
        let values = DVector::from_iterator(points.len(), points.iter().map(|(_, value)| *value));
        let normal = matrix.tr_mul(&matrix);
        // Points that lie on a surface of second order make some combination of terms unknown.
        let eigenvalues = normal.symmetric_eigenvalues();
        if eigenvalues.min() < 1e-10 * eigenvalues.max() {
            return None;
        }
        let spread = normal.cholesky()?.inverse();
        let coefficients = &spread * matrix.tr_mul(&values);
        let deviation = ((&matrix * &coefficients - values).norm_squared() / freedom as f64).sqrt();
        Some(Self { coefficients, spread, deviation, freedom })
    }

    /// The measure at a place.
    pub fn value(&self, x: &[f64]) -> f64 {
        self.coefficients.dot(&terms(x))
    }

    /// Derivatives by the coordinates.
    pub fn gradient(&self, x: &[f64]) -> Vec<f64> {
        let mut gradient: Vec<f64> = self.coefficients.iter().skip(1).take(x.len()).copied().collect();
        let mut products = self.coefficients.iter().skip(1 + x.len());
        for i in 0..x.len() {
            for j in i..x.len() {
                let c = products.next().copied().unwrap_or(0.0);
                gradient[i] += c * x[j];
                gradient[j] += c * x[i];
            }
        }
        gradient
    }

    /// Variance of the surface at a place, widened as the scatter is known from few points, by what makes 68 % of Student's
    /// distribution from those of the normal one.
    pub fn variance(&self, x: &[f64]) -> f64 {
        self.value_and_variance(x)[1]
    }

    /// Both at once.
    pub fn value_and_variance(&self, x: &[f64]) -> [f64; 2] {
        let terms = terms(x);
        let rows = terms.iter().zip(self.spread.column_iter());
        let spread: f64 = rows.map(|(term, column)| term * column.dot(&terms)).sum();
        let freedom = self.freedom as f64;
        let widened = freedom / (freedom - 1.0);
        [self.coefficients.dot(&terms), self.deviation.powi(2) * spread * widened]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn a_surface_of_second_order_is_found_again_with_its_slopes() {
        let f =
            |x: &[f64]| 2.0 - x[0] + 0.5 * x[1] + 3.0 * x[0] * x[0] - 0.7 * x[0] * x[1] + 0.2 * x[1] * x[1];
        let mut random = Random::new(3, 0);
        let points: Vec<[f64; 2]> =
            (0..9).map(|_| [2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0]).collect();
        let rows: Vec<(&[f64], f64)> = points.iter().map(|x| (&x[..], f(x))).collect();
        let surface = Surface::fit(&rows).unwrap();
        let x = [0.3, -0.4];
        assert!((surface.value(&x) - f(&x)).abs() < 1e-12 && surface.deviation < 1e-12);
        let slopes = [-1.0 + 6.0 * 0.3 + 0.7 * 0.4, 0.5 - 0.7 * 0.3 - 0.4 * 0.4];
        surface.gradient(&x).iter().zip(slopes).for_each(|(a, b)| assert!((a - b).abs() < 1e-12, "{a} {b}"));
        assert!(Surface::fit(&rows[..7]).is_none());
        let on_a_line: Vec<(&[f64], f64)> = rows.iter().map(|_| (&points[0][..], 1.0)).collect();
        assert!(Surface::fit(&on_a_line).is_none());
    }
}
