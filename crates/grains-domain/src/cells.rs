//! The linked cells of one subdomain: a grid for every class of sizes, with layers around it for clones (thesis fig. 5.1).
//!
//! One grid as wide as the largest particle makes small ones many to a cell, and every search long. So a radius is of
//! class k if it is R 2⁻ᵏ or less, but more than half of that, R being the largest; a class has cells as wide as what its
//! own particles, and smaller ones, may need. Particles of a class look for each other in its own grid, half the
//! directions each, and smaller ones look for larger ones in the grids of these, never the other way round. Of particles
//! of about one size there is one class, and that is all there is to it.

use crate::Decomposition;
use std::ops::Range;

/// Number of classes; the last also takes all that is smaller.
pub const SIZE_CLASSES: usize = 16;

/// Class of a radius in a system whose largest radius is `largest` (both m).
#[inline]
pub fn size_class(radius: f64, largest: f64) -> usize {
    // The binary exponent of a ratio is the number of its halvings.
    let exponent = ((largest / radius).to_bits() >> 52) as usize;
    exponent.saturating_sub(1023).min(SIZE_CLASSES - 1)
}

/// The cells of one class: the subdomain's own and layers around them.
#[derive(Clone, Debug)]
pub struct CellGrid {
    /// Cells per axis, clone layers included.
    pub counts: [usize; 3],
    /// Clone layers on either side per axis.
    pub layers: [usize; 3],
    /// Number of the first cell among those of all grids.
    first: usize,
    lower: [f64; 3],
    inverse_width: [f64; 3],
}

impl CellGrid {
    /// Grid over a subdomain of cells at least `width` (m) wide, about `max_cells` at most; clones lie up to `beyond` (m)
    /// outside.
    fn new(decomposition: &Decomposition, first: usize, width: f64, beyond: f64, max_cells: usize) -> Self {
        let (lower, upper) = (decomposition.lower(), decomposition.upper());
        let fitting = |width: f64| {
            std::array::from_fn::<usize, 3, _>(|a| (((upper[a] - lower[a]) / width) as usize).max(1))
        };
        let (mut own, mut wide) = (fitting(width), width);
        // An axis that is down to one cell yields no more: the others must.
        loop {
            let excess = own.iter().map(|&n| n as f64).product::<f64>() / max_cells as f64;
            let divided = own.iter().filter(|&&n| n > 1).count();
            if excess <= 1.0 || divided == 0 {
                break;
            }
            // At least a hundredth wider, so that rounding to whole cells cannot stop it.
            wide *= libm::pow(excess, 1.0 / divided as f64).max(1.01);
            own = fitting(wide);
        }
        let inverse_width: [f64; 3] = std::array::from_fn(|a| own[a] as f64 / (upper[a] - lower[a]));
        let layers = std::array::from_fn(|a| {
            // Where no neighbour is, there are no clones: one layer spares the search a border.
            let is_shared = decomposition.ranks[a] > 1 || decomposition.global.periodic[a];
            if is_shared { ((beyond * inverse_width[a]).ceil() as usize).max(1) } else { 1 }
        });
        Self { counts: std::array::from_fn(|a| own[a] + 2 * layers[a]), layers, first, lower, inverse_width }
    }

    /// Numbers of its cells among those of all grids.
    pub fn cells(&self) -> Range<usize> {
        self.first..self.first + self.counts.iter().product::<usize>()
    }

    /// Per-axis place of a position; positions outside go to the nearest cell.
    #[inline]
    pub fn place(&self, position: [f64; 3]) -> [usize; 3] {
        std::array::from_fn(|a| {
            let at = ((position[a] - self.lower[a]) * self.inverse_width[a]).floor() + self.layers[a] as f64;
            at.clamp(0.0, (self.counts[a] - 1) as f64) as usize
        })
    }

    /// Place of a particle owned by this subdomain: never a clone cell, however the border rounds.
    #[inline]
    pub fn own_place(&self, position: [f64; 3]) -> [usize; 3] {
        let place = self.place(position);
        std::array::from_fn(|a| place[a].clamp(self.layers[a], self.counts[a] - self.layers[a] - 1))
    }

