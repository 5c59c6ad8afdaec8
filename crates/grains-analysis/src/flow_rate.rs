//! `analyse flow-rate`: number and mass per time through the flow planes of a run, from its time series.

use super::Common;
use super::fit::{least_squares, standard_uncertainties};
use super::picture::{Curve, Picture};
use super::report::{Report, Table, seconds};
use super::series::TimeSeries;
use super::snapshots::StoredRun;
use grains_comm::MpiTransport;
use grains_domain::Transport;
use grains_simulation::{RunError, agreed};

/// Options of `analyse flow-rate`.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Options {
    #[cfg_attr(feature = "clap", command(flatten))]
    /// Which states of which run.
    pub common: Common,
    /// Plane; all of the case if absent.
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    pub plane: Option<String>,
    /// Time over which a rate is taken (s); a fiftieth of the series if absent.
    #[cfg_attr(feature = "clap", arg(long, value_name = "S"))]
    pub window: Option<f64>,
}

/// The rate of what passed a plane over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Rate {
    /// Middles of windows (s) and the rate in each (1/s or kg/s).
    pub over_time: Vec<[f64; 2]>,
    /// Slope and its standard uncertainty of the line of least squares between a tenth and nine tenths of what passed in all.
    pub mean: Option<[f64; 2]>,
}

/// The rate of a running total at some times (s), in windows of at least a length (s).
pub fn measure(times: &[f64], passed: &[f64], window: f64) -> Rate {
    let mut over_time = Vec::new();
    let mut first = 0;
    for k in 0..times.len() {
        // A window ends with the first row that is late enough, so that rounding of times does not double it.
        if k > first && times[k] - times[first] >= (1.0 - 1e-9) * window {
            let rate = (passed[k] - passed[first]) / (times[k] - times[first]);
            over_time.push([0.5 * (times[first] + times[k]), rate]);
            first = k;
        }
    }
    let (begin, end) = (passed.first().copied().unwrap_or(0.0), passed.last().copied().unwrap_or(0.0));
    let share = |value: f64| (value - begin) / (end - begin);
    let steady: Vec<[f64; 2]> = times
        .iter()
        .zip(passed)
        .filter(|&(_, &value)| (0.1..=0.9).contains(&share(value)))
        .map(|(&t, &value)| [t, value])
        .collect();
    let mean = least_squares(&steady).map(|line| [line.slope, standard_uncertainties(&steady, &line)[1]]);
    Rate { over_time, mean }
}

/// The rates through the planes of a run; the report is that of rank 0.
///
/// # Errors
/// A case without the plane, or a series that cannot be read.
pub fn analyse(run: &StoredRun, options: &Options, transport: &MpiTransport) -> Result<Report, RunError> {
    let planes: Vec<&str> = run.case.flow_planes.iter().map(|plane| plane.name.as_str()).collect();
    let chosen: Vec<&str> = match &options.plane {
        None => planes.clone(),
        Some(name) => planes.iter().copied().filter(|plane| plane == name).collect(),
    };
    if chosen.is_empty() {
        let there = if planes.is_empty() { "none".to_string() } else { planes.join(", ") };
        return Err(RunError::case(format!(
            "{}: no such flow plane, the case has {there}: add a [[flow_plane]] to the case and run it again, or choose one with --plane",
            run.path.display()
        )));
    }
    let report = match transport.rank() {
        0 => TimeSeries::read(run).and_then(|series| report(&series, &chosen, options.window)),
        _ => Ok(Report::default()),
    };
    agreed(transport, report)
}

fn report(series: &TimeSeries, planes: &[&str], window: Option<f64>) -> Result<Report, RunError> {
    let times = series.column("time")?;
    let length = times.last().unwrap_or(&0.0) - times.first().unwrap_or(&0.0);
    let window = window.unwrap_or(length / 50.0);
    if !(window > 0.0 && window <= length) {
        return Err(RunError::case(format!(
            "--window {window} s: must be positive and at most the {length} s of the series"
        )));
    }
    let mut table = Table::new(
        "flow-rate",
        "Net number and mass per time through each flow plane, in windows of time.",
        &[("time", "s")],
    );
    let (mut report, mut curves) = (Report::default(), Vec::new());
    for &plane in planes {
        for (what, unit, rate_unit) in [("count", "-", "1/s"), ("mass", "kg", "kg/s")] {
            let passed = series.column(&format!("{plane}_{what}"))?;
            let rate = measure(&times, &passed, window);
            table.columns.push((format!("{plane}_{what}_rate"), rate_unit));
            if table.rows.is_empty() {
                table.rows = rate.over_time.iter().map(|point| vec![point[0]]).collect();
            }
            table.rows.iter_mut().zip(&rate.over_time).for_each(|(row, point)| row.push(point[1]));
            let total = passed.last().unwrap_or(&0.0) - passed.first().unwrap_or(&0.0);
            report.lines.push(match rate.mean {
                Some([mean, uncertainty]) => format!(
                    "{plane}: {mean:.5e} ± {uncertainty:.1e} {rate_unit} between a tenth and nine tenths of the {total} {unit} that passed",
                ),
                None => format!("{plane}: too few rows of the series for a mean rate ({total} {unit} passed)"),
            });
            if what == "mass" {
                curves.push(Curve::line(plane, rate.over_time));
            }
        }
    }
    let title = format!("Mass flow rate, windows of {}", seconds(window));
    report.pictures.push(Picture::new("flow-rate", title, ["time (s)", "mass flow rate (kg/s)"], curves));
    report.tables.push(table);
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::tests::series;

    #[test]
    fn a_silo_that_opens_and_empties_has_the_rate_of_its_steady_flow() {
        // Nothing before 1 s, 2 kg/s until 6 s, nothing after.
        let times: Vec<f64> = (0..=800).map(|k| 0.01 * f64::from(k)).collect();
        let passed: Vec<f64> = times.iter().map(|t| 2.0 * (t - 1.0).clamp(0.0, 5.0)).collect();
        let rate = measure(&times, &passed, 0.5);
        let [mean, uncertainty] = rate.mean.unwrap();
        assert!((mean - 2.0).abs() < 1e-9 && uncertainty < 1e-9, "{mean} ± {uncertainty}");
        assert_eq!(rate.over_time.len(), 16);
        // The windows lose nothing.
        let sum: f64 = rate.over_time.iter().map(|point| 0.5 * point[1]).sum();
        assert!((sum - 10.0).abs() < 1e-9, "{sum}");
        assert_eq!(measure(&times, &vec![3.0; 801], 0.5).mean, None);
    }

    #[test]
    fn every_plane_has_its_columns() {
        let text = "time,a_count,a_mass,b_count,b_mass\n0,0,0,0,0\n1,2,0.2,-1,-0.1\n2,4,0.4,-2,-0.2\n";
        let found = report(&series(text).unwrap(), &["a", "b"], Some(1.0)).unwrap();
        assert_eq!(found.tables[0].rows, [[0.5, 2.0, 0.2, -1.0, -0.1], [1.5, 2.0, 0.2, -1.0, -0.1]]);
        assert_eq!(found.lines.len(), 4);
        assert!(report(&series(text).unwrap(), &["a"], Some(3.0)).unwrap_err().message.contains("--window"));
    }
}
