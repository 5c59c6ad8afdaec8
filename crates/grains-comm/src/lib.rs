//! [`Transport`](grains_domain::Transport) over MPI, and how a job begins, ends and is aborted.

mod count;
mod graph;
mod node_memory;
mod nodes;
mod persistent;
mod reductions;
mod sparse;
mod transport;

pub use node_memory::share_on_node;
pub use nodes::{are_nodes_given, cartesian, ranks_of_node};
pub use transport::MpiTransport;

use mpi::environment::Universe;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, FromRaw, Root};
use std::mem::ManuallyDrop;

/// Exit code of a job in which some rank panicked: a bug.
const PANIC: i32 = 101;
/// Bytes that are broadcast at once: MPI counts them in 31 bits.
const MAX_BROADCAST: usize = 1 << 30;

/// The MPI job: initialised once per process and finalised when dropped, or one that others have initialised.
pub struct Job {
    /// Among all ranks; freed before MPI ends.
    transport: MpiTransport,
    world: SimpleCommunicator,
    /// Ends MPI when dropped, if this job has begun it.
    _universe: Option<Universe>,
}

impl Job {
    /// Starts MPI; a panic on any rank from here on ends all ranks instead of hanging them.
    ///
    /// Panics for which `is_caught` answers true become errors where they are caught, and end nothing.
    /// A program started without mpirun is a job of one rank. Errors if MPI was already initialised.
    pub fn start(is_caught: fn() -> bool) -> Result<Self, String> {
        let universe = mpi::initialize().ok_or("MPI is already initialised in this process")?;
        let world = universe.world();
        Ok(Self::among(world, Some(universe), is_caught))
    }

    /// The job of a communicator of MPI that others have initialised and will finalise; as for [`Job::start`].
    ///
    /// # Safety
    /// `communicator` is the address of an `MPI_Comm` that is valid while the job is.
    #[allow(unsafe_code)]
    pub unsafe fn join(communicator: usize, is_caught: fn() -> bool) -> Self {
        // SAFETY: as the caller says.
        let world = unsafe {
            let handle = *(communicator as *const mpi::ffi::MPI_Comm);
            match handle == mpi::ffi::RSMPI_COMM_WORLD {
                true => SimpleCommunicator::world(),
                // Whoever has made it frees it.
                false => ManuallyDrop::new(SimpleCommunicator::from_raw(handle)).duplicate(),
            }
        };
        Self::among(world, None, is_caught)
    }

    fn among(world: SimpleCommunicator, universe: Option<Universe>, is_caught: fn() -> bool) -> Self {
        let report = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if is_caught() {
                return;
            }
            report(info);
            abort(PANIC);
        }));
        Self { transport: MpiTransport::new(world.duplicate()), world, _universe: universe }
    }

    /// Messages among all ranks.
    pub fn transport(&self) -> &MpiTransport {
        &self.transport
    }

    /// Messages among all ranks that no others can be taken for; collective.
    pub fn new_transport(&self) -> MpiTransport {
        MpiTransport::new(self.world.duplicate())
    }

    /// All ranks.
    pub fn world(&self) -> &SimpleCommunicator {
        &self.world
    }

    /// Number of ranks.
    pub fn size(&self) -> usize {
        self.world().size() as usize
    }

    /// The text of rank 0 on every rank (an error text likewise).
    pub fn broadcast(&self, text: Result<String, String>) -> Result<String, String> {
        let is_ok = text.is_ok();
        let (Ok(text) | Err(text)) = text;
        let mut bytes = text.into_bytes();
        bytes.push(u8::from(is_ok));
        let mut bytes = self.broadcast_bytes(bytes);
        let is_ok = bytes.pop() == Some(1);
        let text = String::from_utf8_lossy(&bytes).into_owned();
        if is_ok { Ok(text) } else { Err(text) }
    }

    /// The bytes of rank 0 on every rank; collective.
    pub fn broadcast_bytes(&self, mut bytes: Vec<u8>) -> Vec<u8> {
        let root = self.world().process_at_rank(0);
        let mut length = bytes.len() as u64;
        root.broadcast_into(&mut length);
        bytes.resize(length as usize, 0);
        bytes.chunks_mut(MAX_BROADCAST).for_each(|part| root.broadcast_into(part));
        bytes
    }
}

/// Ends all ranks of the job with an exit code.
pub fn abort(code: i32) -> ! {
    // SAFETY: MPI_Abort may be called at any time between initialisation and finalisation.
    #[allow(unsafe_code)]
    unsafe {
        mpi::ffi::MPI_Abort(mpi::ffi::RSMPI_COMM_WORLD, code);
    }
    std::process::exit(code)
}
