//! What a simulation shows of its particles, walls and fluid.

use crate::fluid::{FluidPhase, Seconds};
use grains_dem::{Body, Dem, Load, WallLoad, WallState};
use grains_fluid::Flow;
use grains_geometry::{Rotation, Vec3};

/// A particle.
#[derive(Clone, Copy, Debug)]
pub struct ParticleView<'a> {
    /// Identity, which it keeps.
    pub id: u64,
    /// Name of its shape in the case.
    pub shape: &'a str,
    /// Position (m), velocity (m/s), angular velocity (rad/s), bounding radius (m), mass (kg).
    pub body: &'a Body,
    /// From its own axes to those of the domain.
    pub orientation: Rotation,
    /// Force (N) and torque about its centre (N m) at the last step.
    pub load: &'a Load,
}

impl<'a> ParticleView<'a> {
    pub(crate) fn new(dem: &'a Dem, i: usize) -> Self {
        let particles = &dem.particles;
        Self {
            id: particles.ids[i],
            shape: &dem.setup.catalogue.shape(particles.bodies[i].kind).name,
            body: &particles.bodies[i],
            orientation: particles.record(i).orientation,
            load: &particles.loads[i],
        }
    }

    /// Centre (m).
    pub fn position(&self) -> Vec3 {
        self.body.position
    }

    /// Velocity of the centre (m/s).
    pub fn velocity(&self) -> Vec3 {
        self.body.velocity
    }

    /// Kinetic energy of its translation ½ m v² (J).
    pub fn kinetic_energy(&self) -> f64 {
        0.5 * self.body.mass * self.body.velocity.norm_squared()
    }
}

/// A wall.
#[derive(Clone, Copy, Debug)]
pub struct WallView<'a> {
    /// Its name in the case.
    pub name: &'a str,
    /// Pose and velocity.
    pub state: &'a WallState,
    /// Force (N) and torque about the origin (N m) by the particles of this rank at the last step.
    pub load: &'a WallLoad,
}

impl<'a> WallView<'a> {
    pub(crate) fn new(dem: &'a Dem, k: usize) -> Self {
        let state = &dem.wall_states()[k];
        Self { name: &dem.setup.walls[k].name, state, load: &dem.wall_loads[k] }
    }
}

/// The fluid.
#[derive(Clone, Copy)]
pub struct FluidView<'a> {
    /// Grid, velocity (m/s) and pressure (Pa) in the cells of this rank.
    pub flow: &'a Flow,
    /// Steps since the simulation was built.
    pub steps: u64,
    /// Iterations for the pressure in these.
    pub iterations: u64,
    /// Wall-clock time in these on this rank (s).
    pub seconds: f64,
    /// Wall-clock time of the exchange with particles on this rank (s).
    pub exchange_seconds: f64,
}

impl<'a> FluidView<'a> {
    pub(crate) fn new(fluid: &'a FluidPhase) -> Self {
        let Seconds { flow: seconds, exchange: exchange_seconds, .. } = fluid.seconds;
        let FluidPhase { flow, steps, iterations, .. } = fluid;
        Self { flow, steps: *steps, iterations: *iterations, seconds, exchange_seconds }
    }

    /// Cells of the whole grid.
    pub fn cells(&self) -> usize {
        self.flow.setup.grid.cells().iter().product()
    }
}
