//! Films of liquid that feed bridges: the same bits, conservation, closed forms.

use crate::common::{
    Scene, Stopped, knobbly_shapes, lattice, law, merged, mixed_shapes, setup, state_of, wall,
};
use grains_contact::{
    Attraction, BridgeViscosity, Capillary, ContactLaw, FilmAmount, FilmShare, FilmSupply, Formation,
    LiquidBridge, Rupture, Supply, Tangential, Willett,
};
use grains_dem::{Dem, ExchangeStrategy, Kind, Liquid, MaterialFilms, Motion, NewParticle, Skin, Surface};
use grains_domain::{SerialTransport, Transport};
use grains_geometry::{Rotation, Shape, Vec3};
use grains_testing::on_ranks;
use std::f64::consts::PI;

/// Bridges of water that films feed, which leave a third on walls.
fn bridges(share: FilmShare, formation: Formation, largest: f64) -> Attraction {
    let bridge = LiquidBridge {
        surface_tension: 0.07,
        contact_angle: 0.2,
        capillary: Capillary::Willett(Willett::new(0.2)),
        rupture: Rupture::Lian,
        viscosity: BridgeViscosity { viscosity: 0.01, min_gap: 0.01 },
        formation,
        supply: Supply::Films(FilmSupply { share, largest, wall_share: 1.0 / 3.0 }),
    };
    Attraction::LiquidBridge { bridge, film: 0.0 }
}

/// Wet particles of many sizes and shapes between moving walls, which fall out at one side.
fn crowd(share: FilmShare, formation: Formation, shapes: Vec<Shape>) -> Scene {
    let kinds = shapes.len() as u16;
    let attraction = bridges(share, formation, 2e-11);
    let law = law(true).with_attraction(attraction);
    let mut setup = setup([0.018, 0.018, 0.024], [true, false, false], shapes, law);
    setup.parameters.gravity = Vec3::new(3.0, -15.0, -60.0);
    setup.overlap_limit = 0.9;
    (setup.outlets[2], setup.outlets[5]) = (true, true);
    setup.catalogue.contacts.set(0, 1, law);
    let films = vec![Some(FilmAmount::Content(0.01)), Some(FilmAmount::Thickness(1e-6))];
    setup.catalogue.contacts.wet(MaterialFilms::new(films, 2e-10));
    let floor = Surface::Plane { point: Vec3::new(0.0, 0.0, 0.002), normal: Vec3::z() };
    let shaking = Motion::Oscillation {
        amplitude: Vec3::z() * 4e-4,
        frequency: 300.0,
        phase: 0.0,
        start: 0.0,
        end: f64::INFINITY,
    };
    let side = Surface::Plane { point: Vec3::new(0.0, 0.0175, 0.0), normal: -Vec3::y() };
    setup.walls = vec![wall("floor", floor, shaking), wall("side", side, Motion::Fixed)];
    let mut particles = lattice([0.0, 0.0, 0.0022], [0.018, 0.0172, 0.0122], 2.5e-3, kinds, 4.0);
    particles.iter_mut().for_each(|p| p.velocity.x += 300.0 * (p.position.z - 0.006));
    Scene { setup, particles }
}

/// One more particle, let fall at a step, of an identity that none has.
fn late(dem: &mut Dem, step: u64) {
    let new = NewParticle {
        id: 10_000 + step,
        kind: Kind { shape: 0, material: 0 },
        scale: 0.8,
        position: Vec3::new(0.004 + 1e-5 * step as f64, 0.009, 0.020),
        orientation: Rotation::identity(),
        velocity: Vec3::new(0.0, 0.0, -6.0),
        angular_velocity: Vec3::zeros(),
        temperature: 0.0,
    };
    if dem.owns(&new.position) {
        let record = new.record(dem);
        dem.insert(&record);
    }
    dem.announce_insertion();
}

/// Steps up to `until`, with new particles now and then; all liquid is accounted for in every step.
fn run(dem: &mut Dem, transport: &impl Transport, until: u64) -> Liquid {
    while dem.step < until {
        if dem.step % 120 == 60 {
            late(dem, dem.step);
        }
        dem.step(transport).unwrap();
        assert!(dem.particles.films.iter().all(|film| film.volume() >= 0.0));
        dem.check_liquid(transport).unwrap();
    }
    dem.check_liquid(transport).unwrap()
}

/// State and liquid after some steps on a grid of ranks, from the beginning or from where another run stopped.
fn after(
    scene: &Scene,
    ranks: [usize; 3],
    from: Option<&Stopped>,
    until: u64,
) -> (crate::common::State, Liquid) {
    let parts = on_ranks(ranks.iter().product(), |transport| {
        let mut dem = match from {
            None => scene.start(ranks, transport.rank()),
            Some(from) => scene.resume(ranks, transport.rank(), from, |_| ()),
        };
        let liquid = run(&mut dem, &transport, until);
        (state_of(&dem), liquid)
    });
    let liquid = parts[0].1;
    (merged(parts.into_iter().map(|(state, _)| state).collect()), liquid)
}

