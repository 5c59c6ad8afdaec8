//! The operator div(c grad p) itself, for iterations and residuals.

use super::PressureProblem;
use crate::metrics::Local;
use crate::{CellPartition, Centre, Faces, Field, Grid, Layout};

/// Σ_faces c A (p_neighbour − p)/d of every cell.
#[derive(Clone, Debug)]
pub struct PressureOperator {
    pub(crate) local: Local,
    /// Conductances c A/d of the upper faces (m³/(Pa s)), on faces of the box 2 c A/width; zero where closed.
    pub(crate) conductances: Faces,
    /// Sum of the six conductances of every own cell.
    pub(crate) diagonal: Field<Centre>,
}

/// A row of cells' neighbours, each with the conductance of the face between.
pub(crate) struct Neighbours<'a> {
    values: [&'a [f64]; 6],
    conductances: [&'a [f64]; 6],
}

impl Neighbours<'_> {
    /// Σ_faces conductance × neighbour of cell `i` of the row.
    #[inline(always)]
    pub fn sum(&self, i: usize) -> f64 {
        let (v, c) = (&self.values, &self.conductances);
        (c[0][i] * v[0][i] + c[1][i] * v[1][i])
            + (c[2][i] * v[2][i] + c[3][i] * v[3][i])
            + (c[4][i] * v[4][i] + c[5][i] * v[5][i])
    }
}

impl PressureOperator {
    /// Operator with coefficients zero.
    pub fn new(problem: &PressureProblem) -> Self {
        Self::on(&problem.grid, &problem.partition, problem.halo)
    }

    /// Operator with coefficients zero for fields with a halo of so many cells.
    pub(crate) fn on(grid: &Grid, partition: &CellPartition, halo: usize) -> Self {
        let local = Local::new(grid, partition, halo);
        let layout = local.layout;
        Self { local, conductances: Faces::new(layout), diagonal: Field::new(layout) }
    }

    /// Extent of the fields it is applied to.
    pub fn layout(&self) -> Layout {
        self.local.layout
    }

    /// Takes coefficients; halos must be filled, the lower boundary faces have index −1.
    pub fn set(&mut self, coefficients: &Faces) {
        for axis in 0..3 {
            self.set_axis(axis, coefficients.component(axis), coefficients.layout());
        }
        self.set_diagonal();
    }

    fn set_axis(&mut self, axis: usize, coefficients: &[f64], given: Layout) {
        let (local, layout) = (&self.local, self.local.layout);
        let [nx, ny, nz] = layout.cells.map(|n| n as isize);
        let entry = |i: isize| (i + layout.halo as isize) as usize;
        // On the faces of the box half the distance counts; an axis of one periodic cell has no neighbours.
        let end = |a: usize, i: isize| match local.ends[a] {
            _ if a != axis => 1.0,
            [false, false] if !local.active[a] => 0.0,
            [low, high] if low && i == -1 || high && i + 1 == layout.cells[a] as isize => 2.0,
            _ => 1.0,
        };
        let factors = |a: usize| match a == axis {
            true => &local.axes[a].inverse_distance,
            false => &local.axes[a].width,
        };
        let [fx, fy, fz] = [0, 1, 2].map(factors);
        let mut from = [0_isize; 3];
        from[axis] = -1;
        let count = (nx - from[0]) as usize;
        for k in from[2]..nz {
            for j in from[1]..ny {
                let factor = fy[entry(j)] * end(1, j) * fz[entry(k)] * end(2, k);
                let start = layout.index(from[0], j, k);
                let row = &mut self.conductances.component_mut(axis)[start..start + count];
                let given = &coefficients[given.index(from[0], j, k)..][..count];
                let across = &fx[entry(from[0])..][..count];
                for ((c, given), across) in row.iter_mut().zip(given).zip(across) {
                    *c = given * across * factor;
                }
                row[0] *= end(0, from[0]);
                if count > 1 {
                    row[count - 1] *= end(0, nx - 1);
                }
            }
        }
    }

    /// Sums the conductances of every own cell.
    pub(crate) fn set_diagonal(&mut self) {
        let (layout, strides) = (self.local.layout, self.local.layout.strides());
        let n = layout.cells[0];
        for start in layout.rows() {
            let faces = |a: usize| {
                let c = self.conductances.component(a);
                [&c[start..start + n], &c[start - strides[a]..][..n]]
            };
            let [[x1, x0], [y1, y0], [z1, z0]] = [0, 1, 2].map(faces);
            let row = &mut self.diagonal.data_mut()[start..start + n];
            for i in 0..n {
                row[i] = (x0[i] + x1[i]) + (y0[i] + y1[i]) + (z0[i] + z1[i]);
            }
        }
    }

    /// The neighbours of the row that starts at an array place; halos filled, zero beyond the box.
    #[inline(always)]
    pub(crate) fn neighbours<'a>(&'a self, p: &'a [f64], start: usize) -> Neighbours<'a> {
        let (n, [_, sy, sz]) = (self.local.layout.cells[0], self.local.layout.strides());
        let at = |data: &'a [f64], start: usize| &data[start..start + n];
        let [x, y, z] = self.conductances.components();
        Neighbours {
            values: [
                at(p, start - 1),
                at(p, start + 1),
                at(p, start - sy),
                at(p, start + sy),
                at(p, start - sz),
                at(p, start + sz),
            ],
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

    /// out = A p in the own cells; the halo of p must be filled, and zero beyond the box.
    pub fn apply(&self, p: &Field<Centre>, out: &mut Field<Centre>) {
        let layout = self.local.layout;
        for start in layout.rows() {
            self.apply_row(p.data(), start, &mut out.data_mut()[start..start + layout.cells[0]]);
        }
    }

    /// The row of A p that starts at an array place.
    #[inline(always)]
    pub(crate) fn apply_row(&self, p: &[f64], start: usize, row: &mut [f64]) {
        let n = self.local.layout.cells[0];
        let neighbours = self.neighbours(p, start);
        let (here, diagonal) = (&p[start..start + n], &self.diagonal.data()[start..start + n]);
        let row = &mut row[..n];
        for i in 0..n {
            row[i] = neighbours.sum(i) - diagonal[i] * here[i];
        }
    }
}

/// Partial sums kept apart, so that additions need not wait for one another.
const LANES: usize = 8;

/// Σ a b of two rows.
#[inline]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    let (whole_a, rest_a) = a.as_chunks::<LANES>();
    let (whole_b, rest_b) = b.as_chunks::<LANES>();
    for (a, b) in whole_a.iter().zip(whole_b) {
        for l in 0..LANES {
            lanes[l] += a[l] * b[l];
        }
    }
    let rest: f64 = rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum();
    lanes.iter().sum::<f64>() + rest
}
