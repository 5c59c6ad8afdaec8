//! Walls that a load moves: equilibrium, momentum, and the same bits whatever the ranks.

use crate::common::{Scene, State, Stopped, lattice, law, merged, setup, state_of, wall};
use grains_dem::{Dem, Failure, Kind, Loading, Motion, NewParticle, Skin, StepError, Surface, Travel};
use grains_domain::{SerialTransport, Transport};
use grains_geometry::{Rotation, Shape, Vec3};
use grains_testing::on_ranks;

const SIZE: f64 = 0.03;

fn loading(axis: Vec3, force: f64, mass: f64) -> Loading {
    Loading {
        axis,
        force,
        mass,
        damping: 0.0,
        max_speed: f64::INFINITY,
        velocity: Vec3::zeros(),
        start: 0.0,
        end: f64::INFINITY,
    }
}

fn lid(height: f64, loading: Loading) -> grains_dem::Wall {
    let surface = Surface::Plane { point: Vec3::new(0.0, 0.0, height), normal: -Vec3::z() };
    wall("lid", surface, Motion::Loaded(loading))
}

/// Spheres between a floor and a lid that presses and slides.
fn pressed_bed(skin: Skin) -> Scene {
    let mut setup = setup([SIZE; 3], [true, true, false], vec![Shape::sphere(1.5e-3).unwrap()], law(true));
    setup.skin = skin;
    let floor = Surface::Plane { point: Vec3::new(0.0, 0.0, 0.001), normal: Vec3::z() };
    let slides =
        Loading { velocity: Vec3::new(0.3, 0.1, 0.0), damping: 0.5, ..loading(-Vec3::z(), 5.0, 0.02) };
    setup.walls = vec![wall("floor", floor, Motion::Fixed), lid(0.0215, slides)];
    let particles = lattice([0.0, 0.0, 0.001], [SIZE, SIZE, 0.0205], 3.2e-3, 1, 0.3);
    Scene { setup, particles }
}

/// Particles and lid after some steps from a state, on a grid of ranks.
fn go_on(
    scene: &Scene,
    ranks: [usize; 3],
    from: Option<&(Stopped, Vec<Travel>)>,
    steps: u64,
) -> (State, Vec<Travel>) {
    let parts = on_ranks(ranks.iter().product(), |transport| {
        let mut dem = match from {
            None => scene.start(ranks, transport.rank()),
            Some((stopped, travels)) => {
                scene.resume(ranks, transport.rank(), stopped, |dem| dem.travels.clone_from(travels))
            }
        };
        for _ in 0..steps {
            dem.step(&transport).unwrap();
        }
        (state_of(&dem), dem.travels)
    });
    let travels: Vec<Vec<Travel>> = parts.iter().map(|(_, travels)| travels.clone()).collect();
    assert!(travels.iter().all(|of_rank| *of_rank == travels[0]), "ranks differ: {travels:?}");
    (merged(parts.into_iter().map(|(state, _)| state).collect()), travels[0].clone())
}

#[test]
fn a_loaded_lid_has_the_same_bits_on_any_ranks_with_any_skin_and_after_a_restart() {
    let steps = 3000;
    let scene = pressed_bed(Skin::default());
    let alone = go_on(&scene, [1; 3], None, steps);
    assert!(alone.1[1].way > 1e-4, "the lid comes down: {:?}", alone.1);
    for ranks in [[2, 1, 1], [1, 2, 2], [2, 1, 2], [1, 3, 1]] {
        assert!(go_on(&scene, ranks, None, steps) == alone, "{ranks:?}");
    }
    let thin = Skin { max: 0.03, min: 0.01, ..Skin::default() };
    assert!(go_on(&pressed_bed(thin), [2, 2, 1], None, steps) == alone, "skin");
    let before = 1300;
    let mut dem = scene.start([1; 3], 0);
    for _ in 0..before {
        dem.step(&SerialTransport).unwrap();
    }
    dem.refresh(&SerialTransport).unwrap();
    let from = (Stopped::of(&dem), dem.travels.clone());
    assert!(go_on(&scene, [2, 2, 1], Some(&from), steps - before) == alone, "restart");
}

#[test]
fn a_bed_comes_to_bear_the_load_of_its_lid() {
    let mut scene = pressed_bed(Skin::default());
    let load = Loading { damping: 20.0, ..loading(-Vec3::z(), 5.0, 0.02) };
    scene.setup.walls[1] = lid(0.0215, load);
    let mut dem = scene.start([1; 3], 0);
    let (mut mean, mut count) = (0.0, 0);
    for step in 0..40_000 {
        dem.step(&SerialTransport).unwrap();
        if step >= 20_000 {
            mean += dem.wall_loads[1].force.z;
            count += 1;
        }
    }
    let mean = mean / f64::from(count);
    assert!((mean / 5.0 - 1.0).abs() < 0.01, "{mean} N for 5 N");
    let state = &dem.wall_states()[1];
    assert!(state.velocity.norm() < 0.01, "{state:?}");
}

