//! Direct solver by transforms along two axes and tridiagonal lines along the third.

use super::modal_tridiagonal::{LineProfile, ModalTridiagonal};
use super::pencil_transpose::PencilTranspose;
use super::transform::Transform;
use super::{PressureProblem, PressureSolver, SolveReport};
use crate::{Centre, Faces, Field, Layout, SolveError};
use grains_domain::Transport;

/// Columns transformed together: one cache line of f64.
const COLUMNS: usize = 8;

/// Direct solver of div(c grad p) = f for coefficients c that vary along one axis only (the line axis).
///
/// Along the other two axes the operator is diagonalised: by Fourier, cosine or sine transforms where they are
/// uniform with like ends, else by a matrix of eigenvectors (n operations per cell). Axes shared by several ranks
/// are transformed on whole lines, sent there and back; the line axis needs two numbers per line and rank only,
/// so the shared axis becomes the line axis if nothing speaks against it.
///
/// As a preconditioner it takes the mean of any coefficients over the planes normal to the line axis.
pub struct FastSolver {
    problem: PressureProblem,
    axis: usize,
    transforms: Vec<(usize, Transform)>,
    transposes: Vec<Option<PencilTranspose>>,
    lines: ModalTridiagonal,
    profile: LineProfile,
    block: Vec<f64>,
    columns: Vec<f64>,
    scale: f64,
}

impl FastSolver {
    /// Solver for a problem with coefficients 1 (m⁴/(N s)).
    pub fn new(problem: &PressureProblem, transport: &dyn Transport) -> Self {
        let axis = line_axis(problem);
        let transforms: Vec<(usize, Transform)> = (0..3)
            .filter(|&a| a != axis)
            .map(|a| (a, Transform::new(problem.grid.axis(a), problem.imposed[a])))
            .collect();
        let transposes = transforms
            .iter()
            .map(|&(a, _)| problem.partition.is_split(a).then(|| PencilTranspose::new(&problem.partition, a)))
            .collect();
        let eigenvalues = [&transforms[0].1.eigenvalues[..], &transforms[1].1.eigenvalues[..]];
        let n = problem.grid.axis(axis).cells();
        let mut along = vec![1.0; n + 1];
        if !problem.grid.axis(axis).is_periodic() {
            (along[0], along[n]) = (
                f64::from(u8::from(problem.imposed[axis][0])),
                f64::from(u8::from(problem.imposed[axis][1])),
            );
        }
        let mut solver = Self {
            axis,
            lines: ModalTridiagonal::new(problem, axis, eigenvalues),
            scale: transforms.iter().map(|t| t.1.scale).product(),
            transforms,
            transposes,
            profile: LineProfile { across: [vec![1.0; n], vec![1.0; n]], along },
            block: vec![0.0; problem.partition.cells().iter().product()],
            columns: Vec::new(),
            problem: problem.clone(),
        };
        solver.lines.set(&solver.problem, &solver.profile, transport);
        solver
    }

    /// Axis along which tridiagonal systems are solved.
    pub fn line_axis(&self) -> usize {
        self.axis
    }

    /// Takes the means of the coefficients over planes normal to the line axis; returns the largest deviation
    /// from them, relative to the largest coefficient. Collective.
    pub fn set_mean_coefficients(&mut self, coefficients: &Faces, transport: &dyn Transport) -> f64 {
        let means = PlaneMeans::new(&self.problem, self.axis, coefficients, transport);
        let deviation = means.deviation(&self.problem, self.axis, coefficients, transport);
        self.profile = means.profile;
        self.lines.set(&self.problem, &self.profile, transport);
        deviation
    }

    /// Solves for the coefficients' means, see [`PressureSolver::solve`]; no first guess, no failure; collective.
    pub fn apply(&mut self, rhs: &Field<Centre>, solution: &mut Field<Centre>, transport: &dyn Transport) {
        let layout = rhs.layout();
        let [nx, ny, nz] = layout.cells;
        let mut block = std::mem::take(&mut self.block);
        for k in 0..nz {
            let plane = &mut block[k * nx * ny..(k + 1) * nx * ny];
            for (j, row) in plane.chunks_exact_mut(nx).enumerate() {
                // The operator is negative: its sign is turned here.
                row.iter_mut().zip(rhs.row(j, k)).for_each(|(b, r)| *b = -self.scale * r);
            }
            self.transform_plane(plane, [nx, ny], Way::There);
        }
        self.transform_shared(&mut block, layout, Way::There, transport);
        if self.problem.is_singular() {
            self.balance_constant(&mut block, transport);
        }
        self.lines.solve(&mut block, transport);
        if self.problem.is_singular() {
            self.centre_constant(&mut block, transport);
        }
        self.transform_shared(&mut block, layout, Way::Back, transport);
        for k in 0..nz {
            let plane = &mut block[k * nx * ny..(k + 1) * nx * ny];
            self.transform_plane(plane, [nx, ny], Way::Back);
            for (j, row) in plane.chunks_exact(nx).enumerate() {
                let start = layout.row(j, k);
                solution.data_mut()[start..start + nx].copy_from_slice(row);
            }
        }
        self.block = block;
    }

