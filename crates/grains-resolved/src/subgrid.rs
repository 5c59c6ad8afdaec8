//! The uniform cells of one rank: where velocities lie, and the ranks around.

use crate::SetupError;
use crate::cell_stencil::{Cells, Stencil};
use crate::point_stencil::PointStencil;
use grains_domain::Transport;
use grains_fluid::{FlowSetup, Layout};
use grains_geometry::Vec3;
use grains_geometry::lanes::{Number, Vector};
use std::ops::{Range, RangeInclusive};

/// What rounding may make of a place (cells): points on nodes have the same cell on any rank.
const ROUNDING: f64 = 1e-9;

/// Where the velocities of one rank lie, halo included, and which ranks lie around it.
#[derive(Clone, Debug)]
pub struct Subgrid {
    /// Extent of the arrays.
    pub layout: Layout,
    /// Widths of the cells (m).
    pub spacing: Vec3,
    /// Differences of place in the arrays to the neighbours of a velocity, along the axes on which the flow varies.
    neighbour_strides: Vec<isize>,
    /// Axes along which the flow varies.
    pub active: [bool; 3],
    /// Lower corner of own cell (0, 0, 0) (m).
    pub lower: Vec3,
    /// Upper corner of the last own cell (m).
    upper: Vec3,
    /// Places along each axis whose velocities mean something, for components along it and for others.
    valid: [[[isize; 2]; 2]; 3],
    /// Those of them that are unknown.
    unknown: [[[isize; 2]; 2]; 3],
    /// Whether this rank touches an end of the box that is not periodic.
    pub(crate) ends: [[bool; 2]; 3],
    /// Ranks below and above.
    pub(crate) neighbours: [[Option<usize>; 2]; 3],
    /// Begin and length (m) of the box along its periodic axes.
    pub(crate) periods: [Option<[f64; 2]>; 3],
    /// What brings a body into the frame of the rank below and above (m).
    pub(crate) shifts: [[f64; 2]; 3],
    rank: usize,
}

impl Subgrid {
    /// The cells of a rank.
    ///
    /// # Errors
    /// An axis whose cells differ in width.
    pub fn new(setup: &FlowSetup) -> Result<Self, SetupError> {
        let (grid, partition) = (&setup.grid, &setup.partition);
        if let Some(axis) = (0..3).find(|&a| !grid.axis(a).is_uniform()) {
            return Err(SetupError::NotUniform { axis: ['x', 'y', 'z'][axis] });
        }
        let layout = Layout { cells: partition.cells(), halo: setup.halo };
        let first = partition.first();
        let ends: [[bool; 2]; 3] =
            std::array::from_fn(|a| partition.touches(a).map(|t| t && !grid.axis(a).is_periodic()));
        let valid = |a: usize| {
            let (n, h) = (layout.cells[a] as isize, layout.halo as isize);
            [true, false].map(|is_normal| {
                let low = if ends[a][0] { -1 } else { -h };
                let high = match (ends[a][1], is_normal) {
                    (false, _) => n + h - 1,
                    (true, true) => n - 1,
                    (true, false) => n,
                };
                [low, high]
            })
        };
        let unknown = |a: usize| {
            let (n, h) = (layout.cells[a] as isize, layout.halo as isize);
            [true, false].map(|is_normal| {
                let low = if ends[a][0] { 0 } else { -h };
                let last = n - 1 - isize::from(is_normal);
                [low, if ends[a][1] { last } else { n + h - 1 }]
            })
        };
        let shifts = |a: usize| {
            let length = grid.axis(a).length();
            let wraps = partition.touches(a).map(|t| t && grid.axis(a).is_periodic());
            [if wraps[0] { length } else { 0.0 }, if wraps[1] { -length } else { 0.0 }]
        };
        let spacing = Vec3::from_fn(|a, _| grid.axis(a).width(0));
        Ok(Self {
            layout,
            spacing,
            neighbour_strides: (0..3)
                .filter(|&a| grid.is_active(a))
                .flat_map(|a| [-1, 1].map(|side| side * layout.strides()[a] as isize))
                .collect(),
            active: std::array::from_fn(|a| grid.is_active(a)),
            lower: Vec3::from_fn(|a, _| grid.axis(a).node(first[a] as isize)),
            upper: Vec3::from_fn(|a, _| grid.axis(a).node((first[a] + layout.cells[a]) as isize)),
            valid: std::array::from_fn(valid),
            unknown: std::array::from_fn(unknown),
            ends,
            neighbours: std::array::from_fn(|a| partition.neighbours(a, grid.axis(a).is_periodic())),
            periods: std::array::from_fn(|a| {
                grid.axis(a).is_periodic().then(|| [grid.axis(a).node(0), grid.axis(a).length()])
            }),
            shifts: std::array::from_fn(shifts),
            rank: partition.rank_at(partition.coordinates),
        })
    }

