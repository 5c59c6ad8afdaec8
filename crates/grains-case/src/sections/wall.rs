//! `[[wall]]`: boundaries of the particles.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Checker, Names};
use crate::sections::domain::Domain;
use crate::sections::motion::Motion;
use crate::vector::{cross, dot, norm, sub, unit};

/// The side of a closed surface on which the particles are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// A container.
    #[default]
    Inside,
    /// An obstacle.
    Outside,
}

/// The side of a wall on which the fluid is; the other side is solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FluidSide {
    /// Where the particles are: before a plane, and as `side` of a box or a cylinder says.
    Particles,
    /// Inside a closed surface.
    Inside,
    /// Outside a closed surface.
    Outside,
}

/// The form of a wall.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum WallKind {
    /// Infinite plane.
    Plane {
        /// A point of the plane (m).
        point: [f64; 3],
        /// Normal towards the particles (-), of any length.
        normal: [f64; 3],
    },
    /// Rectangular box.
    Box {
        /// Lower corner (m).
        lower: [f64; 3],
        /// Upper corner (m).
        upper: [f64; 3],
        /// Whether particles are inside (a container) or outside (an obstacle).
        #[serde(default)]
        side: Side,
    },
    /// Circular cylinder.
    Cylinder {
        /// Middle of the cylinder (m); any point of the axis if the height is infinite.
        center: [f64; 3],
        /// Direction of the axis (-), of any length.
        axis: [f64; 3],
        /// Radius (m).
        #[schemars(extend("exclusiveMinimum" = 0))]
        radius: f64,
        /// Height (m); infinite by default.
        #[serde(default = "super::infinity")]
        #[schemars(extend("exclusiveMinimum" = 0, "x-infinite" = true))]
        height: f64,
        /// Whether particles are inside (a drum) or outside (a pillar); without effect on an open tube.
        #[serde(default)]
        side: Side,
        /// Whether flat discs close the two ends; without effect on an infinite cylinder. A cylinder of finite height
        /// without them is an open tube, a sheet of no thickness: particles meet its rims and both of its sides.
        #[serde(default = "super::yes")]
        caps: bool,
    },
    /// Frustum of a circular cone. The fluid sees the cone itself; particles see facets whose sections have the same area, from
    /// both sides.
    Cone {
        /// Middle of the cone, on the axis at half of the height (m).
        center: [f64; 3],
        /// Direction of the axis (-), from bottom to top, of any length.
        axis: [f64; 3],
        /// Radius at the bottom (m), or 0.
        #[schemars(extend("minimum" = 0))]
        bottom_radius: f64,
        /// Radius at the top (m), or 0.
        #[schemars(extend("minimum" = 0))]
        top_radius: f64,
        /// Height (m).
        #[schemars(extend("exclusiveMinimum" = 0))]
        height: f64,
        /// Whether the fluid is inside (a hopper) or outside (an obstacle), where `fluid` says "particles".
        #[serde(default)]
        side: Side,
        /// Whether flat discs close the two ends. If not, particles go through them, and the walls of a fluid go on as tubes.
        #[serde(default = "super::yes")]
        caps: bool,
        /// Facets about the axis that particles see (-).
        #[serde(default = "facets")]
        #[schemars(extend("minimum" = 12, "maximum" = 10000))]
        facets: u32,
    },
    /// Surface of revolution: a hopper, a funnel, a cyclone, a ring. The fluid sees the surface itself; particles see facets whose
    /// sections have the same area, from both sides.
    Revolution {
        /// Point of the axis from which heights count (m).
        origin: [f64; 3],
        /// Direction of the axis (-), of any length.
        axis: [f64; 3],
        /// Heights along the axis and radii of the corners of the profile, one after the other (m). A profile that comes back to
        /// its first corner bounds a ring. Otherwise ends with radius 0 are closed; from others the walls of a fluid go on as tubes.
        #[schemars(length(min = 2))]
        profile: Vec<[f64; 2]>,
        /// Whether the fluid is inside or outside, where `fluid` says "particles".
        #[serde(default)]
        side: Side,
        /// Facets about the axis that particles see (-).
        #[serde(default = "facets")]
        #[schemars(extend("minimum" = 12, "maximum" = 10000))]
        facets: u32,
    },
    /// Surface from an STL or OBJ file; particles meet both of its sides.
    Mesh {
        /// STL or OBJ file, relative to the folder of the case file.
        path: PathBuf,
        /// Factor from the file's unit to metres (m per unit): 0.001 for a file in millimetres.
        #[serde(default = "super::one")]
        #[schemars(extend("exclusiveMinimum" = 0))]
        scale: f64,
        /// Translation after scaling (m).
        #[serde(default)]
        translate: [f64; 3],
    },
    /// Flat convex polygons given here; particles meet both of their sides.
    Polygons {
        /// Corners (m).
        #[schemars(length(min = 3))]
        vertices: Vec<[f64; 3]>,
        /// Polygons as lists of indices (-) into `vertices`, from 0, going round.
        #[schemars(schema_with = "polygon_list")]
        faces: Vec<Vec<u64>>,
    },
}

