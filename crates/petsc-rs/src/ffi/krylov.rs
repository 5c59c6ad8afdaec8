//! Krylov solvers and their preconditioners.

use super::bindings as c;
use super::matrix::Matrix;
use super::session::{Session, c_text};
use super::vector::Vector;
use crate::PetscError;
use std::any::Any;
use std::ffi::{CStr, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::ptr::null_mut;
use std::rc::Rc;

/// An approximate inverse, from its first argument to the second, on the own cells (x fastest).
pub type Function = Box<dyn FnMut(&[f64], &mut [f64])>;

/// What a preconditioner of the caller needs between PETSc's calls.
struct Shell {
    apply: Function,
    /// A panic of the closure, on its way across PETSc.
    panic: Option<Box<dyn Any + Send>>,
}

/// PETSc's code for an error in a function of the user.
const USER_ERROR: i32 = 83;

/// Over-relaxation of the smoother: saves one iteration of eight against none, on 1, 2 and 4 ranks alike.
const RELAXATION: f64 = 1.15;

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Stop {
    /// Within the tolerance.
    Converged,
    /// Without a look at the residual, as a single application of the preconditioner does.
    Unchecked,
    /// The limit of iterations.
    IterationLimit,
    /// For a reason, with what helps.
    Broken(&'static str),
}

/// A solve, done.
pub(crate) struct Outcome {
    /// Iterations.
    pub iterations: usize,
    /// Norm of the last residual.
    pub residual: f64,
    /// Why it ended.
    pub stop: Stop,
}

/// A Krylov solver.
pub(crate) struct Krylov {
    raw: c::KSP,
    session: Rc<Session>,
    shell: *mut Shell,
}

impl Krylov {
    /// Conjugate gradients that stop at a tolerance on the norm of the true residual over that of b.
    pub fn new(
        session: &Rc<Session>,
        prefix: &str,
        tolerance: f64,
        max_iterations: usize,
    ) -> Result<Self, PetscError> {
        let mut krylov = Self { raw: null_mut(), session: Rc::clone(session), shell: null_mut() };
        let prefix = c_text(prefix)?;
        // The residual may grow on the way: no limit on that; and no absolute tolerance.
        let (absolute, growth, limit) = (0.0, 1e30, max_iterations.min(i32::MAX as usize) as i32);
        let norm = c::KSPNormType::KSP_NORM_UNPRECONDITIONED;
        // SAFETY: texts outlive their calls and are copied.
        unsafe {
            session.check("KSPCreate", c::KSPCreate(session.raw(), &mut krylov.raw))?;
            let raw = krylov.raw;
            session.check("KSPSetOptionsPrefix", c::KSPSetOptionsPrefix(raw, prefix.as_ptr()))?;
            session.check("KSPSetType", c::KSPSetType(raw, c"cg".as_ptr()))?;
            session.check("KSPSetNormType", c::KSPSetNormType(raw, norm))?;
            let code = c::KSPSetTolerances(raw, tolerance, absolute, growth, limit);
            session.check("KSPSetTolerances", code)?;
        }
        Ok(krylov)
    }

    /// Solves with this matrix, which the preconditioner is built from too.
    pub fn set_operator(&mut self, matrix: &Matrix) -> Result<(), PetscError> {
        // SAFETY: both exist; PETSc takes a reference to the matrix.
        let code = unsafe { c::KSPSetOperators(self.raw, matrix.raw(), matrix.raw()) };
        self.session.check("KSPSetOperators", code)
    }

    fn preconditioner(&self) -> Result<c::PC, PetscError> {
        let mut pc = null_mut();
        // SAFETY: the solver exists and owns what it returns.
        self.session.check("KSPGetPC", unsafe { c::KSPGetPC(self.raw, &mut pc) })?;
        Ok(pc)
    }

    /// Chooses PETSc's preconditioner by name.
    pub fn set_preconditioner(&mut self, name: &CStr) -> Result<(), PetscError> {
        // SAFETY: the preconditioner exists; PETSc copies the name.
        let code = unsafe { c::PCSetType(self.preconditioner()?, name.as_ptr()) };
        self.session.check("PCSetType", code)
    }

    /// Preconditions by a function.
    pub fn set_shell(&mut self, apply: Function) -> Result<(), PetscError> {
        self.set_preconditioner(c"shell")?;
        let pc = self.preconditioner()?;
        let shell = Box::into_raw(Box::new(Shell { apply, panic: None }));
        // SAFETY: the context lives until the solver is dropped, which destroys the preconditioner first; an
        // earlier one is freed once nothing refers to it.
        unsafe {
            let old = std::mem::replace(&mut self.shell, shell);
            self.session.check("PCShellSetContext", c::PCShellSetContext(pc, shell.cast()))?;
            self.session.check("PCShellSetApply", c::PCShellSetApply(pc, Some(apply_shell)))?;
            self.session
                .check("PCShellSetName", c::PCShellSetName(pc, c"function of the caller".as_ptr()))?;
            if !old.is_null() {
                drop(Box::from_raw(old));
            }
        }
        Ok(())
    }

    /// A V-cycle on as many grids as `transfers` lead to; `transfers[l]` leads from level l to l + 1, the coarsest first. A symmetric Gauss-Seidel sweep before and after each coarse correction; singular values on the
    /// coarsest level.
    pub fn set_multigrid(&mut self, transfers: &[&Matrix]) -> Result<(), PetscError> {
        self.set_preconditioner(c"mg")?;
        let (pc, session) = (self.preconditioner()?, &self.session);
        let levels = transfers.len() as i32 + 1;
        // SAFETY: levels are numbered from the coarsest; PETSc takes references to the matrices.
        unsafe {
            session.check("PCMGSetLevels", c::PCMGSetLevels(pc, levels, null_mut()))?;
            for (level, transfer) in (1..).zip(transfers) {
                let code = c::PCMGSetInterpolation(pc, level, transfer.raw());
                session.check("PCMGSetInterpolation", code)?;
            }
            for level in 1..levels {
                set_smoother(session, self.smoother(pc, level)?)?;
            }
            set_coarse_solver(session, self.smoother(pc, 0)?)
        }
    }

    /// Tells the levels of a multigrid that their matrices are new, coarsest first and without the finest.
    pub fn set_level_operators(&mut self, operators: &[&Matrix]) -> Result<(), PetscError> {
        let pc = self.preconditioner()?;
        for (level, operator) in (0..).zip(operators) {
            let smoother = self.smoother(pc, level)?;
            // SAFETY: both exist; PETSc takes references to the matrix.
            let code = unsafe { c::KSPSetOperators(smoother, operator.raw(), operator.raw()) };
            self.session.check("KSPSetOperators", code)?;
        }
        Ok(())
    }

    /// The solver of a level.
    fn smoother(&self, pc: c::PC, level: i32) -> Result<c::KSP, PetscError> {
        let mut smoother = null_mut();
        // SAFETY: the preconditioner exists and owns what it returns; PETSc checks that it has the level.
        let code = unsafe { c::PCMGGetSmoother(pc, level, &mut smoother) };
        self.session.check("PCMGGetSmoother", code)?;
        Ok(smoother)
    }

    /// Lets the options of PETSc have the last word.
    pub fn set_from_options(&mut self) -> Result<(), PetscError> {
        // SAFETY: the solver exists.
        self.session.check("KSPSetFromOptions", unsafe { c::KSPSetFromOptions(self.raw) })
    }

    /// Whether PETSc's multigrid makes the operators of its coarse grids itself, by its option `-pc_mg_galerkin`.
    pub fn is_galerkin(&self) -> Result<bool, PetscError> {
        let mut kind = c::PCMGGalerkinType::PC_MG_GALERKIN_NONE;
        // SAFETY: a multigrid, as the caller has found out; PETSc writes one number.
        let code = unsafe { c::PCMGGetGalerkin(self.preconditioner()?, &mut kind) };
        self.session.check("PCMGGetGalerkin", code)?;
        Ok(kind != c::PCMGGalerkinType::PC_MG_GALERKIN_NONE)
    }

    /// Name of the preconditioner in force.
    pub fn preconditioner_name(&self) -> Result<String, PetscError> {
        let mut name = std::ptr::null();
        // SAFETY: the preconditioner owns its name, which is copied here.
        unsafe {
            self.session.check("PCGetType", c::PCGetType(self.preconditioner()?, &mut name))?;
            Ok(if name.is_null() { String::new() } else { CStr::from_ptr(name).to_string_lossy().into() })
        }
    }

    /// Whether the preconditioner stays as it is although the matrix has changed.
    pub fn keep_preconditioner(&mut self, keep: bool) -> Result<(), PetscError> {
        // SAFETY: the solver exists.
        let code = unsafe { c::KSPSetReusePreconditioner(self.raw, flag(keep)) };
        self.session.check("KSPSetReusePreconditioner", code)
    }

    /// Relative tolerance in force, after the options.
    pub fn tolerance(&self) -> Result<f64, PetscError> {
        let (mut tolerance, unwanted) = (0.0, null_mut());
        // SAFETY: PETSc writes one number; null pointers stand for those that are not wanted.
        let code = unsafe { c::KSPGetTolerances(self.raw, &mut tolerance, unwanted, unwanted, null_mut()) };
        self.session.check("KSPGetTolerances", code)?;
        Ok(tolerance)
    }

    /// Builds what the solves need.
    pub fn set_up(&mut self) -> Result<(), PetscError> {
        // SAFETY: the solver exists and has an operator.
        self.session.check("KSPSetUp", unsafe { c::KSPSetUp(self.raw) })
    }

    /// Solves A x = b from the first guess in x, or from zero.
    pub fn solve(&mut self, b: &Vector, x: &Vector, has_guess: bool) -> Result<Outcome, PetscError> {
        let (mut iterations, mut residual, mut reason) = (0, 0.0, 0);
        // SAFETY: all objects exist; PETSc writes three numbers.
        unsafe {
            let code = c::KSPSetInitialGuessNonzero(self.raw, flag(has_guess));
            self.session.check("KSPSetInitialGuessNonzero", code)?;
            let code = c::KSPSolve(self.raw, b.raw(), x.raw());
            if let Some(panic) = self.shell.as_mut().and_then(|shell| shell.panic.take()) {
                resume_unwind(panic);
            }
            self.session.check("KSPSolve", code)?;
            self.session
                .check("KSPGetIterationNumber", c::KSPGetIterationNumber(self.raw, &mut iterations))?;
            self.session.check("KSPGetResidualNorm", c::KSPGetResidualNorm(self.raw, &mut residual))?;
            self.session.check("KSPGetConvergedReason", c::KSPGetConvergedReason(self.raw, &mut reason))?;
        }
        Ok(Outcome { iterations: iterations as usize, residual, stop: stop(reason) })
    }
}

impl Drop for Krylov {
    fn drop(&mut self) {
        // SAFETY: destroyed once, while PETSc runs, and before the context its preconditioner refers to. If
        // it cannot be destroyed any more nothing will call the preconditioner either.
        unsafe {
            if self.session.is_usable() {
                c::KSPDestroy(&mut self.raw);
            }
            if !self.shell.is_null() {
                drop(Box::from_raw(self.shell));
            }
        }
    }
}

/// One Richardson step with a symmetric Gauss-Seidel sweep within each rank, so that the cycle is symmetric.
///
/// # Safety
/// `smoother` must be a solver that PETSc has handed out and that still exists.
unsafe fn set_smoother(session: &Session, smoother: c::KSP) -> Result<(), PetscError> {
    let usual = f64::from(c::PETSC_DEFAULT);
    let mut pc = null_mut();
    // SAFETY: the solver exists, as the caller promises.
    unsafe {
        session.check("KSPSetType", c::KSPSetType(smoother, c"richardson".as_ptr()))?;
        session.check("KSPSetTolerances", c::KSPSetTolerances(smoother, usual, usual, usual, 1))?;
        session.check("KSPGetPC", c::KSPGetPC(smoother, &mut pc))?;
        session.check("PCSetType", c::PCSetType(pc, c"sor".as_ptr()))?;
        session.check("PCSORSetOmega", c::PCSORSetOmega(pc, RELAXATION))
    }
}

/// Every rank solves the whole coarsest problem by singular values, whether it is singular or not.
///
/// # Safety
/// `coarse` must be a solver that PETSc has handed out and that still exists.
unsafe fn set_coarse_solver(session: &Session, coarse: c::KSP) -> Result<(), PetscError> {
    let (mut pc, mut inner) = (null_mut(), null_mut());
    // SAFETY: the solver exists, as the caller promises.
    unsafe {
        session.check("KSPSetType", c::KSPSetType(coarse, c"preonly".as_ptr()))?;
        session.check("KSPGetPC", c::KSPGetPC(coarse, &mut pc))?;
        session.check("PCSetType", c::PCSetType(pc, c"redundant".as_ptr()))?;
        session.check("PCRedundantGetKSP", c::PCRedundantGetKSP(pc, &mut inner))?;
        session.check("KSPGetPC", c::KSPGetPC(inner, &mut pc))?;
        session.check("PCSetType", c::PCSetType(pc, c"svd".as_ptr()))
    }
}

/// Calls the closure of a [`Shell`] on PETSc's vectors; panics stay on this side.
unsafe extern "C" fn apply_shell(pc: c::PC, residual: c::Vec, correction: c::Vec) -> c::PetscErrorCode {
    let mut context: *mut c_void = null_mut();
    let (mut input, mut output, mut length) = (std::ptr::null(), null_mut(), 0);
    // SAFETY: PETSc calls this with the preconditioner that `set_shell` gave a context, and two different
    // vectors of equal length, whose arrays are given back before it goes on. No other reference to the
    // context exists meanwhile: `solve` looks at it after PETSc has returned.
    unsafe {
        for code in [
            c::PCShellGetContext(pc, (&raw mut context).cast()),
            c::VecGetLocalSize(residual, &mut length),
            c::VecGetArrayRead(residual, &mut input),
            c::VecGetArray(correction, &mut output),
        ] {
            if code != 0 {
                return code;
            }
        }
        let shell = &mut *context.cast::<Shell>();
        let (from, to) = match length {
            0 => (&[][..], &mut [][..]),
            n => (
                std::slice::from_raw_parts(input, n as usize),
                std::slice::from_raw_parts_mut(output, n as usize),
            ),
        };
        let done = catch_unwind(AssertUnwindSafe(|| (shell.apply)(from, to)));
        let codes =
            [c::VecRestoreArrayRead(residual, &mut input), c::VecRestoreArray(correction, &mut output)];
        match done {
            Ok(()) => codes.into_iter().find(|&code| code != 0).unwrap_or(0),
            Err(panic) => {
                shell.panic = Some(panic);
                USER_ERROR
            }
        }
    }
}

fn flag(is: bool) -> c::PetscBool::Type {
    if is { c::PetscBool::PETSC_TRUE } else { c::PetscBool::PETSC_FALSE }
}

fn stop(reason: c::KSPConvergedReason::Type) -> Stop {
    use c::KSPConvergedReason as r;
    Stop::Broken(match reason {
        r::KSP_DIVERGED_ITS => return Stop::IterationLimit,
        r::KSP_DIVERGED_NULL | r::KSP_CONVERGED_ITERATING => {
            "the solver ended without a result; choose another -ksp_type"
        }
        r::KSP_DIVERGED_DTOL => {
            "the residual grew beyond -ksp_divtol; choose the default solver or a stronger preconditioner"
        }
        r::KSP_DIVERGED_BREAKDOWN | r::KSP_DIVERGED_BREAKDOWN_BICG => {
            "the Krylov method broke down; a singular system whose inflow and outflow differ does this, else choose another -ksp_type"
        }
        r::KSP_DIVERGED_NONSYMMETRIC => {
            "the solver needs a symmetric matrix and preconditioner; choose -ksp_type gmres or bcgs"
        }
        r::KSP_DIVERGED_INDEFINITE_PC => {
            "the preconditioner is not positive definite; make it symmetric, give the faces between ranks and periodic images the same coefficient on both sides, or choose -ksp_type fgmres"
        }
        r::KSP_DIVERGED_NANORINF => {
            "NaN or infinity appeared; look for coefficients that are zero all around a cell, or a preconditioner that overflows"
        }
        r::KSP_DIVERGED_INDEFINITE_MAT => {
            "the matrix is not positive definite; give the faces between ranks and periodic images the same coefficient on both sides"
        }
        r::KSP_DIVERGED_PC_FAILED => {
            "the preconditioner could not be built; choose the default (multigrid) or -pc_type jacobi"
        }
        r::KSP_CONVERGED_RTOL | r::KSP_CONVERGED_ATOL | r::KSP_CONVERGED_HAPPY_BREAKDOWN => {
            return Stop::Converged;
        }
        positive if positive > 0 => return Stop::Unchecked,
        _ => "for a reason unknown to this program; run with -ksp_converged_reason to see PETSc's",
    })
}
