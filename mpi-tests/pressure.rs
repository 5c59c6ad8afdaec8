//! The pressure equation solved by PETSc on 1, 2, 4 and 8 ranks.

#![allow(clippy::unwrap_used)]

#[path = "pressure/problem.rs"]
mod problem;
mod ranks;

use grains_comm::Job;
use petsc_rs::{Boundary, Grid, Petsc, PetscError, Settings};
use problem::{
    DIRICHLET, EVERY, Function, NEUMANN, PERIODIC, Problem, bed, difference, largest, part, petsc, rough,
    solve, tight,
};
use ranks::on_ranks;
use std::f64::consts::{PI, TAU};

/// Error against an analytic answer on grids of 16 and 32 cells; asserts second order.
fn assert_second_order(
    job: &Job,
    boundaries: [[Boundary; 2]; 3],
    [coefficient, answer, rhs]: [Function; 3],
    is_stretched: bool,
) {
    let petsc = petsc(job, "");
    let errors = [16, 32].map(|n| {
        let mut problem = Problem::uniform([n; 3], boundaries);
        if is_stretched {
            problem = problem.stretched();
        }
        let grid = problem.grid(&petsc, job.size());
        let fields = problem.fields(grid.owned(), coefficient, rhs);
        let (pressure, _, solver) = solve(&problem, &grid, &fields, &tight());
        let mut wanted = problem.at_centres(problem.whole(), answer);
        if solver.pressure().is_singular() {
            wanted = problem.centred(&wanted);
        }
        largest(job, difference(&pressure, &part(&wanted, problem.cells, grid.owned())))
    });
    let order = (errors[0] / errors[1]).log2();
    println!("measured order {order:.3}, errors {errors:?}");
    assert!((1.85..2.3).contains(&order) && errors[1] < 0.02, "order {order}, errors {errors:?}");
}

#[test]
fn closed_box_is_second_order() {
    on_ranks(&EVERY, "closed_box_is_second_order", |job| {
        let answer: Function = |[x, y, z]| (PI * x).cos() * (TAU * y).cos() * (PI * z).cos();
        let rhs: Function = |[x, y, z]| -6.0 * PI * PI * (PI * x).cos() * (TAU * y).cos() * (PI * z).cos();
        assert_second_order(job, [NEUMANN; 3], [|_| 1.0, answer, rhs], false);
    });
}

#[test]
fn open_box_is_second_order() {
    on_ranks(&EVERY, "open_box_is_second_order", |job| {
        let answer: Function = |[x, y, z]| (PI * x).sin() * (PI * y).sin() * (TAU * z).sin();
        let rhs: Function = |[x, y, z]| -6.0 * PI * PI * (PI * x).sin() * (PI * y).sin() * (TAU * z).sin();
        assert_second_order(job, [DIRICHLET; 3], [|_| 1.0, answer, rhs], false);
    });
}

#[test]
fn periodic_box_is_second_order() {
    on_ranks(&EVERY, "periodic_box_is_second_order", |job| {
        let answer: Function = |[x, y, z]| (TAU * x).sin() * (TAU * y).cos() + (TAU * z).cos();
        let rhs: Function =
            |[x, y, z]| -TAU * TAU * (2.0 * (TAU * x).sin() * (TAU * y).cos() + (TAU * z).cos());
        assert_second_order(job, [PERIODIC; 3], [|_| 1.0, answer, rhs], false);
    });
}

