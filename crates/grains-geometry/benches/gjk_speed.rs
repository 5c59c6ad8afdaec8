//! Nanoseconds of a warm distance query, ours and parry's, on the same moving pairs of unit size.
//!
//! Run with `cargo bench -p grains-geometry`.

use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{Core, Placement, Rotation, Simplex, Superellipsoid, Vec3};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::details::closest_points_support_map_support_map_with_params;
use parry3d_f64::query::gjk::{GJKResult, VoronoiSimplex};
use parry3d_f64::shape::{ConvexPolyhedron, Cuboid, Cylinder, SupportMap};
use std::f64::consts::FRAC_PI_2;
use std::hint::black_box;
use std::time::Instant;

const PAIRS: usize = 200;
const STEPS: usize = 40;
const REPEATS: usize = 25;
/// Motion of a step, in sizes and radians.
const MOTION: f64 = 1e-4;

/// One pair on its way: where B is in the frame of A at each step.
struct Path {
    rotations: Vec<Rotation>,
    translations: Vec<Vec3>,
}

fn main() {
    let icosahedron = icosahedron();
    let icosahedron_points = icosahedron.iter().map(|v| Vector::new(v.x, v.y, v.z)).collect::<Vec<_>>();
    let hull = ConvexPolyhedron::from_convex_hull(&icosahedron_points).expect("an icosahedron is a hull");
    println!("{:<14}{:>8}{:>10}{:>10}{:>12}", "pair", "gap", "ours/ns", "parry/ns", "beyond/ns");
    for gap in [0.02, 0.2] {
        compare(
            "cube",
            &Core::Box(Vec3::repeat(0.5)),
            &Cuboid::new(Vector::new(0.5, 0.5, 0.5)),
            gap,
            Rotation::identity(),
        );
        compare("icosahedron", &Core::polyhedron(icosahedron.clone()), &hull, gap, Rotation::identity());
        let to_parry = Rotation::from_scaled_axis(Vec3::new(FRAC_PI_2, 0.0, 0.0));
        compare(
            "cylinder",
            &Core::Cylinder { radius: 0.5, half_height: 0.5 },
            &Cylinder::new(0.5, 0.5),
            gap,
            to_parry,
        );
    }
    superellipsoids();
}

/// Ours alone, for there is no other: pairs of one superellipsoid, and of it with other cores.
fn superellipsoids() {
    let core = |semi_axes: [f64; 3], eps: [f64; 2]| {
        let body = Superellipsoid::new(Vec3::from(semi_axes), eps).expect("in range");
        let crust = 0.02 * body.inscribed_radius();
        let core = if eps.iter().all(|e| *e <= 1.0) { body.eroded(crust) } else { body.rounded(crust) };
        Core::superellipsoid(core)
    };
    let ellipsoid = core([1.0, 0.5, 0.5], [1.0, 1.0]);
    let block = core([0.5, 0.5, 0.5], [0.25, 0.25]);
    let pairs = [
        ("ellipsoid 2:1:1", ellipsoid.clone(), ellipsoid.clone()),
        ("block 0.25", block.clone(), block.clone()),
        ("block 0.5", core([0.6, 0.5, 0.4], [0.5, 0.5]), core([0.6, 0.5, 0.4], [0.5, 0.5])),
        ("block 0.3", core([0.6, 0.5, 0.4], [0.3, 0.3]), core([0.6, 0.5, 0.4], [0.3, 0.3])),
        ("cylinder 0.1, 1", core([0.5, 0.5, 0.5], [0.1, 1.0]), core([0.5, 0.5, 0.5], [0.1, 1.0])),
        ("0.7, 0.4", core([0.6, 0.5, 0.4], [0.7, 0.4]), core([0.6, 0.5, 0.4], [0.7, 0.4])),
        ("edges 1.5", core([0.6, 0.5, 0.4], [1.5, 1.5]), core([0.6, 0.5, 0.4], [1.5, 1.5])),
        ("octahedron", core([0.5, 0.5, 0.5], [2.0, 2.0]), core([0.5, 0.5, 0.5], [2.0, 2.0])),
        ("ellipsoid-sphere", ellipsoid.clone(), Core::Point),
        ("block-sphere", block.clone(), Core::Point),
        ("ellipsoid-box", ellipsoid.clone(), Core::Box(Vec3::repeat(0.5))),
        ("block-icosahedron", block.clone(), Core::polyhedron(icosahedron())),
        ("ellipsoid-cylinder", ellipsoid, Core::Cylinder { radius: 0.5, half_height: 0.5 }),
        ("block-cylinder", block, Core::Cylinder { radius: 0.5, half_height: 0.5 }),
    ];
    println!("\n{:<20}{:>8}{:>10}{:>12}", "pair", "gap", "ours/ns", "beyond/ns");
    for gap in [1e-3, 0.02, 0.2] {
        for (name, a, b) in &pairs {
            let paths: Vec<Path> = (0..PAIRS).map(|seed| path(a, b, gap, seed as u64)).collect();
            let placements: Vec<Vec<Placement>> = paths.iter().map(Path::placements).collect();
            let query = |cutoff: f64| {
                time(&placements, Simplex::default(), |placement, simplex| {
                    black_box(distance(a, b, placement, cutoff, simplex).expect("converges"));
                })
            };
            println!("{name:<20}{gap:>8}{:>10.1}{:>12.1}", query(1.0), query(0.5 * gap));
        }
    }
}

