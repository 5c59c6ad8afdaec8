//! Contact history saved from the pairs, row by row.

use super::lists::VerletLists;
use crate::contact_history::{ContactHistory, PartHistory, SavedHistories, SphereHistory, WallHistory};
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
        let owned = particles.owned as u32;
        let ids = &particles.ids;
        histories.fill(
            particles.owned,
            |add| {
                for pair in self.spheres.iter().filter(|p| p.tangential_displacement != Vec3::zeros()) {
                    add(
                        pair.a,
                        SphereHistory {
                            partner: ids[pair.b as usize],
                            tangential_displacement: pair.tangential_displacement,
                        },
                    );
                    if pair.b < owned {
                        add(
                            pair.b,
                            SphereHistory {
                                partner: ids[pair.a as usize],
                                tangential_displacement: -pair.tangential_displacement,
                            },
                        );
                    }
                }
            },
            |add| {
                for (&PartPair { a, b, parts, .. }, contact) in self.part_pairs.with_history() {
                    for (own, other) in [(a, b), (b, a)] {
                        if own < owned {
                            add(own, PartHistory { partner: ids[other as usize], parts, contact: *contact });
                        }
                    }
                }
            },
            |add| {
                for pair in &self.walls.pairs {
                    let &WallPair {
                        wall,
                        surface,
                        part,
                        element,
                        tangential_displacement,
                        torsional_angle,
                        ..
                    } = pair;
                    let simplex = self.walls.simplexes.get(pair.simplex as usize).copied();
                    let contact = ContactHistory {
                        tangential_displacement,
                        torsional_angle,
                        simplex: simplex.unwrap_or_default(),
                    };
                    if contact.is_empty() {
                        continue;
                    }
                    let wrapped =
                        walls[wall as usize].wrapped_axes(&walls[wall as usize].surfaces[surface as usize]);
                    let position = &particles.bodies[pair.particle as usize].position;
                    if let Some(image) = images::seen_from_wrapped(pair.image, position, global, wrapped) {
                        add(pair.particle, WallHistory { wall, surface, part, element, image, contact });
                    }
                }
            },
        );
    }
}
