//! Ranks rebuild their lists apart from each other, and learn of errors and stops together.

use crate::common::{Random, Scene, State, lattice, law, merged, mixed_shapes, setup, state_of};
use grains_dem::{Crossings, Dem, DemSetup, Failure, StepError};
use grains_domain::Transport;
use grains_geometry::{Shape, Vec3};
use grains_testing::on_ranks;

/// The state of all particles, and what has crossed the planes.
type Found = (State, Vec<Crossings>);

/// Runs `steps` steps on a grid of ranks; returns the state with what has crossed the planes, and of each rank how often it rebuilt its lists,
/// and those of its border alone.
fn run(scene: &Scene, ranks: [usize; 3], steps: u64) -> (Found, Vec<[u64; 2]>) {
    let parts = on_ranks(ranks.iter().product(), |transport| {
        let mut dem = scene.start(ranks, transport.rank());
        for _ in 0..steps {
            dem.step(&transport).unwrap();
        }
        dem.settle(&transport).unwrap();
        assert!(dem.check_ledger(&transport).is_ok());
        let crossings = dem.crossings(&transport);
        ((state_of(&dem), crossings), [dem.report.rebuilds, dem.report.border_rebuilds])
    });
    let (found, rebuilds): (Vec<Found>, Vec<[u64; 2]>) = parts.into_iter().unzip();
    let (states, mut crossings): (Vec<State>, Vec<Vec<Crossings>>) = found.into_iter().unzip();
    ((merged(states), crossings.swap_remove(0)), rebuilds)
}

/// A row of boxes: particles at rest but in the first, where they fly about.
fn hot_corner(shapes: Vec<Shape>) -> Scene {
    let kinds = shapes.len() as u16;
    let mut setup = setup([0.12, 0.03, 0.03], [false, true, true], shapes, law(true));
    setup.parameters.gravity = Vec3::zeros();
    let mut particles = lattice([0.003, 0.0, 0.0], [0.117, 0.03, 0.03], 3.7e-3, kinds, 0.0);
    let mut random = Random(7);
    for particle in &mut particles {
        particle.angular_velocity = Vec3::zeros();
        if particle.position.x < 0.02 {
            // Inwards: what is fast stays there for a while.
            particle.velocity = random.direction() * 3.0;
            particle.velocity.x = -particle.velocity.x.abs();
        }
    }
    setup.outlets = [true; 6];
    Scene { setup, particles }
}

#[test]
fn an_agitated_corner_does_not_wake_the_rest() {
    for shapes in [vec![Shape::sphere(1.5e-3).unwrap()], mixed_shapes(1.4e-3)] {
        let scene = hot_corner(shapes);
        let (one, _) = run(&scene, [1; 3], 400);
        let (four, rebuilds) = run(&scene, [4, 1, 1], 400);
        assert_eq!(one, four, "the state depends on the ranks");
        let [first, .., last] = rebuilds[..] else { panic!("four ranks") };
        assert!(first[0] >= 8, "the agitated rank: {rebuilds:?}");
        // The first rebuild is one of all, and each widening of the ranges.
        assert!(last[0] <= 4, "a rank at rest: {rebuilds:?}");
        assert!(rebuilds[1][1] > 0, "the neighbour of the agitated rank takes its clones: {rebuilds:?}");
        assert_eq!(last[1], 0, "nobody near the last rank moves: {rebuilds:?}");
    }
}

