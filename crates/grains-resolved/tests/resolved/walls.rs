//! Walls inside the flow, against closed forms and against bodies.

use crate::common::*;
use grains_domain::{SerialTransport, Transport};
use grains_fluid::{Boundaries, Condition, Drive, Flow, FlowSetup, Grid, Profile};
use grains_geometry::{ClosedMesh, ClosedSurface, Shape, TriMesh, Vec3};
use grains_resolved::{FlowOnWall, FluidWall, Form, Resolved, RigidBody, SolidSide};
use grains_testing::on_ranks;
use std::f64::consts::PI;
use std::sync::Arc;

/// A flow between walls.
pub struct Walled {
    pub flow: Flow,
    pub resolved: Resolved,
    walls: Vec<FluidWall>,
}

/// Where a wall is whose frame is the world's.
pub fn at_rest(wall: usize) -> RigidBody {
    RigidBody { form: Form::Wall(0), ..body(wall as u64, Vec3::zeros()) }
}

/// The inside or outside of a cylinder without end.
pub fn cylinder(center: Vec3, axis: Vec3, radius: f64, solid: SolidSide) -> FluidWall {
    let surface = ClosedSurface::Cylinder { center, axis, radius, half_length: f64::INFINITY };
    FluidWall { surface, solid }
}

impl Walled {
    pub fn new(
        setup: &FlowSetup,
        ranks: [usize; 3],
        (walls, places): (&[FluidWall], Vec<RigidBody>),
        transport: &dyn Transport,
    ) -> Self {
        let own = partition(&setup.grid, ranks, transport.rank());
        let mut flow = Flow::new(FlowSetup { partition: own, halo: 7, ..setup.clone() }, transport).unwrap();
        let resolved = Resolved::new(&mut flow, QUADRATIC).unwrap();
        let mut walled = Self { flow, resolved, walls: walls.to_vec() };
        walled.place(places, transport);
        walled
    }

    pub fn still(setup: &FlowSetup, walls: &[FluidWall]) -> Self {
        let places = (0..walls.len()).map(at_rest).collect();
        Self::new(setup, [1; 3], (walls, places), &SerialTransport)
    }

    /// Takes the walls where they are now.
    fn place(&mut self, places: Vec<RigidBody>, transport: &dyn Transport) {
        self.resolved.place_walls(self.walls.iter().cloned().zip(places).collect());
        self.resolved.place(Vec::new(), &[], &mut self.flow, transport);
    }

    pub fn step(&mut self, dt: f64, transport: &dyn Transport) {
        self.flow.step(dt, transport).unwrap();
        self.resolved.impose_rigid_velocity(None, &mut self.flow, dt, transport).unwrap();
    }

    /// Steps until no velocity changes by more than a share of the largest.
    pub fn settle(&mut self, dt: f64, share: f64) {
        for _ in 0..100_000 {
            let before = self.flow.state.velocity.clone();
            self.step(dt, &SerialTransport);
            let (mut change, mut max) = (0.0_f64, 0.0_f64);
            for (a, b) in before.components().into_iter().zip(self.flow.state.velocity.components()) {
                change = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(change, f64::max);
                max = b.iter().map(|b| b.abs()).fold(max, f64::max);
            }
            if change < share * max {
                return;
            }
        }
        panic!("no steady flow");
    }

    /// Largest error of the velocities where there is an exact one, and that in the mean square.
    pub fn errors(&self, exact: impl Fn(usize, Vec3) -> Option<f64>) -> [f64; 2] {
        let (mut largest, mut squares, mut count) = (0.0_f64, 0.0, 0.0);
        self.compare(exact, |found, exact| {
            largest = largest.max((found - exact).abs());
            squares += (found - exact).powi(2);
            count += 1.0;
        });
        [largest, f64::sqrt(squares / count)]
    }

    /// The multiple of an exact flow that comes nearest.
    fn multiple(&self, exact: impl Fn(usize, Vec3) -> Option<f64>) -> f64 {
        let [mut product, mut square] = [0.0; 2];
        self.compare(exact, |found, exact| {
            product += found * exact;
            square += exact * exact;
        });
        product / square
    }

