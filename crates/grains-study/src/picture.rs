//! The picture of a study: every measure over every varied quantity, and for a fit the surfaces and how the best values came about.

use crate::fit::Search;
use crate::fit_report::quantities;
use crate::panel::{Layer, Panel};
use crate::study_file::Study;
use crate::table::{Row, Table};
use plotters::prelude::{IntoDrawingArea, SVGBackend, WHITE};
use toml::Value;

/// Size of a panel (pixels).
const PANEL: (u32, u32) = (400, 300);

/// Values of a list up to which means are drawn.
const MOST_MEANS: usize = 12;

/// The text of the picture; none while no member has a measure.
///
/// # Errors
/// What the drawing library says.
pub(crate) fn draw(study: &Study, table: &Table, search: Option<&Search>) -> Result<Option<String>, String> {
    if table.measures.is_empty() || table.rows.iter().all(|row| row.measures.iter().all(|m| !m.is_finite())) {
        return Ok(None);
    }
    // What has one value alone needs no axis, unless there is nothing else.
    let mut varied: Vec<&String> =
        table.varied.iter().filter(|name| distinct(table, name).len() > 1).collect();
    if varied.is_empty() {
        varied.extend(table.varied.first());
    }
    let mut rows: Vec<Vec<Panel>> = (0..table.measures.len())
        .map(|measure| varied.iter().map(|name| panel(study, table, measure, name, search)).collect())
        .collect();
    rows.extend(search.map(|search| convergence(study, search)));
    let mut text = String::new();
    {
        let size = (PANEL.0 * varied.len() as u32, PANEL.1 * rows.len() as u32);
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        area.fill(&WHITE).map_err(|e| e.to_string())?;
        let places = area.split_evenly((rows.len(), varied.len()));
        for (panel, place) in rows.iter().flatten().zip(&places) {
            panel.draw(place)?;
        }
        area.present().map_err(|e| e.to_string())?;
    }
    Ok(Some(text))
}

/// A measure over a varied quantity.
fn panel(study: &Study, table: &Table, measure: usize, name: &str, search: Option<&Search>) -> Panel {
    let (label, unit) = &table.measures[measure];
    let axis = if unit.is_empty() { label.clone() } else { format!("{label} ({unit})") };
    let words = words_of(table, name);
    let is_log = study.vary[name].log;
    let x = |row: &Row| place(&row.member.values[name], &words);
    let points: Vec<[f64; 2]> = table
        .rows
        .iter()
        .filter(|row| row.measures[measure].is_finite())
        .map(|row| [x(row), row.measures[measure]])
        .collect();
    let mut panel = Panel { axes: [name.into(), axis], is_log, ..Panel::default() };
    if let Some(search) = search {
        panel.layers = fitted(study, label, name, search);
        panel.layers.push(Layer::Points { points, is_light: true });
        return panel;
    }
    let is_list =
        |name: &str| study.vary[name].range().is_none() && distinct(table, name).len() <= MOST_MEANS;
    panel.layers.push(Layer::Points { points, is_light: is_list(name) });
    if is_list(name) {
        let other = table
            .varied
            .iter()
            .find(|other| *other != name && is_list(other) && distinct(table, other).len() <= 7);
        let alone = table.varied.len() == 2;
        let groups: Vec<Option<(&String, Value)>> = match other {
            Some(other) if alone => {
                distinct(table, other).into_iter().map(|value| Some((other, value))).collect()
            }
            _ => vec![None],
        };
        for group in groups {
            let is_in =
                |row: &&Row| group.as_ref().is_none_or(|(other, value)| row.member.values[*other] == *value);
            let label =
                group.as_ref().map_or(String::new(), |(other, value)| format!("{other} = {}", short(value)));
            let members: Vec<&Row> = table.rows.iter().filter(is_in).collect();
            panel.layers.push(Layer::Bars { label, points: means(&members, measure, x) });
        }
    }
    panel.words = words;
    panel
}

