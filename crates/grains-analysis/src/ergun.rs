//! `analyse ergun`: the coefficients of Ergun's equation from the beds of several runs (Rakotonirina 2016, eq. 7.23).
//!
//! ```text
//! f = (Δp/H) ε³ d_p² / ((1 − ε)² μ u) = α + β Re',   Re' = ρ u d_p/((1 − ε) μ)
//! ```

use super::Common;
use super::bed::{self, Bed, ControlVolume};
use super::fit::{least_squares, mean_and_sample_deviation, standard_uncertainties};
use super::picture::{Curve, Picture};
use super::report::{Report, Table};
use super::snapshots::StoredRun;
use grains_comm::{Job, MpiTransport};
use grains_simulation::RunError;
use std::path::PathBuf;

/// Options of `analyse ergun`.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Which states of which run.
    pub common: Common,
    /// Output directories of further runs.
    #[cfg_attr(feature = "clap", arg(value_name = "RUN"))]
    pub others: Vec<PathBuf>,
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Part of the bed that counts.
    pub volume: ControlVolume,
}

/// Fewest runs that β is fitted to.
const FEWEST_RUNS: usize = 3;
/// Smallest ratio of their largest to their smallest Re'.
const MIN_RATIO: f64 = 2.0;

/// The coefficients of Ergun's equation.
#[derive(Clone, Debug, PartialEq)]
pub struct Coefficients {
    /// α and its standard uncertainty (-); without β the mean of f and the standard deviation of the mean.
    pub alpha: [f64; 2],
    /// β and its standard uncertainty (-), or why it is not fitted.
    pub beta: Result<[f64; 2], String>,
    /// Sample standard deviation of f about α + β Re', or about the mean (-).
    pub deviation: f64,
}

/// The coefficients that fit points (Re', f).
pub fn fitted(points: &[[f64; 2]]) -> Coefficients {
    let extreme = |of: fn(f64, f64) -> f64, start: f64| points.iter().map(|p| p[0]).fold(start, of);
    let [min, max] = [extreme(f64::min, f64::INFINITY), extreme(f64::max, 0.0)];
    let reason = match least_squares(points) {
        _ if points.len() < FEWEST_RUNS => format!("that takes {FEWEST_RUNS} runs or more"),
        Some(line) if max >= MIN_RATIO * min => {
            let [of_alpha, of_beta] = standard_uncertainties(points, &line);
            let rest: f64 = points.iter().map(|p| (p[1] - line.intercept - line.slope * p[0]).powi(2)).sum();
            return Coefficients {
                alpha: [line.intercept, of_alpha],
                beta: Ok([line.slope, of_beta]),
                deviation: (rest / (points.len() as f64 - 2.0)).sqrt(),
            };
        }
        _ => format!("the largest Re' {max:.3e} is less than twice the smallest, {min:.3e}"),
    };
    let f: Vec<f64> = points.iter().map(|p| p[1]).collect();
    let [mean, deviation] = mean_and_sample_deviation(&f);
    Coefficients { alpha: [mean, deviation / (f.len() as f64).sqrt()], beta: Err(reason), deviation }
}

impl Coefficients {
    /// α + β Re' at a Re'.
    fn at(&self, reynolds: f64) -> f64 {
        self.alpha[0] + self.beta.as_ref().map_or(0.0, |beta| beta[0]) * reynolds
    }

    /// What was found, in a sentence.
    fn sentence(&self, runs: usize) -> String {
        let ([alpha, uncertainty], deviation) = (self.alpha, self.deviation);
        match &self.beta {
            Ok([beta, of_beta]) => format!(
                "{runs} runs: alpha = {alpha:.3} ± {uncertainty:.2}, beta = {beta:.4} ± {of_beta:.3} (standard uncertainties), deviation from the line {deviation:.2}"
            ),
            Err(reason) if runs > 1 => format!(
                "{runs} runs: alpha = {alpha:.3}, standard deviation {deviation:.2}; 2 sigma {:.2} of the mean, {:.2} of a packing; beta is not fitted: {reason}",
                2.0 * uncertainty,
                2.0 * deviation
            ),
            Err(reason) => format!("1 run: alpha = {alpha:.3}; beta is not fitted: {reason}"),
        }
    }
}

/// The bed of the last of the chosen states of a run, and where it comes from.
fn last_bed(
    run: &StoredRun,
    states: &[usize],
    volume: &ControlVolume,
    transport: &MpiTransport,
) -> Result<Vec<(String, Bed)>, RunError> {
    let last = &states[states.len().saturating_sub(1)..];
    let beds = bed::of_run(run, last, volume, ("ergun", transport))?;
    Ok(beds.into_iter().map(|bed| (run.path.display().to_string(), bed)).collect())
}

