//! The implicit half of Crank–Nicolson diffusion, (1 − a δx²)(1 − a δy²)(1 − a δz²) Δu = r with a = ν Δt / 2.
//!
//! In increments Δu the factors split (Douglas–Gunn): the error a² δx² δy² Δu is of third order per step, and none
//! remains in a steady state.
//!
//! Where the viscosity varies, the whole stress 2 μ D couples the components. With D the factors of each by itself, normal stresses
//! twice, and L and Lᵀ the transposed gradients of the components before and after it (`transposed`),
//!
//! ```text
//! (D + L) D⁻¹ (D + Lᵀ) Δu = r       D + L + Lᵀ and an error L D⁻¹ Lᵀ Δu, of third order as well
//! ```
//!
//! is solved once forth and once back. It is symmetric and no less than the operator itself, so that no viscosity, however
//! large and uneven, limits the step.

use super::constant::{ConstantLines, LineEnd, LineKind};
use super::system::MomentumDiagonal;
use super::transposed::add_transposed;
use super::variable::VariableLines;
use crate::boundary::{BoundaryData, BoxFace, Kind};
use crate::metrics::Local;
use crate::tridiagonal::Panel;
use crate::{Boundaries, CellPartition, Faces, Grid, Halo, Side};
use grains_domain::{SerialTransport, Transport};

/// Rows along x solved side by side, through a transposed buffer.
const ROWS: usize = 8;

/// Solver of the implicit diffusion of all components.
pub(crate) struct Implicit {
    grid: Grid,
    partition: CellPartition,
    /// Ends of the lines along an axis, for components across it; none if they differ from place to place.
    ends: Option<[[LineEnd; 2]; 3]>,
    /// a the factors belong to (m²).
    a: f64,
    lines: Vec<ConstantLines>,
    variable: VariableLines,
    rows: Vec<f64>,
    /// What a component gets from those after it.
    remainder: Vec<f64>,
}

impl Implicit {
    pub fn new(grid: &Grid, partition: &CellPartition, boundaries: &Boundaries) -> Self {
        let mut ends = Some([[LineEnd::Free; 2]; 3]);
        for face in BoxFace::all().filter(|f| !grid.axis(f.axis).is_periodic()) {
            let imposed = boundaries.imposes_tangential(face);
            ends = ends.zip(imposed).map(|(mut ends, is_imposed)| {
                let side = usize::from(face.side == Side::High);
                ends[face.axis][side] = if is_imposed { LineEnd::Imposed } else { LineEnd::Free };
                ends
            });
        }
        let periodic = std::array::from_fn(|a| grid.axis(a).is_periodic());
        Self {
            grid: grid.clone(),
            partition: partition.clone(),
            ends,
            a: f64::NAN,
            lines: Vec::new(),
            variable: VariableLines::new(partition, periodic),
            rows: Vec::new(),
            remainder: Vec::new(),
        }
    }

    /// Turns the right-hand sides r (m/s) into increments Δu, in place; collective.
    pub fn solve(
        &mut self,
        local: &Local,
        boundary_data: &[BoundaryData],
        diagonal: MomentumDiagonal<'_>,
        increments: &mut Faces,
        halo: &mut Halo,
        transport: &dyn Transport,
    ) {
        if diagonal.is_full {
            return self.solve_full(local, boundary_data, diagonal, increments, halo, transport);
        }
        let is_constant =
            diagonal.inverse.is_none() && diagonal.weights.is_none() && diagonal.carrier.is_none();
        match self.ends {
            Some(ends) if is_constant => {
                self.set(ends, 0.5 * diagonal.viscosity * diagonal.dt);
                for component in (0..3).filter(|&c| local.active[c]) {
                    self.solve_constant(local, component, increments.component_mut(component), transport);
                }
            }
            _ => {
                for component in (0..3).filter(|&c| local.active[c]) {
                    let data = increments.component_mut(component);
                    self.variable.solve_all(local, boundary_data, component, diagonal, data, transport);
                }
            }
        }
    }

    /// The whole stress: all components forth, each with what those before it do, and back.
    fn solve_full(
        &mut self,
        local: &Local,
        boundary_data: &[BoundaryData],
        diagonal: MomentumDiagonal<'_>,
        increments: &mut Faces,
        halo: &mut Halo,
        transport: &dyn Transport,
    ) {
        let is_after = |c: usize, other: usize| other > c && local.active[other];
        for component in (0..3).filter(|&c| local.active[c]) {
            for source in (0..component).filter(|&s| local.active[s]) {
                let (data, from) = increments.two_components(component, source);
                add_transposed(local, diagonal, [component, source], from, data);
            }
            let data = increments.component_mut(component);
            self.variable.solve_all(local, boundary_data, component, diagonal, data, transport);
            halo.fill(&mut [data], transport);
        }
        for component in (0..3).rev().filter(|&c| local.active[c] && (0..3).any(|s| is_after(c, s))) {
            self.remainder.clear();
            self.remainder.resize(local.layout.len(), 0.0);
            for source in (0..3).filter(|&s| is_after(component, s)) {
                let from = increments.component(source);
                add_transposed(local, diagonal, [component, source], from, &mut self.remainder);
            }
            let remainder = &mut self.remainder;
            self.variable.solve_all(local, boundary_data, component, diagonal, remainder, transport);
            let data = increments.component_mut(component);
            let n = local.unknowns(component);
            for k in 0..n[2] {
                for j in 0..n[1] {
                    let own = local.layout.row(j, k)..local.layout.row(j, k) + n[0];
                    data[own.clone()].iter_mut().zip(&remainder[own]).for_each(|(x, y)| *x += y);
                }
            }
            if component > 0 {
                halo.fill(&mut [data], transport);
            }
        }
    }

