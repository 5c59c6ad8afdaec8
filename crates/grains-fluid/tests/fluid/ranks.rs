//! The same flow on any number of ranks.

use crate::common::{difference, joined, partition, piece, refined_channel};
use grains_domain::Transport;
use grains_fluid::{
    Advection, Axis, Boundaries, BoxFace, Clearance, Condition, Drive, FanCurve, Flow, FlowRate, FlowSetup,
    Grid, MixtureModel, Outline, Patch, Profile, Side,
};
use grains_testing::on_ranks;
use std::sync::Arc;

/// Velocity components and pressure after some steps.
fn run(setup: &FlowSetup, ranks: [usize; 3], steps: usize) -> Vec<Vec<f64>> {
    run_from(setup, ranks, steps, |_| ())
}

/// The same from a flow that was changed at the beginning.
fn run_from(
    setup: &FlowSetup,
    ranks: [usize; 3],
    steps: usize,
    change: impl Fn(&mut Flow) + Sync,
) -> Vec<Vec<f64>> {
    let results = on_ranks(ranks.iter().product(), |transport| {
        let own = partition(&setup.grid, ranks, transport.rank());
        let mut flow = Flow::new(FlowSetup { partition: own, ..setup.clone() }, &transport).unwrap();
        let wave =
            |x: f64, y: f64, z: f64| 0.3 * (6.0 * x + 1.0).sin() * (5.0 * y).cos() * (4.0 * z + 0.5).sin();
        flow.initialise(|[x, y, z]| [wave(x, y, z), wave(y, z, x), wave(z, x, y)], |[x, ..]| x, &transport);
        change(&mut flow);
        for step in 0..steps {
            add_particles(&mut flow, step as f64 * 0.1);
            // What appears at once would leave by the fan.
            if let (true, 0, Some(mixture)) = (!flow.state.fans.is_empty(), step, &mut flow.mixture) {
                mixture.begin();
            }
            flow.step(0.01, &transport).unwrap();
        }
        let (state, layout, first) = (&flow.state, flow.layout(), flow.first_cell());
        let [u, v, w] = state.velocity.components();
        [u, v, w, state.pressure.data()].map(|data| piece(data, layout, first))
    });
    (0..4).map(|field| joined(results.iter().map(|r| r[field].clone()).collect())).collect()
}

/// A cloud of particles whose density drifts.
fn add_particles(flow: &mut Flow, phase: f64) {
    let (layout, first) = (flow.layout(), flow.first_cell());
    let Some(mixture) = &mut flow.mixture else { return };
    let [nx, ny, nz] = layout.cells.map(|n| n as isize);
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let at = [i, j, k];
                let [x, y, z] = std::array::from_fn(|a| (at[a] + first[a] as isize) as f64);
                let wave = (0.8 * x + phase).sin() * (0.6 * y).cos() * (0.7 * z).cos();
                mixture.void_fraction.set(i, j, k, 0.7 + 0.2 * wave);
                mixture.drag.x.set(i, j, k, 30.0 * (1.0 + wave));
                mixture.drag.z.set(i, j, k, 20.0 * (1.0 - wave));
                mixture.source.y.set(i, j, k, 5.0 * wave);
            }
        }
    }
}

fn compare(setup: &FlowSetup, rank_grids: &[[usize; 3]]) {
    let serial = run(setup, [1; 3], 6);
    let size = serial[0].iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    assert!(size > 0.05 && size < 10.0, "the flow must flow: {size}");
    for &ranks in rank_grids {
        let split = run(setup, ranks, 6);
        for (name, (a, b)) in ["u", "v", "w", "p"].iter().zip(serial.iter().zip(&split)) {
            let error = difference(a, b);
            assert!(error < 1e-10, "{ranks:?} {name}: {error:.2e}");
        }
    }
}

const GRIDS: [[usize; 3]; 7] = [[2, 1, 1], [1, 2, 1], [1, 1, 2], [2, 2, 1], [1, 2, 2], [4, 1, 1], [2, 2, 2]];

#[test]
fn a_closed_box_with_a_lid() {
    let lid = Condition::Wall { velocity: [1.0, 0.0, 0.3] };
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [12, 10, 8], [false; 3]).unwrap();
    let boundaries = Boundaries::default().with(1, Side::High, lid);
    compare(&FlowSetup { boundaries, ..FlowSetup::new(grid, 1.0, 0.02) }, &GRIDS);
}

