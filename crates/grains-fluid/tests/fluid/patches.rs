//! What flows through inlets on patches is their velocity times their area, wherever their edges lie among the cells.

use grains_domain::SerialTransport as SERIAL;
use grains_fluid::{
    Axis, Boundaries, BoxFace, Condition, Flow, FlowSetup, Grid, Outline, Patch, Profile, Side,
};
use std::sync::Arc;

/// Random numbers in [0, 1), the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / 2.0_f64.powi(53)
    }

    /// Two ends within [0, 1], at least a length apart.
    fn ends(&mut self, apart: f64) -> [f64; 2] {
        loop {
            let [a, b] = [self.next(), self.next()];
            if (b - a).abs() > apart {
                return [a.min(b), a.max(b)];
            }
        }
    }
}

/// A box of 1 m with an outlet opposite of the face with the patches; the flow rate (m³/s) that comes in at first and after a
/// few steps.
fn inflow(axis: usize, side: Side, is_stretched: bool, patches: Vec<Patch>) -> [f64; 2] {
    let line = |n: usize| match is_stretched {
        true => Axis::clustered(0.0, 1.0, n, 1.5),
        false => Axis::uniform(0.0, 1.0, n, false),
    };
    let grid = Grid::new([line(11), line(13), line(10)]).unwrap();
    let opposite = if side == Side::Low { Side::High } else { Side::Low };
    let mut boundaries = Boundaries::default();
    boundaries.faces[BoxFace { axis, side: opposite }.index()] = Condition::Outlet { pressure: 0.0 };
    boundaries.patches = patches;
    let mut flow = Flow::new(FlowSetup { boundaries, ..FlowSetup::new(grid, 1.0, 0.01) }, &SERIAL).unwrap();
    let last = flow.setup.grid.cells()[axis];
    let node = if side == Side::Low { 0 } else { last };
    let sign = if side == Side::Low { 1.0 } else { -1.0 };
    let first = sign * flow.flow_rate(axis, node, &SERIAL);
    for _ in 0..3 {
        flow.step(1e-3, &SERIAL).unwrap();
    }
    [first, sign * flow.flow_rate(axis, last - node, &SERIAL)]
}

fn patch(face: BoxFace, [a, b]: [[f64; 2]; 2], condition: Condition) -> Patch {
    let (mut lower, mut upper) = ([0.0; 3], [1.0; 3]);
    let tangents = [[1, 2], [0, 2], [0, 1]][face.axis];
    for (t, [begin, end]) in tangents.into_iter().zip([a, b]) {
        (lower[t], upper[t]) = (begin, end);
    }
    Patch { face, outline: Outline::Rectangle { lower, upper }, condition }
}

#[test]
fn the_flow_rate_of_a_patch_is_that_of_its_area() {
    let mut random = Random(11);
    for trial in 0..60 {
        let (axis, side) = (trial % 3, if trial % 2 == 0 { Side::Low } else { Side::High });
        let ends = [random.ends(0.2), random.ends(0.2)];
        let area: f64 = ends.iter().map(|[a, b]| b - a).product();
        let speed = 0.5 + random.next();
        let mut velocity = [0.0; 3];
        velocity[axis] = if side == Side::Low { speed } else { -speed };
        let profile = match trial % 4 {
            0 => Profile::Uniform(velocity),
            1 => Profile::SteadyFunction(Arc::new(move |_| velocity)),
            2 => Profile::Parabolic { mean: speed },
            _ => Profile::Function(Arc::new(move |_, _| velocity)),
        };
        let name = format!("{trial}: {profile:?} over {ends:?}");
        let inlet = patch(BoxFace { axis, side }, ends, Condition::Inlet { profile });
        for rate in inflow(axis, side, trial % 5 == 0, vec![inlet]) {
            assert!((rate / (speed * area) - 1.0).abs() < 1e-9, "{name}: {rate} for {}", speed * area);
        }
    }
}

