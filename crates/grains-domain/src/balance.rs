//! Moving the borders between subdomains to where the work is.
//!
//! Borders stay planes across the whole box, so that neighbours stay the 26 they were. Along each axis they go to the
//! quantiles of the work there. In one move a border stays between the two next to it as they were: what changes hands goes
//! to a neighbour.

use crate::{Decomposition, GlobalBox, Transport};

/// Slices of the box per axis in which work is summed.
const MIN_SLICES: usize = 1024;
/// The same for each rank along an axis, where that is more: a slab is cut from as many on average.
const SLICES_PER_RANK: usize = 16;

/// When borders move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// Smallest width of a subdomain along each axis (m): the interaction range, or what a halo of cells needs.
    pub min_width: [f64; 3],
    /// Smallest number of steps between two looks at the work, if the last one moved nothing (-).
    pub interval: u64,
    /// Work of the busiest slab of subdomains over the mean, above which borders across its axis move (-).
    pub threshold: f64,
}

/// What is done in a step beside contacts by those that share the borders of the particles, in units of theirs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OtherWork {
    /// Nodes (m) of a grid that fills the box, along each axis; none without one.
    pub nodes: [Vec<f64>; 3],
    /// Work in each of its cells.
    pub per_cell: f64,
    /// Work with each particle.
    pub per_particle: u64,
}

impl OtherWork {
    /// Adds the work in the cells of all ranks to a profile.
    pub fn add_cells(&self, profile: &mut WorkProfile, global: &GlobalBox) {
        if self.per_cell > 0.0 {
            profile.add_cells(global, &self.nodes, self.per_cell);
        }
    }

    /// Work of a rank with a number of particles.
    pub fn of_rank(&self, particles: usize, decomposition: &Decomposition) -> u64 {
        let (lower, upper) = (decomposition.lower(), decomposition.upper());
        let cells = self.nodes.iter().enumerate().map(|(a, nodes)| {
            let is_own = |w: &&[f64]| (lower[a]..upper[a]).contains(&(0.5 * (w[0] + w[1])));
            nodes.windows(2).filter(is_own).count()
        });
        self.per_particle * particles as u64
            + (self.per_cell * cells.product::<usize>() as f64).round() as u64
    }
}

/// How much there is to do where along each axis.
#[derive(Clone, Debug)]
pub struct WorkProfile {
    /// Where the slices of each axis begin and those of the last end.
    first: [usize; 4],
    /// Work per slice, axis by axis.
    slices: Vec<u64>,
}

impl WorkProfile {
    /// No work yet, for so many ranks along each axis.
    pub fn new(ranks: [usize; 3]) -> Self {
        let mut first = [0; 4];
        for (a, ranks) in ranks.into_iter().enumerate() {
            first[a + 1] = first[a] + MIN_SLICES.max(SLICES_PER_RANK * ranks);
        }
        Self { first, slices: vec![0; first[3]] }
    }

    /// Slices along an axis.
    fn count(&self, axis: usize) -> usize {
        self.first[axis + 1] - self.first[axis]
    }

    /// Adds work at a position (m), which may be a period off.
    #[inline]
    pub fn add(&mut self, global: &GlobalBox, position: [f64; 3], work: u64) {
        for (a, &x) in position.iter().enumerate() {
            let x = if global.periodic[a] { global.wrap_along(a, x) } else { x };
            let count = self.count(a);
            let slice = ((x - global.lower[a]) / global.length(a) * count as f64) as usize;
            self.slices[self.first[a] + slice.min(count - 1)] += work;
        }
    }

    /// Adds the work in the cells of a grid between nodes (m) that fill the box.
    fn add_cells(&mut self, global: &GlobalBox, nodes: &[Vec<f64>; 3], per_cell: f64) {
        let counts = nodes.each_ref().map(|nodes| nodes.len() - 1);
        for (a, nodes) in nodes.iter().enumerate() {
            let layer = per_cell * counts.iter().product::<usize>() as f64 / counts[a] as f64;
            let slices = self.count(a);
            let below = |slice: usize| {
                let x = global.lower[a] + global.length(a) * slice as f64 / slices as f64;
                let cell = nodes[1..counts[a]].partition_point(|&node| node <= x);
                let share = (x - nodes[cell]) / (nodes[cell + 1] - nodes[cell]);
                (layer * (cell as f64 + share)).round() as u64
            };
            for (slice, sum) in self.slices[self.first[a]..self.first[a + 1]].iter_mut().enumerate() {
                *sum += below(slice + 1) - below(slice);
            }
        }
    }

