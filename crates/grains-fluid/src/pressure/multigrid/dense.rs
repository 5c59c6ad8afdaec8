//! The coarsest problem of one rank: a few cells solved at once.

use super::level::Level;
use crate::Layout;

/// Cells that are solved directly.
pub(super) const SOLVED_DIRECTLY: usize = 64;

/// Pivots below this share of their diagonal entry are those of the last cell of a region that nothing ties to a pressure: it gets 0.
const SMALLEST_PIVOT: f64 = 1e-12;

/// A symmetric matrix of some cells, factored by Cholesky.
#[derive(Clone, Debug)]
pub(crate) struct Dense {
    layout: Layout,
    periodic: [bool; 3],
    is_singular: bool,
    /// Rows of the lower factor, their diagonal inverted.
    factor: Vec<f64>,
    values: Vec<f64>,
}

impl Dense {
    /// Room for the matrix of a level that one rank has.
    pub fn new(level: &Level, is_singular: bool) -> Self {
        let (layout, periodic) =
            (level.operator.layout(), [0, 1, 2].map(|a| level.grid.axis(a).is_periodic()));
        let n = layout.cells.iter().product::<usize>();
        Self { layout, periodic, is_singular, factor: vec![0.0; n * n], values: vec![0.0; n] }
    }

    /// Takes the operator of a level, with its sign turned.
    pub fn set(&mut self, level: &Level) {
        let n = self.values.len();
        let (operator, [nx, ny, _]) = (&level.operator, self.layout.cells);
        self.factor.fill(0.0);
        for row in 0..n {
            let cell = [row % nx, row / nx % ny, row / (nx * ny)];
            let p = self.layout.row(cell[1], cell[2]) + cell[0];
            let diagonal = operator.diagonal(p);
            self.factor[row * n + row] += if diagonal > 0.0 { diagonal } else { 1.0 };
            for axis in 0..3 {
                let (mut next, cells) = (cell, self.layout.cells[axis]);
                next[axis] = (cell[axis] + 1) % cells;
                if next[axis] != cell[axis] && (next[axis] > 0 || self.periodic[axis]) {
                    let other = (next[2] * ny + next[1]) * nx + next[0];
                    let conductance = f64::from(operator.conductances[axis][p]);
                    self.factor[row.max(other) * n + row.min(other)] -= conductance;
                }
            }
        }
        if self.is_singular {
            // Any value for the mean will do: one that leaves the condition as it is.
            let share = (0..n).map(|i| self.factor[i * n + i]).sum::<f64>() / (n * n) as f64;
            (0..n).for_each(|i| self.factor[i * n..=i * n + i].iter_mut().for_each(|a| *a += share));
        }
        self.decompose();
    }

    fn decompose(&mut self) {
        let n = self.values.len();
        for i in 0..n {
            let (done, row) = self.factor.split_at_mut(i * n);
            for j in 0..i {
                let above = &done[j * n..];
                let sum: f64 = row[..j].iter().zip(above).map(|(a, b)| a * b).sum();
                row[j] = (row[j] - sum) * above[j];
            }
            let sum: f64 = row[..i].iter().map(|a| a * a).sum();
            let pivot = row[i] - sum;
            row[i] = if pivot > SMALLEST_PIVOT * row[i] { 1.0 / pivot.sqrt() } else { 0.0 };
        }
    }

    /// solution = A⁻¹ rhs of a level.
    pub fn solve(&mut self, level: &mut Level) {
        let (n, nx) = (self.values.len(), self.layout.cells[0]);
        let x = &mut self.values;
        for (row, start) in x.chunks_exact_mut(nx).zip(self.layout.rows()) {
            row.iter_mut().zip(&level.rhs.data()[start..]).for_each(|(x, rhs)| *x = f64::from(*rhs));
        }
        for i in 0..n {
            let row = &self.factor[i * n..=i * n + i];
            let sum: f64 = row[..i].iter().zip(&*x).map(|(a, x)| a * x).sum();
            x[i] = (x[i] - sum) * row[i];
        }
        for i in (0..n).rev() {
            let row = &self.factor[i * n..=i * n + i];
            x[i] *= row[i];
            let value = x[i];
            x[..i].iter_mut().zip(row).for_each(|(x, a)| *x -= a * value);
        }
        for (row, start) in x.chunks_exact(nx).zip(self.layout.rows()) {
            let solution = &mut level.solution.data_mut()[start..start + nx];
            solution.iter_mut().zip(row).for_each(|(solution, x)| *solution = *x as f32);
        }
    }
}
