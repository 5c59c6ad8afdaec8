//! Pictures of curves as SVG.

use plotters::coord::Shift;
use plotters::prelude::{
    BLACK, ChartBuilder, Circle, DrawingArea, IntoDrawingArea, LineSeries, PathElement, RGBColor, Rectangle,
    SVGBackend, SeriesLabelPosition, WHITE,
};
use plotters::style::{Color, ShapeStyle};
use std::ops::Range;

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Style {
    /// Straight lines from point to point.
    Line,
    /// Dots.
    Points,
    /// Bars of a width, in the unit of x, that stand on zero.
    Bars(f64),
}

/// A curve of a picture.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Label in the legend; none if empty.
    pub label: String,
    /// Points (x, y); those that are not finite are left out.
    pub points: Vec<[f64; 2]>,
    /// How it is drawn.
    pub style: Style,
}

impl Curve {
    /// A line.
    pub fn line(label: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        Self { label: label.into(), points, style: Style::Line }
    }

    /// Dots.
    pub fn dots(label: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        Self { label: label.into(), points, style: Style::Points }
    }
}

/// Curves over common axes.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Name of the file, without its ending.
    pub name: String,
    /// Title.
    pub title: String,
    /// What x and y are, with units.
    pub axes: [String; 2],
    /// Curves, drawn in this order.
    pub curves: Vec<Curve>,
    /// Whether a length is as long along x as along y, so that angles are true.
    pub is_true_to_scale: bool,
}

impl Picture {
    /// A picture of some curves.
    pub fn new(name: &str, title: impl Into<String>, axes: [&str; 2], curves: Vec<Curve>) -> Self {
        let axes = axes.map(String::from);
        Self { name: name.into(), title: title.into(), axes, curves, is_true_to_scale: false }
    }

    /// A picture of at most as many of the curves as can be told apart, the first and the last among them.
    pub fn few(name: &str, title: impl Into<String>, axes: [&str; 2], curves: Vec<Curve>) -> Self {
        let (all, max) = (curves.len(), COLOURS.len());
        let is_kept = |k: usize| all <= max || (0..max).any(|m| m * (all - 1) / (max - 1) == k);
        let kept = curves.into_iter().enumerate().filter(|(k, _)| is_kept(*k)).map(|(_, curve)| curve);
        let mut picture = Self::new(name, title, axes, kept.collect());
        if let [only] = &mut picture.curves[..] {
            let label = std::mem::take(&mut only.label);
            picture.title += &format!(", t = {label}");
        }
        picture
    }
}

const SIZE: (u32, u32) = (800, 560);
/// Leaves a square between the labels.
const SQUARE: (u32, u32) = (640, 640);
/// Colours that remain apart for the colour-blind (Okabe & Ito 2008).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
];

/// The picture as the text of an SVG file.
///
/// # Errors
/// What the drawing library says.
pub fn draw(picture: &Picture) -> Result<String, String> {
    let mut text = String::new();
    {
        let size = if picture.is_true_to_scale { SQUARE } else { SIZE };
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        let drawn = draw_on(&area, picture).and_then(|()| area.present().map_err(|e| e.to_string()));
        drawn.map_err(|e| format!("{}.svg: cannot be drawn: {e}", picture.name))?;
    }
    Ok(text)
}

