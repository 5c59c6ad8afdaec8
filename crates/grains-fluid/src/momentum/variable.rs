//! The implicit factors where void fraction, viscosity, drag or kinds of boundary differ from place to place.

use super::system::{Arrays, MomentumDiagonal, Scratch, System};
use crate::CellPartition;
use crate::boundary::BoundaryData;
use crate::metrics::Local;
use crate::tridiagonal::{Couplings, Panel, SharedLines};
use grains_domain::Transport;

/// Transposed copies of rows along x, with one unknown more at the beginning.
#[derive(Clone, Default)]
struct Transposed {
    data: Vec<f64>,
    conductance: Vec<f64>,
    carried: Vec<f64>,
    inverse: Vec<f64>,
    before: Vec<f64>,
    after: Vec<f64>,
}

/// Solver of the factors, one component and axis at a time.
#[derive(Clone)]
pub(crate) struct VariableLines {
    shared: [SharedLines; 3],
    couplings: Couplings,
    coupled: [bool; 3],
    /// θ ν w / distance at the upper side of every unknown.
    conductance: Vec<f64>,
    /// What carries momentum through the same sides, if that is implicit.
    carried: Vec<f64>,
    before: Vec<f64>,
    after: Vec<f64>,
    ends: Vec<f64>,
    scratch: Scratch,
    rows: Transposed,
}

impl VariableLines {
    pub fn new(local: &Local, partition: &CellPartition, periodic: [bool; 3]) -> Self {
        let coupled = std::array::from_fn(|a| partition.is_split(a) || periodic[a]);
        let influence = if coupled.contains(&true) { local.layout.len() } else { 0 };
        Self {
            shared: std::array::from_fn(|a| SharedLines::new(&partition.row(a), partition.coordinates[a])),
            couplings: Couplings::default(),
            coupled,
            conductance: vec![0.0; local.layout.len()],
            carried: Vec::new(),
            before: vec![0.0; influence],
            after: vec![0.0; influence],
            ends: Vec::new(),
            scratch: Scratch::default(),
            rows: Transposed::default(),
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
            self.solve(local, boundary_data, [component, axis], diagonal, data, transport);
        }
    }

    /// Solves the factor of one axis for all lines of a component, in place.
    fn solve(
        &mut self,
        local: &Local,
        boundary_data: &[BoundaryData],
        [component, axis]: [usize; 2],
        diagonal: MomentumDiagonal<'_>,
        data: &mut [f64],
        transport: &dyn Transport,
    ) {
        let system = System { local, component, axis, diagonal };
        if local.unknowns(component).contains(&0) {
            return;
        }
        system.set_conductance(&mut self.conductance);
        if component != axis {
            system.close_ends(boundary_data, &mut self.conductance);
        }
        if let Some(carrier) = diagonal.carrier {
            self.carried.resize(local.layout.len(), 0.0);
            system.set_carried(carrier, &mut self.carried);
            if component != axis {
                system.close_ends(boundary_data, &mut self.carried);
            }
        } else {
            self.carried.clear();
        }
        self.ends.clear();
        if axis == 0 {
            self.eliminate_rows(&system, data);
        } else {
            self.eliminate_columns(&system, data);
        }
        if self.coupled[axis] {
            let (shared, couplings) = (&mut self.shared[axis], &mut self.couplings);
            shared.collect(&self.ends, 6, transport);
            let parts = shared.parts();
            shared.solve(transport, |_, line, put| {
                couplings.join(parts, |part| {
                    let e = line.part(part);
                    [[e[2], e[3]], [e[4], e[5]]]
                });
                couplings.solve(|part| [line.part(part)[0], line.part(part)[1]], put);
            });
            self.correct(&system, data);
        }
    }

    /// Lines along y or z, which lie side by side in the arrays.
    fn eliminate_columns(&mut self, system: &System<'_>, data: &mut [f64]) {
        let is_coupled = self.coupled[system.axis];
        let inverse = system.diagonal.inverse.map(|faces| faces.component(system.component));
        system.for_panels(|panel| {
            let mut arrays = Arrays {
                data,
                conductance: &self.conductance,
                carried: &self.carried,
                inverse,
                before: if is_coupled { &mut self.before } else { &mut [] },
                after: if is_coupled { &mut self.after } else { &mut [] },
            };
            system.eliminate(panel, &mut arrays, &mut self.scratch);
            if is_coupled {
                arrays.note_ends(panel, system.len(), &mut self.ends);
            }
        });
    }

    /// Lines along x, transposed some at a time.
    fn eliminate_rows(&mut self, system: &System<'_>, data: &mut [f64]) {
        let (n, is_coupled) = (system.len(), self.coupled[0]);
        let inverse = system.diagonal.inverse.map(|faces| faces.component(system.component));
        system.for_row_groups(|starts| {
            let lines = starts.clone().count();
            let panel = Panel { start: lines, stride: lines, lines };
            let rows = &mut self.rows;
            rows.resize((n + 1) * lines, is_coupled);
            for (l, start) in starts.clone().enumerate() {
                transpose(&data[start..start + n], &mut rows.data[lines + l..], lines);
                transpose(&self.conductance[start - 1..start + n], &mut rows.conductance[l..], lines);
                if !self.carried.is_empty() {
                    transpose(&self.carried[start - 1..start + n], &mut rows.carried[l..], lines);
                }
                if let Some(inverse) = inverse {
                    transpose(&inverse[start..start + n], &mut rows.inverse[lines + l..], lines);
                }
            }
            let mut arrays = Arrays {
                data: &mut rows.data,
                conductance: &rows.conductance,
                carried: if self.carried.is_empty() { &[] } else { &rows.carried },
                inverse: inverse.map(|_| &rows.inverse[..]),
                before: &mut rows.before,
                after: &mut rows.after,
            };
            system.eliminate(panel, &mut arrays, &mut self.scratch);
            if is_coupled {
                arrays.note_ends(panel, n, &mut self.ends);
            }
            for (l, start) in starts.enumerate() {
                gather(&rows.data[lines + l..], &mut data[start..start + n], lines);
                if is_coupled {
                    gather(&rows.before[lines + l..], &mut self.before[start..start + n], lines);
                    gather(&rows.after[lines + l..], &mut self.after[start..start + n], lines);
                }
            }
        });
    }

    /// Adds to all lines what the values beyond their own parts contribute.
    fn correct(&mut self, system: &System<'_>, data: &mut [f64]) {
        let (n, mut lines) = (system.len(), self.shared[system.axis].around().iter());
        let stride = system.local.layout.strides()[system.axis];
        let (v, w) = (&self.before, &self.after);
        let mut correct_line = |start: usize| {
            let [before, after] = lines.next().copied().unwrap_or_default();
            for p in (start..).step_by(stride).take(n) {
                data[p] -= v[p] * before + w[p] * after;
            }
        };
        if system.axis == 0 {
            system.for_row_groups(|starts| starts.for_each(&mut correct_line));
        } else {
            system.for_panels(|panel| (panel.start..panel.start + panel.lines).for_each(&mut correct_line));
        }
    }
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
        for (list, size) in [
            (&mut self.data, size),
            (&mut self.conductance, size),
            (&mut self.carried, size),
            (&mut self.inverse, size),
            (&mut self.before, influence),
            (&mut self.after, influence),
        ] {
            list.resize(size, 0.0);
        }
    }
}
