//! `scale = { kind = ... }` and `diameter = { kind = ... }`: the sizes of particles of one shape.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::Checker;
use crate::diagnostic::rounded;
use crate::sections::sieve;

/// What the fractions of a distribution are fractions of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Basis {
    /// Of the number of particles.
    #[default]
    Number,
    /// Of their mass, as a sieve analysis gives.
    Mass,
}

impl Basis {
    /// Whether fractions are of the number, as where nothing is said.
    fn is_number(&self) -> bool {
        *self == Self::Number
    }
}

/// Sizes of particles and how they are distributed: diameters of spheres (m), or factors on all lengths of a shape (-).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum SizeDistribution {
    /// All particles of one size.
    Constant {
        /// The size (-, or m).
        #[serde(default = "super::one")]
        #[schemars(extend("exclusiveMinimum" = 0))]
        value: f64,
    },
    /// All sizes in a range equally likely.
    Uniform {
        /// Whether the fractions are of the number or of the mass, by default of the number.
        #[serde(default, skip_serializing_if = "Basis::is_number")]
        by: Basis,
        /// Smallest size (-, or m), which decides the time step.
        #[schemars(extend("exclusiveMinimum" = 0))]
        min: f64,
        /// Largest size (-, or m), which decides how far neighbours are looked for.
        #[schemars(extend("exclusiveMinimum" = 0))]
        max: f64,
    },
    /// Normal distribution, cut at both ends.
    Normal {
        /// Whether the fractions are of the number or of the mass, by default of the number.
        #[serde(default, skip_serializing_if = "Basis::is_number")]
        by: Basis,
        /// Mean of the uncut distribution (-, or m).
        #[schemars(extend("exclusiveMinimum" = 0))]
        mean: f64,
        /// Standard deviation of the uncut distribution (-, or m).
        #[schemars(extend("exclusiveMinimum" = 0))]
        deviation: f64,
        /// Smallest size (-, or m), which decides the time step.
        #[schemars(extend("exclusiveMinimum" = 0))]
        min: f64,
        /// Largest size (-, or m), which decides how far neighbours are looked for.
        #[schemars(extend("exclusiveMinimum" = 0))]
        max: f64,
    },
    /// Log-normal distribution, cut at both ends.
    LogNormal {
        /// Whether the fractions are of the number or of the mass.
        by: Basis,
        /// Median d_50 of the uncut distribution (-, or m).
        #[schemars(extend("exclusiveMinimum" = 0))]
        median: f64,
        /// Geometric standard deviation σ_g = d_84.1/d_50 of the uncut distribution (-), above 1.
        #[schemars(extend("exclusiveMinimum" = 1, "x-plausible" = [1.01, 5]))]
        geometric_deviation: f64,
        /// Smallest size (-, or m), which decides the time step.
        #[schemars(extend("exclusiveMinimum" = 0))]
        min: f64,
        /// Largest size (-, or m), which decides how far neighbours are looked for.
        #[schemars(extend("exclusiveMinimum" = 0))]
        max: f64,
    },
    /// Weibull distribution (Rosin, Rammler, Sperling, Bennett), cut at both ends: the fraction Q = 1 − exp(−(d/d_63)^n) is
    /// smaller than d.
    Weibull {
        /// Whether the fractions are of the number or of the mass.
        by: Basis,
        /// Size d_63 below which 63.2 % of the uncut distribution are (-, or m).
        #[schemars(extend("exclusiveMinimum" = 0))]
        characteristic: f64,
        /// Exponent n (-), above 0; the larger, the more alike the sizes.
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [0.5, 20]))]
        exponent: f64,
        /// Smallest size (-, or m), which decides the time step.
        #[schemars(extend("exclusiveMinimum" = 0))]
        min: f64,
        /// Largest size (-, or m), which decides how far neighbours are looked for.
        #[schemars(extend("exclusiveMinimum" = 0))]
        max: f64,
    },
    /// The cumulative curve of a sieve analysis; between its rows the passing fraction is linear in the size.
    Sieve {
        /// Whether the fractions are of the number or of the mass.
        by: Basis,
        /// Rows [size (-, or m), fraction that passes (-)], ascending, from fraction 0 to 1.
        #[serde(default)]
        #[schemars(schema_with = "super::sieve_rows")]
        passing: Vec<[f64; 2]>,
        /// CSV file with a header of the columns `size` (-, or m) and `passing` (-) instead of the rows; relative to the folder of the case file.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        path: Option<PathBuf>,
        /// Smallest size (-, or m), by default that of the curve; what is smaller is left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("exclusiveMinimum" = 0))]
        min: Option<f64>,
        /// Largest size (-, or m), by default that of the curve; what is larger is left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("exclusiveMinimum" = 0))]
        max: Option<f64>,
    },
    /// A few sizes with their shares.
    Table {
        /// Whether the shares are of the number or of the mass, by default of the number.
        #[serde(default, skip_serializing_if = "Basis::is_number")]
        by: Basis,
        /// The sizes (-, or m).
        #[schemars(schema_with = "super::positive_list")]
        values: Vec<f64>,
        /// Share of each size (-), one per value; need not sum to 1.
        #[schemars(schema_with = "super::share_list")]
        shares: Vec<f64>,
    },
}

impl Default for SizeDistribution {
    fn default() -> Self {
        Self::Constant { value: 1.0 }
    }
}

