//! Distributed Lagrange multipliers: the constraint at points inside and on the surface of the bodies, by conjugate gradients
//! (Uzawa) on the multipliers (Wachs et al. 2009; Rakotonirina 2016, 7.3).
//!
//! With C the interpolation to the points, R the velocities of the bodies there, M their inertia, V the volume of a cell,
//! and the multipliers Λ (N) at the points:
//!
//! ```text
//!  u = û + Δt/(ρ V) Cᵀ Λ,   M X = b − Δt Rᵀ Λ,   C u = R X      →      (Δt/(ρ V) C Cᵀ + Δt R M⁻¹ Rᵀ) Λ = R M⁻¹ b − C û
//! ```

use crate::balance::unit_row;
use crate::multiplier::{MultiplierMethod, Multipliers};
use crate::{Action, BodyMotion, ConstraintError, Resolved};
use grains_domain::Transport;
use grains_fluid::Flow;
use grains_geometry::Vec3;
use nalgebra::Vector6;

impl Resolved {
    /// Solves for the multipliers, and applies them to fluid and bodies; collective.
    pub(crate) fn solve_multipliers(
        &mut self,
        method: &MultiplierMethod,
        motions: Option<&[BodyMotion]>,
        flow: &mut Flow,
        dt: f64,
        transport: &dyn Transport,
    ) -> Result<Vec<Action>, ConstraintError> {
        self.take_back(flow, dt);
        flow.refresh_velocity(flow.setup.halo, transport);
        let inverse_diagonal = dt / (flow.setup.density * self.subgrid.cell_volume());
        self.velocities_without_flow(motions, transport);
        let count = self.multipliers.constraints.rows.len();
        let mut residual = vec![0.0; count];
        self.multipliers.constraints.interpolate(flow.state.velocity.components(), &mut residual);
        for (value, row) in residual.iter_mut().zip(&self.multipliers.constraints.rows) {
            let body = &self.bodies[row.body as usize];
            *value = body.velocity_at(&row.arm)[row.component as usize] - *value;
        }
        let wanted = sum_of_squares(&residual, transport);
        let mut values = std::mem::take(&mut self.multipliers.values);
        values.resize(count, 0.0);
        let mut response = vec![0.0; count];
        if transport.any(values.iter().any(|v| *v != 0.0)) {
            self.respond(&values, &mut response, inverse_diagonal, dt, motions, transport);
            residual.iter_mut().zip(&response).for_each(|(r, s)| *r -= s);
        }
        let mut direction = residual.clone();
        let mut squared = sum_of_squares(&residual, transport);
        let enough = method.tolerance * method.tolerance * wanted;
        let mut iterations = 0;
        // A residual that is no number is never enough.
        while squared.is_nan() || squared > enough {
            if iterations == method.iterations || squared.is_nan() {
                return Err(ConstraintError::NotConverged {
                    iterations,
                    residual: (squared / wanted).sqrt(),
                });
            }
            self.respond(&direction, &mut response, inverse_diagonal, dt, motions, transport);
            let mut curvature = [direction.iter().zip(&response).map(|(d, s)| d * s).sum::<f64>()];
            transport.sum(&mut curvature);
            let step = squared / curvature[0];
            for k in 0..count {
                values[k] += step * direction[k];
                residual[k] -= step * response[k];
            }
            let next = sum_of_squares(&residual, transport);
            let beta = next / squared;
            direction.iter_mut().zip(&residual).for_each(|(d, r)| *d = r + beta * *d);
            squared = next;
            iterations += 1;
        }
        self.multipliers.iterations = iterations;
        let actions = self.apply(values, motions, flow, dt, transport);
        flow.refresh_velocity(flow.setup.halo, transport);
        Ok(actions)
    }

    /// Takes the explicit force back from the velocities.
    fn take_back(&mut self, flow: &mut Flow, dt: f64) {
        let Some(immersed) = &mut flow.immersed else { return };
        for component in 0..3 {
            let velocity = flow.state.velocity.component_mut(component);
            let force = immersed.force.component_mut(component);
            for &place in &self.forced[component] {
                velocity[place] -= dt / flow.setup.density * force[place];
                force[place] = 0.0;
            }
        }
    }

