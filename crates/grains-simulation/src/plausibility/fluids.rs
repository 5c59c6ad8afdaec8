//! Properties of fluids and temperatures that no substance has, and flows that carry nothing or carry particles off.

use super::flow::{conditions, speed_inwards};
use super::setting::{Remark, Setting};
use super::walls::bare_faces;
use grains_case::{BoundaryKind, Expression, Face, Insert, Scalar, ScalarBoundaryKind, ScalarKind};

/// A kinematic viscosity in place of the dynamic one, or millipascal seconds.
pub(super) fn odd_viscosity(s: &Setting) -> Vec<Remark> {
    /// Densities (kg/m³) of liquids, and of gases near the ambient pressure; 1 is that of cases without units.
    const LIQUID: [f64; 2] = [300.0, 20_000.0];
    const GAS: [f64; 2] = [1.05, 5.0];
    let Some(fluid) = s.case.fluid.as_ref().filter(|fluid| fluid.rheology.is_none()) else {
        return Vec::new();
    };
    let is_within = |[low, high]: [f64; 2]| (low..=high).contains(&fluid.density);
    let (rho, mu) = (fluid.density, fluid.viscosity);
    let message = if is_within(LIQUID) && mu < 5e-5 {
        format!(
            "no liquid of {rho} kg/m3 is so thin (water: 1e-3 Pa s), and drag is as much too small; a kinematic viscosity (m2/s) times the density is {:.1e} Pa s; of a gas mend fluid.density",
            mu * rho
        )
    } else if is_within(GAS) && mu > 1e-3 {
        format!(
            "no gas of {rho} kg/m3 is so thick (air: 1.8e-5 Pa s), and drag is as much too large; the unit is Pa s: {mu} mPa s are {:.1e}",
            mu / 1000.0
        )
    } else {
        return Vec::new();
    };
    vec![("fluid.viscosity".into(), message)]
}

/// Temperatures in degrees Celsius beside such in kelvin.
pub(super) fn celsius_beside_kelvin(s: &Setting) -> Vec<Remark> {
    /// Kelvin below which the one, and above which the other is meant.
    const DOUBTFUL: f64 = 200.0;
    const USUAL: f64 = 250.0;
    let temperatures = temperatures(s);
    let highest = temperatures.iter().map(|(_, value)| *value).fold(0.0, f64::max);
    let lowest =
        temperatures.into_iter().filter(|(_, value)| *value >= 2.0).min_by(|a, b| a.1.total_cmp(&b.1));
    let Some((key, value)) = lowest.filter(|(_, value)| *value < DOUBTFUL && highest > USUAL) else {
        return Vec::new();
    };
    let message = format!(
        "{value} K are {:.0} degrees Celsius, and {highest} K stand beside them: heat flows by that difference; temperatures are in K: {value} degrees Celsius are {:.2}",
        value - 273.15,
        value + 273.15
    );
    vec![(key, message)]
}

/// Every temperature of a case that is a number, with its key.
fn temperatures(s: &Setting) -> Vec<(String, f64)> {
    let case = s.case;
    let mut found: Vec<(String, f64)> = Vec::new();
    if let Some(heat) = &case.heat {
        found.push(("heat.temperature".into(), heat.temperature));
        found.extend(heat.radiation.iter().map(|r| ("heat.radiation.surroundings".into(), r.surroundings)));
    }
    let inserts = case.inserts.iter().enumerate();
    found.extend(
        inserts.filter_map(|(i, insert)| Some((format!("insert[{i}].temperature"), insert.temperature?))),
    );
    let walls = case.walls.iter().enumerate();
    found.extend(walls.filter_map(|(i, wall)| Some((format!("wall[{i}].temperature"), wall.temperature?))));
    for (k, scalar) in case.fluid.iter().flat_map(|fluid| fluid.scalar.iter().enumerate()) {
        found.extend(
            temperatures_of(scalar)
                .into_iter()
                .map(|(key, value)| (format!("fluid.scalar[{k}].{key}"), value)),
        );
    }
    found
}

/// Those of one scalar of a fluid.
fn temperatures_of(scalar: &Scalar) -> Vec<(String, f64)> {
    let evaporation = scalar.particles.as_ref().and_then(|particles| particles.evaporation.as_ref());
    let mut found: Vec<(String, f64)> =
        evaporation.iter().map(|e| ("particles.evaporation.boiling_point".into(), e.boiling_point)).collect();
    if !matches!(scalar.kind, ScalarKind::Temperature { .. }) {
        return found;
    }
    let mut take = |key: String, value: &Expression| {
        if let Expression::Number(value) = value {
            found.push((key, *value));
        }
    };
    take("initial".into(), &scalar.initial);
    for (i, boundary) in scalar.boundary.iter().enumerate() {
        match &boundary.kind {
            ScalarBoundaryKind::Value { value } => take(format!("boundary[{i}].value"), value),
            ScalarBoundaryKind::Transfer { ambient, .. } => take(format!("boundary[{i}].ambient"), ambient),
            _ => {}
        }
    }
    if let Some(buoyancy) = &scalar.buoyancy {
        found.push(("buoyancy.reference".into(), buoyancy.reference));
    }
    found
}

