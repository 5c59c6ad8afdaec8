//! The convex cores of bodies and their support mapping.

use crate::superellipsoid::Superellipsoid;
use crate::{Face, Mat3, Vec3};
use std::sync::Arc;

/// A convex core, centred on its own frame's origin, in metres at scale 1.
#[derive(Clone, Debug)]
pub enum Core {
    /// The origin alone (a sphere is this with its radius for crust).
    Point,
    /// Axis-aligned box of the given half edges (m).
    Box(Vec3),
    /// Cylinder about z: radius and half height (m).
    Cylinder {
        /// Radius (m).
        radius: f64,
        /// Half of the height (m).
        half_height: f64,
    },
    /// Convex hull of the given vertices (m).
    Polyhedron(Arc<Polyhedron>),
    /// A triangle of a wall mesh (m).
    Triangle([Vec3; 3]),
    /// Superellipsoid less an inset (m).
    Superellipsoid(Arc<Superellipsoid>),
}

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
        match self {
            Self::Point => Vec3::zeros(),
            Self::Box(half) => BoxCore(*half).farthest(direction),
            Self::Cylinder { radius, half_height } => {
                CylinderCore { radius: *radius, half_height: *half_height }.farthest(direction)
            }
            Self::Polyhedron(hull) => hull.farthest(direction),
            Self::Triangle(corners) => TriangleCore(*corners).farthest(direction),
            Self::Superellipsoid(body) => body.farthest(direction),
        }
    }

    /// Support function, max d·x: how far the core reaches along `direction`, in metres times its length.
    #[inline]
    pub fn reach(&self, direction: &Vec3) -> f64 {
        match self {
            Self::Point => 0.0,
            Self::Box(half) => BoxCore(*half).height(direction),
            Self::Cylinder { radius, half_height } => {
                CylinderCore { radius: *radius, half_height: *half_height }.height(direction)
            }
            Self::Polyhedron(hull) => hull.height(direction),
            Self::Triangle(corners) => TriangleCore(*corners).height(direction),
            Self::Superellipsoid(body) => body.height(direction),
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
        let farthest = |points: &mut dyn Iterator<Item = Vec3>| {
            points.fold((Vec3::zeros(), -1.0), |(best, most), p| {
                let distance = away(&p).norm_squared();
                if distance > most { (p, distance) } else { (best, most) }
            })
        };
        let corner =
            |half: &Vec3, k: usize| Vec3::from_fn(|a, _| if k >> a & 1 == 0 { half[a] } else { -half[a] });
        match self {
            Self::Point => Vec3::zeros(),
            Self::Box(half) => farthest(&mut (0..8).map(|k| corner(half, k))).0,
            Self::Polyhedron(hull) => farthest(&mut hull.vertices.iter().copied()).0,
            Self::Triangle(corners) => farthest(&mut corners.iter().copied()).0,
            Self::Cylinder { .. } | Self::Superellipsoid(_) => {
                let outward = away(&Vec3::zeros());
                let distance = outward.norm();
                let start = if distance > 0.0 { outward / distance } else { normal_to(axis) };
                let sideways = axis.cross(&start);
                let (radius, steps) = (self.radius(), 4);
                let widest =
                    if distance > radius { (radius / distance).asin() } else { std::f64::consts::PI };
                let climbed = (-steps..=steps).map(|k| {
                    let (sin, cos) = (widest * f64::from(k) / f64::from(steps)).sin_cos();
                    self.climb_from_axis(start * cos + sideways * sin, away)
                });
                farthest(&mut climbed.into_iter()).0
            }
        }
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

    /// Lowest and highest corner of the axis-aligned bounding box in the core's frame (m).
    pub fn bounds(&self) -> (Vec3, Vec3) {
        match self {
            Self::Point => (Vec3::zeros(), Vec3::zeros()),
            Self::Box(half) => (-half, *half),
            Self::Cylinder { radius, half_height } => {
                let half = Vec3::new(*radius, *radius, *half_height);
                (-half, half)
            }
            Self::Polyhedron(hull) => bounds_of(&hull.vertices),
            Self::Triangle(corners) => bounds_of(corners),
            Self::Superellipsoid(body) => {
                let half = body.semi_axes().add_scalar(-body.inset());
                (-half, half)
            }
        }
    }

    /// Radius of the smallest ball about the frame's origin that holds the core (m).
    pub fn radius(&self) -> f64 {
        match self {
            Self::Point => 0.0,
            Self::Box(half) => half.norm(),
            Self::Cylinder { radius, half_height } => radius.hypot(*half_height),
            Self::Polyhedron(hull) => hull.radius,
            Self::Triangle(corners) => radius_of(corners),
            Self::Superellipsoid(body) => body.bounding_radius() - body.inset(),
        }
    }
}

/// Vertices of a convex polyhedron, also laid out for a vectorised support scan.
#[derive(Clone, Debug)]
pub struct Polyhedron {
    vertices: Vec<Vec3>,
    /// x, y, z of four vertices at a time; the last group is filled up with the first vertex.
    lanes: Vec<[[f64; LANES]; 3]>,
    /// Largest distance of a vertex from the origin (m).
    radius: f64,
    faces: Vec<Face>,
}

const LANES: usize = 4;

impl Polyhedron {
    fn new(vertices: Vec<Vec3>, faces: Vec<Face>) -> Self {
        assert!(!vertices.is_empty(), "a polyhedron needs at least one vertex");
        let lanes = vertices
            .chunks(LANES)
            .map(|group| {
                std::array::from_fn(|axis| {
                    std::array::from_fn(|lane| group.get(lane).unwrap_or(&vertices[0])[axis])
                })
            })
            .collect();
        let radius = radius_of(&vertices);
        Self { vertices, lanes, radius, faces }
    }

    /// The flat faces, as loops of vertex numbers; none if the vertices span no volume.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// The vertices, in the order given (m).
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }
}