/// A ball below a lid that its load presses down, nothing else.
fn ball_below_lid(load: Loading, distance: f64) -> Dem {
    let radius = 1.5e-3;
    let mut setup = setup([SIZE; 3], [false; 3], vec![Shape::sphere(radius).unwrap()], law(true));
    setup.parameters.gravity = Vec3::zeros();
    setup.walls = vec![lid(0.02, load)];
    let mut dem = Dem::new(setup, 0).unwrap();
    let particle = NewParticle {
        id: 0,
        kind: Kind { shape: 0, material: 0 },
        scale: 1.0,
        position: Vec3::new(0.015, 0.015, 0.02 - radius - distance),
        orientation: Rotation::identity(),
        velocity: Vec3::zeros(),
        angular_velocity: Vec3::zeros(),
        temperature: 0.0,
    };
    let record = particle.record(&dem);
    dem.insert(&record);
    dem
}

#[test]
fn lid_and_ball_have_the_momentum_that_the_load_gives() {
    for mass in [1e-5, 1e-3] {
        let load = loading(-Vec3::z(), 0.3 * mass / 1e-3, mass);
        let mut dem = ball_below_lid(load, 1e-3);
        let ball = dem.particles.bodies[0].mass;
        for step in 0..1500_u32 {
            let momentum = ball * -dem.particles.half_velocity[0].z + mass * dem.travels[0].half_speed;
            let given = load.force * f64::from(step) * dem.setup.parameters.dt;
            assert!((momentum - given).abs() < 1e-9 * (given + load.force * 1e-3), "{momentum} {given}");
            dem.step(&SerialTransport).unwrap();
        }
        assert!(dem.particles.bodies[0].velocity.z < -0.1, "the lid has hit the ball");
    }
}

#[test]
fn a_lid_that_nothing_holds_or_that_hits_too_hard_ends_the_run() {
    let until_error = |mut dem: Dem| {
        (0..200_000).find_map(|_| match dem.step(&SerialTransport) {
            Err(Failure::Here { error, .. }) => Some(error),
            _ => None,
        })
    };
    let up = until_error(ball_below_lid(loading(Vec3::z(), 1.0, 0.1), 1e-3));
    assert!(
        matches!(&up, Some(StepError::WallOutside { wall, way, .. }) if wall == "lid" && (*way - 0.01).abs() < 1e-4),
        "{up:?}"
    );
    // Its load is small beside what its speed does to the ball.
    let mut fast = ball_below_lid(loading(-Vec3::z(), 1e-6, 10.0), 1e-3);
    fast.travels[0] = Travel { way: 0.0, half_speed: 1000.0, speed: 1000.0 };
    assert!(until_error(fast).is_some());
}

#[test]
fn a_lid_rests_before_and_after_its_load_acts() {
    let load = Loading { start: 1e-3, end: 2e-3, ..loading(-Vec3::z(), 1.0, 0.1) };
    let mut dem = ball_below_lid(load, 0.01);
    let mut height = |steps: u32| {
        (0..steps).for_each(|_| dem.step(&SerialTransport).unwrap());
        (dem.wall_states()[0].translation.z, dem.wall_states()[0].velocity.z)
    };
    assert_eq!(height(250), (0.0, 0.0));
    let (lowered, speed) = height(250);
    // a t²/2 and a t.
    assert!((lowered / -5e-6 - 1.0).abs() < 0.02 && (speed / -1e-2 - 1.0).abs() < 0.02, "{lowered} {speed}");
    assert_eq!(height(10).1, 0.0);
    assert!((height(100).0 - lowered).abs() < 0.02 * lowered.abs());
}

#[test]
fn a_lid_goes_on_from_where_it_is_when_its_load_changes() {
    let mut dem = ball_below_lid(loading(-Vec3::z(), 1.0, 0.1), 0.01);
    (0..500).for_each(|_| dem.step(&SerialTransport).unwrap());
    let before = dem.wall_states()[0];
    dem.set_wall_motion(0, Motion::Loaded(loading(Vec3::z(), 2.0, 0.1)));
    let after = dem.wall_states()[0];
    assert!((after.translation - before.translation).norm() < 1e-15);
    assert!((after.velocity - before.velocity).norm() < 1e-15 && before.velocity.z < -0.01);
    dem.set_wall_motion(0, Motion::Fixed);
    let fixed = dem.wall_states()[0];
    assert!((fixed.translation - before.translation).norm() < 1e-15 && fixed.velocity == Vec3::zeros());
}
