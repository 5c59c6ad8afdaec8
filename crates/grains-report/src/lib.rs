//! A run as one page: `report.html`, made from the files of its directory.
//!
//! ```text
//! run.json, status.json, case.resolved.toml   what was run, what `check` said, what came of it
//! series.csv, profile-*.csv                   curves
//! particles.vtkhdf, walls.vtkhdf, shapes/     the player: chosen states, quantised
//! fluid.vtkhdf                                its slices, of fewer cells if there are many
//! analysis*/                                  pictures
//!        → a description (JSON) and one block of numbers (deflated, base64) → report.html
//! ```
//!
//! The page asks for nothing from elsewhere: scripts and styles are in it. What is left out to keep it small is said in it.
//! Nothing here needs MPI; HDF5 reads the files of a run that still goes on up to their last complete step.

mod block;
mod channel;
mod curves;
mod error;
mod fields;
mod files;
mod fluid;
mod frames;
mod page;
mod particles;
mod pictures;
mod scene;
mod shapes;
mod walls;
mod watch;

pub use error::ReportError;
pub use files::{Case, REPORT, RUN, STATUS};
pub use watch::{Stop, watch};

use page::Kind;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// A description and its block of numbers, as the page reads them.
struct Contents {
    description: Value,
    block: String,
    /// Whether states or particles were left out.
    is_thinned: bool,
}

/// Writes `report.html` into a directory of results, under another name first, and returns its path.
///
/// # Errors
/// A directory of no run, or one that cannot be written to. Files that cannot be read are named in the page instead.
pub fn write(directory: &Path) -> Result<PathBuf, ReportError> {
    let (path, part) = (directory.join(REPORT), directory.join(".report.html"));
    let page = page::text(&contents(directory)?, Kind::File);
    let written = fs::write(&part, page).and_then(|()| fs::rename(&part, &path));
    written.map_err(|error| ReportError::new(&path, format!("cannot be written: {error}")))?;
    Ok(path)
}

/// All that a page shows, as much as fits.
///
/// # Errors
/// A directory of no run.
fn contents(directory: &Path) -> Result<Contents, ReportError> {
    /// Bytes of the particles at first, and at most, as a browser holds them all.
    const PARTICLES: [usize; 2] = [12_000_000, 48_000_000];
    /// Bytes of the block as text.
    const MAX: usize = 8_300_000;
    let contents = files::contents(directory, PARTICLES[0])?;
    // How far numbers deflate is known only then.
    let fitting = |contents: &Contents, budget: usize| budget * (MAX / 100) / (contents.block.len() / 90 + 1);
    let mut budget = fitting(&contents, PARTICLES[0]).min(PARTICLES[1]);
    if contents.block.len() <= MAX && (!contents.is_thinned || budget < PARTICLES[0] * 3 / 2) {
        return Ok(contents);
    }
    loop {
        let contents = files::contents(directory, budget)?;
        if contents.block.len() <= MAX || budget < PARTICLES[0] / 20 {
            return Ok(contents);
        }
        budget = fitting(&contents, budget) * 9 / 10;
    }
}
