//! Walls that bound the fluid, and the closest surface points of whatever is solid.

use crate::body::Form;
use crate::{RigidBody, Subgrid};
use grains_geometry::{ClosedSurface, ClosestSurface, Shape, Vec3};

/// What rounding may make of a place (cells): a velocity on the surface of a wall is that of the wall on any rank.
const ROUNDING: f64 = 1e-9;

/// The side of its surface on which a wall is solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolidSide {
    /// An obstacle in the fluid.
    Inside,
    /// A container of fluid.
    Outside,
}

/// A wall that bounds the fluid: a closed surface in the wall's frame, solid on one side.
///
/// In a periodic box an obstacle has images, but along axes that it spans; a container is met at the wrapped position, and must
/// be periodic itself where it crosses a periodic face.
#[derive(Clone, Debug)]
pub struct FluidWall {
    /// The surface.
    pub surface: ClosedSurface,
    /// Where it is solid.
    pub solid: SolidSide,
}

impl FluidWall {
    /// How deep a point (m) of the wall's frame is in it (m), negative in the fluid; `flat` is the axis along which nothing
    /// varies.
    pub fn depth(&self, point: &Vec3, flat: Option<usize>) -> f64 {
        let distance = self.surface.signed_distance(point, flat).distance;
        if self.solid == SolidSide::Inside { -distance } else { distance }
    }

    /// Corners (m) of a box about all that is solid of a placed wall; none if that has no end.
    fn extents(&self, place: &RigidBody) -> Option<[Vec3; 2]> {
        if self.solid == SolidSide::Outside {
            return None;
        }
        let [lower, upper] = self.surface.extents()?;
        let (middle, half) = ((lower + upper) * 0.5, (upper - lower) * 0.5);
        let (middle, half) = (place.center + place.rotation * middle, place.rotation.abs() * half);
        Some([middle - half, middle + half])
    }
}

/// A wall where it is now.
#[derive(Clone, Debug)]
pub(crate) struct PlacedWall {
    pub wall: FluidWall,
    /// Pose and velocity.
    pub body: RigidBody,
    /// Shifts (m) of its periodic images that reach into the box, its own place among them.
    shifts: Vec<Vec3>,
    /// Corners (m) of a box about all that is solid, if that has an end.
    extents: Option<[Vec3; 2]>,
}

impl PlacedWall {
    pub fn new(wall: FluidWall, body: RigidBody, subgrid: &Subgrid) -> Self {
        let extents = wall.extents(&body);
        let shifts = extents.map_or_else(|| vec![Vec3::zeros()], |extents| images(extents, subgrid));
        Self { wall, body, shifts, extents }
    }

    /// Whether it lies where another one does.
    pub fn is_where(&self, other: &Self) -> bool {
        let [here, there] = [&self.body, &other.body];
        (here.id, here.center, here.rotation) == (there.id, there.center, there.rotation)
    }

    /// Whether it moves.
    pub fn is_moving(&self) -> bool {
        self.body.velocity != Vec3::zeros() || self.body.spin != Vec3::zeros()
    }

    /// Whether a row of velocities along x through a point (m) may come within a cell of it.
    fn may_meet_row(&self, point: &Vec3, subgrid: &Subgrid) -> bool {
        let Some([lower, upper]) = self.extents else { return true };
        let holds = |shift: &Vec3, a: usize| {
            let (at, width) = (point[a] - shift[a], subgrid.spacing[a]);
            !subgrid.active[a] || (lower[a] - width..=upper[a] + width).contains(&at)
        };
        self.shifts.iter().any(|shift| (1..3).all(|a| holds(shift, a)))
    }

    /// How deep a point (m) of the box is in the wall (m, negative in the fluid), and the closest point of its surface.
    fn depth(&self, point: &Vec3, flat: Option<usize>) -> (f64, ClosestPoint) {
        let of_image = |shift: &Vec3| {
            let arm = point - shift - self.body.center;
            let found = self.wall.surface.signed_distance(&self.body.rotation.tr_mul(&arm), flat);
            let (depth, direction) = match self.wall.solid {
                SolidSide::Inside => (-found.distance, found.outward),
                SolidSide::Outside => (found.distance, -found.outward),
            };
            let direction = self.body.rotation * direction;
            (depth, ClosestPoint { arm, surface: ClosestSurface { distance: depth, direction } })
        };
        let deeper = |a: (f64, ClosestPoint), b: (f64, ClosestPoint)| if b.0 > a.0 { b } else { a };
        let nowhere = ClosestSurface { distance: 0.0, direction: Vec3::zeros() };
        let none = (f64::NEG_INFINITY, ClosestPoint { arm: Vec3::zeros(), surface: nowhere });
        self.shifts.iter().map(of_image).fold(none, deeper)
    }
}

/// Shifts (m) of the periodic images of a box between two corners (m) that reach into the domain.
fn images([lower, upper]: [Vec3; 2], subgrid: &Subgrid) -> Vec<Vec3> {
    let mut shifts = vec![Vec3::zeros()];
    for a in (0..3).filter(|&a| subgrid.periods[a].is_some()) {
        let [begin, length] = subgrid.periods[a].unwrap_or_default();
        if lower[a] <= begin && upper[a] >= begin + length {
            continue;
        }
        let all = std::mem::take(&mut shifts);
        for image in [-1.0, 0.0, 1.0].map(|image| image * length) {
            if lower[a] + image <= begin + length && upper[a] + image >= begin {
                let shifted = |shift: &Vec3| {
                    let mut shift = *shift;
                    shift[a] = image;
                    shift
                };
                shifts.extend(all.iter().map(shifted));
            }
        }
    }
    shifts
}

