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

/// Lines solved side by side: unknown i of line l lies at start + i s + l across, with s the stride of the axis.
#[derive(Clone, Copy)]
pub(super) struct Bundle {
    pub start: usize,
    pub across: usize,
    pub lines: usize,
}

/// Coefficients of a bundle, those of its lines side by side.
#[derive(Clone, Default)]
pub(super) struct Coefficients {
    /// θ ν w / distance at the lower side of the first unknown and the upper side of every one.
    conductance: Vec<f64>,
    /// Volume fluxes per area (m/s) that carry momentum through the same sides; empty if diffusion alone is implicit.
    carried: Vec<f64>,
    /// 1/m of every unknown (s); empty where m = 1/Δt.
    inverse: Vec<f64>,
}

/// Influence vectors of a bundle for unit values before and after its lines; empty if they stand alone.
#[derive(Clone, Default)]
pub(super) struct Influence {
    pub before: Vec<f64>,
    pub after: Vec<f64>,
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

    /// Sets the coefficients of a bundle.
    pub fn set(&self, bundle: Bundle, boundary_data: &[BoundaryData], coefficients: &mut Coefficients) {
        let sides = (self.len() + 1) * bundle.lines;
        coefficients.conductance.resize(sides, 0.0);
        self.set_conductance(bundle, &mut coefficients.conductance);
        coefficients.carried.resize(if self.diagonal.carrier.is_some() { sides } else { 0 }, 0.0);
        if let Some(velocity) = self.diagonal.carrier {
            self.set_carried(bundle, velocity, &mut coefficients.carried);
        }
        if self.component != self.axis {
            self.close_ends(bundle, boundary_data, coefficients);
        }
        coefficients.inverse.clear();
        if let Some(inverse) = self.diagonal.inverse {
            let inverse = inverse.component(self.component);
            coefficients.inverse.resize(self.len() * bundle.lines, 0.0);
            self.for_runs(bundle, 0, |p, n, first, step| {
                put(&mut coefficients.inverse[first..], step, inverse[p..p + n].iter().copied());
            });
        }
    }

    /// Sets θ ν w/distance at the upper side of every unknown and at the lower one of the first.
    fn set_conductance(&self, bundle: Bundle, conductance: &mut [f64]) {
        let (layout, axis) = (self.local.layout, self.axis);
        let (m, share) = (&self.local.axes[axis], self.diagonal.share(self.component == axis));
        // Own stresses act in the cell above the face.
        let (inverse, shift) = match self.component == axis {
            true => (&m.inverse_width[1..], layout.strides()[axis]),
            false => (&m.inverse_distance[..], 0),
        };
        let sides = conductance.chunks_exact_mut(bundle.lines).zip(&inverse[layout.halo - 1..]);
        sides.for_each(|(side, inverse)| side.fill(share * inverse));
        let Some(weights) = self.diagonal.weights else { return };
        let weights = match self.component == axis {
            true => weights.centres[axis],
            false => weights.edges[self.component][axis],
        };
        self.for_runs(bundle, 1, |p, n, first, step| {
            let weights = &weights[p + shift..][..n];
            let row = conductance[first..].iter_mut().step_by(step);
            row.zip(weights).for_each(|(c, weight)| *c *= weight);
        });
    }

    /// Sets the volume flux per area through the upper side of every unknown and the lower one of the first.
    fn set_carried(&self, bundle: Bundle, velocity: &Faces, carried: &mut [f64]) {
        let q = velocity.component(self.axis);
        let shift = self.local.layout.strides()[self.component];
        self.for_runs(bundle, 1, |p, n, first, step| {
            let (here, next) = (&q[p..][..n], &q[p + shift..][..n]);
            put(&mut carried[first..], step, here.iter().zip(next).map(|(a, b)| 0.5 * (a + b)));
        });
    }

    /// Beyond the box there is no neighbour unless it is imposed.
    fn close_ends(&self, bundle: Bundle, boundary_data: &[BoundaryData], coefficients: &mut Coefficients) {
        let (dims, strides) = (self.local.layout.dims(), self.local.layout.strides());
        for face_data in boundary_data.iter().filter(|t| t.face.axis == self.axis) {
            let side = if face_data.face.side == Side::High { self.len() } else { 0 };
            for l in 0..bundle.lines {
                let place = bundle.start + l * bundle.across;
                let [m1, m2] = face_data.tangents.map(|t| place / strides[t] % dims[t]);
                if face_data.kinds[self.component][m2 * face_data.extents[0] + m1] != Kind::Fixed {
                    for list in [&mut coefficients.conductance, &mut coefficients.carried] {
                        list.get_mut(side * bundle.lines + l).into_iter().for_each(|value| *value = 0.0);
                    }
                }
            }
        }
    }

    /// Calls `job` with contiguous runs of places of a bundle, from so many before the first unknowns: the first place and their
    /// number, and where the values of a run go among those of the bundle, from which place on and how far apart.
    fn for_runs(&self, bundle: Bundle, before: usize, mut job: impl FnMut(usize, usize, usize, usize)) {
        let Bundle { start, across, lines } = bundle;
        let (count, stride) = (self.len() + before, self.local.layout.strides()[self.axis]);
        let start = start - before * stride;
        match self.axis {
            0 => (0..lines).for_each(|l| job(start + l * across, count, l, lines)),
            _ => (0..count).for_each(|i| job(start + i * stride, lines, i * lines, 1)),
        }
    }

