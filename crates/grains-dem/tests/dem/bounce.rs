//! Bodies of faces and of several parts bounce off a wall and off one another: no energy is made, and without damping none is
//! lost.

use crate::common::{setup, wall};
use grains_contact::{ContactLaw, Tangential};
use grains_dem::{Dem, FaceContact, Kind, Motion, NewParticle, Surface, SurfaceMobility, Wall};
use grains_domain::SerialTransport;
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{
    Component, Core, Lobes, Mat3, Placement, Rotation, SMOOTH_ANGLE, Shape, Simplex, TriMesh, Vec3, WallMesh,
};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

const SIZE: f64 = 4e-3;
const STIFFNESS: f64 = 1e5;
const SPEED: f64 = 0.1;
const FLOOR: f64 = 0.02;
const CRUST: f64 = 0.02;

fn dumbbell() -> Shape {
    let ball = |x: f64| Component::new(Shape::sphere(0.4 * SIZE).unwrap(), Vec3::x() * x);
    Shape::glued(&[ball(-0.35 * SIZE), ball(0.35 * SIZE)], CRUST).unwrap()
}

fn eight_cubes() -> Shape {
    let cube = |k: u32| {
        let side = |bit: u32| if k >> bit & 1 == 0 { -0.25 * SIZE } else { 0.25 * SIZE };
        Component::new(
            Shape::cuboid(Vec3::repeat(0.5 * SIZE), CRUST).unwrap(),
            Vec3::new(side(0), side(1), side(2)),
        )
    };
    Shape::glued(&(0..8).map(cube).collect::<Vec<_>>(), CRUST).unwrap()
}

fn shapes() -> Vec<(&'static str, Shape)> {
    let lobes = Lobes::with_area_fraction(3, 0.5 * SIZE, 0.69).unwrap();
    vec![
        ("dumbbell", dumbbell()),
        ("box", Shape::cuboid(Vec3::new(1.2, 1.0, 0.8) * SIZE, CRUST).unwrap()),
        ("cylinder", Shape::cylinder(0.4 * SIZE, 1.2 * SIZE, CRUST).unwrap()),
        ("cross", Shape::cross(3, 0.3 * SIZE, 1.5 * SIZE, CRUST).unwrap()),
        ("trilobe", Shape::lobes(lobes, 1.2 * SIZE, CRUST).unwrap()),
        ("eight cubes", eight_cubes()),
    ]
}

/// The surface point of a turned body that is farthest in a direction, from its centre (m).
fn farthest(shape: &Shape, turn: &Rotation, direction: Vec3) -> Vec3 {
    let toward = turn.inverse() * direction;
    let points = shape.parts.iter().map(|part| {
        let core = part.core.support(&(part.rotation.transpose() * toward));
        part.center + part.rotation * core + toward * part.crust
    });
    turn * points.max_by(|a, b| a.dot(&toward).total_cmp(&b.dot(&toward))).unwrap()
}

/// What a body bounces off.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Partner {
    Plane,
    Block,
    /// Squares of two triangles, smaller than the body.
    Tiles,
    /// A floor cut at random.
    Tiling,
    /// One mesh of two rectangles that meet below the body.
    Sheets,
    /// A wall of two boxes that meet below the body.
    Boxes,
    /// Another of the same shape, turned at random.
    Same,
    /// Another of the same shape that lies as the body does, edge on edge.
    Aligned,
    /// Another of the same shape, below it and nearly flush.
    Stacked,
    /// The same with parallel edges.
    Flush,
    /// Another of the same shape beside it, of which it meets an edge with an edge.
    Edge,
}

