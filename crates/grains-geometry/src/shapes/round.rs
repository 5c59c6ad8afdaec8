//! Spheres, boxes and cylinders, whose mass properties have closed forms.

use super::tessellation::{cylinder_surface, sphere_surface};
use crate::convex::cuboid::triangles as cuboid_surface;
use crate::error::{check_length, crust_thickness};
use crate::{Core, Mat3, Part, PartFrame, Rotation, Shape, ShapeError, ShapeReport, Vec3};
use std::f64::consts::PI;

impl Shape {
    /// Sphere: V = 4/3 π r³, I = 2/5 V r²; the crust is the radius (m).
    pub fn sphere(radius: f64) -> Result<Self, ShapeError> {
        check_length("sphere radius", radius)?;
        let volume = 4.0 / 3.0 * PI * radius.powi(3);
        let part = centred_part(Core::Point, radius, Vec3::repeat(radius), radius);
        Ok(Shape {
            name: "sphere".to_string(),
            inertia: Vec3::repeat(0.4 * volume * radius * radius),
            bounding_radius: part.bounding_radius,
            parts: vec![part],
            volume,
            inscribed_radius: radius,
            user_to_body: (Rotation::identity(), Vec3::zeros()),
            discrete: None,
            surface: sphere_surface(radius),
            report: ShapeReport::default(),
        })
    }

    /// Box of the given edges (m): V = a b c, I_x = V (b² + c²)/12.
    pub fn cuboid(edges: Vec3, crust_fraction: f64) -> Result<Self, ShapeError> {
        edges.iter().try_for_each(|&edge| check_length("box edge", edge))?;
        let half = edges / 2.0;
        let inscribed_radius = half.min();
        let crust = crust_thickness(crust_fraction, inscribed_radius)?;
        let inner = half.add_scalar(-crust);
        let volume = edges.product();
        let squares = edges.component_mul(&edges);
        let part = centred_part(Core::Box(inner), crust, half, inner.norm() + crust);
        Ok(Shape {
            name: "cuboid".to_string(),
            inertia: Vec3::repeat(squares.sum()).map(|s| s * volume / 12.0) - squares * (volume / 12.0),
            bounding_radius: part.bounding_radius,
            parts: vec![part],
            volume,
            inscribed_radius,
            user_to_body: (Rotation::identity(), Vec3::zeros()),
            discrete: None,
            surface: cuboid_surface(&half),
            report: ShapeReport::default(),
        })
    }

    /// Cylinder about z (m): V = π r² h, I_z = V r²/2, I_x = I_y = V (3 r² + h²)/12.
    pub fn cylinder(radius: f64, height: f64, crust_fraction: f64) -> Result<Self, ShapeError> {
        check_length("cylinder radius", radius)?;
        check_length("cylinder height", height)?;
        let inscribed_radius = radius.min(height / 2.0);
        let crust = crust_thickness(crust_fraction, inscribed_radius)?;
        let core = Core::Cylinder { radius: radius - crust, half_height: height / 2.0 - crust };
        let bounding = libm::hypot(radius - crust, height / 2.0 - crust) + crust;
        let part = centred_part(core, crust, Vec3::new(radius, radius, height / 2.0), bounding);
        let volume = PI * radius * radius * height;
        let transverse = volume * (3.0 * radius * radius + height * height) / 12.0;
        Ok(Shape {
            name: "cylinder".to_string(),
            inertia: Vec3::new(transverse, transverse, volume * radius * radius / 2.0),
            bounding_radius: part.bounding_radius,
            parts: vec![part],
            volume,
            inscribed_radius,
            user_to_body: (Rotation::identity(), Vec3::zeros()),
            discrete: None,
            surface: cylinder_surface(radius, height),
            report: ShapeReport::default(),
        })
    }
}

/// A part whose frame is the body frame.
pub(super) fn centred_part(core: Core, crust: f64, half_extents: Vec3, bounding_radius: f64) -> Part {
    let (center, rotation, frame) = (Vec3::zeros(), Mat3::identity(), PartFrame::OfBody);
    Part { core, crust, center, rotation, frame, half_extents, bounding_radius }
}
