//! Preconditioned conjugate gradients for coefficients that vary.

use super::{FastSolver, PressureOperator, PressureProblem, PressureSolver, SolveReport};
use crate::metrics::Local;
use crate::{Centre, Faces, Field, Halo, Layout, SolveError};
use grains_domain::Transport;

/// Conjugate gradients for any coefficients, preconditioned by the [`FastSolver`] with their means over planes.
///
/// The number of iterations depends on how much the coefficients vary within a plane, not on the grid.
pub struct ConjugateGradients {
    problem: PressureProblem,
    tolerance: f64,
    most: usize,
    preconditioner: FastSolver,
    operator: PressureOperator,
    halo: Halo,
    local: Local,
    residual: Field<Centre>,
    correction: Field<Centre>,
    direction: Field<Centre>,
    image: Field<Centre>,
}

impl ConjugateGradients {
    /// Solver that stops when the residual is below `tolerance` times the right-hand side, within `most`
    /// iterations.
    pub fn new(problem: &PressureProblem, tolerance: f64, most: usize, transport: &dyn Transport) -> Self {
        let layout = Layout { cells: problem.ownership.cells(), halo: problem.halo };
        let field = || Field::new(layout);
        Self {
            problem: problem.clone(),
            tolerance,
            most,
            preconditioner: FastSolver::new(problem, transport),
            operator: PressureOperator::new(problem),
            halo: Halo::new(&problem.grid, &problem.ownership, layout),
            local: Local::new(&problem.grid, &problem.ownership, problem.halo),
            residual: field(),
            correction: field(),
            direction: field(),
            image: field(),
        }
    }

    /// Per volume, the sum of a field over all ranks.
    fn density(&self, field: &Field<Centre>, transport: &dyn Transport) -> f64 {
        let mut sum = [field.own().sum()];
        transport.sum(&mut sum);
        sum[0] / self.problem.grid.volume()
    }

    /// Takes off the residual what no pressure can balance, evenly.
    fn balance(&mut self, transport: &dyn Transport) -> f64 {
        let density = self.density(&self.residual, transport);
        let mut sum = [0.0];
        for_volumes(&self.local, &mut self.residual, |r, volume| {
            *r -= density * volume;
            sum[0] += *r * *r;
        });
        transport.sum(&mut sum);
        sum[0].sqrt()
    }

    /// Makes the mean of the solution over the volume zero.
    fn centre(&mut self, pressure: &mut Field<Centre>, transport: &dyn Transport) {
        let mut sum = [0.0];
        for_volumes(&self.local, pressure, |p, volume| sum[0] += *p * volume);
        transport.sum(&mut sum);
        let mean = sum[0] / self.problem.grid.volume();
        for_volumes(&self.local, pressure, |p, _| *p -= mean);
    }

    /// r = f − A p; returns the norms of r and f.
    fn start(
        &mut self,
        rhs: &Field<Centre>,
        pressure: &mut Field<Centre>,
        transport: &dyn Transport,
    ) -> [f64; 2] {
        self.halo.fill(&mut [pressure.data_mut()], transport);
        self.operator.apply(pressure, &mut self.image);
        let layout = rhs.layout();
        let n = layout.cells[0];
        let mut norms = [0.0, 0.0];
        for start in layout.rows() {
            let own = start..start + n;
            let (f, image) = (&rhs.data()[own.clone()], &self.image.data()[own.clone()]);
            for ((r, f), a) in self.residual.data_mut()[own].iter_mut().zip(f).zip(image) {
                *r = f - a;
                norms[0] += *r * *r;
                norms[1] += f * f;
            }
        }
        transport.sum(&mut norms);
        norms.map(f64::sqrt)
    }

    /// x += α d and r −= α A d; returns the norm of r.
    fn advance(&mut self, pressure: &mut Field<Centre>, alpha: f64, transport: &dyn Transport) -> f64 {
        let layout = pressure.layout();
        let n = layout.cells[0];
        let mut sum = [0.0];
        for start in layout.rows() {
            let own = start..start + n;
            let direction = &self.direction.data()[own.clone()];
            pressure.data_mut()[own.clone()].iter_mut().zip(direction).for_each(|(x, d)| *x += alpha * d);
            let image = &self.image.data()[own.clone()];
            for (r, a) in self.residual.data_mut()[own].iter_mut().zip(image) {
                *r -= alpha * a;
                sum[0] += *r * *r;
            }
        }
        transport.sum(&mut sum);
        sum[0].sqrt()
    }

