//! The cells of one rank along one axis, and the weights of a kernel on them.

use super::function::Kernel;
use crate::CouplingError;

/// Largest number of cells along an axis that a kernel may cover.
pub const MAX_CELLS: usize = 32;

/// Weights along x are multiplied so many at a time.
pub(super) const LANES: usize = 4;

/// Room for the faces of the largest number of cells.
const PADDED: usize = (MAX_CELLS + 1).next_multiple_of(LANES);

/// What lies beyond the last cell of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// More cells, of another rank or of the periodic image: the halo ends here.
    Halo,
    /// A boundary of the domain: wall, inlet or outlet. Kernels are mirrored at it.
    Boundary,
}

/// The cells of one rank along an axis, with its halo but without cells beyond a boundary of the domain.
#[derive(Clone, Debug, PartialEq)]
pub struct GridAxis {
    /// Faces of the cells (m), ascending: cells + 1 numbers, and a group of infinite ones.
    nodes: Vec<f64>,
    ends: [End; 2],
    /// Cells per metre of a uniform axis.
    per_length: Option<f64>,
}

impl Kernel {
    /// Whether the kernel is of an allowed width and the largest particle of a case fits the cells: covers no more than
    /// [`MAX_CELLS`] along any axis.
    ///
    /// `diameter` is the largest equivalent diameter (m). Errors: [`CouplingError::OutOfRange`], [`CouplingError::TooManyCells`].
    pub fn check(&self, axes: &[GridAxis; 3], diameter: f64) -> Result<(), CouplingError> {
        self.check_width()?;
        let reach = self.reach(diameter);
        for (a, axis) in axes.iter().enumerate() {
            let cell = axis.smallest_cell();
            let cells = ((2.0 * reach / cell).ceil() as usize + 1).min(axis.cells());
            if cells > MAX_CELLS {
                let axis = ['x', 'y', 'z'][a];
                return Err(CouplingError::TooManyCells { axis, reach, cell, cells, max: MAX_CELLS });
            }
        }
        Ok(())
    }
}

/// Weights of a run of cells or faces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    pub(super) first: usize,
    pub(super) count: usize,
    /// Beyond `count` zeros, to the next multiple of [`LANES`].
    pub(super) values: [f64; PADDED],
}

impl Weights {
    pub(super) const NONE: Self = Self { first: 0, count: 0, values: [0.0; PADDED] };

    #[inline(always)]
    pub(super) fn slice(&self) -> &[f64] {
        &self.values[..self.count]
    }

    /// The same in groups; zeros fill the last one.
    #[inline(always)]
    pub(super) fn groups(&self) -> &[[f64; LANES]] {
        self.values[..self.count.next_multiple_of(LANES)].as_chunks().0
    }
}

impl GridAxis {
    /// Cells between ascending nodes (m) of axis `axis` (0, 1, 2), and what lies beyond both ends.
    ///
    /// Errors: fewer than two nodes, nodes that are not finite or do not ascend.
    pub fn new(axis: usize, nodes: Vec<f64>, ends: [End; 2]) -> Result<Self, CouplingError> {
        let bad = |reason: String| CouplingError::BadNodes { axis: ['x', 'y', 'z'][axis], reason };
        if nodes.len() < 2 {
            return Err(bad(format!("there are {}", nodes.len())));
        }
        if let Some(k) = (1..nodes.len()).find(|&k| !(nodes[k] > nodes[k - 1] && nodes[k].is_finite())) {
            return Err(bad(format!("nodes {} and {k} are {:e} and {:e} m", k - 1, nodes[k - 1], nodes[k])));
        }
        let cells = nodes.len() - 1;
        let mean = (nodes[cells] - nodes[0]) / cells as f64;
        let even = |k: usize| (nodes[k] - nodes[0] - k as f64 * mean).abs() < 1e-9 * mean;
        let per_length = (0..=cells).all(even).then(|| 1.0 / mean);
        let padding = [f64::INFINITY; LANES];
        Ok(Self { nodes: [&nodes[..], &padding].concat(), ends, per_length })
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.nodes.len() - LANES - 1
    }

    /// Faces of the cells (m).
    pub fn nodes(&self) -> &[f64] {
        &self.nodes[..=self.cells()]
    }

