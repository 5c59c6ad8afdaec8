//! Boundary conditions per face of the box and per patch of a face.

mod data;
mod fan;
mod fill;
mod open_area;
mod outline;
mod pieces;
mod pressure_inlet;
mod profile;

use crate::grid::AXES;
use crate::{Axis, Grid, SetupError};
use outline::tangents_of;
use std::fmt::{self, Display, Formatter};

pub(crate) use data::{BoundaryData, Kind, MAX_GHOSTS};
pub use fan::FanCurve;
pub(crate) use fill::fill_velocity;
pub use outline::Outline;
pub use profile::{FlowRate, Profile, SteadyVelocity, VelocityFunction};

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
        write!(f, "{}{}", if self.side == Side::High { "+" } else { "-" }, AXES[self.axis])
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
    /// Imposed total pressure p₀: where fluid enters, along the normal, the pressure is p₀ − ρ u²/2; where it leaves, p₀.
    PressureInlet {
        /// Total pressure p₀ (Pa), of a fan that on its suction side.
        pressure: f64,
        /// The fan that raises it, if there is one.
        fan: Option<FanCurve>,
    },
    /// No flow through, no shear.
    Symmetry,
}

impl Condition {
    /// A wall at rest.
    pub const WALL: Condition = Condition::Wall { velocity: [0.0; 3] };

    /// Whether the velocity it imposes may change in time.
    pub(crate) fn is_unsteady(&self) -> bool {
        matches!(self, Condition::Inlet { profile } if profile.is_unsteady())
    }

    /// Whether it imposes a pressure, so that fluid may come and go as it likes.
    pub fn imposes_pressure(&self) -> bool {
        matches!(self, Condition::Outlet { .. } | Condition::PressureInlet { .. })
    }
}

/// A part of a face with a condition of its own; along periodic axes it may reach over the end of the period.
///
/// The flow rate through an inlet, Σ u·n A over the faces of the boundary cells (m³/s), is its mean velocity times its area
/// within the face, wherever its edges lie among the cells. Other conditions hold in the cells whose middle they cover.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Face it lies on.
    pub face: BoxFace,
    /// Its form and place.
    pub outline: Outline,
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

    /// The condition of a number: 0 to 5 those of the faces, in the order of [`BoxFace::all`], then those of the patches.
    pub(crate) fn condition(&self, number: usize) -> &Condition {
        match number.checked_sub(6) {
            Some(k) => &self.patches[k].condition,
            None => &self.faces[number],
        }
    }

    /// The face of the condition of a number.
    pub(crate) fn face_of(&self, number: usize) -> BoxFace {
        match number.checked_sub(6) {
            Some(k) => self.patches[k].face,
            None => BoxFace {
                axis: number / 2,
                side: if number.is_multiple_of(2) { Side::Low } else { Side::High },
            },
        }
    }

    /// The conditions, by their numbers.
    pub(crate) fn conditions(&self) -> impl Iterator<Item = &Condition> {
        self.faces.iter().chain(self.patches.iter().map(|patch| &patch.condition))
    }

    /// Whether any face of an axis that is not periodic has an outlet, or an inlet of imposed pressure.
    pub fn has_outlet(&self, grid: &Grid) -> bool {
        open_faces(grid).any(|face| self.on(face).any(Condition::imposes_pressure))
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
        let axis = self.face.axis;
        if grid.axis(axis).is_periodic() {
            return error("the axis is periodic and has no boundary; remove the patch or the periodicity");
        }
        if let Some(reason) = self.outline.fault(axis) {
            return error(reason);
        }
        let tangents = tangents_of(axis);
        if self.condition.is_parabolic() && matches!(self.outline, Outline::Polygon { .. }) {
            return error("a polygon has no parabola; take a uniform profile, or a function");
        }
        let bounds = self.outline.bounds(tangents);
        if matches!(self.condition, Condition::Inlet { .. }) {
            let overlaps = |k: usize| {
                let (axis, nodes) = (grid.axis(tangents[k]), grid.axis(tangents[k]).nodes());
                axis.is_periodic() || bounds[k][0] < nodes[axis.cells()] && nodes[0] < bounds[k][1]
            };
            return if (0..2).all(overlaps) { Ok(()) } else { error("it covers no part of the face") };
        }
        let [n, m] = tangents.map(|t| grid.axis(t).cells() as isize);
        let covers = |i: isize, j: isize| {
            let mut at = [0.0; 3];
            (at[tangents[0]], at[tangents[1]]) =
                (grid.axis(tangents[0]).centre(i), grid.axis(tangents[1]).centre(j));
            self.outline.contains(grid, axis, at)
        };
        if (0..n).any(|i| (0..m).any(|j| covers(i, j))) {
            Ok(())
        } else {
            error("it covers no centre of a boundary cell; widen it or refine the grid")
        }
    }
}

/// The image of a coordinate (m) that is less than a period above `lower`; on axes that are not periodic, the coordinate.
pub(crate) fn image_from(axis: &Axis, lower: f64, x: f64) -> f64 {
    if axis.is_periodic() { x + axis.length() * ((lower - x) / axis.length()).ceil() } else { x }
}
