//! Surface, projected area and sphericities of a shape, as drag laws for any shape need them.
//!
//! For a direction d of the body frame, with S the surface of the body and d_eq the diameter of the sphere of its
//! volume:
//!
//! * the *projected area* A(d) is that of the body's shadow along d;
//! * the *longitudinal area* A∥(d) is the mean of the shadows along all directions normal to d;
//! * Φ = π d_eq²/S, Φ⊥ = (π/4) d_eq²/A(d), Φ∥ = (π/4) d_eq²/(S/2 − A∥(d)) (Hölzer and Sommerfeld 2008).
//!
//! All three are 1 for a sphere. Spheres, boxes, cylinders, ellipsoids and convex polyhedra have closed forms: of a
//! convex polyhedron A = ½ Σ A_f |n_f·d| and A∥ = (1/π) Σ A_f √(1 − (n_f·d)²). Composites, superellipsoids and
//! polyhedra of very many faces get a table over directions, whose error is measured when it is made.

mod elliptic;
mod facets;
mod shadow;
mod sharp;
mod table;
mod union;

use crate::CouplingError;
use elliptic::{ellipse_mean, symmetric_integral};
use facets::Facets;
use grains_geometry::{Core, Mat3, Part, Shape, Vec3};
use shadow::Shadows;
use std::f64::consts::PI;
use table::Table;
pub use table::TableError;

/// Polyhedra of more faces, opposite ones counted once, get a table.
const MOST_FACES: usize = 256;
/// A sphericity this close to 1 is 1 but for rounding, to which laws with (−log Φ)^0.2 would be sensitive.
const ROUNDING: f64 = 1e-12;

/// How a body compares with the sphere of its volume, seen along the flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeFactors {
    /// Sphericity Φ: surface of the sphere over that of the body (-).
    pub sphericity: f64,
    /// Crosswise sphericity Φ⊥: cross section of the sphere over the projected area (-).
    pub crosswise: f64,
    /// Lengthwise sphericity Φ∥: cross section of the sphere over half the surface less the longitudinal area (-).
    pub lengthwise: f64,
}

impl ShapeFactors {
    /// Those of a sphere.
    pub const SPHERE: Self = Self { sphericity: 1.0, crosswise: 1.0, lengthwise: 1.0 };

    /// Means over all orientations of a convex body of sphericity Φ: A and A∥ are then S/4 (Cauchy), hence Φ⊥ = Φ∥ = Φ.
    pub fn any_orientation(sphericity: f64) -> Self {
        Self { sphericity, crosswise: sphericity, lengthwise: sphericity }
    }
}

/// The outline of a shape, ready to be asked from any direction; all lengths at scale 1.
#[derive(Clone, Debug)]
pub struct ShapeProfile {
    /// Volume of the shape (m³).
    pub volume: f64,
    /// Diameter of the sphere of its volume (m).
    pub equivalent_diameter: f64,
    /// Surface of the shape (m²).
    pub surface: f64,
    /// Sphericity (-).
    pub sphericity: f64,
    /// Body frame to the frame of the outline.
    rotation: Mat3,
    outline: Outline,
}

#[derive(Clone, Debug)]
enum Outline {
    /// Radius (m).
    Sphere(f64),
    /// Areas of the faces normal to x, y, z (m²).
    Box(Vec3),
    Cylinder {
        radius: f64,
        height: f64,
    },
    /// Squared products of two semi-axes (m⁴): A(d) = π √(Σ m d²).
    Ellipsoid(Vec3),
    Facets(Facets),
    Table(Table),
}

impl ShapeProfile {
    /// Measures a shape; a table takes some tenths of a second.
    ///
    /// Errors: a shape whose parts have no usable surface.
    pub fn new(shape: &Shape) -> Result<Self, CouplingError> {
        let (surface, rotation, outline) = match shape.parts.as_slice() {
            [part] => convex(shape, part)?,
            _ => {
                let surface = union::surface(shape)?;
                let shadows = Shadows::new(shape)?;
                (surface, Mat3::identity(), Outline::Table(Table::new(|d| shadows.area(d))))
            }
        };
        let equivalent_diameter = shape.sphere_equivalent_diameter();
        let sphericity = PI * equivalent_diameter.powi(2) / surface;
        let sphericity = if (sphericity - 1.0).abs() < ROUNDING { 1.0 } else { sphericity.min(1.0) };
        let rotation = rotation.transpose();
        Ok(Self { volume: shape.volume, equivalent_diameter, surface, sphericity, rotation, outline })
    }

    /// Projected area A (m²) along a unit direction of the body frame.
    pub fn projected_area(&self, direction: &Vec3) -> f64 {
        self.areas(direction)[0]
    }

    /// Longitudinal area A∥ (m²): mean of the projected areas along the directions normal to a unit direction of the
    /// body frame.
    pub fn longitudinal_area(&self, direction: &Vec3) -> f64 {
        self.areas(direction)[1]
    }

