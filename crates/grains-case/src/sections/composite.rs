//! Keys of shapes that are made of several convex bodies, and what is checked of them.

use std::f64::consts::PI;

use schemars::{JsonSchema, Schema, json_schema};
use serde::{Deserialize, Serialize};

use crate::check::Checker;
use crate::sections::shape::ShapeKind;
use crate::vector::{norm, sub};

/// Length of a beam of a cross over its width where the case does not say (errata R16-24 of Rakotonirina 2016).
const BEAM_RATIO: f64 = 5.0;

/// A convex body of a composite, with its place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(extend("unevaluatedProperties" = false))]
pub struct GluedPart {
    /// Place of the origin of the part's coordinates in those of the shape (m).
    #[serde(default)]
    pub at: [f64; 3],
    /// Quaternion [w, x, y, z] (-), from the part's coordinates to those of the shape.
    #[serde(default = "unturned")]
    pub orientation: [f64; 4],
    /// The form of the part, a convex one.
    #[serde(flatten)]
    pub kind: ShapeKind,
}

fn unturned() -> [f64; 4] {
    [1.0, 0.0, 0.0, 0.0]
}

pub(crate) fn sixteen() -> u32 {
    16
}

pub(crate) fn sixty_four() -> u32 {
    64
}

pub(crate) fn one_layer() -> u32 {
    1
}

/// Schema of a list of numbers of spheres, not empty.
pub(crate) fn ring_list(_: &mut schemars::SchemaGenerator) -> Schema {
    json_schema!({"type": "array", "minItems": 1, "items": {"type": "integer", "minimum": 1, "maximum": 10000}})
}

/// Width and length (m) of the beams of a cross: as given, or so that it has the volume of a sphere of the
/// equivalent diameter, V = w³ (2 q − 1) for two and w³ (3 q − 2) for three beams q times as long as wide.
pub fn beam_size(
    beams: u32,
    beam_width: Option<f64>,
    beam_length: Option<f64>,
    equivalent_diameter: Option<f64>,
    aspect_ratio: Option<f64>,
) -> (f64, f64) {
    let ratio = aspect_ratio.unwrap_or(BEAM_RATIO);
    let cubes = f64::from(beams) * (ratio - 1.0) + 1.0;
    let from_volume = || equivalent_diameter.unwrap_or(f64::NAN) * libm::cbrt(PI / 6.0 / cubes);
    let width = beam_width.unwrap_or_else(from_volume);
    (width, beam_length.unwrap_or(width * ratio))
}

/// Radius of the spheres of an imitated cylinder (m): as given, or so that the layers touch each other
/// and both ends.
pub fn layer_radius(sphere_radius: Option<f64>, height: f64, layers: u32) -> f64 {
    sphere_radius.unwrap_or(0.5 * height / f64::from(layers))
}

impl ShapeKind {
    /// Radius of the smallest sphere about the centre of mass that holds a composite (m), where a closed
    /// form gives it.
    pub(crate) fn composite_bounding_radius(&self) -> Option<f64> {
        match self {
            Self::Lobes { diameter, length, .. } => Some(0.5 * norm([*diameter, *length])),
            Self::SlicedCylinder { radius, height, .. } => Some(norm([*radius, 0.5 * height])),
            Self::Cross { beams, beam_width, beam_length, equivalent_diameter, aspect_ratio } => {
                let (width, length) =
                    beam_size(*beams, *beam_width, *beam_length, *equivalent_diameter, *aspect_ratio);
                Some(0.5 * norm([length, width, width]))
            }
            Self::SphereCylinder { radius, height, layers, sphere_radius, .. } => {
                let sphere = layer_radius(*sphere_radius, *height, *layers);
                let rise = if *layers > 1 { 0.5 * height - sphere } else { 0.0 };
                Some(norm([radius - sphere, rise]) + sphere)
            }
            _ => None,
        }
    }

    /// Radius of a sphere about the centre of mass that lies within a composite (m), where a closed form
    /// gives it.
    pub(crate) fn composite_inscribed_radius(&self) -> Option<f64> {
        match self {
            Self::SlicedCylinder { radius, height, .. } => Some(radius.min(0.5 * height)),
            Self::Cross { beams, beam_width, beam_length, equivalent_diameter, aspect_ratio } => Some(
                0.5 * beam_size(*beams, *beam_width, *beam_length, *equivalent_diameter, *aspect_ratio).0,
            ),
            _ => None,
        }
    }

    /// Largest distance found between two points of glued parts (m): a lower bound of the true one.
    pub(crate) fn glued_diameter(parts: &[GluedPart]) -> f64 {
        let inner = |p: &GluedPart| p.kind.inscribed_radius().unwrap_or(0.0);
        let pairs = parts.iter().enumerate().flat_map(|(i, a)| parts[..i].iter().map(move |b| (a, b)));
        // Only round bodies are sure to be centred on the origin of their coordinates.
        let is_centred =
            |p: &GluedPart| !matches!(p.kind, ShapeKind::Hull { .. } | ShapeKind::HullFile { .. });
        let apart = pairs
            .filter(|(a, b)| is_centred(a) && is_centred(b))
            .map(|(a, b)| norm(sub(a.at, b.at)) + inner(a) + inner(b));
        parts.iter().filter_map(|p| p.kind.diameter()).chain(apart).fold(0.0, f64::max)
    }