/// c = 1 + x y / 2 + sin(2 pi z) / 4 with p = cos(pi x) cos(pi y) cos(2 pi z), closed along x, y, periodic in z.
#[test]
fn smooth_coefficients_on_stretched_axes_are_second_order() {
    on_ranks(&EVERY, "smooth_coefficients_on_stretched_axes_are_second_order", |job| {
        let coefficient: Function = |[x, y, z]| 1.0 + 0.5 * x * y + 0.25 * (TAU * z).sin();
        let answer: Function = |[x, y, z]| (PI * x).cos() * (PI * y).cos() * (TAU * z).cos();
        let rhs: Function = |[x, y, z]| {
            let c = 1.0 + 0.5 * x * y + 0.25 * (TAU * z).sin();
            let (a, b, d) = ((PI * x).cos(), (PI * y).cos(), (TAU * z).cos());
            let x_part = -0.5 * y * PI * (PI * x).sin() * b * d;
            let y_part = -0.5 * x * PI * a * (PI * y).sin() * d;
            let z_part = -0.25 * TAU * d * TAU * a * b * (TAU * z).sin();
            x_part + y_part + z_part - 6.0 * PI * PI * c * a * b * d
        };
        assert_second_order(job, [NEUMANN, NEUMANN, PERIODIC], [coefficient, answer, rhs], true);
    });
}

/// The same answer on any ranks as a plain serial solver finds: jumps in the coefficient, odd numbers of
/// cells, unequal partition, all kinds of boundaries, two-dimensional grids.
#[test]
fn every_number_of_ranks_gives_the_reference_answer() {
    on_ranks(&[1, 2, 4, 8], "every_number_of_ranks_gives_the_reference_answer", |job| {
        let petsc = petsc(job, "");
        let open_above = [NEUMANN, NEUMANN, [Boundary::Neumann, Boundary::Dirichlet]];
        for (cells, boundaries, is_stretched) in [
            ([16, 16, 16], [NEUMANN; 3], false),
            ([16, 16, 16], [PERIODIC; 3], false),
            ([13, 11, 21], open_above, true),
            ([18, 9, 7], [PERIODIC, DIRICHLET, NEUMANN], true),
            ([24, 2, 20], [NEUMANN, PERIODIC, PERIODIC], false),
            ([3, 4, 2], [PERIODIC, NEUMANN, PERIODIC], false),
        ] {
            let mut problem = Problem::uniform(cells, boundaries);
            if is_stretched {
                problem = problem.stretched();
            }
            let whole = problem.fields(problem.whole(), bed, rough);
            let wanted = problem.reference(&whole);
            let grid = problem.grid(&petsc, job.size());
            let fields = problem.fields(grid.owned(), bed, rough);
            let (pressure, iterations, mut solver) = solve(&problem, &grid, &fields, &tight());
            let error = largest(job, difference(&pressure, &part(&wanted, cells, grid.owned())));
            let size = wanted.iter().fold(0.0_f64, |m, p| m.max(p.abs()));
            println!(
                "measured {cells:?}: {iterations} iterations, {} levels, error {:.1e}",
                solver.levels(),
                error / size
            );
            assert!(error < 1e-10 * size, "{cells:?} {boundaries:?}: {error} of {size}");
            assert!(iterations <= 40, "{cells:?}: {iterations} iterations");
            // A good first guess is used.
            let mut again = pressure.clone();
            let loose = solver.solve(&fields.rhs, &mut again).unwrap();
            assert!(loose.iterations <= 1, "{loose:?}");
        }
    });
}

#[test]
fn one_cell_thick_grids_are_two_dimensional() {
    on_ranks(&[1, 2], "one_cell_thick_grids_are_two_dimensional", |job| {
        let petsc = petsc(job, "");
        for third in [PERIODIC, NEUMANN] {
            let problem = Problem::uniform([30, 1, 20], [DIRICHLET, third, NEUMANN]);
            let wanted = problem.reference(&problem.fields(problem.whole(), bed, rough));
            let grid = problem.grid(&petsc, job.size());
            let fields = problem.fields(grid.owned(), bed, rough);
            let (pressure, iterations, _) = solve(&problem, &grid, &fields, &tight());
            let error = difference(&pressure, &part(&wanted, problem.cells, grid.owned()));
            assert!(error < 1e-10 && iterations <= 30, "{error}, {iterations}");
        }
    });
}

