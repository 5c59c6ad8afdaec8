//! The parts of a shape as they are with sharp edges, which core and crust only imply.

use crate::CouplingError;
use crate::shape_factors::facets::Facets;
use grains_geometry::{Cone, ConvexHull, Core, Part, Superellipsoid, TriMesh, Vec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Meridians and steps from pole to pole of surfaces drawn for round parts.
const MERIDIANS: u32 = 48;
const PARALLELS: u32 = 24;
/// Meridians of the coarser of two surfaces by which superellipsoids are measured.
const COARSE: u32 = 96;

/// A convex part with sharp edges, in its own frame.
#[derive(Clone, Debug)]
pub(super) enum SharpPart {
    /// Ball of a radius (m).
    Ball(f64),
    /// Convex hull of points (m).
    Points(Vec<Vec3>),
    /// Any other body, by its support points.
    Core(Core),
}

impl SharpPart {
    /// The body of which `part` is the crusted form.
    ///
    /// Errors: a polyhedron without faces.
    pub(super) fn of(part: &Part) -> Result<Self, CouplingError> {
        let crust = part.crust;
        Ok(match &part.core {
            Core::Point => Self::Ball(crust),
            Core::Box(half) => Self::Points(corners(&half.add_scalar(crust))),
            Core::Cylinder { radius, half_height } => {
                Self::Core(Core::Cylinder { radius: radius + crust, half_height: half_height + crust })
            }
            Core::Segment { half_length } => Self::Points(capsule(crust, *half_length)),
            Core::Cone(cone) => Self::Points(cone_rims(&cone.grown(crust))),
            Core::Polyhedron(hull) => {
                let core = ConvexHull { vertices: hull.vertices().to_vec(), faces: hull.faces().to_vec() };
                let middle = core.vertices.iter().sum::<Vec3>() / core.vertices.len() as f64;
                let vertices = core.eroded_vertices(&middle, -crust).map_err(|e| unusable(&e))?;
                Self::Points(vertices)
            }
            Core::Superellipsoid(core) => Self::Core(Core::superellipsoid(core.sharp())),
            Core::Triangle(corners) => Self::Points(corners.to_vec()),
        })
    }

    /// A closed surface of triangles (m); round bodies are drawn with some thousand.
    pub(super) fn mesh(&self) -> Result<TriMesh, CouplingError> {
        match self {
            Self::Ball(radius) => Ok(globe(MERIDIANS, PARALLELS, |point| point * *radius)),
            Self::Points(points) => {
                Ok(ConvexHull::new(&distinct(points)).map_err(|e| unusable(&e))?.triangles())
            }
            Self::Core(Core::Cylinder { radius, half_height }) => Ok(tube(*radius, *half_height)),
            Self::Core(Core::Superellipsoid(body)) => Ok(superellipsoid_mesh(body, MERIDIANS)),
            Self::Core(_) => unreachable!("only cylinders and superellipsoids are kept as cores"),
        }
    }

    /// Surface (m²), exact but for superellipsoids.
    pub(super) fn surface(&self) -> Result<f64, CouplingError> {
        Ok(match self {
            Self::Ball(radius) => 4.0 * PI * radius * radius,
            Self::Core(Core::Cylinder { radius, half_height }) => TAU * radius * (radius + 2.0 * half_height),
            Self::Core(Core::Superellipsoid(body)) => SuperellipsoidFacets::new(body).surface(),
            _ => Facets::of_triangles(&self.mesh()?).surface(),
        })
    }
}

/// Areas of a superellipsoid by inscribed surfaces of n and 2n meridians, extrapolated: (4 A₂ₙ − Aₙ)/3.
pub(super) struct SuperellipsoidFacets {
    coarse: Facets,
    fine: Facets,
}

impl SuperellipsoidFacets {
    pub(super) fn new(body: &Superellipsoid) -> Self {
        let facets = |meridians: u32| Facets::of_triangles(&superellipsoid_mesh(body, meridians));
        Self { coarse: facets(COARSE), fine: facets(2 * COARSE) }
    }

    /// Surface (m²).
    pub(super) fn surface(&self) -> f64 {
        extrapolated(self.coarse.surface(), self.fine.surface())
    }

    /// Projected area (m²) along a unit direction.
    pub(super) fn projected_area(&self, d: &Vec3) -> f64 {
        extrapolated(self.coarse.projected_area(d), self.fine.projected_area(d))
    }
}

fn extrapolated(coarse: f64, fine: f64) -> f64 {
    (4.0 * fine - coarse) / 3.0
}

fn unusable(error: &impl std::fmt::Display) -> CouplingError {
    CouplingError::Shape { shape: "polyhedron".to_string(), reason: error.to_string() }
}

fn corners(half: &Vec3) -> Vec<Vec3> {
    let sign = |k: usize, bit: usize| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
    (0..8).map(|k| half.component_mul(&Vec3::new(sign(k, 0), sign(k, 1), sign(k, 2)))).collect()
}

/// Points of a circle about z at a height (m), on a polygon of the circle's area.
fn circle(radius: f64, z: f64) -> impl Iterator<Item = Vec3> {
    let angle = TAU / f64::from(MERIDIANS);
    let radius = radius * (angle / angle.sin()).sqrt();
    (0..MERIDIANS).map(move |k| {
        let (y, x) = (angle * f64::from(k)).sin_cos();
        Vec3::new(radius * x, radius * y, z)
    })
}

/// Points all over a capsule about z.
fn capsule(radius: f64, half_length: f64) -> Vec<Vec3> {
    let cap = |k: u32| (FRAC_PI_2 * f64::from(k) / f64::from(PARALLELS)).sin_cos();
    let half = |side: f64| {
        let rings = (0..PARALLELS)
            .map(cap)
            .flat_map(move |(sin, cos)| circle(radius * cos, side * (half_length + radius * sin)));
        rings.chain([Vec3::z() * (side * (half_length + radius))])
    };
    half(-1.0).chain(half(1.0)).collect()
}

/// Points on the rims of a cone, and its apex.
fn cone_rims(cone: &Cone) -> Vec<Vec3> {
    let of_end = |k: usize| {
        let (radius, z) = (cone.radii[k], cone.heights[k]);
        let count = if radius > 0.0 { MERIDIANS as usize } else { 1 };
        circle(radius, z).take(count)
    };
    of_end(0).chain(of_end(1)).collect()
}

/// The points without those that coincide with an earlier one.
fn distinct(points: &[Vec3]) -> Vec<Vec3> {
    let size = points.iter().map(Vec3::amax).fold(0.0, f64::max);
    let mut kept: Vec<Vec3> = Vec::new();
    for point in points {
        if kept.iter().all(|k| (k - point).amax() > 1e-8 * size) {
            kept.push(*point);
        }
    }
    kept
}

/// A surface of meridians and parallels, whose points are moved from those of the unit sphere.
fn globe(meridians: u32, parallels: u32, place: impl Fn(&Vec3) -> Vec3) -> TriMesh {
    let n = meridians;
    let mut vertices = Vec::new();
    for row in 1..parallels {
        let latitude = PI * f64::from(row) / f64::from(parallels) - FRAC_PI_2;
        let (z, m) = latitude.sin_cos();
        vertices.extend((0..n).map(|k| {
            let (y, x) = (TAU * f64::from(k) / f64::from(n)).sin_cos();
            place(&Vec3::new(m * x, m * y, z))
        }));
    }
    let (south, last) = (vertices.len() as u32, (parallels - 2) * n);
    vertices.extend([place(&-Vec3::z()), place(&Vec3::z())]);
    let mut triangles = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        triangles.extend([[j, i, south], [last + i, last + j, south + 1]]);
        for row in (0..last).step_by(n as usize) {
            let [a, b, c, d] = [row + i, row + j, row + n + i, row + n + j];
            // The diagonals of opposite sides mirror each other.
            let split = if 2 * i < n { [[a, b, d], [a, d, c]] } else { [[a, b, c], [b, d, c]] };
            triangles.extend(split);
        }
    }
    TriMesh { vertices, triangles }
}

