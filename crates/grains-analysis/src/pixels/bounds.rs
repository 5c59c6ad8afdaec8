//! Boxes and balls about bodies with sharp edges.
//!
//! The box and the ball of a [`Part`] hold its core swept by the crust, whose edges are round. The body that
//! [`Part::contains`] knows has sharp edges and corners beyond: it is the one whose erosion by the crust c is
//! the core. If a ball of radius ρ about a point p lies in the core, then the body lies in the core blown up
//! about p by λ = 1 + c/ρ: a point x of the body and the ball of radius ρ + c about p, which lies in it too,
//! span a cone in the body, which about p + (x − p)/λ holds a ball of radius c.

use grains_geometry::{Core, Part, Shape, Vec3};

/// A convex part and what surely holds it.
#[derive(Clone, Debug)]
pub struct Bounded<'a> {
    pub part: &'a Part,
    /// Half edges of a box about the part's origin, along its frame (m).
    pub half_extents: Vec3,
    /// Radius of a ball about the part's origin (m).
    pub radius: f64,
}

/// The parts of a shape and the radius of a ball about its centre that holds them (m).
pub fn bounded(shape: &Shape) -> (Vec<Bounded<'_>>, f64) {
    let parts: Vec<Bounded> = shape.parts.iter().map(Bounded::new).collect();
    let radius = parts.iter().map(|b| b.part.center.norm() + b.radius).fold(0.0, f64::max);
    (parts, radius)
}

/// More than rounding of the inside test (-).
const SLACK: f64 = 1.0 + 1e-9;

impl<'a> Bounded<'a> {
    fn new(part: &'a Part) -> Self {
        let mut bounded =
            Self { part, half_extents: part.half_extents * SLACK, radius: part.bounding_radius * SLACK };
        if matches!(part.core, Core::Point | Core::Segment { .. } | Core::Triangle(_)) {
            return bounded;
        }
        let directions = directions(&part.core);
        let points: Vec<Vec3> = directions.iter().map(|d| part.core.support(d)).collect();
        let middle = points.iter().sum::<Vec3>() / points.len() as f64;
        let depths = directions.iter().zip(&points).map(|(d, point)| d.dot(&(point - middle)));
        let inscribed = depths.fold(f64::INFINITY, f64::min);
        // The directions of a curved core may miss the smallest depth by a little.
        let growth = 1.5 * part.crust / inscribed;
        if growth > 0.0 && growth.is_finite() {
            let grown = |length: f64, shift: f64| (1.0 + growth) * (length - part.crust) + growth * shift;
            for a in 0..3 {
                let half = grown(part.half_extents[a], middle[a].abs());
                bounded.half_extents[a] = bounded.half_extents[a].max(half);
            }
            bounded.radius = bounded.radius.max(grown(part.bounding_radius, middle.norm()));
        }
        bounded
    }
}

/// Directions among which the depth of a core is smallest: normals of faces, axes, and some more.
fn directions(core: &Core) -> Vec<Vec3> {
    const MORE: usize = 500;
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let on_spiral = |k: usize| {
        let z = 1.0 - (2 * k + 1) as f64 / MORE as f64;
        let (sin, cos) = (golden * k as f64).sin_cos();
        Vec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + Vec3::z() * z
    };
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    let mut directions: Vec<Vec3> = axes.iter().flat_map(|axis| [*axis, -axis]).collect();
    directions.extend((0..MORE).map(on_spiral));
    if let Core::Polyhedron(hull) = core {
        directions.extend(hull.faces().iter().map(|face| face.normal));
    }
    directions
}
