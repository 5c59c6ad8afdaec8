//! Boundary conditions per face of the box and per rectangular patch of a face.

mod data;
mod fill;

use crate::grid::AXES;
use crate::{Axis, Grid, SetupError};
use std::fmt::{self, Debug, Display, Formatter};
use std::sync::Arc;

pub(crate) use data::{BoundaryData, Kind};
pub(crate) use fill::fill_velocity;

/// End of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Towards lower coordinates.
    Low,
    /// Towards higher coordinates.
    High,
}

/// One of the six faces of the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoxFace {
    /// Axis normal to the face.
    pub axis: usize,
    /// Which end of it.
    pub side: Side,
}

impl BoxFace {
    /// All faces: x low, x high, y low, …
    pub fn all() -> impl Iterator<Item = BoxFace> {
        (0..6).map(|k| BoxFace { axis: k / 2, side: if k % 2 == 0 { Side::Low } else { Side::High } })
    }

    /// Position in [`BoxFace::all`].
    pub fn index(self) -> usize {
        2 * self.axis + usize::from(self.side == Side::High)
    }

    /// +1 where the outward normal points to higher coordinates, else −1.
    pub fn outward(self) -> f64 {
        if self.side == Side::High { 1.0 } else { -1.0 }
    }
}

impl Display for BoxFace {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", AXES[self.axis], if self.side == Side::High { "+" } else { "-" })
    }
}

/// A velocity (m/s) as a function of position (m) and time (s).
pub type VelocityFunction = Arc<dyn Fn([f64; 3], f64) -> [f64; 3] + Send + Sync>;

/// Velocity over an inlet.
#[derive(Clone)]
pub enum Profile {
    /// The same velocity everywhere (m/s).
    Uniform([f64; 3]),
    /// Parabolas across the inlet, zero at its edges, Π 6 s (1 − s) times the mean normal speed (m/s, inwards);
    /// cells take their exact mean, so the flow rate is exact.
    Parabolic {
        /// Mean speed into the box (m/s).
        mean: f64,
    },
    /// Any function of position and time, taken at the middle of a boundary cell, or of the parts into which edges of
    /// patches cut it: the flow rate is of second order in the width of the cells.
    Function(VelocityFunction),
}

impl Debug for Profile {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Profile::Uniform(velocity) => write!(f, "Uniform({velocity:?})"),
            Profile::Parabolic { mean } => write!(f, "Parabolic({mean})"),
            Profile::Function(_) => write!(f, "Function"),
        }
    }
}

/// What holds on a part of the boundary.
#[derive(Clone, Debug)]
pub enum Condition {
    /// No slip; the wall may move along itself.
    Wall {
        /// Velocity of the wall (m/s), its normal component zero.
        velocity: [f64; 3],
    },
    /// Imposed velocity; among particles the superficial one ε u.
    Inlet {
        /// Velocity over the inlet.
        profile: Profile,
    },
    /// Imposed pressure; fluid that comes back in carries no momentum, so back-flow cannot feed itself.
    Outlet {
        /// Pressure on the outlet (Pa).
        pressure: f64,
    },
    /// No flow through, no shear.
    Symmetry,
}

impl Condition {
    /// A wall at rest.
    pub const WALL: Condition = Condition::Wall { velocity: [0.0; 3] };

    /// Whether the velocity it imposes may change in time.
    pub(crate) fn is_unsteady(&self) -> bool {
        matches!(self, Condition::Inlet { profile: Profile::Function(_) })
    }
}

/// A rectangle of a face with a condition of its own; along periodic axes it may reach over the end of the period.
///
/// The flow rate through an inlet, Σ u·n A over the faces of the boundary cells (m³/s), is its mean velocity times its area
/// within the face, wherever its edges lie among the cells. Other conditions hold in the cells whose middle they cover.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Face it lies on.
    pub face: BoxFace,
    /// Lower corner (m); the coordinate normal to the face is not read.
    pub lower: [f64; 3],
    /// Upper corner (m).
    pub upper: [f64; 3],
    /// What holds there.
    pub condition: Condition,
}

/// Conditions of all faces; those of periodic axes are not read.
#[derive(Clone, Debug)]
pub struct Boundaries {
    /// One condition per face, in the order of [`BoxFace::all`].
    pub faces: [Condition; 6],
    /// Exceptions, later ones before earlier ones.
    pub patches: Vec<Patch>,
}

impl Default for Boundaries {
    fn default() -> Self {
        Self { faces: std::array::from_fn(|_| Condition::WALL), patches: Vec::new() }
    }
}

impl Boundaries {
    /// The same condition on all six faces.
    pub fn all(condition: Condition) -> Self {
        Self { faces: std::array::from_fn(|_| condition.clone()), patches: Vec::new() }
    }

