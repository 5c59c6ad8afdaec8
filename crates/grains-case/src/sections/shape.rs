//! `[[shape]]`: the forms of particles.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::Checker;
use crate::vector::{cross, dot, norm, sub, unit};

/// The five regular polyhedra.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Solid {
    /// 4 triangles.
    Tetrahedron,
    /// 6 squares.
    Cube,
    /// 8 triangles.
    Octahedron,
    /// 12 pentagons.
    Dodecahedron,
    /// 20 triangles.
    Icosahedron,
}

impl Solid {
    /// Inscribed over circumscribed radius (-).
    pub fn inscribed_ratio(self) -> f64 {
        match self {
            Self::Tetrahedron => 1.0 / 3.0,
            Self::Cube | Self::Octahedron => 1.0 / 3.0_f64.sqrt(),
            Self::Dodecahedron | Self::Icosahedron => ((5.0 + 2.0 * 5.0_f64.sqrt()) / 15.0).sqrt(),
        }
    }
}

/// How the latitudes of surface vertices are spaced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum VertexSpacing {
    /// Evenly.
    #[default]
    Linear,
    /// Crowded at the equator, for bodies with flat ends.
    Exponential,
}

/// Vertices on a surface that find its contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfaceVertices {
    /// Longitudes, and as many latitudes (-).
    #[schemars(extend("minimum" = 4, "maximum" = 1000, "x-plausible" = [10, 100]))]
    pub per_direction: u32,
    /// Spacing of the latitudes.
    #[serde(default)]
    pub spacing: VertexSpacing,
}

/// The form of a convex body, in its own frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ShapeKind {
    /// Sphere.
    Sphere {
        /// Radius (m).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-7, 0.5]))]
        radius: f64,
    },
    /// Rectangular box.
    Box {
        /// Full edge lengths along x, y and z (m).
        #[schemars(schema_with = "super::three_lengths")]
        edges: [f64; 3],
    },
    /// Circular cylinder with its axis along z.
    Cylinder {
        /// Radius (m).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-7, 0.5]))]
        radius: f64,
        /// Height (m).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-7, 1]))]
        height: f64,
    },
    /// Regular polyhedron.
    Regular {
        /// Which of the five.
        solid: Solid,
        /// Radius of the circumscribed sphere (m).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-7, 0.5]))]
        circumradius: f64,
    },
    /// Superellipsoid: ellipsoids, boxes and cylinders with rounded edges, octahedra.
    Superellipsoid {
        /// Half of the length along x, y and z (m).
        #[schemars(schema_with = "super::three_lengths")]
        semi_axes: [f64; 3],
        /// Exponents of the meridian and of the x-y section (-): 1 round, towards 0 square, 2 a rhombus.
        #[serde(default = "round")]
        #[schemars(schema_with = "super::two_exponents")]
        eps: [f64; 2],
        /// Finds contacts with others of the kind by vertices of the surface instead of by the distance of the bodies.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        surface_vertices: Option<SurfaceVertices>,
    },
    /// Convex hull of points.
    Hull {
        /// Points (m), not all in one plane.
        #[schemars(length(min = 4))]
        vertices: Vec<[f64; 3]>,
    },
    /// Convex hull of the vertices of an STL or OBJ file.
    HullFile {
        /// STL or OBJ file, relative to the folder of the case file.
        path: PathBuf,
        /// Factor from the file's unit to metres (m per unit): 0.001 for a file in millimetres.
        #[serde(default = "super::one")]
        #[schemars(extend("exclusiveMinimum" = 0))]
        scale: f64,
    },
}

/// A named form with its crust.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(extend("unevaluatedProperties" = false))]
pub struct Shape {
    /// Name by which particles refer to the shape.
    pub name: String,
    /// Thickness of the crust in which contacts are sought (-), as a fraction of the inscribed radius.
    ///
    /// The default is 0.02. Spheres have none: their contacts are computed in closed form.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 0.5))]
    pub crust: Option<f64>,
    /// The form itself.
    #[serde(flatten)]
    pub kind: ShapeKind,
}

