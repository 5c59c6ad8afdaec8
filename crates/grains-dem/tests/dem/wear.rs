//! Wear of walls: closed forms of what slides, sums over elements, and the same bits whatever the ranks.

use crate::common::{Scene, Stopped, lattice, law, merged, mixed_shapes, setup, state_of, wall};
use crate::laws::bridge;
use grains_contact::{ContactLaw, Tangential};
use grains_dem::{Dem, Kind, Motion, NewParticle, Skin, Surface, Wall, Wear, WornElement, WornWall};
use grains_domain::{SerialTransport, Transport};
use grains_geometry::{Rotation, SMOOTH_ANGLE, Shape, TriMesh, Vec3, WallMesh};
use grains_testing::on_ranks;
use std::f64::consts::PI;
use std::sync::Arc;

const SIZE: f64 = 0.03;
const RADIUS: f64 = 1.5e-3;
const STIFFNESS: f64 = 1e5;
const GRAVITY: f64 = 9.81;
const FLOOR: f64 = 0.005;
/// Steps in which a body comes to rest on a wall.
const SETTLING: u64 = 2000;
const WEAR: Wear = Wear { coefficient: 1e-4, hardness: 2e9 };

fn wears(wall: Wall) -> Wall {
    Wall { wear: Some(WEAR), ..wall }
}

fn floor(motion: Motion) -> Wall {
    let surface = Surface::Plane { point: Vec3::new(0.0, 0.0, FLOOR), normal: Vec3::z() };
    wears(wall("floor", surface, motion))
}

fn sliding_at(velocity: Vec3) -> Motion {
    Motion::Translation { velocity, start: 0.0, end: f64::INFINITY }
}

fn contact_law(friction: f64) -> ContactLaw {
    ContactLaw::linear(
        STIFFNESS,
        0.75,
        friction,
        Tangential::Spring { stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.5 },
    )
}

/// A body that rests on a wall at a point (m) below its centre, where its weight and the overlap hold each other, and moves
/// along it.
fn resting((shape, height): (Shape, f64), wall: Wall, law: ContactLaw, [point, velocity]: [Vec3; 2]) -> Dem {
    let mut setup = setup([SIZE; 3], [true, true, false], vec![shape], law);
    setup.catalogue.contacts.set(0, 1, law);
    setup.walls = vec![wall];
    let kind = Kind { shape: 0, material: 0 };
    let overlap = setup.catalogue.mass(kind, 1.0) * GRAVITY / STIFFNESS;
    let particle = NewParticle {
        id: 0,
        kind,
        scale: 1.0,
        position: point + Vec3::z() * (height - overlap),
        orientation: Rotation::identity(),
        velocity,
        angular_velocity: Vec3::zeros(),
        temperature: 0.0,
    };
    Scene { setup, particles: vec![particle] }.start([1; 3], 0)
}

fn ball() -> (Shape, f64) {
    (Shape::sphere(RADIUS).unwrap(), RADIUS)
}

/// Volume (m³) that some steps wear off the first wall.
fn worn_in(dem: &mut Dem, steps: u64) -> f64 {
    let worn = |dem: &Dem| dem.worn_walls(&SerialTransport)[0].unwrap().volume;
    let before = worn(dem);
    for _ in 0..steps {
        dem.step(&SerialTransport).unwrap();
    }
    worn(dem) - before
}

