//! What can go wrong, in words.

use thiserror::Error;

/// Why PETSc could not be set up or did not solve.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PetscError {
    /// PETSc runs already in this process.
    #[error("PETSc is already running in this process: keep one `Petsc` and share it by reference")]
    AlreadyStarted,
    /// A text of options that cannot be read.
    #[error(
        "solver options `{text}`: {reason}; write them as on PETSc's command line: -name value -name value"
    )]
    OptionSyntax {
        /// The text.
        text: String,
        /// What is wrong with it.
        reason: String,
    },
    /// Options that no solver asked for.
    #[error("solver option{} {}: no solver uses it{hint}; correct or remove it", if names.len() > 1 { "s" } else { "" }, names.join(", "))]
    UnusedOptions {
        /// Their names.
        names: Vec<String>,
        /// The suggestion, or nothing.
        hint: String,
    },
    /// PETSc rejects an option or its value.
    #[error(
        "PETSc rejects a solver option: {message}; correct it in the solver options of the case or on the command line after `--`"
    )]
    BadOption {
        /// PETSc's own words.
        message: String,
    },
    /// A call of PETSc failed.
    #[error("PETSc's {call} failed with error {code}: {message}")]
    Call {
        /// The function.
        call: &'static str,
        /// PETSc's error code.
        code: i32,
        /// PETSc's own words.
        message: String,
    },
    /// Numbers of cells or ranks that do not make a grid.
    #[error("grid of the pressure equation: {0}")]
    Grid(String),
    /// An array of the wrong length.
    #[error("{what} has {found} entries, {expected} are needed (x fastest, owned cells or their faces)")]
    Length {
        /// Which array.
        what: &'static str,
        /// Entries needed.
        expected: usize,
        /// Entries given.
        found: usize,
    },
    /// A coefficient that is negative, infinite or not a number, on this or another rank.
    #[error("the coefficient of the pressure equation must be finite and not negative: {0}")]
    Coefficient(String),
    /// A solve before any coefficients were set.
    #[error("the pressure equation has no coefficients yet: call set_coefficients before the first solve")]
    NoCoefficients,
    /// The right-hand side or the first guess holds NaN or infinity.
    #[error(
        "the {0} of the pressure equation holds NaN or infinity: the fields before the solve are broken already, most often by too large a time step"
    )]
    NotFinite(&'static str),
    /// The tolerance was not met within the allowed iterations.
    #[error(
        "the pressure solve stopped at its limit of {iterations} iterations with a relative residual of {residual:.2e}, {tolerance:.1e} was asked for: allow more iterations, loosen the tolerance, or choose a stronger preconditioner (multigrid)"
    )]
    IterationLimit {
        /// Iterations done.
        iterations: usize,
        /// Norm of the residual over that of the right-hand side.
        residual: f64,
        /// The tolerance.
        tolerance: f64,
    },
    /// The iteration broke down.
    #[error(
        "the pressure solve failed after {iterations} iterations: {reason} (relative residual {residual:.2e})"
    )]
    Diverged {
        /// PETSc's reason and what helps.
        reason: &'static str,
        /// Iterations done.
        iterations: usize,
        /// Norm of the residual over that of the right-hand side.
        residual: f64,
    },
}