/// Points of the unit sphere pushed to the body along curves of even angle, so that faces and edges both get theirs.
fn superellipsoid_mesh(body: &Superellipsoid, meridians: u32) -> TriMesh {
    let [e1, e2] = body.eps();
    let semi_axes = *body.semi_axes();
    globe(meridians, meridians / 2, |point| {
        let m = point.x.hypot(point.y);
        let [m_curve, z] = on_curve([m, point.z], 2.0 / e1);
        let [x, y] = if m > 0.0 { on_curve([point.x / m, point.y / m], 2.0 / e2) } else { [1.0, 0.0] };
        Vec3::new(m_curve * x, m_curve * y, z).component_mul(&semi_axes)
    })
}

/// The point of the curve |u|^p + |v|^p = 1 on the ray through a point other than 0.
fn on_curve([u, v]: [f64; 2], p: f64) -> [f64; 2] {
    let largest = u.abs().max(v.abs());
    let norm = largest * ((u.abs() / largest).powf(p) + (v.abs() / largest).powf(p)).powf(1.0 / p);
    [u / norm, v / norm]
}

fn tube(radius: f64, half_height: f64) -> TriMesh {
    let n = MERIDIANS;
    let ring = |z: f64| {
        (0..n).map(move |k| {
            let (y, x) = (TAU * f64::from(k) / f64::from(n)).sin_cos();
            Vec3::new(radius * x, radius * y, z)
        })
    };
    let mut vertices: Vec<Vec3> = ring(-half_height).chain(ring(half_height)).collect();
    vertices.extend([Vec3::new(0.0, 0.0, -half_height), Vec3::new(0.0, 0.0, half_height)]);
    let side = |i: u32| {
        let j = (i + 1) % n;
        [[i, j, n + j], [i, n + j, n + i], [j, i, 2 * n], [n + i, n + j, 2 * n + 1]]
    };
    TriMesh { vertices, triangles: (0..n).flat_map(side).collect() }
}
