//! Cases, particles and meshes from inputs of LAMMPS and LIGGGHTS.
//!
//! ```text
//! script ── lines, variables ──▶ Script ── commands ──▶ Scene ── assemble ──▶ case.toml, particles.csv, meshes/
//! data, dump ───────────────────▶ particles ───────────┘                      import.txt: what became of each command
//! ```
//!
//! Formulas are those of LAMMPS (2021-09-29 to 2025) and of LIGGGHTS-PUBLIC 3.8, as their sources have them.

mod assemble;
mod case_text;
mod data_file;
mod dump_file;
mod error;
mod fixes;
mod import;
mod insertion;
mod lammps_law;
mod laws;
mod liggghts_law;
mod lines;
mod meshes;
mod particles;
mod regions;
mod report;
mod scene;
mod script;
mod setup;
mod units;
mod variables;
mod vtk;
mod walls;

pub use error::ImportError;
pub use import::{Imported, Options, import};
pub use report::{Outcome, Report, Source};
