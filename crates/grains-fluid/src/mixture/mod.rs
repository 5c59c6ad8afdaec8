//! Fluid among particles: void fraction, drag and sources (Rakotonirina 2016, eqs 5.10-5.11).

mod displacement;
mod face_rows;

use crate::boundary::BoundaryData;
use crate::metrics::Local;
use crate::momentum::{FaceTerms, StressWeights};
use crate::openings::Openings;
use crate::{Centre, Faces, Field, Halo, Layout, MixtureModel, StepError};
use face_rows::{FaceRow, for_rows, on_faces};
use grains_domain::Transport;

/// What the particles carry through the box, for drives that keep the flux of the mixture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolidFlux {
    /// Mean of (1 − ε) v over the box (m/s), at the beginning of the coming step.
    pub mean: [f64; 3],
    /// Its rise in the step over that of the mean of ε u (-), as particles follow the fluid.
    pub drag_response: [f64; 3],
    /// Its rise in the step over that of the drive's force (m/s per Pa/m), as they feel that pressure gradient themselves.
    pub gradient_response: [f64; 3],
}

/// What the particles do to the fluid; the caller sets the public fields in the own cells before every step.
#[derive(Clone, Debug)]
pub struct Mixture {
    /// Sharing of the pressure gradient.
    pub model: MixtureModel,
    /// Void fraction ε at the end of the coming step; where walls bound the fluid ψ = V ε, the share of the whole cell.
    pub void_fraction: Field<Centre>,
    /// Force on the fluid per volume of mixture (N/m³), explicit.
    pub source: Faces,
    /// Implicit drag coefficient β ≥ 0 per volume of mixture (kg/(m³ s)): the force −β u at the end of the step; what
    /// belongs to the particles' velocity, +β U, goes into `source`.
    pub drag: Faces,
    /// Their flux, read by drives that keep that of the mixture.
    pub solid: SolidFlux,
    /// What walls leave open, if there are any.
    pub openings: Option<Openings>,
    /// A ε on the faces at the end of the step, if there are walls.
    open_faces: Option<Faces>,
    /// β with the friction of the walls (kg/(m³ s)), if there are any.
    resistance: Option<Faces>,
    /// Force of this friction on a fluid at rest (N/m³), if walls move.
    dragging: Option<Faces>,
    /// Whether walls move in a box without outlet.
    keeps_volume: bool,
    pub(crate) previous: Field<Centre>,
    /// ε in the middle of the step.
    pub(crate) middle: Field<Centre>,
    /// The same on the edges along each axis: of a cell, that of its upper faces normal to the other two axes. Beside walls
    /// by how stresses of the component after the axis act across it, and those of the one before in `cut_edges`.
    edges: [Vec<f64>; 3],
    cut_edges: [Vec<f64>; 3],
    /// ε at the centres by how stresses of each component act across them, beside walls.
    cut_centres: [Vec<f64>; 3],
    /// ε on the faces at the end and the beginning of the step.
    pub(crate) faces: Faces,
    pub(crate) old_faces: Faces,
    /// ε u at the beginning of the step (m/s).
    pub(crate) flux: Faces,
    /// 1/(ε/Δt + β/ρ) (s).
    pub(crate) inverse: Faces,
    /// What −∇p is multiplied with to change the velocity in a step (m³ s/kg).
    pub(crate) gradient_factor: Faces,
    /// Coefficients of the pressure equation, ε × gradient factor (m⁴/(N s)).
    pub(crate) coefficients: Faces,
    /// ∂ε/∂t over the last step (1/s).
    pub rate: Field<Centre>,
    /// Whether `previous` is filled with its halo and `faces` belong to it: what a step leaves behind.
    is_continued: bool,
}

/// 1/m of closed faces (s): nothing moves them.
const SHUT: f64 = 1e-200;

/// What a step is made with.
#[derive(Clone, Copy)]
pub(crate) struct StepInputs<'a> {
    pub velocity: &'a Faces,
    pub density: f64,
    /// Dynamic viscosity (Pa s).
    pub viscosity: f64,
    pub dt: f64,
    pub step: u64,
}

