//! Preconditioners, options and errors of the solver of the pressure equation, on 1, 2 and 4 ranks.

#![allow(clippy::unwrap_used)]

#[path = "pressure/problem.rs"]
mod problem;
mod ranks;

use grains_comm::Job;
use petsc_rs::{LinearSolver, Options, Petsc, PetscError, Preconditioner, Settings};
use problem::{
    EVERY, Fields, Function, NEUMANN, Problem, bed, difference, petsc, rough, solve, solver, tight,
};
use ranks::on_ranks;
use std::cell::RefCell;
use std::f64::consts::PI;
use std::rc::Rc;

/// The preconditioner is kept for a number of solves with changed coefficients, and is still good.
#[test]
fn the_preconditioner_is_kept_as_long_as_asked() {
    on_ranks(&[1, 2], "the_preconditioner_is_kept_as_long_as_asked", |job| {
        let petsc = petsc(job, "");
        let problem = Problem::uniform([32; 3], [NEUMANN; 3]);
        let grid = problem.grid(&petsc, job.size());
        for (reuse, builds) in [(0, 7), (2, 4), (100, 1)] {
            let settings = Settings { reuse, tolerance: 1e-8, ..Settings::default() };
            let fields = problem.fields(grid.owned(), bed, rough);
            let (_, fresh, mut solver) = solve(&problem, &grid, &fields, &settings);
            let mut worst = 0;
            for step in 1..=6 {
                let void = |x: [f64; 3]| bed(x) * (1.0 + 0.02 * f64::from(step) * (5.0 * x[0]).sin());
                let faces = problem.at_faces(grid.owned(), void);
                solver.set_coefficients(faces.each_ref().map(|list| &list[..])).unwrap();
                let mut pressure = vec![0.0; fields.rhs.len()];
                worst = worst.max(solver.solve(&fields.rhs, &mut pressure).unwrap().iterations);
                // A second solve with the same coefficients needs nothing new.
                solver.solve(&fields.rhs, &mut pressure).unwrap();
            }
            assert_eq!(solver.builds(), builds, "kept for {reuse} solves");
            assert!(worst <= fresh + 2, "{reuse}: {worst} iterations, {fresh} at first");
        }
    });
}

/// After coefficients have changed by orders of magnitude a new preconditioner is as good as a first one.
#[test]
fn a_new_preconditioner_knows_the_new_coefficients() {
    on_ranks(&[1, 2], "a_new_preconditioner_knows_the_new_coefficients", |job| {
        let petsc = petsc(job, "");
        let problem = Problem::uniform([16; 3], [NEUMANN; 3]);
        let grid = problem.grid(&petsc, job.size());
        let steep = |[x, _, _]: [f64; 3]| (-9.0 * x).exp();
        let fields = problem.fields(grid.owned(), steep, rough);
        for kind in [|| Preconditioner::Multigrid, || Preconditioner::Algebraic] {
            let solve = |first: Function, reuse| {
                let settings = Settings { reuse, max_iterations: 500, ..tight() };
                let mut solver = LinearSolver::new(problem.matrix(&grid), &settings, kind()).unwrap();
                let mut pressure = vec![0.0; fields.rhs.len()];
                for faces in [&problem.at_faces(grid.owned(), first), &fields.faces] {
                    solver.set_coefficients(faces.each_ref().map(|list| &list[..])).unwrap();
                    pressure.fill(0.0);
                    solver.solve(&fields.rhs, &mut pressure).unwrap();
                }
                pressure.fill(0.0);
                solver.solve(&fields.rhs, &mut pressure).unwrap().iterations
            };
            let rising: Function = |[x, _, _]| (9.0 * x).exp();
            let (fresh, renewed, kept) = (solve(steep, 0), solve(rising, 0), solve(rising, 9));
            println!("measured iterations: fresh {fresh}, renewed {renewed}, kept {kept}");
            assert!(renewed.abs_diff(fresh) <= 1 && kept > fresh + 3, "{fresh}, {renewed}, {kept}");
        }
    });
}

