//! Which ranks share a node.

use grains_domain::Bricks;
use mpi::collective::SystemOperation;
use mpi::topology::{Color, SimpleCommunicator};
use mpi::traits::{Communicator, CommunicatorCollectives, Root};

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
