//! Conduction along lines of cells, (m − ∂ c ∂) x = r: tridiagonal systems along any axis, closed into rings or shared among ranks.

use super::{Couplings, Panel, SharedLines};
use crate::metrics::Local;
use crate::{CellPartition, Grid, Layout};
use grains_domain::Transport;
use std::iter::StepBy;
use std::ops::Range;

/// Lines solved side by side: few enough for their working set to stay in cache.
const LINES: usize = 64;
/// Rows along x solved side by side, through transposed buffers.
const ROWS: usize = 16;

/// m x_i − c₊ (x_{i+1} − x_i) + c₋ (x_i − x_{i−1}) = r_i, with zeros beyond the ends of the box.
#[derive(Clone, Copy)]
pub(crate) struct Conduction<'a> {
    /// m of the cells.
    pub mass: &'a [f64],
    /// Conductances of the upper faces of the cells, those of the ends of the box included.
    pub conductance: &'a [f64],
    /// What multiplies them.
    pub factor: f64,
}

/// Rows along x side by side, with one place more at the beginning.
#[derive(Clone, Default)]
struct Transposed {
    data: Vec<f64>,
    mass: Vec<f64>,
    conductance: Vec<f64>,
    before: Vec<f64>,
    after: Vec<f64>,
}

/// Solver of such systems on the cells of a rank.
pub(crate) struct ConductionLines {
    layout: Layout,
    ends: [[bool; 2]; 3],
    shared: [SharedLines; 3],
    couplings: Couplings,
    coupled: [bool; 3],
    before: Vec<f64>,
    after: Vec<f64>,
    line_ends: Vec<f64>,
    /// Coefficients above over the pivots of a panel, and a row of coefficients below and inverse pivots.
    carried: Vec<f64>,
    low: Vec<f64>,
    pivot: Vec<f64>,
    rows: Transposed,
}

impl ConductionLines {
    pub fn new(grid: &Grid, partition: &CellPartition, local: &Local) -> Self {
        let coupled: [bool; 3] = std::array::from_fn(|a| partition.is_split(a) || grid.axis(a).is_periodic());
        let influence = if coupled.contains(&true) { local.layout.len() } else { 0 };
        Self {
            layout: local.layout,
            ends: local.ends,
            shared: std::array::from_fn(|a| SharedLines::new(&partition.row(a), partition.coordinates[a])),
            couplings: Couplings::default(),
            coupled,
            before: vec![0.0; influence],
            after: vec![0.0; influence],
            line_ends: Vec::new(),
            carried: Vec::new(),
            low: Vec::new(),
            pivot: Vec::new(),
            rows: Transposed::default(),
        }
    }

    /// Solves all lines along an axis, in place; collective.
    pub fn solve(
        &mut self,
        axis: usize,
        conduction: Conduction<'_>,
        data: &mut [f64],
        transport: &dyn Transport,
    ) {
        self.line_ends.clear();
        if axis == 0 {
            self.eliminate_rows(conduction, data);
        } else {
            let (mut before, mut after) = (std::mem::take(&mut self.before), std::mem::take(&mut self.after));
            for panel in panels(self.layout, axis) {
                let lists = [&mut *data, &mut before, &mut after];
                self.eliminate(axis, panel, conduction, lists);
            }
            (self.before, self.after) = (before, after);
        }
        if !self.coupled[axis] {
            return;
        }
        self.shared[axis].join(&self.line_ends, &mut self.couplings, transport);
        self.correct(axis, data);
    }

    /// Lines along x, transposed some at a time.
    fn eliminate_rows(&mut self, conduction: Conduction<'_>, data: &mut [f64]) {
        let (layout, n) = (self.layout, self.layout.cells[0]);
        let mut rows = std::mem::take(&mut self.rows);
        for starts in row_groups(layout) {
            let lines = starts.clone().count();
            rows.resize((n + 1) * lines, self.coupled[0]);
            for (l, start) in starts.clone().enumerate() {
                transpose(&data[start..start + n], &mut rows.data[lines + l..], lines);
                transpose(&conduction.mass[start..start + n], &mut rows.mass[lines + l..], lines);
                transpose(&conduction.conductance[start - 1..start + n], &mut rows.conductance[l..], lines);
            }
            let panel = Panel { start: lines, stride: lines, lines };
            let transposed =
                Conduction { mass: &rows.mass, conductance: &rows.conductance, factor: conduction.factor };
            self.eliminate(0, panel, transposed, [&mut rows.data, &mut rows.before, &mut rows.after]);
            for (l, start) in starts.enumerate() {
                gather(&rows.data[lines + l..], &mut data[start..start + n], lines);
                if self.coupled[0] {
                    gather(&rows.before[lines + l..], &mut self.before[start..start + n], lines);
                    gather(&rows.after[lines + l..], &mut self.after[start..start + n], lines);
                }
            }
        }
        self.rows = rows;
    }