    /// Number of a cell among those of all grids, x fastest.
    #[inline]
    pub fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        self.first + (z * self.counts[1] + y) * self.counts[0] + x
    }

    /// Whether a cell has clone cells around it, or is one.
    #[inline]
    pub fn is_near_border(&self, place: [usize; 3]) -> bool {
        (0..3).any(|a| place[a] <= self.layers[a] || place[a] + 1 >= self.counts[a] - self.layers[a])
    }

    /// The cells around a place and itself, in runs of consecutive numbers.
    #[inline]
    pub fn around(&self, [x, y, z]: [usize; 3]) -> impl Iterator<Item = Range<usize>> + use<'_> {
        let span = |at: usize, a: usize| at.saturating_sub(1)..(at + 2).min(self.counts[a]);
        span(z, 2).flat_map(move |z| {
            span(y, 1).map(move |y| {
                let row = self.index([0, y, z]);
                row + span(x, 0).start..row + span(x, 0).end
            })
        })
    }

    /// Half of the cells around an own place, in runs; the particle's own cell comes first and begins its run.
    #[inline]
    pub fn half_around(&self, [x, y, z]: [usize; 3]) -> [Range<usize>; 5] {
        let own = self.index([x, y, z]);
        let run = |row: usize| row - 1..row + 2;
        let (row, slab) = (self.counts[0], self.counts[0] * self.counts[1]);
        [own..own + 2, run(own + row), run(own + slab - row), run(own + slab), run(own + slab + row)]
    }
}

/// The grids of the classes that occur, larger particles first.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    grids: Vec<CellGrid>,
    /// Grid of every class.
    grid_of: [usize; SIZE_CLASSES],
    largest: f64,
}

impl Cells {
    /// Grids for particles up to a radius `largest` (m).
    ///
    /// `cutoffs` (m) holds per class how far from its centre a particle, wherever it is, may touch until the next sorting,
    /// 0 if there is none of the class; `counts` holds how many of each class this rank owns.
    pub fn new(
        decomposition: &Decomposition,
        largest: f64,
        cutoffs: &[f64; SIZE_CLASSES],
        counts: &[usize; SIZE_CLASSES],
    ) -> Self {
        let mut cells = Self { grids: Vec::new(), grid_of: [0; SIZE_CLASSES], largest };
        let of_all = cutoffs.iter().fold(0.0, |w: f64, &x| w.max(x));
        let mut first = 0;
        for class in (0..SIZE_CLASSES).filter(|&class| cutoffs[class] > 0.0) {
            let width = 2.0 * cutoffs[class..].iter().fold(0.0, |w: f64, &x| w.max(x));
            let max_cells = CELLS_PER_PARTICLE * counts[class] + FEW_CELLS;
            let grid = CellGrid::new(decomposition, first, width, cutoffs[class] + of_all, max_cells);
            first = grid.cells().end;
            assert!(first < u32::MAX as usize, "cells have numbers of 32 bits: use more ranks");
            cells.grid_of[class] = cells.grids.len();
            cells.grids.push(grid);
        }
        cells
    }

    /// All grids, those of larger particles first.
    pub fn grids(&self) -> &[CellGrid] {
        &self.grids
    }

    /// Place in [`Cells::grids`] of the grid for particles of a radius (m).
    #[inline]
    pub fn grid_of(&self, radius: f64) -> usize {
        self.grid_of[size_class(radius, self.largest)]
    }

    /// Number of the cells of all grids.
    pub fn len(&self) -> usize {
        self.grids.last().map_or(0, |grid| grid.cells().end)
    }

    /// Whether there is no cell, as there is no particle on any rank.
    pub fn is_empty(&self) -> bool {
        self.grids.is_empty()
    }
}

