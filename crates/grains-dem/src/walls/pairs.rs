//! Pairs of particles and wall elements that may touch.

use super::motion::WallState;
use super::wall::Wall;
use grains_domain::GlobalBox;
use grains_geometry::Vec3;

/// A part of a particle and an element of a wall that may touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallPair {
    pub(crate) particle: u32,
    /// Triangle of a mesh, else 0.
    pub(crate) element: u32,
    pub(crate) wall: u16,
    pub(crate) surface: u16,
    pub(crate) part: u16,
    /// Periodic image of the particle, see [`crate::periodic_images`].
    pub(crate) image: u8,
    pub(crate) tangential_displacement: Vec3,
    /// Torsional angle about the normal (rad).
    pub(crate) torsional_angle: f64,
    /// Index of the pair's simplex, or `WallPair::CLOSED_FORM`.
    pub(crate) simplex: u32,
}

impl WallPair {
    pub(crate) const CLOSED_FORM: u32 = u32::MAX;

    /// Whether it keeps a displacement.
    pub(super) fn is_stretched(&self) -> bool {
        self.tangential_displacement != Vec3::zeros()
    }

    pub(super) fn reset_displacements(&mut self) {
        self.tangential_displacement = Vec3::zeros();
        self.torsional_angle = 0.0;
    }
}

/// Where and when the walls are met.
pub(crate) struct WallScene<'a> {
    pub(crate) walls: &'a [Wall],
    pub(crate) states: &'a [WallState],
    pub(crate) time: f64,
    pub(crate) dt: f64,
    pub(crate) global: &'a GlobalBox,
}

impl<'a> WallScene<'a> {
    /// Centre (m) of the periodic image of a particle that a pair is about.
    ///
    /// Along axes on which a surface has no end it is its own image: it is met at the wrapped position, so
    /// that the answer does not depend on when the particle was last wrapped.
    #[inline]
    pub(crate) fn center(&self, pair: &WallPair, position: &Vec3, shifts: &[Vec3]) -> Vec3 {
        let mut center = position + shifts[pair.image as usize];
        if self.global.periodic != [false; 3] {
            let wall = &self.walls[pair.wall as usize];
            let wrapped = wall.wrapped_axes(&wall.surfaces[pair.surface as usize]);
            for a in (0..3).filter(|&a| wrapped[a] && self.global.periodic[a]) {
                center[a] = self.global.wrap_along(a, position[a]);
            }
        }
        center
    }
}
