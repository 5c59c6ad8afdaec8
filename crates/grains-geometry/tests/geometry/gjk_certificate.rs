//! Any pair of cores in any pose: each body of its own size of 1e-6 to 1e3 m and slenderness to 100, faces parallel, edges
//! crossed, centres on each other, bodies that just touch or just meet, lie deep in each other or far apart.
//!
//! Each pair is drawn from its own number. The tests look at some of them, and at ten million if `GRAINS_TORTURE` is set.

use crate::gjk_common::{Kind, Pair, Random, scaled};
use grains_geometry::epa::penetration;
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{ConvexHull, Core, Face, Mat3, Placement, Rotation, Shape, Simplex, Vec3};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_4, PI};
use std::time::Instant;

const SLENDERNESS: f64 = 100.0;
const SIZES: [f64; 2] = [1e-6, 1e3];
/// Bodies that take long to make, of each kind.
const STOCK: usize = 300;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Body {
    Point,
    Segment,
    Box,
    Cylinder,
    Cone,
    Points,
    Hull,
    Triangle,
    Ellipsoid,
    Superellipsoid,
}

const BODIES: [Body; 10] = [
    Body::Point,
    Body::Segment,
    Body::Box,
    Body::Cylinder,
    Body::Cone,
    Body::Points,
    Body::Hull,
    Body::Triangle,
    Body::Ellipsoid,
    Body::Superellipsoid,
];

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    Beside,
    Touching,
    Deep,
    Centred,
    Far,
}

/// Bodies of longest extent about 1.
struct Stock {
    hulls: Vec<Core>,
    ellipsoids: Vec<Core>,
    superellipsoids: Vec<Core>,
}

impl Stock {
    fn new() -> Self {
        let mut random = Random(1);
        let hulls = (0..STOCK).map(|_| hull(&mut random)).collect();
        let ellipsoids = (0..STOCK).map(|_| superellipsoid(&mut random, true)).collect();
        let superellipsoids = (0..STOCK / 5).map(|_| superellipsoid(&mut random, false)).collect();
        Self { hulls, ellipsoids, superellipsoids }
    }

    fn draw(&self, random: &mut Random, body: Body) -> Core {
        let slenderness = if random.below(2) == 0 { 2.0 } else { SLENDERNESS };
        let kind = match body {
            Body::Point => Kind::Point,
            Body::Segment => Kind::Segment,
            Body::Box => Kind::Box,
            Body::Cylinder => Kind::Cylinder,
            Body::Cone => Kind::Cone,
            Body::Points => Kind::Hull,
            Body::Triangle => Kind::Triangle,
            Body::Hull => return self.hulls[random.below(STOCK)].clone(),
            Body::Ellipsoid => return self.ellipsoids[random.below(STOCK)].clone(),
            Body::Superellipsoid => return self.superellipsoids[random.below(STOCK / 5)].clone(),
        };
        random.core(kind, slenderness)
    }
}

fn semi_axes(random: &mut Random) -> Vec3 {
    let slenderness = if random.below(2) == 0 { 2.0 } else { SLENDERNESS };
    let mut axes = Vec3::from_fn(|_, _| random.log(1.0 / slenderness, 1.0));
    axes[random.below(3)] = 1.0;
    axes
}

/// A hull with faces: of random points, or a prism, whose faces have more corners.
fn hull(random: &mut Random) -> Core {
    let axes = semi_axes(random);
    let sides = 3 + random.below(10);
    let points: Vec<Vec3> = if random.below(2) == 0 {
        (0..4 + random.below(30)).map(|_| random.direction().component_mul(&axes)).collect()
    } else {
        let at = |k: usize| (2.0 * PI * (k / 2) as f64 / sides as f64).sin_cos();
        let corner = |k: usize| Vec3::new(at(k).1, at(k).0, if k.is_multiple_of(2) { -1.0 } else { 1.0 });
        (0..2 * sides).map(|k| corner(k).component_mul(&axes)).collect()
    };
    let hull = ConvexHull::new(&points).unwrap();
    Core::polyhedron_with_faces(hull.vertices, hull.faces)
}

fn superellipsoid(random: &mut Random, is_ellipsoid: bool) -> Core {
    let one = |random: &mut Random| match random.below(5) {
        0 => [0.1, 0.2, 0.25, 0.5, 2.0][random.below(5)],
        1 => random.log(0.05, 0.3),
        2 | 3 => 0.3 + 0.7 * random.unit(),
        _ => 1.0 + random.unit(),
    };
    let eps = if is_ellipsoid { [1.0; 2] } else { [one(random), one(random)] };
    let crust = random.log(1e-3, 0.2);
    Shape::superellipsoid(semi_axes(random), eps, crust).unwrap().parts[0].core.clone()
}

