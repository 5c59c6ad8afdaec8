//! Grids of the multigrid hierarchy: numbering of the cells, the stencil's pattern and its geometry.

use crate::axis::Axis;

/// Largest number of cells of the coarsest grid, which every rank solves by itself.
const COARSEST: usize = 64;
/// An axis is coarsened with the others if its cells are not wider than this times the thinnest.
const ISOTROPIC: f64 = 1.5;
/// Slots of the stencil: neighbours below in z, y, x, the cell, neighbours above in x, y, z.
pub(crate) const CENTRE: usize = 3;
/// Slots of the neighbours below and above along each axis.
pub(crate) const SLOTS: [[usize; 2]; 3] = [[2, 4], [1, 5], [0, 6]];

/// Positions of the slots in a row with all neighbours, in this order.
const NATURAL: [Option<u8>; 7] = [Some(0), Some(1), Some(2), Some(3), Some(4), Some(5), Some(6)];

/// Cells of one grid, seen from one rank.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// The axes x, y, z.
    pub axes: [Axis; 3],
    /// Place of the own rank along each.
    pub place: [usize; 3],
}

/// Where in its row of the matrix each neighbour of a cell has its entry.
pub(crate) struct Stencil {
    /// Where each row begins, and where the last ends.
    pub starts: Vec<i32>,
    /// Kind of each row; 0 has all neighbours, in the order of the slots.
    pub kinds: Vec<u16>,
    /// Position in its row of each slot, by kind; `None` where there is no neighbour.
    pub positions: Vec<[Option<u8>; 7]>,
}

impl Layout {
    /// Number of all cells.
    pub fn cells(&self) -> usize {
        self.axes.iter().map(Axis::cells).product()
    }

    /// First own cell along each axis.
    pub fn lower(&self) -> [usize; 3] {
        std::array::from_fn(|a| self.axes[a].starts[self.place[a]])
    }

    /// Own cells along each axis.
    pub fn counts(&self) -> [usize; 3] {
        std::array::from_fn(|a| self.axes[a].owned(self.place[a]))
    }

    /// Widths (m) of the own cells along an axis.
    pub fn widths(&self, axis: usize) -> &[f64] {
        let at = self.lower()[axis];
        &self.axes[axis].widths[at..at + self.counts()[axis]]
    }

    /// Row of a cell: ranks one after the other, x fastest among them and among the cells of each.
    pub fn row(&self, cell: [usize; 3]) -> usize {
        let [x, y, z] = &self.axes;
        let rank: [usize; 3] = std::array::from_fn(|a| self.axes[a].owner(cell[a]));
        let start: [usize; 3] = std::array::from_fn(|a| self.axes[a].starts[rank[a]]);
        let [nx, ny, nz]: [usize; 3] = std::array::from_fn(|a| self.axes[a].owned(rank[a]));
        let before = (start[2] * y.cells() + nz * start[1]) * x.cells() + nz * ny * start[0];
        debug_assert!(cell[2] < z.cells());
        before + ((cell[2] - start[2]) * ny + cell[1] - start[1]) * nx + cell[0] - start[0]
    }

    /// The next coarser grid and, per axis, the coarse cell of each cell; nothing if this one is small.
    ///
    /// Only axes with thin cells are coarsened: a point smoother evens out errors along strong couplings.
    pub fn coarsened(&self) -> Option<(Self, [Vec<usize>; 3])> {
        if self.cells() <= COARSEST {
            return None;
        }
        let long = || self.axes.iter().filter(|axis| axis.cells() > 1);
        let thinnest = long().map(Axis::mean_width).fold(f64::INFINITY, f64::min);
        let mut parents = [const { Vec::new() }; 3];
        let axes = std::array::from_fn(|a| {
            let axis = &self.axes[a];
            let is_paired = axis.cells() > 1 && axis.mean_width() <= ISOTROPIC * thinnest;
            let (coarse, map) =
                if is_paired { axis.paired() } else { (axis.clone(), (0..axis.cells()).collect()) };
            parents[a] = map;
            coarse
        });
        Some((Self { axes, place: self.place }, parents))
    }

    /// Calls `visit` with the own index and the place in the grid of every own cell.
    pub fn for_each_cell(&self, mut visit: impl FnMut(usize, [usize; 3])) {
        let (lower, n) = (self.lower(), self.counts());
        let mut index = 0;
        for k in 0..n[2] {
            for j in 0..n[1] {
                for i in 0..n[0] {
                    visit(index, [lower[0] + i, lower[1] + j, lower[2] + k]);
                    index += 1;
                }
            }
        }
    }

    /// Neighbour of a cell below or above along an axis; nothing beyond an end.
    fn neighbour(&self, cell: [usize; 3], axis: usize, is_above: bool) -> Option<[usize; 3]> {
        let (n, mut other) = (self.axes[axis].cells(), cell);
        let is_last = cell[axis] == if is_above { n - 1 } else { 0 };
        if is_last && !self.axes[axis].is_periodic {
            return None;
        }
        other[axis] = (cell[axis] + if is_above { 1 } else { n - 1 }) % n;
        Some(other)
    }

