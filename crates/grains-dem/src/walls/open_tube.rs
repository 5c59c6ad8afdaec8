//! Open tubes: cylindrical sheets of no thickness that end in circles, met from both sides.
//!
//! A contact is a local minimum of the signed distance d of the body over the sheet, as on meshes: on the wall, where the
//! normal is radial, or on a rim. A rim that a body covers whole is touched at its shallowest point too, so that a lid
//! or a ball on a seat is held all around: ½ k δ² of the deepest and the shallowest point have no kink where they change
//! places.

use super::surface_contact::{SphereTouch, SurfaceContact};
use crate::narrow_phase::{Meeting, PlacedPart, touch};
use grains_geometry::epa::penetration;
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{Core, GjkError, Mat3, Simplex, Vec3};
use std::f64::consts::TAU;

/// Arcs of a rim, each of which owns the minima on it.
const ARCS: u32 = 64;
/// Elements of a rim: the nearest point to a ball, the shallowest of a covered rim, the arcs.
const RIM: u32 = 2 + ARCS;
/// The element that is the wall between the rims.
const WALL: u32 = 0;
/// Sine of the angle between a radial normal and one that only a rim can have.
const TILT: f64 = 1e-6;
/// Halvings of an arc in the search for a minimum, to rounding.
const HALVINGS: usize = 50;

/// A cylindrical sheet.
#[derive(Clone, Copy, Debug)]
pub struct OpenTube {
    /// Centre (m).
    pub center: Vec3,
    /// Unit vector of the axis.
    pub axis: Vec3,
    /// Radius (m).
    pub radius: f64,
    /// Half of the length (m), finite.
    pub half_length: f64,
}

/// What an element is a piece of.
enum Piece {
    Wall,
    /// The point of a rim nearest to a ball.
    Nearest(Rim),
    /// The point of a wholly covered rim that is shallowest.
    Shallowest(Rim),
    /// Arc of a rim and its number.
    Arc(Rim, u32),
}

/// The circle in which a tube ends.
#[derive(Clone, Copy)]
struct Rim {
    center: Vec3,
    /// Unit vector of the axis, out of the tube.
    outward: Vec3,
    /// Unit vectors across the axis, from which angles count.
    across: [Vec3; 2],
    radius: f64,
}

impl Rim {
    fn at(&self, angle: f64) -> Vec3 {
        let (sin, cos) = libm::sincos(angle);
        self.center + (self.across[0] * cos + self.across[1] * sin) * self.radius
    }

    /// Unit tangent.
    fn along(&self, angle: f64) -> Vec3 {
        let (sin, cos) = libm::sincos(angle);
        self.across[1] * cos - self.across[0] * sin
    }
}

/// Angle (rad) at which an arc begins; that after the last is the first again.
fn start_of(arc: u32) -> f64 {
    f64::from(arc % ARCS) * (TAU / f64::from(ARCS))
}

impl OpenTube {
    fn piece(&self, element: u32) -> Piece {
        if element == WALL {
            return Piece::Wall;
        }
        let (end, piece) = ((element - 1) / RIM, (element - 1) % RIM);
        let outward = if end == 0 { -self.axis } else { self.axis };
        let first = self.across();
        let rim = Rim {
            center: self.center + outward * self.half_length,
            outward,
            across: [first, self.axis.cross(&first)],
            radius: self.radius,
        };
        match piece {
            0 => Piece::Nearest(rim),
            1 => Piece::Shallowest(rim),
            arc => Piece::Arc(rim, arc - 2),
        }
    }

    /// Some unit vector across the axis.
    fn across(&self) -> Vec3 {
        let crosswise = Vec3::ith(self.axis.iamin(), 1.0);
        self.axis.cross(&crosswise).normalize()
    }

    /// Coordinate along the axis (m), unit vector away from it, and distance from it (m).
    fn coordinates(&self, point: &Vec3) -> (f64, Vec3, f64) {
        let from = point - self.center;
        let along = from.dot(&self.axis);
        let off = from - self.axis * along;
        let distance = off.norm();
        (along, if distance > 0.0 { off / distance } else { self.across() }, distance)
    }

