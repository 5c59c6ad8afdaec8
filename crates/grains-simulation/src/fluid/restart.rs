//! The state of the fluid as arrays of a checkpoint, and back on any ranks.

use super::exchange::Exchange;
use super::observe::There;
use super::scalars::{Accounts, ScalarNames};
use super::{FluidPhase, walls};
use crate::error::RunError;
use grains_comm::MpiTransport;
use grains_coupling::unpaid_impulse;
use grains_dem::Dem;
use grains_domain::Transport;
use grains_fluid::{CellPartition, Centre, Field, Flow, Layout, March};
use grains_geometry::Vec3;
use grains_output::{CheckpointFile, FileError, GridArray, GridBlock, Metadata, agree};
use grains_resolved::FlowOnWall;

const VELOCITY: [&str; 3] = ["velocity_x", "velocity_y", "velocity_z"];
const ADVECTIVE: [&str; 3] = ["advective_x", "advective_y", "advective_z"];
const FORCE: [&str; 3] = ["body_force_x", "body_force_y", "body_force_z"];
const BEYOND: [&str; 3] = ["beyond_x", "beyond_y", "beyond_z"];
/// The void fraction at the beginning of the coming step: with what was inserted since the last one, without what left.
const COMING: &str = "coming_void_fraction";
/// What the divergence of the last step is told with.
const RATE: &str = "void_fraction_rate";
const MEANS: [&str; 9] =
    ["sum_u", "sum_v", "sum_w", "sum_p", "sum_void", "sum_flux_x", "sum_flux_y", "sum_flux_z", "sum_solid"];

/// The same of the fields there are.
fn mean_names(there: There, scalars: &[ScalarNames]) -> impl Iterator<Item = &'static str> {
    let plain = MEANS.into_iter().take(if there.particles { 9 } else { 4 });
    plain.chain(there.viscosity.then_some("sum_viscosity")).chain(scalars.iter().map(|scalar| scalar.sum))
}

/// What a text of a checkpoint says of the clocks of the fluid.
const CLOCKS: &str = "fluid";
/// What one says of the flow's last action on its walls.
const ON_WALLS: &str = "flow_on_walls";
/// What one says of the scalars' accounts.
const SCALARS: &str = "scalars";
/// What one says of the last step of the fluid.
const LAST_STEP: &str = "fluid_last_step";

/// Times and counts of the fluid.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Clocks {
    time: f64,
    /// Last time step (s), the negative of one in pseudo-time.
    last_dt: f64,
    force: [f64; 3],
    step: u64,
    next_step: u64,
    last_span: u64,
    /// Samples of the means.
    samples: u64,
    /// Pressure rises of the fans (Pa).
    fans: Vec<f64>,
    scalars: Accounts,
}

impl Clocks {
    fn text(&self) -> String {
        let [fx, fy, fz] = self.force;
        let exact = [self.time, self.last_dt, fx, fy, fz].map(|x| format!("{:x}", x.to_bits()));
        let counts = [self.step, self.next_step, self.last_span, self.samples].map(|n| n.to_string());
        let fans = self.fans.iter().map(|rise| format!("{:x}", rise.to_bits()));
        exact.into_iter().chain(counts).chain(fans).collect::<Vec<_>>().join(" ")
    }

    fn parse(text: &str) -> Option<Self> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let real = |k: usize| u64::from_str_radix(words.get(k)?, 16).ok().map(f64::from_bits);
        let count = |k: usize| words.get(k)?.parse::<u64>().ok();
        Some(Self {
            time: real(0)?,
            last_dt: real(1)?,
            force: [real(2)?, real(3)?, real(4)?],
            step: count(5)?,
            next_step: count(6)?,
            last_span: count(7)?,
            samples: count(8).unwrap_or(0),
            fans: (9..words.len()).map(real).collect::<Option<_>>()?,
            scalars: Accounts::default(),
        })
    }
}

/// What rows of the time series tell of the last step of the fluid, and the step of the last sample of the means.
struct LastStep {
    dt: f64,
    iterations: [u64; 2],
    min_void_fraction: f64,
    /// Of all ranks together.
    rise: [[f64; 2]; 3],
    /// Of all ranks together (N s).
    imbalance: [f64; 3],
    sampled: Option<u64>,
}

