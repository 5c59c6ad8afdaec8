//! Multipliers with those deep inside eliminated, against all of them at once by a dense matrix.

use crate::body::others;
use crate::constraints::Block;
use crate::multiplier::Multipliers;
use crate::{BodyMotion, Forcing, Form, Interpolation, Method, MultiplierMethod, Resolved, RigidBody};
use grains_domain::SerialTransport;
use grains_fluid::{Flow, FlowSetup, Grid};
use grains_geometry::{Mat3, Shape, Vec3};
use nalgebra::{DMatrix, DVector, Vector6};
use std::collections::{BTreeMap, HashMap};

const DT: f64 = 0.02;

/// A row of C with its body and R.
struct Constraint {
    component: usize,
    entries: Vec<(usize, f64)>,
    body: usize,
    along: Vector6<f64>,
}

fn along(component: usize, arm: &Vec3) -> Vector6<f64> {
    let [b, c] = others(component);
    let mut along = Vector6::zeros();
    (along[component], along[3 + b], along[3 + c]) = (1.0, arm[c], -arm[b]);
    along
}

fn constraints(resolved: &Resolved) -> Vec<Constraint> {
    let (subgrid, mut all) = (&resolved.subgrid, Vec::new());
    let strides = subgrid.layout.strides();
    // Across periodic sides places are those of own cells, and images of bodies are the bodies.
    let own_place = |place: usize| {
        let [i, j, k] = std::array::from_fn(|a| {
            let (i, cells) = (subgrid.index_along(a, place), subgrid.layout.cells[a] as isize);
            if subgrid.neighbours[a][0].is_some() { i.rem_euclid(cells) } else { i }
        });
        subgrid.layout.index(i, j, k)
    };
    let body = |number: u32| {
        let id = resolved.bodies[number as usize].id;
        resolved.bodies.iter().position(|body| body.id == id).unwrap()
    };
    for component in 0..3 {
        for node in resolved.nodes.of[component].iter().filter(|node| node.is_deep()) {
            let place = node.place as usize;
            let arm = subgrid.position(component, place) - resolved.bodies[node.body as usize].center;
            all.push(Constraint {
                component,
                entries: vec![(place, 1.0)],
                body: body(node.body),
                along: along(component, &arm),
            });
        }
    }
    let constraints = &resolved.multipliers.constraints;
    for block in &constraints.blocks {
        let component = usize::from(block.component);
        for row in block.rows() {
            let mut field = vec![0.0; subgrid.layout.len()];
            constraints.stencils[row].spread(strides, 1.0, &mut field);
            let mut entries: BTreeMap<usize, f64> = BTreeMap::new();
            for (place, weight) in field.into_iter().enumerate().filter(|(_, weight)| *weight != 0.0) {
                *entries.entry(own_place(place)).or_default() += weight;
            }
            all.push(Constraint {
                component,
                entries: entries.into_iter().collect(),
                body: body(block.body),
                along: along(component, &constraints.arms[row]),
            });
        }
    }
    all
}

/// Velocities of the fluid and of the bodies that meet all constraints.
fn dense(resolved: &Resolved, flow: &Flow, motions: &[BodyMotion]) -> ([Vec<f64>; 3], Vec<Vector6<f64>>) {
    let all = constraints(resolved);
    let force = &flow.immersed.as_ref().unwrap().force;
    let mut velocity = [0, 1, 2].map(|c| {
        let pairs = flow.state.velocity.component(c).iter().zip(force.component(c));
        pairs.map(|(u, f)| u - DT / flow.setup.density * f).collect::<Vec<f64>>()
    });
    let scale = DT / (flow.setup.density * resolved.subgrid.cell_volume());
    let free: Vec<Vector6<f64>> = motions
        .iter()
        .map(|m| {
            let (matrix, right) = m.balance(resolved.virtual_mass(m));
            m.solved(matrix, right)
        })
        .collect();
    let of_body = |body: usize| resolved.virtual_mass(&motions[body]);
    let n = all.len();
    let mut matrix = DMatrix::zeros(n, n);
    let mut right = DVector::zeros(n);
    let mut field = vec![0.0; resolved.subgrid.layout.len()];
    for (i, one) in all.iter().enumerate() {
        one.entries.iter().for_each(|&(place, weight)| field[place] = weight);
        let recoil = motions[one.body].change(motions[one.body].balance(of_body(one.body)).0, one.along * DT);
        for (j, other) in all.iter().enumerate() {
            if one.component == other.component {
                matrix[(i, j)] += scale * other.entries.iter().map(|&(p, w)| w * field[p]).sum::<f64>();
            }
            if one.body == other.body {
                matrix[(i, j)] += other.along.dot(&recoil);
            }
        }
        one.entries.iter().for_each(|&(place, _)| field[place] = 0.0);
        let here: f64 = one.entries.iter().map(|&(p, w)| w * velocity[one.component][p]).sum();
        right[i] = one.along.dot(&free[one.body]) - here;
    }
    let values = matrix.cholesky().unwrap().solve(&right);
    let mut bodies = free;
    for (one, value) in all.iter().zip(&values) {
        one.entries
            .iter()
            .for_each(|&(place, weight)| velocity[one.component][place] += scale * weight * value);
        bodies[one.body] += motions[one.body]
            .change(motions[one.body].balance(of_body(one.body)).0, one.along * (-DT * value));
    }
    (velocity, bodies)
}

