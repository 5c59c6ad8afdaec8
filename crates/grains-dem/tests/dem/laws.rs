//! What every contact law keeps: the same bits on any ranks, skin and restart, momentum, energy, symmetry, restitution.

use crate::common::{Scene, knobbly_shapes, lattice, mixed_shapes, setup, wall};
use grains_contact::{
    Attraction, BridgeViscosity, Capillary, CohesionArea, ContactLaw, Damping, Dmt, ElasticPlastic,
    Formation, Hertz, Jkr, Linear, LiquidBridge, Memory, Normal, Rolling, Rupture, Sjkr, Supply, Tangential,
    Tear, Twisting, VanDerWaals, Willett,
};
use grains_dem::{ContactTable, Dem, Kind, Motion, NewParticle, Skin, Surface, Wall};
use grains_domain::SerialTransport;
use grains_geometry::{Rotation, SMOOTH_ANGLE, Shape, TriMesh, Vec3, WallMesh};
use std::f64::consts::PI;
use std::sync::Arc;

const MODULUS: f64 = 1e7;
const WORK: f64 = 0.5;
const HERTZ: Hertz = Hertz { modulus: MODULUS };

fn mindlin(memory: Memory) -> Tangential {
    let stiffness_ratio = 0.8;
    Tangential::Mindlin { stiffness_ratio, damping_ratio: Tangential::equal_damping(stiffness_ratio), memory }
}

fn spring() -> Tangential {
    Tangential::Spring { stiffness_ratio: 2.0 / 7.0, damping_ratio: 0.5 }
}

/// Bridges of a tenth of a cubic millimetre, of a liquid of this viscosity (Pa s), that form between films (m).
pub fn bridge(viscosity: f64, film: f64) -> Attraction {
    let bridge = LiquidBridge {
        surface_tension: 0.07,
        contact_angle: 0.2,
        capillary: Capillary::Willett(Willett::new(0.2)),
        rupture: Rupture::Lian,
        viscosity: BridgeViscosity { viscosity, min_gap: 0.01 },
        formation: if film > 0.0 { Formation::Films } else { Formation::Contact },
        supply: Supply::PerBridge(1e-11),
    };
    Attraction::LiquidBridge { bridge, film }
}

/// Laws of the normal direction, the adhesive ones without adhesion's energy where it is not asked for.
fn normals(restitution: f64, work: f64) -> Vec<Normal> {
    vec![
        Linear { stiffness: 1e4 }.into(),
        HERTZ.into(),
        Dmt { hertz: HERTZ, work }.into(),
        Jkr { modulus: MODULUS, work, tear: Tear::Displacement }.into(),
        Jkr { modulus: MODULUS, work, tear: Tear::Load }.into(),
        Sjkr { hertz: HERTZ, energy_density: 1e5 * work, area: CohesionArea::Lens }.into(),
        ElasticPlastic::with_restitution(1e4, restitution, 1e4 * work).into(),
    ]
}

/// Every law of the normal direction with one or another of all rules of friction, rolling and twisting.
fn laws() -> Vec<ContactLaw> {
    let friction = 0.02;
    let (stiffness, dashpot) = (300.0, 0.01);
    let rules = [
        (spring(), Rolling::spring(friction), Twisting::Marshall),
        (mindlin(Memory::ForceRescaled), Rolling::spring(friction), Twisting::Marshall),
        (mindlin(Memory::Displacement), Rolling::Tangential { friction }, Twisting::None),
        (mindlin(Memory::Force), Rolling::Given { friction, stiffness, dashpot }, Twisting::Marshall),
        (mindlin(Memory::DisplacementRescaled), Rolling::Constant { friction }, Twisting::None),
        (Tangential::Viscous { rate: 2e3 }, Rolling::Viscous { friction }, Twisting::None),
        (spring(), Rolling::None, Twisting::None),
    ];
    let of = |(normal, (tangential, rolling, twisting))| {
        ContactLaw::new(normal, 0.8, 0.4, tangential).with_rolling(rolling).with_twisting(twisting)
    };
    let mut laws: Vec<_> = normals(0.8, WORK).into_iter().zip(rules).map(of).collect();
    laws.push(laws[1].with_damping(Damping::Viscoelastic { time: 1e-6 }));
    laws.extend([laws[0], laws[5]].map(|law| law.with_attraction(bridge(0.01, 2e-5))));
    laws.push(laws[1].with_attraction(bridge(0.0, 0.0)));
    let wide = VanDerWaals { hamaker: 1e-11, asperity: 0.0, inner: 1e-6, outer: 3e-5 };
    laws.push(laws[2].with_attraction(Attraction::VanDerWaals(wide)));
    laws
}