impl LastStep {
    fn text(&self) -> String {
        let reals = [self.dt, self.min_void_fraction].into_iter();
        let reals = reals.chain(self.rise.as_flattened().iter().copied()).chain(self.imbalance);
        let counts = self.iterations.into_iter().chain(self.sampled).map(|n| n.to_string());
        reals.map(|x| format!("{:x}", x.to_bits())).chain(counts).collect::<Vec<_>>().join(" ")
    }

    fn parse(text: &str) -> Option<Self> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let bits = |word: &&str| u64::from_str_radix(word, 16).ok().map(f64::from_bits);
        let reals: Vec<f64> = words.get(..11)?.iter().map(bits).collect::<Option<_>>()?;
        let count = |k: usize| words.get(k)?.parse::<u64>().ok();
        Some(Self {
            dt: reals[0],
            min_void_fraction: reals[1],
            rise: std::array::from_fn(|a| [reals[2 + 2 * a], reals[3 + 2 * a]]),
            imbalance: std::array::from_fn(|a| reals[8 + a]),
            iterations: [count(11)?, count(12)?],
            sampled: count(13),
        })
    }
}

/// Numbers at the places of the cells.
#[derive(Clone, Copy)]
enum Numbers<'a> {
    Everywhere(&'a [f64]),
    /// At some places; 0 elsewhere.
    Somewhere(&'a [(u32, f64)]),
}

impl Numbers<'_> {
    fn of_places(self, layout: Layout, places: impl Iterator<Item = usize>) -> Vec<f64> {
        match self {
            Self::Everywhere(data) => places.map(|p| data[p]).collect(),
            Self::Somewhere(values) => {
                let mut data = vec![0.0; layout.len()];
                values.iter().for_each(|&(place, value)| data[place as usize] = value);
                places.map(|p| data[p]).collect()
            }
        }
    }
}

impl FluidPhase {
    /// What a checkpoint says of the fluid beside the fields; collective.
    pub fn texts(&self, dem: &Dem, transport: &MpiTransport) -> Metadata {
        let on_walls = walls::text(self.on_walls());
        let texts = [
            (CLOCKS, self.clocks().text()),
            (SCALARS, Accounts::new(&self.flow).summed(transport).text()),
            (LAST_STEP, self.last_step(dem, transport).text()),
            (ON_WALLS, on_walls),
        ];
        texts.map(|(name, text)| (name.into(), text)).into()
    }

    fn last_step(&self, dem: &Dem, transport: &MpiTransport) -> LastStep {
        let account = self.exchange.as_ref().map(|exchange| &exchange.account);
        let mut rise = account.map_or([[0.0; 2]; 3], |account| account.rise);
        transport.sum(rise.as_flattened_mut());
        let imbalance = self.exchange.as_ref().map(|exchange| exchange.imbalance(&dem.particles, transport));
        let mut min = [-account.map_or(1.0, |account| account.min_void_fraction)];
        transport.max(&mut min);
        let multipliers = self.resolved.as_ref().map_or(0, |resolved| resolved.bodies.iterations());
        LastStep {
            dt: self.report.dt,
            iterations: [self.report.solve.iterations, multipliers].map(|n| n as u64),
            min_void_fraction: -min[0],
            rise,
            imbalance: imbalance.map_or([0.0; 3], Into::into),
            sampled: self.sampled,
        }
    }

    /// Takes what is told of the last step; sums over ranks go to the first one.
    fn take_last_step(&mut self, last: &LastStep, dem: &Dem, is_first: bool) {
        self.report.dt = last.dt;
        self.report.solve.iterations = last.iterations[0] as usize;
        if let Some(resolved) = &mut self.resolved {
            resolved.bodies.resume_iterations(last.iterations[1] as usize);
        }
        if let Some(Exchange { account, .. }) = &mut self.exchange {
            account.min_void_fraction = last.min_void_fraction;
            // What is unpaid was given before.
            account.ledger.given = unpaid_impulse(&dem.particles);
            if is_first {
                account.rise = last.rise;
                account.ledger.given += Vec3::from(last.imbalance);
            }
        }
        self.sampled = last.sampled;
    }

    pub(super) fn clocks(&self) -> Clocks {
        let state = &self.flow.state;
        Clocks {
            time: state.time,
            last_dt: if self.flow.march == March::PseudoTime { -state.last_dt } else { state.last_dt },
            force: state.force,
            step: state.step,
            next_step: self.next_step,
            last_span: self.last_span,
            samples: self.means.as_ref().map_or(0, |m| m.samples),
            fans: state.fans.clone(),
            scalars: Accounts::new(&self.flow),
        }
    }

