//! A step of all scalars.

use super::limiter::limit;
use super::solids::{Barrier, FIXED, Tie};
use super::{Scalar, Scalars, Scheme, SolidCells, Work};
use crate::metrics::Local;
use crate::tridiagonal::Conduction;
use crate::{Centre, Faces, Field, Grid, Halo, Immersed, Layout};
use grains_domain::Transport;

/// Share of the implicit part of diffusion at the end of the step, of high order (-).
const IMPLICITNESS: f64 = 0.5;

/// The flow that carries scalars, at the end of its step.
pub(crate) struct CarrierFlow<'a> {
    pub grid: &'a Grid,
    pub local: &'a Local,
    pub halo: &'a mut Halo,
    /// Velocity (m/s).
    pub velocity: &'a Faces,
    /// What flows beside it, where bodies are.
    pub immersed: Option<&'a Immersed>,
    /// What of the faces is open to the fluid (-), and the void fraction of the cells at the beginning of the step; none of one phase.
    pub open: Option<(&'a Faces, &'a Field<Centre>)>,
    /// Time at the beginning of the step (s), and the step (s).
    pub time: f64,
    pub dt: f64,
}

impl Scalars {
    /// A step of all scalars; collective.
    ///
    /// # Errors
    /// How often a step would empty a cell, if that is too often.
    pub(crate) fn advance(
        &mut self,
        mut carrier: CarrierFlow<'_>,
        transport: &dyn Transport,
    ) -> Result<(), f64> {
        self.set_fluxes(&mut carrier, transport);
        let parts = self.parts(&carrier, transport)?;
        let (begin, dt) = (carrier.time, carrier.dt / f64::from(parts));
        for part in 0..parts {
            (carrier.time, carrier.dt) = (begin + f64::from(part) * dt, dt);
            let last_dt = std::mem::replace(&mut self.last_dt, dt);
            let ratio = if last_dt > 0.0 { dt / last_dt } else { 0.0 };
            let weights = [1.0 + 0.5 * ratio, -0.5 * ratio];
            self.work.set_volume(&self.volume, carrier.local, carrier.open.is_some(), dt);
            for scalar in &mut self.all {
                let mut barrier = scalar.barrier.take();
                let solids = barrier.as_mut().zip(self.solids.as_ref());
                let volumes = (&self.volume[..], &self.pace[..]);
                self.work.advance(scalar, solids, volumes, weights, &mut carrier, transport);
                scalar.barrier = barrier;
                scalar.average(part, parts);
            }
            std::mem::swap(&mut self.volume, &mut self.work.volume);
        }
        Ok(())
    }

    /// Sets the volumes of fluid and the volume fluxes of a step; collective.
    pub(super) fn set_fluxes(&mut self, carrier: &mut CarrierFlow<'_>, transport: &dyn Transport) {
        let local = carrier.local;
        if let Some((_, void)) = carrier.open {
            self.take_volumes(local, void);
        }
        let work = &mut self.work;
        for axis in 0..3 {
            let (flux, geometry) = (work.flux.component_mut(axis), work.geometry.component_mut(axis));
            if !local.active[axis] {
                continue;
            }
            let (velocity, inverse) = (carrier.velocity.component(axis), &local.axes[axis].inverse_distance);
            let open = carrier.open.map(|(open, _)| open.component(axis));
            for_faces(local, axis, |p, area, e| {
                let area = area * open.map_or(1.0, |open| open[p]);
                flux[p] = area * velocity[p];
                geometry[p] = area * inverse[e];
            });
        }
        work.add_beside(carrier, transport);
    }