/// Iterations to 1e-8 with a rough right-hand side.
fn iterations(job: &Job, petsc: &Petsc, problem: &Problem, coefficient: Function) -> usize {
    let grid = problem.grid(petsc, job.size());
    let fields = problem.fields(grid.owned(), coefficient, rough);
    solve(problem, &grid, &fields, &Settings { tolerance: 1e-8, ..Settings::default() }).1
}

#[test]
fn iterations_do_not_grow_with_the_grid() {
    on_ranks(&[1, 2], "iterations_do_not_grow_with_the_grid", |job| {
        let petsc = petsc(job, "");
        let one: Function = |_| 1.0;
        for (name, boundaries, coefficient) in [
            ("closed", [NEUMANN; 3], one),
            ("open", [DIRICHLET; 3], one),
            ("periodic", [PERIODIC; 3], one),
            ("closed bed", [NEUMANN; 3], bed as Function),
        ] {
            let found =
                [32, 64].map(|n| iterations(job, &petsc, &Problem::uniform([n; 3], boundaries), coefficient));
            println!("measured iterations {name}: {found:?} at 32^3, 64^3 on {} ranks", job.size());
            assert!(found[1] <= found[0] + 1 && found[1] <= 11, "{name}: {found:?}");
        }
        let flat = Problem::uniform([64, 64, 4], [NEUMANN; 3]);
        let odd = Problem::uniform([50, 37, 27], [NEUMANN; 3]);
        for problem in [flat, odd] {
            let found = iterations(job, &petsc, &problem, bed);
            println!("measured iterations {:?}: {found} on {} ranks", problem.cells, job.size());
            assert!(found <= 14, "{:?}: {found}", problem.cells);
        }
    });
}

#[test]
fn two_unequal_halves_take_no_more_iterations() {
    on_ranks(&[2], "two_unequal_halves_take_no_more_iterations", |job| {
        let petsc = petsc(job, "");
        let problem = Problem::uniform([64; 3], [NEUMANN; 3]);
        let settings = Settings { tolerance: 1e-8, ..Settings::default() };
        let found = [[32, 32], [37, 27]].map(|owned| {
            let grid = Grid::new(&petsc, [&owned, &[64], &[64]], [false; 3]).unwrap();
            let fields = problem.fields(grid.owned(), |_| 1.0, rough);
            solve(&problem, &grid, &fields, &settings).1
        });
        println!("measured iterations of 32+32 and 37+27: {found:?}");
        assert!(found[1] <= found[0] + 1, "{found:?}");
    });
}

/// Boxes of a micrometre and coefficients of any size make no difference.
#[test]
fn nothing_depends_on_units() {
    on_ranks(&[1, 2], "nothing_depends_on_units", |job| {
        let petsc = petsc(job, "");
        let mut found = Vec::new();
        for (length, unit) in [(1.0, 1.0), (1e-6, 1e-7), (1e3, 1e12)] {
            let mut problem = Problem::uniform([20, 20, 20], [NEUMANN; 3]);
            let grid = problem.grid(&petsc, job.size());
            let fields = problem.fields(grid.owned(), |x| unit * bed(x), |x| unit * rough(x));
            problem.edges.iter_mut().flatten().for_each(|x| *x *= length);
            let (pressure, iterations, _) = solve(&problem, &grid, &fields, &tight());
            found.push((pressure.iter().map(|p| p / (length * length)).collect::<Vec<_>>(), iterations));
        }
        for (pressure, iterations) in &found[1..] {
            let size = found[0].0.iter().fold(0.0_f64, |m, p| m.max(p.abs()));
            assert!(difference(pressure, &found[0].0) < 1e-10 * size);
            assert!(iterations.abs_diff(found[0].1) <= 1, "{iterations} and {} iterations", found[0].1);
        }
    });
}