    /// Calls `visit` with each velocity for which there is an exact one, and that.
    pub fn compare(&self, exact: impl Fn(usize, Vec3) -> Option<f64>, mut visit: impl FnMut(f64, f64)) {
        let subgrid = &self.resolved.subgrid;
        let [nx, ny, nz] = subgrid.layout.cells.map(|n| n as isize);
        for c in (0..3).filter(|&c| subgrid.active[c]) {
            let velocity = self.flow.state.velocity.component(c);
            for (i, j, k) in (0..nx * ny * nz).map(|m| (m % nx, m / nx % ny, m / nx / ny)) {
                let at = Vec3::from_fn(|a, _| subgrid.coordinate(c, a, [i, j, k][a]));
                if let Some(exact) = exact(c, at) {
                    visit(velocity[subgrid.layout.index(i, j, k)], exact);
                }
            }
        }
    }
}

/// Orders of errors on grids of cells half as wide each time.
fn orders(errors: &[[f64; 2]]) -> Vec<[f64; 2]> {
    errors.windows(2).map(|pair| [0, 1].map(|k| order(pair[0][k], pair[1][k], 2.0))).collect()
}

/// Errors in a pipe of radius 0.4 along x, off the grid lines, over the largest velocity.
fn pipe(n: usize) -> [f64; 2] {
    let h = 1.0 / n as f64;
    let grid = Grid::uniform([0.0; 3], [8.0 * h, 1.0, 1.0], [8, n, n], [true; 3]).unwrap();
    let mut setup = FlowSetup::new(grid, 1.0, 1.0);
    setup.drive[0] = Drive::PressureGradient(-1.0);
    let center = Vec3::new(0.0, 0.513, 0.487);
    let mut walled = Walled::still(&setup, &[cylinder(center, Vec3::x(), 0.4, SolidSide::Outside)]);
    walled.settle(h * h, 1e-9);
    let from_axis = |at: Vec3| (at - center).yz().norm();
    // The wall holds what the gradient drives: the velocities that are free.
    let subgrid = &walled.resolved.subgrid;
    let rows = (0..n * n).map(|m| {
        Vec3::new(0.0, subgrid.coordinate(0, 1, (m % n) as isize), subgrid.coordinate(0, 2, (m / n) as isize))
    });
    let area = rows.filter(|at| from_axis(*at) < 0.4).count() as f64 * h * h;
    let force = walled.resolved.on_walls[0].force;
    assert!((force.x / (8.0 * h) - area).abs() < 1e-6 && force.yz().norm() < 1e-9, "{force:?} {area}");
    let exact = |c: usize, at: Vec3| {
        let r = from_axis(at);
        (r < 0.4).then_some(if c == 0 { 0.25 * (0.16 - r * r) } else { 0.0 })
    };
    walled.errors(exact).map(|e| e / 0.04)
}

#[test]
fn poiseuille_flow_in_a_pipe_off_the_grid_lines_is_of_second_order() {
    let errors = [12, 24, 48].map(pipe);
    println!("pipe: errors {errors:?}, orders {:.2?}", orders(&errors));
    // From grid to grid the errors follow how the wall lies in its cells; from the first to the last they fall.
    let over_both = [0, 1].map(|k| order(errors[0][k], errors[2][k], 4.0));
    assert!(over_both.iter().all(|order| *order > 1.8) && errors[2][0] < 2e-3, "{errors:?} {over_both:?}");
}