    /// Solves the own part of the lines of a panel, and notes their ends where they are joined to others.
    fn eliminate(
        &mut self,
        axis: usize,
        panel: Panel,
        conduction: Conduction<'_>,
        [data, before, after]: [&mut [f64]; 3],
    ) {
        let (n, Panel { start, stride, lines }) = (self.layout.cells[axis], panel);
        let is_coupled = self.coupled[axis];
        self.carried.resize(n * lines, 0.0);
        self.low.resize(lines, 0.0);
        self.pivot.resize(lines, 0.0);
        for i in 0..n {
            let (is_first, is_last) = (i == 0, i + 1 == n);
            let p = start + i * stride;
            self.set_row((axis, i), [p, stride, lines], conduction);
            let (low, pivot) = (&self.low[..lines], &self.pivot[..lines]);
            panel.forward(data, i, |l| [low[l], pivot[l]]);
            if is_coupled {
                let high = &self.carried[i * lines..][..lines];
                for l in 0..lines {
                    before[p + l] = if is_first { -low[l] } else { 0.0 };
                    after[p + l] = if is_last { -high[l] / pivot[l] } else { 0.0 };
                }
                panel.forward(before, i, |l| [low[l], pivot[l]]);
                panel.forward(after, i, |l| [low[l], pivot[l]]);
            }
        }
        for i in (0..n - 1).rev() {
            let carried = &self.carried[i * lines..][..lines];
            panel.backward(data, i, |l| carried[l]);
            if is_coupled {
                panel.backward(before, i, |l| carried[l]);
                panel.backward(after, i, |l| carried[l]);
            }
        }
        if is_coupled {
            for first in start..start + lines {
                let last = first + (n - 1) * stride;
                let both = |x: &[f64]| [x[first], x[last]];
                self.line_ends.extend([both(data), both(before), both(after)].as_flattened());
            }
        }
    }

    /// Coefficients below, inverse pivots and carried coefficients of row i.
    fn set_row(
        &mut self,
        (axis, i): (usize, usize),
        [p, stride, lines]: [usize; 3],
        conduction: Conduction<'_>,
    ) {
        let n = self.layout.cells[axis];
        let below = &conduction.conductance[p - stride..][..lines];
        let above = &conduction.conductance[p..][..lines];
        let mass = &conduction.mass[p..][..lines];
        // What conducts to the ends of the box is no neighbour.
        let has_low = if i == 0 && self.ends[axis][0] { 0.0 } else { conduction.factor };
        let has_high = if i + 1 == n && self.ends[axis][1] { 0.0 } else { conduction.factor };
        let (done, carried) = self.carried.split_at_mut(i * lines);
        let (carried, low, pivot) = (&mut carried[..lines], &mut self.low[..lines], &mut self.pivot[..lines]);
        for l in 0..lines {
            low[l] = has_low * below[l];
            carried[l] = has_high * above[l];
            pivot[l] = mass[l] + conduction.factor * (below[l] + above[l]);
        }
        if i > 0 {
            let previous = &done[(i - 1) * lines..];
            pivot.iter_mut().zip(&*low).zip(previous).for_each(|((pivot, low), c)| *pivot -= low * c);
        }
        for (pivot, carried) in pivot.iter_mut().zip(carried) {
            *pivot = 1.0 / *pivot;
            *carried *= *pivot;
        }
    }

    /// Adds to all lines what the values beyond their own parts contribute.
    fn correct(&mut self, axis: usize, data: &mut [f64]) {
        let (n, stride) = (self.layout.cells[axis], self.layout.strides()[axis]);
        let mut lines = self.shared[axis].around().iter();
        let (v, w) = (&self.before, &self.after);
        let mut correct_line = |start: usize| {
            let [before, after] = lines.next().copied().unwrap_or_default();
            for p in (start..).step_by(stride).take(n) {
                data[p] -= v[p] * before + w[p] * after;
            }
        };
        if axis == 0 {
            row_groups(self.layout).for_each(|starts| starts.for_each(&mut correct_line));
        } else {
            panels(self.layout, axis)
                .for_each(|panel| (panel.start..panel.start + panel.lines).for_each(&mut correct_line));
        }
    }
}

/// Starts of rows along x, some at a time.
fn row_groups(layout: Layout) -> impl Iterator<Item = StepBy<Range<usize>>> {
    let ([_, ny, nz], stride) = (layout.cells, layout.strides()[1]);
    (0..nz).flat_map(move |k| {
        (0..ny).step_by(ROWS).map(move |j| {
            let (first, rows) = (layout.row(j, k), ROWS.min(ny - j));
            (first..first + rows * stride).step_by(stride)
        })
    })
}

/// Panels of lines along y or z.
fn panels(layout: Layout, axis: usize) -> impl Iterator<Item = Panel> {
    let ([nx, ny, nz], stride) = (layout.cells, layout.strides()[axis]);
    let parts = nx.div_ceil(LINES);
    (0..if axis == 1 { nz } else { ny }).flat_map(move |slab| {
        let row = if axis == 1 { layout.row(0, slab) } else { layout.row(slab, 0) };
        (0..parts).map(move |part| {
            let (first, end) = (nx * part / parts, nx * (part + 1) / parts);
            Panel { start: row + first, stride, lines: end - first }
        })
    })
}

/// Writes a row to every `lines`-th entry.
fn transpose(row: &[f64], to: &mut [f64], lines: usize) {
    to.iter_mut().step_by(lines).zip(row).for_each(|(to, value)| *to = *value);
}

/// The way back.
fn gather(from: &[f64], row: &mut [f64], lines: usize) {
    row.iter_mut().zip(from.iter().step_by(lines)).for_each(|(value, from)| *value = *from);
}

impl Transposed {
    fn resize(&mut self, size: usize, is_coupled: bool) {
        let influence = if is_coupled { size } else { 0 };
        let lists = [
            (&mut self.data, size),
            (&mut self.mass, size),
            (&mut self.conductance, size),
            (&mut self.before, influence),
            (&mut self.after, influence),
        ];
        lists.into_iter().for_each(|(list, size)| list.resize(size, 0.0));
    }
}
