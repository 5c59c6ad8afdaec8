//! Rotations about axes, the same to the last bit on all machines.
//!
//! The C library may compute sines otherwise on another machine; those of `libm` are plain arithmetic.

use crate::{Rotation, Vec3};
use nalgebra::{Quaternion, Unit};

/// Rotation by an angle (rad) about an axis of unit length: the quaternion (cos φ/2, a sin φ/2).
pub fn rotation_about(axis: &Vec3, angle: f64) -> Rotation {
    let (sine, cosine) = libm::sincos(0.5 * angle);
    Unit::new_normalize(Quaternion::from_parts(cosine, axis * sine))
}

/// Rotation by a vector (rad): about its direction by its length.
pub fn rotation_by(vector: &Vec3) -> Rotation {
    match vector.try_normalize(0.0) {
        Some(axis) => rotation_about(&axis, vector.norm()),
        None => Rotation::identity(),
    }
}

/// The shortest rotation of the z-axis onto a direction of unit length: the quaternion (1 + z·d, z × d), normalised.
pub fn rotation_onto(direction: &Vec3) -> Rotation {
    let quaternion = Quaternion::from_parts(1.0 + direction.z, Vec3::z().cross(direction));
    match quaternion.norm() > 1e-8 {
        true => Unit::new_normalize(quaternion),
        false => Rotation::new_unchecked(Quaternion::from_parts(0.0, Vec3::x())),
    }
}

/// The vector (rad) of the shorter way of a rotation.
pub fn rotation_vector(rotation: &Rotation) -> Vec3 {
    let (vector, real) = (rotation.imag(), rotation.w);
    let sine = vector.norm();
    if sine == 0.0 {
        return Vec3::zeros();
    }
    let angle = 2.0 * libm::atan2(sine, real.abs());
    vector * (angle / sine).copysign(real)
}

/// Angle between two vectors (rad), 0 to π.
pub(crate) fn angle_between(a: &Vec3, b: &Vec3) -> f64 {
    libm::atan2(a.cross(b).norm(), a.dot(b))
}

#[cfg(test)]
mod tests {
    use super::{angle_between, rotation_about, rotation_by, rotation_onto, rotation_vector};
    use crate::{Rotation, Vec3};
    use nalgebra::Unit;
    use std::f64::consts::PI;

    #[test]
    fn rotations_are_those_of_nalgebra() {
        for k in 0..200 {
            let t = f64::from(k);
            let axis = Vec3::new((1.3 * t).sin(), (0.7 * t).cos(), (0.1 * t).sin() + 0.2);
            let (unit, angle) = (Unit::new_normalize(axis), 0.05 * t - 5.0);
            let (ours, theirs) = (rotation_about(&unit, angle), Rotation::from_axis_angle(&unit, angle));
            assert!(ours.angle_to(&theirs) < 1e-7, "{axis:?} by {angle}");
            assert!((ours.coords - theirs.coords).norm() < 1e-15);
            assert!((rotation_vector(&ours) - theirs.scaled_axis()).norm() < 1e-14);
            assert!((rotation_by(&(unit.scale(angle))).coords - theirs.coords).norm() < 1e-15);
            let turned = rotation_onto(&unit) * Vec3::z();
            assert!((turned - unit.into_inner()).norm() < 1e-15);
            assert!((angle_between(&axis, &Vec3::z()) - axis.angle(&Vec3::z())).abs() < 1e-14);
        }
        assert_eq!(rotation_by(&Vec3::zeros()), Rotation::identity());
        assert_eq!(rotation_vector(&Rotation::identity()), Vec3::zeros());
        assert_eq!(rotation_onto(&-Vec3::z()) * Vec3::z(), -Vec3::z());
        assert_eq!(angle_between(&Vec3::x(), &-Vec3::x()), PI);
    }
}