/// Spheres, convex bodies and composites under shear above a plane and a mesh of tiles, in a box periodic along both.
fn crowd(law: ContactLaw) -> Scene {
    let mut shapes = mixed_shapes(1.4e-3);
    shapes.extend(knobbly_shapes(1.4e-3).into_iter().take(3));
    crowd_of(shapes, law)
}

/// The same of any shapes.
fn crowd_of(shapes: Vec<Shape>, law: ContactLaw) -> Scene {
    let kinds = shapes.len() as u16;
    let mut setup = setup([0.018, 0.018, 0.024], [true, true, false], shapes, law);
    setup.parameters.gravity = Vec3::new(6.0, 4.0, -60.0);
    setup.overlap_limit = 0.9;
    let tile =
        |k: usize| Vec3::new(-0.006 + 0.0061 * (k % 6) as f64, -0.006 + 0.0061 * (k / 6) as f64, 0.0015);
    let faces: Vec<Vec<usize>> =
        (0..25).map(|k| k / 5 * 6 + k % 5).map(|k| vec![k, k + 1, k + 7, k + 6]).collect();
    let tiles = TriMesh::from_polygons((0..36).map(tile).collect(), &faces).unwrap();
    let tiles = Arc::new(WallMesh::new(&tiles, SMOOTH_ANGLE).unwrap());
    let lid = Surface::Plane { point: Vec3::new(0.0, 0.0, 0.0121), normal: -Vec3::z() };
    // A second material of particles and the lid meet under a law without reach.
    let plain = ContactLaw::new(HERTZ, 0.7, 0.3, mindlin(Memory::Force));
    let mut contacts = ContactTable::new(4);
    for (a, b) in [(0, 0), (0, 1), (2, 3)] {
        contacts.set(a, b, law);
    }
    for (a, b) in [(0, 2), (2, 2), (2, 1), (0, 3)] {
        contacts.set(a, b, plain);
    }
    setup.catalogue.contacts = contacts;
    setup.catalogue.densities = vec![2500.0, f64::NAN, 3000.0, f64::NAN];
    let mut tiles = wall("tiles", Surface::Mesh(tiles), Motion::Fixed);
    tiles.spans = [true, true, false];
    setup.walls = vec![tiles, Wall { material: 3, ..wall("lid", lid, Motion::Fixed) }];
    let mut particles = lattice([0.0, 0.0, 0.0014], [0.018, 0.018, 0.0118], 2.57e-3, kinds, 1.5);
    for p in &mut particles {
        p.velocity.x += 40.0 * (p.position.z - 0.006);
        p.kind.material = if p.id % 3 == 0 { 2 } else { 0 };
    }
    Scene { setup, particles }
}

#[test]
fn every_law_has_the_same_bits_on_any_ranks_skin_and_restart() {
    for law in laws() {
        has_the_same_bits(crowd(law), law);
    }
}

/// Spheres alone, of two materials under two laws: their pairs change places in the list as they touch and part.
#[test]
fn spheres_under_two_laws_have_the_same_bits_on_any_ranks_skin_and_restart() {
    for law in laws() {
        let shapes = [1.3e-3, 1.1e-3].map(|radius| Shape::sphere(radius).unwrap());
        has_the_same_bits(crowd_of(shapes.into(), law), law);
    }
}

fn has_the_same_bits(mut scene: Scene, law: ContactLaw) {
    const STEPS: u64 = 240;
    assert!(scene.contacts_after(STEPS) > 40, "{}: too few contacts", law.normal.name());
    let alone = scene.run([1; 3], STEPS);
    for ranks in [[2, 1, 1], [1, 3, 1], [2, 2, 2]] {
        assert_eq!(alone, scene.run(ranks, STEPS), "{} on {ranks:?}", law.normal.name());
    }
    let restarted = scene.run_with_restart([2, 1, 1], STEPS / 2 + 1, [1, 1, 2], STEPS / 2 - 1);
    assert_eq!(alone, restarted, "{} after a restart", law.normal.name());
    scene.setup.skin = Skin { min: 0.02, max: 0.02, ..scene.setup.skin };
    assert_eq!(alone, scene.run([1; 3], STEPS), "{} with another skin", law.normal.name());
}

