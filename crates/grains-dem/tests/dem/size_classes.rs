//! Wide distributions of sizes: every contact is found, and the bits are the same on any ranks.

use crate::common::{Scene, lattice, mixed_shapes, setup, wall};
use grains_contact::{ContactLaw, Lubrication, Tangential};
use grains_dem::{CollisionModel, Dem, HardModel, Kind, Motion, NewParticle, Partner, Surface};
use grains_domain::{Balance, SerialTransport, Transport};
use grains_geometry::{Rotation, Shape, Vec3};
use grains_testing::on_ranks;

/// Radius of the large spheres (m).
const LARGE: f64 = 4e-3;

/// A law of contacts that last for many steps, of small particles too.
fn soft() -> ContactLaw {
    let tangential = Tangential::Spring { stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.5 };
    ContactLaw::linear(2e3, 0.75, 0.5, tangential)
}

/// A box, periodic along x and y, of a few large particles of `shapes` amid ones a twentieth and a third of their size.
fn mixture(shapes: Vec<Shape>) -> Scene {
    let kinds = shapes.len() as u16;
    let mut setup = setup([0.03, 0.03, 0.03], [true, true, false], shapes, soft());
    setup.parameters.dt = 1e-6;
    setup.overlap_limit = 0.6;
    setup.parameters.gravity = Vec3::new(0.0, 0.0, -100.0);
    setup.walls =
        vec![wall("floor", Surface::Plane { point: Vec3::zeros(), normal: Vec3::z() }, Motion::Fixed)];
    let mut particles = Vec::new();
    for (k, [x, y, z]) in
        [[0.001, 0.015, 0.005], [0.02, 0.029, 0.006], [0.015, 0.014, 0.015], [0.001, 0.003, 0.02]]
            .iter()
            .enumerate()
    {
        particles.push(NewParticle {
            id: k as u64,
            kind: Kind { shape: k as u16 % kinds, material: 0 },
            scale: 1.0,
            position: Vec3::new(*x, *y, *z),
            orientation: Rotation::identity(),
            velocity: Vec3::new(0.5, -0.7, -0.6),
            angular_velocity: Vec3::new(5.0, 0.0, 9.0),
            temperature: 0.0,
        });
    }
    for (scale, spacing) in [(0.3, 3e-3), (0.05, 0.5e-3)] {
        let upper = if scale < 0.1 { [0.03, 0.03, 0.004] } else { [0.03, 0.03, 0.02] };
        for mut small in lattice([0.0; 3], upper, spacing, kinds, 2.0) {
            (small.id, small.scale) = (particles.len() as u64, small.scale * scale);
            let clear = |other: &NewParticle| {
                let mut between = other.position - small.position;
                for a in 0..2 {
                    between[a] -= 0.03 * (between[a] / 0.03).round();
                }
                between.norm() > LARGE * (small.scale + other.scale)
            };
            if particles.iter().all(clear) {
                particles.push(small);
            }
        }
    }
    Scene { setup, particles }
}

fn spheres() -> Scene {
    mixture(vec![Shape::sphere(LARGE).unwrap()])
}

/// Pairs of identities that touch, as a rank finds them.
fn pairs(dem: &Dem) -> Vec<[u64; 2]> {
    let mut pairs = Vec::new();
    dem.for_each_contact(|touch| {
        if let Partner::Particle(other) = touch.other {
            let mut pair = [touch.particle, other].map(|i| dem.particles.ids[i]);
            pair.sort_unstable();
            pairs.push(pair);
        }
    });
    pairs
}

#[test]
fn every_contact_of_a_mixture_is_found() {
    let scene = spheres();
    let mut serial = scene.start([1; 3], 0);
    for _ in 0..450 {
        serial.step(&SerialTransport).unwrap();
    }
    serial.refresh(&SerialTransport).unwrap();
    let (particles, global) = (&serial.particles, &serial.setup.global);
    let mut expected = Vec::new();
    let position = |i: usize| Vec3::from(global.wrap(particles.bodies[i].position.into()));
    for i in 0..particles.owned {
        for j in 0..i {
            let mut between = position(i) - position(j);
            for a in 0..2 {
                between[a] -= global.length(a) * (between[a] / global.length(a)).round();
            }
            if between.norm() < particles.bodies[i].radius + particles.bodies[j].radius {
                let (a, b) = (particles.ids[i], particles.ids[j]);
                expected.push([a.min(b), a.max(b)]);
            }
        }
    }
    expected.sort_unstable();
    let radii = |pair: &[u64; 2]| pair.map(|id| scene.particles[id as usize].scale);
    let unequal = expected.iter().map(radii).filter(|[a, b]| (a / b).max(b / a) > 15.0).count();
    assert!(
        expected.len() > 300 && unequal > 20,
        "{} contacts, {unequal} of very unequal sizes",
        expected.len()
    );
    for ranks in [[1, 1, 1], [2, 2, 2]] {
        let mut found = on_ranks(ranks.iter().product(), |transport| {
            let mut dem = scene.start(ranks, transport.rank());
            for _ in 0..450 {
                dem.step(&transport).unwrap();
            }
            dem.refresh(&transport).unwrap();
            pairs(&dem)
        })
        .concat();
        found.sort_unstable();
        found.dedup();
        assert!(found == expected, "{ranks:?}: {} contacts instead of {}", found.len(), expected.len());
    }
}

#[test]
fn mixtures_have_the_same_bits_on_any_ranks() {
    for scene in [spheres(), mixture(mixed_shapes(LARGE))] {
        let serial = scene.run([1; 3], 200);
        for ranks in [[2, 1, 1], [2, 2, 2], [1, 2, 1]] {
            assert!(scene.run(ranks, 200) == serial, "{ranks:?}");
        }
        assert!(scene.run_with_restart([2, 1, 2], 90, [1, 2, 1], 110) == serial, "restart");
    }
}

#[test]
fn films_moving_borders_and_hard_collisions_of_mixtures_change_no_bit_with_the_ranks() {
    let mut films = spheres();
    films.setup.lubrication = Some(Lubrication { viscosity: 0.1, range: 1e-4, min_gap: 1e-3 });
    let mut balanced = spheres();
    let min_width = [balanced.setup.interaction_range(); 3];
    balanced.setup.balance = Some(Balance { min_width, interval: 10, threshold: 1.02 });
    let mut hard = spheres();
    hard.setup.collisions = CollisionModel::Hard(HardModel::new(&hard.setup.parameters));
    for (scene, what) in [(films, "films"), (balanced, "moving borders"), (hard, "hard collisions")] {
        let serial = scene.run([1; 3], 120);
        assert!(scene.run([2, 1, 2], 120) == serial, "{what}");
    }
}
