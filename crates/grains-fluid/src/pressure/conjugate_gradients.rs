//! Preconditioned conjugate gradients for coefficients that vary.

use super::multigrid::Multigrid;
use super::operator::dot;
use super::single_operator::{self, Equation, SingleOperator};
use super::{FastSolver, PressureOperator, PressureProblem, PressureSolver, SolveReport};
use crate::{Centre, Faces, Field, Halo, Layout, SolveError};
use grains_domain::Transport;
use multiversion::multiversion;

/// Ratio of the widest to the thinnest cell of an axis up to which multigrid is chosen: its smoother takes all cells
/// for equally flat.
const EVEN: f64 = 4.0;

/// Share by which iterations in single precision reduce a residual before it is found anew in double precision.
const REDUCTION: f64 = 1e-3;

/// Share of its square before below which the expected square of a residual is lost in rounding.
const LOST: f64 = 1e-6;

/// Residual over that expected from which on directions begin anew: what has been lost to rounding is of another kind.
const ASTRAY: f64 = 2.0;

/// What rounding leaves of a residual, over the norm of diagonal times pressure.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// What [`ConjugateGradients`] are preconditioned by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preconditioner {
    /// Geometric multigrid: some ten iterations to 1e-6 in beds, whatever the number of cells; some fifty to 1e-8 where
    /// coefficients jump 40-fold from face to face.
    Multigrid,
    /// The [`FastSolver`] with the means of the coefficients over planes: exact for layers and on stretched grids;
    /// iterations grow with the variation within a plane.
    PlaneMeans,
}

/// Conjugate gradients for any coefficients. After the first solve on one rank nothing is allocated.
///
/// Residuals, corrections and directions have single precision, the pressure that they change has double. The residual is found anew
/// in double precision whenever it has fallen a thousandfold, and at the end; directions go on (reliable updates, Clark et
/// al. 2010). So the residual that is compared with the tolerance is that of the equation itself.
///
/// Ranks agree twice per iteration: on r · z and |r|², and on the products of A d, from which |r + α A d| follows.
pub struct ConjugateGradients {
    problem: PressureProblem,
    tolerance: f64,
    max_iterations: usize,
    operator: PressureOperator,
    /// Unit of the conductances in single precision (m³/(Pa s)).
    unit: f64,
    engine: Engine,
    halo: Halo,
    /// Pressure with a halo of one cell, zero beyond the box (Pa).
    pressure: Field<Centre>,
    /// The residual of a row of cells.
    row: Vec<f64>,
    /// All with a halo of one cell, zero beyond the box.
    direction: Field<Centre, f32>,
    /// The operator applied to the search direction, A d.
    applied: Field<Centre, f32>,
    /// Own part of |r|².
    own_square: f64,
}

/// The equation in single precision and an approximate solver of it.
enum Engine {
    Multigrid(Multigrid),
    PlaneMeans(Box<PlaneMeans>),
}

/// The solution with the means of coefficients over planes, in double precision.
struct PlaneMeans {
    operator: SingleOperator,
    unit: f64,
    residual: Field<Centre, f32>,
    correction: Field<Centre, f32>,
    solver: FastSolver,
    rhs: Field<Centre>,
    solution: Field<Centre>,
}

impl PlaneMeans {
    fn new(problem: &PressureProblem, layout: Layout, transport: &dyn Transport) -> Self {
        Self {
            operator: SingleOperator::new(layout.cells),
            unit: 1.0,
            residual: Field::new(layout),
            correction: Field::new(layout),
            solver: FastSolver::new(problem, transport),
            rhs: Field::new(layout),
            solution: Field::new(layout),
        }
    }

    fn solve(&mut self, transport: &dyn Transport) -> f64 {
        let pairs = self.rhs.data_mut().iter_mut().zip(self.residual.data());
        pairs.for_each(|(rhs, r)| *rhs = f64::from(*r));
        self.solver.apply(&self.rhs, &mut self.solution, transport);
        let pairs = self.correction.data_mut().iter_mut().zip(self.solution.data());
        pairs.for_each(|(z, solution)| *z = (-self.unit * solution) as f32);
        let (r, z) = (self.residual.data(), self.correction.data());
        own_rows(&self.residual).map(|own| single_operator::dot(&r[own.clone()], &z[own])).sum()
    }
}