/// Two spheres, or a sphere and a box, that meet off their centres with spins; `swapped` gives them each other's identity.
fn meeting(law: ContactLaw, case: u64, swapped: bool, steps: f64) -> Dem {
    let number = |k: u64| ((case * 17 + k) as f64 * 0.618_033_988_75).fract();
    let vector = |k: u64| Vec3::new(number(k), number(k + 1), number(k + 2)) - Vec3::repeat(0.5);
    let box_ = Shape::cuboid(Vec3::new(2.2, 1.9, 1.6) * 1e-3, 0.05).unwrap();
    let shapes = vec![Shape::sphere(1e-3).unwrap(), box_];
    let mut setup = setup([0.04; 3], [false; 3], shapes, law);
    setup.largest_radius = 2e-3;
    setup.overlap_limit = 0.9;
    setup.parameters.gravity = Vec3::zeros();
    let mass = 2500.0 * 4.0 / 3.0 * PI * 1e-9;
    setup.parameters.dt = law.collision(0.3 * mass, 4e-4, 0.5).contact_time / steps;
    let mut dem = Dem::new(setup, 0).unwrap();
    let towards = (vector(0) + Vec3::new(0.0, 0.0, 0.2)).normalize();
    let side = towards.cross(&vector(3));
    let scales = [0.7 + 0.5 * number(8), 0.8 + 0.4 * number(9)];
    let middle = Vec3::repeat(0.02);
    let of = |k: usize, shape: u16| NewParticle {
        id: if swapped { 1 - k as u64 } else { k as u64 },
        kind: Kind { shape, material: 0 },
        scale: scales[k],
        position: middle + (towards * 2.7e-3 + side * 1e-3) * k as f64,
        orientation: Rotation::new(vector(20) * 3.0),
        velocity: vector(11) * 0.3 - towards * if k == 1 { 0.6 } else { 0.0 },
        angular_velocity: vector(14 + 3 * k as u64) * 300.0,
        temperature: 0.0,
    };
    let new = [of(0, 0), of(1, (case % 2) as u16)];
    let order = if swapped { [1, 0] } else { [0, 1] };
    for k in order {
        let record = new[k].record(&dem);
        dem.insert(&record);
    }
    dem
}

/// Momentum, angular momentum about the middle of the box, and kinetic energy.
fn totals(dem: &Dem) -> (Vec3, Vec3, f64) {
    let mut sums = (Vec3::zeros(), Vec3::zeros(), 0.0);
    for (i, body) in dem.particles.bodies.iter().enumerate() {
        let turn = dem.particles.record(i).orientation;
        let spin = turn.inverse() * body.angular_velocity;
        let moment = spin.component_mul(&dem.setup.catalogue.inertia(body));
        let momentum = body.velocity * body.mass;
        sums.0 += momentum;
        sums.1 += (body.position - Vec3::repeat(0.02)).cross(&momentum) + turn * moment;
        sums.2 += 0.5 * (body.velocity.dot(&momentum) + spin.dot(&moment));
    }
    sums
}

#[test]
fn every_law_keeps_momentum_and_makes_no_energy() {
    for law in laws() {
        let name = law.normal.name();
        let mut hits = 0;
        for case in 0..12 {
            let mut dem = meeting(law, case, false, 200.0);
            let before = totals(&dem);
            let (mut since_touch, mut max_energy, mut step) = (0, 0.0_f64, 0);
            while step < 40_000 && since_touch < 600 {
                dem.step(&SerialTransport).unwrap();
                let touches = dem.report.max_overlap > 0.0;
                since_touch = if touches { 1 } else { since_touch + usize::from(since_touch > 0) };
                max_energy = max_energy.max(totals(&dem).2);
                step += 1;
            }
            hits += usize::from(since_touch > 0);
            let after = totals(&dem);
            let (p, l) = ((after.0 - before.0).norm(), (after.1 - before.1).norm());
            assert!(p < 1e-12 * before.0.norm(), "{name} {case}: momentum off by {p}");
            assert!(l < 2e-5 * before.1.norm(), "{name} {case}: angular momentum off by {l}");
            // What pulls the bodies together makes kinetic energy of its own, which they need to part.
            let pull = law.normal.pull_off(1e-3) * law.normal.reach(1e-3).max(1e-5)
                + law.attraction.force_bound(1e-3) * law.attraction.reach(1e-3);
            assert!(after.2 < before.2 * (1.0 + 1e-3), "{name} {case}: {} of the energy", after.2 / before.2);
            assert!(
                max_energy < before.2 * (1.0 + 1e-3) + 10.0 * pull,
                "{name} {case}: {}",
                max_energy / before.2
            );
        }
        assert!(hits > 8, "{name}: {hits} hits");
    }
}

