//! `place = { kind = ... }`: where particles are inserted.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::Checker;
use crate::sections::domain::Domain;

/// The region in which random centres are drawn, uniformly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Window {
    /// Rectangular box; it may be flat.
    Box {
        /// Lower corner (m).
        lower: [f64; 3],
        /// Upper corner (m).
        upper: [f64; 3],
    },
    /// Flat disc.
    Disc {
        /// Centre (m).
        center: [f64; 3],
        /// Normal of the disc (-), of any length.
        normal: [f64; 3],
        /// Radius (m).
        #[schemars(extend("exclusiveMinimum" = 0))]
        radius: f64,
    },
    /// A single point.
    Point {
        /// The point (m).
        at: [f64; 3],
    },
}

/// How the positions of particles are chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Place {
    /// Cubic lattice: cells of edge `spacing` from the lower corner on, one centre in each, x fastest.
    Lattice {
        /// Lower corner of the region the cells fill (m).
        lower: [f64; 3],
        /// Upper corner of the region (m).
        upper: [f64; 3],
        /// Edge of a cell (m); by default the largest bounding sphere fits, noise included.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("exclusiveMinimum" = 0))]
        spacing: Option<f64>,
        /// Largest random displacement along each axis (-), as a fraction of the spacing.
        #[serde(default)]
        #[schemars(extend("minimum" = 0, "exclusiveMaximum" = 0.5))]
        noise: f64,
    },
    /// Random positions in a window, tried again until the particle fits.
    Window {
        /// Region of the centres.
        window: Window,
        /// Attempts per particle before the insertion is given up (-).
        #[serde(default = "thousand")]
        #[schemars(extend("minimum" = 1, "maximum" = 1_000_000))]
        attempts: u64,
        /// Wait for room, and try again after this time (s), instead of refusing a first batch that does not fit.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("exclusiveMinimum" = 0))]
        retry: Option<f64>,
    },
    /// Positions from a file.
    ///
    /// CSV with a header of the columns x,y,z (m) of the centres of mass and, as needed, radius (m, spheres) or scale (-),
    /// qw,qx,qy,qz, which turn the shape as the case gives it, vx,vy,vz (m/s), wx,wy,wz (rad/s), shape, material; or HDF5
    /// with those data sets (numbers, and names of variable length). Snapshots write the same places and quaternions.
    File {
        /// CSV (.csv) or HDF5 (.h5) file, or the particles.vtkhdf of a run, of which the last snapshot is taken;
        /// relative to the folder of the case file.
        path: PathBuf,
    },
}

fn thousand() -> u64 {
    1000
}

/// Lattice spacing (m) at which bodies of a bounding radius R (m) stay apart: 2 R / (1 − 2 noise),
/// and a thousandth more against rounding.
pub fn default_spacing(bounding_radius: f64, noise: f64) -> f64 {
    2.002 * bounding_radius / (1.0 - 2.0 * noise)
}

/// Largest number of places (-) along an axis: those of three axes can be numbered in 64 bits.
pub(crate) const MOST_PLACES: f64 = 2_097_151.0;

/// Number of lattice cells (-) of an edge (m) that fit along each axis between two corners (m).
pub fn lattice_sites(lower: [f64; 3], upper: [f64; 3], spacing: f64) -> [u64; 3] {
    // The tolerance lets a region made for a whole number of cells hold that number.
    [0, 1, 2].map(|a| ((upper[a] - lower[a]) / spacing + 1e-9).max(0.0) as u64)
}

impl Place {
    /// Lower and upper corner (m) of the region of the centres; none for a file, which is not read here.
    pub fn extents(&self) -> Option<[[f64; 3]; 2]> {
        match self {
            Self::Lattice { lower, upper, .. }
            | Self::Window { window: Window::Box { lower, upper }, .. } => Some([*lower, *upper]),
            Self::Window { window: Window::Disc { center, normal, radius }, .. } => {
                let reach = normal.map(|n| radius * (1.0 - n * n).max(0.0).sqrt());
                Some([-1.0, 1.0].map(|sign| [0, 1, 2].map(|a| center[a] + sign * reach[a])))
            }
            Self::Window { window: Window::Point { at }, .. } => Some([*at, *at]),
            Self::File { .. } => None,
        }
    }

    pub(crate) fn check(&mut self, path: &str, domain: &Domain, checker: &mut Checker) {
        match self {
            Self::Lattice { lower, upper, .. } => {
                checker.ordered_corners(path, *lower, *upper);
                domain.must_hold(checker, &format!("{path}.lower"), *lower);
                domain.must_hold(checker, &format!("{path}.upper"), *upper);
            }
            Self::Window { window, .. } => window.check(&format!("{path}.window"), domain, checker),
            Self::File { path: file } => {
                *file = checker.file(&format!("{path}.path"), file, &["csv", "h5", "hdf5", "vtkhdf"]);
            }
        }
    }
}

impl Window {
    fn check(&mut self, path: &str, domain: &Domain, checker: &mut Checker) {
        match self {
            Self::Box { lower, upper } => {
                for axis in 0..3 {
                    if lower[axis] > upper[axis] {
                        let low = lower[axis];
                        checker.error(
                            &format!("{path}.upper[{axis}]"),
                            format!("must not be below lower[{axis}] = {low} m"),
                        );
                    }
                }
                domain.must_hold(checker, &format!("{path}.lower"), *lower);
                domain.must_hold(checker, &format!("{path}.upper"), *upper);
            }
            Self::Disc { center, normal, radius } => {
                *normal = checker.direction(&format!("{path}.normal"), *normal);
                domain.must_hold(checker, &format!("{path}.center"), *center);
                let reach = normal.map(|n| *radius * (1.0 - n * n).max(0.0).sqrt());
                let beyond = (0..3).any(|a| {
                    center[a] - reach[a] < domain.lower[a] || center[a] + reach[a] > domain.upper[a]
                });
                if beyond && domain.contains(*center) {
                    checker.error(
                        &format!("{path}.radius"),
                        "the disc reaches beyond the domain; reduce the radius or move the centre".into(),
                    );
                }
            }
            Self::Point { at } => domain.must_hold(checker, &format!("{path}.at"), *at),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_region_of_three_cells_holds_three_in_spite_of_rounding() {
        assert_eq!(lattice_sites([0.0; 3], [0.3, 0.1, 0.05], 0.1), [3, 1, 0]);
        assert_eq!(lattice_sites([0.1, 0.0, 0.0], [0.1 + 7.0 * 0.0138, 1.0, 1.0], 0.0138)[0], 7);
    }

    #[test]
    fn neighbours_at_the_default_spacing_stay_apart_under_the_largest_noise() {
        for noise in [0.0, 0.01, 0.4] {
            let spacing = default_spacing(0.5, noise);
            assert!(spacing - 2.0 * noise * spacing > 1.0);
        }
    }
}
