//! Capsules (spherocylinders), whose contacts are those of their axes: exact, with the radius for crust.

use super::round::centred_part;
use super::tessellation::revolved;
use crate::error::check_length;
use crate::{Core, Rotation, Shape, ShapeError, ShapeReport, Vec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Steps from the rim of a cap to its pole in the surface drawn.
const CAP_STEPS: u32 = 8;

impl Shape {
    /// Capsule about z: cylinder of the given radius with half a ball on either end, of the given length from tip to tip
    /// (m). With l = length − 2 r, V = π r² l + 4/3 π r³; the crust is the radius.
    ///
    /// # Errors
    /// Lengths that are not positive; a length that is not above the diameter.
    pub fn capsule(radius: f64, length: f64) -> Result<Self, ShapeError> {
        check_length("capsule radius", radius)?;
        check_length("capsule length", length)?;
        let straight = length - 2.0 * radius;
        if straight <= 1e-6 * radius {
            return Err(ShapeError::OutOfRange {
                quantity: "length over diameter of a capsule",
                value: length / (2.0 * radius),
                allowed: "above 1",
                remedy: "give the length from tip to tip, or take a sphere",
            });
        }
        let core = Core::Segment { half_length: straight / 2.0 };
        let part = centred_part(core, radius, Vec3::new(radius, radius, length / 2.0), length / 2.0);
        let (cylinder, ball) = (PI * radius * radius * straight, 4.0 / 3.0 * PI * radius.powi(3));
        let along = cylinder * radius * radius / 2.0 + ball * 0.4 * radius * radius;
        // Half a ball has its centre of mass 3/8 r from its flat face.
        let across = cylinder * (straight * straight / 12.0 + radius * radius / 4.0)
            + ball * (0.4 * radius * radius + straight * straight / 4.0 + 0.375 * straight * radius);
        Ok(Shape {
            name: "capsule".to_string(),
            inertia: Vec3::new(across, across, along),
            bounding_radius: part.bounding_radius,
            parts: vec![part],
            volume: cylinder + ball,
            inscribed_radius: radius,
            user_to_body: (Rotation::identity(), Vec3::zeros()),
            discrete: None,
            surface: revolved(&outline(radius, straight / 2.0)),
            report: ShapeReport::default(),
        })
    }
}

/// Distances from the axis and heights from the lower to the upper pole (m).
fn outline(radius: f64, half_length: f64) -> Vec<[f64; 2]> {
    let on_cap = |k: u32| libm::sincos(FRAC_PI_2 * f64::from(k) / f64::from(CAP_STEPS));
    let lower = (0..=CAP_STEPS).map(on_cap).map(|(sin, cos)| [radius * sin, -half_length - radius * cos]);
    let upper =
        (0..=CAP_STEPS).rev().map(on_cap).map(|(sin, cos)| [radius * sin, half_length + radius * cos]);
    lower.chain(upper).collect()
}
