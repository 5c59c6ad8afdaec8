//! What `check` says of bodies that the grid resolves.

use crate::population::KindRange;
use grains_case::{Case, Extrapolation, Fluid, Insert, Resolved, ResolvedMethod};
use grains_dem::Catalogue;
use grains_geometry::Vec3;
use grains_resolved::surface_points;

/// Cells across a body below which its drag is off by ten percent and more.
const COARSE: f64 = 8.0;
/// Cells across the thinnest part of a body below which no flow is resolved around it.
const THIN: f64 = 2.0;

/// The bodies that are resolved the worst and the best.
struct Extremes {
    /// Diameters of the spheres of their volumes, in two dimensions of the discs of their sections (m).
    diameters: [f64; 2],
    /// Smallest extent of any part, in two dimensions in the plane (m).
    thinnest: f64,
    /// Most points of multipliers on the surface of one.
    points: usize,
}

/// Lines about bodies of some kinds.
pub fn lines(
    case: &Case,
    catalogue: &Catalogue,
    fluid: &Fluid,
    resolved: &Resolved,
    kinds: &[KindRange],
) -> Vec<String> {
    let width = narrowest(case, fluid);
    let spacing = (resolved.method == ResolvedMethod::Multiplier).then_some(resolved.point_spacing * width);
    let found = extremes((case, fluid), catalogue, kinds, spacing);
    let what = [
        ("free bodies", case.inserts.iter().any(|insert| !insert.is_prescribed())),
        ("bodies that stay where they are", case.inserts.iter().any(Insert::is_fixed)),
        (
            "bodies of prescribed motion",
            case.inserts.iter().any(|insert| insert.is_prescribed() && !insert.is_fixed()),
        ),
    ];
    let what: Vec<&str> = what.into_iter().filter(|(_, is_there)| *is_there).map(|(name, _)| name).collect();
    let what = what.join(", ");
    let how = match (resolved.method, resolved.extrapolation(&case.inserts)) {
        (ResolvedMethod::Multiplier, _) => format!("multipliers {} cells apart", resolved.point_spacing),
        (_, Extrapolation::Cubic) => "cubics".into(),
        (_, Extrapolation::Quadratic) => "parabolas".into(),
        (_, Extrapolation::Linear) => "straight lines".into(),
        (_, Extrapolation::Rigid) => "nothing".into(),
    };
    let [smallest, largest] = found.diameters.map(|d| d / width);
    let across = if largest > 1.001 * smallest {
        format!("{smallest:.1} to {largest:.1}")
    } else {
        format!("{smallest:.1}")
    };
    let components = if fluid.cells.contains(&1) { 2.0 } else { 3.0 };
    let nodes = |cells: f64| match fluid.cells.contains(&1) {
        true => components * std::f64::consts::PI / 4.0 * cells.powi(2),
        false => components * std::f64::consts::PI / 6.0 * cells.powi(3),
    };
    let mut lines = vec![
        format!("resolved       {what}; velocities next to surfaces by {how}"),
        format!(
            "  cells        {across} across the {} of equal size, {:.1} across the thinnest part; about {:.0} \
             velocities imposed by the largest",
            if fluid.cells.contains(&1) { "disc" } else { "sphere" },
            found.thinnest / width,
            nodes(largest)
        ),
    ];
    if resolved.method == ResolvedMethod::Multiplier {
        lines.push(format!(
            "  multipliers  about {:.0} on the surface and {:.0} inside the largest",
            components * found.points as f64,
            nodes((largest - 2.0).max(0.0))
        ));
    }
    if found.thinnest < THIN * width {
        lines.push(format!(
            "  warning: parts thinner than {THIN} cells: the fluid hardly sees them; take cells of at most {:.3e} m",
            found.thinnest / THIN
        ));
    } else if (10.0 * smallest).round() < 10.0 * COARSE {
        // As rounded above.
        lines.push(format!(
            "  warning: fewer than {COARSE} cells across the smallest: drag is off by ten percent and more"
        ));
    }
    let by_diffusion = super::super::setup::diffusion_step(fluid, resolved, width);
    if let Some(films) = super::super::lubrication(case) {
        lines.push(format!(
            "  lubrication  films thinner than {:.3e} m between spheres and at walls, down to {} of the radius",
            films.range, films.min_gap
        ));
    }
    lines.push(format!(
        "  diffusion    at most {by_diffusion:.3e} s per step of the fluid (fluid.resolved.diffusion_number = {}), {:.0} \
         steps to the end",
        resolved.diffusion_number,
        (case.time.end / by_diffusion).ceil()
    ));
    lines
}

/// Extremes of all bodies, with points on their surfaces a spacing (m) apart if there is one.
fn extremes(
    (case, fluid): (&Case, &Fluid),
    catalogue: &Catalogue,
    kinds: &[KindRange],
    spacing: Option<f64>,
) -> Extremes {
    let flat = (0..3).find(|&a| fluid.cells[a] == 1);
    let depth = flat.map(|a| case.domain.upper[a] - case.domain.lower[a]);
    let mut found = Extremes { diameters: [f64::INFINITY, 0.0], thinnest: f64::INFINITY, points: 0 };
    for range in kinds {
        let shape = catalogue.shape(range.kind);
        let diameter = match depth {
            Some(depth) => 2.0 * (shape.volume / (std::f64::consts::PI * depth)).sqrt(),
            None => shape.sphere_equivalent_diameter(),
        };
        found.diameters[0] = found.diameters[0].min(diameter * range.smallest);
        found.diameters[1] = found.diameters[1].max(diameter * range.largest);
        if let Some(spacing) = spacing {
            // In two dimensions the outline of a section, here across the axis of a prism.
            let across = flat.map(|_| Vec3::z());
            let points = surface_points(shape, spacing / range.largest, across.as_ref());
            found.points = found.points.max(points.len());
        }
        for part in &shape.parts {
            let mut halves: [f64; 3] = part.half_extents.into();
            halves.sort_by(f64::total_cmp);
            // Bodies of two dimensions lie with their thinnest side across the plane.
            let half = halves[usize::from(depth.is_some())];
            found.thinnest = found.thinnest.min(2.0 * half * range.smallest);
        }
    }
    found
}

/// Width of the narrowest cells along the axes of the flow (m).
fn narrowest(case: &Case, fluid: &Fluid) -> f64 {
    let widths = (0..3).filter(|&a| fluid.cells[a] > 1).map(|a| fluid.cell_widths(&case.domain, a)[0]);
    widths.fold(f64::INFINITY, f64::min)
}