/// Errors in a channel or pipe turned by 30 degrees, between inlets with the exact profile, of which a face on the border takes
/// the value in its middle: of what flows by that, and of the profile of as much; and the largest difference of the flow rates
/// through sections, over the flow rate.
fn turned(n: usize, is_pipe: bool) -> (f64, [f64; 2], f64) {
    let (h, half) = (1.0 / n as f64, 0.15);
    let depth = if is_pipe { 0.4 } else { h };
    let cells = [n, n, (depth / h).round() as usize];
    let grid = Grid::uniform([0.0; 3], [1.0, 1.0, cells[2] as f64 * h], cells, [false; 3]).unwrap();
    let mut setup = FlowSetup::new(grid, 1.0, 1.0);
    let (sin, cos) = (PI / 6.0).sin_cos();
    let (along, across) = (Vec3::new(cos, sin, 0.0), Vec3::new(-sin, cos, 0.0));
    let center = Vec3::new(0.5, 0.5, 0.5 * cells[2] as f64 * h);
    let share = move |at: Vec3| {
        let from = at - center;
        let off = if is_pipe { (from - along * from.dot(&along)).norm() } else { from.dot(&across) };
        1.0 - (off / half).powi(2)
    };
    let inlet = Profile::Function(Arc::new(move |x: [f64; 3], _| (along * share(x.into()).max(0.0)).into()));
    let mut boundaries = Boundaries::default();
    for face in 0..2 {
        boundaries.faces[face] = Condition::Inlet { profile: inlet.clone() };
    }
    if !is_pipe {
        (boundaries.faces[4], boundaries.faces[5]) = (Condition::Symmetry, Condition::Symmetry);
    }
    setup.boundaries = boundaries;
    let plane = |side: f64| FluidWall {
        surface: ClosedSurface::Plane { point: center + across * (side * half), normal: across * -side },
        solid: SolidSide::Inside,
    };
    let walls = match is_pipe {
        true => vec![cylinder(center, along, half, SolidSide::Outside)],
        false => vec![plane(1.0), plane(-1.0)],
    };
    let mut walled = Walled::still(&setup, &walls);
    walled.settle(h * h, 1e-9);
    // The ends are those of the profile given there, not of the walls.
    let is_far = |at: Vec3| (at - center).dot(&along).abs() < 0.25;
    let exact = |c: usize, at: Vec3| (share(at) > 0.0 && is_far(at)).then(|| along[c] * share(at));
    let rates: Vec<f64> = (0..=n).map(|node| walled.flow.flow_rate(0, node, &SerialTransport)).collect();
    let differ = rates.iter().map(|rate| (rate / rates[0] - 1.0).abs()).fold(0.0, f64::max);
    let multiple = walled.multiple(exact);
    (multiple - 1.0, walled.errors(|c, at| exact(c, at).map(|u| multiple * u)), differ)
}

#[test]
fn poiseuille_flow_through_slanted_walls_is_of_second_order_and_carries_the_same_everywhere() {
    for (is_pipe, cells) in [(false, vec![24, 48, 96]), (true, vec![20, 40])] {
        let found: Vec<(f64, [f64; 2], f64)> = cells.iter().map(|&n| turned(n, is_pipe)).collect();
        let errors: Vec<[f64; 2]> = found.iter().map(|found| found.1).collect();
        println!("turned, pipe {is_pipe}: {found:?}, orders {:.2?}", orders(&errors));
        for ((flow, _, differ), n) in found.iter().zip(&cells) {
            // At both ends of a row of faces up to an eighth of the velocity a cell away.
            assert!(*differ < 1e-7 && flow.abs() < 12.5 / (n * n) as f64, "{found:?}");
        }
        assert!(orders(&errors).iter().all(|order| order[1] > 1.8), "{errors:?}");
    }
}

/// Radii of an annulus (m) and angular velocities of its cylinders (rad/s).
const ANNULUS: [[f64; 2]; 2] = [[0.2, 0.42], [1.0, -0.5]];

/// Torques on the inner and outer cylinder of an annulus, per length, and errors of the velocity.
fn couette(n: usize) -> ([f64; 2], [f64; 2]) {
    let h = 1.0 / n as f64;
    let grid = Grid::uniform([0.0; 3], [1.0, 1.0, h], [n, n, 1], [false; 3]).unwrap();
    let mut setup = FlowSetup::new(grid, 1.0, 1.0);
    let mut boundaries = Boundaries::default();
    (boundaries.faces[4], boundaries.faces[5]) = (Condition::Symmetry, Condition::Symmetry);
    setup.boundaries = boundaries;
    let center = Vec3::new(0.507, 0.496, 0.0);
    let [radii, rates] = ANNULUS;
    let walls = [(radii[0], SolidSide::Inside), (radii[1], SolidSide::Outside)]
        .map(|(radius, solid)| cylinder(Vec3::zeros(), Vec3::z(), radius, solid));
    let place = |k: usize| RigidBody { center, spin: Vec3::z() * rates[k], ..at_rest(k) };
    let mut walled = Walled::new(&setup, [1; 3], (&walls, vec![place(0), place(1)]), &SerialTransport);
    walled.settle(h * h, 1e-9);
    let [a, b] = radii.map(|r| r * r);
    let exact = |c: usize, at: Vec3| {
        let from = at - center;
        let r = from.norm_squared();
        let rate = (rates[1] * b - rates[0] * a) / (b - a) + (rates[0] - rates[1]) * a * b / ((b - a) * r);
        (r > a && r < b).then(|| [-rate * from.y, rate * from.x][c])
    };
    let errors = walled.errors(|c, at| exact(c, Vec3::new(at.x, at.y, 0.0)));
    let torque = |on: &FlowOnWall| (on.torque - center.cross(&on.force)).z / h;
    ([torque(&walled.resolved.on_walls[0]), torque(&walled.resolved.on_walls[1])], errors)
}

