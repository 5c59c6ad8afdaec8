//! Rims of open tubes: both sides and both ends of a sheet of no thickness, for every kind of body.

use crate::common::{Random, Scene, knobbly_shapes, lattice, law, mixed_shapes, setup, wall};
use grains_contact::{ContactLaw, Tangential};
use grains_dem::{Dem, DemSetup, Kind, Motion, NewParticle, OpenTube, Skin, Surface};
use grains_domain::SerialTransport;
use grains_geometry::epa::penetration;
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::{Core, Mat3, Placement, Rotation, Shape, Simplex, Vec3};
use std::f64::consts::TAU;

const RADIUS: f64 = 1.5e-3;
const MIDDLE: f64 = 0.03;

/// Spheres, boxes, cylinders, hulls, lobes, crosses, glued spheres, superellipsoids, capsules and cones.
fn shapes() -> Vec<Shape> {
    let mut all = mixed_shapes(RADIUS);
    // Those met by their vertices only have no signed distance.
    all.extend(knobbly_shapes(RADIUS).into_iter().filter(|shape| shape.discrete.is_none()));
    all
}

fn tube(random: &mut Random, radius: f64) -> OpenTube {
    OpenTube { center: Vec3::repeat(MIDDLE), axis: random.direction(), radius, half_length: 4e-3 }
}

fn scene(tube: OpenTube, shape: Shape, law: ContactLaw, particle: NewParticle) -> Scene {
    let base = setup([2.0 * MIDDLE; 3], [false; 3], vec![shape], law);
    let mut scene = Scene { setup: DemSetup { overlap_limit: 1.0, ..base }, particles: vec![particle] };
    scene.setup.catalogue.contacts.set(0, 1, law);
    scene.setup.parameters.gravity = Vec3::zeros();
    scene.setup.walls = vec![wall("tube", Surface::OpenTube(tube), Motion::Fixed)];
    scene
}

fn particle(position: Vec3, orientation: Rotation) -> NewParticle {
    NewParticle {
        id: 0,
        kind: Kind { shape: 0, material: 0 },
        scale: 1.0,
        position,
        orientation,
        velocity: Vec3::zeros(),
        angular_velocity: Vec3::zeros(),
        temperature: 0.0,
    }
}

/// A point of the sheet at an angle (rad) and along the axis (m).
fn on_sheet(tube: &OpenTube, angle: f64, along: f64) -> Vec3 {
    let across = tube.axis.cross(&Vec3::ith(tube.axis.iamin(), 1.0)).normalize();
    let second = tube.axis.cross(&across);
    tube.center + (across * angle.cos() + second * angle.sin()) * tube.radius + tube.axis * along
}

/// Signed distance (m) of a shape in its place from a point, and the normal towards the point.
fn signed_distance(shape: &Shape, at: &Vec3, turn: &Rotation, point: &Vec3) -> (f64, Vec3) {
    let local = turn.inverse() * (point - at);
    let mut best = (f64::INFINITY, Vec3::zeros());
    for part in &shape.parts {
        let translation = part.rotation.transpose() * (local - part.center);
        let placement = Placement { matrix: Mat3::identity(), translation };
        let mut simplex = Simplex::default();
        let (gap, normal) = if matches!(part.core, Core::Point) {
            (translation.norm(), translation.normalize())
        } else {
            match distance(&part.core, &Core::Point, &placement, f64::INFINITY, &mut simplex).unwrap() {
                Separation::Apart { distance, normal, .. } => (distance, normal),
                _ => {
                    let p = penetration(&part.core, &Core::Point, &placement, &simplex).unwrap();
                    (-p.depth, p.normal)
                }
            }
        };
        if gap - part.crust < best.0 {
            best = (gap - part.crust, turn * (part.rotation * normal));
        }
    }
    best
}

/// Nearest of many points of the sheet: signed distance (m), and normal towards it.
fn sampled(tube: &OpenTube, shape: &Shape, at: &Vec3, turn: &Rotation, searches: usize) -> (f64, Vec3) {
    let look = |angle: f64, along: f64| signed_distance(shape, at, turn, &on_sheet(tube, angle, along));
    let mut points = Vec::new();
    for i in 0..96 {
        for j in 0..=24 {
            let place = [TAU * f64::from(i) / 96.0, tube.half_length * (f64::from(j) / 12.0 - 1.0)];
            if (on_sheet(tube, place[0], place[1]) - at).norm() < 1.5 * shape.bounding_radius {
                points.push((place, look(place[0], place[1])));
            }
        }
    }
    points.sort_by(|a, b| a.1.0.total_cmp(&b.1.0));
    // The nearest points that are not side by side, each improved by a search at random, which no edge holds up.
    let mut starts: Vec<([f64; 2], (f64, Vec3))> = Vec::new();
    for point in points {
        let place = |p: &([f64; 2], (f64, Vec3))| on_sheet(tube, p.0[0], p.0[1]);
        if starts.len() < searches && starts.iter().all(|s| (place(s) - place(&point)).norm() > 0.3 * RADIUS)
        {
            starts.push(point);
        }
    }
    let mut random = Random(7);
    for start in &mut starts {
        let mut size = 1.0;
        while size > 1e-6 {
            let mut moved = false;
            for _ in 0..24 {
                let [i, j] = [size, size].map(|s| s * (2.0 * random.unit() - 1.0));
                let end = tube.half_length;
                let angle = start.0[0] + i * TAU / 96.0;
                let along = (start.0[1] + j * end / 12.0).clamp(-end, end);
                let found = look(angle, along);
                if found.0 < start.1.0 {
                    (*start, moved) = (([angle, along], found), true);
                }
            }
            size *= if moved { 1.0 } else { 0.6 };
        }
    }
    let nearest = starts.into_iter().min_by(|a, b| a.1.0.total_cmp(&b.1.0));
    nearest.map_or((f64::INFINITY, Vec3::zeros()), |n| n.1)
}