    /// Width of the smallest cell (m).
    pub fn smallest_cell(&self) -> f64 {
        self.nodes().windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min)
    }

    /// Cell that holds a coordinate (m), the first or last one for those beyond.
    #[inline(always)]
    fn cell_of(&self, x: f64) -> usize {
        let last = self.cells() - 1;
        match self.per_length {
            Some(per_length) => {
                let mut cell = (((x - self.nodes[0]) * per_length).max(0.0) as usize).min(last);
                // The division may be off by one next to a node.
                if cell > 0 && x < self.nodes[cell] {
                    cell -= 1;
                } else if cell < last && x >= self.nodes[cell + 1] {
                    cell += 1;
                }
                cell
            }
            None => self.nodes[1..=last].partition_point(|&node| node <= x),
        }
    }

    /// Weights of the cells under a kernel about `x` (m) that reaches `reach` (m), of the inverse `per_reach` (1/m); their sum is 1.
    ///
    /// Errors: a kernel that leaves the halo.
    #[inline(always)]
    pub(super) fn spread(
        &self,
        (kernel, axis): (&Kernel, usize),
        x: f64,
        [reach, per_reach]: [f64; 2],
        weights: &mut Weights,
    ) -> Result<(), CouplingError> {
        let (lower, upper) = (self.nodes[0], self.nodes[self.cells()]);
        let is_out = |end: End, beyond: bool| end == End::Halo && beyond;
        let (below, above) = (x - reach < lower, x + reach > upper);
        if is_out(self.ends[0], below) || is_out(self.ends[1], above) || !x.is_finite() {
            let axis = ['x', 'y', 'z'][axis];
            return Err(CouplingError::OutsideHalo { axis, place: x, reach, lower, upper });
        }
        // A particle pressed into a wall stays where the fluid is.
        let x = x.clamp(lower, upper);
        let (first, last) = (self.cell_of(x - reach), self.cell_of(x + reach));
        // The set-up has checked the largest particle, so that this never cuts anything off.
        let count = (last - first + 1).min(MAX_CELLS);
        (weights.first, weights.count) = (first, count);
        let share = |node: f64| kernel.below((node - x) * per_reach);
        let mut before = share(self.nodes[first]);
        for group in 0..count.div_ceil(LANES) {
            let at = group * LANES;
            let shares: [f64; LANES] = std::array::from_fn(|lane| share(self.nodes[first + at + 1 + lane]));
            for lane in 0..LANES {
                let below = if lane == 0 { before } else { shares[lane - 1] };
                weights.values[at + lane] = (shares[lane] - below).max(0.0);
            }
            before = shares[LANES - 1];
        }
        weights.values[count..count.next_multiple_of(LANES)].fill(0.0);
        if below || above {
            self.complete([below, above], share, weights);
        }
        Ok(())
    }

    /// Adds what of the kernel lies beyond boundaries, and makes the sum 1.
    #[cold]
    fn complete(&self, [below, above]: [bool; 2], share: impl Fn(f64) -> f64, weights: &mut Weights) {
        if below {
            self.mirror(self.nodes[0], &share, weights);
        }
        if above {
            self.mirror(self.nodes[self.cells()], &share, weights);
        }
        let values = &mut weights.values[..weights.count];
        let per_sum = 1.0 / values.iter().sum::<f64>();
        values.iter_mut().for_each(|w| *w *= per_sum);
    }

    /// Adds to each cell what of the kernel lies in its mirror image beyond a boundary at `wall` (m).
    fn mirror(&self, wall: f64, share: impl Fn(f64) -> f64, weights: &mut Weights) {
        let first = weights.first;
        let image = |k: usize| share(2.0 * wall - self.nodes[first + k]);
        let mut before = image(0);
        for k in 0..weights.count {
            let after = image(k + 1);
            weights.values[k] += (before - after).max(0.0);
            before = after;
        }
    }

    /// Whether the lower face of the first of these cells and the upper one of the last lie on a boundary of the domain. A single cell
    /// between two boundaries has no other face to pass its share to.
    #[inline(always)]
    pub(super) fn is_on_boundary(&self, cells: &Weights) -> [bool; 2] {
        let [lower, upper] = self.ends.map(|end| end == End::Boundary && self.cells() > 1);
        [lower && cells.first == 0, upper && cells.first + cells.count == self.cells()]
    }
}

impl Weights {
    /// Weights of the faces: half of the cell on either side. Those on a boundary pass their shares on inwards.
    #[inline(always)]
    pub(super) fn spread_to_faces(&self, is_on_boundary: [bool; 2], faces: &mut Self) {
        (faces.first, faces.count) = (self.first, self.count + 1);
        let mut before = 0.0;
        for (face, &cell) in faces.values.iter_mut().zip(self.slice()) {
            let half = 0.5 * cell;
            *face = before + half;
            before = half;
        }
        faces.values[self.count] = before;
        faces.values[faces.count..faces.count.next_multiple_of(LANES)].fill(0.0);
        if is_on_boundary[0] {
            faces.values[1] += std::mem::take(&mut faces.values[0]);
        }
        if is_on_boundary[1] {
            faces.values[self.count - 1] += std::mem::take(&mut faces.values[self.count]);
        }
    }
}
