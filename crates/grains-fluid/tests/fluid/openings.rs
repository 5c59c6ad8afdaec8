//! Flows averaged over particles, bounded by walls that cut cells.

use crate::common::order;
use grains_domain::SerialTransport;
use grains_fluid::{
    Boundaries, BoxFace, Clearance, Condition, Drive, Enclosure, Flow, FlowSetup, Grid, MixtureModel,
    Profile, Side,
};
use std::f64::consts::PI;

const SERIAL: SerialTransport = SerialTransport;
const VISCOSITY: f64 = 0.1;

/// Inside a tube of a radius (m) along an axis, about a middle (m).
fn tube(axis: usize, middle: [f64; 3], radius: f64) -> impl Fn([f64; 3]) -> Clearance {
    move |at| {
        let off: [f64; 3] = std::array::from_fn(|a| if a == axis { 0.0 } else { at[a] - middle[a] });
        let distance = off.iter().map(|x| x * x).sum::<f64>().sqrt();
        let direction = if distance > 0.0 { off.map(|x| -x / distance) } else { [0.0, 1.0, 0.0] };
        Clearance { distance: radius - distance, direction, wall: 0 }
    }
}

/// Between two planes normal to y, a distance (m) on either side of a middle (m).
fn slot(middle: [f64; 3], half: f64) -> impl Fn([f64; 3]) -> Clearance {
    move |at| {
        let off = at[1] - middle[1];
        Clearance { distance: half - off.abs(), direction: [0.0, -off.signum(), 0.0], wall: 0 }
    }
}

/// Steps until nothing changes by more than a share of the largest.
fn settle(flow: &mut Flow, dt: f64) {
    let mut before = 0.0;
    for _ in 0..2000 {
        flow.step(dt, &SERIAL).unwrap();
        let energy = flow.kinetic_energy(&SERIAL);
        if (energy - before).abs() < 1e-9 * energy {
            return;
        }
        before = energy;
    }
    panic!("no steady state");
}

/// Error of the mean velocity along x of a tube or slot that cuts n² cells, over the exact one.
fn error(n: usize, clearance: &dyn Enclosure, exact: f64, model: MixtureModel) -> f64 {
    let grid = Grid::uniform([0.0; 3], [0.5, 1.0, 1.0], [2, n, n], [true, false, false]).unwrap();
    let mut drive = [Drive::None; 3];
    drive[0] = Drive::PressureGradient(-1.0);
    let setup = FlowSetup { mixture: Some(model), drive, ..FlowSetup::new(grid, 1.0, VISCOSITY) };
    let mut flow = Flow::new(setup, &SERIAL).unwrap();
    flow.enclose(clearance, &SERIAL).unwrap();
    settle(&mut flow, 0.05);
    flow.flow_rate(0, 1, &SERIAL) / exact - 1.0
}

#[test]
fn poiseuille_flow_converges_whatever_cells_the_wall_cuts() {
    let radius = 0.413_f64;
    let in_tube = PI * radius.powi(4) / (8.0 * VISCOSITY);
    for model in [MixtureModel::A, MixtureModel::B] {
        let tube = tube(0, [0.0, 0.507, 0.489], radius);
        let errors = [12, 24, 48].map(|n| error(n, &tube, in_tube, model));
        println!("tube, model {model:?}: {errors:?}");
        assert!(order(errors[0].abs(), errors[2].abs(), 4.0) > 1.8, "{errors:?}");
        assert!(errors[2].abs() < 4e-3, "{errors:?}");
    }
    for half in [0.31, 0.3517] {
        let slot = slot([0.0, 0.4921, 0.5], half);
        let errors = [12, 24, 48].map(|n| slot_error(n, &slot, half));
        println!("slot of {half}: {errors:?}");
        assert!(order(errors[0].abs(), errors[2].abs(), 4.0) > 1.8, "{errors:?}");
        assert!(errors[2].abs() < 4e-3, "{errors:?}");
    }
}

