//! Preconditioned conjugate gradients for coefficients that vary.

use super::multigrid::Multigrid;
use super::operator::dot;
use super::{FastSolver, PressureOperator, PressureProblem, PressureSolver, SolveReport};
use crate::{Centre, Faces, Field, Halo, Layout, SolveError};
use grains_domain::Transport;

/// Ratio of the widest to the thinnest cell of an axis up to which multigrid is chosen: its smoother takes all cells
/// for equally flat.
const EVEN: f64 = 4.0;

/// Share of its square before below which the expected square of a residual is lost in rounding.
const LOST: f64 = 1e-12;

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
/// Ranks agree twice per iteration: on r · z and |r|², and on the products of A d, from which |r + α A d| follows.
pub struct ConjugateGradients {
    problem: PressureProblem,
    tolerance: f64,
    max_iterations: usize,
    engine: Engine,
    halo: Halo,
    /// All with a halo of one cell, zero beyond the box.
    residual: Field<Centre>,
    correction: Field<Centre>,
    direction: Field<Centre>,
    /// The operator applied to the search direction, A d.
    applied: Field<Centre>,
    /// Own part of |r|².
    own_square: f64,
}

/// The operator and an approximate inverse of it.
enum Engine {
    Multigrid(Multigrid),
    PlaneMeans { operator: Box<PressureOperator>, solver: Box<FastSolver> },
}

impl Engine {
    fn operator(&self) -> &PressureOperator {
        match self {
            Engine::Multigrid(multigrid) => multigrid.operator(),
            Engine::PlaneMeans { operator, .. } => operator,
        }
    }

    fn set(&mut self, coefficients: &Faces, transport: &dyn Transport) {
        match self {
            Engine::Multigrid(multigrid) => multigrid.set(coefficients, transport),
            Engine::PlaneMeans { operator, solver } => {
                operator.set(coefficients);
                solver.set_mean_coefficients(coefficients, transport);
            }
        }
    }

    /// Solves −div(c grad z) = r approximately; returns the own part of r · z.
    fn precondition(
        &mut self,
        r: &mut Field<Centre>,
        z: &mut Field<Centre>,
        transport: &dyn Transport,
    ) -> f64 {
        match self {
            Engine::Multigrid(multigrid) => multigrid.apply(r, z, transport),
            Engine::PlaneMeans { solver, .. } => {
                solver.apply(r, z, transport);
                z.data_mut().iter_mut().for_each(|z| *z = -*z);
                own_rows(r).map(|own| dot(&r.data()[own.clone()], &z.data()[own])).sum()
            }
        }
    }
}

