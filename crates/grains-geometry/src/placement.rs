//! How one body lies in the frame of another.

use crate::{Mat3, Vec3};

/// Placement of one core in the frame of another: x = matrix p + translation.
///
/// `matrix` is a rotation times a uniform scale, so bodies of one shape may differ in size.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// Rotation times uniform scale (-).
    pub matrix: Mat3,
    /// Position of the core's origin (m).
    pub translation: Vec3,
}

impl Placement {
    /// The placed point: matrix p + translation (m).
    #[inline(always)]
    pub fn apply(&self, point: &Vec3) -> Vec3 {
        self.matrix * point + self.translation
    }

    /// The placement of the first core in the frame of the second.
    pub fn inverse(&self) -> Self {
        let matrix = self.matrix.transpose() / self.matrix.column(0).norm_squared();
        Self { matrix, translation: -(matrix * self.translation) }
    }
}
