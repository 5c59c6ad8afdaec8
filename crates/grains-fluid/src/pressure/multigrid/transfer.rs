//! Between a grid and the next coarser one, made of its cells in pairs: axis by axis.

use crate::pressure::operator::PressureOperator;
use crate::{Axis, Centre, Field, Layout};

/// An axis is coarsened with the others if its cells are not wider than this times the thinnest.
const ISOTROPIC: f64 = 1.5;

/// A fine cell or face that becomes part of a coarse one.
#[derive(Clone, Copy, Debug)]
struct Part {
    fine: isize,
    coarse: isize,
    factor: f64,
}

/// One axis of a transfer, own cells only.
#[derive(Clone, Debug)]
struct AxisTransfer {
    /// Coarse cell of every cell, the nearest other coarse cell, and the weights of both.
    around: Vec<[(isize, f64); 2]>,
    /// For every coarse cell, halo included: the first of four cells that see it, and its weights there.
    seen: Vec<(usize, [f64; 4])>,
    cells: Vec<Part>,
    /// Faces that remain; factors are ratios of distances.
    faces: Vec<Part>,
}

/// Linear interpolation from a coarse grid, its transpose, and the coarse conductances.
#[derive(Clone, Debug)]
pub(crate) struct Transfer {
    axes: [AxisTransfer; 3],
    fine: Layout,
    coarse: Layout,
    /// A row of the fine grid, three entries longer; a row of the coarse grid with halo.
    fine_row: Vec<f64>,
    coarse_row: Vec<f64>,
}

/// Which axes have the thin cells.
fn thin(axes: [&Axis; 3]) -> [bool; 3] {
    let mean = |a: usize| axes[a].length() / axes[a].cells() as f64;
    let long = |a: &usize| axes[*a].cells() > 1;
    let thinnest = (0..3).filter(long).map(mean).fold(f64::INFINITY, f64::min);
    std::array::from_fn(|a| long(&a) && mean(a) <= ISOTROPIC * thinnest)
}

/// Which axes are coarsened: the thin ones, as far as some rank has cells to pair.
pub(crate) fn pairing(axes: [&Axis; 3], counts: [&[usize]; 3]) -> [bool; 3] {
    let thin = thin(axes);
    std::array::from_fn(|a| thin[a] && counts[a].iter().any(|&n| n > 1))
}

/// Which thin axes cannot be coarsened, as every rank has one cell along them.
pub(crate) fn stuck(axes: [&Axis; 3], counts: [&[usize]; 3]) -> [bool; 3] {
    let (thin, pairs) = (thin(axes), pairing(axes, counts));
    std::array::from_fn(|a| thin[a] && !pairs[a])
}

/// The coarse axis and where its ranks start; every rank pairs its own cells, the last of an odd number stays alone.
pub(crate) fn paired(axis: &Axis, starts: &[usize]) -> (Axis, Vec<usize>) {
    let mut nodes = vec![axis.nodes()[0]];
    let mut coarse_starts = vec![0];
    for own in starts.windows(2) {
        nodes.extend((own[0]..own[1]).step_by(2).map(|cell| axis.nodes()[(cell + 2).min(own[1])]));
        coarse_starts.push(nodes.len() - 1);
    }
    (Axis::stretched(nodes, axis.is_periodic()), coarse_starts)
}

/// An axis of both grids as one rank sees it.
pub(crate) struct AxisPair<'a> {
    pub fine: &'a Axis,
    pub coarse: &'a Axis,
    /// First own cell and number of own cells, fine and coarse.
    pub fine_own: [usize; 2],
    pub coarse_own: [usize; 2],
    /// Whether zero is imposed at the ends of the box.
    pub imposed: [bool; 2],
}

impl AxisPair<'_> {
    fn parent(&self, cell: usize) -> isize {
        let is_paired = self.fine.cells() > self.coarse.cells();
        (if is_paired { cell / 2 } else { cell }) as isize
    }

    /// Coarse cells around an own cell with their weights.
    fn around(&self, cell: usize) -> [(isize, f64); 2] {
        let (parent, first) = (self.parent(cell), self.coarse_own[0] as isize);
        let centre = self.coarse.centre(first + parent);
        let away = self.fine.centre((self.fine_own[0] + cell) as isize) - centre;
        let width = self.coarse.width(first + parent);
        if away.abs() < 1e-6 * width {
            return [(parent, 1.0), (parent, 0.0)];
        }
        let other = parent + if away > 0.0 { 1 } else { -1 };
        let is_beyond = !(0..self.coarse.cells() as isize).contains(&(first + other));
        if is_beyond && !self.coarse.is_periodic() {
            let falls = if self.imposed[usize::from(away > 0.0)] { away.abs() / (0.5 * width) } else { 0.0 };
            return [(parent, 1.0 - falls), (parent, 0.0)];
        }
        let share = away / (self.coarse.centre(first + other) - centre);
        [(parent, 1.0 - share), (other, share)]
    }

    /// The fine face of a coarse one; −1 is the lower face of the first own cell.
    fn face(&self, coarse: isize) -> Part {
        let last_child = (0..self.fine_own[1]).rev().find(|&cell| self.parent(cell) == coarse);
        let fine = last_child.map_or(-1, |cell| cell as isize);
        let distance = |axis: &Axis, first: usize, face: isize| {
            let cell = first as isize + face;
            axis.centre(cell + 1) - axis.centre(cell)
        };
        let is_ring = self.coarse.is_periodic() && self.coarse.cells() == 1;
        let ratio =
            distance(self.fine, self.fine_own[0], fine) / distance(self.coarse, self.coarse_own[0], coarse);
        Part { fine, coarse, factor: if is_ring { 0.0 } else { ratio } }
    }

    fn transfer(&self) -> AxisTransfer {
        let (n, coarse) = (self.fine_own[1], self.coarse_own[1] as isize);
        let around: Vec<_> = (0..n).map(|cell| self.around(cell)).collect();
        let seen = |coarse: isize| {
            let weights = around.iter().enumerate().filter_map(|(cell, around)| {
                let weight: f64 = around.iter().filter(|(c, _)| *c == coarse).map(|(_, w)| w).sum();
                (weight != 0.0).then_some((cell, weight))
            });
            let mut entry = (usize::MAX, [0.0; 4]);
            for (cell, weight) in weights {
                entry.0 = entry.0.min(cell);
                entry.1[cell - entry.0] = weight;
            }
            if entry.0 == usize::MAX { (0, entry.1) } else { entry }
        };
        AxisTransfer {
            seen: (-1..=coarse).map(seen).collect(),
            cells: (0..n)
                .map(|cell| Part { fine: cell as isize, coarse: self.parent(cell), factor: 1.0 })
                .collect(),
            faces: (-1..coarse).map(|face| self.face(face)).collect(),
            around,
        }
    }
}

