//! Distributions given by a formula: normal, log-normal and Weibull, weighted with a power of the size and cut at both ends.
//!
//! With that weight none but the log-normal has a closed cumulative distribution, and none a closed quantile. Each is therefore
//! integrated cell by cell over the logarithm y of the size, and its inverse y(Q) interpolated by cubics that have the exact slopes
//! dy/dQ = 1/q.

use grains_case::SizeDistribution;
use std::f64::consts::FRAC_1_SQRT_2;

/// Cells of the table. The tests measure what this leaves of errors.
const CELLS: usize = 4096;

/// Abscissae in [−1, 1] and weights of the integration over a cell (Gauss and Legendre, five points).
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

/// Density below its largest value that no draw meets, as a natural logarithm (-).
const NEGLIGIBLE: f64 = 40.0;

/// A formula as one of y = ln(d/middle).
#[derive(Clone, Copy, Debug)]
struct Law {
    /// Mean of a normal, median of a log-normal, d_63 of a Weibull distribution.
    middle: f64,
    form: Form,
}

#[derive(Clone, Copy, Debug)]
enum Form {
    /// Density exp(−z²/2) over z = (d/mean − 1)/deviation.
    Normal {
        /// Standard deviation over mean.
        deviation: f64,
    },
    /// Density exp(−z²/2) over z = y/deviation.
    LogNormal {
        /// Standard deviation ln σ_g of ln d.
        deviation: f64,
    },
    /// Density exp(−z) over z = exp(exponent y).
    Weibull {
        /// Exponent n.
        exponent: f64,
    },
}

impl Law {
    /// That of a distribution and its cut-offs, if it has a formula.
    fn of(given: &SizeDistribution) -> Option<(Self, [f64; 2])> {
        let (middle, form, cut_offs) = match *given {
            SizeDistribution::Normal { mean, deviation, min, max, .. } => {
                (mean, Form::Normal { deviation: deviation / mean }, [min, max])
            }
            SizeDistribution::LogNormal { median, geometric_deviation, min, max, .. } => {
                (median, Form::LogNormal { deviation: libm::log(geometric_deviation) }, [min, max])
            }
            SizeDistribution::Weibull { characteristic, exponent, min, max, .. } => {
                (characteristic, Form::Weibull { exponent }, [min, max])
            }
            _ => return None,
        };
        Some((Self { middle, form }, cut_offs))
    }

    fn size(self, y: f64) -> f64 {
        self.middle * libm::exp(y)
    }

    fn variable(self, size: f64) -> f64 {
        libm::log(size / self.middle)
    }
}

impl Form {
    /// Logarithm of the density over y times d^power, but for a constant.
    fn log_density(self, y: f64, power: f64) -> f64 {
        let half_square = |z: f64| 0.5 * z * z;
        match self {
            Self::Normal { deviation } => (1.0 + power) * y - half_square(libm::expm1(y) / deviation),
            Self::LogNormal { deviation } => power * y - half_square(y / deviation),
            Self::Weibull { exponent } => (exponent + power) * y - libm::exp(exponent * y),
        }
    }

    /// The part of an interval of y beyond which the density times d^power is negligible.
    fn support(self, [lower, upper]: [f64; 2], power: f64) -> [f64; 2] {
        let [below, above] = match self {
            // Sizes differ by a factor of 10⁶ at most, their third powers by exp(42).
            Self::Normal { deviation } => {
                let reach = deviation * (2.0 * (NEGLIGIBLE + 42.0)).sqrt();
                [if reach < 1.0 { libm::log1p(-reach) } else { lower }, libm::log1p(reach)]
            }
            Self::LogNormal { deviation } => {
                let mode = (power * deviation * deviation).clamp(lower, upper);
                let reach = deviation * (2.0 * NEGLIGIBLE).sqrt();
                [mode - reach, mode + reach]
            }
            // Towards small sizes the density goes with exp(rise y), towards large ones with exp(−exp(n y)).
            Self::Weibull { exponent } => {
                let rise = exponent + power;
                let rises = rise > 0.0;
                let mode =
                    if rises { (libm::log(rise / exponent) / exponent).clamp(lower, upper) } else { lower };
                let reach = if rises { 1.0 / exponent + NEGLIGIBLE / rise } else { 0.0 };
                [mode - reach, mode.max(0.0) + libm::log(2.0 * NEGLIGIBLE) / exponent]
            }
        };
        [lower.max(below), upper.min(above)]
    }

