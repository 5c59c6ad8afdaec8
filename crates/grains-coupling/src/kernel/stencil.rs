//! The weights of one particle on the cells and faces around it.

use super::axis::{GridAxis, Weights};
use super::function::Kernel;
use super::site_weights::{Layout, SiteWeights};
use crate::CouplingError;
use grains_geometry::Vec3;

/// Where a field lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Site {
    /// Centres of cells.
    Cells,
    /// Faces normal to an axis (0, 1, 2); face i is the lower one of cell i.
    Faces(usize),
    /// The same without those on a boundary of the domain, whose shares the next ones within take.
    InnerFaces(usize),
}

/// Weights of one particle along the three axes, whose products are those of the cells.
#[derive(Clone, Debug)]
pub struct Stencil {
    cells: [Weights; 3],
    /// Whether the lower face of the first cell and the upper one of the last lie on a boundary of the domain, which has others within.
    is_on_boundary: [[bool; 2]; 3],
    /// Scratch: weights of faces along their normal.
    faces: Weights,
}

impl Default for Stencil {
    fn default() -> Self {
        Self { cells: [Weights::NONE; 3], is_on_boundary: [[false; 2]; 3], faces: Weights::NONE }
    }
}

impl Stencil {
    /// Takes the place of a particle at `center` (m) of equivalent diameter `diameter` (m); allocates nothing.
    ///
    /// Errors: a kernel that leaves the cells and their halo.
    #[inline(always)]
    pub fn place(
        &mut self,
        kernel: &Kernel,
        axes: &[GridAxis; 3],
        center: &Vec3,
        diameter: f64,
    ) -> Result<(), CouplingError> {
        let reach = kernel.reach(diameter);
        let reaches = [reach, 1.0 / reach];
        for a in 0..3 {
            axes[a].spread((kernel, a), center[a], reaches, &mut self.cells[a])?;
            self.is_on_boundary[a] = axes[a].is_on_boundary(&self.cells[a]);
        }
        Ok(())
    }

    /// Whether the faces normal to an axis and the inner ones have different weights.
    #[inline(always)]
    pub fn has_boundary_faces(&self, axis: usize) -> bool {
        self.is_on_boundary[axis] != [false; 2]
    }

    /// Finds the weights of the values at a site, whose sum is 1; allocates nothing once it has been called for the widest kernel.
    #[inline(always)]
    pub fn weigh(&mut self, site: Site, layout: &Layout, weights: &mut SiteWeights) {
        let Self { cells, is_on_boundary, faces } = self;
        let mut along: [&Weights; 3] = cells.each_ref();
        let boundaries = match site {
            Site::Cells => None,
            Site::Faces(axis) => Some((axis, [false; 2])),
            Site::InnerFaces(axis) => Some((axis, is_on_boundary[axis])),
        };
        if let Some((axis, is_on_boundary)) = boundaries {
            along[axis].spread_to_faces(is_on_boundary, faces);
            along[axis] = faces;
        }
        weights.multiply(along, layout);
    }
}
