//! The kernel as a function along one axis.
//!
//! *Cube* is the cube of the particle's volume (Bernard et al. 2016; thesis 5.4.3). *Smooth* is (15/16)(1 − t²)² per axis with
//! t = (x − x_p)/(half width) (Deen et al. 2004), at a width that has nothing to do with the cells. Its standard deviation is
//! the half width over √7: 2.29 diameters smooth like a box of three.

use crate::CouplingError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a particle is spread over the cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Kernel {
    /// A cube of the particle's volume, cut by the cells: for cells of three diameters and more.
    #[default]
    Cube,
    /// A smooth blob whose width does not depend on the cells.
    Smooth {
        /// Half width (diameters of the sphere of the particle's volume).
        #[serde(default = "usual_half_width")]
        #[schemars(extend("minimum" = 0.5, "maximum" = 20))]
        half_width: f64,
    },
}

/// Smooths like a cell of three diameters, ½ · 3 · √(7/3) (diameters).
fn usual_half_width() -> f64 {
    2.291_287_847_477_92
}

impl Kernel {
    /// Refuses a smoothing kernel whose half width is below half a diameter or beyond twenty.
    pub(super) fn check_width(self) -> Result<(), CouplingError> {
        match self {
            Self::Smooth { half_width } if !(0.5..=20.0).contains(&half_width) => {
                Err(CouplingError::OutOfRange {
                    quantity: "fluid.coupling.kernel.half_width (diameters)",
                    value: half_width,
                    allowed: "in [0.5, 20]",
                    remedy: "2.29 smooths like cells of three diameters",
                })
            }
            Self::Smooth { .. } | Self::Cube => Ok(()),
        }
    }

    /// How far (m) the kernel of a particle of equivalent diameter d (m) reaches to either side: half the cube's edge
    /// (π/6)^⅓ d/2, or the half width.
    #[inline(always)]
    pub fn reach(&self, diameter: f64) -> f64 {
        /// (π/6)^⅓/2.
        const HALF_CUBE: f64 = 0.402_997_988_504_117_4;
        match self {
            Self::Cube => HALF_CUBE * diameter,
            Self::Smooth { half_width } => half_width * diameter,
        }
    }

    /// Share of the kernel that lies below the place `t`, in units of the reach from its centre (-).
    #[inline(always)]
    pub(super) fn below(&self, t: f64) -> f64 {
        let t = t.clamp(-1.0, 1.0);
        match self {
            Self::Cube => 0.5 * (1.0 + t),
            Self::Smooth { .. } => {
                let s = t * t;
                0.5 + t * (15.0 / 16.0 - s * (0.625 - 0.1875 * s))
            }
        }
    }

    /// Cells of halo that a rank needs: those that the reach of the largest particle covers which has wandered
    /// `drift` (m) out of the rank's own cells since it last migrated, of size `cell` (m) at least.
    pub fn halo(&self, diameter: f64, drift: f64, cell: f64) -> usize {
        ((self.reach(diameter) + drift) / cell).ceil() as usize
    }
}