impl Mixture {
    /// Pure fluid, ε = 1.
    pub fn new(model: MixtureModel, layout: Layout) -> Self {
        let mut ones = Faces::new(layout);
        ones.fill(1.0);
        let mut one = Field::new(layout);
        one.fill(1.0);
        Self {
            model,
            void_fraction: one.clone(),
            source: Faces::new(layout),
            drag: Faces::new(layout),
            solid: SolidFlux::default(),
            openings: None,
            open_faces: None,
            resistance: None,
            dragging: None,
            keeps_volume: false,
            previous: one.clone(),
            middle: one,
            edges: std::array::from_fn(|_| vec![1.0; layout.len()]),
            cut_edges: Default::default(),
            cut_centres: Default::default(),
            faces: ones.clone(),
            old_faces: ones,
            flux: Faces::new(layout),
            inverse: Faces::new(layout),
            gradient_factor: Faces::new(layout),
            coefficients: Faces::new(layout),
            rate: Field::new(layout),
            is_continued: false,
        }
    }

    /// Takes what walls leave open now; the void fraction at the end of the step is to be set after it.
    ///
    /// Where walls appear or vanish (`is_changed`) they displace no fluid: it goes or comes with them.
    pub(crate) fn move_walls(&mut self, openings: Openings, is_changed: bool) {
        let Some(old) = self.openings.replace(openings) else { return };
        // What faces hold at the beginning of the step is among the walls as they are in it.
        self.is_continued = false;
        if let (Some(new), true) = (&self.openings, is_changed) {
            let cells =
                self.previous.data_mut().iter_mut().zip(new.cells.data().iter().zip(old.cells.data()));
            cells.for_each(|(psi, (new, old))| *psi = (*psi + new - old).max(0.0));
        }
    }

    /// Pure fluid between walls, in a box without outlet or with one.
    pub(crate) fn enclose(&mut self, openings: Openings, is_closed: bool) {
        let layout = openings.cells.layout();
        for field in [&mut self.void_fraction, &mut self.previous, &mut self.middle] {
            field.data_mut().copy_from_slice(openings.cells.data());
        }
        self.cut_edges = std::array::from_fn(|_| vec![0.0; layout.len()]);
        self.cut_centres = std::array::from_fn(|_| vec![0.0; layout.len()]);
        self.open_faces = Some(Faces::new(layout));
        self.resistance = Some(Faces::new(layout));
        self.dragging = openings.wall_velocity.is_some().then(|| Faces::new(layout));
        self.keeps_volume = is_closed && self.dragging.is_some();
        self.openings = Some(openings);
        self.is_continued = false;
    }

    /// What of a face fluid flows through (-), at the end of the step: ε, beside walls A ε.
    pub fn open_faces(&self) -> &Faces {
        self.open_faces.as_ref().unwrap_or(&self.faces)
    }

    /// Friction coefficient of the walls (kg/(m³ s)) at a face, and the velocity of the closest one (m/s).
    pub(crate) fn wall_friction(&self, component: usize, p: usize) -> [f64; 2] {
        let of = |faces: &Faces| faces.component(component)[p];
        let Some(resistance) = &self.resistance else { return [0.0; 2] };
        let walls = self.openings.as_ref().and_then(|openings| openings.wall_velocity.as_ref());
        [of(resistance) - of(&self.drag), walls.map_or(0.0, of)]
    }

    /// What resists the fluid (kg/(m³ s)): particles, and walls.
    fn resistance(&self) -> &Faces {
        self.resistance.as_ref().unwrap_or(&self.drag)
    }

    /// Gives closed faces the velocity of their wall.
    pub(crate) fn close_velocity(&self, velocity: &mut Faces) {
        let Some(openings) = &self.openings else { return };
        for axis in 0..3 {
            let ratios = openings.ratios.component(axis).iter().enumerate();
            let walls = openings.wall_velocity.as_ref().map(|walls| walls.component(axis));
            let velocity = velocity.component_mut(axis);
            ratios
                .filter(|(_, ratio)| **ratio == 0.0)
                .for_each(|(p, _)| velocity[p] = walls.map_or(0.0, |walls| walls[p]));
        }
    }

    /// Takes the present void fraction as that of the beginning: no change in the first step.
    pub fn begin(&mut self) {
        let (from, to) = (&self.void_fraction, &mut self.previous);
        to.data_mut().copy_from_slice(from.data());
        self.is_continued = false;
    }

    /// Void fraction at the beginning of the coming step, for checkpoints.
    pub fn previous_void_fraction(&self) -> &Field<Centre> {
        &self.previous
    }

    /// Sets the void fraction of the beginning of the coming step, from a checkpoint.
    pub fn set_previous_void_fraction(&mut self, values: &Field<Centre>) {
        self.previous.data_mut().copy_from_slice(values.data());
        self.is_continued = false;
    }

    /// The same, to take what appeared or vanished out of the change over the coming step; own cells.
    pub fn previous_void_fraction_mut(&mut self) -> &mut Field<Centre> {
        self.is_continued = false;
        &mut self.previous
    }

