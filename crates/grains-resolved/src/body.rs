//! A rigid body in the fluid.

use grains_geometry::{Mat3, Shape, Vec3};

/// Numbers of a body in a message between ranks.
pub(crate) const RECORD: usize = 21;

/// What the surface of a body is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Form {
    /// That of a shape with this number.
    Shape(u16),
    /// That of a wall with this number: all ranks have it.
    Wall(u16),
}

/// A rigid body, or a periodic image or ghost of one that another rank owns; or a wall.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidBody {
    /// Id of the particle; below 2⁵³.
    pub id: u64,
    /// Its surface.
    pub form: Form,
    /// Factor on all lengths of the shape (-).
    pub scale: f64,
    /// Centre of mass (m); may lie beyond the box, as that of an image.
    pub center: Vec3,
    /// Rotation from the body frame to the world.
    pub rotation: Mat3,
    /// Velocity of the centre of mass (m/s).
    pub velocity: Vec3,
    /// Angular velocity (rad/s).
    pub spin: Vec3,
}

impl RigidBody {
    /// Velocity (m/s) of the body at an arm (m) from its centre: U + ω × r.
    #[inline]
    pub fn velocity_at(&self, arm: &Vec3) -> Vec3 {
        self.velocity + self.spin.cross(arm)
    }

    /// Component of that velocity (m/s).
    #[inline]
    pub(crate) fn component_at(&self, a: usize, arm: &Vec3) -> f64 {
        let [b, c] = others(a);
        self.velocity[a] + self.spin[b] * arm[c] - self.spin[c] * arm[b]
    }

    /// Whether it is a wall.
    pub fn is_wall(&self) -> bool {
        matches!(self.form, Form::Wall(_))
    }

    /// Its shape, of which a wall has none.
    pub fn shape<'a>(&self, shapes: &'a [Shape]) -> Option<&'a Shape> {
        match self.form {
            Form::Shape(number) => Some(&shapes[usize::from(number)]),
            Form::Wall(_) => None,
        }
    }

    /// Radius (m) of a ball about the centre that holds the body.
    #[inline]
    pub fn radius(&self, shapes: &[Shape]) -> f64 {
        self.shape(shapes).map_or(f64::INFINITY, |shape| self.scale * shape.bounding_radius)
    }

    /// Whether a point (m) lies in it; none does in a wall.
    pub(crate) fn holds(&self, point: &Vec3, shapes: &[Shape]) -> bool {
        let from = point - self.center;
        let local = self.rotation.tr_mul(&from) / self.scale;
        from.norm() < self.radius(shapes) && self.shape(shapes).is_some_and(|shape| shape.contains(&local))
    }

    /// Writes a body that is no wall.
    pub(crate) fn write(&self, to: &mut Vec<f64>) {
        let (Form::Shape(number) | Form::Wall(number)) = self.form;
        to.extend([self.id as f64, f64::from(number), self.scale]);
        to.extend_from_slice(self.center.as_slice());
        to.extend_from_slice(self.rotation.as_slice());
        to.extend_from_slice(self.velocity.as_slice());
        to.extend_from_slice(self.spin.as_slice());
    }

    pub(crate) fn read(record: &[f64]) -> Self {
        Self {
            id: record[0] as u64,
            form: Form::Shape(record[1] as u16),
            scale: record[2],
            center: Vec3::from_column_slice(&record[3..6]),
            rotation: Mat3::from_column_slice(&record[6..15]),
            velocity: Vec3::from_column_slice(&record[15..18]),
            spin: Vec3::from_column_slice(&record[18..21]),
        }
    }
}

/// Component of U + ω × r at an arm r (m) from the centre of a body that moves with (U, ω).
#[inline]
pub(crate) fn component_at(velocities: &[f64; 6], a: usize, arm: &Vec3) -> f64 {
    let [b, c] = others(a);
    velocities[a] + velocities[3 + b] * arm[c] - velocities[3 + c] * arm[b]
}

/// The axes b, c for which e_a · (ω × r) = ω_b r_c − ω_c r_b.
pub(crate) fn others(a: usize) -> [usize; 2] {
    [(a + 1) % 3, (a + 2) % 3]
}

/// Unit vector along an axis.
pub(crate) fn unit(axis: usize) -> Vec3 {
    Vec3::ith(axis, 1.0)
}
