//! Direct forcing: the bodies' velocities from the balance of their momentum, the fluid's from them.

use crate::balance::unit_row;
use crate::nodes::Node;
use crate::subgrid::Stencil;
use crate::{Action, BodyMotion, Resolved, RigidBody};
use grains_domain::Transport;
use grains_fluid::Flow;
use grains_geometry::Vec3;
use nalgebra::{Matrix6, Vector6};

impl Resolved {
    /// Gives free bodies their new velocities, and the fluid inside all bodies what follows from them; collective.
    pub(crate) fn set_velocities(
        &mut self,
        motions: Option<&[BodyMotion]>,
        flow: &mut Flow,
        dt: f64,
        transport: &dyn Transport,
    ) -> Vec<Action> {
        if let Some(motions) = motions {
            self.release(flow, dt);
            flow.refresh_velocity(transport);
            self.move_bodies(motions, flow, dt, transport);
        }
        let mut actions = vec![[0.0; 12]; self.bodies.len()];
        let (density, volume) = (flow.setup.density, self.subgrid.cell_volume());
        let strides = self.subgrid.layout.strides();
        let mut excess = [0.0; 3];
        if let Some(immersed) = &mut flow.immersed {
            for component in (0..3).filter(|&c| self.subgrid.active[c]) {
                let velocity = flow.state.velocity.component_mut(component);
                let force = immersed.force.component_mut(component);
                let nodes = &self.nodes.of[component];
                // All are found before any is set: extrapolations may read each other's places.
                let wanted: Vec<f64> = nodes
                    .iter()
                    .map(|node| {
                        let body = &self.bodies[node.body as usize];
                        node.wanted(body, component, velocity, strides)
                    })
                    .collect();
                for (node, wanted) in nodes.iter().zip(wanted) {
                    let place = node.place;
                    let whole = force[place] + density / dt * (wanted - velocity[place]);
                    force[place] = self.forcing.explicit * whole;
                    velocity[place] = wanted;
                    let beyond = wanted - self.bodies[node.body as usize].velocity_at(&node.arm)[component];
                    excess[component] += beyond;
                    let action = &mut actions[node.body as usize];
                    let row = unit_row(&node.arm, component) * volume;
                    for a in 0..6 {
                        action[a] += row[a] * whole;
                        action[6 + a] += row[a] * density * beyond;
                    }
                }
                self.forced[component].clear();
                self.forced[component].extend(nodes.iter().map(|node| node.place));
            }
            transport.sum(&mut excess);
            let whole = flow.setup.grid.volume();
            immersed.excess = excess.map(|e| e * volume / whole);
        }
        flow.refresh_velocity(transport);
        self.spread.gather(&mut actions, &self.subgrid, transport);
        actions.iter().take(self.owned).map(Action::read).collect()
    }

    /// Takes back the explicit force where no body is any more.
    fn release(&mut self, flow: &mut Flow, dt: f64) {
        let Some(immersed) = &mut flow.immersed else { return };
        let density = flow.setup.density;
        for component in 0..3 {
            let velocity = flow.state.velocity.component_mut(component);
            let force = immersed.force.component_mut(component);
            for &place in &self.forced[component] {
                if !self.nodes.holds(component, place) {
                    velocity[place] -= dt / density * force[place];
                    force[place] = 0.0;
                }
            }
        }
    }

    /// New velocities of the bodies from the balance of momentum of each and of the fluid that turns with it.
    ///
    /// (m − m_f + C m_f)(U − Uⁿ) + C m_f (Uⁿ⁻¹ − Uⁿ) = −J + E − Eⁿ + K
    ///
    /// with K the impulse of all but the flow, J that on the fluid, C the virtual mass, and E the momentum of the fluid
    /// inside beyond that of rigid motion, which jumps when nodes come and go; likewise for the angular momentum.
    fn move_bodies(&mut self, motions: &[BodyMotion], flow: &Flow, dt: f64, transport: &dyn Transport) {
        let Some(immersed) = &flow.immersed else { return };
        let (density, volume) = (flow.setup.density, self.subgrid.cell_volume());
        // Per body: the 6 x 6 response of the impulse to the velocities, and the impulse at rest.
        let mut sums = vec![[0.0; 42]; self.bodies.len()];
        for component in (0..3).filter(|&c| self.subgrid.active[c]) {
            let velocity = flow.state.velocity.component(component);
            let force = immersed.force.component(component);
            for node in &self.nodes.of[component] {
                let sum = &mut sums[node.body as usize];
                // Impulse on the fluid along e: V (f Δt + ρ (e·(U + ω × r) − u)).
                let row = unit_row(&node.arm, component);
                let mass = density * volume;
                let at_rest = volume * dt * force[node.place] - mass * velocity[node.place];
                for a in 0..6 {
                    for b in 0..6 {
                        sum[6 * a + b] += mass * row[a] * row[b];
                    }
                    sum[36 + a] += row[a] * at_rest;
                }
            }
        }
        self.spread.gather(&mut sums, &self.subgrid, transport);
        let mut values = vec![[0.0; 6]; self.bodies.len()];
        for ((value, sum), motion) in values.iter_mut().zip(&sums).zip(motions) {
            let (matrix, right) = motion.balance();
            let matrix = matrix + Matrix6::from_row_slice(&sum[..36]);
            let right = right - Vector6::from_column_slice(&sum[36..]);
            *value = motion.solved(matrix, right).into();
        }
        self.spread.scatter(&mut values, &self.subgrid, transport);
        for (body, value) in self.bodies.iter_mut().zip(&values) {
            body.velocity = Vec3::from_column_slice(&value[..3]);
            body.spin = Vec3::from_column_slice(&value[3..]);
        }
    }
}

impl Node {
    /// Share s of the body's velocity at an arm r_s, and the fluid's part g, of the velocity here: s e·(U + ω × r_s) + g.
    #[inline]
    fn terms(&self, velocity: &[f64], strides: [usize; 3]) -> (f64, Vec3, f64) {
        match &self.skin {
            None => (1.0, self.arm, 0.0),
            Some(skin) => {
                let of_point = |(weight, stencil): &(f64, Option<Stencil>)| {
                    stencil.as_ref().map_or(0.0, |s| weight * s.interpolate(velocity, strides))
                };
                (skin.surface, skin.foot, skin.fluid.iter().map(of_point).sum())
            }
        }
    }

    #[inline]
    fn wanted(&self, body: &RigidBody, component: usize, velocity: &[f64], strides: [usize; 3]) -> f64 {
        let (share, arm, fluid) = self.terms(velocity, strides);
        share * body.velocity_at(&arm)[component] + fluid
    }
}
