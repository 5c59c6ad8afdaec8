//! Between the particles of the granular phase and the bodies in the fluid (Wachs et al. 2009, steps 4 to 6).

use crate::{Action, BodyMotion, Form, RigidBody};
use grains_dem::{CARGO_LENGTH, Cargo, Catalogue, Dem, Particles};
use grains_geometry::{Mat3, Vec3};

/// What a particle carries through a step of the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlowLink {
    /// Force of the flow in the last step (N), buoyancy apart.
    pub force: Vec3,
    /// Torque of the flow in the last step (N m).
    pub torque: Vec3,
    /// Impulse of contacts since then (N s); of a body of prescribed motion the momentum m_f U of the fluid
    /// it displaced then.
    pub impulse: Vec3,
    /// Angular impulse of contacts since then (N m s), or that angular momentum.
    pub angular_impulse: Vec3,
    /// What the last step left to the next, [`Action::carried_over`] (N s, N m s).
    pub carried_over: [Vec3; 2],
}

impl FlowLink {
    /// The link as the cargo of its particle.
    pub fn write(&self) -> Cargo {
        let mut cargo = [0.0; CARGO_LENGTH];
        let [linear, angular] = self.carried_over;
        let parts = [self.force, self.torque, self.impulse, self.angular_impulse, linear, angular];
        const { assert!(CARGO_LENGTH >= 18, "a link is eighteen numbers") };
        cargo.chunks_exact_mut(3).zip(parts).for_each(|(to, from)| to.copy_from_slice(from.as_slice()));
        cargo
    }

    /// The cargo of a body whose motion was prescribed, and which moves freely from now on.
    pub fn released(cargo: &Cargo) -> Cargo {
        Self { impulse: Vec3::zeros(), angular_impulse: Vec3::zeros(), ..Self::read(cargo) }.write()
    }

    /// Reads what [`FlowLink::write`] wrote.
    pub fn read(cargo: &Cargo) -> Self {
        let vector = |k: usize| Vec3::new(cargo[k], cargo[k + 1], cargo[k + 2]);
        Self {
            force: vector(0),
            torque: vector(3),
            impulse: vector(6),
            angular_impulse: vector(9),
            carried_over: [vector(12), vector(15)],
        }
    }
}

/// The fluid as free bodies feel it.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings {
    /// Density of the fluid (kg/m³).
    pub density: f64,
    /// Axes along which the flow varies; bodies neither move along the others nor turn out of their plane.
    pub active: [bool; 3],
}

/// Own particles as bodies.
pub fn bodies(particles: &Particles, catalogue: &Catalogue) -> Vec<RigidBody> {
    let body = |i: usize| {
        let body = &particles.bodies[i];
        RigidBody {
            id: particles.ids[i],
            form: Form::Shape(body.kind.shape),
            scale: body.radius / catalogue.shape(body.kind).bounding_radius,
            center: body.position,
            rotation: particles.frames.get(i).copied().unwrap_or_else(Mat3::identity),
            velocity: body.velocity,
            spin: body.angular_velocity,
        }
    };
    (0..particles.owned).map(body).collect()
}

impl Surroundings {
    /// Adds the flow's last force and torque and buoyancy to the loads of the own particles, between the contact forces
    /// and the advance of each of their steps.
    pub fn add_loads(&self, dem: &mut Dem) {
        let (rates, catalogue) = (dem.setup.parameters, &dem.setup.catalogue);
        let Particles { bodies, loads, cargo, .. } = &mut dem.particles;
        for ((load, cargo), body) in loads.iter_mut().zip(cargo).zip(bodies) {
            if body.is_prescribed() {
                continue;
            }
            let mut link = FlowLink::read(cargo);
            let share = self.density / catalogue.densities[body.kind.material as usize];
            for a in (0..3).filter(|&a| !self.active[a]) {
                load.force[a] = 0.0;
                (0..3).filter(|&b| b != a).for_each(|b| load.torque[b] = 0.0);
            }
            link.impulse += load.force * rates.dt;
            link.angular_impulse += load.torque * rates.dt;
            // Weight is added as the particles move.
            load.force += link.force + (self.weight(&rates.gravity, share) - rates.gravity) * body.mass;
            load.torque += link.torque;
            *cargo = link.write();
        }
    }

    /// Weight less buoyancy per mass (m/s²) of a body, with the density of the fluid over its own; none along axes that the flow does
    /// not vary along.
    fn weight(&self, gravity: &Vec3, density_ratio: f64) -> Vec3 {
        Vec3::from_fn(|a, _| if self.active[a] { (1.0 - density_ratio) * gravity[a] } else { 0.0 })
    }