impl Shape {
    /// Radius of the largest sphere inside (m), where a closed form gives it.
    pub fn inscribed_radius(&self) -> Option<f64> {
        match &self.kind {
            ShapeKind::Sphere { radius } => Some(*radius),
            ShapeKind::Box { edges } => Some(0.5 * edges.iter().fold(f64::INFINITY, |m, e| m.min(*e))),
            ShapeKind::Cylinder { radius, height } => Some(radius.min(0.5 * height)),
            ShapeKind::Regular { solid, circumradius } => Some(circumradius * solid.inscribed_ratio()),
            ShapeKind::Superellipsoid { semi_axes, eps, .. } => Some(nested_radius(*semi_axes, *eps, -1.0)),
            ShapeKind::Hull { .. } | ShapeKind::HullFile { .. } => None,
        }
    }

    /// Radius of the smallest sphere about the centre that holds the body (m), where a closed form
    /// gives it.
    pub fn bounding_radius(&self) -> Option<f64> {
        match &self.kind {
            ShapeKind::Sphere { radius } => Some(*radius),
            ShapeKind::Box { edges } => Some(0.5 * norm(*edges)),
            ShapeKind::Cylinder { radius, height } => Some(norm([*radius, 0.5 * height])),
            ShapeKind::Regular { circumradius, .. } => Some(*circumradius),
            ShapeKind::Superellipsoid { semi_axes, eps, .. } => Some(nested_radius(*semi_axes, *eps, 1.0)),
            ShapeKind::Hull { .. } | ShapeKind::HullFile { .. } => None,
        }
    }

    /// Largest distance between two points of the body (m), for every shape but one in a file.
    pub(crate) fn diameter(&self) -> Option<f64> {
        match &self.kind {
            ShapeKind::Hull { vertices } => Some(
                (vertices.iter().enumerate())
                    .flat_map(|(i, a)| vertices[..i].iter().map(|b| norm(sub(*a, *b))))
                    .fold(0.0, f64::max),
            ),
            // A tetrahedron has no opposite points: its edge is sqrt(8/3) R.
            ShapeKind::Regular { solid: Solid::Tetrahedron, circumradius } => {
                Some(circumradius * (8.0_f64 / 3.0).sqrt())
            }
            _ => self.bounding_radius().map(|radius| 2.0 * radius),
        }
    }

    /// The key that sets the size, for messages.
    pub(crate) fn size_key(&self) -> &'static str {
        match &self.kind {
            ShapeKind::Sphere { .. } | ShapeKind::Cylinder { .. } => "radius",
            ShapeKind::Box { .. } => "edges",
            ShapeKind::Regular { .. } => "circumradius",
            ShapeKind::Superellipsoid { .. } => "semi_axes",
            ShapeKind::Hull { .. } => "vertices",
            ShapeKind::HullFile { .. } => "scale",
        }
    }

    fn check(&mut self, path: &str, checker: &mut Checker) {
        if let ShapeKind::Sphere { .. } = self.kind {
            if self.crust.is_some() {
                checker.error(
                    &format!("{path}.crust"),
                    "spheres have no crust, their contacts are computed in closed form; remove the key"
                        .into(),
                );
            }
        } else {
            self.crust.get_or_insert(0.02);
        }
        match &mut self.kind {
            ShapeKind::HullFile { path: file, .. } => {
                *file = checker.file(&format!("{path}.path"), file, &["stl", "obj"]);
            }
            ShapeKind::Hull { vertices } if is_flat(vertices) => checker.error(
                &format!("{path}.vertices"),
                "all points lie in one plane, so the hull has no volume; add a point off the plane".into(),
            ),
            _ => {}
        }
    }
}

/// Fills in defaults and checks the shapes.
pub(crate) fn check(mut shapes: Vec<Shape>, checker: &mut Checker) -> Vec<Shape> {
    for (i, shape) in shapes.iter_mut().enumerate() {
        shape.check(&format!("shape[{i}]"), checker);
    }
    shapes
}

fn round() -> [f64; 2] {
    [1.0; 2]
}

