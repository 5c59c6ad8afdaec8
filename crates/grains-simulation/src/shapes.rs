//! Shapes of particles, from their description in the case.

use crate::convex::convex;
use grains_case::{GluedPart, Meshes, Shape as CaseShape, ShapeKind, beam_size, layer_radius};
use grains_geometry::{Component, Lobes, Rotation, Shape, ShapeError, SphereArrangement, Vec3};
use nalgebra::{Quaternion, UnitQuaternion};

/// Crust over inscribed radius where the case does not say.
const CRUST: f64 = 0.02;

/// Builds a particle shape.
///
/// # Errors
/// What makes the shape impossible.
pub fn shape(shape: &CaseShape, meshes: &Meshes) -> Result<Shape, String> {
    let crust = shape.crust.unwrap_or(CRUST);
    let built = match &shape.kind {
        kind if kind.is_composite() => composite(kind, crust, meshes),
        kind => convex(kind, crust, meshes),
    };
    built.map(|s| s.named(&shape.name)).map_err(|e| e.to_string())
}

/// Builds a shape of several parts.
fn composite(kind: &ShapeKind, crust: f64, meshes: &Meshes) -> Result<Shape, ShapeError> {
    match kind {
        ShapeKind::Glued { parts } => {
            let components =
                parts.iter().map(|part| component(part, crust, meshes)).collect::<Result<Vec<_>, _>>()?;
            Shape::glued(&components, crust)
        }
        ShapeKind::Lobes { lobes, diameter, length, area_fraction, offset } => {
            let radius = 0.5 * diameter;
            let section = match (area_fraction, offset) {
                (_, Some(offset)) => Lobes { count: *lobes, radius, offset: *offset },
                (fraction, None) => Lobes::with_area_fraction(*lobes, radius, fraction.unwrap_or(f64::NAN))?,
            };
            Shape::lobes(section, *length, crust)
        }
        ShapeKind::Cross { beams, beam_width, beam_length, equivalent_diameter, aspect_ratio } => {
            let (width, length) =
                beam_size(*beams, *beam_width, *beam_length, *equivalent_diameter, *aspect_ratio);
            Shape::cross(*beams, width, length, crust)
        }
        ShapeKind::SphereCylinder { radius, height, layers, rings, sphere_radius } => {
            let sphere_radius = layer_radius(*sphere_radius, *height, *layers);
            let arrangement = SphereArrangement { layers: *layers, rings: rings.clone(), sphere_radius };
            Shape::spheres_of_cylinder(*radius, *height, &arrangement)
        }
        ShapeKind::SlicedCylinder { radius, height, slices } => {
            Shape::sliced_cylinder(*radius, *height, *slices, crust)
        }
        ShapeKind::Mesh { path, scale, .. } => {
            let parts = kind.decomposition().ok_or(ShapeError::NoComponents)?;
            Shape::of_parts(&*meshes.mesh(path)?, *scale, &*meshes.parts(&parts)?, crust)
        }
        single => convex(single, crust, meshes),
    }
}

fn component(part: &GluedPart, crust: f64, meshes: &Meshes) -> Result<Component, ShapeError> {
    let [w, x, y, z] = part.orientation;
    let rotation: Rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Ok(Component::new(convex(&part.kind, crust, meshes)?, Vec3::from(part.at)).turned(rotation))
}
