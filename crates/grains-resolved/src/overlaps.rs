//! Products C Cᵀ of rows that share places of the grid: a few numbers per row, in place of all the velocities that it reaches to.

use crate::Subgrid;
use crate::constraints::Constraints;

/// Places along an axis by which stencils that share some differ at most.
const APART: i32 = 2;

/// Products of all pairs of rows of which one at least is alone; the field stands for the other pairs.
#[derive(Debug, Default)]
pub(crate) struct Overlaps {
    /// C_i · C_i of all rows.
    pub squares: Vec<f64>,
    /// Rows, each with the end of its products.
    rows: Vec<(u32, u32)>,
    /// The other rows of the pairs, none twice.
    others: Vec<u32>,
    products: Vec<f64>,
    is_shared: Vec<bool>,
    bins: Bins,
}

/// Rows of a component in bins three places wide, line by line of bins along x.
#[derive(Debug, Default)]
struct Bins {
    dims: [usize; 3],
    /// Where the rows of each bin begin.
    starts: Vec<u32>,
    /// Rows with the indices of their first places above those of the array.
    rows: Vec<(u32, [i32; 3])>,
}

impl Overlaps {
    /// Finds the products of all rows.
    pub fn find(&mut self, constraints: &Constraints, subgrid: &Subgrid) {
        let Self { squares, rows, others, products, is_shared, bins } = self;
        squares.clear();
        squares.extend(constraints.stencils.iter().map(|stencil| stencil.square()));
        is_shared.clear();
        is_shared.resize(squares.len(), false);
        constraints.blocks.iter().for_each(|block| is_shared[block.shared.clone()].fill(true));
        rows.clear();
        others.clear();
        products.clear();
        for component in (0..3).filter(|&c| subgrid.active[c]) {
            bins.fill(component, constraints, subgrid);
            for (number, &(row, at)) in bins.rows.iter().enumerate() {
                let windows = constraints.stencils[row as usize].windows();
                for &(other, there) in bins.around(number, at) {
                    let apart: [i32; 3] = std::array::from_fn(|a| there[a] - at[a]);
                    let is_near = apart.iter().all(|d| d.abs() <= APART);
                    if is_near && !(is_shared[row as usize] && is_shared[other as usize]) {
                        others.push(other);
                        products.push(windows.overlap(&constraints.stencils[other as usize], apart));
                    }
                }
                rows.push((row, others.len() as u32));
            }
        }
    }

    /// Adds C Cᵀ Λ of the pairs.
    pub fn multiply(&self, values: &[f64], result: &mut [f64]) {
        let mut start = 0;
        for &(row, end) in &self.rows {
            let (row, range) = (row as usize, start..end as usize);
            let value = values[row];
            let mut sum = if self.is_shared[row] { 0.0 } else { self.squares[row] * value };
            for (&other, product) in self.others[range.clone()].iter().zip(&self.products[range.clone()]) {
                sum += product * values[other as usize];
                result[other as usize] += product * value;
            }
            result[row] += sum;
            start = range.end;
        }
    }
}

impl Bins {
    /// Takes the rows of a component.
    fn fill(&mut self, component: usize, constraints: &Constraints, subgrid: &Subgrid) {
        let wide = (APART + 1) as usize;
        let strides = subgrid.layout.strides();
        // A bin more on each side: those around are there.
        self.dims = subgrid.layout.dims().map(|n| n.div_ceil(wide) + 2);
        let [nx, ny, nz] = self.dims;
        self.starts.clear();
        self.starts.resize(nx * ny * nz + 1, 0);
        let blocks = || constraints.blocks.iter().filter(|block| usize::from(block.component) == component);
        let placed = || {
            blocks().flat_map(|block| block.rows()).map(|row| {
                let place = constraints.stencils[row].first as usize;
                let at = [place % strides[1], place % strides[2] / strides[1], place / strides[2]];
                (row as u32, at.map(|i| i as i32))
            })
        };
        let bin = |at: [i32; 3]| {
            let [i, j, k] = at.map(|i| i as usize / wide + 1);
            (k * ny + j) * nx + i
        };
        placed().for_each(|(_, at)| self.starts[bin(at) + 1] += 1);
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        // Each start moves to the end of its bin, from where it is found again below.
        self.rows.clear();
        self.rows.resize(sum as usize, (0, [0; 3]));
        for (row, at) in placed() {
            let start = &mut self.starts[bin(at)];
            self.rows[*start as usize] = (row, at);
            *start += 1;
        }
        self.starts.rotate_right(1);
        self.starts[0] = 0;
    }

    /// Rows after the one of this number, in its bin and those around.
    fn around(&self, number: usize, at: [i32; 3]) -> impl Iterator<Item = &(u32, [i32; 3])> {
        let [nx, ny, _] = self.dims;
        let [i, j, k] = at.map(|i| (i / (APART + 1) + 1) as usize);
        let line = |j: usize, k: usize| {
            let bin = (k * ny + j) * nx + i;
            self.starts[bin - 1] as usize..self.starts[bin + 2] as usize
        };
        let own = number + 1..line(j, k).end;
        [own, line(j + 1, k), line(j - 1, k + 1), line(j, k + 1), line(j + 1, k + 1)]
            .into_iter()
            .flat_map(|range| &self.rows[range])
    }
}
