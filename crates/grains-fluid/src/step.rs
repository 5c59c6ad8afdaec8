//! One step: predict, diffuse, divergence, pressure, correct.

use crate::boundary::{MAX_GHOSTS, fill_velocity};
use crate::clock::Phase;
use crate::flow::{Drive, Flow, Immersed, March, StepReport, close_faces};
use crate::mixture::{SolidFlux, StepInputs};
use crate::momentum::{Diffusion, MomentumDiagonal, imposed_increments};
use crate::projection::{Correction, add_divergence, divergence};
use crate::{Advection, Centre, Field, SolveError, SolveReport, StepError};
use grains_domain::Transport;

/// What a net source may be of the fluxes through the faces and still pass for rounding.
const IMBALANCE: f64 = 1e-9;

/// The same of the volume V/dt that the void fraction could free or fill in a step: that of its rounding, summed.
const ROUNDING: f64 = 1e-13;

impl Flow {
    /// One time step of `dt` seconds; collective.
    ///
    /// Adams–Bashforth for advection (with the ratio of the last two steps; Euler in the first), Crank–Nicolson for
    /// diffusion, incremental pressure correction p ← p + φ − ½ μ ∇·u*. Without particles nothing is allocated on
    /// one rank.
    pub fn step(&mut self, dt: f64, transport: &dyn Transport) -> Result<StepReport, StepError> {
        let step = self.state.step;
        if !(dt > 0.0 && dt.is_finite()) {
            return Err(StepError::TimeStep { step, dt });
        }
        self.clock.start();
        if let Some(mixture) = &mut self.mixture {
            let inputs = StepInputs {
                velocity: &self.state.velocity,
                density: self.setup.density,
                viscosity: self.setup.viscosity,
                dt,
                step,
            };
            mixture.prepare(&self.local, &self.boundary_data, &mut self.halo, inputs, transport)?;
            let Self { boundary_data, solver, .. } = self;
            close_faces(boundary_data, &mut mixture.coefficients);
            solver
                .set_coefficients(&mixture.coefficients, transport)
                .map_err(|source| StepError::Pressure { step, source })?;
        }
        self.set_viscosity();
        let before = self.driven_means(transport);
        self.predict(dt);
        self.clock.book(Phase::Momentum);
        self.diffuse(dt, transport);
        self.add_increments();
        self.clock.book(Phase::Diffusion);
        self.keep_means(before, dt, transport);
        let solve = self.project(dt, transport)?;
        self.carry_along(dt, transport)?;
        self.clock.book(Phase::Scalars);
        if let Some(mixture) = &mut self.mixture {
            mixture.finish();
        }
        self.keep_volumes();
        self.state.time += dt;
        self.state.step += 1;
        self.state.last_dt = dt;
        Ok(StepReport { dt, solve })
    }

    /// Makes the fluxes through the faces free of sources, with those by way of bodies; collective.
    pub(crate) fn project(&mut self, dt: f64, transport: &dyn Transport) -> Result<SolveReport, StepError> {
        let step = self.state.step;
        // What fluid passes, fluid must bring: none goes through bodies, whatever the extrapolated velocities inside.
        self.add_extrapolated(-1.0);
        self.exchange_velocity(1, transport);
        self.clock.book(Phase::Boundaries);
        self.source(dt, transport)?;
        self.clock.book(Phase::Divergence);
        let solved = self.solver.solve(&self.rhs, &mut self.state.correction, transport);
        let solve = solved.map_err(|source| match self.check_inflow(transport) {
            Err(source) => StepError::ShutOff { step, source },
            Ok(()) => StepError::Pressure { step, source },
        })?;
        self.clock.book(Phase::Pressure);
        self.correct(dt, transport)?;
        Ok(solve)
    }

