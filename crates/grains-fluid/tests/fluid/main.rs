//! The flow on one rank and on several, against exact solutions.

#![allow(clippy::unwrap_used)]

mod common;
mod flows;
mod halo;
mod mixture;
mod openings;
mod outlines;
mod patches;
mod poisson;
mod poisson_boxes;
mod pressure_inlets;
mod random_walls;
mod ranks;
mod scalars;
mod viscosity;