/// Any rotation; an exact one of the axes; a nearly aligned one; one that stands bodies on their edges.
fn rotation(random: &mut Random) -> Mat3 {
    match random.below(4) {
        0 => random.rotation().to_rotation_matrix().into_inner(),
        1 => {
            let turn = random.below(3);
            let sign = |random: &mut Random| if random.below(2) == 0 { 1.0 } else { -1.0 };
            let (first, second) = (sign(random), sign(random));
            let columns: [Vec3; 3] = std::array::from_fn(|k| Vec3::ith((k + turn) % 3, 1.0));
            Mat3::from_columns(&[columns[0] * first, columns[1] * second, columns[2] * (first * second)])
        }
        2 => random.aligned().to_rotation_matrix().into_inner(),
        _ => {
            let eighth = |axis: usize| Rotation::from_scaled_axis(Vec3::ith(axis, FRAC_PI_4));
            (eighth(random.below(3)) * eighth(random.below(3))).to_rotation_matrix().into_inner()
        }
    }
}

/// The pair of a number.
fn draw(stock: &Stock, number: u64) -> (Random, [Body; 2], Place, Pair) {
    let mut random = Random(number.wrapping_mul(0x2545_f491_4f6c_dd1d));
    let bodies = [0; 2].map(|_| BODIES[random.below(BODIES.len())]);
    let own = random.log(SIZES[0], SIZES[1]);
    let other =
        if random.below(2) == 0 { own * random.log(0.1, 10.0) } else { random.log(SIZES[0], SIZES[1]) };
    // The second is as large as drawn by its core or by its scale.
    let of_core = [other, own, 1.0][random.below(3)];
    let a = scaled(&stock.draw(&mut random, bodies[0]), own);
    let b = scaled(&stock.draw(&mut random, bodies[1]), of_core);
    let (matrix, scale) = (rotation(&mut random), other / of_core);
    let direction = match random.below(3) {
        0 => random.direction(),
        1 => Vec3::ith(random.below(3), if random.below(2) == 0 { 1.0 } else { -1.0 }),
        _ => matrix.column(random.below(3)).into_owned(),
    };
    // A point is the core of a ball.
    let radii = [a.radius().max(own), b.radius().max(of_core) * scale];
    let reach = radii[0] + radii[1];
    let place = [Place::Beside, Place::Touching, Place::Deep, Place::Centred, Place::Far][random.below(5)];
    let length = match place {
        Place::Beside => reach * (0.2 + random.unit()),
        Place::Touching => reach * 1.1,
        Place::Deep => radii[random.below(2)] * random.unit(),
        Place::Centred if random.below(2) == 0 => 0.0,
        Place::Centred => radii[random.below(2)] * random.log(1e-16, 1e-3),
        Place::Far => reach * random.log(1.0, 1e6),
    };
    let mut pair = Pair::new(a, b, Placement { matrix: matrix * scale, translation: direction * length });
    if place == Place::Touching
        && let Ok(Separation::Apart { distance, normal, .. }) = ask(&pair, &mut Simplex::default())
    {
        let measure = if random.below(2) == 0 { pair.size } else { radii[0].min(radii[1]) };
        let side = if random.below(2) == 0 { 1.0 } else { -1.0 };
        let target = side * measure * random.log(1e-12, 1e-3);
        let translation = pair.placement.translation - normal * (distance - target);
        pair = Pair::new(pair.a, pair.b, Placement { translation, ..pair.placement });
    }
    (random, bodies, place, pair)
}

fn ask(pair: &Pair, simplex: &mut Simplex) -> Result<Separation, String> {
    distance(&pair.a, &pair.b, &pair.placement, f64::INFINITY, simplex).map_err(|error| error.to_string())
}

/// What was found of the pairs.
#[derive(Default)]
struct Findings {
    meeting: usize,
    /// The largest of each figure, relative to the size of the pair, and of which pair.
    largest: BTreeMap<&'static str, (f64, String)>,
    failures: Vec<String>,
}

/// The pair that is looked at, and where what is found of it goes.
struct Trial<'a> {
    findings: &'a mut Findings,
    pair: String,
}

impl Drop for Trial<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("{}", self.pair);
        }
    }
}

