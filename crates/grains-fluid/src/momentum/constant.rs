//! (1 − a δ²) x = d along lines with the same coefficients for all lines: factors computed once per time step.

use crate::tridiagonal::{Couplings, Panel, SharedLines};
use crate::{CellPartition, Grid};
use grains_domain::Transport;
use multiversion::multiversion;

/// What closes a line at an end of the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LineEnd {
    /// The unknown's neighbour is imposed; its change is on the right-hand side.
    Imposed,
    /// No gradient.
    Free,
}

/// Factors of one component along one axis, and the exchange along the row of ranks.
#[derive(Clone, Debug)]
pub(crate) struct ConstantLines {
    /// Thomas factors of the own part, see [`factor`].
    factors: [Vec<f64>; 3],
    /// Influence vectors of the own part for unit values beyond its ends; empty where the line is not shared nor a ring.
    before: Vec<f64>,
    after: Vec<f64>,
    couplings: Couplings,
    shared: SharedLines,
    /// First and last value of the own part of every line.
    ends: Vec<f64>,
}

/// Which lines: a velocity component along an axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LineKind {
    pub component: usize,
    pub axis: usize,
    /// What closes the lines at the ends of the box.
    pub ends: [LineEnd; 2],
}

impl LineKind {
    /// Coefficients [lower, diagonal, upper] of 1 − a δ² on the unknowns of place `column` in the row of ranks.
    fn rows(&self, grid: &Grid, partition: &CellPartition, column: usize, a: f64) -> Vec<[f64; 3]> {
        let axis = grid.axis(self.axis);
        let (start, mut stop) =
            (partition.starts[self.axis][column], partition.starts[self.axis][column + 1]);
        let is_along = self.component == self.axis;
        let n = axis.cells();
        if is_along && stop == n && !axis.is_periodic() {
            stop -= 1;
        }
        let distance = |i: isize| axis.centre(i + 1) - axis.centre(i);
        let coefficients = |i: isize| match is_along {
            true => [a / (axis.width(i) * distance(i)), a / (axis.width(i + 1) * distance(i))],
            false => [a / (distance(i - 1) * axis.width(i)), a / (distance(i) * axis.width(i))],
        };
        let close = |row: &mut [f64; 3], side: usize, conductance: f64| match self.ends[side] {
            // A face unknown lies a whole cell from the imposed value, a centre half a cell.
            LineEnd::Imposed if is_along => row[1] += conductance,
            LineEnd::Imposed => {
                let [_, first, second] = axis.wall_weights(side);
                row[1] += conductance * (1.0 - first);
                row[2 * (1 - side)] -= conductance * second;
            }
            LineEnd::Free => {}
        };
        let last = if is_along { n as isize - 2 } else { n as isize - 1 };
        (start as isize..stop as isize)
            .map(|i| {
                let [low, high] = coefficients(i);
                let mut row = [0.0, 1.0, 0.0];
                if i == 0 && !axis.is_periodic() {
                    close(&mut row, 0, low);
                } else {
                    row[0] -= low;
                    row[1] += low;
                }
                if i == last && !axis.is_periodic() {
                    close(&mut row, 1, high);
                } else {
                    row[2] -= high;
                    row[1] += high;
                }
                row
            })
            .collect()
    }
}

/// Thomas factors of the rows −low x₋ + diagonal x − high x₊: low, the inverse pivot, and high over the pivot.
fn factor(rows: &[[f64; 3]]) -> [Vec<f64>; 3] {
    let mut out: [Vec<f64>; 3] = Default::default();
    let mut carried = 0.0;
    for (i, &[low, diagonal, high]) in rows.iter().enumerate() {
        let low = if i == 0 { 0.0 } else { low };
        let inverse = 1.0 / (diagonal - low * carried);
        carried = if i + 1 == rows.len() { 0.0 } else { high * inverse };
        out[0].push(-low);
        out[1].push(inverse);
        out[2].push(-carried);
    }
    out
}

/// Solution for a right-hand side that is `value` at one place.
fn influence_vector(factors: &[Vec<f64>; 3], place: usize, value: f64) -> Vec<f64> {
    let n = factors[0].len();
    let mut x = vec![0.0; n];
    if n > 0 {
        x[place] = value;
        eliminate(&mut x, Panel { start: 0, stride: 1, lines: 1 }, factors);
    }
    x
}

/// Thomas elimination of all lines of a panel.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn eliminate(data: &mut [f64], panel: Panel, factors: &[Vec<f64>; 3]) {
    let [low, inverse_pivot, high] = factors;
    for (i, (&low, &pivot)) in low.iter().zip(inverse_pivot).enumerate() {
        match i {
            0 => data[panel.start..][..panel.lines].iter_mut().for_each(|x| *x *= pivot),
            _ => combine(panel.rows(data, i, i - 1), |x, before| (x + low * before) * pivot),
        }
    }
    for i in (0..low.len().saturating_sub(1)).rev() {
        let high = high[i];
        combine(panel.rows(data, i, i + 1), |x, after| x + high * after);
    }
}

/// x = f(x, y) of all entries of two rows, as many at a time as fill the lanes of a processor.
#[inline(always)]
fn combine((x, y): (&mut [f64], &[f64]), f: impl Fn(f64, f64) -> f64) {
    const LANES: usize = 8;
    let ((x, rest_of_x), (y, rest_of_y)) = (x.as_chunks_mut::<LANES>(), y.as_chunks::<LANES>());
    for (x, y) in x.iter_mut().zip(y) {
        let (now, y) = (*x, *y);
        *x = std::array::from_fn(|l| f(now[l], y[l]));
    }
    rest_of_x.iter_mut().zip(rest_of_y).for_each(|(x, y)| *x = f(*x, *y));
}