    /// Calls `found` with every element within `range` (m) of a point.
    pub(super) fn for_each_near(&self, center: &Vec3, range: f64, mut found: impl FnMut(u32)) {
        let is_near = |element: &u32| self.distance_bound(*element, center) < range;
        if !is_near(&WALL) {
            return;
        }
        found(WALL);
        for first in [1, 1 + RIM] {
            // The nearest point of a rim comes first: no other element is near without it.
            if is_near(&first) {
                (first..first + RIM).filter(is_near).for_each(&mut found);
            }
        }
    }

    /// Lower bound (m) on the distance of an element from a point.
    pub(super) fn distance_bound(&self, element: u32, center: &Vec3) -> f64 {
        let (along, _, off) = self.coordinates(center);
        // The point of a rim at a distance (m) across the axis.
        let from_rim = |rim: &Rim, across: f64| {
            let from_end = (center - rim.center).dot(&rim.outward);
            (across * across + from_end * from_end).sqrt()
        };
        let beside = off - self.radius;
        match self.piece(element) {
            Piece::Wall => beside.abs().max(along.abs() - self.half_length),
            Piece::Nearest(rim) => from_rim(&rim, beside),
            Piece::Shallowest(rim) => from_rim(&rim, off + self.radius),
            Piece::Arc(rim, arc) => {
                let half = 0.5 * TAU / f64::from(ARCS);
                let middle = rim.at(start_of(arc) + half);
                let radius_of_arc = 2.0 * self.radius * libm::sin(0.5 * half);
                from_rim(&rim, beside).max((center - middle).norm() - radius_of_arc)
            }
        }
    }

    /// Whether a sphere may touch an element: arcs are for others.
    pub(super) fn is_for_spheres(&self, element: u32) -> bool {
        !matches!(self.piece(element), Piece::Arc(..))
    }

    /// Whether a contact that moves on over the sheet may go from one element to the other.
    pub(super) fn adjoin(&self, element: u32, other: u32) -> bool {
        match (self.piece(element), self.piece(other)) {
            (Piece::Arc(a, i), Piece::Arc(b, j)) => {
                let apart = i.abs_diff(j);
                a.outward == b.outward && (apart <= 1 || apart == ARCS - 1)
            }
            (Piece::Shallowest(_), _) | (_, Piece::Shallowest(_)) => false,
            (Piece::Wall, _) | (_, Piece::Wall) => true,
            _ => false,
        }
    }

    /// Contact of a sphere with one element, if they touch.
    pub(super) fn meets_sphere(&self, element: u32, center: &Vec3, radius: f64) -> Option<SphereTouch> {
        let (along, outward, off) = self.coordinates(center);
        let on_rim = |rim: &Rim, point: Vec3| {
            let to = point - center;
            let gap = to.norm();
            let normal = if gap > 0.0 { to / gap } else { -rim.outward };
            let is_past = (center - rim.center).dot(&rim.outward) > 0.0;
            (is_past && gap < radius).then_some(SphereTouch { normal, overlap: radius - gap })
        };
        match self.piece(element) {
            Piece::Wall => {
                let gap = self.radius - off;
                let normal = if gap >= 0.0 { outward } else { -outward };
                let overlap = radius - gap.abs();
                (overlap > 0.0 && along.abs() <= self.half_length).then_some(SphereTouch { normal, overlap })
            }
            Piece::Nearest(rim) => on_rim(&rim, rim.center + outward * self.radius),
            Piece::Shallowest(rim) => on_rim(&rim, rim.center - outward * self.radius),
            Piece::Arc(..) => None,
        }
    }

