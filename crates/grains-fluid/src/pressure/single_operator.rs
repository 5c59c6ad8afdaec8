//! The operator in single precision: for corrections that another step makes good.

use super::operator::PressureOperator;
use crate::{Centre, Field, Layout};
use multiversion::multiversion;

/// Cells that are worked on at a time, and partial sums kept apart.
const LANES: usize = 8;

/// N numbers of a row.
#[inline(always)]
fn at<const N: usize>(row: &[f32], first: usize) -> [f32; N] {
    let mut group = [0.0; N];
    group.copy_from_slice(&row[first..first + N]);
    group
}

/// Σ_faces c A (p_neighbour − p)/d of every cell, from conductances in single precision on fields with a halo of one cell.
///
/// Differences are taken before they are multiplied, so that an even pressure gives exactly nothing.
#[derive(Clone, Debug)]
pub(crate) struct SingleOperator {
    layout: Layout,
    /// Conductances of the upper faces per axis, in a unit of choice; zero where closed.
    pub conductances: [Vec<f32>; 3],
}

/// The equation −A z = r in single precision: r in m³/s over a scale, z in Pa over another.
pub(crate) struct Equation<'a> {
    pub operator: &'a SingleOperator,
    pub residual: &'a mut Field<Centre, f32>,
    pub correction: &'a mut Field<Centre, f32>,
}

impl SingleOperator {
    /// Operator with conductances zero on so many cells.
    pub fn new(cells: [usize; 3]) -> Self {
        let layout = Layout { cells, halo: 1 };
        Self { layout, conductances: [0; 3].map(|_| vec![0.0; layout.len()]) }
    }

    /// Extent of the fields it is applied to.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Takes the conductances of an operator on fields of the same extent, divided by a unit.
    pub fn set(&mut self, operator: &PressureOperator, unit: f64) {
        debug_assert_eq!(self.layout, operator.layout());
        for (to, from) in self.conductances.iter_mut().zip(operator.conductances.components()) {
            to.iter_mut().zip(from).for_each(|(to, from)| *to = (from / unit) as f32);
        }
    }

    /// Sum of the six conductances of the cell at a place.
    pub fn diagonal(&self, place: usize) -> f64 {
        let strides = self.layout.strides();
        let of_axis = |(c, stride): (&Vec<f32>, usize)| f64::from(c[place - stride]) + f64::from(c[place]);
        self.conductances.iter().zip(strides).map(of_axis).sum()
    }

    /// out = A p in the own cells; the halo of p must be filled, and zero beyond the box. Returns Σ p A p, Σ r A p and Σ (A p)²
    /// of the own cells.
    pub fn apply(
        &self,
        p: &Field<Centre, f32>,
        r: &Field<Centre, f32>,
        out: &mut Field<Centre, f32>,
    ) -> [f64; 3] {
        apply(self, p.data(), r.data(), out.data_mut())
    }

    /// The row that starts at an array place and its neighbours.
    #[inline(always)]
    pub fn row<'a>(&'a self, p: &'a [f32], start: usize) -> Row<'a> {
        let (n, [_, sy, sz]) = (self.layout.cells[0], self.layout.strides());
        let at = |data: &'a [f32], start: usize| &data[start..start + n];
        let [x, y, z] = &self.conductances;
        Row {
            here: at(p, start),
            values: [start - 1, start + 1, start - sy, start + sy, start - sz, start + sz]
                .map(|start| at(p, start)),
            conductances: [
                at(x, start - 1),
                at(x, start),
                at(y, start - sy),
                at(y, start),
                at(z, start - sz),
                at(z, start),
            ],
        }
    }
}

/// A row of cells and their neighbours, each with the conductance of the face between.
pub(crate) struct Row<'a> {
    here: &'a [f32],
    values: [&'a [f32]; 6],
    conductances: [&'a [f32]; 6],
}

impl Row<'_> {
    /// Hands Σ_faces conductance × (neighbour − cell) of every cell to `job(i, here, flux)`, some cells that begin with `i` at a
    /// time, with what it gives for them written to `out`; of cells that lie in two groups the same is written twice.
    #[inline(always)]
    pub fn for_each(&self, out: &mut [f32], job: impl Fn(usize, f32, f32) -> f32) {
        let n = self.here.len();
        let out = &mut out[..n];
        if n < LANES {
            for (i, out) in out.iter_mut().enumerate() {
                [*out] = self.group(i, &job);
            }
            return;
        }
        for group in 0..n.div_ceil(LANES) {
            let first = (group * LANES).min(n - LANES);
            out[first..first + LANES].copy_from_slice(&self.group::<LANES>(first, &job));
        }
    }

    /// The same for N cells.
    #[inline(always)]
    fn group<const N: usize>(&self, first: usize, job: &impl Fn(usize, f32, f32) -> f32) -> [f32; N] {
        let here = at::<N>(self.here, first);
        let mut flux = [0.0; N];
        for (value, conductance) in self.values.iter().zip(&self.conductances) {
            let (value, conductance) = (at::<N>(value, first), at::<N>(conductance, first));
            for l in 0..N {
                flux[l] += conductance[l] * (value[l] - here[l]);
            }
        }
        std::array::from_fn(|l| job(first + l, here[l], flux[l]))
    }
}