    /// Into how many parts a step must be divided, so that no more is carried out of a cell than it has; collective.
    ///
    /// # Errors
    /// That number, if it is too large.
    fn parts(&self, carrier: &CarrierFlow<'_>, transport: &dyn Transport) -> Result<u32, f64> {
        let (local, work) = (carrier.local, &self.work);
        let (layout, strides) = (local.layout, local.layout.strides());
        let mut largest = [0.0_f64];
        let bounded = self.all.iter().filter(|scalar| scalar.setup.scheme == Scheme::Bounded);
        let capacities: Vec<&[f64]> = bounded
            .filter_map(|scalar| scalar.barrier.as_ref())
            .map(|barrier| &barrier.capacity[..])
            .collect();
        for p in own_cells(layout) {
            let leaving: f64 = (0..3)
                .map(|a| {
                    let flux = work.flux.component(a);
                    flux[p].max(0.0) - flux[p - strides[a]].min(0.0)
                })
                .sum();
            if leaving > 0.0 {
                let smallest = capacities.iter().map(|capacity| capacity[p]).fold(1.0, f64::min);
                let smallest = smallest * self.pace.get(p).copied().unwrap_or(1.0);
                largest[0] =
                    largest[0].max(carrier.dt * leaving / (smallest * self.volume[p]).max(f64::MIN_POSITIVE));
            }
        }
        let is_limited = self.all.iter().any(|scalar| scalar.setup.scheme == Scheme::Bounded);
        if !is_limited {
            return Ok(1);
        }
        let [fourier_x, fourier_y, fourier_z] = self.fourier_numbers(local, carrier.dt);
        let mut largest = [largest[0], fourier_x, fourier_y, fourier_z];
        transport.max(&mut largest);
        let [courant, fourier @ ..] = &mut largest;
        // The second largest of the three: implicit diffusion along one axis is the same in both orders.
        fourier.sort_unstable_by(f64::total_cmp);
        let by_diffusion = (fourier[1] / MAX_FOURIER).min(MAX_PARTS_BY_DIFFUSION);
        let parts = courant.max(by_diffusion).ceil().max(1.0);
        if parts <= MAX_PARTS { Ok(parts as u32) } else { Err(parts) }
    }
}

/// Largest Fourier number along more than one axis for the bounded scheme (-): the two orders differ by products of these, and what
/// the limiter refuses of that would make steady states swing.
const MAX_FOURIER: f64 = 0.5;

/// Largest number of parts for that reason: scalars that are uniform within a step need no more.
const MAX_PARTS_BY_DIFFUSION: f64 = 64.0;

/// Largest number of parts of a step: at the Courant numbers of flows more are a sign of cells that hold next to no fluid.
const MAX_PARTS: f64 = 1000.0;

impl Work {
    /// Corrects the volume fluxes for what flows beside the velocity where bodies are: nothing by extrapolated velocities, and what
    /// passes cut faces; collective.
    fn add_beside(&mut self, carrier: &mut CarrierFlow<'_>, transport: &dyn Transport) {
        let Some(immersed) = carrier.immersed else { return };
        let local = carrier.local;
        for axis in (0..3).filter(|&a| local.active[a]) {
            let flux = self.flux.component_mut(axis);
            if let Some(passing) = &immersed.passing {
                let passing = passing.component(axis);
                for_faces(local, axis, |p, area, _| flux[p] += area * passing[p]);
            }
            if let Some(extrapolated) = &immersed.extrapolated {
                let (layout, strides) = (local.layout, local.layout.strides());
                for &(place, velocity) in &extrapolated[axis] {
                    let place = place as usize;
                    let e = |a: usize| place / strides[a] % layout.dims()[a];
                    let others = [(axis + 1) % 3, (axis + 2) % 3];
                    let area: f64 = others.iter().map(|&a| local.axes[a].width[e(a)]).product();
                    flux[place] -= area * velocity;
                }
            }
        }
        let [x, y, z] = self.flux.components_mut();
        carrier.halo.fill_to(1, &mut [x, y, z], transport);
    }

    /// Volumes of fluid at the end of a step: those at its beginning less what flows out; of one phase it is all of a cell.
    fn set_volume(&mut self, volume: &[f64], local: &Local, is_mixture: bool, dt: f64) {
        let (strides, flux) = (local.layout.strides(), &self.flux);
        for p in own_cells(local.layout) {
            self.volume[p] = volume[p];
            if is_mixture {
                let out: f64 = (0..3).map(|a| flux.component(a)[p] - flux.component(a)[p - strides[a]]).sum();
                self.volume[p] -= dt * out;
            }
        }
    }

