//! The bodies of a rank, and how their rigid-body velocity is imposed on the fluid.

use crate::balance::velocities;
use crate::body_ghosts::BodyGhosts;
use crate::multiplier::{MultiplierMethod, Multipliers};
use crate::nodes::Nodes;
use crate::wall::{PlacedWall, Solids};
use crate::{
    Action, BodyMotion, ConstraintError, Extrapolation, FlowOnWall, FluidWall, Form, RigidBody, SetupError,
    Subgrid,
};
use grains_domain::Transport;
use grains_fluid::{Faces, Flow, Immersed, Layout, March, ValuesOnFaces};
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
    /// Own bodies, then ghosts, then walls.
    pub bodies: Vec<RigidBody>,
    /// Number of own bodies.
    pub owned: usize,
    /// What the flow does to the walls there are, of all ranks together.
    pub on_walls: Vec<FlowOnWall>,
    pub(crate) walls: Vec<PlacedWall>,
    /// The first wall that lies elsewhere than in the last step of the fluid; none if all rest.
    pub(crate) first_moved: Option<usize>,
    pub(crate) ghosts: BodyGhosts,
    pub(crate) nodes: Nodes,
    /// Places of the last step's forces per component.
    pub(crate) forced: [Vec<usize>; 3],
    /// Places of faces of outlets that lie in walls, per component, and the bodies that these are.
    pub(crate) outlets: [Vec<(u32, u32)>; 3],
    pub(crate) multipliers: Multipliers,
    /// Changes of the velocities of all bodies but walls by contacts in the step, if the force knows of them.
    pub(crate) changes_by_contacts: Vec<[f64; 6]>,
}

