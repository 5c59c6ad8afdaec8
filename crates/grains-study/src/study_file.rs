//! `study.toml`: what is varied, what is measured, how it is run, what is fitted.

use crate::error::StudyError;
use grains_case::{read_text, read_toml, remark};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A study as written in its file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "grains-mpi study file")]
pub struct Study {
    /// Case file, relative to the study.
    pub case: PathBuf,
    /// Folder of the members' folders, the table and the picture; `results/NAME` of the study's name by default.
    pub directory: Option<PathBuf>,
    /// What is varied; the names head columns of the table.
    pub vary: BTreeMap<String, Vary>,
    /// Which combinations are run.
    #[serde(default)]
    pub design: Design,
    /// Numbers that are taken from each run; the names head columns of the table.
    #[serde(default)]
    pub measure: BTreeMap<String, Measure>,
    /// How the runs are started.
    #[serde(default)]
    pub run: Run,
    /// What the varied keys are fitted to.
    pub fit: Option<Fit>,
    /// File and text, for messages.
    #[serde(skip)]
    #[schemars(skip)]
    pub(crate) written: (String, String),
}

/// One varied quantity: a list of values, or a range.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Vary {
    /// Key of the case, such as `contact[bead, wall].friction`.
    pub key: Option<String>,
    /// Keys of the case that all get the value.
    #[serde(default)]
    pub keys: Vec<String>,
    /// Values, as the case would have them.
    #[serde(default)]
    #[schemars(with = "Vec<serde_json::Value>")]
    pub values: Vec<toml::Value>,
    /// Lower end of a range, in the unit of the key.
    pub min: Option<f64>,
    /// Upper end of a range, in the unit of the key.
    pub max: Option<f64>,
    /// Whether the logarithm is spread evenly over the range.
    #[serde(default)]
    pub log: bool,
}

impl Vary {
    /// Addresses of all its keys.
    pub fn addresses(&self) -> impl Iterator<Item = &str> {
        self.key.iter().chain(&self.keys).map(String::as_str)
    }

    /// The range, if it is one.
    pub fn range(&self) -> Option<Range> {
        Some(Range { min: self.min?, max: self.max?, is_log: self.log })
    }
}

/// The range of a varied quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Lower end.
    pub min: f64,
    /// Upper end.
    pub max: f64,
    /// Whether the logarithm is spread evenly.
    pub is_log: bool,
}

impl Range {
    /// The value at a share (0 to 1) of the range.
    pub fn at(&self, share: f64) -> f64 {
        let value = if self.is_log {
            (self.min.ln() + share * (self.max / self.min).ln()).exp()
        } else {
            self.min + share * (self.max - self.min)
        };
        value.clamp(self.min, self.max)
    }

    /// The share of the range at which a value lies.
    pub fn share(&self, value: f64) -> f64 {
        if self.is_log {
            (value / self.min).ln() / (self.max / self.min).ln()
        } else {
            (value - self.min) / (self.max - self.min)
        }
    }
}

/// Which combinations of values are run.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Design {
    /// Points of the Latin hypercube over all ranges (-).
    #[schemars(range(min = 1, max = 100_000))]
    pub samples: Option<usize>,
    /// Seed of the Latin hypercube (-); that of the case is not touched.
    pub seed: u64,
    /// Groups of lists whose values go together, the first with the first.
    pub together: Vec<Vec<String>>,
    /// Table (CSV), relative to the study, whose columns are names of varied quantities without values and whose rows are
    /// their values.
    pub points: Option<PathBuf>,
    /// Runs of every combination, each with the next seed of the case (-).
    #[schemars(range(min = 1, max = 1000))]
    pub repeats: usize,
}

impl Default for Design {
    fn default() -> Self {
        Self { samples: None, seed: 1, together: Vec::new(), points: None, repeats: 1 }
    }
}

