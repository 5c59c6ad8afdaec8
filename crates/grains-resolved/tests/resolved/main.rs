//! Resolved bodies: fixed, free and of prescribed motion, and the points on their surfaces.

#![allow(clippy::unwrap_used)]

mod common;
mod contacts;
mod fixed;
mod free;
mod points;
mod prescribed;
mod rheology;
mod scalars;
mod walls;
