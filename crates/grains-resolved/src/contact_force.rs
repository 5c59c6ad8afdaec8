//! The part of the force on the fluid that contacts need: fluid inside a body goes along with it.
//!
//! Contacts may be faster than a step of the fluid. Their part of f is known before it, and is not taken from the last step as the rest
//! is; taken from there, packed bodies are shaken without end:
//!
//! ```text
//!  f = g + ρ/Δt (ΔU_c + Δω_c × r),   (ΔU_c, Δω_c) = M⁻¹ K_c
//! ```
//!
//! with g what is kept from step to step, as f is found less that part, K_c the impulse of the contacts in the step, and M the inertia
//! of the body.

use crate::body::component_at;
use crate::node::prefetch_at;
use crate::{BodyMotion, Method, Resolved};
use grains_domain::Transport;
use grains_fluid::Flow;

impl Resolved {
    /// Adds to the explicit force what contacts need in the step `dt` (s) of the fluid that follows; collective.
    pub fn add_contact_force(
        &mut self,
        motions: &[BodyMotion],
        flow: &mut Flow,
        dt: f64,
        transport: &dyn Transport,
    ) {
        let mut changes = vec![[0.0; 6]; self.bodies.len()];
        for (change, motion) in changes.iter_mut().zip(motions) {
            if motion.contacts != [0.0; 6] {
                *change = motion.change_by_contacts().into();
            }
        }
        self.ghosts.scatter(&mut changes, &self.subgrid, transport);
        self.changes_by_contacts = changes;
        self.apply_contact_force(flow, 1.0 / dt);
        // All explicit forces are taken back before multipliers are solved for.
        if let Method::Multiplier(_) = self.forcing.method {
            for (forced, nodes) in self.forced.iter_mut().zip(&self.nodes.of) {
                forced.extend(nodes.iter().filter(|node| node.is_deep()).map(|node| node.place as usize));
            }
        }
    }

    /// What contacts change a body's velocities by in the step, if they do.
    pub(crate) fn change_by_contacts(&self, body: u32) -> Option<&[f64; 6]> {
        self.changes_by_contacts.get(body as usize).filter(|change| **change != [0.0; 6])
    }

    /// Adds a multiple (1/s) of ρ (ΔU_c + Δω_c × r) to the force at velocities that bodies hold: all that are set directly, those deep
    /// inside beside multipliers.
    pub(crate) fn apply_contact_force(&self, flow: &mut Flow, factor: f64) {
        let factor = factor * flow.setup.density;
        let all = matches!(self.forcing.method, Method::Direct { .. });
        let Some(immersed) = &mut flow.immersed else { return };
        for component in (0..3).filter(|&c| self.subgrid.active[c]) {
            let force = immersed.force.component_mut(component);
            let nodes = &self.nodes.of[component];
            let mut arms = self.nodes.arms(component, &self.bodies, &self.subgrid);
            let mut first = 0;
            for group in nodes.chunk_by(|n, m| n.body == m.body) {
                let numbers = first..first + group.len();
                first = numbers.end;
                let Some(change) = self.change_by_contacts(group[0].body) else { continue };
                for (node, number) in group.iter().zip(numbers).filter(|(node, _)| all || node.is_deep()) {
                    prefetch_at(nodes, number, [force]);
                    force[node.place as usize] +=
                        factor * component_at(change, component, &arms.to(number, node));
                }
            }
        }
    }
}