#[test]
fn a_body_that_slides_at_constant_speed_wears_its_floor_by_load_and_distance() {
    let (steps, speed) = (500, 0.4);
    let block = (Shape::cuboid(Vec3::new(2.0, 2.0, 1.0) * RADIUS, 0.05).unwrap(), 0.5 * RADIUS);
    let start = Vec3::new(0.4 * SIZE, 0.6 * SIZE, FLOOR);
    let along = Vec3::new(0.6, -0.8, 0.0) * speed;
    for body in [ball(), block] {
        // The floor moves, the body does, or both: what counts is how fast they slide on each other.
        for [of_floor, of_body] in [[0.0, 1.0], [-1.0, 0.0], [2.0, 3.0], [-0.25, 0.75]] {
            let wall = floor(sliding_at(along * of_floor));
            let mut dem = resting(body.clone(), wall, contact_law(0.0), [start, along * of_body]);
            let weight = dem.particles.bodies[0].mass * GRAVITY;
            let distance = speed * steps as f64 * dem.setup.parameters.dt;
            let exact = WEAR.coefficient * weight * distance / WEAR.hardness;
            worn_in(&mut dem, SETTLING);
            let worn = worn_in(&mut dem, steps);
            assert!((worn / exact - 1.0).abs() < 1e-6, "{worn} against {exact}");
        }
    }
}

#[test]
fn the_sliding_power_is_load_times_speed_and_none_where_both_move_alike() {
    let along = Vec3::new(0.24, -0.32, 0.0);
    let start = Vec3::new(0.4 * SIZE, 0.6 * SIZE, FLOOR);
    let after = |of_body: f64| {
        let at = [start, along * of_body];
        let mut dem = resting(ball(), floor(sliding_at(along)), contact_law(0.0), at);
        worn_in(&mut dem, SETTLING);
        (dem.worn_walls(&SerialTransport)[0].unwrap(), dem.particles.bodies[0].mass)
    };
    let (worn, mass) = after(-2.0);
    let exact = mass * GRAVITY * 3.0 * along.norm();
    assert!((worn.sliding_power / exact - 1.0).abs() < 1e-6, "{worn:?} against {exact} W");
    assert_eq!(after(1.0).0, WornWall::default());
}

#[test]
fn a_turning_drum_wears_by_the_speed_of_its_shell() {
    let (rate, radius, steps) = (12.0, 0.4 * SIZE, 300);
    let center = Vec3::repeat(0.5 * SIZE);
    let (axis, half_length) = (Vec3::y(), f64::INFINITY);
    let shell = Surface::Tube { center, axis, radius, half_length };
    let motion = Motion::Rotation { point: center, axis, rate, start: 0.0, end: f64::INFINITY };
    let at = [center - Vec3::z() * radius, Vec3::zeros()];
    let mut dem = resting(ball(), wears(wall("drum", shell, motion)), contact_law(0.0), at);
    let weight = dem.particles.bodies[0].mass * GRAVITY;
    let distance = rate * radius * steps as f64 * dem.setup.parameters.dt;
    let exact = WEAR.volume_per_work() * weight * distance;
    worn_in(&mut dem, SETTLING);
    let worn = worn_in(&mut dem, steps);
    assert!((worn / exact - 1.0).abs() < 1e-5, "{worn} against {exact}");
}

/// A ball that slides to rolling loses m v²/7, all by friction: μ times the normal force times what it slides.
#[test]
fn a_ball_that_comes_to_roll_wears_by_the_energy_it_loses_over_its_friction() {
    let (friction, speed) = (0.4, 0.2);
    let start = [Vec3::new(0.1 * SIZE, 0.5 * SIZE, FLOOR), Vec3::x() * speed];
    let mut dem = resting(ball(), floor(Motion::Fixed), contact_law(friction), start);
    let exact = WEAR.volume_per_work() * dem.particles.bodies[0].mass * speed * speed / (7.0 * friction);
    let until_it_rolls = 2.0 / 7.0 * speed / (friction * GRAVITY);
    let steps = (1.2 * until_it_rolls / dem.setup.parameters.dt) as u64;
    let worn = worn_in(&mut dem, steps);
    assert!((worn / exact - 1.0).abs() < 0.01, "{worn} against {exact}");
    let after = worn_in(&mut dem, steps);
    assert!(after < 1e-3 * worn, "a ball that rolls does not wear: {worn}, then {after}");
}