    /// Transforms along x and y of one plane, as far as they are not shared.
    fn transform_plane(&mut self, plane: &mut [f64], [nx, ny]: [usize; 2], way: Way) {
        let columns = &mut self.columns;
        for (t, (axis, transform)) in self.transforms.iter_mut().enumerate() {
            match (self.transposes[t].is_some(), *axis) {
                (false, 0) => plane.chunks_exact_mut(nx).for_each(|row| way.apply(transform, row)),
                (false, 1) => transform_columns(plane, [nx, ny], transform, columns, way),
                _ => {}
            }
        }
    }

    /// Transforms along z, and along axes that several ranks share.
    fn transform_shared(&mut self, block: &mut [f64], layout: Layout, way: Way, transport: &dyn Transport) {
        let [nx, ny, nz] = layout.cells;
        for ((axis, transform), shared) in self.transforms.iter_mut().zip(&mut self.transposes) {
            match shared {
                Some(shared) => shared.for_lines(block, transport, |line| way.apply(transform, line)),
                None if *axis == 2 => {
                    transform_columns(block, [nx * ny, nz], transform, &mut self.columns, way);
                }
                None => {}
            }
        }
    }

    /// Takes from the constant mode what no pressure could balance (rounding).
    fn balance_constant(&mut self, block: &mut [f64], transport: &dyn Transport) {
        let (axis, first) = (self.problem.grid.axis(self.axis), self.problem.partition.first()[self.axis]);
        let n = self.problem.partition.cells()[self.axis];
        let line = self.lines.constant_line().map(|l| self.lines.line(l));
        let cells = |(start, stride): (usize, usize)| (0..n).map(move |i| (i, start + i * stride));
        let mut sum = [line.map_or(0.0, |line| cells(line).map(|(_, p)| block[p]).sum())];
        transport.sum(&mut sum);
        if let Some(line) = line {
            let density = sum[0] / axis.length();
            cells(line).for_each(|(i, p)| block[p] -= density * axis.width((first + i) as isize));
        }
    }

    /// Makes the mean of the solution zero.
    fn centre_constant(&mut self, block: &mut [f64], transport: &dyn Transport) {
        let (axis, first) = (self.problem.grid.axis(self.axis), self.problem.partition.first()[self.axis]);
        let n = self.problem.partition.cells()[self.axis];
        let line = self.lines.constant_line().map(|l| self.lines.line(l));
        let cells = |(start, stride): (usize, usize)| (0..n).map(move |i| (i, start + i * stride));
        let weighted =
            |line| cells(line).map(|(i, p)| block[p] * axis.width((first + i) as isize)).sum::<f64>();
        let mut sum = [line.map_or(0.0, weighted)];
        transport.sum(&mut sum);
        if let Some(line) = line {
            cells(line).for_each(|(_, p)| block[p] -= sum[0] / axis.length());
        }
    }
}

impl PressureSolver for FastSolver {
    fn set_coefficients(
        &mut self,
        coefficients: &Faces,
        transport: &dyn Transport,
    ) -> Result<(), SolveError> {
        let deviation = self.set_mean_coefficients(coefficients, transport);
        if deviation > 1e-12 {
            let reason = format!(
                "the coefficients vary by {deviation:.1e} across the {} axis: the fast solver is for constant ones; use conjugate gradients",
                ['x', 'y', 'z'][self.axis]
            );
            return Err(SolveError::Coefficients { reason });
        }
        Ok(())
    }

    fn solve(
        &mut self,
        rhs: &Field<Centre>,
        pressure: &mut Field<Centre>,
        transport: &dyn Transport,
    ) -> Result<SolveReport, SolveError> {
        self.apply(rhs, pressure, transport);
        Ok(SolveReport { iterations: 1, residual: 0.0 })
    }
}

#[derive(Clone, Copy)]
enum Way {
    There,
    Back,
}

impl Way {
    fn apply(self, transform: &mut Transform, line: &mut [f64]) {
        match self {
            Way::There => transform.forward(line),
            Way::Back => transform.backward(line),
        }
    }
}