/// The point of a body's surface closest to a point in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClosestPoint {
    /// From the centre of the body, or of its image, to the point (m).
    pub arm: Vec3,
    /// Distance and direction from there.
    pub surface: ClosestSurface,
}

impl ClosestPoint {
    /// That of a body of a shape to a point at an arm (m) from its centre; none from outside.
    fn of_shape(arm: Vec3, (body, shape): (&RigidBody, &Shape), flat: Option<usize>) -> Option<Self> {
        let local = body.rotation.tr_mul(&arm) / body.scale;
        let across = flat.map(|a| body.rotation.row(a).transpose());
        let surface = shape.closest_surface(&local, across.as_ref())?;
        let (distance, direction) = (surface.distance * body.scale, body.rotation * surface.direction);
        Some(Self { arm, surface: ClosestSurface { distance, direction } })
    }

    /// That of a sphere of a radius (m) to a point at an arm (m) from its centre; none from outside.
    #[inline(always)]
    fn of_sphere(arm: Vec3, radius: f64) -> Option<Self> {
        let length = arm.norm();
        let direction = if length > 0.0 { arm / length } else { Vec3::x() };
        let surface = ClosestSurface { distance: radius - length, direction };
        (length <= radius).then_some(Self { arm, surface })
    }
}

/// A run of velocities along x in a wall, or one in the fluid beside it.
pub(crate) struct WallRun {
    /// Whether they are in the wall.
    pub is_solid: bool,
    /// Indices of the first one along the axes.
    pub first: [isize; 3],
    /// How many there are.
    pub count: usize,
    /// The surface point closest to the first; its distance is negative in the fluid.
    pub out: ClosestPoint,
}

/// All that is solid on a rank.
pub(crate) struct Solids<'a> {
    /// Bodies, then walls.
    pub bodies: &'a [RigidBody],
    pub shapes: &'a [Shape],
    pub walls: &'a [PlacedWall],
    pub subgrid: &'a Subgrid,
}

impl Solids<'_> {
    /// Radius (m) of a ball about the centre of a body that lies in it; 0 of composites, of which none is known.
    pub fn inscribed_radius(&self, body: usize) -> f64 {
        let body = &self.bodies[body];
        let convex = body.shape(self.shapes).filter(|shape| shape.parts.len() == 1);
        convex.map_or(0.0, |shape| body.scale * shape.inscribed_radius)
    }

    /// The surface point of a body closest to a point (m); none from outside.
    #[inline(always)]
    pub fn closest_point(&self, body: usize, point: &Vec3) -> Option<ClosestPoint> {
        let body = &self.bodies[body];
        let arm = point - body.center;
        match body.form {
            Form::Shape(shape) => {
                let (shape, flat) = (&self.shapes[usize::from(shape)], self.subgrid.flat());
                match flat.is_none() && shape.is_sphere() {
                    true => ClosestPoint::of_sphere(arm, body.radius(self.shapes)),
                    false => ClosestPoint::of_shape(arm, (body, shape), flat),
                }
            }
            Form::Wall(wall) => {
                let (depth, out) =
                    self.walls[usize::from(wall)].depth(&self.subgrid.wrapped(point), self.subgrid.flat());
                (depth >= -self.slack()).then_some(out)
            }
        }
    }

    /// How deep a point (m) is in a wall (m), negative in the fluid.
    pub fn depth_in_wall(&self, wall: usize, point: &Vec3) -> f64 {
        self.walls[wall].depth(&self.subgrid.wrapped(point), self.subgrid.flat()).0
    }

    /// Calls `found` with runs that make up all velocities of a component in a wall and next to it, halo included.
    ///
    /// No velocity lies nearer to the surface than its neighbour does, less their distance: those between are not looked at.
    pub fn for_each_run(&self, component: usize, wall: usize, mut found: impl FnMut(WallRun)) {
        let Subgrid { layout, spacing, active, .. } = self.subgrid;
        let wall = &self.walls[wall];
        let range = |a: usize| {
            let (h, n) = (layout.halo as isize, layout.cells[a] as isize);
            if active[a] { -h..n + h } else { 0..1 }
        };
        let diagonal = self.subgrid.diagonal();
        let width = spacing.x;
        for k in range(2) {
            for j in range(1) {
                let mut i = range(0).start;
                while i < range(0).end {
                    let at = Vec3::from_fn(|a, _| self.subgrid.coordinate(component, a, [i, j, k][a]));
                    let point = self.subgrid.wrapped(&at);
                    if !wall.may_meet_row(&point, self.subgrid) {
                        break;
                    }
                    let (depth, out) = wall.depth(&point, self.subgrid.flat());
                    let is_solid = depth >= -self.slack();
                    // The same as far as the surface is not, up to the border at which positions are wrapped.
                    let same = if is_solid { depth - diagonal } else { -depth - diagonal };
                    let left = (range(0).end - i) as f64;
                    let same =
                        same.min(self.subgrid.left_in_period(&point) - width).min((left - 1.0) * width);
                    let count = 1 + (same / width).max(0.0) as isize;
                    if depth > -diagonal {
                        found(WallRun { is_solid, first: [i, j, k], count: count as usize, out });
                    }
                    i += count;
                }
            }
        }
    }

    /// Depth (m) by which rounding may take a velocity on the surface out of a wall.
    fn slack(&self) -> f64 {
        ROUNDING * self.subgrid.spacing.min()
    }
}