    /// Columns of the row of a cell by slot.
    fn columns(&self, cell: [usize; 3], row: usize) -> [Option<usize>; 7] {
        let mut columns = [None; 7];
        columns[CENTRE] = Some(row);
        for (axis, slots) in SLOTS.iter().enumerate() {
            for (side, &slot) in slots.iter().enumerate() {
                columns[slot] = self.neighbour(cell, axis, side == 1).map(|other| self.row(other));
            }
        }
        columns
    }

    /// The pattern of the seven-point matrix: columns of the rows, and what leads to their entries.
    pub fn stencil(&self) -> (Vec<i32>, Stencil) {
        let (lower, n) = (self.lower(), self.counts());
        let count = n.iter().product();
        let (line, plane) = (n[0] as i32, (n[0] * n[1]) as i32);
        let (mut columns, mut starts) = (Vec::with_capacity(7 * count), Vec::with_capacity(count + 1));
        let (mut kinds, mut positions) = (Vec::with_capacity(count), vec![NATURAL]);
        let first = if count > 0 { self.row(lower) } else { 0 };
        starts.push(0);
        self.for_each_cell(|index, cell| {
            let is_inner = (0..3).all(|a| cell[a] > lower[a] && cell[a] + 1 < lower[a] + n[a]);
            if is_inner {
                let row = (first + index) as i32;
                columns.extend([row - plane, row - line, row - 1, row, row + 1, row + line, row + plane]);
                kinds.push(0);
            } else {
                let own = self.columns(cell, first + index);
                kinds.push(kind(&own, &mut positions, &mut columns));
            }
            starts.push(columns.len() as i32);
        });
        (columns, Stencil { starts, kinds, positions })
    }
}

/// Adds a row with the given columns by slot, sorted and each once; returns its kind.
fn kind(slots: &[Option<usize>; 7], positions: &mut Vec<[Option<u8>; 7]>, columns: &mut Vec<i32>) -> u16 {
    let mut sorted: Vec<usize> = slots.iter().flatten().copied().collect();
    sorted.sort_unstable();
    sorted.dedup();
    columns.extend(sorted.iter().map(|&column| column as i32));
    let place = |column| sorted.iter().position(|&other| other == column).map(|p| p as u8);
    let position = slots.map(|column| column.and_then(place));
    let known = positions.iter().position(|other| *other == position);
    known.unwrap_or_else(|| {
        positions.push(position);
        positions.len() - 1
    }) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layouts(owned: [&[usize]; 3], periodic: bool) -> Vec<Layout> {
        let axes = owned.map(|list| Axis::new(list, periodic));
        let ranks = owned.map(<[usize]>::len);
        let place = |r: usize| [r % ranks[0], r / ranks[0] % ranks[1], r / (ranks[0] * ranks[1])];
        (0..ranks.iter().product()).map(|r| Layout { axes: axes.clone(), place: place(r) }).collect()
    }

    #[test]
    fn rows_follow_the_ranks_and_their_cells() {
        let mut next = 0;
        for layout in layouts([&[3, 2], &[1, 4], &[2, 2, 1]], false) {
            layout.for_each_cell(|_, cell| {
                assert_eq!(layout.row(cell), next);
                next += 1;
            });
        }
        assert_eq!(next, 5 * 5 * 5);
    }

    #[test]
    fn patterns_are_symmetric_and_short_periods_merge_their_neighbours() {
        for (owned, periodic) in [
            ([&[3, 2][..], &[1, 4], &[2, 1]], true),
            ([&[2], &[1], &[1, 1]], true),
            ([&[4], &[2, 2], &[1]], false),
        ] {
            let all = layouts(owned, periodic);
            let mut entries = std::collections::BTreeSet::new();
            let mut row = 0;
            for layout in &all {
                let (columns, stencil) = layout.stencil();
                for ends in stencil.starts.windows(2) {
                    let columns = &columns[ends[0] as usize..ends[1] as usize];
                    assert!(columns.is_sorted() && columns.contains(&row));
                    entries.extend(columns.iter().map(|&c| (row, c)));
                    row += 1;
                }
            }
            assert!(entries.iter().all(|&(r, c)| entries.contains(&(c, r))));
        }
    }

    #[test]
    fn flat_cells_are_joined_across_first() {
        let mut layout = layouts([&[32], &[32], &[32]], false).remove(0);
        layout.axes[2].widths = vec![0.25; 32];
        let counts = |layout: &Layout| layout.axes.each_ref().map(Axis::cells);
        let (first, _) = layout.coarsened().unwrap();
        let (second, _) = first.coarsened().unwrap();
        let (third, _) = second.coarsened().unwrap();
        assert_eq!(
            [counts(&first), counts(&second), counts(&third)],
            [[32, 32, 16], [32, 32, 8], [16, 16, 4]]
        );
    }
}
