//! What is told of the fluid: columns of the time series, fields in the cells, and their means over time.

use super::scalars::ScalarNames;
use super::{FluidPhase, scalars, steady, walls};
use crate::error::RunError;
use grains_case::{Boundary, BoundaryKind, Case, FluidField, ProfileKind};
use grains_comm::MpiTransport;
use grains_dem::Dem;
use grains_domain::Transport;
use grains_fluid::{Centre, Field, Grid, Layout};
use grains_resolved::FlowLink;

/// Columns of the fluid in the time series. The pressure drop is that between the first and the last layer of cells along the axis
/// that fluid enters and leaves along (without such, along gravity or x), among particles that between the boundaries; `drive` is the force −dp/dx of an imposed mean
/// gradient; what is not accounted for of the momentum grows when particles leave that the fluid owes something; the
/// superficial velocity is the mean of ε u over the domain. NaN where something is not measured. At the surfaces of resolved
/// bodies, where velocities are imposed after the projection, the divergence is not zero.
const COLUMNS: [(&str, &str); 16] = [
    ("fluid_dt", "s"),
    ("fluid_cfl", "-"),
    ("fluid_kinetic", "J"),
    ("fluid_divergence", "1/s"),
    ("pressure_drop", "Pa"),
    ("drive_x", "Pa/m"),
    ("drive_y", "Pa/m"),
    ("drive_z", "Pa/m"),
    ("pressure_iterations", "-"),
    ("min_void_fraction", "-"),
    ("solid_volume", "m3"),
    ("momentum_imbalance", "N s"),
    ("superficial_x", "m/s"),
    ("superficial_y", "m/s"),
    ("superficial_z", "m/s"),
    ("multiplier_iterations", "-"),
];

/// What comes back in through outlets over what passes them.
const BACKFLOW: (&str, &str) = ("outlet_backflow", "-");
/// Share from which it is warned of (-).
const NOTABLE: f64 = 0.01;

/// Whether fluid may leave a case through an outlet.
fn has_outlet(case: &Case) -> bool {
    let is_outlet = |boundary: &Boundary| matches!(boundary.kind, BoundaryKind::Outlet { .. });
    case.fluid.as_ref().is_some_and(|fluid| fluid.boundary.iter().any(is_outlet))
}

/// What is told of the flow's action on bodies: the force, buoyancy apart, and the torque, of each about its centre.
const OF_BODIES: [(&str, &str); 6] =
    [("fx", "N"), ("fy", "N"), ("fz", "N"), ("tx", "N m"), ("ty", "N m"), ("tz", "N m")];

/// Names and units of the columns that the fluid of a case adds to the time series.
pub fn columns(case: &Case) -> Vec<(String, &'static str)> {
    let Some(fluid) = &case.fluid else { return Vec::new() };
    let mut columns: Vec<_> = COLUMNS.iter().map(|&(name, unit)| (name.to_string(), unit)).collect();
    if fluid.resolved.is_some() && !case.inserts.is_empty() {
        let chosen = fluid.output.bodies.iter().map(|id| format!("body_{id}"));
        let prescribed = case.inserts.iter().filter(|i| i.is_prescribed() && !case.holds_particles());
        let prescribed = prescribed.map(|insert| format!("insert_{}_flow", insert.name));
        for name in std::iter::once("bodies".to_string()).chain(chosen).chain(prescribed) {
            columns.extend(OF_BODIES.map(|(what, unit)| (format!("{name}_{what}"), unit)));
        }
    }
    for (_, wall) in case.walls_of_fluid() {
        columns.extend(walls::COLUMNS.map(|(what, unit)| (format!("{}_flow_{what}", wall.name), unit)));
    }
    if fluid.steady.is_some() {
        let of_scalars = (!fluid.scalar.is_empty()).then_some(steady::OF_SCALARS);
        let all = steady::COLUMNS.into_iter().chain(of_scalars);
        columns.extend(all.map(|(name, unit)| (name.to_string(), unit)));
    }
    for profile in &fluid.profile {
        if let ProfileKind::Plane { .. } = profile.kind {
            columns.push((format!("{}_pressure", profile.name), "Pa"));
            columns.push((format!("{}_flow", profile.name), "m3/s"));
        }
    }
    columns.extend(scalars::columns(fluid));
    if has_outlet(case) {
        columns.push((BACKFLOW.0.to_string(), BACKFLOW.1));
    }
    columns
}

