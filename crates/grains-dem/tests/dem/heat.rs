//! Temperatures of particles: closed forms, the same bits, and heat that is accounted for.

use crate::common::{
    Random, Scene, State, Stopped, knobbly_shapes, lattice, law, merged, mixed_shapes, setup, state_of, wall,
};
use grains_contact::{Conduction, ContactLaw, GasLens, Hertz, Tangential};
use grains_dem::{
    Dem, DemSetup, ExchangeStrategy, Heat, HeatLedger, Kind, Motion, NewParticle, PrescribedMotion, Skin,
    Surface, Thermal, WallHeat,
};
use grains_domain::{ExactSum, SerialTransport, Transport, sum_exact};
use grains_geometry::{Rotation, Shape, Vec3};
use grains_testing::on_ranks;

/// Makes particles of a system conduct, radiate and produce heat.
fn warm(setup: &mut DemSetup, lens: Option<GasLens>, surroundings: Option<f64>) {
    let mut thermal = Thermal::new(2, lens, surroundings);
    thermal.every = if surroundings.is_some() { 3 } else { 1 };
    thermal.heat_capacities = vec![2.0, 0.0];
    thermal.emissivities = vec![0.8, 0.0];
    thermal.sources = vec![if surroundings.is_some() { 3.0 } else { 0.0 }, 0.0];
    thermal.areas = setup.catalogue.shapes.iter().map(Shape::area).collect();
    thermal.set_conduction([0, 0], Conduction::between(20.0, 20.0, None));
    thermal.set_conduction([0, 1], Conduction::between(20.0, 5.0, Some(1e9)));
    setup.thermal = Some(thermal);
}

/// Heat (W) of the side wall of the crowd.
const HEATING: f64 = 0.02;

/// Hot and cold particles of many sizes and shapes, some of prescribed motion, between a warm and a heated wall; they fall out at
/// one side.
fn crowd(shapes: Vec<Shape>) -> Scene {
    let kinds = shapes.len() as u16;
    let law = law(true);
    let mut setup = setup([0.018, 0.018, 0.024], [true, false, false], shapes, law);
    setup.parameters.gravity = Vec3::new(3.0, -15.0, -60.0);
    setup.overlap_limit = 0.9;
    (setup.outlets[2], setup.outlets[5]) = (true, true);
    setup.catalogue.contacts.set(0, 1, law);
    let lens = GasLens { conductivity: 0.03, thickness: 0.2, smallest_gap: 1e-8 };
    warm(&mut setup, Some(lens), Some(500.0));
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
    setup.walls[0].heat = Some(WallHeat::Temperature(400.0));
    setup.walls[1].heat = Some(WallHeat::Power(HEATING));
    let mut particles = lattice([0.0, 0.0, 0.0022], [0.018, 0.0172, 0.0122], 2.5e-3, kinds, 4.0);
    let mut random = Random(17);
    for particle in &mut particles {
        particle.velocity.x += 300.0 * (particle.position.z - 0.006);
        particle.temperature = random.range(200.0, 600.0);
    }
    // A few stay where they are, side by side and at the wall.
    setup.prescribed = vec![PrescribedMotion {
        name: "still".into(),
        ids: 0..40,
        motion: Motion::Fixed,
        about_centres: false,
    }];
    Scene { setup, particles }
}

/// Steps up to `until`, with new particles now and then; all heat is accounted for.
fn run(dem: &mut Dem, transport: &impl Transport, until: u64) -> f64 {
    let mut worst = 0.0_f64;
    while dem.step < until {
        if dem.step % 120 == 60 {
            let new = NewParticle {
                id: 10_000 + dem.step,
                kind: Kind { shape: 0, material: 0 },
                scale: 0.8,
                position: Vec3::new(0.004 + 1e-5 * dem.step as f64, 0.009, 0.020),
                orientation: Rotation::identity(),
                velocity: Vec3::new(0.0, 0.0, -6.0),
                angular_velocity: Vec3::zeros(),
                temperature: 700.0,
            };
            if dem.owns(&new.position) {
                let record = new.record(dem);
                dem.insert(&record);
            }
            dem.announce_insertion();
        }
        dem.step(transport).unwrap();
        let heat = dem.heat(transport).unwrap();
        worst = worst.max(heat.unaccounted().abs() / heat.content);
    }
    worst
}

