//! The time step: as long as accuracy and stability allow.

use crate::Diffusion;
use crate::flow::{Drive, Flow};
use grains_domain::Transport;

/// Limits of the time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowLimits {
    /// Largest Courant number Σ |u| Δt/Δx.
    pub cfl: f64,
    /// Largest ν Δt Σ 1/Δx² where diffusion is explicit; Adams–Bashforth is stable up to 1/4.
    pub diffusion: f64,
    /// Longest step (s): what holds for fluid at rest.
    pub longest: f64,
    /// Largest ratio of a step to the one before.
    pub growth: f64,
}

impl FlowLimits {
    /// Courant number 0.25 (two-step Adams–Bashforth damps little), explicit diffusion at 0.2.
    pub fn new(longest: f64) -> Self {
        Self { cfl: 0.25, diffusion: 0.2, longest, growth: 1.2 }
    }

    /// Next time step (s); collective.
    pub fn time_step(&self, flow: &Flow, transport: &dyn Transport) -> f64 {
        let limit = self.longest.min(self.stable_step(flow, transport));
        if flow.state.last_dt > 0.0 { limit.min(self.growth * flow.state.last_dt) } else { limit }
    }

    /// Longest step (s) by the Courant number, of the velocities there are and of the means that drives restore, and by explicit
    /// diffusion; collective.
    pub fn stable_step(&self, flow: &Flow, transport: &dyn Transport) -> f64 {
        let mut rates = [flow.rates_of_own_cells().max(flow.rate_of_drive()) / self.cfl, 0.0];
        if flow.setup.diffusion == Diffusion::Explicit {
            rates[1] = flow.diffusion_rate() / self.diffusion;
        }
        transport.max(&mut rates);
        1.0 / rates[0].max(rates[1])
    }

    /// Whether velocities imposed by functions of time keep the Courant number all through a step (s); collective.
    pub fn holds_ahead(&self, flow: &Flow, dt: f64, transport: &dyn Transport) -> bool {
        /// Times in the step at which the functions are looked at.
        const SAMPLES: u32 = 4;
        if !flow.setup.boundaries.is_unsteady(&flow.setup.grid) {
            return true;
        }
        let mut largest = [0.0];
        for sample in 1..=SAMPLES {
            let time = flow.state.time + dt * f64::from(sample) / f64::from(SAMPLES);
            largest[0] = f64::max(largest[0], flow.rate_of_boundaries(time));
        }
        transport.max(&mut largest);
        largest[0] * dt <= self.cfl
    }
}

impl Flow {
    /// Largest Courant number Σ |u| Δt/Δx with a step (s); collective.
    pub fn cfl_number(&self, dt: f64, transport: &dyn Transport) -> f64 {
        let mut largest = [self.rates_of_own_cells()];
        transport.max(&mut largest);
        largest[0] * dt
    }

    /// Σ |U|/Δx (1/s) of the mean velocities U that drives restore, at the narrowest own cells.
    fn rate_of_drive(&self) -> f64 {
        let rate = |a: usize| match self.setup.drive[a] {
            Drive::MeanVelocity(mean) | Drive::MeanFlux(mean) => mean.abs() * self.largest_inverse_width(a),
            Drive::None | Drive::PressureGradient(_) => 0.0,
        };
        (0..3).filter(|&a| self.local.active[a]).map(rate).sum()
    }

    /// Largest Σ |u|/Δx (1/s) of the velocities imposed at a time (s) by functions of it, in the own cells behind them.
    fn rate_of_boundaries(&self, time: f64) -> f64 {
        let unsteady = self.boundary_data.iter().filter(|face_data| face_data.is_unsteady);
        unsteady.fold(0.0, |largest: f64, face_data| {
            let mut face_data = face_data.clone();
            face_data.evaluate(&self.setup.grid, &self.local, &self.setup.boundaries, time);
            largest.max(face_data.largest_rate(&self.local))
        })
    }

    /// Largest 1/Δx of the own cells along an axis (1/m).
    fn largest_inverse_width(&self, axis: usize) -> f64 {
        let h = self.local.layout.halo;
        let own = &self.local.axes[axis].inverse_width[h..h + self.local.layout.cells[axis]];
        own.iter().fold(0.0_f64, |max, inverse| max.max(*inverse))
    }

    /// Largest ν Σ 1/Δx² of the own cells (1/s).
    fn diffusion_rate(&self) -> f64 {
        let nu = self.setup.viscosity / self.setup.density;
        let squared = |a: usize| nu * self.largest_inverse_width(a).powi(2);
        (0..3).filter(|&a| self.local.active[a]).map(squared).sum()
    }
}
