//! Bodies that do not deform: collisions are impulses, time-stepped (Srinivasan 2019, ch. 3.1 and app. A).
//!
//! ```text
//! add_forces  find the contacts at the present positions; apply an impulse to each, in a fixed order
//! advance     move the bodies out of each other, kick by gravity, drift
//! ```
//!
//! # Order
//!
//! Each contact sees the velocities that the earlier ones left, so their order is part of the result. It is that
//! of a [`key::Key`], a hash of the identities of the two bodies: the same on any ranks, and mixed, so that a chain of
//! contacts that wait for each other is short. A contact is due when its key is the lowest pending one of both its bodies; then no two
//! that are due share a body. Contacts are worked off in rounds ([`rounds`]). Between rounds the clones learn velocities, relocations and
//! lowest keys from their owners, and a contact of an owned particle with a clone is worked out alike on both ranks. All ranks agree
//! once per step, and once per sweep if there are several.
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
mod model;
mod rounds;
mod solver;

pub use model::{CollisionModel, HardModel};
pub(crate) use rounds::Collisions;
pub(crate) use solver::ContactSolver;
