//! The solver.

use crate::arrays::{gather, gather_faces, inverse_volumes, scatter, widths};
use grains_domain::Transport;
use grains_fluid::{
    Centre, Faces, FastSolver, Field, Layout, PressureProblem, PressureSolver, SolveError, SolveReport,
};
use mpi::traits::Communicator;
use petsc_rs::{
    Boundary, Grid, LinearSolver, Options, Petsc, PetscError, Preconditioner, PressureMatrix, Settings,
};
use std::cell::RefCell;
use std::rc::Rc;

/// What preconditions PETSc's Krylov method, unless PETSc's option `-pc_type` chooses another.
pub enum Preconditioning {
    /// Geometric multigrid, for coefficients that vary.
    Multigrid,
    /// PETSc's algebraic multigrid.
    Algebraic,
    /// The fluid's own [`FastSolver`] with the means of the coefficients over planes, which communicates through the
    /// transport given: one or two iterations for a single phase.
    FastTransform(Box<dyn Transport>),
}

/// [`PressureSolver`] that hands Σ_faces c A (p_neighbour − p)/d = f to PETSc: conjugate gradients by default, any
/// Krylov method by its options.
///
/// It keeps PETSc running as long as it lives, and must be dropped before MPI ends. On the first coefficients the
/// options of case and command line are checked: one that PETSc does not use is an error.
pub struct PetscSolver {
    // Dropped in this order: PETSc is the last to go.
    solver: LinearSolver,
    fast: Option<Rc<RefCell<FastSolver>>>,
    petsc: Petsc,
    has_checked_options: bool,
    faces: [Vec<f64>; 3],
    inverse_volumes: Vec<f64>,
    ones: Vec<f64>,
    rhs: Vec<f64>,
    pressure: Vec<f64>,
}

impl PetscSolver {
    /// Starts PETSc on the ranks of a communicator and builds a solver for a problem; collective.
    ///
    /// Rank r of the communicator owns the cells of place r of [`grains_fluid::CellPartition`], x fastest. Errors if
    /// PETSc runs already, rejects an option, or the ranks do not match.
    pub fn new<C: Communicator>(
        problem: &PressureProblem,
        communicator: &C,
        options: &Options,
        settings: &Settings,
        preconditioning: Preconditioning,
    ) -> Result<Self, SolveError> {
        Self::start(problem, communicator, options, settings, preconditioning).map_err(explained)
    }

    fn start<C: Communicator>(
        problem: &PressureProblem,
        communicator: &C,
        options: &Options,
        settings: &Settings,
        preconditioning: Preconditioning,
    ) -> Result<Self, PetscError> {
        let petsc = Petsc::start(communicator, options)?;
        let matrix = matrix(problem, &petsc)?;
        let faces = matrix.face_counts().map(|n| vec![0.0; n]);
        let (cells, inverse_volumes) = (matrix.cells(), inverse_volumes(problem));
        let mut fast = None;
        let preconditioner = match preconditioning {
            Preconditioning::Multigrid => Preconditioner::Multigrid,
            Preconditioning::Algebraic => Preconditioner::Algebraic,
            Preconditioning::FastTransform(transport) => {
                let shared = Rc::new(RefCell::new(FastSolver::new(problem, &*transport)));
                fast = Some(Rc::clone(&shared));
                fast_transform(problem, shared, inverse_volumes.clone(), transport)
            }
        };
        Ok(Self {
            solver: LinearSolver::new(matrix, settings, preconditioner)?,
            fast,
            petsc,
            has_checked_options: false,
            faces,
            inverse_volumes,
            ones: vec![1.0; cells],
            rhs: vec![0.0; cells],
            pressure: vec![0.0; cells],
        })
    }

    /// Number of grids of the geometric multigrid; 1 without it.
    pub fn levels(&self) -> usize {
        self.solver.levels()
    }

    fn set(&mut self, coefficients: &Faces) -> Result<(), PetscError> {
        for (axis, array) in self.faces.iter_mut().enumerate() {
            gather_faces(coefficients, axis, array);
        }
        self.solver.set_coefficients(self.faces.each_ref().map(|list| &list[..]))?;
        if !self.has_checked_options {
            // PETSc asks for the options of inner solvers when they are set up.
            self.solver.set_up()?;
            self.petsc.check_options()?;
            self.has_checked_options = true;
        }
        Ok(())
    }
}

/// The operator of a problem.
fn matrix(problem: &PressureProblem, petsc: &Petsc) -> Result<PressureMatrix, PetscError> {
    let periodic = [0, 1, 2].map(|a| problem.grid.axis(a).is_periodic());
    let owned = [0, 1, 2].map(|a| problem.partition.counts(a));
    let grid = Grid::new(petsc, owned.each_ref().map(|list| &list[..]), periodic)?;
    let widths = [0, 1, 2].map(|a| widths(problem, a));
    let boundaries = [0, 1, 2].map(|a| {
        problem.imposed[a].map(|imposed| match (periodic[a], imposed) {
            (true, _) => Boundary::Periodic,
            (false, true) => Boundary::Dirichlet,
            (false, false) => Boundary::Neumann,
        })
    });
    PressureMatrix::new(&grid, widths.each_ref().map(|list| &list[..]), boundaries)
}

/// The fast solver as a function of arrays without halo.
fn fast_transform(
    problem: &PressureProblem,
    solver: Rc<RefCell<FastSolver>>,
    inverse_volumes: Vec<f64>,
    transport: Box<dyn Transport>,
) -> Preconditioner {
    let layout = Layout { cells: problem.partition.cells(), halo: problem.halo };
    let (mut rhs, mut solution) = (Field::<Centre>::new(layout), Field::<Centre>::new(layout));
    let ones = vec![1.0; inverse_volumes.len()];
    Preconditioner::Function(Box::new(move |f, p| {
        scatter(f, &inverse_volumes, &mut rhs);
        solver.borrow_mut().apply(&rhs, &mut solution, &*transport);
        gather(&solution, &ones, p);
    }))
}

/// What PETSc found, as the fluid reports it.
fn explained(error: PetscError) -> SolveError {
    match error {
        PetscError::IterationLimit { iterations, residual, tolerance } => SolveError::NotConverged {
            iterations,
            residual,
            tolerance,
            reason: "PETSc's limit of iterations: allow more (-ksp_max_it), loosen the tolerance (-ksp_rtol), or choose a stronger preconditioner (-pc_type)".into(),
        },
        PetscError::Coefficient(reason) => SolveError::Coefficients { reason },
        other => SolveError::Library(other.to_string()),
    }
}

impl PressureSolver for PetscSolver {
    fn set_coefficients(
        &mut self,
        coefficients: &Faces,
        transport: &dyn Transport,
    ) -> Result<(), SolveError> {
        self.set(coefficients).map_err(explained)?;
        if let Some(fast) = &self.fast {
            fast.borrow_mut().set_mean_coefficients(coefficients, transport);
        }
        Ok(())
    }

    fn solve(
        &mut self,
        rhs: &Field<Centre>,
        pressure: &mut Field<Centre>,
        _: &dyn Transport,
    ) -> Result<SolveReport, SolveError> {
        gather(rhs, &self.inverse_volumes, &mut self.rhs);
        gather(pressure, &self.ones, &mut self.pressure);
        let report = self.solver.solve(&self.rhs, &mut self.pressure).map_err(explained)?;
        scatter(&self.pressure, &self.ones, pressure);
        Ok(SolveReport { iterations: report.iterations, residual: report.residual })
    }
}