/// The same of a slot in two dimensions, flow along x.
fn slot_error(n: usize, clearance: &dyn Enclosure, half: f64) -> f64 {
    let grid = Grid::uniform([0.0; 3], [0.5, 1.0, 1.0], [2, n, 1], [true, false, false]).unwrap();
    let mut drive = [Drive::None; 3];
    drive[0] = Drive::PressureGradient(-1.0);
    let mut boundaries = Boundaries::default();
    for side in [Side::Low, Side::High] {
        boundaries.faces[BoxFace { axis: 2, side }.index()] = Condition::Symmetry;
    }
    let setup = FlowSetup {
        mixture: Some(MixtureModel::A),
        drive,
        boundaries,
        ..FlowSetup::new(grid, 1.0, VISCOSITY)
    };
    let mut flow = Flow::new(setup, &SERIAL).unwrap();
    flow.enclose(clearance, &SERIAL).unwrap();
    settle(&mut flow, 0.05);
    flow.flow_rate(0, 1, &SERIAL) / (2.0 * half.powi(3) / (3.0 * VISCOSITY)) - 1.0
}

/// Whatever is open, what flows through one section of a tube flows through all, and fills what particles leave.
#[test]
fn as_much_flows_through_every_section_of_a_tube() {
    let n = [10, 11, 16];
    let grid = Grid::uniform([0.0; 3], [1.0, 1.1, 1.6], n, [false; 3]).unwrap();
    let mut boundaries = Boundaries::default();
    let low = BoxFace { axis: 2, side: Side::Low };
    let high = BoxFace { axis: 2, side: Side::High };
    boundaries.faces[low.index()] = Condition::Inlet { profile: Profile::Uniform([0.0, 0.0, 0.7]) };
    boundaries.faces[high.index()] = Condition::Outlet { pressure: 0.0 };
    for model in [MixtureModel::A, MixtureModel::B] {
        let setup = FlowSetup {
            mixture: Some(model),
            boundaries: boundaries.clone(),
            ..FlowSetup::new(grid.clone(), 1.0, 0.01)
        };
        let solver = setup.suitable_solver_to(1e-13, 500, &SERIAL);
        let mut flow = Flow::with_solver(setup, solver, &SERIAL).unwrap();
        flow.enclose(&tube(2, [0.52, 0.55, 0.0], 0.431), &SERIAL).unwrap();
        let open = flow.mixture.as_ref().unwrap().openings.as_ref().unwrap().clone();
        let volume: f64 = open.cells.own().sum::<f64>() * 0.1_f64.powi(3);
        let exact = PI * 0.431_f64.powi(2) * 1.6;
        assert!((volume / exact - 1.0).abs() < 2e-3, "{volume} of {exact}");
        let mut iterations = 0;
        for step in 0..30 {
            let mixture = flow.mixture.as_mut().unwrap();
            for k in 0..n[2] as isize {
                for j in 0..n[1] as isize {
                    for i in 0..n[0] as isize {
                        // Particles that stand still, and a drag.
                        let solid = 0.6 * (0.5 + 0.5 * ((i * 7 + j * 5 + k * 3) % 11) as f64 / 10.0);
                        mixture.void_fraction.set(i, j, k, open.cells.at(i, j, k) * (1.0 - solid));
                    }
                }
            }
            if step == 0 {
                mixture.begin();
            }
            mixture.drag.fill(3.0);
            let report = flow.step(0.02, &SERIAL).unwrap();
            iterations = iterations.max(report.solve.iterations);
            let rates = (0..=n[2]).map(|node| flow.flow_rate(2, node, &SERIAL)).collect::<Vec<_>>();
            for rate in &rates {
                assert!((rate / rates[0] - 1.0).abs() < 1e-10, "{rates:?}");
            }
            let area = 0.7 * PI * 0.431_f64.powi(2);
            assert!((rates[0] / area - 1.0).abs() < 5e-3, "{} for {area}", rates[0]);
            let [divergence, fastest] = flow.divergence(&SERIAL);
            assert!(divergence < 1e-10 * fastest, "{divergence:e} of {fastest}");
        }
        assert!(iterations < 30, "{iterations} iterations for 1e-13 of model {model:?}");
        assert!(flow.state.velocity.z.data().iter().all(|u| u.abs() < 10.0));
    }
}

