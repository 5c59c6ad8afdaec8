//! Flat faces of meshes: however they are cut into triangles, bodies touch them as planes.

use crate::common::{
    Random, Scene, assert_same, knobbly_shapes, merged, mixed_shapes, setup, state_of, wall,
};
use grains_contact::{ContactLaw, Sharing, Tangential};
use grains_dem::{Dem, FaceContact, Kind, Motion, NewParticle, Skin, Surface, Wear};
use grains_domain::SerialTransport;
use grains_geometry::{Rotation, SMOOTH_ANGLE, Shape, Spacing, TriMesh, Vec3, WallMesh};
use std::sync::Arc;

const RADIUS: f64 = 1.5e-3;
const BOX: f64 = 0.04;

/// Shapes of all kinds; the vertices of one that meets others by them do not meet triangles.
fn shapes() -> Vec<Shape> {
    let all = mixed_shapes(RADIUS).into_iter().chain(knobbly_shapes(RADIUS));
    all.filter(|shape| shape.discrete.is_none()).collect()
}

/// Corners over a rectangle of `cells`, moved at random in it but for those on its border.
fn grid(random: &mut Random, cells: [usize; 2], noise: f64, place: impl Fn(f64, f64) -> Vec3) -> Vec<Vec3> {
    let [n, m] = cells;
    let mut corner = |k: usize| {
        let shift = |random: &mut Random, i: usize, n: usize| {
            let by = if i == 0 || i == n { 0.0 } else { noise * (random.unit() - 0.5) };
            (i as f64 + by) / n as f64
        };
        let (x, y) = (shift(random, k % (n + 1), n), shift(random, k / (n + 1), m));
        place(x, y)
    };
    (0..(n + 1) * (m + 1)).map(&mut corner).collect()
}

/// The squares of a grid that are `there`, cut along one diagonal or the other.
fn cut(
    random: &mut Random,
    vertices: Vec<Vec3>,
    [n, m]: [usize; 2],
    is_there: impl Fn(usize, usize) -> bool,
) -> Surface {
    let mut faces = Vec::new();
    for k in (0..n * m).filter(|k| is_there(k % n, k / n)) {
        let a = k / n * (n + 1) + k % n;
        let [b, c, d] = [a + 1, a + n + 2, a + n + 1];
        let halves = if random.unit() < 0.5 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
        faces.extend(halves.map(|half| half.to_vec()));
    }
    let mesh = TriMesh::from_polygons(vertices, &faces).unwrap();
    Surface::Mesh(Arc::new(WallMesh::new(&mesh, SMOOTH_ANGLE).unwrap()))
}

/// The inclined plane through the middle of the floor of the box, as it is and cut into triangles of both senses.
fn floors(random: &mut Random) -> [Surface; 2] {
    let [along, across] = [Vec3::new(0.9, 0.1, 0.15), Vec3::new(-0.1, 0.95, -0.1)];
    let (middle, n) = (Vec3::new(0.5, 0.5, 0.25) * BOX, 4 + random.index(60));
    let normal = along.cross(&across).normalize();
    let flipped = if random.unit() < 0.5 { -1.0 } else { 1.0 };
    let place = |x: f64, y: f64| middle + (along * (x - 0.5) + across * ((y - 0.5) * flipped)) * (3.0 * BOX);
    let vertices = grid(random, [n, n], 0.6, place);
    [Surface::Plane { point: middle, normal }, cut(random, vertices, [n, n], |_, _| true)]
}

fn spring_law() -> ContactLaw {
    ContactLaw::linear(1e5, 0.6, 0.4, Tangential::Spring { stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.5 })
}