/// Support mapping of one kind of core; the distance loop is compiled once for each pair of kinds.
pub(crate) trait Support {
    /// Whether the core has curved parts, so that its support points are not a finite set.
    const CURVED: bool;

    /// Whether the core may have flat faces.
    const FACED: bool = false;

    /// Point farthest along `direction`, which need not be of unit length.
    fn farthest(&self, direction: &Vec3) -> Vec3;

    /// Support function max d·x: what [`Support::farthest`] reaches, at less cost.
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

    /// The cylinder, if the core is one.
    fn cylinder(&self) -> Option<&CylinderCore> {
        None
    }

    /// The superellipsoid, if the core is one.
    fn superellipsoid(&self) -> Option<&Superellipsoid> {
        None
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

/// The origin.
pub(crate) struct PointCore;

impl Support for PointCore {
    const CURVED: bool = false;

    #[inline]
    fn farthest(&self, _direction: &Vec3) -> Vec3 {
        Vec3::zeros()
    }

    #[inline]
    fn height(&self, _direction: &Vec3) -> f64 {
        0.0
    }

    fn extent(&self) -> f64 {
        0.0
    }
}

/// Box of half edges (m).
pub(crate) struct BoxCore(pub Vec3);

impl Support for BoxCore {
    const CURVED: bool = false;
    const FACED: bool = true;

    #[inline(always)]
    fn facing(&self, direction: &Vec3) -> Option<FacePlane> {
        let [x, y, z] = direction.abs().into();
        let number = if x >= y && x >= z { 0 } else { 2 - usize::from(y >= z) };
        let side = |k: usize| if k == number { 1.0_f64.copysign(direction[k]) } else { 0.0 };
        Some(FacePlane { number, normal: Vec3::new(side(0), side(1), side(2)), offset: self.0[number] })
    }

    #[inline(always)]
    fn is_below(&self, face: &FacePlane, point: &Vec3) -> bool {
        (0..3).all(|k| k == face.number || point[k].abs() <= self.0[k])
    }

    #[inline(always)]
    fn corners(&self, face: &FacePlane, to: &mut [Vec3]) -> Option<usize> {
        let (j, k) = ((face.number + 1) % 3, (face.number + 2) % 3);
        let signs = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
        for (corner, (sign_j, sign_k)) in to.get_mut(..4)?.iter_mut().zip(signs) {
            *corner = face.normal * face.offset;
            (corner[j], corner[k]) = (sign_j * self.0[j], sign_k * self.0[k]);
        }
        Some(4)
    }

    #[inline(always)]
    fn farthest(&self, direction: &Vec3) -> Vec3 {
        self.0.zip_map(direction, f64::copysign)
    }

    #[inline(always)]
    fn height(&self, direction: &Vec3) -> f64 {
        self.0.dot(&direction.abs())
    }

    #[inline(always)]
    fn extent(&self) -> f64 {
        self.0.x + self.0.y + self.0.z
    }
}

/// Squares below this have lost digits: what lies across an axis by less than its root points nowhere.
pub(crate) const NO_DIRECTION: f64 = 1e-280;

/// Cylinder about z.
pub(crate) struct CylinderCore {
    pub radius: f64,
    pub half_height: f64,
}

impl Support for CylinderCore {
    const CURVED: bool = true;

    #[inline(always)]
    fn farthest(&self, direction: &Vec3) -> Vec3 {
        let squared = direction.x * direction.x + direction.y * direction.y;
        let z = self.half_height.copysign(direction.z);
        if squared > NO_DIRECTION {
            let scale = self.radius / squared.sqrt();
            Vec3::new(direction.x * scale, direction.y * scale, z)
        } else {
            Vec3::new(self.radius, 0.0, z)
        }
    }

    #[inline(always)]
    fn height(&self, direction: &Vec3) -> f64 {
        let radial = (direction.x * direction.x + direction.y * direction.y).sqrt();
        self.radius * radial + self.half_height * direction.z.abs()
    }

    #[inline(always)]
    fn extent(&self) -> f64 {
        self.radius + self.half_height
    }

    #[inline(always)]
    fn cylinder(&self) -> Option<&CylinderCore> {
        Some(self)
    }
}

impl Support for Polyhedron {
    const CURVED: bool = false;
    const FACED: bool = true;

    #[inline]
    fn facing(&self, direction: &Vec3) -> Option<FacePlane> {
        let mut best = (0, f64::NEG_INFINITY);
        for (number, face) in self.faces.iter().enumerate() {
            let along = face.normal.dot(direction);
            if along > best.1 {
                best = (number, along);
            }
        }
        let Face { normal, offset, .. } = self.faces.get(best.0)?;
        Some(FacePlane { number: best.0, normal: *normal, offset: *offset })
    }

    #[inline]
    fn is_below(&self, face: &FacePlane, point: &Vec3) -> bool {
        let corners = &self.faces[face.number].vertices;
        let mut last = corners.last().copied().unwrap_or(0);
        corners.iter().all(|&next| {
            let (from, to) = (self.vertices[last as usize], self.vertices[next as usize]);
            last = next;
            (to - from).cross(&(point - from)).dot(&face.normal) >= 0.0
        })
    }

    #[inline]
    fn corners(&self, face: &FacePlane, to: &mut [Vec3]) -> Option<usize> {
        let corners = &self.faces[face.number].vertices;
        let to = to.get_mut(..corners.len())?;
        to.iter_mut().zip(corners).for_each(|(to, &k)| *to = self.vertices[k as usize]);
        Some(corners.len())
    }

    #[inline]
    fn farthest(&self, direction: &Vec3) -> Vec3 {
        let mut best = [f64::NEG_INFINITY; LANES];
        let mut group = [0; LANES];
        for (number, points) in self.lanes.iter().enumerate() {
            let heights = heights(points, direction);
            for lane in 0..LANES {
                let higher = heights[lane] > best[lane];
                best[lane] = if higher { heights[lane] } else { best[lane] };
                group[lane] = if higher { number } else { group[lane] };
            }
        }
        let pick = |i: usize, j: usize| if best[j] > best[i] { j } else { i };
        let (low, high) = (pick(0, 1), pick(2, 3));
        let lane = pick(low, high);
        let [x, y, z] = &self.lanes[group[lane]];
        Vec3::new(x[lane], y[lane], z[lane])
    }

    /// Four running maxima side by side: no branch in the scan.
    #[inline]
    fn height(&self, direction: &Vec3) -> f64 {
        let mut best = [f64::NEG_INFINITY; LANES];
        for points in &self.lanes {
            let heights = heights(points, direction);
            for lane in 0..LANES {
                best[lane] = larger(heights[lane], best[lane]);
            }
        }
        larger(larger(best[0], best[1]), larger(best[2], best[3]))
    }

    #[inline(always)]
    fn extent(&self) -> f64 {
        self.radius
    }
}

/// d·x of four points.
#[inline(always)]
fn heights([x, y, z]: &[[f64; LANES]; 3], direction: &Vec3) -> [f64; LANES] {
    std::array::from_fn(|lane| x[lane] * direction.x + y[lane] * direction.y + z[lane] * direction.z)
}

/// The larger of two numbers, one machine instruction where `f64::max` must mind NaN.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Triangle (m).
pub(crate) struct TriangleCore(pub [Vec3; 3]);

impl Support for TriangleCore {
    const CURVED: bool = false;

    #[inline(always)]
    fn farthest(&self, direction: &Vec3) -> Vec3 {
        let [a, b, c] = &self.0;
        let (ha, hb, hc) = (a.dot(direction), b.dot(direction), c.dot(direction));
        let (first, height) = if hb > ha { (b, hb) } else { (a, ha) };
        if hc > height { *c } else { *first }
    }

    #[inline(always)]
    fn height(&self, direction: &Vec3) -> f64 {
        let [a, b, c] = self.0.map(|corner| corner.dot(direction));
        larger(larger(a, b), c)
    }

    #[inline(always)]
    fn extent(&self) -> f64 {
        self.0.iter().fold(0.0, |extent, corner| corner.amax().max(extent))
    }
}

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

fn bounds_of(points: &[Vec3]) -> (Vec3, Vec3) {
    points.iter().fold((points[0], points[0]), |(low, high), p| (low.inf(p), high.sup(p)))
}

/// Some unit vector normal to a unit vector.
pub(crate) fn normal_to(axis: &Vec3) -> Vec3 {
    let least = Vec3::ith(axis.iamin(), 1.0);
    axis.cross(&least).normalize()
}

fn radius_of(points: &[Vec3]) -> f64 {
    points.iter().map(Vec3::norm).fold(0.0, f64::max)
}