/// The state after a step, and the sums over all ranks.
fn after(
    scene: &Scene,
    ranks: [usize; 3],
    from: Option<&(Stopped, [ExactSum; 6])>,
    until: u64,
) -> (State, Heat, Vec<f64>) {
    let found = on_ranks(ranks.iter().product(), |transport| {
        let mut dem = match from {
            None => scene.start(ranks, transport.rank()),
            Some((from, ledger)) => {
                let mut dem = scene.resume(ranks, transport.rank(), from, |_| ());
                if transport.rank() == 0 {
                    dem.heat_ledger = HeatLedger::from_sums(*ledger);
                }
                dem
            }
        };
        let worst = run(&mut dem, &transport, until);
        assert!(worst < 1e-13, "{worst:e} of the heat is unaccounted for");
        let heated = dem.wall_heat(&transport)[1];
        // To the quanta of the flows.
        assert!(heated == 0.0 || (heated / HEATING - 1.0).abs() < 1e-6, "{heated}");
        let loads = dem.prescribed_loads(&transport);
        let of_walls = dem.wall_heat(&transport);
        let sums = loads.iter().flat_map(|load| [load.force.x, load.torque.y, load.torque.z]).chain(of_walls);
        (state_of(&dem), dem.heat(&transport).unwrap(), sums.collect::<Vec<f64>>())
    });
    let (heat, sums) = (found[0].1, found[0].2.clone());
    (merged(found.into_iter().map(|(state, ..)| state).collect()), heat, sums)
}

/// Heat flows through contacts, gaps, walls and by radiation; temperatures, all else and their sums are the same bits on any number of ranks,
/// with any skin, exchange and restart, and all heat is accounted for in every step.
#[test]
fn temperatures_have_the_same_bits_on_any_ranks_skin_and_restart() {
    const STEPS: u64 = 300;
    let mut bodies = mixed_shapes(1.4e-3);
    bodies.extend(knobbly_shapes(1.4e-3).into_iter().take(3));
    let spheres = [1.3e-3, 1.0e-3, 0.5e-3].map(|radius| Shape::sphere(radius).unwrap());
    for shapes in [spheres.to_vec(), bodies] {
        let mut scene = crowd(shapes);
        let alone = after(&scene, [1; 3], None, STEPS);
        println!("{:?}", alone.1);
        let [inserted, left, walls, radiation, produced, _] = alone.1.ledger;
        // What passes through contacts is no rounding of what is there.
        assert!(left > 0.0 && walls.abs() > 1e-5 * inserted && radiation != 0.0 && produced > 0.0);
        for ranks in [[2, 1, 1], [1, 3, 1], [2, 2, 2]] {
            assert!(alone == after(&scene, ranks, None, STEPS), "on {ranks:?}");
        }
        for (stop, ranks) in [(61, [1, 1, 2]), (150, [2, 1, 1])] {
            let first = on_ranks(2, |transport| {
                let mut dem = scene.start([2, 1, 1], transport.rank());
                run(&mut dem, &transport, stop);
                dem.refresh(&transport).unwrap();
                let mut ledger = dem.heat_ledger.sums();
                sum_exact(&mut ledger, &transport);
                (Stopped::of(&dem), ledger)
            });
            let ledger = first[0].1;
            let stopped = Stopped::joined(first.into_iter().map(|(part, _)| part).collect());
            assert!(alone == after(&scene, ranks, Some(&(stopped, ledger)), STEPS), "stopped at {stop}");
        }
        scene.setup.exchange = ExchangeStrategy::AllGatherLocal;
        scene.setup.skin = Skin { min: 0.02, max: 0.02, ..scene.setup.skin };
        assert!(alone == after(&scene, [2, 1, 1], None, STEPS), "with another skin");
    }
}

