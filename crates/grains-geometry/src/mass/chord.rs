//! Where a line along x crosses a convex part with sharp edges.

use crate::{Part, Vec3};

/// A convex part with sharp edges, ready to be cut by lines along x.
pub(super) struct Solid<'a> {
    part: &'a Part,
    /// Direction of x in the part's frame.
    along: Vec3,
    /// Lower corner of the axis-aligned box around the part (m).
    pub lower: Vec3,
    /// Upper corner of that box (m).
    pub upper: Vec3,
}

impl<'a> Solid<'a> {
    pub fn new(part: &'a Part) -> Self {
        let (lower, upper) = part.core.extents(part.crust, &part.rotation);
        let along = part.rotation.row(0).transpose();
        Self { part, along, lower: part.center + lower, upper: part.center + upper }
    }

    /// Whether a line along x through a point can cross the part.
    pub fn meets_row(&self, point: &Vec3) -> bool {
        (1..3).all(|a| self.lower[a] <= point[a] && point[a] <= self.upper[a])
    }

    /// Where the line from `origin` along x enters and leaves the part, to rounding (m from the origin).
    pub fn chord(&self, origin: &Vec3) -> Option<(f64, f64)> {
        let (part, along) = (self.part, &self.along);
        let start = part.rotation.tr_mul(&(origin - part.center));
        part.core.chord(part.crust, &start, along)
    }
}
