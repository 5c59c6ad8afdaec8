//! Scalars that a flow carries: exact solutions, what is kept, and what limits hold.

use crate::common::{difference, joined, order, partition, piece, set};
use grains_domain::{SerialTransport, Transport};
use grains_fluid::{
    Axis, Boundaries, Buoyancy, Centre, Clearance, Condition, Field, Flow, FlowSetup, Grid, MixtureModel,
    Profile, ScalarBoundaries, ScalarCondition, ScalarSetup, ScalarValue, Scheme, SolidCondition,
    SolidConditions,
};
use grains_testing::on_ranks;
use std::f64::consts::PI;
use std::sync::Arc;

const SERIAL: SerialTransport = SerialTransport;

/// A scalar of a diffusivity (m²/s) that nothing enters or leaves.
fn insulated(diffusivity: f64, scheme: Scheme) -> ScalarSetup {
    ScalarSetup {
        name: "tracer".into(),
        diffusivity,
        scheme,
        boundaries: ScalarBoundaries::default(),
        solids: SolidConditions::default(),
        buoyancy: None,
    }
}

fn value(value: f64) -> ScalarCondition {
    ScalarCondition::Value(ScalarValue::Uniform(value))
}

/// De Vahl Davis' cavity: largest velocities along x in the middle plane and along y, and the mean Nusselt number of the hot wall.
fn cavity(rayleigh: f64, n: usize, scheme: Scheme) -> [f64; 3] {
    let prandtl = 0.71;
    let axis = || Axis::clustered(0.0, 1.0, n, 1.0 + 1.6 / n as f64);
    let grid = Grid::new([axis(), axis(), Axis::uniform(0.0, 1.0, 1, true)]).unwrap();
    // Lengths in edges, times in L²/α: α = 1, ν = Pr, g β ΔT = Ra Pr.
    let mut flow = Flow::new(FlowSetup::new(grid, 1.0, prandtl), &SERIAL).unwrap();
    let mut setup = insulated(1.0, scheme);
    setup.boundaries.faces[0] = value(1.0);
    setup.boundaries.faces[1] = value(0.0);
    setup.buoyancy =
        Some(Buoyancy { expansion: 1.0, reference: 0.5, gravity: [0.0, -rayleigh * prandtl, 0.0] });
    flow.add_scalar(setup, |[x, ..]| 1.0 - x, &SERIAL);
    let fastest = 0.3 * (rayleigh * prandtl).sqrt() + 4.0;
    let dt = 0.4 * flow.setup.grid.axis(0).width(n as isize / 2) / fastest;
    let (mut before, mut nusselt) = (0.0, 0.0_f64);
    for step in 0..200_000 {
        flow.step(dt, &SERIAL).unwrap();
        if step % 200 == 199 {
            let entered = std::mem::take(&mut flow.scalars.as_mut().unwrap().all[0].entered);
            let field = &flow.scalars.as_ref().unwrap().all[0].value;
            let hot = |j: usize| {
                let (x, y) = (flow.setup.grid.axis(0), flow.setup.grid.axis(1));
                (1.0 - field.at(0, j as isize, 0)) / (0.5 * x.width(0)) * y.width(j as isize)
            };
            nusselt = (0..n).map(hot).sum();
            if (nusselt - before).abs() < 1e-6 {
                assert!(entered.abs() < 1e-4, "what comes in leaves: {entered}");
                break;
            }
            before = nusselt;
        }
    }
    let largest = |f: &dyn Fn(isize) -> f64| (0..n as isize).map(f).fold(0.0, f64::max);
    let middle = n as isize / 2;
    let u = largest(&|j| flow.state.velocity.x.at(middle - 1, j, 0));
    let v = largest(&|i| flow.state.velocity.y.at(i, middle - 1, 0));
    [u, v, nusselt]
}

#[test]
fn convection_in_a_square_is_that_of_de_vahl_davis() {
    let sources = [
        (1e3, 24, [3.649, 3.697, 1.118]),
        (1e4, 32, [16.178, 19.617, 2.243]),
        (1e5, 40, [34.73, 68.59, 4.519]),
    ];
    for (rayleigh, n, source) in sources {
        for scheme in [Scheme::Bounded, Scheme::Central] {
            let found = cavity(rayleigh, n, scheme);
            println!("{rayleigh:e} {scheme:?} {found:?} {source:?}");
            for (found, source) in found.iter().zip(source) {
                assert!((found / source - 1.0).abs() < 0.01, "{rayleigh} {scheme:?}: {found} {source}");
            }
        }
    }
}