impl WallKind {
    /// The side of a closed surface on which the particles are; none of planes and of surfaces that do not say so.
    pub fn side(&self) -> Option<Side> {
        match self {
            Self::Box { side, .. }
            | Self::Cylinder { side, .. }
            | Self::Cone { side, .. }
            | Self::Revolution { side, .. } => Some(*side),
            Self::Plane { .. } | Self::Mesh { .. } | Self::Polygons { .. } => None,
        }
    }
}

/// Facets of a surface of revolution by default: they depart from it by half a thousandth of its radius.
fn facets() -> u32 {
    96
}

fn polygon_list(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({
        "type": "array", "minItems": 1,
        "items": {"type": "array", "minItems": 3, "items": {"type": "integer", "minimum": 0}}
    })
}

/// Wear of a wall (Archard 1953): the worn volume grows by dV/dt = K Fₙ |v_t| / H at each contact, with the normal force Fₙ that
/// presses on the wall and the sliding velocity v_t.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wear {
    /// Wear coefficient K (-).
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-9, 1]))]
    pub coefficient: f64,
    /// Hardness H of the wall (Pa).
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e5, 1e12]))]
    pub hardness: f64,
}

/// A wall, fixed or moving, present all the time or for a while.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "Wall", extend("unevaluatedProperties" = false))]
pub struct Wall<Name = usize> {
    /// Name, which also heads the columns of its force and torque in the time series.
    pub name: String,
    /// Material, which sets the contact law with each particle material.
    pub material: Name,
    /// Time from which the wall exists (s).
    #[serde(default)]
    pub from: f64,
    /// Time until which the wall exists (s).
    #[serde(default = "super::infinity")]
    #[schemars(extend("x-infinite" = true))]
    pub until: f64,
    /// The form.
    #[serde(flatten)]
    pub kind: WallKind,
    /// Prescribed motion; fixed if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<Motion>,
    /// Wear by the particles that slide on it; not asked for if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wear: Option<Wear>,
    /// Temperature (K), with which heat passes between the wall and particles that touch it; no heat passes if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0, "x-plausible" = [2, 4000]))]
    pub temperature: Option<f64>,
    /// Heat (W) that the wall gives to the particles that touch it, at the one temperature at which it does; this or `temperature`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heating: Option<f64>,
    /// The side on which the fluid is, which the wall bounds; without it the wall is for particles alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fluid: Option<FluidSide>,
    /// Whether the fluid slips along the wall instead of sticking to it, in a flow averaged over particles.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub slip: bool,
}

impl<Name> Wall<Name> {
    /// The same wall with its material named otherwise.
    pub(crate) fn rename<Other>(self, name: impl FnOnce(Name) -> Other) -> Wall<Other> {
        let Self {
            name: label,
            material,
            from,
            until,
            kind,
            motion,
            wear,
            temperature,
            heating,
            fluid,
            slip,
        } = self;
        Wall {
            name: label,
            material: name(material),
            from,
            until,
            kind,
            motion,
            wear,
            temperature,
            heating,
            fluid,
            slip,
        }
    }

    /// Whether it bounds the fluid and is not always there and at rest.
    pub fn moves_fluid(&self) -> bool {
        let is_there = self.from <= 0.0 && self.until == f64::INFINITY;
        self.fluid.is_some() && (self.motion.is_some() || !is_there)
    }