impl ConstantLines {
    /// Factors for a (m²) = ν Δt / 2.
    pub fn new(grid: &Grid, partition: &CellPartition, kind: LineKind, a: f64) -> Self {
        let (parts, own) = (partition.ranks[kind.axis], partition.coordinates[kind.axis]);
        let mut lines = Self {
            factors: factor(&kind.rows(grid, partition, own, a)),
            before: Vec::new(),
            after: Vec::new(),
            couplings: Couplings::default(),
            shared: SharedLines::new(&partition.row(kind.axis), own),
            ends: Vec::new(),
        };
        if parts > 1 || grid.axis(kind.axis).is_periodic() {
            lines.couple(grid, partition, kind, a);
        }
        lines
    }

    /// Influence vectors of all parts for unit values beyond their ends, joined.
    fn couple(&mut self, grid: &Grid, partition: &CellPartition, kind: LineKind, a: f64) {
        let (parts, own) = (partition.ranks[kind.axis], partition.coordinates[kind.axis]);
        let mut influences = Vec::new();
        for column in 0..parts {
            let rows = kind.rows(grid, partition, column, a);
            let factors = factor(&rows);
            let n = rows.len();
            let v = influence_vector(&factors, 0, rows[0][0]);
            let w = influence_vector(&factors, n - 1, rows[n - 1][2]);
            influences.push([[v[0], v[n - 1]], [w[0], w[n - 1]]]);
            if column == own {
                (self.before, self.after) = (v, w);
            }
        }
        self.couplings.join(parts, |part| influences[part]);
    }

    /// Whether lines need the values beyond their ends.
    pub fn is_coupled(&self) -> bool {
        !self.before.is_empty()
    }

    /// Number of unknowns of a line.
    pub fn len(&self) -> usize {
        self.factors[0].len()
    }

    /// Whether other ranks share the lines, so that ends must be exchanged before they are corrected.
    pub fn is_shared(&self) -> bool {
        self.shared.parts() > 1
    }

    /// Forgets the ends noted by [`ConstantLines::eliminate`].
    pub fn begin(&mut self) {
        self.ends.clear();
    }

    /// Solves the own part of all lines of a panel; ends are noted if the lines are coupled.
    pub fn eliminate(&mut self, data: &mut [f64], panel: Panel) {
        eliminate(data, panel, &self.factors);
        if self.is_coupled() {
            let last = panel.start + (self.len() - 1) * panel.stride;
            for l in 0..panel.lines {
                self.ends.extend([data[panel.start + l], data[last + l]]);
            }
        }
    }

    /// Finds the values beyond the ends of all lines whose ends were noted; collective where lines are shared.
    pub fn exchange(&mut self, transport: &dyn Transport) {
        self.shared.collect(&self.ends, 2, transport);
        let couplings = &mut self.couplings;
        self.shared.solve(transport, |_, line, put| {
            couplings.solve(|part| [line.part(part)[0], line.part(part)[1]], put);
        });
    }

    /// Corrects the lines of a panel, the first of which is line `first` in the order of elimination.
    pub fn correct(&self, data: &mut [f64], panel: Panel, first: usize) {
        let values = &self.shared.around()[first..first + panel.lines];
        for (i, (v, w)) in self.before.iter().zip(&self.after).enumerate() {
            let row = &mut data[panel.start + i * panel.stride..][..panel.lines];
            row.iter_mut().zip(values).for_each(|(x, around)| *x -= v * around[0] + w * around[1]);
        }
    }

    /// Corrects one line whose unknowns lie side by side.
    pub fn correct_contiguous(&self, line: &mut [f64], number: usize) {
        let around = self.shared.around()[number];
        for (x, (v, w)) in line.iter_mut().zip(self.before.iter().zip(&self.after)) {
            *x -= v * around[0] + w * around[1];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines side by side solve their rows, and have the bits that each has alone, whatever their number and stride.
    #[test]
    fn lines_side_by_side_are_solved_as_each_alone() {
        let value = |k: usize| (k as f64 * 1.7).sin();
        for (n, lines) in (1..8).flat_map(|n| (1..=25).map(move |lines| (n, lines))) {
            let rows: Vec<[f64; 3]> = (0..n)
                .map(|i| [-0.4 - 0.2 * value(i), 2.0 + value(i + 9), -0.3 + 0.2 * value(i + 5)])
                .collect();
            let factors = factor(&rows);
            let (start, stride) = (2, lines + n % 3);
            let given: Vec<f64> = (0..start + n * stride).map(value).collect();
            let mut solved = given.clone();
            eliminate(&mut solved, Panel { start, stride, lines }, &factors);
            for l in 0..lines {
                let of_line =
                    |data: &[f64]| (0..n).map(|i| data[start + i * stride + l]).collect::<Vec<f64>>();
                let (wanted, x) = (of_line(&given), of_line(&solved));
                for (i, [low, diagonal, high]) in rows.iter().enumerate() {
                    let before = if i > 0 { low * x[i - 1] } else { 0.0 };
                    let after = if i + 1 < n { high * x[i + 1] } else { 0.0 };
                    assert!((before + diagonal * x[i] + after - wanted[i]).abs() < 1e-13, "{n} {lines} {l}");
                }
                let mut alone = wanted;
                eliminate(&mut alone, Panel { start: 0, stride: 1, lines: 1 }, &factors);
                assert_eq!(alone, x, "{n} {lines} {l}");
            }
        }
    }
}
