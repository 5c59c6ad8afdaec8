//! Moving the borders between subdomains to where the work is.
//!
//! Borders stay planes across the whole box, so that neighbours stay the 26 they were. Along each axis they go to the
//! quantiles of the work there. In one move a border stays between the two next to it as they were: what changes hands goes
//! to a neighbour.

use crate::{Decomposition, GlobalBox, Transport};

/// Slices of the box per axis in which work is summed, whatever the number of ranks.
const SLICES: usize = 1024;

/// When borders move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// Least number of steps between two looks at the work, if the last one moved nothing (-).
    pub interval: u64,
    /// Work of the busiest slab of subdomains over the mean, above which borders across its axis move (-).
    pub threshold: f64,
}

/// How much there is to do where along each axis.
#[derive(Clone, Debug)]
pub struct WorkProfile {
    /// Work per slice, axis by axis.
    slices: Vec<u64>,
}

impl Default for WorkProfile {
    fn default() -> Self {
        Self { slices: vec![0; 3 * SLICES] }
    }
}

impl WorkProfile {
    /// Adds work at a position (m), which may be a period off.
    #[inline]
    pub fn add(&mut self, global: &GlobalBox, position: [f64; 3], work: u64) {
        for (a, &x) in position.iter().enumerate() {
            let x = if global.periodic[a] { global.wrap_along(a, x) } else { x };
            let slice = ((x - global.lower[a]) / global.length(a) * SLICES as f64) as usize;
            self.slices[a * SLICES + slice.min(SLICES - 1)] += work;
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
        for &work in &self.slices[axis * SLICES..(axis + 1) * SLICES] {
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
        let (global, all) = (&self.global, below[SLICES]);
        let at = |cut: f64| {
            let place = ((cut - global.lower[axis]) / global.length(axis) * SLICES as f64).max(0.0);
            let slice = (place as usize).min(SLICES - 1);
            below[slice] + (place - slice as f64).min(1.0) * (below[slice + 1] - below[slice])
        };
        let mean = all / self.ranks[axis] as f64;
        let share = |cut: &[f64]| if all > 0.0 { (at(cut[1]) - at(cut[0])) / mean } else { 1.0 };
        cuts.windows(2).map(share).collect()
    }

    /// Borders that share the work better by a hundredth of its squares at least, with no subdomain thinner than `range` (m); none if
    /// no axis is worth it.
    pub fn rebalanced(&self, profile: &WorkProfile, range: f64, threshold: f64) -> Option<[Vec<f64>; 3]> {
        let mut cuts = self.cuts.clone();
        for (axis, moved) in cuts.iter_mut().enumerate() {
            if self.ranks[axis] == 1 || self.imbalance(axis, profile) <= threshold {
                continue;
            }
            self.move_cuts(axis, &profile.cumulative(axis), range, moved);
            // The busiest slab may have to wait until its neighbours have made room.
            let unevenness = |cuts: &[f64]| -> f64 {
                self.shares(axis, cuts, profile).into_iter().map(|share| share * share).sum()
            };
            if unevenness(moved) > 0.99 * unevenness(&self.cuts[axis]) {
                moved.clone_from(&self.cuts[axis]);
            }
        }
        (cuts != self.cuts).then_some(cuts)
    }

    /// Moves the inner borders across an axis towards the quantiles of the work below them.
    fn move_cuts(&self, axis: usize, below: &[f64], range: f64, moved: &mut [f64]) {
        let (old, ranks, global) = (&self.cuts[axis], self.ranks[axis], &self.global);
        for k in 1..ranks {
            let wanted = below[SLICES] * k as f64 / ranks as f64;
            let slice = below.partition_point(|&work| work < wanted).clamp(1, SLICES) - 1;
            let within = (wanted - below[slice]) / (below[slice + 1] - below[slice]);
            let quantile = global.lower[axis] + global.length(axis) * (slice as f64 + within) / SLICES as f64;
            // Rounding must not make a subdomain too thin.
            let (lattice, least) = (&global.lattice, range + 2.0 * global.lattice.spacing());
            let (low, high) = (old[k - 1].max(moved[k - 1]) + least, old[k + 1] - least);
            if low <= high {
                moved[k] = lattice.snap(quantile.clamp(low, high));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decomposition(ranks: [usize; 3]) -> Decomposition {
        let global = GlobalBox::new([0.0; 3], [8.0, 1.0, 1.0], [false; 3]);
        Decomposition::new(global, ranks, 0, 0.1).unwrap()
    }

    /// Work that falls off along x.
    fn profile(global: &GlobalBox) -> WorkProfile {
        let mut profile = WorkProfile::default();
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
        while let Some(cuts) = d.rebalanced(&profile, 0.1, 1.05) {
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
    fn no_subdomain_gets_thinner_than_the_range_and_even_work_moves_nothing() {
        let mut d = decomposition([4, 1, 1]);
        let mut profile = WorkProfile::default();
        (0..200).for_each(|k| profile.add(&d.global, [1e-3 * k as f64, 0.5, 0.5], 1));
        while let Some(cuts) = d.rebalanced(&profile, 0.1, 1.05) {
            d.cuts = cuts;
        }
        assert!(d.cuts[0].windows(2).all(|cut| cut[1] - cut[0] > 0.0999), "{:?}", d.cuts);
        // Half of the work is in the thinnest subdomain there may be.
        assert!((d.imbalance(0, &profile) - 2.0).abs() < 0.05, "{:?}", d.cuts);
        let d = decomposition([4, 1, 1]);
        profile.clear();
        (0..1000).for_each(|k| profile.add(&d.global, [8e-3 * k as f64, 0.5, 0.5], 1));
        assert_eq!(d.rebalanced(&profile, 0.1, 1.05), None);
    }
}
