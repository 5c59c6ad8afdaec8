//! Which ranks have the cells of a coarse level.

use super::level::Level;
use super::transfer::stuck;
use crate::CellPartition;

/// Cells of a coarse level that one rank may have of others.
const AGGLOMERATED: usize = 1000;
/// Largest number of ranks whose cells one of them takes at a time.
const GROUP: usize = 8;

/// Ranks among the job's: every so many-th along each axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaders {
    of_job: [usize; 3],
    spacing: [usize; 3],
}

impl Leaders {
    /// All ranks of a partition.
    pub fn all(partition: &CellPartition) -> Self {
        Self { of_job: partition.ranks, spacing: [1; 3] }
    }

    /// Rank in the job of the leader at a place among the leaders.
    pub fn rank(&self, place: [usize; 3]) -> usize {
        let [x, y, z] = [0, 1, 2].map(|a| place[a] * self.spacing[a]);
        (z * self.of_job[1] + y) * self.of_job[0] + x
    }

    /// The first of every group of so many along each axis.
    pub fn of_groups(&self, group: [usize; 3]) -> Self {
        Self { of_job: self.of_job, spacing: [0, 1, 2].map(|a| self.spacing[a] * group[a]) }
    }
}

/// Ranks along each axis that shall give their cells of a level to the first of them; one where each keeps its own.
///
/// Groups form as soon as their cells are few. Two ranks also join along an axis on which each has but one cell left.
pub(crate) fn grouping(level: &Level) -> [usize; 3] {
    let ranks = level.partition.ranks;
    let groups = |group: &[usize; 3], a: usize| ranks[a].div_ceil(group[a]);
    let mut group = [1; 3];
    while group.iter().product::<usize>() < GROUP {
        let Some(axis) = (0..3).filter(|&a| groups(&group, a) > 1).max_by_key(|&a| groups(&group, a)) else {
            break;
        };
        group[axis] *= 2;
    }
    let leaders: usize = (0..3).map(|a| groups(&group, a)).product();
    if level.cells() <= AGGLOMERATED * leaders {
        return group;
    }
    let counts = [0, 1, 2].map(|a| level.partition.counts(a));
    let axes = [0, 1, 2].map(|a| level.grid.axis(a));
    stuck(axes, counts.each_ref().map(|c| &c[..])).map(|is_stuck| if is_stuck { 2 } else { 1 })
}

/// The partition among the groups, for the leader of the own one.
pub(crate) fn grouped(partition: &CellPartition, group: [usize; 3]) -> CellPartition {
    let starts = [0, 1, 2].map(|a| {
        let (starts, ranks) = (&partition.starts[a], partition.ranks[a]);
        let firsts = (0..ranks).step_by(group[a]).map(|rank| starts[rank]);
        firsts.chain([starts[ranks]]).collect::<Vec<usize>>()
    });
    CellPartition {
        ranks: starts.each_ref().map(|s| s.len() - 1),
        coordinates: [0, 1, 2].map(|a| partition.coordinates[a] / group[a]),
        starts,
    }
}

/// Places of the own group, the leader's first.
pub(crate) fn members(partition: &CellPartition, group: [usize; 3]) -> Vec<[usize; 3]> {
    let [x, y, z] = [0, 1, 2].map(|a| {
        let first = partition.coordinates[a] / group[a] * group[a];
        first..(first + group[a]).min(partition.ranks[a])
    });
    z.flat_map(|k| y.clone().map(move |j| [j, k]))
        .flat_map(|[j, k]| x.clone().map(move |i| [i, j, k]))
        .collect()
}
