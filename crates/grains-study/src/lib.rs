//! Parameter studies: a case with lists of values or a Latin hypercube over ranges, run side by side, gathered in one table and picture, and
//! quantities of the case fitted to what was measured.
//!
//! ```text
//! study.toml ── study_file, study_check ──▶ Study
//!   design     which combinations               address, member   their cases, checked before anything runs
//!   folder     what has become of each          launch, sweep     processes side by side
//!   measure    numbers from their files         table, picture    what came of all
//!   surface, estimate, fit                      values that meet measured numbers, with their uncertainty
//! ```
//!
//! The program is started as a process for each run, so this crate knows neither MPI nor HDF5.

mod address;
mod case_check;
mod csv_table;
mod design;
mod error;
mod estimate;
mod fit;
mod fit_report;
mod folder;
mod launch;
mod measure;
mod member;
mod panel;
mod picture;
mod plan;
mod random;
mod slurm;
mod study_check;
mod study_file;
mod surface;
mod sweep;
mod table;

pub use error::StudyError;
pub use launch::Launch;
pub use plan::{Options, Task, carry_out};
pub use slurm::{JobArray, write_scripts};
pub use study_file::Study;
pub use sweep::Say;

/// JSON schema of study files, for editors.
pub fn schema() -> serde_json::Value {
    grains_case::schema_of::<Study>()
}