fn draw_on(area: &DrawingArea<SVGBackend, Shift>, picture: &Picture) -> Result<(), String> {
    let refuse = |e: &dyn std::fmt::Display| e.to_string();
    area.fill(&WHITE).map_err(|e| refuse(&e))?;
    let [mut x, mut y] = [0, 1].map(|axis| range(picture, axis));
    if picture.is_true_to_scale {
        let half = 0.5 * (x.end - x.start).max(y.end - y.start);
        [x, y] = [x, y].map(|r| 0.5 * (r.start + r.end) - half..0.5 * (r.start + r.end) + half);
    }
    let mut chart = ChartBuilder::on(area)
        .caption(&picture.title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(72)
        .build_cartesian_2d(x, y)
        .map_err(|e| refuse(&e))?;
    let mut mesh = chart.configure_mesh();
    mesh.x_desc(&picture.axes[0]).y_desc(&picture.axes[1]).light_line_style(WHITE);
    mesh.label_style(("sans-serif", 13)).axis_desc_style(("sans-serif", 15));
    mesh.draw().map_err(|e| refuse(&e))?;
    for (k, curve) in picture.curves.iter().enumerate() {
        let colour = COLOURS[k % COLOURS.len()];
        let points: Vec<(f64, f64)> =
            curve.points.iter().filter(|p| p.iter().all(|c| c.is_finite())).map(|p| (p[0], p[1])).collect();
        let drawn = match curve.style {
            Style::Line => chart.draw_series(LineSeries::new(points, colour.stroke_width(2))),
            Style::Points => {
                chart.draw_series(points.into_iter().map(|p| Circle::new(p, 2, colour.filled())))
            }
            Style::Bars(width) => {
                let (half, fill): (f64, ShapeStyle) = (0.5 * width, colour.mix(0.6).filled());
                let bar = move |(x, y): (f64, f64)| Rectangle::new([(x - half, 0.0), (x + half, y)], fill);
                chart.draw_series(points.into_iter().map(bar))
            }
        };
        let drawn = drawn.map_err(|e| refuse(&e))?;
        if !curve.label.is_empty() {
            drawn
                .label(&curve.label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(3)));
        }
    }
    if picture.curves.iter().any(|c| !c.label.is_empty()) {
        let mut labels = chart.configure_series_labels();
        labels.position(SeriesLabelPosition::UpperRight).label_font(("sans-serif", 13));
        labels.background_style(WHITE.mix(0.85)).border_style(BLACK.mix(0.3));
        labels.draw().map_err(|e| refuse(&e))?;
    }
    Ok(())
}

/// Range of the curves along an axis, a little wider than they are.
fn range(picture: &Picture, axis: usize) -> Range<f64> {
    let (mut lower, mut upper) = (f64::INFINITY, f64::NEG_INFINITY);
    for curve in &picture.curves {
        for point in curve.points.iter().filter(|p| p.iter().all(|c| c.is_finite())) {
            let margin = match curve.style {
                Style::Bars(width) if axis == 0 => 0.5 * width,
                _ => 0.0,
            };
            (lower, upper) = (lower.min(point[axis] - margin), upper.max(point[axis] + margin));
            if matches!(curve.style, Style::Bars(_)) && axis == 1 {
                lower = lower.min(0.0);
            }
        }
    }
    if lower > upper {
        return 0.0..1.0;
    }
    let size = lower.abs().max(upper.abs());
    let width = if upper - lower > 1e-12 * size { upper - lower } else { size.max(f64::MIN_POSITIVE) };
    lower - 0.04 * width..upper + 0.04 * width
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_holds_its_texts_and_curves() {
        let line = Curve::line("measured", vec![[0.0, 1.0], [1.0, f64::NAN], [2.0, 3.0]]);
        let bars =
            Curve { label: "bars".into(), points: vec![[0.5, 2.0], [1.5, 1.0]], style: Style::Bars(1.0) };
        let dots = Curve::dots("", vec![[1.0, 1.0]]);
        let picture = Picture::new("p", "Height <m>", ["x (m)", "h (m)"], vec![bars, line, dots]);
        let svg = draw(&picture).unwrap();
        for part in
            ["<svg", "</svg>", "Height &lt;m&gt;", "x (m)", "h (m)", "measured", "<polyline", "<circle"]
        {
            assert!(svg.contains(part), "{part} is missing in {svg}");
        }
        assert!(!svg.contains("NaN"));
    }

    #[test]
    fn empty_and_constant_curves_can_be_drawn() {
        for points in [vec![], vec![[1.0, 0.0]], vec![[0.0, 5.0], [1.0, 5.0]], vec![[1e-9, 1e-300]]] {
            let picture = Picture::new("p", "t", ["x", "y"], vec![Curve::line("", points)]);
            assert!(draw(&picture).unwrap().ends_with("</svg>\n"));
        }
    }
}