    /// Adds up what all ranks found; collective.
    pub fn sum(&mut self, transport: &impl Transport) {
        transport.sum_counts(&mut self.slices);
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.slices.fill(0);
    }

    /// Work below each slice along an axis, and all of it.
    fn cumulative(&self, axis: usize) -> Vec<f64> {
        let mut sum = 0.0;
        let mut below = vec![0.0];
        for &work in &self.slices[self.first[axis]..self.first[axis + 1]] {
            sum += work as f64;
            below.push(sum);
        }
        below
    }
}

impl Decomposition {
    /// Work of the busiest slab between two borders across an axis, over the mean (-).
    pub fn imbalance(&self, axis: usize, profile: &WorkProfile) -> f64 {
        self.shares(axis, &self.cuts[axis], profile).into_iter().fold(0.0, f64::max)
    }

    /// Work of every slab between borders (m) across an axis, over the mean (-).
    fn shares(&self, axis: usize, cuts: &[f64], profile: &WorkProfile) -> Vec<f64> {
        let below = profile.cumulative(axis);
        let slices = profile.count(axis);
        let (global, all) = (&self.global, below[slices]);
        let at = |cut: f64| {
            let place = ((cut - global.lower[axis]) / global.length(axis) * slices as f64).max(0.0);
            let slice = (place as usize).min(slices - 1);
            below[slice] + (place - slice as f64).min(1.0) * (below[slice + 1] - below[slice])
        };
        let mean = all / self.ranks[axis] as f64;
        let share = |cut: &[f64]| if all > 0.0 { (at(cut[1]) - at(cut[0])) / mean } else { 1.0 };
        cuts.windows(2).map(share).collect()
    }

    /// Borders on their way to where they share the work better, by a hundredth at least; none if no axis is worth it.
    pub fn rebalanced(&self, profile: &WorkProfile, balance: &Balance) -> Option<[Vec<f64>; 3]> {
        let mut cuts = self.cuts.clone();
        for (axis, cuts) in cuts.iter_mut().enumerate() {
            if self.ranks[axis] == 1 || self.imbalance(axis, profile) <= balance.threshold {
                continue;
            }
            let below = profile.cumulative(axis);
            let first = self.moved(axis, cuts, &below, balance.min_width[axis]);
            // The busiest slab may have to wait until its neighbours have made room: what counts is where borders will be.
            let last = self.wanted(axis, &below, balance.min_width[axis]);
            // Work of the busiest slab, which all wait for, and the squares, as another slab may be the next.
            let unevenness = |cuts: &[f64]| {
                let add = |[max, squares]: [f64; 2], share: f64| [max.max(share), squares + share * share];
                self.shares(axis, cuts, profile).into_iter().fold([0.0; 2], add)
            };
            let (now, then) = (unevenness(cuts), unevenness(&last));
            if then.iter().zip(now).any(|(then, now)| *then < 0.99 * now) {
                *cuts = first;
            }
        }
        (cuts != self.cuts).then_some(cuts)
    }

    /// Where the work below a border is the wanted share of all (m).
    fn quantile(&self, axis: usize, below: &[f64], share: f64) -> f64 {
        let slices = below.len() - 1;
        let wanted = below[slices] * share;
        let slice = below.partition_point(|&work| work < wanted).clamp(1, slices) - 1;
        let within = (wanted - below[slice]) / (below[slice + 1] - below[slice]);
        self.global.lower[axis] + self.global.length(axis) * (slice as f64 + within) / slices as f64
    }

