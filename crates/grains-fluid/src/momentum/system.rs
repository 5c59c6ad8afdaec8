//! One factor of the implicit diffusion as a tridiagonal system, and its elimination along lines side by side.

use super::StressWeights;
use crate::boundary::{BoundaryData, Kind};
use crate::metrics::Local;
use crate::tridiagonal::Panel;
use crate::{Faces, Side};

/// Coefficients of (m − θ ν ∇·w∇) δ = r.
#[derive(Clone, Copy)]
pub(crate) struct MomentumDiagonal<'a> {
    /// 1/m on the faces (s): 1/(ε/Δt + β/ρ); none where m = 1/Δt.
    pub inverse: Option<&'a Faces>,
    /// Time step Δt (s).
    pub dt: f64,
    /// Weights w of the stresses; none where they are 1.
    pub weights: Option<StressWeights<'a>>,
    /// Kinematic viscosity ν (m²/s).
    pub viscosity: f64,
    /// What carries momentum implicitly, by upwind differences; none where advection is explicit.
    pub carrier: Option<&'a Faces>,
    /// Share θ of the end of the step (-).
    pub implicitness: f64,
    /// Whether the operator is that of the whole stress, ∇·w(∇ + ∇ᵀ).
    pub is_full: bool,
}

impl MomentumDiagonal<'_> {
    /// 1/m of a face (s).
    pub fn inverse_at(&self, component: usize, p: usize) -> f64 {
        self.inverse.map_or(self.dt, |faces| faces.component(component)[p])
    }

    /// θ ν (m²/s), twice that of normal stresses, which are their own transpose.
    pub fn share(&self, is_normal: bool) -> f64 {
        let share = self.implicitness * self.viscosity;
        if self.is_full && is_normal { 2.0 * share } else { share }
    }
}

/// Lines solved side by side: few enough for their working set to stay in cache.
const LINES: usize = 64;
/// Rows along x solved side by side, through transposed buffers.
const ROWS: usize = 16;

/// The arrays of a panel; conductances begin with those of the lower side one stride before the first unknown.
pub(super) struct Arrays<'a> {
    pub data: &'a mut [f64],
    pub conductance: &'a [f64],
    /// Volume fluxes per area (m/s) that carry momentum through the same sides; empty if diffusion alone is implicit.
    pub carried: &'a [f64],
    pub inverse: Option<&'a [f64]>,
    /// Influence vectors for unit values before and after the lines; empty if they stand alone.
    pub before: &'a mut [f64],
    pub after: &'a mut [f64],
}

/// Rows of one panel that the elimination needs: of all unknowns, then of one.
#[derive(Clone, Default)]
pub(super) struct Scratch {
    carried: Vec<f64>,
    low: Vec<f64>,
    pivot: Vec<f64>,
    diagonal: Vec<f64>,
}