/// Ranges of the own rows of a field.
fn own_rows(field: &Field<Centre>) -> impl Iterator<Item = std::ops::Range<usize>> + use<> {
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
        let field = || Field::new(layout);
        let engine = match preconditioner {
            Preconditioner::Multigrid => Engine::Multigrid(Multigrid::new(problem)),
            Preconditioner::PlaneMeans => Engine::PlaneMeans {
                operator: Box::new(PressureOperator::on(&problem.grid, &problem.partition, 1)),
                solver: Box::new(FastSolver::new(problem, transport)),
            },
        };
        Self {
            problem: problem.clone(),
            tolerance,
            max_iterations: max_iterations as usize,
            engine,
            halo: Halo::new(&problem.grid, &problem.partition, layout),
            residual: field(),
            correction: field(),
            direction: field(),
            applied: field(),
            own_square: 0.0,
        }
    }

    /// r = A p − f, the residual with its sign turned, less evenly what no pressure can balance; returns the norms of r and f.
    fn start(&mut self, rhs: &Field<Centre>, guess: &Field<Centre>, transport: &dyn Transport) -> [f64; 2] {
        for (own, given) in own_rows(&self.direction).zip(own_rows(guess)) {
            self.direction.data_mut()[own].copy_from_slice(&guess.data()[given]);
        }
        self.halo.fill(&mut [self.direction.data_mut()], transport);
        self.engine.operator().apply(&self.direction, &mut self.applied);
        let mut sums = [0.0; 4];
        for (own, given) in own_rows(&self.residual).zip(own_rows(rhs)) {
            let (f, applied) = (&rhs.data()[given], &self.applied.data()[own.clone()]);
            let r = &mut self.residual.data_mut()[own];
            r.iter_mut().zip(f).zip(applied).for_each(|((r, f), a)| *r = a - f);
            sums[0] += dot(r, r);
            sums[1] += dot(f, f);
        }
        self.own_square = sums[0];
        if self.problem.is_singular() {
            for_volumes(self.engine.operator(), &mut self.residual, |r, volume| {
                sums[2] += *r;
                sums[3] += volume;
            });
        }
        transport.sum(&mut sums);
        let [mut square, of_rhs, sum, volume] = sums;
        if self.problem.is_singular() && of_rhs > 0.0 {
            square = self.balance(sum / volume, transport);
        }
        [square.sqrt(), of_rhs.sqrt()]
    }

    /// Takes so much per volume off the residual; returns its square.
    fn balance(&mut self, density: f64, transport: &dyn Transport) -> f64 {
        let mut squares = [0.0];
        for_volumes(self.engine.operator(), &mut self.residual, |r, volume| {
            *r -= density * volume;
            squares[0] += *r * *r;
        });
        self.own_square = squares[0];
        transport.sum(&mut squares);
        squares[0]
    }

    /// Makes the mean of the solution over the volume zero.
    fn centre(&mut self, pressure: &mut Field<Centre>, transport: &dyn Transport) {
        let mut sums = [0.0; 2];
        for_volumes(self.engine.operator(), pressure, |p, volume| {
            sums[0] += *p * volume;
            sums[1] += volume;
        });
        transport.sum(&mut sums);
        let mean = sums[0] / sums[1];
        for_volumes(self.engine.operator(), pressure, |p, _| *p -= mean);
    }

    /// z of the residual; returns r · z and |r|² over all ranks.
    fn precondition(&mut self, transport: &dyn Transport) -> [f64; 2] {
        let product = self.engine.precondition(&mut self.residual, &mut self.correction, transport);
        let mut sums = [product, self.own_square];
        transport.sum(&mut sums);
        sums
    }

    /// d = z + β d; returns −d · A d, r · A d and |A d|² over all ranks.
    fn new_direction(&mut self, beta: f64, transport: &dyn Transport) -> [f64; 3] {
        for own in own_rows(&self.direction) {
            let z = &self.correction.data()[own.clone()];
            self.direction.data_mut()[own].iter_mut().zip(z).for_each(|(d, z)| *d = z + beta * *d);
        }
        self.halo.fill(&mut [self.direction.data_mut()], transport);
        let (residual, mut along, mut square) = (self.residual.data(), 0.0, 0.0);
        let product = self.engine.operator().apply_with(&self.direction, &mut self.applied, |own, row| {
            along += dot(&residual[own], row);
            square += dot(row, row);
        });
        let mut sums = [-product, along, square];
        transport.sum(&mut sums);
        sums
    }

    /// x += α d and r += α A d.
    fn advance(&mut self, pressure: &mut Field<Centre>, alpha: f64) {
        self.own_square = 0.0;
        for (own, given) in own_rows(&self.direction).zip(own_rows(pressure)) {
            let direction = &self.direction.data()[own.clone()];
            pressure.data_mut()[given].iter_mut().zip(direction).for_each(|(x, d)| *x += alpha * d);
            let applied = &self.applied.data()[own.clone()];
            let r = &mut self.residual.data_mut()[own];
            r.iter_mut().zip(applied).for_each(|(r, a)| *r += alpha * a);
            self.own_square += dot(r, r);
        }
    }

    fn failed(&self, iterations: usize, residual: f64, why: &str) -> SolveError {
        let reason = why.to_string();
        SolveError::NotConverged { iterations, residual, tolerance: self.tolerance, reason }
    }

    /// Iterates from a residual of the norm `residual`; returns the number of iterations and the last norm.
    fn iterate(
        &mut self,
        pressure: &mut Field<Centre>,
        [mut residual, scale]: [f64; 2],
        transport: &dyn Transport,
    ) -> Result<(usize, f64), SolveError> {
        let (mut iterations, mut rho) = (0, 0.0);
        while residual.is_nan() || residual > self.tolerance * scale {
            if residual.is_nan() {
                let why = "the right-hand side or the guess is no number";
                return Err(self.failed(iterations, residual, why));
            }
            if iterations == self.max_iterations {
                let why = "raise the limit of iterations, or look for cells with extreme coefficients";
                return Err(self.failed(iterations, residual / scale, why));
            }
            let [next, before] = self.precondition(transport);
            let beta = if iterations == 0 { 0.0 } else { next / rho };
            rho = next;
            let [curvature, along, square] = self.new_direction(beta, transport);
            if curvature <= 0.0 || rho <= 0.0 {
                return Err(self.failed(iterations, residual / scale, "the operator is not definite"));
            }
            let alpha = rho / curvature;
            self.advance(pressure, alpha);
            let mut expected = [before + alpha * (2.0 * along + alpha * square)];
            if expected[0] < LOST * before {
                expected = [self.own_square];
                transport.sum(&mut expected);
            }
            residual = expected[0].sqrt();
            iterations += 1;
        }
        Ok((iterations, residual))
    }
}

/// Every own value with the volume of its cell (m³), but for cells with no open face.
fn for_volumes(operator: &PressureOperator, field: &mut Field<Centre>, mut job: impl FnMut(&mut f64, f64)) {
    let (layout, local) = (field.layout(), &operator.local);
    let [nx, ny, nz] = layout.cells;
    for k in 0..nz {
        for j in 0..ny {
            let area = local.axes[1].width[local.entry(j)] * local.axes[2].width[local.entry(k)];
            let row = field.data_mut()[layout.row(j, k)..][..nx].iter_mut();
            let diagonal = &operator.diagonal.data()[operator.layout().row(j, k)..][..nx];
            let cells = row.zip(local.row_widths()).zip(diagonal);
            cells
                .filter(|(_, diagonal)| **diagonal > 0.0)
                .for_each(|((value, width), _)| job(value, width * area));
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
        if transport.any(bad) {
            let reason = "a coefficient is negative or no number: look at void fraction and drag".to_string();
            return Err(SolveError::Coefficients { reason });
        }
        self.engine.set(coefficients, transport);
        Ok(())
    }

    fn solve(
        &mut self,
        rhs: &Field<Centre>,
        pressure: &mut Field<Centre>,
        transport: &dyn Transport,
    ) -> Result<SolveReport, SolveError> {
        let [residual, scale] = self.start(rhs, pressure, transport);
        if scale == 0.0 {
            pressure.fill(0.0);
            return Ok(SolveReport::default());
        }
        let (iterations, residual) = self.iterate(pressure, [residual, scale], transport)?;
        if self.problem.is_singular() {
            self.centre(pressure, transport);
        }
        Ok(SolveReport { iterations, residual: residual / scale })
    }
}
