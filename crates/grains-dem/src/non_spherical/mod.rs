//! Contacts between particles that are not both spheres.

mod batch;
mod contacts;
mod forces;
mod found;
mod histories;
mod list;
mod pairs;
mod point_contact;
mod window;

pub(crate) use contacts::meet;
pub(crate) use forces::add_forces;
pub(crate) use list::PartPairList;
pub(crate) use pairs::PartPair;