    /// Replaces the condition of one face.
    pub fn with(mut self, axis: usize, side: Side, condition: Condition) -> Self {
        self.faces[BoxFace { axis, side }.index()] = condition;
        self
    }

    /// Adds a patch.
    pub fn with_patch(mut self, patch: Patch) -> Self {
        self.patches.push(patch);
        self
    }

    /// All conditions that hold somewhere on a face.
    pub fn on(&self, face: BoxFace) -> impl Iterator<Item = &Condition> {
        let patches = self.patches.iter().filter(move |p| p.face == face);
        std::iter::once(&self.faces[face.index()]).chain(patches.map(|p| &p.condition))
    }

    /// Whether any face of an axis that is not periodic has an outlet.
    pub fn has_outlet(&self, grid: &Grid) -> bool {
        open_faces(grid).any(|face| self.on(face).any(|c| matches!(c, Condition::Outlet { .. })))
    }

    /// Whether velocities imposed somewhere on the boundary may change in time.
    pub fn is_unsteady(&self, grid: &Grid) -> bool {
        open_faces(grid).any(|face| self.on(face).any(Condition::is_unsteady))
    }

    /// Whether tangential velocities are imposed on the whole face, on none of it (false), or on parts (none).
    pub(crate) fn imposes_tangential(&self, face: BoxFace) -> Option<bool> {
        let imposes = |c: &Condition| matches!(c, Condition::Wall { .. } | Condition::Inlet { .. });
        let first = imposes(&self.faces[face.index()]);
        self.on(face).all(|c| imposes(c) == first).then_some(first)
    }

    /// Refuses what makes no sense on this grid.
    pub fn check(&self, grid: &Grid) -> Result<(), SetupError> {
        for face in open_faces(grid) {
            for condition in self.on(face) {
                if let Condition::Wall { velocity } = condition
                    && velocity[face.axis] != 0.0
                {
                    let speed = velocity[face.axis];
                    return Err(SetupError::WallMovesOut { face: face.to_string(), speed });
                }
                if !grid.is_active(face.axis) && !matches!(condition, Condition::Symmetry) {
                    return Err(SetupError::OneCell { axis: AXES[face.axis] });
                }
            }
        }
        self.patches.iter().try_for_each(|patch| patch.check(grid))
    }
}

/// Faces of the axes that are not periodic.
pub(crate) fn open_faces(grid: &Grid) -> impl Iterator<Item = BoxFace> {
    BoxFace::all().filter(|face| !grid.axis(face.axis).is_periodic())
}

impl Patch {
    fn check(&self, grid: &Grid) -> Result<(), SetupError> {
        let error =
            |reason: &str| Err(SetupError::Patch { face: self.face.to_string(), reason: reason.to_string() });
        if grid.axis(self.face.axis).is_periodic() {
            return error("the axis is periodic and has no boundary; remove the patch or the periodicity");
        }
        let mut tangents = (0..3).filter(|&a| a != self.face.axis);
        if matches!(self.condition, Condition::Inlet { .. }) {
            let overlaps = |a: usize| {
                let (axis, nodes) = (grid.axis(a), grid.axis(a).nodes());
                let [begin, end] = match axis.is_periodic() {
                    true => [self.lower[a], self.upper[a]],
                    false => [self.lower[a].max(nodes[0]), self.upper[a].min(nodes[axis.cells()])],
                };
                begin < end
            };
            return if tangents.all(overlaps) { Ok(()) } else { error("it covers no part of the face") };
        }
        let covers = |a: usize| {
            let axis = grid.axis(a);
            let centres = (0..axis.cells()).map(|i| axis.centre(i as isize));
            centres
                .map(|x| image_from(axis, self.lower[a], x))
                .any(|x| self.lower[a] <= x && x <= self.upper[a])
        };
        if tangents.all(covers) {
            Ok(())
        } else {
            error("it covers no centre of a boundary cell; widen it or refine the grid")
        }
    }

    /// Whether a point of the face or an image of it lies on the patch, edges included.
    fn contains(&self, grid: &Grid, at: [f64; 3]) -> bool {
        (0..3).filter(|&a| a != self.face.axis).all(|a| {
            let slack = 1e-9 * (self.upper[a] - self.lower[a]);
            let lower = self.lower[a] - slack;
            let image = image_from(grid.axis(a), lower, at[a]);
            image >= lower && image <= self.upper[a] + slack
        })
    }
}

/// The image of a coordinate (m) that is less than a period above `lower`; on axes that are not periodic, the coordinate.
pub(crate) fn image_from(axis: &Axis, lower: f64, x: f64) -> f64 {
    if axis.is_periodic() { x + axis.length() * ((lower - x) / axis.length()).ceil() } else { x }
}