fn shapes() -> [Vec<Shape>; 2] {
    let mut bodies = mixed_shapes(1.4e-3);
    bodies.extend(knobbly_shapes(1.4e-3).into_iter().take(3));
    let spheres = [1.3e-3, 1.0e-3, 0.5e-3].map(|radius| Shape::sphere(radius).unwrap());
    [spheres.to_vec(), bodies]
}

/// Bridges form and break by the hundred; films, bridges, ledger and all else are the same bits on any number of ranks, with any
/// skin, exchange and restart, and all liquid is accounted for in every step.
#[test]
fn films_and_bridges_have_the_same_bits_on_any_ranks_skin_and_restart() {
    const STEPS: u64 = 300;
    let [spheres, bodies] = shapes();
    let rules = [
        (FilmShare::Constant(0.7), Formation::Films, spheres.clone()),
        (FilmShare::Cap, Formation::Contact, spheres),
        (FilmShare::Constant(1.0), Formation::Films, bodies),
    ];
    for (share, formation, shapes) in rules {
        let mut scene = crowd(share, formation, shapes);
        let alone = after(&scene, [1; 3], None, STEPS);
        let Liquid { count, broken, left, walls, .. } = alone.1;
        println!("{share:?}: {count} bridges, {broken} broken, {left:e} m3 left, {walls:e} m3 onto walls");
        assert!(count > 40 && broken > 100, "{share:?}: {count} bridges, {broken} broken");
        assert!(left > 0.0 && walls != 0.0);
        for ranks in [[2, 1, 1], [1, 3, 1], [2, 2, 1], [2, 2, 2]] {
            assert!(alone == after(&scene, ranks, None, STEPS), "{share:?} on {ranks:?}");
        }
        for (stop, ranks) in [(61, [1, 1, 2]), (150, [2, 1, 1])] {
            let first = on_ranks(2, |transport| {
                let mut dem = scene.start([2, 1, 1], transport.rank());
                run(&mut dem, &transport, stop);
                dem.refresh(&transport).unwrap();
                Stopped::of(&dem)
            });
            let stopped = Stopped::joined(first);
            assert!(alone == after(&scene, ranks, Some(&stopped), STEPS), "{share:?} stopped at {stop}");
        }
        scene.setup.exchange = ExchangeStrategy::AllGatherLocal;
        scene.setup.skin = Skin { min: 0.02, max: 0.02, ..scene.setup.skin };
        assert!(alone == after(&scene, [2, 1, 1], None, STEPS), "{share:?} with another skin");
    }
}

/// A run goes on with the same bits from any step, also from those in which bridges form and break.
#[test]
fn films_go_on_from_any_step() {
    let scene = crowd(FilmShare::Constant(0.5), Formation::Contact, shapes()[0].clone());
    let (from, to) = (120, 180);
    let alone = after(&scene, [1; 3], None, to);
    let mut dem = scene.start([1; 3], 0);
    run(&mut dem, &SerialTransport, from);
    for stop in from..to {
        run(&mut dem, &SerialTransport, stop);
        let mut copy = scene.start([1; 3], 0);
        run(&mut copy, &SerialTransport, stop);
        copy.refresh(&SerialTransport).unwrap();
        if stop % 6 == 0 {
            assert!(alone == after(&scene, [1; 3], Some(&Stopped::of(&copy)), to), "stopped at {stop}");
        }
    }
}

