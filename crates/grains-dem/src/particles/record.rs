//! The one packed form of a particle: what migrates, and what a checkpoint holds.

use super::body::{Body, Kind};
use grains_geometry::{Rotation, Vec3};
use nalgebra::{Quaternion, Unit};

/// The whole state of a particle, apart from its contact history.
#[derive(Clone, Copy, Debug)]
pub struct ParticleRecord {
    /// Identity, below 2⁵³.
    pub id: u64,
    /// Mechanical state.
    pub body: Body,
    /// Orientation, body to world.
    pub orientation: Rotation,
    /// Velocity half a step before (m/s).
    pub half_velocity: Vec3,
    /// Angular velocity (sphere, rad/s) or angular momentum (kg m²/s) half a step before.
    pub half_spin: Vec3,
    /// Sides of the flow planes.
    pub sides: u32,
    /// Temperature (K), 0 where particles have none.
    pub temperature: f64,
}

impl ParticleRecord {
    /// Number of f64 in a packed record.
    pub const LENGTH: usize = 4 + 3 * 5 + 4 + 2 + 1;

    /// Appends the record to a message.
    pub fn write(&self, message: &mut Vec<f64>) {
        debug_assert!(self.id < 1 << 53, "identities are exact in f64 up to 2^53");
        let b = &self.body;
        message.extend([
            self.id as f64,
            f64::from(b.kind.shape),
            f64::from(b.kind.material),
            f64::from(self.sides),
        ]);
        for v in [b.position, b.velocity, b.angular_velocity, self.half_velocity, self.half_spin] {
            message.extend([v.x, v.y, v.z]);
        }
        let q = self.orientation.quaternion();
        message.extend([q.w, q.i, q.j, q.k, b.radius, b.mass, self.temperature]);
    }

    /// Reads a record written by [`ParticleRecord::write`].
    pub fn read(message: &[f64]) -> Self {
        let vector = |k: usize| Vec3::new(message[k], message[k + 1], message[k + 2]);
        let q = &message[19..23];
        Self {
            id: message[0] as u64,
            sides: message[3] as u32,
            body: Body {
                position: vector(4),
                velocity: vector(7),
                angular_velocity: vector(10),
                radius: message[23],
                mass: message[24],
                kind: Kind { shape: message[1] as u16, material: message[2] as u16 },
                prescribed: 0,
            },
            half_velocity: vector(13),
            half_spin: vector(16),
            temperature: message[25],
            orientation: Unit::new_unchecked(Quaternion::new(q[0], q[1], q[2], q[3])),
        }
    }
}

/// Number of f64 that create a clone: what never changes, and the first update.
pub(crate) const CLONE_LENGTH: usize = FIXED_LENGTH + UPDATE_LENGTH;
const FIXED_LENGTH: usize = 5;

/// Where an image of a particle is, and how it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Image {
    /// From the particle to it (m).
    pub(crate) shift: Vec3,
    /// Axis along which it moves otherwise, and by how much (m/s).
    pub(crate) sliding: Option<(usize, f64)>,
}

impl Image {
    /// Position (m) and velocity (m/s) of the image of a body; exact.
    #[inline(always)]
    pub(crate) fn motion_of(&self, body: &Body) -> (Vec3, Vec3) {
        let mut velocity = body.velocity;
        if let Some((axis, speed)) = self.sliding {
            velocity[axis] += speed;
        }
        (body.position + self.shift, velocity)
    }

    /// The image of which this particle is one.
    pub(crate) fn opposite(&self) -> Self {
        Self { shift: -self.shift, sliding: self.sliding.map(|(axis, speed)| (axis, -speed)) }
    }
}

/// Appends what a neighbour needs to create a clone, an image of the particle.
pub(crate) fn write_clone(
    id: u64,
    body: &Body,
    orientation: &Rotation,
    image: &Image,
    message: &mut Vec<f64>,
) {
    message.extend([
        id as f64,
        f64::from(body.kind.shape),
        f64::from(body.kind.material),
        body.radius,
        body.mass,
    ]);
    message.extend(clone_update(body, orientation, image));
}

