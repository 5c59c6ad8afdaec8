//! Solving the pressure equation.

use crate::ffi::{Function, Krylov, Outcome, Stop, Vector};
use crate::multigrid::Hierarchy;
use crate::pressure::check_length;
use crate::{PetscError, PressureMatrix};
use std::cell::Cell;
use std::rc::Rc;

/// What makes the Krylov method converge fast.
pub enum Preconditioner {
    /// Geometric multigrid on grids of paired cells, of any numbers of cells, stretched or flat.
    Multigrid,
    /// PETSc's algebraic multigrid (GAMG): slower to build and to apply, also where coefficients jump 1000-fold.
    Algebraic,
    /// A function of the caller that solves div(c grad p) = f approximately: from f on the own cells (x
    /// fastest) it writes p. It must be linear and symmetric; it may communicate.
    Function(Function),
}

/// How a [`LinearSolver`] works; PETSc's options win over it.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Largest norm of the residual f - div(c grad p), weighted by volume, over that of f.
    pub tolerance: f64,
    /// Largest number of iterations per solve.
    pub max_iterations: usize,
    /// Number of solves with changed coefficients for which the preconditioner is kept before it is built
    /// anew; 0 builds it after every change.
    pub reuse: usize,
    /// What names of this solver's options begin with, after the dash: such as `pressure_`.
    pub prefix: String,
}

/// A solve that met its tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// Iterations of the Krylov method.
    pub iterations: usize,
    /// Norm of the residual over that of the right-hand side.
    pub residual: f64,
    /// Where the operator is singular, |Σ f V| / Σ |f V|: the part of the right-hand side that no pressure
    /// can meet and that was left out; else 0. Much above rounding, in and outflow do not balance.
    pub imbalance: f64,
}

/// A Krylov solver for the pressure equation, set up once and used many times.
pub struct LinearSolver {
    // Fields are dropped in this order: the solver before the matrices it refers to.
    krylov: Krylov,
    hierarchy: Option<Hierarchy>,
    /// Whether PETSc makes the operators of the coarse grids itself, as its option `-pc_mg_galerkin` asks.
    is_galerkin: bool,
    pressure: PressureMatrix,
    rhs: Vector,
    /// Scale of the matrix, as a preconditioner of the caller must know it.
    scale: Rc<Cell<f64>>,
    settings: Settings,
    tolerance: f64,
    state: State,
}

/// How old the preconditioner is.
#[derive(Default)]
struct State {
    /// Scale and singularity it was built for.
    built_for: Option<(f64, bool)>,
    /// Whether coefficients have changed since.
    is_stale: bool,
    /// Solves with changed coefficients since.
    stale_solves: usize,
    /// Times it was built.
    builds: usize,
}

impl Default for Settings {
    /// A tolerance of 1e-6, 200 iterations, a new preconditioner for new coefficients, no prefix.
    fn default() -> Self {
        Self { tolerance: 1e-6, max_iterations: 200, reuse: 0, prefix: String::new() }
    }
}

impl LinearSolver {
    /// A solver for an operator: conjugate gradients with a preconditioner. Collective.
    ///
    /// Errors if PETSc rejects one of its options.
    pub fn new(
        pressure: PressureMatrix,
        settings: &Settings,
        preconditioner: Preconditioner,
    ) -> Result<Self, PetscError> {
        let session = Rc::clone(&pressure.session);
        let mut krylov =
            Krylov::new(&session, &settings.prefix, settings.tolerance, settings.max_iterations)?;
        krylov.set_operator(&pressure.matrix)?;
        let scale = Rc::new(Cell::new(1.0));
        let mut hierarchy = None;
        match preconditioner {
            Preconditioner::Multigrid => {
                let max_levels = session.integer_option(&settings.prefix, "-pc_mg_levels")?;
                let grids = Hierarchy::new(&pressure, max_levels.unwrap_or(usize::MAX).max(1))?;
                krylov.set_multigrid(&grids.transfers())?;
                hierarchy = Some(grids);
            }
            Preconditioner::Algebraic => krylov.set_preconditioner(c"gamg")?,
            Preconditioner::Function(apply) => krylov.set_shell(adapted(&pressure, &scale, apply))?,
        }
        krylov.set_from_options()?;
        if krylov.preconditioner_name()? != "mg" {
            hierarchy = None;
        }
        let is_galerkin = hierarchy.is_some() && krylov.is_galerkin()?;
        let (tolerance, (_, rhs)) = (krylov.tolerance()?, pressure.matrix.vectors()?);
        let (settings, state) = (settings.clone(), State::default());
        Ok(Self { krylov, hierarchy, is_galerkin, pressure, rhs, scale, settings, tolerance, state })
    }

