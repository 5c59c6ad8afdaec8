//! The global box, its Cartesian decomposition over ranks, the cells of one subdomain, and the
//! routing of particles to the 26 neighbours (Rakotonirina 2016, ch. 5, section 3).
//!
//! **Exact positions.** Every coordinate is a multiple of a power of two, the [`Quantum`] of the box, about
//! the resolution of f64 at the far end of the box. Adding a period and subtracting two coordinates are
//! then exact, so a pair has bit for bit the same separation on both sides of a border and in every
//! periodic image. The same rounding applied to forces makes their sums exact and so independent of
//! their order: this is what makes a state the same on any number of ranks.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod balance;
mod cells;
mod decomposition;
mod direction;
mod exact_sum;
mod global_box;
mod placement;
mod prefetch;
mod quantum;
mod transport;
mod wide_sums;

pub use balance::{Balance, OtherWork, WorkProfile};
pub use cells::{CellGrid, Cells, SIZE_CLASSES, size_class};
pub use decomposition::{Decomposition, DecompositionError, choose_ranks};
pub use direction::Direction;
pub use exact_sum::{ExactSum, sum_exact};
pub use global_box::GlobalBox;
pub use placement::Bricks;
pub use prefetch::prefetch;
pub use quantum::Quantum;
pub use transport::{Channel, ChannelParts, SerialTransport, Transport};
pub use wide_sums::{sum_wide, sum_wide_before};
