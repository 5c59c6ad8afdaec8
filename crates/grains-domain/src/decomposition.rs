//! One Cartesian subdomain per rank.

use crate::{Direction, GlobalBox};
use thiserror::Error;

/// A box that cannot be divided as asked.
#[derive(Debug, Error, PartialEq)]
pub enum DecompositionError {
    /// A subdomain is thinner than the interaction range.
    #[error(
        "{ranks} subdomains along {axis} are {width:.4e} m wide each, thinner than the interaction range {range:.4e} m (largest diameter, skin, gaps that are acted over and bonds): use at most {max_ranks} there (domain.ranks, or fewer ranks)"
    )]
    TooThin {
        /// Axis name.
        axis: char,
        /// Ranks along it.
        ranks: usize,
        /// Width of one subdomain (m).
        width: f64,
        /// Interaction range (m).
        range: f64,
        /// Largest number of ranks that fit.
        max_ranks: usize,
    },
    /// A periodic axis is so short that a particle would meet another twice.
    #[error(
        "the periodic length {length:.4e} m along {axis} is below twice the interaction range {range:.4e} m (largest diameter, skin, gaps that are acted over and bonds): a particle would meet the same neighbour twice; widen the domain along {axis}"
    )]
    PeriodTooShort {
        /// Axis name.
        axis: char,
        /// Period (m).
        length: f64,
        /// Interaction range (m).
        range: f64,
    },
    /// The axis along which images of a sheared box slide is divided.
    #[error(
        "{ranks} subdomains along {axis}, the axis of the flow of a sheared box, which must not be divided: take 1 there (domain.ranks), or another number of ranks"
    )]
    FlowDivided {
        /// Axis name.
        axis: char,
        /// Ranks along it.
        ranks: usize,
    },
}

/// Division of the global box into equal subdomains, seen from one of them.
#[derive(Clone, Debug)]
pub struct Decomposition {
    /// The whole box.
    pub global: GlobalBox,
    /// Ranks per axis.
    pub ranks: [usize; 3],
    /// Own place in the grid of ranks.
    pub coordinates: [usize; 3],
    /// Borders of the subdomains along each axis (m): ranks + 1 ascending numbers.
    pub cuts: [Vec<f64>; 3],
}

impl Decomposition {
    /// Division for rank `rank` of `ranks[0] ranks[1] ranks[2]`, numbered with x fastest.
    ///
    /// `range` is the largest distance (m) of the centres of interacting particles, skin included.
    pub fn new(
        global: GlobalBox,
        ranks: [usize; 3],
        rank: usize,
        range: f64,
    ) -> Result<Self, DecompositionError> {
        for axis in 0..3 {
            let (length, name) = (global.length(axis), ['x', 'y', 'z'][axis]);
            if global.periodic[axis] && length < 2.0 * range {
                return Err(DecompositionError::PeriodTooShort { axis: name, length, range });
            }
            let width = length / ranks[axis] as f64;
            if ranks[axis] > 1 && width < range {
                let max_ranks = ((length / range) as usize).max(1);
                return Err(DecompositionError::TooThin {
                    axis: name,
                    ranks: ranks[axis],
                    width,
                    range,
                    max_ranks,
                });
            }
        }
        let cuts = std::array::from_fn(|a| {
            let n = ranks[a];
            let cut =
                |k: usize| global.quantum.snap(global.lower[a] + global.length(a) * (k as f64 / n as f64));
            (0..=n).map(|k| if k == n { global.upper[a] } else { cut(k) }).collect()
        });
        let coordinates = [rank % ranks[0], rank / ranks[0] % ranks[1], rank / (ranks[0] * ranks[1])];
        Ok(Self { global, ranks, coordinates, cuts })
    }

    /// Moves the borders to nodes (m) of a grid, so that subdomains have as many cells, to one: for grids whose cells are the work.
    ///
    /// Axes along which all cells are equal keep their borders, which share these as well.
    pub fn share_cells(&mut self, nodes: &[Vec<f64>; 3]) {
        for (axis, nodes) in nodes.iter().enumerate() {
            let (n, ranks) = (nodes.len() - 1, self.ranks[axis]);
            let mean = (nodes[n] - nodes[0]) / n as f64;
            if nodes.windows(2).all(|w| (w[1] - w[0] - mean).abs() < 1e-9 * mean) {
                continue;
            }
            for (k, cut) in self.cuts[axis].iter_mut().enumerate().take(ranks).skip(1) {
                *cut = self.global.quantum.snap(nodes[k * n / ranks]);
            }
        }
    }