    /// A step of one scalar.
    fn advance(
        &mut self,
        scalar: &mut Scalar,
        mut solids: Option<(&mut Barrier, &SolidCells)>,
        (old_volume, pace): (&[f64], &[f64]),
        weights: [f64; 2],
        carrier: &mut CarrierFlow<'_>,
        transport: &dyn Transport,
    ) {
        let (local, dt) = (carrier.local, carrier.dt);
        let (layout, strides) = (local.layout, local.layout.strides());
        let diffusivity = scalar.setup.diffusivity;
        let middle = carrier.time + 0.5 * dt;
        for face in &mut scalar.conditions {
            face.evaluate(&scalar.setup.boundaries, diffusivity, middle);
        }
        self.linear.clear();
        if let Some((barrier, cells)) = &mut solids {
            let of = (&scalar.setup, *cells);
            let place = (carrier.grid, local);
            barrier.evaluate(of, &scalar.of_solids, place, middle, &mut scalar.value);
            barrier.linear(of, place, middle, (scalar.value.data(), &self.volume), &mut self.linear);
            for face in &mut scalar.conditions {
                face.note_free(|cell| barrier.is_free(cell));
            }
        }
        let mut barrier = solids.map(|(barrier, _)| barrier);
        self.set_conductance(scalar, barrier.as_deref(), carrier);
        self.set_high(scalar, barrier.as_deref(), weights, local);
        // m and the rates of change.
        let [value, source, exchange] =
            [Some(&scalar.value), scalar.source.as_ref(), scalar.exchange.as_ref()]
                .map(|f| f.map(Field::data));
        let value = value.unwrap_or_default();
        for_cells(local, |p, whole| {
            let exchanged = whole * exchange.map_or(0.0, |exchange| exchange[p]);
            let pace = pace.get(p).copied().unwrap_or(1.0);
            let capacity = pace * barrier.as_ref().map_or(1.0, |barrier| barrier.capacity[p]);
            // Nothing changes what solids hold, and where walls leave no room.
            let is_free = capacity < pace * FIXED && self.volume[p] > 0.0;
            self.mass[p] = if is_free { capacity * self.volume[p] / dt + exchanged } else { FIXED };
            self.rates[p] = whole * source.map_or(0.0, |source| source[p]);
            let out: f64 =
                (0..3).map(|a| self.high.component(a)[p] - self.high.component(a)[p - strides[a]]).sum();
            // ∂(ψ φ)/∂t = ψ Δφ/Δt + φ ∂ψ/∂t.
            let growth = if is_free { capacity * (self.volume[p] - old_volume[p]) / dt } else { 0.0 };
            self.change[p] = self.rates[p] - out - (exchanged + growth) * value[p];
        });
        for linear in &self.linear {
            self.mass[linear.cell] += linear.coefficient;
            self.rates[linear.cell] += linear.rate;
            self.change[linear.cell] += linear.rate - linear.coefficient * value[linear.cell];
        }
        for face in &scalar.conditions {
            for cell in &face.cells {
                let influx = cell.influx * open_share(carrier, cell.cell);
                self.rates[cell.cell] += influx;
                self.change[cell.cell] += influx;
                scalar.entered += influx * dt;
            }
        }
        // Of high order.
        for axis in (0..3).filter(|&a| local.active[a]) {
            let conduction = Conduction {
                mass: &self.mass,
                conductance: self.conductance.component(axis),
                factor: IMPLICITNESS,
            };
            self.lines.solve(axis, conduction, &mut self.change, transport);
            carrier.halo.fill_to(1, &mut [self.change.as_mut_slice()], transport);
            let conductance = self.conductance.component(axis);
            let (high, change) = (self.high.component_mut(axis), &mut self.change);
            for face in scalar.conditions.iter().filter(|face| face.axis == axis) {
                // What is imposed behind a face is that of the middle of the step.
                face.cells.iter().for_each(|cell| change[face.beyond(cell, strides)] = 0.0);
            }
            for_faces(local, axis, |p, _, _| {
                high[p] -= IMPLICITNESS * conductance[p] * (change[p + strides[axis]] - change[p]);
            });
            if (axis + 1..3).any(|a| local.active[a]) {
                own_cells(layout).for_each(|p| change[p] *= self.mass[p]);
            }
        }
        let is_bounded = scalar.setup.scheme == Scheme::Bounded;
        let mut passed: f64 =
            scalar.conditions.iter().map(|face| face.entering(self.high.component(face.axis))).sum();
        if let Some(barrier) = &mut barrier {
            barrier.set_carried(&self.high);
        }
        if is_bounded {
            self.set_low(scalar, barrier.as_deref(), (old_volume, pace), carrier, transport);
            passed -= limit(self, (scalar, barrier.as_deref_mut()), carrier, transport);
        }
        scalar.entered += passed * dt;
        std::mem::swap(&mut scalar.value, &mut scalar.previous);
        let (new, old) = (scalar.value.data_mut(), scalar.previous.data());
        if is_bounded {
            own_cells(layout).for_each(|p| new[p] = self.low.data()[p]);
        } else {
            own_cells(layout).for_each(|p| new[p] = old[p] + self.change[p]);
        }
        let [source, exchange] = [&scalar.source, &scalar.exchange].map(|f| f.as_ref().map(Field::data));
        if source.is_some() || exchange.is_some() {
            let mut produced = 0.0;
            for_cells(local, |p, whole| {
                let exchanged = exchange.map_or(0.0, |exchange| exchange[p]) * new[p];
                produced += whole * (source.map_or(0.0, |source| source[p]) - exchanged);
            });
            scalar.produced += produced * dt;
            // What cells exchange that walls hold comes from these.
            for &(place, solid) in barrier.iter().flat_map(|barrier| &barrier.fixed) {
                let p = place as usize;
                let exchanged = exchange.map_or(0.0, |exchange| exchange[p]) * new[p];
                let amount = local.volume_at(p) * (source.map_or(0.0, |source| source[p]) - exchanged) * dt;
                scalar.entered -= amount;
                scalar.gained[solid as usize] -= amount;
            }
        }
        for linear in &self.linear {
            let amount = dt * (linear.rate - linear.coefficient * new[linear.cell]);
            if linear.reacts {
                scalar.reacted[linear.solid as usize] -= amount;
                scalar.produced += amount;
                // What reacts in cells that are fixed comes from outside.
                if barrier.as_ref().is_some_and(|barrier| !barrier.is_free(linear.cell)) {
                    scalar.entered -= amount;
                }
            } else {
                scalar.gained[linear.solid as usize] += amount;
                scalar.entered += amount;
            }
        }
        if let Some(barrier) = &barrier {
            let own = |tie: &&Tie| is_own(layout, tie.free);
            for (axis, ties) in barrier.ties.iter().enumerate() {
                let flux = self.flux.component(axis);
                for tie in ties.iter().filter(own) {
                    let of_solid = tie.value.map_or(tie.carried, |value| flux[tie.face] * value);
                    scalar.entered -= tie.side * tie.carried * dt;
                    scalar.gained[tie.solid as usize] -= tie.side * (tie.carried - of_solid) * dt;
                }
            }
        }
        carrier.halo.fill(&mut [new], transport);
        scalar.conditions.iter().for_each(|face| face.continue_beyond(scalar.value.data_mut(), strides));
    }

