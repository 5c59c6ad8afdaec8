//! Walls: surfaces with a material, fixed or moving, present for all or part of a run.

mod contacts;
mod motion;
mod open_tube;
mod surface;
mod table;

pub use motion::{Motion, WallPlace, WallState};
pub use open_tube::OpenTube;
pub use surface::Surface;
pub use table::MotionTable;

pub(crate) use contacts::{
    WallList, WallMeeting, WallPair, WallScene, add_forces, for_each_contact, meet, not_found,
};
pub(crate) use surface::SurfaceContact;

use grains_geometry::Vec3;

/// A wall: surfaces that share a name, a material, a motion and a life time.
#[derive(Clone, Debug)]
pub struct Wall {
    /// Name in the case.
    pub name: String,
    /// Material number.
    pub material: u16,
    /// Its surfaces, in the wall's own frame: the world frame at time zero.
    pub surfaces: Vec<Surface>,
    /// Prescribed motion.
    pub motion: Motion,
    /// Time from which the wall exists (s).
    pub from: f64,
    /// Time from which it no longer exists (s).
    pub until: f64,
    /// Axes along which the wall reaches over the whole periodic box.
    ///
    /// Along these it is met at the wrapped position; it should reach beyond the box by a radius.
    pub spans: [bool; 3],
}

impl Wall {
    /// Axes along which a surface of the wall is met at the wrapped position, not at images: those along
    /// which it has no end.
    pub(crate) fn wrapped_axes(&self, surface: &Surface) -> [bool; 3] {
        if surface.is_finite() { self.spans } else { [true; 3] }
    }

    /// Whether the wall exists at a time (s).
    pub fn exists_at(&self, time: f64) -> bool {
        time >= self.from && time < self.until
    }
}

/// Force (N) and torque about the origin (N m) that particles exert on a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WallLoad {
    /// Force (N).
    pub force: Vec3,
    /// Torque about the origin of the world frame (N m).
    pub torque: Vec3,
}
