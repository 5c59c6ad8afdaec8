//! The convex cores of bodies: the list of their kinds.

use crate::convex::cone::Cone;
use crate::convex::feature::Feature;
use crate::convex::polyhedron::Polyhedron;
use crate::convex::surface_points::SurfaceElement;
use crate::convex::{Convex, Rims, Support, normal_to};
use crate::superellipsoid::Superellipsoid;
use crate::{Face, Mat3, Vec3};
use std::sync::Arc;

/// A convex core in its own frame, in metres at scale 1.
#[derive(Clone, Debug)]
pub enum Core {
    /// The origin alone (a sphere is this with its radius for crust).
    Point,
    /// Segment of the z axis about the origin (a capsule is this with its radius for crust).
    Segment {
        /// Half of the length (m).
        half_length: f64,
    },
    /// Axis-aligned box of the given half edges (m).
    Box(Vec3),
    /// Cylinder about z: radius and half height (m).
    Cylinder {
        /// Radius (m).
        radius: f64,
        /// Half of the height (m).
        half_height: f64,
    },
    /// Cone or frustum about z.
    Cone(Cone),
    /// Convex hull of the given vertices (m).
    Polyhedron(Arc<Polyhedron>),
    /// A triangle of a wall mesh (m).
    Triangle([Vec3; 3]),
    /// Superellipsoid less an inset (m).
    Superellipsoid(Arc<Superellipsoid>),
}

/// What becomes of a core under another crust.
pub(crate) enum Crusted {
    /// The crust cannot be chosen: it is the radius of the body or was fitted to it.
    Fixed,
    /// Another core about the same origin.
    Core(Core),
    /// The erosion of the body, by its faces.
    Eroded,
}

/// Evaluates an expression of the convex body a core is: the one place that tells the kinds apart. Each kind gets its
/// own compiled code, as the distance loop needs.
macro_rules! with_convex {
    ($core:expr, $convex:ident => $value:expr) => {
        match $core {
            $crate::Core::Point => {
                let $convex = &$crate::convex::point::Point;
                $value
            }
            $crate::Core::Segment { half_length } => {
                let $convex = &$crate::convex::segment::Segment { half_length: *half_length };
                $value
            }
            $crate::Core::Box(half) => {
                let $convex = &$crate::convex::cuboid::Cuboid(*half);
                $value
            }
            $crate::Core::Cylinder { radius, half_height } => {
                let $convex =
                    &$crate::convex::cylinder::Cylinder { radius: *radius, half_height: *half_height };
                $value
            }
            $crate::Core::Cone($convex) => $value,
            $crate::Core::Polyhedron(hull) => {
                let $convex = hull.as_ref();
                $value
            }
            $crate::Core::Triangle(corners) => {
                let $convex = &$crate::convex::triangle::Triangle(*corners);
                $value
            }
            $crate::Core::Superellipsoid(body) => {
                let $convex = body.as_ref();
                $value
            }
        }
    };
}
pub(crate) use with_convex;

impl Core {
    /// Convex hull of `vertices` (m), its faces unknown; points inside the hull are harmless but cost time.
    ///
    /// # Panics
    /// If `vertices` is empty.
    pub fn polyhedron(vertices: Vec<Vec3>) -> Self {
        Self::polyhedron_with_faces(vertices, Vec::new())
    }

    /// Convex hull of `vertices` (m) with the given faces.
    ///
    /// # Panics
    /// If `vertices` is empty.
    pub fn polyhedron_with_faces(vertices: Vec<Vec3>, faces: Vec<Face>) -> Self {
        Self::Polyhedron(Arc::new(Polyhedron::new(vertices, faces)))
    }

    /// Superellipsoid less its inset.
    pub fn superellipsoid(body: Superellipsoid) -> Self {
        Self::Superellipsoid(Arc::new(body))
    }

    /// Point of the core farthest along `direction`: argmax of d·x; any such point for a zero direction.
    pub fn support(&self, direction: &Vec3) -> Vec3 {
        with_convex!(self, convex => convex.farthest(direction))
    }