impl Trial<'_> {
    fn fail(&mut self, what: &str, reason: &str) {
        self.findings.failures.push(format!("{}: {what}: {reason:.200}", self.pair));
    }

    /// Holds a figure against its limit, both relative to the size of the pair.
    fn measure(&mut self, what: &'static str, figure: f64, limit: f64) {
        let largest = self.findings.largest.entry(what).or_default();
        if figure > largest.0 {
            *largest = (figure, self.pair.clone());
        }
        if figure.is_nan() || figure > limit {
            self.fail(what, &format!("{figure:e} of at most {limit:e}"));
        }
    }

    /// Distance of a pair and how much less it may be, both relative to the size; `None` if there is no answer.
    fn certified(&mut self, what: &'static str, pair: &Pair, simplex: &mut Simplex) -> Option<[f64; 2]> {
        let answer = ask(pair, simplex).map_err(|error| self.fail(what, &error)).ok()?;
        let gap = pair.gap_of(&answer, off_bodies(pair, &answer));
        let gap = gap.map_err(|reason| self.fail(what, &reason)).ok()?;
        match answer {
            Separation::Meeting => Some([0.0, MEETING]),
            Separation::Apart { distance, .. } => {
                let near = distance / pair.size;
                let class = match near {
                    1e-4.. => "gap",
                    1e-8.. => "gap of near ones",
                    _ => "gap of touching ones",
                };
                self.measure(class, gap, STALLED + ROUNDING / near);
                Some([near, gap])
            }
            Separation::Beyond { .. } => {
                self.fail(what, "beyond any distance");
                None
            }
        }
    }

    /// Asks once more for what must be the same distance, each answer being as good as its own gap.
    fn same(&mut self, what: &'static str, pair: &Pair, simplex: &mut Simplex, known: [f64; 2]) {
        if let Some(found) = self.certified(what, pair, simplex) {
            let rounding = if has_superellipsoid(pair) { 1e-10 } else { 1e-13 };
            self.measure(what, (found[0] - known[0]).abs(), found[1] + known[1] + rounding);
        }
    }
}

/// Distance below which bodies meet, gap that is accepted at the worst, and how rounding turns a short way: what
/// `gjk.rs` says of them, 1e-12, 1e-10 and 1e-15, in sizes of up to 5.2 times ours.
const MEETING: f64 = 5.2e-12;
const STALLED: f64 = 5.2e-10;
const ROUNDING: f64 = 2.7e-14;

fn has_superellipsoid(pair: &Pair) -> bool {
    [&pair.a, &pair.b].iter().any(|core| matches!(core, Core::Superellipsoid(_)))
}

/// How far the points may be off their bodies, relative to the size: normals of superellipsoids are good to the root of the
/// tolerance, and their points are put on one normal.
fn off_bodies(pair: &Pair, answer: &Separation) -> f64 {
    match answer {
        Separation::Apart { distance, .. } if has_superellipsoid(pair) => {
            1e-13 + 3e-7 * (distance / pair.size).sqrt()
        }
        _ => 1e-13,
    }
}

/// A core turned about z by a right angle without rounding, a superellipsoid by two; and the turn.
fn turned(core: &Core) -> (Core, Mat3) {
    let quarter = Mat3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let core = match core {
        Core::Superellipsoid(_) => return (core.clone(), quarter * quarter),
        Core::Box(half) => Core::Box(Vec3::new(half.y, half.x, half.z)),
        Core::Triangle(corners) => Core::Triangle(corners.map(|p| quarter * p)),
        Core::Polyhedron(hull) => {
            let turn = |f: &Face| Face { normal: quarter * f.normal, ..f.clone() };
            let vertices = hull.vertices().iter().map(|p| quarter * p).collect();
            Core::polyhedron_with_faces(vertices, hull.faces().iter().map(turn).collect())
        }
        Core::Point | Core::Segment { .. } | Core::Cylinder { .. } | Core::Cone(_) => core.clone(),
    };
    (core, quarter)
}

/// Both bodies turned without rounding, each in its own frame, and the frame of the first.
fn turned_pair(pair: &Pair) -> Pair {
    let ((a, turn), (b, other)) = (turned(&pair.a), turned(&pair.b));
    let Placement { matrix, translation } = pair.placement;
    Pair::new(a, b, Placement { matrix: turn * matrix * other.transpose(), translation: turn * translation })
}

/// Any points of the bodies.
fn points_of(pair: &Pair, random: &mut Random) -> Simplex {
    let mut simplex = Simplex { len: 1 + random.below(4) as u8, ..Simplex::default() };
    for i in 0..simplex.len as usize {
        simplex.a[i] = pair.a.support(&random.direction());
        simplex.b[i] = pair.b.support(&random.direction());
    }
    simplex
}

/// Finite numbers that are no points of bodies.
fn garbage(random: &mut Random) -> Simplex {
    let mut number = || match random.below(4) {
        0 => 0.0,
        1 => random.unit() - 0.5,
        2 => random.log(1e-12, 1e12),
        _ => -random.log(1e-100, 1e100),
    };
    let mut points = || std::array::from_fn(|_| Vec3::new(number(), number(), number()));
    let (a, b) = (points(), points());
    Simplex { len: 1 + random.below(4) as u8, a, b }
}

