//! One panel of a picture: points, lines with bars and bands over common axes.

use plotters::coord::Shift;
use plotters::prelude::{
    BLACK, ChartBuilder, Circle, DrawingArea, LineSeries, PathElement, Polygon, RGBColor, Rectangle,
    SVGBackend, SeriesLabelPosition, WHITE,
};
use plotters::style::Color;
use std::ops::Range;

/// Colours that remain apart for the colour-blind (Okabe & Ito 2008).
pub(crate) const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
];

/// What is drawn over the axes.
#[derive(Clone, Debug)]
pub(crate) enum Layer {
    /// Dots, light if they lie behind others.
    Points { points: Vec<[f64; 2]>, is_light: bool },
    /// A line through points (x, y, lower and upper end of the bar), with dots.
    Bars { label: String, points: Vec<[f64; 4]> },
    /// A line through points (x, y) with a band from y − w to y + w.
    Band { points: Vec<[f64; 3]> },
    /// A level of y with what it is uncertain by.
    Level { y: f64, half: f64 },
    /// A place of x with the interval about it.
    Place { x: f64, interval: [f64; 2] },
}

/// Axes and what is drawn over them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Panel {
    pub axes: [String; 2],
    /// Whether x is drawn by its logarithm.
    pub is_log: bool,
    /// Words at x = 0, 1, 2 … in place of numbers.
    pub words: Vec<String>,
    pub layers: Vec<Layer>,
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