    fn check(&mut self, path: &str, (domain, is_hard): (&Domain, bool), checker: &mut Checker) {
        checker.ordered_times(&format!("{path}.until"), ("from", self.from), self.until);
        if let Some(motion) = &mut self.motion {
            motion.check(&format!("{path}.motion"), checker);
            motion.check_load(&format!("{path}.motion"), (domain, is_hard), checker);
            if let Motion::Rotation { point: None, .. } = motion {
                let message = "missing key; give a point of the axis (m), which a wall needs";
                checker.error(&format!("{path}.motion.point"), message.into());
            }
        }
        if is_hard && self.wear.is_some() {
            let message = "wear is by contact forces, which hard collisions have not; remove it, or take collisions.model = \"soft\"";
            checker.error(&format!("{path}.wear"), message.into());
        }
        match &mut self.kind {
            WallKind::Plane { point, normal } => {
                *normal = checker.direction(&format!("{path}.normal"), *normal);
                let is_behind = |corner: [f64; 3]| dot(sub(corner, *point), *normal) <= 0.0;
                if self.motion.is_none()
                    && norm(*normal) > 0.0
                    && domain.is_upright()
                    && domain.corners().into_iter().all(is_behind)
                {
                    checker.error(
                        &format!("{path}.normal"),
                        "the whole domain lies behind this plane; let the normal point to the particles"
                            .into(),
                    );
                }
            }
            WallKind::Box { lower, upper, .. } => checker.ordered_corners(path, *lower, *upper),
            WallKind::Cylinder { axis, .. } => {
                *axis = checker.direction(&format!("{path}.axis"), *axis);
            }
            WallKind::Cone { axis, bottom_radius, top_radius, .. } => {
                *axis = checker.direction(&format!("{path}.axis"), *axis);
                if bottom_radius.max(*top_radius) <= 0.0 {
                    let message = "one of bottom_radius and top_radius must be above 0";
                    checker.error(&format!("{path}.bottom_radius"), message.into());
                }
            }
            WallKind::Revolution { axis, profile, .. } => {
                *axis = checker.direction(&format!("{path}.axis"), *axis);
                if let Err((corner, message)) = check_profile(profile) {
                    checker.error(&format!("{path}.profile[{corner}]"), message);
                }
            }
            WallKind::Mesh { path: file, .. } => {
                *file = checker.file(&format!("{path}.path"), file, &["stl", "obj"]);
            }
            WallKind::Polygons { vertices, faces } => {
                for (i, face) in faces.iter().enumerate() {
                    if let Err(message) = check_polygon(vertices, face) {
                        checker.error(&format!("{path}.faces[{i}]"), message);
                    }
                }
            }
        }
    }
}

/// Checks the walls and resolves their materials.
pub(crate) fn check(
    raw: Vec<Wall<String>>,
    (domain, is_hard): (&Domain, bool),
    names: &Names,
    checker: &mut Checker,
) -> Vec<Wall> {
    let walls = raw.into_iter().enumerate().map(|(i, mut wall)| {
        wall.check(&format!("wall[{i}]"), (domain, is_hard), checker);
        wall.rename(|name| {
            checker.reference(&format!("wall[{i}].material"), &name, "material", &names.materials)
        })
    });
    walls.collect()
}

/// A profile must keep to one side of the axis, be an open or closed line without crossings, and bound something.
fn check_profile(profile: &[[f64; 2]]) -> Result<(), (usize, String)> {
    let last = profile.len() - 1;
    if let Some(k) = profile.iter().position(|[_, radius]| *radius < 0.0) {
        return Err((k, "the radius must not be below 0".into()));
    }
    if let Some(k) = (1..last).find(|&k| profile[k][1] == 0.0) {
        return Err((k, "only the ends of a profile may lie on the axis; make two walls of it".into()));
    }
    if let Some(k) = (1..=last).find(|&k| profile[k] == profile[k - 1]) {
        return Err((k, "the corner before is the same; name each once".into()));
    }
    let is_ring = profile[0] == profile[last];
    if is_ring && last < 3 {
        return Err((
            last,
            "a ring needs at least three corners, the first of which is named again at the end".into(),
        ));
    }
    if !is_ring && profile[0][0] == profile[last][0] && profile[0][1].max(profile[last][1]) > 0.0 {
        let message = "the profile ends at the height where it starts and bounds nothing; end on the axis (radius 0), or name the first corner again to make a ring";
        return Err((last, message.into()));
    }
    for k in 0..last {
        for m in k + 1..last {
            let joins = m == k + 1 || (is_ring && k == 0 && m == last - 1);
            if !joins && cross_each_other([profile[k], profile[k + 1]], [profile[m], profile[m + 1]]) {
                return Err((
                    m,
                    format!(
                        "the piece from here crosses that from corner {k}; a profile must not cross itself"
                    ),
                ));
            }
        }
    }
    Ok(())
}