/// A flow of sines between walls and along a periodic axis, on some ranks.
fn stirred(transport: &dyn Transport, ranks: [usize; 3]) -> Flow {
    let grid = crate::common::refined_channel(Axis::uniform(0.0, 1.0, 14, false));
    let partition = partition(&grid, ranks, transport.rank());
    let setup = FlowSetup { partition, ..FlowSetup::new(grid, 1.0, 1e-3) };
    let mut flow = Flow::new(setup, transport).unwrap();
    let wave = |x: f64| (2.0 * PI * x).sin();
    flow.initialise(
        |[x, y, z]| {
            let s = (PI * z).sin();
            [wave(y) * s, wave(x + 0.3 * y) * (PI * y).sin() * s, wave(x) * wave(y) * s]
        },
        |_| 0.0,
        transport,
    );
    flow
}

/// A block of a tracer, 2 in it and −1 about it.
fn block([x, y, z]: [f64; 3]) -> f64 {
    if (0.2..0.5).contains(&x) && (0.3..0.8).contains(&y) && (0.1..0.6).contains(&z) { 2.0 } else { -1.0 }
}

fn tracer(flow: &Flow) -> &Field<Centre> {
    &flow.scalars.as_ref().unwrap().all[0].value
}

fn range(field: &Field<Centre>) -> [f64; 2] {
    field.own().fold([f64::MAX, f64::MIN], |[low, high], x| [low.min(x), high.max(x)])
}

/// Content, and what has entered and been produced, of the first scalar.
fn ledger(flow: &Flow, transport: &dyn Transport) -> [f64; 2] {
    let scalars = flow.scalars.as_ref().unwrap();
    let mut sums = [scalars.content(0), scalars.all[0].entered + scalars.all[0].produced];
    transport.sum(&mut sums);
    sums
}

#[test]
fn limits_and_contents_are_kept_at_any_diffusivity_and_on_any_ranks() {
    for diffusivity in [1e-9, 1e-3, 1.0, 1e3] {
        let run = |ranks: [usize; 3]| {
            let pieces = on_ranks(ranks.iter().product(), |transport| {
                let mut flow = stirred(&transport, ranks);
                flow.add_scalar(insulated(diffusivity, Scheme::Bounded), block, &transport);
                let [before, _] = ledger(&flow, &transport);
                for step in 0..12 {
                    flow.step([0.03, 0.01][step % 2], &transport).unwrap();
                    let [after, entered] = ledger(&flow, &transport);
                    assert!((after - before).abs() < 1e-13, "{diffusivity}: {before} {after}");
                    assert_eq!(entered, 0.0);
                    let [low, high] = range(tracer(&flow));
                    assert!(low >= -1.0 - 1e-12 && high <= 2.0 + 1e-12, "{diffusivity} {step}: {low} {high}");
                }
                piece(tracer(&flow).data(), flow.layout(), flow.first_cell())
            });
            joined(pieces)
        };
        let alone = run([1; 3]);
        assert!(
            diffusivity > 0.5 || alone.iter().fold(0.0, |m: f64, x| m.max(*x)) > 0.5,
            "something is left"
        );
        for ranks in [[2, 1, 1], [1, 2, 2], [3, 2, 1]] {
            // Rounding grows with the diffusion number.
            let apart = difference(&alone, &run(ranks));
            assert!(apart < 1e-12 * (1.0 + 1e3 * diffusivity), "{diffusivity} {ranks:?} {apart}");
        }
    }
}

