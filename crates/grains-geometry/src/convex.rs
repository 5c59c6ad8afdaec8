//! What a kind of convex body has to know of itself, and the kinds, a file each.
//!
//! [`Support`] is all that distances need; [`Convex`] is the rest: size, contact patch, and the body with sharp edges
//! that is the core swept by its crust, for mass properties and surfaces. [`Core`](crate::Core) lists the kinds.

pub(crate) mod cone;
pub(crate) mod cuboid;
pub(crate) mod cylinder;
pub(crate) mod feature;
pub(crate) mod line;
pub(crate) mod point;
pub(crate) mod polyhedron;
pub(crate) mod segment;
mod superellipsoid;
pub(crate) mod surface_points;
pub(crate) mod triangle;

use crate::superellipsoid::Superellipsoid;
use crate::{Mat3, Vec3};
use feature::Feature;
use polyhedron::Polyhedron;
use surface_points::SurfaceElement;

/// Support mapping of one kind of core; the distance loop is compiled once for each pair of kinds.
pub(crate) trait Support {
    /// Whether the core has curved parts, so that its support points are not a finite set.
    const CURVED: bool;

    /// Whether the core may have flat faces.
    const FACED: bool = false;

    /// Point farthest along `direction`, which need not be of unit length.
    fn farthest(&self, direction: &Vec3) -> Vec3;

    /// Support value max d·x: the height of [`Support::farthest`], at less cost.
    fn height(&self, direction: &Vec3) -> f64;

    /// A length within a factor 2 of the largest distance of the core from its origin (m).
    fn extent(&self) -> f64;

    /// The flat face that looks along `direction` most directly, if there are faces.
    fn facing(&self, _direction: &Vec3) -> Option<FacePlane> {
        None
    }

    /// Whether a face lies straight below a point before it.
    fn is_below(&self, _face: &FacePlane, _point: &Vec3) -> bool {
        false
    }

    /// Writes the corners of a face in order; returns how many, if there is room.
    fn corners(&self, _face: &FacePlane, _to: &mut [Vec3]) -> Option<usize> {
        None
    }

    /// The rims of a body of revolution about z, if the core is one: the points of a simplex lie on them.
    fn rims(&self) -> Option<Rims> {
        None
    }

    /// Half edges of a box (m), if the core is one.
    fn half_edges(&self) -> Option<Vec3> {
        None
    }

    /// The polyhedron, if the core is one that has faces.
    fn polyhedron(&self) -> Option<&Polyhedron> {
        None
    }

    /// The superellipsoid, if the core is one.
    fn superellipsoid(&self) -> Option<&Superellipsoid> {
        None
    }
}

/// The two rims of a circular cylinder about z.
#[derive(Clone, Copy)]
pub(crate) struct Rims {
    /// Radius (m).
    pub radius: f64,
    /// Half of the height (m).
    pub half_height: f64,
}

impl Rims {
    /// Height of the upper or lower rim over the middle (m).
    #[inline(always)]
    pub(crate) fn height(&self, is_upper: bool) -> f64 {
        if is_upper { self.half_height } else { -self.half_height }
    }
}

/// The plane of a face: normal·x = offset, with the core behind it.
#[derive(Clone, Copy)]
pub(crate) struct FacePlane {
    /// Number of the face.
    pub number: usize,
    /// Outward unit normal (-).
    pub normal: Vec3,
    /// Distance of the plane from the core's origin (m).
    pub offset: f64,
}

/// What shapes need of one kind of core beside distances, all in the frame of the core.
///
/// The *body* is the core with a crust (m) added, its edges sharp: a box, say, of half edges larger by the crust. Of a
/// triangle of a wall there is no body.
pub(crate) trait Convex: Support {
    /// Lowest and highest corner of the axis-aligned box around the core (m).
    fn bounds(&self) -> (Vec3, Vec3);

    /// Radius of the smallest ball about the origin that holds the core (m).
    fn radius(&self) -> f64;

    /// Largest distance of the core with a crust (m) from the origin of a frame in which it is turned and moved (m), or
    /// somewhat more.
    fn largest_distance(&self, crust: f64, rotation: &Mat3, center: &Vec3) -> f64;

