//! What all contacts share, and the contacts between spheres.

mod lanes;
mod load_quanta;
mod pass_statistics;
mod spheres;

pub(crate) use lanes::{BLOCK, Columns, set, vector_at, whole_lanes};
pub(crate) use load_quanta::LoadLattice;
pub(crate) use pass_statistics::Tally;
pub(crate) use spheres::{SpherePair, add_forces as add_sphere_forces};
