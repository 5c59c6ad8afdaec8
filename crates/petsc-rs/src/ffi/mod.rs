//! All unsafe code of the crate: owners of PETSc's objects with safe methods.
//!
//! Each owner keeps the [`Session`] alive, so that PETSc is finalised after its last object. Once a call
//! has failed, or MPI has ended, objects are left alone instead of being destroyed: destroying is collective
//! and would hang if only one rank had failed.

#![allow(unsafe_code)]

#[allow(
    missing_docs,
    non_upper_case_globals,
    non_camel_case_types,
    non_snake_case,
    dead_code,
    unused_imports,
    clippy::all
)]
mod bindings {
    include!(concat!(env!("OUT_DIR"), "/petsc.rs"));
}

mod distributed;
mod krylov;
mod matrix;
mod session;
mod vector;

pub(crate) use distributed::DistributedArray;
pub use krylov::Function;
pub(crate) use krylov::{Krylov, Outcome, Stop};
pub(crate) use matrix::{Matrix, Rows};
pub(crate) use session::{Session, version};
pub(crate) use vector::Vector;
