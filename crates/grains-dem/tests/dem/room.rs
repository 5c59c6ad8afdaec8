//! Whether there is room for a new particle, beside the contacts that it would have.

use crate::common::{Random, knobbly_shapes, law, mixed_shapes, setup, wall};
use grains_dem::{Dem, Kind, Motion, NewParticle, Occupancy, Surface, is_wall_in_the_way};
use grains_domain::SerialTransport;
use grains_geometry::{Rotation, Shape, Vec3};

const RADIUS: f64 = 0.01;
const BOX: f64 = 0.07;

fn shapes() -> Vec<Shape> {
    // Bodies that are met by their vertices have no other surface to contacts.
    let all = mixed_shapes(RADIUS).into_iter().chain(knobbly_shapes(RADIUS));
    all.filter(|shape| shape.discrete.is_none()).collect()
}

fn particle(id: u64, count: usize, random: &mut Random) -> NewParticle {
    NewParticle {
        id,
        kind: Kind { shape: random.index(count) as u16, material: 0 },
        scale: random.range(0.5, 1.0),
        position: Vec3::from_fn(|_, _| random.range(0.0, BOX)),
        orientation: Rotation::new(random.vector() * 3.0),
        velocity: Vec3::zeros(),
        angular_velocity: Vec3::zeros(),
        temperature: 0.0,
    }
}

/// Whether anything touches among some particles, in a periodic box with a floor of any slope or without one.
fn touches(particles: &[NewParticle], floor: Option<(Vec3, Vec3)>) -> (bool, Dem) {
    let mut setup = setup([BOX; 3], [true, true, false], shapes(), law(true));
    let surface = |(point, normal)| Surface::Plane { point, normal };
    setup.walls = floor.map(|floor| wall("floor", surface(floor), Motion::Fixed)).into_iter().collect();
    let mut dem = Dem::new(setup, 0).unwrap();
    for particle in particles {
        let record = particle.record(&dem);
        dem.insert(&record);
    }
    dem.refresh(&SerialTransport).unwrap();
    let mut touching = false;
    dem.for_each_contact(|_| touching = true);
    (touching, dem)
}

#[test]
fn there_is_room_where_nothing_would_touch() {
    let (count, mut random) = (shapes().len(), Random(5));
    let mut found = [[0; 2]; 2];
    for _ in 0..400 {
        let [old, mut new] = [0, 1].map(|id| particle(id, count, &mut random));
        // Across the periodic faces too.
        let beside = old.position + random.direction() * random.range(0.6, 1.6) * RADIUS;
        new.position =
            Vec3::new(beside.x.rem_euclid(BOX), beside.y.rem_euclid(BOX), beside.z.clamp(0.0, 0.99 * BOX));
        let (_, dem) = touches(&[old], None);
        let occupancy = Occupancy::near(&dem, [&Vec3::zeros(), &Vec3::repeat(BOX)], RADIUS);
        let (is_met, _) = touches(&[old, new], None);
        assert_eq!(occupancy.is_in_the_way(&new, &dem), is_met, "{old:?} {new:?}");
        found[0][usize::from(is_met)] += 1;

        let floor = (Vec3::repeat(0.5 * BOX), Vec3::new(0.0, 0.3 * random.unit(), 1.0).normalize());
        let (is_met, dem) = touches(&[new], Some(floor));
        assert_eq!(is_wall_in_the_way(&new, &dem), is_met, "{new:?} {floor:?}");
        found[1][usize::from(is_met)] += 1;
    }
    assert!(found.iter().flatten().all(|&count| count > 80), "{found:?}");
}
