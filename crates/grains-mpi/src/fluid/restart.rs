//! The state of the fluid as arrays of a checkpoint, and back on any ranks.

use super::FluidPhase;
use crate::error::RunError;
use grains_comm::MpiTransport;
use grains_coupling::owed;
use grains_dem::Dem;
use grains_fluid::{Flow, Layout};
use grains_output::{CheckpointFile, FileError, GridArray, GridBlock, Metadata, agree};

const VELOCITY: [&str; 3] = ["velocity_x", "velocity_y", "velocity_z"];
const ADVECTIVE: [&str; 3] = ["advective_x", "advective_y", "advective_z"];
const FORCE: [&str; 3] = ["body_force_x", "body_force_y", "body_force_z"];
const BEYOND: [&str; 3] = ["beyond_x", "beyond_y", "beyond_z"];
const MEANS: [&str; 9] =
    ["sum_u", "sum_v", "sum_w", "sum_p", "sum_void", "sum_flux_x", "sum_flux_y", "sum_flux_z", "sum_solid"];

/// What a text of a checkpoint says of the clocks of the fluid.
const CLOCKS: &str = "fluid";

impl FluidPhase {
    /// The state of this rank.
    pub fn state(&self) -> (Vec<GridArray>, Metadata) {
        let (flow, mut arrays) = (&self.flow, Vec::new());
        let layout = flow.layout();
        let mut add = |name, unit, (block, first): (GridBlock, [isize; 3]), data: &[f64]| {
            let values = places(layout, block, first).map(|p| data[p]).collect();
            arrays.push(GridArray { name, unit, width: 1, block, values });
        };
        for a in 0..3 {
            add(VELOCITY[a], "m/s", faces(flow, a), flow.state.velocity.component(a));
            add(ADVECTIVE[a], "m/s2", faces(flow, a), flow.state.advective.component(a));
        }
        for (immersed, a) in flow.immersed.iter().flat_map(|immersed| [0, 1, 2].map(|a| (immersed, a))) {
            add(FORCE[a], "N/m3", faces(flow, a), immersed.force.component(a));
            if let Some(beyond) = &immersed.beyond {
                add(BEYOND[a], "m/s", faces(flow, a), beyond.component(a));
            }
        }
        add("pressure", "Pa", cells(flow), flow.state.pressure.data());
        add("correction", "Pa or m2/s", cells(flow), flow.state.correction.data());
        if let Some(mixture) = &flow.mixture {
            add("void_fraction", "-", cells(flow), mixture.previous_void_fraction().data());
        }
        for (field, name) in self.means.iter().flat_map(|m| &m.fields).zip(MEANS) {
            add(name, "sum of samples", cells(flow), field.data());
        }
        let state = &flow.state;
        let [fx, fy, fz] = state.force;
        let exact = [state.time, state.last_dt, fx, fy, fz].map(|x| format!("{:x}", x.to_bits()));
        let samples = self.means.as_ref().map_or(0, |m| m.samples);
        let counts = [state.step, self.next_step, self.last_span, samples].map(|n| n.to_string());
        let words = exact.into_iter().chain(counts);
        (arrays, vec![(CLOCKS.into(), words.collect::<Vec<_>>().join(" "))])
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
        let read = self.read(file);
        agree(transport.communicator(), read)?;
        if let Some(exchange) = &mut self.exchange {
            // What is owed was given before: the account goes on from zero.
            exchange.ledger.given = owed(&dem.particles);
        }
        self.flow.synchronise(transport);
        if let Some(resolved) = &mut self.resolved {
            resolved.bodies.resume(&mut self.flow, transport);
            resolved.place(dem, &mut self.flow, transport);
        }
        Ok(())
    }

    fn read(&mut self, file: &CheckpointFile) -> Result<(), FileError> {
        let layout = self.flow.layout();
        let take = |name: &str,
                    (block, first): (GridBlock, [isize; 3]),
                    data: &mut [f64]|
         -> Result<(), FileError> {
            let values = file.grid(name, 1, &block)?;
            places(layout, block, first).zip(values).for_each(|(p, value)| data[p] = value);
            Ok(())
        };
        let faces_of = [0, 1, 2].map(|a| faces(&self.flow, a));
        for (a, place) in faces_of.into_iter().enumerate() {
            take(VELOCITY[a], place, self.flow.state.velocity.component_mut(a))?;
            take(ADVECTIVE[a], place, self.flow.state.advective.component_mut(a))?;
        }
        if let Some(immersed) = &mut self.flow.immersed {
            for a in 0..3 {
                take(FORCE[a], faces_of[a], immersed.force.component_mut(a))?;
                if let Some(beyond) = &mut immersed.beyond {
                    take(BEYOND[a], faces_of[a], beyond.component_mut(a))?;
                }
            }
        }
        let place = cells(&self.flow);
        take("pressure", place, self.flow.state.pressure.data_mut())?;
        take("correction", place, self.flow.state.correction.data_mut())?;
        if let Some(mixture) = &mut self.flow.mixture {
            take("void_fraction", place, mixture.void_fraction.data_mut())?;
            mixture.begin();
        }
        let words: Vec<&str> = file.text(CLOCKS).unwrap_or("").split_whitespace().collect();
        let lacking = || FileError::new(&file.path, "lacks the state of the fluid: it is of another version");
        let real = |k: usize| {
            let bits = words.get(k).and_then(|w| u64::from_str_radix(w, 16).ok());
            bits.map(f64::from_bits).ok_or_else(lacking)
        };
        let count = |k: usize| words.get(k).and_then(|w| w.parse::<u64>().ok()).ok_or_else(lacking);
        let state = &mut self.flow.state;
        (state.time, state.last_dt) = (real(0)?, real(1)?);
        state.force = [real(2)?, real(3)?, real(4)?];
        state.step = count(5)?;
        (self.next_step, self.last_span) = (count(6)?, count(7)?);
        if let Some(means) = self.means.as_mut().filter(|_| file.has_grid(MEANS[0])) {
            means.samples = count(8)?;
            for (field, name) in means.fields.iter_mut().zip(MEANS) {
                take(name, place, field.data_mut())?;
            }
        }
        Ok(())
    }
}

/// The own cells in the global array, and the first of them in the local one.
fn cells(flow: &Flow) -> (GridBlock, [isize; 3]) {
    let setup = &flow.setup;
    (GridBlock { all: setup.grid.cells(), first: flow.first_cell(), own: flow.layout().cells }, [0; 3])
}

/// The own faces normal to an axis: the upper ones of the own cells, and on a boundary of the domain the lowest one; where
/// the axis is not periodic, face k of the global array is the lower one of cell k.
fn faces(flow: &Flow, axis: usize) -> (GridBlock, [isize; 3]) {
    let (mut block, mut from) = cells(flow);
    if !flow.setup.grid.axis(axis).is_periodic() {
        block.all[axis] += 1;
        if block.first[axis] == 0 {
            block.own[axis] += 1;
            from[axis] = -1;
        } else {
            block.first[axis] += 1;
        }
    }
    (block, from)
}

/// Places in the arrays of a block whose first is the cell `first`, x fastest.
fn places(layout: Layout, block: GridBlock, [x, y, z]: [isize; 3]) -> impl Iterator<Item = usize> {
    let [nx, ny, nz] = block.own.map(|n| n as isize);
    let rows = (z..z + nz).flat_map(move |k| (y..y + ny).map(move |j| (j, k)));
    rows.flat_map(move |(j, k)| (x..x + nx).map(move |i| layout.index(i, j, k)))
}
