//! Messages between subdomains: migration of particles, creation of clones, and their updates.
//!
//! When lists are rebuilt, particles that crossed a border *migrate* with their contact history; right after,
//! clones are *created* of every particle so near a border that it may act across it, with the neighbours of its
//! GEOLOC. In every step between, [`updates`] brings them up to date. After each round of hard
//! collisions, changes are *forwarded* to clones. There is one message per neighbour.

mod all_gather;
mod clones;
mod link;
mod messages;
mod migration;
mod notice;
mod updates;

pub(crate) use clones::{Forwarded, KeptClones};
pub(crate) use messages::Exchange;
pub(crate) use notice::Notice;
pub use updates::{ExchangeStrategy, Traffic};
