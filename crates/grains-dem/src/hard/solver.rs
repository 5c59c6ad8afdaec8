//! What one contact does to its bodies: an impulse and a relocation. Clones are left to their owners.

use super::contacts::{Counterpart, HardContact};
use super::model::HardModel;
use crate::catalogue::Catalogue;
use crate::particles::Particles;
use crate::rotation::angular_velocity;
use grains_contact::{Impact, Mobility};
use grains_domain::{ExactSum, Quantum};
use grains_geometry::{Mat3, Vec3};

/// Applies impulses and relocations to the bodies of contacts.
pub(crate) struct ContactSolver<'a> {
    pub(crate) particles: &'a mut Particles,
    pub(crate) catalogue: &'a Catalogue,
    /// Force (N) and torque (N m) on each wall.
    pub(crate) wall_loads: &'a mut [[ExactSum; 6]],
    /// Quantum of the positions.
    pub(crate) positions: &'a Quantum,
    /// Time step (s): the loads reported are impulses over it.
    pub(crate) dt: f64,
}

/// What a contact came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// The bodies did not approach.
    Separating,
    /// An impulse with the restitution of the pair.
    Collision,
    /// An impulse without restitution: the bodies rest on each other.
    Rest,
}

impl ContactSolver<'_> {
    /// Gives both bodies of a contact their impulse.
    pub(crate) fn collide(&mut self, contact: &HardContact, model: &HardModel) -> Outcome {
        let other = match contact.counterpart {
            Counterpart::Particle(b, arm) => self.velocity_at(b, &arm),
            Counterpart::Wall { velocity, .. } => velocity,
        };
        let velocity = other - self.velocity_at(contact.a, &contact.arm);
        let approach = -velocity.dot(&contact.normal);
        if approach <= 0.0 {
            return Outcome::Separating;
        }
        let rests = approach < model.rest_speed;
        let restitution = if rests { 0.0 } else { contact.restitution };
        let impact = Impact { normal: contact.normal, velocity, restitution, friction: contact.friction };
        let mut mobility = self.mobility(contact.a, contact.arm);
        if let Counterpart::Particle(b, arm) = contact.counterpart {
            mobility += self.mobility(b, arm);
        }
        let impulse = model.scheme.impulse(&impact, &mobility);
        self.push(contact.a, &contact.arm, &-impulse);
        match contact.counterpart {
            Counterpart::Particle(b, arm) => self.push(b, &arm, &impulse),
            Counterpart::Wall { wall, point, .. } => {
                let force = impulse / self.dt;
                let sums = self.wall_loads[wall as usize].iter_mut();
                sums.zip(force.iter().chain(&point.cross(&force))).for_each(|(sum, x)| *sum += *x);
            }
        }
        if rests { Outcome::Rest } else { Outcome::Collision }
    }

    /// Moves both bodies of a contact apart by what is left of their overlap after earlier relocations (m).
    pub(crate) fn relocate(&self, contact: &HardContact, relocations: &mut [Vec3]) {
        let a = contact.a as usize;
        let mass = |i: usize| self.particles.bodies[i].contact_mass();
        let (moved, share) = match contact.counterpart {
            Counterpart::Particle(b, _) => {
                let (m1, m2) = (mass(a), mass(b as usize));
                (relocations[a] - relocations[b as usize], m2 / (m1 + m2))
            }
            Counterpart::Wall { .. } => (relocations[a], 1.0),
        };
        let left = contact.overlap + moved.dot(&contact.normal);
        if left > 0.0 {
            let round = |way: f64| (contact.normal * way).map(|x| self.positions.round(x));
            relocations[a] -= round(left * share);
            if let Counterpart::Particle(b, _) = contact.counterpart {
                relocations[b as usize] += round(left * (1.0 - share));
            }
        }
    }

    /// Velocity of a point of a particle, `arm` from its centre of mass (m/s).
    fn velocity_at(&self, i: u32, arm: &Vec3) -> Vec3 {
        let body = &self.particles.bodies[i as usize];
        body.velocity + body.angular_velocity.cross(arm)
    }

    fn mobility(&self, i: u32, arm: Vec3) -> Mat3 {
        let body = &self.particles.bodies[i as usize];
        if body.is_prescribed() {
            return Mat3::zeros();
        }
        let inverse = self.catalogue.inertia(body).map(|moment| 1.0 / moment);
        let inverse_inertia = match self.particles.frames.get(i as usize) {
            Some(frame) if !self.catalogue.shape(body.kind).is_sphere() => {
                frame * Mat3::from_diagonal(&inverse) * frame.transpose()
            }
            _ => Mat3::from_diagonal(&inverse),
        };
        Mobility { inverse_mass: 1.0 / body.mass, inverse_inertia, arm }.matrix()
    }

    /// Changes the motion of an owned particle by an impulse (N s) at `arm` from its centre of mass.
    fn push(&mut self, i: u32, arm: &Vec3, impulse: &Vec3) {
        let i = i as usize;
        let particles = &mut *self.particles;
        if i >= particles.owned {
            return;
        }
        let turn = arm.cross(impulse);
        let load = &mut particles.loads[i];
        load.force += impulse / self.dt;
        load.torque += turn / self.dt;
        let body = &mut particles.bodies[i];
        if body.is_prescribed() {
            return;
        }
        let gain = impulse * (1.0 / body.mass);
        body.velocity += gain;
        particles.half_velocity[i] += gain;
        let inertia = self.catalogue.inertia(body);
        if self.catalogue.shape(body.kind).is_sphere() {
            let gain = turn.component_div(&inertia);
            body.angular_velocity += gain;
            particles.half_spin[i] += gain;
        } else {
            particles.half_spin[i] += turn;
            body.angular_velocity = angular_velocity(&particles.frames[i], &inertia, &particles.half_spin[i]);
        }
    }
}