#[test]
fn a_function_of_the_caller_preconditions() {
    on_ranks(&EVERY, "a_function_of_the_caller_preconditions", |job| {
        let petsc = petsc(job, "");
        let n = 16;
        let problem = Problem::uniform([n; 3], [NEUMANN; 3]);
        let grid = problem.grid(&petsc, job.size());
        // An eigenvector of the discrete operator: one iteration, whatever the function's exact answer.
        let wave = |[x, _, z]: [f64; 3]| (PI * x).cos() * (2.0 * PI * z).cos();
        let h = 1.0 / n as f64;
        let squared = |k: f64| (2.0 / h * (0.5 * k * PI * h).sin()).powi(2);
        let eigenvalue = -(squared(1.0) + squared(2.0));
        let fields = problem.fields(grid.owned(), |_| 3.0, |x| 3.0 * eigenvalue * wave(x));
        let seen = Rc::new(RefCell::new(Vec::new()));
        let log = Rc::clone(&seen);
        let inverse = move |f: &[f64], p: &mut [f64]| {
            log.borrow_mut().push(f.to_vec());
            p.iter_mut().zip(f).for_each(|(p, f)| *p = f / (3.0 * eigenvalue));
        };
        let function = Preconditioner::Function(Box::new(inverse));
        let mut solver = LinearSolver::new(problem.matrix(&grid), &tight(), function).unwrap();
        solver.set_coefficients(fields.faces.each_ref().map(|list| &list[..])).unwrap();
        let mut pressure = vec![0.0; fields.rhs.len()];
        let report = solver.solve(&fields.rhs, &mut pressure).unwrap();
        assert_eq!(report.iterations, 1);
        let wanted = problem.at_centres(grid.owned(), wave);
        assert!(difference(&pressure, &wanted) < 1e-12);
        // It is asked what the caller asked: the first residual from a zero guess is f itself.
        assert!(difference(&seen.borrow()[0], &fields.rhs) < 1e-10);
    });
}

#[test]
fn algebraic_multigrid_gives_the_same_answer() {
    on_ranks(&[1, 2], "algebraic_multigrid_gives_the_same_answer", |job| {
        let petsc = petsc(job, "");
        let problem = Problem::uniform([20, 18, 22], [NEUMANN; 3]);
        let grid = problem.grid(&petsc, job.size());
        let fields = problem.fields(grid.owned(), bed, rough);
        let (geometric, _, _) = solve(&problem, &grid, &fields, &tight());
        let mut solver =
            LinearSolver::new(problem.matrix(&grid), &tight(), Preconditioner::Algebraic).unwrap();
        solver.set_coefficients(fields.faces.each_ref().map(|list| &list[..])).unwrap();
        let mut pressure = vec![0.0; fields.rhs.len()];
        let report = solver.solve(&fields.rhs, &mut pressure).unwrap();
        println!("measured iterations of GAMG to 1e-12: {}", report.iterations);
        assert!(difference(&pressure, &geometric) < 1e-10 && report.iterations < 40, "{report:?}");
    });
}

/// A closed box of 24 cells with options of PETSc.
fn small(petsc: &Petsc, job: &Job, settings: &Settings) -> Result<(LinearSolver, Fields), PetscError> {
    let problem = Problem::uniform([24; 3], [NEUMANN; 3]);
    let grid = problem.grid(petsc, job.size());
    let fields = problem.fields(grid.owned(), bed, rough);
    Ok((solver(&problem, &grid, settings, &fields.faces)?, fields))
}

#[test]
fn petsc_may_make_the_coarse_operators() {
    on_ranks(&[1, 2], "petsc_may_make_the_coarse_operators", |job| {
        let petsc = petsc(job, "-galerkin_pc_mg_galerkin both");
        let [own, of_petsc] = ["own_", "galerkin_"].map(|prefix| {
            let settings = Settings { prefix: prefix.into(), ..tight() };
            let (mut solver, fields) = small(&petsc, job, &settings).unwrap();
            assert!(solver.levels() > 1, "{}", solver.levels());
            let mut pressure = vec![0.0; fields.rhs.len()];
            solver.solve(&fields.rhs, &mut pressure).unwrap();
            pressure
        });
        let largest = own.iter().fold(0.0_f64, |max, p| max.max(p.abs()));
        for (a, b) in own.iter().zip(&of_petsc) {
            assert!((a - b).abs() <= 1e-8 * largest, "{a} {b}");
        }
    });
}

#[test]
fn options_reach_petsc_and_mistakes_are_reported() {
    on_ranks(&[1, 2], "options_reach_petsc_and_mistakes_are_reported", |job| {
        let prefixed = Settings { prefix: "pressure_".into(), ..Settings::default() };
        let line = ["grains", "case.toml", "--", "-pressure_ksp_max_it", "55"].map(String::from);
        let text = "-pressure_pc_mg_levels 3 -pressure_ksp_rtol 1e-5 -pressure_mg_levels_pc_sor_omega 1.1 \
                    -pressure_ksp_max_it 2 -pressure_mg_coarse_redundant_pc_type svd \
                    -pressure_ksp_converged_reason";
        let options = Options::parse(text).unwrap().with_command_line(line);
        {
            let petsc = Petsc::start(job.world(), &options).unwrap();
            let again = Petsc::start(job.world(), &options).err().unwrap();
            assert_eq!(again, PetscError::AlreadyStarted);
            let (mut solver, fields) = small(&petsc, job, &prefixed).unwrap();
            solver.set_up().unwrap();
            petsc.check_options().unwrap();
            assert_eq!(solver.levels(), 3);
            let mut pressure = vec![0.0; fields.rhs.len()];
            let report = solver.solve(&fields.rhs, &mut pressure).unwrap();
            assert!(report.residual > 1e-7 && report.iterations > 2, "{report:?}");
        }
        {
            let petsc = petsc(job, "-ksp_rtoll 1e-9");
            let (mut solver, _) = small(&petsc, job, &Settings::default()).unwrap();
            solver.set_up().unwrap();
            let message = petsc.check_options().unwrap_err().to_string();
            assert_eq!(
                message,
                "solver option -ksp_rtoll: no solver uses it (did you mean -ksp_rtol?); correct or remove it"
            );
        }
        let petsc = petsc(job, "-pc_type multigird");
        let message = small(&petsc, job, &Settings::default()).err().unwrap().to_string();
        assert!(message.contains("multigird") && message.contains("correct it"), "{message}");
    });
}