/// Two spheres, or a sphere and a wall, that are pushed together and pulled apart twice, slowly.
fn twice(share: FilmShare, radii: [f64; 2], swapped: bool, at_wall: bool) -> (Vec<[f64; 2]>, Liquid, f64) {
    let none = Tangential::Viscous { rate: 0.0 };
    let law = ContactLaw::linear(1e4, 0.5, 0.0, none);
    let law = law.with_attraction(bridges(share, Formation::Contact, 1e-9));
    let mut setup = setup([0.04; 3], [false; 3], vec![Shape::sphere(1e-3).unwrap()], law);
    setup.catalogue.contacts.set(0, 1, law);
    setup.largest_radius = 3e-3;
    setup.parameters.gravity = Vec3::zeros();
    setup.parameters.dt = 2e-6;
    let films = vec![Some(FilmAmount::Content(0.01)), Some(FilmAmount::Thickness(2e-6))];
    let largest = 0.01 * 4.0 / 3.0 * PI * 8e-9;
    setup.catalogue.contacts.wet(MaterialFilms::new(films, largest));
    let quantum = setup.catalogue.contacts.films().unwrap().quantum;
    if at_wall {
        let floor = Surface::Plane { point: Vec3::repeat(0.02), normal: Vec3::z() };
        setup.walls = vec![wall("floor", floor, Motion::Fixed)];
    }
    let mut dem = Dem::new(setup, 0).unwrap();
    let count = if at_wall { 1 } else { 2 };
    for k in 0..count {
        let height = if at_wall { radii[0] } else { [0.0, radii[0] + radii[1]][k] };
        let new = NewParticle {
            id: if swapped { 1 - k as u64 } else { k as u64 },
            kind: Kind { shape: 0, material: 0 },
            scale: radii[k] / 1e-3,
            position: Vec3::new(0.02, 0.02, 0.02 + height + if k + 1 == count { 1e-5 } else { 0.0 }),
            orientation: Rotation::identity(),
            velocity: Vec3::zeros(),
            angular_velocity: Vec3::zeros(),
            temperature: 0.0,
        };
        let record = new.record(&dem);
        dem.insert(&record);
    }
    // Driven by hand: only where they are matters.
    let drive = |dem: &mut Dem, speed: f64| {
        let moves = if at_wall || swapped { 0 } else { 1 };
        let velocity = |id: u64| Vec3::z() * if id == moves { speed } else { 0.0 };
        let before: Vec<(u64, Vec3)> =
            dem.particles.ids.iter().copied().zip(dem.particles.bodies.iter().map(|b| b.position)).collect();
        dem.step(&SerialTransport).unwrap();
        for i in 0..dem.particles.owned {
            let id = dem.particles.ids[i];
            let at = before.iter().find(|(other, _)| *other == id).unwrap().1;
            let body = &mut dem.particles.bodies[i];
            (body.position, body.velocity) = (at + velocity(id) * 2e-6, velocity(id));
            dem.particles.half_velocity[i] = velocity(id);
        }
    };
    let mut volumes = Vec::new();
    for round in 0..2 {
        for (speed, steps) in [(-0.2, 80), (0.2, 60), (2.0, 400)] {
            for _ in 0..steps {
                drive(&mut dem, speed);
                let liquid = dem.check_liquid(&SerialTransport).unwrap();
                assert!(liquid.count <= 1);
            }
            let mut each: Vec<(u64, [f64; 2])> =
                dem.particles.ids.iter().copied().zip(dem.liquid_of_each()).collect();
            each.sort_by_key(|(id, _)| *id);
            if swapped {
                each.reverse();
            }
            let film = |k: usize| each.get(k).map_or(0.0, |(_, [film, _])| *film);
            volumes.push([film(0), film(1)]);
        }
        // Back to where they began.
        for _ in 0..if round == 0 { 402 } else { 0 } {
            drive(&mut dem, -2.0);
        }
    }
    let liquid = dem.check_liquid(&SerialTransport).unwrap();
    (volumes, liquid, quantum)
}

/// Each time a pair is pulled apart, half of both shares goes over: closed forms to a few quanta, whichever body has the lower
/// identity.
#[test]
fn a_pair_pulled_apart_twice_has_the_volumes_of_its_closed_form() {
    let cases = [
        (FilmShare::Constant(0.3), [1e-3, 2e-3]),
        (FilmShare::Cap, [1e-3, 2e-3]),
        (FilmShare::Constant(1.0), [1e-3, 1e-3]),
    ];
    for (share, radii) in cases {
        let shares = [share.of(radii[0], radii[1]), share.of(radii[1], radii[0])];
        let mut wanted = radii.map(|r| 0.01 * 4.0 / 3.0 * PI * r.powi(3));
        let runs = [false, true].map(|swapped| twice(share, radii, swapped, false));
        for round in 0..2 {
            let given = [0, 1].map(|k| shares[k] * wanted[k]);
            let bridge = given[0] + given[1];
            let left = [wanted[0] - given[0], wanted[1] - given[1]];
            let after = left.map(|volume| volume + 0.5 * bridge);
            for (volumes, liquid, quantum) in &runs {
                for k in 0..2 {
                    let [held, _, freed] = [0, 1, 2].map(|at| volumes[3 * round + at][k]);
                    assert!((held - left[k]).abs() < 4.0 * quantum, "{share:?} {round}: {held} {left:?}");
                    assert!((freed - after[k]).abs() < 8.0 * quantum, "{share:?} {round}: {freed} {after:?}");
                }
                assert_eq!((liquid.count, liquid.broken, liquid.bridges), (0, 2, 0.0));
            }
            wanted = after;
        }
    }
    // A wall gives what lies on a disc as wide as the body, and keeps a third of the bridge.
    let (radius, share) = (1e-3, FilmShare::Cap);
    let (volumes, liquid, quantum) = twice(share, [radius, 0.0], false, true);
    let (mut film, mut walls) = (0.01 * 4.0 / 3.0 * PI * radius.powi(3), 0.0);
    for round in 0..2 {
        let (given, disc) = (0.5 * film, PI * radius * radius * 2e-6);
        assert!((volumes[3 * round][0] - (film - given)).abs() < 4.0 * quantum);
        film += 2.0 / 3.0 * (given + disc) - given;
        walls += (given + disc) / 3.0 - disc;
        assert!((volumes[3 * round + 2][0] - film).abs() < 8.0 * quantum);
    }
    assert!((liquid.walls - walls).abs() < 16.0 * quantum, "{} {walls}", liquid.walls);
}