/// A number that is taken from a run.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Column of `series.csv`, or of the table of the analysis.
    pub column: Option<String>,
    /// Analysis and its options, as after `grains-mpi analyse`, without the run.
    pub analyse: Option<String>,
    /// Program and its arguments, started in the folder of the run; the last number that it prints is the measure.
    #[serde(default)]
    pub command: Vec<String>,
    /// What is taken of the column.
    #[serde(default)]
    pub take: Take,
    /// Value at which `time-to` is reached, in the unit of the column.
    pub level: Option<f64>,
    /// Time (s) from which rows count; `time-to` is counted from it.
    pub from: Option<f64>,
    /// Time (s) up to which rows count.
    pub to: Option<f64>,
    /// Unit for the table and the picture; that of the column by default.
    pub unit: Option<String>,
}

/// What is taken of a column.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub enum Take {
    /// Its last value.
    #[default]
    Last,
    /// Its first value.
    First,
    /// Mean of the rows.
    Mean,
    /// Largest value.
    Max,
    /// Smallest value.
    Min,
    /// Slope of the line of least squares over time (1/s times the unit of the column).
    Rate,
    /// Time (s) at which it passes `level` for the first time, between rows along straight lines.
    TimeTo,
}

/// How the runs are started.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Run {
    /// Ranks of each run (-).
    #[schemars(range(min = 1))]
    pub ranks: usize,
    /// Runs side by side (-); as many as the machine has cores for by default.
    #[schemars(range(min = 1))]
    pub jobs: Option<usize>,
    /// What stays of a finished run.
    pub keep: Keep,
    /// Wall-clock time (min) after which a run writes a checkpoint and leaves, to be continued by the next call.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub minutes: Option<f64>,
}

impl Default for Run {
    fn default() -> Self {
        Self { ranks: 1, jobs: None, keep: Keep::All, minutes: None }
    }
}

/// What stays of a finished run.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub enum Keep {
    /// All files.
    All,
    /// Tables and logs; snapshots and checkpoints are removed once all measures have been taken.
    Series,
}

/// What the varied quantities are fitted to.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fit {
    /// Measured values, by the names of measures.
    pub target: BTreeMap<String, Target>,
    /// Runs after which the search ends at the latest, repeats included (-).
    #[schemars(range(min = 1, max = 100_000))]
    pub max_runs: usize,
}

/// A measured value.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// The value, in the unit of the measure.
    pub value: f64,
    /// Its standard uncertainty, in the same unit.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub uncertainty: f64,
}

impl Study {
    /// Reads and checks a study.
    ///
    /// # Errors
    /// What is wrong with the file, or why it cannot be read.
    pub fn load(path: &Path) -> Result<Self, StudyError> {
        let text = read_text(path)
            .map_err(|error| StudyError::of_file(path, format!("cannot read the study: {error}")))?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Checks the text of a study; `file` is its name.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str, file: &str) -> Result<Self, StudyError> {
        crate::study_check::check_kind(text, file)?;
        let read: Self = read_toml(text, file)?;
        let study = Self { written: (file.into(), text.into()), ..read };
        crate::study_check::check(&study)?;
        Ok(study)
    }

    /// An error about a key of the study.
    pub(crate) fn error(&self, key: &str, message: impl Into<String>) -> StudyError {
        remark(&self.written.1, &self.written.0, key, message.into()).into()
    }

    /// A remark about a key of the study, with file, line and value.
    pub fn about(&self, key: &str, message: impl Into<String>) -> String {
        self.error(key, message).to_string()
    }

    /// Name of the study: that of its file.
    pub fn name(&self) -> String {
        Path::new(&self.written.0).file_stem().map_or("study".into(), |stem| stem.to_string_lossy().into())
    }

    /// Folder to which paths in the study refer.
    pub(crate) fn base(&self) -> &Path {
        Path::new(&self.written.0).parent().unwrap_or(Path::new(""))
    }

    /// Folder of the results.
    pub fn directory(&self) -> PathBuf {
        self.directory.clone().unwrap_or_else(|| Path::new("results").join(self.name()))
    }

    /// Number of members that it begins with.
    ///
    /// # Errors
    /// A table of points that does not fit the study, or more members than any machine runs.
    pub fn members(&self) -> Result<usize, StudyError> {
        crate::design::count(self)
    }

    /// Varied quantities with a range, in the order of their names.
    pub fn ranges(&self) -> Vec<(&str, Range)> {
        self.vary.iter().filter_map(|(name, vary)| Some((name.as_str(), vary.range()?))).collect()
    }
}
