//! Bodies that do not deform: collisions are impulses, time-stepped (Srinivasan 2019, ch. 3.1 and app. A).
//!
//! ```text
//! add_forces  find the contacts at the present positions; give each an impulse, in a fixed order
//! advance     move the bodies out of each other, kick by gravity, drift
//! ```
//!
//! # Order
//!
//! Each contact sees the velocities that the earlier ones left, so their order is part of the result. It is that
//! of a [`key::Key`], a hash of the identities of the two bodies: the same on any ranks, and mixed, so that a chain of
//! contacts that wait for each other is short. Contacts are worked off in rounds. In a round a contact is due when
//! its key is the lowest pending one of both its bodies; then no two of them share a body. Between rounds the
//! clones learn velocities, relocations and lowest keys from their owners, and a contact of an owned particle
//! with a clone is worked out alike on both ranks.
//!
//! # Relocation
//!
//! Overlapping bodies are moved apart along the normal (errata S19-7) by the overlap that the earlier contacts of
//! the step left, so that a body on four legs is not lifted four times. Two free bodies share it by inverse mass,
//! which keeps their centre of mass (half each for equal masses, as in the source); at a wall the particle takes
//! all of it.
//!
//! # Rest
//!
//! A body at rest falls by g dt in every step. Below [`HardModel::rest_speed`] restitution is taken as 0, so that
//! beds come to rest in a bounded number of collisions where events would pile up without end. Each sweep
//! carries the weight of a bed on by a few layers only; what is not yet borne sinks, and relocation lifts it
//! again: a bed at rest keeps a residual speed of some 10 g dt.

mod contacts;
mod key;
mod response;
mod rounds;

pub(crate) use response::Site;
pub(crate) use rounds::Collisions;

use crate::Rates;
use grains_contact::ImpulseScheme;

/// What happens when bodies meet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum CollisionModel {
    /// They overlap, and the overlap makes a force.
    #[default]
    Soft,
    /// They do not deform: an instant impulse.
    Hard(HardModel),
    /// They never do: all are held where they are, and no neighbours are looked for.
    Held,
}

/// Parameters of collisions by impulses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HardModel {
    /// How friction and restitution are brought together.
    pub scheme: ImpulseScheme,
    /// How often all contacts of a step are worked off (-); 1 in the source. More carry the weight of a deep
    /// bed farther in one step.
    pub sweeps: u32,
    /// Approach speed (m/s) below which restitution is taken as 0.
    pub rest_speed: f64,
}

impl HardModel {
    /// Exact restitution, one sweep, and rest below 2 |g| dt: nothing rests without gravity.
    pub fn new(rates: &Rates) -> Self {
        let rest_speed = 2.0 * rates.gravity.norm() * rates.dt;
        Self { scheme: ImpulseScheme::Exact, sweeps: 1, rest_speed }
    }
}
