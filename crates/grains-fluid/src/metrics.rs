//! Widths and distances of the own cells and their halo.

use crate::{CellPartition, Grid, Layout};

/// One axis of a subdomain; entry i + h belongs to cell i, from −h to n + h.
#[derive(Clone, Debug)]
pub(crate) struct AxisMetrics {
    /// Width of the cell (m).
    pub width: Vec<f64>,
    /// Inverse width (1/m).
    pub inverse_width: Vec<f64>,
    /// Inverse distance from this centre to the next (1/m).
    pub inverse_distance: Vec<f64>,
    /// Share of this cell in the control volume of its upper face; the rest is the next cell's.
    pub lower_share: Vec<f64>,
    /// Share of the next cell.
    pub upper_share: Vec<f64>,
}

impl AxisMetrics {
    fn new(grid: &Grid, axis: usize, first: usize, n: usize, h: usize) -> Self {
        let cell = |m: usize| m as isize - h as isize + first as isize;
        let width = |m: usize| grid.axis(axis).width(cell(m));
        let each = |f: &dyn Fn(usize) -> f64| (0..n + 2 * h).map(f).collect::<Vec<f64>>();
        let distance = |m: usize| 0.5 * (width(m) + width(m + 1));
        Self {
            width: each(&width),
            inverse_width: each(&|m| 1.0 / width(m)),
            inverse_distance: each(&|m| 1.0 / distance(m)),
            lower_share: each(&|m| 0.5 * width(m) / distance(m)),
            upper_share: each(&|m| 0.5 * width(m + 1) / distance(m)),
        }
    }
}

/// What the kernels know of a subdomain.
#[derive(Clone, Debug)]
pub(crate) struct Local {
    pub layout: Layout,
    pub axes: [AxisMetrics; 3],
    /// Axes along which the flow varies.
    pub active: [bool; 3],
    /// Whether the subdomain ends at the lower and upper face of the box.
    pub ends: [[bool; 2]; 3],
    /// First own cell.
    pub first: [usize; 3],
    /// Ghost weights of walls per axis and side, see [`crate::Axis::wall_weights`].
    pub walls: [[[f64; 3]; 2]; 3],
}

impl Local {
    pub fn new(grid: &Grid, partition: &CellPartition, halo: usize) -> Self {
        let (cells, first) = (partition.cells(), partition.first());
        let layout = Layout { cells, halo };
        Self {
            layout,
            axes: std::array::from_fn(|a| AxisMetrics::new(grid, a, first[a], cells[a], halo)),
            active: std::array::from_fn(|a| grid.is_active(a)),
            ends: std::array::from_fn(|a| partition.touches(a).map(|t| t && !grid.axis(a).is_periodic())),
            first,
            walls: std::array::from_fn(|a| [0, 1].map(|side| grid.axis(a).wall_weights(side))),
        }
    }

    /// Unknown faces of a velocity component per axis: all own upper faces but the boundary's.
    pub fn unknowns(&self, component: usize) -> [usize; 3] {
        if !self.active[component] {
            return [0; 3];
        }
        let mut n = self.layout.cells;
        n[component] -= usize::from(self.ends[component][1]);
        n
    }

    /// Metrics entry of own cell `i`.
    #[inline]
    pub fn entry(&self, i: usize) -> usize {
        i + self.layout.halo
    }

    /// Volume of own cell (i, j, k) (m³).
    pub fn volume(&self, cell: [usize; 3]) -> f64 {
        (0..3).map(|a| self.axes[a].width[self.entry(cell[a])]).product()
    }

    /// Volume of the cell at a place in the arrays (m³).
    pub fn volume_at(&self, place: usize) -> f64 {
        let (dims, strides) = (self.layout.dims(), self.layout.strides());
        (0..3).map(|a| self.axes[a].width[place / strides[a] % dims[a]]).product()
    }

    /// Widths of the own cells along x (m).
    pub fn row_widths(&self) -> &[f64] {
        &self.axes[0].width[self.layout.halo..][..self.layout.cells[0]]
    }
}