    /// Lower corner of the own subdomain (m).
    pub fn lower(&self) -> [f64; 3] {
        std::array::from_fn(|a| self.cuts[a][self.coordinates[a]])
    }

    /// Smallest width (m) of any subdomain along an axis along which particles have images or ranks have neighbours; infinite if
    /// there is none.
    pub fn smallest_width(&self) -> f64 {
        let is_shared = |&a: &usize| self.ranks[a] > 1 || self.global.periodic[a];
        let widths = |a: usize| self.cuts[a].windows(2).map(|cuts| cuts[1] - cuts[0]);
        (0..3).filter(is_shared).flat_map(widths).fold(f64::INFINITY, f64::min)
    }

    /// Upper corner of the own subdomain (m).
    pub fn upper(&self) -> [f64; 3] {
        std::array::from_fn(|a| self.cuts[a][self.coordinates[a] + 1])
    }

    /// Place in the grid of ranks that owns a position inside the box.
    pub fn owner_coordinates(&self, position: [f64; 3]) -> [usize; 3] {
        std::array::from_fn(|a| {
            let inner = &self.cuts[a][1..self.ranks[a]];
            inner.partition_point(|&cut| cut <= position[a])
        })
    }

    /// Rank at a place in the grid, x fastest.
    pub fn rank_at(&self, coordinates: [usize; 3]) -> usize {
        (coordinates[2] * self.ranks[1] + coordinates[1]) * self.ranks[0] + coordinates[0]
    }

    /// Rank that owns a position inside the box.
    pub fn owner(&self, position: [f64; 3]) -> usize {
        self.rank_at(self.owner_coordinates(position))
    }

    /// Rank of the neighbour in a direction and the shift (m) that brings a particle into its frame.
    ///
    /// `None` beyond a face that is not periodic. The neighbour may be the own rank.
    pub fn neighbour(&self, direction: Direction) -> Option<(usize, [f64; 3])> {
        let mut place = self.coordinates;
        let mut shift = [0.0; 3];
        for a in 0..3 {
            let (n, at) = (self.ranks[a] as isize, self.coordinates[a] as isize + direction.0[a] as isize);
            if at < 0 || at >= n {
                if !self.global.periodic[a] {
                    return None;
                }
                shift[a] = if at < 0 { self.global.length(a) } else { -self.global.length(a) };
            }
            place[a] = at.rem_euclid(n) as usize;
        }
        Some((self.rank_at(place), shift))
    }
}

