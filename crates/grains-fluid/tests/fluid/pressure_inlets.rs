//! Inlets of imposed total pressure, fans, and outlets through which fluid comes back.

use grains_domain::SerialTransport as SERIAL;
use grains_fluid::{
    Boundaries, BoxFace, Condition, FanCurve, Flow, FlowSetup, Grid, MixtureModel, Outline, Patch, Profile,
    Side,
};
use std::f64::consts::PI;

const DENSITY: f64 = 1.3;

/// A channel along x, of one cell along z, between walls or slippery sides, with conditions at its ends.
fn channel(cells: [usize; 2], viscosity: f64, sides: &Condition, ends: [Condition; 2]) -> Flow {
    let grid =
        Grid::uniform([0.0; 3], [2.0, 0.5, 0.1], [cells[0], cells[1], 1], [false, false, true]).unwrap();
    let [first, last] = ends;
    let boundaries = Boundaries::default()
        .with(0, Side::Low, first)
        .with(0, Side::High, last)
        .with(1, Side::Low, sides.clone())
        .with(1, Side::High, sides.clone());
    Flow::new(FlowSetup { boundaries, ..FlowSetup::new(grid, DENSITY, viscosity) }, &SERIAL).unwrap()
}

const OUTLET: Condition = Condition::Outlet { pressure: 0.0 };

fn total(pressure: f64) -> Condition {
    Condition::PressureInlet { pressure, fan: None }
}

fn fan(pressure: f64, points: &[[f64; 2]]) -> Condition {
    Condition::PressureInlet { pressure, fan: Some(FanCurve::new(points.to_vec()).unwrap()) }
}

/// Without friction dU/dt = (p₀/ρ − U²/2)/L: U = U∞ tanh(U∞ t/(2 L)), U∞² = 2 p₀/ρ.
#[test]
fn bernoullis_flow_starts_as_it_should() {
    let ends = [[total(0.8), OUTLET], [OUTLET, total(0.8)]];
    for (number, ends) in ends.into_iter().enumerate() {
        let speed = (2.0 * 0.8 / DENSITY).sqrt();
        let error = |dt: f64| {
            let mut flow = channel([16, 4], 1e-6, &Condition::Symmetry, ends.clone());
            let mut largest = 0.0_f64;
            while flow.state.time < 6.0 {
                flow.step(dt, &SERIAL).unwrap();
                let exact = speed * (0.25 * speed * flow.state.time).tanh();
                let found = flow.mean_velocity(0, &SERIAL) * if number == 0 { 1.0 } else { -1.0 };
                largest = largest.max((found - exact).abs() / speed);
            }
            largest
        };
        let [coarse, fine] = [0.04, 0.02].map(error);
        assert!(coarse < 0.02 && fine < 0.6 * coarse, "{number}: {coarse:.2e}, {fine:.2e}");
    }
}

/// What the sum of a parabola over the middles of ten cells is more than its integral.
const OF_CELLS: f64 = 1.005;

/// Poiseuille: Q = h³ w Δp/(12 μ L), at a small Reynolds number, also in steps in which momentum diffuses over many cells.
#[test]
fn a_duct_gets_the_flow_of_its_resistance() {
    let viscosity = 2.0;
    for dt in [0.01, 0.05] {
        let mut flow = channel([12, 10], viscosity, &Condition::WALL, [total(0.3), OUTLET]);
        (0..500).for_each(|_| {
            let _ = flow.step(dt, &SERIAL).unwrap();
        });
        let exact = OF_CELLS * 0.5_f64.powi(3) * 0.1 * 0.3 / (12.0 * viscosity * 2.0);
        let found = flow.flow_rate(0, 6, &SERIAL);
        assert!((found / exact - 1.0).abs() < 1e-3, "{dt}: {found:.6e} for {exact:.6e}");
    }
}

/// The operating point is where the curve meets the line of the duct, however steep the curve and long the step.
#[test]
fn a_fan_finds_its_operating_point() {
    let viscosity = 2.0;
    let resistance = 12.0 / OF_CELLS * viscosity * 2.0 / (0.5_f64.powi(3) * 0.1);
    // The duct's flow at 1 Pa is 2.6e-4 m³/s.
    let curves: [&[[f64; 2]]; 3] = [
        &[[0.0, 1.0], [5e-4, 0.0]],
        &[[0.0, 40.0], [1.0e-4, 39.0], [1.1e-4, 0.0]],
        &[[-1e-3, 0.9], [1e-3, 0.7]],
    ];
    for (points, before) in curves.into_iter().zip([0.0, 0.1, 0.2]) {
        for dt in [0.005, 0.02] {
            let mut flow = channel([12, 10], viscosity, &Condition::WALL, [fan(before, points), OUTLET]);
            (0..500).for_each(|_| {
                let _ = flow.step(dt, &SERIAL).unwrap();
            });
            let (found, rise) = (flow.flow_rate(0, 0, &SERIAL), flow.state.fans[0]);
            let curve = FanCurve::new(points.to_vec()).unwrap();
            assert!((rise - curve.rise(found)).abs() < 1e-9 * rise.abs().max(1.0), "{rise} off the curve");
            let of_duct = resistance * found - before;
            assert!((of_duct / rise - 1.0).abs() < 1e-3, "{points:?} {dt}: {of_duct} and {rise} at {found}");
        }
    }
}

