//! The first part of a step: increments of the velocities by all terms of the momentum equation.

use crate::flow::{Flow, March};
use crate::mixture::StepInputs;
use crate::momentum::{
    Diffusion, Explicit, FaceTerms, OutletTerms, RowPlace, StressWeights, advance_outlets,
};
use crate::projection::ForceRow;
use crate::scalar::add_buoyancy;
use multiversion::multiversion;

impl Flow {
    /// Adams–Bashforth weights of the new and the old explicit terms; in pseudo-time those of Euler.
    fn weights(&self, dt: f64) -> [f64; 2] {
        let has_last = self.state.last_dt > 0.0 && self.march == March::Time;
        let ratio = if has_last { dt / self.state.last_dt } else { 0.0 };
        [1.0 + 0.5 * ratio, -0.5 * ratio]
    }

    /// Right-hand sides of the momentum increments of all rows, and the increments of outlets.
    pub(crate) fn predict(&mut self, dt: f64) {
        let weights = self.weights(dt);
        let [mut advective, mut viscous] = std::mem::take(&mut self.rows);
        let [_, _, nz] = self.local.layout.cells;
        for k in 0..nz {
            for component in 0..3 {
                let n = self.local.unknowns(component);
                if k >= n[2] {
                    continue;
                }
                for j in 0..n[1] {
                    let place = RowPlace { component, j, k };
                    self.explicit_terms().row(place, &mut advective[..n[0]], &mut viscous[..n[0]]);
                    set_increments(self, place, [&mut advective[..n[0]], &mut viscous[..n[0]]], weights, dt);
                }
            }
        }
        self.rows = [advective, viscous];
        self.predict_outlets(weights, dt);
    }

    pub(crate) fn explicit_terms(&self) -> Explicit<'_> {
        let velocity = self.state.velocity.components();
        Explicit {
            local: &self.local,
            velocity,
            flux: self.mixture.as_ref().map_or(velocity, |m| m.flux.components()),
            viscosity: self.weighed_viscosity(),
            weights: self.stress_weights(),
            is_full: self.viscosity.is_some(),
            advection: self.setup.advection,
        }
    }

    /// Sets the viscosity to that of the present velocity, where it varies.
    pub(crate) fn set_viscosity(&mut self) {
        let Some(viscosity) = &mut self.viscosity else { return };
        viscosity.update(&self.local, &self.boundary_data, self.state.velocity.components());
        if let Some(mixture) = &self.mixture {
            viscosity.weigh(mixture.porosity());
        }
        if let Some(immersed) = &self.immersed {
            viscosity.thin(&immersed.solid, self.setup.viscosity / self.setup.density);
        }
    }

    /// What the stresses are weighed with: the void fraction, and a viscosity that varies.
    fn stress_weights(&self) -> Option<StressWeights<'_>> {
        match &self.viscosity {
            Some(viscosity) => Some(viscosity.weights()),
            None => self.mixture.as_ref().map(|mixture| mixture.porosity()),
        }
    }

    /// Kinematic viscosity (m²/s) that the weights multiply: 1 where they hold it.
    pub(crate) fn weighed_viscosity(&self) -> f64 {
        if self.viscosity.is_some() { 1.0 } else { self.setup.viscosity / self.setup.density }
    }

    fn predict_outlets(&mut self, weights: [f64; 2], dt: f64) {
        let velocity = self.state.velocity.components();
        let (density, mixture) = (self.setup.density, self.mixture.as_ref());
        let of_bodies = |component: usize, p: usize| {
            self.immersed.as_ref().map_or(0.0, |bodies| bodies.force.component(component)[p] / density)
        };
        let pure = |component, p| FaceTerms {
            void_fraction: 1.0,
            gradient: 1.0,
            diagonal: 1.0 / dt,
            source: of_bodies(component, p),
            friction: 0.0,
        };
        let terms = OutletTerms {
            local: &self.local,
            velocity,
            flux: mixture.map_or(velocity, |m| m.flux.components()),
            pressure: self.state.pressure.data(),
            inverse_density: 1.0 / density,
            viscosity: self.weighed_viscosity(),
            stress_weights: self.viscosity.as_ref().map(|viscosity| viscosity.weights()),
            face: &|component, p| {
                let terms = match mixture {
                    Some(mixture) => mixture.face_terms(component, p, density, dt),
                    None => pure(component, p),
                };
                let buoyancy = self.scalars.as_ref().map_or(0.0, |scalars| {
                    let cell =
                        p / self.local.layout.strides()[component] % self.local.layout.dims()[component];
                    let cell = cell as isize - self.local.layout.halo as isize;
                    scalars.acceleration(&self.local, component, p, cell)
                });
                FaceTerms { source: terms.source + terms.void_fraction * buoyancy, ..terms }
            },
            weights,
        };
        let mut increments = self.increments.components_mut();
        let mut advective = self.state.advective.components_mut();
        advance_outlets(&self.boundary_data, &terms, &mut increments, &mut advective);
    }
}

