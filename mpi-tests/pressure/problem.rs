//! Pressure equations with a known answer, and a plain serial solver to compare with.

#![allow(dead_code)] // each test program uses its own part
#![allow(clippy::unwrap_used)]

use grains_comm::Job;
use petsc_rs::{
    Block, Boundary, Grid, LinearSolver, Options, Petsc, PetscError, Preconditioner, PressureMatrix, Settings,
};

/// A function of the place in the unit box.
pub type Function = fn([f64; 3]) -> f64;

/// The unit box, cut into cells.
#[derive(Clone)]
pub struct Problem {
    pub cells: [usize; 3],
    pub boundaries: [[Boundary; 2]; 3],
    /// Edges of the cells along each axis.
    pub edges: [Vec<f64>; 3],
}

/// Arrays of a part of a problem: coefficients of the faces and numbers of the cells.
pub struct Fields {
    pub faces: [Vec<f64>; 3],
    pub rhs: Vec<f64>,
}

pub const NEUMANN: [Boundary; 2] = [Boundary::Neumann; 2];
pub const DIRICHLET: [Boundary; 2] = [Boundary::Dirichlet; 2];
pub const PERIODIC: [Boundary; 2] = [Boundary::Periodic; 2];

/// Ranks along x, y, z.
pub fn divided(size: usize) -> [usize; 3] {
    match size {
        4 => [2, 1, 2],
        8 => [2, 2, 2],
        n => [n, 1, 1],
    }
}

/// Cells of each of `ranks` ranks along an axis, unequal if that can be.
pub fn unequal(cells: usize, ranks: usize) -> Vec<usize> {
    let mut owned = vec![cells / ranks; ranks];
    owned[0] += cells % ranks;
    if ranks > 1 && owned[1] > 2 {
        let moved = owned[1] / 7 + 1;
        owned[0] += moved;
        owned[1] -= moved;
    }
    owned
}

impl Problem {
    pub fn uniform(cells: [usize; 3], boundaries: [[Boundary; 2]; 3]) -> Self {
        let edges = cells.map(|n| (0..=n).map(|i| i as f64 / n as f64).collect());
        Self { cells, boundaries, edges }
    }

    /// Cells that grow smoothly along each axis.
    pub fn stretched(mut self) -> Self {
        let warp = |x: f64| x + 0.1 * (std::f64::consts::TAU * x).sin() / std::f64::consts::TAU * 4.0;
        self.edges.iter_mut().flatten().for_each(|x| *x = warp(*x));
        self
    }

    pub fn widths(&self) -> [Vec<f64>; 3] {
        self.edges.each_ref().map(|list| list.windows(2).map(|pair| pair[1] - pair[0]).collect())
    }

    pub fn whole(&self) -> Block {
        Block { lower: [0; 3], counts: self.cells }
    }

    pub fn grid(&self, petsc: &Petsc, size: usize) -> Grid {
        let ranks = divided(size);
        let owned: Vec<Vec<usize>> = (0..3).map(|a| unequal(self.cells[a], ranks[a])).collect();
        let periodic = self.boundaries.map(|b| b == PERIODIC);
        Grid::new(petsc, [&owned[0], &owned[1], &owned[2]], periodic).unwrap()
    }

    pub fn matrix(&self, grid: &Grid) -> PressureMatrix {
        let widths = self.widths();
        PressureMatrix::new(grid, widths.each_ref().map(|w| &w[..]), self.boundaries).unwrap()
    }

    /// Values at the centres of the cells of a block.
    pub fn at_centres(&self, block: Block, function: impl Fn([f64; 3]) -> f64) -> Vec<f64> {
        let centre = |a: usize, i: usize| 0.5 * (self.edges[a][i] + self.edges[a][i + 1]);
        places(block).map(|cell| function([0, 1, 2].map(|a| centre(a, cell[a])))).collect()
    }