/// A tube through a point (m) along a unit vector, and its images by `periods` (m).
fn leaning_tube(
    along: [f64; 3],
    middle: [f64; 3],
    periods: [f64; 3],
    radius: f64,
) -> impl Fn([f64; 3]) -> Clearance {
    let image = move |at: [f64; 3], shift: [f64; 3]| {
        let off: [f64; 3] = std::array::from_fn(|a| at[a] - middle[a] - shift[a] * periods[a]);
        let way: f64 = (0..3).map(|a| off[a] * along[a]).sum();
        let across: [f64; 3] = std::array::from_fn(|a| off[a] - way * along[a]);
        let distance = across.iter().map(|x| x * x).sum::<f64>().sqrt();
        let direction = if distance > 0.0 { across.map(|x| -x / distance) } else { [0.0, 1.0, 0.0] };
        Clearance { distance: radius - distance, direction, wall: 0 }
    };
    move |at| {
        let shifts = [-1.0, 0.0, 1.0];
        let all = shifts
            .into_iter()
            .flat_map(|x| shifts.map(|y| [x, y]))
            .flat_map(|[x, y]| shifts.map(|z| [x, y, z]));
        all.map(|shift| image(at, shift)).max_by(|a, b| a.distance.total_cmp(&b.distance)).unwrap()
    }
}

/// A unit vector.
fn unit(along: [f64; 3]) -> [f64; 3] {
    let length = along.iter().map(|x| x * x).sum::<f64>().sqrt();
    along.map(|x| x / length)
}

/// A steady flow hands to the walls what drives it: friction and pressure add up to the force on all the fluid.
#[test]
fn walls_take_the_momentum_of_a_steady_flow() {
    // A tube along the diagonal of a periodic box ends where it begins.
    let grid = Grid::uniform([0.0; 3], [1.0, 0.7, 1.0], [10, 7, 10], [true, false, true]).unwrap();
    let drive = [Drive::PressureGradient(-1.0), Drive::None, Drive::PressureGradient(-0.6)];
    let setup = FlowSetup { mixture: Some(MixtureModel::A), drive, ..FlowSetup::new(grid, 1.0, VISCOSITY) };
    let solver = setup.suitable_solver_to(1e-12, 500, &SERIAL);
    let mut flow = Flow::with_solver(setup, solver, &SERIAL).unwrap();
    let closest = leaning_tube(unit([1.0, 0.0, 1.0]), [0.52, 0.34, 0.5], [1.0, 0.0, 1.0], 0.23);
    flow.enclose(&closest, &SERIAL).unwrap();
    settle(&mut flow, 0.05);
    let open = flow.mixture.as_ref().unwrap().openings.as_ref().unwrap().cells.own().sum::<f64>() * 1e-3;
    let load = flow.loads_on_walls(1, &SERIAL)[0];
    assert!(load[0] > 0.5 * open && load[2] > 0.3 * open, "{load:?}");
    assert!((load[0] / open - 1.0).abs() < 1e-4, "{load:?} N on {open} m³");
    assert!((load[2] / (0.6 * open) - 1.0).abs() < 1e-4, "{load:?} N on {open} m³");
    assert!(load[1].abs() < 1e-4 * open, "{load:?}");
}

/// Error of the flow through a tube that leans against the grid lines of cells of a width (m), in a periodic box.
fn leaning_error(along: [f64; 3], lengths: [f64; 3], width: f64, radius: f64) -> f64 {
    let cells = lengths.map(|length| (length / width).round() as usize);
    let periodic = along.map(|x| x != 0.0);
    let grid = Grid::uniform([0.0; 3], lengths, cells, periodic).unwrap();
    let along = unit(along);
    let drive = along.map(|x| if x == 0.0 { Drive::None } else { Drive::PressureGradient(-x) });
    let setup = FlowSetup { mixture: Some(MixtureModel::A), drive, ..FlowSetup::new(grid, 1.0, VISCOSITY) };
    let mut flow = Flow::new(setup, &SERIAL).unwrap();
    let periods = std::array::from_fn(|a| if periodic[a] { lengths[a] } else { 0.0 });
    let middle = [0.52, 0.487 * lengths[1], 0.5];
    flow.enclose(&leaning_tube(along, middle, periods, radius), &SERIAL).unwrap();
    settle(&mut flow, 0.05);
    flow.flow_rate(0, 1, &SERIAL) / (PI * radius.powi(4) / (8.0 * VISCOSITY)) - 1.0
}

