//! What a search has found, in numbers.

use crate::design::Values;
use crate::estimate::Estimate;
use crate::fit::{Search, Verdict};
use crate::study_file::{Range, Study, Target};
use crate::sweep::{in_unit, rounded};
use crate::table::Table;
use serde::Serialize;
use std::collections::BTreeMap;

/// A fitted quantity.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Quantity {
    pub value: f64,
    /// Half the width of the middle 68.3 % of its distribution.
    pub uncertainty: f64,
    pub interval_68: [f64; 2],
    pub interval_95: [f64; 2],
    /// Whether the best value is at an end of the range.
    pub is_at_bound: bool,
    /// Whether the measures tell it.
    pub is_identified: bool,
}

/// A measure at the best values.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Met {
    pub value: f64,
    /// Standard uncertainty of the surface.
    pub uncertainty: f64,
    pub target: f64,
    pub target_uncertainty: f64,
    /// Standard deviation of the runs from the surface.
    pub scatter: f64,
    /// Deviation from the target over both uncertainties.
    pub misfit: f64,
    #[serde(skip)]
    unit: String,
}

/// What a search has found.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct FitReport {
    pub program: String,
    pub end: String,
    pub runs: usize,
    pub runs_used: usize,
    pub chi_squared: f64,
    pub quantity: BTreeMap<String, Quantity>,
    pub measure: BTreeMap<String, Met>,
    /// Correlations of pairs of quantities, `a, b`.
    pub correlation: BTreeMap<String, f64>,
    #[serde(skip)]
    others: Vec<Values>,
    #[serde(skip)]
    convergence: Vec<(usize, BTreeMap<String, Quantity>)>,
}

/// The quantities of an estimate, by name.
pub(crate) fn quantities(estimate: &Estimate, ranges: &[(&str, Range)]) -> BTreeMap<String, Quantity> {
    let quantity = |(i, (name, range)): (usize, &(&str, Range))| {
        let value = |x: f64| range.at(0.5 * (x + 1.0));
        let [interval_68, interval_95] = estimate.intervals[i].map(|interval| interval.map(value));
        let quantity = Quantity {
            value: value(estimate.best[i]),
            uncertainty: 0.5 * (interval_68[1] - interval_68[0]),
            interval_68,
            interval_95,
            is_at_bound: estimate.is_at_bound(i),
            is_identified: !estimate.is_unknown(i),
        };
        (name.to_string(), quantity)
    };
    ranges.iter().enumerate().map(quantity).collect()
}

impl FitReport {
    /// That of the last estimate of a search, which must have one.
    pub fn of(study: &Study, search: &Search, verdict: Verdict, table: &Table) -> Self {
        let ranges = study.ranges();
        let (runs, last) = &search.estimates[search.estimates.len() - 1];
        let met = |(j, (name, target)): (usize, &(String, Target))| {
            let surface = &last.surfaces[j];
            let unit =
                table.measures.iter().find(|(other, _)| other == name).map_or(String::new(), |m| m.1.clone());
            let met = Met {
                value: surface.value(&last.best),
                uncertainty: surface.variance(&last.best).sqrt(),
                target: target.value,
                target_uncertainty: target.uncertainty,
                scatter: surface.deviation,
                misfit: last.misfits[j],
                unit,
            };
            (name.clone(), met)
        };
        let pairs = (0..ranges.len()).flat_map(|i| (i + 1..ranges.len()).map(move |j| (i, j)));
        let end = match verdict {
            Verdict::Settled => "the best values stay where they are",
            Verdict::RunsSpent => "max_runs are spent before the best values stay where they are",
            Verdict::GoesOn => "not at its end",
        };
        Self {
            program: String::new(),
            end: end.into(),
            runs: *runs,
            runs_used: last.used,
            chi_squared: last.chi_squared(),
            quantity: quantities(last, &ranges),
            measure: search.targets.iter().enumerate().map(met).collect(),
            correlation: pairs
                .map(|(i, j)| (format!("{}, {}", ranges[i].0, ranges[j].0), last.correlation(i, j)))
                .collect(),
            others: last.others.iter().map(|x| search.values(x)).collect(),
            convergence: search.estimates.iter().map(|(runs, e)| (*runs, quantities(e, &ranges))).collect(),
        }
    }

    /// The best values.
    pub fn values(&self) -> Values {
        self.quantity.iter().map(|(name, q)| (name.clone(), toml::Value::Float(rounded(q.value)))).collect()
    }

    /// What the terminal shows.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!("fit to {} of {} runs: {}", self.runs_used, self.runs, self.end)];
        for (name, q) in &self.quantity {
            let [[a, b], [c, d]] = [q.interval_68, q.interval_95].map(|interval| interval.map(rounded));
            lines.push(format!(
                "{name} = {} ± {} (68 %: {a} to {b}, 95 %: {c} to {d})",
                rounded(q.value),
                digits(q.uncertainty)
            ));
        }
        for (names, correlation) in &self.correlation {
            lines.push(format!("correlation of {names}: {correlation:.2}"));
        }
        for (name, m) in &self.measure {
            lines.push(format!(
                "{name}: {} ± {}{unit} there, target {} ± {}{unit}; runs scatter by {}{unit}",
                rounded(m.value),
                digits(m.uncertainty),
                m.target,
                m.target_uncertainty,
                digits(m.scatter),
                unit = in_unit(&m.unit)
            ));
        }
        lines.extend(self.warnings().into_iter().map(|warning| format!("warning: {warning}")));
        lines
    }

    /// What makes the values doubtful.
    fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        for (name, q) in &self.quantity {
            if !q.is_identified {
                warnings.push(format!("the measures hardly tell {name}: its 68 % take more than half of its range; fix it, or add a measure that depends on it"));
            } else if q.is_at_bound {
                warnings
                    .push(format!("{name} is at an end of its range; widen the range, or doubt the model"));
            }
        }
        for (name, m) in self.measure.iter().filter(|(_, m)| m.misfit.abs() > 3.0) {
            warnings.push(format!(
                "{name} is {:.1} uncertainties off its target: no values within the ranges meet all targets",
                m.misfit.abs()
            ));
        }
        for (names, correlation) in self.correlation.iter().filter(|(_, c)| c.abs() > 0.95) {
            warnings.push(format!("{names} are correlated by {correlation:.2}: the measures tell little but a combination of them"));
        }
        for other in &self.others {
            warnings.push(format!("{} meet the targets as well", crate::member::told(other)));
        }
        warnings
    }

    /// The file `fit.toml`.
    pub fn toml(&self, program: &str) -> String {
        let report = Self { program: program.into(), ..self.clone() };
        // It holds nothing that TOML could not.
        toml::to_string(&report).unwrap_or_default()
    }

    /// The file `fit.csv`: the best values from round to round.
    pub fn csv(&self) -> String {
        let mut text =
            "# what: Best values and the middle 68 % of their distribution, from round to round.\nround,runs"
                .to_string();
        for name in self.quantity.keys() {
            text += &format!(",{name},{name}_lower,{name}_upper");
        }
        for (round, (runs, quantities)) in self.convergence.iter().enumerate() {
            text += &format!("\n{round},{runs}");
            for q in quantities.values() {
                text += &format!(",{:?},{:?},{:?}", q.value, q.interval_68[0], q.interval_68[1]);
            }
        }
        text + "\n"
    }
}

/// An uncertainty, with two digits.
fn digits(number: f64) -> f64 {
    format!("{number:.1e}").parse().unwrap_or(number)
}
