//! One collision: restitution, duration and depth against the closed forms, and conservation.

use crate::common::{law, setup, wall};
use grains_contact::{Collision, ContactLaw, Tangential};
use grains_dem::{Dem, DemSetup, Kind, Motion, NewParticle, Surface};
use grains_domain::SerialTransport;
use grains_geometry::{RegularSolid, Rotation, SMOOTH_ANGLE, Shape, TriMesh, Vec3, WallMesh};
use std::sync::Arc;

const RADIUS: f64 = 1.5e-3;

fn particle(id: u64, shape: u16, position: Vec3, velocity: Vec3) -> NewParticle {
    NewParticle {
        id,
        kind: Kind { shape, material: 0 },
        scale: 1.0,
        position,
        orientation: Rotation::identity(),
        velocity,
        angular_velocity: Vec3::zeros(),
        temperature: 0.0,
    }
}

fn dem_of(setup: DemSetup, particles: &[NewParticle]) -> Dem {
    let mut dem = Dem::new(setup, 0).unwrap();
    for p in particles {
        let record = p.record(&dem);
        dem.insert(&record);
    }
    dem
}

fn quiet(law: ContactLaw, steps_per_contact: f64, collision: &Collision) -> DemSetup {
    let mut setup = setup([0.05; 3], [false; 3], vec![Shape::sphere(RADIUS).unwrap()], law);
    setup.parameters.gravity = Vec3::zeros();
    setup.parameters.dt = collision.contact_time / steps_per_contact;
    setup
}

/// Restitution, contact time (s) and largest overlap (m) seen in a head-on collision at 1 m/s.
fn collide(mut dem: Dem, speed: f64) -> [f64; 3] {
    let (mut steps, mut deepest) = (0, 0.0_f64);
    let transport = SerialTransport;
    loop {
        dem.refresh(&transport).unwrap();
        dem.add_forces(&transport);
        let overlap = dem.report.max_overlap * RADIUS;
        deepest = deepest.max(overlap);
        if overlap > 0.0 {
            steps += 1;
        }
        dem.advance(&transport).unwrap();
        if overlap == 0.0 && steps > 0 {
            // One free step on, the velocity no longer holds the last acceleration of the contact.
            break;
        }
    }
    let velocity = |i: usize| dem.particles.bodies[i].velocity.z;
    let after = if dem.particles.owned == 2 {
        let (low, high) = if dem.particles.ids[0] == 0 { (0, 1) } else { (1, 0) };
        velocity(high) - velocity(low)
    } else {
        velocity(0)
    };
    [after / speed, steps as f64 * dem.setup.parameters.dt, deepest]
}

fn laws() -> Vec<ContactLaw> {
    let spring = Tangential::Spring { stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.5 };
    let viscous = Tangential::Viscous { rate: 1e5 };
    [spring, viscous]
        .into_iter()
        .flat_map(|t| [0.73, 0.5, 1.0].map(|e| ContactLaw::linear(1e5, e, 0.55, t)))
        .collect()
}

#[test]
fn pair_and_wall_collisions_match_the_closed_forms() {
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3);
    for law in laws() {
        for is_wall in [false, true] {
            let collision = law.collision(if is_wall { mass } else { 0.5 * mass }, RADIUS, 1.0);
            let mut setup = quiet(law, 400.0, &collision);
            let middle = Vec3::repeat(0.025);
            // a gap that is no multiple of the way per step
            let gap = 3.37e-2 * collision.contact_time;
            let dem = if is_wall {
                let floor = Surface::Plane { point: middle, normal: Vec3::z() };
                setup.catalogue.contacts.set(0, 1, law);
                setup.walls = vec![wall("floor", floor, Motion::Fixed)];
                dem_of(setup, &[particle(0, 0, middle + Vec3::z() * (RADIUS + gap), -Vec3::z())])
            } else {
                let lift = Vec3::z() * (RADIUS + 0.5 * gap);
                let (a, b) = (middle - lift, middle + lift);
                dem_of(setup, &[particle(0, 0, a, Vec3::z() * 0.5), particle(1, 0, b, -Vec3::z() * 0.5)])
            };
            let [restitution, duration, depth] = collide(dem, 1.0);
            let wanted = [law.restitution, collision.contact_time, collision.max_overlap];
            for (got, want) in [restitution, duration, depth].iter().zip(wanted) {
                assert!(
                    (got / want - 1.0).abs() < 5e-3,
                    "wall {is_wall} e {}: {got} for {want}",
                    law.restitution
                );
            }
        }
    }
}