    fn failed(&self, iterations: usize, residual: f64, why: &str) -> SolveError {
        let reason = why.to_string();
        SolveError::NotConverged { iterations, residual, tolerance: self.tolerance, reason }
    }
}

/// Every own value with the volume of its cell (m³).
fn for_volumes(local: &Local, field: &mut Field<Centre>, mut job: impl FnMut(&mut f64, f64)) {
    let [nx, ny, nz] = local.layout.cells;
    for k in 0..nz {
        for j in 0..ny {
            let area = local.axes[1].width[local.entry(j)] * local.axes[2].width[local.entry(k)];
            let start = local.layout.row(j, k);
            let row = &mut field.data_mut()[start..start + nx];
            row.iter_mut().zip(local.row_widths()).for_each(|(value, width)| job(value, width * area));
        }
    }
}

/// Σ a b over the own cells of all ranks.
fn dot(a: &Field<Centre>, b: &Field<Centre>, transport: &dyn Transport) -> f64 {
    let layout = a.layout();
    let row = |start: usize| {
        let own = start..start + layout.cells[0];
        a.data()[own.clone()].iter().zip(&b.data()[own]).map(|(x, y)| x * y).sum::<f64>()
    };
    let mut sum = [layout.rows().map(row).sum()];
    transport.sum(&mut sum);
    sum[0]
}

impl PressureSolver for ConjugateGradients {
    fn set_coefficients(
        &mut self,
        coefficients: &Faces,
        transport: &dyn Transport,
    ) -> Result<(), SolveError> {
        let bad = coefficients.components().iter().any(|c| c.iter().any(|v| !v.is_finite() || *v < 0.0));
        if transport.any(bad) {
            let reason = "a coefficient is negative or no number: look at void fraction and drag".to_string();
            return Err(SolveError::Coefficients { reason });
        }
        self.preconditioner.set_mean_coefficients(coefficients, transport);
        self.operator.set(coefficients);
        Ok(())
    }

    fn solve(
        &mut self,
        rhs: &Field<Centre>,
        pressure: &mut Field<Centre>,
        transport: &dyn Transport,
    ) -> Result<SolveReport, SolveError> {
        let [mut residual, scale] = self.start(rhs, pressure, transport);
        if scale == 0.0 {
            pressure.fill(0.0);
            return Ok(SolveReport::default());
        }
        if self.problem.is_singular() {
            residual = self.balance(transport);
        }
        let (mut iterations, mut rho) = (0, 0.0);
        while residual.is_nan() || residual > self.tolerance * scale {
            if residual.is_nan() {
                return Err(self.failed(
                    iterations,
                    residual,
                    "the right-hand side or the guess is no number",
                ));
            }
            if iterations == self.most {
                let why = "raise the limit of iterations, or look for cells with extreme coefficients";
                return Err(self.failed(iterations, residual / scale, why));
            }
            self.preconditioner.apply(&self.residual, &mut self.correction, transport);
            let next = dot(&self.residual, &self.correction, transport);
            let beta = if iterations == 0 { 0.0 } else { next / rho };
            rho = next;
            let direction = self.direction.data_mut().iter_mut();
            direction.zip(self.correction.data()).for_each(|(d, z)| *d = z + beta * *d);
            self.halo.fill(&mut [self.direction.data_mut()], transport);
            let mut curvature = [self.operator.apply(&self.direction, &mut self.image)];
            transport.sum(&mut curvature);
            // Both the operator and its preconditioner are negative definite but for the null space.
            if curvature[0] >= 0.0 || rho >= 0.0 {
                return Err(self.failed(iterations, residual / scale, "the operator is not definite"));
            }
            residual = self.advance(pressure, rho / curvature[0], transport);
            iterations += 1;
        }
        if self.problem.is_singular() {
            self.centre(pressure, transport);
        }
        Ok(SolveReport { iterations, residual: residual / scale })
    }
}