#[test]
fn couette_flow_turns_both_cylinders_with_one_torque() {
    let [radii, rates] = ANNULUS;
    let [a, b] = radii.map(|r| r * r);
    let torque = -4.0 * PI * (rates[0] - rates[1]) * a * b / (b - a);
    let found = [24, 48, 96].map(couette);
    let errors = found.map(|(_, errors)| errors);
    println!("Couette: {found:?} of {torque}, orders {:.2?}", orders(&errors));
    // Five cells across the radius of the inner one are few.
    for ([inner, outer], _) in &found[1..] {
        assert!((inner + outer).abs() < 0.01 * torque.abs(), "{inner} {outer}");
        assert!((inner / torque - 1.0).abs() < 0.01, "{inner} of {torque}");
    }
    assert!(orders(&errors).iter().all(|order| order[1] > 1.8), "{errors:?}");
}

#[test]
fn an_array_of_cylinders_that_are_walls_resists_as_sangani_and_acrivos_found() {
    let (fraction, found, n) = (0.2, 51.53, 32);
    let h = 1.0 / n as f64;
    let grid = Grid::uniform([0.0; 3], [1.0, h, 1.0], [n, 1, n], [true; 3]).unwrap();
    let mut setup = FlowSetup::new(grid, 1.0, 1.0);
    setup.drive[0] = Drive::PressureGradient(-1.0);
    // Near a corner of the box: most of it is in images.
    let center = Vec3::new(0.98, 0.0, 0.03);
    let surface = ClosedSurface::Cylinder {
        center,
        axis: Vec3::y(),
        radius: f64::sqrt(fraction / PI),
        half_length: 1.0,
    };
    let mut walled = Walled::still(&setup, &[FluidWall { surface, solid: SolidSide::Inside }]);
    walled.settle(h * h, 1e-8);
    let friction = 1.0 / walled.flow.mean_velocity(0, &SerialTransport);
    assert!((friction / found - 1.0).abs() < 0.01, "{friction}");
    // What drives the fluid is what holds the wall.
    let force = walled.resolved.on_walls[0].force.x / h;
    assert!((force - 1.0).abs() < 1e-4, "{force}");
}

#[test]
fn a_container_that_speeds_up_takes_its_fluid_along() {
    let (n, radius, acceleration, dt) = (40, 0.35, 0.1, 0.01);
    let h = 1.0 / n as f64;
    let grid = Grid::uniform([0.0; 3], [1.0, 1.0, h], [n, n, 1], [false; 3]).unwrap();
    let mut setup = FlowSetup::new(grid, 3.0, 1e-3);
    let mut boundaries = Boundaries::default();
    (boundaries.faces[4], boundaries.faces[5]) = (Condition::Symmetry, Condition::Symmetry);
    setup.boundaries = boundaries;
    let wall = cylinder(Vec3::zeros(), Vec3::z(), radius, SolidSide::Outside);
    let place = |time: f64| RigidBody {
        center: Vec3::new(0.503 + 0.5 * acceleration * time * time, 0.497, 0.0),
        velocity: Vec3::x() * (acceleration * time),
        ..at_rest(0)
    };
    let mut walled = Walled::new(&setup, [1; 3], (&[wall], vec![place(0.0)]), &SerialTransport);
    for step in 1..=20 {
        walled.place(vec![place(step as f64 * dt)], &SerialTransport);
        walled.step(dt, &SerialTransport);
    }
    let wanted = -setup.density * PI * radius * radius * acceleration;
    let force = walled.resolved.on_walls[0].force / h;
    assert!(
        (force.x / wanted - 1.0).abs() < 0.03 && force.y.abs() < 0.03 * wanted.abs(),
        "{force:?} {wanted}"
    );
}

