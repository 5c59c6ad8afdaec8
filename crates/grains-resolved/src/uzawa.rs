//! Distributed Lagrange multipliers: the constraint at points inside and on the surface of the bodies, by conjugate gradients
//! (Uzawa) on the multipliers (Wachs et al. 2009; Rakotonirina 2016, 7.3).
//!
//! With C the interpolation to the points of the surfaces, R the velocities of the bodies there and R_d those at nodes deep inside,
//! M the inertia of the bodies, V the volume of a cell, and the multipliers Λ (N) at the points:
//!
//! ```text
//!  u = û + Δt/(ρ V) Cᵀ Λ,   M X = b − Δt Rᵀ Λ − Δt R_dᵀ Λ_d,   C u = R X,   u = R_d X deep inside
//! ```
//!
//! Each multiplier Λ_d acts on its own node alone. They are eliminated: deep inside the fluid turns with the bodies, whose inertia
//! it adds to, and which get what surfaces do to it there,
//!
//! ```text
//!  (M + ρ V R_dᵀ R_d) X = b + ρ V R_dᵀ û − Δt (Rᵀ − R_dᵀ Cᵀ) Λ
//! ```
//!
//! What remains are those on the surfaces, a few per body: symmetric and positive, solved with the sizes of the rows of C for a
//! preconditioner, from what the multipliers of the same points would be if they changed as in the last step.

use crate::balance::velocities;
use crate::body::{component_at, others};
use crate::multiplier::{MultiplierMethod, Multipliers, REACH};
use crate::node::Node;
use crate::{Action, BodyMotion, ConstraintError, Resolved};
use grains_domain::Transport;
use grains_fluid::Flow;
use grains_geometry::Vec3;
use nalgebra::{Matrix6, Vector6};