#[test]
fn solves_that_cannot_converge_say_why() {
    on_ranks(&[1, 2], "solves_that_cannot_converge_say_why", |job| {
        let petsc = petsc(job, "-one_pc_type jacobi -two_ksp_type preonly -two_pc_type jacobi");
        let named =
            |prefix: &str| Settings { prefix: prefix.into(), max_iterations: 5, ..Settings::default() };
        for prefix in ["one_", "two_"] {
            let (mut solver, fields) = small(&petsc, job, &named(prefix)).unwrap();
            let mut pressure = vec![0.0; fields.rhs.len()];
            let message = solver.solve(&fields.rhs, &mut pressure).unwrap_err().to_string();
            assert!(message.contains("limit of") && message.contains("multigrid"), "{prefix}: {message}");
        }
        let (mut solver, mut fields) = small(&petsc, job, &Settings::default()).unwrap();
        let mut pressure = vec![0.0; fields.rhs.len()];
        let short = solver.solve(&fields.rhs[1..], &mut pressure).unwrap_err().to_string();
        assert!(short.contains("the right-hand side has"), "{short}");
        fields.rhs[3] = f64::NAN;
        let message = solver.solve(&fields.rhs, &mut pressure).unwrap_err().to_string();
        assert!(message.contains("right-hand side") && message.contains("NaN"), "{message}");
        // One bad coefficient on the last rank stops all.
        let last = job.size() - 1;
        fields.faces[1][7] = if rank(job) == last { -2.0 } else { 1.0 };
        let wrong = solver.set_coefficients(fields.faces.each_ref().map(|list| &list[..])).unwrap_err();
        let wanted = if rank(job) == last { "it is -2 on the lower face" } else { "another rank" };
        assert!(wrong.to_string().contains(wanted), "{wrong}");
        // A preconditioner that breaks the method, and one that overflows.
        let problem = Problem::uniform([8; 3], [NEUMANN; 3]);
        let grid = problem.grid(&petsc, job.size());
        let fields = problem.fields(grid.owned(), |_| 1.0, rough);
        for (factor, words) in [(1.0, "not positive definite"), (f64::NAN, "NaN or infinity appeared")] {
            let bad = move |f: &[f64], p: &mut [f64]| {
                let signs = [factor, -factor, -factor].into_iter().cycle();
                p.iter_mut().zip(f).zip(signs).for_each(|((p, f), sign)| *p = sign * f);
            };
            let function = Preconditioner::Function(Box::new(bad));
            let mut solver = LinearSolver::new(problem.matrix(&grid), &tight(), function).unwrap();
            solver.set_coefficients(fields.faces.each_ref().map(|list| &list[..])).unwrap();
            let mut pressure = vec![0.0; fields.rhs.len()];
            let message = solver.solve(&fields.rhs, &mut pressure).unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
        }
    });
}

fn rank(job: &Job) -> usize {
    use mpi::traits::Communicator;
    job.world().rank() as usize
}

#[test]
fn a_panic_in_a_preconditioner_crosses_petsc_unharmed() {
    on_ranks(&[1], "a_panic_in_a_preconditioner_crosses_petsc_unharmed", |job| {
        let petsc = petsc(job, "");
        let problem = Problem::uniform([8; 3], [NEUMANN; 3]);
        let grid = problem.grid(&petsc, 1);
        let fields = problem.fields(grid.owned(), |_| 1.0, rough);
        let function =
            Preconditioner::Function(Box::new(|_, _| std::panic::resume_unwind(Box::new("tired"))));
        let mut solver = LinearSolver::new(problem.matrix(&grid), &tight(), function).unwrap();
        solver.set_coefficients(fields.faces.each_ref().map(|list| &list[..])).unwrap();
        let mut pressure = vec![0.0; fields.rhs.len()];
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            solver.solve(&fields.rhs, &mut pressure)
        }));
        assert_eq!(result.unwrap_err().downcast_ref::<&str>(), Some(&"tired"));
    });
}
