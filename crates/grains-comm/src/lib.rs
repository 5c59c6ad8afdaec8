//! [`Transport`](grains_domain::Transport) over MPI, and how a job begins, ends and is aborted.

mod count;
mod graph;
mod persistent;
mod reductions;
mod sparse;
mod transport;

pub use transport::MpiTransport;

use grains_domain::Bricks;
use mpi::collective::SystemOperation;
use mpi::environment::Universe;
use mpi::topology::{Color, SimpleCommunicator};
use mpi::traits::{Communicator, CommunicatorCollectives, FromRaw, Root};
use std::mem::ManuallyDrop;

/// Exit code of a job in which some rank panicked: a bug.
const PANIC: i32 = 101;

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

/// Bytes that are broadcast at once: MPI counts them in 31 bits.
const MAX_BROADCAST: usize = 1 << 30;

/// Ends all ranks of the job with an exit code.
pub fn abort(code: i32) -> ! {
    // SAFETY: MPI_Abort may be called at any time between initialisation and finalisation.
    #[allow(unsafe_code)]
    unsafe {
        mpi::ffi::MPI_Abort(mpi::ffi::RSMPI_COMM_WORLD, code);
    }
    std::process::exit(code)
}

/// Variable of the environment: ranks per node, as if each node had that many. To try what many nodes would do on one.
const RANKS_PER_NODE: &str = "GRAINS_RANKS_PER_NODE";

/// The ranks of `world` numbered as the decomposition does, x fastest, so that those of a node lie together as a brick in the grid of
/// ranks, whose subdomains are `widths` (m) wide. Where bricks do not fill the grid they are numbered as in `world`. Rank 0 stays; collective.
///
/// `ranks` must multiply to the size of `world`.
pub fn cartesian(world: &SimpleCommunicator, ranks: [usize; 3], widths: [f64; 3]) -> SimpleCommunicator {
    let own = world.rank() as usize;
    let (node, rank_of_node, per_node) = place_on_nodes(world);
    let bricks = per_node.and_then(|per_node| Bricks::of(ranks, widths, per_node));
    let number = bricks.map_or(own, |bricks| bricks.rank(node, rank_of_node));
    world.split_by_color_with_key(Color::with_value(0), number as i32).unwrap_or_else(|| world.duplicate())
}

/// Ranks per node as the environment gives them.
fn given_per_node() -> Option<i32> {
    std::env::var(RANKS_PER_NODE).ok()?.parse().ok().filter(|per_node| *per_node > 0)
}

/// Whether the environment gives the ranks per node.
pub fn are_nodes_given() -> bool {
    given_per_node().is_some()
}

/// The ranks that share a node with this one, in the order of `communicator`; collective.
pub fn ranks_of_node(communicator: &SimpleCommunicator) -> SimpleCommunicator {
    let of_given = |per_node| {
        let node = SimpleCommunicator::world().rank() / per_node;
        communicator.split_by_color(Color::with_value(node))
    };
    given_per_node().and_then(of_given).unwrap_or_else(|| communicator.split_shared(communicator.rank()))
}

/// Number of the own node, by its first rank, number of the own rank on it, and how many ranks there are on each node, if on all as many;
/// collective.
fn place_on_nodes(world: &SimpleCommunicator) -> (usize, usize, Option<usize>) {
    let size = world.size() as usize;
    let shared = ranks_of_node(world);
    let (rank_of_node, per_node) = (shared.rank() as usize, shared.size() as usize);
    let mut firsts = vec![0_i32; size];
    let mut first = [world.rank()];
    shared.process_at_rank(0).broadcast_into(&mut first[..]);
    world.all_gather_into(&first[0], &mut firsts[..]);
    firsts.sort_unstable();
    firsts.dedup();
    let node = firsts.partition_point(|&other| other < first[0]);
    let mut largest = [0_i32, 0];
    let of_own = per_node as i32;
    world.all_reduce_into(&[of_own, -of_own][..], &mut largest[..], SystemOperation::max());
    (node, rank_of_node, (largest[0] == -largest[1]).then_some(per_node))
}