/// A wave that drifts through a periodic square and decays: largest error on n² cells after as many steps as cells.
fn drifting(n: usize, scheme: Scheme) -> f64 {
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [n, n, 1], [true; 3]).unwrap();
    let mut flow = Flow::new(FlowSetup::new(grid, 1.0, 1e-3), &SERIAL).unwrap();
    let (u, v, diffusivity) = (0.4, 0.3, 2e-3);
    flow.initialise(|_| [u, v, 0.0], |_| 0.0, &SERIAL);
    let exact = |[x, y, _]: [f64; 3], t: f64| {
        let decay = (-8.0 * PI * PI * diffusivity * t).exp();
        decay * (2.0 * PI * (x - u * t)).sin() * (2.0 * PI * (y - v * t)).cos()
    };
    flow.add_scalar(insulated(diffusivity, scheme), |x| exact(x, 0.0), &SERIAL);
    for _ in 0..n {
        flow.step(1.0 / n as f64, &SERIAL).unwrap();
    }
    let at = |k: isize| (k as f64 + 0.5) / n as f64;
    let error = |i: isize, j: isize| (tracer(&flow).at(i, j, 0) - exact([at(i), at(j), 0.0], 1.0)).powi(2);
    let n = n as isize;
    ((0..n * n).map(|k| error(k % n, k / n)).sum::<f64>() / (n * n) as f64).sqrt()
}

#[test]
fn smooth_waves_converge_with_order_two() {
    for (scheme, wanted) in [(Scheme::Central, 1.9), (Scheme::Bounded, 1.7)] {
        let errors = [16, 32, 64].map(|n| drifting(n, scheme));
        let found = order(errors[1], errors[2], 2.0);
        println!("{scheme:?} {errors:?} {found}");
        assert!(found > wanted, "{scheme:?}: {found} {errors:?}");
    }
}

#[test]
fn what_is_uniform_stays_so_among_particles_that_come_and_go() {
    let mut fields = Vec::new();
    for ranks in [[1; 3], [2, 2, 1]] {
        let results = on_ranks(ranks.iter().product(), |transport| {
            let grid = Grid::uniform([0.0; 3], [1.0, 1.0, 1.5], [8, 9, 12], [true, false, false]).unwrap();
            let mut boundaries = Boundaries::default();
            boundaries.faces[4] = Condition::Inlet { profile: Profile::Uniform([0.0, 0.0, 0.7]) };
            boundaries.faces[5] = Condition::Outlet { pressure: 0.0 };
            let partition = partition(&grid, ranks, transport.rank());
            let mixture = Some(MixtureModel::A);
            let setup = FlowSetup { partition, boundaries, mixture, ..FlowSetup::new(grid, 1.0, 1e-2) };
            let mut flow = Flow::new(setup, &transport).unwrap();
            let mut setup = insulated(1e-3, Scheme::Bounded);
            setup.boundaries.faces[4] = value(3.0);
            flow.add_scalar(setup.clone(), |_| 3.0, &transport);
            flow.add_scalar(setup, |x| 3.0 + block(x), &transport);
            let ledger = |flow: &Flow| {
                let scalars = flow.scalars.as_ref().unwrap();
                let mut sums = [scalars.content(1), scalars.all[1].entered];
                transport.sum(&mut sums);
                sums[0] - sums[1]
            };
            let mut before = 0.0;
            for step in 0..20 {
                let first = flow.first_cell();
                let cloud = |[i, j, k]: [usize; 3]| {
                    let phase = 0.3 * step as f64;
                    0.7 + 0.25
                        * (0.8 * i as f64 + phase).sin()
                        * (0.9 * j as f64).cos()
                        * (0.7 * k as f64 - phase).sin()
                };
                set(&mut flow.mixture.as_mut().unwrap().void_fraction, first, cloud);
                if step == 0 {
                    flow.mixture.as_mut().unwrap().begin();
                }
                flow.step(0.02, &transport).unwrap();
                let [low, high] = range(tracer(&flow));
                assert!(low > 3.0 - 1e-12 && high < 3.0 + 1e-12, "{low} {high}");
                let [low, high] = range(&flow.scalars.as_ref().unwrap().all[1].value);
                assert!(low > 2.0 - 1e-12 && high < 5.0 + 1e-12, "{low} {high}");
                // The first particles are there from the beginning.
                before = if step == 0 { ledger(&flow) } else { before };
                let drift = ledger(&flow) - before;
                assert!(drift.abs() < 1e-12, "{step}: {drift}");
            }
            piece(flow.scalars.as_ref().unwrap().all[1].value.data(), flow.layout(), flow.first_cell())
        });
        fields.push(joined(results));
    }
    assert!(difference(&fields[0], &fields[1]) < 1e-9, "{}", difference(&fields[0], &fields[1]));
}

