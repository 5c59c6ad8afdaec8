//! The Verlet lists of one rank.

use super::pair_search::BondChanges;
use super::references::References;
use crate::bonds::BondList;
use crate::contact_history::LawHistory;
use crate::contacts::SpherePair;
use crate::memory_use::heap_bytes;
use crate::non_spherical::PartPairList;
use crate::walls::WallList;

/// The Verlet lists of one rank.
#[derive(Debug, Default)]
pub(crate) struct VerletLists {
    pub(crate) references: References,
    pub(crate) spheres: Vec<SpherePair>,
    /// What laws keep of these beside the tangential displacement; empty if nothing.
    pub(crate) sphere_laws: Vec<LawHistory>,
    pub(crate) part_pairs: PartPairList,
    pub(crate) walls: WallList,
    pub(crate) bonds: BondList,
    /// Pairs that exert no forces, but exchange heat.
    pub(crate) resting: RestingPairs,
    /// How many pairs, at the beginning of the lists, are of two owned particles.
    pub(crate) inner: Inner,
    /// Distance any wall may move before the lists are rebuilt (m).
    pub(crate) wall_allowance: f64,
    /// What became of bonds in the search under way.
    pub(super) bond_changes: BondChanges,
    /// Scratch: parts of two bodies near each other.
    pub(super) near_parts: [Vec<u16>; 2],
}

/// Pairs of bodies of prescribed motion with each other and with walls: nothing comes of their forces. Empty unless particles have
/// temperatures.
#[derive(Debug, Default)]
pub(crate) struct RestingPairs {
    pub(crate) spheres: Vec<SpherePair>,
    pub(crate) part_pairs: PartPairList,
    pub(crate) walls: WallList,
}

/// Numbers of pairs of spheres, and of parts of bodies, with forces and without.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Inner {
    pub(crate) spheres: usize,
    pub(crate) part_pairs: usize,
    pub(crate) resting_spheres: usize,
    pub(crate) resting_part_pairs: usize,
}

impl VerletLists {
    /// Memory (B).
    pub(crate) fn bytes(&self) -> usize {
        let Self { references, spheres, sphere_laws, part_pairs, walls, bonds, resting, .. } = self;
        references.bytes()
            + heap_bytes(spheres)
            + heap_bytes(sphere_laws)
            + part_pairs.bytes()
            + bonds.bytes()
            + walls.bytes()
            + heap_bytes(&resting.spheres)
            + resting.part_pairs.bytes()
            + resting.walls.bytes()
    }

    /// Number of pairs in the lists: spheres, parts of other particles, walls.
    pub(crate) fn sizes(&self) -> [usize; 3] {
        [self.spheres.len(), self.part_pairs.pairs.len(), self.walls.pairs.len()]
    }
}
