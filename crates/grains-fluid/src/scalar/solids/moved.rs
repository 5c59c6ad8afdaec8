//! Cells that come into solids and leave them as these move.

use super::super::Scalars;
use super::super::advance::own_cells;
use super::barrier::Barrier;
use super::build::{SolidCellsBuilder, SurfacePoint};
use super::cells::{BEYOND, SolidCells};
use super::step::middle;
use crate::metrics::Local;
use crate::{Enclosure, Field, Flow, Grid};
use grains_domain::Transport;
use std::collections::BTreeMap;

/// Weight of the value of a surface alone for a cell that a solid has left, beside those with a neighbour in the fluid (-).
const UNKNOWN: f64 = 1e-6;

impl Flow {
    /// Whether scalars need the shares of cells and faces that bodies, or walls, take.
    pub fn scalars_need_shares(&self, is_body: bool) -> bool {
        let all = self.scalars.iter().flat_map(|scalars| &scalars.all);
        all.into_iter().any(|scalar| scalar.setup.solids.need_shares(is_body))
    }

    /// Tells the scalars where solids lie for the coming step, to be followed by [`Flow::pass_solids`]; `of_solids` has the value of each
    /// solid for each scalar.
    pub fn place_solids(&mut self, builder: SolidCellsBuilder, of_solids: Vec<Vec<f64>>) {
        let Some(scalars) = &mut self.scalars else { return };
        let mut cells = builder.finish(&self.local);
        for (scalar, of_solids) in scalars.all.iter_mut().zip(of_solids) {
            scalar.of_solids = of_solids;
            scalar.gained = vec![0.0; cells.count];
            scalar.reacted = vec![0.0; cells.count];
            scalar.gained_over = 0.0;
            // Not two at a time.
            scalar.barrier = None;
            scalar.barrier = Some(Barrier::new(&cells, &scalar.setup, &self.local));
        }
        cells.forget_cuts();
        scalars.solids = Some(cells);
    }

    /// Takes what solids have covered since the last step out of the fluid; collective.
    ///
    /// A cell that they have left gets the value between the surface and the next one in the fluid.
    pub fn pass_solids(&mut self, transport: &dyn Transport) {
        let Some(scalars) = &mut self.scalars else { return };
        for number in 0..scalars.all.len() {
            scalars.pass_solids(number, (&self.setup.grid, &self.local), self.state.time);
        }
        scalars.all.iter_mut().for_each(|scalar| scalar.fill(&mut self.halo, transport));
    }
}

impl Flow {
    /// Whether a scalar meets walls of an averaged flow that let something through: what is open of these is fluid like all else.
    fn scalars_meet_walls(&self) -> bool {
        let all = self.scalars.iter().flat_map(|scalars| &scalars.all);
        all.into_iter().any(|scalar| scalar.setup.solids.walls.iter().any(|wall| !wall.is_insulated()))
    }

    /// Tells the scalars of an averaged flow where its walls stand; collective.
    pub(crate) fn place_enclosure(&mut self, walls: &dyn Enclosure, transport: &dyn Transport) {
        if !self.scalars_meet_walls() {
            return;
        }
        let (grid, local) = (&self.setup.grid, &self.local);
        let all = self.scalars.iter().flat_map(|scalars| &scalars.all);
        let count = all.map(|scalar| scalar.setup.solids.walls.len()).max().unwrap_or(0);
        let mut builder = SolidCellsBuilder::new(local.layout.len(), [0, count], true).averaged();
        let near = NEAR * (0..3).filter(|&a| local.active[a]).map(|a| widest(local, a)).fold(0.0, f64::max);
        for place in 0..local.layout.len() {
            let found = walls.clearance(middle(grid, local, place));
            let (solid, distance) = (found.wall as u32, found.distance);
            if distance.abs() < near {
                builder.note(SurfacePoint { place, solid, distance, normal: found.direction });
            }
            if distance <= 0.0 {
                builder.hold(place, solid);
            }
        }
        let of_solids = self.scalars.iter().flat_map(|scalars| &scalars.all).map(|_| Vec::new()).collect();
        self.place_solids(builder, of_solids);
        self.pass_solids(transport);
    }
}

/// Distance (widths of a cell) up to which a middle tells of a surface.
const NEAR: f64 = 2.0;

/// Widest cell (m) along an axis.
fn widest(local: &Local, axis: usize) -> f64 {
    local.axes[axis].width.iter().copied().fold(0.0, f64::max)
}

impl Scalars {
    /// The values of a scalar where cells have changed sides since the last step, at a time (s).
    fn pass_solids(&mut self, number: usize, (grid, local): (&Grid, &Local), time: f64) {
        let (scalar, volume) = (&mut self.all[number], &self.volume);
        let (Some(cells), Some(barrier)) = (&self.solids, &mut scalar.barrier) else { return };
        if let Some(old) = &scalar.free {
            let mut on_surfaces = scalar.value.clone();
            let of = (&scalar.setup, cells);
            barrier.evaluate(of, &scalar.of_solids, (grid, local), time, &mut on_surfaces);
            let was_free = |place: usize| old.data()[place] > 0.0;
            let left = left_cells(was_free, barrier, cells, scalar.value.data(), local.layout.strides());
            let (value, previous) = (scalar.value.data_mut(), scalar.previous.data_mut());
            own_cells(local.layout).for_each(|place| match (was_free(place), barrier.is_free(place)) {
                (true, false) => {
                    scalar.entered -= volume[place] * value[place];
                    let solid = cells.holder[place].wrapping_sub(1) as usize;
                    if let Some(gained) = scalar.gained.get_mut(solid) {
                        *gained -= volume[place] * (value[place] - on_surfaces.data()[place]);
                    }
                }
                (false, true) => {
                    if let Some(left) = left.get(&place) {
                        value[place] = left.sum / left.weight;
                        scalar.gained[left.solid] += volume[place] * (value[place] - left.surface);
                    }
                    previous[place] = value[place];
                    scalar.entered += volume[place] * value[place];
                }
                _ => {}
            });
        }
        let free = scalar.free.get_or_insert_with(|| Field::new(local.layout));
        free.data_mut().iter_mut().enumerate().for_each(|(place, free)| {
            *free = f64::from(u8::from(barrier.is_free(place)));
        });
    }
}

/// A cell that a solid has left.
struct Left {
    sum: f64,
    weight: f64,
    solid: usize,
    surface: f64,
}

/// The cells that solids have left, with values between those of the surface and of the next cells in the fluid.
fn left_cells(
    was_free: impl Fn(usize) -> bool,
    new: &Barrier,
    cells: &SolidCells,
    value: &[f64],
    strides: [usize; 3],
) -> BTreeMap<usize, Left> {
    let mut left = BTreeMap::new();
    for (axis, ties) in new.ties.iter().enumerate() {
        for tie in ties.iter().filter(|tie| !was_free(tie.free)) {
            let next = if tie.side > 0.0 { tie.free - strides[axis] } else { tie.free + strides[axis] };
            let Some(surface) = tie.value else { continue };
            let is_known = was_free(next) && new.is_free(next) && cells.holder[next] != BEYOND;
            let (weight, rise) = match is_known {
                true => (1.0, (value[next] - surface) * tie.way / (1.0 + tie.way)),
                false => (UNKNOWN, 0.0),
            };
            let start = Left { sum: 0.0, weight: 0.0, solid: tie.solid as usize, surface };
            let of_cell = left.entry(tie.free).or_insert(start);
            of_cell.sum += weight * (surface + rise);
            of_cell.weight += weight;
        }
    }
    left
}