/// Bodies at rest in contact: `positions` (m) of particles of one shape, of prescribed motion where `are_fixed`.
fn at_rest(shape: Shape, law: ContactLaw, places: &[(Vec3, f64)], are_fixed: bool) -> Scene {
    let mut setup = setup([0.02; 3], [false; 3], vec![shape], law);
    setup.parameters.gravity = Vec3::zeros();
    setup.parameters.dt = 1e-5;
    warm(&mut setup, None, None);
    let particles = places.iter().enumerate().map(|(id, (position, temperature))| NewParticle {
        id: id as u64,
        kind: Kind { shape: 0, material: 0 },
        scale: 1.0,
        position: *position,
        orientation: Rotation::identity(),
        velocity: Vec3::zeros(),
        angular_velocity: Vec3::zeros(),
        temperature: *temperature,
    });
    let particles: Vec<NewParticle> = particles.collect();
    if are_fixed {
        let ids = 0..particles.len() as u64;
        setup.prescribed =
            vec![PrescribedMotion { name: "still".into(), ids, motion: Motion::Fixed, about_centres: false }];
    }
    Scene { setup, particles }
}

fn temperatures(scene: &Scene, steps: u64) -> Vec<f64> {
    let mut dem = scene.start([1; 3], 0);
    (0..steps).for_each(|_| dem.step(&SerialTransport).unwrap());
    let mut all: Vec<(u64, f64)> =
        (0..dem.particles.owned).map(|i| (dem.particles.ids[i], dem.particles.temperatures[i])).collect();
    all.sort_by_key(|(id, _)| *id);
    all.into_iter().map(|(_, temperature)| temperature).collect()
}

/// The difference of two spheres in contact falls as exp(−2 G t/(m c)), G = 2 k a, a² = R* δ.
#[test]
fn two_spheres_in_contact_follow_the_closed_form() {
    let (radius, overlap) = (1e-3, 2e-5);
    let law = ContactLaw::linear(1e3, 0.5, 0.0, Tangential::Viscous { rate: 0.0 });
    let middle = Vec3::repeat(0.01);
    let places = [(middle, 300.0), (middle + Vec3::x() * (2.0 * radius - overlap), 400.0)];
    let scene = at_rest(Shape::sphere(radius).unwrap(), law, &places, true);
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let conductance = 40.0 * (0.5 * radius * overlap).sqrt();
    let rate = 2.0 * conductance / (mass * 2.0);
    let steps = (1.0 / (rate * 1e-5)) as u64;
    let found = temperatures(&scene, steps);
    // The explicit steps of the exponential.
    let exact = 100.0 * (1.0 - rate * 1e-5).powi(steps as i32);
    println!("{found:?} after {steps} steps, a difference of {exact}");
    assert!(
        (found[1] - found[0] - exact).abs() < 1e-9 * exact && (found[0] + found[1] - 700.0).abs() < 1e-10
    );
}

/// Ten spheres in a row between a cold and a hot wall get temperatures on a straight line, and the same if the hot wall is given the
/// heat that it needs for it, from which its temperature follows.
#[test]
fn a_row_between_two_walls_is_linear_in_its_steady_state() {
    let (radius, spacing, first) = (1e-3, 1.98e-3, 1e-4);
    let law = ContactLaw::linear(1e3, 0.5, 0.0, Tangential::Viscous { rate: 0.0 });
    let places: Vec<(Vec3, f64)> =
        (0..10).map(|k| (Vec3::new(first + (f64::from(k) + 0.5) * spacing, 0.01, 0.01), 273.15)).collect();
    let mut scene = at_rest(Shape::sphere(radius).unwrap(), law, &places, true);
    scene.setup.parameters.dt = 1e-3;
    let thermal = scene.setup.thermal.as_mut().unwrap();
    thermal.set_conduction([0, 1], Conduction::between(20.0, 20.0, None));
    let plane = |x: f64, towards: f64| Surface::Plane {
        point: Vec3::new(x, 0.01, 0.01),
        normal: Vec3::x() * towards,
    };
    let [cold, hot] = [plane(first, 1.0), plane(first + 10.0 * spacing, -1.0)];
    scene.setup.walls = vec![wall("cold", cold, Motion::Fixed), wall("hot", hot, Motion::Fixed)];
    for (wall, temperature) in scene.setup.walls.iter_mut().zip([273.15, 323.15]) {
        wall.heat = Some(WallHeat::Temperature(temperature));
    }
    // Contacts of spheres and of a sphere with a wall are as wide, so that all eleven conduct alike, but for the quanta of positions.
    let check = |scene: &Scene| {
        for (k, found) in temperatures(scene, 10_000).into_iter().enumerate() {
            let exact = 273.15 + 50.0 * (k as f64 + 1.0) / 11.0;
            assert!((found - exact).abs() < 1e-6, "sphere {k}: {found} instead of {exact}");
        }
    };
    check(&scene);
    let power = 20.0 * 2.0 * (0.5 * radius * 2e-5).sqrt() * 50.0 / 11.0;
    scene.setup.walls[1].heat = Some(WallHeat::Power(power));
    check(&scene);
    let mut dem = scene.start([1; 3], 0);
    (0..10_000).for_each(|_| dem.step(&SerialTransport).unwrap());
    assert!((dem.wall_temperatures()[1] - 323.15).abs() < 1e-6, "{:?}", dem.wall_temperatures());
    let [cold, hot] = [0, 1].map(|k| dem.wall_heat(&SerialTransport)[k]);
    assert!((hot / power - 1.0).abs() < 1e-8 && (cold / power + 1.0).abs() < 1e-8, "{cold} {hot} {power}");
}

