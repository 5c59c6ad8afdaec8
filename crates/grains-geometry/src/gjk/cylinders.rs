//! Two cylinders: which of their features touch, and where those are nearest each other.

mod guess;
mod lanes;
mod marks;
mod touching;

pub(super) use guess::Guess;
pub use lanes::CylinderQueries;
pub use marks::CylinderMarks;
pub(super) use marks::{WORDS, read, write};
pub(super) use touching::Touching;