#[test]
fn restitution_converges_with_order_two_for_every_phase_of_the_contact() {
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3);
    let law = ContactLaw::linear(1e5, 0.73, 0.0, Tangential::Viscous { rate: 0.0 });
    let collision = law.collision(mass, RADIUS, 1.0);
    let worst = |steps: f64| {
        let phase = |k: usize| {
            let mut setup = quiet(law, steps, &collision);
            let floor = Surface::Plane { point: Vec3::repeat(0.025), normal: Vec3::z() };
            setup.catalogue.contacts.set(0, 1, law);
            let gap = setup.parameters.dt * (k as f64 / 25.0 + 1e-3);
            setup.walls = vec![wall("floor", floor, Motion::Fixed)];
            let start = Vec3::repeat(0.025) + Vec3::z() * (RADIUS + gap);
            (collide(dem_of(setup, &[particle(0, 0, start, -Vec3::z())]), 1.0)[0] - 0.73).abs()
        };
        (0..25).map(phase).fold(0.0, f64::max)
    };
    let (coarse, fine) = (worst(50.0), worst(100.0));
    println!("largest error of e_n: {coarse:.2e} at T_c/dt = 50, {fine:.2e} at 100");
    // The lagged velocity of the plain leap-frog has 7e-3 and 4e-3.
    assert!(coarse < 5e-4 && coarse / fine > 2.8, "errors {coarse:e} and {fine:e}");
}

#[test]
fn a_pair_of_any_shapes_conserves_momentum_and_angular_momentum() {
    for spring in [true, false] {
        for shapes in [[0, 0], [0, 1], [1, 2], [2, 3], [3, 3]] {
            let mut setup = setup([0.05; 3], [false; 3], crate::common::mixed_shapes(RADIUS), law(spring));
            setup.parameters.gravity = Vec3::zeros();
            let middle = Vec3::repeat(0.025);
            let offset = Vec3::new(2.2, 0.5, 0.3) * RADIUS;
            let mut a = particle(0, shapes[0], middle, Vec3::zeros());
            let mut b = particle(1, shapes[1], middle + offset, Vec3::new(-2.0, -0.3, 0.4));
            a.orientation = Rotation::from_euler_angles(0.3, 0.5, 0.7);
            b.orientation = Rotation::from_euler_angles(1.3, -0.5, 0.2);
            a.angular_velocity = Vec3::new(100.0, -300.0, 50.0);
            let mut dem = dem_of(setup, &[a, b]);
            let transport = SerialTransport;
            // Momenta live with the half-step velocities.
            let momenta = |dem: &Dem| {
                let p = &dem.particles;
                let (mut momentum, mut angular, mut scale) = (Vec3::zeros(), Vec3::zeros(), [0.0; 2]);
                for i in 0..p.owned {
                    let (m, x, v) = (p.bodies[i].mass, p.bodies[i].position - middle, p.half_velocity[i]);
                    // position half a step back, where the velocity belongs
                    let x = x - v * (0.5 * dem.setup.parameters.dt);
                    let shape = dem.setup.catalogue.shape(p.bodies[i].kind);
                    let spin = if shape.is_sphere() {
                        p.half_spin[i] * 0.4 * m * p.bodies[i].radius.powi(2)
                    } else {
                        p.half_spin[i]
                    };
                    momentum += v * m;
                    angular += x.cross(&v) * m + spin;
                    scale[0] += m * v.norm();
                    scale[1] += m * x.norm() * v.norm();
                }
                (momentum, angular, scale)
            };
            dem.step(&transport).unwrap();
            let before = momenta(&dem);
            let (mut touched, mut worst) = (false, (0.0_f64, 0.0_f64));
            for _ in 0..300 {
                dem.refresh(&transport).unwrap();
                dem.add_forces(&transport);
                touched |= dem.report.max_overlap > 0.0;
                let p = &dem.particles;
                let (mut moment, mut scale) = (Vec3::zeros(), 0.0);
                for i in 0..p.owned {
                    let x = p.bodies[i].position - middle;
                    moment += x.cross(&p.loads[i].force) + p.loads[i].torque;
                    scale += x.norm() * p.loads[i].force.norm() + p.loads[i].torque.norm();
                }
                worst = (worst.0.max(moment.norm()), worst.1.max(scale));
                dem.advance(&transport).unwrap();
            }
            assert!(
                worst.0 < 1e-12 * worst.1,
                "moment {:e} of the forces of {shapes:?} of {:e}",
                worst.0,
                worst.1
            );
            let after = momenta(&dem);
            assert!(touched, "{shapes:?} never met");
            assert!((after.0 - before.0).norm() < 1e-12 * before.2[0], "momentum of {shapes:?}");
            let error = (after.1 - before.1).norm() / after.2[1];
            // Positions are multiples of 1.4e-17 m: 300 steps may add up to 2e-15 m of way.
            assert!(error < 4e-12, "angular momentum of {shapes:?}: relative error {error:e}");
        }
    }
}

