//! Tests of the granular phase against closed forms, and of its invariances.

#![allow(clippy::unwrap_used)]

mod apart_from_walls;
mod bonds;
mod bounce;
mod cargo;
mod common;
mod contact_patches;
mod facets;
mod failures;
mod films;
mod hard;
mod heat;
mod impact;
mod laws;
mod loaded_walls;
mod lubrication;
mod oblique;
mod open_tubes;
mod part_seams;
mod prescribed;
mod rebuilds;
mod room;
mod same_bits;
mod sheared;
mod size_classes;
mod size_ratio;
mod two_bodies;
mod walls;
mod wear;