/// Multipliers by body, point and component.
fn of_points(resolved: &Resolved) -> HashMap<(u64, u32, u8), f64> {
    let Multipliers { constraints, values, .. } = &resolved.multipliers;
    let of_block = |block: &Block| {
        let (id, component) = (resolved.bodies[block.body as usize].id, block.component);
        block.rows().map(move |row| ((id, constraints.points[row], component), values[row]))
    };
    constraints.blocks.iter().flat_map(of_block).collect()
}

#[test]
fn multipliers_on_surfaces_alone_do_what_all_do() {
    do_what_all_do([false; 3], Interpolation::Quadratic);
}

#[test]
fn they_do_so_across_periodic_sides() {
    do_what_all_do([true, false, true], Interpolation::Quadratic);
    do_what_all_do([true; 3], Interpolation::Multilinear);
}

fn do_what_all_do(periodic: [bool; 3], interpolation: Interpolation) {
    let grid = Grid::uniform([0.0; 3], [1.0, 1.0, 1.5], [12, 12, 18], periodic).unwrap();
    let setup = FlowSetup { halo: 7, ..FlowSetup::new(grid, 1.0, 0.1) };
    let mut flow = Flow::new(setup, &SerialTransport).unwrap();
    let method = MultiplierMethod { interpolation, spacing: 2.0, tolerance: 1e-12, iterations: 500 };
    let forcing = Forcing { method: Method::Multiplier(method), explicit: 1.0 };
    let mut resolved = Resolved::new(&mut flow, forcing).unwrap();
    let tau = std::f64::consts::TAU;
    let swirl = |x: [f64; 3]| [(tau * x[1]).sin(), (tau / 1.5 * x[2]).cos(), (tau * (x[0] + x[1])).sin()];
    flow.initialise(swirl, |_| 0.0, &SerialTransport);
    let shapes = [Shape::sphere(0.24).unwrap()];
    let body = |id: u64, center: Vec3| RigidBody {
        id,
        form: Form::Shape(0),
        scale: 1.0,
        center,
        rotation: Mat3::identity(),
        velocity: Vec3::zeros(),
        spin: Vec3::zeros(),
    };
    // Points of each reach into the other; the third is led.
    let mut bodies = vec![
        body(1, Vec3::new(0.5, 0.47, 0.4)),
        body(2, Vec3::new(0.53, 0.5, 0.86)),
        body(3, Vec3::new(0.4, 0.6, 1.23)),
    ];
    let mass = 1.7 * 4.0 / 3.0 * std::f64::consts::PI * 0.24_f64.powi(3);
    let motion = |id: u64, momentum: [f64; 6]| BodyMotion {
        mass,
        inertia: Mat3::identity() * (0.4 * mass * 0.24 * 0.24),
        density_ratio: 1.0 / 1.7,
        momentum,
        contacts: [0.0; 6],
        weight: [0.0, 1e-3, 0.0, 2e-4, 0.0, 1e-4],
        carried_over: [0.0; 6],
        imposed: if id == 3 { [0.1, 0.0, -0.2, 0.0, 1.0, 0.0].map(Some) } else { [None; 6] },
    };
    for step in 0..4 {
        let before = of_points(&resolved);
        // The order of bodies does not matter to their points.
        if step == 3 {
            bodies.rotate_left(1);
        }
        resolved.place(bodies.clone(), &shapes, &mut flow, &SerialTransport);
        let after = of_points(&resolved);
        let kept = after.iter().filter(|(point, value)| **value != 0.0 && before.get(point) == Some(value));
        let (kept, there) = (kept.count(), after.keys().filter(|point| before.contains_key(point)).count());
        assert_eq!(kept, there, "points begin with their last multipliers");
        assert!((step == 0 || there > after.len() / 2) && (step > 0 || there == 0), "{step} {there}");
        if step > 0 {
            flow.step(DT, &SerialTransport).unwrap();
        }
        let momentum = |b: &RigidBody| (b.velocity * mass, b.spin * (0.4 * mass * 0.24 * 0.24));
        let motions: Vec<BodyMotion> = bodies
            .iter()
            .map(|b| {
                let (p, l) = momentum(b);
                motion(b.id, [p.x, p.y, p.z, l.x, l.y, l.z])
            })
            .collect();
        let deep = resolved.multipliers.shared.deep.iter().map(Vec::len).sum::<usize>();
        assert!(deep > 0, "points reach to nodes deep in the other body");
        let blocks = &resolved.multipliers.constraints.blocks;
        let shared: usize = blocks.iter().map(|block| block.shared.len()).sum();
        let alone: usize = blocks.iter().map(|block| block.alone.len()).sum();
        assert!(shared > 0 && alone > 50, "{shared} {alone}");
        let (velocity, velocities) = dense(&resolved, &flow, &motions);
        resolved.impose_rigid_velocity(Some(&motions), &mut flow, DT, &SerialTransport).unwrap();
        let layout = resolved.subgrid.layout;
        for (component, velocity) in velocity.iter().enumerate() {
            let found = flow.state.velocity.component(component);
            for place in layout.rows().flat_map(|row| row..row + layout.cells[0]) {
                let (a, b) = (velocity[place], found[place]);
                assert!((a - b).abs() < 1e-9, "{step} {component} {place}: {a} {b}");
            }
        }
        for (body, wanted) in resolved.bodies.iter().zip(&velocities) {
            let found = [body.velocity, body.spin];
            let wanted = [0, 3].map(|k| Vec3::from_column_slice(&wanted.as_slice()[k..k + 3]));
            assert!((0..2).all(|k| (found[k] - wanted[k]).norm() < 1e-8), "{found:?} {wanted:?}");
        }
        bodies.clone_from_slice(&resolved.bodies[..3]);
        bodies.iter_mut().for_each(|body| body.center += body.velocity * DT);
    }
}