/// Largest (`side` = 1) or least (-1) distance (m) of a superellipsoid's surface from its centre.
///
/// The extreme of c X + d Y on X^(1/ε) + Y^(1/ε) = 1, X and Y squares, is (c^s + d^s)^(1/s) with s = 1/(1 − ε) if
/// that has the sign of the side, else at an end.
fn nested_radius([a, b, c]: [f64; 3], [meridian, section]: [f64; 2], side: f64) -> f64 {
    let extreme = |c: f64, d: f64, eps: f64| {
        let s = 1.0 / (1.0 - eps);
        let at_end = if (c > d) == (side > 0.0) { c } else { d };
        let ratio = (c / at_end).min(d / at_end).min((at_end / c).min(at_end / d));
        let is_inside = s.is_finite() && s * side > 0.0;
        if is_inside { at_end * (1.0 + ratio.powf(s.abs())).powf(1.0 / s) } else { at_end }
    };
    extreme(extreme(a * a, b * b, section), c * c, meridian).sqrt()
}

/// Whether points span no volume, relative to their extent.
fn is_flat(points: &[[f64; 3]]) -> bool {
    const TOLERANCE: f64 = 1e-9;
    let farthest = |measure: &dyn Fn([f64; 3]) -> f64| {
        points
            .iter()
            .map(|p| sub(*p, points[0]))
            .fold(([0.0; 3], 0.0), |best, v| if measure(v) > best.1 { (v, measure(v)) } else { best })
    };
    let (first, size) = farthest(&|v| norm(v));
    let Some(along) = unit(first) else { return true };
    let (second, width) = farthest(&|v| norm(cross(along, v)));
    let Some(normal) = unit(cross(along, second)) else { return true };
    let (_, height) = farthest(&|v| dot(normal, v).abs());
    width <= TOLERANCE * size || height <= TOLERANCE * size
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_point_sets_are_recognised_at_any_size() {
        for size in [1e-6, 1.0, 1e6] {
            let flat = [[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 2.0]];
            let flat = flat.map(|p| p.map(|x| x * size));
            assert!(is_flat(&flat));
            let mut solid = flat;
            solid[3][2] += 1e-3 * size;
            assert!(!is_flat(&solid));
        }
        assert!(is_flat(&[[1.0; 3]; 4]));
    }

    #[test]
    fn radii_of_superellipsoids_have_closed_forms() {
        let of = |semi_axes, eps| {
            let kind = ShapeKind::Superellipsoid { semi_axes, eps, surface_vertices: None };
            let shape = Shape { name: String::new(), crust: None, kind };
            (shape.inscribed_radius().unwrap_or(0.0), shape.bounding_radius().unwrap_or(0.0))
        };
        let near = |found: (f64, f64), inner: f64, outer: f64| {
            assert!((found.0 - inner).abs() < 1e-14 && (found.1 - outer).abs() < 1e-14, "{found:?}");
        };
        near(of([1.0, 2.0, 0.5], [1.0, 1.0]), 0.5, 2.0);
        // Octahedron: its face is 1/sqrt(1/a² + 1/b² + 1/c²) away.
        near(of([1.0, 2.0, 0.5], [2.0, 2.0]), 1.0 / 5.25_f64.sqrt(), 2.0);
        // x⁴ + y⁴ + z⁴ = 1 is farthest where all are 3^(-1/4).
        near(of([1.0; 3], [0.5, 0.5]), 1.0, 3.0_f64.powf(0.25));
        // A circular bar, x² + y² = m², m⁴ + z⁴ = 1.
        near(of([1.0; 3], [0.5, 1.0]), 1.0, 2.0_f64.powf(0.25));
    }

    #[test]
    fn radii_of_a_box_and_a_tetrahedron_follow_from_their_edges() {
        let of = |kind| Shape { name: String::new(), crust: None, kind };
        let brick = of(ShapeKind::Box { edges: [3.0, 4.0, 12.0] });
        assert_eq!((brick.inscribed_radius(), brick.bounding_radius()), (Some(1.5), Some(6.5)));
        // Vertices (1,1,1), (1,-1,-1), ... : circumradius sqrt(3), edge sqrt(8).
        let tetrahedron = of(ShapeKind::Regular { solid: Solid::Tetrahedron, circumradius: 3.0_f64.sqrt() });
        assert!((tetrahedron.diameter().unwrap_or(0.0) - 8.0_f64.sqrt()).abs() < 1e-15);
    }
}