impl Engine {
    fn equation(&mut self) -> Equation<'_> {
        match self {
            Engine::Multigrid(multigrid) => multigrid.equation(),
            Engine::PlaneMeans(means) => {
                let PlaneMeans { operator, residual, correction, .. } = &mut **means;
                Equation { operator, residual, correction }
            }
        }
    }

    fn set(
        &mut self,
        coefficients: &Faces,
        operator: &PressureOperator,
        unit: f64,
        transport: &dyn Transport,
    ) {
        match self {
            Engine::Multigrid(multigrid) => multigrid.set(operator, unit, transport),
            Engine::PlaneMeans(means) => {
                means.operator.set(operator, unit);
                means.unit = unit;
                means.solver.set_mean_coefficients(coefficients, transport);
            }
        }
    }

    /// Solves the equation approximately; returns the own part of r · z.
    fn precondition(&mut self, transport: &dyn Transport) -> f64 {
        match self {
            Engine::Multigrid(multigrid) => multigrid.cycle(transport),
            Engine::PlaneMeans(means) => means.solve(transport),
        }
    }
}

/// Ranges of the own rows of a field.
fn own_rows<T: crate::Real>(
    field: &Field<Centre, T>,
) -> impl Iterator<Item = std::ops::Range<usize>> + use<T> {
    let n = field.layout().cells[0];
    field.layout().rows().map(move |start| start..start + n)
}

impl ConjugateGradients {
    /// Solver that stops when the residual is below `tolerance` times the right-hand side, within `max_iterations`,
    /// with the preconditioner that suits the grid.
    pub fn new(
        problem: &PressureProblem,
        tolerance: f64,
        max_iterations: usize,
        transport: &dyn Transport,
    ) -> Self {
        let is_even = |a: usize| {
            let axis = problem.grid.axis(a);
            let widths = || (0..axis.cells() as isize).map(|i| axis.width(i));
            widths().fold(0.0, f64::max) <= EVEN * widths().fold(f64::INFINITY, f64::min)
        };
        let suitable =
            if (0..3).all(is_even) { Preconditioner::Multigrid } else { Preconditioner::PlaneMeans };
        Self::preconditioned(problem, [tolerance, max_iterations as f64], suitable, transport)
    }

    /// Solver with a given preconditioner; `limits` are the tolerance and the number of iterations, see
    /// [`ConjugateGradients::new`].
    pub fn preconditioned(
        problem: &PressureProblem,
        [tolerance, max_iterations]: [f64; 2],
        preconditioner: Preconditioner,
        transport: &dyn Transport,
    ) -> Self {
        let layout = Layout { cells: problem.partition.cells(), halo: 1 };
        let engine = match preconditioner {
            Preconditioner::Multigrid => Engine::Multigrid(Multigrid::new(problem)),
            Preconditioner::PlaneMeans => {
                Engine::PlaneMeans(Box::new(PlaneMeans::new(problem, layout, transport)))
            }
        };
        Self {
            problem: problem.clone(),
            tolerance,
            max_iterations: max_iterations as usize,
            operator: PressureOperator::on(&problem.grid, &problem.partition, 1),
            unit: 1.0,
            engine,
            halo: Halo::new(&problem.grid, &problem.partition, layout),
            pressure: Field::new(layout),
            row: vec![0.0; layout.cells[0]],
            direction: Field::new(layout),
            applied: Field::new(layout),
            own_square: 0.0,
        }
    }

    /// Norm of the right-hand side (m³/s), and what it does not sum to zero over the volume (1/s) if no pressure can balance that.
    fn norm_and_excess(&self, rhs: &Field<Centre>, transport: &dyn Transport) -> [f64; 2] {
        let mut sums = [0.0; 3];
        for own in own_rows(rhs) {
            sums[0] += dot(&rhs.data()[own.clone()], &rhs.data()[own]);
        }
        if self.problem.is_singular() {
            for_volumes(&self.operator, rhs.layout(), |place, volume| {
                sums[1] += rhs.data()[place];
                sums[2] += volume;
            });
        }
        transport.sum(&mut sums);
        let [square, sum, volume] = sums;
        [square.sqrt(), if volume > 0.0 { sum / volume } else { 0.0 }]
    }

    /// r = (A p − f) `scale`, the residual with its sign turned, without the excess of f; returns its norm, and that of what
    /// rounding leaves of it, both divided by the scale. Collective.
    fn find_residual(
        &mut self,
        (rhs, excess): (&Field<Centre>, f64),
        scale: f64,
        transport: &dyn Transport,
    ) -> [f64; 2] {
        self.halo.fill(&mut [self.pressure.data_mut()], transport);
        let (local, layout) = (&self.operator.local, self.pressure.layout());
        let residual = self.engine.equation().residual;
        let [nx, ny, nz] = layout.cells;
        let mut sums = [0.0; 2];
        for k in 0..nz {
            for j in 0..ny {
                let area = local.axes[1].width[local.entry(j)] * local.axes[2].width[local.entry(k)];
                let start = layout.row(j, k);
                let of_row = residual_row(
                    &self.operator,
                    (self.pressure.data(), start),
                    (rhs.row(j, k), excess * area),
                    (&mut self.row, &mut residual.data_mut()[start..start + nx]),
                    scale,
                );
                sums.iter_mut().zip(of_row).for_each(|(sum, value)| *sum += value);
            }
        }
        self.own_square = sums[0] * scale * scale;
        transport.sum(&mut sums);
        [sums[0].sqrt(), ROUNDING * sums[1].sqrt()]
    }

