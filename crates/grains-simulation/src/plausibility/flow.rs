//! What is odd about the fluid, its boundaries and its drive.

use super::setting::{Remark, Setting};
use crate::fluid::fastest;
use grains_case::{BoundaryKind, Case, Drive, Expression, Face, Fluid, Insert, Kernel, TimeStep};

/// Conditions that hold somewhere on the boundary of the fluid, by their index in the case.
pub(super) fn conditions<'a>(case: &'a Case, fluid: &'a Fluid) -> Vec<usize> {
    let open = Face::ALL.into_iter().filter(|face| !case.domain.periodic[face.axis()]);
    open.flat_map(|face| {
        let on_face = fluid.on_face(face);
        on_face.whole.into_iter().chain(on_face.patches)
    })
    .collect()
}

/// Speed into the domain (m/s) that an inlet imposes, if it is a number.
pub(super) fn speed_inwards(fluid: &Fluid, index: usize) -> Option<f64> {
    let boundary = &fluid.boundary[index];
    match &boundary.kind {
        BoundaryKind::ParabolicInlet { mean } => Some(*mean),
        BoundaryKind::Inlet { velocity } => match velocity[boundary.face.axis()] {
            Expression::Number(normal) => Some(if boundary.face.is_upper() { -normal } else { normal }),
            Expression::Formula(_) => None,
        },
        kind => match kind.flow(fluid.density) {
            Some((Expression::Number(flow), factor)) => Some(flow * factor),
            _ => None,
        },
    }
}

pub(super) fn inlet_outwards(s: &Setting) -> Vec<Remark> {
    let Some(fluid) = &s.case.fluid else { return Vec::new() };
    let all = conditions(s.case, fluid);
    // Without an outlet, what one inlet blows in another has to take out.
    if !all.iter().any(|&i| fluid.boundary[i].kind.imposes_pressure()) {
        return Vec::new();
    }
    let outwards = all.into_iter().filter(|&i| speed_inwards(fluid, i).is_some_and(|speed| speed < 0.0));
    outwards
        .map(|i| {
            let boundary = &fluid.boundary[i];
            let (axis, face) = (boundary.face.axis(), boundary.face.name());
            let key = match boundary.kind {
                BoundaryKind::ParabolicInlet { .. } => format!("fluid.boundary[{i}].mean"),
                BoundaryKind::FlowInlet { .. } => format!("fluid.boundary[{i}].kind"),
                _ => format!("fluid.boundary[{i}].velocity[{axis}]"),
            };
            (key, format!("this inlet on {face} blows out of the domain, so fluid is sucked in through the outlet; change the sign"))
        })
        .collect()
}

pub(super) fn outlet_alone(s: &Setting) -> Vec<Remark> {
    let Some(fluid) = &s.case.fluid else { return Vec::new() };
    let all = conditions(s.case, fluid);
    let mut pressures = all.iter().filter_map(|&i| match fluid.boundary[i].kind {
        BoundaryKind::Outlet { pressure } => Some((i, pressure)),
        _ => None,
    });
    let Some((first, pressure)) = pressures.next() else { return Vec::new() };
    let is_driven = all.iter().any(|&i| match &fluid.boundary[i].kind {
        kind if kind.imposes_flow() => true,
        BoundaryKind::PressureInlet { .. } => true,
        BoundaryKind::Wall { velocity } => *velocity != [0.0; 3],
        _ => false,
    });
    let still = [Expression::Number(0.0), Expression::Number(0.0), Expression::Number(0.0)];
    let is_set_going = fluid.initial.velocity != still || pressures.any(|(_, other)| other != pressure);
    let has_drive = match &fluid.drive {
        Some(Drive::PressureGradient { gradient }) => *gradient != [0.0; 3],
        Some(Drive::MeanVelocity { velocity, .. } | Drive::MeanFlux { velocity, .. }) => {
            *velocity != [0.0; 3]
        }
        None => false,
    };
    // Particles that come or go later displace fluid.
    let come = |insert: &Insert| insert.start > 0.0 || insert.batch.is_some() || insert.velocity != [0.0; 3];
    let is_displaced =
        s.has_moving_particles() && (s.case.inserts.iter().any(come) || !s.domain().outlets.is_empty());
    if is_driven || is_set_going || has_drive || is_displaced {
        return Vec::new();
    }
    let message = "an outlet, but nothing lets fluid in: it stays at rest, or moves with the particles alone; add [[fluid.boundary]] with kind = \"inlet\"";
    vec![(format!("fluid.boundary[{first}].kind"), message.into())]
}

