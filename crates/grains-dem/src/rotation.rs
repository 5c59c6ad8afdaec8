//! Rotation of a rigid body: kinetic energy from angular momentum, and free rotation over a step.

use grains_geometry::{Mat3, Rotation, Vec3};
use nalgebra::{Quaternion, Unit};

/// Angular velocity ω = R I⁻¹ Rᵀ L (rad/s) of an angular momentum (kg m²/s), all in the world frame.
#[inline]
pub(crate) fn angular_velocity(frame: &Mat3, inertia: &Vec3, momentum: &Vec3) -> Vec3 {
    frame * frame.tr_mul(momentum).component_div(inertia)
}

/// Orientation after turning freely for `dt` (s) with a constant angular momentum (world frame, kg m²/s).
///
/// The kinetic energy Σ L²/2I is split into its three principal axes; each sub-rotation conserves |L|
/// exactly and the composition x y z y x is symmetric, so the map is second order, time-reversible and
/// symplectic (Dullweber, Leimkuhler and McLachlan 1997). The sub-rotations use the Cayley map, which is
/// itself second order and needs no transcendental function.
pub(crate) fn rotate_freely(orientation: &Rotation, inertia: &Vec3, momentum: &Vec3, dt: f64) -> Rotation {
    let (mut w, mut q) = (orientation.w, Vec3::from(orientation.imag()));
    let mut body = orientation.inverse_transform_vector(momentum);
    let rate = Vec3::repeat(0.5 * dt).component_div(inertia);
    for (axis, share) in [(0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)] {
        let half_angle = share * rate[axis] * body[axis];
        let scale = 1.0 / (1.0 + half_angle * half_angle);
        let (cos, sin) = ((1.0 - half_angle * half_angle) * scale, 2.0 * half_angle * scale);
        // The body turns by the angle, so its momentum turns back in the body frame.
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        (body[u], body[v]) = (cos * body[u] + sin * body[v], cos * body[v] - sin * body[u]);
        // The product with 1 + half_angle e_axis; its length is taken out at the end.
        (w, q[axis]) = (w - half_angle * q[axis], q[axis] + half_angle * w);
        (q[u], q[v]) = (q[u] + half_angle * q[v], q[v] - half_angle * q[u]);
    }
    Unit::new_normalize(Quaternion::from_parts(w, q))
}

/// The rotation matrix of an orientation.
#[inline]
pub(crate) fn frame(orientation: &Rotation) -> Mat3 {
    orientation.to_rotation_matrix().into_inner()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Euler's top with I = (1, 2, 3) and ω0 = (1, 0, 1): reference values of Jacobi's elliptic functions.
    fn error_at(steps: usize) -> f64 {
        let inertia = Vec3::new(1.0, 2.0, 3.0);
        let momentum = inertia.component_mul(&Vec3::new(1.0, 0.0, 1.0));
        let (mut q, dt) = (Rotation::identity(), 5.0 / steps as f64);
        for _ in 0..steps {
            q = rotate_freely(&q, &inertia, &momentum, dt);
        }
        let omega = q.inverse_transform_vector(&momentum).component_div(&inertia);
        (omega - Vec3::new(-0.16435043, -0.98640202, 0.82199170)).norm()
    }

    #[test]
    fn the_free_top_follows_the_closed_solution_with_order_two() {
        let (coarse, fine) = (error_at(500), error_at(1000));
        let order = (coarse / fine).log2();
        assert!((1.95..2.05).contains(&order) && fine < 1e-4, "errors {coarse:e}, {fine:e}, order {order}");
    }

    #[test]
    fn the_free_top_keeps_energy_and_momentum_over_a_hundred_periods() {
        let inertia = Vec3::new(1.0, 2.0, 3.0);
        let momentum = Vec3::new(1.0, 0.0, 3.0);
        let (mut q, dt) = (Rotation::identity(), 6.93566754103174 / 1000.0);
        let mut worst: f64 = 0.0;
        for _ in 0..100_000 {
            q = rotate_freely(&q, &inertia, &momentum, dt);
            let body = q.inverse_transform_vector(&momentum);
            worst = worst.max((0.5 * body.component_div(&inertia).dot(&body) / 2.0 - 1.0).abs());
        }
        assert!(worst < 1e-4, "relative energy error {worst:e}");
        assert!((q.quaternion().norm() - 1.0).abs() < 1e-12);
    }
}
