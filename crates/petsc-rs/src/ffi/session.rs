//! PETSc between initialisation and finalisation, its options and its error messages.

use super::bindings as c;
use crate::{Options, PetscError};
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{AsRaw, Communicator, CommunicatorCollectives};
use std::cell::Cell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::mem::ManuallyDrop;
use std::ptr::{null, null_mut};
use std::rc::Rc;
use std::sync::Mutex;

/// PETSc's code for a name of a solver or preconditioner it does not know.
const UNKNOWN_TYPE: i32 = 86;
/// PETSc's codes for values out of range and of the wrong form.
const BAD_VALUES: [i32; 2] = [62, 63];

/// What PETSc said when an error arose, before it travelled up the calls.
static MESSAGE: Mutex<String> = Mutex::new(String::new());

/// PETSc running on a communicator of its own.
pub(crate) struct Session {
    communicator: ManuallyDrop<SimpleCommunicator>,
    has_failed: Cell<bool>,
    names: Vec<String>,
}

/// Keeps the message of an error where it arises; replaces PETSc's printed trace.
unsafe extern "C" fn remember(
    _communicator: c::MPI_Comm,
    _line: c_int,
    function: *const c_char,
    _file: *const c_char,
    code: c::PetscErrorCode,
    kind: c::PetscErrorType::Type,
    message: *const c_char,
    _context: *mut c_void,
) -> c::PetscErrorCode {
    if kind == c::PetscErrorType::PETSC_ERROR_INITIAL {
        let text = |pointer: *const c_char| {
            if pointer.is_null() {
                return String::new();
            }
            // SAFETY: PETSc hands over texts that end with a zero and outlive this call.
            unsafe { CStr::from_ptr(pointer) }.to_string_lossy().trim().to_string()
        };
        if let Ok(mut kept) = MESSAGE.lock() {
            *kept = match (text(message), text(function)) {
                (message, function) if message.is_empty() => format!("in {function}"),
                (message, function) => format!("{} (in {function})", message.replace('\n', "; ")),
            };
        }
    }
    code
}

impl Session {
    /// Starts PETSc on a duplicate of the communicator.
    pub fn start<C: Communicator>(communicator: &C, options: &Options) -> Result<Rc<Self>, PetscError> {
        let mut is_running = c::PetscBool::PETSC_FALSE;
        // SAFETY: may be called at any time; writes one flag.
        unsafe { c::PetscInitialized(&mut is_running) };
        if is_running == c::PetscBool::PETSC_TRUE {
            return Err(PetscError::AlreadyStarted);
        }
        for (name, value) in &options.case {
            let (name, value) = (c_text(name)?, value.as_deref().map(c_text).transpose()?);
            // SAFETY: PETSc copies both texts; this call is allowed before the initialisation, whose
            // other sources of options then win.
            let code = unsafe {
                c::PetscOptionsSetValue(
                    null_mut(),
                    name.as_ptr(),
                    value.as_ref().map_or(null(), |v| v.as_ptr()),
                )
            };
            plain_check("PetscOptionsSetValue", code)?;
        }
        let communicator = ManuallyDrop::new(communicator.duplicate());
        let (mut count, mut words) = leaked_arguments(&options.command_line)?;
        // SAFETY: MPI runs, as a communicator exists; PETSc keeps the arguments, which are never freed. Its
        // signal handler would print over the messages of the program.
        unsafe {
            c::PETSC_COMM_WORLD = communicator.as_raw();
            plain_check("PetscInitialize", c::PetscInitialize(&mut count, &mut words, null(), null()))?;
            plain_check("PetscPopSignalHandler", c::PetscPopSignalHandler())?;
            plain_check("PetscPushErrorHandler", c::PetscPushErrorHandler(Some(remember), null_mut()))?;
        }
        let names = options.names().map(String::from).collect();
        Ok(Rc::new(Self { communicator, has_failed: Cell::new(false), names }))
    }

    /// The communicator of all objects.
    pub fn communicator(&self) -> &SimpleCommunicator {
        &self.communicator
    }

    /// The same for PETSc.
    pub(super) fn raw(&self) -> c::MPI_Comm {
        self.communicator.as_raw()
    }

    /// Whether there is one rank only.
    pub fn is_serial(&self) -> bool {
        self.communicator.size() == 1
    }

    /// The largest of each of the values on any rank.
    pub fn max<const N: usize>(&self, values: [f64; N]) -> [f64; N] {
        let mut largest = values;
        self.communicator.all_reduce_into(&values[..], &mut largest[..], SystemOperation::max());
        largest
    }

    /// The sums of values over all ranks.
    pub fn sum<const N: usize>(&self, values: [f64; N]) -> [f64; N] {
        let mut sums = values;
        self.communicator.all_reduce_into(&values[..], &mut sums[..], SystemOperation::sum());
        sums
    }