/// Velocity and spin after an impact at an angle (from the normal) on a surface through `middle`.
fn oblique(angle: f64, law: ContactLaw, surface: Option<Surface>) -> (Vec3, Vec3) {
    let middle = Vec3::repeat(0.025);
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3);
    let mut setup = quiet(law, 200.0, &law.collision(mass, RADIUS, 1.0));
    setup.catalogue.contacts.set(0, 1, law);
    let velocity = Vec3::new(angle.sin(), 0.3 * angle.sin(), -angle.cos());
    let start = middle + Vec3::new(0.31, 0.17, 0.0) * RADIUS + Vec3::z() * (RADIUS + 1e-7);
    let mut bodies = vec![particle(0, 0, start, velocity)];
    match surface {
        Some(surface) => setup.walls = vec![wall("wall", surface, Motion::Fixed)],
        None => {
            // A block as heavy as a wall, with its upper face where the plane is.
            const EDGE: f64 = 0.02;
            let block = Shape::cuboid(Vec3::repeat(EDGE), 0.02).unwrap();
            setup.largest_radius = block.bounding_radius;
            setup.catalogue.shapes.push(block);
            setup.catalogue.densities = vec![2500.0, 2500.0 * 1e14];
            let below = middle - Vec3::z() * (0.5 * EDGE);
            bodies.push(NewParticle {
                kind: Kind { shape: 1, material: 1 },
                ..particle(1, 1, below, Vec3::zeros())
            });
        }
    }
    let mut dem = dem_of(setup, &bodies);
    let transport = SerialTransport;
    let steps = (2e-7 / angle.cos() / dem.setup.parameters.dt) as usize + 260;
    for _ in 0..steps {
        dem.step(&transport).unwrap();
    }
    let i = dem.particles.ids.iter().position(|&id| id == 0).unwrap();
    (dem.particles.bodies[i].velocity, dem.particles.bodies[i].angular_velocity)
}