    /// What conducts through the faces.
    fn set_conductance(&mut self, scalar: &Scalar, barrier: Option<&Barrier>, carrier: &CarrierFlow<'_>) {
        for axis in (0..3).filter(|&a| carrier.local.active[a]) {
            let conductance = self.conductance.component_mut(axis);
            let geometry = self.geometry.component(axis);
            conductance.iter_mut().zip(geometry).for_each(|(c, g)| *c = scalar.setup.diffusivity * g);
            let by_solids = barrier.iter().flat_map(|barrier| &barrier.conductance[axis]);
            let is_averaged = barrier.is_some_and(|barrier| barrier.is_averaged);
            by_solids.for_each(|&(face, value)| match is_averaged {
                true => conductance[face as usize] *= value,
                false => conductance[face as usize] = value,
            });
            for face in scalar.conditions.iter().filter(|face| face.axis == axis) {
                for cell in &face.cells {
                    conductance[cell.face] = cell.conductance * open_share(carrier, cell.cell);
                }
            }
        }
    }

    /// Fluxes of high order at the beginning of the step.
    fn set_high(&mut self, scalar: &Scalar, barrier: Option<&Barrier>, [new, old]: [f64; 2], local: &Local) {
        let strides = local.layout.strides();
        let (value, previous) = (scalar.value.data(), scalar.previous.data());
        for axis in (0..3).filter(|&a| local.active[a]) {
            let (flux, conductance) = (self.flux.component(axis), self.conductance.component(axis));
            let (high, stride, m) = (self.high.component_mut(axis), strides[axis], &local.axes[axis]);
            for_faces(local, axis, |p, _, e| {
                // The share of the cell below a face in its value is that of the cell above in its control volume.
                let shares = [m.upper_share[e], m.lower_share[e]];
                let on_face = |x: &[f64]| shares[0] * x[p] + shares[1] * x[p + stride];
                let carried = new * on_face(value) + old * on_face(previous);
                high[p] = flux[p] * carried - conductance[p] * (value[p + stride] - value[p]);
            });
            if let Some(barrier) = barrier {
                barrier.set_high(axis, flux, (value, previous, [new, old]), local, high);
            }
            for face in scalar.conditions.iter().filter(|face| face.axis == axis) {
                for cell in &face.cells {
                    let mean = new * value[cell.cell] + old * previous[cell.cell];
                    let carried = face.carried(cell, flux[cell.face], mean);
                    let rise = cell.outside.map_or(0.0, |outside| outside - value[cell.cell]);
                    high[cell.face] =
                        flux[cell.face] * carried - face.outward * conductance[cell.face] * rise;
                }
            }
        }
    }

