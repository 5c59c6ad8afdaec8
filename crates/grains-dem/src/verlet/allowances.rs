//! How far each particle may move before the lists are rebuilt.

use super::list_context::ListContext;
use super::lists::VerletLists;
use super::skin::Reference;
use crate::particles::{Body, Particles};

impl VerletLists {
    /// Allowance of every owned particle (m), from its speed and the faces it must not cross unseen.
    pub(crate) fn choose_allowances(&mut self, particles: &Particles, context: &ListContext) {
        let global = &context.decomposition.global;
        self.references.clear();
        self.reference_orientations.clear();
        for i in 0..particles.owned {
            let body = &particles.bodies[i];
            let mut allowance = nominal_allowance(body, context);
            for a in (0..3).filter(|&a| !global.periodic[a]) {
                // The lists are rebuilt in the very step in which a particle crosses a face.
                allowance =
                    allowance.min(body.position[a] - global.lower[a]).min(global.upper[a] - body.position[a]);
            }
            self.references.push(Reference { position: body.position, allowance });
        }
        self.reference_orientations.extend(particles.orientations.iter().take(particles.owned));
    }

    /// Distance (m) from the centre within which owned particle `i` may act before the lists are rebuilt.
    pub(crate) fn range_of(&self, particles: &Particles, i: usize, gap: f64) -> f64 {
        particles.bodies[i].radius + self.references[i].allowance + 0.5 * gap
    }
}

/// Allowance of a clone (m): that of its owner, and beyond the border that images slide along how far they may.
pub(super) fn clone_allowance(clone: &Body, context: &ListContext) -> f64 {
    match context.images.filter(|images| images.side(&clone.position) != 0.0) {
        Some(images) => {
            let owner = Body { velocity: images.own_velocity(clone), ..*clone };
            nominal_allowance(&owner, context) + context.slide
        }
        None => nominal_allowance(clone, context),
    }
}

/// Allowance of a body (m) by its size and speed: owner and clone agree on it, bit for bit.
pub(super) fn nominal_allowance(body: &Body, context: &ListContext) -> f64 {
    let ListContext { catalogue, skin, dt, .. } = context;
    let mut speed = body.velocity.norm();
    if !catalogue.shape(body.kind).is_sphere() {
        speed += body.radius * body.angular_velocity.norm();
    }
    (speed * skin.horizon * dt).clamp(skin.min * body.radius, skin.max * body.radius)
}
