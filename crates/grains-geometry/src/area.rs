//! Surface area of shapes: exact surfaces of the parts, less what lies in other parts.

use crate::mass::sharp_corners;
use crate::{ConvexHull, Core, Part, Shape, TriMesh, Vec3};
use std::f64::consts::{PI, TAU};

/// Points on the surfaces of all parts together.
const POINTS: usize = 400_000;
/// Fewest points on the surface of a part.
const LEAST_POINTS: usize = 2_000;
/// Distance from the surface of the points that tell what is inside, relative to the size of the body.
const OFF_SURFACE: f64 = 1e-7;
/// The inverse of the golden ratio.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

impl Shape {
    /// Area of the surface of the body with sharp edges, A = Σ_k ∫ dA over the surface of part k outside all other parts
    /// (m², at scale 1); of a mesh its own area.
    ///
    /// Single spheres, boxes, cylinders and polyhedra are exact to rounding, others to about 1e-4: each part's exact surface
    /// is taken at evenly spread points. A surface that two parts share counts once if their outsides agree, else not.
    pub fn area(&self) -> f64 {
        if let Some(mesh) = &self.report.decomposition {
            return mesh.area;
        }
        if let [Part { core: Core::Polyhedron(_), .. }] = &self.parts[..] {
            return area_of(&self.surface);
        }
        let off = OFF_SURFACE * self.bounding_radius;
        let number = match &self.parts[..] {
            // Nothing is hidden, and one point stands for all of a piece of even density.
            [Part { core: Core::Point | Core::Box(_) | Core::Cylinder { .. }, .. }] => 1,
            parts => (POINTS / parts.len()).max(LEAST_POINTS),
        };
        let mut sum = 0.0;
        for (k, part) in self.parts.iter().enumerate() {
            for_each_point(part, number, |point, normal, area| {
                let place = |x: Vec3| part.rotation * x + part.center;
                let (outside, inside) = (place(point + normal * off), place(point - normal * off));
                let holds =
                    |other: &Part, x: &Vec3| other.contains(&other.rotation.tr_mul(&(x - other.center)));
                // Of a surface that parts share, the first one's counts.
                let is_hidden = |(j, other): (usize, &Part)| {
                    j != k && (holds(other, &outside) || j < k && holds(other, &inside))
                };
                if !self.parts.iter().enumerate().any(is_hidden) {
                    sum += area;
                }
            });
        }
        sum
    }
}

/// Hands over about `number` points spread over the surface of a part (m), with the outward unit normal and the area (m²)
/// each stands for, in the part's frame.
fn for_each_point(part: &Part, number: usize, mut visit: impl FnMut(Vec3, Vec3, f64)) {
    let crust = part.crust;
    match &part.core {
        Core::Point => {
            let area = 4.0 * PI * crust * crust / number as f64;
            lattice(number).map(direction).for_each(|n| visit(n * crust, n, area));
        }
        Core::Box(half) => {
            on_triangles(&crate::shapes::cuboid_surface(&half.add_scalar(crust)), number, visit)
        }
        Core::Cylinder { radius, half_height } => {
            on_cylinder([radius + crust, half_height + crust], number, visit)
        }
        Core::Polyhedron(_) => {
            if let Ok(hull) = ConvexHull::new(&sharp_corners(part)) {
                on_triangles(&hull.triangles(), number, visit);
            }
        }
        // dA = a₁a₂a₃ |∇g| dω/g³ with the gauge g and its gradient at a∘ω, ω a unit vector.
        Core::Superellipsoid(body) => {
            let axes = body.sharp_axes();
            let solid_angle = 4.0 * PI / number as f64;
            for along in lattice(number).map(direction).map(|w| w.component_mul(axes)) {
                let (gauge, gradient) = body.gauge(&along);
                let steepness = gradient.norm();
                let area = axes.product() * steepness / gauge.powi(3) * solid_angle;
                visit(along / gauge, gradient / steepness, area);
            }
        }
        // A piece of a wall has no inside.
        Core::Triangle(_) => {}
    }
}

/// Points spread evenly over the unit square: no two in a row or column, so that straight seams cut off their share.
fn lattice(number: usize) -> impl Iterator<Item = [f64; 2]> {
    (0..number).map(move |k| [(k as f64 + 0.5) / number as f64, (k as f64 * GOLDEN).fract()])
}

/// The square on the unit sphere, areas in proportion.
fn direction([u, v]: [f64; 2]) -> Vec3 {
    let (z, (sine, cosine)) = (1.0 - 2.0 * u, (TAU * v).sin_cos());
    let ring = (1.0 - z * z).sqrt();
    Vec3::new(ring * cosine, ring * sine, z)
}

/// Points on a cylinder about z of radius and half height (m).
fn on_cylinder([radius, half_height]: [f64; 2], number: usize, mut visit: impl FnMut(Vec3, Vec3, f64)) {
    let (round, flat) = (2.0 * TAU * radius * half_height, PI * radius * radius);
    let share = |area: f64| (number as f64 * area / (round + 2.0 * flat)).ceil();
    let on_circle = |v: f64| Vec3::new((TAU * v).cos(), (TAU * v).sin(), 0.0);
    for [u, v] in lattice(share(round) as usize) {
        let normal = on_circle(v);
        visit(normal * radius + Vec3::z() * (half_height * (2.0 * u - 1.0)), normal, round / share(round));
    }
    for normal in [Vec3::z(), -Vec3::z()] {
        for [u, v] in lattice(share(flat) as usize) {
            visit(on_circle(v) * (radius * u.sqrt()) + normal * half_height, normal, flat / share(flat));
        }
    }
}

/// Points on the triangles of a closed mesh.
fn on_triangles(mesh: &TriMesh, number: usize, mut visit: impl FnMut(Vec3, Vec3, f64)) {
    let whole = area_of(mesh);
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t);
        let (ab, ac) = (b - a, c - a);
        let cross = ab.cross(&ac);
        let area = 0.5 * cross.norm();
        let Some(normal) = cross.try_normalize(0.0) else { continue };
        let share = (number as f64 * area / whole).ceil();
        for [u, v] in lattice(share as usize) {
            // Half of the parallelogram, folded onto the other.
            let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
            visit(a + ab * u + ac * v, normal, area / share);
        }
    }
}

/// Area of the triangles of a mesh (m²).
pub(crate) fn area_of(mesh: &TriMesh) -> f64 {
    let twice = |[a, b, c]: [Vec3; 3]| (b - a).cross(&(c - a)).norm();
    (0..mesh.triangles.len()).map(|t| 0.5 * twice(mesh.corners(t))).sum()
}