/// The channel with a cylinder of Schäfer and Turek (1996) at Reynolds number 20, cut off behind 1.2 m: setup, middle and radius
/// of the cylinder (m), and width of the cells (m).
fn channel_with_a_cylinder(cells_across: usize) -> (FlowSetup, Vec3, f64, f64) {
    let h = 0.1 / cells_across as f64;
    let [nx, ny] = [1.2, 0.41].map(|length: f64| (length / h).round() as usize);
    let grid = Grid::uniform([0.0; 3], [nx as f64 * h, ny as f64 * h, h], [nx, ny, 1], [false; 3]).unwrap();
    let mut setup = FlowSetup::new(grid, 1.0, 1e-3);
    let mut boundaries = Boundaries::default();
    boundaries.faces[0] = Condition::Inlet { profile: Profile::Parabolic { mean: 0.2 } };
    boundaries.faces[1] = Condition::Outlet { pressure: 0.0 };
    (boundaries.faces[4], boundaries.faces[5]) = (Condition::Symmetry, Condition::Symmetry);
    setup.boundaries = boundaries;
    (setup, Vec3::new(0.2, 0.2, 0.5 * h), 0.05, h)
}

#[test]
fn a_cylinder_in_a_channel_has_one_drag_as_a_body_and_as_a_wall() {
    let (setup, center, radius, h) = channel_with_a_cylinder(20);
    let (dt, unit) = (0.4 * h / 0.45, 0.5 * 0.2 * 0.2 * 2.0 * radius * h);
    let steps = (6.0 / dt) as usize;
    let disc = Shape::cylinder(radius, h, 0.02).unwrap();
    let mut scene = Scene::new(&setup, [1; 3], (&disc, &[body(1, center)]), QUADRATIC, &SerialTransport);
    let mut walled = Walled::still(&setup, &[cylinder(center, Vec3::z(), radius, SolidSide::Inside)]);
    for _ in 0..steps {
        scene.step(dt, &SerialTransport);
        walled.step(dt, &SerialTransport);
    }
    let [of_body, of_wall] = [-scene.actions[0].force, walled.resolved.on_walls[0].force].map(|f| f / unit);
    println!("drag and lift as a body {of_body:?}, as a wall {of_wall:?}");
    for drag in [of_body.x, of_wall.x] {
        assert!((drag / 5.5795 - 1.0).abs() < 0.02, "{drag}");
    }
    assert!((of_body.x / of_wall.x - 1.0).abs() < 0.01, "{of_body:?} {of_wall:?}");
    assert!((of_body.y - of_wall.y).abs() < 2e-3 * of_wall.x, "{of_body:?} {of_wall:?}");
}

/// A tetrahedron about the origin.
fn tetrahedron(size: f64) -> ClosedMesh {
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let vertices = corners.map(|c| Vec3::from(c) * size).to_vec();
    let faces = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]].map(|face| face.to_vec());
    ClosedMesh::new(TriMesh::from_polygons(vertices, &faces).unwrap()).unwrap()
}

