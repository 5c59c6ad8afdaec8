//! Projected and longitudinal areas on a grid of directions.
//!
//! Areas do not change when a direction is turned round, so three faces of a cube hold all directions: that of the
//! largest component a, with (u, v) the other two over it. One row of nodes beyond each edge lets the same rule
//! work everywhere; as it holds true areas, the values of two cube faces agree along their common edge.

use grains_geometry::{Mat3, Vec3};
use std::f64::consts::PI;

/// Intervals along an edge of a cube face.
const CELLS: usize = 24;
/// Nodes along an edge, one beyond either end.
const NODES: usize = CELLS + 3;
/// Directions of the circle over which longitudinal areas are averaged; half a turn.
const CIRCLE: usize = 90;
/// Every so many cells the error is measured.
const SAMPLED: usize = 2;

/// How values between nodes follow from those at nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rule {
    /// Straight between the two nodes: keeps the kinks that flat faces make.
    Linear,
    /// Cubic through four nodes, with continuous slopes.
    Cubic,
}

/// Relative error of a table, measured between its nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TableError {
    /// Largest (-).
    pub largest: f64,
    /// Root mean square (-).
    pub rms: f64,
}

/// Areas (m²) by direction.
#[derive(Clone, Debug)]
pub(super) struct Table {
    /// Projected and longitudinal area at node (face, v, u), u fastest (m²).
    nodes: Vec<[f64; 2]>,
    rule: Rule,
    /// Errors of the projected and the longitudinal area.
    pub(super) errors: [TableError; 2],
}

impl Table {
    /// Tabulates projected areas (m²) given by unit direction; of the two rules the one with the smaller largest error
    /// stays.
    pub(super) fn new(area: impl Fn(&Vec3) -> f64) -> Self {
        let nodes = directions().map(|d| [area(&d.normalize()), 0.0]).collect();
        let mut table = Self { nodes, rule: Rule::Linear, errors: [TableError::default(); 2] };
        let samples: Vec<Vec3> = middles().step_by(SAMPLED).map(|d| d.normalize()).collect();
        let truth: Vec<f64> = samples.iter().map(&area).collect();
        let linear = table.measure(&samples, 0, &truth);
        table.rule = Rule::Cubic;
        let cubic = table.measure(&samples, 0, &truth);
        if linear.largest < cubic.largest {
            table.rule = Rule::Linear;
        }
        let longitudinal: Vec<f64> = directions().map(|d| table.circle_mean(&d.normalize())).collect();
        for (node, mean) in table.nodes.iter_mut().zip(longitudinal) {
            node[1] = mean;
        }
        let means: Vec<f64> = samples.iter().map(|d| table.circle_mean(d)).collect();
        table.errors = [0, 1].map(|k| table.measure(&samples, k, [&truth, &means][k]));
        table
    }

    /// Projected and longitudinal area (m²) along a direction, of any length but 0.
    pub(super) fn areas(&self, direction: &Vec3) -> [f64; 2] {
        let axis = direction.iamax();
        let scale = 0.5 * CELLS as f64 / direction[axis];
        let place = |a: usize| {
            let at = direction[a % 3] * scale + 0.5 * CELLS as f64;
            let cell = (at as usize).min(CELLS - 1);
            (cell, self.rule.weights(at - cell as f64))
        };
        let ((i, wu), (j, wv)) = (place(axis + 1), place(axis + 2));
        let mut sum = [0.0; 2];
        for (row, v) in wv.iter().enumerate() {
            let first = (axis * NODES + j + row) * NODES + i;
            let mut along = [0.0; 2];
            for (node, u) in self.nodes[first..first + 4].iter().zip(&wu) {
                along[0] += u * node[0];
                along[1] += u * node[1];
            }
            sum[0] += v * along[0];
            sum[1] += v * along[1];
        }
        sum
    }

    /// Errors at the samples of the projected (0) or longitudinal (1) area, given the true ones.
    fn measure(&self, samples: &[Vec3], which: usize, truth: &[f64]) -> TableError {
        let errors = samples.iter().zip(truth).map(|(d, area)| (self.areas(d)[which] / area - 1.0).abs());
        let (largest, squares) = errors.fold((0.0f64, 0.0), |(m, s), e| (m.max(e), s + e * e));
        TableError { largest, rms: (squares / samples.len() as f64).sqrt() }
    }

    /// Mean of the projected areas along the directions normal to a unit vector (m²).
    fn circle_mean(&self, direction: &Vec3) -> f64 {
        let (across, up) = plane(direction);
        let angles = (0..CIRCLE).map(|k| PI * k as f64 / CIRCLE as f64);
        angles.map(|t| self.areas(&(across * t.cos() + up * t.sin()))[0]).sum::<f64>() / CIRCLE as f64
    }
}

impl Rule {
    /// Weights of the nodes before, at, after and beyond, at a share `t` of the interval.
    fn weights(self, t: f64) -> [f64; 4] {
        match self {
            Self::Linear => [0.0, 1.0 - t, t, 0.0],
            Self::Cubic => {
                let s = 1.0 - t;
                [-0.5 * t * s * s, s * (1.0 + t - 1.5 * t * t), t * (1.0 + s - 1.5 * s * s), -0.5 * s * t * t]
            }
        }
    }
}

/// Two unit vectors that make a right-handed frame with a third.
pub(super) fn plane(direction: &Vec3) -> (Vec3, Vec3) {
    let across = direction.cross(&Vec3::ith(direction.iamin(), 1.0)).normalize();
    (across, direction.cross(&across))
}

/// Directions of all nodes, not of unit length.
fn directions() -> impl Iterator<Item = Vec3> {
    let at = |k: usize| (k as f64 - 1.0) * 2.0 / CELLS as f64 - 1.0;
    grid(NODES, at)
}

/// Directions of the middles of all cells.
fn middles() -> impl Iterator<Item = Vec3> {
    grid(CELLS, |k| (k as f64 + 0.5) * 2.0 / CELLS as f64 - 1.0)
}

fn grid(count: usize, at: impl Fn(usize) -> f64 + Copy) -> impl Iterator<Item = Vec3> {
    let axes = Mat3::identity();
    (0..3 * count * count).map(move |n| {
        let (axis, j, i) = (n / (count * count), n / count % count, n % count);
        axes.column(axis) + axes.column((axis + 1) % 3) * at(i) + axes.column((axis + 2) % 3) * at(j)
    })
}