    /// Cumulative distribution without cut-offs.
    fn cumulative(self, y: f64) -> f64 {
        let normal = |z: f64| 0.5 * libm::erfc(-z * FRAC_1_SQRT_2);
        match self {
            Self::Normal { deviation } => normal(libm::expm1(y) / deviation),
            Self::LogNormal { deviation } => normal(y / deviation),
            Self::Weibull { exponent } => -libm::expm1(-libm::exp(exponent * y)),
        }
    }
}

/// Fraction of an uncut distribution between its cut-offs (-), if it has a formula.
pub fn kept(given: &SizeDistribution) -> Option<f64> {
    let (law, cut_offs) = Law::of(given)?;
    let [below, above] = cut_offs.map(|size| law.form.cumulative(law.variable(size)));
    Some(above - below)
}

/// The tabulated inverse of a cumulative distribution.
#[derive(Clone, Debug)]
pub struct Formula {
    law: Law,
    cut_offs: [f64; 2],
    /// The variable at the first node, and width of the cells.
    first: f64,
    width: f64,
    /// Cumulative distribution Q at the nodes (-).
    fractions: Vec<f64>,
    /// dy/dQ at the nodes.
    slopes: Vec<f64>,
    /// Mean size.
    pub mean: f64,
}

impl Formula {
    /// The distribution whose density is that of a formula times size^power, if there is a formula.
    pub fn of(given: &SizeDistribution, power: i32) -> Option<Self> {
        let (law, cut_offs) = Law::of(given)?;
        let power = f64::from(power);
        let [first, last] = law.form.support(cut_offs.map(|size| law.variable(size)), power);
        let width = (last - first) / CELLS as f64;
        let node = |k: usize| first + width * k as f64;
        let highest =
            (0..=CELLS).map(|k| law.form.log_density(node(k), power)).fold(f64::NEG_INFINITY, f64::max);
        let density = |y: f64| libm::exp(law.form.log_density(y, power) - highest);
        let (mut sums, mut moment) = (vec![0.0], 0.0);
        for k in 0..CELLS {
            let mut sum = 0.0;
            for (abscissa, weight) in GAUSS {
                let y = node(k) + 0.5 * width * (1.0 + abscissa);
                let share = 0.5 * width * weight * density(y);
                sum += share;
                moment += share * law.size(y);
            }
            sums.push(sums[k] + sum);
        }
        let total = sums[CELLS];
        Some(Self {
            slopes: (0..=CELLS).map(|k| total / density(node(k))).collect(),
            fractions: sums.into_iter().map(|sum| sum / total).collect(),
            mean: moment / total,
            law,
            cut_offs,
            first,
            width,
        })
    }

    /// The size below which a fraction in [0, 1) is.
    pub fn quantile(&self, fraction: f64) -> f64 {
        let cell = self.fractions[1..CELLS].partition_point(|&end| end <= fraction);
        let step = self.fractions[cell + 1] - self.fractions[cell];
        let t = (fraction - self.fractions[cell]) / step;
        let [begin, end] = [self.slopes[cell], self.slopes[cell + 1]].map(|slope| slope * step / self.width);
        // The cubic of Hermite from 0 to 1, in units of the cell.
        let part = t * t * (3.0 - 2.0 * t) + t * (1.0 - t) * (begin * (1.0 - t) - end * t);
        let y = self.first + self.width * (cell as f64 + part.clamp(0.0, 1.0));
        self.law.size(y).clamp(self.cut_offs[0], self.cut_offs[1])
    }
}
