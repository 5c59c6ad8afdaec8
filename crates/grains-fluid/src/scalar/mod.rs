//! Scalars that a flow carries: temperature, concentrations.
//!
//! ```text
//!  ∂(ψ φ)/∂t + ∇·(A ε u φ) = ∇·(A ε D ∇φ) + s − κ φ
//! ```
//!
//! with the void fraction ψ of cells, what A ε of faces is open to the fluid, diffusivity D, sources s and exchange coefficients κ
//! per volume of mixture; ψ = A ε = 1 of one phase. The volume fluxes are those of the flow at the end of its step, which bring the
//! volume of each cell from that at the beginning to that at the end: what is uniform stays so, and what faces pass on is
//! kept to rounding.
//!
//! # One step
//!
//! ```text
//! high order    (m − ½ Gx)(m − ½ Gy)(m − ½ Gz)/m² Δφ = −∇·H(φⁿ), H central (Adams–Bashforth) and diffusive; m = ψ/Δt + κ
//! low order     upwind (Euler), then (m − Gx), (m − Gy), (m − Gz) one after the other: a mean of what is around each cell
//! limit         φ = low − Σ α A/m, A = H − L and α of each face such that no cell leaves the range of its neighbours
//! ```
//!
//! Both orders pass on what they change through faces, the factors of the implicit diffusion too, so that their difference A does
//! (Boris & Book 1973; Zalesak 1979). Where nothing is limited the result is of second order, and what is steady does not depend on
//! the step. Steps that carry more out of a cell than it has are divided. With [`Scheme::Central`] the high order is all there is.
//!
//! # Solids
//!
//! Bodies and walls among the cells change capacities of cells and conductances of faces (`solids`), and what a solid holds is
//! as infinitely heavy: no step changes it.
//!
//! Scalars are taken as those of the middle of the flow's next step, and act on it so (buoyancy): volume fluxes at the end of a step
//! lie in the middle of that of the scalars.

mod advance;
mod carried;
mod conditions;
mod limiter;
mod pace;
mod setup;
mod solids;

pub use setup::{
    Buoyancy, Interior, ScalarBoundaries, ScalarCondition, ScalarSetup, ScalarValue, Scheme, SolidCondition,
    SolidConditions, SolidReaction,
};
pub use solids::{
    BEYOND, CutFace, NearCell, NearFace, SolidCells, SolidCellsBuilder, SurfacePoint, share_in_front,
};

pub(crate) use carried::add_buoyancy;

use crate::metrics::Local;
use crate::tridiagonal::ConductionLines;
use crate::{CellPartition, Centre, Faces, Field, Grid, Halo};
use conditions::FaceConditions;
use grains_domain::Transport;
use solids::{Barrier, Linear};

/// A scalar on the cells of a rank.
pub struct Scalar {
    /// What it is.
    pub setup: ScalarSetup,
    /// Its value φ, halo filled.
    pub value: Field<Centre>,
    /// That before the last step, halo filled.
    pub previous: Field<Centre>,
    /// Sources s per volume of mixture (unit/s) of the coming step, own cells.
    pub source: Option<Field<Centre>>,
    /// Exchange coefficient κ ≥ 0 per volume of mixture (1/s) of the coming step, own cells.
    pub exchange: Option<Field<Centre>>,
    /// Mean of the values at the ends of the parts of the last step, halo filled, where that was divided and something is exchanged.
    divided: Option<Field<Centre>>,
    /// Values that solids have, by their numbers, where these count ([`SolidCondition::OfSolid`]).
    pub of_solids: Vec<f64>,
    /// What the fluid of this rank got from each solid in the last step (unit m³), without what fluid that it displaces holds at its
    /// value.
    pub gained: Vec<f64>,
    /// What reacted in each solid on this rank in the last step (unit m³).
    pub reacted: Vec<f64>,
    /// That step (s); zero before the first.
    pub gained_over: f64,
    /// What was there at the beginning and has come in through the faces of the box and from solids since, on this rank (unit m³).
    pub entered: f64,
    /// What sources have brought, less what was exchanged, and what fluid took along that made room for particles, or brought as they
    /// left, on this rank (unit m³).
    pub produced: f64,
    /// 1 in cells that change in the step for which solids were last passed, 0 in those inside solids, halo filled; none before.
    pub free: Option<Field<Centre>>,
    conditions: Vec<FaceConditions>,
    barrier: Option<Barrier>,
}

