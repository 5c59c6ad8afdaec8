//! Contact history saved from the pairs, row by row.

use super::lists::{Inner, VerletLists};
use crate::bonds::ListedBond;
use crate::catalogue::Catalogue;
use crate::contact_history::{
    BondHistory, LawHistory, PartHistory, SavedHistories, SphereHistory, WallHistory,
};
use crate::contacts::SpherePair;
use crate::non_spherical::PartPair;
use crate::particles::Particles;
use crate::periodic_images as images;
use crate::walls::{Wall, WallPair};
use grains_domain::GlobalBox;
use grains_geometry::Vec3;

/// Which pairs are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Extent {
    All,
    /// Those of owned particles with clones, and all bonds.
    Border,
}

impl VerletLists {
    /// Saves the contact history of pairs in rows by owned particle.
    pub(crate) fn save_history(
        &self,
        particles: &Particles,
        (catalogue, walls): (&Catalogue, &[Wall]),
        global: &GlobalBox,
        histories: &mut SavedHistories,
        extent: Extent,
    ) {
        let keeps_law_history = !self.sphere_laws.is_empty();
        let inner = if extent == Extent::All { Inner::default() } else { self.inner };
        histories.fill(
            particles.owned,
            keeps_law_history,
            |add| self.save_spheres(particles, inner.spheres, add),
            |add| self.save_parts((particles, catalogue), inner.part_pairs, add),
            |add| {
                if extent == Extent::All {
                    self.save_walls(particles, walls, global, add);
                }
            },
            |add| self.save_bonds(particles, add),
        );
    }

    fn save_bonds(&self, particles: &Particles, add: &mut dyn FnMut(u32, BondHistory)) {
        for bond in self.bonds.bonds.iter().filter(|bond| !bond.is_broken) {
            let &ListedBond { ends: [a, b], kind, state, .. } = bond;
            for (own, other) in [(a, b), (b, a)] {
                if (own as usize) < particles.owned {
                    add(own, BondHistory { partner: particles.ids[other as usize], kind, state });
                }
            }
        }
    }

    fn save_spheres(
        &self,
        particles: &Particles,
        first: usize,
        add: &mut dyn FnMut(u32, SphereHistory, &LawHistory),
    ) {
        let (ids, owned) = (&particles.ids, particles.owned as u32);
        for (k, &SpherePair { a, b, tangential_displacement }) in self.spheres.iter().enumerate().skip(first)
        {
            let law = self.sphere_laws.get(k).copied().unwrap_or_default();
            if tangential_displacement == Vec3::zeros() && law.is_empty() {
                continue;
            }
            // With one sign of zero, whichever of the two bodies a list has it from.
            let of_pair = |partner: u32, tangential_displacement: Vec3| SphereHistory {
                partner: ids[partner as usize],
                tangential_displacement: tangential_displacement + Vec3::zeros(),
            };
            add(a, of_pair(b, tangential_displacement), &law.saved());
            if b < owned {
                add(b, of_pair(a, -tangential_displacement), &law.seen_from_other());
            }
        }
    }

    fn save_parts(
        &self,
        (particles, catalogue): (&Particles, &Catalogue),
        first: usize,
        add: &mut dyn FnMut(u32, PartHistory),
    ) {
        let touching = self.part_pairs.with_history_from(first, (particles, catalogue));
        for (&PartPair { a, b, parts, .. }, contact) in touching {
            for (own, other) in [(a, b), (b, a)] {
                if (own as usize) < particles.owned {
                    let partner = particles.ids[other as usize];
                    add(own, PartHistory { partner, parts, contact });
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
        for (k, pair) in self.walls.pairs.iter().enumerate() {
            let &WallPair { wall, surface, part, element, .. } = pair;
            let contact = self.walls.history_of(k);
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
