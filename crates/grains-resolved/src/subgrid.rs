//! The uniform cells of one rank: where velocities lie, and the ranks around.

use crate::SetupError;
use crate::point_stencil::PointStencil;
use crate::solid_mask::Holders;
use grains_domain::Transport;
use grains_fluid::{FlowSetup, Layout};
use grains_geometry::Vec3;
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

    /// Corner and weights of the cell of velocities about a point (m); none if one of them means nothing.
    #[inline(always)]
    pub(crate) fn stencil(&self, component: usize, point: &Vec3) -> Option<Stencil> {
        self.cell_about(component, point, &self.valid)
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
        Some(PointStencil { first: self.layout.index(i, j, k) as u32, weights })
    }

    /// Places and weights of the cell of velocities about a point (m); none if one of them is imposed by a boundary.
    pub(crate) fn block_about(&self, component: usize, point: &Vec3) -> Option<PointStencil> {
        let Stencil { base, fractions } = self.cell_about(component, point, &self.unknown)?;
        let weights = fractions.map(|t| [1.0 - t, t, 0.0]);
        Some(PointStencil { first: base as u32, weights })
    }

    #[inline(always)]
    fn cell_about(&self, component: usize, point: &Vec3, allowed: &[[[isize; 2]; 2]; 3]) -> Option<Stencil> {
        let (mut base, mut fractions) = (0, [0.0; 3]);
        let (strides, halo) = (self.layout.strides(), self.layout.halo as isize);
        for a in 0..3 {
            if !self.active[a] {
                base += halo as usize * strides[a];
                continue;
            }
            let place = self.cells_to(component, a, point[a]);
            let [low, high] = allowed[a][usize::from(a != component)];
            // In cells from the first; those that are not negative are rounded down as they become whole numbers.
            let from_first = place - low as f64 + ROUNDING;
            if !(from_first > 0.0 && place < high as f64 + ROUNDING) {
                return None;
            }
            let cell = low + (from_first as isize).min(high - 1 - low);
            base += (cell + halo) as usize * strides[a];
            let fraction = (place - cell as f64).clamp(0.0, 1.0);
            // A corner that counts by rounding alone would be found to lie in a body on one rank and not on another.
            fractions[a] =
                if (fraction - fraction.round()).abs() < ROUNDING { fraction.round() } else { fraction };
        }
        Some(Stencil { base, fractions })
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
    #[inline]
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

/// Weights of the corners of a cell of velocities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stencil {
    /// Place in the arrays of the lowest corner.
    pub base: usize,
    /// Place of the point between the lower and the upper corners (-).
    pub fractions: [f64; 3],
}

impl Stencil {
    /// Places and weights of the corners that count.
    #[inline]
    pub fn corners(&self, strides: [usize; 3]) -> impl Iterator<Item = (usize, f64)> + '_ {
        (0..8).filter_map(move |corner| {
            let (mut place, mut weight) = (self.base, 1.0);
            for (a, (stride, fraction)) in strides.iter().zip(self.fractions).enumerate() {
                if corner >> a & 1 == 1 {
                    place += stride;
                    weight *= fraction;
                } else {
                    weight *= 1.0 - fraction;
                }
            }
            (weight != 0.0).then_some((place, weight))
        })
    }

    /// Multilinear interpolation of the values at the corners.
    #[inline]
    pub fn mean(&self, strides: [usize; 3], values: &[f64]) -> f64 {
        self.between(self.rows(strides).map(|row| [values[row], values[row + 1]]))
    }

    /// Weight of the corners that are held (-).
    #[inline(always)]
    pub fn hidden(&self, strides: [usize; 3], holders: Holders) -> f64 {
        let [a, b, c, d] = self.rows(strides);
        // Maps of arrays would be calls of their own.
        let on = |row: usize| holders.mask.contains_edge(row);
        let solid = [on(a), on(b), on(c), on(d)];
        match solid.as_flattened().contains(&true) {
            true => self.between(solid.map(|row| row.map(|is_solid| f64::from(u8::from(is_solid))))),
            false => 0.0,
        }
    }

    /// Lower corners of the four edges along x.
    #[inline]
    fn rows(&self, [_, sy, sz]: [usize; 3]) -> [usize; 4] {
        [0, sy, sz, sy + sz].map(|offset| self.base + offset)
    }

    /// Multilinear interpolation of values on the four edges along x.
    #[inline]
    fn between(&self, edges: [[f64; 2]; 4]) -> f64 {
        let [x, y, z] = self.fractions;
        let between = |[low, high]: [f64; 2], t: f64| low + t * (high - low);
        let [a, b, c, d] = edges.map(|edge| between(edge, x));
        between([between([a, b], y), between([c, d], y)], z)
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
            let corners: Vec<(usize, f64)> =
                subgrid.stencil(component, &point).unwrap().corners(subgrid.layout.strides()).collect();
            assert_eq!(corners, [(place, 1.0)], "{point:?}");
        }
    }
}