    /// Takes the mean over the volume off the pressure.
    fn centre(&mut self, transport: &dyn Transport) {
        let mut sums = [0.0; 2];
        let (pressure, layout) = (self.pressure.data_mut(), self.operator.layout());
        for_volumes(&self.operator, layout, |place, volume| {
            sums[0] += pressure[place] * volume;
            sums[1] += volume;
        });
        transport.sum(&mut sums);
        let mean = sums[0] / sums[1];
        for_volumes(&self.operator, layout, |place, _| pressure[place] -= mean);
    }

    /// z of the residual; returns r · z and |r|² over all ranks.
    fn precondition(&mut self, transport: &dyn Transport) -> [f64; 2] {
        let product = self.engine.precondition(transport);
        let mut sums = [product, self.own_square];
        transport.sum(&mut sums);
        sums
    }

    /// d = z + β d; returns −d · A d, r · A d and |A d|² over all ranks.
    fn new_direction(&mut self, beta: f64, transport: &dyn Transport) -> [f64; 3] {
        let Equation { operator, residual, correction } = self.engine.equation();
        turn(self.direction.data_mut(), correction.data(), beta as f32);
        self.halo.fill(&mut [self.direction.data_mut()], transport);
        let mut sums = operator.apply(&self.direction, residual, &mut self.applied);
        transport.sum(&mut sums);
        [-sums[0], sums[1], sums[2]]
    }

    /// p += α d, of a residual with a scale, and r += α A d.
    fn advance(&mut self, alpha: f64, scale: f64) {
        self.own_square = 0.0;
        let of_pressure = alpha / (scale * self.unit);
        let residual = self.engine.equation().residual;
        for own in own_rows(&self.direction) {
            let (direction, applied) =
                (&self.direction.data()[own.clone()], &self.applied.data()[own.clone()]);
            let (p, r) = (&mut self.pressure.data_mut()[own.clone()], &mut residual.data_mut()[own]);
            self.own_square += advance_row((p, of_pressure, direction), (r, alpha as f32, applied));
        }
    }

    fn failed(&self, iterations: usize, residual: f64, why: &str) -> SolveError {
        let reason = why.to_string();
        SolveError::NotConverged { iterations, residual, tolerance: self.tolerance, reason }
    }

    /// Iterates from the pressure until its residual is small beside the `norm` of the right-hand side.
    fn iterate(
        &mut self,
        rhs: &Field<Centre>,
        [norm, excess]: [f64; 2],
        transport: &dyn Transport,
    ) -> Result<SolveReport, SolveError> {
        let (mut iterations, mut rho, mut scale, mut goes_on) = (0, 0.0, 1.0 / norm, false);
        let [mut residual, mut rounding] = self.find_residual((rhs, excess), scale, transport);
        while !residual.is_finite() || residual > (self.tolerance * norm).max(rounding) {
            if !residual.is_finite() {
                let why = "the right-hand side or the guess is no number";
                return Err(self.failed(iterations, residual, why));
            }
            if iterations == self.max_iterations {
                let why = "raise the limit of iterations, or look for cells with extreme coefficients";
                return Err(self.failed(iterations, residual / norm, why));
            }
            let enough = (self.tolerance * norm).max(rounding).max(REDUCTION * residual);
            while residual > enough && iterations < self.max_iterations {
                let [next, before] = self.precondition(transport);
                let beta = if goes_on { next / rho } else { 0.0 };
                (rho, goes_on) = (next, true);
                let [curvature, along, square] = self.new_direction(beta, transport);
                if !(curvature > 0.0 && rho > 0.0) {
                    let why = "the operator is not definite";
                    return Err(self.failed(iterations, residual / norm, why));
                }
                let alpha = rho / curvature;
                self.advance(alpha, scale);
                let mut expected = [before + alpha * (2.0 * along + alpha * square)];
                if expected[0] < LOST * before {
                    expected = [self.own_square];
                    transport.sum(&mut expected);
                }
                residual = expected[0].sqrt() / scale;
                iterations += 1;
            }
            // What is kept of the last direction has the new scale.
            let expected = residual;
            if expected > 0.0 {
                rho /= expected * scale;
                scale = 1.0 / expected;
            }
            [residual, rounding] = self.find_residual((rhs, excess), scale, transport);
            goes_on = residual < ASTRAY * expected;
        }
        Ok(SolveReport { iterations, residual: residual / norm })
    }
}

