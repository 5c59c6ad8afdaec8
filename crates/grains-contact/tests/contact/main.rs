//! Laws against theory: bridges of liquid against the Young-Laplace equation.

mod liquid_bridge;
mod van_der_waals;
mod young_laplace;