/// A cube on a cube, touching in a patch, conducts as the circle of the area of their faces; lying askew as that of what they share.
#[test]
fn faces_conduct_over_their_common_area() {
    let side = 2e-3;
    let law = ContactLaw::linear(1e5, 0.5, 0.0, Tangential::Viscous { rate: 0.0 });
    let middle = Vec3::repeat(0.01);
    let rate = |shift: f64| {
        let up = Vec3::z() * (side - 1e-6) + Vec3::x() * shift;
        let cube = Shape::cuboid([side, side, side].into(), 0.05).unwrap();
        let mut scene = at_rest(cube, law, &[(middle, 300.0), (middle + up, 400.0)], true);
        scene.setup.catalogue.faces = grains_dem::FaceContact::MultiPoint;
        let found = temperatures(&scene, 1);
        found[0] - 300.0
    };
    let [whole, half] = [0.0, 0.5 * side].map(rate);
    println!("{whole} K, {half} K in a step; {}", whole / half);
    // a = √(area/π): half the area conducts √2 less. Corners are round, which the patch does not know.
    assert!((whole / half - 2.0_f64.sqrt()).abs() < 0.08, "{}", whole / half);
}

/// A softened law conducts as the one it stands for under the same force.
#[test]
fn softened_contacts_conduct_as_hard_ones_under_the_same_force() {
    let (radius, modulus, force) = (1e-3, 5e9, 0.5);
    let conducted = |softening: f64| {
        let law = ContactLaw::new(
            Hertz { modulus: modulus / softening },
            0.5,
            0.0,
            Tangential::Viscous { rate: 0.0 },
        );
        let effective = 0.5 * radius;
        let overlap = (0.75 * force * softening / (modulus * f64::sqrt(effective))).powf(2.0 / 3.0);
        let middle = Vec3::repeat(0.01);
        let places = [(middle, 300.0), (middle + Vec3::x() * (2.0 * radius - overlap), 400.0)];
        let mut scene = at_rest(Shape::sphere(radius).unwrap(), law, &places, true);
        let conduction = Conduction::between(20.0, 20.0, (softening > 1.0).then_some(modulus));
        scene.setup.thermal.as_mut().unwrap().set_conduction([0, 0], conduction);
        temperatures(&scene, 1)[0] - 300.0
    };
    let [hard, soft] = [conducted(1.0), conducted(1000.0)];
    assert!((hard / soft - 1.0).abs() < 1e-9 && hard > 0.0, "{hard} {soft}");
}

/// A time step in which temperatures would overshoot ends the run with the particle's id.
#[test]
fn a_step_too_long_for_the_temperatures_is_an_error() {
    let law = ContactLaw::linear(1e3, 0.5, 0.0, Tangential::Viscous { rate: 0.0 });
    let middle = Vec3::repeat(0.01);
    let places = [(middle, 300.0), (middle + Vec3::x() * 1.9e-3, 400.0)];
    let mut scene = at_rest(Shape::sphere(1e-3).unwrap(), law, &places, true);
    scene.setup.parameters.dt = 0.01;
    let mut dem = scene.start([1; 3], 0);
    let failure = dem.step(&SerialTransport).unwrap_err();
    let message = format!("{failure:?}");
    assert!(message.contains("Temperature") && message.contains("id: 0"), "{message}");
}
