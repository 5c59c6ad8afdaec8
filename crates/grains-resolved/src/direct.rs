//! Direct forcing: the bodies' velocities from the balance of their momentum, the fluid's from them.

use crate::multiplier::{MultiplierMethod, Multipliers};
use crate::nodes::{Node, Nodes};
use crate::{BodyMotion, Extrapolation, FollowError, RigidBody, SetupError, Spread, Subgrid};
use grains_domain::Transport;
use grains_fluid::{Flow, Immersed};
use grains_geometry::{Shape, Vec3};
use nalgebra::{Matrix6, Vector6};

/// Part of the displaced fluid's inertia that a body is given besides, with its acceleration in the last step for a force:
/// no body is so light that what the fluid answers a step later makes it swing.
const VIRTUAL_MASS: f64 = 1.0;

/// How the constraint is imposed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Velocities inside bodies are set.
    Direct {
        /// How they follow those outside.
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

/// The bodies of a rank and the fluid that follows them.
pub struct Resolved {
    /// Where velocities lie.
    pub subgrid: Subgrid,
    /// How the constraint is imposed.
    pub forcing: Forcing,
    /// Own bodies, then copies.
    pub bodies: Vec<RigidBody>,
    /// Number of own bodies.
    pub owned: usize,
    pub(crate) spread: Spread,
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
        flow.immersed = Some(Immersed::new(flow.layout()));
        Ok(Self {
            multipliers: Multipliers::new(&flow.setup, flow.layout()),
            nodes: Nodes::new(&subgrid),
            subgrid,
            forcing,
            bodies: Vec::new(),
            owned: 0,
            spread: Spread::default(),
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
        self.spread = Spread::new(&mut self.bodies, shapes, &self.subgrid, transport);
        let extrapolation = match self.forcing.method {
            Method::Direct { extrapolation } => extrapolation,
            Method::Multiplier(_) => Extrapolation::Rigid,
        };
        self.nodes.find(&self.bodies, shapes, &self.subgrid, extrapolation);
        let solid = match self.forcing.method {
            Method::Direct { .. } => self.nodes.solid.as_slice(),
            Method::Multiplier(method) => {
                self.multipliers.place(&method, &self.nodes, &self.bodies, shapes, &self.subgrid);
                &[]
            }
        };
        if let Some(immersed) = &mut flow.immersed {
            immersed.solid.clear();
            immersed.solid.extend_from_slice(solid);
        }
    }

    /// Iterations of the last solve for multipliers.
    pub fn iterations(&self) -> usize {
        self.multipliers.iterations
    }

    /// Goes on from the forces of a flow that was continued: they are released where no body is any more.
    pub fn resume(&mut self, flow: &Flow) {
        let Some(immersed) = &flow.immersed else { return };
        for (component, forced) in self.forced.iter_mut().enumerate() {
            let force = immersed.force.component(component);
            let rows = self.subgrid.layout.rows().flat_map(|row| row..row + self.subgrid.layout.cells[0]);
            forced.clear();
            forced.extend(rows.filter(|&place| force[place] != 0.0));
        }
    }

    /// Makes the fluid follow the bodies after a step of it of `dt` (s); collective.
    ///
    /// Bodies of which `motions` tells the dynamics get new velocities; the others keep theirs. Returns what each own body
    /// does to the fluid.
    ///
    /// # Errors
    /// Multipliers that were not found.
    pub fn follow(
        &mut self,
        motions: Option<&[BodyMotion]>,
        flow: &mut Flow,
        dt: f64,
        transport: &dyn Transport,
    ) -> Result<Vec<Action>, FollowError> {
        let mut actions = match self.forcing.method {
            Method::Direct { .. } => self.set_velocities(motions, flow, dt, transport),
            Method::Multiplier(method) => self.solve_multipliers(&method, motions, flow, dt, transport)?,
        };
        let moved = actions.iter_mut().zip(&self.bodies).zip(motions.unwrap_or_default());
        for ((action, body), motion) in moved {
            let after = motion.six_by_six() * velocities(body);
            for (a, pending) in action.pending.iter_mut().enumerate() {
                *pending -= VIRTUAL_MASS * motion.density_ratio * (after[a] - motion.momentum[a]);
            }
        }
        Ok(actions)
    }

    fn set_velocities(
        &mut self,
        motions: Option<&[BodyMotion]>,
        flow: &mut Flow,
        dt: f64,
        transport: &dyn Transport,
    ) -> Vec<Action> {
        if let Some(motions) = motions {
            self.release(flow, dt);
            flow.refresh_velocity(transport);
            self.move_bodies(motions, flow, dt, transport);
        }
        let mut actions = vec![[0.0; 12]; self.bodies.len()];
        let (density, volume) = (flow.setup.density, self.subgrid.cell_volume());
        let strides = self.subgrid.layout.strides();
        let mut excess = [0.0; 3];
        if let Some(immersed) = &mut flow.immersed {
            for component in (0..3).filter(|&c| self.subgrid.active[c]) {
                let velocity = flow.state.velocity.component_mut(component);
                let force = immersed.force.component_mut(component);
                let nodes = &self.nodes.of[component];
                // All are found before any is set: extrapolations may read each other's places.
                let wanted: Vec<f64> = nodes
                    .iter()
                    .map(|node| {
                        let body = &self.bodies[node.body as usize];
                        node.wanted(body, component, velocity, strides)
                    })
                    .collect();
                for (node, wanted) in nodes.iter().zip(wanted) {
                    let place = node.place;
                    let whole = force[place] + density / dt * (wanted - velocity[place]);
                    force[place] = self.forcing.explicit * whole;
                    velocity[place] = wanted;
                    let beyond = wanted - self.bodies[node.body as usize].velocity_at(&node.arm)[component];
                    excess[component] += beyond;
                    let action = &mut actions[node.body as usize];
                    let row = unit_row(&node.arm, component) * volume;
                    for a in 0..6 {
                        action[a] += row[a] * whole;
                        action[6 + a] += row[a] * density * beyond;
                    }
                }
                self.forced[component].clear();
                self.forced[component].extend(nodes.iter().map(|node| node.place));
            }
            transport.sum(&mut excess);
            let whole = flow.setup.grid.volume();
            immersed.excess = excess.map(|e| e * volume / whole);
        }
        flow.refresh_velocity(transport);
        self.spread.gather(&mut actions, &self.subgrid, transport);
        actions.iter().take(self.owned).map(Action::read).collect()
    }

    /// Takes back the explicit force where no body is any more.
    fn release(&mut self, flow: &mut Flow, dt: f64) {
        let Some(immersed) = &mut flow.immersed else { return };
        let density = flow.setup.density;
        for component in 0..3 {
            let velocity = flow.state.velocity.component_mut(component);
            let force = immersed.force.component_mut(component);
            for &place in &self.forced[component] {
                if !self.nodes.holds(component, place) {
                    velocity[place] -= dt / density * force[place];
                    force[place] = 0.0;
                }
            }
        }
    }

    /// New velocities of the bodies from the balance of momentum of each and of the fluid that turns with it.
    ///
    /// (m − m_f + C m_f)(U − Uⁿ) + C m_f (Uⁿ⁻¹ − Uⁿ) = −J + E − Eⁿ + K
    ///
    /// with K the impulse of all but the flow, J that on the fluid, C the virtual mass, and E the momentum of the fluid
    /// inside beyond that of rigid motion, which jumps when nodes come and go; likewise for the angular momentum.
    fn move_bodies(&mut self, motions: &[BodyMotion], flow: &Flow, dt: f64, transport: &dyn Transport) {
        let Some(immersed) = &flow.immersed else { return };
        let (density, volume) = (flow.setup.density, self.subgrid.cell_volume());
        // Per body: the 6 x 6 response of the impulse to the velocities, and the impulse at rest.
        let mut sums = vec![[0.0; 42]; self.bodies.len()];
        for component in (0..3).filter(|&c| self.subgrid.active[c]) {
            let velocity = flow.state.velocity.component(component);
            let force = immersed.force.component(component);
            for node in &self.nodes.of[component] {
                let sum = &mut sums[node.body as usize];
                // Impulse on the fluid along e: V (f Δt + ρ (e·(U + ω × r) − u)).
                let row = unit_row(&node.arm, component);
                let mass = density * volume;
                let at_rest = volume * dt * force[node.place] - mass * velocity[node.place];
                for a in 0..6 {
                    for b in 0..6 {
                        sum[6 * a + b] += mass * row[a] * row[b];
                    }
                    sum[36 + a] += row[a] * at_rest;
                }
            }
        }
        self.spread.gather(&mut sums, &self.subgrid, transport);
        let mut values = vec![[0.0; 6]; self.bodies.len()];
        for ((value, sum), motion) in values.iter_mut().zip(&sums).zip(motions) {
            let (matrix, right) = motion.balance();
            let matrix = matrix + Matrix6::from_row_slice(&sum[..36]);
            let right = right - Vector6::from_column_slice(&sum[36..]);
            *value = motion.solved(matrix, right).into();
        }
        self.spread.scatter(&mut values, &self.subgrid, transport);
        for (body, value) in self.bodies.iter_mut().zip(&values) {
            body.velocity = Vec3::from_column_slice(&value[..3]);
            body.spin = Vec3::from_column_slice(&value[3..]);
        }
    }
}

/// What a body does to the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Action {
    /// Force (N).
    pub force: Vec3,
    /// Torque about the body's centre (N m).
    pub torque: Vec3,
    /// Momentum and angular momentum that the balance of this step leaves to the next (N s, N m s): E − C m_f (U − Uⁿ).
    pub pending: [f64; 6],
}

impl BodyMotion {
    /// Inertia (m − m_f + C m_f, and of rotation), and the momentum after the step without the flow.
    pub(crate) fn balance(&self) -> (Matrix6<f64>, Vector6<f64>) {
        let share = 1.0 + (VIRTUAL_MASS - 1.0) * self.density_ratio;
        let six = Vector6::from_column_slice;
        let right = six(&self.momentum) * share + six(&self.impulse) - six(&self.pending);
        (self.six_by_six() * share, right)
    }

    /// Velocities of a momentum; those held are 0.
    pub(crate) fn solved(&self, mut matrix: Matrix6<f64>, mut right: Vector6<f64>) -> Vector6<f64> {
        for a in (0..6).filter(|&a| self.held[a]) {
            matrix.row_mut(a).fill(0.0);
            matrix[(a, a)] = 1.0;
            right[a] = 0.0;
        }
        matrix.lu().solve(&right).unwrap_or_else(Vector6::zeros)
    }

    /// Mass and inertia as one matrix.
    fn six_by_six(&self) -> Matrix6<f64> {
        let mut matrix = Matrix6::from_diagonal_element(self.mass);
        matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&self.inertia);
        matrix
    }
}