#[test]
fn flow_between_walls_that_move_is_the_same_on_any_ranks() {
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [16; 3], [true, false, false]).unwrap();
    let mut setup = FlowSetup::new(grid, 1.0, 0.1);
    setup.drive[0] = Drive::PressureGradient(-1.0);
    let walls = [
        cylinder(Vec3::new(0.0, 0.52, 0.49), Vec3::x(), 0.42, SolidSide::Outside),
        FluidWall { surface: ClosedSurface::Mesh(Arc::new(tetrahedron(0.15))), solid: SolidSide::Inside },
    ];
    let places = |step: usize| {
        let angle = 0.05 * step as f64;
        let stirrer = RigidBody {
            center: Vec3::new(0.95, 0.5, 0.5),
            rotation: nalgebra::Rotation3::from_euler_angles(angle, 0.0, 0.0).into_inner(),
            spin: Vec3::x() * 5.0,
            ..at_rest(1)
        };
        vec![at_rest(0), stirrer]
    };
    let run = |ranks: [usize; 3]| {
        let results = on_ranks(ranks.iter().product(), |transport| {
            let mut walled = Walled::new(&setup, ranks, (&walls, places(0)), &transport);
            for step in 1..=5 {
                walled.place(places(step), &transport);
                walled.step(0.01, &transport);
            }
            let (layout, first) = (walled.flow.layout(), walled.flow.first_cell());
            let velocity = walled.flow.state.velocity.components().map(|u| piece(u, layout, first));
            (velocity, walled.resolved.on_walls)
        });
        let velocity: Vec<f64> =
            (0..3).flat_map(|c| joined(results.iter().map(|r| r.0[c].clone()).collect())).collect();
        let loads = results[0].1.iter().flat_map(|on| [on.force, on.torque]).flat_map(<[f64; 3]>::from);
        (velocity, loads.collect::<Vec<f64>>())
    };
    let (velocity, loads) = run([1; 3]);
    assert!(loads[9].abs() > 1e-4, "{loads:?}");
    for ranks in [[2, 1, 1], [1, 2, 1], [1, 2, 2]] {
        let (others, other_loads) = run(ranks);
        assert!(difference(&velocity, &others) < 1e-12, "{ranks:?} {}", difference(&velocity, &others));
        assert!(difference(&loads, &other_loads) < 1e-10, "{ranks:?} {loads:?} {other_loads:?}");
    }
}

#[test]
fn walls_that_rest_hold_what_they_would_if_found_anew() {
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [16; 3], [true, false, false]).unwrap();
    let mut setup = FlowSetup::new(grid, 1.0, 0.1);
    setup.drive[0] = Drive::PressureGradient(-1.0);
    let obstacle =
        || FluidWall { surface: ClosedSurface::Mesh(Arc::new(tetrahedron(0.2))), solid: SolidSide::Inside };
    let container = cylinder(Vec3::new(0.0, 0.52, 0.49), Vec3::x(), 0.42, SolidSide::Outside);
    // Obstacles that overlap each other, the container and a periodic face, listed on both sides of it.
    let walls = [obstacle(), container, obstacle(), obstacle()];
    let centers = [[0.3, 0.5, 0.45], [0.0; 3], [0.45, 0.6, 0.5], [0.95, 0.4, 0.6]].map(Vec3::from);
    let mut turned = [0.0; 4];
    let places = |turned: &[f64; 4]| {
        let place = |wall: usize| RigidBody {
            center: centers[wall],
            rotation: nalgebra::Rotation3::from_euler_angles(turned[wall], 0.3, 0.0).into_inner(),
            spin: Vec3::x(),
            ..at_rest(wall)
        };
        let mut places: Vec<RigidBody> = (0..4).map(place).collect();
        places[1] = at_rest(1);
        places
    };
    let new = || Walled::new(&setup, [1; 3], (&walls, places(&[0.0; 4])), &SerialTransport);
    let [mut kept, mut anew] = [new(), new()];
    // Any of the obstacles move, in an order in which each comes after others.
    for (step, moving) in [4, 1, 6, 3, 5, 2, 7, 4, 2, 1].into_iter().enumerate() {
        for (bit, wall) in [0, 2, 3].into_iter().enumerate().filter(|(bit, _)| moving & 1 << bit != 0) {
            turned[wall] += 0.1 + 0.03 * (step + bit) as f64;
        }
        anew.resolved.place_walls(Vec::new());
        for walled in [&mut kept, &mut anew] {
            walled.place(places(&turned), &SerialTransport);
            walled.step(0.01, &SerialTransport);
        }
        for component in 0..3 {
            let [a, b] = [&kept, &anew].map(|walled| walled.flow.state.velocity.component(component));
            assert!(a == b, "{turned:?}");
        }
        assert_eq!(kept.resolved.on_walls, anew.resolved.on_walls);
    }
}
