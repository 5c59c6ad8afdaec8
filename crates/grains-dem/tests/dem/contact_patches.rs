//! Bodies that rest on faces, edges and lines: no creep, no spin, towers that stand.

use crate::common::{setup, wall};
use grains_contact::{ContactLaw, Tangential};
use grains_dem::{Dem, FaceContact, Kind, Motion, NewParticle, Surface};
use grains_domain::SerialTransport;
use grains_geometry::{Rotation, SMOOTH_ANGLE, Shape, TriMesh, Vec3, WallMesh};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

const EDGE: f64 = 4e-3;
const FLOOR: f64 = 0.01;
const STIFFNESS: f64 = 1e4;

fn law() -> ContactLaw {
    ContactLaw::linear(
        STIFFNESS,
        0.5,
        0.5,
        Tangential::Spring { stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.5 },
    )
}

fn plane() -> Surface {
    Surface::Plane { point: Vec3::new(0.0, 0.0, FLOOR), normal: Vec3::z() }
}

/// A floor of n x n squares, each cut into two triangles.
fn tiles(n: usize) -> Surface {
    let corner =
        |i: usize, j: usize| Vec3::new(i as f64, j as f64, 0.0) * (0.1 / n as f64) + Vec3::z() * FLOOR;
    let vertices = (0..=n).flat_map(|j| (0..=n).map(move |i| corner(i, j))).collect();
    let at = |i: usize, j: usize| (j * (n + 1) + i) as u32;
    let triangles = (0..n * n).flat_map(|k| {
        let (i, j) = (k % n, k / n);
        [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
    });
    let mesh = TriMesh { vertices, triangles: triangles.collect() };
    Surface::Mesh(Arc::new(WallMesh::new(&mesh, SMOOTH_ANGLE).unwrap()))
}

/// Particles of one shape, dropped from where they are.
fn placed(shape: Shape, floor: Surface, faces: FaceContact, places: &[(Vec3, Rotation)]) -> Dem {
    let mut setup = setup([0.1; 3], [false; 3], vec![shape], law());
    setup.catalogue.faces = faces;
    setup.catalogue.contacts.set(0, 1, law());
    setup.parameters.dt = 2.5e-5;
    setup.walls = vec![wall("floor", floor, Motion::Fixed)];
    let mut dem = Dem::new(setup, 0).unwrap();
    for (id, &(position, orientation)) in places.iter().enumerate() {
        let new = NewParticle {
            id: id as u64,
            kind: Kind { shape: 0, material: 0 },
            scale: 1.0,
            position,
            orientation,
            velocity: Vec3::zeros(),
            angular_velocity: Vec3::zeros(),
            temperature: 0.0,
        };
        let record = new.record(&dem);
        dem.insert(&record);
    }
    dem
}

fn run(dem: &mut Dem, seconds: f64) {
    for _ in 0..(seconds / dem.setup.parameters.dt).round() as u64 {
        dem.step(&SerialTransport).unwrap();
    }
}

fn place(dem: &Dem, id: u64) -> (Vec3, Rotation, f64) {
    let i = dem.particles.ids.iter().position(|&k| k == id).unwrap();
    let body = &dem.particles.bodies[i];
    let speed = body.velocity.norm() + body.radius * body.angular_velocity.norm();
    (body.position, dem.particles.record(i).orientation, speed)
}

/// Drops one body a little onto a floor, lets it come to rest, and returns how far it moves (m) and turns
/// (rad) in the next `seconds`, and its last speed (m/s).
fn drift(
    shape: Shape,
    floor: Surface,
    faces: FaceContact,
    turn: Rotation,
    height: f64,
    seconds: f64,
) -> [f64; 3] {
    let start = Vec3::new(0.0503, 0.0497, FLOOR + height);
    let mut dem = placed(shape, floor, faces, &[(start, turn)]);
    run(&mut dem, 0.5);
    let (position, orientation, _) = place(&dem, 0);
    run(&mut dem, seconds);
    let (later, turned, speed) = place(&dem, 0);
    [(later - position).norm(), orientation.angle_to(&turned), speed]
}

fn cube() -> Shape {
    Shape::cuboid(Vec3::repeat(EDGE), 0.02).unwrap()
}

#[test]
fn a_cube_at_rest_stays_for_ten_seconds() {
    let turn = Rotation::from_axis_angle(&Vec3::z_axis(), 0.4);
    for floor in [plane(), tiles(37)] {
        let [moved, turned, speed] = drift(cube(), floor, FaceContact::MultiPoint, turn, 0.5005 * EDGE, 10.0);
        assert!(moved < 1e-9 * EDGE && turned < 1e-9, "moved {moved:e} m, turned {turned:e}");
        assert!(speed < 1e-10, "still moves at {speed:e} m/s");
    }
}

#[test]
fn a_cube_on_one_point_does_not() {
    let turn = Rotation::from_axis_angle(&Vec3::z_axis(), 0.4);
    let [moved, turned, speed] = drift(cube(), plane(), FaceContact::Point, turn, 0.5005 * EDGE, 1.0);
    assert!(
        speed > 1e-6 || moved > 1e-6 * EDGE || turned > 1e-6,
        "the single point has become stable: say so"
    );
}

#[test]
fn a_cylinder_stays_on_its_side_and_on_its_end() {
    let rod = || Shape::cylinder(0.5 * EDGE, 2.0 * EDGE, 0.02).unwrap();
    let lying = Rotation::from_axis_angle(&Vec3::x_axis(), FRAC_PI_2);
    for floor in [plane(), tiles(37)] {
        let [moved, turned, speed] =
            drift(rod(), floor.clone(), FaceContact::MultiPoint, Rotation::identity(), 1.0005 * EDGE, 4.0);
        assert!(moved < 1e-9 * EDGE && turned < 1e-9, "moved {moved:e} m, turned {turned:e}");
        assert!(speed < 1e-10, "still moves at {speed:e} m/s");
        // On its side it is free to roll; landing on tiles may set it off, but nothing drives it on.
        let [moved, _, speed] = drift(rod(), floor, FaceContact::MultiPoint, lying, 0.5005 * EDGE, 4.0);
        assert!(moved < 1e-3 * EDGE, "rolled {moved:e} m");
        assert!(speed < 3.3 * moved / 4.0 + 1e-10, "rolls at {speed:e} m/s, {moved:e} m in 4 s");
    }
}

#[test]
fn a_cube_dropped_askew_comes_to_rest_on_a_face() {
    let turn = Rotation::new(Vec3::new(0.4, 0.3, 0.2));
    let [moved, turned, speed] = drift(cube(), plane(), FaceContact::MultiPoint, turn, 1.2 * EDGE, 1.0);
    assert!(
        moved < 1e-8 * EDGE && turned < 1e-8 && speed < 1e-9,
        "{moved:e} m, {turned:e} rad, {speed:e} m/s"
    );
}

/// Ten cubes, each a little off and turned against the one below.
fn tower(faces: FaceContact) -> Dem {
    let places: Vec<(Vec3, Rotation)> = (0..10)
        .map(|k| {
            let (angle, off) = (0.7 * f64::from(k), 0.05 * EDGE);
            let position = Vec3::new(0.05 + off * angle.cos(), 0.05 + off * angle.sin(), 0.0)
                + Vec3::z() * (FLOOR + (0.5 + 1.0005 * f64::from(k)) * EDGE + 1e-6);
            (position, Rotation::from_axis_angle(&Vec3::z_axis(), 0.1 * angle.sin()))
        })
        .collect();
    placed(cube(), plane(), faces, &places)
}

#[test]
fn a_tower_of_ten_cubes_stands() {
    let mut dem = tower(FaceContact::MultiPoint);
    run(&mut dem, 2.0);
    let before: Vec<_> = (0..10).map(|k| place(&dem, k)).collect();
    run(&mut dem, 3.0);
    for k in 0..10 {
        let (position, _, speed) = place(&dem, k);
        let (earlier, _, faster) = before[k as usize];
        let height = position.z - FLOOR - (0.5 + k as f64) * EDGE;
        // Interface j bears the 10 − j cubes above it, Σ (10 − j) m g/k, where k = N^(1/4) kn of N = 4 to 8 corners;
        // leaning adds a little. The lowest stands on its own four.
        let weight = 2500.0 * EDGE.powi(3) * 9.81;
        let sunk = (0..=k).map(|j| (10 - j) as f64).sum::<f64>() * weight / STIFFNESS;
        let share = height / -sunk * 4f64.powf(0.25);
        let range = if k == 0 { 0.9999..1.0001 } else { 0.5f64.powf(0.25) - 0.01..1.05 };
        assert!(
            range.contains(&share),
            "cube {k} is {height:e} m off its height, {share} of that on four corners"
        );
        let moved = (position - earlier).norm();
        // Its slowest swaying dies out.
        assert!(
            moved < 1e-3 * EDGE && speed < 1e-4 && speed < 0.5 * faster,
            "cube {k}: {moved:e} m, {speed:e} after {faster:e} m/s"
        );
    }
}
