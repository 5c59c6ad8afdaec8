//! What flows through inlets on patches is their velocity times their area, wherever their edges lie among the cells.

use grains_domain::SerialTransport as SERIAL;
use grains_fluid::{Axis, Boundaries, BoxFace, Condition, Flow, FlowSetup, Grid, Patch, Profile, Side};
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
    Patch { face, lower, upper, condition }
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
            0 | 1 => Profile::Uniform(velocity),
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