#[test]
fn of_patches_that_overlap_the_last_counts() {
    let mut random = Random(5);
    for trial in 0..40 {
        let face = BoxFace { axis: 0, side: Side::Low };
        let [a, b] = [[random.ends(0.3), random.ends(0.3)], [random.ends(0.3), random.ends(0.3)]];
        let overlap = |k: usize| (a[k][1].min(b[k][1]) - a[k][0].max(b[k][0])).max(0.0);
        let area = |e: &[[f64; 2]; 2]| e.iter().map(|[lower, upper]| upper - lower).product::<f64>();
        let inlet = |speed: f64| Condition::Inlet { profile: Profile::Uniform([speed, 0.0, 0.0]) };
        let below = area(&a) - overlap(0) * overlap(1);
        // A second inlet, or a wall that covers a part of the first.
        let (second, wanted) = match trial % 2 {
            0 => (inlet(0.4), below + 0.4 * area(&b)),
            _ => (Condition::WALL, below),
        };
        let patches = vec![patch(face, a, inlet(1.0)), patch(face, b, second)];
        for rate in inflow(0, Side::Low, trial % 3 == 0, patches) {
            assert!((rate - wanted).abs() < 1e-9, "{trial}: {rate} for {wanted}");
        }
    }
}

#[test]
fn patches_narrower_than_cells_let_in_the_flow_of_their_area() {
    let mut random = Random(7);
    for trial in 0..40 {
        let face = BoxFace { axis: trial % 3, side: Side::Low };
        let begin = [0.98 * random.next(), 0.98 * random.next()];
        let ends = begin.map(|begin| [begin, begin + 0.005 + 0.015 * random.next()]);
        let area: f64 = ends.iter().map(|[a, b]| b - a).product();
        let mut velocity = [0.0; 3];
        velocity[face.axis] = 1.0;
        let profile = match trial % 3 {
            0 => Profile::Uniform(velocity),
            1 => Profile::Parabolic { mean: 1.0 },
            // It begins to flow in the first step.
            _ => Profile::Function(Arc::new(move |_, time| if time > 0.0 { velocity } else { [0.0; 3] })),
        };
        let name = format!("{trial}: {profile:?} over {ends:?}");
        let inlet = patch(face, ends, Condition::Inlet { profile });
        let [first, last] = inflow(face.axis, Side::Low, trial % 2 == 0, vec![inlet]);
        assert!((last / area - 1.0).abs() < 1e-9, "{name}: {last} for {area}");
        assert!(trial % 3 == 2 || (first / area - 1.0).abs() < 1e-9, "{name}: {first} for {area}");
    }
}

#[test]
fn the_flow_rate_of_a_formula_is_of_second_order() {
    let profile = |[_, y, z]: [f64; 3], _| [(3.0 * y).sin() * (1.0 + z * z), 0.0, 0.0];
    let ends = [[0.137, 0.731], [0.211, 0.803]];
    let exact = ((3.0 * 0.137_f64).cos() - (3.0 * 0.731_f64).cos()) / 3.0
        * (0.803 - 0.211 + (0.803_f64.powi(3) - 0.211_f64.powi(3)) / 3.0);
    let error = |n: usize| {
        let face = BoxFace { axis: 0, side: Side::Low };
        let profile = Profile::Function(Arc::new(profile));
        let boundaries = Boundaries::default()
            .with(0, Side::High, Condition::Outlet { pressure: 0.0 })
            .with_patch(patch(face, ends, Condition::Inlet { profile }));
        let grid = Grid::uniform([0.0; 3], [1.0; 3], [4, n, n], [false; 3]).unwrap();
        let flow = Flow::new(FlowSetup { boundaries, ..FlowSetup::new(grid, 1.0, 0.01) }, &SERIAL).unwrap();
        (flow.flow_rate(0, 0, &SERIAL) / exact - 1.0).abs()
    };
    // How the edges cut the cells changes from grid to grid: the bound is that of whole cells.
    for n in [8, 16, 32, 64] {
        let bound = 9.0 / 24.0 / (n * n) as f64;
        assert!(error(n) < bound, "{n} cells: {:.2e}, not below {bound:.2e}", error(n));
    }
}