/// Key numbers of the fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FluidProgress {
    /// Steps of the fluid.
    pub step: u64,
    /// Whether nothing moves but the fluid.
    pub is_alone: bool,
    /// Its last time step (s).
    pub dt: f64,
    /// CFL number (-).
    pub cfl: f64,
    /// Kinetic energy (J).
    pub kinetic_energy: f64,
    /// Pressure drop (Pa).
    pub pressure_drop: f64,
    /// Iterations for the last pressure.
    pub iterations: f64,
}

impl FluidPhase {
    /// Key numbers, from a row of the time series.
    pub fn progress(&self, row: &[f64]) -> FluidProgress {
        FluidProgress {
            step: self.flow.state.step,
            is_alone: self.is_alone(),
            dt: row[0],
            cfl: row[1],
            kinetic_energy: row[2],
            pressure_drop: row[4],
            iterations: row[8],
        }
    }
}

/// What the cells hold: sums over samples, or one sample.
#[derive(Clone, Debug)]
pub struct Sums {
    /// Number of samples.
    pub samples: u64,
    /// u, v, w at the centres (m/s), p (Pa); among particles also ε (-), the flux of solid volume along x, y, z
    /// (m⁴/s per cell) and the solid volume (m³ per cell); where the viscosity varies that (Pa s); at last the scalars.
    pub fields: Vec<Field<Centre>>,
    /// Which of these there are.
    pub there: There,
}

/// Which fields a fluid has besides velocity and pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct There {
    /// Those of particles.
    pub particles: bool,
    /// The viscosity, as it varies.
    pub viscosity: bool,
    /// Number of scalars.
    pub scalars: usize,
}

impl There {
    /// Number of fields in [`Sums`].
    fn count(self) -> usize {
        (if self.particles { 9 } else { 4 }) + usize::from(self.viscosity) + self.scalars
    }
}

/// A field as it is written: one component, or three.
pub struct Observation {
    /// Its components, halo filled.
    pub components: Vec<Field<Centre>>,
}

impl Observation {
    /// Values of the own cells, x fastest, components side by side.
    pub fn interleaved(self) -> Vec<f64> {
        let width = self.components.len();
        let mut values =
            vec![
                0.0;
                self.components.first().map_or(0, |c| c.layout().cells.iter().product::<usize>()) * width
            ];
        for (k, component) in self.components.iter().enumerate() {
            values.iter_mut().skip(k).step_by(width).zip(component.own()).for_each(|(to, from)| *to = from);
        }
        values
    }
}

impl Sums {
    /// No samples yet.
    pub fn new(layout: Layout, there: There) -> Self {
        Self { samples: 0, fields: vec![Field::new(layout); there.count()], there }
    }

    /// Adds a sample.
    pub fn add(&mut self, sample: &Sums) {
        self.samples += sample.samples;
        self.fields.iter_mut().zip(&sample.fields).for_each(|(sum, field)| *sum += field);
    }

    /// The means as fields, of those that a case asks for; the solid velocity is that of the mean flux.
    pub fn into_observations(mut self, wanted: &[FluidField]) -> Vec<Observation> {
        let share = 1.0 / self.samples.max(1) as f64;
        let There { particles: has_particles, viscosity: varies, scalars } = self.there;
        let volumes = has_particles.then(|| self.fields.remove(8));
        let mut rest = self.fields.into_iter();
        let mut means = |count: usize| -> Vec<Field<Centre>> {
            let scaled = rest.by_ref().take(count).map(|mut field| {
                field.data_mut().iter_mut().for_each(|x| *x *= share);
                field
            });
            scaled.collect()
        };
        let (velocity, pressure) = (means(3), means(1));
        let [void_fraction, mut solid_velocity] =
            if has_particles { [means(1), means(3)] } else { Default::default() };
        let viscosity = if varies { means(1) } else { Vec::new() };
        let scalars = means(scalars);
        for (field, volumes) in solid_velocity.iter_mut().zip(volumes.iter().cycle()) {
            let pairs = field.data_mut().iter_mut().zip(volumes.data());
            pairs.for_each(|(x, v)| *x = if *v > 0.0 { *x / (share * v) } else { 0.0 });
        }
        let mut known = [
            (FluidField::Velocity, velocity),
            (FluidField::Pressure, pressure),
            (FluidField::VoidFraction, void_fraction),
            (FluidField::SolidVelocity, solid_velocity),
            (FluidField::Viscosity, viscosity),
            (FluidField::Scalars, scalars),
        ];
        let mut observations = Vec::new();
        for field in wanted.iter().filter(|field| is_there(field, self.there)) {
            let found = known.iter_mut().find(|(known, _)| known == field);
            let components = found.map(|(_, components)| std::mem::take(components)).unwrap_or_default();
            match field {
                FluidField::Scalars => {
                    observations.extend(components.into_iter().map(|c| Observation { components: vec![c] }));
                }
                _ => observations.push(Observation { components }),
            }
        }
        observations
    }
}