impl Partner {
    /// How another of the same shape and the body lie, turned at random by `turn`, and how far aside (m) it is.
    fn pair(self, shape: &Shape, turn: Rotation) -> Option<([Rotation; 2], Vec3)> {
        let (flush, askew) = (turn.angle() * 0.03, Rotation::new(turn.scaled_axis() * 0.03));
        let tilted = Rotation::from_axis_angle(&Vec3::y_axis(), flush);
        let (turns, aside) = match self {
            Partner::Same => ([turn_of((turn.angle() * 1e6) as usize), turn], [0.2, -0.1]),
            Partner::Aligned => ([turn; 2], [0.0; 2]),
            Partner::Stacked => ([Rotation::identity(), askew], [0.3, 0.13]),
            Partner::Flush => ([Rotation::identity(), tilted], [0.3, 0.13]),
            Partner::Edge => {
                let [left, right] =
                    [-1.0, 1.0].map(|side| farthest(shape, &Rotation::identity(), Vec3::x() * side).x);
                ([Rotation::identity(), tilted], [(right - left) / SIZE - 0.005, 0.13])
            }
            _ => return None,
        };
        Some((turns, Vec3::new(aside[0], aside[1], 0.0) * SIZE))
    }

    /// The surfaces of the floor, if it is none of a body.
    fn floor(self) -> Vec<Surface> {
        let up = Vec3::z();
        match self {
            Partner::Plane => vec![Surface::Plane { point: up * FLOOR, normal: up }],
            Partner::Tiles => vec![mesh_floor(37, 0.0)],
            Partner::Tiling => vec![mesh_floor(23, 0.3)],
            Partner::Sheets => vec![mesh_floor(2, 0.0)],
            Partner::Boxes => [-1.0, 1.0]
                .map(|side| Surface::Solid {
                    core: Core::Box(Vec3::new(0.02, 0.02, 0.005)),
                    rotation: Mat3::identity(),
                    center: Vec3::new(0.02 + 0.02 * side, 0.02, FLOOR - 0.005),
                    bounding_radius: 0.03,
                })
                .into(),
            _ => vec![],
        }
    }
}