    /// The value of low order, halo filled; its fluxes are taken off those of high order.
    fn set_low(
        &mut self,
        scalar: &Scalar,
        barrier: Option<&Barrier>,
        (old_volume, pace): (&[f64], &[f64]),
        carrier: &mut CarrierFlow<'_>,
        transport: &dyn Transport,
    ) {
        let local = carrier.local;
        let (layout, strides) = (local.layout, local.layout.strides());
        let value = scalar.value.data();
        let low = self.low.data_mut();
        for p in own_cells(layout) {
            let pace = pace.get(p).copied().unwrap_or(1.0);
            let capacity = pace * barrier.map_or(1.0, |barrier| barrier.capacity[p]);
            low[p] = match self.mass[p] < FIXED {
                true => capacity * old_volume[p] / carrier.dt * value[p] + self.rates[p],
                false => FIXED * value[p],
            };
        }
        for axis in (0..3).filter(|&a| local.active[a]) {
            let (flux, high) = (self.flux.component(axis), self.high.component_mut(axis));
            let stride = strides[axis];
            let upwind = |p: usize| flux[p] * if flux[p] >= 0.0 { value[p] } else { value[p + stride] };
            for p in own_cells(layout) {
                low[p] -= upwind(p) - upwind(p - stride);
            }
            for_faces(local, axis, |p, _, _| high[p] -= upwind(p));
            for (tie, right) in barrier.iter().flat_map(|barrier| barrier.upwind(axis, flux, value)) {
                let missing = right - upwind(tie.face);
                if is_own(layout, tie.free) {
                    low[tie.free] -= tie.side * missing;
                }
                high[tie.face] -= missing;
            }
            for face in scalar.conditions.iter().filter(|face| face.axis == axis) {
                for cell in &face.cells {
                    let (wrong, flux) = (upwind(cell.face), flux[cell.face]);
                    let right = flux * face.carried(cell, flux, value[cell.cell]);
                    low[cell.cell] -= face.outward * (right - wrong);
                    high[cell.face] -= right - wrong;
                }
            }
        }
        for p in own_cells(layout) {
            low[p] = if self.mass[p] > 0.0 { low[p] / self.mass[p] } else { value[p] };
        }
        for axis in (0..3).filter(|&a| local.active[a]) {
            carrier.halo.fill_to(1, &mut [self.low.data_mut()], transport);
            let (conductance, stride) = (self.conductance.component(axis), strides[axis]);
            let low = self.low.data_mut();
            for face in scalar.conditions.iter().filter(|face| face.axis == axis) {
                face.set_beyond(low, strides);
            }
            for p in own_cells(layout) {
                self.change[p] = conductance[p] * (low[p + stride] - low[p])
                    - conductance[p - stride] * (low[p] - low[p - stride]);
            }
            let conduction = Conduction { mass: &self.mass, conductance, factor: 1.0 };
            self.lines.solve(axis, conduction, &mut self.change, transport);
            own_cells(layout).for_each(|p| low[p] += self.change[p]);
            carrier.halo.fill_to(1, &mut [self.low.data_mut()], transport);
            let (low, high) = (self.low.data_mut(), self.high.component_mut(axis));
            for face in scalar.conditions.iter().filter(|face| face.axis == axis) {
                face.set_beyond(low, strides);
            }
            for_faces(local, axis, |p, _, _| high[p] += conductance[p] * (low[p + stride] - low[p]));
        }
    }
}

