//! `[[shape]]`: the forms of particles.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::Checker;
use crate::sections::composite::{self, GluedPart};
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

/// The form of a body, in its own frame, whose axes are those of the domain where the orientation is "aligned"; where a
/// body is placed, its centre of mass is.
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
    /// Capsule (spherocylinder) with its axis along z: a cylinder with half a sphere on either end.
    Capsule {
        /// Radius (m).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-7, 0.5]))]
        radius: f64,
        /// Length from tip to tip (m), above the diameter.
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-7, 1]))]
        length: f64,
    },
    /// Circular cone with its axis along z, or a frustum.
    Cone {
        /// Radius at the lower end (m).
        #[schemars(extend("minimum" = 0, "x-plausible" = [1e-7, 0.5]))]
        bottom_radius: f64,
        /// Radius at the upper end (m), by default 0: an apex.
        #[serde(default)]
        #[schemars(extend("minimum" = 0))]
        top_radius: f64,
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
    /// Convex bodies glued into one; they may overlap, and must hang together.
    Glued {
        /// The bodies: a kind with its keys, and `at` and `orientation`.
        #[schemars(length(min = 1))]
        parts: Vec<GluedPart>,
    },
    /// Lobed extrudate along z: a cylinder for each lobe, the first one at +x, and the prism through their axes.
    Lobes {
        /// Number of lobes (-): 3 for a trilobe, 4 for a quadralobe.
        #[schemars(extend("minimum" = 3, "maximum" = 100))]
        lobes: u32,
        /// Diameter of the circumscribed cylinder (m).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-7, 1]))]
        diameter: f64,
        /// Length along z (m).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-7, 1]))]
        length: f64,
        /// Cross-section over that of the circumscribed cylinder (-); this or `offset`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
        area_fraction: Option<f64>,
        /// Distance of the lobes' axes from that of the body (m); the lobes' radius is what is left.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("exclusiveMinimum" = 0))]
        offset: Option<f64>,
    },
    /// Square beams along x, y and, for three, z, that share their middle.
    Cross {
        /// Number of beams (-): 2 for a flat cross, 3 for one in space.
        #[schemars(extend("minimum" = 2, "maximum" = 3))]
        beams: u32,
        /// Width of a beam (m); this or `equivalent_diameter`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-7, 1]))]
        beam_width: Option<f64>,
        /// Length of a beam (m); this or `aspect_ratio`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-7, 1]))]
        beam_length: Option<f64>,
        /// Diameter of the sphere of the same volume (m).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-7, 1]))]
        equivalent_diameter: Option<f64>,
        /// Length of a beam over its width (-), by default 5.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("minimum" = 1.01))]
        aspect_ratio: Option<f64>,
    },
    /// Cylinder along z imitated by glued spheres, in layers of concentric rings.
    SphereCylinder {
        /// Radius of the cylinder (m).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-7, 0.5]))]
        radius: f64,
        /// Height of the cylinder (m).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-7, 1]))]
        height: f64,
        /// Number of layers (-).
        #[serde(default = "composite::one_layer")]
        #[schemars(extend("minimum" = 1, "maximum" = 1000))]
        layers: u32,
        /// Spheres in each ring of a layer (-), from the axis outwards: [1, 8] is one on the axis and eight
        /// that touch the side of the cylinder.
        #[schemars(schema_with = "composite::ring_list")]
        rings: Vec<u32>,
        /// Radius of the spheres (m); by default the layers touch each other and both ends.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("exclusiveMinimum" = 0))]
        sphere_radius: Option<f64>,
    },
    /// Cylinder along z cut into like slices: moves as the whole, with a contact for each slice.
    SlicedCylinder {
        /// Radius (m).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-7, 0.5]))]
        radius: f64,
        /// Height of all slices together (m).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-7, 1]))]
        height: f64,
        /// Number of slices (-).
        #[schemars(extend("minimum" = 1, "maximum" = 10000))]
        slices: u32,
    },
    /// Solid of a closed STL or OBJ file, convex or not, cut into convex parts that approximate it.
    ///
    /// Volume, centre of mass and inertia are those of the file. The parts are kept in the user's cache folder.
    Mesh {
        /// STL or OBJ file, relative to the folder of the case file.
        path: PathBuf,
        /// Factor from the file's unit to metres (m per unit): 0.001 for a file in millimetres.
        #[serde(default = "super::one")]
        #[schemars(extend("exclusiveMinimum" = 0))]
        scale: f64,
        /// Largest number of convex parts (-).
        #[serde(default = "composite::sixteen")]
        #[schemars(extend("minimum" = 1, "maximum" = 1024))]
        max_parts: u32,
        /// Voxels along the longest edge of the solid (-), between which it is cut.
        #[serde(default = "composite::sixty_four")]
        #[schemars(extend("minimum" = 16, "maximum" = 400))]
        resolution: u32,
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
    /// The default is 0.02. Spheres and capsules have none: their contacts are those of centres and axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 0.5))]
    pub crust: Option<f64>,
    /// The form itself.
    #[serde(flatten)]
    pub kind: ShapeKind,
}

impl ShapeKind {
    /// Whether the form is made of several convex bodies, or may be.
    pub fn is_composite(&self) -> bool {
        matches!(
            self,
            Self::Glued { .. }
                | Self::Lobes { .. }
                | Self::Cross { .. }
                | Self::SphereCylinder { .. }
                | Self::SlicedCylinder { .. }
                | Self::Mesh { .. }
        )
    }

    /// Radius of the largest sphere inside (m), where a closed form gives it; for composites about the
    /// centre.
    pub fn inscribed_radius(&self) -> Option<f64> {
        match self {
            Self::Sphere { radius } => Some(*radius),
            Self::Box { edges } => Some(0.5 * edges.iter().fold(f64::INFINITY, |m, e| m.min(*e))),
            Self::Cylinder { radius, height } => Some(radius.min(0.5 * height)),
            Self::Capsule { radius, .. } => Some(*radius),
            Self::Cone { bottom_radius, top_radius, height } => {
                let [below, above] = cone_heights([*bottom_radius, *top_radius], *height);
                let slope = (top_radius - bottom_radius) / height;
                let side = (bottom_radius + slope * below) / norm([1.0, slope]);
                Some(below.min(above).min(side))
            }
            Self::Regular { solid, circumradius } => Some(circumradius * solid.inscribed_ratio()),
            Self::Superellipsoid { semi_axes, eps, .. } => Some(nested_radius(*semi_axes, *eps, -1.0)),
            Self::Hull { .. } | Self::HullFile { .. } => None,
            _ => self.composite_inscribed_radius(),
        }
    }

    /// Radius of the smallest sphere about the centre that holds the body (m), where a closed form
    /// gives it.
    pub fn bounding_radius(&self) -> Option<f64> {
        match self {
            Self::Sphere { radius } => Some(*radius),
            Self::Box { edges } => Some(0.5 * norm(*edges)),
            Self::Cylinder { radius, height } => Some(norm([*radius, 0.5 * height])),
            Self::Capsule { length, .. } => Some(0.5 * length),
            Self::Cone { bottom_radius, top_radius, height } => {
                let [below, above] = cone_heights([*bottom_radius, *top_radius], *height);
                Some(norm([*bottom_radius, below]).max(norm([*top_radius, above])))
            }
            Self::Regular { circumradius, .. } => Some(*circumradius),
            Self::Superellipsoid { semi_axes, eps, .. } => Some(nested_radius(*semi_axes, *eps, 1.0)),
            Self::Hull { .. } | Self::HullFile { .. } => None,
            _ => self.composite_bounding_radius(),
        }
    }

    /// Largest distance between two points of the body (m), for every shape but one in a file; for glued
    /// parts a lower bound.
    pub(crate) fn diameter(&self) -> Option<f64> {
        match self {
            Self::Hull { vertices } => Some(
                (vertices.iter().enumerate())
                    .flat_map(|(i, a)| vertices[..i].iter().map(|b| norm(sub(*a, *b))))
                    .fold(0.0, f64::max),
            ),
            // A tetrahedron has no opposite points: its edge is sqrt(8/3) R.
            Self::Regular { solid: Solid::Tetrahedron, circumradius } => {
                Some(circumradius * (8.0_f64 / 3.0).sqrt())
            }
            Self::Cone { bottom_radius, top_radius, height } => Some(
                norm([bottom_radius + top_radius, *height]).max(2.0 * bottom_radius).max(2.0 * top_radius),
            ),
            // Nor has a trilobe: its neck is opposite a lobe.
            Self::Lobes { diameter, length, .. } => Some(diameter.max(*length)),
            Self::Glued { parts } => Some(Self::glued_diameter(parts)),
            _ => self.bounding_radius().map(|radius| 2.0 * radius),
        }
    }

    /// The key that sets the size, for messages.
    pub(crate) fn size_key(&self) -> &'static str {
        match self {
            Self::Sphere { .. }
            | Self::Cylinder { .. }
            | Self::Capsule { .. }
            | Self::SphereCylinder { .. }
            | Self::SlicedCylinder { .. } => "radius",
            Self::Box { .. } => "edges",
            Self::Cone { .. } => "bottom_radius",
            Self::Regular { .. } => "circumradius",
            Self::Superellipsoid { .. } => "semi_axes",
            Self::Hull { .. } => "vertices",
            Self::HullFile { .. } | Self::Mesh { .. } => "scale",
            Self::Glued { .. } => "parts",
            Self::Lobes { .. } => "diameter",
            Self::Cross { beam_width: Some(_), .. } => "beam_width",
            Self::Cross { .. } => "equivalent_diameter",
        }
    }

    /// Fills in defaults and checks the keys of the form.
    pub(crate) fn check(&mut self, path: &str, checker: &mut Checker) {
        match self {
            Self::HullFile { path: file, .. } => {
                *file = checker.file(&format!("{path}.path"), file, &["stl", "obj"]);
            }
            Self::Capsule { radius, length } if *length <= 2.0 * *radius => checker.error(
                &format!("{path}.length"),
                format!("{length} is not above the diameter 2 radius = {}; give the length from tip to tip, or take a sphere", 2.0 * *radius),
            ),
            Self::Cone { bottom_radius, top_radius, .. } if bottom_radius.max(*top_radius) <= 0.0 => checker.error(
                &format!("{path}.bottom_radius"),
                "both radii are zero; give one of them".into(),
            ),
            Self::Hull { vertices } if is_flat(vertices) => checker.error(
                &format!("{path}.vertices"),
                "all points lie in one plane, so the hull has no volume; add a point off the plane".into(),
            ),
            _ => self.check_composite(path, checker),
        }
    }
}