/// Plug of Poiseuille's flow between plates of one temperature: the Nusselt number far from the inlet, of the hydraulic diameter.
#[test]
fn the_nusselt_number_between_plates_is_that_of_graetz() {
    let (n, height) = (24, 1.0);
    let grid = Grid::uniform([0.0; 3], [6.0, height, 1.0], [60, n, 1], [false, false, true]).unwrap();
    let mut boundaries = Boundaries::default();
    boundaries.faces[0] = Condition::Inlet { profile: Profile::Parabolic { mean: 1.0 } };
    boundaries.faces[1] = Condition::Outlet { pressure: 0.0 };
    let mut flow = Flow::new(FlowSetup { boundaries, ..FlowSetup::new(grid, 1.0, 1.0) }, &SERIAL).unwrap();
    flow.initialise(|[_, y, _]| [6.0 * y * (1.0 - y), 0.0, 0.0], |[x, ..]| 12.0 * (6.0 - x), &SERIAL);
    let diffusivity = 0.05;
    let mut setup = insulated(diffusivity, Scheme::Bounded);
    setup.boundaries.faces[0] = value(1.0);
    setup.boundaries.faces[2] = value(0.0);
    setup.boundaries.faces[3] = value(0.0);
    flow.add_scalar(setup, |_| 0.0, &SERIAL);
    for _ in 0..400 {
        flow.step(0.03, &SERIAL).unwrap();
    }
    let field = tracer(&flow);
    let nusselt = |i: isize| {
        let u = |j: isize| 0.5 * (flow.state.velocity.x.at(i, j, 0) + flow.state.velocity.x.at(i - 1, j, 0));
        let cup: f64 = (0..n as isize).map(|j| u(j) * field.at(i, j, 0)).sum::<f64>()
            / (0..n as isize).map(u).sum::<f64>();
        let h = height / n as f64;
        0.5 * (field.at(i, 0, 0) + field.at(i, n as isize - 1, 0)) / (0.5 * h) / cup * 2.0 * height
    };
    let found = nusselt(50);
    println!("{} {} {found}", nusselt(20), nusselt(40));
    assert!((found / 7.5407 - 1.0).abs() < 0.01, "{found}");
}

/// Diffusivity of what flows through a pipe at a mean velocity of 1 and with a diameter of 1: a Péclet number of 25.
const DIFFUSIVITY: f64 = 0.04;

/// A pipe of radius 0.5 along x whose wall cuts the cells of an averaged flow: one scalar with a value on the wall, one with a flux through
/// it, one that nothing passes.
fn pipe(n: usize) -> Flow {
    let lengths = [5.0, 1.13, 1.13];
    let cells = [2 * n, n, n];
    let grid = Grid::uniform([0.0; 3], lengths, cells, [false; 3]).unwrap();
    let mut boundaries = Boundaries::default();
    let square = |[_, y, z]: [f64; 3]| 4.0 * ((y - 0.553).powi(2) + (z - 0.571).powi(2));
    let profile = move |at: [f64; 3], _: f64| [2.0 * (1.0 - square(at)).max(0.0), 0.0, 0.0];
    boundaries.faces[0] = Condition::Inlet { profile: Profile::Function(Arc::new(profile)) };
    boundaries.faces[1] = Condition::Outlet { pressure: 0.0 };
    let setup = FlowSetup { boundaries, mixture: Some(MixtureModel::A), ..FlowSetup::new(grid, 1.0, 0.1) };
    let mut flow = Flow::new(setup, &SERIAL).unwrap();
    let wall = move |at: [f64; 3]| {
        let r = 0.5 * square(at).sqrt().max(1e-9);
        Clearance { distance: 0.5 - r, direction: [0.0, (0.553 - at[1]) / r, (0.571 - at[2]) / r], wall: 0 }
    };
    flow.initialise(move |at| profile(at, 0.0), |[x, ..]| 3.2 * (5.0 - x), &SERIAL);
    let conditions = [
        SolidCondition::Value(ScalarValue::Uniform(0.0)),
        SolidCondition::Flux(ScalarValue::Uniform(DIFFUSIVITY)),
        SolidCondition::default(),
    ];
    for condition in conditions {
        let mut setup = insulated(DIFFUSIVITY, Scheme::Bounded);
        setup.boundaries.faces[0] = value(1.0);
        setup.solids.walls = vec![condition];
        flow.add_scalar(setup, |_| 1.0, &SERIAL);
    }
    flow.enclose(&wall, &SERIAL).unwrap();
    flow.begin_scalars(|_| true);
    flow
}