/// An outlet over a part of a face: coefficients of zero on the rest close it.
#[test]
fn an_outlet_may_cover_part_of_a_face() {
    on_ranks(&EVERY, "an_outlet_may_cover_part_of_a_face", |job| {
        let petsc = petsc(job, "");
        let mut boundaries = [NEUMANN; 3];
        boundaries[2][1] = Boundary::Dirichlet;
        let problem = Problem::uniform([16, 16, 16], boundaries);
        let slot = |[x, _, z]: [f64; 3]| if z > 0.999 && x < 0.5 { 0.0 } else { 1.0 };
        let wanted = problem.reference(&problem.fields(problem.whole(), slot, rough));
        let grid = problem.grid(&petsc, job.size());
        let fields = problem.fields(grid.owned(), slot, rough);
        let (pressure, iterations, mut solver) = solve(&problem, &grid, &fields, &tight());
        let error = difference(&pressure, &part(&wanted, problem.cells, grid.owned()));
        assert!(error < 1e-10 && iterations < 30, "{error}, {iterations}");
        // Closed altogether the pressure is known up to a constant, and opened again it is known.
        let closed = problem.at_faces(grid.owned(), |[_, _, z]| f64::from(u8::from(z < 0.999)));
        for (faces, is_singular) in [(&closed, true), (&fields.faces, false)] {
            solver.set_coefficients(faces.each_ref().map(|list| &list[..])).unwrap();
            let mut pressure = vec![0.0; pressure.len()];
            let report = solver.solve(&fields.rhs, &mut pressure).unwrap();
            assert_eq!(solver.pressure().is_singular(), is_singular);
            assert_eq!(report.imbalance > 0.0, is_singular);
        }
    });
}

#[test]
fn the_operator_is_that_of_its_solution() {
    on_ranks(&EVERY, "the_operator_is_that_of_its_solution", |job| {
        let petsc = petsc(job, "");
        let problem = Problem::uniform([12, 10, 14], [DIRICHLET, PERIODIC, NEUMANN]).stretched();
        let grid = problem.grid(&petsc, job.size());
        let fields = problem.fields(grid.owned(), bed, rough);
        let mut matrix = problem.matrix(&grid);
        let mut pressure = vec![0.0; fields.rhs.len()];
        let mut result = pressure.clone();
        assert_eq!(matrix.apply(&mut pressure, &mut result), Err(PetscError::NoCoefficients));
        matrix.set_coefficients(fields.faces.each_ref().map(|list| &list[..])).unwrap();
        let wanted = problem.reference(&problem.fields(problem.whole(), bed, rough));
        pressure = part(&wanted, problem.cells, grid.owned());
        matrix.apply(&mut pressure, &mut result).unwrap();
        assert!(difference(&result, &fields.rhs) < 1e-10, "{}", difference(&result, &fields.rhs));
    });
}

#[test]
fn grids_that_do_not_fit_the_ranks_are_refused() {
    on_ranks(&[2], "grids_that_do_not_fit_the_ranks_are_refused", |job| {
        let petsc = petsc(job, "");
        let refusal = |owned: [&[usize]; 3]| Grid::new(&petsc, owned, [false; 3]).err().unwrap().to_string();
        assert!(refusal([&[4], &[4], &[4]]).contains("1 x 1 x 1 ranks, but there are 2"));
        assert!(refusal([&[4, 0], &[4], &[4]]).contains("rank 1 of 2 along x would own no cells"));
        assert!(refusal([&[2000, 2000], &[2000], &[2000]]).contains("more than PETSc counts"));
        let grid = Grid::new(&petsc, [&[4, 4], &[4], &[4]], [true, false, false]).unwrap();
        let widths = [&[1.0; 8][..], &[1.0; 4], &[1.0; 4]];
        let matrix = |widths, boundaries| petsc_rs::PressureMatrix::new(&grid, widths, boundaries);
        let message = matrix(widths, [NEUMANN; 3]).err().unwrap().to_string();
        assert!(message.contains("the grid is periodic there"), "{message}");
        let message = matrix([&[1.0; 7], widths[1], widths[2]], [PERIODIC, NEUMANN, NEUMANN]);
        assert!(message.err().unwrap().to_string().contains("7 widths were given for the 8 cells"));
    });
}