/// Transforms the columns of an array `[n][width]`, several at a time through a transposed buffer.
fn transform_columns(
    data: &mut [f64],
    [width, n]: [usize; 2],
    transform: &mut Transform,
    buffer: &mut Vec<f64>,
    way: Way,
) {
    buffer.resize(COLUMNS * n, 0.0);
    for first in (0..width).step_by(COLUMNS) {
        let count = COLUMNS.min(width - first);
        for (c, line) in buffer.chunks_exact_mut(n).take(count).enumerate() {
            line.iter_mut().zip(data[first + c..].iter().step_by(width)).for_each(|(x, value)| *x = *value);
            way.apply(transform, line);
        }
        for (c, line) in buffer.chunks_exact(n).take(count).enumerate() {
            data[first + c..].iter_mut().step_by(width).zip(line).for_each(|(value, x)| *value = *x);
        }
    }
}

/// The axis whose transform would be the dearest; among like ones a shared axis, then the last.
fn line_axis(problem: &PressureProblem) -> usize {
    let cost = |a: usize| {
        let axis = problem.grid.axis(a);
        let slow = if Transform::is_fast(axis, problem.imposed[a]) { 0 } else { axis.cells() };
        (problem.grid.is_active(a), slow, problem.partition.ranks[a], a)
    };
    (0..3).max_by_key(|&a| cost(a)).unwrap_or(2)
}

/// Means of coefficients over planes.
struct PlaneMeans {
    profile: LineProfile,
}

impl PlaneMeans {
    fn new(problem: &PressureProblem, axis: usize, coefficients: &Faces, transport: &dyn Transport) -> Self {
        let n = problem.grid.axis(axis).cells();
        let mut sums = vec![0.0; 3 * (n + 1)];
        let mut counts = vec![0.0; 3 * (n + 1)];
        for_faces(problem, axis, coefficients, |slot, value| {
            sums[slot] += value;
            counts[slot] += 1.0;
        });
        transport.sum(&mut sums);
        transport.sum(&mut counts);
        let means: Vec<f64> =
            sums.iter().zip(&counts).map(|(s, c)| if *c > 0.0 { s / c } else { 0.0 }).collect();
        let mut along = means[..=n].to_vec();
        if problem.grid.axis(axis).is_periodic() {
            along[0] = along[n];
        }
        let across = [means[n + 1..2 * n + 1].to_vec(), means[2 * n + 2..3 * n + 2].to_vec()];
        Self { profile: LineProfile { across, along } }
    }

    fn deviation(
        &self,
        problem: &PressureProblem,
        axis: usize,
        coefficients: &Faces,
        transport: &dyn Transport,
    ) -> f64 {
        let n = problem.grid.axis(axis).cells();
        let mut largest = [0.0_f64, 0.0];
        for_faces(problem, axis, coefficients, |slot, value| {
            let mean = match slot / (n + 1) {
                0 => self.profile.along[slot],
                o => self.profile.across[o - 1][slot % (n + 1)],
            };
            largest = [largest[0].max((value - mean).abs()), largest[1].max(value.abs())];
        });
        transport.max(&mut largest);
        if largest[1] > 0.0 { largest[0] / largest[1] } else { 0.0 }
    }
}

/// Own faces that carry flow, with their slot: plane along the axis, then of the two axes across it.
fn for_faces(problem: &PressureProblem, axis: usize, coefficients: &Faces, mut job: impl FnMut(usize, f64)) {
    let (layout, first) = (coefficients.layout(), problem.partition.first());
    let n = problem.grid.axis(axis).cells();
    let mut other = 0;
    for a in 0..3 {
        let global = problem.grid.axis(a);
        let closed = !global.is_periodic();
        if a != axis {
            other += 1;
        }
        let values = coefficients.component(a);
        // The lower boundary face has index −1.
        let low = if closed && first[a] == 0 { -1 } else { 0 };
        let mut from = [0_isize; 3];
        from[a] = low;
        let to = layout.cells.map(|c| c as isize);
        for k in from[2]..to[2] {
            for j in from[1]..to[1] {
                for i in from[0]..to[0] {
                    let place = [i, j, k];
                    let face = first[a] as isize + place[a];
                    let is_end = closed && (face == -1 || face + 1 == global.cells() as isize);
                    let side = usize::from(face >= 0);
                    let plane = (first[axis] as isize + place[axis]) as usize;
                    if a == axis {
                        job((face + 1) as usize, values[layout.index(i, j, k)]);
                    } else if !is_end || problem.imposed[a][side] {
                        job(other * (n + 1) + plane, values[layout.index(i, j, k)]);
                    }
                }
            }
        }
    }
}