fn tessellation() -> TriMesh {
    // A plane cut into triangles with their edges and vertices under the ball.
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    let (n, h) = (9, 2.0 * RADIUS / 3.0);
    for j in 0..n {
        for i in 0..n {
            vertices.push(Vec3::repeat(0.025) + Vec3::new((i as f64 - 4.0) * h, (j as f64 - 4.0) * h, 0.0));
        }
    }
    for j in 0..n - 1 {
        for i in 0..n - 1 {
            let k = j * n + i;
            faces.extend([vec![k, k + 1, k + n + 1], vec![k, k + n + 1, k + n]]);
        }
    }
    TriMesh::from_polygons(vertices, &faces).unwrap()
}

#[test]
fn plane_and_tessellation_give_the_same_rebound_at_all_angles_and_no_energy() {
    let plane = Surface::Plane { point: Vec3::repeat(0.025), normal: Vec3::z() };
    let mesh = Surface::Mesh(Arc::new(WallMesh::new(&tessellation(), SMOOTH_ANGLE).unwrap()));
    for law in laws() {
        for degrees in [0.0_f64, 10.0, 30.0, 45.0, 60.0, 75.0, 85.0, 89.0] {
            let angle = degrees.to_radians();
            let (v, w) = oblique(angle, law, Some(plane.clone()));
            let (v_mesh, w_mesh) = oblique(angle, law, Some(mesh.clone()));
            let difference = (v - v_mesh).norm() + RADIUS * (w - w_mesh).norm();
            assert!(difference < 1e-9, "{degrees} degrees: plane {v:?}, mesh {v_mesh:?}");
            let before = angle.cos().powi(2) + 1.09 * angle.sin().powi(2);
            let after = v.norm_squared() + 0.4 * RADIUS * RADIUS * w.norm_squared();
            assert!(
                after <= before * (1.0 + 2e-3),
                "{degrees} degrees: energy grew from {before} to {after}"
            );
            assert!(
                (v.z / angle.cos() - law.restitution).abs() < 5e-3,
                "{degrees} degrees: {}",
                v.z / angle.cos()
            );
        }
    }
}

#[test]
fn a_body_gives_the_same_rebound_as_a_wall() {
    for law in laws() {
        for degrees in [0.0_f64, 20.0, 45.0, 60.0, 75.0, 85.0, 89.0] {
            let angle = degrees.to_radians();
            let plane = Surface::Plane { point: Vec3::repeat(0.025), normal: Vec3::z() };
            let (v, w) = oblique(angle, law, Some(plane));
            let (v_body, w_body) = oblique(angle, law, None);
            let difference = (v - v_body).norm() + RADIUS * (w - w_body).norm();
            assert!(difference < 1e-6, "{degrees} degrees: {difference}");
        }
    }
}

/// Table A3 of the reference values: thesis law, friction 0.55, γt = 1e5 1/s, e 0.73.
#[test]
fn oblique_impacts_of_the_memoryless_law_match_the_reference() {
    let law = ContactLaw::linear(1e5, 0.73, 0.55, Tangential::Viscous { rate: 1e5 });
    let rows = [
        (30.0_f64, None),
        (60.0, None),
        (75.0, Some([0.719660, 0.615666])),
        (85.0, Some([0.913266, 0.207322])),
    ];
    for (degrees, sliding) in rows {
        let angle = degrees.to_radians();
        // Up to 73 degrees the ball ends rolling, with 5/7 of its tangential velocity.
        let [tangential, spin] = sliding.unwrap_or([angle.sin() / 1.4; 2]);
        let plane = Surface::Plane { point: Vec3::repeat(0.025), normal: Vec3::z() };
        let middle = Vec3::repeat(0.025);
        let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3);
        let mut setup = quiet(law, 400.0, &law.collision(mass, RADIUS, 1.0));
        setup.catalogue.contacts.set(0, 1, law);
        setup.walls = vec![wall("wall", plane, Motion::Fixed)];
        let velocity = Vec3::new(angle.sin(), 0.0, -angle.cos());
        let mut dem = dem_of(setup, &[particle(0, 0, middle + Vec3::z() * (RADIUS + 1e-8), velocity)]);
        for _ in 0..450 {
            dem.step(&SerialTransport).unwrap();
        }
        let body = &dem.particles.bodies[0];
        let surface = (body.angular_velocity.y * RADIUS).abs();
        for (got, want) in [(body.velocity.x, tangential), (surface, spin)] {
            assert!((got / want - 1.0).abs() < 5e-3, "{degrees} degrees: {got}, reference {want}");
        }
    }
}