    /// The fields of this rank, each made when it is asked for.
    pub fn arrays<'a>(&'a self) -> impl Iterator<Item = GridArray> + 'a {
        let (flow, mut all) = (&self.flow, Vec::new());
        let layout = flow.layout();
        let of_faces = [0, 1, 2].map(|a| faces(flow, a));
        for (a, place) in of_faces.into_iter().enumerate() {
            all.push((VELOCITY[a], "m/s", place, Numbers::Everywhere(flow.state.velocity.component(a))));
            if flow.march == March::Time {
                all.push((
                    ADVECTIVE[a],
                    "m/s2",
                    place,
                    Numbers::Everywhere(flow.state.advective.component(a)),
                ));
            }
        }
        for (immersed, a) in flow.immersed.iter().flat_map(|immersed| [0, 1, 2].map(|a| (immersed, a))) {
            all.push((FORCE[a], "N/m3", of_faces[a], Numbers::Everywhere(immersed.force.component(a))));
            if let Some(extrapolated) = &immersed.extrapolated {
                all.push((BEYOND[a], "m/s", of_faces[a], Numbers::Somewhere(&extrapolated[a])));
            }
        }
        let mut add = |name, unit, field: &'a Field<Centre>| {
            all.push((name, unit, cells(flow), Numbers::Everywhere(field.data())));
        };
        add("pressure", "Pa", &flow.state.pressure);
        add("correction", "Pa or m2/s", &flow.state.correction);
        if let Some(mixture) = &flow.mixture {
            add("void_fraction", "-", &mixture.void_fraction);
            add(COMING, "-", mixture.previous_void_fraction());
            add(RATE, "1/s", &mixture.rate);
        }
        let scalars = flow.scalars.iter().flat_map(|scalars| &scalars.all);
        for (scalar, names) in scalars.zip(&self.scalar_names) {
            add(names.value, names.unit, &scalar.value);
            add(names.before, names.unit, &scalar.previous);
            // In a flow without bodies walls are put back where the last step met them.
            if let Some(free) = scalar.free.as_ref().filter(|_| self.resolved.is_some()) {
                add(names.free, "-", free);
            }
        }
        if let Some(means) = &self.means {
            for (field, name) in means.fields.iter().zip(mean_names(means.there, &self.scalar_names)) {
                add(name, "sum of samples", field);
            }
        }
        all.into_iter().map(move |(name, unit, (block, first), numbers)| {
            let values = numbers.of_places(layout, places(layout, block, first));
            GridArray { name, unit, width: 1, block, values }
        })
    }

    /// Takes the state of a checkpoint whose particles are back already; collective.
    ///
    /// # Errors
    /// Arrays that the checkpoint lacks, or of another grid.
    pub fn restore(
        &mut self,
        file: &CheckpointFile,
        dem: &Dem,
        transport: &MpiTransport,
    ) -> Result<(), RunError> {
        let lacking = || FileError::new(&file.path, "lacks the state of the fluid: it is of another version");
        let mut clocks = file.text(CLOCKS).and_then(Clocks::parse).ok_or_else(lacking);
        if let Ok(clocks) = &mut clocks {
            clocks.scalars = file.text(SCALARS).and_then(Accounts::parse).unwrap_or_default();
            // What is of all ranks together goes to the first one.
            if transport.rank() > 0 {
                clocks
                    .scalars
                    .of
                    .iter_mut()
                    .for_each(|account| (account.entered, account.produced) = (0.0, 0.0));
            }
        }
        let read = clocks.and_then(|clocks| self.take(|name, block| file.grid(name, 1, block), &clocks));
        agree(transport.communicator(), read)?;
        let last = file.text(LAST_STEP).and_then(LastStep::parse).ok_or_else(lacking)?;
        self.take_last_step(&last, dem, transport.rank() == 0);
        self.resume(dem, transport);
        // Scalars that the state has not got begin now.
        let known = file.text(SCALARS).and_then(Accounts::parse).unwrap_or_default();
        let names = &self.scalar_names;
        // Those that settle begin anew.
        let settles = self.steady.is_some();
        self.flow.begin_scalars(|number| {
            settles || known.of.iter().all(|account| account.name != names[number].field)
        });
        self.resume_on_walls(file.text(ON_WALLS).and_then(walls::parse).unwrap_or_default());
        Ok(())
    }

    /// What the flow did to the walls in its last step.
    pub(super) fn on_walls(&self) -> &[FlowOnWall] {
        let of_resolved = self.resolved.as_ref().map(|resolved| &resolved.bodies.on_walls[..]);
        let of_averaged = self.enclosing.as_ref().map(|walls| &walls.on_walls[..]);
        of_resolved.or(of_averaged).unwrap_or_default()
    }

    /// Takes that of a continued run.
    pub(super) fn resume_on_walls(&mut self, on_walls: Vec<FlowOnWall>) {
        if let Some(resolved) = &mut self.resolved {
            resolved.bodies.resume_on_walls(&on_walls);
        }
        if let Some(walls) = &mut self.enclosing {
            walls.on_walls = on_walls;
        }
    }

    /// Begins now, in a run whose particles were there before.
    pub fn begin_at(&mut self, dem: &Dem) {
        self.flow.state.time = dem.time();
        self.next_step = dem.step;
    }

    /// Keeps to what is left of a step of the fluid (s) when the time step of the particles is `ratio` times that before.
    pub fn change_step(&mut self, step: u64, ratio: f64) {
        let changed = |steps: u64| (steps as f64 / ratio).round().max(1.0) as u64;
        if ratio != 1.0 {
            let left = self.next_step.saturating_sub(step);
            self.next_step = step + if left == 0 { 0 } else { changed(left) };
            self.last_span = changed(self.last_span);
        }
    }

    /// Takes the own values of all fields, by the name and the block of an array, and the clocks.
    ///
    /// # Errors
    /// Those of `array`.
    pub(super) fn take<E>(
        &mut self,
        array: impl Fn(&str, &GridBlock) -> Result<Vec<f64>, E>,
        clocks: &Clocks,
    ) -> Result<(), E> {
        let layout = self.flow.layout();
        let take = |name: &str, (block, first): (GridBlock, [isize; 3]), data: &mut [f64]| -> Result<(), E> {
            let values = array(name, &block)?;
            places(layout, block, first).zip(values).for_each(|(p, value)| data[p] = value);
            Ok(())
        };
        let faces_of = [0, 1, 2].map(|a| faces(&self.flow, a));
        for (a, place) in faces_of.into_iter().enumerate() {
            take(VELOCITY[a], place, self.flow.state.velocity.component_mut(a))?;
            // Pseudo-steps leave none, and a march in time that follows them begins with a step of Euler.
            if self.flow.march == March::Time && clocks.last_dt >= 0.0 {
                take(ADVECTIVE[a], place, self.flow.state.advective.component_mut(a))?;
            }
        }
        if let Some(immersed) = &mut self.flow.immersed {
            for a in 0..3 {
                take(FORCE[a], faces_of[a], immersed.force.component_mut(a))?;
                if let Some(extrapolated) = &mut immersed.extrapolated {
                    let mut beyond = vec![0.0; layout.len()];
                    take(BEYOND[a], faces_of[a], &mut beyond)?;
                    let own = layout.rows().flat_map(|row| row..row + layout.cells[0]);
                    extrapolated[a] =
                        own.filter(|&p| beyond[p] != 0.0).map(|p| (p as u32, beyond[p])).collect();
                }
            }
        }
        let place = cells(&self.flow);
        take("pressure", place, self.flow.state.pressure.data_mut())?;
        take("correction", place, self.flow.state.correction.data_mut())?;
        if let Some(mixture) = &mut self.flow.mixture {
            take("void_fraction", place, mixture.void_fraction.data_mut())?;
            take(COMING, place, mixture.previous_void_fraction_mut().data_mut())?;
            take(RATE, place, mixture.rate.data_mut())?;
        }
        if let Some(scalars) = &mut self.flow.scalars {
            scalars.last_dt = clocks.scalars.last_dt;
            for (scalar, names) in scalars.all.iter_mut().zip(&self.scalar_names) {
                // The case may have other scalars than the state; these begin anew.
                let known = clocks.scalars.of.iter().find(|account| account.name == names.field);
                let Some(account) = known else { continue };
                take(names.value, place, scalar.value.data_mut())?;
                take(names.before, place, scalar.previous.data_mut())?;
                if self.resolved.is_some() {
                    let free = scalar.free.insert(Field::new(layout));
                    // Beyond the box, where nothing fills it.
                    free.fill(1.0);
                    take(names.free, place, free.data_mut())?;
                }
                (scalar.entered, scalar.produced) = (account.entered, account.produced);
            }
        }
        let state = &mut self.flow.state;
        let last_dt = match self.flow.march {
            March::Time => clocks.last_dt.max(0.0),
            March::PseudoTime => clocks.last_dt.abs(),
        };
        (state.time, state.last_dt) = (clocks.time, last_dt);
        (state.force, state.step) = (clocks.force, clocks.step);
        // The case may have other fans than the state; these begin anew.
        if state.fans.len() == clocks.fans.len() {
            state.fans.clone_from(&clocks.fans);
        }
        (self.next_step, self.last_span) = (clocks.next_step, clocks.last_span);
        // The case may ask for means that the state has not got.
        if let Some(means) = self.means.as_mut().filter(|_| clocks.samples > 0) {
            means.samples = clocks.samples;
            let names = mean_names(means.there, &self.scalar_names);
            for (field, name) in means.fields.iter_mut().zip(names) {
                take(name, place, field.data_mut())?;
            }
        }
        Ok(())
    }

    /// Makes all else fit the fields that were taken; collective.
    pub(super) fn resume(&mut self, dem: &Dem, transport: &MpiTransport) {
        if let (Some(walls), Some(exchange)) = (&mut self.enclosing, &mut self.exchange) {
            walls.resume((&mut self.flow, exchange), dem, transport);
        }
        self.flow.synchronise(transport);
        // Profiles interpolate means beyond the own cells.
        if let Some(means) = &mut self.means {
            let mut fields: Vec<&mut [f64]> = means.fields.iter_mut().map(Field::data_mut).collect();
            self.halo.fill(&mut fields, transport);
        }
        if let Some(resolved) = &mut self.resolved {
            resolved.resume(dem, &mut self.flow, transport);
        }
    }
}

