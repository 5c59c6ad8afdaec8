//! A grid over a region whose cells hold several particles each.

use super::region::{Region, mean_diameter};
use super::snapshots::Snapshot;
use grains_domain::Transport;
use grains_geometry::{Shape, Vec3};
use grains_simulation::RunError;

/// Largest number of cells.
const MAX_CELLS: f64 = 1e7;

/// Equal cells that fill a region, x fastest.
#[derive(Clone, Copy, Debug)]
pub struct CoarseGrid {
    lower: Vec3,
    spacing: Vec3,
    number: [usize; 3],
}

impl CoarseGrid {
    /// Cells of about an edge (m), as many as fit best along each axis.
    pub fn new(region: &Region, edge: f64) -> Self {
        let size = region.upper - region.lower;
        let number = size.map(|length| (length / edge).round().max(1.0));
        let spacing = size.component_div(&number);
        Self { lower: region.lower, spacing, number: [0, 1, 2].map(|a| number[a] as usize) }
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.number.iter().product()
    }

    /// The cell that holds a point of the region.
    pub fn cell(&self, point: &Vec3) -> usize {
        let place = (point - self.lower).component_div(&self.spacing);
        let at = |a: usize| (place[a] as usize).min(self.number[a] - 1);
        at(0) + self.number[0] * (at(1) + self.number[1] * at(2))
    }

    /// Middle of a cell (m).
    pub fn middle(&self, cell: usize) -> Vec3 {
        let [nx, ny, _] = self.number;
        let at = [cell % nx, cell / nx % ny, cell / (nx * ny)];
        Vec3::from_fn(|a, _| self.lower[a] + (at[a] as f64 + 0.5) * self.spacing[a])
    }
}

/// Edge of the cells (m): the one asked for, else three mean diameters of the particles.
///
/// # Errors
/// An edge that makes too many cells.
pub fn edge(
    asked: Option<f64>,
    region: &Region,
    (snapshot, shapes): (&Snapshot, &[Shape]),
    transport: &impl Transport,
) -> Result<f64, RunError> {
    let volume = (region.upper - region.lower).product();
    let edge = match asked {
        Some(edge) => edge,
        None => 3.0 * mean_diameter(snapshot, shapes, 0..snapshot.len(), transport),
    };
    // Without particles there is no mean diameter, and one cell shows all there is.
    let edge = if edge.is_nan() && asked.is_none() { volume.cbrt() } else { edge };
    if edge > 0.0 && volume / edge.powi(3) <= MAX_CELLS {
        return Ok(edge);
    }
    Err(RunError::case(format!(
        "--cell {edge:.3e} m: makes too many cells of a region of {volume:.3e} m3; at most {MAX_CELLS:.0e} are possible, take larger ones"
    )))
}
