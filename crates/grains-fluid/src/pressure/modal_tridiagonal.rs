//! The ordinary differential equation that remains per mode: tridiagonal along the third axis.

use super::PressureProblem;
use crate::tridiagonal::{Couplings, Panel, SharedLines};
use grains_domain::Transport;
use multiversion::multiversion;

/// Coefficients c that depend on the place along the line axis only; global, the same on all ranks.
#[derive(Clone, Debug, PartialEq, Default)]
pub(crate) struct LineProfile {
    /// Across: of the faces normal to the two transformed axes, per cell.
    pub across: [Vec<f64>; 2],
    /// Along: of the faces normal to the line axis, from the lower boundary's to the upper's; n + 1 numbers.
    pub along: Vec<f64>,
}

/// Tridiagonal solver along the line axis of a block `[nz][ny][nx]` of modes.
#[derive(Clone)]
pub(crate) struct ModalTridiagonal {
    axis: usize,
    cells: [usize; 3],
    is_coupled: bool,
    /// λ of the two transformed axes per line.
    lambda: [Vec<f64>; 2],
    /// Per own cell: off-diagonals and the parts of the (negated) diagonal.
    lower: Vec<f64>,
    upper: Vec<f64>,
    base: Vec<f64>,
    across: [Vec<f64>; 2],
    /// Line of the constant, and what is added to its first diagonal where it has no pressure imposed.
    pinned: Option<(usize, f64)>,
    shared: SharedLines,
    /// Of every line of the own share.
    couplings: Vec<Couplings>,
    ends: Vec<f64>,
    scratch: Scratch,
}

#[derive(Clone, Default)]
struct Scratch {
    panel: Vec<f64>,
    carried: Vec<f64>,
    rows: Vec<f64>,
}

/// Lines solved side by side: few enough for their working set to stay in cache.
const LINES: usize = 64;
/// Lines along x are transposed in blocks of this many.
const ROWS: usize = 16;

impl ModalTridiagonal {
    /// Lines along `axis` for modes with the eigenvalues of the other two axes (ascending axis order).
    pub fn new(problem: &PressureProblem, axis: usize, eigenvalues: [&[f64]; 2]) -> Self {
        let partition = &problem.partition;
        let (cells, first) = (partition.cells(), partition.first());
        let others = [usize::from(axis == 0), if axis == 2 { 1 } else { 2 }];
        let [n1, n2] = others.map(|a| cells[a]);
        let lambda = std::array::from_fn(|o| {
            let at = |l: usize| if o == 0 { l % n1 } else { l / n1 };
            (0..n1 * n2).map(|l| eigenvalues[o][first[others[o]] + at(l)]).collect()
        });
        let (row, own) = (partition.row(axis), partition.coordinates[axis]);
        Self {
            axis,
            cells,
            is_coupled: partition.is_split(axis) || problem.grid.axis(axis).is_periodic(),
            lambda,
            lower: Vec::new(),
            upper: Vec::new(),
            base: Vec::new(),
            across: Default::default(),
            pinned: None,
            shared: SharedLines::new(&row, own),
            couplings: Vec::new(),
            ends: Vec::new(),
            scratch: Scratch::default(),
        }
    }

    fn len(&self) -> usize {
        self.cells[self.axis]
    }

    /// Takes coefficients; collective.
    pub fn set(&mut self, problem: &PressureProblem, profile: &LineProfile, transport: &dyn Transport) {
        let axis = problem.grid.axis(self.axis);
        let (n, first) = (axis.cells(), problem.partition.first()[self.axis]);
        let (periodic, own) = (axis.is_periodic(), first..first + self.len());
        let is_inner = |face: usize| (face > 0 && face < n) || periodic && n > 1;
        let conductance = |face: usize| {
            let i = face as isize;
            let distance = axis.centre(i) - axis.centre(i - 1);
            match (is_inner(face), periodic) {
                (true, _) => profile.along[face] / distance,
                (false, true) => 0.0,
                (false, false) => 2.0 * profile.along[face] / distance,
            }
        };
        let inner = |face: usize| if is_inner(face) { conductance(face) } else { 0.0 };
        self.lower = own.clone().map(inner).collect();
        self.upper = own.clone().map(|i| inner(i + 1)).collect();
        self.base = own.clone().map(|i| conductance(i) + conductance(i + 1)).collect();
        for (across, given) in self.across.iter_mut().zip(&profile.across) {
            *across = own.clone().map(|i| -given[i] * axis.width(i as isize)).collect();
        }
        let constant = (0..self.lambda[0].len()).find(|&l| self.lambda.iter().all(|lambda| lambda[l] == 0.0));
        let size = if self.upper[0] > 0.0 { self.upper[0] } else { 1.0 };
        let is_floating = problem.is_singular() && first == 0;
        self.pinned = constant.filter(|_| is_floating).map(|line| (line, size));
        if self.is_coupled {
            self.set_influence(transport);
        }
    }

