//! Superellipsoids, whose mass properties are products of Beta functions.

use super::round::centred_part;
use crate::error::crust_thickness;
use crate::superellipsoid::Superellipsoid;
use crate::{Core, DiscreteSurface, Rotation, Shape, ShapeError, ShapeReport, Spacing, TriMesh, Vec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

/// Meridians and steps from pole to pole of the surface drawn; multiples of 8 and 4, so that edges of boxes
/// and octahedra are edges of the mesh.
const MERIDIANS: u32 = 32;
const PARALLELS: u32 = 24;

impl Shape {
    /// Superellipsoid of semi-axes a (m) and exponents ε₁ (meridian) and ε₂ (x-y section) (Srinivasan 2019, 2.1):
    /// V = 2 a₁a₂a₃ ε₁ε₂ B(ε₁/2 + 1, ε₁) B(ε₂/2, ε₂/2) (2.3), inertia by (2.4).
    ///
    /// Up to ε = 1 the core swept by the crust is the body itself; the crust is then at most half of the
    /// least radius of curvature. With an ε beyond 1 the crust rounds the edges, as it does those of polyhedra.
    ///
    /// # Errors
    /// Semi-axes that are not positive, ε outside [0.05, 2], crust outside (0, 0.5].
    pub fn superellipsoid(semi_axes: Vec3, eps: [f64; 2], crust_fraction: f64) -> Result<Self, ShapeError> {
        let body = Superellipsoid::new(semi_axes, eps)?;
        let inscribed_radius = body.inscribed_radius();
        let mut crust = crust_thickness(crust_fraction, inscribed_radius)?;
        let core = if body.is_sharp() {
            body.rounded(crust)
        } else {
            crust = crust.min(0.5 * body.min_curvature_radius());
            body.eroded(crust)
        };
        let core = Core::superellipsoid(core);
        let part = centred_part(core, crust, semi_axes, body.bounding_radius());
        Ok(Shape {
            name: "superellipsoid".to_string(),
            inertia: inertia(&semi_axes, eps),
            bounding_radius: part.bounding_radius,
            parts: vec![part],
            volume: volume(&semi_axes, eps),
            inscribed_radius,
            user_to_body: (Rotation::identity(), Vec3::zeros()),
            report: ShapeReport::default(),
            discrete: None,
            surface: surface(&body),
        })
    }

    /// The same shape with contacts found by about n² vertices of its surface (Srinivasan 2019, 2.4), if it
    /// is a superellipsoid and n at least 4.
    ///
    /// # Errors
    /// Fewer than 4 vertices per direction.
    pub fn with_surface_vertices(
        mut self,
        per_direction: usize,
        spacing: Spacing,
    ) -> Result<Self, ShapeError> {
        if let Some(Core::Superellipsoid(core)) = self.parts.first().map(|part| &part.core) {
            let surface = DiscreteSurface::new(&core.sharp(), per_direction, spacing)?;
            self.discrete = Some(Arc::new(surface));
        }
        Ok(self)
    }
}

/// B(x, y) = Γ(x) Γ(y) / Γ(x + y) (2.6).
fn beta(x: f64, y: f64) -> f64 {
    libm::tgamma(x) * libm::tgamma(y) / libm::tgamma(x + y)
}

fn volume(a: &Vec3, [e1, e2]: [f64; 2]) -> f64 {
    2.0 * a.product() * e1 * e2 * beta(0.5 * e1 + 1.0, e1) * beta(0.5 * e2, 0.5 * e2)
}

/// Moments of inertia for unit density (m⁵).
fn inertia(a: &Vec3, [e1, e2]: [f64; 2]) -> Vec3 {
    let half = 0.5 * a.product() * e1 * e2;
    let across = half * beta(1.5 * e2, 0.5 * e2) * beta(0.5 * e1, 2.0 * e1 + 1.0);
    let along = half * 4.0 * beta(0.5 * e2, 0.5 * e2 + 1.0) * beta(1.5 * e1, e1 + 1.0);
    let squares = a.component_mul(a);
    let (x, y, z) = (across * squares.x, across * squares.y, along * squares.z);
    Vec3::new(y + z, x + z, x + y)
}

/// Meridians and parallels at even angles, each pushed along its ray to the curve |u|^p + |v|^p = 1: for any ε
/// points are spread over faces and edges alike.
fn surface(body: &Superellipsoid) -> TriMesh {
    let [e1, e2] = body.eps();
    let a = body.semi_axes();
    let ring = |latitude: f64| {
        let [m, z] = on_curve(latitude, 2.0 / e1);
        (0..MERIDIANS).map(move |k| {
            let [x, y] = on_curve(TAU * f64::from(k) / f64::from(MERIDIANS), 2.0 / e2);
            Vec3::new(a.x * m * x, a.y * m * y, a.z * z)
        })
    };
    let latitude = |k: u32| PI * f64::from(k) / f64::from(PARALLELS) - FRAC_PI_2;
    let mut vertices: Vec<Vec3> = (1..PARALLELS).flat_map(|k| ring(latitude(k))).collect();
    let (n, south) = (MERIDIANS, vertices.len() as u32);
    vertices.extend([Vec3::new(0.0, 0.0, -a.z), Vec3::new(0.0, 0.0, a.z)]);
    let mut triangles = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        let last = (PARALLELS - 2) * n;
        triangles.extend([[j, i, south], [last + i, last + j, south + 1]]);
        for row in (0..last).step_by(n as usize) {
            let (low, high) = ([row + i, row + j], [row + n + i, row + n + j]);
            triangles.extend([[low[0], low[1], high[1]], [low[0], high[1], high[0]]]);
        }
    }
    TriMesh { vertices, triangles }
}

/// The point at an angle of the curve |u|^p + |v|^p = 1.
fn on_curve(angle: f64, p: f64) -> [f64; 2] {
    let (u, v) = (libm::cos(angle), libm::sin(angle));
    let largest = u.abs().max(v.abs());
    let norm =
        largest * libm::pow(libm::pow(u.abs() / largest, p) + libm::pow(v.abs() / largest, p), 1.0 / p);
    [u / norm, v / norm]
}
