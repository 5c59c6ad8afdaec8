//! Straight lines through points.

/// A line `y = intercept + slope x`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Slope.
    pub slope: f64,
    /// Value at zero.
    pub intercept: f64,
    /// Share of the variance of y that the line explains (-).
    pub r_squared: f64,
}

impl Fit {
    /// Least squares, from the means of x and y and the sums Σ (x − x̄)², Σ (x − x̄)(y − ȳ) and Σ (y − ȳ)²; none if the first is zero.
    pub fn of_moments(means: [f64; 2], [xx, xy, yy]: [f64; 3]) -> Option<Self> {
        if xx.is_nan() || xx <= 0.0 {
            return None;
        }
        let slope = xy / xx;
        let r_squared = if yy > 0.0 { slope * xy / yy } else { 1.0 };
        Some(Self { slope, intercept: means[1] - slope * means[0], r_squared })
    }
}

/// Least squares; none for fewer than two different x.
pub fn least_squares(points: &[[f64; 2]]) -> Option<Fit> {
    let n = points.len() as f64;
    // About the means, so that large offsets cost no digits.
    let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / n;
    let means = [mean(0), mean(1)];
    let moment =
        |a: usize, b: usize| points.iter().map(|p| (p[a] - means[a]) * (p[b] - means[b])).sum::<f64>();
    Fit::of_moments(means, [moment(0, 0), moment(0, 1), moment(1, 1)])
}

/// Standard uncertainties of intercept and slope of the line of least squares through some points, s² = Σ r²/(n − 2) being
/// the variance about it: s (1/n + x̄²/S)^½ and s/S^½ with S = Σ (x − x̄)²; NaN for fewer than three points.
pub fn standard_uncertainties(points: &[[f64; 2]], line: &Fit) -> [f64; 2] {
    if points.len() < 3 {
        return [f64::NAN; 2];
    }
    let n = points.len() as f64;
    let mean = points.iter().map(|p| p[0]).sum::<f64>() / n;
    let spread: f64 = points.iter().map(|p| (p[0] - mean).powi(2)).sum();
    let rest: f64 = points.iter().map(|p| (p[1] - line.intercept - line.slope * p[0]).powi(2)).sum();
    let s = (rest / (n - 2.0)).sqrt();
    [s * (1.0 / n + mean * mean / spread).sqrt(), s / spread.sqrt()]
}

/// Mean and sample standard deviation √(Σ (x − x̄)²/(n − 1)); NaN for the latter of fewer than two values.
pub fn mean_and_sample_deviation(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    [mean, (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()]
}

/// The line of the median slope of all pairs of points (Theil 1950, Sen 1968): up to 29 % of the points may
/// lie anywhere; none for fewer than two different x.
pub fn median_slope(points: &[[f64; 2]]) -> Option<Fit> {
    let pairs = points.iter().enumerate().flat_map(|(k, p)| points[k + 1..].iter().map(move |q| (p, q)));
    let slopes: Vec<f64> =
        pairs.filter(|(p, q)| p[0] != q[0]).map(|(p, q)| (q[1] - p[1]) / (q[0] - p[0])).collect();
    let slope = median(slopes)?;
    let intercept = median(points.iter().map(|p| p[1] - slope * p[0]).collect())?;
    let mean = points.iter().map(|p| p[1]).sum::<f64>() / points.len() as f64;
    let scatter = |line: &dyn Fn(f64) -> f64| points.iter().map(|p| (p[1] - line(p[0])).powi(2)).sum::<f64>();
    let (rest, all) = (scatter(&|x| intercept + slope * x), scatter(&|_| mean));
    let r_squared = if all > 0.0 { 1.0 - rest / all } else { 1.0 };
    Some(Fit { slope, intercept, r_squared })
}

/// The middle value; none of no values.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    match n {
        0 => None,
        _ if n % 2 == 1 => Some(values[n / 2]),
        _ => Some(0.5 * (values[n / 2 - 1] + values[n / 2])),
    }
}

/// Mean and standard deviation of the values that are numbers; NaN without any.
pub fn mean_and_deviation(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let values: Vec<f64> = values.filter(|x| x.is_finite()).collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    [mean, (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uncertainties_are_those_of_a_computation_by_hand() {
        // Means 2.5 and 5, Σ (x − x̄)² = 5, Σ (x − x̄)(y − ȳ) = 9.4: slope 1.88, intercept 5 − 2.5 · 1.88.
        let points = [[1.0, 2.0], [2.0, 4.3], [3.0, 6.0], [4.0, 7.7]];
        let line = least_squares(&points).unwrap();
        assert!((line.slope - 1.88).abs() < 1e-12 && (line.intercept - 0.3).abs() < 1e-12, "{line:?}");
        // Residuals −0.18, 0.24, 0.06, −0.12: s² = 0.108/2 = 0.054.
        let [of_intercept, of_slope] = standard_uncertainties(&points, &line);
        assert!((of_slope - (0.054_f64 / 5.0).sqrt()).abs() < 1e-12, "{of_slope}");
        assert!((of_intercept - (0.054_f64 * (0.25 + 6.25 / 5.0)).sqrt()).abs() < 1e-12, "{of_intercept}");
        assert!(standard_uncertainties(&points[..2], &line)[0].is_nan());
        // The ten beds of trilobes of table 7.3 of the thesis: 1.00 % of the mean.
        let voids = [0.4070, 0.4047, 0.4017, 0.4047, 0.4030, 0.4038, 0.4030, 0.4120, 0.4142, 0.4056];
        let [mean, deviation] = mean_and_sample_deviation(&voids);
        assert!(
            (mean - 0.4060).abs() < 1e-4 && (deviation / mean - 0.0100).abs() < 1e-4,
            "{mean} {deviation}"
        );
    }

    #[test]
    fn both_fits_find_a_line_and_one_bears_outliers() {
        let mut points: Vec<[f64; 2]> =
            (0..20).map(|k| [1e6 + f64::from(k), 3.0 - 0.5 * f64::from(k)]).collect();
        let plain = least_squares(&points).unwrap();
        assert!((plain.slope + 0.5).abs() < 1e-12 && (plain.r_squared - 1.0).abs() < 1e-12);
        for k in [2, 9, 15, 17] {
            points[k][1] = 1e3;
        }
        let robust = median_slope(&points).unwrap();
        assert!((robust.slope + 0.5).abs() < 1e-9, "{robust:?}");
        assert!(least_squares(&points).unwrap().slope.abs() > 1.0);
        assert_eq!(least_squares(&[[1.0, 2.0]; 3]), None);
        assert_eq!(median_slope(&[[1.0, 2.0]; 3]), None);
        assert_eq!(median(vec![3.0, 1.0, 2.0, 4.0]), Some(2.5));
    }
}
