//! PETSc, running.

use crate::ffi::{self, Session};
use crate::options::suggestion;
use crate::{Options, PetscError};
use mpi::traits::Communicator;
use std::rc::Rc;

/// Ends of names that PETSc looks up only during a solve or at its end.
const LATE: [&str; 6] =
    ["ksp_converged_reason", "options_left", "options_view", "malloc_dump", "malloc_view", "objects_dump"];

/// PETSc between initialisation and finalisation.
///
/// It is finalised when this and everything made with it is dropped, which must be before MPI ends.
pub struct Petsc {
    pub(crate) session: Rc<Session>,
}

impl Petsc {
    /// Starts PETSc on the ranks of a communicator, of which it keeps a duplicate. Collective.
    ///
    /// Errors if it runs already, or rejects an option.
    pub fn start<C: Communicator>(communicator: &C, options: &Options) -> Result<Self, PetscError> {
        Ok(Self { session: Session::start(communicator, options)? })
    }

    /// Refuses options of the case or the command line that nothing has asked for.
    ///
    /// To be called once the solvers are set up ([`crate::LinearSolver::set_up`]). Options in
    /// `$PETSC_OPTIONS` and `.petscrc` are not looked at: they may be meant for other programs.
    pub fn check_options(&self) -> Result<(), PetscError> {
        let mut names = self.session.unused_options()?;
        names.retain(|name| !LATE.iter().any(|end| name.ends_with(end)));
        if names.is_empty() {
            return Ok(());
        }
        let hint = if names.len() == 1 { suggestion(&names[0]) } else { String::new() };
        Err(PetscError::UnusedOptions { names, hint })
    }

    /// Release of the library, such as 3.18.5.
    pub fn version() -> String {
        ffi::version()
    }
}