/// A body of each shape over a wall, at rest and apart from each other, which do not touch.
fn scene(
    random: &mut Random,
    surface: Surface,
    shapes: Vec<Shape>,
    faces: FaceContact,
    height: f64,
) -> Scene {
    let count = shapes.len();
    let mut setup = setup([BOX; 3], [false; 3], shapes, spring_law());
    setup.catalogue.faces = faces;
    setup.catalogue.sharing = Sharing::Potential;
    setup.walls = vec![wall("floor", surface, Motion::Fixed)];
    setup.parameters = grains_dem::StepParameters { gravity: Vec3::new(1.0, 0.5, -60.0), dt: 1e-5 };
    let particle = |k: usize| NewParticle {
        id: k as u64,
        kind: Kind { shape: k as u16, material: 0 },
        scale: 1.0,
        position: Vec3::new(
            (0.2 + 0.2 * (k % 4) as f64 + 0.04 * random.unit()) * BOX,
            (0.2 + 0.2 * (k / 4) as f64 + 0.04 * random.unit()) * BOX,
            height,
        ),
        orientation: Rotation::new(random.vector() * 3.0),
        velocity: random.vector() * 0.2 - Vec3::z() * 0.3,
        angular_velocity: random.vector() * 40.0,
        temperature: 0.0,
    };
    let particles = (0..count).map(particle).collect();
    Scene { setup, particles }
}

/// Largest difference of the places of bodies (m), turning included.
fn difference(a: &Dem, b: &Dem) -> f64 {
    let place = |dem: &Dem, id: u64| {
        let i = dem.particles.ids.iter().position(|&k| k == id).unwrap();
        (dem.particles.bodies[i].position, dem.particles.record(i).orientation)
    };
    let of_one = |id: u64| {
        let [(p, q), (r, s)] = [place(a, id), place(b, id)];
        (p - r).norm() + RADIUS * q.angle_to(&s)
    };
    (0..a.particles.owned as u64).map(of_one).fold(0.0, f64::max)
}

/// The motion over a floor is that over a plane but for rounding to quanta of force, which bounces of edgy bodies let grow.
#[test]
fn bodies_move_over_a_tessellated_floor_as_over_a_plane() {
    let mut random = Random(5);
    let mut bounces = 0;
    for round in 0..12 {
        let floors = floors(&mut random);
        let faces = [FaceContact::Point, FaceContact::MultiPoint][round % 2];
        let seed = round as u64 + 1;
        let start =
            |surface: Surface| scene(&mut Random(seed), surface, shapes(), faces, 0.4 * BOX).start([1; 3], 0);
        let mut dems = floors.map(start);
        for step in 0..1300 {
            dems.iter_mut().for_each(|dem| dem.step(&SerialTransport).map(|_| ()).unwrap());
            let off = difference(&dems[0], &dems[1]);
            assert!(off < 1e-3 * RADIUS, "round {round}, step {step}: {off:e}");
            bounces += dems[1].coordination().1.iter().sum::<u32>();
        }
    }
    assert!(bounces > 1000, "{bounces}");
}

/// Bodies that fall over rims: a table with holes, cut in two ways between the same corners of its rims.
#[test]
fn rims_and_holes_are_met_however_the_facet_between_is_cut() {
    let mut random = Random(7);
    let (mut touching, mut worst) = (0, 0.0_f64);
    for round in 0..8 {
        let n = 3 * (1 + random.index(10));
        let is_table = |i: usize, j: usize| !matches!((3 * i / n, 3 * j / n), (1, 1) | (2, 2));
        let place = |x: f64, y: f64| Vec3::new(x, y, 0.3) * BOX;
        let tables = [0.0, 0.4].map(|noise| {
            let vertices = grid(&mut random, [n, n], noise, place);
            let even = grid(&mut random, [n, n], 0.0, place);
            let is_inner = |k: usize| {
                let (i, j) = (k % (n + 1), k / (n + 1));
                let there = |i: usize, j: usize| is_table(i.min(n - 1), j.min(n - 1));
                i > 0 && j > 0 && there(i, j) && there(i - 1, j) && there(i, j - 1) && there(i - 1, j - 1)
            };
            let of_both = vertices.into_iter().zip(even).enumerate();
            let vertices = of_both.map(|(k, (moved, even))| if is_inner(k) { moved } else { even }).collect();
            cut(&mut random, vertices, [n, n], is_table)
        });
        let seed = round as u64 + 11;
        let start = |surface: Surface| {
            scene(&mut Random(seed), surface, shapes(), FaceContact::MultiPoint, 0.36 * BOX).start([1; 3], 0)
        };
        let mut dems = tables.map(start);
        for _ in 0..1300 {
            dems.iter_mut().for_each(|dem| dem.step(&SerialTransport).map(|_| ()).unwrap());
            touching += dems[1].coordination().1.iter().sum::<u32>();
        }
        worst = worst.max(difference(&dems[0], &dems[1]));
    }
    assert!(touching > 500, "{touching}");
    assert!(worst < 1e-6 * RADIUS, "{worst:e}");
}