#[test]
fn in_a_pipe_that_cuts_the_cells_heat_passes_as_by_graetz() {
    for n in [12, 18] {
        let mut flow = pipe(n);
        let dt = 0.3 * 5.0 / (2 * n) as f64;
        for _ in 0..(12.0 / dt) as usize {
            flow.step(dt, &SERIAL).unwrap();
        }
        let scalars = flow.scalars.as_ref().unwrap();
        for number in 0..3 {
            let lost = scalars.content(number) - scalars.all[number].entered - scalars.all[number].produced;
            assert!(lost.abs() < 1e-10, "{n} {number}: {lost}");
        }
        let [low, high] = range(&scalars.all[2].value);
        assert!(low > 1.0 - 1e-9 && high < 1.0 + 1e-9, "what is insulated stays uniform: {low} {high}");
        let open = flow.mixture.as_ref().unwrap().open_faces();
        // Of a section: mixed by the flow.
        let section = |i: isize| {
            let value = &scalars.all[0].value;
            let (mut flux, mut carried) = (0.0, 0.0);
            for (j, k) in (0..n as isize).flat_map(|k| (0..n as isize).map(move |j| (j, k))) {
                let through = open.x.at(i, j, k) * flow.state.velocity.x.at(i, j, k);
                flux += through;
                carried += through * 0.5 * (value.at(i, j, k) + value.at(i + 1, j, k));
            }
            [flux, carried / flux]
        };
        let (h, [here, there]) = (5.0 / (2 * n) as f64, [n as isize, 3 * n as isize / 2]);
        let ([flux, first], [_, last]) = (section(here), section(there));
        let flux = flux * (1.13 / n as f64).powi(2);
        // u A dT/dx = −Nu D π T, less what is conducted along the pipe.
        let slope = (first / last).ln() / ((there - here) as f64 * h);
        let conducted = DIFFUSIVITY * 0.25 * PI * slope;
        let nusselt = (flux + conducted) * slope / (DIFFUSIVITY * PI);
        // φ − φ_axis = q R/D (η² − η⁴/4), η = r/R.
        let square = |j: isize, k: isize| {
            let at = |i: isize| (i as f64 + 0.5) * 1.13 / n as f64;
            4.0 * ((at(j) - 0.553).powi(2) + (at(k) - 0.571).powi(2))
        };
        let rise = |j: isize, k: isize| 0.5 * (square(j, k) - 0.25 * square(j, k).powi(2));
        let value = |j: isize, k: isize| scalars.all[1].value.at(there, j, k);
        let m = n as isize / 2;
        let inside = (0..n as isize).flat_map(|k| (0..n as isize).map(move |j| (j, k)));
        let inside = inside.filter(|&(j, k)| square(j, k) < 1.0);
        let (mut sum, mut count) = (0.0, 0.0);
        for (j, k) in inside {
            sum += (value(j, k) - value(m, m) - rise(j, k) + rise(m, m)).abs();
            count += 1.0;
        }
        // Single cells beside the wall are off by more.
        let error = sum / count / 0.375;
        let area = scalars.all[1].gained[0] / scalars.all[1].gained_over / DIFFUSIVITY / (PI * 5.0);
        // At this Péclet number (Shah & London 1978).
        let wanted = 3.657 * (1.0 + 1.227 / 625.0);
        println!("{n}: flux {flux}, Nusselt {nusselt} of {wanted}, profile off by {error}, area {area}");
        assert!((nusselt / wanted - 1.0).abs() < if n == 12 { 0.015 } else { 0.01 }, "{n}: {nusselt}");
        assert!(error < 0.015 && (area - 1.0).abs() < 5e-3, "{n}: {error} {area}");
    }
}

