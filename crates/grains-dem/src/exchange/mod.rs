//! What subdomains tell each other: who moves, who is cloned, and what clones must know.
//!
//! When lists are rebuilt, particles that crossed a border *migrate* with their contact history; right after,
//! clones are *created* of every particle so near a border that it may act across it, with the neighbours of its
//! GEOLOC. In every step between, [`updates`] brings them up to date. Hard collisions *forward* to clones what each of
//! their rounds changed. All that goes to one neighbour is one message.

mod all_gather;
mod clones;
#[allow(clippy::module_inception)]
mod exchange;
mod link;
mod migration;
mod updates;

pub(crate) use exchange::Exchange;
pub use updates::{ExchangeStrategy, Traffic};
