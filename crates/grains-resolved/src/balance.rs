//! The balance of momentum of one body in a step: what it is moved by, and what it does to the fluid.

use crate::RigidBody;
use grains_geometry::{Mat3, Vec3};
use nalgebra::{Matrix6, Vector6};

/// What a body is moved by in a step; of six numbers the last three are those of rotation.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyMotion {
    /// Mass (kg).
    pub mass: f64,
    /// Inertia in the world frame (kg m²).
    pub inertia: Mat3,
    /// Density of the fluid over that of the body (-).
    pub density_ratio: f64,
    /// Momentum before the step (N s, N m s).
    pub momentum: [f64; 6],
    /// Impulse of contacts in the step (N s, N m s).
    pub contacts: [f64; 6],
    /// Impulse of weight and buoyancy in the step (N s, N m s).
    pub weight: [f64; 6],
    /// What the last step left to this one, [`Action::carried_over`].
    pub carried_over: [f64; 6],
    /// Components of velocity and angular velocity that are imposed (m/s, rad/s).
    pub imposed: [Option<f64>; 6],
}

/// What a body does to the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Action {
    /// Force (N).
    pub force: Vec3,
    /// Torque about the body's centre (N m).
    pub torque: Vec3,
    /// Momentum and angular momentum that the balance of this step leaves to the next (N s, N m s): E − C (m_f (U − Uⁿ) − m_f/m K_c).
    pub carried_over: [f64; 6],
}

impl BodyMotion {
    /// Inertia (m − m_f + C m_f, and of rotation) with a virtual mass C, and the momentum after the step without the flow.
    pub(crate) fn balance(&self, virtual_mass: f64) -> (Matrix6<f64>, Vector6<f64>) {
        let virtual_mass = virtual_mass * self.density_ratio;
        let share = 1.0 - self.density_ratio + virtual_mass;
        let six = Vector6::from_column_slice;
        let pushed = six(&self.weight) + six(&self.contacts) * (1.0 + virtual_mass);
        (self.six_by_six() * share, six(&self.momentum) * share + pushed - six(&self.carried_over))
    }

    /// Change of the velocities by contacts, were there no fluid outside: what is inside goes along.
    pub(crate) fn change_by_contacts(&self) -> Vector6<f64> {
        self.change(self.six_by_six(), Vector6::from_column_slice(&self.contacts))
    }

    /// Whether forces do not move the body.
    pub(crate) fn is_prescribed(&self) -> bool {
        self.imposed.iter().all(Option::is_some)
    }

    /// Velocities of a momentum; those imposed are what they are.
    pub(crate) fn solved(&self, matrix: Matrix6<f64>, right: Vector6<f64>) -> Vector6<f64> {
        solve(matrix, right, &self.imposed)
    }

    /// Change of the velocities by an impulse, which those imposed do not follow.
    pub(crate) fn change(&self, matrix: Matrix6<f64>, impulse: Vector6<f64>) -> Vector6<f64> {
        solve(matrix, impulse, &self.imposed.map(|given| given.map(|_| 0.0)))
    }

    /// Mass and inertia as one matrix.
    pub(crate) fn six_by_six(&self) -> Matrix6<f64> {
        let mut matrix = Matrix6::from_diagonal_element(self.mass);
        matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&self.inertia);
        matrix
    }
}

/// Velocities of a momentum, some of them given. NaN, which the next step reports, if the matrix has no inverse: inertia is
/// positive, so only NaN can make one such.
fn solve(mut matrix: Matrix6<f64>, mut right: Vector6<f64>, given: &[Option<f64>; 6]) -> Vector6<f64> {
    for (a, given) in given.iter().enumerate() {
        if let Some(given) = given {
            matrix.row_mut(a).fill(0.0);
            matrix[(a, a)] = 1.0;
            right[a] = *given;
        }
    }
    matrix.lu().solve(&right).unwrap_or_else(|| Vector6::repeat(f64::NAN))
}

/// Velocity and angular velocity of a body.
pub(crate) fn velocities(body: &RigidBody) -> Vector6<f64> {
    let (u, w) = (&body.velocity, &body.spin);
    Vector6::new(u.x, u.y, u.z, w.x, w.y, w.z)
}

impl Action {
    /// Force (N) and torque (N m) of the flow on a body of prescribed motion, over a step `dt` (s) before which `carried_over` was
    /// left: −J/Δt + (Eⁿ⁺¹ − Eⁿ)/Δt + m_f (Uⁿ⁺¹ − Uⁿ)/Δt, with the momentum m_f U of the fluid it displaces before and after.
    ///
    /// The force on the fluid also changes the momentum of the fluid inside, which that outside never had: E of the extrapolated
    /// velocities, and m_f U of what goes with the body.
    pub fn on_prescribed(&self, carried_over: &[f64; 6], displaced: [&[f64; 6]; 2], dt: f64) -> [Vec3; 2] {
        let [before, after] = displaced;
        let change = |k: usize| {
            Vec3::from_fn(|a, _| {
                (self.carried_over[k + a] - carried_over[k + a] + after[k + a] - before[k + a]) / dt
            })
        };
        [change(0) - self.force, change(3) - self.torque]
    }

    pub(crate) fn read(sums: &[f64; 12]) -> Self {
        let vector = |k: usize| Vec3::from_column_slice(&sums[k..k + 3]);
        Self { force: vector(0), torque: vector(3), carried_over: std::array::from_fn(|a| sums[6 + a]) }
    }
}