    /// Contact of a part, its centre at `center`, with one element, if they touch.
    pub(super) fn meets_part(
        &self,
        element: u32,
        center: &Vec3,
        part: &PlacedPart,
    ) -> Result<Option<SurfaceContact>, GjkError> {
        if matches!(part.core, Core::Point) {
            let touch = self.meets_sphere(element, center, part.crust);
            return Ok(touch.map(|touch| touch.contact(center, part.crust)));
        }
        let (rim, found) = match self.piece(element) {
            Piece::Wall => return self.meets_wall(center, part),
            Piece::Nearest(_) => return Ok(None),
            Piece::Shallowest(rim) => (rim, shallowest(&rim, center, part)?),
            Piece::Arc(rim, arc) => (rim, deepest(&rim, arc, center, part)?),
        };
        Ok(found.and_then(|SheetPoint { point, gap, normal }| {
            // Where the distance shrinks from the rim into the wall, the minimum is on the wall.
            let is_of_rim = normal.dot(&rim.outward) < -TILT;
            (is_of_rim && gap < 0.0).then(|| SurfaceContact::new(point - normal * gap, normal, -gap, None))
        }))
    }

    /// Contact of a part with the wall between the rims.
    fn meets_wall(&self, center: &Vec3, part: &PlacedPart) -> Result<Option<SurfaceContact>, GjkError> {
        let (along, _, off) = self.coordinates(center);
        if off >= self.radius {
            return self.meets_outside(center, part);
        }
        let slack = TILT * part.bounding_radius;
        let touches = |deepest: Vec3, outward: Vec3, distance: f64| {
            let end = (center + deepest - self.center).dot(&self.axis);
            // The straight way from the centre to a point behind the wall leads over the rim, or through the wall.
            let crossing = along + (end - along) * ((self.radius - off) / (distance - off)).min(1.0);
            let is_beside = end.abs() <= self.half_length + slack;
            let is_through = distance <= self.radius || crossing.abs() <= self.half_length + slack;
            (is_beside && is_through)
                .then(|| SurfaceContact::behind(part, &(center + deepest), outward, distance - self.radius))
                .flatten()
        };
        let (deepest, outward, distance) = part.farthest_from_axis(&(center - self.center), &self.axis);
        if let Some(contact) = touches(deepest, outward, distance) {
            return Ok(Some(contact));
        }
        if (center + deepest - self.center).dot(&self.axis).abs() <= self.half_length {
            return Ok(None);
        }
        // Other points where the distance from the axis has a local maximum.
        const STARTS: u32 = 16;
        const CLIMBS: usize = 50;
        let first = self.across();
        let second = self.axis.cross(&first);
        let mut best: Option<SurfaceContact> = None;
        for start in 0..STARTS {
            let (sin, cos) = libm::sincos(f64::from(start) * (TAU / f64::from(STARTS)));
            let mut direction = first * cos + second * sin;
            let mut reached = (Vec3::zeros(), f64::NEG_INFINITY);
            for _ in 0..CLIMBS {
                let point = part.farthest(&direction);
                let (_, outward, distance) = self.coordinates(&(center + point));
                if distance <= reached.1 {
                    break;
                }
                (reached, direction) = ((point, distance), outward);
            }
            if let Some(contact) = touches(reached.0, direction, reached.1)
                && best.is_none_or(|b| contact.overlap > b.overlap)
            {
                best = Some(contact);
            }
        }
        Ok(best)
    }

    /// Contact of a part whose centre is farther from the axis than the wall: with the cylinder the wall is the side of.
    ///
    /// Only points whose normal is radial are on the wall; the ends of the cylinder are open.
    fn meets_outside(&self, center: &Vec3, part: &PlacedPart) -> Result<Option<SurfaceContact>, GjkError> {
        let first = self.across();
        let rotation = Mat3::from_columns(&[first, self.axis.cross(&first), self.axis]);
        let core = Core::Cylinder { radius: self.radius, half_height: self.half_length };
        let placement = part.placement(&rotation, 1.0, &(self.center - center));
        let Meeting::Touching(contact) = touch(part, &core, &placement, 0.0, 0.0, &mut Simplex::default())?
        else {
            return Ok(None);
        };
        let is_radial = contact.normal.dot(&self.axis).abs() <= TILT;
        Ok(is_radial.then(|| SurfaceContact {
            normal: contact.normal,
            overlap: contact.overlap,
            point: center + contact.point,
            footprint: None,
        }))
    }
}