impl Shape {
    /// Radius of the largest sphere inside (m), where a closed form gives it.
    pub fn inscribed_radius(&self) -> Option<f64> {
        self.kind.inscribed_radius()
    }

    /// Radius of the smallest sphere about the centre that holds the body (m), where a closed form
    /// gives it.
    pub fn bounding_radius(&self) -> Option<f64> {
        self.kind.bounding_radius()
    }

    fn check(&mut self, path: &str, checker: &mut Checker) {
        if let ShapeKind::Sphere { .. } | ShapeKind::SphereCylinder { .. } | ShapeKind::Capsule { .. } =
            self.kind
        {
            if self.crust.is_some() {
                checker.error(
                    &format!("{path}.crust"),
                    "spheres and capsules have no crust, their contacts are those of centres and axes; remove the key"
                        .into(),
                );
            }
        } else {
            self.crust.get_or_insert(0.02);
        }
        self.kind.check(path, checker);
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

/// Largest (`side` = 1) or smallest (-1) distance (m) of a superellipsoid's surface from its centre.
///
/// The extreme of c X + d Y on X^(1/ε) + Y^(1/ε) = 1, X and Y squares, is (c^s + d^s)^(1/s) with s = 1/(1 − ε) if
/// that has the sign of the side, else at an end.
fn nested_radius([a, b, c]: [f64; 3], [meridian, section]: [f64; 2], side: f64) -> f64 {
    let extreme = |c: f64, d: f64, eps: f64| {
        let s = 1.0 / (1.0 - eps);
        let at_end = if (c > d) == (side > 0.0) { c } else { d };
        let ratio = (c / at_end).min(d / at_end).min((at_end / c).min(at_end / d));
        let is_inside = s.is_finite() && s * side > 0.0;
        if is_inside { at_end * libm::pow(1.0 + libm::pow(ratio, s.abs()), 1.0 / s) } else { at_end }
    };
    extreme(extreme(a * a, b * b, section), c * c, meridian).sqrt()
}

/// Height of the centre of mass of a cone over its lower end and below its upper one (m).
fn cone_heights([bottom, top]: [f64; 2], height: f64) -> [f64; 2] {
    let squares = bottom * bottom + bottom * top + top * top;
    let below = height / 4.0 * (bottom * bottom + 2.0 * bottom * top + 3.0 * top * top) / squares;
    [below, height - below]
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
    fn radii_of_capsules_and_cones_are_about_their_centres_of_mass() {
        let of = |kind| Shape { name: String::new(), crust: None, kind };
        let capsule = of(ShapeKind::Capsule { radius: 0.5, length: 3.0 });
        assert_eq!((capsule.inscribed_radius(), capsule.bounding_radius()), (Some(0.5), Some(1.5)));
        let cone = |bottom_radius, top_radius, height| {
            let cone = of(ShapeKind::Cone { bottom_radius, top_radius, height });
            (cone.inscribed_radius().unwrap_or(0.0), cone.bounding_radius().unwrap_or(0.0))
        };
        let near = |found: (f64, f64), inner: f64, outer: f64| {
            assert!((found.0 - inner).abs() < 1e-15 && (found.1 - outer).abs() < 1e-15, "{found:?}");
        };
        // The centre of mass is a quarter of the height over the base, the side of a steep cone nearer.
        near(cone(3.0, 0.0, 4.0), 1.0, 10.0_f64.sqrt());
        near(cone(0.0, 3.0, 4.0), 1.0, 10.0_f64.sqrt());
        near(cone(0.75, 0.0, 4.0), 0.5625 / (1.0_f64 + 0.1875 * 0.1875).sqrt(), 3.0);
        near(cone(1.0, 1.0, 4.0), 1.0, 5.0_f64.sqrt());
    }

    #[test]
    fn radii_of_a_box_and_a_tetrahedron_follow_from_their_edges() {
        let of = |kind| Shape { name: String::new(), crust: None, kind };
        let brick = of(ShapeKind::Box { edges: [3.0, 4.0, 12.0] });
        assert_eq!((brick.inscribed_radius(), brick.bounding_radius()), (Some(1.5), Some(6.5)));
        // Vertices (1,1,1), (1,-1,-1), ... : circumradius sqrt(3), edge sqrt(8).
        let tetrahedron = of(ShapeKind::Regular { solid: Solid::Tetrahedron, circumradius: 3.0_f64.sqrt() });
        assert!((tetrahedron.kind.diameter().unwrap_or(0.0) - 8.0_f64.sqrt()).abs() < 1e-15);
    }
}