    /// Values at the centres of the faces of a block.
    pub fn at_faces(&self, block: Block, function: impl Fn([f64; 3]) -> f64) -> [Vec<f64>; 3] {
        std::array::from_fn(|axis| {
            let mut faces = block;
            faces.counts[axis] += 1;
            let place = |a: usize, i: usize| match a == axis {
                // A face of a period has one coefficient.
                true if self.boundaries[a] == PERIODIC => self.edges[a][i % self.cells[a]],
                true => self.edges[a][i],
                false => 0.5 * (self.edges[a][i] + self.edges[a][i + 1]),
            };
            places(faces).map(|cell| function([0, 1, 2].map(|a| place(a, cell[a])))).collect()
        })
    }

    pub fn fields(
        &self,
        block: Block,
        coefficient: impl Fn([f64; 3]) -> f64,
        rhs: impl Fn([f64; 3]) -> f64,
    ) -> Fields {
        Fields { faces: self.at_faces(block, coefficient), rhs: self.at_centres(block, rhs) }
    }

    /// Volume-weighted mean of a field over the whole box, and its largest magnitude after taking it away.
    pub fn centred(&self, values: &[f64]) -> Vec<f64> {
        let [x, y, z] = self.widths();
        let volume = |c: [usize; 3]| x[c[0]] * y[c[1]] * z[c[2]];
        let mean: f64 = places(self.whole()).zip(values).map(|(cell, v)| v * volume(cell)).sum();
        values.iter().map(|v| v - mean).collect()
    }

    /// -div(c grad p), integrated over the cells of the whole box.
    fn operator(&self, faces: &[Vec<f64>; 3], p: &[f64]) -> Vec<f64> {
        let (n, widths) = (self.cells, self.widths());
        let strides = [1, n[0], n[0] * n[1]];
        let index = |c: [usize; 3]| c[0] + n[0] * (c[1] + n[1] * c[2]);
        let mut result = vec![0.0; p.len()];
        for cell in places(self.whole()) {
            let mut sum = 0.0;
            for axis in 0..3 {
                let area: f64 = (0..3).filter(|&a| a != axis).map(|a| widths[a][cell[a]]).product();
                let mut extent = n;
                extent[axis] += 1;
                for side in 0..2 {
                    let mut face = cell;
                    face[axis] += side;
                    let c = faces[axis][face[0] + extent[0] * (face[1] + extent[1] * face[2])];
                    let (at, last) = (cell[axis], n[axis] - 1);
                    let is_end = at == side * last;
                    let own = widths[axis][at];
                    let here = p[index(cell)];
                    let (other, distance) = match (is_end, self.boundaries[axis][side]) {
                        (true, Boundary::Neumann) => continue,
                        (true, Boundary::Dirichlet) => (0.0, 0.5 * own),
                        (true, Boundary::Periodic) => {
                            let mut beyond = cell;
                            beyond[axis] = last - at;
                            (p[index(beyond)], 0.5 * (own + widths[axis][last - at]))
                        }
                        (false, _) => {
                            let next = (at + 2 * side) - 1;
                            let place = (index(cell) + 2 * side * strides[axis]) - strides[axis];
                            (p[place], 0.5 * (own + widths[axis][next]))
                        }
                    };
                    sum += c * area / distance * (here - other);
                }
            }
            result[index(cell)] = sum;
        }
        result
    }

