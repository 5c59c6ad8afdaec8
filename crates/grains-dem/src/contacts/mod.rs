//! What all contacts share - loads, batches, exact sums - and the contacts between spheres.

mod batch;
mod lanes;
mod load_quanta;
mod loads;
mod pass;
mod several;
mod spheres;

pub(crate) use batch::{Batch, BatchedContact, ContactColumns};
pub(crate) use lanes::{BLOCK, Columns, set, vector_at};
pub(crate) use load_quanta::LoadQuanta;
pub(crate) use loads::{ContactLoads, ContactPoint};
pub(crate) use pass::{ContactPass, Overlapping, PassStatistics};
pub(crate) use several::{Kept, PairLaw, PatchShare, Screw, SeveralContacts, Wound, either};
pub(crate) use spheres::{SpherePair, add_forces as add_sphere_forces};