/// Two equal fans side by side are one of twice the flow; among particles too, and beside a steep one.
#[test]
fn fans_side_by_side_share_the_flow() {
    for mixture in [None, Some(MixtureModel::A), Some(MixtureModel::B)] {
        let run = |patches: Vec<Patch>, whole: Option<Condition>| {
            let grid = Grid::uniform([0.0; 3], [1.0; 3], [6, 6, 8], [false; 3]).unwrap();
            let mut boundaries = Boundaries { patches, ..Boundaries::all(Condition::Symmetry) };
            boundaries.faces[1] = OUTLET;
            if let Some(whole) = whole {
                boundaries.faces[0] = whole;
            }
            let mut flow =
                Flow::new(FlowSetup { boundaries, mixture, ..FlowSetup::new(grid, 1.0, 0.5) }, &SERIAL)
                    .unwrap();
            for _ in 0..60 {
                if let Some(mixture) = &mut flow.mixture {
                    mixture.void_fraction.fill(0.6);
                    mixture.drag.x.fill(3.0);
                    if flow.state.step == 0 {
                        mixture.begin();
                    }
                }
                flow.step(0.05, &SERIAL).unwrap();
            }
            (flow.flow_rate(0, 0, &SERIAL), flow.state.fans.clone())
        };
        let (whole, rises) = run(vec![], Some(fan(0.0, &[[0.0, 2.0], [1.0, 0.0]])));
        let half = |low: f64| Patch {
            face: BoxFace { axis: 0, side: Side::Low },
            outline: Outline::Rectangle { lower: [0.0, low, 0.0], upper: [0.0, low + 0.5, 1.0] },
            condition: fan(0.0, &[[0.0, 2.0], [0.5, 0.0]]),
        };
        let (both, halves) = run(vec![half(0.0), half(0.5)], None);
        assert!(whole > 0.1, "{whole}");
        assert!((both / whole - 1.0).abs() < 1e-6, "{mixture:?}: {both} for {whole}");
        halves.iter().for_each(|rise| assert!((rise / rises[0] - 1.0).abs() < 1e-6, "{rise}, {rises:?}"));
    }
}

/// A vortex ten times as fast as the flow leaves through an outlet, half of it coming back in: the energy never grows, and
/// what enters leaves.
#[test]
fn a_vortex_leaves_through_an_outlet() {
    for mixture in [None, Some(MixtureModel::A)] {
        let speed = 0.1;
        let n = 32;
        let grid = Grid::uniform([0.0; 3], [1.5, 1.0, 0.1], [48, n, 1], [false, false, true]).unwrap();
        let inlet = Condition::Inlet { profile: Profile::Uniform([speed, 0.0, 0.0]) };
        let boundaries =
            Boundaries::all(Condition::Symmetry).with(0, Side::Low, inlet).with(0, Side::High, OUTLET);
        let setup = FlowSetup { boundaries, mixture, ..FlowSetup::new(grid, 1.0, 1e-4) };
        let mut flow = Flow::new(setup, &SERIAL).unwrap();
        let spin = |x: f64, y: f64| {
            let [x, y] = [x - 1.2, y - 0.5];
            let r = (x * x + y * y).sqrt() / 0.25;
            if r < 1.0 { 8.0 * (1.0 + (PI * r).cos()) * 0.5 } else { 0.0 }
        };
        flow.initialise(
            |[x, y, _]| [speed - spin(x, y) * (y - 0.5), spin(x, y) * (x - 1.2), 0.0],
            |_| 0.0,
            &SERIAL,
        );
        let begin = flow.kinetic_energy(&SERIAL);
        let (mut largest_share, mut before) = (0.0_f64, begin);
        while flow.state.time < 12.0 {
            let rate = 1.0 / flow.cfl_number(1.0, &SERIAL);
            flow.step((0.3 * rate).min(0.02), &SERIAL).unwrap();
            let energy = flow.kinetic_energy(&SERIAL);
            // What the inlet brings and its pressure does is small beside the vortex.
            assert!(energy < before + 1e-3 * begin, "{} s: {energy} after {before}", flow.state.time);
            before = energy;
            let [entering, leaving] = flow.outlet_flows(&SERIAL);
            assert!((leaving - entering - speed * 0.1).abs() < 1e-10, "{entering} in, {leaving} out");
            largest_share = largest_share.max(entering / (entering + leaving));
        }
        assert!(largest_share > 0.1, "it must come back: {largest_share}");
        let still = 0.5 * speed * speed * 0.15;
        assert!(before < 3.0 * still, "{before}, the flow alone {still}, at the beginning {begin}");
    }
}
