//! The bonds of one rank, found again whenever particles change places.

use crate::contact_history::{BondHistory, SavedHistories};
use crate::error::{StepError, vector};
use crate::memory_use::heap_bytes;
use crate::particles::Particles;
use grains_contact::BondState;
use rustc_hash::FxHashMap;

/// A bond between two particles, at least one of them owned.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ListedBond {
    /// The particle of lower id, and the other.
    pub(crate) ends: [u32; 2],
    pub(crate) kind: u16,
    pub(crate) is_broken: bool,
    /// As seen from the first.
    pub(crate) state: BondState,
}

/// The bonds of one rank.
#[derive(Clone, Debug, Default)]
pub(crate) struct BondList {
    pub(crate) bonds: Vec<ListedBond>,
    /// How many of them, at the beginning, are of two owned particles.
    pub(crate) inner: usize,
}

impl ListedBond {
    /// How many of its particles are owned.
    pub(crate) fn owned_ends(&self, owned: usize) -> u64 {
        self.ends.iter().filter(|&&end| (end as usize) < owned).count() as u64
    }
}

impl BondList {
    /// Memory (B).
    pub(crate) fn bytes(&self) -> usize {
        heap_bytes(&self.bonds)
    }

    /// Number of bonds of each owned particle.
    pub(crate) fn of_each(&self, owned: usize) -> Vec<u32> {
        let mut counts = vec![0; owned];
        for &end in self.bonds.iter().filter(|bond| !bond.is_broken).flat_map(|bond| &bond.ends) {
            counts.get_mut(end as usize).into_iter().for_each(|count| *count += 1);
        }
        counts
    }

    /// Adds a bond of particle `i` with `j`; that of two owned particles is to be added once.
    pub(crate) fn push(&mut self, particles: &Particles, [i, j]: [usize; 2], kind: u16, state: BondState) {
        let ends = if particles.ids[i] < particles.ids[j] { [i, j] } else { [j, i] };
        self.bonds.push(ListedBond { ends: ends.map(|end| end as u32), kind, is_broken: false, state });
    }

    /// Finds the particles of all bonds among those sorted and their clones; returns how many ends had a partner that is gone.
    ///
    /// `row` says which row of `histories` an owned particle has.
    ///
    /// # Errors
    /// A partner that is not there, where none may leave.
    pub(crate) fn find(
        &mut self,
        particles: &Particles,
        histories: &SavedHistories,
        row: impl Fn(usize) -> usize,
        may_leave: bool,
    ) -> Result<u64, StepError> {
        self.bonds.clear();
        self.inner = 0;
        if histories.bonds.is_empty() {
            return Ok(0);
        }
        let images = Images::of(particles);
        let mut gone = 0;
        for i in 0..particles.owned {
            for &BondHistory { partner, kind, state } in histories.bonds.row(row(i)) {
                let (id, position) = (particles.ids[i], &particles.bodies[i].position);
                let away = |j: &usize| (particles.bodies[*j].position - position).norm_squared();
                match images.of_id(partner).min_by(|j, k| away(j).total_cmp(&away(k))) {
                    Some(j) if j >= particles.owned || id < partner => {
                        self.push(particles, [i, j], kind, state);
                    }
                    Some(_) => {}
                    None if may_leave => gone += 1,
                    None => return Err(StepError::BondLost { id, partner, place: vector(position) }),
                }
            }
        }
        Ok(gone)
    }

    /// Puts those of two owned particles first.
    pub(crate) fn sort(&mut self, owned: usize) {
        let has_clone = |bond: &ListedBond| bond.owned_ends(owned) < 2;
        self.bonds.sort_by_key(has_clone);
        self.inner = self.bonds.partition_point(|bond| !has_clone(bond));
    }
}

/// Where the images of a particle are, by its id.
struct Images {
    first: FxHashMap<u64, u32>,
    /// The next image of the same particle.
    next: Vec<u32>,
}

/// No image.
const NONE: u32 = u32::MAX;

impl Images {
    fn of(particles: &Particles) -> Self {
        let mut first = FxHashMap::with_capacity_and_hasher(particles.len(), Default::default());
        let after = |(i, &id): (usize, &u64)| first.insert(id, i as u32).unwrap_or(NONE);
        let next = particles.ids.iter().enumerate().map(after).collect();
        Self { first, next }
    }

    fn of_id(&self, id: u64) -> impl Iterator<Item = usize> {
        let known = |i: u32| (i != NONE).then_some(i);
        let first = self.first.get(&id).copied();
        std::iter::successors(first, move |&i| known(self.next[i as usize])).map(|i| i as usize)
    }
}
