//! All wall pairs of a rank.

use super::pairs::WallPair;
use super::sphere_batch::SphereBatch;
use super::surface_contact::{SphereTouch, SurfaceContact};
use crate::contact_history::{ContactHistory, LawHistory, WallKey};
use grains_geometry::{Simplex, Vec3};
use std::ops::Range;

/// All wall pairs of a rank, those of one particle and surface side by side, triangles ascending.
#[derive(Clone, Debug, Default)]
pub(crate) struct WallList {
    pub(crate) pairs: Vec<WallPair>,
    /// What laws keep of the pairs beside their displacements; empty if nothing.
    pub(crate) laws: Vec<LawHistory>,
    pub(crate) keep_laws: bool,
    pub(crate) simplexes: Vec<Simplex>,
    /// Shift (m) of each periodic image.
    pub(crate) shifts: Vec<Vec3>,
    pub(super) touching: Vec<Option<SurfaceContact>>,
    pub(super) touching_spheres: Vec<Option<SphereTouch>>,
    pub(super) batch: Box<SphereBatch>,
}

impl WallList {
    /// Adds the pair of a particle and what `key` names, with its contact history.
    pub(crate) fn push(&mut self, particle: u32, key: WallKey, known: ContactHistory, is_closed_form: bool) {
        let (wall, surface, part, element, image) = key;
        let ContactHistory { tangential_displacement, torsional_angle, law, simplex } = known;
        if self.keep_laws {
            self.laws.push(law);
        }
        let simplex = if is_closed_form {
            WallPair::CLOSED_FORM
        } else {
            self.simplexes.push(simplex);
            self.simplexes.len() as u32 - 1
        };
        self.pairs.push(WallPair {
            particle,
            element,
            wall,
            surface,
            part,
            image,
            tangential_displacement,
            torsional_angle,
            simplex,
        });
    }

    /// What a pair keeps of its contact.
    pub(crate) fn history_of(&self, pair: usize) -> ContactHistory {
        let WallPair { tangential_displacement, torsional_angle, simplex, .. } = self.pairs[pair];
        let simplex = self.simplexes.get(simplex as usize).copied().unwrap_or_default();
        let law = self.laws.get(pair).copied().unwrap_or_default();
        ContactHistory { tangential_displacement, torsional_angle, law, simplex }
    }

    /// Forgets a contact that ended.
    pub(super) fn forget(&mut self, pair: usize) {
        self.pairs[pair].reset_displacements();
        if let Some(law) = self.laws.get_mut(pair) {
            *law = LawHistory::default();
        }
    }

    /// Drops the simplexes of a range of pairs.
    pub(super) fn drop_simplexes(&mut self, group: Range<usize>) {
        for pair in &self.pairs[group] {
            if let Some(simplex) = self.simplexes.get_mut(pair.simplex as usize) {
                simplex.len = 0;
            }
        }
    }

    /// End of the group of pairs of one particle, image and surface that begins at `start`.
    pub(super) fn group_end(&self, start: usize) -> usize {
        let first = &self.pairs[start];
        self.pairs[start..].iter().position(|p| !p.meets_same(first)).map_or(self.pairs.len(), |n| start + n)
    }

    /// End of the pairs of one part of the particle that begin at `start`.
    pub(super) fn part_end(&self, start: usize, group_end: usize) -> usize {
        let part = self.pairs[start].part;
        let others = self.pairs[start..group_end].iter().position(|p| p.part != part);
        others.map_or(group_end, |n| start + n)
    }
}