#[test]
fn a_ball_rolling_over_a_tessellated_floor_feels_a_plane() {
    let roll = |surface: Surface| {
        let mut setup = setup([0.05; 3], [false; 3], vec![Shape::sphere(RADIUS).unwrap()], law(true));
        setup.walls = vec![wall("floor", surface, Motion::Fixed)];
        let weight = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3) * 9.81;
        let start = Vec3::repeat(0.025) + Vec3::new(-3.3e-3, -2.1e-3, RADIUS - weight / 1e5);
        let mut dem = dem_of(setup, &[particle(0, 0, start, Vec3::new(0.2, 0.13, 0.0))]);
        for _ in 0..7000 {
            dem.step(&SerialTransport).unwrap();
        }
        dem.particles.bodies[0]
    };
    let plane = roll(Surface::Plane { point: Vec3::repeat(0.025), normal: Vec3::z() });
    let mesh = roll(Surface::Mesh(Arc::new(WallMesh::new(&tessellation(), SMOOTH_ANGLE).unwrap())));
    assert!((plane.position - mesh.position).norm() < 1e-9, "{} and {}", plane.position, mesh.position);
    assert!((plane.velocity - mesh.velocity).norm() < 1e-7 && plane.velocity.x > 0.1);
    assert!(plane.position.x > 0.0255, "the ball must have crossed several triangles");
}

/// A cube dropped flat or on an edge or corner returns e at its contact point, on a plane and on a mesh.
#[test]
fn bodies_on_a_mesh_rebound_as_on_the_plane() {
    let plane = Surface::Plane { point: Vec3::repeat(0.025), normal: Vec3::z() };
    let mesh = Surface::Mesh(Arc::new(WallMesh::new(&tessellation(), SMOOTH_ANGLE).unwrap()));
    let shapes = || {
        vec![
            Shape::cuboid(Vec3::repeat(2e-3), 0.05).unwrap(),
            Shape::regular(RegularSolid::Icosahedron, RADIUS, 0.05).unwrap(),
        ]
    };
    for shape in [0, 1] {
        for turn in [Rotation::from_euler_angles(0.5, 0.3, 0.1), Rotation::from_euler_angles(0.9, 0.6, 0.2)] {
            let rebound = |surface: Surface| {
                let mut setup = setup([0.05; 3], [false; 3], shapes(), law(true));
                setup.parameters.gravity = Vec3::zeros();
                setup.walls = vec![wall("floor", surface, Motion::Fixed)];
                let start = Vec3::repeat(0.025) + Vec3::new(0.2e-3, 0.1e-3, 2.2e-3);
                let mut body = particle(0, shape, start, Vec3::new(0.1, 0.0, -1.0));
                body.orientation = turn;
                let mut dem = dem_of(setup, &[body]);
                for _ in 0..400 {
                    dem.step(&SerialTransport).unwrap();
                }
                dem.particles.bodies[0]
            };
            let (on_plane, on_mesh) = (rebound(plane.clone()), rebound(mesh.clone()));
            let difference = (on_plane.velocity - on_mesh.velocity).norm();
            assert!(difference < 1e-6, "shape {shape}: {} and {}", on_plane.velocity, on_mesh.velocity);
            assert!(on_plane.velocity.z > -0.9, "it must have hit the floor");
        }
    }
}