    /// Solves the own part of the lines of a panel.
    pub fn eliminate(
        &self,
        (data, panel): (&mut [f64], Panel),
        coefficients: &Coefficients,
        influence: &mut Influence,
        scratch: &mut Scratch,
    ) {
        let (n, lines) = (self.len(), panel.lines);
        let own = Panel { start: 0, stride: lines, lines };
        scratch.resize(n * lines, lines, self.diagonal.dt);
        for i in 0..n {
            self.set_row(i, lines, coefficients, scratch);
            let (low, pivot) = (&scratch.low[..lines], &scratch.pivot[..lines]);
            panel.forward(data, i, |l| [low[l], pivot[l]]);
            if !influence.before.is_empty() {
                let high = &scratch.carried[i * lines..][..lines];
                influence.start(i * lines, [low, pivot, high], [i == 0, i + 1 == n]);
                own.forward(&mut influence.before, i, |l| [low[l], pivot[l]]);
                own.forward(&mut influence.after, i, |l| [low[l], pivot[l]]);
            }
        }
        for i in (0..n.saturating_sub(1)).rev() {
            let carried = &scratch.carried[i * lines..][..lines];
            panel.backward(data, i, |l| carried[l]);
            for list in [&mut influence.before, &mut influence.after] {
                if !list.is_empty() {
                    own.backward(list, i, |l| carried[l]);
                }
            }
        }
    }

    /// Coefficient below, inverse pivot and carried coefficient of row i.
    fn set_row(&self, i: usize, lines: usize, coefficients: &Coefficients, scratch: &mut Scratch) {
        let Coefficients { conductance, carried, inverse } = coefficients;
        let both = |sides: &'_ [f64]| -> [std::ops::Range<usize>; 2] {
            if sides.is_empty() {
                [0..0, 0..0]
            } else {
                [i, i + 1].map(|side| side * lines..(side + 1) * lines)
            }
        };
        let [below, above] = both(conductance).map(|side| &conductance[side]);
        let [entering, leaving] = both(carried).map(|side| &carried[side]);
        let inverse =
            if inverse.is_empty() { &scratch.diagonal[..lines] } else { &inverse[i * lines..][..lines] };
        let (RowKind { low: a, high: b, diagonal: c }, width) = (self.kind(i), self.inverse_width(i));
        let (done, carried) = scratch.carried.split_at_mut(i * lines);
        let (carried, low) = (&mut carried[..lines], &mut scratch.low[..lines]);
        let pivot = &mut scratch.pivot[..lines];
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

    /// All lines, some at a time.
    pub fn for_bundles(&self, mut job: impl FnMut(Bundle)) {
        let (layout, [nx, ny, nz]) = (self.local.layout, self.local.unknowns(self.component));
        let across = if self.axis == 0 { layout.strides()[1] } else { 1 };
        let [slabs, count, at_once] = match self.axis {
            0 => [nz, ny, ROWS],
            1 => [nz, nx, LINES],
            _ => [ny, nx, LINES],
        };
        let parts = count.div_ceil(at_once);
        for slab in 0..slabs {
            let row = if self.axis == 2 { layout.row(slab, 0) } else { layout.row(0, slab) };
            for part in 0..parts {
                let (first, end) = (count * part / parts, count * (part + 1) / parts);
                job(Bundle { start: row + first * across, across, lines: end - first });
            }
        }
    }
}

/// Writes values so many places apart.
fn put(to: &mut [f64], step: usize, values: impl Iterator<Item = f64>) {
    match step {
        1 => to.iter_mut().zip(values).for_each(|(to, value)| *to = value),
        _ => to.iter_mut().step_by(step).zip(values).for_each(|(to, value)| *to = value),
    }
}

impl Influence {
    pub fn resize(&mut self, size: usize) {
        [&mut self.before, &mut self.after].into_iter().for_each(|list| list.resize(size, 0.0));
    }

    /// Right-hand sides of the row at a place, of unit values: −low before the first unknown, −high after the last. The coefficient
    /// above is the carried one over the pivot.
    fn start(&mut self, p: usize, [low, pivot, carried]: [&[f64]; 3], [is_first, is_last]: [bool; 2]) {
        let before = &mut self.before[p..p + low.len()];
        before.iter_mut().zip(low).for_each(|(v, low)| *v = if is_first { -low } else { 0.0 });
        let after = &mut self.after[p..p + low.len()];
        for ((w, pivot), carried) in after.iter_mut().zip(pivot).zip(carried) {
            *w = if is_last { -carried / pivot } else { 0.0 };
        }
    }

    /// Notes the first and last values of the lines of a panel and of their influence vectors.
    pub fn note_ends(&self, (data, panel): (&[f64], Panel), n: usize, ends: &mut Vec<f64>) {
        let last = (n - 1) * panel.stride;
        for l in 0..panel.lines {
            let both = |x: &[f64]| [x[l], x[(n - 1) * panel.lines + l]];
            let of_data = [data[panel.start + l], data[panel.start + last + l]];
            ends.extend([of_data, both(&self.before), both(&self.after)].as_flattened());
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
