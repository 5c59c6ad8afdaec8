//! Particles sorted by cell.

use super::list_context::ListContext;
use super::references::{Reference, STRAY_SHARE, nominal_allowance};
use crate::memory_use::heap_bytes;
use crate::particles::{Body, Particles};
use grains_domain::{Cells, SIZE_CLASSES, size_class};
use std::ops::Range;

/// Cutoff (m) per size class: how far from its centre a particle among `stays` may act before the lists are rebuilt, at
/// most, and while it strays beyond a border; and the number of particles of each class.
pub(crate) fn cutoffs(
    particles: &Particles,
    stays: &[u32],
    context: &ListContext,
) -> ([f64; SIZE_CLASSES], [usize; SIZE_CLASSES]) {
    let (mut cutoffs, mut counts) = ([0.0; SIZE_CLASSES], [0; SIZE_CLASSES]);
    for &i in stays {
        let body = &particles.bodies[i as usize];
        let class = size_class(body.radius, context.largest_radius);
        let allowance = nominal_allowance(body, context);
        let beyond = if context.is_apart { (STRAY_SHARE * allowance).max(context.stray) } else { 0.0 };
        let cutoff = body.radius + allowance + beyond + 0.5 * context.gap();
        cutoffs[class] = f64::max(cutoffs[class], cutoff);
        counts[class] += 1;
    }
    (cutoffs, counts)
}

/// The owned particles by cell.
#[derive(Debug, Default)]
pub(crate) struct CellList {
    pub(super) cells: Cells,
    /// The first of every cell.
    pub(super) start: Vec<u32>,
}

impl CellList {
    /// Memory (B).
    pub(crate) fn bytes(&self) -> usize {
        heap_bytes(&self.start)
    }
}

/// The particles in `stays` sorted by cell, and what places they had before.
pub(crate) fn sort(particles: &Particles, stays: &[u32], cells: Cells) -> (CellList, Vec<u32>) {
    let cell_of = |&i: &u32| {
        let body = &particles.bodies[i as usize];
        let grid = &cells.grids()[cells.grid_of(body.radius)];
        grid.index(grid.own_place(body.position.into())) as u32
    };
    let (start, mut order) = bin(&stays.iter().map(cell_of).collect::<Vec<_>>(), cells.len());
    order.iter_mut().for_each(|slot| *slot = stays[*slot as usize]);
    (CellList { cells, start }, order)
}

/// The clones by cell.
#[derive(Default)]
pub(super) struct Clones {
    pub(super) order: Vec<u32>,
    /// The first of every cell in `order`.
    pub(super) start: Vec<u32>,
}

impl Clones {
    /// Bins the clones by their references.
    pub(super) fn new(particles: &Particles, references: &[Reference], cells: &Cells) -> Self {
        let cell_of = |(body, reference): (&Body, &Reference)| {
            let grid = &cells.grids()[cells.grid_of(body.radius)];
            grid.index(grid.place(reference.position.into())) as u32
        };
        let clones = particles.owned..;
        let clones = particles.bodies[clones.clone()].iter().zip(&references[clones]).map(cell_of);
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