#[test]
fn every_law_is_antisymmetric_bit_for_bit() {
    for law in laws() {
        let mut hits = 0;
        // Of spheres; a distance query asks from the body of lower id.
        for case in (0..12).step_by(2) {
            let [mut one, mut other] = [false, true].map(|swapped| meeting(law, case, swapped, 60.0));
            let (mut touching, mut step) = (0, 0_u32);
            while f64::from(step) * one.setup.parameters.dt < 8e-3 && touching < 60 {
                step += 1;
                one.step(&SerialTransport).unwrap();
                other.step(&SerialTransport).unwrap();
                for k in 0..2 {
                    let find = |dem: &Dem, id: u64| {
                        let i = dem.particles.ids.iter().position(|&other| other == id).unwrap();
                        dem.particles.bodies[i]
                    };
                    let (a, b) = (find(&one, k), find(&other, 1 - k));
                    let state =
                        |body: &grains_dem::Body| (body.position, body.velocity, body.angular_velocity);
                    assert_eq!(state(&a), state(&b), "{} {case} at step {step}", law.normal.name());
                }
                touching += usize::from(one.report.max_overlap > 0.0);
            }
            hits += usize::from(touching > 0);
        }
        assert!(hits > 3, "{}: {hits} hits", law.normal.name());
    }
}

/// Speed after over before of a sphere that hits a plane or another head on.
fn rebound(law: ContactLaw, shape: Shape, speed: f64, on_plane: bool, steps: f64) -> f64 {
    let mass = 2500.0 * shape.volume;
    let radius = shape.part_radius();
    let mut setup = setup([0.04; 3], [false; 3], vec![shape], law);
    setup.overlap_limit = 0.95;
    setup.parameters.gravity = Vec3::zeros();
    let (reduced, effective) = if on_plane { (mass, radius) } else { (0.5 * mass, 0.5 * radius) };
    let collision = law.collision(reduced, effective, speed);
    setup.parameters.dt = collision.shortest_time / steps;
    if on_plane {
        let floor = Surface::Plane { point: Vec3::repeat(0.01), normal: Vec3::z() };
        setup.walls = vec![wall("floor", floor, Motion::Fixed)];
        setup.catalogue.contacts.set(0, 1, law);
    }
    let mut dem = Dem::new(setup, 0).unwrap();
    let gap = 3.37e-2 * collision.contact_time * speed + law.attraction.reach(effective);
    let add = |dem: &mut Dem, id: u64, z: f64, velocity: f64| {
        let record = NewParticle {
            id,
            kind: Kind { shape: 0, material: 0 },
            scale: 1.0,
            position: Vec3::new(0.02, 0.02, 0.01 + z),
            orientation: Rotation::new(Vec3::new(0.3, 0.2, 0.1)),
            velocity: Vec3::z() * velocity,
            angular_velocity: Vec3::zeros(),
            temperature: 0.0,
        }
        .record(dem);
        dem.insert(&record);
    };
    let width = if on_plane { radius } else { 2.0 * radius };
    add(&mut dem, 0, width + gap, if on_plane { -speed } else { -0.5 * speed });
    if !on_plane {
        add(&mut dem, 1, 0.0, 0.5 * speed);
    }
    let contact = steps * collision.contact_time / collision.shortest_time;
    let way = (law.reach(effective) + gap) / speed / (collision.shortest_time / steps);
    for _ in 0..(3.0 * (contact + way)) as usize {
        dem.step(&SerialTransport).unwrap();
    }
    let after = dem.particles.bodies.iter().map(|body| body.velocity.z.abs()).fold(0.0, f64::max);
    after / if on_plane { speed } else { 0.5 * speed }
}

