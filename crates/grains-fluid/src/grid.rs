//! Global Cartesian grid: cells per axis, uniform or stretched.

use crate::SetupError;

/// Names of the axes.
pub(crate) const AXES: [char; 3] = ['x', 'y', 'z'];

/// One axis of the grid: cells between ascending nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    nodes: Vec<f64>,
    periodic: bool,
    uniform: bool,
}

impl Axis {
    /// `cells` equal cells between two ends (m).
    pub fn uniform(lower: f64, upper: f64, cells: usize, periodic: bool) -> Self {
        let at = |k: usize| lower + (upper - lower) * (k as f64 / cells.max(1) as f64);
        let nodes = (0..=cells).map(|k| if k == cells { upper } else { at(k) }).collect();
        Self { nodes, periodic, uniform: true }
    }

    /// Cells between given nodes (m), ascending.
    pub fn stretched(nodes: Vec<f64>, periodic: bool) -> Self {
        let n = nodes.len().max(2) - 1;
        let mean = nodes.last().zip(nodes.first()).map_or(0.0, |(b, a)| (b - a) / n as f64);
        let uniform = nodes.windows(2).all(|w| (w[1] - w[0] - mean).abs() <= 1e-12 * mean.abs());
        Self { nodes, periodic, uniform }
    }

    /// `cells` cells refined towards both ends by [`clustered`], `strength` s > 0.
    pub fn clustered(lower: f64, upper: f64, cells: usize, strength: f64) -> Self {
        let at = |k: usize| lower + clustered(k as f64 / cells as f64, strength) * (upper - lower);
        Self::stretched((0..=cells).map(at).collect(), false)
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.nodes.len().saturating_sub(1)
    }

    /// Nodes (m), cells + 1 ascending numbers.
    pub fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    /// Whether the axis is periodic.
    pub fn is_periodic(&self) -> bool {
        self.periodic
    }

    /// Whether all cells are equally wide.
    pub fn is_uniform(&self) -> bool {
        self.uniform
    }

    /// Length (m).
    pub fn length(&self) -> f64 {
        self.nodes[self.cells()] - self.nodes[0]
    }

    /// Coordinate (m) of node `i`, continued periodically or by reflection beyond the ends.
    pub fn node(&self, i: isize) -> f64 {
        let n = self.cells() as isize;
        if (0..=n).contains(&i) {
            return self.nodes[i as usize];
        }
        if self.periodic {
            return self.nodes[i.rem_euclid(n) as usize] + self.length() * i.div_euclid(n) as f64;
        }
        let end = if i < 0 { 0 } else { n };
        2.0 * self.nodes[end as usize] - self.node((2 * end - i).clamp(0, n))
    }

    /// Width (m) of cell `i`, continued beyond the ends.
    pub fn width(&self, i: isize) -> f64 {
        let n = self.cells() as isize;
        if self.uniform {
            return self.length() / n as f64;
        }
        let inside = match (self.periodic, i) {
            (true, _) => i.rem_euclid(n),
            (false, i) if i < 0 => (-1 - i).min(n - 1),
            (false, i) => {
                if i >= n {
                    (2 * n - 1 - i).max(0)
                } else {
                    i
                }
            }
        } as usize;
        self.nodes[inside + 1] - self.nodes[inside]
    }

    /// Centre (m) of cell `i`, continued beyond the ends.
    pub fn centre(&self, i: isize) -> f64 {
        0.5 * (self.node(i) + self.node(i + 1))
    }

    /// Ghost of a velocity along a wall, [of the imposed value, of the first cell, of the second]: the parabola through
    /// the three, so that Poiseuille flow is exact on any grid. `side` is 0 for the lower end.
    pub(crate) fn wall_weights(&self, side: usize) -> [f64; 3] {
        let n = self.cells() as isize;
        if n < 2 {
            return [2.0, -1.0, 0.0];
        }
        let [first, second] = if side == 0 { [0, 1] } else { [n - 1, n - 2] };
        let near = 0.5 * self.width(first);
        let far = 2.0 * near + 0.5 * self.width(second);
        let between = far - near;
        [2.0 * (near + far) / far, 1.0 - 2.0 * far / between, 2.0 * near * near / (far * between)]
    }

    fn check(&self, axis: usize) -> Result<(), SetupError> {
        let bad = |index: usize| SetupError::Nodes {
            axis: AXES[axis],
            index,
            value: self.nodes.get(index).copied().unwrap_or(f64::NAN),
        };
        if self.nodes.len() < 2 {
            return Err(bad(0));
        }
        match (1..self.nodes.len()).find(|&k| {
            !(self.nodes[k] > self.nodes[k - 1] && self.nodes[k].is_finite() && self.nodes[k - 1].is_finite())
        }) {
            Some(k) => Err(bad(k)),
            None => Ok(()),
        }
    }
}

/// Place of a node on an axis refined towards both ends, x/L = ½ (1 + tanh(s ξ)/tanh s) with ξ = 2 k/n − 1 (-), from its
/// share k/n of the cells (-) and the strength s > 0 of the refinement (-).
pub fn clustered(share: f64, strength: f64) -> f64 {
    0.5 * (1.0 + (strength * (2.0 * share - 1.0)).tanh() / strength.tanh())
}

/// The global grid; an axis of one cell makes the flow two-dimensional.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    axes: [Axis; 3],
}

impl Grid {
    /// Grid of three axes, x, y, z.
    pub fn new(axes: [Axis; 3]) -> Result<Self, SetupError> {
        (0..3).try_for_each(|a| axes[a].check(a))?;
        Ok(Self { axes })
    }

    /// Uniform grid of a box.
    pub fn uniform(
        lower: [f64; 3],
        upper: [f64; 3],
        cells: [usize; 3],
        periodic: [bool; 3],
    ) -> Result<Self, SetupError> {
        Self::new(std::array::from_fn(|a| Axis::uniform(lower[a], upper[a], cells[a], periodic[a])))
    }

    /// An axis.
    pub fn axis(&self, axis: usize) -> &Axis {
        &self.axes[axis]
    }

    /// Global number of cells per axis.
    pub fn cells(&self) -> [usize; 3] {
        std::array::from_fn(|a| self.axes[a].cells())
    }

    /// Whether the flow varies along an axis (more than one cell).
    pub fn is_active(&self, axis: usize) -> bool {
        self.axes[axis].cells() > 1
    }

    /// Volume of the box (m³).
    pub fn volume(&self) -> f64 {
        self.axes.iter().map(Axis::length).product()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_beyond_the_ends_are_mirrored_or_repeated() {
        let nodes = vec![0.0, 1.0, 3.0, 6.0];
        let closed = Axis::stretched(nodes.clone(), false);
        assert_eq!([closed.width(-1), closed.width(-2), closed.width(3)], [1.0, 2.0, 3.0]);
        assert_eq!([closed.centre(-1), closed.centre(3)], [-0.5, 7.5]);
        let round = Axis::stretched(nodes, true);
        assert_eq!([round.width(-1), round.width(3), round.node(-1), round.node(5)], [3.0, 1.0, -3.0, 9.0]);
    }

    #[test]
    fn nodes_must_ascend() {
        let ok = Axis::uniform(0.0, 1.0, 2, false);
        let bad = Axis::stretched(vec![0.0, 2.0, 1.0], false);
        let error = Grid::new([ok.clone(), bad, ok]).unwrap_err();
        assert!(error.to_string().contains("along y: node 2"), "{error}");
    }
}
