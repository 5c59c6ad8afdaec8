//! Shapes of several convex parts, from their description in the case, and what `check` says of them.

use crate::geometry::convex;
use grains_case::{GluedPart, ShapeKind, beam_size, layer_radius};
use grains_geometry::{
    Component, DecompositionOptions, Lobes, MassSource, Rotation, Shape, ShapeError, SphereArrangement, Vec3,
};
use nalgebra::{Quaternion, UnitQuaternion};
use std::fmt::Write;

/// Builds a shape of several parts.
pub(crate) fn composite(kind: &ShapeKind, crust: f64) -> Result<Shape, ShapeError> {
    match kind {
        ShapeKind::Glued { parts } => {
            let components =
                parts.iter().map(|part| component(part, crust)).collect::<Result<Vec<_>, _>>()?;
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
        ShapeKind::Mesh { path, scale, max_parts, resolution } => {
            let options = DecompositionOptions {
                max_parts: *max_parts,
                resolution: *resolution,
                ..DecompositionOptions::default()
            };
            Shape::of_mesh_file(path, *scale, &options, crust)
        }
        single => convex(single, crust),
    }
}

fn component(part: &GluedPart, crust: f64) -> Result<Component, ShapeError> {
    let [w, x, y, z] = part.orientation;
    let rotation: Rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Ok(Component::new(convex(&part.kind, crust)?, Vec3::from(part.at)).turned(rotation))
}

/// Lines of `check` about a shape that is no simple convex body: parts, mass properties, decomposition.
///
/// # Errors
/// Parts without mass properties to compare with.
pub(crate) fn describe(shape: &Shape) -> Result<String, String> {
    let mut text = String::new();
    if shape.parts.len() == 1 && shape.report.mass == MassSource::ClosedForm {
        return Ok(text);
    }
    let source = match shape.report.mass {
        MassSource::ClosedForm => "in closed form".to_string(),
        MassSource::ClosedMesh => "by integrals over the closed surface".to_string(),
        MassSource::Parts => "as the sum of the parts, which do not overlap".to_string(),
        MassSource::Clipped => "of the union of the parts, exact".to_string(),
        MassSource::Chords { lines, error } => {
            format!("of the union of the parts, by {lines} x {lines} chords (error about {error:.0e})")
        }
    };
    let report = shape.mass_report();
    if report.volume_difference.is_nan() || report.inertia_difference.is_nan() {
        return Err(format!(
            "shape \"{}\": its parts under the crust bound no volume, so that its contacts would be wrong: choose a smaller `crust`, or vertices farther apart",
            shape.name
        ));
    }
    let count = shape.parts.len();
    let _ = writeln!(
        text,
        "    {count} part{}; mass properties {source}; those of the parts by chords differ by {:+.1e} in volume, {:+.1e} in inertia",
        if count == 1 { "" } else { "s" },
        report.volume_difference,
        report.inertia_difference
    );
    let worst = report.volume_difference.abs().max(report.inertia_difference.abs());
    if worst > NOTABLE_DIFFERENCE && shape.report.decomposition.is_none() {
        let _ = writeln!(
            text,
            "    warning: the parts that make contact differ from the body that has the mass by {:.2} %: choose a smaller `crust`",
            100.0 * worst
        );
    }
    if let Some(cut) = &shape.report.decomposition {
        let _ = writeln!(
            text,
            "    mesh of {} triangles cut into {} pieces, {} united with others, {} flat ones dropped{}; volume error of the parts {:+.2} %",
            cut.triangles,
            cut.pieces,
            cut.merged,
            cut.dropped,
            if cut.cached { " (kept from an earlier run)" } else { "" },
            100.0 * cut.volume_error
        );
        if cut.volume_error.abs() > LARGE_ERROR {
            let _ = writeln!(
                text,
                "    warning: the parts are a coarse likeness of the mesh: raise `max_parts` or `resolution`"
            );
        }
    }
    Ok(text)
}

/// Difference of mass properties that is worth a warning (-).
const NOTABLE_DIFFERENCE: f64 = 2e-3;

/// Volume error of a decomposition that is worth a warning (-).
const LARGE_ERROR: f64 = 0.05;
