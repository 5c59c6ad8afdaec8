//! What `check` finds of bodies that the grid resolves.

use crate::fluid::resolved::lubrication;
use crate::fluid::setup::{diffusion_step, narrowest};
use crate::insertion::KindRange;
use grains_case::{Case, Fluid, Resolved, ResolvedMethod};
use grains_dem::Catalogue;
use grains_geometry::Vec3;
use grains_resolved::surface_points;
use std::f64::consts::PI;

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
    /// Max. points of multipliers on the surface of one.
    points: usize,
}

/// Bodies that the grid resolves.
#[derive(Clone, Debug, PartialEq)]
pub struct ResolvedReport {
    /// Cells across the sphere of equal volume of the smallest and the largest body, in two dimensions across the disc (-).
    pub cells_across: [f64; 2],
    /// Cells across the thinnest part of any (-).
    pub cells_across_thinnest: f64,
    /// Velocities that the largest body imposes (-).
    pub imposed_velocities: f64,
    /// Multipliers on the surface of the largest body and inside it (-), if it has any.
    pub multipliers: Option<[f64; 2]>,
    /// Why the cells are too large, if they are.
    pub too_coarse: Option<TooCoarse>,
    /// The lubrication that the grid does not resolve, if the case asks for it.
    pub lubrication: Option<LubricationRange>,
    /// Longest step of the fluid by the diffusion number (s).
    pub max_diffusion_step: f64,
}

/// Why cells are too large for resolved bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TooCoarse {
    /// The flow does not resolve the thinnest part.
    Part {
        /// Cells that it takes (-).
        cells: f64,
        /// Width of cells that would do (m).
        max_width: f64,
    },
    /// Drag on the smallest body is off by ten percent and more.
    Body {
        /// Cells that it takes (-).
        cells: f64,
    },
}

/// Gaps in which lubrication acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LubricationRange {
    /// Largest gap (m).
    pub range: f64,
    /// Smallest gap over the radius (-).
    pub min_gap: f64,
}

/// Bodies of some kinds on the grid of a fluid.
pub fn report(
    case: &Case,
    catalogue: &Catalogue,
    fluid: &Fluid,
    resolved: &Resolved,
    kinds: &[KindRange],
) -> ResolvedReport {
    let width = narrowest(case, fluid);
    let has_multipliers = resolved.method == ResolvedMethod::Multiplier;
    let spacing = has_multipliers.then_some(resolved.point_spacing * width);
    let found = extremes((case, fluid), catalogue, kinds, spacing);
    let [smallest, largest] = found.diameters.map(|d| d / width);
    let (components, dimensions, measure) = match fluid.cells.contains(&1) {
        true => (2.0, 2, PI / 4.0),
        false => (3.0, 3, PI / 6.0),
    };
    let nodes = |cells: f64| components * measure * cells.powi(dimensions);
    let too_coarse = if found.thinnest < THIN * width {
        Some(TooCoarse::Part { cells: THIN, max_width: found.thinnest / THIN })
    } else if (10.0 * smallest).round() < 10.0 * COARSE {
        // As it is printed.
        Some(TooCoarse::Body { cells: COARSE })
    } else {
        None
    };
    ResolvedReport {
        cells_across: [smallest, largest],
        cells_across_thinnest: found.thinnest / width,
        imposed_velocities: nodes(largest),
        multipliers: has_multipliers
            .then(|| [components * found.points as f64, nodes((largest - 2.0).max(0.0))]),
        too_coarse,
        lubrication: lubrication(case)
            .map(|given| LubricationRange { range: given.range, min_gap: given.min_gap }),
        max_diffusion_step: diffusion_step(case, fluid, resolved),
    }
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
            Some(depth) => 2.0 * (shape.volume / (PI * depth)).sqrt(),
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
