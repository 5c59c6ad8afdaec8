//! Motion by a table of times: displacements and angles with continuous velocities between the rows.

use grains_geometry::Vec3;

/// Displacements, and angles about an axis, given at times.
///
/// Each component y(t) is the monotone cubic through its rows: a cubic Hermite polynomial between two rows, with the slope
/// of Fritsch and Butland (1984) at each row,
///
/// ```text
/// 1/y' = (w₋/Δ₋ + w₊/Δ₊)/(w₋ + w₊),  w₋ = h₋ + 2 h₊,  w₊ = 2 h₋ + h₊     y' = 0 where Δ₋ Δ₊ ≤ 0
/// ```
///
/// with the widths h and secants Δ of the intervals before and after. It has no extremes but at rows. At the first and the last
/// row y' = 0: the wall rests before and after, and its velocity is continuous.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionTable {
    times: Vec<f64>,
    /// Displacement (m) and angle (rad) of each row.
    values: Vec<[f64; 4]>,
    /// Their rates at each row (m/s, rad/s).
    slopes: Vec<[f64; 4]>,
    bounds: [f64; 3],
    /// Point on the axis (m).
    pub point: Vec3,
    /// Unit vector of the axis.
    pub axis: Vec3,
}

impl MotionTable {
    /// The table of rows of ascending times (s), displacements (m) and angles (rad) about an axis through a point (m).
    pub fn new(rows: &[(f64, Vec3, f64)], point: Vec3, axis: Vec3) -> Self {
        let times: Vec<f64> = rows.iter().map(|row| row.0).collect();
        let values: Vec<[f64; 4]> = rows.iter().map(|(_, d, angle)| [d.x, d.y, d.z, *angle]).collect();
        let mut slopes = vec![[0.0; 4]; rows.len()];
        for k in 1..rows.len().saturating_sub(1) {
            let (before, after) = (times[k] - times[k - 1], times[k + 1] - times[k]);
            slopes[k] = std::array::from_fn(|c| {
                let secants =
                    [(values[k][c] - values[k - 1][c]) / before, (values[k + 1][c] - values[k][c]) / after];
                slope([before, after], secants)
            });
        }
        let bounds = bounds(&times, &values, &slopes);
        Self { times, values, slopes, bounds, point, axis }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// Whether there are no rows: the wall rests.
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// Times (s) of the first and the last row.
    pub fn interval(&self) -> [f64; 2] {
        [self.times.first(), self.times.last()].map(|time| time.copied().unwrap_or(0.0))
    }

    /// Displacement (m) and angle (rad) at a time (s), and their rates.
    pub fn at(&self, time: f64) -> [(Vec3, f64); 2] {
        let next = self.times.partition_point(|&row| row <= time);
        let [values, rates] = if next == 0 {
            [self.values.first().copied().unwrap_or_default(), [0.0; 4]]
        } else if next == self.times.len() {
            [self.values[next - 1], [0.0; 4]]
        } else {
            self.between(next, time)
        };
        [values, rates].map(|[x, y, z, angle]| (Vec3::new(x, y, z), angle))
    }

    /// Values and rates at a time (s) before a row.
    fn between(&self, next: usize, time: f64) -> [[f64; 4]; 2] {
        let h = self.times[next] - self.times[next - 1];
        let s = (time - self.times[next - 1]) / h;
        let rest = 1.0 - s;
        let value = |c: usize| {
            let [y, z] = [self.values[next - 1][c], self.values[next][c]];
            let [d, e] = [self.slopes[next - 1][c], self.slopes[next][c]];
            let curve = rest * (y * (1.0 + 2.0 * s) + d * h * s) * rest;
            curve + s * (z * (1.0 + 2.0 * rest) - e * h * rest) * s
        };
        let rate = |c: usize| {
            let secant = (self.values[next][c] - self.values[next - 1][c]) / h;
            let [d, e] = [self.slopes[next - 1][c], self.slopes[next][c]];
            6.0 * s * rest * secant + d * rest * (1.0 - 3.0 * s) + e * s * (3.0 * s - 2.0)
        };
        [std::array::from_fn(value), std::array::from_fn(rate)]
    }

    /// Bounds on the speed (m/s), on the angular speed (rad/s) and on the displacement (m).
    pub fn bounds(&self) -> [f64; 3] {
        self.bounds
    }
}

/// Bounds on the speed (m/s), the angular speed (rad/s) and the displacement (m) of cubics.
fn bounds(times: &[f64], values: &[[f64; 4]], slopes: &[[f64; 4]]) -> [f64; 3] {
    let (mut speed, mut turning) = (0.0_f64, 0.0_f64);
    for next in 1..times.len() {
        let h = times[next] - times[next - 1];
        let [x, y, z, angle]: [f64; 4] = std::array::from_fn(|c| {
            let secant = (values[next][c] - values[next - 1][c]) / h;
            largest_rate(secant, [slopes[next - 1][c], slopes[next][c]])
        });
        speed = speed.max(Vec3::new(x, y, z).norm());
        turning = turning.max(angle);
    }
    // Between two rows each component lies between theirs.
    let largest = |c: usize| values.iter().map(|row| row[c].abs()).fold(0.0, f64::max);
    [speed, turning, Vec3::new(largest(0), largest(1), largest(2)).norm()]
}

/// Slope at a row between two intervals of widths h and secants Δ.
fn slope([h, k]: [f64; 2], [before, after]: [f64; 2]) -> f64 {
    if before * after <= 0.0 {
        return 0.0;
    }
    let weights = [h + 2.0 * k, 2.0 * h + k];
    (weights[0] + weights[1]) / (weights[0] / before + weights[1] / after)
}

/// Largest magnitude of the rate between two rows, of a secant and the slopes at both.
fn largest_rate(secant: f64, [d, e]: [f64; 2]) -> f64 {
    // d + b s + c s² with s from 0 to 1.
    let (b, c) = (6.0 * secant - 4.0 * d - 2.0 * e, 3.0 * (d + e - 2.0 * secant));
    let s = -b / (2.0 * c);
    let at_extreme = if s > 0.0 && s < 1.0 { (d + s * (b + s * c)).abs() } else { 0.0 };
    d.abs().max(e.abs()).max(at_extreme)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> MotionTable {
        let rows = [
            (0.1, Vec3::new(0.0, 1.0, 0.0), 0.0),
            (0.3, Vec3::new(0.2, 1.0, -0.3), 0.4),
            (0.4, Vec3::new(0.5, 1.0, 0.1), 1.0),
            (0.9, Vec3::new(0.6, 1.0, 0.0), 0.5),
        ];
        MotionTable::new(&rows, Vec3::zeros(), Vec3::z())
    }

    #[test]
    fn a_table_goes_through_its_rows_monotonically_with_continuous_velocity() {
        let table = table();
        for (k, &time) in table.times.iter().enumerate() {
            let [(displacement, angle), _] = table.at(time);
            assert_eq!([displacement.x, displacement.y, displacement.z, angle], table.values[k]);
        }
        let [speed, turning, displacement] = table.bounds();
        let (mut fastest, h, n) = (0.0_f64, 1e-4, 10_000);
        let components = |(v, angle): (Vec3, f64)| [v.x, v.y, v.z, angle];
        for k in 0..n {
            let time = k as f64 * h;
            let [[now, rate], [next, later]] = [time, time + h].map(|t| table.at(t).map(components));
            for c in 0..4 {
                // Simpson's rule is exact for the cubics of one interval, and near one between two.
                let middle = components(table.at(time + 0.5 * h)[1])[c];
                let integral = h * (rate[c] + 4.0 * middle + later[c]) / 6.0;
                assert!((next[c] - now[c] - integral).abs() < 1e-8, "{time} {c}");
                assert!((later[c] - rate[c]).abs() < 0.05, "{time} {c}");
                let row = table.times.partition_point(|&row| row <= time);
                if row > 0 && row < table.times.len() && time + h <= table.times[row] {
                    let [a, b] = [table.values[row - 1][c], table.values[row][c]];
                    assert!((b - a) * (next[c] - now[c]) >= -1e-15, "{time} {c}");
                }
            }
            let moving = Vec3::new(rate[0], rate[1], rate[2]).norm();
            assert!(moving < 1.000_001 * speed && rate[3].abs() < 1.000_001 * turning, "{time}");
            assert!(Vec3::new(now[0], now[1], now[2]).norm() <= displacement);
            fastest = fastest.max(moving);
        }
        assert!(fastest > 0.7 * speed, "{fastest} of {speed}");
        assert_eq!(table.at(0.05)[1], (Vec3::zeros(), 0.0));
        assert_eq!(table.at(0.9)[1], (Vec3::zeros(), 0.0));
    }

    #[test]
    fn between_two_rows_a_table_starts_and_stops_smoothly() {
        let rows = [(1.0, Vec3::zeros(), 0.0), (3.0, Vec3::new(4.0, 0.0, 0.0), 0.0)];
        let table = MotionTable::new(&rows, Vec3::zeros(), Vec3::z());
        // s²(3 − 2 s), up to 3/2 of the mean speed.
        assert_eq!(table.at(1.5)[0].0.x, 4.0 * 0.0625 * 2.5);
        assert_eq!(table.at(2.0)[1].0.x, 3.0);
        assert_eq!(table.bounds()[0], 3.0);
        assert_eq!(table.interval(), [1.0, 3.0]);
    }
}