    /// Changes of imposed velocities over the step, and the implicit half of the diffusion.
    fn diffuse(&mut self, dt: f64, transport: &dyn Transport) {
        let time = self.state.time + dt;
        for face_data in self.boundary_data.iter_mut().filter(|t| t.is_unsteady) {
            face_data.evaluate(&self.setup.grid, &self.local, &self.setup.boundaries, time);
        }
        let diagonal = MomentumDiagonal {
            inverse: self.mixture.as_ref().map(|mixture| &mixture.inverse),
            dt,
            weights: match &self.viscosity {
                Some(viscosity) => Some(viscosity.weights()),
                None => self.mixture.as_ref().map(|mixture| mixture.porosity()),
            },
            viscosity: self.weighed_viscosity(),
            implicitness: self.viscosity.as_ref().map_or(0.5, |viscosity| viscosity.implicitness()),
            is_full: self.viscosity.is_some(),
            carrier: (self.march == March::PseudoTime).then_some(&self.state.velocity),
        };
        let is_implicit = self.setup.diffusion == Diffusion::Implicit;
        imposed_increments(&self.local, &self.boundary_data, diagonal, is_implicit, &mut self.increments);
        if is_implicit {
            let Self { implicit, local, boundary_data, increments, halo, .. } = self;
            implicit.solve(local, boundary_data, diagonal, increments, halo, transport);
        }
    }

    /// u* = u + Δu on all own faces and the lower boundary faces; in pseudo-time u takes the place of Δu.
    fn add_increments(&mut self) {
        let layout = self.local.layout;
        let n = layout.cells[0];
        for face_data in self.boundary_data.iter().filter(|t| t.face.outward() < 0.0) {
            let increments = self.increments.component(face_data.face.axis);
            face_data.add_boundary(increments, &mut self.state.velocity);
        }
        for component in (0..3).filter(|&c| self.local.active[c]) {
            let increments = self.increments.component_mut(component);
            let velocity = self.state.velocity.component_mut(component);
            for start in layout.rows() {
                let own = start..start + n;
                let pairs = velocity[own.clone()].iter_mut().zip(&mut increments[own]);
                match self.march {
                    March::Time => pairs.for_each(|(u, d)| *u += *d),
                    March::PseudoTime => pairs.for_each(|(u, d)| (*u, *d) = (*u + *d, *u)),
                }
            }
        }
    }

    /// Adds a multiple of the extrapolated velocities inside bodies to the own ones.
    fn add_extrapolated(&mut self, share: f64) {
        let Some(extrapolated) = self.immersed.as_ref().and_then(|bodies| bodies.extrapolated.as_ref())
        else {
            return;
        };
        for (component, values) in extrapolated.iter().enumerate() {
            let velocity = self.state.velocity.component_mut(component);
            values.iter().for_each(|&(place, value)| velocity[place as usize] += share * value);
        }
    }

    /// Means of ε u (m/s) along the axes on which the flux of a mixture is kept, 0 along others.
    fn driven_means(&self, transport: &dyn Transport) -> [f64; 3] {
        let is_kept = |a: usize| self.mixture.is_some() && matches!(self.setup.drive[a], Drive::MeanFlux(_));
        [0, 1, 2].map(|a| if is_kept(a) { self.mean_velocity(a, transport) } else { 0.0 })
    }

    /// Adds to a driven axis the uniform force that restores its mean velocity, and keeps the force.
    ///
    /// ⟨ε u⟩ = ⟨ε u⟩* + R Δf. Of a mixture the flux Q = ⟨ε u⟩ + ⟨(1 − ε) v⟩ is wanted, with
    /// ⟨(1 − ε) v⟩ = s + κ (⟨ε u⟩ − ⟨ε u⟩₀) + λ Δf: s and ⟨ε u⟩₀ at the beginning of the step, κ and λ from the [`SolidFlux`].
    /// In steady motion nothing depends on κ and λ, which steady the drive.
    fn keep_means(&mut self, before: [f64; 3], dt: f64, transport: &dyn Transport) {
        let solid = self.mixture.as_ref().map_or(SolidFlux::default(), |mixture| mixture.solid);
        for (axis, before) in before.into_iter().enumerate() {
            if !self.local.active[axis] {
                continue;
            }
            let (wanted, [s, drag, gradient]) = match self.setup.drive[axis] {
                Drive::MeanVelocity(wanted) => (wanted, [0.0; 3]),
                Drive::MeanFlux(wanted) => {
                    (wanted, [solid.mean[axis], solid.drag_response[axis], solid.gradient_response[axis]])
                }
                Drive::None | Drive::PressureGradient(_) => continue,
            };
            let [mean, response] = self.mean_and_response(axis, dt, transport);
            let lacking = wanted - s + drag * before - (1.0 + drag) * mean;
            let force = lacking / ((1.0 + drag) * response + gradient);
            self.state.force[axis] += force;
            let density = self.setup.density;
            let layout = self.local.layout;
            for start in layout.rows() {
                for p in start..start + layout.cells[0] {
                    let gradient_factor =
                        self.mixture.as_ref().map_or(dt / density, |m| m.gradient_factor.component(axis)[p]);
                    self.state.velocity.component_mut(axis)[p] += force * gradient_factor;
                }
            }
        }
    }