/// The factor of one component and axis: row i is diagonal x − low x₋ − high x₊.
pub(super) struct System<'a> {
    pub local: &'a Local,
    pub component: usize,
    pub axis: usize,
    pub diagonal: MomentumDiagonal<'a>,
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
    pub fn len(&self) -> usize {
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

    /// Sets θ ν w/distance at the upper side of every unknown and at the lower one of the first.
    pub fn set_conductance(&self, conductance: &mut [f64]) {
        let (layout, n, axis) = (self.local.layout, self.local.unknowns(self.component), self.axis);
        let (m, share) = (&self.local.axes[axis], self.diagonal.share(self.component == axis));
        // Own stresses act in the cell above the face.
        let (inverse, shift) = match self.component == axis {
            true => (&m.inverse_width[1..], layout.strides()[axis]),
            false => (&m.inverse_distance[..], 0),
        };
        let weights = self.diagonal.weights.map(|weights| match self.component == axis {
            true => weights.centres[axis],
            false => weights.edges[self.component][axis],
        });
        let mut from = [0_isize; 3];
        from[axis] = -1;
        let count = (n[0] as isize - from[0]) as usize;
        for k in from[2]..n[2] as isize {
            for j in from[1]..n[1] as isize {
                let start = layout.index(from[0], j, k);
                let row = &mut conductance[start..start + count];
                let e = ([from[0], j, k][axis] + layout.halo as isize) as usize;
                let weights = weights.map(|weights| &weights[start + shift..][..count]);
                if axis == 0 {
                    row.iter_mut().zip(&inverse[e..]).for_each(|(c, inverse)| *c = share * inverse);
                } else {
                    row.fill(share * inverse[e]);
                }
                if let Some(weights) = weights {
                    row.iter_mut().zip(weights).for_each(|(c, weight)| *c *= weight);
                }
            }
        }
    }

    /// Sets the volume flux per area through the upper side of every unknown and the lower one of the first.
    pub fn set_carried(&self, velocity: &Faces, carried: &mut [f64]) {
        let (layout, n, axis) = (self.local.layout, self.local.unknowns(self.component), self.axis);
        let q = velocity.component(axis);
        let shift = layout.strides()[self.component];
        let mut from = [0_isize; 3];
        from[axis] = -1;
        let count = (n[0] as isize - from[0]) as usize;
        for k in from[2]..n[2] as isize {
            for j in from[1]..n[1] as isize {
                let start = layout.index(from[0], j, k);
                let (here, next) = (&q[start..][..count], &q[start + shift..][..count]);
                let row = &mut carried[start..][..count];
                row.iter_mut().zip(here).zip(next).for_each(|((m, a), b)| *m = 0.5 * (a + b));
            }
        }
    }

    /// Beyond the box there is no neighbour unless it is imposed.
    pub fn close_ends(&self, boundary_data: &[BoundaryData], conductance: &mut [f64]) {
        let (layout, stride) = (self.local.layout, self.local.layout.strides()[self.axis]);
        for face_data in boundary_data.iter().filter(|t| t.face.axis == self.axis) {
            for m2 in layout.halo..face_data.extents[1] - layout.halo {
                for m1 in layout.halo..face_data.extents[0] - layout.halo {
                    let inside = face_data.inside(layout, m1, m2);
                    let upper = if face_data.face.side == Side::High { inside } else { inside - stride };
                    if face_data.kinds[self.component][m2 * face_data.extents[0] + m1] != Kind::Fixed {
                        conductance[upper] = 0.0;
                    }
                }
            }
        }
    }

    /// Solves the own part of the lines of a panel.
    pub fn eliminate(&self, panel: Panel, arrays: &mut Arrays<'_>, scratch: &mut Scratch) {
        let (n, Panel { start, stride, lines }) = (self.len(), panel);
        scratch.resize(n * lines, lines, self.diagonal.dt);
        for i in 0..n {
            let p = start + i * stride;
            self.set_row(i, arrays, [p, stride, lines], scratch);
            let (low, pivot) = (&scratch.low[..lines], &scratch.pivot[..lines]);
            panel.forward(arrays.data, i, |l| [low[l], pivot[l]]);
            if !arrays.before.is_empty() {
                let high = &scratch.carried[i * lines..][..lines];
                start_influence(arrays, [p, lines], [low, pivot, high], [i == 0, i + 1 == n]);
                panel.forward(arrays.before, i, |l| [low[l], pivot[l]]);
                panel.forward(arrays.after, i, |l| [low[l], pivot[l]]);
            }
        }
        for i in (0..n.saturating_sub(1)).rev() {
            let carried = &scratch.carried[i * lines..][..lines];
            for list in [&mut *arrays.data, &mut *arrays.before, &mut *arrays.after] {
                if !list.is_empty() {
                    panel.backward(list, i, |l| carried[l]);
                }
            }
        }
    }

    /// Coefficient below, inverse pivot and carried coefficient of row i.
    fn set_row(&self, i: usize, arrays: &Arrays<'_>, [p, stride, lines]: [usize; 3], scratch: &mut Scratch) {
        let below = &arrays.conductance[p - stride..][..lines];
        let above = &arrays.conductance[p..][..lines];
        let inverse = arrays.inverse.map_or(&scratch.diagonal[..lines], |inverse| &inverse[p..p + lines]);
        let (RowKind { low: a, high: b, diagonal: c }, width) = (self.kind(i), self.inverse_width(i));
        let (done, carried) = scratch.carried.split_at_mut(i * lines);
        let (carried, low) = (&mut carried[..lines], &mut scratch.low[..lines]);
        let pivot = &mut scratch.pivot[..lines];
        let [entering, leaving] = match arrays.carried {
            [] => [&below[..0]; 2],
            carried => [&carried[p - stride..][..lines], &carried[p..][..lines]],
        };
        for l in 0..lines {
            let factor = inverse[l] * width;
            let (mut down, mut up) = (factor * below[l], factor * above[l]);
            if !entering.is_empty() {
                down += factor * entering[l].max(0.0);
                up -= factor * leaving[l].min(0.0);
            }
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
    pub fn for_panels(&self, mut job: impl FnMut(Panel)) {
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
    pub fn for_row_groups(&self, mut job: impl FnMut(std::iter::StepBy<std::ops::Range<usize>>)) {
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

impl Arrays<'_> {
    /// Notes the first and last values of all lines and of their influence vectors.
    pub fn note_ends(&self, panel: Panel, n: usize, ends: &mut Vec<f64>) {
        for first in panel.start..panel.start + panel.lines {
            let last = first + (n - 1) * panel.stride;
            let both = |x: &[f64]| [x[first], x[last]];
            ends.extend([both(self.data), both(self.before), both(self.after)].as_flattened());
        }
    }
}

impl Scratch {
    fn resize(&mut self, all: usize, lines: usize, dt: f64) {
        self.carried.resize(all, 0.0);
        [&mut self.low, &mut self.pivot].into_iter().for_each(|list| list.resize(lines, 0.0));
        self.diagonal.clear();
        self.diagonal.resize(lines, dt);
    }
}

/// Right-hand sides of the influence vectors of unit values: −low before the first unknown, −high after the last. The coefficient
/// above is the carried one over the pivot.
fn start_influence(
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