/// Whether two segments of a plane have a point in common.
fn cross_each_other([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let turn =
        |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let is_between = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        (0..2).all(|k| p[k].min(q[k]) <= r[k] && r[k] <= p[k].max(q[k]))
    };
    let turns = [turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b)];
    let touches = [(a, b, c), (a, b, d), (c, d, a), (c, d, b)];
    let touches = turns.iter().zip(touches).any(|(turn, (p, q, r))| *turn == 0.0 && is_between(p, q, r));
    touches || (turns[0] * turns[1] < 0.0 && turns[2] * turns[3] < 0.0)
}

/// A polygon must have existing, distinct corners, be flat and be convex.
fn check_polygon(vertices: &[[f64; 3]], face: &[u64]) -> Result<(), String> {
    const FLATNESS: f64 = 1e-6;
    let corner = |index: u64| usize::try_from(index).ok().and_then(|i| vertices.get(i)).copied();
    let mut corners = Vec::with_capacity(face.len());
    for (i, &index) in face.iter().enumerate() {
        let Some(point) = corner(index) else {
            return Err(format!(
                "there is no vertex {index}; vertices are numbered 0 to {}",
                vertices.len() - 1
            ));
        };
        if face[..i].contains(&index) {
            return Err(format!("vertex {index} is named twice; name each corner once, going round"));
        }
        corners.push(point);
    }
    let count = corners.len();
    let edge = |i: usize| sub(corners[(i + 1) % count], corners[i % count]);
    // Twice the area along the normal, whatever the first corners are.
    let doubled_area = (1..count - 1)
        .map(|i| cross(sub(corners[i], corners[0]), sub(corners[i + 1], corners[0])))
        .fold([0.0; 3], |sum, c| [sum[0] + c[0], sum[1] + c[1], sum[2] + c[2]]);
    let size = (0..count).map(|i| norm(edge(i))).fold(0.0, f64::max);
    let Some(normal) = unit(doubled_area).filter(|_| norm(doubled_area) > 1e-12 * size * size) else {
        return Err(
            "the polygon encloses no area: its corners lie on one line or do not go round; reorder them"
                .into(),
        );
    };
    if corners.iter().any(|c| dot(sub(*c, corners[0]), normal).abs() > FLATNESS * size) {
        return Err("the corners do not lie in one plane; split the polygon into triangles".into());
    }
    let is_outside =
        |i: usize, c: [f64; 3]| dot(cross(edge(i), sub(c, corners[i])), normal) < -FLATNESS * size * size;
    if (0..count).any(|i| corners.iter().any(|c| is_outside(i, *c))) {
        return Err("the polygon is not convex or its corners do not go round; split or reorder it".into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_must_be_flat_convex_and_ordered() {
        let corners = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.6, 0.6, 0.0],
            [0.5, 0.0, 0.0],
        ];
        assert_eq!(check_polygon(&corners, &[0, 1, 2, 3]), Ok(()));
        assert_eq!(check_polygon(&corners, &[3, 2, 1, 0]), Ok(()));
        let fails = |face: &[u64], word: &str| {
            let message = check_polygon(&corners, face).expect_err(word);
            assert!(message.contains(word), "{message}");
        };
        fails(&[0, 2, 1, 3], "do not go round");
        fails(&[1, 2, 3, 4], "convex");
        fails(&[0, 1, 9], "no vertex 9");
        fails(&[0, 1, 1], "twice");
        fails(&[0, 5, 1], "no area");
        let mut bent = corners;
        bent[2][2] = 0.01;
        assert!(check_polygon(&bent, &[0, 1, 2, 3]).is_err_and(|m| m.contains("plane")));
    }
}