/// A corner that goes deeper than the crusts is resolved by the penetration routine, without a jump of force.
#[test]
fn a_collision_deeper_than_the_crusts_keeps_its_restitution() {
    let law = ContactLaw::linear(1e5, 0.75, 0.0, Tangential::Viscous { rate: 0.0 });
    let half_edge = 1e-3;
    let shapes = vec![Shape::cuboid(Vec3::repeat(2.0 * half_edge), 0.02).unwrap()];
    let mut setup = setup([0.05; 3], [false; 3], shapes, law);
    setup.parameters.gravity = Vec3::zeros();
    setup.parameters.dt = 2e-7;
    let middle = Vec3::repeat(0.025);
    let speed = 20.0;
    let corner = Rotation::rotation_between(&Vec3::new(1.0, 1.0, 1.0), &-Vec3::z()).unwrap();
    let gap = 1e-5;
    let height = half_edge * (1.0 + 3_f64.sqrt()) + gap;
    let below = particle(0, 0, middle, Vec3::zeros());
    let above = NewParticle {
        orientation: corner,
        ..particle(1, 0, middle + Vec3::z() * height, -Vec3::z() * speed)
    };
    let mut dem = dem_of(setup, &[below, above]);
    for _ in 0..1000 {
        dem.step(&SerialTransport).unwrap();
    }
    let velocity = |id: u64| {
        let i = dem.particles.ids.iter().position(|&other| other == id).unwrap();
        dem.particles.bodies[i].velocity
    };
    let restitution = (velocity(1) - velocity(0)).z / speed;
    assert!((restitution / 0.75 - 1.0).abs() < 5e-3, "{restitution}");
    assert!(dem.report.deep_penetrations > 20, "the cores met {} times", dem.report.deep_penetrations);
}

/// Oblique impact at 1 m/s on a wall under the contact-time law, e = 1: velocity along the wall and spin times
/// radius afterwards, for a slope v_t/v_n.
fn oblique_with_contact_time(stiffness_ratio: f64, friction: f64, slope: f64) -> [f64; 2] {
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3);
    let law = ContactLaw::linear(1e5, 1.0, friction, Tangential::ContactTime { stiffness_ratio });
    let mut setup = quiet(law, 800.0, &law.collision(mass, RADIUS, 1.0));
    let middle = Vec3::repeat(0.025);
    setup.catalogue.contacts.set(0, 1, law);
    setup.walls = vec![wall("floor", Surface::Plane { point: middle, normal: Vec3::z() }, Motion::Fixed)];
    let gap = 1e-3 * setup.parameters.dt;
    let start = middle + Vec3::z() * (RADIUS + gap);
    let mut dem = dem_of(setup, &[particle(0, 0, start, Vec3::new(slope, 0.0, -1.0))]);
    for _ in 0..820 {
        dem.step(&SerialTransport).unwrap();
    }
    let body = dem.particles.bodies[0];
    assert!((body.velocity.z - 1.0).abs() < 1e-3);
    [body.velocity.x, body.angular_velocity.y * RADIUS]
}

/// Srinivasan 2019, eqs 3.43-3.47: below the cap the slip of a sphere decays at 7/2 k_t τ_c/m, so by
/// exp(−7/2 π² k_t/k_n) in a contact; at the cap friction takes μ (1 + e) v_n.
#[test]
fn the_contact_time_law_makes_slip_decay_and_slides_at_the_cap() {
    let ratio: f64 = 0.02;
    let decay = (-3.5 * std::f64::consts::PI.powi(2) * ratio).exp();
    let [speed, spin] = oblique_with_contact_time(ratio, 1e4, 0.5);
    assert!(((speed - spin) / 0.5 / decay - 1.0).abs() < 5e-3, "slip {} for {}", speed - spin, 0.5 * decay);
    let [speed, spin] = oblique_with_contact_time(2.0 / 7.0, 0.1, 2.0);
    assert!((speed - (2.0 - 0.2)).abs() < 1e-3 && (spin - 2.5 * 0.2).abs() < 3e-3, "{speed} {spin}");
}