/// A body that slides from the middle of a floor over its rim keeps what friction has wound up.
#[test]
fn friction_goes_on_where_a_facet_gives_way_to_its_triangles() {
    let n = 20;
    let place = |x: f64, y: f64| Vec3::new(x * BOX, (y - 0.5) * BOX, 0.25 * BOX);
    let mut random = Random(3);
    let vertices = grid(&mut random, [n, n], 0.5, place);
    let surface = cut(&mut random, vertices, [n, n], |_, _| true);
    let cube = Shape::cuboid(Vec3::repeat(2.0 * RADIUS), 0.05).unwrap();
    let mut scene =
        scene(&mut random, surface, vec![cube], FaceContact::MultiPoint, 0.25 * BOX + RADIUS - 1e-6);
    let particle = &mut scene.particles[0];
    (particle.orientation, particle.angular_velocity) = (Rotation::identity(), Vec3::zeros());
    // The floor ends at half of the box along y.
    particle.position.y = 0.5 * BOX - 3.5 * RADIUS;
    particle.velocity = Vec3::zeros();
    scene.setup.parameters.gravity = Vec3::new(0.0, 0.0, -9.81);
    let mut dem = scene.start([1; 3], 0);
    for _ in 0..2000 {
        dem.step(&SerialTransport).unwrap();
    }
    // Pulled along it slips: friction stays near its limit of 0.3 all the way to where its middle is near the rim, and would
    // begin from nothing at a contact without history.
    let mut smallest = f64::INFINITY;
    dem.setup.parameters.gravity.y = 0.5 * 9.81;
    for step in 0..20_000 {
        dem.step(&SerialTransport).unwrap();
        let load = dem.wall_loads(&SerialTransport)[0].force;
        if step > 500 {
            smallest = smallest.min(load.y / -load.z);
        }
        if dem.particles.bodies[0].position.y > 0.5 * BOX - 0.4 * RADIUS {
            break;
        }
    }
    assert!(dem.particles.bodies[0].position.y > 0.5 * BOX - 0.4 * RADIUS, "it slid");
    assert!(smallest > 0.29, "{smallest}");
}

/// What slides on a facet wears its triangles below the path, together as much as a plane.
#[test]
fn a_cube_wears_the_triangles_below_its_path() {
    let mut random = Random(13);
    let n = 40;
    let place = |x: f64, y: f64| Vec3::new(1.2 * x - 0.1, 1.2 * y - 0.1, 0.25) * BOX;
    let vertices = grid(&mut random, [n, n], 0.7, place);
    let mesh = cut(&mut random, vertices, [n, n], |_, _| true);
    let plane = Surface::Plane { point: Vec3::new(0.0, 0.0, 0.25) * BOX, normal: Vec3::z() };
    let (half, start, speed) = (0.8 * RADIUS, Vec3::new(0.3, 0.52, 0.25) * BOX, 0.3);
    let worn = [plane, mesh.clone()].map(|surface| {
        let cube = Shape::cuboid(Vec3::repeat(2.0 * half), 0.05).unwrap();
        let mut scene = scene(&mut random, surface, vec![cube], FaceContact::MultiPoint, 0.5 * BOX);
        scene.setup.parameters.gravity = Vec3::new(0.0, 0.0, -9.81);
        scene.setup.walls[0].wear = Some(Wear { coefficient: 1e-4, hardness: 2e9 });
        let particle = &mut scene.particles[0];
        (particle.orientation, particle.angular_velocity) = (Rotation::identity(), Vec3::zeros());
        (particle.position, particle.velocity) = (start + Vec3::z() * half, Vec3::x() * speed);
        let mut dem = scene.start([1; 3], 0);
        for _ in 0..2000 {
            dem.step(&SerialTransport).unwrap();
        }
        let end = dem.particles.bodies[0].position;
        let whole = dem.worn_walls(&SerialTransport)[0].unwrap().volume;
        (whole, dem.worn_volumes(&SerialTransport)[0][0].clone(), end)
    });
    let ([whole, of_mesh], triangles) = (worn.each_ref().map(|of| of.0), &worn[1].1);
    assert!(whole > 0.0 && (of_mesh / whole - 1.0).abs() < 1e-6, "{of_mesh} for {whole}");
    assert!((triangles.iter().sum::<f64>() / of_mesh - 1.0).abs() < 1e-12);
    let Surface::Mesh(mesh) = mesh else { panic!("a mesh") };
    let is_worn = |&t: &usize| triangles[t] > 0.0;
    let worn_triangles: Vec<usize> = (0..triangles.len()).filter(is_worn).collect();
    assert!(worn_triangles.len() > 4, "{worn_triangles:?}");
    for t in worn_triangles {
        let corners = mesh.mesh().corners(t);
        let [low, high] =
            [corners[0].inf(&corners[1]).inf(&corners[2]), corners[0].sup(&corners[1]).sup(&corners[2])];
        assert!(low.y < start.y + half && high.y > start.y - half, "{t}");
        assert!(low.x < worn[1].2.x + half && high.x > start.x - half, "{t}");
    }
}

