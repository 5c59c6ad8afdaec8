//! Memory of a simulation that others still read while it goes on.

use crate::Simulation;
use grains_dem::{Body, Load};
use grains_fluid::{Centre, Faces, Field};
use grains_geometry::Rotation;

/// The state that particles and fluid of this rank had, in the memory they had it in.
#[derive(Debug)]
pub struct Loan {
    /// Positions (m), velocities (m/s) and the rest of the mechanical state.
    pub bodies: Vec<Body>,
    /// Identities.
    pub ids: Vec<u64>,
    /// From body to world; empty if all particles are spheres.
    pub orientations: Vec<Rotation>,
    /// Forces (N) and torques (N m).
    pub loads: Vec<Load>,
    /// Temperatures (K); empty without them.
    pub temperatures: Vec<f64>,
    /// The fluid, if there is one.
    pub fluid: Option<FluidLoan>,
}

/// The fluid's part of a [`Loan`].
#[derive(Debug)]
pub struct FluidLoan {
    /// Velocity on the faces of the cells (m/s).
    pub velocity: Faces,
    /// Pressure (Pa).
    pub pressure: Field<Centre>,
    /// Void fraction, if the flow is averaged over particles.
    pub void_fraction: Option<Field<Centre>>,
    /// Values of the scalars.
    pub scalars: Vec<Field<Centre>>,
}

impl Simulation {
    /// Gives away the memory of the present state and goes on in a copy of it, with the same bits.
    ///
    /// So that whoever looks at the state without copying it (an array of another language, say) may go on looking.
    pub fn give_memory_away(&mut self) -> Loan {
        /// Puts a copy in the place of what is given away.
        fn swap<T: Clone>(kept: &mut T) -> T {
            let copy = kept.clone();
            std::mem::replace(kept, copy)
        }
        let particles = &mut self.dem.particles;
        let fluid = self.fluid.as_mut().map(|phase| {
            let flow = &mut phase.flow;
            FluidLoan {
                velocity: swap(&mut flow.state.velocity),
                pressure: swap(&mut flow.state.pressure),
                void_fraction: flow.mixture.as_mut().map(|mixture| swap(&mut mixture.void_fraction)),
                scalars: flow
                    .scalars
                    .iter_mut()
                    .flat_map(|s| &mut s.all)
                    .map(|s| swap(&mut s.value))
                    .collect(),
            }
        });
        Loan {
            bodies: swap(&mut particles.bodies),
            ids: swap(&mut particles.ids),
            orientations: swap(&mut particles.orientations),
            loads: swap(&mut particles.loads),
            temperatures: swap(&mut particles.temperatures),
            fluid,
        }
    }
}