/// Where particles are few, wider cells are cheaper than many empty ones.
const CELLS_PER_PARTICLE: usize = 8;
const FEW_CELLS: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GlobalBox;

    fn decomposition() -> Decomposition {
        let global = GlobalBox::new([0.0; 3], [2.0, 1.0, 1.0], [false; 3]);
        Decomposition::new(global, [2, 1, 1], 0, 0.1).unwrap()
    }

    fn per_class<T: Default + Copy>(values: &[(usize, T)]) -> [T; SIZE_CLASSES] {
        let mut all = [T::default(); SIZE_CLASSES];
        values.iter().for_each(|&(class, value)| all[class] = value);
        all
    }

    #[test]
    fn a_class_is_a_factor_of_two() {
        let class = |radius| size_class(radius, 1.0);
        assert_eq!([1.0, 0.51, 0.5, 0.26, 0.25, 0.01].map(class), [0, 0, 1, 1, 2, 6]);
        assert_eq!([1.0000001, 1e-9].map(class), [0, SIZE_CLASSES - 1]);
    }

    #[test]
    fn cells_are_wide_enough_for_their_class_and_smaller_ones_and_clones_fit_in_their_layers() {
        let (cutoffs, counts) =
            (per_class(&[(0, 0.05), (3, 0.004)]), per_class(&[(0, 1000), (3, 1_000_000)]));
        let cells = Cells::new(&decomposition(), 0.04, &cutoffs, &counts);
        let [coarse, fine] = cells.grids() else { panic!("{} grids", cells.grids().len()) };
        assert_eq!((cells.grid_of(0.03), cells.grid_of(0.004)), (0, 1));
        assert_eq!((coarse.layers, coarse.counts), ([1; 3], [12; 3]));
        // Small clones matter as far out as a large particle inside could reach them.
        assert_eq!((fine.layers, fine.counts), ([7, 1, 1], [139, 127, 127]));
        assert_eq!((coarse.cells().end, cells.len()), (fine.cells().start, fine.cells().end));
        assert!(!fine.is_near_border(fine.place([0.5; 3])) && fine.is_near_border(fine.place([0.999; 3])));
        assert_eq!(fine.place([1.053, 0.5, 0.5])[0], 138);
    }

    #[test]
    fn few_particles_get_few_cells() {
        let (cutoffs, counts) = (per_class(&[(0, 0.01)]), per_class(&[(0, 10)]));
        let cells = Cells::new(&decomposition(), 0.01, &cutoffs, &counts);
        let own: usize = cells.grids()[0].counts.iter().map(|n| n - 2).product();
        assert!((100..=144).contains(&own), "{own}");
    }

    #[test]
    fn few_particles_get_few_cells_in_boxes_of_any_proportion() {
        for extents in [[1e6, 1.0, 1.0], [1.0, 1e9, 1.0], [3.0, 1e5, 1e7], [1e4, 1e4, 1e4], [0.5, 0.5, 0.5]] {
            let global = GlobalBox::new([0.0; 3], extents, [false; 3]);
            let decomposition = Decomposition::new(global, [1; 3], 0, 0.1).unwrap();
            let (cutoffs, counts) = (per_class(&[(0, 0.05)]), per_class(&[(0, 10)]));
            let cells = Cells::new(&decomposition, 0.05, &cutoffs, &counts);
            let own: usize = cells.grids()[0].counts.iter().map(|n| n - 2).product();
            assert!(own <= CELLS_PER_PARTICLE * 10 + FEW_CELLS, "{extents:?}: {own}");
        }
    }

    #[test]
    fn two_halves_and_the_own_cell_make_the_cells_around() {
        let (cutoffs, counts) = (per_class(&[(0, 0.05)]), per_class(&[(0, 1000)]));
        let cells = Cells::new(&decomposition(), 0.05, &cutoffs, &counts);
        let grid = &cells.grids()[0];
        let around = |place| grid.around(place).flatten().collect::<Vec<_>>();
        let place = [4, 5, 6];
        let mut all = around(place);
        assert_eq!(all.len(), 27);
        for cell in all.clone() {
            let half = |p| grid.half_around(p).into_iter().flatten().any(|c| c == cell);
            let own = grid.index(place);
            let met = [half(place), cell != own && around(place).contains(&cell) && !half(place)];
            assert_eq!(met.iter().filter(|&&m| m).count(), 1, "cell {cell}");
        }
        all = around([0; 3]);
        assert_eq!(all.len(), 8);
    }
}