    /// What the own bodies are moved by in a step of the fluid `dt` (s) that their particles have just gone through.
    pub fn motions(&self, dem: &Dem, dt: f64) -> Vec<BodyMotion> {
        let particles = &dem.particles;
        let motion = |i: usize| {
            let body = &particles.bodies[i];
            let link = FlowLink::read(&particles.cargo[i]);
            let inertia = world_inertia(particles, i, &dem.setup.catalogue);
            let density_ratio = self.density / dem.setup.catalogue.densities[body.kind.material as usize];
            let weight = self.weight(&dem.setup.parameters.gravity, density_ratio) * (body.mass * dt);
            let before = particles.half_velocity[i] * body.mass - link.impulse - weight - link.force * dt;
            let spun = angular_momentum(dem, i, &inertia) - link.angular_impulse - link.torque * dt;
            let mut imposed = [None; 6];
            for a in (0..3).filter(|&a| !self.active[a]) {
                imposed[a] = Some(0.0);
                (0..3).filter(|&b| b != a).for_each(|b| imposed[3 + b] = Some(0.0));
            }
            let mut contacts = six(&link.impulse, &link.angular_impulse);
            if body.is_prescribed() {
                imposed = six(&body.velocity, &body.angular_velocity).map(Some);
                contacts = [0.0; 6];
            }
            BodyMotion {
                mass: body.mass,
                inertia,
                density_ratio,
                momentum: six(&before, &spun),
                contacts,
                weight: six(&weight, &Vec3::zeros()),
                carried_over: six(&link.carried_over[0], &link.carried_over[1]),
                imposed,
            }
        };
        (0..particles.owned).map(motion).collect()
    }

    /// Lets particles that stay where they are know what the flow did to them in a step of the fluid `dt` (s).
    pub fn note(dem: &mut Dem, actions: &[Action], dt: f64) {
        for (cargo, action) in dem.particles.cargo.iter_mut().zip(actions) {
            let [linear, angular] = FlowLink::read(cargo).carried_over;
            let [force, torque] = action.on_prescribed(&six(&linear, &angular), [&[0.0; 6]; 2], dt);
            let carried_over = [0, 3].map(|k| Vec3::from_column_slice(&action.carried_over[k..k + 3]));
            *cargo = FlowLink { force, torque, carried_over, ..FlowLink::default() }.write();
        }
    }

    /// Gives the own particles the velocities of their bodies, and the force of the flow that led to them.
    pub fn correct(&self, dem: &mut Dem, bodies: &[RigidBody], actions: &[Action], dt: f64) {
        let catalogue = &dem.setup.catalogue;
        for (i, (body, action)) in bodies.iter().zip(actions).enumerate() {
            let inertia = world_inertia(&dem.particles, i, catalogue);
            let old = angular_momentum(dem, i, &inertia);
            let new = inertia * body.spin;
            let particles = &mut dem.particles;
            let mut link = FlowLink::read(&particles.cargo[i]);
            let carried_over = [0, 3].map(|k| Vec3::from_column_slice(&action.carried_over[k..k + 3]));
            if particles.bodies[i].is_prescribed() {
                let own = &particles.bodies[i];
                let share = self.density / catalogue.densities[own.kind.material as usize];
                let (before, after) = (
                    six(&link.impulse, &link.angular_impulse),
                    six(&(body.velocity * (share * own.mass)), &(new * share)),
                );
                let left = six(&link.carried_over[0], &link.carried_over[1]);
                let [force, torque] = action.on_prescribed(&left, [&before, &after], dt);
                let [impulse, angular_impulse] = [0, 3].map(|k| Vec3::from_column_slice(&after[k..k + 3]));
                particles.cargo[i] =
                    FlowLink { force, torque, impulse, angular_impulse, carried_over }.write();
                continue;
            }
            let kick = body.velocity - particles.half_velocity[i];
            link.force += kick * (particles.bodies[i].mass / dt);
            link.torque += (new - old) / dt;
            (link.impulse, link.angular_impulse) = (Vec3::zeros(), Vec3::zeros());
            link.carried_over = carried_over;
            particles.cargo[i] = link.write();
            particles.half_velocity[i] = body.velocity;
            particles.bodies[i].velocity = body.velocity;
            particles.bodies[i].angular_velocity = body.spin;
            particles.half_spin[i] =
                if catalogue.shape(particles.bodies[i].kind).is_sphere() { body.spin } else { new };
        }
    }
}

fn six(linear: &Vec3, angular: &Vec3) -> [f64; 6] {
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}

/// Inertia of a particle in the world frame (kg m²).
fn world_inertia(particles: &Particles, i: usize, catalogue: &Catalogue) -> Mat3 {
    let principal = Mat3::from_diagonal(&catalogue.inertia(&particles.bodies[i]));
    particles.frames.get(i).map_or(principal, |frame| frame * principal * frame.transpose())
}

/// Angular momentum (kg m²/s) half a step before the position.
fn angular_momentum(dem: &Dem, i: usize, inertia: &Mat3) -> Vec3 {
    let (spin, kind) = (dem.particles.half_spin[i], dem.particles.bodies[i].kind);
    // Spheres keep their angular velocity.
    if dem.setup.catalogue.shape(kind).is_sphere() { inertia * spin } else { spin }
}
