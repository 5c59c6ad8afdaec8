//! Walls that bound the fluid: what it can be bounded by.

use super::{Fluid, ResolvedMethod};
use crate::case::Case;
use crate::check::Checker;
use crate::sections::motion::Motion;
use crate::sections::wall::{FluidSide, Wall, WallKind};

/// Smallest cosine of two directions that are one.
const ALONG: f64 = 1.0 - 1e-9;
/// Largest cosine of two directions at a right angle.
const ACROSS: f64 = 1e-9;

/// Refuses walls that cannot bound the fluid.
pub(crate) fn check_walls(case: &Case, checker: &mut Checker) {
    for (i, wall) in case.walls.iter().enumerate() {
        if let Some(message) = slip_of(wall, case) {
            checker.error(&format!("wall[{i}].slip"), message);
        }
        let Some(side) = wall.fluid else { continue };
        let key = format!("wall[{i}].fluid");
        let Some(fluid) = &case.fluid else {
            checker.error(&key, "there is no fluid; add [fluid], or remove it".into());
            continue;
        };
        let refused = side_of(wall, side).or_else(|| flow_of(fluid, case)).or_else(|| motion_of(wall));
        if let Some(message) = refused.or_else(|| flat_of(fluid, wall)) {
            checker.error(&key, message);
        }
    }
}

/// Why the wall has no such side, if so.
fn side_of(wall: &Wall, side: FluidSide) -> Option<String> {
    let message = match (&wall.kind, side) {
        (WallKind::Plane { .. }, FluidSide::Inside | FluidSide::Outside) => {
            "a plane has no inside; take \"particles\", the side its normal points to"
        }
        (WallKind::Mesh { .. } | WallKind::Polygons { .. }, FluidSide::Particles) => {
            "particles meet both sides of this surface; say whether the fluid is \"inside\" or \"outside\" it"
        }
        (WallKind::Cylinder { height, caps: false, .. }, _) if height.is_finite() => {
            "an open tube is a sheet without thickness, of which no side is solid; remove height, set caps = true, or give a closed mesh of its wall"
        }
        _ => return None,
    };
    Some(message.into())
}

/// Why the flow cannot be bounded by walls, if so.
fn flow_of(fluid: &Fluid, case: &Case) -> Option<String> {
    if fluid.coupling.is_some() && case.inserts.is_empty() {
        return Some("fluid.coupling is without effect, for there are no particles; remove it".into());
    }
    let has_multipliers =
        fluid.resolved.as_ref().is_some_and(|resolved| resolved.method == ResolvedMethod::Multiplier);
    has_multipliers.then(|| "walls have no multipliers; take fluid.resolved.method = \"direct\"".into())
}

/// Why the fluid cannot slip along a wall, if so.
fn slip_of(wall: &Wall, case: &Case) -> Option<String> {
    let message = match case.fluid.as_ref().map(|fluid| fluid.coupling.is_some() && !case.inserts.is_empty())
    {
        _ if !wall.slip => return None,
        _ if wall.fluid.is_none() => {
            "this wall does not bound the fluid; say on which side that is (fluid), or remove it"
        }
        Some(true) | None => return None,
        Some(false) => {
            "the fluid sticks to walls that the grid resolves; remove it, or average over the particles (fluid.coupling)"
        }
    };
    Some(message.into())
}

/// Why a wall that moves so cannot bound the fluid, if so.
fn motion_of(wall: &Wall) -> Option<String> {
    let is_loaded = matches!(wall.motion, Some(Motion::Load { .. }));
    is_loaded.then(|| {
        "a load moves this wall against contact forces, those of the fluid left out; remove it, or prescribe the motion".into()
    })
}

/// Why a flow in two dimensions cannot be bounded by a wall, if so: it must be the same in all sections.
fn flat_of(fluid: &Fluid, wall: &Wall) -> Option<String> {
    let flat = (0..3).find(|&a| fluid.cells[a] == 1)?;
    let is_prism = match &wall.kind {
        WallKind::Plane { normal, .. } => normal[flat].abs() < ACROSS,
        WallKind::Box { .. } => true,
        WallKind::Cylinder { axis, .. } => axis[flat].abs() > ALONG,
        WallKind::Cone { .. }
        | WallKind::Revolution { .. }
        | WallKind::Mesh { .. }
        | WallKind::Polygons { .. } => false,
    };
    let turns_in_plane =
        wall.motion.as_ref().and_then(Motion::axis).is_none_or(|(_, axis)| axis[flat].abs() > ALONG);
    let name = ['x', 'y', 'z'][flat];
    (!is_prism || !turns_in_plane).then(|| {
        format!(
            "a flow in two dimensions is bounded by planes and cylinders along {name}, the axis of one cell, and boxes, which turn about it if they do; give {name} more cells, or another wall"
        )
    })
}