    /// Borders across an axis at the quantiles of the work below them, apart by a width (m) at least.
    fn wanted(&self, axis: usize, below: &[f64], min_width: f64) -> Vec<f64> {
        let (ranks, mut cuts) = (self.ranks[axis], self.cuts[axis].clone());
        let min_width = min_width + 2.0 * self.global.quantum.size();
        for k in 1..ranks {
            cuts[k] = self.quantile(axis, below, k as f64 / ranks as f64).max(cuts[k - 1] + min_width);
        }
        for k in (1..ranks).rev() {
            cuts[k] = cuts[k].min(cuts[k + 1] - min_width);
        }
        cuts
    }

    /// Inner borders across an axis, moved towards the quantiles of the work below them.
    fn moved(&self, axis: usize, old: &[f64], below: &[f64], min_width: f64) -> Vec<f64> {
        let (ranks, quantum, mut moved) = (self.ranks[axis], &self.global.quantum, old.to_vec());
        for k in 1..ranks {
            let quantile = self.quantile(axis, below, k as f64 / ranks as f64);
            // Rounding must not make a subdomain too thin.
            let min_width = min_width + 2.0 * quantum.size();
            let (low, high) = (old[k - 1].max(moved[k - 1]) + min_width, old[k + 1] - min_width);
            if low <= high {
                moved[k] = quantum.snap(quantile.clamp(low, high));
            }
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BALANCE: Balance = Balance { min_width: [0.1; 3], interval: 1, threshold: 1.05 };

    fn decomposition(ranks: [usize; 3]) -> Decomposition {
        let global = GlobalBox::new([0.0; 3], [8.0, 1.0, 1.0], [false; 3]);
        Decomposition::new(global, ranks, 0, 0.1).unwrap()
    }

    /// Work that falls off along x.
    fn profile(global: &GlobalBox) -> WorkProfile {
        let mut profile = WorkProfile::new([8, 1, 1]);
        for k in 0..8000 {
            let x = (k as f64 + 0.5) * 1e-3;
            profile.add(global, [x, 0.5, 0.5], (1000.0 * (-x).exp()) as u64);
        }
        profile
    }

    #[test]
    fn borders_reach_the_quantiles_in_a_few_moves() {
        let mut d = decomposition([8, 1, 1]);
        let profile = profile(&d.global);
        let before = d.imbalance(0, &profile);
        assert!(before > 4.0, "{before}");
        let mut moves = 0;
        while let Some(cuts) = d.rebalanced(&profile, &BALANCE) {
            for k in 1..8 {
                assert!(cuts[0][k] >= d.cuts[0][k - 1] + 0.1 && cuts[0][k] <= d.cuts[0][k + 1] - 0.1);
                assert!(cuts[0][k] - cuts[0][k - 1] > 0.0999);
            }
            d.cuts = cuts;
            moves += 1;
            assert!(moves < 10);
        }
        let after = d.imbalance(0, &profile);
        assert!(after < 1.05 && moves > 1, "{after} after {moves} moves");
    }

    #[test]
    fn borders_of_thousands_of_slabs_share_work_that_lies_in_layers() {
        let (ranks, layers, points) = (2000, 1500.0, 1_000_000);
        let global = GlobalBox::new([0.0; 3], [8.0, 1.0, 1.0], [false; 3]);
        let mut d = Decomposition::new(global, [ranks, 1, 1], 0, 1e-4).unwrap();
        let mut profile = WorkProfile::new(d.ranks);
        // Layers with gaps between them, twice as dense in the middle of the box as at its ends.
        for k in 0..points {
            let x = (f64::from(k) + 0.5) / f64::from(points);
            let work = if (layers * x).fract() < 0.5 { 1000.0 * (1.0 + 4.0 * x * (1.0 - x)) } else { 0.0 };
            profile.add(&d.global, [8.0 * x, 0.5, 0.5], work as u64);
        }
        let before = d.imbalance(0, &profile);
        let balance = Balance { min_width: [1e-4, 0.1, 0.1], ..BALANCE };
        let mut moves = 0;
        while let Some(cuts) = d.rebalanced(&profile, &balance) {
            d.cuts = cuts;
            moves += 1;
            assert!(moves < ranks);
        }
        let after = d.imbalance(0, &profile);
        assert!(before > 1.5 && after < 1.06, "{before}, {after} after {moves} moves");
    }

    #[test]
    fn no_subdomain_gets_thinner_than_the_range_and_even_work_moves_nothing() {
        let mut d = decomposition([4, 1, 1]);
        let mut profile = WorkProfile::new(d.ranks);
        (0..200).for_each(|k| profile.add(&d.global, [1e-3 * k as f64, 0.5, 0.5], 1));
        while let Some(cuts) = d.rebalanced(&profile, &BALANCE) {
            d.cuts = cuts;
        }
        assert!(d.cuts[0].windows(2).all(|cut| cut[1] - cut[0] > 0.0999), "{:?}", d.cuts);
        // Half of the work is in the thinnest subdomain there may be.
        assert!((d.imbalance(0, &profile) - 2.0).abs() < 0.05, "{:?}", d.cuts);
        let d = decomposition([4, 1, 1]);
        profile.clear();
        (0..1000).for_each(|k| profile.add(&d.global, [8e-3 * k as f64, 0.5, 0.5], 1));
        assert_eq!(d.rebalanced(&profile, &BALANCE), None);
    }

    #[test]
    fn borders_go_on_through_moves_that_gain_nothing() {
        // Thirty layers of particles at the lower end of eight slabs: after the first move the second slab holds as much as it
        // did, and so will the third after the second.
        let global = GlobalBox::new([0.0; 3], [0.36, 0.06, 0.06], [false; 3]);
        let mut d = Decomposition::new(global, [8, 1, 1], 0, 0.024).unwrap();
        let mut profile = WorkProfile::new(d.ranks);
        (0..30).for_each(|k| profile.add(&d.global, [0.003 + 0.00303 * k as f64, 0.03, 0.03], 300));
        let balance = Balance { min_width: [0.024; 3], ..BALANCE };
        let mut unevenness = Vec::new();
        while let Some(cuts) = d.rebalanced(&profile, &balance) {
            d.cuts = cuts;
            unevenness.push(d.shares(0, &d.cuts[0], &profile).into_iter().map(|s| s * s).sum::<f64>());
            assert!(unevenness.len() < 10);
        }
        assert!(unevenness[1] > 0.99 * unevenness[0], "{unevenness:?}");
        // Slabs as thin as they may be have 7, 8, 8 and 7 layers.
        let best = [7.0_f64, 8.0, 8.0, 7.0].into_iter().map(|layers| (layers / 3.75).powi(2)).sum::<f64>();
        assert!((unevenness.last().unwrap() / best - 1.0).abs() < 0.02, "{unevenness:?} {:?}", d.cuts[0]);
    }

    #[test]
    fn cells_weigh_where_they_lie_and_pull_borders_to_them() {
        let mut d = decomposition([2, 1, 1]);
        // Three cells in the lower eighth, one in the rest.
        let nodes = [vec![0.0, 0.25, 0.5, 1.0, 8.0], vec![0.0, 1.0], vec![0.0, 0.5, 1.0]];
        let cells = OtherWork { nodes, per_cell: 1000.0, per_particle: 7 };
        let mut profile = WorkProfile::new(d.ranks);
        cells.add_cells(&mut profile, &d.global);
        for axis in 0..3 {
            assert_eq!(profile.cumulative(axis).last(), Some(&8000.0));
        }
        assert_eq!(profile.cumulative(0)[MIN_SLICES / 8], 6000.0);
        assert_eq!(cells.of_rank(2, &d), 7 * 2 + 6000);
        let cuts = d.rebalanced(&profile, &BALANCE).unwrap();
        assert!((cuts[0][1] - 0.5).abs() < 8.0 / MIN_SLICES as f64, "{cuts:?}");
        d.cuts = cuts;
        assert!(d.imbalance(0, &profile) < 1.01);
        let none = OtherWork::default();
        none.add_cells(&mut profile, &d.global);
        assert_eq!((profile.cumulative(2).last(), none.of_rank(5, &d)), (Some(&8000.0), 0));
    }
}
