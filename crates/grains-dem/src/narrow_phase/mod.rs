//! Convex parts of particles where they are now, and how they meet.

mod contact;
mod placed_part;

pub(crate) use contact::{
    Meeting, PartContact, across_gap, contact_patch, gap_across_plane, meet_parts, overlaps,
    patch_on_triangle, touch, widest_gap,
};
pub(crate) use placed_part::{PlacedPart, Pose, SweptFrame};