    /// Shape factors for a flow along a unit direction of the body frame; they do not depend on the scale.
    pub fn factors(&self, direction: &Vec3) -> ShapeFactors {
        if let Outline::Sphere(_) = self.outline {
            return ShapeFactors::SPHERE;
        }
        let section = 0.25 * PI * self.equivalent_diameter.powi(2);
        let [projected, longitudinal] = self.areas(direction);
        ShapeFactors {
            sphericity: self.sphericity,
            crosswise: section / projected,
            lengthwise: section / (0.5 * self.surface - longitudinal),
        }
    }

    /// Errors of the projected and the longitudinal area by the table, measured when it was made; 0 for closed forms.
    ///
    /// That of the longitudinal area is largest along the normals of flat faces, where it has a cone.
    pub fn table_errors(&self) -> [TableError; 2] {
        match &self.outline {
            Outline::Table(table) => table.errors,
            _ => [TableError::default(); 2],
        }
    }

    fn areas(&self, direction: &Vec3) -> [f64; 2] {
        let d = self.rotation * direction;
        match &self.outline {
            Outline::Sphere(radius) => [PI * radius * radius; 2],
            Outline::Box(faces) => {
                let sines = d.map(|c| (1.0 - c * c).max(0.0).sqrt());
                [faces.dot(&d.abs()), 2.0 / PI * faces.dot(&sines)]
            }
            Outline::Cylinder { radius, height } => {
                let (along, across) = (d.z.abs(), d.x.hypot(d.y));
                let end = PI * radius * radius;
                let side = 2.0 * radius * height;
                [end * along + side * across, 2.0 / PI * end * across + side * ellipse_mean(1.0, along)]
            }
            Outline::Ellipsoid(m) => ellipsoid(m, &d),
            Outline::Facets(facets) => facets.areas(&d),
            Outline::Table(table) => table.areas(&d),
        }
    }
}

/// A and A∥ of an ellipsoid. The quadratic form Σ m d² restricted to the plane normal to d has the trace Σ m − Σ m d²
/// and the determinant Σ m₂ m₃ d₁²; its root has the mean of an ellipse's.
fn ellipsoid(m: &Vec3, d: &Vec3) -> [f64; 2] {
    let squares = d.component_mul(d);
    let along = m.dot(&squares);
    let minors = Vec3::new(m.y * m.z, m.x * m.z, m.x * m.y);
    let half = 0.5 * (m.sum() - along);
    let root = (half * half - minors.dot(&squares)).max(0.0).sqrt();
    let larger = half + root;
    let smaller = (minors.dot(&squares) / larger).min(larger);
    [PI * along.sqrt(), PI * ellipse_mean(larger.sqrt(), smaller.sqrt())]
}

/// Surface, rotation from the frame of the outline to the body frame, and outline of a shape of one part.
fn convex(shape: &Shape, part: &Part) -> Result<(f64, Mat3, Outline), CouplingError> {
    let crust = part.crust;
    let (surface, outline) = match &part.core {
        Core::Point => (4.0 * PI * crust * crust, Outline::Sphere(crust)),
        Core::Box(half) => {
            let e = half.add_scalar(crust) * 2.0;
            let faces = Vec3::new(e.y * e.z, e.x * e.z, e.x * e.y);
            (2.0 * faces.sum(), Outline::Box(faces))
        }
        Core::Cylinder { radius, half_height } => {
            let (radius, height) = (radius + crust, 2.0 * (half_height + crust));
            (2.0 * PI * radius * (radius + height), Outline::Cylinder { radius, height })
        }
        Core::Superellipsoid(core) if core.eps() == [1.0; 2] => {
            let a = *core.sharp().semi_axes();
            let m = Vec3::new(a.y * a.z, a.x * a.z, a.x * a.y).map(|product| product * product);
            (4.0 * PI * symmetric_integral(m.into()), Outline::Ellipsoid(m))
        }
        Core::Superellipsoid(core) => {
            let body = sharp::SuperellipsoidFacets::new(&core.sharp());
            (body.surface(), Outline::Table(Table::new(|d| body.projected_area(d))))
        }
        Core::Segment { .. } | Core::Cone(_) => {
            let facets = Facets::of_triangles(&sharp::SharpPart::of(part)?.mesh()?);
            (facets.surface(), Outline::Table(Table::new(|d| facets.areas(d)[0])))
        }
        Core::Polyhedron(_) | Core::Triangle(_) => {
            // The surface of a single polyhedron is its exact hull, and lies in the body frame.
            let facets = Facets::of_mesh(&shape.surface);
            let surface = facets.surface();
            if !(surface > 0.0 && surface.is_finite()) {
                let reason = format!("its area is {surface} m2");
                return Err(CouplingError::Shape { shape: shape.name.clone(), reason });
            }
            let outline = if facets.len() > MOST_FACES {
                Outline::Table(Table::new(|d| facets.areas(d)[0]))
            } else {
                Outline::Facets(facets)
            };
            return Ok((surface, Mat3::identity(), outline));
        }
    };
    Ok((surface, part.rotation, outline))
}