/// Name, unit and number of components of a field.
pub type Name = (&'static str, &'static str, usize);

fn names_of(field: &FluidField, scalars: &[ScalarNames]) -> Vec<Name> {
    match field {
        FluidField::Velocity => vec![("velocity", "m/s", 3)],
        FluidField::Pressure => vec![("pressure", "Pa", 1)],
        FluidField::VoidFraction => vec![("void_fraction", "-", 1)],
        FluidField::SolidVelocity => vec![("solid_velocity", "m/s", 3)],
        FluidField::Viscosity => vec![("viscosity", "Pa s", 1)],
        FluidField::Scalars => scalars.iter().map(|scalar| (scalar.field, scalar.unit, 1)).collect(),
    }
}

fn is_there(field: &FluidField, there: There) -> bool {
    match field {
        FluidField::Velocity | FluidField::Pressure => true,
        FluidField::VoidFraction | FluidField::SolidVelocity => there.particles,
        FluidField::Viscosity => there.viscosity,
        FluidField::Scalars => there.scalars > 0,
    }
}

impl FluidPhase {
    /// The fields that a case asks for and that there are.
    pub fn names(&self, wanted: &[FluidField]) -> Vec<Name> {
        let there = self.there();
        let wanted = wanted.iter().filter(|field| is_there(field, there));
        wanted.flat_map(|field| names_of(field, &self.scalar_names)).collect()
    }

    /// Which fields there are.
    pub(super) fn there(&self) -> There {
        There {
            particles: self.exchange.is_some() || self.resolved.is_some(),
            viscosity: self.flow.setup.viscosity_law.is_some(),
            scalars: self.scalar_names.len(),
        }
    }

    /// Values of the columns of the fluid in the time series; collective.
    pub fn row(&self, case: &Case, dem: &Dem, transport: &MpiTransport) -> Vec<f64> {
        let flow = &self.flow;
        let dt = self.report.dt;
        let [divergence, rate] = flow.divergence(transport);
        let along = main_axis(case);
        let last = flow.setup.grid.axis(along).cells() - 1;
        let mut drop = flow.mean_pressure(along, 0, transport) - flow.mean_pressure(along, last, transport);
        let (mut solid, mut void_fraction, mut imbalance) = ([0.0], [-1.0], 0.0);
        if let Some(exchange) = &self.exchange {
            let own = &dem.particles.bodies[..dem.particles.owned];
            solid[0] = own.iter().map(|body| exchange.coupling.volume(body)).sum();
            void_fraction[0] = -exchange.account.min_void_fraction;
            imbalance = exchange.imbalance(&dem.particles, transport).norm();
            drop += exchange.drop_at_boundaries(along, transport);
        }
        if self.resolved.is_some() {
            let own = &dem.particles.bodies[..dem.particles.owned];
            let densities = &dem.setup.catalogue.densities;
            solid[0] = own.iter().map(|body| body.mass / densities[body.kind.material as usize]).sum();
            // Neither is measured of bodies that the grid resolves.
            (void_fraction[0], imbalance) = (f64::NAN, f64::NAN);
        }
        transport.sum(&mut solid);
        if self.resolved.is_none() {
            transport.max(&mut void_fraction);
        }
        let (energy, iterations) = (flow.kinetic_energy(transport), self.report.solve.iterations as f64);
        let mut row = vec![dt, rate * dt, energy, divergence, drop];
        row.extend(flow.state.force);
        row.extend([iterations, -void_fraction[0], solid[0], imbalance]);
        row.extend((0..3).map(|axis| flow.mean_velocity(axis, transport)));
        row.push(self.resolved.as_ref().map_or(0.0, |resolved| resolved.bodies.iterations() as f64));
        if let Some(walls) = &self.enclosing {
            row.extend(walls.row());
        }
        if let Some(resolved) = &self.resolved {
            if !case.inserts.is_empty() {
                row.extend(loads_of_bodies(case, dem, transport));
            }
            row.extend(resolved.walls.row(&resolved.bodies.on_walls));
        }
        // Infinite is not what a table takes.
        let unsettled = self
            .steady
            .iter()
            .flat_map(|steady| steady.unsettled.into_iter().chain(steady.unsettled_scalars));
        row.extend(unsettled.map(|x| if x.is_finite() { x } else { f64::NAN }));
        for profile in case.fluid.iter().flat_map(|f| &f.profile) {
            if let ProfileKind::Plane { axis, at } = profile.kind {
                let axis = axis as usize;
                let (cell, node) = nearest(&flow.setup.grid, axis, at);
                row.push(flow.mean_pressure(axis, cell, transport));
                row.push(flow.flow_rate(axis, node, transport));
            }
        }
        row.extend(case.fluid.iter().flat_map(|fluid| scalars::row(fluid, flow, transport)));
        if has_outlet(case) {
            row.push(self.backflow(dem, transport));
        }
        row
    }