    /// Support value max d·x of a direction of any length (m times that length).
    #[inline]
    pub fn support_value(&self, direction: &Vec3) -> f64 {
        with_convex!(self, convex => convex.height(direction))
    }

    /// Whether the core has curved parts, so that its support points are not a finite set.
    pub(crate) fn is_curved(&self) -> bool {
        fn of<S: Support>(_: &S) -> bool {
            S::CURVED
        }
        with_convex!(self, convex => of(convex))
    }

    /// Lowest and highest corner of the axis-aligned bounding box in the core's frame (m).
    pub fn bounds(&self) -> (Vec3, Vec3) {
        with_convex!(self, convex => convex.bounds())
    }

    /// Radius of the smallest ball about the frame's origin that holds the core (m).
    pub fn radius(&self) -> f64 {
        with_convex!(self, convex => convex.radius())
    }

    /// Calls `visit` with the points whose hull the core is; with none of a curved core.
    #[inline]
    fn for_each_vertex(&self, visit: impl FnMut(Vec3)) {
        with_convex!(self, convex => convex.for_each_vertex(visit));
    }

    /// Largest distance of the core with a crust (m) from the origin of a frame in which it is turned and moved (m), or
    /// somewhat more.
    pub(crate) fn largest_distance(&self, crust: f64, rotation: &Mat3, center: &Vec3) -> f64 {
        with_convex!(self, convex => convex.largest_distance(crust, rotation, center))
    }

    /// From a point to the nearest point of the core (m), zero inside; `None` without a closed form.
    #[inline]
    pub(crate) fn offset_from(&self, point: &Vec3) -> Option<Vec3> {
        with_convex!(self, convex => convex.offset_from(point))
    }

    /// Finds the face or line that looks most along a unit `direction`; `None` if contacts there are points.
    #[inline]
    pub(crate) fn contact_feature(&self, direction: &Vec3, found: &mut Feature) -> Option<()> {
        with_convex!(self, convex => convex.contact_feature(direction, found))
    }

    /// Whether a point lies in the body with sharp edges of which this is the core under a crust (m).
    #[inline]
    pub(crate) fn contains(&self, crust: f64, point: &Vec3) -> bool {
        with_convex!(self, convex => convex.contains(crust, point))
    }

    /// Corners of the axis-aligned box around that body turned by `rotation`, about its origin (m).
    pub(crate) fn extents(&self, crust: f64, rotation: &Mat3) -> (Vec3, Vec3) {
        with_convex!(self, convex => convex.extents(crust, rotation))
    }

    /// Where the line start + s·along enters and leaves that body (s in m).
    pub(crate) fn chord(&self, crust: f64, start: &Vec3, along: &Vec3) -> Option<(f64, f64)> {
        with_convex!(self, convex => convex.chord(crust, start, along))
    }

    /// Distance along a unit direction from a point within to the surface of that body (m).
    pub(crate) fn exit(&self, crust: f64, point: &Vec3, direction: &Vec3) -> f64 {
        with_convex!(self, convex => convex.exit(crust, point, direction))
    }

    /// Calls `visit` with distance (m) and outward unit normal of places on that body's surface, the closest among them.
    pub(crate) fn surface_normals(
        &self,
        crust: f64,
        point: &Vec3,
        across: Option<&Vec3>,
        visit: impl FnMut(f64, Vec3),
    ) {
        with_convex!(self, convex => convex.surface_normals(crust, point, across, visit));
    }

    /// Calls `visit` with about `number` elements spread over that body's surface.
    pub(crate) fn surface_elements(&self, crust: f64, number: usize, visit: impl FnMut(SurfaceElement)) {
        with_convex!(self, convex => convex.surface_elements(crust, number, visit));
    }

    /// Whether one element stands for all of a piece of that surface exactly.
    pub(crate) fn has_exact_area(&self) -> bool {
        with_convex!(self, convex => convex.has_exact_area())
    }

