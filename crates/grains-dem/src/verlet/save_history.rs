//! Contact history saved from the pairs, row by row.

use super::lists::Neighbours;
use crate::contact_history::{BodyMemory, ContactMemory, Memories, SphereMemory, WallMemory};
use crate::non_spherical::BodyPair;
use crate::particles::Particles;
use crate::periodic_images as images;
use crate::walls::{Wall, WallPair};
use grains_domain::GlobalBox;
use grains_geometry::Vec3;

impl Neighbours {
    /// Gathers what all pairs remember into rows by owned particle.
    pub(crate) fn remember(
        &self,
        particles: &Particles,
        walls: &[Wall],
        global: &GlobalBox,
        memories: &mut Memories,
    ) {
        let owned = particles.owned as u32;
        let ids = &particles.ids;
        memories.fill(
            particles.owned,
            |add| {
                for pair in self.spheres.iter().filter(|p| p.spring != Vec3::zeros()) {
                    add(pair.a, SphereMemory { partner: ids[pair.b as usize], spring: pair.spring });
                    if pair.b < owned {
                        add(pair.b, SphereMemory { partner: ids[pair.a as usize], spring: -pair.spring });
                    }
                }
            },
            |add| {
                for (&BodyPair { a, b, parts, .. }, contact) in self.bodies.remembered() {
                    for (own, other) in [(a, b), (b, a)] {
                        if own < owned {
                            add(own, BodyMemory { partner: ids[other as usize], parts, contact: *contact });
                        }
                    }
                }
            },
            |add| {
                for pair in &self.walls.pairs {
                    let &WallPair { wall, surface, part, element, spring, twist, .. } = pair;
                    let simplex = self.walls.simplexes.get(pair.simplex as usize).copied();
                    let contact = ContactMemory { spring, twist, simplex: simplex.unwrap_or_default() };
                    if contact.is_empty() {
                        continue;
                    }
                    let wrapped =
                        walls[wall as usize].wrapped_axes(&walls[wall as usize].surfaces[surface as usize]);
                    let position = &particles.bodies[pair.particle as usize].position;
                    if let Some(image) = images::seen_from_wrapped(pair.image, position, global, wrapped) {
                        add(pair.particle, WallMemory { wall, surface, part, element, image, contact });
                    }
                }
            },
        );
    }
}