    /// Void fraction in the middle of the step, where stresses act.
    pub(crate) fn porosity(&self) -> StressWeights<'_> {
        let edges = |component: usize, across: usize| -> &[f64] {
            let along = (6 - component - across) % 3;
            match self.openings.is_some() && component == (along + 2) % 3 {
                true => &self.cut_edges[along],
                false => &self.edges[along],
            }
        };
        let edges =
            std::array::from_fn(|c| std::array::from_fn(|a| if a == c { &[][..] } else { edges(c, a) }));
        let centres = std::array::from_fn(|a| match self.cut_centres[a].is_empty() {
            true => self.middle.data(),
            false => &self.cut_centres[a],
        });
        StressWeights { centres, edges }
    }

    /// Coefficients of the momentum equation of a face, over the density.
    pub(crate) fn face_terms(&self, component: usize, p: usize, density: f64, dt: f64) -> FaceTerms {
        let (new, old) = (self.faces.component(component)[p], self.old_faces.component(component)[p]);
        let diagonal = 1.0 / self.inverse.component(component)[p];
        let dragging = self.dragging.as_ref().map_or(0.0, |dragging| dragging.component(component)[p]);
        FaceTerms {
            void_fraction: new,
            gradient: self.gradient_factor.component(component)[p] * diagonal * density,
            diagonal,
            source: (self.source.component(component)[p] + dragging) / density,
            friction: (new - old) / dt + self.resistance().component(component)[p] / density,
        }
    }

    /// Increments (m/s) of a row that starts at `start`, from the sum of its advective and viscous terms (m/s²): Δu =
    /// (sum + S/ρ − u ∂ε/∂t − β u/ρ)/m, without the pressure.
    pub(crate) fn increments(
        &self,
        component: usize,
        start: usize,
        inputs: StepInputs<'_>,
        sum: &[f64],
        out: &mut [f64],
    ) {
        let n = out.len();
        let [new, old, drag, source, inverse, velocity] =
            [&self.faces, &self.old_faces, self.resistance(), &self.source, &self.inverse, inputs.velocity]
                .map(|faces| &faces.component(component)[start..start + n]);
        let sum = &sum[..n];
        let (rate, specific) = (1.0 / inputs.dt, 1.0 / inputs.density);
        for i in 0..n {
            // ∂(εu)/∂t = ε Δu/Δt + u ∂ε/∂t, and the drag on the old velocity.
            let friction = (new[i] - old[i]) * rate + drag[i] * specific;
            out[i] = (sum[i] + source[i] * specific - friction * velocity[i]) * inverse[i];
        }
        if let Some(dragging) = &self.dragging {
            let dragging = &dragging.component(component)[start..start + n];
            let increments = out.iter_mut().zip(dragging.iter().zip(inverse));
            increments.for_each(|(out, (force, inverse))| *out += force * specific * inverse);
        }
    }

    /// Gives the faces their void fraction, as a step leaves it: for states that come from elsewhere; collective.
    pub(crate) fn settle_faces(
        &mut self,
        local: &Local,
        boundary_data: &[BoundaryData],
        halo: &mut Halo,
        transport: &dyn Transport,
    ) {
        let openings = self.openings.as_ref();
        let places = (local, boundary_data, halo);
        on_faces(&mut self.void_fraction, &mut self.faces, openings, places, transport);
        for face_data in boundary_data {
            face_data
                .for_imposed(local.layout, |face| self.faces.component_mut(face_data.face.axis)[face] = 1.0);
        }
        self.set_open_faces(local.layout, boundary_data);
    }

    /// Checks the void fraction and works out what a step needs of it; collective.
    pub(crate) fn prepare(
        &mut self,
        local: &Local,
        boundary_data: &[BoundaryData],
        halo: &mut Halo,
        inputs: StepInputs<'_>,
        transport: &dyn Transport,
    ) -> Result<(), StepError> {
        self.check(local, inputs.step, transport)?;
        let [x, y, z] = self.drag.components_mut();
        halo.fill(&mut [self.void_fraction.data_mut(), x, y, z], transport);
        boundary_data.iter().for_each(|face_data| face_data.fill_even(&mut self.void_fraction));
        std::mem::swap(&mut self.faces, &mut self.old_faces);
        if !self.is_continued {
            let openings = self.openings.as_ref();
            on_faces(
                &mut self.previous,
                &mut self.old_faces,
                openings,
                (local, boundary_data, halo),
                transport,
            );
        }
        self.set_middle(local.layout, inputs.dt);
        if self.dragging.is_some() {
            self.share_rates(local);
        }
        if self.keeps_volume {
            self.keep_volume(local, transport);
        }
        for axis in 0..3 {
            for_rows(local, axis, |row| self.set_row(row, inputs));
        }
        self.set_imposed(local.layout, boundary_data, inputs.velocity);
        self.set_open_faces(local.layout, boundary_data);
        Ok(())
    }

    /// Nothing is in the way on faces with an imposed velocity: it is the superficial one, whatever lies behind.
    fn set_imposed(&mut self, layout: Layout, boundary_data: &[BoundaryData], velocity: &Faces) {
        for face_data in boundary_data {
            let axis = face_data.face.axis;
            face_data.for_imposed(layout, |face| {
                self.faces.component_mut(axis)[face] = 1.0;
                self.old_faces.component_mut(axis)[face] = 1.0;
                self.flux.component_mut(axis)[face] = velocity.component(axis)[face];
            });
        }
    }

    /// What is open of the faces, where there are walls: of faces with an imposed velocity what these leave.
    fn set_open_faces(&mut self, layout: Layout, boundary_data: &[BoundaryData]) {
        let (Some(openings), Some(open_faces)) = (&self.openings, &mut self.open_faces) else { return };
        for axis in 0..3 {
            let (eps, ratios) = (self.faces.component(axis), openings.ratios.component(axis));
            let faces = open_faces.component_mut(axis).iter_mut().zip(eps.iter().zip(ratios));
            faces.for_each(|(open, (eps, ratio))| *open = eps * ratio);
        }
        for face_data in boundary_data {
            let axis = face_data.face.axis;
            face_data.for_imposed(layout, |face| {
                let share = openings.faces.component(axis)[face];
                open_faces.component_mut(axis)[face] = share;
                self.flux.component_mut(axis)[face] *= share;
            });
        }
    }

    /// ε in the middle of the step at centres and edges, and its rate of change.
    fn set_middle(&mut self, layout: Layout, dt: f64) {
        let (new, old, rate) = (self.void_fraction.data(), self.previous.data(), 1.0 / dt);
        let means = self.middle.data_mut().iter_mut().zip(self.rate.data_mut());
        for ((middle, change), (new, old)) in means.zip(new.iter().zip(old)) {
            *middle = 0.5 * (new + old);
            *change = (new - old) * rate;
        }
        let (strides, middle) = (layout.strides(), self.middle.data());
        for (axis, edges) in self.edges.iter_mut().enumerate() {
            let [a, b] = [strides[(axis + 1) % 3], strides[(axis + 2) % 3]];
            // Straight through the array: what wraps around its ends is never read.
            let n = layout.len() - a - b;
            let corners = [0, a, b, a + b].map(|offset| &middle[offset..offset + n]);
            for (i, edge) in edges[..n].iter_mut().enumerate() {
                *edge = 0.25 * ((corners[0][i] + corners[1][i]) + (corners[2][i] + corners[3][i]));
            }
        }
        let Some(openings) = &self.openings else { return };
        for (cut, shares) in self.cut_centres.iter_mut().zip(&openings.centres) {
            let centres = cut.iter_mut().zip(self.middle.data().iter().zip(shares));
            centres.for_each(|(cut, (middle, share))| *cut = middle * share);
        }
        for ((edges, cut), shares) in self.edges.iter_mut().zip(&mut self.cut_edges).zip(&openings.edges) {
            let both = edges.iter_mut().zip(cut).zip(shares[0].iter().zip(&shares[1]));
            for ((edge, cut), (first, second)) in both {
                (*edge, *cut) = (*edge * first, *edge * second);
            }
        }
    }

    /// All that belongs to the faces of a row.
    fn set_row(&mut self, row: FaceRow<'_>, inputs: StepInputs<'_>) {
        let axis = row.axis;
        row.interpolate(&self.void_fraction, self.faces.component_mut(axis));
        row.gain(self.openings.as_ref(), self.faces.component_mut(axis));
        let own = row.start..row.start + row.length;
        let (new, old) =
            (&self.faces.component(axis)[own.clone()], &self.old_faces.component(axis)[own.clone()]);
        let velocity = &inputs.velocity.component(axis)[own.clone()];
        let flux = &mut self.flux.component_mut(axis)[own.clone()];
        flux.iter_mut().zip(old.iter().zip(velocity)).for_each(|(q, (eps, u))| *q = eps * u);
        let (rate, specific) = (1.0 / inputs.dt, 1.0 / inputs.density);
        let mut drag = &self.drag.component(axis)[own.clone()];
        if let (Some(openings), Some(resistance)) = (&self.openings, &mut self.resistance) {
            let friction = openings.friction.component(axis)[own.clone()].iter().zip(new);
            let resistance = &mut resistance.component_mut(axis)[own.clone()];
            for ((sum, beta), (friction, eps)) in resistance.iter_mut().zip(drag).zip(friction) {
                *sum = beta + inputs.viscosity * friction * eps;
            }
            if let (Some(dragging), Some(walls)) = (&mut self.dragging, &openings.wall_velocity) {
                let dragging = &mut dragging.component_mut(axis)[own.clone()];
                let walls = &walls.component(axis)[own.clone()];
                let forces = dragging.iter_mut().zip(walls).zip(resistance.iter().zip(drag));
                forces.for_each(|((force, wall), (sum, beta))| *force = (sum - beta) * wall);
            }
            drag = resistance;
        }
        let inverse = &mut self.inverse.component_mut(axis)[own.clone()];
        for (inverse, (eps, beta)) in inverse.iter_mut().zip(new.iter().zip(drag)) {
            *inverse = 1.0 / (eps * rate + beta * specific);
        }
        if let Some(openings) = &self.openings {
            let ratios = &openings.ratios.component(axis)[own.clone()];
            let faces = inverse.iter_mut().zip(flux).zip(ratios);
            for ((inverse, flux), ratio) in faces {
                *flux *= ratio;
                *inverse = if *ratio > 0.0 { *inverse } else { SHUT };
            }
        }
        let inverse = &self.inverse.component(axis)[own.clone()];
        let gradient_factor = &mut self.gradient_factor.component_mut(axis)[own.clone()];
        let factors = inverse.iter().zip(new.iter().zip(old));
        match self.model {
            MixtureModel::A => {
                gradient_factor.iter_mut().zip(factors).for_each(|(factor, (inverse, (new, old)))| {
                    *factor = 0.5 * specific * (new + old) * inverse;
                })
            }
            MixtureModel::B => gradient_factor.iter_mut().zip(factors).for_each(|(factor, (inverse, _))| {
                *factor = specific * inverse;
            }),
        }
        let coefficients = &mut self.coefficients.component_mut(axis)[own];
        coefficients
            .iter_mut()
            .zip(new.iter().zip(&*gradient_factor))
            .for_each(|(c, (eps, factor))| *c = eps * factor);
        let Some(openings) = &self.openings else { return };
        let own = row.start..row.start + row.length;
        let ratios = &openings.ratios.component(axis)[own.clone()];
        coefficients.iter_mut().zip(ratios).for_each(|(c, ratio)| *c *= ratio);
        if self.model == MixtureModel::B {
            // ∇p acts on all that walls leave open, particles or not.
            let volumes = &openings.volumes.component(axis)[own.clone()];
            let factors = self.gradient_factor.component_mut(axis)[own].iter_mut().zip(coefficients);
            factors.zip(volumes).for_each(|((factor, c), volume)| {
                *factor *= volume;
                *c *= volume;
            });
        }
    }

    fn check(&self, local: &Local, step: u64, transport: &dyn Transport) -> Result<(), StepError> {
        let [nx, ny, nz] = local.layout.cells;
        let mut worst: Option<(f64, [usize; 3])> = None;
        for k in 0..nz {
            for j in 0..ny {
                for (i, &eps) in self.void_fraction.row(j, k).iter().enumerate().take(nx) {
                    let open = self.openings.as_ref().map_or(1.0, |open| open.cells.row(j, k)[i]);
                    let is_solid = open == 0.0 && eps == 0.0;
                    let is_right = is_solid || (eps > 0.0 && eps <= open + 1e-9);
                    if !is_right && worst.is_none() {
                        worst = Some((eps, [i, j, k]));
                    }
                }
            }
        }
        // All ranks fail alike, with the cell of the first rank that has one.
        let Some(first) = transport.first_rank_with(worst.is_some()) else { return Ok(()) };
        let mut found = [0.0; 4];
        if let (Some((value, cell)), true) = (worst, first == transport.rank()) {
            let at: [usize; 3] = std::array::from_fn(|a| cell[a] + local.first[a]);
            found = [value, at[0] as f64, at[1] as f64, at[2] as f64];
        }
        transport.sum(&mut found);
        let [value, at @ ..] = found;
        Err(StepError::VoidFraction { step, value, cell: at.map(|place| place as usize) })
    }

    /// After the step, its end is the next one's beginning.
    pub(crate) fn finish(&mut self) {
        self.begin();
        self.is_continued = true;
    }
}