/// Void fraction of a cell at the beginning of the step, 1 of one phase.
fn open_share(carrier: &CarrierFlow<'_>, cell: usize) -> f64 {
    carrier.open.map_or(1.0, |(_, void)| void.data()[cell])
}

/// Whether a place is that of an own cell.
pub(super) fn is_own(layout: Layout, place: usize) -> bool {
    let (strides, dims, h) = (layout.strides(), layout.dims(), layout.halo);
    (0..3).all(|a| (h..h + layout.cells[a]).contains(&(place / strides[a] % dims[a])))
}

/// Places of all own cells.
pub(super) fn own_cells(layout: Layout) -> impl Iterator<Item = usize> {
    layout.rows().flat_map(move |row| row..row + layout.cells[0])
}

/// Places and volumes (m³) of all own cells.
pub(super) fn for_cells(local: &Local, mut job: impl FnMut(usize, f64)) {
    let ([_, ny, nz], widths) = (local.layout.cells, local.row_widths());
    for k in 0..nz {
        for j in 0..ny {
            let area = local.axes[1].width[local.entry(j)] * local.axes[2].width[local.entry(k)];
            let start = local.layout.row(j, k);
            widths.iter().enumerate().for_each(|(i, width)| job(start + i, width * area));
        }
    }
}

/// Places and areas (m²) of the faces of own cells normal to an axis, with the entries in its metrics of the cells below.
pub(super) fn for_faces(local: &Local, axis: usize, mut job: impl FnMut(usize, f64, usize)) {
    let (layout, h, widths) = (local.layout, local.layout.halo, &local.axes);
    let mut first = [h; 3];
    first[axis] -= 1;
    let [[x0, y0, z0], strides] = [first, layout.strides()];
    let [x1, y1, z1] = layout.cells.map(|n| n + h);
    for z in z0..z1 {
        for y in y0..y1 {
            let start = y * strides[1] + z * strides[2];
            let (wy, wz) = (widths[1].width[y], widths[2].width[z]);
            match axis {
                0 => (x0..x1).for_each(|x| job(start + x, wy * wz, x)),
                1 => (x0..x1).for_each(|x| job(start + x, widths[0].width[x] * wz, y)),
                _ => (x0..x1).for_each(|x| job(start + x, widths[0].width[x] * wy, z)),
            }
        }
    }
}
