//! Between a grid and the next coarser one, made of its cells in pairs: axis by axis.

use crate::pressure::single_operator::SingleOperator;
use crate::{Axis, Centre, Field, Layout};

/// An axis is coarsened with the others if its cells are not wider than this times the thinnest.
const ISOTROPIC: f64 = 1.5;

/// Zeros before a row of the fine grid: the cells beyond its first that the coarse cell before the first would see.
const BEFORE: usize = 3;

/// A fine cell or face that becomes part of a coarse one.
#[derive(Clone, Copy, Debug)]
struct Part {
    fine: isize,
    coarse: isize,
    factor: f32,
}

/// One axis of a transfer, own cells only.
#[derive(Clone, Debug)]
struct AxisTransfer {
    is_paired: bool,
    /// Coarse cell of every cell, the nearest other coarse cell, and the weights of both.
    around: Vec<[(isize, f32); 2]>,
    /// Weights of every coarse cell I, from −1 on, in the cells 2 I − 1 to 2 I + 2 that see it if cells are paired.
    seen: [Vec<f32>; 4],
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
    /// A row of the fine grid between zeros, of which three are before it; a row of the coarse grid with halo.
    fine_row: Vec<f32>,
    coarse_row: Vec<f32>,
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
    fn around(&self, cell: usize) -> [(isize, f32); 2] {
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
            return [(parent, (1.0 - falls) as f32), (parent, 0.0)];
        }
        let share = away / (self.coarse.centre(first + other) - centre);
        [(parent, (1.0 - share) as f32), (other, share as f32)]
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
        Part { fine, coarse, factor: if is_ring { 0.0 } else { ratio as f32 } }
    }

    fn transfer(&self) -> AxisTransfer {
        let (n, coarse) = (self.fine_own[1], self.coarse_own[1] as isize);
        let around: Vec<_> = (0..n).map(|cell| self.around(cell)).collect();
        let is_paired = self.fine.cells() > self.coarse.cells();
        let seen = |k: isize| {
            let weight = |coarse: isize| {
                let cell = usize::try_from(2 * coarse - 1 + k).ok().and_then(|cell| around.get(cell));
                cell.map_or(0.0, |around| around.iter().filter(|(c, _)| *c == coarse).map(|(_, w)| w).sum())
            };
            (-1..=coarse).map(weight).collect()
        };
        AxisTransfer {
            is_paired,
            seen: [0, 1, 2, 3].map(seen),
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
            fine_row: vec![0.0; fine.cells[0].max(2 * coarse.cells[0]) + 6],
            coarse_row: vec![0.0; coarse.cells[0] + 2],
        }
    }

    /// Coarse conductances from fine ones: faces side by side add, distances are those of the coarse grid.
    pub fn coarsen(&self, fine: &SingleOperator, coarse: &mut SingleOperator) {
        for axis in 0..3 {
            let parts = |a: usize| if a == axis { &self.axes[a].faces } else { &self.axes[a].cells };
            let from = &fine.conductances[axis];
            let to = &mut coarse.conductances[axis];
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
    }

    /// Makes a coarse field, halo included, the transpose of the interpolation applied to a field that is given row by row
    /// by `row(start, out)`.
    #[inline(always)]
    pub fn restrict(&mut self, mut row: impl FnMut(usize, &mut [f32]), coarse: &mut Field<Centre, f32>) {
        let n = self.fine.cells[0];
        coarse.fill(0.0);
        for (k, z) in self.axes[2].around.iter().enumerate() {
            for (j, y) in self.axes[1].around.iter().enumerate() {
                row(self.fine.row(j, k), &mut self.fine_row[BEFORE..BEFORE + n]);
                self.axes[0].restrict(&self.fine_row, &mut self.coarse_row);
                for (start, weight) in rows_around(self.coarse, *y, *z) {
                    let to = &mut coarse.data_mut()[start..][..self.coarse_row.len()];
                    to.iter_mut().zip(&self.coarse_row).for_each(|(to, value)| *to += weight * value);
                }
            }
        }
    }

    /// Adds the interpolation of a coarse field, halo filled, to a fine one.
    #[inline(always)]
    pub fn prolong(&mut self, coarse: &Field<Centre, f32>, fine: &mut Field<Centre, f32>) {
        let n = self.fine.cells[0];
        for (k, z) in self.axes[2].around.iter().enumerate() {
            for (j, y) in self.axes[1].around.iter().enumerate() {
                self.coarse_row.fill(0.0);
                for (start, weight) in rows_around(self.coarse, *y, *z) {
                    let from = &coarse.data()[start..][..self.coarse_row.len()];
                    self.coarse_row.iter_mut().zip(from).for_each(|(sum, value)| *sum += weight * value);
                }
                let to = &mut fine.data_mut()[self.fine.row(j, k)..][..n];
                self.axes[0].prolong(&self.coarse_row, to);
            }
        }
    }
}

