//! Convex parts of particles where they are now, and how they meet.

mod contact;
mod placed_part;

pub(crate) use contact::{Meeting, PartContact, gap_across_plane, meet_parts, spread, touch};
pub(crate) use placed_part::{PlacedPart, Pose};