    fn set(&mut self, ends: [[LineEnd; 2]; 3], a: f64) {
        if a == self.a {
            return;
        }
        self.a = a;
        self.lines.clear();
        for component in 0..3 {
            for (axis, &across) in ends.iter().enumerate() {
                let ends = if component == axis { [LineEnd::Imposed; 2] } else { across };
                let kind = LineKind { component, axis, ends };
                self.lines.push(ConstantLines::new(&self.grid, &self.partition, kind, a));
            }
        }
    }

    fn solve_constant(
        &mut self,
        local: &Local,
        component: usize,
        data: &mut [f64],
        transport: &dyn Transport,
    ) {
        let sweeps = Sweeps { local, n: local.unknowns(component) };
        let [x, y, z] = &mut self.lines[3 * component..][..3] else { return };
        if x.is_shared() || y.is_shared() {
            sweeps.solve(0, x, &mut self.rows, data, transport);
            sweeps.solve(1, y, &mut self.rows, data, transport);
        } else {
            // While a plane is in cache, its lines along x and y are solved one after the other.
            for k in 0..sweeps.n[2] {
                sweeps.solve_slab(0, x, k, &mut self.rows, data);
                sweeps.solve_slab(1, y, k, &mut self.rows, data);
            }
        }
        sweeps.solve(2, z, &mut self.rows, data, transport);
    }
}

/// Sweeps over the unknowns of one component; slabs are planes of constant z for lines along x and y, of constant y
/// for lines along z.
#[derive(Clone, Copy)]
struct Sweeps<'a> {
    local: &'a Local,
    n: [usize; 3],
}

impl Sweeps<'_> {
    /// Solves all lines along an axis.
    fn solve(
        &self,
        axis: usize,
        lines: &mut ConstantLines,
        rows: &mut Vec<f64>,
        data: &mut [f64],
        transport: &dyn Transport,
    ) {
        let slabs = 0..if axis == 2 { self.n[1] } else { self.n[2] };
        if !lines.is_shared() {
            slabs.for_each(|slab| self.solve_slab(axis, lines, slab, rows, data));
        } else if self.local.active[axis] {
            lines.begin();
            slabs.clone().for_each(|slab| self.eliminate_slab(axis, lines, slab, rows, data));
            lines.exchange(transport);
            let per_slab = if axis == 0 { self.n[1] } else { self.n[0] };
            slabs.for_each(|slab| self.correct_slab(axis, lines, slab, slab * per_slab, data));
        }
    }

    /// Solves the lines of a slab that no other rank shares.
    fn solve_slab(
        &self,
        axis: usize,
        lines: &mut ConstantLines,
        slab: usize,
        rows: &mut Vec<f64>,
        data: &mut [f64],
    ) {
        if self.local.active[axis] {
            lines.begin();
            self.eliminate_slab(axis, lines, slab, rows, data);
            if lines.is_coupled() {
                lines.exchange(&SerialTransport);
                self.correct_slab(axis, lines, slab, 0, data);
            }
        }
    }

    fn panel(&self, axis: usize, slab: usize) -> Panel {
        let (layout, strides) = (self.local.layout, self.local.layout.strides());
        let start = if axis == 2 { layout.row(slab, 0) } else { layout.row(0, slab) };
        Panel { start, stride: strides[axis], lines: self.n[0] }
    }

    fn eliminate_slab(
        &self,
        axis: usize,
        lines: &mut ConstantLines,
        slab: usize,
        rows: &mut Vec<f64>,
        data: &mut [f64],
    ) {
        if axis != 0 {
            return lines.eliminate(data, self.panel(axis, slab));
        }
        let n = self.n[0];
        rows.resize(ROWS * n, 0.0);
        for first in (0..self.n[1]).step_by(ROWS) {
            let count = ROWS.min(self.n[1] - first);
            let row = |l: usize| self.local.layout.row(first + l, slab);
            for l in 0..count {
                let line = &data[row(l)..][..n];
                rows[l..].iter_mut().step_by(count).zip(line).for_each(|(r, x)| *r = *x);
            }
            lines.eliminate(rows, Panel { start: 0, stride: count, lines: count });
            for l in 0..count {
                let line = &mut data[row(l)..][..n];
                line.iter_mut().zip(rows[l..].iter().step_by(count)).for_each(|(x, r)| *x = *r);
            }
        }
    }

    /// Corrects the lines of a slab, the first of which is line `first` since the ends were last forgotten.
    fn correct_slab(
        &self,
        axis: usize,
        lines: &mut ConstantLines,
        slab: usize,
        first: usize,
        data: &mut [f64],
    ) {
        if axis != 0 {
            return lines.correct(data, self.panel(axis, slab), first);
        }
        for j in 0..self.n[1] {
            let line = &mut data[self.local.layout.row(j, slab)..][..self.n[0]];
            lines.correct_contiguous(line, first + j);
        }
    }
}