/// A bridge of liquid holds a ball below a plate that slides past it.
#[test]
fn a_contact_that_pulls_does_not_wear() {
    let law = contact_law(0.0).with_attraction(bridge(0.0, 0.0));
    let wall = floor(sliding_at(Vec3::x() * 0.3));
    let mut dem = resting(ball(), wall, law, [Vec3::new(0.5 * SIZE, 0.5 * SIZE, FLOOR), Vec3::zeros()]);
    dem.setup.parameters.gravity = Vec3::z() * GRAVITY;
    worn_in(&mut dem, SETTLING);
    let load = dem.wall_loads(&SerialTransport)[0].force.z;
    assert!(load > 0.0, "the ball hangs on the plate: {load} N");
    assert_eq!(worn_in(&mut dem, SETTLING), 0.0);
}

/// Spheres and other bodies in a turning and open drum of triangles, above a box that the drum's rim passes.
fn drum(skin: Skin) -> Scene {
    let mut setup = setup([SIZE; 3], [false, true, false], mixed_shapes(RADIUS), law(true));
    setup.skin = skin;
    setup.parameters.gravity = Vec3::new(30.0, 0.0, -60.0);
    setup.catalogue.contacts.set(0, 1, law(true));
    let center = Vec3::repeat(0.5 * SIZE);
    let sides = 24;
    let rim = |k: usize| {
        let angle = 2.0 * PI * (k / 2) as f64 / sides as f64;
        let along = if k.is_multiple_of(2) { -0.9 } else { 0.9 };
        center + Vec3::new(0.43 * angle.cos(), along, 0.43 * angle.sin()) * SIZE
    };
    let faces =
        (0..sides).map(|k| [2 * k, 2 * k + 1, (2 * k + 3) % (2 * sides), (2 * k + 2) % (2 * sides)].to_vec());
    let mesh = TriMesh::from_polygons((0..2 * sides).map(rim).collect(), &faces.collect::<Vec<_>>()).unwrap();
    let shell = Surface::Mesh(Arc::new(WallMesh::new(&mesh, SMOOTH_ANGLE).unwrap()));
    let turning =
        Motion::Rotation { point: center, axis: Vec3::y(), rate: -30.0, start: 0.0, end: f64::INFINITY };
    let mut drum = wears(wall("drum", shell, turning));
    drum.spans = [false, true, false];
    let low =
        Surface::Plane { point: Vec3::repeat(0.2 * SIZE), normal: Vec3::new(0.1, 0.0, 1.0).normalize() };
    let side = Surface::Plane { point: Vec3::repeat(0.15 * SIZE), normal: Vec3::x() };
    let mut planes = wears(wall("planes", low, Motion::Fixed));
    planes.surfaces.push(side.clone());
    setup.walls = vec![drum, wall("other", side, Motion::Fixed), planes];
    let particles = lattice([0.2 * SIZE, 0.0, 0.2 * SIZE], [0.8 * SIZE, SIZE, 0.8 * SIZE], 3.4e-3, 4, 2.0);
    Scene { setup, particles }
}

#[test]
fn liquid_that_presses_over_a_gap_does_not_wear() {
    let (gap, speed, steps) = (2e-5, 0.1, 30);
    let law = contact_law(0.0).with_attraction(bridge(0.05, gap));
    let at = [Vec3::new(0.5 * SIZE, 0.5 * SIZE, FLOOR + gap), Vec3::z() * -speed];
    let mut dem = resting(ball(), floor(sliding_at(Vec3::x() * 0.3)), law, at);
    let worn = worn_in(&mut dem, steps);
    let height = dem.particles.bodies[0].position.z - FLOOR - RADIUS;
    let load = dem.wall_loads(&SerialTransport)[0].force.z;
    assert!(height > 0.0 && load < 0.0, "a gap of {height} m, {load} N on the floor");
    assert_eq!(worn, 0.0);
}