/// See [`SingleOperator::apply`].
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn apply(operator: &SingleOperator, p: &[f32], r: &[f32], out: &mut [f32]) -> [f64; 3] {
    let n = operator.layout.cells[0];
    let mut sums = [0.0; 3];
    for start in operator.layout.rows() {
        let row = operator.row(p, start);
        let (r, out) = (&r[start..start + n], &mut out[start..start + n]);
        row.for_each(out, |_, _, flux| flux);
        sums[0] += dot(row.here, out);
        sums[1] += dot(r, out);
        sums[2] += dot(out, out);
    }
    sums
}

/// Σ a b of two rows, summed in double precision.
#[inline(always)]
pub(crate) fn dot(a: &[f32], b: &[f32]) -> f64 {
    let mut lanes = [0.0; LANES];
    let (whole_a, rest_a) = a.as_chunks::<LANES>();
    let (whole_b, rest_b) = b.as_chunks::<LANES>();
    for (a, b) in whole_a.iter().zip(whole_b) {
        for l in 0..LANES {
            lanes[l] += f64::from(a[l]) * f64::from(b[l]);
        }
    }
    let rest: f64 = rest_a.iter().zip(rest_b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum();
    lanes.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Axis, CellPartition, Faces, Grid};
    use std::array::from_fn;

    /// Rows of any length, shorter than a group or not whole groups: what double precision gives, to the rounding of single; and
    /// exactly nothing for an even pressure.
    #[test]
    fn rows_of_any_length_are_those_of_double_precision() {
        for n in 1..40 {
            let axes = [n, 3, 2].map(|cells| Axis::uniform(0.0, 1.0, cells, true));
            let grid = Grid::new(axes).unwrap();
            let partition = CellPartition::serial(&grid);
            let mut exact = PressureOperator::on(&grid, &partition, 1);
            let mut wave = (0..).map(|i| (1.3 * f64::from(i)).sin());
            let mut faces = Faces::new(exact.layout());
            faces.components_mut().into_iter().flatten().for_each(|c| *c = 1.2 + wave.next().unwrap_or(0.0));
            exact.set(&faces);
            let mut single = SingleOperator::new([n, 3, 2]);
            single.set(&exact, 3.0);
            let layout = single.layout();
            let [mut p, mut r, mut out] = from_fn(|_| Field::<Centre, f32>::new(layout));
            let (mut wide, mut expected) = (Field::new(layout), Field::new(layout));
            for place in 0..layout.len() {
                p.data_mut()[place] = wave.next().unwrap_or(0.0) as f32;
                r.data_mut()[place] = wave.next().unwrap_or(0.0) as f32;
                wide.data_mut()[place] = f64::from(p.data()[place]);
            }
            let sums = single.apply(&p, &r, &mut out);
            exact.apply(&wide, &mut expected);
            let bound = 1e-6 * expected.own().fold(0.0, |largest: f64, a| largest.max(a.abs()));
            assert!(
                expected.own().zip(out.own()).all(|(a, b)| (a - 3.0 * f64::from(b)).abs() < bound),
                "{n}"
            );
            let product = |field: &Field<Centre, f32>| -> f64 {
                field.own().zip(out.own()).map(|(a, b)| f64::from(a) * f64::from(b)).sum()
            };
            for (sum, by_hand) in sums.into_iter().zip([product(&p), product(&r), product(&out)]) {
                assert!((sum - by_hand).abs() < 1e-12 * (1.0 + product(&out)), "{n}");
            }
            p.fill(0.7);
            assert_eq!(single.apply(&p, &r, &mut out), [0.0; 3], "{n}");
        }
    }
}