    fn exchange_velocity(&mut self, depth: usize, transport: &dyn Transport) {
        let [x, y, z] = self.state.velocity.components_mut();
        self.halo.fill_to(depth, &mut [x, y, z], transport);
    }

    /// Lower bound of the viscosity (Pa s).
    fn smallest_viscosity(&self) -> f64 {
        self.viscosity.as_ref().map_or(self.setup.viscosity, |viscosity| viscosity.smallest_viscosity())
    }

    /// Dynamic viscosity (Pa s) at the centres of the own cells, of the present velocity; not collective, halos and ghosts of the
    /// velocity are filled.
    pub fn dynamic_viscosity(&mut self) -> Field<Centre> {
        match &mut self.viscosity {
            Some(viscosity) => viscosity.dynamic_viscosity(
                &self.local,
                &self.boundary_data,
                self.state.velocity.components(),
            ),
            None => {
                let mut field = Field::new(self.local.layout);
                field.fill(self.setup.viscosity);
                field
            }
        }
    }

    /// Layers of the velocity's halo that the next step reads; all where something else looks at them before it ends.
    pub fn layers_of_step(&self) -> usize {
        let is_sampled =
            self.immersed.as_ref().is_some_and(|i| i.passing.is_some() || i.extrapolated.is_none());
        if self.mixture.is_some() || is_sampled { self.setup.halo } else { 2 }
    }

    /// Fills so many layers of the halo, and the ghosts, of the velocity: to be called when it was changed inside; collective.
    pub fn refresh_velocity(&mut self, depth: usize, transport: &dyn Transport) {
        self.exchange_velocity(depth, transport);
        let ghosts = self.ghosts();
        fill_velocity(&self.boundary_data, &mut self.state.velocity, ghosts);
    }

    /// Fills the halo, one layer, and the ghosts of the pressure; collective.
    pub(crate) fn refresh_pressure(&mut self, transport: &dyn Transport) {
        self.halo.fill_to(1, &mut [self.state.pressure.data_mut()], transport);
        self.impose_pressures();
    }

    /// Fills the halo, two layers, of what passes cut faces; collective.
    pub fn refresh_passing(&mut self, transport: &dyn Transport) {
        if let Some(passing) = self.immersed.as_mut().and_then(|bodies| bodies.passing.as_mut()) {
            let [x, y, z] = passing.components_mut();
            self.halo.fill_to(2, &mut [x, y, z], transport);
        }
    }

    /// Layers of ghosts that the next step reads: central differences one, the bounded scheme and rates of strain two.
    fn ghosts(&self) -> usize {
        if self.setup.advection == Advection::Central && self.viscosity.is_none() { 1 } else { MAX_GHOSTS }
    }