/// Velocity and angular velocity of a body.
fn velocities(body: &RigidBody) -> Vector6<f64> {
    let (u, w) = (&body.velocity, &body.spin);
    Vector6::new(u.x, u.y, u.z, w.x, w.y, w.z)
}

impl Action {
    pub(crate) fn read(sums: &[f64; 12]) -> Self {
        let vector = |k: usize| Vec3::from_column_slice(&sums[k..k + 3]);
        Self { force: vector(0), torque: vector(3), pending: std::array::from_fn(|a| sums[6 + a]) }
    }
}

/// Torque about the centre of a force f along axis `component` at an arm.
fn moment(arm: &Vec3, component: usize, force: f64) -> Vec3 {
    let mut along = Vec3::zeros();
    along[component] = force;
    arm.cross(&along)
}

/// (e, r × e) for the unit vector e of an axis: e·(U + ω × r) = row · (U, ω), and force and torque of a unit force.
pub(crate) fn unit_row(arm: &Vec3, component: usize) -> Vector6<f64> {
    let torque = moment(arm, component, 1.0);
    let mut row = Vector6::new(0.0, 0.0, 0.0, torque.x, torque.y, torque.z);
    row[component] = 1.0;
    row
}

impl Node {
    /// Share s of the body's velocity at an arm r_s, and the fluid's part g, of the velocity here: s e·(U + ω × r_s) + g.
    #[inline]
    fn terms(&self, velocity: &[f64], strides: [usize; 3]) -> (f64, Vec3, f64) {
        match &self.skin {
            None => (1.0, self.arm, 0.0),
            Some(skin) => {
                let of_point = |(weight, stencil): &(f64, Option<crate::subgrid::Stencil>)| {
                    stencil.as_ref().map_or(0.0, |s| weight * s.interpolate(velocity, strides))
                };
                (skin.surface, skin.foot, skin.fluid.iter().map(of_point).sum())
            }
        }
    }

    #[inline]
    fn wanted(&self, body: &RigidBody, component: usize, velocity: &[f64], strides: [usize; 3]) -> f64 {
        let (share, arm, fluid) = self.terms(velocity, strides);
        share * body.velocity_at(&arm)[component] + fluid
    }
}