/// What turns the loads on the fluid into changes of the bodies' velocities.
struct Recoil<'a> {
    motions: &'a [BodyMotion],
    /// Inertia of the own bodies with the fluid deep inside.
    inertia: Vec<Matrix6<f64>>,
    dt: f64,
}

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
        let recoil = motions.map(|motions| {
            let inertia = self.move_bodies((motions, Node::is_deep), flow, dt, transport);
            Recoil { motions, inertia, dt }
        });
        let inside = self.impose_deep(flow, dt);
        flow.refresh_velocity(REACH, transport);
        let scale = dt / (flow.setup.density * self.subgrid.cell_volume());
        let Multipliers { constraints, overlaps, values, .. } = &mut self.multipliers;
        let mut values = std::mem::take(values);
        let inverse: Vec<f64> = overlaps.squares.iter().map(|square| 1.0 / square).collect();
        let count = inverse.len();
        let (mut residual, mut response) = (vec![0.0; count], vec![0.0; count]);
        let of_bodies: Vec<[f64; 6]> = self.bodies.iter().map(|body| velocities(body).into()).collect();
        constraints.set_residual(&of_bodies, &flow.state.velocity, &mut residual);
        let mut sums = [inside + square(&residual)];
        transport.sum(&mut sums);
        let enough = method.tolerance * method.tolerance * sums[0];
        // They go on as they went in the last step.
        let last = values.clone();
        values.iter_mut().zip(&self.multipliers.changes).for_each(|(value, change)| *value += change);
        if transport.any(values.iter().any(|v| *v != 0.0)) {
            self.respond(&values, &mut response, scale, recoil.as_ref(), transport);
            residual.iter_mut().zip(&response).for_each(|(r, s)| *r -= s);
        }
        let mut direction = vec![0.0; count];
        let (mut beta, mut iterations) = (0.0, 0);
        let weighed_square = residual.iter().zip(&inverse).map(|(r, d)| r * r * d).sum::<f64>();
        let mut sums = [square(&residual), weighed_square];
        transport.sum(&mut sums);
        let [mut squared, mut weighed] = sums;
        // A residual that is no number is never enough.
        while squared.is_nan() || squared > enough {
            if iterations == method.iterations || squared.is_nan() {
                let residual = (squared / enough).sqrt() * method.tolerance;
                return Err(ConstraintError::NotConverged { iterations, residual });
            }
            for k in 0..count {
                direction[k] = residual[k] * inverse[k] + beta * direction[k];
            }
            let mut curvature = [self.respond(&direction, &mut response, scale, recoil.as_ref(), transport)];
            transport.sum(&mut curvature);
            let step = weighed / curvature[0];
            let mut sums = [0.0; 2];
            for k in 0..count {
                values[k] += step * direction[k];
                residual[k] -= step * response[k];
                let square = residual[k] * residual[k];
                sums[0] += square;
                sums[1] += square * inverse[k];
            }
            transport.sum(&mut sums);
            beta = sums[1] / weighed;
            [squared, weighed] = sums;
            iterations += 1;
        }
        self.multipliers.iterations = iterations;
        let changes = &mut self.multipliers.changes;
        changes.clear();
        let change = |(now, last): (&f64, f64)| if last == 0.0 { 0.0 } else { now - last };
        changes.extend(values.iter().zip(last).map(change));
        let actions = self.apply(values, recoil.as_ref(), flow, dt, transport);
        flow.refresh_velocity(REACH, transport);
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

    /// Gives the fluid deep inside the velocities of the bodies, and notes the force that this takes; returns Σ (R_d X − u)² of the
    /// own nodes (m²/s²).
    fn impose_deep(&self, flow: &mut Flow, dt: f64) -> f64 {
        let density = flow.setup.density;
        let Some(immersed) = &mut flow.immersed else { return 0.0 };
        let mut sum = 0.0;
        for component in (0..3).filter(|&c| self.subgrid.active[c]) {
            let velocity = flow.state.velocity.component_mut(component);
            let force = immersed.force.component_mut(component);
            let mut arms = self.nodes.arms(component, &self.bodies, &self.subgrid);
            for (number, node) in self.nodes.of[component].iter().enumerate().filter(|(_, n)| n.is_deep()) {
                let place = node.place as usize;
                let arm = arms.to(number, node);
                let change = self.bodies[node.body as usize].component_at(component, &arm) - velocity[place];
                velocity[place] += change;
                force[place] += density / dt * change;
                sum += change * change;
            }
        }
        sum
    }

    /// Force and torque (N, N m) of the multipliers on surfaces on the fluid per body, less those of the field on the fluid deep inside
    /// it, and of the force there of `flow` if it is given; collective.
    fn loads(&self, values: &[f64], forces: Option<&Flow>, transport: &dyn Transport) -> Vec<[f64; 6]> {
        let mut loads = vec![[0.0; 6]; self.bodies.len()];
        let Multipliers { constraints, field, shared, .. } = &self.multipliers;
        constraints.add_loads(values, &mut loads);
        for component in (0..3).filter(|&c| self.subgrid.active[c]) {
            let nodes = &self.nodes.of[component];
            let mut arms = self.nodes.arms(component, &self.bodies, &self.subgrid);
            let [b, c] = others(component);
            let mut add = |number: usize, value: f64| {
                let arm = arms.to(number, &nodes[number]);
                let load = &mut loads[nodes[number].body as usize];
                load[component] += value;
                load[3 + b] += arm[c] * value;
                load[3 + c] -= arm[b] * value;
            };
            let field = field.component(component);
            for &number in &shared.deep[component] {
                add(number as usize, -field[nodes[number as usize].place as usize]);
            }
            if let Some(immersed) = forces.and_then(|flow| flow.immersed.as_ref()) {
                let (force, volume) = (immersed.force.component(component), self.subgrid.cell_volume());
                for (number, node) in nodes.iter().enumerate().filter(|(_, node)| node.is_deep()) {
                    add(number, volume * force[node.place as usize]);
                }
            }
        }
        self.ghosts.gather(&mut loads, &self.subgrid, transport);
        loads
    }

    /// (Δt/(ρ V) C Cᵀ + …) Λ, and its product with Λ on this rank; collective.
    fn respond(
        &mut self,
        values: &[f64],
        response: &mut [f64],
        scale: f64,
        recoil: Option<&Recoil>,
        transport: &dyn Transport,
    ) -> f64 {
        self.multipliers.spread_shared(values, transport);
        let changes = recoil.map(|recoil| self.changes(values, recoil, transport));
        // Deep inside the fluid goes with the bodies.
        for component in (0..3).filter(|&c| self.subgrid.active[c]) {
            let nodes = &self.nodes.of[component];
            let mut arms = self.nodes.arms(component, &self.bodies, &self.subgrid);
            let field = self.multipliers.field.component_mut(component);
            for &number in &self.multipliers.shared.deep[component] {
                let node = &nodes[number as usize];
                let change = changes.as_ref().map_or(0.0, |changes| {
                    component_at(&changes[node.body as usize], component, &arms.to(number as usize, node))
                });
                field[node.place as usize] = change / scale;
            }
        }
        self.multipliers.fill(transport);
        let Multipliers { constraints, overlaps, field, .. } = &self.multipliers;
        constraints.respond(values, overlaps, (scale, field), changes.as_deref(), response)
    }

    /// Changes of the velocities of all bodies by multipliers that have been spread; collective.
    fn changes(&self, values: &[f64], recoil: &Recoil, transport: &dyn Transport) -> Vec<[f64; 6]> {
        let mut changes = self.loads(values, None, transport);
        for ((change, motion), inertia) in changes.iter_mut().zip(recoil.motions).zip(&recoil.inertia) {
            *change = motion.change(*inertia, Vector6::from_column_slice(change) * -recoil.dt).into();
        }
        self.ghosts.scatter(&mut changes, &self.subgrid, transport);
        changes
    }

    /// Applies the multipliers to fluid and bodies, and keeps them; collective.
    fn apply(
        &mut self,
        values: Vec<f64>,
        recoil: Option<&Recoil>,
        flow: &mut Flow,
        dt: f64,
        transport: &dyn Transport,
    ) -> Vec<Action> {
        self.multipliers.spread_all(&values, transport);
        if let Some(recoil) = recoil {
            let changes = self.changes(&values, recoil, transport);
            for (body, change) in self.bodies.iter_mut().zip(&changes) {
                body.velocity += Vec3::from_column_slice(&change[..3]);
                body.spin += Vec3::from_column_slice(&change[3..]);
            }
        }
        self.impose_deep(flow, dt);
        let (density, volume) = (flow.setup.density, self.subgrid.cell_volume());
        for component in (0..3).filter(|&c| self.subgrid.active[c]) {
            let nodes = &self.nodes.of[component];
            let field = self.multipliers.field.component(component);
            let velocity = flow.state.velocity.component_mut(component);
            let Some(immersed) = &mut flow.immersed else { continue };
            let force = immersed.force.component_mut(component);
            let forced = &mut self.forced[component];
            forced.clear();
            forced.extend(nodes.iter().filter(|node| node.is_deep()).map(|node| node.place as usize));
            let [columns, lines, layers] = self.subgrid.unknowns(component);
            let lines = (0..layers).flat_map(|k| (0..lines).map(move |j| (j, k)));
            for first in lines.map(|(j, k)| self.subgrid.layout.row(j, k)) {
                for place in first..first + columns {
                    if field[place] == 0.0 || self.nodes.is_deep(component, place) {
                        continue;
                    }
                    let f = field[place] / volume;
                    velocity[place] += dt / density * f;
                    force[place] = f;
                    forced.push(place);
                }
            }
        }
        let loads = self.loads(&values, Some(flow), transport);
        self.multipliers.field.fill(0.0);
        self.multipliers.values = values;
        if let Some(immersed) = &mut flow.immersed {
            for component in (0..3).filter(|&c| self.subgrid.active[c]) {
                let force = immersed.force.component_mut(component);
                self.forced[component].iter().for_each(|&place| force[place] *= self.forcing.explicit);
            }
        }
        self.apply_contact_force(flow, -self.forcing.explicit / dt);
        let action = |load: &[f64; 6]| {
            let mut sums = [0.0; 12];
            sums[..6].copy_from_slice(load);
            Action::read(&sums)
        };
        loads[..self.owned].iter().map(action).collect()
    }
}

fn square(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum()
}
