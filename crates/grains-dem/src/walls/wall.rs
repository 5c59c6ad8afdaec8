//! A wall and the loads on it.

use super::motion::Motion;
use super::surface::Surface;
use super::wear::{SlidingSums, Wear};
use crate::contacts::{ContactLoads, LoadQuanta};
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
    /// Axes along which the wall spans the whole periodic box.
    ///
    /// Along these it is met at the wrapped position; it should extend beyond the box by a radius.
    pub spans: [bool; 3],
    /// What heat passes between the wall and particles, if any does.
    pub heat: Option<WallHeat>,
    /// How it wears, if that is asked for.
    pub wear: Option<Wear>,
}

/// What a wall says of the heat between it and the particles that touch it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WallHeat {
    /// Its temperature (K).
    Temperature(f64),
    /// The heat (W) that it gives to all particles that touch it, at the one temperature at which it does.
    Power(f64),
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

/// What a pass over the contacts with walls sums up.
pub(crate) struct WallSums<'a> {
    /// Load on each wall.
    pub(crate) loads: &'a mut [WallLoad],
    /// What slides on the walls that wear.
    pub(crate) sliding: &'a mut SlidingSums,
}

impl WallSums<'_> {
    /// Adds the opposite of the loads of a particle at a point (m) of a wall.
    #[inline(always)]
    pub(super) fn add(&mut self, wall: u16, loads: &ContactLoads, point: &Vec3, quanta: &LoadQuanta) {
        let load = &mut self.loads[usize::from(wall)];
        load.force -= loads.force;
        load.torque += loads.torques[1] - quanta.torque(&point.cross(&loads.force));
    }
}
