//! A velocity of the fluid that a body imposes.

use crate::Subgrid;
use crate::profile::pitch;
use crate::wall::ClosestPoint;
use grains_domain::prefetch;
use grains_geometry::ClosestSurface;
use grains_geometry::lanes::Vector;

/// Relative difference of distances that counts as rounding: velocities a cell deep are so on all ranks.
pub(crate) const ROUNDING: f64 = 1e-9;

/// A velocity of the fluid that a body imposes.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    /// Place in the arrays.
    pub place: u32,
    /// Place of the body in the list.
    pub body: u32,
    /// Number of its closest surface point, then of its [`InterfaceStencil`](crate::interface_stencil::InterfaceStencil), or one of
    /// the two below.
    pub interface: u32,
}

/// A node that is not next to the surface.
const DEEP: u32 = u32::MAX;
/// A node next to the surface that has the velocity of the body all the same.
pub(crate) const RIGID: u32 = u32::MAX - 1;

impl Node {
    /// A node at this depth; the closest point of its body's surface is kept if it is next to that.
    #[inline(always)]
    pub fn new(place: usize, body: u32, depth: &Depth, closest_points: &mut Vec<ClosestPoint>) -> Self {
        let Depth::Near(out) = depth else { return Self::deep(place, body) };
        closest_points.push(*out);
        Self { place: place as u32, body, interface: closest_points.len() as u32 - 1 }
    }

    /// One that is not next to the surface.
    pub fn deep(place: usize, body: u32) -> Self {
        Self { place: place as u32, body, interface: DEEP }
    }

    /// Whether it is not next to the surface.
    pub fn is_deep(&self) -> bool {
        self.interface == DEEP
    }
}

/// How deep in a body a velocity is.
pub(crate) enum Depth {
    /// Not next to the surface.
    Deep,
    /// Next to this point of the surface.
    Near(ClosestPoint),
}

impl Depth {
    /// That of a velocity with this closest point of the surface.
    #[inline(always)]
    pub fn of(out: &ClosestPoint, subgrid: &Subgrid) -> Self {
        let ClosestSurface { distance, direction } = out.surface;
        if distance >= pitch(&Vector::<f64>::of(&direction), subgrid) * (1.0 - ROUNDING) {
            return Self::Deep;
        }
        Self::Near(ClosestPoint {
            surface: ClosestSurface { distance: distance.max(0.0), direction },
            ..*out
        })
    }
}

/// As many nodes as are worked off while memory answers.
pub(crate) const AHEAD: usize = 16;

/// Asks for the values of fields at a node some way after the one of this number.
#[inline(always)]
pub(crate) fn prefetch_at<const N: usize>(nodes: &[Node], number: usize, fields: [&[f64]; N]) {
    if let Some(node) = nodes.get(number + AHEAD) {
        fields.iter().for_each(|field| prefetch(field, node.place as usize));
    }
}
