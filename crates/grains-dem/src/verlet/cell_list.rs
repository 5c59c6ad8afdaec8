//! Particles sorted by cell.

use super::allowances::nominal_allowance;
use super::list_context::ListContext;
use crate::particles::{Body, Particles};
use grains_domain::{Cells, SIZE_CLASSES, size_class};
use std::ops::Range;

/// Cutoff (m) per size class: how far from its centre a particle among `stays` may act before the lists are rebuilt, at
/// most; and the number of particles of each class.
pub(crate) fn cutoffs(
    particles: &Particles,
    stays: &[u32],
    context: &ListContext,
) -> ([f64; SIZE_CLASSES], [usize; SIZE_CLASSES]) {
    let (mut cutoffs, mut counts) = ([0.0; SIZE_CLASSES], [0; SIZE_CLASSES]);
    for &i in stays {
        let body = &particles.bodies[i as usize];
        let class = size_class(body.radius, context.largest_radius);
        cutoffs[class] =
            f64::max(cutoffs[class], body.radius + nominal_allowance(body, context) + 0.5 * context.gap());
        counts[class] += 1;
    }
    (cutoffs, counts)
}

/// The owned particles sorted by cell.
pub(crate) struct CellList {
    /// What places they had before.
    pub(crate) order: Vec<u32>,
    pub(super) cells: Cells,
    /// The first of every cell.
    pub(super) start: Vec<u32>,
}

impl CellList {
    /// Sorts the particles in `stays`.
    pub(crate) fn new(particles: &Particles, stays: &[u32], cells: Cells) -> Self {
        let cell_of = |&i: &u32| {
            let body = &particles.bodies[i as usize];
            let grid = &cells.grids()[cells.grid_of(body.radius)];
            grid.index(grid.own_place(body.position.into())) as u32
        };
        let (start, mut order) = bin(&stays.iter().map(cell_of).collect::<Vec<_>>(), cells.len());
        order.iter_mut().for_each(|slot| *slot = stays[*slot as usize]);
        Self { order, cells, start }
    }
}

/// The clones by cell.
#[derive(Default)]
pub(super) struct Clones {
    pub(super) order: Vec<u32>,
    /// The first of every cell in `order`.
    pub(super) start: Vec<u32>,
}

impl Clones {
    pub(super) fn new(particles: &Particles, cells: &Cells) -> Self {
        let cell_of = |body: &Body| {
            let grid = &cells.grids()[cells.grid_of(body.radius)];
            grid.index(grid.place(body.position.into())) as u32
        };
        let clones = particles.bodies[particles.owned..].iter().map(cell_of);
        let (start, mut order) = bin(&clones.collect::<Vec<_>>(), cells.len());
        order.iter_mut().for_each(|slot| *slot += particles.owned as u32);
        Self { order, start }
    }
}

/// The slots of a run of cells.
pub(super) fn held(start: &[u32], cells: &Range<usize>) -> Range<usize> {
    start[cells.start] as usize..start[cells.end] as usize
}

/// Counting sort: the first item of every cell, and the items cell by cell.
fn bin(cells: &[u32], count: usize) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0; count + 1];
    for &c in cells {
        start[c as usize + 1] += 1;
    }
    for c in 0..count {
        start[c + 1] += start[c];
    }
    let mut order = vec![0; cells.len()];
    for (item, &c) in cells.iter().enumerate() {
        let at = &mut start[c as usize];
        order[*at as usize] = item as u32;
        *at += 1;
    }
    start.rotate_right(1);
    start[0] = 0;
    (start, order)
}
