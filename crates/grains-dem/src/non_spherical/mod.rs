//! Contacts between particles that are not both spheres.

mod batch;
mod forces;
mod found;
mod list;
mod pairs;
mod point_contact;

pub(crate) use forces::{add_forces, meet, smaller_radius};
pub(crate) use list::BodyList;
pub(crate) use pairs::BodyPair;
