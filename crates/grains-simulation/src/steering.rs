//! What may be changed of a simulation while it goes on: motions of walls, inflow, insertion.
//!
//! A restart goes on with what the case says; who steers does so again.

use crate::Simulation;
use crate::error::RunError;
use crate::fluid::condition_number;
use crate::system;
use grains_case::{BoundaryKind, Case, Expression, Motion as CaseMotion};
use grains_dem::Motion;
use grains_fluid::{FlowRate, Profile};
use std::path::Path;
use std::sync::Arc;

/// What an inlet lets in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Inflow {
    /// A velocity (m/s), of an `inlet`.
    Velocity([f64; 3]),
    /// A flow, of a `flow_inlet`: mass (kg/s) or volume per time (m³/s), as the case states it.
    Flow(f64),
}

impl Simulation {
    /// Moves a wall otherwise from now on; it goes on from where it is. A restart continues with the motion of the case.
    ///
    /// All ranks must do so together.
    ///
    /// # Errors
    /// A name of no wall.
    pub fn set_wall_motion(&mut self, wall: &str, motion: Motion) -> Result<(), RunError> {
        let k = self.wall(wall)?;
        self.dem.set_wall_motion(k, motion);
        Ok(())
    }

    /// The same by a motion in the words of the case, a table in TOML such as `{ kind = "translation", velocity = [0, 0, 1] }`.
    ///
    /// # Errors
    /// A name of no wall, or a motion that the case could not have.
    pub fn set_wall_motion_as_in_case(&mut self, wall: &str, motion: &str) -> Result<(), RunError> {
        let k = self.wall(wall)?;
        let given: CaseMotion = toml::from_str(motion)
            .map_err(|e| RunError::case(format!("walls.{wall}.motion: {}", e.message())))?;
        let mut case = self.case.clone();
        case.walls[k].motion = Some(given);
        let motion = checked(&case)?.walls[k].motion.as_ref().map_or(Motion::Fixed, system::motion);
        self.dem.set_wall_motion(k, motion);
        Ok(())
    }

    /// Lets in otherwise from the next step of the fluid on, through a `[[fluid.boundary]]` of a number, from 0; collective.
    ///
    /// # Errors
    /// A boundary that is no such inlet, a flow that is no number, or one that seeks its steady state.
    pub fn set_inflow(&mut self, boundary: usize, inflow: Inflow) -> Result<(), RunError> {
        let place = format!("fluid.boundary[{boundary}]");
        let mut case = self.case.clone();
        let Some(fluid) = case.fluid.as_mut().filter(|fluid| boundary < fluid.boundary.len()) else {
            return Err(RunError::case(format!("{place}: the case has no such boundary")));
        };
        if fluid.steady.is_some() {
            let message =
                format!("{place}: a flow that seeks its steady state keeps its inlets; remove fluid.steady");
            return Err(RunError::case(message));
        }
        let number = Expression::Number;
        match (&mut fluid.boundary[boundary].kind, inflow) {
            (BoundaryKind::Inlet { velocity: old }, Inflow::Velocity(velocity)) => {
                *old = velocity.map(number)
            }
            (BoundaryKind::FlowInlet { mass_flow: Some(old), .. }, Inflow::Flow(flow))
            | (BoundaryKind::FlowInlet { volume_flow: Some(old), .. }, Inflow::Flow(flow)) => {
                *old = number(flow)
            }
            _ => {
                let message = format!(
                    "{place}: a velocity can be set of an `inlet`, a flow of a `flow_inlet`; this is neither, or the other"
                );
                return Err(RunError::case(message));
            }
        }
        // With the same boundaries in the case, the flow keeps them when cells change hands.
        self.case.fluid = checked(&case)?.fluid;
        let (Some(fluid), Some(phase)) = (&self.case.fluid, &mut self.fluid) else { return Ok(()) };
        let kind = &fluid.boundary[boundary].kind;
        let profile = match (inflow, kind) {
            (Inflow::Velocity(velocity), _) => Profile::Function(Arc::new(move |_, _| velocity)),
            (Inflow::Flow(flow), BoundaryKind::FlowInlet { .. }) => {
                let factor = kind.flow(fluid.density).map_or(1.0, |(_, factor)| factor);
                let rate = FlowRate::Function(Arc::new(move |_| factor * flow));
                Profile::FlowRate { rate, is_parabolic: kind.is_parabolic() }
            }
            (Inflow::Flow(_), _) => return Ok(()),
        };
        if let Some(number) = condition_number(fluid, boundary) {
            phase.flow.set_inlet(number, profile, &self.transport);
        }
        Ok(())
    }

    /// Inserts otherwise from now on: particles per batch, time between batches (s), and when the next is due (s); by default at once,
    /// and never if that is infinite. Collective.
    ///
    /// # Errors
    /// A name of no insertion, a batch of none, or a time that is no number.
    pub fn set_insertion(
        &mut self,
        name: &str,
        batch: u64,
        interval: f64,
        next: Option<f64>,
    ) -> Result<(), RunError> {
        let next = next.unwrap_or(self.time()).max(self.time());
        if batch == 0 || !(interval.is_finite() && interval >= 0.0) || next.is_nan() {
            let message = format!(
                "insert.{name}: batch = {batch}, interval = {interval}, next = {next}: a batch needs a particle and an interval (s) of 0 or more; to pause, set the next one to be due at an infinite time"
            );
            return Err(RunError::case(message));
        }
        self.insertions.set_batches(name, batch, interval, next).map_err(RunError::case)
    }

    /// The place of a wall among all.
    fn wall(&self, name: &str) -> Result<usize, RunError> {
        let walls = &self.dem.setup.walls;
        walls.iter().position(|wall| wall.name == name).ok_or_else(|| {
            let names: Vec<&str> = walls.iter().map(|wall| wall.name.as_str()).collect();
            RunError::case(format!("no wall is called `{name}`; there are {}", names.join(", ")))
        })
    }
}

/// A case after a change, checked as one that is read.
fn checked(case: &Case) -> Result<Case, RunError> {
    Case::parse(&case.to_toml(), "the changed case", Path::new("")).map_err(|e| RunError::case(e.to_string()))
}
