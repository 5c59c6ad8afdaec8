//! Whether forces settle: the largest eigenvalue λ of L_ii − W L_oi, times ν Δt/Δx² below 1 ([`MAX_DIFFUSION_NUMBER`]).

use crate::nodes::Nodes;
use crate::wall::Solids;
use crate::{Extrapolation, Form, MAX_DIFFUSION_NUMBER, RigidBody, Subgrid};
use grains_fluid::{FlowSetup, Grid};
use grains_geometry::{Mat3, Shape, Vec3};
use nalgebra::Rotation3;

/// Applications of the operator: the largest eigenvalue is found from below.
const ITERATIONS: usize = 300;

/// Numbers from 0 to 1.
pub(crate) struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn turn(&mut self) -> f64 {
        std::f64::consts::TAU * self.next()
    }
}

/// λ of the velocities along x that bodies impose, by the power method on L_ii − W L_oi + 2 d, d axes.
fn largest_eigenvalue(subgrid: &Subgrid, nodes: &Nodes) -> f64 {
    let (strides, own) = (subgrid.layout.strides(), &nodes.of[0]);
    let axes: Vec<usize> = (0..3).filter(|&a| subgrid.active[a]).collect();
    let around = |p: usize| axes.iter().flat_map(move |&a| [p - strides[a], p + strides[a]]);
    let holds = |p: usize| nodes.holds(0, p);
    let mut beside: Vec<usize> = own.iter().flat_map(|n| around(n.place as usize)).collect();
    beside.retain(|&p| !holds(p));
    beside.sort_unstable();
    beside.dedup();
    let sum = |f: &[f64], p: usize| around(p).filter(|&q| holds(q)).map(|q| f[q]).sum::<f64>();
    let mut random = Random(1);
    let mut f = vec![0.0; subgrid.layout.len()];
    own.iter().for_each(|node| f[node.place as usize] = random.next() - 0.5);
    let (mut outside, mut norm) = (vec![0.0; f.len()], 0.0);
    for _ in 0..ITERATIONS {
        beside.iter().for_each(|&p| outside[p] = sum(&f, p));
        let next: Vec<f64> = own
            .iter()
            .map(|node| {
                let extrapolated =
                    nodes.interface(0, node).map_or(0.0, |interface| interface.weighted(&outside, strides));
                sum(&f, node.place as usize) - extrapolated
            })
            .collect();
        norm = next.iter().map(|x| x * x).sum::<f64>().sqrt();
        own.iter().zip(next).for_each(|(node, x)| f[node.place as usize] = x / norm);
    }
    norm - 2.0 * axes.len() as f64
}

/// The largest λ of round and angular bodies of many sizes, places and poses.
fn worst(extrapolation: Extrapolation, is_flat: bool) -> f64 {
    let mut random = Random(7);
    let (bodies, n, largest) = if is_flat { (600, 40, 14.0) } else { (60, 22, 7.0) };
    let one = |k: usize| {
        let cells = if is_flat { [n, 1, n] } else { [n; 3] };
        let grid = Grid::uniform([0.0; 3], cells.map(|n| n as f64), cells, [true; 3]).unwrap();
        let setup = FlowSetup { halo: 7, ..FlowSetup::new(grid, 1.0, 1.0) };
        let subgrid = Subgrid::new(&setup).unwrap();
        let size = 2.0 + (largest - 2.0) * random.next();
        let shape = match (is_flat, k % 3) {
            (true, 0) => Shape::cylinder(size, 1.0, 0.02).unwrap(),
            (true, _) => Shape::cuboid(Vec3::new(size, 1.3 * size, 40.0), 0.02).unwrap(),
            (false, 0) => Shape::sphere(size).unwrap(),
            (false, _) => Shape::cuboid(Vec3::repeat(size), 0.02).unwrap(),
        };
        let mut center = Vec3::from_fn(|_, _| 0.5 * n as f64 + random.next());
        let turn = [random.turn(), random.turn(), random.turn()];
        let rotation: Mat3 = if is_flat {
            center.y = 0.5;
            // The longest axis, that of cylinders in their frame and of boxes in any, is turned to y.
            let long = if k.is_multiple_of(3) { 2 } else { shape.parts[0].half_extents.imax() };
            let upright = Rotation3::rotation_between(&Vec3::ith(long, 1.0), &Vec3::y()).unwrap();
            (Rotation3::from_euler_angles(0.0, turn[0], 0.0) * upright).into_inner()
        } else {
            Rotation3::from_euler_angles(turn[0], turn[1], turn[2]).into_inner()
        };
        let (velocity, spin) = (Vec3::zeros(), Vec3::zeros());
        let body = RigidBody { id: 1, form: Form::Shape(0), scale: 1.0, center, rotation, velocity, spin };
        let mut nodes = Nodes::new(&subgrid);
        let solids = Solids { bodies: &[body], shapes: &[shape], walls: &[], subgrid: &subgrid };
        nodes.find(&solids, extrapolation);
        largest_eigenvalue(&subgrid, &nodes)
    };
    (0..bodies).map(one).fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn forces_settle_about_bodies_in_any_pose() {
    for is_flat in [true, false] {
        for extrapolation in [Extrapolation::Rigid, Extrapolation::Linear, Extrapolation::Quadratic] {
            let found = worst(extrapolation, is_flat);
            assert!(found < 0.0, "{extrapolation:?} {is_flat}: {found}");
        }
        let found = worst(Extrapolation::Cubic, is_flat);
        assert!(found * MAX_DIFFUSION_NUMBER < 1.0, "{is_flat}: {found}");
    }
}
