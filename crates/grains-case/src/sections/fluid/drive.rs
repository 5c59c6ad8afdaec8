//! `[fluid.drive]`: what drives the flow along periodic axes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::Checker;
use crate::sections::domain::Domain;

/// What drives the flow along a periodic axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Drive {
    /// An imposed mean pressure gradient.
    PressureGradient {
        /// Mean dp/dx along each axis (Pa/m); negative drives towards higher coordinates.
        gradient: [f64; 3],
    },
    /// An imposed mean superficial velocity, kept by adjusting the pressure gradient.
    MeanVelocity {
        /// Mean of ε u over the domain (m/s).
        velocity: [f64; 3],
        /// Axes along which the mean is kept, per axis (x, y, z).
        axes: [bool; 3],
    },
    /// An imposed mean velocity of the mixture, fluid and particles together, kept by adjusting the pressure gradient: 0 for
    /// particles that settle as in a closed vessel. Past resolved particles the same as `mean_velocity`.
    MeanFlux {
        /// Mean of ε u + (1 − ε) v over the domain (m/s), v of the particles.
        velocity: [f64; 3],
        /// Axes along which the mean is kept, per axis (x, y, z).
        axes: [bool; 3],
    },
}

impl Drive {
    /// Only periodic axes along which there is flow can be driven.
    pub(super) fn check(&self, cells: &[u64; 3], domain: &Domain, checker: &mut Checker) {
        let (key, driven) = match self {
            Self::PressureGradient { gradient } => ("gradient", gradient.map(|g| g != 0.0)),
            Self::MeanVelocity { axes, .. } | Self::MeanFlux { axes, .. } => ("axes", *axes),
        };
        for a in (0..3).filter(|a| driven[*a]) {
            let (path, axis) = (format!("fluid.drive.{key}[{a}]"), ["x", "y", "z"][a]);
            if !domain.periodic[a] {
                checker.error(
                    &path,
                    format!(
                        "only periodic axes are driven so, and {axis} is not; set domain.periodic[{a}] = true, or \
                         drive the flow by [[fluid.boundary]]"
                    ),
                );
            } else if cells[a] == 1 {
                checker.error(
                    &path,
                    format!("there is no flow along {axis}, which has one cell; drive another"),
                );
            }
        }
        if let Self::MeanVelocity { velocity, axes } | Self::MeanFlux { velocity, axes } = self
            && let Some(a) = (0..3).find(|a| velocity[*a] != 0.0 && !axes[*a])
        {
            let message =
                format!("without effect: the mean is kept where axes are true, and axes[{a}] is false");
            checker.warn(&format!("fluid.drive.velocity[{a}]"), message);
        }
    }
}