/// In a tube whose axis follows no grid line the error falls with the square of the cells too.
#[test]
fn poiseuille_flow_in_leaning_tubes() {
    for (along, lengths) in [
        ([1.0, 0.0, 1.0], [1.0, 0.7, 1.0]),
        ([2.0, 0.0, 1.0], [2.0, 0.7, 1.0]),
        ([1.0, 1.0, 1.0], [1.0, 1.0, 1.0]),
    ] {
        let errors = [0.1, 0.05].map(|width| leaning_error(along, lengths, width, 0.23));
        println!("tube along {along:?}: {errors:?}");
        assert!(order(errors[0].abs(), errors[1].abs(), 2.0) > 1.9 && errors[1].abs() < 0.026, "{errors:?}");
    }
}

/// Two walls of which one may move.
struct Walls {
    is_slippery: bool,
    clearance: Box<dyn Fn([f64; 3]) -> Clearance>,
    velocity: Box<dyn Fn(usize, [f64; 3]) -> [f64; 3]>,
}

impl Enclosure for Walls {
    fn clearance(&self, at: [f64; 3]) -> Clearance {
        (self.clearance)(at)
    }
    fn is_moving(&self) -> bool {
        true
    }
    fn velocity(&self, wall: usize, at: [f64; 3]) -> [f64; 3] {
        (self.velocity)(wall, at)
    }
    fn slips(&self, _: usize) -> bool {
        self.is_slippery
    }
}

/// A cylinder (m) that turns at 1 rad/s, wall 1, in one at rest.
fn annulus(inner: f64, outer: f64) -> Walls {
    let middle = [0.507, 0.489];
    let clearance = move |at: [f64; 3]| {
        let off = [at[0] - middle[0], at[1] - middle[1]];
        let r = off[0].hypot(off[1]).max(1e-9);
        let outward = [off[0] / r, off[1] / r, 0.0];
        match r - inner < outer - r {
            true => Clearance { distance: r - inner, direction: outward, wall: 1 },
            false => Clearance { distance: outer - r, direction: outward.map(|x| -x), wall: 0 },
        }
    };
    let velocity = move |wall: usize, at: [f64; 3]| match wall {
        1 => [-(at[1] - middle[1]), at[0] - middle[0], 0.0],
        _ => [0.0; 3],
    };
    Walls { is_slippery: false, clearance: Box::new(clearance), velocity: Box::new(velocity) }
}

#[test]
fn couette_flow_has_its_torque_on_both_cylinders() {
    let (inner, outer) = (0.211_f64, 0.446_f64);
    let exact = 4.0 * PI * VISCOSITY * (inner * outer).powi(2) / (outer.powi(2) - inner.powi(2)) * 0.25;
    let errors = [16, 64].map(|n| {
        let grid = Grid::uniform([0.0; 3], [1.0, 1.0, 0.25], [n, n, 2], [false, false, true]).unwrap();
        let setup = FlowSetup { mixture: Some(MixtureModel::A), ..FlowSetup::new(grid, 1.0, VISCOSITY) };
        let mut flow = Flow::new(setup, &SERIAL).unwrap();
        flow.enclose(&annulus(inner, outer), &SERIAL).unwrap();
        settle(&mut flow, 0.02);
        // About the axis.
        let about = |load: [f64; 6]| load[5] - 0.507 * load[1] + 0.489 * load[0];
        let [at_rest, turning] = flow.loads_on_walls(2, &SERIAL)[..] else { panic!("two walls") };
        [about(at_rest) / exact - 1.0, about(turning) / exact + 1.0]
    });
    println!("torques on the cylinder at rest and the turning one: {errors:?}");
    for [coarse, fine] in [0, 1].map(|wall| errors.map(|of| of[wall].abs())) {
        assert!(fine < 0.015 && fine < 0.5 * coarse, "{errors:?}");
    }
}