/// The own cells in the global array, and the first of them in the local one.
fn cells(flow: &Flow) -> (GridBlock, [isize; 3]) {
    let (all, partition) = (flow.setup.grid.cells(), &flow.setup.partition);
    (block(all, all, partition, partition.coordinates), [0; 3])
}

/// The own faces normal to an axis: the upper ones of the own cells, and on a boundary of the domain the lowest one; where
/// the axis is not periodic, face k of the global array is the lower one of cell k.
fn faces(flow: &Flow, axis: usize) -> (GridBlock, [isize; 3]) {
    let (cells, partition) = (flow.setup.grid.cells(), &flow.setup.partition);
    let (mut all, mut from) = (cells, [0; 3]);
    if !flow.setup.grid.axis(axis).is_periodic() {
        all[axis] += 1;
        from[axis] = if partition.coordinates[axis] == 0 { -1 } else { 0 };
    }
    (block(all, cells, partition, partition.coordinates), from)
}

/// What a rank has of an array of `all` places: its cells, or its faces normal to the axis along which there is one place more.
pub(super) fn block(
    all: [usize; 3],
    cells: [usize; 3],
    partition: &CellPartition,
    coordinates: [usize; 3],
) -> GridBlock {
    let range = |a: usize| {
        let (starts, column) = (&partition.starts[a], coordinates[a]);
        let of_faces = usize::from(all[a] > cells[a]);
        let first = starts[column] + if column == 0 { 0 } else { of_faces };
        first..starts[column + 1] + of_faces
    };
    let ranges = [0, 1, 2].map(range);
    GridBlock { all, first: ranges.each_ref().map(|r| r.start), own: ranges.each_ref().map(|r| r.len()) }
}

/// Places in the arrays of a block whose first is the cell `first`, x fastest.
fn places(layout: Layout, block: GridBlock, [x, y, z]: [isize; 3]) -> impl Iterator<Item = usize> {
    let [nx, ny, nz] = block.own.map(|n| n as isize);
    let rows = (z..z + nz).flat_map(move |k| (y..y + ny).map(move |j| (j, k)));
    rows.flat_map(move |(j, k)| (x..x + nx).map(move |i| layout.index(i, j, k)))
}
