//! The implicit factors where void fraction, viscosity, drag or kinds of boundary differ from place to place.

use super::system::{Bundle, Coefficients, Influence, MomentumDiagonal, Scratch, System};
use crate::CellPartition;
use crate::boundary::BoundaryData;
use crate::metrics::Local;
use crate::tridiagonal::{Couplings, Panel, SharedLines};
use grains_domain::{SerialTransport, Transport};

/// Solver of the factors, one component and axis at a time.
#[derive(Clone)]
pub(crate) struct VariableLines {
    shared: [SharedLines; 3],
    couplings: Couplings,
    coupled: [bool; 3],
    coefficients: Coefficients,
    influence: Influence,
    /// Those of all bundles, of lines that other ranks share.
    influences: Influence,
    ends: Vec<f64>,
    scratch: Scratch,
    /// Rows along x of a bundle, transposed.
    rows: Vec<f64>,
}

impl VariableLines {
    pub fn new(partition: &CellPartition, periodic: [bool; 3]) -> Self {
        Self {
            shared: std::array::from_fn(|a| SharedLines::new(&partition.row(a), partition.coordinates[a])),
            couplings: Couplings::default(),
            coupled: std::array::from_fn(|a| partition.is_split(a) || periodic[a]),
            coefficients: Coefficients::default(),
            influence: Influence::default(),
            influences: Influence::default(),
            ends: Vec::new(),
            scratch: Scratch::default(),
            rows: Vec::new(),
        }
    }

    /// Solves the factors of all axes for a component, in place.
    pub fn solve_all(
        &mut self,
        local: &Local,
        boundary_data: &[BoundaryData],
        component: usize,
        diagonal: MomentumDiagonal<'_>,
        data: &mut [f64],
        transport: &dyn Transport,
    ) {
        for axis in (0..3).filter(|&a| local.active[a]) {
            let system = System { local, component, axis, diagonal };
            if !local.unknowns(component).contains(&0) {
                self.solve(&system, boundary_data, data, transport);
            }
        }
    }

    /// Solves one factor for all lines of a component, in place.
    fn solve(
        &mut self,
        system: &System<'_>,
        boundary_data: &[BoundaryData],
        data: &mut [f64],
        transport: &dyn Transport,
    ) {
        let (n, axis) = (system.len(), system.axis);
        let is_shared = self.shared[axis].parts() > 1;
        self.ends.clear();
        self.influences.resize(0);
        system.for_bundles(|bundle| {
            system.set(bundle, boundary_data, &mut self.coefficients);
            self.influence.resize(if self.coupled[axis] { n * bundle.lines } else { 0 });
            let mut rows = std::mem::take(&mut self.rows);
            let panel = match axis {
                0 => {
                    rows.resize(n * bundle.lines, 0.0);
                    transpose(data, bundle, n, &mut rows);
                    Panel { start: 0, stride: bundle.lines, lines: bundle.lines }
                }
                _ => Panel {
                    start: bundle.start,
                    stride: system.local.layout.strides()[axis],
                    lines: bundle.lines,
                },
            };
            let lines = if axis == 0 { &mut rows[..] } else { &mut *data };
            system.eliminate((lines, panel), &self.coefficients, &mut self.influence, &mut self.scratch);
            if self.coupled[axis] {
                self.influence.note_ends((lines, panel), n, &mut self.ends);
            }
            if is_shared {
                self.influences.before.extend_from_slice(&self.influence.before);
                self.influences.after.extend_from_slice(&self.influence.after);
            } else if self.coupled[axis] {
                self.exchange(axis, &SerialTransport);
                let Influence { before, after } = &self.influence;
                correct((lines, panel), [before, after], self.shared[axis].around());
                self.ends.clear();
            }
            if axis == 0 {
                gather(&rows, bundle, n, data);
            }
            self.rows = rows;
        });
        if is_shared {
            self.exchange(axis, transport);
            self.correct_shared(system, data);
        }
    }

    /// Finds the values beyond the ends of all lines whose ends were noted; collective where lines are shared.
    fn exchange(&mut self, axis: usize, transport: &dyn Transport) {
        self.shared[axis].join(&self.ends, &mut self.couplings, transport);
    }

    /// Adds to all lines what the values beyond their own parts contribute.
    fn correct_shared(&mut self, system: &System<'_>, data: &mut [f64]) {
        let (n, axis) = (system.len(), system.axis);
        let (mut first, mut around) = (0, self.shared[axis].around());
        system.for_bundles(|bundle| {
            let (now, later) = around.split_at(bundle.lines);
            let own = first..first + n * bundle.lines;
            let influence = [&self.influences.before[own.clone()], &self.influences.after[own.clone()]];
            if axis == 0 {
                self.rows.resize(own.len(), 0.0);
                transpose(data, bundle, n, &mut self.rows);
                let panel = Panel { start: 0, stride: bundle.lines, lines: bundle.lines };
                correct((&mut self.rows, panel), influence, now);
                gather(&self.rows, bundle, n, data);
            } else {
                let stride = system.local.layout.strides()[axis];
                let panel = Panel { start: bundle.start, stride, lines: bundle.lines };
                correct((data, panel), influence, now);
            }
            (first, around) = (own.end, later);
        });
    }
}

/// Adds to the lines of a panel what the values around them contribute.
fn correct((data, panel): (&mut [f64], Panel), [before, after]: [&[f64]; 2], around: &[[f64; 2]]) {
    let rows = before.chunks_exact(panel.lines).zip(after.chunks_exact(panel.lines));
    for (i, (v, w)) in rows.enumerate() {
        let row = &mut data[panel.start + i * panel.stride..][..panel.lines];
        for ((x, around), (v, w)) in row.iter_mut().zip(around).zip(v.iter().zip(w)) {
            *x -= v * around[0] + w * around[1];
        }
    }
}

/// Rows along x of n unknowns, side by side.
fn transpose(data: &[f64], bundle: Bundle, n: usize, rows: &mut [f64]) {
    for l in 0..bundle.lines {
        let row = &data[bundle.start + l * bundle.across..][..n];
        rows[l..].iter_mut().step_by(bundle.lines).zip(row).for_each(|(to, value)| *to = *value);
    }
}

/// The way back.
fn gather(rows: &[f64], bundle: Bundle, n: usize, data: &mut [f64]) {
    for l in 0..bundle.lines {
        let row = &mut data[bundle.start + l * bundle.across..][..n];
        row.iter_mut().zip(rows[l..].iter().step_by(bundle.lines)).for_each(|(value, from)| *value = *from);
    }
}