/// Adds what changes of imposed velocities do to the unknowns next to them, θ ν ∇·w∇ of the boundary increments; the
/// increments of imposed normal velocities themselves are set on the faces.
pub(crate) fn imposed_increments(
    local: &Local,
    boundary_data: &[BoundaryData],
    diagonal: MomentumDiagonal<'_>,
    is_implicit: bool,
    increments: &mut Faces,
) {
    for face_data in boundary_data {
        set_normal_increments(local, face_data, increments);
        if !is_implicit || !local.active[face_data.face.axis] {
            continue;
        }
        for component in (0..3).filter(|&c| local.active[c]) {
            if component == face_data.face.axis {
                add_normal(local, face_data, diagonal, increments);
            } else if face_data.is_unsteady {
                add_tangential(local, face_data, component, diagonal, increments);
            }
        }
    }
}

/// Own entries of a face, with the array places of the cell inside and the boundary value.
fn own_entries(
    local: &Local,
    face_data: &BoundaryData,
    mut job: impl FnMut(usize, [usize; 2], usize, usize),
) {
    let h = local.layout.halo;
    for m2 in h..face_data.extents[1] - h {
        for m1 in h..face_data.extents[0] - h {
            let inside = face_data.inside(local.layout, m1, m2);
            let boundary = face_data.boundary(local.layout, inside);
            job(m2 * face_data.extents[0] + m1, [m1, m2], inside, boundary);
        }
    }
}

fn set_normal_increments(local: &Local, face_data: &BoundaryData, increments: &mut Faces) {
    let axis = face_data.face.axis;
    let data = increments.component_mut(axis);
    own_entries(local, face_data, |e, _, _, boundary| {
        if face_data.kinds[axis][e] != Kind::Free {
            data[boundary] = if face_data.is_unsteady { face_data.increments[axis][e] } else { 0.0 };
        }
    });
}

fn add_normal(
    local: &Local,
    face_data: &BoundaryData,
    diagonal: MomentumDiagonal<'_>,
    increments: &mut Faces,
) {
    let (axis, n) = (face_data.face.axis, local.layout.cells[face_data.face.axis]);
    if local.unknowns(axis)[axis] == 0 {
        return;
    }
    let is_high = face_data.face.side == Side::High;
    let stride = local.layout.strides()[axis];
    let (cell, unknown) = if is_high { (n - 1, n - 2) } else { (0, 0) };
    let m = &local.axes[axis];
    let inverses = m.inverse_width[local.entry(cell)] * m.inverse_distance[local.entry(unknown)];
    let factor = diagonal.share(true) * inverses;
    let data = increments.component_mut(axis);
    own_entries(local, face_data, |_, _, inside, boundary| {
        let p = if is_high { boundary - stride } else { boundary + stride };
        let weight = diagonal.weights.map_or(1.0, |weights| weights.centres[axis][inside]);
        data[p] += diagonal.inverse_at(axis, p) * factor * weight * data[boundary];
    });
}

fn add_tangential(
    local: &Local,
    face_data: &BoundaryData,
    component: usize,
    diagonal: MomentumDiagonal<'_>,
    increments: &mut Faces,
) {
    let (axis, n) = (face_data.face.axis, local.layout.cells[face_data.face.axis]);
    let cell = if face_data.face.side == Side::High { n - 1 } else { 0 };
    let inverse = local.axes[axis].inverse_width[local.entry(cell)];
    let factor = diagonal.share(false) * face_data.wall[0] * inverse * inverse;
    let along = usize::from(face_data.tangents[1] == component);
    let (unknowns, stride) = (local.unknowns(component)[component], local.layout.strides()[component]);
    let data = increments.component_mut(component);
    own_entries(local, face_data, |e, m, inside, boundary| {
        if face_data.kinds[component][e] == Kind::Fixed && m[along] - local.layout.halo < unknowns {
            let weight = diagonal.weights.map_or(1.0, |weights| match diagonal.is_full {
                true => weights.edges[component][axis][boundary],
                false => {
                    0.5 * (weights.centres[component][inside] + weights.centres[component][inside + stride])
                }
            });
            data[inside] +=
                diagonal.inverse_at(component, inside) * factor * weight * face_data.increments[component][e];
        }
    });
}