#[test]
fn ranks_apart_and_together_end_in_the_same_bits_in_a_gas_of_any_density_and_speed() {
    let mut random = Random(20_261_126);
    let (mut own, mut border, mut crossed) = (0, 0, 0);
    for round in 0..12 {
        let shapes = if round % 2 == 0 { vec![Shape::sphere(1.5e-3).unwrap()] } else { mixed_shapes(1.4e-3) };
        let kinds = shapes.len() as u16;
        let periodic = std::array::from_fn(|_| random.unit() < 0.6);
        let mut setup = setup([0.04, 0.03, 0.03], periodic, shapes, law(round % 3 > 0));
        setup.outlets = [true; 6];
        setup.parameters.gravity = random.vector() * 9.81;
        // From settled to shot.
        let speed = 10.0_f64.powf(random.range(-2.0, 1.2));
        let spacing = random.range(3.4e-3, 6e-3);
        let particles = lattice([0.0; 3], [0.04, 0.03, 0.03], spacing, kinds, speed);
        let mut scene = Scene { setup, particles };
        let (one, _) = run(&scene, [1; 3], 200);
        for ranks in [[3, 1, 1], [2, 2, 2], [1, 2, 3]] {
            let (apart, rebuilds) = run(&scene, ranks, 200);
            assert_eq!(one, apart, "round {round}: {ranks:?} apart, {speed} m/s");
            own += rebuilds.iter().map(|r| r[0]).sum::<u64>();
            border += rebuilds.iter().map(|r| r[1]).sum::<u64>();
        }
        crossed += one.1[0].count.abs();
        scene.setup.rebuilds_together = true;
        let (together, _) = run(&scene, [2, 2, 1], 200);
        assert_eq!(one, together, "round {round}: together");
    }
    assert!(own > 1000 && border > 100, "{own} rebuilds, {border} of borders alone");
    assert!(crossed > 20, "{crossed} particles have crossed the plane");
}

/// Two particles that meet nothing, the second going fast towards the upper end of the box.
fn shot(ranks: [usize; 3], rank: usize) -> Dem {
    let mut setup =
        setup([0.12, 0.03, 0.03], [false, true, true], vec![Shape::sphere(1.5e-3).unwrap()], law(true));
    setup.parameters.gravity = Vec3::zeros();
    let mut particles = lattice([0.003, 0.0, 0.0], [0.117, 0.03, 0.03], 0.012, 1, 0.0);
    let last = particles.iter_mut().max_by(|a, b| a.position.x.total_cmp(&b.position.x)).unwrap();
    last.velocity = Vec3::new(20.0, 0.0, 0.0);
    Scene { setup: DemSetup { ranks, ..setup }, particles }.start(ranks, rank)
}

#[test]
fn an_error_ends_all_ranks_at_the_same_step_and_names_the_one_it_was_met_in() {
    let ends = |ranks: [usize; 3]| {
        on_ranks(ranks.iter().product(), |transport| {
            let mut dem = shot(ranks, transport.rank());
            let failure = (0..1000).find_map(|_| dem.step(&transport).err()).unwrap();
            (failure, dem.step)
        })
    };
    let one = ends([1; 3]);
    let (Failure::Here { error, step }, _) = &one[0] else { panic!("{one:?}") };
    assert!(matches!(error, StepError::Lost { face, .. } if face == "+x"), "{error}");
    for ranks in [[2, 1, 1], [4, 1, 1], [2, 2, 2]] {
        let all = ends(ranks);
        let told: Vec<_> = all.iter().filter(|(failure, _)| *failure != Failure::Elsewhere).collect();
        let [(Failure::Here { error: other, step: at }, end)] = told[..] else { panic!("{all:?}") };
        assert_eq!((other, at), (error, step), "{ranks:?}");
        assert!(all.iter().all(|(_, step)| step == end) && end - at <= 8, "{all:?}");
    }
}

#[test]
fn a_stop_asked_for_on_one_rank_reaches_all_at_the_same_step() {
    for ranks in [[3, 1, 1], [2, 2, 2]] {
        let ends = on_ranks(ranks.iter().product(), |transport| {
            let mut dem = shot(ranks, transport.rank());
            for step in 0..20 {
                dem.interrupt = step == 5 && transport.rank() == 1;
                dem.step(&transport).unwrap();
                if dem.interrupt {
                    return dem.step;
                }
            }
            panic!("nobody is told")
        });
        assert!(ends.iter().all(|&step| step == ends[0]) && ends[0] <= 14, "{ends:?}");
    }
}