impl Panel {
    /// Draws the panel.
    ///
    /// # Errors
    /// What the drawing library says.
    pub fn draw(&self, area: &Area<'_>) -> Result<(), String> {
        let refuse = |e: &dyn std::fmt::Display| e.to_string();
        let x = |value: f64| if self.is_log { value.log10() } else { value };
        let [x_range, y_range] = self.ranges();
        let mut chart = ChartBuilder::on(area)
            .margin(10)
            .x_label_area_size(42)
            .y_label_area_size(70)
            .build_cartesian_2d(x_range.clone(), y_range.clone())
            .map_err(|e| refuse(&e))?;
        let x_label = |value: &f64| match (self.words.is_empty(), self.is_log) {
            (false, _) if (value - value.round()).abs() < 1e-6 => usize::try_from(value.round() as i64)
                .ok()
                .and_then(|i| self.words.get(i))
                .cloned()
                .unwrap_or_default(),
            (false, _) => String::new(),
            (true, true) => number(format!("{:.1e}", 10_f64.powf(*value)).parse().unwrap_or(*value)),
            (true, false) => number(*value),
        };
        let mut mesh = chart.configure_mesh();
        mesh.x_desc(&self.axes[0]).y_desc(&self.axes[1]).light_line_style(WHITE).x_labels(6).y_labels(6);
        mesh.x_label_formatter(&x_label).y_label_formatter(&|value| number(*value));
        mesh.label_style(("sans-serif", 12)).axis_desc_style(("sans-serif", 14));
        mesh.draw().map_err(|e| refuse(&e))?;
        let mut colours = COLOURS.iter().cycle();
        let mut has_labels = false;
        for layer in &self.layers {
            match layer {
                Layer::Level { y, half } => {
                    let grey = RGBColor(90, 90, 90);
                    let band = Rectangle::new(
                        [(x_range.start, y - half), (x_range.end, y + half)],
                        grey.mix(0.18).filled(),
                    );
                    chart.draw_series([band]).map_err(|e| refuse(&e))?;
                    let line = vec![(x_range.start, *y), (x_range.end, *y)];
                    chart.draw_series(LineSeries::new(line, grey.stroke_width(1))).map_err(|e| refuse(&e))?;
                }
                Layer::Place { x: at, interval } => {
                    let colour = COLOURS[1];
                    let [from, to] = interval.map(x);
                    let band =
                        Rectangle::new([(from, y_range.start), (to, y_range.end)], colour.mix(0.13).filled());
                    chart.draw_series([band]).map_err(|e| refuse(&e))?;
                    let line = vec![(x(*at), y_range.start), (x(*at), y_range.end)];
                    chart
                        .draw_series(LineSeries::new(line, colour.stroke_width(2)))
                        .map_err(|e| refuse(&e))?;
                }
                Layer::Points { points, is_light } => {
                    let style =
                        if *is_light { COLOURS[6].mix(0.45).filled() } else { COLOURS[0].mix(0.7).filled() };
                    let dot =
                        |p: &[f64; 2]| Circle::new((x(p[0]), p[1]), if *is_light { 2 } else { 3 }, style);
                    chart.draw_series(points.iter().map(dot)).map_err(|e| refuse(&e))?;
                }
                Layer::Band { points } => {
                    let colour = COLOURS[0];
                    let upper = points.iter().map(|p| (x(p[0]), p[1] + p[2]));
                    let lower = points.iter().rev().map(|p| (x(p[0]), p[1] - p[2]));
                    let band = Polygon::new(upper.chain(lower).collect::<Vec<_>>(), colour.mix(0.2));
                    chart.draw_series([band]).map_err(|e| refuse(&e))?;
                    let line = points.iter().map(|p| (x(p[0]), p[1]));
                    chart
                        .draw_series(LineSeries::new(line, colour.stroke_width(2)))
                        .map_err(|e| refuse(&e))?;
                }
                Layer::Bars { label, points } => {
                    let colour = *colours.next().unwrap_or(&BLACK);
                    let line = points.iter().map(|p| (x(p[0]), p[1]));
                    let drawn = chart
                        .draw_series(LineSeries::new(line, colour.stroke_width(2)))
                        .map_err(|e| refuse(&e))?;
                    if !label.is_empty() {
                        has_labels = true;
                        drawn.label(label).legend(move |(x, y)| {
                            PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(3))
                        });
                    }
                    let bar = |p: &[f64; 4]| {
                        PathElement::new([(x(p[0]), p[2]), (x(p[0]), p[3])], colour.stroke_width(1))
                    };
                    chart.draw_series(points.iter().map(bar)).map_err(|e| refuse(&e))?;
                    let dot = |p: &[f64; 4]| Circle::new((x(p[0]), p[1]), 3, colour.filled());
                    chart.draw_series(points.iter().map(dot)).map_err(|e| refuse(&e))?;
                }
            }
        }
        if has_labels {
            let mut labels = chart.configure_series_labels();
            labels.position(SeriesLabelPosition::UpperRight).label_font(("sans-serif", 12));
            labels.background_style(WHITE.mix(0.85)).border_style(BLACK.mix(0.3));
            labels.draw().map_err(|e| refuse(&e))?;
        }
        Ok(())
    }

    /// Ranges of both axes, a little wider than what is drawn.
    fn ranges(&self) -> [Range<f64>; 2] {
        let x = |value: f64| if self.is_log { value.log10() } else { value };
        let mut places: Vec<[f64; 2]> = Vec::new();
        let (mut levels, mut marks) = (Vec::new(), Vec::new());
        for layer in &self.layers {
            match layer {
                Layer::Points { points, .. } => places.extend(points.iter().map(|p| [x(p[0]), p[1]])),
                Layer::Bars { points, .. } => {
                    places.extend(points.iter().flat_map(|p| [1, 2, 3].map(|k| [x(p[0]), p[k]])));
                }
                Layer::Band { points } => {
                    places.extend(
                        points.iter().flat_map(|p| [-1.0, 1.0].map(|side| [x(p[0]), p[1] + side * p[2]])),
                    );
                }
                Layer::Level { y, half } => levels.extend([y - half, y + half]),
                Layer::Place { x: at, interval } => marks.extend([*at, interval[0], interval[1]].map(x)),
            }
        }
        let along = |axis: usize, others: &[f64]| {
            let all = places
                .iter()
                .map(|p| p[axis])
                .chain(others.iter().copied())
                .filter(|value| value.is_finite());
            let (low, high) =
                all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
            let (low, high) = if low > high { (0.0, 1.0) } else { (low, high) };
            let margin = if high > low { 0.06 * (high - low) } else { 0.5 * high.abs().max(1e-3) };
            low - margin..high + margin
        };
        let (across, mut up) = (along(0, &marks), along(1, &levels));
        // Room for the legend, by the number of its lines.
        let labels =
            self.layers.iter().filter(|l| matches!(l, Layer::Bars { label, .. } if !label.is_empty()));
        up.end += (up.end - up.start) * 0.14 * labels.count() as f64;
        [across, up]
    }
}

/// A number at an axis.
fn number(value: f64) -> String {
    let short: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    match short.abs() {
        s if s < 1e-12 => "0".into(),
        s if !(1e-3..1e5).contains(&s) => format!("{short:e}"),
        _ => format!("{short}"),
    }
}
