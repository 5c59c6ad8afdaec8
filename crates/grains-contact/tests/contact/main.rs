//! Laws against theory: bridges against the Young-Laplace equation, bonds against beams.

mod bond;
mod chain;
mod liquid_bridge;
mod van_der_waals;
mod young_laplace;