    /// Coordinate (m) along an axis of component `component` in cell `i` along it, own cells from 0.
    #[inline]
    pub fn coordinate(&self, component: usize, axis: usize, i: isize) -> f64 {
        let within = if axis == component { 1.0 } else { 0.5 };
        self.lower[axis] + (i as f64 + within) * self.spacing[axis]
    }

    /// Where a coordinate (m) along an axis lies among velocities along `component`: cells from the first own one (-).
    #[inline]
    fn cells_to(&self, component: usize, axis: usize, coordinate: f64) -> f64 {
        (coordinate - self.coordinate(component, axis, 0)) / self.spacing[axis]
    }

    /// Indices along an axis, halo included, of velocities along `component` between two coordinates (m).
    pub(crate) fn indices_between(
        &self,
        component: usize,
        axis: usize,
        ends: [f64; 2],
    ) -> RangeInclusive<isize> {
        let (h, n) = (self.layout.halo as isize, self.layout.cells[axis] as isize);
        if !self.active[axis] {
            return 0..=0;
        }
        let [low, high] = ends.map(|end| self.cells_to(component, axis, end));
        low.ceil().max(-h as f64) as isize..=high.floor().min((n + h - 1) as f64) as isize
    }

    /// Where the velocity along `component` at a place in the arrays lies (m).
    pub(crate) fn position(&self, component: usize, place: usize) -> Vec3 {
        let ([_, sy, sz], h) = (self.layout.strides(), self.layout.halo as isize);
        let at = [place % sy, place % sz / sy, place / sz];
        Vec3::from_fn(|a, _| self.coordinate(component, a, at[a] as isize - h))
    }

    /// Places next to one along the axes on which the flow varies.
    #[inline(always)]
    pub(crate) fn around(&self, place: usize) -> impl Iterator<Item = usize> {
        self.neighbour_strides.iter().map(move |stride| place.wrapping_add_signed(*stride))
    }

    /// How many places that are.
    pub(crate) fn neighbours_of_a_velocity(&self) -> usize {
        self.neighbour_strides.len()
    }