/// Inlets through which nothing flows.
pub(super) fn idle_inlets(s: &Setting) -> Vec<Remark> {
    let Some(fluid) = &s.case.fluid else { return Vec::new() };
    let idle = conditions(s.case, fluid).into_iter().filter(|&i| speed_inwards(fluid, i) == Some(0.0));
    let message =
        "nothing comes in: the velocity has no component into the domain; give one, or take kind = \"wall\"";
    let remark = |i: usize| {
        let key = match fluid.boundary[i].kind {
            BoundaryKind::Inlet { .. } => "velocity",
            BoundaryKind::ParabolicInlet { .. } => "mean",
            _ => "kind",
        };
        (format!("fluid.boundary[{i}].{key}"), message.to_string())
    };
    idle.map(remark).collect()
}

/// So few cells along every axis that no flow is resolved.
pub(super) fn few_cells(s: &Setting) -> Vec<Remark> {
    /// Fewest cells along one axis at least (-).
    const FEWEST: u64 = 4;
    let Some(fluid) = &s.case.fluid else { return Vec::new() };
    let most = fluid.cells.into_iter().max().unwrap_or(0);
    if most >= FEWEST {
        return Vec::new();
    }
    let message = format!(
        "at most {most} along an axis: no profile of the flow is resolved; take 8 and more along that of the flow"
    );
    vec![("fluid.cells".into(), message)]
}

/// Particles lighter than the fluid under a face through which they are lost.
pub(super) fn rise_out(s: &Setting) -> Vec<Remark> {
    let Some(fluid) = s.case.fluid.as_ref().filter(|_| s.has_moving_particles()) else { return Vec::new() };
    let free = s.case.inserts.iter().filter(|insert| !insert.is_prescribed());
    let materials = free.flat_map(|insert: &Insert| &insert.particles).map(|c| &s.case.materials[c.material]);
    let heaviest = materials.filter_map(|material| material.density).fold(0.0, f64::max);
    let is_above = |face: &Face| s.case.gravity[face.axis()] * if face.is_upper() { 1.0 } else { -1.0 } < 0.0;
    let bare = bare_faces(s.case, s.walls).into_iter().find(is_above);
    let Some(face) = bare.filter(|_| heaviest < fluid.density) else { return Vec::new() };
    let message = format!(
        "all particles are lighter, {heaviest} kg/m3 at most: they rise, and the run ends when one gets to {}; mend material.density or this (kg/m3), or add a [[wall]] there or the face to domain.outlets",
        face.name()
    );
    vec![("fluid.density".into(), message)]
}

/// Inlets so fast that the fluid would be compressed, as where flows are in g/s or speeds in mm/s.
pub(super) fn fast_inlet(s: &Setting) -> Vec<Remark> {
    /// Density (kg/m3) that parts gases from liquids, and their largest usual speeds (m/s).
    const DENSE: f64 = 100.0;
    const USUAL: [f64; 2] = [100.0, 50.0];
    let Some(fluid) = &s.case.fluid else { return Vec::new() };
    let usual = USUAL[usize::from(fluid.density > DENSE)];
    let remark = |i: usize| {
        let boundary = &fluid.boundary[i];
        let axis = boundary.face.axis();
        let (key, remedy) = match boundary.kind {
            BoundaryKind::FlowInlet { mass_flow: Some(_), .. } => {
                ("mass_flow", "the unit is kg/s: 1 g/s is 1e-3")
            }
            BoundaryKind::FlowInlet { .. } => ("volume_flow", "the unit is m3/s: 1 l/min is 1.67e-5"),
            BoundaryKind::ParabolicInlet { .. } => ("mean", "the unit is m/s: 1 mm/s is 1e-3"),
            _ => ("velocity", "the unit is m/s: 1 mm/s is 1e-3"),
        };
        let extents = s.domain().extents();
        let whole = || (0..3).filter(|&a| a != axis).map(|a| extents[a]).product();
        let area: f64 = boundary.part.outline().map_or_else(whole, |outline| outline.area(axis));
        let is_flow = boundary.kind.flow(fluid.density).is_some();
        let speed = speed_inwards(fluid, i)?.abs() / if is_flow { area } else { 1.0 };
        let message = format!(
            "fluid comes in at {speed:.1} m/s, and the flow is computed without its compression, which counts beyond {usual} m/s; time steps are as much shorter; {remedy}"
        );
        (speed > usual).then(|| (format!("fluid.boundary[{i}].{key}"), message))
    };
    conditions(s.case, fluid).into_iter().filter_map(remark).collect()
}