/// Times both on the same paths; `frame` turns parry's cylinder axis (y) to ours (z).
fn compare(name: &str, core: &Core, shape: &impl SupportMap, gap: f64, frame: Rotation) {
    let paths: Vec<Path> = (0..PAIRS).map(|seed| path(core, core, gap, seed as u64)).collect();
    let placements: Vec<Vec<Placement>> = paths.iter().map(Path::placements).collect();
    let poses: Vec<Vec<Pose>> = paths.iter().map(|path| path.poses(&frame)).collect();
    let ours = time(&placements, Simplex::default(), |placement, simplex| {
        black_box(distance(core, core, placement, 1.0, simplex).expect("converges"));
    });
    let beyond = time(&placements, Simplex::default(), |placement, simplex| {
        black_box(distance(core, core, placement, 0.5 * gap, simplex).expect("converges"));
    });
    let parry = time(&poses, None, |pose, direction: &mut Option<Vector>| {
        let mut simplex = VoronoiSimplex::new();
        let answer = closest_points_support_map_support_map_with_params(
            pose,
            shape,
            shape,
            1.0,
            &mut simplex,
            *direction,
        );
        if let GJKResult::ClosestPoints(p, q, _) = black_box(answer) {
            *direction = Some(q - p);
        }
    });
    println!("{name:<14}{gap:>8}{ours:>10.1}{parry:>10.1}{beyond:>12.1}");
}

/// Mean time of `query` over the steps of all pairs but the first (ns).
fn time<T, M: Clone>(paths: &[Vec<T>], cold: M, mut query: impl FnMut(&T, &mut M)) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..REPEATS {
        let mut memories = vec![cold.clone(); paths.len()];
        for (path, memory) in paths.iter().zip(&mut memories) {
            query(&path[0], memory);
        }
        let start = Instant::now();
        for step in 1..STEPS {
            for (path, memory) in paths.iter().zip(&mut memories) {
                query(&path[step], memory);
            }
        }
        best = best.min(start.elapsed().as_secs_f64());
    }
    best * 1e9 / (paths.len() * (STEPS - 1)) as f64
}

/// A random orientation at the given gap, then steady slow motion.
fn path(a: &Core, b: &Core, gap: f64, seed: u64) -> Path {
    let mut random = Random(seed);
    let mut rotation = Rotation::from_scaled_axis(random.vector() * 3.0);
    let mut translation = random.vector().normalize() * 4.0;
    let placement = Placement { matrix: rotation.to_rotation_matrix().into_inner(), translation };
    let answer = distance(a, b, &placement, f64::INFINITY, &mut Simplex::default());
    if let Ok(Separation::Apart { distance, normal, .. }) = answer {
        translation -= normal * (distance - gap);
    }
    let spin = Rotation::from_scaled_axis(random.vector().normalize() * MOTION);
    let drift = random.vector().normalize() * MOTION;
    let mut path = Path { rotations: Vec::new(), translations: Vec::new() };
    for _ in 0..STEPS {
        path.rotations.push(rotation);
        path.translations.push(translation);
        rotation = spin * rotation;
        translation += drift;
    }
    path
}

impl Path {
    fn placements(&self) -> Vec<Placement> {
        let place = |(r, t): (&Rotation, &Vec3)| Placement {
            matrix: r.to_rotation_matrix().into_inner(),
            translation: *t,
        };
        self.rotations.iter().zip(&self.translations).map(place).collect()
    }

    fn poses(&self, frame: &Rotation) -> Vec<Pose> {
        let pose = |(r, t): (&Rotation, &Vec3)| {
            let turn = (frame.inverse() * r * frame).scaled_axis();
            let shift = frame.inverse() * t;
            Pose::new(Vector::new(shift.x, shift.y, shift.z), Vector::new(turn.x, turn.y, turn.z))
        };
        self.rotations.iter().zip(&self.translations).map(pose).collect()
    }
}

/// The generator SplitMix64.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::from_fn(|_, _| 2.0 * self.unit() - 1.0)
    }
}

fn icosahedron() -> Vec<Vec3> {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut vertices = Vec::new();
    for (x, y) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
        vertices.extend([Vec3::new(0.0, x, y), Vec3::new(x, y, 0.0), Vec3::new(y, 0.0, x)]);
    }
    vertices.iter().map(|v| v * (0.5 / v.norm())).collect()
}