    /// Where the velocities along `component` lie, at places that for the most part follow one another along x.
    pub(crate) fn positions(&self, component: usize) -> Positions<'_> {
        Positions { subgrid: self, component, row: 0..0, first: Vec3::zeros(), left: 0 }
    }

    /// The axis along which nothing varies, of a flow in two dimensions.
    pub(crate) fn flat(&self) -> Option<usize> {
        (0..3).find(|&a| !self.active[a])
    }

    /// A point (m) at its place in the box, along the axes that are periodic.
    pub(crate) fn wrapped(&self, point: &Vec3) -> Vec3 {
        Vec3::from_fn(|a, _| match self.periods[a] {
            Some([begin, length]) => point[a] - ((point[a] - begin) / length).floor() * length,
            None => point[a],
        })
    }

    /// Distance (m) along x from a point in the box to where positions are wrapped.
    pub(crate) fn left_in_period(&self, point: &Vec3) -> f64 {
        self.periods[0].map_or(f64::INFINITY, |[begin, length]| begin + length - point.x)
    }

    /// Calls `visit` with the place and the centre (m) of own cells in ranges along the axes.
    pub(crate) fn for_each_cell(&self, [x, y, z]: [Range<usize>; 3], mut visit: impl FnMut(usize, Vec3)) {
        for k in z {
            for j in y.clone() {
                for i in x.clone() {
                    let at = |a: usize| self.lower[a] + ([i, j, k][a] as f64 + 0.5) * self.spacing[a];
                    visit(
                        self.layout.index(i as isize, j as isize, k as isize),
                        Vec3::new(at(0), at(1), at(2)),
                    );
                }
            }
        }
    }

    /// Volume (m³) of a cell.
    pub fn cell_volume(&self) -> f64 {
        self.spacing.product()
    }

    /// Diagonal (m) of a cell along the axes on which the flow varies: no two parallel planes between which a cell fits are further
    /// apart.
    pub(crate) fn diagonal(&self) -> f64 {
        (0..3).filter(|&a| self.active[a]).map(|a| self.spacing[a].powi(2)).sum::<f64>().sqrt()
    }

    /// Own faces per axis that carry an unknown velocity along `component`.
    pub(crate) fn unknowns(&self, component: usize) -> [usize; 3] {
        let mut n = self.layout.cells;
        n[component] -= usize::from(self.ends[component][1]);
        n
    }

    /// Whether an unknown velocity along `component` with these indices is this rank's own.
    pub(crate) fn is_own(&self, component: usize, index: [isize; 3]) -> bool {
        let own = self.unknowns(component);
        index.iter().zip(own).all(|(&m, n)| m >= 0 && m < n as isize)
    }

    /// Indices of a place in the arrays.
    pub(crate) fn indices(&self, place: usize) -> [isize; 3] {
        [0, 1, 2].map(|a| self.index_along(a, place))
    }

    /// Whether a place is that of an own cell or of one next to it.
    pub(crate) fn is_beside_own(&self, place: usize) -> bool {
        let cells = self.layout.cells;
        let at = self.indices(place);
        (0..3).all(|a| !self.active[a] || (-2..=cells[a] as isize).contains(&at[a]))
    }

    /// Index along an axis of a place in the arrays.
    pub(crate) fn index_along(&self, axis: usize, place: usize) -> isize {
        let h = self.layout.halo as isize;
        ((place / self.layout.strides()[axis]) % self.layout.dims()[axis]) as isize - h
    }

    /// Whether no boundary imposes the velocity normal to a face, halo included.
    pub(crate) fn is_unknown(&self, axis: usize, face: usize) -> bool {
        let [low, high] = self.unknown[axis][0];
        (low..=high).contains(&self.index_along(axis, face))
    }

    /// Place of the velocity of a component beside one along an axis, on a side (-1 or 1); none where a boundary imposes it.
    pub(crate) fn beside(&self, component: usize, place: usize, axis: usize, side: f64) -> Option<usize> {
        let [low, high] = self.unknown[axis][usize::from(axis != component)];
        let at = self.index_along(axis, place) + side as isize;
        let stride = self.layout.strides()[axis];
        (low..=high).contains(&at).then(|| if side > 0.0 { place + stride } else { place - stride })
    }

    /// Ends (m) between which bodies concern this rank alone.
    pub(crate) fn reach(&self, axis: usize) -> [f64; 2] {
        // The subdomain of the particles may end half a cell elsewhere.
        let margin = (self.layout.halo as f64 + 1.0) * self.spacing[axis];
        let high = self.lower[axis] + self.layout.cells[axis] as f64 * self.spacing[axis];
        [self.lower[axis] + margin, high - margin]
    }

    /// Whether a point (m) lies in the own cells.
    pub(crate) fn owns(&self, point: &Vec3) -> bool {
        (0..3).filter(|&a| self.active[a]).all(|a| point[a] >= self.lower[a] && point[a] < self.upper[a])
    }

    /// The cells of velocities about points (m), where all corners mean something.
    #[inline(always)]
    pub(crate) fn cells_about<T: Number>(&self, component: usize, points: &Vector<T>) -> Cells<T> {
        self.allowed_cells(component, points, &self.valid)
    }

    /// Places and weights of 3 x 3 x 3 velocities about a point (m): the cell about it, and on from there the way the
    /// normal points; parabolas along each axis. None if one of them is imposed by a boundary.
    pub(crate) fn outward_block(
        &self,
        component: usize,
        point: &Vec3,
        normal: &Vec3,
    ) -> Option<PointStencil> {
        let (mut lowest, mut weights) = ([0; 3], [[1.0, 0.0, 0.0]; 3]);
        for a in (0..3).filter(|&a| self.active[a]) {
            let place = self.cells_to(component, a, point[a]);
            let (floor, is_up) = (place.floor(), normal[a] >= 0.0);
            let (low, t) = if is_up { (floor, place - floor) } else { (floor - 1.0, floor + 1.0 - place) };
            let [first, last] = self.unknown[a][usize::from(a != component)];
            lowest[a] = low as isize;
            if lowest[a] < first || lowest[a] + 2 > last {
                return None;
            }
            weights[a] = [0.5 * (1.0 - t) * (2.0 - t), t * (2.0 - t), -0.5 * t * (1.0 - t)];
            if !is_up {
                weights[a].reverse();
            }
        }
        let [i, j, k] = lowest;
        Some(PointStencil::new(self.layout.index(i, j, k), weights))
    }

    /// Places and weights of the cell of velocities about a point (m); none if one of them is imposed by a boundary.
    pub(crate) fn block_about(&self, component: usize, point: &Vec3) -> Option<PointStencil> {
        let cell = self.allowed_cells(component, &Vector::<f64>::of(point), &self.unknown);
        let Stencil { base, fractions } = cell.stencil(0)?;
        let weights = fractions.map(|t| [1.0 - t, t, 0.0]);
        Some(PointStencil::new(base, weights))
    }

    /// The cells about points (m) whose corners are all allowed.
    #[inline(always)]
    fn allowed_cells<T: Number>(
        &self,
        component: usize,
        Vector(points): &Vector<T>,
        allowed: &[[[isize; 2]; 2]; 3],
    ) -> Cells<T> {
        let [zero, one] = [0.0, 1.0].map(T::of);
        let mut cells = Cells { base: zero, fractions: [zero; 3], is_there: one };
        let (strides, halo) = (self.layout.strides(), self.layout.halo as isize);
        for a in 0..3 {
            if !self.active[a] {
                cells.base = cells.base + T::of((halo as usize * strides[a]) as f64);
                continue;
            }
            let first = T::of(self.coordinate(component, a, 0));
            let place = (points[a] - first) / T::of(self.spacing[a]);
            let [low, high] = allowed[a][usize::from(a != component)];
            let from_first = place - T::of(low as f64 - ROUNDING);
            cells.is_there = from_first.if_above(zero, cells.is_there, zero);
            cells.is_there = T::of(high as f64 + ROUNDING).if_above(place, cells.is_there, zero);
            let last = T::of((high - 1 - low) as f64);
            let cell = last.if_above(from_first, from_first.whole(), last);
            let fraction = place - (cell + T::of(low as f64));
            // A corner that counts by rounding alone would be found to lie in a body on one rank and not on another.
            let fraction = fraction.if_above(T::of(1.0 - ROUNDING), one, fraction);
            cells.fractions[a] = fraction.if_above(T::of(ROUNDING), fraction, zero);
            cells.base = cells.base + (cell + T::of((low + halo) as f64)) * T::of(strides[a] as f64);
        }
        cells
    }

    /// Sends a message to the rank below (0) and above (1); returns what came from below and above; collective.
    pub(crate) fn pass(
        &self,
        axis: usize,
        messages: [Vec<f64>; 2],
        transport: &dyn Transport,
    ) -> [Vec<f64>; 2] {
        let neighbours = self.neighbours[axis];
        let [down, up] = messages;
        if neighbours.contains(&Some(self.rank)) {
            return [up, down];
        }
        let sides: Vec<usize> = (0..2).filter(|&s| neighbours[s].is_some()).collect();
        let peers: Vec<usize> = sides.iter().filter_map(|&s| neighbours[s]).collect();
        let mut messages = [Some(down), Some(up)];
        let sent: Vec<Vec<f64>> = sides.iter().filter_map(|&s| messages[s].take()).collect();
        let mut received = vec![Vec::new(); peers.len()];
        transport.exchange_unsized(&peers, &sent, &mut received);
        let mut arrived = [Vec::new(), Vec::new()];
        // One rank on both sides sends downwards first, which arrives from above.
        let is_one = peers.len() == 2 && peers[0] == peers[1];
        for (side, message) in sides.into_iter().zip(received) {
            arrived[if is_one { 1 - side } else { side }] = message;
        }
        arrived
    }
}