#[test]
fn a_periodic_stretched_channel_with_a_flow_rate() {
    let grid = refined_channel(Axis::uniform(0.0, 1.0, 8, true));
    let drive = [Drive::MeanVelocity(0.5), Drive::PressureGradient(0.4), Drive::None];
    compare(&FlowSetup { drive, ..FlowSetup::new(grid, 1.0, 0.02) }, &GRIDS);
}

/// Inlet patch below, outlet above, walls with a moving one.
fn bed(mixture: Option<MixtureModel>) -> FlowSetup {
    let grid = Grid::uniform([0.0; 3], [1.0, 1.0, 1.5], [8, 8, 12], [false, true, false]).unwrap();
    let inlet = Condition::Inlet { profile: Profile::Uniform([0.0, 0.1, 0.6]) };
    let patch = Patch {
        face: BoxFace { axis: 2, side: Side::Low },
        outline: Outline::Rectangle { lower: [0.25, 0.0, 0.0], upper: [0.75, 1.0, 0.0] },
        condition: inlet,
    };
    let boundaries = Boundaries::default()
        .with(2, Side::High, Condition::Outlet { pressure: 1.0 })
        .with(0, Side::Low, Condition::Wall { velocity: [0.0, 0.2, 0.0] })
        .with_patch(patch);
    FlowSetup { boundaries, mixture, advection: Advection::VanLeer, ..FlowSetup::new(grid, 1.2, 0.02) }
}

#[test]
fn a_bed_with_an_inlet_patch_and_an_outlet() {
    compare(&bed(None), &GRIDS);
}

/// Velocities further than two layers beyond an end of the box are never read, however wide the halo is.
#[test]
fn ghosts_far_beyond_the_box_are_not_read() {
    let spoil = |flow: &mut Flow| {
        let (layout, grid, first) = (flow.layout(), flow.setup.grid.clone(), flow.first_cell());
        let h = layout.halo as isize;
        let [x, y, z] = layout.cells.map(|n| -h..n as isize + h);
        let cells = z.flat_map(|k| {
            y.clone().flat_map({
                let x = x.clone();
                move |j| x.clone().map(move |i| [i, j, k])
            })
        });
        let is_far = |at: [isize; 3]| {
            (0..3).any(|a| {
                let (i, n) = (at[a] + first[a] as isize, grid.cells()[a] as isize);
                !grid.axis(a).is_periodic() && !(-2..n + 2).contains(&i)
            })
        };
        let far: Vec<usize> = cells.filter(|&at| is_far(at)).map(|[i, j, k]| layout.index(i, j, k)).collect();
        assert!(!far.is_empty());
        for component in 0..3 {
            let velocity = flow.state.velocity.component_mut(component);
            far.iter().for_each(|&place| velocity[place] = f64::NAN);
        }
    };
    for mixture in [None, Some(MixtureModel::A), Some(MixtureModel::B)] {
        for advection in [Advection::Central, Advection::VanLeer] {
            let setup = FlowSetup { halo: 4, advection, ..bed(mixture) };
            for ranks in [[1; 3], [2, 1, 1], [2, 1, 2], [2, 2, 2]] {
                let [plain, spoilt] = [run(&setup, ranks, 4), run_from(&setup, ranks, 4, spoil)];
                assert!(plain == spoilt, "{mixture:?} {advection:?} {ranks:?}");
            }
        }
    }
}

/// Edges off the lines of the grid and beyond the end of the period, a patch narrower than cells, profiles of all kinds.
#[test]
fn patches_that_cut_cells() {
    let formula = |[x, y, _]: [f64; 3], t: f64| [0.0, 0.1, 0.5 + 0.2 * (4.0 * x + 9.0 * t).sin() * y];
    let profiles = [
        Profile::Uniform([0.1, 0.0, 0.6]),
        Profile::Parabolic { mean: 0.7 },
        Profile::Function(Arc::new(formula)),
    ];
    for profile in profiles {
        let mut setup = bed(None);
        let face = BoxFace { axis: 2, side: Side::Low };
        let condition = Condition::Inlet { profile };
        let at = |lower, upper| Patch {
            face,
            outline: Outline::Rectangle { lower, upper },
            condition: condition.clone(),
        };
        setup.boundaries.patches =
            vec![at([0.21, 0.68, 0.0], [0.83, 1.31, 0.0]), at([0.51, 0.45, 0.0], [0.55, 0.49, 0.0])];
        compare(&setup, &GRIDS);
    }
}