/// Ranks per axis for `size` ranks: smallest surface between subdomains, none thinner than `min_width` (m, per axis) if that
/// can be had, and the axis along which particles pile up (`gravity`) cut last.
pub fn choose_ranks(global: &GlobalBox, size: usize, min_width: [f64; 3], gravity: [f64; 3]) -> [usize; 3] {
    let length: [f64; 3] = std::array::from_fn(|a| global.length(a));
    let strongest = gravity.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
    let mut best = ([size, 1, 1], f64::INFINITY);
    for px in (1..=size).filter(|p| size.is_multiple_of(*p)) {
        for py in (1..=size / px).filter(|p| (size / px).is_multiple_of(*p)) {
            let ranks = [px, py, size / px / py];
            let mut cost = 0.0;
            for a in 0..3 {
                let area = length[(a + 1) % 3] * length[(a + 2) % 3];
                let piles_up = strongest > 0.0 && gravity[a].abs() > 0.5 * strongest;
                let faces = (ranks[a] - 1) as f64 * if piles_up { 100.0 } else { 1.0 };
                let too_thin = ranks[a] > 1 && length[a] / (ranks[a] as f64) < min_width[a];
                cost += faces * area * if too_thin { 1e6 } else { 1.0 };
            }
            if cost < best.1 {
                best = (ranks, cost);
            }
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_box(periodic: bool) -> GlobalBox {
        GlobalBox::new([0.0; 3], [1.0, 2.0, 4.0], [periodic; 3])
    }

    #[test]
    fn every_position_has_one_owner_also_on_a_cut() {
        let d = Decomposition::new(unit_box(false), [3, 2, 1], 0, 0.1).unwrap();
        for rank in 0..6 {
            let own = Decomposition::new(unit_box(false), [3, 2, 1], rank, 0.1).unwrap();
            let (lower, upper) = (own.lower(), own.upper());
            assert_eq!(d.owner(lower), rank);
            let inside = std::array::from_fn(|a| 0.5 * (lower[a] + upper[a]));
            assert_eq!(d.owner(inside), rank);
        }
    }

    #[test]
    fn neighbours_are_mutual_and_their_shifts_opposite() {
        for rank in 0..6 {
            let own = Decomposition::new(unit_box(true), [3, 2, 1], rank, 0.1).unwrap();
            for direction in Direction::all() {
                let (other, shift) = own.neighbour(direction).unwrap();
                let back = Decomposition::new(unit_box(true), [3, 2, 1], other, 0.1).unwrap();
                assert_eq!(back.neighbour(direction.opposite()), Some((rank, shift.map(|s| -s))));
            }
        }
        let closed = Decomposition::new(unit_box(false), [3, 2, 1], 0, 0.1).unwrap();
        assert_eq!(closed.neighbour(Direction([-1, 0, 0])), None);
    }

    #[test]
    fn thin_subdomains_and_short_periods_are_refused_with_the_remedy() {
        let thin = Decomposition::new(unit_box(false), [4, 1, 1], 0, 0.3).unwrap_err();
        assert!(thin.to_string().contains("at most 3"), "{thin}");
        let short = Decomposition::new(unit_box(true), [1, 1, 1], 0, 0.6).unwrap_err();
        assert!(short.to_string().contains("widen the domain along x"), "{short}");
    }

    #[test]
    fn the_axis_of_gravity_is_cut_last() {
        assert_eq!(choose_ranks(&unit_box(false), 2, [0.2; 3], [0.0, 0.0, -9.81]), [1, 2, 1]);
        assert_eq!(choose_ranks(&unit_box(false), 2, [0.2; 3], [0.0; 3]), [1, 1, 2]);
        let thin = GlobalBox::new([0.0; 3], [0.1, 0.1, 4.0], [false; 3]);
        assert_eq!(choose_ranks(&thin, 4, [0.2; 3], [0.0, 0.0, -9.81]), [1, 1, 4]);
    }

    #[test]
    fn cells_refined_towards_both_ends_are_shared_by_number() {
        let nodes = |n: usize, strength: f64| -> Vec<f64> {
            let at = |i: usize| (strength * (2.0 * i as f64 / n as f64 - 1.0)).tanh() / strength.tanh();
            (0..=n).map(|i| 0.5 + 0.5 * at(i)).collect()
        };
        let even: Vec<f64> = (0..=10).map(|i| f64::from(i) / 10.0).collect();
        for n in [64, 67, 100] {
            for ranks in [2, 3, 8] {
                let mut d = Decomposition::new(unit_box(false), [1, ranks, 4], 0, 1e-6).unwrap();
                let before = d.cuts.clone();
                let y = nodes(n, 3.0);
                d.share_cells(&[even.clone(), y.clone(), even.clone()]);
                assert_eq!([&d.cuts[0], &d.cuts[2]], [&before[0], &before[2]], "equal cells");
                let count = |cuts: &[f64]| -> Vec<usize> {
                    let own = |w: &[f64]| {
                        y.windows(2).filter(|c| (w[0]..w[1]).contains(&(0.5 * (c[0] + c[1])))).count()
                    };
                    cuts.windows(2).map(own).collect()
                };
                let (old, new) = (count(&before[1]), count(&d.cuts[1]));
                assert_eq!(new.iter().sum::<usize>(), n);
                assert!(new.iter().all(|&c| c == n / ranks || c == n.div_ceil(ranks)), "{new:?}");
                assert!(ranks < 8 || old[0] * 4 > n, "an end had more than a quarter of all: {old:?}");
            }
        }
    }
}