impl Scalar {
    /// The value with which the last step exchanged, halo filled: V (s − κ φ) Δt is what a cell got.
    pub fn exchanged_at(&self) -> &Field<Centre> {
        self.divided.as_ref().unwrap_or(&self.value)
    }

    /// Fills the halo of its fields; collective.
    fn fill(&mut self, halo: &mut Halo, transport: &dyn Transport) {
        let fields = [Some(&mut self.value), Some(&mut self.previous), self.free.as_mut()];
        let mut fields: Vec<&mut [f64]> = fields.into_iter().flatten().map(Field::data_mut).collect();
        halo.fill(&mut fields, transport);
    }

    /// Takes the value at the end of part `part` of a step in `parts`.
    fn average(&mut self, part: u32, parts: u32) {
        if parts == 1 || self.exchange.is_none() {
            self.divided = None;
            return;
        }
        let mean = self.divided.get_or_insert_with(|| Field::new(self.value.layout()));
        if part == 0 {
            mean.fill(0.0);
        }
        let weight = 1.0 / f64::from(parts);
        mean.data_mut().iter_mut().zip(self.value.data()).for_each(|(mean, x)| *mean += weight * x);
    }
}

/// All scalars of a flow, and what their steps need.
pub struct Scalars {
    /// The scalars.
    pub all: Vec<Scalar>,
    /// Volumes of fluid ψ V of the cells (m³), as the last step has left them.
    pub(crate) volume: Vec<f64>,
    /// Last step (s), zero before the first.
    pub last_dt: f64,
    /// Where solids lie among the cells, if there are any.
    pub solids: Option<SolidCells>,
    /// Step over that of each cell (-), of scalars that are to settle and do not march in time; empty if they do.
    pace: Vec<f64>,
    work: Work,
}

/// Arrays of a step, shared by all scalars.
struct Work {
    /// Volume fluxes through the faces (m³/s).
    flux: Faces,
    /// What is open of the faces over the distance of the centres (m).
    geometry: Faces,
    /// The same times the diffusivity, at the ends of the box by the conditions there (m³/s).
    conductance: Faces,
    /// Fluxes of high order, then their difference to those of low order (unit m³/s).
    high: Faces,
    /// Volumes of fluid at the end of the step (m³).
    volume: Vec<f64>,
    /// What sources and imposed fluxes bring (unit m³/s).
    rates: Vec<f64>,
    /// m of the cells (m³/s).
    mass: Vec<f64>,
    /// Change of an implicit factor.
    change: Vec<f64>,
    /// Value of low order.
    low: Field<Centre>,
    /// What a cell may gain and lose of what wants in and out (-).
    shares: [Vec<f64>; 2],
    /// What comes by way of solids.
    linear: Vec<Linear>,
    lines: ConductionLines,
}

impl Scalars {
    /// None yet, on the cells of a rank with so much of their volumes open to the fluid.
    pub(crate) fn new(grid: &Grid, partition: &CellPartition, local: &Local) -> Self {
        let layout = local.layout;
        let zeros = || vec![0.0; layout.len()];
        Self {
            all: Vec::new(),
            volume: zeros(),
            last_dt: 0.0,
            solids: None,
            pace: Vec::new(),
            work: Work {
                flux: Faces::new(layout),
                geometry: Faces::new(layout),
                conductance: Faces::new(layout),
                high: Faces::new(layout),
                volume: zeros(),
                rates: zeros(),
                mass: zeros(),
                change: zeros(),
                low: Field::new(layout),
                shares: [zeros(), zeros()],
                linear: Vec::new(),
                lines: ConductionLines::new(grid, partition, local),
            },
        }
    }

    /// What a cell holds per unit of scalar `number` (m³); 0 where no step changes it.
    fn capacity(&self, number: usize, place: usize) -> f64 {
        match &self.all[number].barrier {
            Some(barrier) if barrier.is_free(place) => self.volume[place] * barrier.capacity[place],
            Some(_) => 0.0,
            None => self.volume[place],
        }
    }