    /// Fills in defaults and checks the keys of a composite.
    pub(crate) fn check_composite(&mut self, path: &str, checker: &mut Checker) {
        match self {
            Self::Glued { parts } => {
                for (k, part) in parts.iter_mut().enumerate() {
                    part.check(&format!("{path}.parts[{k}]"), checker);
                }
            }
            Self::Lobes { diameter, area_fraction, offset, .. } => {
                check_lobes(*diameter, *area_fraction, *offset, path, checker);
            }
            Self::Cross { .. } => self.check_cross(path, checker),
            Self::SphereCylinder { radius, height, sphere_radius: Some(sphere), .. } => {
                let room = radius.min(0.5 * *height);
                if *sphere > room {
                    let message =
                        format!("spheres of this radius do not fit the cylinder; at most {room} m do");
                    checker.error(&format!("{path}.sphere_radius"), message);
                }
            }
            Self::Mesh { path: file, .. } => {
                *file = checker.file(&format!("{path}.path"), file, &["stl", "obj"]);
            }
            _ => {}
        }
    }

    fn check_cross(&mut self, path: &str, checker: &mut Checker) {
        let Self::Cross { beam_width, beam_length, equivalent_diameter, aspect_ratio, .. } = self else {
            return;
        };
        match (&beam_width, &equivalent_diameter) {
            (Some(_), None) | (None, Some(_)) => {}
            (None, None) => checker.error(
                &format!("{path}.beam_width"),
                "missing key; give the width of the beams, or `equivalent_diameter`".into(),
            ),
            (Some(_), Some(_)) => checker.error(
                &format!("{path}.equivalent_diameter"),
                "the size follows from beam_width already; remove one of the two".into(),
            ),
        }
        match (*beam_length, *aspect_ratio, *beam_width) {
            (Some(_), Some(_), _) => checker.error(
                &format!("{path}.aspect_ratio"),
                "the length follows from beam_length already; remove one of the two".into(),
            ),
            (Some(_), None, None) => checker.error(
                &format!("{path}.beam_length"),
                "with `equivalent_diameter` the length follows from `aspect_ratio`; give that instead".into(),
            ),
            (Some(length), None, Some(width)) if length <= width => checker.error(
                &format!("{path}.beam_length"),
                format!("must be above beam_width = {width} m; a cross as short as wide is a box"),
            ),
            (Some(_), None, Some(_)) => {}
            (None, ..) => {
                aspect_ratio.get_or_insert(BEAM_RATIO);
            }
        }
    }
}

fn check_lobes(
    diameter: f64,
    area_fraction: Option<f64>,
    offset: Option<f64>,
    path: &str,
    checker: &mut Checker,
) {
    match (area_fraction, offset) {
        (Some(_), None) => {}
        (None, Some(offset)) if offset < 0.5 * diameter => {}
        (None, Some(_)) => checker.error(
            &format!("{path}.offset"),
            format!("must be below the radius, {} m, of the circumscribed circle", 0.5 * diameter),
        ),
        (None, None) => checker.error(
            &format!("{path}.area_fraction"),
            "missing key; give it (0.69 for a trilobe, 0.74 for a quadralobe), or `offset`".into(),
        ),
        (Some(_), Some(_)) => checker.error(
            &format!("{path}.offset"),
            "the lobes' place follows from area_fraction already; remove one of the two".into(),
        ),
    }
}

impl GluedPart {
    fn check(&mut self, path: &str, checker: &mut Checker) {
        self.orientation = checker.direction(&format!("{path}.orientation"), self.orientation);
        if self.kind.is_composite() {
            let message = "not convex; only convex shapes can be glued: list the parts of this one";
            checker.error(&format!("{path}.kind"), message.into());
        } else {
            self.kind.check(path, checker);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crosses_of_a_given_volume_have_the_known_beams() {
        // Equivalent sphere of radius 1.5 mm, beams 4, 5 and 6 times as long as wide; then one of 8 mm.
        let width = |beams, d, q| beam_size(beams, None, None, Some(d), Some(q)).0;
        let known = [(4.0, 1.2640e-3, 1.1223e-3), (5.0, 1.1624e-3, 1.0283e-3), (6.0, 1.0872e-3, 0.95958e-3)];
        for (q, two, three) in known {
            assert!(
                (width(2, 3e-3, q) / two - 1.0).abs() < 5e-5
                    && (width(3, 3e-3, q) / three - 1.0).abs() < 5e-5
            );
        }
        assert!((width(2, 8e-3, 5.0) / 3.0999e-3 - 1.0).abs() < 5e-5);
        let (w, l) = beam_size(3, None, None, Some(8e-3), None);
        assert!((w / 2.7423e-3 - 1.0).abs() < 5e-5 && (l / w - 5.0).abs() < 1e-12);
        assert_eq!(beam_size(2, Some(1.0), Some(3.0), None, None), (1.0, 3.0));
    }

    #[test]
    fn the_ball_about_a_composite_holds_its_corners() {
        let nine = ShapeKind::SphereCylinder {
            radius: 4.0,
            height: 5.3,
            layers: 1,
            rings: vec![1, 8],
            sphere_radius: None,
        };
        assert_eq!(nine.composite_bounding_radius(), Some(4.0));
        let two = ShapeKind::SphereCylinder {
            radius: 4.0,
            height: 8.0,
            layers: 2,
            rings: vec![3],
            sphere_radius: Some(1.0),
        };
        assert!((two.composite_bounding_radius().unwrap_or(0.0) - (18f64.sqrt() + 1.0)).abs() < 1e-14);
        let part = |x: f64| GluedPart {
            at: [x, 0.0, 0.0],
            orientation: unturned(),
            kind: ShapeKind::Sphere { radius: 1.0 },
        };
        assert_eq!(ShapeKind::glued_diameter(&[part(0.0), part(1.5), part(3.0)]), 5.0);
    }
}