/// A point of the sheet, how far it is from a body, and the unit normal of the body towards it.
struct SheetPoint {
    point: Vec3,
    /// Signed distance (m), negative inside.
    gap: f64,
    normal: Vec3,
}

/// Signed distance of a part from a point; its gradient is the normal.
fn signed_distance(center: &Vec3, part: &PlacedPart, point: Vec3) -> Result<SheetPoint, GjkError> {
    let placement = part.placement(&Mat3::identity(), 1.0, &(point - center));
    let mut simplex = Simplex::default();
    let (gap, normal) = match distance(part.core, &Core::Point, &placement, f64::INFINITY, &mut simplex)? {
        Separation::Apart { distance, normal, .. } => (distance, normal),
        _ => {
            let found = penetration(part.core, &Core::Point, &placement, &simplex)?;
            (-found.depth, found.normal)
        }
    };
    Ok(SheetPoint { point, gap: gap * part.scale - part.crust, normal: part.rotation * normal })
}

/// The local minimum of the signed distance that an arc owns.
fn deepest(rim: &Rim, arc: u32, center: &Vec3, part: &PlacedPart) -> Result<Option<SheetPoint>, GjkError> {
    let slope = |angle: f64| -> Result<(f64, SheetPoint), GjkError> {
        let found = signed_distance(center, part, rim.at(angle))?;
        Ok((found.normal.dot(&rim.along(angle)), found))
    };
    let (first, at_first) = slope(start_of(arc))?;
    // The distance changes by no more than the way.
    let longest = TAU / f64::from(ARCS) * rim.radius;
    if first >= 0.0 || at_first.gap >= longest || slope(start_of(arc + 1))?.0 < 0.0 {
        return Ok(None);
    }
    let mut range = [start_of(arc), start_of(arc) + TAU / f64::from(ARCS)];
    for _ in 0..HALVINGS {
        let middle = 0.5 * (range[0] + range[1]);
        if middle <= range[0] || middle >= range[1] {
            break;
        }
        range[usize::from(slope(middle)?.0 >= 0.0)] = middle;
    }
    // At an edge of the body the normals of both sides make up that of the minimum.
    let (low, high) = (slope(range[0])?, slope(range[1])?);
    let share = low.0 / (low.0 - high.0);
    let normal = low.1.normal * (1.0 - share) + high.1.normal * share;
    let Some(normal) = normal.try_normalize(f64::EPSILON) else { return Ok(None) };
    Ok(Some(SheetPoint { normal, ..high.1 }))
}

/// The largest signed distance over a rim that is all within a part.
fn shallowest(rim: &Rim, center: &Vec3, part: &PlacedPart) -> Result<Option<SheetPoint>, GjkError> {
    let mut best: Option<(f64, SheetPoint)> = None;
    for arc in 0..ARCS {
        let found = signed_distance(center, part, rim.at(start_of(arc)))?;
        if found.gap >= 0.0 {
            return Ok(None);
        }
        if best.as_ref().is_none_or(|(_, b)| found.gap > b.gap) {
            best = Some((start_of(arc), found));
        }
    }
    let Some((middle, _)) = best else { return Ok(None) };
    let step = TAU / f64::from(ARCS);
    let mut range = [middle - step, middle + step];
    for _ in 0..HALVINGS {
        let angle = 0.5 * (range[0] + range[1]);
        let found = signed_distance(center, part, rim.at(angle))?;
        range[usize::from(found.normal.dot(&rim.along(angle)) < 0.0)] = angle;
    }
    signed_distance(center, part, rim.at(0.5 * (range[0] + range[1]))).map(Some)
}
