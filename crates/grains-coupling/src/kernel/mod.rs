//! Kernels: which cells a particle's volume and momentum go to, and whence it takes the fluid's velocity.
//!
//! Both kernels are products of one function per axis whose integral is known, so a cell's weight is a product of
//! differences of that integral: exact on uniform and stretched axes alike, and of sum 1 whatever the cells. What lies
//! beyond a wall or an open boundary of the domain is mirrored back. The same weights deposit and interpolate, so the
//! force on a particle and its reaction on the fluid are the same numbers.
//!
//! *Cube* is the cube of the particle's volume (Bernard et al. 2016; thesis 5.4.3). *Smooth* is (15/16)(1 − t²)² per axis with
//! t = (x − x_p)/(half width) (Deen et al. 2004), at a width that has nothing to do with the cells. Its standard deviation is
//! the half width over √7: 2.29 diameters smooth like a box of three.
//!
//! *Faces.* A face takes half the weight of the cell on either side ([`Stencil::at`]): the velocity a particle sees is
//! the weighted mean of the cells' mean velocities, its force goes in halves to the faces of each cell, and the void
//! fraction that belongs to a face is the mean of those of its cells weighted by their volume. Faces on a boundary
//! of the domain take their half as well: the drag there is borne by the boundary, and shows as a pressure gradient between it
//! and the centre of its cell ([`crate::boundary_gradient`]), so that particles and fluid together lose no momentum but through
//! the pressure on the boundary. The velocity a particle sees leaves such faces out ([`Site::InnerFaces`]): what an inlet or
//! a wall imposes is not what flows between the particles.
//!
//! The shape of a particle plays no part: it is spread like the cube or blob of its volume. Particles larger than the
//! cells want their true shape sampled, or the flow around them resolved; neither is done here, and the smoothing kernel
//! is what lets cells be smaller than three diameters.

mod axis;
mod stencil;

use crate::CouplingError;
pub use axis::{End, GridAxis};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
pub use stencil::{Layout, MAX_CELLS, Site, Stencil};

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
    fn check_width(self) -> Result<(), CouplingError> {
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
    #[inline]
    pub fn reach(&self, diameter: f64) -> f64 {
        /// (π/6)^⅓/2.
        const HALF_CUBE: f64 = 0.402_997_988_504_117_4;
        match self {
            Self::Cube => HALF_CUBE * diameter,
            Self::Smooth { half_width } => half_width * diameter,
        }
    }

    /// Share of the kernel that lies below the place `t`, in units of the reach from its centre (-).
    #[inline]
    fn below(&self, t: f64) -> f64 {
        let t = t.clamp(-1.0, 1.0);
        match self {
            Self::Cube => 0.5 * (1.0 + t),
            Self::Smooth { .. } => {
                let s = t * t;
                0.5 + t * (15.0 / 16.0 - s * (0.625 - 0.1875 * s))
            }
        }
    }

    /// Whether the kernel is of an allowed width and the largest particle of a case fits the cells: covers no more than
    /// [`MAX_CELLS`] along any axis.
    ///
    /// `diameter` is the largest equivalent diameter (m). Errors: [`CouplingError::OutOfRange`], [`CouplingError::TooManyCells`].
    pub fn check(&self, axes: &[GridAxis; 3], diameter: f64) -> Result<(), CouplingError> {
        self.check_width()?;
        let reach = self.reach(diameter);
        for (a, axis) in axes.iter().enumerate() {
            let cell = axis.smallest_cell();
            let cells = ((2.0 * reach / cell).ceil() as usize + 1).min(axis.cells());
            if cells > MAX_CELLS {
                let axis = ['x', 'y', 'z'][a];
                return Err(CouplingError::TooManyCells { axis, reach, cell, cells, most: MAX_CELLS });
            }
        }
        Ok(())
    }

    /// Cells of halo that a rank needs: those that the reach of the largest particle covers which has wandered
    /// `drift` (m) out of the rank's own cells since it last migrated, of size `cell` (m) at least.
    pub fn halo(&self, diameter: f64, drift: f64, cell: f64) -> usize {
        ((self.reach(diameter) + drift) / cell).ceil() as usize
    }
}