/// Increment of a row before implicit diffusion: the sum of all terms over the momentum diagonal m.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn set_increments(
    flow: &mut Flow,
    place: RowPlace,
    [explicit, viscous]: [&mut [f64]; 2],
    [new, old]: [f64; 2],
    dt: f64,
) {
    let (component, n) = (place.component, explicit.len());
    let (layout, density) = (flow.local.layout, flow.setup.density);
    let start = layout.row(place.j, place.k);
    if flow.setup.diffusion == Diffusion::Explicit {
        explicit.iter_mut().zip(&*viscous).for_each(|(e, v)| *e -= v);
        viscous.fill(0.0);
    }
    let pressure = flow.state.pressure.data();
    let (here, next) = (&pressure[start..][..n], &pressure[start + layout.strides()[component]..][..n]);
    let out = &mut flow.increments.component_mut(component)[start..][..n];
    if flow.march == March::PseudoTime {
        viscous.iter_mut().zip(&*explicit).for_each(|(viscous, explicit)| *viscous -= new * explicit);
    } else {
        let kept = &mut flow.state.advective.component_mut(component)[start..][..n];
        for ((viscous, explicit), kept) in viscous.iter_mut().zip(&*explicit).zip(kept) {
            *viscous -= new * explicit + old * *kept;
            *kept = *explicit;
        }
    }
    let e = flow.local.entry([0, place.j, place.k][component]);
    let distances = &flow.local.axes[component].inverse_distance[e..];
    let force = ForceRow {
        pressures: [here, next],
        distances: &distances[..if component == 0 { n } else { 1 }],
        drive: flow.state.force[component],
    };
    match &flow.mixture {
        None => {
            out.iter_mut().zip(viscous).for_each(|(out, sum)| *out = dt * *sum);
            force.add(out, |_| dt / density);
            add_buoyancy(flow.scalars.as_ref(), &flow.local, place, out, |_| dt);
            if let Some(immersed) = &flow.immersed {
                let force = &immersed.force.component(component)[start..][..n];
                out.iter_mut().zip(force).for_each(|(out, f)| *out += dt / density * f);
            }
        }
        Some(mixture) => {
            let inputs = StepInputs {
                velocity: &flow.state.velocity,
                density,
                viscosity: flow.setup.viscosity,
                dt,
                step: flow.state.step,
            };
            mixture.increments(component, start, inputs, viscous, out);
            let gradient_factor = &mixture.gradient_factor.component(component)[start..][..n];
            force.add(out, |i| gradient_factor[i]);
            let [eps, inverse] =
                [&mixture.faces, &mixture.inverse].map(|faces| &faces.component(component)[start..][..n]);
            add_buoyancy(flow.scalars.as_ref(), &flow.local, place, out, |i| eps[i] * inverse[i]);
        }
    }
}
