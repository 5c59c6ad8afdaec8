//! Seconds of setup, re-assembly and solve, and iterations, of a closed box with a bed of void fraction 0.4.
//!
//! `mpirun -n 2 target/release/examples/pressure_speed 64 [multigrid|algebraic] [-- options of PETSc]`

use grains_comm::Job;
use mpi::traits::{Communicator, CommunicatorCollectives};
use petsc_rs::{
    Boundary, Grid, LinearSolver, Options, Petsc, PetscError, Preconditioner, PressureMatrix, Settings,
};
use std::time::Instant;

/// Solves timed for each kind.
const REPEATS: usize = 8;

fn main() {
    let job = Job::start(|| false).expect("MPI starts");
    if let Err(error) = run(&job) {
        eprintln!("error: {error}");
        grains_comm::abort(2);
    }
}

fn run(job: &Job) -> Result<(), PetscError> {
    let arguments: Vec<String> = std::env::args().collect();
    let cells: usize = arguments.get(1).and_then(|text| text.parse().ok()).unwrap_or(64);
    let is_algebraic = arguments.get(2).is_some_and(|word| word == "algebraic");
    let preconditioner = if is_algebraic { Preconditioner::Algebraic } else { Preconditioner::Multigrid };
    let petsc = Petsc::start(job.world(), &Options::default().with_command_line(arguments))?;
    let ranks = job.size();
    let along_z: Vec<usize> = (0..ranks).map(|r| cells * (r + 1) / ranks - cells * r / ranks).collect();
    let grid = Grid::new(&petsc, [&[cells], &[cells], &along_z], [false; 3])?;
    let widths = vec![1.0 / cells as f64; cells];
    let begun = Instant::now();
    let matrix = PressureMatrix::new(&grid, [&widths, &widths, &widths], [[Boundary::Neumann; 2]; 3])?;
    let settings = Settings { tolerance: 1e-8, ..Settings::default() };
    let faces = faces(&grid, cells);
    let faces = faces.each_ref().map(|list| &list[..]);
    let mut solver = LinearSolver::new(matrix, &settings, preconditioner)?;
    solver.set_coefficients(faces)?;
    solver.set_up()?;
    let setup = begun.elapsed().as_secs_f64();
    petsc.check_options()?;
    let rhs = rough(&grid);
    let mut pressure = vec![0.0; rhs.len()];
    let mut iterations = 0;
    let solve = seconds(job, || {
        pressure.fill(0.0);
        iterations = solver.solve(&rhs, &mut pressure)?.iterations;
        Ok(())
    })?;
    let matrix = seconds(job, || solver.set_coefficients(faces))?;
    let renewal = seconds(job, || {
        solver.set_coefficients(faces)?;
        solver.set_up()
    })?;
    if job.world().rank() == 0 {
        println!(
            "{cells}^3 on {ranks} ranks, PETSc {}, {} levels: setup {setup:.3} s, solve {solve:.4} s with {iterations} iterations to 1e-8, new coefficients {matrix:.4} s, with a new preconditioner {renewal:.4} s",
            Petsc::version(),
            solver.levels()
        );
    }
    Ok(())
}

/// Least seconds of an action: on a machine with other work the mean says little.
fn seconds(job: &Job, mut action: impl FnMut() -> Result<(), PetscError>) -> Result<f64, PetscError> {
    let mut least = f64::INFINITY;
    for _ in 0..REPEATS {
        job.world().barrier();
        let begun = Instant::now();
        action()?;
        job.world().barrier();
        least = least.min(begun.elapsed().as_secs_f64());
    }
    Ok(least)
}

/// Coefficients of the own faces: 0.4 in the lower half, 1 above.
fn faces(grid: &Grid, cells: usize) -> [Vec<f64>; 3] {
    let own = grid.owned();
    std::array::from_fn(|axis| {
        let mut counts = own.counts;
        counts[axis] += 1;
        let plane = counts[0] * counts[1];
        let void = |index: usize| if 2 * (own.lower[2] + index / plane) < cells { 0.4 } else { 1.0 };
        (0..plane * counts[2]).map(void).collect()
    })
}

/// A right-hand side without structure.
fn rough(grid: &Grid) -> Vec<f64> {
    let own = grid.owned();
    let first = own.lower[2] * own.counts[0] * own.counts[1];
    let count = own.counts.iter().product::<usize>();
    (first..first + count).map(|index| ((index * index % 1_000_003) as f64 * 0.7).sin()).collect()
}