    /// Gives free bodies the velocities they would have without the flow; collective.
    fn velocities_without_flow(&mut self, motions: Option<&[BodyMotion]>, transport: &dyn Transport) {
        let Some(motions) = motions else { return };
        let mut values = vec![[0.0; 6]; self.bodies.len()];
        for (value, motion) in values.iter_mut().zip(motions) {
            let (matrix, right) = motion.balance();
            *value = motion.solved(matrix, right).into();
        }
        self.ghosts.scatter(&mut values, &self.subgrid, transport);
        for (body, value) in self.bodies.iter_mut().zip(&values) {
            body.velocity = Vec3::from_column_slice(&value[..3]);
            body.spin = Vec3::from_column_slice(&value[3..]);
        }
    }

    /// Force and torque of multipliers on the fluid per body, ghosts included; collective.
    fn loads(&self, values: &[f64], transport: &dyn Transport) -> Vec<[f64; 6]> {
        let mut loads = vec![[0.0; 6]; self.bodies.len()];
        for (row, value) in self.multipliers.constraints.rows.iter().zip(values) {
            let along = unit_row(&row.arm, row.component as usize);
            let load = &mut loads[row.body as usize];
            (0..6).for_each(|a| load[a] += along[a] * value);
        }
        self.ghosts.gather(&mut loads, &self.subgrid, transport);
        loads
    }

    /// Change of the bodies' velocities by loads of theirs on the fluid; collective.
    fn recoil(
        &self,
        loads: &[[f64; 6]],
        dt: f64,
        motions: &[BodyMotion],
        transport: &dyn Transport,
    ) -> Vec<[f64; 6]> {
        let mut values = vec![[0.0; 6]; self.bodies.len()];
        for ((value, load), motion) in values.iter_mut().zip(loads).zip(motions) {
            *value = motion.change(motion.balance().0, Vector6::from_column_slice(load) * -dt).into();
        }
        self.ghosts.scatter(&mut values, &self.subgrid, transport);
        values
    }

    /// (Δt/(ρ V) C Cᵀ + Δt R M⁻¹ Rᵀ) Λ; collective.
    fn respond(
        &mut self,
        values: &[f64],
        response: &mut [f64],
        inverse_diagonal: f64,
        dt: f64,
        motions: Option<&[BodyMotion]>,
        transport: &dyn Transport,
    ) {
        self.multipliers.spread(values, transport);
        let Multipliers { constraints, field, .. } = &self.multipliers;
        constraints.interpolate(field.components(), response);
        response.iter_mut().for_each(|r| *r *= inverse_diagonal);
        let Some(motions) = motions else { return };
        let recoil = self.recoil(&self.loads(values, transport), dt, motions, transport);
        for (r, row) in response.iter_mut().zip(&constraints.rows) {
            let change = Vector6::from_column_slice(&recoil[row.body as usize]);
            *r -= unit_row(&row.arm, row.component as usize).dot(&change);
        }
    }

    /// Applies the multipliers to fluid and bodies, and keeps them; collective.
    fn apply(
        &mut self,
        values: Vec<f64>,
        motions: Option<&[BodyMotion]>,
        flow: &mut Flow,
        dt: f64,
        transport: &dyn Transport,
    ) -> Vec<Action> {
        self.multipliers.spread(&values, transport);
        let loads = self.loads(&values, transport);
        if let Some(motions) = motions {
            let recoil = self.recoil(&loads, dt, motions, transport);
            for (body, change) in self.bodies.iter_mut().zip(&recoil) {
                body.velocity += Vec3::from_column_slice(&change[..3]);
                body.spin += Vec3::from_column_slice(&change[3..]);
            }
        }
        self.multipliers.values = values;
        let (layout, volume) = (self.subgrid.layout, self.subgrid.cell_volume());
        let density = flow.setup.density;
        if let Some(immersed) = &mut flow.immersed {
            for component in (0..3).filter(|&c| self.subgrid.active[c]) {
                let own = self.multipliers.field.component(component);
                let velocity = flow.state.velocity.component_mut(component);
                let force = immersed.force.component_mut(component);
                let forced = &mut self.forced[component];
                forced.clear();
                for row in layout.rows() {
                    for place in (row..row + layout.cells[0]).filter(|&place| own[place] != 0.0) {
                        let f = own[place] / volume;
                        velocity[place] += dt / density * f;
                        force[place] = self.forcing.explicit * f;
                        forced.push(place);
                    }
                }
            }
        }
        let action = |load: &[f64; 6]| {
            let mut sums = [0.0; 12];
            sums[..6].copy_from_slice(load);
            Action::read(&sums)
        };
        loads[..self.owned].iter().map(action).collect()
    }
}

fn sum_of_squares(values: &[f64], transport: &dyn Transport) -> f64 {
    let mut sum = [values.iter().map(|v| v * v).sum::<f64>()];
    transport.sum(&mut sum);
    sum[0]
}
