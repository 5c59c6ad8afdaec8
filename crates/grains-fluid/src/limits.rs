//! The time step: as long as accuracy and stability allow.

use crate::Diffusion;
use crate::flow::Flow;
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
        let mut rates = [flow.rates_of_own_cells() / self.cfl, 0.0];
        if flow.setup.diffusion == Diffusion::Explicit {
            rates[1] = flow.diffusion_rate() / self.diffusion;
        }
        transport.max(&mut rates);
        let limit = self.longest.min(1.0 / rates[0].max(rates[1]));
        if flow.state.last_dt > 0.0 { limit.min(self.growth * flow.state.last_dt) } else { limit }
    }
}

impl Flow {
    /// Largest Courant number Σ |u| Δt/Δx with a step (s); collective.
    pub fn courant(&self, dt: f64, transport: &dyn Transport) -> f64 {
        let mut largest = [self.rates_of_own_cells()];
        transport.max(&mut largest);
        largest[0] * dt
    }

    /// Largest ν Σ 1/Δx² of the own cells (1/s).
    fn diffusion_rate(&self) -> f64 {
        let nu = self.setup.viscosity / self.setup.density;
        let largest = |a: usize| {
            let h = self.local.layout.halo;
            self.local.axes[a].inverse_width[h..h + self.local.layout.cells[a]]
                .iter()
                .fold(0.0_f64, |m, w| m.max(*w))
        };
        (0..3).filter(|&a| self.local.active[a]).map(|a| nu * largest(a).powi(2)).sum()
    }
}
