//! Distributions that are uniform within classes of sizes: a range, the curve of a sieve analysis, a table of single sizes.

/// A cumulative distribution whose density goes with a power of the size within each class.
#[derive(Clone, Debug)]
pub struct Classes {
    /// Limits of each class.
    limits: Vec<[f64; 2]>,
    /// Fraction up to the end of each class (-).
    fractions: Vec<f64>,
    /// Power of the size in the density: 0, −3 or 3.
    power: i32,
    /// Mean size.
    pub mean: f64,
}

impl Classes {
    /// Those of classes (lower limit, upper limit, share) with uniform density, weighted with a power of the size: 0, −3 or 3.
    ///
    /// A class of limits a and b keeps its share times the mean of d^power, ∫ d^power dd/(b − a).
    pub fn of(mut classes: Vec<(f64, f64, f64)>, power: i32) -> Self {
        classes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let unit = classes.iter().map(|class| class.1).fold(0.0, f64::max);
        let weight = |power: i32| {
            move |&(lower, upper, share): &(f64, f64, f64)| {
                share * mean_power(power, lower / unit, upper / unit)
            }
        };
        let total: f64 = classes.iter().map(weight(power)).sum();
        let mut sum = 0.0;
        let fractions = classes.iter().map(weight(power)).map(|weight| {
            sum += weight;
            sum / total
        });
        Self {
            fractions: fractions.collect(),
            limits: classes.iter().map(|&(lower, upper, _)| [lower, upper]).collect(),
            power,
            mean: unit * classes.iter().map(weight(power + 1)).sum::<f64>() / total,
        }
    }

    /// The size below which a fraction in [0, 1) is.
    pub fn quantile(&self, fraction: f64) -> f64 {
        let last = self.limits.len() - 1;
        let class = self.fractions.partition_point(|&end| end <= fraction).min(last);
        let before = if class == 0 { 0.0 } else { self.fractions[class - 1] };
        let part = (fraction - before) / (self.fractions[class] - before);
        within(self.limits[class], self.power, part)
    }
}

/// Mean of d^power over a to b; d^power at a where both are the same.
fn mean_power(power: i32, a: f64, b: f64) -> f64 {
    match power {
        0 => 1.0,
        1 => (a + b) / 2.0,
        3 => (a + b) * (a * a + b * b) / 4.0,
        4 => (a * a * a * (a + b) + a * a * b * b + b * b * b * (a + b)) / 5.0,
        -2 => 1.0 / (a * b),
        -3 => (a + b) / (2.0 * a * a * b * b),
        _ => unreachable!("distributions by number and by mass differ by the third power"),
    }
}

/// The size in a class from a to b below which a part in [0, 1] is, where the density goes with d^power.
fn within([a, b]: [f64; 2], power: i32, part: f64) -> f64 {
    let size = match power {
        // d⁴ is uniform between a⁴ and b⁴.
        3 => {
            let square = (a / b) * (a / b);
            let ratio = square * square;
            b * (ratio + part * (1.0 - ratio)).sqrt().sqrt()
        }
        // d⁻² is uniform between a⁻² and b⁻².
        -3 => a / (1.0 - part * (1.0 - (a / b) * (a / b))).sqrt(),
        _ => a + (b - a) * part,
    };
    size.clamp(a, b)
}