    /// Σ C φ, Σ C over the own cells of scalar `number` (unit m³, m³), with what each holds per unit, C = ψ V in the fluid; and smallest and
    /// largest value.
    pub fn sums(&self, number: usize) -> ([f64; 2], [f64; 2]) {
        let value = &self.all[number].value;
        let layout = value.layout();
        let (mut sums, mut range) = ([0.0; 2], [f64::INFINITY, f64::NEG_INFINITY]);
        for p in layout.rows().flat_map(|row| row..row + layout.cells[0]) {
            let (x, capacity) = (value.data()[p], self.capacity(number, p));
            if capacity > 0.0 {
                sums = [sums[0] + capacity * x, sums[1] + capacity];
                range = [range[0].min(x), range[1].max(x)];
            }
        }
        (sums, range)
    }

    /// Σ C φ over the own cells of scalar `number` (unit m³).
    pub fn content(&self, number: usize) -> f64 {
        self.sums(number).0[0]
    }

    /// By how much less each solid would get in a step `dt` (s) if it were by one unit higher from its beginning, on this rank (m³): what the
    /// cells beside it can give, and those behind them as far as it diffuses.
    pub fn responses(&self, number: usize, dt: f64) -> Vec<f64> {
        let scalar = &self.all[number];
        let mut responses = vec![0.0; self.solids.as_ref().map_or(0, |solids| solids.count)];
        let layout = scalar.value.layout();
        let ties = scalar.barrier.iter().flat_map(|barrier| barrier.ties.iter().flatten());
        for tie in ties.filter(|tie| advance::is_own(layout, tie.free)) {
            let (volume, passed) = (self.volume[tie.free], dt * tie.conductance);
            let depth = 1.0 + (scalar.setup.diffusivity * dt).sqrt() / self.volume[tie.free].cbrt();
            responses[tie.solid as usize] += depth * passed * volume / (passed + volume);
        }
        responses
    }

    /// Σ C φ over the own cells by which what is kept is accounted for (unit m³): that content, by the pace of each cell where scalars
    /// settle.
    pub fn kept(&self, number: usize) -> f64 {
        if self.pace.is_empty() {
            return self.content(number);
        }
        let value = &self.all[number].value;
        advance::own_cells(value.layout())
            .map(|p| self.pace[p] * self.capacity(number, p) * value.data()[p])
            .sum()
    }

    /// What solids hold of scalar `number` that diffuses in them, each on this rank (unit m³).
    pub fn content_of_solids(&self, number: usize) -> Vec<f64> {
        let (scalar, solids) = (&self.all[number], self.solids.as_ref());
        let mut content = vec![0.0; solids.map_or(0, |solids| solids.count)];
        let inside = scalar.barrier.iter().flat_map(|barrier| &barrier.inside);
        for inside in inside {
            let condition = scalar.setup.solids.of(inside.solid as usize, solids.map_or(0, |s| s.bodies));
            if let SolidCondition::Interior(interior) = condition {
                content[inside.solid as usize] +=
                    interior.capacity * inside.volume * scalar.value.data()[inside.cell];
            }
        }
        content
    }
}

impl Scalars {
    /// Sets the volumes of fluid to those of a void fraction, or of one phase.
    fn set_volumes(&mut self, local: &Local, void: Option<&Field<Centre>>) {
        advance::for_cells(local, |p, whole| {
            self.volume[p] = whole * void.map_or(1.0, |void| void.data()[p]);
        });
    }

    /// Takes the volumes of fluid of a void fraction, with what particles that came or went since the last step displaced or let in.
    fn take_volumes(&mut self, local: &Local, void: &Field<Centre>) {
        advance::for_cells(local, |p, whole| {
            let (before, now) = (self.volume[p], whole * void.data()[p]);
            if now != before {
                for scalar in &mut self.all {
                    if scalar.barrier.as_ref().is_none_or(|barrier| barrier.is_free(p)) {
                        scalar.produced += scalar.value.data()[p] * (now - before);
                    }
                }
            }
            self.volume[p] = now;
        });
    }

    /// Sets a void fraction to that of the volumes of fluid.
    fn give_volumes(&self, local: &Local, void: &mut Field<Centre>) {
        advance::for_cells(local, |p, whole| void.data_mut()[p] = self.volume[p] / whole);
    }
}