#[test]
fn a_bed_with_particles() {
    for model in [MixtureModel::A, MixtureModel::B] {
        let mut setup = bed(Some(model));
        setup.advection = Advection::Central;
        compare(&setup, &[[2, 1, 1], [1, 2, 1], [1, 1, 2], [2, 1, 2]]);
    }
}

#[test]
fn fans_and_stated_flows_through_discs_and_polygons() {
    let face = |axis, side| BoxFace { axis, side };
    let disc = |x, radius, inner_radius| Outline::Disc { center: [x, 0.52, 0.47], radius, inner_radius };
    let flow = Profile::FlowRate { rate: FlowRate::Constant(0.05), is_parabolic: true };
    let fan = FanCurve::new(vec![[0.0, 3.0], [0.2, 1.0], [0.3, -1.0]]).unwrap();
    let corners = vec![[0.2, 0.1, 0.0], [0.8, 0.3, 0.0], [0.4, 0.9, 0.0]];
    for mixture in [None, Some(MixtureModel::A)] {
        let grid = Grid::new([
            Axis::clustered(0.0, 1.0, 12, 1.0),
            Axis::uniform(0.0, 1.0, 8, true),
            Axis::uniform(0.0, 1.0, 12, false),
        ]);
        let patches = vec![
            Patch {
                face: face(0, Side::Low),
                outline: disc(0.0, 0.3, 0.0),
                condition: Condition::PressureInlet { pressure: 0.5, fan: Some(fan.clone()) },
            },
            Patch {
                face: face(2, Side::High),
                outline: Outline::Polygon { corners: corners.clone() },
                condition: Condition::Inlet { profile: Profile::Uniform([0.1, 0.0, -0.4]) },
            },
            Patch {
                face: face(2, Side::Low),
                outline: disc(0.45, 0.35, 0.12),
                condition: Condition::Inlet { profile: flow.clone() },
            },
        ];
        let boundaries = Boundaries { patches, ..Boundaries::default() };
        let boundaries = boundaries.with(0, Side::High, Condition::Outlet { pressure: 0.0 });
        let setup = FlowSetup { boundaries, mixture, ..FlowSetup::new(grid.unwrap(), 1.0, 0.02) };
        compare(&setup, &GRIDS);
    }
}

/// A plate across the box shuts the inlet off, whichever ranks own it; with a hole it does not.
#[test]
fn regions_that_walls_shut_off() {
    let plate = |hole: f64| {
        move |[x, y, z]: [f64; 3]| {
            let beside = (x - 0.55).abs() - 0.1;
            let to_hole = hole - (y - 0.5).hypot(z - 0.5);
            let (distance, direction) = match beside > to_hole {
                true => (beside, [(x - 0.55).signum(), 0.0, 0.0]),
                false => (to_hole, [0.0, (0.5 - y).signum(), 0.0]),
            };
            Clearance { distance, direction, wall: 0 }
        }
    };
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [16, 10, 10], [false; 3]).unwrap();
    let boundaries = Boundaries::default()
        .with(0, Side::Low, Condition::Inlet { profile: Profile::Uniform([0.3, 0.0, 0.0]) })
        .with(0, Side::High, Condition::Outlet { pressure: 0.0 });
    let setup = FlowSetup { boundaries, mixture: Some(MixtureModel::A), ..FlowSetup::new(grid, 1.0, 0.02) };
    for ranks in [[1, 1, 1], [2, 1, 1], [1, 2, 2], [3, 2, 1]] {
        for (hole, is_shut) in [(-1.0, true), (0.25, false)] {
            let results = on_ranks(ranks.iter().product(), |transport| {
                let own = partition(&setup.grid, ranks, transport.rank());
                let mut flow = Flow::new(FlowSetup { partition: own, ..setup.clone() }, &transport).unwrap();
                flow.enclose(&plate(hole), &transport).map_err(|error| error.to_string())
            });
            for result in results {
                assert_eq!(result.is_err(), is_shut, "{ranks:?} {hole}: {result:?}");
                let message = result.err().unwrap_or_default();
                assert!(
                    !is_shut || message.contains("3.0000e-1 m³/s enter the region about [0.03125"),
                    "{message}"
                );
            }
        }
    }
}
