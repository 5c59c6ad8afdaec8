//! Laws against theory: bridges of liquid against the Young-Laplace equation.

mod liquid_bridge;
mod young_laplace;