fn look_at(stock: &Stock, number: u64, findings: &mut Findings) {
    let (mut random, bodies, place, pair) = draw(stock, number);
    let mut trial = Trial { findings, pair: format!("pair {number}, {bodies:?} {place:?}") };
    let random = &mut random;
    let mut simplex = Simplex::default();
    let Some(known) = trial.certified("cold", &pair, &mut simplex) else { return };
    let left = simplex;
    trial.same("again", &pair, &mut simplex, known);
    trial.same("exchanged", &pair.exchanged(), &mut Simplex::default(), known);
    trial.same("turned", &turned_pair(&pair), &mut Simplex::default(), known);
    let motion = random.log(1e-9, 1.0);
    let mut moved = left;
    trial.certified("another pose", &pair.moved(random, motion), &mut moved);
    trial.same("after another pose", &pair, &mut moved, known);
    trial.same("from points of the bodies", &pair, &mut points_of(&pair, random), known);
    // Such a start may make bodies meet that do not, as it does not lie in them; but it ends.
    if let Err(error) = ask(&pair, &mut garbage(random)) {
        trial.fail("garbage", &error);
    }
    magnify(&mut trial, &pair, [0.125, 1024.0][random.below(2)]);
    if known[0] == 0.0 {
        trial.findings.meeting += 1;
        depth(&mut trial, &pair, &left, random);
    }
}

/// No length is absolute: powers of two change no bit, but of the components of superellipsoids that are too small for powers.
fn magnify(trial: &mut Trial, pair: &Pair, factor: f64) {
    let answers = [pair, &pair.magnified(factor)].map(|pair| ask(pair, &mut Simplex::default()));
    let [off, turn] = if has_superellipsoid(pair) { [1e-13, 1e-6] } else { [0.0; 2] };
    let is_same = match &answers {
        [
            Ok(Separation::Apart { distance: d, normal: n, .. }),
            Ok(Separation::Apart { distance: e, normal: m, .. }),
        ] => (d * factor - e).abs() <= off * factor * pair.size && (n - m).norm() <= turn,
        [Ok(Separation::Meeting), Ok(Separation::Meeting)] => true,
        _ => false,
    };
    if !is_same {
        trial.fail("magnified", &format!("{answers:?}"));
    }
}

/// How deep a pair that meets is, is no more than along other directions; moved out by it the bodies touch.
fn depth(trial: &mut Trial, pair: &Pair, simplex: &Simplex, random: &mut Random) {
    let found = match penetration(&pair.a, &pair.b, &pair.placement, simplex) {
        Ok(found) => found,
        Err(error) => return trial.fail("depth", &error.to_string()),
    };
    let (depth, normal) = (found.depth / pair.size, found.normal);
    trial.measure("depth below zero", -depth, MEETING);
    trial.measure("depth along its normal", (-pair.lower_bound(&normal) / pair.size - depth).abs(), 1e-9);
    let across = (found.point_a - found.point_b - normal * found.depth).norm() / pair.size;
    trial.measure("points of the depth", across, 1e-13);
    for _ in 0..10 {
        let far = random.direction();
        let near = (normal + far * random.log(1e-6, 1.0)).normalize();
        for direction in [far, near] {
            let other = -pair.lower_bound(&direction) / pair.size;
            trial.measure("depth beyond the smallest", depth - other, 1e-6);
        }
    }
    let translation = pair.placement.translation + normal * found.depth;
    let apart = Pair::new(pair.a.clone(), pair.b.clone(), Placement { translation, ..pair.placement });
    if let Some(left) = trial.certified("moved out", &apart, &mut Simplex::default()) {
        trial.measure("apart when moved out", left[0], 3e-6);
    }
}

#[test]
fn any_pair_in_any_pose_is_certified() {
    let pairs = if std::env::var_os("GRAINS_TORTURE").is_some() { 10_000_000 } else { 60_000 };
    let (stock, mut findings, start) = (Stock::new(), Findings::default(), Instant::now());
    (0..pairs).for_each(|number| look_at(&stock, number, &mut findings));
    let Findings { meeting, largest, failures } = findings;
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "attack: random pairs of bodies, {meeting} of which meet | {pairs} | {} failures",
        failures.len()
    );
    println!("{seconds:.1} s");
    for (what, (figure, pair)) in &largest {
        println!("{what}: at most {figure:.2e}, {pair}");
    }
    assert!(failures.is_empty(), "{}", failures[..failures.len().min(100)].join("\n"));
}
