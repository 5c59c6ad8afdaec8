//! Random pairs of cores and the certificates of a query's answer.
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{Cone, Core, Face, Placement, Rotation, Simplex, Vec3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// The generator SplitMix64.
pub struct Random(pub u64);

impl Random {
    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in the logarithm.
    pub fn log(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> Vec3 {
        let z = 2.0 * self.unit() - 1.0;
        let (s, c) = (TAU * self.unit()).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * c, r * s, z)
    }

    pub fn rotation(&mut self) -> Rotation {
        let axis = self.direction();
        Rotation::from_scaled_axis(axis * (self.unit() * 2.0 * FRAC_PI_2))
    }

    /// A rotation that lays axes parallel, exactly or up to an angle between 1e-16 and 1e-2.
    pub fn aligned(&mut self) -> Rotation {
        let quarter = |n: usize| n as f64 * FRAC_PI_2;
        let lay =
            Rotation::from_euler_angles(quarter(self.below(4)), quarter(self.below(4)), TAU * self.unit());
        match self.below(3) {
            0 => Rotation::from_euler_angles(
                quarter(self.below(4)),
                quarter(self.below(4)),
                quarter(self.below(4)),
            ),
            1 => lay,
            _ => {
                let angle = self.log(1e-16, 1e-2);
                let axis = self.direction();
                Rotation::from_scaled_axis(axis * angle) * lay
            }
        }
    }

    /// A core of the kind, of longest extent about 1, the others down to 1/`slenderness`.
    pub fn core(&mut self, kind: Kind, slenderness: f64) -> Core {
        match kind {
            Kind::Point => Core::Point,
            Kind::Box => Core::Box(self.extents(slenderness)),
            Kind::Cylinder => {
                let e = self.extents(slenderness);
                Core::Cylinder { radius: e.x, half_height: e.y }
            }
            Kind::Segment => Core::Segment { half_length: self.extents(slenderness).x },
            Kind::Cone => {
                let e = self.extents(slenderness);
                let share = [0.0, self.unit(), 1.0][self.below(3)];
                let radii = if self.below(2) == 0 { [e.x, e.x * share] } else { [e.x * share, e.x] };
                let middle = self.unit();
                Core::Cone(Cone { heights: [-middle * e.y, (2.0 - middle) * e.y], radii })
            }
            Kind::Icosahedron => Core::polyhedron(icosahedron()),
            Kind::Hull => {
                let e = self.extents(slenderness);
                let n = 4 + self.below(40);
                Core::polyhedron((0..n).map(|_| self.direction().component_mul(&e)).collect())
            }
            Kind::Triangle => {
                let e = self.extents(slenderness);
                let turn = self.rotation();
                Core::Triangle([0, 1, 2].map(|_| turn * Vec3::new(e.x * self.unit(), e.y * self.unit(), 0.0)))
            }
        }
    }

    fn extents(&mut self, slenderness: f64) -> Vec3 {
        let mut e = Vec3::from_fn(|_, _| self.log(1.0 / slenderness, 1.0));
        let longest = self.below(3);
        e[longest] = 1.0;
        e
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Point,
    Segment,
    Box,
    Cylinder,
    Cone,
    Icosahedron,
    Hull,
    Triangle,
}

impl Kind {
    pub fn is_curved(self) -> bool {
        matches!(self, Self::Cylinder | Self::Cone)
    }
}

/// The kinds that random pairs are drawn from; capsules and cones have tests of their own.
pub const KINDS: [Kind; 6] =
    [Kind::Point, Kind::Box, Kind::Cylinder, Kind::Icosahedron, Kind::Hull, Kind::Triangle];

pub fn icosahedron() -> Vec<Vec3> {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut vertices = Vec::new();
    for (x, y) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
        vertices.extend([Vec3::new(0.0, x, y), Vec3::new(x, y, 0.0), Vec3::new(y, 0.0, x)]);
    }
    vertices.iter().map(|v| v / v.norm()).collect()
}

/// The core magnified.
pub fn scaled(core: &Core, s: f64) -> Core {
    match core {
        Core::Point => Core::Point,
        Core::Segment { half_length } => Core::Segment { half_length: half_length * s },
        Core::Cone(Cone { heights, radii }) => {
            Core::Cone(Cone { heights: heights.map(|z| z * s), radii: radii.map(|r| r * s) })
        }
        Core::Box(half) => Core::Box(half * s),
        Core::Cylinder { radius, half_height } => {
            Core::Cylinder { radius: radius * s, half_height: half_height * s }
        }
        Core::Polyhedron(hull) => {
            let faces = hull.faces().iter().map(|f| Face { offset: f.offset * s, ..f.clone() }).collect();
            Core::polyhedron_with_faces(hull.vertices().iter().map(|v| v * s).collect(), faces)
        }
        Core::Triangle(corners) => Core::Triangle(corners.map(|v| v * s)),
        Core::Superellipsoid(body) => Core::superellipsoid(body.magnified(s)),
    }
}

pub fn place(rotation: &Rotation, scale: f64, translation: Vec3) -> Placement {
    Placement { matrix: rotation.to_rotation_matrix().into_inner() * scale, translation }
}

/// Whether `point`, in the core's frame, is in it up to `slack` (m).
pub fn holds(core: &Core, point: &Vec3, slack: f64) -> bool {
    let inside_box = |half: &Vec3| point.iter().zip(half.iter()).all(|(x, h)| x.abs() <= h + slack);
    match core {
        Core::Point => point.norm() <= slack,
        Core::Segment { half_length } => point.xy().norm() <= slack && point.z.abs() <= half_length + slack,
        Core::Cone(Cone { heights: [low, high], radii: [bottom, top] }) => {
            let slope = (top - bottom) / (high - low);
            let side = point.xy().norm() - bottom - slope * (point.z - low);
            low - slack <= point.z && point.z <= high + slack && side <= slack * 1.0_f64.hypot(slope)
        }
        Core::Box(half) => inside_box(half),
        Core::Cylinder { radius, half_height } => {
            point.xy().norm() <= radius + slack && point.z.abs() <= half_height + slack
        }
        // Less the inset: as deep as the inset, seen in random directions about that of the point.
        Core::Superellipsoid(_) => {
            let mut random = Random(11);
            let outward = point.try_normalize(0.0).unwrap_or_else(Vec3::x);
            (0..20)
                .map(|k| (outward + random.direction() * (f64::from(k) / 10.0)).normalize())
                .all(|d| d.dot(point) <= d.dot(&core.support(&d)) + slack)
        }
        // Nearest point to a hull is a query of its own; planes in the six axis directions and the
        // direction from the centre must do.
        Core::Polyhedron(_) | Core::Triangle(_) => {
            let mut directions: Vec<Vec3> =
                (0..3).flat_map(|i| [Vec3::ith(i, 1.0), Vec3::ith(i, -1.0)]).collect();
            directions.extend(point.try_normalize(0.0));
            directions.iter().all(|d| d.dot(point) <= d.dot(&core.support(d)) + slack)
        }
    }
}

/// A pair with its size, the length its errors are measured by (m).
#[derive(Debug)]
pub struct Pair {
    pub a: Core,
    pub b: Core,
    pub placement: Placement,
    pub size: f64,
}

impl Pair {
    pub fn new(a: Core, b: Core, placement: Placement) -> Self {
        let scale = placement.matrix.column(0).norm();
        let size = (a.radius() + b.radius() * scale).max(placement.translation.norm());
        let size = size.max(f64::MIN_POSITIVE);
        Self { a, b, placement, size }
    }

    /// A random pair; `kinds` of shapes, near-parallel if `aligned`, `separation` between -1 and 1 in sizes.
    pub fn random(random: &mut Random, kinds: [Kind; 2], slenderness: f64, aligned: bool, size: f64) -> Self {
        let a = scaled(&random.core(kinds[0], slenderness), size);
        let b = scaled(&random.core(kinds[1], slenderness), size);
        let rotation = if aligned { random.aligned() } else { random.rotation() };
        let scale = random.log(0.5, 2.0);
        let reach = a.radius() + b.radius() * scale;
        let translation = random.direction() * (reach * (0.2 + random.unit()));
        Self::new(a, b, place(&rotation, scale, translation))
    }

    /// The pair moved along its normal to the given distance, if it is apart.
    pub fn at_distance(mut self, target: f64) -> Self {
        if let Separation::Apart { distance, normal, .. } = self.query(&mut Simplex::default()) {
            self.placement.translation -= normal * (distance - target);
        }
        self
    }

    /// The pair with B turned and shifted by `motion` radians and sizes.
    pub fn moved(&self, random: &mut Random, motion: f64) -> Self {
        let turn = Rotation::from_scaled_axis(random.direction() * motion).to_rotation_matrix().into_inner();
        let translation = self.placement.translation + random.direction() * (motion * self.size);
        let placement = Placement { matrix: turn * self.placement.matrix, translation };
        Self { a: self.a.clone(), b: self.b.clone(), placement, size: self.size }
    }

    /// The pair with the cores exchanged.
    pub fn exchanged(&self) -> Self {
        Self::new(self.b.clone(), self.a.clone(), self.placement.inverse())
    }

    /// The pair magnified.
    pub fn magnified(&self, s: f64) -> Self {
        let Placement { matrix, translation } = self.placement;
        let placement = Placement { matrix, translation: translation * s };
        Self::new(scaled(&self.a, s), scaled(&self.b, s), placement)
    }

    /// Distance (m), zero if the cores meet.
    pub fn distance(&self, simplex: &mut Simplex) -> f64 {
        match self.query(simplex) {
            Separation::Apart { distance, .. } => distance,
            _ => 0.0,
        }
    }

    pub fn query(&self, simplex: &mut Simplex) -> Separation {
        distance(&self.a, &self.b, &self.placement, f64::INFINITY, simplex).expect("converges")
    }

    /// Lower bound of the distance from the planes across `normal` (m).
    pub fn lower_bound(&self, normal: &Vec3) -> f64 {
        let b = self.placement.apply(&self.b.support(&-self.placement.matrix.tr_mul(normal)));
        normal.dot(&(b - self.a.support(normal)))
    }

    /// Gap (m) across planes of a normal of any length, by how far the cores reach.
    pub fn gap_across(&self, axis: &Vec3) -> f64 {
        let reach = self.a.support_value(axis) + self.b.support_value(&-self.placement.matrix.tr_mul(axis));
        (axis.dot(&self.placement.translation) - reach) / axis.norm()
    }

    /// Duality gap of an answer relative to the size, whichever bound is the higher; panics if it is no answer.
    pub fn certify(&self, answer: &Separation) -> f64 {
        self.gap_of(answer, 1e-13).unwrap_or_else(|reason| panic!("{reason}"))
    }

    /// Duality gap of an answer relative to the size, whichever bound is the higher; or why it is no answer.
    /// The points may be off their bodies by `off` of the size.
    pub fn gap_of(&self, answer: &Separation, off: f64) -> Result<f64, String> {
        let Separation::Apart { distance, normal, point_a, point_b } = answer else { return Ok(0.0) };
        let slack = off * self.size;
        let scale2 = self.placement.matrix.column(0).norm_squared();
        let in_b = self.placement.matrix.tr_mul(&(point_b - self.placement.translation)) / scale2;
        let across = (point_b - point_a - normal * *distance).norm();
        let reason = if !holds(&self.a, point_a, slack) {
            "witness off A"
        } else if !holds(&self.b, &in_b, slack / scale2.sqrt()) {
            "witness off B"
        } else if (normal.norm() - 1.0).abs() >= 1e-14 {
            "normal not of length 1"
        } else if across >= 1e-13 * self.size || across.is_nan() {
            "points not the distance apart along the normal"
        } else {
            return Ok((distance - self.lower_bound(normal)).abs() / self.size);
        };
        Err(reason.to_string())
    }
}