    /// What comes back in through outlets over what passes them (-), with a warning the first time that it is notable; collective.
    fn backflow(&self, dem: &Dem, transport: &MpiTransport) -> f64 {
        let [entering, leaving] = self.flow.outlet_flows(transport);
        let share = if entering > 0.0 { entering / (entering + leaving) } else { 0.0 };
        if share > NOTABLE && !self.is_told_of_backflow.replace(true) && transport.rank() == 0 {
            log::warn!(
                "t = {:.6e} s: {:.0} % of what passes the outlets comes back in; it brings no momentum, so the run is stable, but \
                 the flow there depends on where the domain ends: move the outlet downstream, or close the part through which \
                 it comes (told once, see outlet_backflow in series.csv)",
                dem.time(),
                100.0 * share
            );
        }
        share
    }

    /// The fields of the cells now, halo filled; collective.
    ///
    /// # Errors
    /// A particle beyond the halo.
    pub fn sample(&mut self, dem: &Dem, transport: &MpiTransport) -> Result<Sums, RunError> {
        let layout = self.flow.layout();
        let mut fields: Vec<Field<Centre>> = Vec::new();
        let mut extrapolated = self.flow.extrapolated_faces(transport);
        for axis in 0..3 {
            let mut field = Field::new(layout);
            let rows = layout.rows().flat_map(|row| row..row + layout.cells[0]);
            rows.zip(self.flow.centre_velocity(axis)).for_each(|(p, u)| field.data_mut()[p] = u);
            // Inside bodies theirs, not what continues the flow.
            if let Some(extrapolated) = &extrapolated {
                let (extrapolated, stride) = (extrapolated.component(axis), layout.strides()[axis]);
                let rows = layout.rows().flat_map(|row| row..row + layout.cells[0]);
                rows.for_each(|p| field.data_mut()[p] -= 0.5 * (extrapolated[p] + extrapolated[p - stride]));
            }
            fields.push(field);
        }
        extrapolated.take();
        fields.push(self.flow.state.pressure.clone());
        if let (Some(exchange), Some(mixture)) = (&mut self.exchange, &self.flow.mixture) {
            fields.push(mixture.void_fraction.clone());
            fields.extend(exchange.solid_flux(&dem.particles, layout, transport)?);
        }
        if let Some(resolved) = &self.resolved {
            fields.extend(resolved.void_and_flux(dem));
        }
        if self.flow.setup.viscosity_law.is_some() {
            fields.push(self.flow.dynamic_viscosity());
        }
        fields.extend(self.flow.scalars.iter().flat_map(|s| &s.all).map(|scalar| scalar.value.clone()));
        let mut all: Vec<&mut [f64]> = fields.iter_mut().map(Field::data_mut).collect();
        self.halo.fill(&mut all, transport);
        Ok(Sums { samples: 1, fields, there: self.there() })
    }
}