/// What is listed changes no bit: floors of all sizes of triangles, skins and none, ranks and restarts.
#[test]
fn lists_of_facets_and_triangles_change_no_bit() {
    let mut random = Random(9);
    for round in 0..6 {
        let n = 3 * (1 + random.index(14));
        let place =
            |x: f64, y: f64| Vec3::new(x, y, 0.3 + 0.1 * f64::from(u8::from(x > 0.5)) * (x - 0.5)) * BOX;
        let vertices = grid(&mut random, [n, n], 0.0, place);
        let surface = cut(&mut random, vertices, [n, n], |i, j| (3 * i / n, 3 * j / n) != (1, 1));
        let turning = Motion::Rotation {
            point: Vec3::new(0.5, 0.5, 0.3) * BOX,
            axis: random.direction(),
            rate: random.range(-3.0, 3.0),
            start: 0.0,
            end: f64::INFINITY,
        };
        let faces = [FaceContact::Point, FaceContact::MultiPoint][round % 2];
        let vertices = Shape::superellipsoid(Vec3::new(0.6, 0.7, 0.9) * RADIUS, [1.0, 0.8], 0.05).unwrap();
        let vertices = vertices.with_surface_vertices(20, Spacing::Linear).unwrap();
        let shapes = shapes().into_iter().chain([vertices]).collect();
        let mut scene = scene(&mut random, surface, shapes, faces, 0.4 * BOX);
        scene.setup.walls[0].motion = turning;
        let start = |skin: Skin| {
            let mut other = Scene { setup: scene.setup.clone(), particles: scene.particles.clone() };
            other.setup.skin = skin;
            other.start([1; 3], 0)
        };
        let skin = |x: f64| Skin { min: x, max: x, horizon: 60.0 };
        let mut dems = [skin(0.0), skin(0.2), skin(1.0)].map(start);
        for step in 0..1500 {
            dems.iter_mut().for_each(|dem| dem.step(&SerialTransport).map(|_| ()).unwrap());
            if step % 10 == 0 {
                let states = dems.each_ref().map(|dem| merged(vec![state_of(dem)]));
                assert!(states[0] == states[1] && states[0] == states[2], "round {round}, step {step}");
            }
        }
        let reference = merged(vec![state_of(&dems[0])]);
        for grid in [[2, 1, 1], [1, 3, 1], [2, 2, 2]] {
            assert_same(&reference, &scene.run(grid, 1500), &format!("round {round}, grid {grid:?}"));
        }
        let [first, second] =
            [[2, 1, 2], [1, 1, 1]].map(|grid| if random.unit() < 0.5 { [1, 3, 1] } else { grid });
        let before = 100 + random.index(1300) as u64;
        let restarted = scene.run_with_restart(first, before, second, 1500 - before);
        assert_same(
            &reference,
            &restarted,
            &format!("round {round}, {first:?}, then {second:?} from {before}"),
        );
    }
}
