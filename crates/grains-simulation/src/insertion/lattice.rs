//! The sites of a lattice that particles are placed on.

use crate::random::Draw;
use grains_case::lattice_sites;
use grains_domain::Decomposition;
use grains_geometry::Vec3;
use std::ops::Range;

/// Sites of a cubic lattice, numbered with x fastest, and how far particles may lie from them.
pub struct Sites {
    lower: [f64; 3],
    spacing: f64,
    /// Largest displacement along each axis over the spacing (-).
    noise: f64,
    /// Sites along x, and in a layer across z.
    counts: [u64; 2],
}

impl Sites {
    /// Sites between two corners (m) a spacing (m) apart; none if not a single one fits across z.
    pub fn new(lower: [f64; 3], upper: [f64; 3], spacing: f64, noise: f64) -> Option<Self> {
        let [nx, ny, _] = lattice_sites(lower, upper, spacing);
        (nx > 0 && ny > 0).then_some(Self { lower, spacing, noise, counts: [nx, nx * ny] })
    }

    /// Place of a particle on a site (m), its displacement drawn.
    pub fn position(&self, site: u64, draw: &mut Draw) -> Vec3 {
        let [row, layer] = self.counts;
        let place = [site % row, site % layer / row, site / layer];
        Vec3::from_fn(|a, _| {
            self.lower[a] + (place[a] as f64 + 0.5 + self.noise * (2.0 * draw.next() - 1.0)) * self.spacing
        })
    }

    /// Those of some sites whose particles may lie in the subdomain of a rank, ascending: all that do and few others.
    pub fn near(&self, decomposition: &Decomposition, sites: Range<u64>) -> impl Iterator<Item = u64> {
        let [row, layer] = self.counts;
        let layers = sites.start / layer..sites.end.div_ceil(layer);
        let [xs, ys, zs] = [(0, 0..row), (1, 0..layer / row), (2, layers)]
            .map(|(axis, places)| self.near_along(axis, decomposition, places));
        zs.into_iter()
            .flat_map(move |z| {
                let xs = xs.clone();
                ys.clone().into_iter().flat_map(move |y| xs.clone().into_iter().map(move |x| (x, y, z)))
            })
            .map(move |(x, y, z)| z * layer + y * row + x)
            .filter(move |site| sites.contains(site))
    }

    /// Places along an axis from which a particle may get into the subdomain, ascending.
    fn near_along(&self, axis: usize, decomposition: &Decomposition, places: Range<u64>) -> Vec<u64> {
        let global = &decomposition.global;
        let (mut lower, mut upper) = (decomposition.lower()[axis], decomposition.upper()[axis]);
        let is_periodic = global.periodic[axis];
        // Who owns the outermost subdomain owns what lies beyond.
        if !is_periodic && decomposition.coordinates[axis] == 0 {
            lower = f64::NEG_INFINITY;
        }
        if !is_periodic && decomposition.coordinates[axis] + 1 == decomposition.ranks[axis] {
            upper = f64::INFINITY;
        }
        let images: &[f64] = if is_periodic { &[-1.0, 0.0, 1.0] } else { &[0.0] };
        let mut near = Vec::new();
        for image in images {
            let place = |x: f64| (x + image * global.length(axis) - self.lower[axis]) / self.spacing - 0.5;
            // One more on either side against rounding.
            let first = (place(lower) - self.noise).floor() - 1.0;
            let end = (place(upper) + self.noise).ceil() + 2.0;
            let [first, end] = [first, end].map(|p| (p.max(0.0) as u64).clamp(places.start, places.end));
            near.extend(first..end);
        }
        near.sort_unstable();
        near.dedup();
        near
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use grains_domain::GlobalBox;

    #[test]
    fn every_particle_is_visited_by_its_owner_and_by_few_others() {
        for (periodic, noise) in [(false, 0.0), (false, 0.45), (true, 0.0), (true, 0.45)] {
            let global = GlobalBox::new([-1.0, 0.0, 0.0], [1.0, 1.0, 3.0], [periodic; 3]);
            let sites = Sites::new([-1.0, 0.1, 0.0], [1.0, 0.9, 3.0], 0.05, noise).unwrap();
            // A second batch that does not begin with a whole layer.
            let numbers = 700..33_333;
            let ranks = [3, 2, 4];
            let mut visits = 0;
            let mut owned = Vec::new();
            for rank in 0..24 {
                let own = Decomposition::new(global.clone(), ranks, rank, 0.1).unwrap();
                let near: Vec<u64> = sites.near(&own, numbers.clone()).collect();
                assert!(near.is_sorted());
                visits += near.len();
                let position = |site: u64| sites.position(site, &mut Draw::new(1, site, 3));
                owned
                    .extend(near.into_iter().filter(|&s| own.owner(global.wrap(position(s).into())) == rank));
            }
            owned.sort();
            assert!(owned.iter().copied().eq(numbers), "periodic {periodic}, noise {noise}");
            assert!(visits < 3 * owned.len(), "{visits} visits");
        }
    }
}
