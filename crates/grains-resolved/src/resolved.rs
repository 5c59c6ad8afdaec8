//! The bodies of a rank, and how their rigid-body velocity is imposed on the fluid.

use crate::balance::{VIRTUAL_MASS, velocities};
use crate::body_ghosts::BodyGhosts;
use crate::multiplier::{MultiplierMethod, Multipliers};
use crate::nodes::Nodes;
use crate::{Action, BodyMotion, ConstraintError, Extrapolation, RigidBody, SetupError, Subgrid};
use grains_domain::Transport;
use grains_fluid::{Faces, Flow, Immersed, Layout};
use grains_geometry::Shape;

/// How the constraint is imposed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Velocities inside bodies are set.
    Direct {
        /// How they are extrapolated from those outside.
        extrapolation: Extrapolation,
    },
    /// Multipliers at points are solved for.
    Multiplier(MultiplierMethod),
}

/// How the bodies act on the fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forcing {
    /// How the constraint is imposed.
    pub method: Method,
    /// Share γ of the last force in the momentum equation (-), eq. 7.9.
    pub explicit: f64,
}

/// The bodies of a rank, whose rigid-body velocity the fluid takes.
pub struct Resolved {
    /// Where velocities lie.
    pub subgrid: Subgrid,
    /// How the constraint is imposed.
    pub forcing: Forcing,
    /// Own bodies, then ghosts.
    pub bodies: Vec<RigidBody>,
    /// Number of own bodies.
    pub owned: usize,
    pub(crate) ghosts: BodyGhosts,
    pub(crate) nodes: Nodes,
    /// Places of the last step's forces per component.
    pub(crate) forced: [Vec<usize>; 3],
    pub(crate) multipliers: Multipliers,
}

impl Resolved {
    /// No bodies yet.
    ///
    /// # Errors
    /// A grid that bodies cannot be resolved on.
    pub fn new(flow: &mut Flow, forcing: Forcing) -> Result<Self, SetupError> {
        let subgrid = Subgrid::new(&flow.setup)?;
        let mut immersed = Immersed::new(flow.layout());
        immersed.extrapolated =
            matches!(forcing.method, Method::Direct { .. }).then(|| Faces::new(flow.layout()));
        flow.immersed = Some(immersed);
        // Direct forcing needs no room for multipliers.
        let layout = match forcing.method {
            Method::Direct { .. } => Layout { cells: [0; 3], halo: 0 },
            Method::Multiplier(_) => flow.layout(),
        };
        Ok(Self {
            multipliers: Multipliers::new(&flow.setup, layout),
            nodes: Nodes::new(&subgrid),
            subgrid,
            forcing,
            bodies: Vec::new(),
            owned: 0,
            ghosts: BodyGhosts::default(),
            forced: Default::default(),
        })
    }

    /// Takes the own bodies where they are now; collective. The next step of the flow is for these places.
    pub fn place(
        &mut self,
        own: Vec<RigidBody>,
        shapes: &[Shape],
        flow: &mut Flow,
        transport: &dyn Transport,
    ) {
        self.owned = own.len();
        self.bodies = own;
        self.ghosts = BodyGhosts::new(&mut self.bodies, shapes, &self.subgrid, transport);
        let extrapolation = match self.forcing.method {
            Method::Direct { extrapolation } => extrapolation,
            Method::Multiplier(_) => Extrapolation::Rigid,
        };
        self.nodes.find(&self.bodies, shapes, &self.subgrid, extrapolation);
        if let Method::Multiplier(method) = self.forcing.method {
            self.multipliers.place(&method, &self.nodes, &self.bodies, shapes, &self.subgrid);
        }
        if let Some(extrapolated) = flow.immersed.as_mut().and_then(|immersed| immersed.extrapolated.as_mut())
        {
            for (component, forced) in self.forced.iter().enumerate() {
                let extrapolated = extrapolated.component_mut(component);
                let left = forced.iter().filter(|&&place| !self.nodes.holds(component, place));
                left.for_each(|&place| extrapolated[place] = 0.0);
            }
        }
        flow.refresh_extrapolated(transport);
    }

    /// Iterations of the last solve for multipliers.
    pub fn iterations(&self) -> usize {
        self.multipliers.iterations
    }

    /// Takes over the iterations of the last solve before a restart.
    pub fn resume_iterations(&mut self, iterations: usize) {
        self.multipliers.iterations = iterations;
    }

    /// Goes on from the forces and velocities of a flow that was continued; collective.
    pub fn resume(&mut self, flow: &mut Flow, transport: &dyn Transport) {
        let Some(immersed) = &flow.immersed else { return };
        for (component, forced) in self.forced.iter_mut().enumerate() {
            let force = immersed.force.component(component);
            let extrapolated =
                immersed.extrapolated.as_ref().map(|extrapolated| extrapolated.component(component));
            let is_left =
                |&place: &usize| force[place] != 0.0 || extrapolated.is_some_and(|b| b[place] != 0.0);
            let rows = self.subgrid.layout.rows().flat_map(|row| row..row + self.subgrid.layout.cells[0]);
            forced.clear();
            forced.extend(rows.filter(is_left));
        }
        flow.refresh_extrapolated(transport);
    }

    /// Imposes the rigid-body velocity on the fluid inside the bodies after a step of it of `dt` (s); collective.
    ///
    /// Bodies of which `motions` tells the dynamics get new velocities; the others keep theirs. Returns what each own body
    /// does to the fluid.
    ///
    /// # Errors
    /// Multipliers that were not found.
    pub fn impose_rigid_velocity(
        &mut self,
        motions: Option<&[BodyMotion]>,
        flow: &mut Flow,
        dt: f64,
        transport: &dyn Transport,
    ) -> Result<Vec<Action>, ConstraintError> {
        let mut actions = match self.forcing.method {
            Method::Direct { .. } => self.set_velocities(motions, flow, dt, transport),
            Method::Multiplier(method) => self.solve_multipliers(&method, motions, flow, dt, transport)?,
        };
        let moved = actions.iter_mut().zip(&self.bodies).zip(motions.unwrap_or_default());
        for ((action, body), motion) in moved.filter(|(_, motion)| !motion.is_prescribed()) {
            let after = motion.six_by_six() * velocities(body);
            for (a, carried_over) in action.carried_over.iter_mut().enumerate() {
                *carried_over -= VIRTUAL_MASS * motion.density_ratio * (after[a] - motion.momentum[a]);
            }
        }
        Ok(actions)
    }
}
