//! Solids that scalars meet: bodies and walls among the cells.

mod barrier;
mod build;
mod cells;
mod jump;
mod moved;
mod step;

pub use build::{SolidCellsBuilder, SurfacePoint};
pub use cells::{BEYOND, CutFace, NearCell, NearFace, SolidCells, share_in_front};

pub(super) use barrier::{Barrier, FIXED, Tie};
pub(super) use step::Linear;