fn deepest_contact(dem: &mut Dem) -> f64 {
    dem.step(&SerialTransport).unwrap();
    let mut deepest = 0.0_f64;
    dem.for_each_contact(|touch| deepest = deepest.max(touch.overlap));
    deepest
}

/// The deepest contact is as deep as the deepest of many points of the sheet: over rims, inside and outside.
#[test]
fn bodies_meet_open_tubes_where_points_of_the_sheet_are_in_them() {
    let mut random = Random(1);
    for (number, shape) in shapes().into_iter().enumerate() {
        let crust = shape.parts.iter().map(|p| p.crust).fold(f64::INFINITY, f64::min);
        let depth = 0.5 * crust.min(0.1 * RADIUS);
        let mut found = 0;
        for _ in 0..14 {
            let tube = tube(&mut random, [0.8, 2.0, 4.0][found % 3] * RADIUS * 1.3);
            let rim = [-1.0, 1.0][found % 2] * (tube.half_length + 0.5 * RADIUS * (random.unit() - 0.5));
            let turn = Rotation::new(random.vector() * 3.0);
            let mut at = on_sheet(&tube, TAU * random.unit(), rim) + random.vector() * (1.2 * RADIUS);
            for _ in 0..4 {
                let (gap, normal) = sampled(&tube, &shape, &at, &turn, 1);
                at += normal * if gap.is_finite() { gap + depth } else { 0.0 };
            }
            let (gap, _) = sampled(&tube, &shape, &at, &turn, 5);
            if gap < -2.0 * depth || gap.is_infinite() {
                continue; // wedged: the sheet goes through it
            }
            let mut scene = scene(tube, shape.clone(), law(false), particle(at, turn));
            scene.setup.parameters.dt = 1e-12;
            let deepest = deepest_contact(&mut scene.start([1; 3], 0));
            let error = (deepest - (-gap).max(0.0)).abs();
            assert!(
                error < 1e-5 * RADIUS,
                "shape {number} at {at} in {tube:?}: {deepest:e} m for {:e}",
                -gap
            );
            found += 1;
        }
        assert!(found > 2, "shape {number}: {found}");
    }
}

fn energy(dem: &Dem, shape: &Shape) -> f64 {
    let body = &dem.particles.bodies[0];
    let frame = dem.particles.frames.first().copied().unwrap_or_else(Mat3::identity);
    let spin = frame.tr_mul(&body.angular_velocity);
    let per_mass = shape.inertia / shape.volume;
    0.5 * body.mass * (body.velocity.norm_squared() + spin.component_mul(&spin).dot(&per_mass))
}

/// Elastic bodies keep their energy on the rim, whichever way they come.
#[test]
fn elastic_bodies_bounce_off_rims_with_the_energy_they_had() {
    let elastic = ContactLaw::linear(1e5, 1.0, 0.0, Tangential::Viscous { rate: 0.0 });
    let (mut random, mut worst) = (Random(2), 0.0_f64);
    for (number, shape) in shapes().into_iter().enumerate() {
        if shape.parts.len() > 1 {
            continue; // the law of several parts is another matter
        }
        let mut bounced = 0;
        for _ in 0..10 {
            let tube = tube(&mut random, [0.8, 2.0, 4.0][bounced % 3] * RADIUS * 1.3);
            let target = on_sheet(&tube, TAU * random.unit(), [-1.0, 1.0][bounced % 2] * tube.half_length);
            let outward = (target - tube.center).dot(&tube.axis).signum() * tube.axis;
            let way = (outward + random.vector() * 0.9).normalize();
            let start = target + way * (1.3 * shape.bounding_radius) + random.vector() * (0.2 * RADIUS);
            let new =
                NewParticle { velocity: -way * 0.3, ..particle(start, Rotation::new(random.vector() * 3.0)) };
            let mut scene = scene(tube, shape.clone(), elastic, new);
            scene.setup.parameters.dt = 2.5e-7;
            let mut dem = scene.start([1; 3], 0);
            let first = dem.step(&SerialTransport);
            if first.is_err() || dem.wall_loads(&SerialTransport)[0].force != Vec3::zeros() {
                continue; // it began in the wall
            }
            let before = energy(&dem, &shape);
            let mut touched = false;
            for _ in 0..80_000 {
                dem.step(&SerialTransport).unwrap();
                let touches = dem.wall_loads(&SerialTransport)[0].force != Vec3::zeros();
                if touched && !touches {
                    break;
                }
                touched |= touches;
            }
            if !touched {
                continue;
            }
            bounced += 1;
            let change = energy(&dem, &shape) / before - 1.0;
            worst = worst.max(change.abs());
            assert!(
                change.abs() < 5e-4,
                "shape {number}: {change:e} after {:?} and {tube:?}",
                scene.particles
            );
        }
        assert!(bounced > 2, "shape {number}: {bounced}");
    }
    println!("energy changes by {worst:e}");
}