    /// The operator.
    pub fn pressure(&self) -> &PressureMatrix {
        &self.pressure
    }

    /// Number of grids of the geometric multigrid, the finest included; 1 without it.
    pub fn levels(&self) -> usize {
        self.hierarchy.as_ref().map_or(1, Hierarchy::count)
    }

    /// How often the preconditioner has been built.
    pub fn builds(&self) -> usize {
        self.state.builds
    }

    /// Changes the coefficients, see [`PressureMatrix::set_coefficients`]. Collective.
    pub fn set_coefficients(&mut self, faces: [&[f64]; 3]) -> Result<(), PetscError> {
        self.pressure.set_coefficients(faces)?;
        self.scale.set(self.pressure.scale);
        self.state.is_stale = true;
        Ok(())
    }

    /// Builds the preconditioner now instead of in the next solve. Collective.
    pub fn set_up(&mut self) -> Result<(), PetscError> {
        self.pressure.check_ready()?;
        if let Some(hierarchy) = self.hierarchy.as_mut().filter(|_| !self.is_galerkin) {
            hierarchy.refresh(&self.pressure)?;
            self.krylov.set_level_operators(&hierarchy.operators())?;
        }
        self.krylov.set_operator(&self.pressure.matrix)?;
        self.krylov.keep_preconditioner(false)?;
        self.krylov.set_up()?;
        let built_for = Some((self.pressure.scale, self.pressure.is_singular));
        let builds = self.state.builds + 1;
        self.state = State { built_for, is_stale: false, stale_solves: 0, builds };
        Ok(())
    }

    /// Solves div(c grad p) = f for the own cells: `x` holds the first guess and then p. Collective.
    ///
    /// Where the operator is singular the mean of f is left out, and p has the mean 0 (by volume). With
    /// coefficients that have changed, a solve that fails is repeated once with a new preconditioner.
    /// Errors with PETSc's reason if the tolerance is not met; `x` is then of no use.
    pub fn solve(&mut self, rhs: &[f64], x: &mut [f64]) -> Result<Report, PetscError> {
        self.pressure.check_ready()?;
        check_length("the right-hand side", self.pressure.cells(), rhs.len())?;
        check_length("the pressure", self.pressure.cells(), x.len())?;
        self.renew_if_old()?;
        let imbalance = self.load(rhs)?;
        let norm = self.rhs.norm()?;
        let guess = self.pressure.input.with_array(x, |x| x.norm())?;
        for (what, value) in [("right-hand side", norm), ("first guess", guess)] {
            if !value.is_finite() {
                return Err(PetscError::NotFinite(what));
            }
        }
        if norm == 0.0 {
            x.fill(0.0);
            return Ok(Report { iterations: 0, residual: 0.0, imbalance });
        }
        let mut done = self.run(x, guess > 0.0, norm);
        let is_retried = matches!(done, Err(PetscError::IterationLimit { .. } | PetscError::Diverged { .. }))
            && self.state.is_stale;
        if is_retried {
            self.set_up()?;
            x.fill(0.0);
            done = self.run(x, false, norm);
        }
        let (iterations, residual) = done?;
        if self.pressure.is_singular {
            self.remove_mean(x);
        }
        Ok(Report { iterations, residual, imbalance })
    }

