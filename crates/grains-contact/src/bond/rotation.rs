//! Rotations by arithmetic alone.

use nalgebra::Vector3;

type Vec3 = Vector3<f64>;

/// A rotation, by the vector t of its axis and the tangent of half its angle (-).
#[derive(Clone, Copy, Debug)]
pub(super) struct Rotation {
    tangent: Vec3,
    scale: f64,
}

/// The rotation by this vector (rad).
///
/// With x half the angle, tan x = x (1 + x²/3 + 2x⁴/15 + 17x⁶/315) to x⁹: for steps of a tenth of a turn the angle is right to 2e-7. Whatever the angle,
/// lengths stay.
#[inline(always)]
pub(super) fn by(angle: Vec3) -> Rotation {
    let half = angle * 0.5;
    let square = half.norm_squared();
    let tangent = half * (1.0 + square * (1.0 / 3.0 + square * (2.0 / 15.0 + square * (17.0 / 315.0))));
    Rotation { tangent, scale: 2.0 / (1.0 + tangent.norm_squared()) }
}

impl Rotation {
    /// The vector turned: v + 2/(1 + t²) t × (v + t × v).
    #[inline(always)]
    pub(super) fn turned(&self, vector: &Vec3) -> Vec3 {
        vector + self.tangent.cross(&(vector + self.tangent.cross(vector))) * self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    #[test]
    fn it_is_that_of_its_angle_and_keeps_lengths() {
        let mut angle = Vec3::new(0.02, -0.05, 0.03);
        let vector = Vec3::new(0.3, 0.4, -0.8);
        for (times, error) in [(1.0, 1e-13), (3.0, 1e-10), (10.0, 1e-5)] {
            angle *= times;
            let turned = by(angle).turned(&vector);
            assert!((turned.norm() / vector.norm() - 1.0).abs() < 1e-15);
            let exact = Rotation3::new(angle) * vector;
            assert!((turned - exact).norm() < error, "{times}: {}", (turned - exact).norm());
            angle /= times;
        }
    }
}