/// A row of the residual A p − f, less what is in excess of f per width, as it is and in single precision times a scale; returns
/// the sums of its squares and of those of diagonal times pressure.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn residual_row(
    operator: &PressureOperator,
    (p, start): (&[f64], usize),
    (f, excess): (&[f64], f64),
    (row, scaled): (&mut [f64], &mut [f32]),
    scale: f64,
) -> [f64; 2] {
    let n = row.len();
    operator.apply_row(p, start, row);
    row.iter_mut().zip(f).for_each(|(row, f)| *row -= f);
    let diagonal = &operator.diagonal.data()[start..start + n];
    if excess != 0.0 {
        let cells = row.iter_mut().zip(operator.local.row_widths()).zip(diagonal);
        let open = cells.filter(|(_, diagonal)| **diagonal > 0.0);
        open.for_each(|((row, width), _)| *row += excess * width);
    }
    scaled.iter_mut().zip(&*row).for_each(|(scaled, row)| *scaled = (scale * row) as f32);
    let square = dot(row, row);
    row.iter_mut().zip(&p[start..]).zip(diagonal).for_each(|((row, p), diagonal)| *row = diagonal * p);
    [square, dot(row, row)]
}

/// d = z + β d.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn turn(d: &mut [f32], z: &[f32], beta: f32) {
    d.iter_mut().zip(z).for_each(|(d, z)| *d = z + beta * *d);
}

/// A row of p += a d and r += α A d; returns |r|² over it.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn advance_row((p, a, d): (&mut [f64], f64, &[f32]), (r, alpha, applied): (&mut [f32], f32, &[f32])) -> f64 {
    p.iter_mut().zip(d).for_each(|(p, d)| *p += a * f64::from(*d));
    r.iter_mut().zip(applied).for_each(|(r, applied)| *r += alpha * applied);
    single_operator::dot(r, r)
}

/// Places in the arrays of a layout of the own cells, but for those with no open face, and volumes (m³).
fn for_volumes(operator: &PressureOperator, layout: Layout, mut job: impl FnMut(usize, f64)) {
    let local = &operator.local;
    let [nx, ny, nz] = layout.cells;
    for k in 0..nz {
        for j in 0..ny {
            let area = local.axes[1].width[local.entry(j)] * local.axes[2].width[local.entry(k)];
            let diagonal = &operator.diagonal.data()[operator.layout().row(j, k)..][..nx];
            for (i, width) in local.row_widths().iter().enumerate() {
                if diagonal[i] > 0.0 {
                    job(layout.row(j, k) + i, width * area);
                }
            }
        }
    }
}

impl PressureSolver for ConjugateGradients {
    fn set_coefficients(
        &mut self,
        coefficients: &Faces,
        transport: &dyn Transport,
    ) -> Result<(), SolveError> {
        // Negative, infinite and no numbers all give a sum that is no number, and no early end keeps this fast.
        let check = |c: &f64| if (0.0..f64::INFINITY).contains(c) { 0.0 } else { f64::NAN };
        let bad = coefficients.components().iter().any(|c| c.iter().map(check).sum::<f64>().is_nan());
        self.operator.set(coefficients);
        let diagonals = own_rows(&self.operator.diagonal).flat_map(|own| &self.operator.diagonal.data()[own]);
        let mut largest = [f64::from(bad), diagonals.fold(0.0, |largest: f64, d| largest.max(*d))];
        transport.max(&mut largest);
        if largest[0] > 0.0 {
            let reason = "a coefficient is negative or no number: look at void fraction and drag".to_string();
            return Err(SolveError::Coefficients { reason });
        }
        self.unit = if largest[1] > 0.0 { largest[1] } else { 1.0 };
        self.engine.set(coefficients, &self.operator, self.unit, transport);
        Ok(())
    }

    fn solve(
        &mut self,
        rhs: &Field<Centre>,
        pressure: &mut Field<Centre>,
        transport: &dyn Transport,
    ) -> Result<SolveReport, SolveError> {
        let [norm, excess] = self.norm_and_excess(rhs, transport);
        if norm == 0.0 {
            pressure.fill(0.0);
            return Ok(SolveReport::default());
        }
        for (own, given) in own_rows(&self.pressure).zip(own_rows(pressure)) {
            self.pressure.data_mut()[own].copy_from_slice(&pressure.data()[given]);
        }
        let report = self.iterate(rhs, [norm, excess], transport)?;
        if self.problem.is_singular() {
            self.centre(transport);
        }
        for (own, given) in own_rows(&self.pressure).zip(own_rows(pressure)) {
            pressure.data_mut()[given].copy_from_slice(&self.pressure.data()[own]);
        }
        Ok(report)
    }
}