    /// Builds the preconditioner if there is none, or it has been kept long enough.
    fn renew_if_old(&mut self) -> Result<(), PetscError> {
        let now = (self.pressure.scale, self.pressure.is_singular);
        let is_usable = self.state.built_for == Some(now);
        if !is_usable || (self.state.is_stale && self.state.stale_solves >= self.settings.reuse) {
            return self.set_up();
        }
        self.state.stale_solves += usize::from(self.state.is_stale);
        self.krylov.keep_preconditioner(true)
    }

    /// Puts the right-hand side where PETSc wants it; returns the imbalance.
    fn load(&mut self, rhs: &[f64]) -> Result<f64, PetscError> {
        let mut b = self.rhs.write()?;
        self.pressure.integrate(rhs, &mut b);
        if !self.pressure.is_singular {
            return Ok(0.0);
        }
        let own = [b.iter().sum::<f64>(), b.iter().map(|v| v.abs()).sum::<f64>()];
        let [sum, size] = self.pressure.session.sum(own);
        let mean = sum / self.pressure.layout.cells() as f64;
        b.iter_mut().for_each(|value| *value -= mean);
        Ok(if size > 0.0 { sum.abs() / size } else { 0.0 })
    }

    fn run(&mut self, x: &mut [f64], has_guess: bool, norm: f64) -> Result<(usize, f64), PetscError> {
        let (krylov, rhs) = (&mut self.krylov, &self.rhs);
        let outcome = self.pressure.input.with_array(x, |x| krylov.solve(rhs, x, has_guess))?;
        let Outcome { iterations, stop, .. } = outcome;
        let tolerance = self.tolerance;
        let residual = match stop {
            Stop::Unchecked => self.true_residual(x)?,
            _ => outcome.residual,
        } / norm;
        match stop {
            Stop::Converged => Ok((iterations, residual)),
            Stop::Unchecked if residual <= tolerance => Ok((iterations, residual)),
            Stop::Unchecked | Stop::IterationLimit => {
                Err(PetscError::IterationLimit { iterations, residual, tolerance })
            }
            Stop::Broken(reason) => Err(PetscError::Diverged { reason, iterations, residual }),
        }
    }

    /// Norm of b - A x.
    fn true_residual(&mut self, x: &mut [f64]) -> Result<f64, PetscError> {
        let (_, product) = self.pressure.matrix.vectors()?;
        self.pressure.input.with_array(x, |x| self.pressure.matrix.multiply(x, &product))?;
        let (b, product) = (self.rhs.read()?, product.read()?);
        let own: f64 = b.iter().zip(product.iter()).map(|(b, a)| (b - a) * (b - a)).sum();
        Ok(self.pressure.session.sum([own])[0].sqrt())
    }

    /// Subtracts the mean by volume.
    fn remove_mean(&self, x: &mut [f64]) {
        let widths = &self.pressure.geometry.widths[0];
        let mut own = [0.0; 2];
        self.pressure.geometry.for_each_line(|first, area| {
            let line = &x[first..first + widths.len()];
            own[0] += area * line.iter().zip(widths).map(|(value, width)| value * width).sum::<f64>();
            own[1] += area * widths.iter().sum::<f64>();
        });
        let [sum, volume] = self.pressure.session.sum(own);
        let mean = sum / volume;
        x.iter_mut().for_each(|value| *value -= mean);
    }
}

/// The caller's function as PETSc needs it: residuals of the scaled matrix instead of f.
fn adapted(pressure: &PressureMatrix, scale: &Rc<Cell<f64>>, mut apply: Function) -> Function {
    let mut inverse_volumes = vec![0.0; pressure.cells()];
    let widths = &pressure.geometry.widths[0];
    pressure.geometry.for_each_line(|first, area| {
        for (value, width) in inverse_volumes[first..].iter_mut().zip(widths) {
            *value = 1.0 / (area * width);
        }
    });
    let (scale, mut rhs) = (Rc::clone(scale), vec![0.0; pressure.cells()]);
    Box::new(move |residual, correction| {
        let scale = -scale.get();
        for ((f, r), inverse) in rhs.iter_mut().zip(residual).zip(&inverse_volumes) {
            *f = r * scale * inverse;
        }
        apply(&rhs, correction);
    })
}