    /// Right-hand side of the pressure equation; extrapolated velocities are taken out of the velocity and come back to the own
    /// ones.
    fn source(&mut self, dt: f64, transport: &dyn Transport) -> Result<(), StepError> {
        let flux = self.mixture.as_ref().map(|m| (m.open_faces().components(), m.rate.data()));
        let passing = self.immersed.as_ref().and_then(|bodies| bodies.passing.as_ref());
        let [mut sum, mut scale] = divergence(&self.local, &self.state.velocity, flux, &mut self.rhs);
        if let Some(passing) = passing {
            let [beyond, size] = add_divergence(&self.local, passing, &mut self.rhs);
            (sum, scale) = (sum + beyond, scale + size);
        }
        self.add_extrapolated(1.0);
        let mut sums = [sum, scale];
        transport.sum(&mut sums);
        let ([sum, scale], step) = (sums, self.state.step);
        self.seal(transport);
        if !scale.is_finite() {
            return Err(StepError::NotFinite { step, dt, cfl: self.own_cfl_number(dt) });
        }
        let has_outlet = self.setup.boundaries.has_outlet(&self.setup.grid);
        let of_rounding = if self.mixture.is_some() { ROUNDING * self.setup.grid.volume() / dt } else { 0.0 };
        if !has_outlet && sum.abs() > IMBALANCE * scale + of_rounding {
            return Err(StepError::Pressure { step, source: SolveError::Incompatible { sum, scale } });
        }
        Ok(())
    }

    /// Spreads the source in cells inside walls that move evenly over them, or takes it out where there is an outlet; collective.
    fn seal(&mut self, transport: &dyn Transport) {
        let Some(Immersed { sealed, .. }) = self.immersed.as_ref().filter(|bodies| bodies.walls_move) else {
            return;
        };
        let rhs = self.rhs.data_mut();
        let source = sealed.iter().map(|&cell| rhs[cell as usize]).sum::<f64>();
        let mut sums = [source, sealed.len() as f64];
        transport.sum(&mut sums);
        let [source, count] = sums;
        let has_outlet = self.setup.boundaries.has_outlet(&self.setup.grid);
        let mean = if has_outlet || count == 0.0 { 0.0 } else { source / count };
        sealed.iter().for_each(|&cell| rhs[cell as usize] = mean);
    }

    /// u = u* − ∇φ/m, p += φ − ½ μ ∇·u*; halos and boundary values.
    fn correct(&mut self, dt: f64, transport: &dyn Transport) -> Result<(), StepError> {
        let is_implicit = self.setup.diffusion == Diffusion::Implicit;
        self.halo.fill_to(1, &mut [self.state.correction.data_mut()], transport);
        self.boundary_data.iter().for_each(|t| t.fill_pressure(&mut self.state.correction, 0.0));
        self.clock.book(Phase::Boundaries);
        let correction = Correction {
            local: &self.local,
            potential: self.state.correction.data(),
            coefficients: self.mixture.as_ref(),
            scale: if self.mixture.is_some() { 1.0 } else { self.setup.density / dt },
            viscosity: if is_implicit { self.smallest_viscosity() } else { 0.0 },
        };
        correction.velocity(&mut self.state.velocity);
        correction.outlets(&self.boundary_data, &mut self.state.velocity);
        correction.pressure(&self.rhs, &mut self.state.pressure);
        self.balance_fans(dt, transport)?;
        if let Some(openings) = self.mixture.as_ref().and_then(|mixture| mixture.openings.as_ref()) {
            // Nothing says what the pressure is where there is no fluid.
            let cells = self.state.pressure.data_mut().iter_mut().zip(openings.cells.data());
            cells.filter(|(_, open)| **open == 0.0).for_each(|(pressure, _)| *pressure = 0.0);
        }
        self.clock.book(Phase::Correction);
        let ghosts = self.ghosts();
        // Bodies sample the velocity as far as the halo goes, particles in a mixture both.
        let (all, is_mixture) = (self.setup.halo, self.mixture.is_some());
        let depth = if self.immersed.is_some() { all } else { self.layers_of_step() };
        let state = &mut self.state;
        let [x, y, z] = state.velocity.components_mut();
        if is_mixture {
            self.halo.fill(&mut [x, y, z, state.pressure.data_mut()], transport);
        } else {
            self.halo.fill_to(depth, &mut [x, y, z], transport);
            self.halo.fill_to(1, &mut [state.pressure.data_mut()], transport);
        }
        fill_velocity(&self.boundary_data, &mut state.velocity, ghosts);
        self.impose_pressures();
        self.clock.book(Phase::Boundaries);
        Ok(())
    }
}