    /// Line of the constant, if its modes are here.
    pub fn constant_line(&self) -> Option<usize> {
        (0..self.lambda[0].len()).find(|&l| self.lambda.iter().all(|lambda| lambda[l] == 0.0))
    }

    /// Place in the block of cell 0 of a line and the distance of its cells.
    pub fn line(&self, number: usize) -> (usize, usize) {
        let [nx, ny, _] = self.cells;
        match self.axis {
            0 => (number * nx, 1),
            1 => (number / nx * nx * ny + number % nx, nx),
            _ => (number, nx * ny),
        }
    }

    /// Influence vectors of the own part of every line for unit values beyond its ends.
    fn set_influence(&mut self, transport: &dyn Transport) {
        let (n, count) = (self.len(), self.lambda[0].len());
        let mut scratch = std::mem::take(&mut self.scratch);
        let mut influence = Vec::with_capacity(4 * count);
        for first in (0..count).step_by(LINES) {
            let lines = LINES.min(count - first);
            let mut ends = [0.0, 0.0, 0.0, 0.0].repeat(lines);
            for (side, place, coupling) in [(0, 0, self.lower[0]), (1, n - 1, self.upper[n - 1])] {
                scratch.panel.clear();
                scratch.panel.resize(n * lines, 0.0);
                scratch.panel[place * lines..][..lines].fill(-coupling);
                thomas(self, &mut scratch.panel, side_by_side(lines), first, &mut scratch.carried);
                for l in 0..lines {
                    ends[4 * l + 2 * side] = scratch.panel[l];
                    ends[4 * l + 2 * side + 1] = scratch.panel[(n - 1) * lines + l];
                }
            }
            influence.extend(ends);
        }
        self.scratch = scratch;
        self.shared.collect(&influence, 4, transport);
        let (shared, parts) = (&self.shared, self.shared.parts());
        self.couplings.resize_with(shared.count(), Couplings::default);
        for (number, couplings) in self.couplings.iter_mut().enumerate() {
            let line = shared.line(number);
            couplings.join(parts, |part| {
                let a = line.part(part);
                [[a[0], a[1]], [a[2], a[3]]]
            });
        }
    }

    /// Solves all lines of the block in place for the right-hand side −d; collective.
    pub fn solve(&mut self, block: &mut [f64], transport: &dyn Transport) {
        let mut scratch = std::mem::take(&mut self.scratch);
        if self.is_coupled {
            self.find_ends(block, &mut scratch);
            self.shared.collect(&self.ends, 2, transport);
            let couplings = &mut self.couplings;
            self.shared.solve(transport, |number, line, put| {
                couplings[number].solve(|part| [line.part(part)[0], line.part(part)[1]], put);
            });
            self.impose_ends(block);
        }
        self.for_panels(block, &mut scratch, |lines, data, panel, first, carried| {
            thomas(lines, data, panel, first, carried);
        });
        self.scratch = scratch;
    }

    /// Ends of the own parts with zeros beyond them; the block stays as it is.
    fn find_ends(&mut self, block: &mut [f64], scratch: &mut Scratch) {
        let n = self.len();
        let mut ends = std::mem::take(&mut self.ends);
        let mut copy = std::mem::take(&mut scratch.panel);
        ends.clear();
        self.for_panels(block, scratch, |this, data, panel, first, carried| {
            let Panel { start, stride, lines } = panel;
            copy.resize(n * lines, 0.0);
            for (i, row) in copy.chunks_exact_mut(lines).enumerate() {
                row.copy_from_slice(&data[start + i * stride..][..lines]);
            }
            thomas(this, &mut copy, side_by_side(lines), first, carried);
            ends.extend((0..lines).flat_map(|l| [copy[l], copy[(n - 1) * lines + l]]));
        });
        scratch.panel = copy;
        self.ends = ends;
    }