    /// The core of the same body under another crust (m).
    pub(crate) fn with_crust(&self, present: f64, wanted: f64) -> Crusted {
        let thinner = present - wanted;
        match self {
            Self::Box(half) => Crusted::Core(Self::Box(half.add_scalar(thinner))),
            Self::Cylinder { radius, half_height } => {
                Crusted::Core(Self::Cylinder { radius: radius + thinner, half_height: half_height + thinner })
            }
            Self::Cone(cone) => Crusted::Core(Self::Cone(cone.grown(thinner))),
            Self::Polyhedron(_) => Crusted::Eroded,
            Self::Point | Self::Segment { .. } | Self::Triangle(_) | Self::Superellipsoid(_) => {
                Crusted::Fixed
            }
        }
    }

    /// The body the core is in by an inset, if it is an ellipsoid.
    #[inline(always)]
    pub fn ellipsoid(&self) -> Option<&Superellipsoid> {
        match self {
            Self::Superellipsoid(body) if body.is_ellipsoid() => Some(body),
            _ => None,
        }
    }

    /// The rims of a cylinder.
    #[inline(always)]
    pub(crate) fn rims(&self) -> Option<Rims> {
        match *self {
            Self::Cylinder { radius, half_height } => Some(Rims { radius, half_height }),
            _ => None,
        }
    }

    /// Whether the body is a polyhedron, whose corners are those of its surface.
    pub(crate) fn is_solid_polyhedron(&self) -> bool {
        match self {
            Self::Box(_) | Self::Polyhedron(_) => true,
            Self::Point
            | Self::Segment { .. }
            | Self::Cylinder { .. }
            | Self::Cone(_)
            | Self::Triangle(_)
            | Self::Superellipsoid(_) => false,
        }
    }

    /// Point of the core (m) farthest from an axis of unit direction `axis`, from a point of which the core's centre
    /// is at `center` (m), all in the core's frame.
    ///
    /// Vertices are compared. On curved cores max over x of the distance is max over θ of h(d(θ)), h the support
    /// function of the core about the axis and d(θ) normal to it; that is climbed from nine directions all over the
    /// angle under which the axis sees the core, which has found the largest in every case tried (tests/shapes.rs).
    pub fn farthest_from_axis(&self, center: &Vec3, axis: &Vec3) -> Vec3 {
        let away = |p: &Vec3| {
            let from = center + p;
            from - axis * from.dot(axis)
        };
        let mut best = (Vec3::zeros(), -1.0);
        let mut offer = |p: Vec3| {
            let distance = away(&p).norm_squared();
            if distance > best.1 {
                best = (p, distance);
            }
        };
        if !self.is_curved() {
            self.for_each_vertex(offer);
            return best.0;
        }
        let outward = away(&Vec3::zeros());
        let distance = outward.norm();
        let start = if distance > 0.0 { outward / distance } else { normal_to(axis) };
        let sideways = axis.cross(&start);
        let (radius, steps) = (self.radius(), 4);
        let widest = if distance > radius { libm::asin(radius / distance) } else { std::f64::consts::PI };
        for k in -steps..=steps {
            let (sin, cos) = libm::sincos(widest * f64::from(k) / f64::from(steps));
            offer(self.climb_from_axis(start * cos + sideways * sin, away));
        }
        best.0
    }

    /// Local maximum of the distance from an axis, `away` of which a point is: each pass asks for the point farthest
    /// along the last one's direction, and the distance can only grow.
    fn climb_from_axis(&self, mut direction: Vec3, away: impl Fn(&Vec3) -> Vec3) -> Vec3 {
        let mut distance = 0.0;
        let mut best = Vec3::zeros();
        for _ in 0..100 {
            let point = self.support(&direction);
            let off = away(&point);
            let next = off.norm();
            if next <= distance * (1.0 + 1e-15) {
                break;
            }
            (best, distance, direction) = (point, next, off / next);
        }
        best
    }
}