impl Transfer {
    pub fn new(axes: [AxisPair<'_>; 3]) -> Self {
        let fine = Layout { cells: axes.each_ref().map(|a| a.fine_own[1]), halo: 1 };
        let coarse = Layout { cells: axes.each_ref().map(|a| a.coarse_own[1]), halo: 1 };
        Self {
            axes: axes.each_ref().map(AxisPair::transfer),
            fine,
            coarse,
            fine_row: vec![0.0; fine.cells[0] + 3],
            coarse_row: vec![0.0; coarse.cells[0] + 2],
        }
    }

    /// Coarse conductances from fine ones: faces side by side add, distances are those of the coarse grid.
    pub fn coarsen(&self, fine: &PressureOperator, coarse: &mut PressureOperator) {
        for axis in 0..3 {
            let parts = |a: usize| if a == axis { &self.axes[a].faces } else { &self.axes[a].cells };
            let from = fine.conductances.component(axis);
            let to = coarse.conductances.component_mut(axis);
            to.fill(0.0);
            for z in parts(2) {
                for y in parts(1) {
                    let factor = y.factor * z.factor;
                    let from = &from[self.fine.index(-1, y.fine, z.fine)..][..self.fine.dims()[0]];
                    let to = &mut to[self.coarse.index(-1, y.coarse, z.coarse)..][..self.coarse.dims()[0]];
                    for x in parts(0) {
                        to[(x.coarse + 1) as usize] += factor * x.factor * from[(x.fine + 1) as usize];
                    }
                }
            }
        }
        coarse.set_diagonal();
    }

    /// Adds the transpose of the interpolation of a field, given row by row by `row(start, out)`, to a coarse field
    /// and its halo.
    pub fn restrict(&mut self, mut row: impl FnMut(usize, &mut [f64]), coarse: &mut Field<Centre>) {
        let n = self.fine.cells[0];
        coarse.fill(0.0);
        for (k, z) in self.axes[2].around.iter().enumerate() {
            for (j, y) in self.axes[1].around.iter().enumerate() {
                row(self.fine.row(j, k), &mut self.fine_row[..n]);
                for (sum, (first, weights)) in self.coarse_row.iter_mut().zip(&self.axes[0].seen) {
                    let values = &self.fine_row[*first..*first + 4];
                    *sum = (weights[0] * values[0] + weights[1] * values[1])
                        + (weights[2] * values[2] + weights[3] * values[3]);
                }
                for (start, weight) in rows_around(self.coarse, *y, *z) {
                    let to = &mut coarse.data_mut()[start..][..self.coarse_row.len()];
                    to.iter_mut().zip(&self.coarse_row).for_each(|(to, value)| *to += weight * value);
                }
            }
        }
    }

    /// Adds the interpolation of a coarse field, halo filled, to a fine one.
    pub fn prolong(&mut self, coarse: &Field<Centre>, fine: &mut Field<Centre>) {
        let n = self.fine.cells[0];
        for (k, z) in self.axes[2].around.iter().enumerate() {
            for (j, y) in self.axes[1].around.iter().enumerate() {
                self.coarse_row.fill(0.0);
                for (start, weight) in rows_around(self.coarse, *y, *z) {
                    let from = &coarse.data()[start..][..self.coarse_row.len()];
                    self.coarse_row.iter_mut().zip(from).for_each(|(sum, value)| *sum += weight * value);
                }
                let to = &mut fine.data_mut()[self.fine.row(j, k)..][..n];
                for (to, [(a, wa), (b, wb)]) in to.iter_mut().zip(&self.axes[0].around) {
                    *to += wa * self.coarse_row[(a + 1) as usize] + wb * self.coarse_row[(b + 1) as usize];
                }
            }
        }
    }
}

/// Starts, halo included, of the coarse rows around a fine one and their weights.
fn rows_around(
    coarse: Layout,
    y: [(isize, f64); 2],
    z: [(isize, f64); 2],
) -> impl Iterator<Item = (usize, f64)> {
    let pairs = z.into_iter().flat_map(move |z| y.map(|y| (coarse.index(-1, y.0, z.0), y.1 * z.1)));
    pairs.filter(|(_, weight)| *weight != 0.0)
}
