//! How long steps of scalars may be.
//!
//! Scalars that are to settle in a flow that stays as it is: each cell goes by its own step, as long as what leaves it and diffuses
//! through it allow, so that slow corners and solids do not wait for the fastest jet. What settles does not depend on it.

use super::advance::{CarrierFlow, own_cells};
use super::{BEYOND, Scalar, Scalars, Scheme, SolidCondition};
use crate::metrics::Local;
use grains_domain::Transport;

/// Courant and Fourier number of a cell in its own step where scalars settle (-), and the smallest share of a cell in the longest step.
const PACE_BY_FLOW: f64 = 0.5;
const PACE_BY_DIFFUSION: f64 = 0.4;
const SLOWEST_PACE: f64 = 0.02;

impl Scalars {
    /// Largest Fourier numbers D Δt/Δx² of the bounded scalars along the axes, inside solids too.
    pub(super) fn fourier_numbers(&self, local: &Local, dt: f64) -> [f64; 3] {
        let bounded = self.all.iter().filter(|scalar| scalar.setup.scheme == Scheme::Bounded);
        let inside = |scalar: &Scalar| match &scalar.setup.solids.bodies {
            SolidCondition::Interior(interior) => interior.diffusivity,
            _ => 0.0,
        };
        let diffusivity = bounded.map(|s| s.setup.diffusivity.max(inside(s))).fold(0.0, f64::max);
        [0, 1, 2].map(|a| {
            let h = local.layout.halo;
            let own = &local.axes[a].inverse_width[h..h + local.layout.cells[a]];
            let inverse = own.iter().copied().fold(0.0, f64::max);
            if local.active[a] { diffusivity * dt * inverse * inverse } else { 0.0 }
        })
    }

    /// Lets each cell go at its own pace from here on, as scalars are to settle: by what leaves it and diffuses in a step `dt` (s).
    pub(super) fn settle_at_own_pace(
        &mut self,
        mut carrier: CarrierFlow<'_>,
        transport: &dyn Transport,
    ) -> Result<(), f64> {
        self.set_fluxes(&mut carrier, transport);
        let (local, dt) = (carrier.local, carrier.dt);
        let (layout, strides) = (local.layout, local.layout.strides());
        let of_solids = |scalar: &Scalar| match &scalar.setup.solids.bodies {
            SolidCondition::Interior(interior) => interior.diffusivity,
            _ => 0.0,
        };
        let largest = |solid: bool| {
            let of = |scalar: &Scalar| if solid { of_solids(scalar) } else { scalar.setup.diffusivity };
            self.all.iter().map(of).fold(0.0, f64::max)
        };
        let diffusivities = [largest(false), largest(true)];
        let mut pace = vec![1.0; layout.len()];
        let mut fastest = [0.0_f64];
        for p in own_cells(layout) {
            let flux = |a: usize| self.work.flux.component(a);
            let leaving: f64 = (0..3).map(|a| flux(a)[p].max(0.0) - flux(a)[p - strides[a]].min(0.0)).sum();
            let open = self.all.iter().filter_map(|s| s.barrier.as_ref()).map(|b| b.capacity[p]);
            let courant = dt * leaving / self.volume[p];
            let share = open.fold(1.0, f64::min);
            let is_solid = self.solids.as_ref().is_some_and(|s| s.holder[p] != 0 && s.holder[p] != BEYOND);
            // Beside a surface both diffuse.
            let near = self.all.iter().filter_map(|s| s.barrier.as_ref()).any(|b| b.capacity[p] != 1.0);
            let diffusivity = match (is_solid, near) {
                (true, _) => diffusivities[1].max(if near { diffusivities[0] } else { 0.0 }),
                (false, _) => diffusivities[0],
            };
            let narrowest = (0..3).filter(|&a| local.active[a]).map(|a| {
                let e = p / strides[a] % layout.dims()[a];
                local.axes[a].inverse_width[e]
            });
            let fourier = dt * diffusivity * narrowest.fold(0.0, f64::max).powi(2);
            fastest[0] = fastest[0].max(courant / PACE_BY_FLOW);
            // A cell of which solids leave a small share goes slower than all others.
            pace[p] = (courant / share / PACE_BY_FLOW).max(fourier / PACE_BY_DIFFUSION);
        }
        // Of the longest step, in which the fastest cell is at its limit: this one may be shorter.
        transport.max(&mut fastest);
        let longest = if fastest[0] > 0.0 { 1.0 / fastest[0] } else { 1.0 };
        own_cells(layout).for_each(|p| pace[p] = (longest * pace[p]).max(SLOWEST_PACE));
        let before: Vec<f64> = (0..self.all.len()).map(|number| self.kept(number)).collect();
        self.pace = pace;
        for (number, before) in before.into_iter().enumerate() {
            let now = self.kept(number);
            self.all[number].entered += now - before;
        }
        Ok(())
    }
}