#[test]
fn bodies_part_with_the_restitution_asked_for_under_every_law() {
    let none = Tangential::Viscous { rate: 0.0 };
    for e in [0.1, 0.3, 0.5, 0.7, 0.9, 1.0] {
        for normal in normals(e, 1e-12) {
            for on_plane in [false, true] {
                let law = ContactLaw::new(normal, e, 0.0, none);
                let found = rebound(law, Shape::sphere(1.5e-3).unwrap(), 0.6, on_plane, 200.0);
                assert!((found / e - 1.0).abs() < 5e-3, "{} {on_plane}: {found} for {e}", normal.name());
            }
        }
    }
}

/// Bodies under JKR part with what the tear leaves them, whether they meet in a point of spheres or in one of polyhedra.
#[test]
fn jkr_takes_the_energy_of_its_tear() {
    let none = Tangential::Viscous { rate: 0.0 };
    let radius: f64 = 1.5e-3;
    for (tear, on_plane) in [(Tear::Displacement, true), (Tear::Load, true), (Tear::Displacement, false)] {
        let law = ContactLaw::new(Jkr { modulus: MODULUS, work: 0.1, tear }, 1.0, 0.0, none);
        let mass = 2500.0 * 4.0 / 3.0 * PI * radius.powi(3);
        let (reduced, effective) = if on_plane { (mass, radius) } else { (0.5 * mass, 0.5 * radius) };
        for speed in [0.02, 0.05, 0.2] {
            let wanted = law.collision(reduced, effective, speed).restitution;
            let found = rebound(law, Shape::sphere(radius).unwrap(), speed, on_plane, 400.0);
            assert!((found - wanted).abs() < 5e-3, "{tear:?} {on_plane} {speed}: {found} for {wanted}");
            assert!(wanted < 0.995 || speed > 0.03, "{tear:?} {on_plane} {speed}: {wanted}");
        }
    }
}

/// A bridge takes the work of its pull from contact to rupture, or from where films met.
#[test]
fn a_liquid_bridge_takes_its_work() {
    let none = Tangential::Viscous { rate: 0.0 };
    for (film, on_plane) in [(0.0, true), (0.0, false), (2e-5, true)] {
        let radius: f64 = 1.5e-3;
        let attraction = bridge(0.0, film);
        let Attraction::LiquidBridge { bridge: liquid, .. } = attraction else { panic!("a bridge") };
        let law = ContactLaw::linear(1e4, 1.0, 0.0, none).with_attraction(attraction);
        let mass = 2500.0 * 4.0 / 3.0 * PI * radius.powi(3);
        let (reduced, effective) = if on_plane { (mass, radius) } else { (0.5 * mass, 0.5 * radius) };
        let work = liquid.work(2.0 * film, 1e-11, effective);
        for share in [0.2, 0.5] {
            let speed = (2.0 * work / share / reduced).sqrt();
            let found = rebound(law, Shape::sphere(radius).unwrap(), speed, on_plane, 200.0);
            let wanted = (1.0 - share).sqrt();
            assert!((found / wanted - 1.0).abs() < 2e-3, "{film} {on_plane} {share}: {found} for {wanted}");
        }
    }
}

/// A sphere of ever finer facets bounces as the sphere does: depth by Hertz' law of the ball of its volume.
#[test]
fn a_tessellated_sphere_becomes_a_sphere_under_hertz() {
    let law = ContactLaw::new(
        Jkr { modulus: MODULUS, work: 0.1, tear: Tear::Displacement },
        0.8,
        0.0,
        Tangential::Viscous { rate: 0.0 },
    );
    let ball = rebound(law, Shape::sphere(1.5e-3).unwrap(), 0.1, true, 300.0);
    let mut last = f64::INFINITY;
    for points in [60, 240, 960] {
        let golden = PI * (3.0 - 5.0_f64.sqrt());
        let vertices: Vec<Vec3> = (0..points)
            .map(|k| {
                let z = 1.0 - (2 * k + 1) as f64 / points as f64;
                let (sin, cos) = (golden * k as f64).sin_cos();
                Vec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z) * 1.5e-3
            })
            .collect();
        let shape = Shape::hull(&vertices, 0.05).unwrap();
        let off = (rebound(law, shape, 0.1, true, 300.0) - ball).abs();
        println!("{points}: {off} after {last}");
        last = off;
    }
    assert!(last < 0.01, "{last}");
}
