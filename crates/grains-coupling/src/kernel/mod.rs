//! Kernels: which cells a particle's volume and momentum go to, and whence it takes the fluid's velocity.
//!
//! Both kernels are products of one function per axis whose integral is known, so a cell's weight is a product of
//! differences of that integral: exact on uniform and stretched axes alike, and of sum 1 whatever the cells. What lies
//! beyond a wall or an open boundary of the domain is mirrored back. The same weights deposit and interpolate, so the
//! force on a particle and its reaction on the fluid are the same numbers.
//!
//! *Faces.* A face takes half the weight of the cell on either side ([`Stencil::weigh`]): the velocity a particle sees is
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
mod function;
mod site_weights;
mod stencil;

pub use axis::{End, GridAxis, MAX_CELLS};
pub use function::Kernel;
pub use site_weights::{Layout, SiteWeights};
pub use stencil::{Site, Stencil};
