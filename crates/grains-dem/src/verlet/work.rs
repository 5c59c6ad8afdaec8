//! The work of a step, counted from the lists.

use super::lists::VerletLists;

/// Time that a particle, a pair of parts of bodies, a pair with a wall and a bond take in a step, over that of a pair of
/// spheres: of settled spheres 0.5 (and a share of the next sorting), of cubes 3, 13 and 4, of a bond 28, in units of
/// 0.014 microseconds.
const WORK_OF_PARTICLE: u64 = 2;
const WORK_OF_PARTS: u64 = 13;
const WORK_AT_WALL: u64 = 4;
const WORK_OF_BOND: u64 = 28;

impl VerletLists {
    /// What each owned particle costs in a step, in units of a pair of spheres.
    ///
    /// Pairs and particles are counted, not timed, so that borders lie alike in every run of a case.
    pub(crate) fn work_of_each(&self, owned: usize) -> Vec<u64> {
        let mut work = vec![WORK_OF_PARTICLE; owned];
        let mut add = |particle: u32, cost: u64| {
            if let Some(sum) = work.get_mut(particle as usize) {
                *sum += cost;
            }
        };
        self.spheres.iter().for_each(|pair| add(pair.a, 1));
        // One of two bodies may be a clone.
        self.part_pairs.pairs.iter().for_each(|pair| add(pair.a.min(pair.b), WORK_OF_PARTS));
        self.walls.pairs.iter().for_each(|pair| add(pair.particle, WORK_AT_WALL));
        self.bonds.bonds.iter().for_each(|bond| add(bond.ends[0].min(bond.ends[1]), WORK_OF_BOND));
        work
    }

    /// The sum of it.
    pub(crate) fn work(&self, owned: usize) -> u64 {
        let [spheres, bodies, walls] = self.sizes().map(|n| n as u64);
        let bonds = self.bonds.bonds.len() as u64;
        WORK_OF_PARTICLE * owned as u64
            + spheres
            + WORK_OF_PARTS * bodies
            + WORK_AT_WALL * walls
            + WORK_OF_BOND * bonds
    }
}
