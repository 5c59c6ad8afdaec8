//! Bodies in a flow, on any number of ranks.

#[path = "../../../grains-fluid/tests/fluid/common.rs"]
mod ranks;

use grains_domain::Transport;
use grains_fluid::{Flow, FlowSetup};
use grains_geometry::{Mat3, Shape, Vec3};
use grains_resolved::{
    Action, BodyMotion, Extrapolation, Forcing, Form, Interpolation, Method, MultiplierMethod, Resolved,
    RigidBody,
};
pub use ranks::{difference, joined, order, partition, piece};

/// A body at rest that is not turned.
pub fn body(id: u64, center: Vec3) -> RigidBody {
    RigidBody {
        id,
        form: Form::Shape(0),
        scale: 1.0,
        center,
        rotation: Mat3::identity(),
        velocity: Vec3::zeros(),
        spin: Vec3::zeros(),
    }
}

/// A flow with bodies on one rank, which owns those whose centres lie in its cells.
pub struct Scene {
    pub flow: Flow,
    pub resolved: Resolved,
    pub shapes: Vec<Shape>,
    pub own: Vec<RigidBody>,
    pub actions: Vec<Action>,
    /// Impulse of contacts on each body in the next step (N s, N m s).
    pub contacts: Vec<[f64; 6]>,
}

pub const CUBIC: Forcing =
    Forcing { method: Method::Direct { extrapolation: Extrapolation::Cubic }, explicit: 1.0 };
/// What free bodies use.
pub const QUADRATIC: Forcing =
    Forcing { method: Method::Direct { extrapolation: Extrapolation::Quadratic }, explicit: 1.0 };

pub const MULTIPLIERS: Forcing = Forcing {
    method: Method::Multiplier(MultiplierMethod {
        interpolation: Interpolation::Quadratic,
        spacing: 2.0,
        tolerance: 1e-10,
        iterations: 500,
    }),
    explicit: 1.0,
};

impl Scene {
    pub fn new(
        setup: &FlowSetup,
        ranks: [usize; 3],
        (shape, bodies): (&Shape, &[RigidBody]),
        forcing: Forcing,
        transport: &dyn Transport,
    ) -> Self {
        let own = partition(&setup.grid, ranks, transport.rank());
        let (first, cells) = (own.first(), own.cells());
        let mut flow = Flow::new(FlowSetup { partition: own, halo: 7, ..setup.clone() }, transport).unwrap();
        let resolved = Resolved::new(&mut flow, forcing).unwrap();
        let is_own = |body: &&RigidBody| {
            (0..3).all(|a| {
                let node = |i: usize| setup.grid.axis(a).node(i as isize);
                body.center[a] >= node(first[a]) && body.center[a] < node(first[a] + cells[a])
            })
        };
        let own = bodies.iter().filter(is_own).cloned().collect();
        let own: Vec<RigidBody> = own;
        let actions = vec![Action::default(); own.len()];
        let contacts = vec![[0.0; 6]; own.len()];
        let mut scene = Self { flow, resolved, shapes: vec![shape.clone()], own, actions, contacts };
        scene.place(transport);
        scene
    }

    /// Takes the bodies where they are now.
    pub fn place(&mut self, transport: &dyn Transport) {
        self.resolved.place(self.own.clone(), &self.shapes, &mut self.flow, transport);
    }

    /// One step past bodies that stay.
    pub fn step(&mut self, dt: f64, transport: &dyn Transport) {
        self.flow.step(dt, transport).unwrap();
        self.actions = self.resolved.impose_rigid_velocity(None, &mut self.flow, dt, transport).unwrap();
    }

    /// One step with spheres that move, of a mass, inertia, and density over that of the fluid, under a force.
    pub fn move_freely(&mut self, of_ball: (f64, f64, f64), force: Vec3, dt: f64, transport: &dyn Transport) {
        self.own.iter_mut().for_each(|body| body.center += body.velocity * dt);
        self.follow(of_ball, force, dt, transport);
    }

    /// One step of the fluid to where the bodies are now, with the contacts they had on the way.
    pub fn follow(
        &mut self,
        (mass, inertia, density): (f64, f64, f64),
        force: Vec3,
        dt: f64,
        transport: &dyn Transport,
    ) {
        self.place(transport);
        let motion = |((body, action), contacts): ((&RigidBody, &Action), &[f64; 6])| {
            let (momentum, spun, impulse) = (body.velocity * mass, body.spin * inertia, force * dt);
            BodyMotion {
                mass,
                inertia: Mat3::identity() * inertia,
                density_ratio: 1.0 / density,
                momentum: [momentum.x, momentum.y, momentum.z, spun.x, spun.y, spun.z],
                contacts: *contacts,
                weight: [impulse.x, impulse.y, impulse.z, 0.0, 0.0, 0.0],
                carried_over: action.carried_over,
                imposed: [None; 6],
            }
        };
        let bodies = self.own.iter().zip(&self.actions).zip(&self.contacts);
        let motions: Vec<BodyMotion> = bodies.map(motion).collect();
        self.resolved.add_contact_force(&motions, &mut self.flow, dt, transport);
        self.flow.step(dt, transport).unwrap();
        self.actions =
            self.resolved.impose_rigid_velocity(Some(&motions), &mut self.flow, dt, transport).unwrap();
        self.own.clone_from_slice(&self.resolved.bodies[..self.resolved.owned]);
    }
}