impl SizeDistribution {
    /// What it is called.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Constant { .. } => "constant",
            Self::Uniform { .. } => "uniform",
            Self::Normal { .. } => "normal",
            Self::LogNormal { .. } => "log-normal",
            Self::Weibull { .. } => "Weibull",
            Self::Sieve { .. } => "sieve curve",
            Self::Table { .. } => "table",
        }
    }

    /// What its fractions are fractions of.
    pub fn basis(&self) -> Basis {
        match self {
            Self::Constant { .. } => Basis::Number,
            Self::Uniform { by, .. }
            | Self::Normal { by, .. }
            | Self::LogNormal { by, .. }
            | Self::Weibull { by, .. }
            | Self::Sieve { by, .. }
            | Self::Table { by, .. } => *by,
        }
    }

    /// Smallest size that can occur.
    pub fn smallest(&self) -> f64 {
        self.classes().iter().map(|&(lower, _, _)| lower).fold(f64::INFINITY, f64::min)
    }

    /// Largest size that can occur.
    pub fn largest(&self) -> f64 {
        self.classes().iter().map(|&(_, upper, _)| upper).fold(0.0, f64::max)
    }

    /// Classes of sizes (lower limit, upper limit, share) that are not empty, shares not normalised; one from cut-off to
    /// cut-off for those that have a formula.
    pub fn classes(&self) -> Vec<(f64, f64, f64)> {
        match self {
            Self::Constant { value } => vec![(*value, *value, 1.0)],
            Self::Uniform { min, max, .. }
            | Self::Normal { min, max, .. }
            | Self::LogNormal { min, max, .. }
            | Self::Weibull { min, max, .. } => vec![(*min, *max, 1.0)],
            Self::Sieve { passing, min, max, .. } => sieve::classes(passing, *min, *max),
            Self::Table { values, shares, .. } => {
                let rows = values.iter().zip(shares).filter(|(_, share)| **share > 0.0);
                rows.map(|(value, share)| (*value, *value, *share)).collect()
            }
        }
    }

    /// The same distribution of sizes measured in another unit.
    pub(crate) fn in_units_of(mut self, unit: f64) -> Self {
        let lengths: Vec<&mut f64> = match &mut self {
            Self::Constant { value } => vec![value],
            Self::Uniform { min, max, .. } => vec![min, max],
            Self::Normal { mean, deviation, min, max, .. } => vec![mean, deviation, min, max],
            Self::LogNormal { median: middle, min, max, .. }
            | Self::Weibull { characteristic: middle, min, max, .. } => vec![middle, min, max],
            Self::Sieve { passing, min, max, .. } => {
                passing.iter_mut().map(|[size, _]| size).chain(min).chain(max).collect()
            }
            Self::Table { values, .. } => values.iter_mut().collect(),
        };
        lengths.into_iter().for_each(|length| *length /= unit);
        self
    }

    /// Checks it and reads its file, whose rows take the place of the path.
    pub(crate) fn check(&mut self, path: &str, checker: &mut Checker) {
        let errors = checker.error_count();
        match self {
            Self::Constant { .. } => {}
            Self::Uniform { min, max, .. } => {
                if min > max {
                    checker.error(&format!("{path}.max"), format!("must not be below min = {min}"));
                }
            }
            Self::Normal { mean: middle, min, max, .. } => {
                check_cut_offs((path, "mean"), *middle, [*min, *max], checker);
            }
            Self::LogNormal { median: middle, min, max, .. } => {
                check_cut_offs((path, "median"), *middle, [*min, *max], checker);
            }
            Self::Weibull { characteristic: middle, min, max, .. } => {
                check_cut_offs((path, "characteristic"), *middle, [*min, *max], checker);
            }
            Self::Sieve { passing, path: file, min, max, .. } => {
                sieve::check(path, (passing, file), [*min, *max], checker);
            }
            Self::Table { values, shares, .. } => check_shares(path, (values, shares), checker),
        }
        let (smallest, largest) = (self.smallest(), self.largest());
        if checker.error_count() == errors && largest / smallest > LARGEST_RATIO {
            let message = format!(
                "sizes from {} to {}, beyond a ratio of {LARGEST_RATIO:e}: no run bears that; leave out the smallest",
                rounded(smallest),
                rounded(largest)
            );
            checker.error(path, message);
        }
    }
}

/// Largest over smallest size (-): the particles of one size would outnumber the others by its cube.
const LARGEST_RATIO: f64 = 1e6;

/// Cut-offs on either side of the middle of a distribution.
fn check_cut_offs((path, key): (&str, &str), middle: f64, [min, max]: [f64; 2], checker: &mut Checker) {
    if min >= max {
        checker.error(&format!("{path}.max"), format!("must be above min = {min}"));
    } else if !(min..=max).contains(&middle) {
        let message = format!("outside the cut-offs, min = {min} and max = {max}; move these to either side");
        checker.error(&format!("{path}.{key}"), message);
    }
}

/// One share for each value, not all of them zero.
fn check_shares(path: &str, (values, shares): (&[f64], &[f64]), checker: &mut Checker) {
    if values.len() != shares.len() {
        let (values, shares) = (values.len(), shares.len());
        checker.error(
            &format!("{path}.shares"),
            format!("{shares} shares for {values} values; give one share per value"),
        );
    } else if shares.iter().sum::<f64>() <= 0.0 {
        checker.error(&format!("{path}.shares"), "at least one must be above zero".into());
    }
}
