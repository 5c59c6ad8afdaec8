//! The implicit factors where void fraction, drag or kinds of boundary differ from place to place.

use super::Porosity;
use crate::boundary::{FaceTable, Kind};
use crate::metrics::Local;
use crate::reduced::{RowGather, Segment, values_around};
use crate::{Faces, Ownership, Side};
use grains_domain::Transport;

/// Coefficients of (m − ½ ν ∇·ε∇) δ = r.
#[derive(Clone, Copy)]
pub(crate) struct Capacity<'a> {
    /// 1/m on the faces (s): 1/(ε/Δt + β/ρ); none where m = 1/Δt.
    pub inverse: Option<&'a Faces>,
    /// Time step Δt (s).
    pub dt: f64,
    /// ε where stresses act; none where it is 1.
    pub void_fraction: Option<Porosity<'a>>,
    /// Kinematic viscosity ν (m²/s).
    pub viscosity: f64,
}

impl Capacity<'_> {
    /// 1/m of a face (s).
    pub fn inverse_at(&self, component: usize, p: usize) -> f64 {
        self.inverse.map_or(self.dt, |faces| faces.component(component)[p])
    }
}

/// Lines solved side by side: few enough for their working set to stay in cache.
const LINES: usize = 64;
/// Rows along x solved side by side, through transposed buffers.
const ROWS: usize = 16;

/// Lines side by side: unknown i of line l at start + i stride + l.
#[derive(Clone, Copy)]
struct Panel {
    start: usize,
    stride: usize,
    lines: usize,
}

/// The arrays of a panel; conductances begin with those of the lower side one stride before the first unknown.
struct Arrays<'a> {
    data: &'a mut [f64],
    conductance: &'a [f64],
    inverse: Option<&'a [f64]>,
    /// Answers to unit values before and after the lines; empty if they stand alone.
    before: &'a mut [f64],
    after: &'a mut [f64],
}

/// Rows of one panel that the elimination needs: of all unknowns, then of one.
#[derive(Clone, Default)]
struct Scratch {
    carried: Vec<f64>,
    low: Vec<f64>,
    pivot: Vec<f64>,
    capacity: Vec<f64>,
}

/// Transposed copies of rows along x, with one unknown more at the beginning.
#[derive(Clone, Default)]
struct Transposed {
    data: Vec<f64>,
    conductance: Vec<f64>,
    inverse: Vec<f64>,
    before: Vec<f64>,
    after: Vec<f64>,
}

/// Solver of the factors, one component and axis at a time.
#[derive(Clone)]
pub(crate) struct VariableLines {
    gathers: [RowGather; 3],
    coupled: [bool; 3],
    /// ½ ν ε / distance at the upper side of every unknown.
    conductance: Vec<f64>,
    before: Vec<f64>,
    after: Vec<f64>,
    ends: Vec<f64>,
    scratch: Scratch,
    rows: Transposed,
}

impl VariableLines {
    pub fn new(local: &Local, ownership: &Ownership, periodic: [bool; 3]) -> Self {
        let coupled = std::array::from_fn(|a| ownership.is_split(a) || periodic[a]);
        let answers = if coupled.contains(&true) { local.layout.len() } else { 0 };
        Self {
            gathers: std::array::from_fn(|a| RowGather::new(&ownership.row(a), ownership.coordinates[a])),
            coupled,
            conductance: vec![0.0; local.layout.len()],
            before: vec![0.0; answers],
            after: vec![0.0; answers],
            ends: Vec::new(),
            scratch: Scratch::default(),
            rows: Transposed::default(),
        }
    }

    /// Solves the factor of one axis for all lines of a component, in place.
    pub fn solve(
        &mut self,
        local: &Local,
        tables: &[FaceTable],
        [component, axis]: [usize; 2],
        capacity: Capacity<'_>,
        data: &mut [f64],
        transport: &dyn Transport,
    ) {
        let system = System { local, component, axis, capacity };
        if local.unknowns(component).contains(&0) {
            return;
        }
        system.set_conductance(&mut self.conductance);
        if component != axis {
            system.close_ends(tables, &mut self.conductance);
        }
        self.ends.clear();
        if axis == 0 {
            self.eliminate_rows(&system, data);
        } else {
            self.eliminate_columns(&system, data);
        }
        if self.coupled[axis] {
            self.gathers[axis].gather(&self.ends, transport);
            self.correct(&system, data);
        }
    }