/// A piston that fills a tube pushes out what it displaces, and a fluid that slips feels no wall along its way.
#[test]
fn a_piston_pushes_out_what_it_displaces() {
    let grid = Grid::uniform([0.0; 3], [1.0, 1.1, 2.0], [10, 11, 20], [false; 3]).unwrap();
    let mut boundaries = Boundaries::default();
    let high = BoxFace { axis: 2, side: Side::High };
    boundaries.faces[high.index()] = Condition::Outlet { pressure: 0.0 };
    let (radius, speed, dt) = (0.43, 0.4, 0.01);
    for is_slippery in [false, true] {
        let setup = FlowSetup {
            mixture: Some(MixtureModel::A),
            boundaries: boundaries.clone(),
            ..FlowSetup::new(grid.clone(), 1.0, 0.01)
        };
        let solver = setup.suitable_solver_to(1e-12, 500, &SERIAL);
        let mut flow = Flow::with_solver(setup, solver, &SERIAL).unwrap();
        let piston = |time: f64| {
            let top = 0.33 + speed * time;
            let tube = tube(2, [0.52, 0.55, 0.0], radius);
            let clearance = move |at: [f64; 3]| {
                let side = tube(at);
                match at[2] - top < side.distance {
                    true => Clearance { distance: at[2] - top, direction: [0.0, 0.0, 1.0], wall: 1 },
                    false => side,
                }
            };
            let velocity = move |wall, _| [0.0, 0.0, if wall == 1 { speed } else { 0.0 }];
            Walls { is_slippery, clearance: Box::new(clearance), velocity: Box::new(velocity) }
        };
        flow.enclose(&piston(0.0), &SERIAL).unwrap();
        let exact = speed * PI * radius * radius;
        let (mut mean, mut push) = (0.0, 0.0);
        for step in 1..=100 {
            flow.move_walls(&piston(f64::from(step) * dt), false, &SERIAL).unwrap();
            let mixture = flow.mixture.as_mut().unwrap();
            let open = mixture.openings.as_ref().unwrap().cells.clone();
            mixture.void_fraction.data_mut().copy_from_slice(open.data());
            flow.step(dt, &SERIAL).unwrap();
            push += flow.loads_on_walls(2, &SERIAL)[1][2] / 100.0;
            for node in [12, 16, 20] {
                let rate = flow.flow_rate(2, node, &SERIAL);
                assert!((rate / exact - 1.0).abs() < 0.1, "{rate} of {exact} in step {step}");
                mean += rate / 300.0;
            }
        }
        assert!((mean / exact - 1.0).abs() < 3e-3, "{mean} of {exact}");
        let largest = flow.state.velocity.z.data().iter().fold(0.0_f64, |m, u| m.max(u.abs()));
        assert!(largest < 3.0 * speed, "{largest} m/s");
        println!("flow of the piston {}, largest velocity {}, force {push} N", mean / exact, largest / speed);
        assert!(push < 0.0, "the piston is pushed back: {push} N");
    }
}

/// An obstacle that goes to and fro in a closed box keeps the volume of the fluid, and what it meets bounded.
#[test]
fn an_obstacle_moves_through_a_closed_box() {
    let grid = Grid::uniform([0.0; 3], [1.0, 1.0, 1.0], [12, 12, 12], [false; 3]).unwrap();
    let setup = FlowSetup { mixture: Some(MixtureModel::A), ..FlowSetup::new(grid, 1.0, 0.02) };
    let solver = setup.suitable_solver_to(1e-11, 500, &SERIAL);
    let mut flow = Flow::with_solver(setup, solver, &SERIAL).unwrap();
    let ball = |time: f64| {
        let x = 0.5 + 0.2 * (2.0 * time).sin();
        let clearance = move |at: [f64; 3]| {
            let off = [at[0] - x, at[1] - 0.47, at[2] - 0.52];
            let r = off.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
            Clearance { distance: r - 0.21, direction: off.map(|x| x / r), wall: 0 }
        };
        let velocity = move |_, _| [0.4 * (2.0 * time).cos(), 0.0, 0.0];
        Walls { is_slippery: false, clearance: Box::new(clearance), velocity: Box::new(velocity) }
    };
    flow.enclose(&ball(0.0), &SERIAL).unwrap();
    for step in 1..=150 {
        flow.move_walls(&ball(f64::from(step) * 0.02), false, &SERIAL).unwrap();
        let mixture = flow.mixture.as_mut().unwrap();
        let open = mixture.openings.as_ref().unwrap().cells.clone();
        mixture.void_fraction.data_mut().copy_from_slice(open.data());
        flow.step(0.02, &SERIAL).unwrap();
        let [divergence, fastest] = flow.divergence(&SERIAL);
        assert!(divergence < 1e-7 * fastest, "{divergence:e} of {fastest}");
        let largest = flow
            .state
            .velocity
            .components()
            .iter()
            .flat_map(|u| u.iter())
            .fold(0.0_f64, |m, u| m.max(u.abs()));
        assert!(largest < 1.0, "{largest} m/s in step {step}");
    }
}
