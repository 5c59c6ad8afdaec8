//! Rotation of rigid bodies: angular velocity from angular momentum, and free rotation over a step.

use grains_geometry::{Mat3, Rotation, Vec3};
use nalgebra::{Quaternion, Unit};

/// Angular velocity ω = R I⁻¹ Rᵀ L (rad/s) of an angular momentum (kg m²/s), all in the world frame.
#[inline]
pub(crate) fn angular_velocity(frame: &Mat3, inertia: &Vec3, momentum: &Vec3) -> Vec3 {
    frame * frame.tr_mul(momentum).component_div(inertia)
}

/// What no point of a body moves farther (m) than as it turns from one orientation to another about the centre of a ball of a radius
/// (m) that holds it.
///
/// A turn by θ moves points by up to 2 R sin(θ/2) = 4 R sin(θ/4) cos(θ/4), and changes the quaternion by 2 sin(θ/4).
#[inline(always)]
pub(crate) fn way_of_turn(radius: f64, before: &Rotation, after: &Rotation) -> f64 {
    2.0 * radius * (after.coords - before.coords).norm()
}

/// Some bodies that turn freely, each with a constant angular momentum: computed together, as one alone is a long
/// chain of numbers that wait for each other. What a body does is the same in every bit whichever others are there.
pub(crate) struct FreeRotors<const N: usize> {
    /// Real and imaginary parts of the orientations.
    w: [f64; N],
    q: [[f64; N]; 3],
    /// Angular momenta in the frames of the bodies (kg m²/s).
    body: [[f64; N]; 3],
    /// dt/2I (s/(kg m²)).
    rate: [[f64; N]; 3],
}

impl<const N: usize> Default for FreeRotors<N> {
    fn default() -> Self {
        Self { w: [1.0; N], q: [[0.0; N]; 3], body: [[0.0; N]; 3], rate: [[0.0; N]; 3] }
    }
}

impl<const N: usize> FreeRotors<N> {
    /// Puts a body with a momentum (world frame, kg m²/s) in a place, to turn for `dt` (s).
    #[inline]
    pub fn set(&mut self, n: usize, orientation: &Rotation, inertia: &Vec3, momentum: &Vec3, dt: f64) {
        let body = orientation.inverse_transform_vector(momentum);
        self.w[n] = orientation.w;
        for axis in 0..3 {
            self.q[axis][n] = orientation.imag()[axis];
            self.body[axis][n] = body[axis];
            self.rate[axis][n] = 0.5 * dt / inertia[axis];
        }
    }

    /// Turns all of them.
    ///
    /// The kinetic energy Σ L²/2I is split into its three principal axes; each sub-rotation conserves |L|
    /// exactly and the composition x y z y x is symmetric, so the map is second order, time-reversible and
    /// symplectic (Dullweber, Leimkuhler and McLachlan 1997). The sub-rotations use the Cayley map, which is
    /// itself second order and needs no transcendental function.
    pub fn rotate_freely(&mut self) {
        let Self { w, q, body, rate } = self;
        for (axis, share) in [(0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)] {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let (spin, rate) = (body[axis], rate[axis]);
            let ([mut body_u, mut body_v], [mut q_axis, mut q_u, mut q_v]) =
                ([body[u], body[v]], [q[axis], q[u], q[v]]);
            for n in 0..N {
                let half_angle = share * rate[n] * spin[n];
                let scale = 1.0 / (1.0 + half_angle * half_angle);
                let (cos, sin) = ((1.0 - half_angle * half_angle) * scale, 2.0 * half_angle * scale);
                // The body turns by the angle, so its momentum turns back in the body frame.
                (body_u[n], body_v[n]) =
                    (cos * body_u[n] + sin * body_v[n], cos * body_v[n] - sin * body_u[n]);
                // The product with 1 + half_angle e_axis; its length is taken out at the end.
                (w[n], q_axis[n]) = (w[n] - half_angle * q_axis[n], q_axis[n] + half_angle * w[n]);
                (q_u[n], q_v[n]) = (q_u[n] + half_angle * q_v[n], q_v[n] - half_angle * q_u[n]);
            }
            [body[u], body[v]] = [body_u, body_v];
            [q[axis], q[u], q[v]] = [q_axis, q_u, q_v];
        }
        for n in 0..N {
            let squares = w[n] * w[n] + q[0][n] * q[0][n] + q[1][n] * q[1][n] + q[2][n] * q[2][n];
            let scale = 1.0 / squares.sqrt();
            w[n] *= scale;
            q.iter_mut().for_each(|part| part[n] *= scale);
        }
    }

    /// Orientation of a body.
    #[inline]
    pub fn orientation(&self, n: usize) -> Rotation {
        Unit::new_unchecked(Quaternion::new(self.w[n], self.q[0][n], self.q[1][n], self.q[2][n]))
    }
}

/// The rotation matrix of an orientation.
#[inline]
pub(crate) fn frame(orientation: &Rotation) -> Mat3 {
    orientation.to_rotation_matrix().into_inner()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rotate_freely(orientation: &Rotation, inertia: &Vec3, momentum: &Vec3, dt: f64) -> Rotation {
        let mut tops = FreeRotors::<1>::default();
        tops.set(0, orientation, inertia, momentum, dt);
        tops.rotate_freely();
        tops.orientation(0)
    }

    #[test]
    fn a_body_turns_alike_alone_and_among_others() {
        let (inertia, momentum) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.3, -1.1, 0.7));
        let start = Rotation::from_euler_angles(0.3, 1.2, -0.4);
        let alone = rotate_freely(&start, &inertia, &momentum, 0.01);
        let mut tops = FreeRotors::<8>::default();
        for n in 0..7 {
            tops.set(n, &start, &(inertia * (1.0 + n as f64)), &momentum, 0.01);
        }
        tops.set(7, &start, &inertia, &momentum, 0.01);
        tops.rotate_freely();
        assert_eq!([tops.orientation(0), tops.orientation(7)], [alone, alone]);
        assert_ne!(tops.orientation(1), alone);
    }

    /// Turns of up to a whole one: no point goes farther, and one across the axis goes as far where the turn is small.
    #[test]
    fn no_point_goes_farther_than_the_way_of_a_turn() {
        let mut state = 11_u64;
        let mut number = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let mut vector = || Vec3::from_fn(|_, _| number());
        for k in 0..10_000 {
            let (before, way) = (Rotation::from_scaled_axis(vector() * 4.0), vector().normalize());
            let angle = std::f64::consts::TAU * f64::from(k + 1) / 10_000.0;
            // The quaternion goes on without a jump, as that of a body does.
            let turn = Rotation::from_axis_angle(&Unit::new_unchecked(way), angle);
            let after = Rotation::new_unchecked(turn.into_inner() * before.into_inner());
            let bound = way_of_turn(2.0, &before, &after);
            let point = before.inverse_transform_vector(&(vector().cross(&way).normalize() * 2.0));
            let gone = (after * point - before * point).norm();
            assert!(gone <= bound * (1.0 + 1e-12), "{angle}: {gone} beyond {bound}");
            assert!(gone >= bound * (0.25 * angle).cos() - 1e-12, "{angle}: {gone} of {bound}");
        }
    }

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
