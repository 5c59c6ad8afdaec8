//! Drag laws, kernels, shape factors and the exchange of momentum.

#![allow(clippy::unwrap_used)]

mod drag;
mod drag_law_of_the_manual;
mod exchange;
mod kernels;
mod shapes;
mod speed;
