//! Contact history saved from the pairs, row by row.

use super::lists::VerletLists;
use crate::contact_history::{PartHistory, SavedHistories, SphereHistory, WallHistory};
use crate::contacts::SpherePair;
use crate::non_spherical::PartPair;
use crate::particles::Particles;
use crate::periodic_images as images;
use crate::walls::{Wall, WallPair};
use grains_domain::GlobalBox;
use grains_geometry::Vec3;

impl VerletLists {
    /// Saves the contact history of all pairs in rows by owned particle.
    pub(crate) fn save_history(
        &self,
        particles: &Particles,
        walls: &[Wall],
        global: &GlobalBox,
        histories: &mut SavedHistories,
    ) {
        histories.fill(
            particles.owned,
            |add| self.save_spheres(particles, add),
            |add| self.save_parts(particles, add),
            |add| self.save_walls(particles, walls, global, add),
        );
    }

    fn save_spheres(&self, particles: &Particles, add: &mut dyn FnMut(u32, SphereHistory)) {
        let (ids, owned) = (&particles.ids, particles.owned as u32);
        for &SpherePair { a, b, tangential_displacement } in &self.spheres {
            if tangential_displacement == Vec3::zeros() {
                continue;
            }
            add(a, SphereHistory { partner: ids[b as usize], tangential_displacement });
            if b < owned {
                let tangential_displacement = -tangential_displacement;
                add(b, SphereHistory { partner: ids[a as usize], tangential_displacement });
            }
        }
    }

    fn save_parts(&self, particles: &Particles, add: &mut dyn FnMut(u32, PartHistory)) {
        for (&PartPair { a, b, parts, .. }, contact) in self.part_pairs.with_history() {
            for (own, other) in [(a, b), (b, a)] {
                if (own as usize) < particles.owned {
                    let partner = particles.ids[other as usize];
                    add(own, PartHistory { partner, parts, contact: *contact });
                }
            }
        }
    }

    fn save_walls(
        &self,
        particles: &Particles,
        walls: &[Wall],
        global: &GlobalBox,
        add: &mut dyn FnMut(u32, WallHistory),
    ) {
        for pair in &self.walls.pairs {
            let &WallPair { wall, surface, part, element, .. } = pair;
            let contact = self.walls.history_of(pair);
            if contact.is_empty() {
                continue;
            }
            let of = &walls[wall as usize];
            let wrapped = of.wrapped_axes(&of.surfaces[surface as usize]);
            let position = &particles.bodies[pair.particle as usize].position;
            if let Some(image) = images::seen_from_wrapped(pair.image, position, global, wrapped) {
                add(pair.particle, WallHistory { wall, surface, part, element, image, contact });
            }
        }
    }
}