/// A ball larger than the tube sits in it as on a seat, and one placed off its middle comes back over it.
#[test]
fn a_ball_on_a_seat_is_held_all_around() {
    let law = ContactLaw::linear(1e5, 0.3, 0.0, Tangential::Viscous { rate: 0.0 });
    let tube =
        OpenTube { center: Vec3::repeat(MIDDLE), axis: Vec3::z(), radius: 0.6 * RADIUS, half_length: 4e-3 };
    for off in [0.0, 1e-6, 1e-4] {
        let height = tube.half_length + 0.88 * RADIUS;
        let new = particle(tube.center + Vec3::new(off, 0.0, height), Rotation::identity());
        let mut scene = scene(tube, Shape::sphere(RADIUS).unwrap(), law, new);
        scene.setup.parameters.gravity = -Vec3::z() * 9.81;
        let mut dem = scene.start([1; 3], 0);
        (0..50_000).for_each(|_| dem.step(&SerialTransport).unwrap());
        let body = &dem.particles.bodies[0];
        let from = body.position - tube.center;
        assert!(
            from.xy().norm() < 1e-6 && (from.z - tube.half_length - 0.8 * RADIUS).abs() < 1e-6,
            "{off}: {from}"
        );
        let weight = dem.wall_loads(&SerialTransport)[0].force;
        assert!((weight.z + 9.81 * body.mass).abs() < 1e-2 * 9.81 * body.mass, "{weight}");
    }
}

/// Spheres, hulls and composites rain over a shaken tube: the same bits on any ranks and skin and after a restart.
#[test]
fn a_rain_over_a_tube_is_the_same_on_any_ranks_skin_and_restart() {
    for (shapes, steps) in [(mixed_shapes(1.4e-3), 1500), (knobbly_shapes(1.4e-3), 1700)] {
        let kinds = shapes.len() as u16;
        let mut setup = setup([0.03, 0.03, 0.04], [true, true, false], shapes, law(true));
        setup.parameters.gravity = Vec3::new(2.0, 1.0, -60.0);
        let shake = Motion::Oscillation {
            amplitude: Vec3::new(2e-4, 1e-4, 1e-4),
            frequency: 60.0,
            phase: 0.3,
            start: 0.0,
            end: f64::INFINITY,
        };
        let axis = Vec3::new(0.1, -0.2, 1.0).normalize();
        let tube = OpenTube { center: Vec3::new(0.012, 0.015, 0.012), axis, radius: 7e-3, half_length: 5e-3 };
        setup.walls = vec![
            wall("tube", Surface::OpenTube(tube), shake),
            wall(
                "floor",
                Surface::Plane { point: Vec3::new(0.0, 0.0, 2e-3), normal: Vec3::z() },
                Motion::Fixed,
            ),
        ];
        let mut particles = lattice([0.0, 0.0, 0.0195], [0.03, 0.03, 0.026], 3.2e-3, kinds, 0.5);
        particles.iter_mut().for_each(|p| p.velocity.z -= 1.0);
        let mut scene = Scene { setup, particles };
        let mut dem = scene.start([1; 3], 0);
        let mut touches = 0;
        for _ in 0..steps {
            dem.step(&SerialTransport).unwrap();
            touches += usize::from(dem.wall_loads(&SerialTransport)[0].force != Vec3::zeros());
        }
        assert!(touches > 100, "{touches}");
        let reference = scene.run([1; 3], steps);
        for ranks in [[2, 1, 1], [2, 2, 2]] {
            assert!(reference == scene.run(ranks, steps), "{ranks:?}");
        }
        assert!(reference == scene.run_with_restart([2, 1, 1], steps - 50, [1, 3, 1], 50), "restart");
        scene.setup.skin = Skin { min: 0.1, max: 0.2, horizon: 7.0 };
        assert!(reference == scene.run([2, 1, 1], steps), "skin");
    }
}
