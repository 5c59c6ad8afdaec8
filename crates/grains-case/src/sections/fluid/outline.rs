//! The part of a face on which a boundary condition holds.

use super::Fluid;
use crate::check::Checker;
use crate::sections::domain::{Domain, Face};
use grains_fluid::Outline;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A part of a face: a rectangle, a disc or a polygon; the whole face if nothing is stated.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Part {
    /// Lower corner of the rectangle (m); the coordinate normal to the face is not read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lower: Option<[f64; 3]>,
    /// Upper corner of the rectangle (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub upper: Option<[f64; 3]>,
    /// Centre of a disc (m), in place of a rectangle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub center: Option<[f64; 3]>,
    /// Radius of the disc (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: Option<f64>,
    /// Radius of a hole about its centre (m), which makes it an annulus.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub inner_radius: Option<f64>,
    /// Corners of a polygon in order (m), in place of a rectangle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corners: Option<Vec<[f64; 3]>>,
}

/// What a condition asks of its part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wants {
    /// A profile that is a parabola.
    pub parabola: bool,
    /// Cells whose centres it holds.
    pub cells: bool,
}

impl Part {
    /// The part of the face, if it is not the whole.
    pub fn outline(&self) -> Option<Outline> {
        match (self.lower, self.upper, self.center, self.radius, &self.corners) {
            (Some(lower), Some(upper), ..) => Some(Outline::Rectangle { lower, upper }),
            (_, _, Some(center), Some(radius), _) => {
                Some(Outline::Disc { center, radius, inner_radius: self.inner_radius.unwrap_or(0.0) })
            }
            (.., Some(corners)) => Some(Outline::Polygon { corners: corners.clone() }),
            _ => None,
        }
    }

    /// Lower and upper corner (m) about it, if it is not the whole face.
    pub fn patch(&self) -> Option<[[f64; 3]; 2]> {
        Some(match self.outline()? {
            Outline::Rectangle { lower, upper } => [lower, upper],
            Outline::Disc { center, radius, .. } => [center.map(|x| x - radius), center.map(|x| x + radius)],
            Outline::Polygon { corners } => {
                let all = |a: usize| corners.iter().map(move |corner| corner[a]);
                let lower = [0, 1, 2].map(|a| all(a).fold(f64::INFINITY, f64::min));
                [lower, [0, 1, 2].map(|a| all(a).fold(f64::NEG_INFINITY, f64::max))]
            }
        })
    }

    pub(super) fn is_whole(&self) -> bool {
        let Self { lower, upper, center, radius, inner_radius, corners, .. } = self;
        let has_point = lower.is_some() || upper.is_some() || center.is_some();
        !has_point && radius.is_none() && inner_radius.is_none() && corners.is_none()
    }
}

impl Part {
    /// One part is stated, it is one, and it lies on the face; it holds the centre of a cell where that is asked for.
    pub(super) fn check(
        &self,
        face: Face,
        wants: Wants,
        path: &str,
        fluid: &Fluid,
        domain: &Domain,
        checker: &mut Checker,
    ) {
        if self.is_whole() {
            return;
        }
        let Self { lower, upper, center, radius, inner_radius, corners } = self;
        let of_rectangle = [("lower", lower.is_some()), ("upper", upper.is_some())];
        let of_disc = [("center", center.is_some()), ("radius", radius.is_some())];
        let missing = |keys: [(&'static str, bool); 2]| keys.into_iter().find(|(_, given)| !given);
        let mut error = |key: &str, message: String| checker.error(&format!("{path}.{key}"), message);
        let kinds = [
            ("lower", of_rectangle.iter().any(|(_, given)| *given)),
            (
                if center.is_some() {
                    "center"
                } else if radius.is_some() {
                    "radius"
                } else {
                    "inner_radius"
                },
                of_disc.iter().any(|(_, given)| *given) || inner_radius.is_some(),
            ),
            ("corners", corners.is_some()),
        ];
        let mut given = kinds.iter().filter(|(_, given)| *given);
        if let (Some(_), Some((second, _))) = (given.next(), given.next()) {
            let message = "the part of the face is stated twice; keep lower and upper, or center and radius, or corners";
            return error(second, message.into());
        }
        match (kinds[0].1, kinds[1].1) {
            (true, _) => {
                if let Some((key, _)) = missing(of_rectangle) {
                    return error(
                        key,
                        "missing key; a rectangle has both corners, the whole face none".into(),
                    );
                }
            }
            (_, true) => {
                if let Some((key, _)) = missing(of_disc) {
                    return error(
                        key,
                        "missing key; a disc has center and radius, the whole face neither".into(),
                    );
                }
            }
            _ => {}
        }
        let Some(outline) = self.outline() else { return };
        let axis = face.axis();
        let (key, is_rectangle) = match &outline {
            Outline::Rectangle { .. } => ("", true),
            Outline::Disc { inner_radius, .. } => {
                (if *inner_radius > 0.0 { "inner_radius" } else { "radius" }, false)
            }
            Outline::Polygon { .. } => ("corners", false),
        };
        if !is_rectangle && let Some(fault) = outline.fault(axis) {
            return error(key, fault.into());
        }
        if wants.parabola && matches!(outline, Outline::Polygon { .. }) {
            return error(
            "corners",
            "a polygon has no parabola; take a uniform profile, or an inlet with a formula for the velocity"
                .into(),
        );
        }
        self.check_place(face.axis(), wants, path, fluid, domain, checker);
    }

    /// The part lies on the face.
    fn check_place(
        &self,
        axis: usize,
        wants: Wants,
        path: &str,
        fluid: &Fluid,
        domain: &Domain,
        checker: &mut Checker,
    ) {
        let Some([lower, upper]) = self.patch() else { return };
        let [low_key, high_key] = match (self.lower, &self.corners) {
            (Some(_), _) => ["lower", "upper"],
            (_, Some(_)) => ["corners"; 2],
            _ => ["center"; 2],
        };
        let entry = |key: &str, a: usize| {
            if key == "corners" { format!("{path}.{key}") } else { format!("{path}.{key}[{a}]") }
        };
        for a in (0..3).filter(|a| *a != axis) {
            let [low, high] = [domain.lower[a], domain.upper[a]];
            // What is written as the corner of the domain must not be outside by rounding.
            let slack = 1e-9 * (high - low);
            let what = if self.lower.is_some() { "" } else { "reaches " };
            if lower[a] >= upper[a] {
                let message = format!("must be above lower[{a}] = {} m", lower[a]);
                checker.error(&entry(high_key, a), message);
            } else if domain.is_upright() && lower[a] < low - slack {
                checker
                    .error(&entry(low_key, a), format!("{what}outside the domain, which begins at {low} m"));
            } else if domain.is_upright() && upper[a] > high + slack {
                checker
                    .error(&entry(high_key, a), format!("{what}outside the domain, which ends at {high} m"));
            } else if domain.is_upright()
                && wants.cells
                && !fluid.has_centre_in(domain, a, [lower[a], upper[a]])
            {
                let part = if self.lower.is_some() { "rectangle" } else { "part" };
                checker.error(
                &entry(high_key, a),
                format!(
                    "no cell has its centre between {} and {} m; widen the {part} or raise fluid.cells[{a}]",
                    lower[a], upper[a]
                ),
            );
            }
        }
    }
}