/// The same bits come of a function of place alone, which is looked at once, and of the same as one of time, in every step: through
/// patches, and along a lid.
#[test]
fn a_function_of_place_alone_is_one_of_time() {
    let profile = |[x, y, z]: [f64; 3]| [(3.0 * y).sin() * (1.0 + z * z), 0.3 * x * z, 0.2 - 0.1 * y];
    let run = |make: &dyn Fn() -> Profile| {
        let inlet = || Condition::Inlet { profile: make() };
        let face = BoxFace { axis: 0, side: Side::Low };
        let boundaries = Boundaries::default()
            .with(0, Side::High, Condition::Outlet { pressure: 0.0 })
            .with(1, Side::High, Condition::Inlet { profile: Profile::Uniform([0.1, 0.0, 0.0]) })
            .with_patch(patch(face, [[0.137, 0.731], [0.211, 0.803]], inlet()))
            .with_patch(patch(BoxFace { axis: 2, side: Side::High }, [[0.2, 0.7], [0.1, 0.66]], inlet()));
        let grid = Grid::uniform([0.0; 3], [1.0; 3], [9, 8, 7], [false; 3]).unwrap();
        let mut flow =
            Flow::new(FlowSetup { boundaries, ..FlowSetup::new(grid, 1.0, 0.01) }, &SERIAL).unwrap();
        for step in 0..6 {
            flow.step(0.01 + 0.002 * f64::from(step), &SERIAL).unwrap();
        }
        flow.state
    };
    let steady = run(&|| Profile::SteadyFunction(Arc::new(profile)));
    assert_eq!(steady, run(&|| Profile::Function(Arc::new(move |at, _| profile(at)))));
    assert!(steady.velocity.z.own().any(|w| w.abs() > 0.01));
}

/// The flow through a patch of a face that is periodic along y, all moved by some cells along y, and moved back.
fn shifted(condition: &Condition, [begin, end]: [f64; 2], shift: usize) -> Vec<f64> {
    let cells = [6, 10, 7];
    let grid = Grid::uniform([0.0; 3], [1.0; 3], cells, [false, true, false]).unwrap();
    let by = shift as f64 / cells[1] as f64;
    let face = BoxFace { axis: 2, side: Side::Low };
    let inlet = patch(face, [[0.13, 0.77], [begin + by, end + by]], condition.clone());
    let boundaries =
        Boundaries::default().with(2, Side::High, Condition::Outlet { pressure: 0.0 }).with_patch(inlet);
    let mut flow = Flow::new(FlowSetup { boundaries, ..FlowSetup::new(grid, 1.0, 0.01) }, &SERIAL).unwrap();
    for _ in 0..5 {
        flow.step(0.01, &SERIAL).unwrap();
    }
    let mut values = Vec::new();
    for field in flow.state.velocity.components().into_iter().chain([flow.state.pressure.data()]) {
        for k in 0..cells[2] {
            for j in 0..cells[1] {
                let row = flow.layout().row((j + shift) % cells[1], k);
                values.extend(&field[row..row + cells[0]]);
            }
        }
    }
    values
}

#[test]
fn a_patch_may_lie_anywhere_in_the_period() {
    let mut random = Random(3);
    let conditions = [
        Condition::Inlet { profile: Profile::Uniform([0.2, 0.3, 1.0]) },
        Condition::Inlet { profile: Profile::Parabolic { mean: 1.0 } },
        Condition::Wall { velocity: [0.4, 0.7, 0.0] },
    ];
    for trial in 0..12 {
        let condition = &conditions[trial % 3];
        // Edges on the lines of the grid too.
        let ends = if trial < 3 { [0.2, 0.5] } else { random.ends(0.2).map(|x| 0.9 * x) };
        let wanted = shifted(condition, ends, 0);
        let size = wanted.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
        assert!(size > 0.01, "the flow must flow: {size}");
        for shift in 1..10 {
            let found = shifted(condition, ends, shift);
            let error = wanted.iter().zip(&found).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
            assert!(
                error < 1e-10 * size,
                "{trial}: {condition:?} over {ends:?} moved by {shift}: {error:.2e}"
            );
        }
    }
}
