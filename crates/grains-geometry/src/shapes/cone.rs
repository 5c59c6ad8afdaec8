//! Circular cones and frustums, whose mass properties have closed forms.

use super::tessellation::revolved;
use crate::error::{check_length, crust_thickness};
use crate::{Cone, Core, Mat3, Part, PartFrame, Rotation, Shape, ShapeError, ShapeReport, Vec3};
use std::f64::consts::PI;

impl Shape {
    /// Cone about z of the given radii at its lower and upper end, one of which may be zero, and height (m); its own
    /// coordinates are about the middle of its axis.
    ///
    /// With r = r₀ + (r₁ − r₀) t, 0 ≤ t ≤ 1: V = π h ∫ r² dt, the height of the centre of mass V z = π h² ∫ t r² dt,
    /// I_z = π h/2 ∫ r⁴ dt, and I_x = I_z/2 + π h³ ∫ t² r² dt − V z². The crust is at most half of what would make
    /// the smaller end vanish.
    ///
    /// # Errors
    /// A height that is not positive, radii that are negative or both zero, crust outside (0, 0.5].
    pub fn cone(radii: [f64; 2], height: f64, crust_fraction: f64) -> Result<Self, ShapeError> {
        check_length("cone height", height)?;
        let [bottom, top] = radii;
        check_length("larger radius of a cone", bottom.max(top))?;
        if bottom.min(top) != 0.0 {
            check_length("smaller radius of a cone (0 for an apex)", bottom.min(top))?;
        }
        let squares = bottom * bottom + bottom * top + top * top;
        let volume = PI * height * squares / 3.0;
        let center = height / 4.0 * (bottom * bottom + 2.0 * bottom * top + 3.0 * top * top) / squares;
        let quartics = (0..=4).map(|k| bottom.powi(4 - k) * top.powi(k)).sum::<f64>();
        let along = PI * height / 10.0 * quartics;
        let widening = top - bottom;
        let second = bottom * bottom / 3.0 + bottom * widening / 2.0 + widening * widening / 5.0;
        let across = along / 2.0 + PI * height.powi(3) * second - volume * center * center;
        let body = Cone { heights: [-center, height - center], radii };
        let part = part(&body, crust_fraction)?;
        Ok(Shape {
            name: "cone".to_string(),
            inertia: Vec3::new(across, across, along),
            bounding_radius: part.bounding_radius,
            parts: vec![part],
            volume,
            inscribed_radius: body.inscribed_radius(),
            user_to_body: (Rotation::identity(), Vec3::new(0.0, 0.0, center - height / 2.0)),
            discrete: None,
            surface: revolved(&outline(&body)),
            report: ShapeReport::default(),
        })
    }
}

/// The part of a cone about its centre of mass.
fn part(body: &Cone, crust_fraction: f64) -> Result<Part, ShapeError> {
    let crust = crust_thickness(crust_fraction, body.inscribed_radius())?.min(0.5 * body.largest_erosion());
    let radius = body.radii[0].max(body.radii[1]);
    let half_height = body.heights[0].abs().max(body.heights[1].abs());
    let core = Core::Cone(body.grown(-crust));
    Ok(Part {
        bounding_radius: core.radius() + crust,
        core,
        crust,
        center: Vec3::zeros(),
        rotation: Mat3::identity(),
        frame: PartFrame::OfBody,
        half_extents: Vec3::new(radius, radius, half_height),
    })
}

/// Distances from the axis and heights from the middle of the lower end to that of the upper (m).
fn outline(body: &Cone) -> Vec<[f64; 2]> {
    let [low, high] = body.heights;
    let [bottom, top] = body.radii;
    let mut outline = vec![[0.0, low], [bottom, low], [top, high], [0.0, high]];
    outline.dedup();
    outline
}
