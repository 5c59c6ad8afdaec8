//! Drag laws, kernels, shape factors and the exchange of momentum.

#![allow(clippy::unwrap_used)]

mod drag;
mod exchange;
mod kernels;
mod shapes;
mod speed;
