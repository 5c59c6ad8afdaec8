//! Bonds between particles: what they are, when they are made, and what they do.
//!
//! A bond joins the centres of two particles from the step in which it is made until it breaks or one of them leaves. Meanwhile the
//! pair has no other contact. In the step after it broke the lists are rebuilt, and the pair meets like any other.
//!
//! Both ranks of a pair hold the bond, as seen from the particle of lower id, so it has the same bits on both.

mod forces;
mod forming;
mod kind;
mod list;

pub(crate) use forces::{BondPass, add_forces};
pub(crate) use forming::{Forming, Made, are_bonded};
pub use kind::{BondKind, BondRadius, Bonded};
pub(crate) use list::{BondList, ListedBond};

/// Ends of bonds on one rank, those of its particles, since the case began; a bond has two.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BondLedger {
    /// Those made.
    pub made: u64,
    /// Those broken by stress.
    pub broken: u64,
    /// Those of pairs of which a particle left the box.
    pub left: u64,
}