    /// The discrete answer on the whole box by plain conjugate gradients to rounding.
    pub fn reference(&self, fields: &Fields) -> Vec<f64> {
        let [x, y, z] = self.widths();
        let volume = |c: [usize; 3]| x[c[0]] * y[c[1]] * z[c[2]];
        let mut r: Vec<f64> =
            places(self.whole()).zip(&fields.rhs).map(|(cell, f)| -f * volume(cell)).collect();
        let is_singular = !self.boundaries.as_flattened().contains(&Boundary::Dirichlet);
        let balance = |r: &mut Vec<f64>| {
            if is_singular {
                let mean = r.iter().sum::<f64>() / r.len() as f64;
                r.iter_mut().for_each(|v| *v -= mean);
            }
        };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        balance(&mut r);
        let (mut p, mut d) = (vec![0.0; r.len()], r.clone());
        let (mut now, first) = (dot(&r, &r), dot(&r, &r));
        // Rounding ends the progress at 1e-14 or so.
        for _ in 0..2000 {
            if now < 1e-27 * first {
                break;
            }
            let q = self.operator(&fields.faces, &d);
            let alpha = now / dot(&d, &q);
            p.iter_mut().zip(&d).for_each(|(p, d)| *p += alpha * d);
            r.iter_mut().zip(&q).for_each(|(r, q)| *r -= alpha * q);
            balance(&mut r);
            let next = dot(&r, &r);
            let beta = next / now;
            d.iter_mut().zip(&r).for_each(|(d, r)| *d = r + beta * *d);
            now = next;
        }
        if is_singular { self.centred(&p) } else { p }
    }
}

/// Cells of a block, x fastest.
pub fn places(block: Block) -> impl Iterator<Item = [usize; 3]> {
    let [x, y, z] = [0, 1, 2].map(|a| block.lower[a]..block.lower[a] + block.counts[a]);
    z.flat_map(move |k| {
        let x = x.clone();
        y.clone().flat_map(move |j| x.clone().map(move |i| [i, j, k]))
    })
}

/// The entries of a block of an array of the whole box.
pub fn part(whole: &[f64], cells: [usize; 3], block: Block) -> Vec<f64> {
    places(block).map(|[i, j, k]| whole[i + cells[0] * (j + cells[1] * k)]).collect()
}

/// PETSc on all ranks of a job.
pub fn petsc(job: &Job, options: &str) -> Petsc {
    Petsc::start(job.world(), &Options::parse(options).unwrap()).unwrap()
}

/// A multigrid solver for a problem, with its coefficients set.
pub fn solver(
    problem: &Problem,
    grid: &Grid,
    settings: &Settings,
    faces: &[Vec<f64>; 3],
) -> Result<LinearSolver, PetscError> {
    let mut solver = LinearSolver::new(problem.matrix(grid), settings, Preconditioner::Multigrid)?;
    solver.set_coefficients(faces.each_ref().map(|list| &list[..]))?;
    Ok(solver)
}

/// The largest of a number over all ranks.
pub fn largest(job: &Job, value: f64) -> f64 {
    use grains_domain::Transport;
    let mut values = [value];
    job.new_transport().max(&mut values);
    values[0]
}

/// The largest difference of two lists.
pub fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |m, (a, b)| m.max((a - b).abs()))
}

/// Numbers of ranks of most tests.
pub const EVERY: [usize; 3] = [1, 2, 4];

/// A tolerance near rounding.
pub fn tight() -> Settings {
    Settings { tolerance: 1e-12, ..Settings::default() }
}

/// Solves on the own block; returns pressure, iterations and the solver.
pub fn solve(
    problem: &Problem,
    grid: &Grid,
    fields: &Fields,
    settings: &Settings,
) -> (Vec<f64>, usize, LinearSolver) {
    let mut solver = solver(problem, grid, settings, &fields.faces).unwrap();
    let mut pressure = vec![0.0; fields.rhs.len()];
    let report = solver.solve(&fields.rhs, &mut pressure).unwrap();
    assert!(report.residual <= settings.tolerance, "{report:?}");
    (pressure, report.iterations, solver)
}

/// A bed with void fraction 0.4 in its lower part under free fluid: blocks of it along all axes.
pub fn bed([x, y, z]: [f64; 3]) -> f64 {
    if z < 0.55 && x + 0.3 * y > 0.21 { 0.4 } else { 1.0 }
}

/// A right-hand side without structure.
pub fn rough([x, y, z]: [f64; 3]) -> f64 {
    (37.0 * x + 91.0 * y * y + 53.0 * x * z).sin() + 0.3 * (400.0 * (x + 2.0 * y + 3.0 * z)).cos()
}