    /// Moves the values beyond the ends of the own parts to the right-hand side.
    fn impose_ends(&mut self, block: &mut [f64]) {
        let n = self.len();
        for (number, [before, after]) in self.shared.around().iter().enumerate() {
            let (start, stride) = self.line(number);
            block[start] += self.lower[0] * before;
            block[start + (n - 1) * stride] += self.upper[n - 1] * after;
        }
    }

    /// Runs `job` on panels of lines that lie side by side; lines along x are transposed for it.
    fn for_panels(
        &self,
        block: &mut [f64],
        scratch: &mut Scratch,
        mut job: impl FnMut(&Self, &mut [f64], Panel, usize, &mut Vec<f64>),
    ) {
        let [nx, ny, nz] = self.cells;
        let carried = &mut scratch.carried;
        match self.axis {
            0 => {
                let rows = &mut scratch.rows;
                for first in (0..ny * nz).step_by(ROWS) {
                    let lines = ROWS.min(ny * nz - first);
                    rows.resize(nx * lines, 0.0);
                    let panel = &mut block[first * nx..(first + lines) * nx];
                    for (l, line) in panel.chunks_exact(nx).enumerate() {
                        rows[l..].iter_mut().step_by(lines).zip(line).for_each(|(r, x)| *r = *x);
                    }
                    job(self, rows, side_by_side(lines), first, carried);
                    for (l, line) in panel.chunks_exact_mut(nx).enumerate() {
                        line.iter_mut().zip(rows[l..].iter().step_by(lines)).for_each(|(x, r)| *x = *r);
                    }
                }
            }
            1 => (0..nz).for_each(|k| {
                let panel = Panel { start: k * nx * ny, stride: nx, lines: nx };
                job(self, block, panel, k * nx, carried);
            }),
            _ => {
                for first in (0..nx * ny).step_by(LINES) {
                    let lines = LINES.min(nx * ny - first);
                    let panel = Panel { start: first, stride: nx * ny, lines };
                    job(self, block, panel, first, carried);
                }
            }
        }
    }
}

/// Thomas elimination of the lines of a panel, from line number `first` on.
///
/// Solves −(lower x₋ − diagonal x + upper x₊) = −d: the sign of the operator is turned once, in `solve`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn thomas(modes: &ModalTridiagonal, data: &mut [f64], panel: Panel, first: usize, carried: &mut Vec<f64>) {
    let (n, lines) = (modes.len(), panel.lines);
    carried.resize(n * lines, 0.0);
    let (l1, l2) = (&modes.lambda[0][first..first + lines], &modes.lambda[1][first..first + lines]);
    let pin = modes.pinned.filter(|p| (first..first + lines).contains(&p.0));
    for i in 0..n {
        let (base, a1, a2) = (modes.base[i], modes.across[0][i], modes.across[1][i]);
        let (low, high) = (modes.lower[i], modes.upper[i]);
        let (carried_done, carried_now) = carried.split_at_mut(i * lines);
        let carried_now = &mut carried_now[..lines];
        if i == 0 {
            panel.forward(data, i, |l| {
                let extra = pin.map_or(0.0, |(line, size)| if line == first + l { size } else { 0.0 });
                let inverse = 1.0 / (base + a1 * l1[l] + a2 * l2[l] + extra);
                carried_now[l] = high * inverse;
                [0.0, inverse]
            });
        } else {
            let previous = &carried_done[(i - 1) * lines..][..lines];
            panel.forward(data, i, |l| {
                let inverse = 1.0 / (base + a1 * l1[l] + a2 * l2[l] - low * previous[l]);
                carried_now[l] = high * inverse;
                [low, inverse]
            });
        }
    }
    for i in (0..n.saturating_sub(1)).rev() {
        let carried = &carried[i * lines..][..lines];
        panel.backward(data, i, |l| carried[l]);
    }
}

/// A panel that holds nothing but its lines.
fn side_by_side(lines: usize) -> Panel {
    Panel { start: 0, stride: lines, lines }
}