/// Reads a clone written by [`write_clone`].
pub(crate) fn read_clone(message: &[f64]) -> (u64, Body, Rotation) {
    let mut body = Body {
        position: Vec3::zeros(),
        radius: message[3],
        velocity: Vec3::zeros(),
        mass: message[4],
        angular_velocity: Vec3::zeros(),
        kind: Kind { shape: message[1] as u16, material: message[2] as u16 },
        prescribed: 0,
    };
    let clone_update = &message[FIXED_LENGTH..];
    read_motion(&mut body, clone_update);
    (message[0] as u64, body, read_orientation(clone_update))
}

/// Largest length of the record of a clone: position, velocity, angular velocity, orientation.
pub(crate) const UPDATE_LENGTH: usize = 13;
/// Those without orientation, of spheres.
pub(crate) const SPHERE_UPDATE_LENGTH: usize = 9;

/// All that changes of a clone, an image of the particle, between rebuilds; the orientation (w, x, y, z) comes last.
#[inline(always)]
pub(crate) fn clone_update(body: &Body, orientation: &Rotation, image: &Image) -> [f64; UPDATE_LENGTH] {
    let ((x, v), w) = (image.motion_of(body), body.angular_velocity);
    let q = orientation.quaternion();
    [x.x, x.y, x.z, v.x, v.y, v.z, w.x, w.y, w.z, q.w, q.i, q.j, q.k]
}

/// Reads the motion out of [`clone_update`].
#[inline]
pub(crate) fn read_motion(body: &mut Body, clone_update: &[f64]) {
    body.position = Vec3::new(clone_update[0], clone_update[1], clone_update[2]);
    body.velocity = Vec3::new(clone_update[3], clone_update[4], clone_update[5]);
    body.angular_velocity = Vec3::new(clone_update[6], clone_update[7], clone_update[8]);
}

/// Reads the orientation out of [`clone_update`], without renormalising: the bits must not change.
#[inline]
pub(crate) fn read_orientation(clone_update: &[f64]) -> Rotation {
    Unit::new_unchecked(Quaternion::new(
        clone_update[9],
        clone_update[10],
        clone_update[11],
        clone_update[12],
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> ParticleRecord {
        let v = |k: f64| Vec3::new(k, k + 0.25, k + 0.5);
        ParticleRecord {
            id: (1 << 53) - 1,
            body: Body {
                position: v(1.0),
                radius: 0.1,
                velocity: v(2.0),
                mass: 0.3,
                angular_velocity: v(3.0),
                kind: Kind { shape: 7, material: 2 },
                prescribed: 0,
            },
            orientation: Rotation::from_euler_angles(0.1, 0.2, 0.3),
            half_velocity: v(4.0),
            half_spin: v(5.0),
            sides: u32::MAX,
            temperature: 293.15,
        }
    }

    #[test]
    fn a_record_survives_packing_bit_for_bit() {
        let (record, mut message, mut again) = (sample(), Vec::new(), Vec::new());
        record.write(&mut message);
        assert_eq!(message.len(), ParticleRecord::LENGTH);
        ParticleRecord::read(&message).write(&mut again);
        assert_eq!(message, again);
    }

    #[test]
    fn a_clone_arrives_shifted_and_faster_and_otherwise_unchanged() {
        let (record, mut message) = (sample(), Vec::new());
        let image = Image { shift: Vec3::new(-1.0, 0.0, 2.0), sliding: Some((1, 0.5)) };
        write_clone(record.id, &record.body, &record.orientation, &image, &mut message);
        assert_eq!(message.len(), CLONE_LENGTH);
        let (id, body, orientation) = read_clone(&message);
        let velocity = record.body.velocity + Vec3::new(0.0, 0.5, 0.0);
        assert_eq!((id, body.velocity, body.mass), (record.id, velocity, record.body.mass));
        assert_eq!(body.position, record.body.position + Vec3::new(-1.0, 0.0, 2.0));
        assert_eq!(orientation, record.orientation);
    }
}