/// The last of the chosen states of each run, and the coefficients that fit them.
///
/// # Errors
/// A run that cannot be opened or is of another kind, or options that do not fit.
pub fn analyse(
    (first, states): (&StoredRun, &[usize]),
    options: &Options,
    job: &Job,
) -> Result<Report, RunError> {
    let transport = job.transport();
    let mut beds = last_bed(first, states, &options.volume, transport)?;
    for run in &options.others {
        let run = StoredRun::open(run, options.common.case.as_deref(), job)?;
        let states = run.select(options.common.time)?;
        beds.extend(last_bed(&run, &states, &options.volume, transport)?);
    }
    Ok(report(&beds))
}

fn report(beds: &[(String, Bed)]) -> Report {
    let mut what = "Flow through the bed of each run, columns as those of bed.csv; alpha is f = (dp/H) eps^3 d^2/((1 - eps)^2 mu u).".to_string();
    let mut report = Report::default();
    for (k, (path, bed)) in beds.iter().enumerate() {
        what += &format!("\nrun {}: {path}", k + 1);
        report.lines.push(format!(
            "{path}: void fraction {:.5}, Re' = {:.4e}, f = {:.3}",
            bed.void_fraction,
            bed.ergun_reynolds(),
            bed.alpha
        ));
    }
    let mut table = Table::new("ergun", &what, &[&[("run", "-")], &bed::COLUMNS[..]].concat());
    for (k, (_, bed)) in beds.iter().enumerate() {
        table.push([vec![(k + 1) as f64], bed.row()].concat());
    }
    let points: Vec<[f64; 2]> = beds.iter().map(|(_, bed)| [bed.ergun_reynolds(), bed.alpha]).collect();
    let found = fitted(&points);
    let mut fit = Table::new(
        "ergun-fit",
        "f = alpha + beta Re' with standard uncertainties, and the sample standard deviation of f about it; without beta, alpha is the mean of f.",
        &[
            ("runs", "-"),
            ("alpha", "-"),
            ("alpha_uncertainty", "-"),
            ("beta", "-"),
            ("beta_uncertainty", "-"),
            ("deviation", "-"),
        ],
    );
    let beta = found.beta.as_ref().map_or([f64::NAN; 2], |beta| *beta);
    fit.push([&[beds.len() as f64], &found.alpha[..], &beta, &[found.deviation]].concat());
    let max = points.iter().map(|p| p[0]).fold(0.0, f64::max);
    let line = [0.0, max].map(|reynolds| [reynolds, found.at(reynolds)]).to_vec();
    let curves = vec![Curve::line("alpha + beta Re'", line), Curve::dots("runs", points)];
    report.pictures.push(Picture::new(
        "ergun",
        "Coefficient of Ergun's equation",
        ["Re' (-)", "f (-)"],
        curves,
    ));
    report.tables.extend([table, fit]);
    report.lines.push(found.sentence(beds.len()));
    report
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_coefficients_are_found_without_noise() {
        let points = [0.1, 1.0, 10.0, 25.0].map(|x| [x, 150.0 + 1.75 * x]);
        let found = fitted(&points);
        let [beta, of_beta] = found.beta.clone().unwrap();
        assert!((found.alpha[0] - 150.0).abs() < 1e-9 && (beta - 1.75).abs() < 1e-10, "{found:?}");
        assert!(found.alpha[1] < 1e-9 && of_beta < 1e-9 && found.deviation < 1e-9, "{found:?}");
        assert!(found.sentence(4).contains("beta = 1.7500"));
    }

    #[test]
    fn beta_is_left_out_where_the_runs_do_not_tell_it() {
        // α of the ten beds of trilobes of table 7.3 of the thesis: 6.28 % of the mean 209.12.
        let alphas = [212.55, 205.16, 211.85, 216.87, 204.37, 184.36, 190.90, 223.58, 218.56, 223.00];
        let points: Vec<[f64; 2]> =
            alphas.iter().enumerate().map(|(k, &f)| [1.0 + 0.1 * k as f64, f]).collect();
        let found = fitted(&points);
        assert!(found.beta.clone().is_err_and(|reason| reason.contains("twice")));
        assert!((found.alpha[0] - 209.12).abs() < 5e-3, "{found:?}");
        assert!((found.deviation / found.alpha[0] - 0.0628).abs() < 1e-4, "{found:?}");
        assert!((found.alpha[1] - found.deviation / 10f64.sqrt()).abs() < 1e-12);
        let two = fitted(&[[1.0, 100.0], [10.0, 120.0]]);
        assert!(two.beta.is_err_and(|reason| reason.contains("3 runs")) && two.alpha[0] == 110.0);
        assert!(fitted(&[[1.0, 100.0]]).sentence(1).contains("1 run"));
    }
}
