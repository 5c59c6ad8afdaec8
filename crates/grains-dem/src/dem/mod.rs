//! The granular phase of one rank and its step.

mod agreement;
mod heat;
mod liquid;
mod loaded_walls;
mod loads;
mod observe;
mod rebuild;
mod rebuild_times;
mod report;
mod setup;
mod sheared;
mod species;
mod state;
mod step;
mod wear;

pub use observe::{Partner, Touch};
pub use report::{Failure, Ledger, Origin, Passages, StepReport};
pub use setup::DemSetup;
pub use species::{Species, SpeciesContent, SpeciesLedger};
pub use state::Dem;