/// A floor of n x n squares, each cut into two triangles, with corners moved at random by a share of a square.
fn mesh_floor(n: usize, shake: f64) -> Surface {
    let number = |k: usize| (k as f64 * 0.618_033_988_75).fract() - 0.5;
    let corner = |i: usize, j: usize| {
        let moves = |k: usize| if k.is_multiple_of(n) { 0.0 } else { 2.0 * shake };
        let off = Vec3::new(moves(i) * number(7 * i + 31 * j), moves(j) * number(17 * i + 5 * j), 0.0);
        (Vec3::new(i as f64, j as f64, 0.0) + off) * (0.04 / n as f64) + Vec3::z() * FLOOR
    };
    let vertices = (0..=n).flat_map(|j| (0..=n).map(move |i| corner(i, j))).collect();
    let at = |i: usize, j: usize| (j * (n + 1) + i) as u32;
    let triangles = (0..n * n).flat_map(|k| {
        let (i, j) = (k % n, k / n);
        [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
    });
    let mesh = TriMesh { vertices, triangles: triangles.collect() };
    Surface::Mesh(Arc::new(WallMesh::new(&mesh, SMOOTH_ANGLE).unwrap()))
}

/// Distance (m) of two turned bodies, the second being at `offset` (m) from the first.
fn distance_of(shape: &Shape, turns: [&Rotation; 2], offset: Vec3) -> f64 {
    let mut least = f64::INFINITY;
    for part in &shape.parts {
        let rotation = turns[0].to_rotation_matrix().into_inner() * part.rotation;
        for other in &shape.parts {
            let turned = turns[1].to_rotation_matrix().into_inner() * other.rotation;
            let between = offset + turns[1] * other.center - turns[0] * part.center;
            let placement = Placement {
                matrix: rotation.transpose() * turned,
                translation: rotation.transpose() * between,
            };
            let far = distance(&part.core, &other.core, &placement, 1.0, &mut Simplex::default()).unwrap();
            let Separation::Apart { distance, .. } = far else { panic!("bodies meet") };
            least = least.min(distance - part.crust - other.crust);
        }
    }
    least
}

/// Kinetic energy (J).
fn energy(dem: &Dem) -> f64 {
    (0..dem.particles.bodies.len())
        .map(|i| {
            let body = &dem.particles.bodies[i];
            let rotation = dem.particles.record(i).orientation;
            let omega = rotation.inverse() * body.angular_velocity;
            let inertia = dem.setup.catalogue.inertia(body);
            0.5 * (body.mass * body.velocity.norm_squared() + omega.component_mul(&omega).dot(&inertia))
        })
        .sum()
}

/// Energy after over before one bounce with a number of steps per shortest contact.
fn bounce(shape: &Shape, partner: Partner, turn: Rotation, restitution: f64, steps: f64) -> f64 {
    let law = ContactLaw::linear(STIFFNESS, restitution, 0.0, Tangential::Viscous { rate: 0.0 });
    let block = Shape::cuboid(Vec3::new(4.0, 4.0, 1.0) * SIZE, CRUST).unwrap();
    let mut setup = setup([0.04; 3], [false; 3], vec![shape.clone(), block], law);
    setup.catalogue.faces = FaceContact::MultiPoint;
    setup.catalogue.contacts.set(0, 1, law);
    setup.catalogue.densities = vec![2500.0, 2500.0];
    setup.parameters.gravity = Vec3::zeros();
    let felt = 2500.0 * shape.volume / SurfaceMobility::of(shape).along_normal;
    setup.parameters.dt = PI * (felt / STIFFNESS).sqrt() / steps;
    let floor = partner.floor();
    if !floor.is_empty() {
        setup.walls =
            vec![Wall { surfaces: floor.clone(), ..wall("floor", floor[0].clone(), Motion::Fixed) }];
    }
    let mut dem = Dem::new(setup, 0).unwrap();
    let is_plain = matches!(partner, Partner::Plane | Partner::Block);
    let [velocity, spin] = if is_plain {
        [-Vec3::z(), Vec3::zeros()]
    } else {
        [Vec3::new(0.3, 0.2, -1.0), Vec3::new(0.3, -0.2, 0.5) * (2.0 / SIZE)]
    }
    .map(|v| v * SPEED);
    let mut add = |id, shape, position, orientation, velocity| {
        let kind = Kind { shape, material: 0 };
        let angular_velocity = if velocity == Vec3::zeros() { velocity } else { spin };
        let new = NewParticle {
            id,
            kind,
            scale: 1.0,
            position,
            orientation,
            velocity,
            angular_velocity,
            temperature: 0.0,
        };
        let record = new.record(&dem);
        dem.insert(&record);
    };
    let at = Vec3::new(0.0203, 0.0197, FLOOR);
    if let Some(([below, turn], aside)) = partner.pair(shape, turn) {
        // Moved together by their distance until they nearly touch.
        let mut offset = aside + Vec3::z() * (2.1 * shape.bounding_radius);
        for _ in 0..2000 {
            let gap = distance_of(shape, [&below, &turn], offset);
            if gap < 2e-7 {
                break;
            }
            offset.z -= gap - 1e-7;
        }
        add(0, 0, at + offset, turn, velocity);
        add(1, 0, at, below, Vec3::zeros());
    } else {
        add(0, 0, at + Vec3::z() * 1e-7 - farthest(shape, &turn, -Vec3::z()), turn, velocity);
    }
    if partner == Partner::Block {
        add(1, 1, at - Vec3::z() * 0.5 * SIZE, Rotation::identity(), Vec3::zeros());
    }
    let before = energy(&dem);
    // Until they have been apart for a while: a body may touch several times in a row.
    let (mut step, mut apart, mut last) = (0.0, 0.0, before);
    while step < 2.0 * steps || apart < steps {
        dem.step(&SerialTransport).unwrap();
        let now = energy(&dem);
        apart = if (now / last - 1.0).abs() < 1e-13 { apart + 1.0 } else { 0.0 };
        (last, step) = (now, step + 1.0);
        assert!(step < 100.0 * steps, "no rebound");
    }
    energy(&dem) / before
}

/// Tilts from 0 to 90 degrees about a horizontal axis, at any turn about the vertical one.
fn tilts(count: usize) -> impl Iterator<Item = Rotation> {
    (0..count).map(move |k| {
        let [first, second] = [0.618_033_988_75, 0.754_877_666_25].map(|g: f64| (k as f64 * g).fract());
        // As many tilts below a tenth of a right angle as above.
        let tilt = if k % 2 == 0 { first * 0.1 } else { first } * FRAC_PI_2;
        Rotation::from_axis_angle(&Vec3::z_axis(), second)
            * Rotation::from_axis_angle(&Vec3::y_axis(), tilt)
            * Rotation::from_axis_angle(&Vec3::x_axis(), 0.3 * second * tilt)
    })
}

#[test]
fn elastic_bounces_keep_the_energy_to_second_order() {
    for partner in [Partner::Plane, Partner::Block] {
        for (name, shape) in shapes() {
            // Root mean square of the error: where a body meets between two steps spreads it.
            let [coarse, fine] = [50.0, 200.0].map(|steps| {
                let errors: Vec<f64> =
                    tilts(24).map(|turn| bounce(&shape, partner, turn, 1.0, steps) - 1.0).collect();
                let worst = errors.iter().fold(0.0_f64, |worst, error| worst.max(error.abs()));
                let limit = 1e-3 * (50.0 / steps);
                assert!(worst < limit, "{name} on {partner:?}, {steps} steps: {worst:e}");
                (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt()
            });
            // Sixteen of second order, four of first; below a part in a hundred thousand there is nothing to measure.
            assert!(fine < coarse / 8.0 || fine < 1e-5, "{name} on {partner:?}: {coarse:e}, {fine:e}");
        }
    }
}

#[test]
fn damped_bounces_take_energy() {
    const RESTITUTION: f64 = 0.8;
    for partner in [Partner::Plane, Partner::Block] {
        for (name, shape) in shapes() {
            for (k, turn) in tilts(24).enumerate() {
                let left = bounce(&shape, partner, turn, RESTITUTION, 50.0);
                assert!(left < 1.0, "{name} on {partner:?}: {left}");
                // The first falls flat: the whole of it has the restitution.
                if k == 0 && partner == Partner::Plane {
                    assert!((left - RESTITUTION.powi(2)).abs() < 2e-3, "{name}: {left}");
                }
            }
        }
    }
}

/// Any turn.
fn turn_of(seed: usize) -> Rotation {
    let number = |k: usize| ((seed * 7 + k) as f64 * 0.754_877_666_25).fract() - 0.5;
    Rotation::new(Vec3::new(number(1), number(3), number(11)) * (2.0 * PI))
}

/// Energy must stay where corners and edges of two bodies meet, and where a floor is cut: with spin, and at an angle.
#[test]
fn where_corners_come_and_go_no_energy_does() {
    let partners = [
        Partner::Tiles,
        Partner::Tiling,
        Partner::Sheets,
        Partner::Boxes,
        Partner::Same,
        Partner::Aligned,
        Partner::Stacked,
        Partner::Flush,
        Partner::Edge,
    ];
    for partner in partners {
        for (name, shape) in shapes() {
            // Bodies without long edges meet none.
            if partner == Partner::Edge && !["box", "cross", "eight cubes"].contains(&name) {
                continue;
            }
            let worst = |steps: f64, count: usize| {
                let errors = tilts(count).map(|turn| bounce(&shape, partner, turn, 1.0, steps) - 1.0);
                errors.fold(0.0_f64, |worst, error| worst.max(error.abs()))
            };
            let coarse = worst(50.0, 24);
            assert!(coarse < 2e-3, "{name} on {partner:?}: {coarse:e}");
            // Aligned edges and cylinders side by side keep a part in a thousand at any step.
            if matches!(partner, Partner::Tiling | Partner::Flush) {
                let fine = worst(200.0, 6);
                assert!(fine < 1e-4, "{name} on {partner:?}: {fine:e}");
            }
            let damped = tilts(8).map(|turn| bounce(&shape, partner, turn, 0.8, 50.0)).fold(0.0, f64::max);
            // One of them passes by.
            assert!(damped < 1.0 + 1e-12, "{name} on {partner:?}: {damped}");
        }
    }
}