    /// Turns the code of a call into an error with PETSc's words; afterwards nothing is destroyed any more.
    pub(super) fn check(&self, call: &'static str, code: c::PetscErrorCode) -> Result<(), PetscError> {
        plain_check(call, code).inspect_err(|_| self.has_failed.set(true))
    }

    /// Whether objects may still be destroyed.
    pub(super) fn is_usable(&self) -> bool {
        !self.has_failed.get() && !is_mpi_over()
    }

    /// Value of a whole-number option such as `-pc_mg_levels`, if it was given.
    pub fn integer_option(&self, prefix: &str, name: &str) -> Result<Option<usize>, PetscError> {
        let (prefix, name) = (c_text(prefix)?, c_text(name)?);
        let (mut value, mut is_set) = (0, c::PetscBool::PETSC_FALSE);
        // SAFETY: two texts that outlive the call; PETSc writes a number and a flag.
        let code = unsafe {
            c::PetscOptionsGetInt(null_mut(), prefix.as_ptr(), name.as_ptr(), &mut value, &mut is_set)
        };
        self.check("PetscOptionsGetInt", code)?;
        Ok((is_set == c::PetscBool::PETSC_TRUE).then_some(value.max(0) as usize))
    }

    /// Those of the given options that nothing has asked for so far.
    pub fn unused_options(&self) -> Result<Vec<String>, PetscError> {
        let mut unused = Vec::new();
        for name in &self.names {
            // PETSc keeps names without their dash, and looks for them so here.
            let bare = name.strip_prefix('-').unwrap_or(name);
            let (text, mut is_used) = (c_text(bare)?, c::PetscBool::PETSC_FALSE);
            // SAFETY: a text that outlives the call; PETSc writes a flag.
            let code = unsafe { c::PetscOptionsUsed(null_mut(), text.as_ptr(), &mut is_used) };
            self.check("PetscOptionsUsed", code)?;
            if is_used != c::PetscBool::PETSC_TRUE && !unused.contains(name) {
                unused.push(name.clone());
            }
        }
        Ok(unused)
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        if self.is_usable() {
            // SAFETY: the last object is gone, as each keeps the session; MPI still runs. The communicator
            // is freed once, after PETSc has let go of it.
            unsafe {
                c::PetscFinalize();
                ManuallyDrop::drop(&mut self.communicator);
            }
        }
    }
}

/// Release of PETSc, such as 3.18.5.
pub(crate) fn version() -> String {
    let [mut major, mut minor, mut patch, mut release] = [0; 4];
    // SAFETY: writes four numbers.
    unsafe { c::PetscGetVersionNumber(&mut major, &mut minor, &mut patch, &mut release) };
    format!("{major}.{minor}.{patch}")
}

pub(super) fn c_text(text: &str) -> Result<CString, PetscError> {
    CString::new(text).map_err(|_| PetscError::OptionSyntax {
        text: text.replace('\0', "\\0"),
        reason: "it holds a zero byte".into(),
    })
}

/// Arguments as C has them; PETSc refers to them until the process ends.
fn leaked_arguments(words: &[String]) -> Result<(c_int, *mut *mut c_char), PetscError> {
    let mut list = vec![c_text("petsc")?.into_raw()];
    for word in words {
        list.push(c_text(word)?.into_raw());
    }
    let count = list.len() as c_int;
    list.push(null_mut());
    Ok((count, list.leak().as_mut_ptr()))
}

fn is_mpi_over() -> bool {
    let mut is_over = 0;
    // SAFETY: may be called at any time; writes one flag.
    unsafe { mpi_sys::MPI_Finalized(&mut is_over) };
    is_over != 0
}

fn plain_check(call: &'static str, code: c::PetscErrorCode) -> Result<(), PetscError> {
    if code == 0 {
        return Ok(());
    }
    let kept = MESSAGE.lock().map(|mut kept| std::mem::take(&mut *kept)).unwrap_or_default();
    let message = if kept.is_empty() { general_message(code) } else { kept };
    if code == UNKNOWN_TYPE || BAD_VALUES.contains(&code) {
        return Err(PetscError::BadOption { message });
    }
    Err(PetscError::Call { call, code, message })
}

/// PETSc's words for an error code.
fn general_message(code: c::PetscErrorCode) -> String {
    let mut text = null();
    // SAFETY: PETSc points `text` to a constant of its own, or to nothing.
    unsafe {
        c::PetscErrorMessage(code, &mut text, null_mut());
        if text.is_null() {
            return "no message".into();
        }
        CStr::from_ptr(text).to_string_lossy().trim().to_string()
    }
}