/// Force (N) and torque (N m) of the flow on all bodies together, on each that the case asks for, NaN while it is not there,
/// and on those of each insertion of prescribed motion; collective.
fn loads_of_bodies(case: &Case, dem: &Dem, transport: &MpiTransport) -> Vec<f64> {
    let chosen = case.fluid.as_ref().map_or(&[][..], |fluid| &fluid.output.bodies);
    // The last number tells how many ranks own the body.
    let of_guides = 1 + chosen.len();
    let mut sums = vec![[0.0; 7]; of_guides + dem.setup.prescribed.len()];
    let particles = &dem.particles;
    for ((id, body), cargo) in particles.ids.iter().zip(&particles.bodies).zip(&particles.cargo) {
        let link = FlowLink::read(cargo);
        let place = chosen.iter().position(|k| k == id).map(|k| k + 1);
        let guide = body.is_prescribed().then(|| of_guides + usize::from(body.prescribed) - 1);
        for sum in std::iter::once(0).chain(place).chain(guide) {
            let load = link.force.iter().chain(&link.torque).copied().chain([1.0]);
            sums[sum].iter_mut().zip(load).for_each(|(sum, x)| *sum += x);
        }
    }
    transport.sum(sums.as_flattened_mut());
    sums[1..of_guides].iter_mut().filter(|sum| sum[6] == 0.0).for_each(|sum| sum.fill(f64::NAN));
    sums.iter().flat_map(|sum| sum[..6].iter().copied()).collect()
}

/// The cell that holds a coordinate (m) and the node next to it; the first or last ones for those beyond.
fn nearest(grid: &Grid, axis: usize, at: f64) -> (usize, usize) {
    let cell = cell_of(grid, axis, at);
    let nodes = grid.axis(axis).nodes();
    (cell, cell + usize::from(at - nodes[cell] > nodes[cell + 1] - at))
}

/// The cell that holds a coordinate (m), the first or last one for those beyond.
pub fn cell_of(grid: &Grid, axis: usize, at: f64) -> usize {
    let nodes = grid.axis(axis).nodes();
    nodes[1..nodes.len() - 1].partition_point(|&node| node <= at)
}

/// The axis along which the pressure drop is taken: that which fluid enters and leaves along, or gravity's, or x without.
fn main_axis(case: &Case) -> usize {
    let is_open = |boundary: &&Boundary| boundary.kind.imposes_flow() || boundary.kind.imposes_pressure();
    let mut open_faces = [false; 6];
    let boundaries = case.fluid.iter().flat_map(|fluid| &fluid.boundary);
    boundaries.filter(is_open).for_each(|boundary| open_faces[boundary.face as usize] = true);
    if let Some(axis) = (0..3).find(|&a| open_faces[2 * a] && open_faces[2 * a + 1]) {
        return axis;
    }
    let g = case.gravity.map(f64::abs);
    (0..3).fold(0, |best, a| if g[a] > g[best] { a } else { best })
}

#[cfg(test)]
mod tests {
    use super::main_axis;
    use grains_case::Case;
    use std::path::Path;

    #[test]
    fn the_pressure_drops_along_the_axis_that_fluid_enters_and_leaves_along() {
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            for gravity in [[0.0; 3], [0.0, 0.0, -9.81], [-9.81, 0.0, 0.0]] {
                let mut velocity = [0.0; 3];
                velocity[axis] = 0.1;
                let text = format!(
                    "gravity = {gravity:?}\n[domain]\nlower = [0, 0, 0]\nupper = [0.2, 0.1, 0.1]\n[time]\nend = 1\n[fluid]\n\
                     density = 1.2\nviscosity = 1.8e-5\ncells = [20, 10, 10]\n[[fluid.boundary]]\nface = \"-{name}\"\n\
                     kind = \"inlet\"\nvelocity = {velocity:?}\n[[fluid.boundary]]\nface = \"+{name}\"\nkind = \"outlet\"\n"
                );
                let case = Case::parse(&text, "duct.toml", Path::new("")).unwrap();
                assert_eq!(main_axis(&case), axis, "{name} {gravity:?}");
            }
        }
    }
}
