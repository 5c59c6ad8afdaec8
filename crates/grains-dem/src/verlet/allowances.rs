//! How far each particle may move before the lists are rebuilt.

use super::list_context::Surroundings;
use super::lists::Neighbours;
use super::skin::Reference;
use crate::particles::{Body, Particles};

impl Neighbours {
    /// Reach of every owned particle (m), from its speed and the faces it must not cross unseen.
    pub(crate) fn choose_reaches(&mut self, particles: &Particles, around: &Surroundings) {
        let global = &around.decomposition.global;
        self.references.clear();
        self.reference_orientations.clear();
        for i in 0..particles.owned {
            let body = &particles.bodies[i];
            let mut reach = nominal_reach(body, around);
            for a in (0..3).filter(|&a| !global.periodic[a]) {
                // The lists are rebuilt in the very step in which a particle crosses a face.
                reach = reach.min(body.position[a] - global.lower[a]).min(global.upper[a] - body.position[a]);
            }
            self.references.push(Reference { position: body.position, reach });
        }
        self.reference_orientations.extend(particles.orientations.iter().take(particles.owned));
    }

    /// Distance (m) from the centre within which owned particle `i` may act before the lists are rebuilt.
    pub(crate) fn range_of(&self, particles: &Particles, i: usize, film: f64) -> f64 {
        particles.bodies[i].radius + self.references[i].reach + 0.5 * film
    }
}

/// Reach of a body (m) by its size and speed: owner and clone agree on it, bit for bit.
pub(super) fn nominal_reach(body: &Body, around: &Surroundings) -> f64 {
    let Surroundings { catalogue, skin, dt, .. } = around;
    let mut speed = body.velocity.norm();
    if !catalogue.shape(body.kind).is_sphere() {
        speed += body.radius * body.angular_velocity.norm();
    }
    (speed * skin.horizon * dt).clamp(skin.least * body.radius, skin.most * body.radius)
}