impl Resolved {
    /// No bodies yet.
    ///
    /// # Errors
    /// A grid that bodies cannot be resolved on.
    pub fn new(flow: &mut Flow, forcing: Forcing) -> Result<Self, SetupError> {
        let subgrid = Subgrid::new(&flow.setup)?;
        let mut immersed = Immersed::new(flow.layout());
        immersed.extrapolated = matches!(forcing.method, Method::Direct { .. }).then(ValuesOnFaces::default);
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
            on_walls: Vec::new(),
            walls: Vec::new(),
            first_moved: None,
            ghosts: BodyGhosts::default(),
            forced: Default::default(),
            outlets: Default::default(),
            changes_by_contacts: Vec::new(),
        })
    }

    /// Takes the walls where they are now, to be followed by [`Resolved::place`]: pose and velocity of each, by the number of
    /// the wall for its id.
    pub fn place_walls(&mut self, walls: Vec<(FluidWall, RigidBody)>) {
        let placed = walls.into_iter().enumerate().map(|(number, (wall, body))| {
            PlacedWall::new(wall, RigidBody { form: Form::Wall(number as u16), ..body }, &self.subgrid)
        });
        let placed: Vec<PlacedWall> = placed.collect();
        let rest = placed.iter().zip(&self.walls).take_while(|(wall, there)| wall.is_where(there)).count();
        self.first_moved = (rest < placed.len().max(self.walls.len())).then_some(rest);
        self.walls = placed;
        let known = std::mem::take(&mut self.on_walls);
        let of = |wall: u64| known.iter().find(|known| known.wall == wall).copied();
        let new = |wall: u64| of(wall).unwrap_or(FlowOnWall { wall, ..FlowOnWall::default() });
        self.on_walls = self.walls.iter().map(|wall| new(wall.body.id)).collect();
    }

    /// Takes over what the flow did to walls before a restart.
    pub fn resume_on_walls(&mut self, known: &[FlowOnWall]) {
        for on_wall in &mut self.on_walls {
            *on_wall = known.iter().find(|known| known.wall == on_wall.wall).copied().unwrap_or(*on_wall);
        }
    }

    /// Takes the own bodies where they are now; collective. The next step of the flow is for these places.
    ///
    /// Extrapolated velocities that bodies have left are the fluid's from now on.
    pub fn place(
        &mut self,
        own: Vec<RigidBody>,
        shapes: &[Shape],
        flow: &mut Flow,
        transport: &dyn Transport,
    ) {
        self.take_bodies(own, shapes, flow, transport);
        if let Some(extrapolated) = flow.immersed.as_mut().and_then(|immersed| immersed.extrapolated.as_mut())
        {
            for (component, values) in extrapolated.iter_mut().enumerate() {
                values.retain(|&(place, _)| self.nodes.holds(component, place as usize));
            }
        }
    }

    /// Takes the own bodies and their ghosts, and finds what they and the walls hold where they are now.
    fn take_bodies(
        &mut self,
        own: Vec<RigidBody>,
        shapes: &[Shape],
        flow: &mut Flow,
        transport: &dyn Transport,
    ) {
        self.owned = own.len();
        self.bodies = own;
        self.ghosts = BodyGhosts::new(&mut self.bodies, shapes, &self.subgrid, transport);
        self.bodies.extend(self.walls.iter().map(|wall| wall.body.clone()));
        let extrapolation = match self.forcing.method {
            Method::Direct { extrapolation } => extrapolation,
            Method::Multiplier(_) => Extrapolation::Rigid,
        };
        let solids = Solids { bodies: &self.bodies, shapes, walls: &self.walls, subgrid: &self.subgrid };
        if let Some(first_moved) = self.first_moved {
            self.nodes.find_in_walls(first_moved, &solids);
        }
        self.nodes.find(&solids, extrapolation);
        if let Method::Multiplier(method) = self.forcing.method {
            let bodies = (&self.bodies[..], shapes);
            self.multipliers.place(&method, &self.nodes, bodies, &self.subgrid);
        }
        self.find_outlets_in_walls(flow);
        if let Some(immersed) = &mut flow.immersed {
            immersed.walls_move = self.walls.iter().any(PlacedWall::is_moving);
            if !self.walls.is_empty() {
                immersed.passing.get_or_insert_with(|| Faces::new(self.subgrid.layout));
            }
            if flow.setup.viscosity_law.is_some() {
                immersed.solid = self.nodes.solid_stresses(&self.subgrid);
            }
            if flow.march == March::PseudoTime {
                immersed.held = self.nodes.held();
                for (held, outlets) in immersed.held.iter_mut().zip(&self.outlets) {
                    held.deep.extend(outlets.iter().map(|(place, _)| place));
                }
            }
            immersed.sealed = self.nodes.sealed_cells(&self.bodies, &self.subgrid);
        }
        self.nodes.cut_faces.note(&self.bodies, &self.subgrid, flow, transport);
    }

    /// Finds the faces of outlets that lie in walls: what is imposed there leaves no way through the wall out of the box.
    fn find_outlets_in_walls(&mut self, flow: &Flow) {
        self.outlets.iter_mut().for_each(Vec::clear);
        if self.walls.is_empty() {
            return;
        }
        for (component, places) in flow.outlets().into_iter().enumerate() {
            let held = places.into_iter().filter_map(|place| {
                let body = self.nodes.holder(component, place as usize)?;
                self.bodies[body as usize].is_wall().then_some((place, body))
            });
            self.outlets[component].extend(held);
        }
    }

    /// Number of the first wall among the bodies.
    pub(crate) fn first_wall(&self) -> usize {
        self.bodies.len() - self.walls.len()
    }

    /// Iterations of the last solve for multipliers.
    pub fn iterations(&self) -> usize {
        self.multipliers.iterations
    }

    /// Takes over the iterations of the last solve before a restart.
    pub fn resume_iterations(&mut self, iterations: usize) {
        self.multipliers.iterations = iterations;
    }

    /// Takes the own bodies where they are now in a flow that is continued, maybe amid a step of it; collective.
    ///
    /// What bodies have left since the last step is known once they are placed at its end.
    pub fn resume(
        &mut self,
        own: Vec<RigidBody>,
        shapes: &[Shape],
        flow: &mut Flow,
        transport: &dyn Transport,
    ) {
        self.find_forced(flow);
        self.take_bodies(own, shapes, flow, transport);
    }

    /// Finds where the forces of the last step are.
    fn find_forced(&mut self, flow: &Flow) {
        let Some(immersed) = &flow.immersed else { return };
        for ((component, forced), outlets) in self.forced.iter_mut().enumerate().zip(flow.outlets()) {
            let force = immersed.force.component(component);
            let rows = self.subgrid.layout.rows().flat_map(|row| row..row + self.subgrid.layout.cells[0]);
            forced.clear();
            forced.extend(rows.filter(|&place| force[place] != 0.0));
            forced
                .extend(outlets.into_iter().map(|place| place as usize).filter(|&place| force[place] != 0.0));
            forced.sort_unstable();
            forced.dedup();
        }
    }

    /// Virtual mass C (-) of a body over the mass m_f of the displaced fluid: C = C₀ + 6 max(0, 1 − m/m_f), with C₀ = 1, and 4 for
    /// multipliers, which leave the fluid next to the surface out of the balance.
    ///
    /// The pressure answers a step later, and the lighter a body, the more it swings by that. The numbers are found by trial, and no
    /// theory's: with 3 in place of 6 cubes of a third of the fluid's density gain energy, with C₀ = 1 springs beside multipliers
    /// do (tests/resolved/contacts.rs).
    pub(crate) fn virtual_mass(&self, motion: &BodyMotion) -> f64 {
        let of_heavy_bodies = match self.forcing.method {
            Method::Direct { .. } => 1.0,
            Method::Multiplier(_) => 4.0,
        };
        of_heavy_bodies + 6.0 * (1.0 - 1.0 / motion.density_ratio).max(0.0)
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
            let virtual_mass = self.virtual_mass(motion) * motion.density_ratio;
            let after = motion.six_by_six() * velocities(body);
            for (a, carried_over) in action.carried_over.iter_mut().enumerate() {
                let by_flow = after[a] - motion.momentum[a] - motion.contacts[a];
                *carried_over -= virtual_mass * by_flow;
            }
        }
        self.changes_by_contacts.clear();
        Ok(actions)
    }
}
