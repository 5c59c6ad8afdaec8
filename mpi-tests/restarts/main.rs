//! Restarts: nothing is lost or doubled wherever a run is stopped.

#![allow(clippy::unwrap_used)]
mod changes;
#[path = "../common/mod.rs"]
mod common;
mod mistakes;
mod stops;