pub(super) fn fine_cells(s: &Setting) -> Vec<Remark> {
    let Some((fluid, coupling)) = s.case.fluid.as_ref().and_then(|f| Some((f, f.coupling.as_ref()?))) else {
        return Vec::new();
    };
    if s.case.inserts.is_empty() || fluid.resolved.is_some() {
        return Vec::new();
    }
    let widths = (0..3).filter(|&a| fluid.cells[a] > 1).map(|a| fluid.cell_widths(&s.case.domain, a)[0]);
    let ratio = widths.fold(f64::INFINITY, f64::min) / s.diameters()[1];
    match coupling.kernel {
        Kernel::Cube if ratio < 3.0 => vec![(
            "fluid.coupling.kernel".into(),
            format!(
                "embedded cubes are for cells of three diameters and more, here some are {ratio:.2}: void fractions will be rough; take {{ kind = \"smooth\" }} or larger cells"
            ),
        )],
        Kernel::Smooth { .. } if ratio < 1.0 => vec![(
            "fluid.cells".into(),
            format!(
                "some cells are {ratio:.2} diameters wide, and drag laws are for flow averaged over several particles: cost without accuracy; take cells of 1.5 diameters and more, or [fluid] resolved with 8 cells across a particle"
            ),
        )],
        _ => Vec::new(),
    }
}

/// Steps of the fluid that pass its CFL number by what the case imposes alone.
pub(super) fn cfl_exceeded(s: &Setting) -> Vec<Remark> {
    let Some(fluid) = &s.case.fluid else { return Vec::new() };
    let is_alone = s.case.inserts.is_empty() || s.case.holds_particles();
    let fastest = fastest(s.case, fluid);
    let (limit, dt) = (fluid.cfl / fastest.rate, s.steps[0]);
    if dt > (1.0 + 1e-9) * limit && (!is_alone || s.case.time.dt != TimeStep::Auto) {
        let message = format!(
            "a step of {dt:.3e} s has CFL number {:.3} at the {:.4} m/s imposed, beyond fluid.cfl = {}: the run ends where the flow gets so fast; take {limit:.2e} or less, or raise fluid.cfl, up to 1",
            fastest.rate * dt,
            fastest.speed,
            fluid.cfl
        );
        return vec![("time.dt".into(), message)];
    }
    let given = fluid.coupling.as_ref().filter(|_| !is_alone).and_then(|coupling| coupling.particle_steps);
    match given {
        Some(count) if count as f64 * dt > (1.0 + 1e-9) * limit => {
            let message = format!(
                "{:.3e} s have CFL number {:.3} at the {:.4} m/s imposed, beyond fluid.cfl = {}: the fluid takes fewer particle steps there; {} would do, or raise fluid.cfl, up to 1",
                count as f64 * dt,
                fastest.rate * dt * count as f64,
                fastest.speed,
                fluid.cfl,
                (limit / dt) as u64
            );
            vec![("fluid.coupling.particle_steps".into(), message)]
        }
        _ => Vec::new(),
    }
}

/// A periodic mixture that gravity accelerates for ever, as neither a wall nor a drive holds it.
pub(super) fn endless_acceleration(s: &Setting) -> Vec<Remark> {
    let Some(fluid) = s.case.fluid.as_ref().filter(|_| s.has_moving_particles()) else { return Vec::new() };
    let domain = s.domain();
    // What does not slip on a face that is not periodic holds the flow along the other axes.
    let holds = |face: Face| {
        let on_face = fluid.on_face(face);
        let is_slippery = |i: usize| matches!(fluid.boundary[i].kind, BoundaryKind::Symmetry);
        let conditions: Vec<usize> = on_face.whole.into_iter().chain(on_face.patches).collect();
        !domain.periodic[face.axis()]
            && fluid.cells[face.axis()] > 1
            && (conditions.is_empty() || !conditions.into_iter().all(is_slippery))
    };
    let mut remarks = Vec::new();
    for a in (0..3).filter(|&a| domain.periodic[a] && s.case.gravity[a] != 0.0 && fluid.cells[a] > 1) {
        let is_driven = match &fluid.drive {
            Some(Drive::PressureGradient { gradient }) => gradient[a] != 0.0,
            Some(Drive::MeanVelocity { axes, .. } | Drive::MeanFlux { axes, .. }) => axes[a],
            None => false,
        };
        if is_driven
            || Face::ALL.into_iter().any(holds)
            || s.walls.iter().any(|wall| !wall.surfaces.is_empty())
        {
            continue;
        }
        let axis = ["x", "y", "z"][a];
        let message = format!(
            "the domain is periodic along {axis}, nothing holds particles or fluid there and nothing drives them against gravity: both accelerate for ever; add [fluid.drive] with kind = \"mean_flux\", velocity = [0, 0, 0] and axes[{a}] = true to let particles settle while the mixture as a whole stays"
        );
        remarks.push((format!("gravity[{a}]"), message));
    }
    remarks
}