/// Where velocities of a component lie; the row of the last one is known.
pub(crate) struct Positions<'a> {
    subgrid: &'a Subgrid,
    component: usize,
    /// Places of the row, and where its first velocity lies (m).
    row: Range<usize>,
    first: Vec3,
    /// Rows after it in its plane.
    left: usize,
}

impl Positions<'_> {
    /// Where the velocity at a place in the arrays lies (m).
    #[inline(always)]
    pub fn at(&mut self, place: usize) -> Vec3 {
        if !self.row.contains(&place) {
            self.find_row(place);
        }
        let i = (place - self.row.start) as isize - self.subgrid.layout.halo as isize;
        Vec3::new(self.subgrid.coordinate(self.component, 0, i), self.first.y, self.first.z)
    }

    /// Takes the row of a place: for the most part it is the next one.
    fn find_row(&mut self, place: usize) {
        let [_, length, _] = self.subgrid.layout.strides();
        let next = self.row.end..self.row.end + length;
        if next.contains(&place) && self.left > 0 {
            (self.row, self.left) = (next, self.left - 1);
            let j = (self.subgrid.layout.cells[1] + self.subgrid.layout.halo - 1 - self.left) as isize;
            self.first.y = self.subgrid.coordinate(self.component, 1, j);
            return;
        }
        let (start, rows) = (place - place % length, self.subgrid.layout.dims()[1]);
        self.row = start..start + length;
        self.left = rows - 1 - start / length % rows;
        self.first = self.subgrid.position(self.component, start);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Random;
    use grains_fluid::Grid;

    /// However rounding shifts a point on a velocity, that velocity alone has weight.
    #[test]
    fn points_on_velocities_have_the_weight_of_these_alone() {
        let mut random = Random(11);
        for k in 0..2000 {
            let upper = [0, 1, 2].map(|_| 0.01 + random.next());
            let grid = Grid::uniform([0.0; 3], upper, [9, 7, 8], [true; 3]).unwrap();
            let subgrid = Subgrid::new(&FlowSetup { halo: 3, ..FlowSetup::new(grid, 1.0, 1.0) }).unwrap();
            let at = [9, 7, 8].map(|n| (random.next() * n as f64) as isize);
            let (component, [i, j, l]) = (k % 3, at);
            let place = subgrid.layout.index(i, j, l);
            let shift = Vec3::from_fn(|a, _| 1e-12 * (random.next() - 0.5) * subgrid.spacing[a]);
            let point = subgrid.position(component, place) + shift;
            let cell = subgrid.cells_about(component, &Vector::<f64>::of(&point)).stencil(0).unwrap();
            let corners: Vec<(usize, f64)> = cell.corners(subgrid.layout.strides()).collect();
            assert_eq!(corners, [(place, 1.0)], "{point:?}");
        }
    }
}