impl AxisTransfer {
    /// A row of the coarse grid, halo included, from one of the fine grid that begins after [`BEFORE`] zeros.
    #[inline(always)]
    fn restrict(&self, fine: &[f32], coarse: &mut [f32]) {
        let n = coarse.len();
        if !self.is_paired {
            coarse.fill(0.0);
            coarse[1..n - 1].copy_from_slice(&fine[BEFORE..][..n - 2]);
            return;
        }
        let [a, b, c, d] = self.seen.each_ref().map(|weights| &weights[..n]);
        // The last pair begins two cells later.
        let (pairs, later) = (fine[..2 * n].as_chunks::<2>().0, fine[2..2 * n + 2].as_chunks::<2>().0);
        for i in 0..n {
            coarse[i] = (a[i] * pairs[i][0] + b[i] * pairs[i][1]) + (c[i] * later[i][0] + d[i] * later[i][1]);
        }
    }

    /// Adds the interpolation of a row of the coarse grid, halo included, to one of the fine grid.
    #[inline(always)]
    fn prolong(&self, coarse: &[f32], fine: &mut [f32]) {
        let inner = coarse.len() - 2;
        if !self.is_paired {
            fine.iter_mut().zip(&coarse[1..]).for_each(|(to, value)| *to += value);
            return;
        }
        let [a, b, c, d] = self.seen.each_ref().map(|weights| &weights[..inner + 2]);
        let coarse = &coarse[..inner + 2];
        let (pairs, alone) = fine.as_chunks_mut::<2>();
        for (i, pair) in pairs.iter_mut().enumerate() {
            pair[0] += b[i + 1] * coarse[i + 1] + d[i] * coarse[i];
            pair[1] += c[i + 1] * coarse[i + 1] + a[i + 2] * coarse[i + 2];
        }
        if let [last] = alone {
            *last += b[inner] * coarse[inner] + d[inner - 1] * coarse[inner - 1];
        }
    }
}

/// Starts, halo included, of the coarse rows around a fine one and their weights.
fn rows_around(
    coarse: Layout,
    y: [(isize, f32); 2],
    z: [(isize, f32); 2],
) -> impl Iterator<Item = (usize, f32)> {
    let pairs = z.into_iter().flat_map(move |z| y.map(|y| (coarse.index(-1, y.0, z.0), y.1 * z.1)));
    pairs.filter(|(_, weight)| *weight != 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A number between −0.5 and 0.5 for each of a row of calls.
    fn noise(seed: &mut u32) -> f32 {
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*seed >> 8) as f32 / (1 << 24) as f32 - 0.5
    }

    /// Axes that are paired or not, of even and odd numbers of cells, even and stretched, periodic and closed: Σ c Rᵀ f = Σ f R c,
    /// again and again in the same room, and an even field stays even unless zero is imposed.
    #[test]
    fn restriction_is_the_transpose_of_interpolation() {
        let mut seed = 7;
        for case in 0..64_usize {
            let cells = [2 + case % 7, 1 + case % 5, 3 + case % 4];
            let axis = |a: usize| {
                let nodes =
                    (0..=cells[a]).map(|i| (i as f64 / cells[a] as f64).powf([1.0, 1.2][(case + a) % 2]));
                Axis::stretched(nodes.collect(), (case >> a).is_multiple_of(3))
            };
            let fine = [0, 1, 2].map(axis);
            let is_paired = [0, 1, 2].map(|a| cells[a] > 1 && (case >> (2 * a)) % 4 != 0);
            let imposed = [0, 1, 2].map(|a| [false, !fine[a].is_periodic() && (case + a).is_multiple_of(5)]);
            let coarse = [0, 1, 2]
                .map(|a| if is_paired[a] { paired(&fine[a], &[0, cells[a]]).0 } else { fine[a].clone() });
            let coarse_cells = coarse.each_ref().map(Axis::cells);
            let mut transfer = Transfer::new([0, 1, 2].map(|a| AxisPair {
                fine: &fine[a],
                coarse: &coarse[a],
                fine_own: [0, cells[a]],
                coarse_own: [0, coarse_cells[a]],
                imposed: imposed[a],
            }));
            let layouts = [cells, coarse_cells].map(|cells| Layout { cells, halo: 1 });
            for _ in 0..3 {
                let [mut f, mut c] = layouts.map(Field::<Centre, f32>::new);
                let rows =
                    |layout: Layout| layout.rows().flat_map(move |start| start..start + layout.cells[0]);
                rows(layouts[0]).for_each(|p| f.data_mut()[p] = noise(&mut seed));
                c.data_mut().iter_mut().for_each(|c| *c = noise(&mut seed));
                let [mut interpolated, mut restricted] = layouts.map(Field::<Centre, f32>::new);
                transfer.prolong(&c, &mut interpolated);
                let row =
                    |start: usize, out: &mut [f32]| out.copy_from_slice(&f.data()[start..][..out.len()]);
                transfer.restrict(row, &mut restricted);
                let sum = |a: &Field<Centre, f32>, b: &Field<Centre, f32>| -> f64 {
                    a.data().iter().zip(b.data()).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
                };
                let (there, back) = (sum(&f, &interpolated), sum(&c, &restricted));
                assert!((there - back).abs() < 1e-5, "{case}: {there} {back}");
                if imposed == [[false; 2]; 3] {
                    c.fill(1.0);
                    interpolated.fill(0.0);
                    transfer.prolong(&c, &mut interpolated);
                    rows(layouts[0])
                        .for_each(|p| assert!((interpolated.data()[p] - 1.0).abs() < 1e-6, "{case}"));
                }
            }
        }
    }
}
