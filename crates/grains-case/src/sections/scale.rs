//! `scale = { kind = ... }`: the size distribution of particles of one shape.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::Checker;

/// Distribution, by number, of the factor that multiplies the lengths of a shape (-).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Scale {
    /// All particles of one size.
    Constant {
        /// The factor (-).
        #[serde(default = "super::one")]
        #[schemars(extend("exclusiveMinimum" = 0))]
        value: f64,
    },
    /// All factors in a range equally likely.
    Uniform {
        /// Smallest factor (-).
        #[schemars(extend("exclusiveMinimum" = 0))]
        min: f64,
        /// Largest factor (-).
        #[schemars(extend("exclusiveMinimum" = 0))]
        max: f64,
    },
    /// Normal distribution, cut at both ends.
    Normal {
        /// Mean of the uncut distribution (-).
        #[schemars(extend("exclusiveMinimum" = 0))]
        mean: f64,
        /// Standard deviation of the uncut distribution (-).
        #[schemars(extend("exclusiveMinimum" = 0))]
        deviation: f64,
        /// Smallest factor (-).
        #[schemars(extend("exclusiveMinimum" = 0))]
        min: f64,
        /// Largest factor (-).
        #[schemars(extend("exclusiveMinimum" = 0))]
        max: f64,
    },
    /// A few factors with their shares.
    Table {
        /// The factors (-).
        #[schemars(schema_with = "super::positive_list")]
        values: Vec<f64>,
        /// Share by number of each factor (-), one per value; need not sum to 1.
        #[schemars(schema_with = "super::share_list")]
        shares: Vec<f64>,
    },
}

impl Default for Scale {
    fn default() -> Self {
        Self::Constant { value: 1.0 }
    }
}

impl Scale {
    /// Smallest factor that can occur (-).
    pub fn smallest(&self) -> f64 {
        match self {
            Self::Constant { value } => *value,
            Self::Uniform { min, .. } | Self::Normal { min, .. } => *min,
            Self::Table { .. } => self.drawn().fold(f64::INFINITY, f64::min),
        }
    }

    /// Largest factor that can occur (-).
    pub fn largest(&self) -> f64 {
        match self {
            Self::Constant { value } => *value,
            Self::Uniform { max, .. } | Self::Normal { max, .. } => *max,
            Self::Table { .. } => self.drawn().fold(0.0, f64::max),
        }
    }

    /// The table's values of share above zero.
    fn drawn(&self) -> impl Iterator<Item = f64> {
        let (values, shares): (&[f64], &[f64]) = match self {
            Self::Table { values, shares } => (values, shares),
            _ => (&[], &[]),
        };
        values.iter().zip(shares).filter(|(_, share)| **share > 0.0).map(|(value, _)| *value)
    }

    pub(crate) fn check(&self, path: &str, checker: &mut Checker) {
        match self {
            Self::Constant { .. } => {}
            Self::Uniform { min, max } => {
                if min > max {
                    checker.error(&format!("{path}.max"), format!("must not be below min = {min}"));
                }
            }
            Self::Normal { mean, deviation, min, max } => {
                if min >= max {
                    checker.error(&format!("{path}.max"), format!("must be above min = {min}"));
                } else if mean + 3.0 * deviation < *min || mean - 3.0 * deviation > *max {
                    // Values are drawn again until one falls inside, which would go on for ever.
                    checker.error(
                        &format!("{path}.mean"),
                        format!("hardly a value would fall in [{min}, {max}]; move the limits to the mean"),
                    );
                }
            }
            Self::Table { values, shares } => {
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
        }
    }
}