/// What has worn off after some steps from a state, on a grid of ranks, and the totals of the walls as bits.
fn go_on(
    scene: &Scene,
    ranks: [usize; 3],
    from: Option<&(Stopped, Vec<WornElement>)>,
    steps: u64,
) -> (Vec<WornElement>, Vec<u64>) {
    let parts = on_ranks(ranks.iter().product(), |transport| {
        let mut dem = match from {
            None => scene.start(ranks, transport.rank()),
            Some((stopped, worn)) => {
                let mut dem = scene.resume(ranks, transport.rank(), stopped, |_| ());
                // Any rank may hold what has worn off, in any order.
                let own = |k: usize| k % transport.size() == transport.rank();
                let mine = worn.iter().enumerate().rev().filter(|(k, _)| own(*k));
                mine.for_each(|(_, &worn)| dem.restore_worn(worn));
                dem
            }
        };
        for _ in 0..steps {
            dem.step(&transport).unwrap();
        }
        let walls = dem.worn_walls(&transport);
        let totals = walls.iter().flatten().flat_map(|worn| [worn.volume, worn.sliding_power]);
        (dem.worn_elements(&transport), totals.map(f64::to_bits).collect::<Vec<_>>())
    });
    assert!(parts.iter().all(|part| *part == parts[0]), "ranks differ");
    parts.into_iter().next().unwrap()
}

#[test]
fn wear_has_the_same_bits_on_any_ranks_with_any_skin_and_after_a_restart() {
    let (steps, before) = (1500, 700);
    let scene = drum(Skin::default());
    let alone = go_on(&scene, [1; 3], None, steps);
    let of_drum = alone.0.iter().filter(|worn| worn.wall == 0).count();
    let surfaces: Vec<u16> = alone.0.iter().filter(|worn| worn.wall == 2).map(|worn| worn.surface).collect();
    assert!(of_drum > 8 && surfaces == [0, 1], "{of_drum} triangles, planes {surfaces:?}");
    for ranks in [[2, 1, 1], [1, 2, 2], [1, 1, 3], [2, 2, 1]] {
        assert!(go_on(&scene, ranks, None, steps) == alone, "{ranks:?}");
    }
    let thin = Skin { max: 0.03, min: 0.01, ..Skin::default() };
    assert!(go_on(&drum(thin), [2, 2, 1], None, steps) == alone, "skin");
    let mut dem = scene.start([1; 3], 0);
    for _ in 0..before {
        dem.step(&SerialTransport).unwrap();
    }
    dem.refresh(&SerialTransport).unwrap();
    let from = (Stopped::of(&dem), dem.worn_elements(&SerialTransport));
    assert!(go_on(&scene, [1, 2, 2], Some(&from), steps - before) == alone, "restart");
}

#[test]
fn elements_add_up_to_their_wall_and_particles_do_not_feel_what_is_counted() {
    let scene = drum(Skin::default());
    let mut plain = drum(Skin::default());
    plain.setup.walls.iter_mut().for_each(|wall| wall.wear = None);
    let (mut dem, mut without) = (scene.start([1; 3], 0), plain.start([1; 3], 0));
    for _ in 0..600 {
        dem.step(&SerialTransport).unwrap();
        without.step(&SerialTransport).unwrap();
    }
    assert!(merged(vec![state_of(&dem)]) == merged(vec![state_of(&without)]));
    assert!(without.worn_walls(&SerialTransport).iter().all(Option::is_none));
    let (walls, volumes) = (dem.worn_walls(&SerialTransport), dem.worn_volumes(&SerialTransport));
    assert!(walls[1].is_none() && volumes[1].is_empty());
    for k in [0, 2] {
        let (whole, sum) = (walls[k].unwrap().volume, volumes[k].iter().flatten().sum::<f64>());
        assert!(whole > 0.0 && (sum / whole - 1.0).abs() < 1e-14, "{sum} of {whole}");
    }
}