/// Means and standard deviations of a measure at each place, in their order.
fn means(rows: &[&Row], measure: usize, x: impl Fn(&Row) -> f64) -> Vec<[f64; 4]> {
    let mut places: Vec<f64> = rows.iter().map(|row| x(row)).filter(|x| x.is_finite()).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    let at = |place: &f64| {
        let here: Vec<f64> = rows
            .iter()
            .filter(|row| x(row) == *place)
            .map(|row| row.measures[measure])
            .filter(|m| m.is_finite())
            .collect();
        let count = here.len() as f64;
        let mean = here.iter().sum::<f64>() / count;
        let variance = here.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
        (count > 0.0).then_some([*place, mean, mean - variance.sqrt(), mean + variance.sqrt()])
    };
    places.iter().filter_map(at).collect()
}

/// Target, best value and the section of the surface through the best values.
fn fitted(study: &Study, measure: &str, name: &str, search: &Search) -> Vec<Layer> {
    let mut layers = Vec::new();
    let Some((_, last)) = search.estimates.last() else { return layers };
    let ranges = study.ranges();
    let Some(axis) = ranges.iter().position(|(other, _)| *other == name) else { return layers };
    let found = &quantities(last, &ranges)[name];
    layers.push(Layer::Place { x: found.value, interval: found.interval_68 });
    if let Some(j) = search.targets.iter().position(|(other, _)| other == measure) {
        let target = search.targets[j].1;
        layers.push(Layer::Level { y: target.value, half: target.uncertainty });
        // The surface says nothing beyond the runs that it was fitted to.
        let [from, to] = last.region[axis];
        let section = (0..=60).map(|k| {
            let mut x = last.best.clone();
            x[axis] = from + (to - from) * f64::from(k) / 60.0;
            let value = ranges[axis].1.at(0.5 * (x[axis] + 1.0));
            let [measure, variance] = last.surfaces[j].value_and_variance(&x);
            [value, measure, 2.0 * variance.sqrt()]
        });
        layers.push(Layer::Band { points: section.collect() });
    }
    layers
}

/// The best values from round to round.
fn convergence(study: &Study, search: &Search) -> Vec<Panel> {
    let ranges = study.ranges();
    let panel = |(name, _): &(&str, crate::study_file::Range)| {
        let point = |(runs, estimate): &(usize, crate::estimate::Estimate)| {
            let q = &quantities(estimate, &ranges)[*name];
            [*runs as f64, q.value, q.interval_68[0], q.interval_68[1]]
        };
        let points = search.estimates.iter().map(point).collect();
        let layers = vec![Layer::Bars { label: String::new(), points }];
        Panel { axes: ["runs".into(), format!("best {name}")], layers, ..Panel::default() }
    };
    ranges.iter().map(panel).collect()
}

/// Values of a quantity, each once, numbers in their order.
fn distinct(table: &Table, name: &str) -> Vec<Value> {
    let mut found: Vec<Value> = Vec::new();
    for row in &table.rows {
        let value = &row.member.values[name];
        if !found.contains(value) {
            found.push(value.clone());
        }
    }
    found.sort_by(|a, b| number(a).total_cmp(&number(b)));
    found
}

/// The values of a quantity as words, if they are no numbers.
fn words_of(table: &Table, name: &str) -> Vec<String> {
    let values = distinct(table, name);
    if values.iter().all(|value| number(value).is_finite()) {
        Vec::new()
    } else {
        values.iter().map(short).collect()
    }
}

/// Where a value stands on its axis.
fn place(value: &Value, words: &[String]) -> f64 {
    if words.is_empty() {
        return number(value);
    }
    let text = short(value);
    words.iter().position(|word| *word == text).map_or(f64::NAN, |i| i as f64)
}

fn number(value: &Value) -> f64 {
    value.as_float().or_else(|| value.as_integer().map(|n| n as f64)).unwrap_or(f64::NAN)
}

/// A value in a few letters.
fn short(value: &Value) -> String {
    let text = value.as_str().map_or_else(|| value.to_string(), String::from);
    if text.chars().count() > 16 { text.chars().take(15).chain(['…']).collect() } else { text }
}