    /// Calls `visit` with the points whose hull the core is; with none of a curved core.
    fn for_each_vertex(&self, visit: impl FnMut(Vec3));

    /// The vertex of a number, in the order of [`Convex::for_each_vertex`]; the origin if there is none.
    fn vertex(&self, number: usize) -> Vec3 {
        let (mut k, mut found) = (0, Vec3::zeros());
        self.for_each_vertex(|vertex| {
            if k == number {
                found = vertex;
            }
            k += 1;
        });
        found
    }

    /// Number of a vertex; `None` of another point.
    fn number_of(&self, point: &Vec3) -> Option<u16> {
        let (mut k, mut found) = (0, None);
        self.for_each_vertex(|vertex| {
            if vertex == *point && found.is_none() {
                found = Some(k);
            }
            k += 1;
        });
        found
    }

    /// From a point to the nearest point of the core (m), zero inside; `None` without a closed form.
    fn offset_from(&self, point: &Vec3) -> Option<Vec3>;

    /// Finds the face or line that looks most along a unit `direction`; `None` if contacts there are points.
    fn contact_feature(&self, direction: &Vec3, found: &mut Feature) -> Option<()>;

    /// Whether a point lies in the body.
    fn contains(&self, crust: f64, point: &Vec3) -> bool;

    /// Corners of the axis-aligned box around the body turned by `rotation`, about its origin (m).
    fn extents(&self, crust: f64, rotation: &Mat3) -> (Vec3, Vec3);

    /// Where the line start + s·along enters and leaves the body, to rounding (s in m).
    fn chord(&self, crust: f64, start: &Vec3, along: &Vec3) -> Option<(f64, f64)>;

    /// Distance along a unit direction from a point within to the surface of the body (m).
    fn exit(&self, crust: f64, point: &Vec3, direction: &Vec3) -> f64;

    /// Calls `visit` with distance (m) and outward unit normal of places on the surface, the closest among them, whose
    /// normals go through a point within; only those at a right angle to `across`, if it is given.
    fn surface_normals(&self, crust: f64, point: &Vec3, across: Option<&Vec3>, visit: impl FnMut(f64, Vec3));

    /// Calls `visit` with about `number` elements spread over the surface of the body.
    fn surface_elements(&self, crust: f64, number: usize, visit: impl FnMut(SurfaceElement));

    /// Whether one element stands for all of a piece of the surface exactly.
    fn has_exact_area(&self) -> bool;
}

/// Squares below this have lost digits: what lies across an axis by less than its root points nowhere.
pub(crate) const NO_DIRECTION: f64 = 1e-280;

/// Cosine to the axis above which a round body shows its end, below which its side.
pub(crate) const END: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Some unit vector normal to a unit vector.
pub(crate) fn normal_to(axis: &Vec3) -> Vec3 {
    let crosswise = Vec3::ith(axis.iamin(), 1.0);
    axis.cross(&crosswise).normalize()
}

/// Lowest and highest corner of the box around points (m).
pub(crate) fn bounds_of(points: &[Vec3]) -> (Vec3, Vec3) {
    points.iter().fold((points[0], points[0]), |(low, high), p| (low.inf(p), high.sup(p)))
}

/// Largest distance of a point from the origin (m).
pub(crate) fn radius_of(points: &[Vec3]) -> f64 {
    points.iter().map(Vec3::norm).fold(0.0, f64::max)
}

/// Unit vector along an axis, to the side of a value.
fn signed_axis(axis: usize, value: f64) -> Vec3 {
    let mut direction = Vec3::zeros();
    direction[axis] = 1.0_f64.copysign(value);
    direction
}

/// Calls `visit` if a normal is at a right angle to `across`.
fn offer(across: Option<&Vec3>, distance: f64, normal: Vec3, visit: &mut impl FnMut(f64, Vec3)) {
    if across.is_none_or(|axis| axis.dot(&normal).abs() < 1e-6) {
        visit(distance, normal);
    }
}