    /// Lines along y or z, which lie side by side in the arrays.
    fn eliminate_columns(&mut self, system: &System<'_>, data: &mut [f64]) {
        let is_coupled = self.coupled[system.axis];
        let inverse = system.capacity.inverse.map(|faces| faces.component(system.component));
        system.for_panels(|panel| {
            let mut arrays = Arrays {
                data,
                conductance: &self.conductance,
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
        let inverse = system.capacity.inverse.map(|faces| faces.component(system.component));
        system.for_row_groups(|starts| {
            let lines = starts.clone().count();
            let panel = Panel { start: lines, stride: lines, lines };
            let rows = &mut self.rows;
            rows.resize((n + 1) * lines, is_coupled);
            for (l, start) in starts.clone().enumerate() {
                transpose(&data[start..start + n], &mut rows.data[lines + l..], lines);
                transpose(&self.conductance[start - 1..start + n], &mut rows.conductance[l..], lines);
                if let Some(inverse) = inverse {
                    transpose(&inverse[start..start + n], &mut rows.inverse[lines + l..], lines);
                }
            }
            let mut arrays = Arrays {
                data: &mut rows.data,
                conductance: &rows.conductance,
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
        let (gather, ends) = (&self.gathers[system.axis], &self.ends);
        let (n, mut number) = (system.len(), 0);
        let stride = system.local.layout.strides()[system.axis];
        let (v, w) = (&self.before, &self.after);
        let mut correct_line = |start: usize| {
            let part = |k: usize| {
                let e = &gather.message(k, ends)[6 * number..][..6];
                Segment { y: [e[0], e[1]], v: [e[2], e[3]], w: [e[4], e[5]] }
            };
            let [before, after] = values_around(gather.len(), gather.own, part);
            for p in (start..).step_by(stride).take(n) {
                data[p] -= v[p] * before + w[p] * after;
            }
            number += 1;
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
        let answers = if is_coupled { size } else { 0 };
        for (list, size) in [
            (&mut self.data, size),
            (&mut self.conductance, size),
            (&mut self.inverse, size),
            (&mut self.before, answers),
            (&mut self.after, answers),
        ] {
            list.resize(size, 0.0);
        }
    }
}

impl Arrays<'_> {
    /// Notes the first and last values of all lines and of their answers.
    fn note_ends(&self, panel: Panel, n: usize, ends: &mut Vec<f64>) {
        for first in panel.start..panel.start + panel.lines {
            let last = first + (n - 1) * panel.stride;
            let both = |x: &[f64]| [x[first], x[last]];
            ends.extend([both(self.data), both(self.before), both(self.after)].as_flattened());
        }
    }
}

/// The factor of one component and axis: row i is diagonal x − low x₋ − high x₊.
struct System<'a> {
    local: &'a Local,
    component: usize,
    axis: usize,
    capacity: Capacity<'a>,
}

/// What the conductances l, h below and above make of a row: low = l + a h, high = h + b l (or none at the ends of the
/// box), diagonal = 1 + c l + d h.
#[derive(Clone, Copy)]
struct RowKind {
    low: [f64; 2],
    high: [f64; 2],
    diagonal: [f64; 2],
}

impl System<'_> {
    fn len(&self) -> usize {
        self.local.unknowns(self.component)[self.axis]
    }

    /// Row i, with what the ghosts beyond the ends of the box add.
    fn kind(&self, i: usize) -> RowKind {
        let ends = self.local.ends[self.axis];
        let mut kind = RowKind { low: [1.0, 0.0], high: [0.0, 1.0], diagonal: [1.0, 1.0] };
        // Share of the first cell taken off the ghost, and that of the second.
        let ghost = |side: usize| match self.component == self.axis {
            true => [1.0, 0.0],
            false => [1.0 - self.local.walls[self.axis][side][1], self.local.walls[self.axis][side][2]],
        };
        let (is_first, is_last) = (i == 0 && ends[0], i + 1 == self.len() && ends[1]);
        if is_first {
            kind.low[0] = 0.0;
            kind.high[0] = ghost(0)[1];
            kind.diagonal[0] = ghost(0)[0];
        }
        if is_last {
            kind.low[1] = if is_first { 0.0 } else { ghost(1)[1] };
            kind.high = [0.0; 2];
            kind.diagonal[1] = ghost(1)[0];
        }
        kind
    }

    /// Inverse width (1/m) of the control volume of unknown i along the axis.
    fn inverse_width(&self, i: usize) -> f64 {
        let (m, e) = (&self.local.axes[self.axis], self.local.entry(i));
        if self.component == self.axis { m.inverse_distance[e] } else { m.inverse_width[e] }
    }

    /// Sets ½ ν ε/distance at the upper side of every unknown and at the lower one of the first.
    fn set_conductance(&self, conductance: &mut [f64]) {
        let (layout, n, axis) = (self.local.layout, self.local.unknowns(self.component), self.axis);
        let (m, half) = (&self.local.axes[axis], 0.5 * self.capacity.viscosity);
        // Own stresses act in the cell above the face.
        let (inverse, shift) = match self.component == axis {
            true => (&m.inverse_width[1..], layout.strides()[axis]),
            false => (&m.inverse_distance[..], 0),
        };
        let eps = self.capacity.void_fraction.map(|eps| match self.component == axis {
            true => eps.centres,
            false => eps.edges[3 - self.component - axis],
        });
        let mut from = [0_isize; 3];
        from[axis] = -1;
        let count = (n[0] as isize - from[0]) as usize;
        for k in from[2]..n[2] as isize {
            for j in from[1]..n[1] as isize {
                let start = layout.index(from[0], j, k);
                let row = &mut conductance[start..start + count];
                let e = ([from[0], j, k][axis] + layout.halo as isize) as usize;
                let eps = eps.map(|eps| &eps[start + shift..][..count]);
                if axis == 0 {
                    row.iter_mut().zip(&inverse[e..]).for_each(|(c, inverse)| *c = half * inverse);
                } else {
                    row.fill(half * inverse[e]);
                }
                if let Some(eps) = eps {
                    row.iter_mut().zip(eps).for_each(|(c, eps)| *c *= eps);
                }
            }
        }
    }

    /// Beyond the box there is no neighbour unless it is imposed.
    fn close_ends(&self, tables: &[FaceTable], conductance: &mut [f64]) {
        let (layout, stride) = (self.local.layout, self.local.layout.strides()[self.axis]);
        for table in tables.iter().filter(|t| t.face.axis == self.axis) {
            for m2 in layout.halo..table.extents[1] - layout.halo {
                for m1 in layout.halo..table.extents[0] - layout.halo {
                    let inside = table.inside(layout, m1, m2);
                    let upper = if table.face.side == Side::High { inside } else { inside - stride };
                    if table.kinds[self.component][m2 * table.extents[0] + m1] != Kind::Fixed {
                        conductance[upper] = 0.0;
                    }
                }
            }
        }
    }

    /// Solves the own part of the lines of a panel.
    fn eliminate(&self, panel: Panel, arrays: &mut Arrays<'_>, scratch: &mut Scratch) {
        let (n, Panel { start, stride, lines }) = (self.len(), panel);
        scratch.resize(n * lines, lines, self.capacity.dt);
        for i in 0..n {
            let p = start + i * stride;
            self.set_row(i, arrays, [p, stride, lines], scratch);
            let (low, pivot) = (&scratch.low[..lines], &scratch.pivot[..lines]);
            advance(arrays.data, [p, stride, lines], [low, pivot], i > 0);
            if !arrays.before.is_empty() {
                let high = &scratch.carried[i * lines..][..lines];
                start_answers(arrays, [p, lines], [low, pivot, high], [i == 0, i + 1 == n]);
                advance_answers(arrays, [p, stride, lines], [low, pivot], i > 0);
            }
        }
        for i in (0..n.saturating_sub(1)).rev() {
            let carried = &scratch.carried[i * lines..][..lines];
            for list in [&mut *arrays.data, &mut *arrays.before, &mut *arrays.after] {
                if !list.is_empty() {
                    retreat(list, [start + i * stride, stride, lines], carried);
                }
            }
        }
    }

    /// Coefficient below, inverse pivot and carried coefficient of row i.
    fn set_row(&self, i: usize, arrays: &Arrays<'_>, [p, stride, lines]: [usize; 3], scratch: &mut Scratch) {
        let below = &arrays.conductance[p - stride..][..lines];
        let above = &arrays.conductance[p..][..lines];
        let inverse = arrays.inverse.map_or(&scratch.capacity[..lines], |inverse| &inverse[p..p + lines]);
        let (RowKind { low: a, high: b, diagonal: c }, width) = (self.kind(i), self.inverse_width(i));
        let (done, carried) = scratch.carried.split_at_mut(i * lines);
        let (carried, low) = (&mut carried[..lines], &mut scratch.low[..lines]);
        let pivot = &mut scratch.pivot[..lines];
        for l in 0..lines {
            let factor = inverse[l] * width;
            let (down, up) = (factor * below[l], factor * above[l]);
            low[l] = a[0] * down + a[1] * up;
            carried[l] = b[0] * down + b[1] * up;
            pivot[l] = 1.0 + c[0] * down + c[1] * up;
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

    /// Panels of lines along y or z.
    fn for_panels(&self, mut job: impl FnMut(Panel)) {
        let (layout, [nx, ny, nz]) = (self.local.layout, self.local.unknowns(self.component));
        let stride = layout.strides()[self.axis];
        let parts = nx.div_ceil(LINES);
        for slab in 0..if self.axis == 1 { nz } else { ny } {
            let row = if self.axis == 1 { layout.row(0, slab) } else { layout.row(slab, 0) };
            for part in 0..parts {
                let (first, end) = (nx * part / parts, nx * (part + 1) / parts);
                job(Panel { start: row + first, stride, lines: end - first });
            }
        }
    }

    /// Starts of rows along x, some at a time.
    fn for_row_groups(&self, mut job: impl FnMut(std::iter::StepBy<std::ops::Range<usize>>)) {
        let (layout, [_, ny, nz]) = (self.local.layout, self.local.unknowns(self.component));
        let stride = layout.strides()[1];
        for k in 0..nz {
            for j in (0..ny).step_by(ROWS) {
                let (first, rows) = (layout.row(j, k), ROWS.min(ny - j));
                job((first..first + rows * stride).step_by(stride));
            }
        }
    }
}

impl Scratch {
    fn resize(&mut self, all: usize, lines: usize, dt: f64) {
        self.carried.resize(all, 0.0);
        [&mut self.low, &mut self.pivot].into_iter().for_each(|list| list.resize(lines, 0.0));
        self.capacity.clear();
        self.capacity.resize(lines, dt);
    }
}

/// x = (x + low x₋) pivot for the row at p.
fn advance(x: &mut [f64], [p, stride, lines]: [usize; 3], [low, pivot]: [&[f64]; 2], has_previous: bool) {
    let (done, ahead) = x.split_at_mut(p);
    let current = &mut ahead[..lines];
    if has_previous {
        let previous = &done[p - stride..][..lines];
        current.iter_mut().zip(low).zip(previous).for_each(|((x, low), before)| *x += low * before);
    }
    current.iter_mut().zip(pivot).for_each(|(x, pivot)| *x *= pivot);
}

/// x += carried x₊ for the row at p.
fn retreat(x: &mut [f64], [p, stride, lines]: [usize; 3], carried: &[f64]) {
    let (current, ahead) = x.split_at_mut(p + stride);
    let current = current[p..][..lines].iter_mut().zip(carried);
    current.zip(&ahead[..lines]).for_each(|((x, carried), next)| *x += carried * next);
}

/// Right-hand sides of the answers to unit values: −low before the first unknown, −high after the last. The coefficient
/// above is the carried one over the pivot.
fn start_answers(
    arrays: &mut Arrays<'_>,
    [p, lines]: [usize; 2],
    [low, pivot, carried]: [&[f64]; 3],
    [is_first, is_last]: [bool; 2],
) {
    let before = &mut arrays.before[p..p + lines];
    before.iter_mut().zip(low).for_each(|(v, low)| *v = if is_first { -low } else { 0.0 });
    let after = &mut arrays.after[p..p + lines];
    for ((w, pivot), carried) in after.iter_mut().zip(pivot).zip(carried) {
        *w = if is_last { -carried / pivot } else { 0.0 };
    }
}

fn advance_answers(arrays: &mut Arrays<'_>, row: [usize; 3], factors: [&[f64]; 2], has_previous: bool) {
    advance(arrays.before, row, factors, has_previous);
    advance(arrays.after, row, factors, has_previous);
}