/// Sources and exchange of any strength, in a closed box that is stirred: between what is there and what they lead to, and accounted for.
#[test]
fn exchange_of_any_strength_overshoots_nothing_and_is_accounted_for() {
    for (ranks, strongest) in [([1; 3], 1e-3), ([2, 1, 2], 10.0), ([1, 2, 1], 1e9)] {
        on_ranks(ranks.iter().product(), |transport| {
            let mut flow = stirred(&transport, ranks);
            flow.add_scalar(insulated(1e-3, Scheme::Bounded), block, &transport);
            flow.begin_scalars(|_| true);
            let first = flow.first_cell();
            let (mut source, mut exchange) = (Field::new(flow.layout()), Field::new(flow.layout()));
            let strength =
                |[i, j, k]: [usize; 3]| strongest * f64::from((7 * i + 3 * j + 5 * k) as u32 % 11) / 10.0;
            // Towards values from 3 to 5.
            let wanted = |[i, j, k]: [usize; 3]| 3.0 + 2.0 * f64::from((i + 2 * j + 3 * k) as u32 % 5) / 4.0;
            set(&mut exchange, first, strength);
            set(&mut source, first, |cell| strength(cell) * wanted(cell));
            for step in 0..8 {
                let scalar = &mut flow.scalars.as_mut().unwrap().all[0];
                (scalar.source, scalar.exchange) = (Some(source.clone()), Some(exchange.clone()));
                flow.step(0.02, &transport).unwrap();
                let [low, high] = range(tracer(&flow));
                assert!(low >= -1.0 - 1e-12 && high <= 5.0 + 1e-12, "{strongest} {step}: {low} {high}");
                let [content, brought] = ledger(&flow, &transport);
                // What is given and taken is much more than what remains: its rounding shows.
                let rounding = 1e-12 + 1e-17 * strongest;
                assert!((content - brought).abs() < rounding, "{strongest} {step}: {content} {brought}");
            }
            let scalar = &flow.scalars.as_ref().unwrap().all[0];
            assert!(strongest < 1.0 || scalar.produced > 0.1, "{}", scalar.produced);
        });
    }
}

/// A uniform fluid that is lighter than its reference, between an inlet and an outlet: its weight is lacking in the pressure, up to the
/// outlet itself, and it flows as without.
#[test]
fn buoyancy_of_a_uniform_fluid_is_borne_by_the_pressure_up_to_the_outlet() {
    for axis in 0..3 {
        for mixture in [None, Some(MixtureModel::A)] {
            let (mut cells, mut velocity, mut gravity) = ([5; 3], [0.0; 3], [0.0; 3]);
            (cells[axis], velocity[axis], gravity[axis]) = (9, 0.3, -9.81);
            let grid = Grid::uniform([0.0; 3], [1.0; 3], cells, [false; 3]).unwrap();
            let mut boundaries = Boundaries::all(Condition::Symmetry);
            boundaries.faces[2 * axis] = Condition::Inlet { profile: Profile::Uniform(velocity) };
            boundaries.faces[2 * axis + 1] = Condition::Outlet { pressure: 0.0 };
            let setup = FlowSetup { boundaries, mixture, ..FlowSetup::new(grid, 1.2, 1e-3) };
            let mut flow = Flow::new(setup, &SERIAL).unwrap();
            flow.initialise(|_| velocity, |_| 0.0, &SERIAL);
            let mut setup = insulated(1e-3, Scheme::Bounded);
            setup.boundaries.faces[2 * axis] = value(350.0);
            setup.buoyancy = Some(Buoyancy { expansion: 3e-3, reference: 300.0, gravity });
            flow.add_scalar(setup, |_| 350.0, &SERIAL);
            for _ in 0..20 {
                flow.step(0.02, &SERIAL).unwrap();
            }
            let acceleration = 3e-3 * 50.0 * 9.81;
            for cell in 0..9 {
                let exact = -1.2 * acceleration * (1.0 - (cell as f64 + 0.5) / 9.0);
                let found = flow.mean_pressure(axis, cell, &SERIAL);
                assert!(
                    (found - exact).abs() < 1e-9,
                    "{axis} {mixture:?} {cell}: {found} instead of {exact}"
                );
            }
            assert!((flow.mean_velocity(axis, &SERIAL) - 0.3).abs() < 1e-12);
        }
    }
}
