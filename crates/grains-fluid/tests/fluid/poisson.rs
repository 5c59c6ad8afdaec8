//! The pressure equation: order, mixes of boundaries, stretched axes, varying coefficients, ranks.

use crate::common::{difference, joined, order, partition, piece, set};
use grains_domain::SerialTransport;
use grains_fluid::{
    Axis, Centre, ConjugateGradients, Faces, FastSolver, Field, Grid, Layout, Preconditioner,
    PressureOperator, PressureProblem, PressureSolver, SolveError,
};
use grains_testing::on_ranks;
use std::f64::consts::PI;

/// What closes an axis: periodic, or zero imposed at the ends or not.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Ends {
    Periodic,
    Closed(bool, bool),
}

impl Ends {
    /// A function on [0, 1] that obeys the ends, with its second derivative.
    fn shape(self, x: f64) -> [f64; 2] {
        let wave = |k: f64, f: fn(f64) -> f64| [f(k * x), -k * k * f(k * x)];
        match self {
            Ends::Periodic => wave(2.0 * PI, |t| (t + 0.3).sin()),
            Ends::Closed(false, false) => wave(PI, f64::cos),
            Ends::Closed(true, true) => wave(PI, f64::sin),
            Ends::Closed(true, false) => wave(0.5 * PI, f64::sin),
            Ends::Closed(false, true) => wave(0.5 * PI, f64::cos),
        }
    }

    pub(crate) fn imposed(self) -> [bool; 2] {
        match self {
            Ends::Periodic => [false; 2],
            Ends::Closed(low, high) => [low, high],
        }
    }

    fn axis(self, n: usize, stretched: bool) -> Axis {
        let is_periodic = matches!(self, Ends::Periodic);
        if stretched {
            let node = |k: usize| {
                let s = k as f64 / n as f64;
                s + 0.08 * (2.0 * PI * s).sin()
            };
            Axis::stretched((0..=n).map(node).collect(), is_periodic)
        } else {
            Axis::uniform(0.0, 1.0, n, is_periodic)
        }
    }
}

pub(crate) fn problem(ends: [Ends; 3], n: usize, stretched: [bool; 3]) -> PressureProblem {
    let cells = [n, n + 2, n - 2];
    let grid = Grid::new(std::array::from_fn(|a| ends[a].axis(cells[a], stretched[a]))).unwrap();
    let whole = partition(&grid, [1; 3], 0);
    PressureProblem { grid, partition: whole, halo: 2, imposed: ends.map(Ends::imposed) }
}

/// Exact solution less its mean if it has none imposed, and the integrated right-hand side.
fn exact(problem: &PressureProblem, ends: [Ends; 3], cell: [usize; 3]) -> [f64; 3] {
    let axis = |a: usize| problem.grid.axis(a);
    let shapes: [[f64; 2]; 3] = std::array::from_fn(|a| ends[a].shape(axis(a).centre(cell[a] as isize)));
    let volume: f64 = (0..3).map(|a| axis(a).width(cell[a] as isize)).product();
    let [x, y, z] = shapes;
    let value = x[0] * y[0] * z[0];
    let laplacian = x[1] * y[0] * z[0] + x[0] * y[1] * z[0] + x[0] * y[0] * z[1];
    [value, laplacian * volume, volume]
}

fn fields(problem: &PressureProblem, ends: [Ends; 3]) -> (Field<Centre>, Field<Centre>) {
    let layout = Layout { cells: problem.partition.cells(), halo: problem.halo };
    let (mut rhs, mut solution) = (Field::new(layout), Field::new(layout));
    let first = problem.partition.first();
    set(&mut rhs, first, |cell| exact(problem, ends, cell)[1]);
    set(&mut solution, first, |cell| exact(problem, ends, cell)[0]);
    (rhs, solution)
}

fn error(ends: [Ends; 3], n: usize, stretched: [bool; 3]) -> f64 {
    let problem = problem(ends, n, stretched);
    let (rhs, expected) = fields(&problem, ends);
    let mut solver = FastSolver::new(&problem, &SerialTransport);
    let mut solution = Field::new(rhs.layout());
    solver.solve(&rhs, &mut solution, &SerialTransport).unwrap();
    let expected: Vec<f64> = expected.own().collect();
    let solution: Vec<f64> = solution.own().collect();
    let shift = match problem.is_singular() {
        true => expected.iter().zip(&solution).map(|(e, s)| e - s).sum::<f64>() / expected.len() as f64,
        false => 0.0,
    };
    let sum: f64 = expected.iter().zip(&solution).map(|(e, s)| (e - s - shift).powi(2)).sum();
    (sum / expected.len() as f64).sqrt()
}

#[test]
fn order_two_for_all_mixes_of_boundaries_and_stretched_axes() {
    use Ends::{Closed, Periodic};
    let kinds =
        [Periodic, Closed(false, false), Closed(true, true), Closed(true, false), Closed(false, true)];
    for (case, &x) in kinds.iter().enumerate() {
        for (shift, &y) in kinds.iter().enumerate() {
            let z = kinds[(case + 2 * shift) % 5];
            let stretched = [case % 2 == 1, shift % 3 == 1, (case + shift) % 4 == 3];
            let (coarse, fine) = (error([x, y, z], 12, stretched), error([x, y, z], 24, stretched));
            let order = order(coarse, fine, 2.0);
            assert!(
                (order - 2.0).abs() < 0.3,
                "{x:?} {y:?} {z:?} {stretched:?}: {coarse:.2e} {fine:.2e} {order:.3}"
            );
        }
    }
}

/// Coefficients that vary in all directions, one on closed faces that impose a pressure.
pub(crate) fn coefficients(problem: &PressureProblem, contrast: f64) -> Faces {
    let layout = Layout { cells: problem.partition.cells(), halo: problem.halo };
    let first = problem.partition.first();
    let mut faces = Faces::new(layout);
    let dims = layout.dims();
    for axis in 0..3 {
        let n = problem.grid.axis(axis).cells() as isize;
        for (p, value) in faces.component_mut(axis).iter_mut().enumerate() {
            let m = [p % dims[0], p / dims[0] % dims[1], p / dims[0] / dims[1]];
            let cell: [isize; 3] = std::array::from_fn(|a| {
                let cell = m[a] as isize - layout.halo as isize + first[a] as isize;
                let n = problem.grid.axis(a).cells() as isize;
                if problem.grid.axis(a).is_periodic() { cell.rem_euclid(n) } else { cell }
            });
            let wave = (cell[0] as f64 * 0.9 + axis as f64).sin() * (cell[1] as f64 * 0.7).cos();
            *value = 1.0 + contrast * (0.5 * wave + 0.4 * (cell[2] as f64 * 0.5).sin());
            let closed = !problem.grid.axis(axis).is_periodic();
            let side = usize::from(cell[axis] > 0);
            if closed && (cell[axis] == -1 || cell[axis] == n - 1) && !problem.imposed[axis][side] {
                *value = 0.0;
            }
        }
    }
    faces
}

#[test]
fn conjugate_gradients_solve_varying_coefficients_in_few_iterations() {
    use Ends::{Closed, Periodic};
    for ends in [
        [Closed(false, false), Closed(false, false), Closed(false, true)],
        [Periodic, Closed(false, false), Periodic],
        [Closed(false, false); 3],
    ] {
        let mut counts = Vec::new();
        for n in [12, 24] {
            let problem = problem(ends, n, [false, true, false]);
            let (rhs, _) = fields(&problem, ends);
            let mut rhs = rhs;
            balance(&mut rhs, problem.is_singular());
            let faces = coefficients(&problem, 0.9);
            let mut solver = ConjugateGradients::new(&problem, 1e-10, 100, &SerialTransport);
            solver.set_coefficients(&faces, &SerialTransport).unwrap();
            let mut p = Field::new(rhs.layout());
            let report = solver.solve(&rhs, &mut p, &SerialTransport).unwrap();
            counts.push(report.iterations);
            assert!(residual(&problem, &faces, &rhs, &mut p) < 2e-10, "{ends:?} {n}");
        }
        assert!(counts.iter().all(|c| *c < 40), "{ends:?}: {counts:?}");
    }
}

/// Multigrid needs as many iterations on a fine grid as on a coarse one; jumps of 40-fold from one face to the next cost
/// it some four times as many, of which the finer grids add few.
#[test]
fn multigrid_iterations_do_not_grow_with_the_grid() {
    let ends = [Ends::Closed(false, false), Ends::Periodic, Ends::Closed(false, true)];
    let iterations = |n: usize, jump: f64| {
        let problem = problem(ends, n, [false; 3]);
        let (rhs, _) = fields(&problem, ends);
        let mut faces = coefficients(&problem, 0.0);
        let [dx, dy, _] = faces.layout().dims();
        for component in faces.components_mut() {
            for (p, c) in component.iter_mut().enumerate() {
                let [x, y, z] = [p % dx, p / dx % dy, p / dx / dy].map(|m| m as f64 / n as f64);
                // The y axis is periodic: nothing depends on it but by whole waves.
                let wave = (9.0 * x).sin() * (2.0 * PI * (y * n as f64 - 2.0) / (n + 2) as f64).cos();
                *c *= if wave * (11.0 * z).cos() > 0.2 { 1.0 } else { 1.0 / jump };
            }
        }
        let limits = [1e-8, 200.0];
        let mut solver =
            ConjugateGradients::preconditioned(&problem, limits, Preconditioner::Multigrid, &SerialTransport);
        solver.set_coefficients(&faces, &SerialTransport).unwrap();
        let mut p = Field::new(rhs.layout());
        let report = solver.solve(&rhs, &mut p, &SerialTransport).unwrap();
        assert!(residual(&problem, &faces, &rhs, &mut p) < 2e-8);
        report.iterations
    };
    let [smooth, jumps] = [1.0, 40.0].map(|jump| [16, 32, 64].map(|n| iterations(n, jump)));
    println!("measured iterations: smooth {smooth:?}, jumps {jumps:?}");
    assert!(smooth[2] <= smooth[0] + 3 && smooth[2] <= 16, "{smooth:?}");
    assert!(jumps[2] <= jumps[1] + 6 && jumps[2] <= 60, "{jumps:?}");
}

/// Coarse levels go to fewer ranks, down to one: no cut of the grid costs iterations, not even 64 ranks of some cells each.
#[test]
fn multigrid_iterations_do_not_grow_with_ranks() {
    for (ends, contrast) in [
        ([Ends::Closed(false, false), Ends::Periodic, Ends::Closed(false, true)], 0.9),
        ([Ends::Periodic, Ends::Closed(false, false), Ends::Periodic], 0.5),
    ] {
        let solve = |ranks: [usize; 3]| {
            let results = on_ranks(ranks.iter().product(), |transport| {
                let mut problem = problem(ends, 34, [false; 3]);
                problem.partition =
                    partition(&problem.grid, ranks, grains_domain::Transport::rank(&transport));
                let (rhs, _) = fields(&problem, ends);
                let mut solver = ConjugateGradients::preconditioned(
                    &problem,
                    [1e-9, 60.0],
                    Preconditioner::Multigrid,
                    &transport,
                );
                solver.set_coefficients(&coefficients(&problem, contrast), &transport).unwrap();
                let mut p = Field::new(rhs.layout());
                let report = solver.solve(&rhs, &mut p, &transport).unwrap();
                (report.iterations, piece(p.data(), p.layout(), problem.partition.first()))
            });
            let iterations = results[0].0;
            (iterations, joined(results.into_iter().map(|(_, piece)| piece).collect()))
        };
        let (serial, expected) = solve([1; 3]);
        for ranks in [
            [2, 1, 1],
            [2, 2, 2],
            [16, 1, 1],
            [1, 3, 5],
            [1, 1, 16],
            [5, 5, 2],
            [7, 1, 1],
            [1, 5, 1],
            [1, 1, 3],
            [4, 4, 4],
        ] {
            let (iterations, pressure) = solve(ranks);
            println!("measured iterations: {ranks:?} {iterations}, serial {serial}");
            assert!(iterations <= serial + 2, "{ranks:?}: {iterations}, serial {serial}");
            let error = difference(&expected, &pressure);
            assert!(error < 1e-6, "{ranks:?}: {error:.2e}");
        }
    }
}

fn balance(rhs: &mut Field<Centre>, is_singular: bool) {
    if is_singular {
        let count = rhs.own().count() as f64;
        let mean = rhs.own().sum::<f64>() / count;
        rhs.data_mut().iter_mut().for_each(|f| *f -= mean);
    }
}

/// |f − A p| / |f|.
pub(crate) fn residual(
    problem: &PressureProblem,
    faces: &Faces,
    rhs: &Field<Centre>,
    p: &mut Field<Centre>,
) -> f64 {
    let mut operator = PressureOperator::new(problem);
    operator.set(faces);
    let mut halo = grains_fluid::Halo::new(&problem.grid, &problem.partition, p.layout());
    halo.fill(&mut [p.data_mut()], &SerialTransport);
    let mut image = Field::new(p.layout());
    operator.apply(p, &mut image);
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
    norm(&mut rhs.own().zip(image.own()).map(|(f, a)| f - a)) / norm(&mut rhs.own())
}

#[test]
fn the_fast_solver_is_exact_for_layers_and_refuses_what_is_not() {
    let ends = [Ends::Closed(false, false), Ends::Periodic, Ends::Closed(true, false)];
    let problem = problem(ends, 10, [false, false, true]);
    let (rhs, _) = fields(&problem, ends);
    let mut solver = FastSolver::new(&problem, &SerialTransport);
    assert_eq!(solver.line_axis(), 2);
    let mut faces = coefficients(&problem, 0.0);
    let layout = faces.layout();
    let [dx, dy, _] = layout.dims();
    for axis in 0..3 {
        for (p, c) in faces.component_mut(axis).iter_mut().enumerate() {
            *c *= 1.0 + (p / (dx * dy)) as f64;
        }
    }
    solver.set_coefficients(&faces, &SerialTransport).unwrap();
    let mut p = Field::new(layout);
    solver.solve(&rhs, &mut p, &SerialTransport).unwrap();
    assert!(residual(&problem, &faces, &rhs, &mut p) < 1e-12);
    let uneven = coefficients(&problem, 0.5);
    let error = solver.set_coefficients(&uneven, &SerialTransport).unwrap_err();
    assert!(error.to_string().contains("use conjugate gradients"), "{error}");
}

/// Iterations in single precision know no units: fluids and cells 2^±60 as heavy and as large take the same bits, whichever the
/// preconditioner; and what is solved for is that of double precision, in a duct of 3,000 cells too.
#[test]
fn single_precision_within_neither_needs_units_nor_limits_the_tolerance() {
    let ends = [Ends::Closed(false, true), Ends::Periodic, Ends::Closed(false, false)];
    let problem = problem(ends, 13, [true, false, false]);
    for preconditioner in [Preconditioner::Multigrid, Preconditioner::PlaneMeans] {
        let solve = |of_coefficients: f64, of_rhs: f64| {
            let mut faces = coefficients(&problem, 0.7);
            faces.components_mut().into_iter().flatten().for_each(|c| *c *= of_coefficients);
            let (mut rhs, _) = fields(&problem, ends);
            rhs.data_mut().iter_mut().for_each(|f| *f *= of_rhs);
            let limits = [1e-11, 100.0];
            let mut solver =
                ConjugateGradients::preconditioned(&problem, limits, preconditioner, &SerialTransport);
            solver.set_coefficients(&faces, &SerialTransport).unwrap();
            let mut p = Field::new(rhs.layout());
            let report = solver.solve(&rhs, &mut p, &SerialTransport).unwrap();
            assert!(report.residual <= 1e-11 && residual(&problem, &faces, &rhs, &mut p) < 1.01e-11);
            let unit = of_rhs / of_coefficients;
            (report.iterations, p.own().map(|p| p / unit).collect::<Vec<f64>>())
        };
        let expected = solve(1.0, 1.0);
        for [of_coefficients, of_rhs] in [[60, 0], [-60, 0], [0, 60], [0, -60], [-60, -60], [50, -60]] {
            let found = solve(2_f64.powi(of_coefficients), 2_f64.powi(of_rhs));
            assert!(found == expected, "{preconditioner:?}, 2^{of_coefficients} and 2^{of_rhs}");
        }
    }
    let long = Ends::Closed(false, true).axis(3000, false);
    let ends = [Ends::Closed(false, false), Ends::Periodic];
    let grid = Grid::new([long, ends[0].axis(2, false), ends[1].axis(2, false)]).unwrap();
    let whole = partition(&grid, [1; 3], 0);
    let imposed = [[false, true], [false; 2], [false; 2]];
    let problem = PressureProblem { grid, partition: whole, halo: 2, imposed };
    let faces = coefficients(&problem, 0.0);
    let mut rhs = Field::new(faces.layout());
    set(&mut rhs, [0; 3], |[i, j, k]| ((i as f64 / 700.0).sin() + 0.3 * (j + 2 * k) as f64) / 12_000.0);
    // What double precision leaves of the residual is 3e-9 here.
    let limits = [1e-8, 100.0];
    let mut solver =
        ConjugateGradients::preconditioned(&problem, limits, Preconditioner::Multigrid, &SerialTransport);
    solver.set_coefficients(&faces, &SerialTransport).unwrap();
    let mut p = Field::new(rhs.layout());
    let report = solver.solve(&rhs, &mut p, &SerialTransport).unwrap();
    println!(
        "measured iterations in a duct of 3,000 cells: {}, residual {:.1e}",
        report.iterations, report.residual
    );
    assert!(report.iterations <= 20 && residual(&problem, &faces, &rhs, &mut p) < 1e-8, "{report:?}");
}

/// A tolerance that double precision cannot reach ends where rounding does, and the report says where.
#[test]
fn no_tolerance_is_too_small() {
    let ends = [Ends::Closed(false, false), Ends::Periodic, Ends::Closed(false, false)];
    for n in [12, 24, 48] {
        let problem = problem(ends, n, [false; 3]);
        let (mut rhs, _) = fields(&problem, ends);
        balance(&mut rhs, true);
        let mut solver = ConjugateGradients::new(&problem, 1e-18, 200, &SerialTransport);
        solver.set_coefficients(&coefficients(&problem, 0.9), &SerialTransport).unwrap();
        let mut p = Field::new(rhs.layout());
        let report = solver.solve(&rhs, &mut p, &SerialTransport).unwrap();
        println!(
            "measured residual with {n} cells: {:.1e} after {} iterations",
            report.residual, report.iterations
        );
        assert!(report.residual > 1e-18 && report.residual < 1e-16 * (n * n) as f64, "{report:?}");
        let before = p.clone();
        let report = solver.solve(&rhs, &mut p, &SerialTransport).unwrap();
        assert!(report.iterations <= 1 && difference_of(&before, &p) < 1e-12, "{report:?}");
    }
}

/// Largest difference of two pressures.
fn difference_of(a: &Field<Centre>, b: &Field<Centre>) -> f64 {
    a.own().zip(b.own()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn what_is_no_number_is_an_error() {
    let ends = [Ends::Closed(false, false), Ends::Periodic, Ends::Closed(false, true)];
    let problem = problem(ends, 6, [false; 3]);
    let mut solver = ConjugateGradients::new(&problem, 1e-6, 20, &SerialTransport);
    solver.set_coefficients(&coefficients(&problem, 0.5), &SerialTransport).unwrap();
    for [of_rhs, of_guess] in [[f64::NAN, 0.0], [f64::INFINITY, 0.0], [1.0, f64::NAN], [1.0, f64::INFINITY]] {
        let (mut rhs, mut p) = fields(&problem, ends);
        rhs.set(2, 3, 1, of_rhs);
        p.set(2, 3, 1, of_guess);
        let error = solver.solve(&rhs, &mut p, &SerialTransport).unwrap_err();
        assert!(error.to_string().contains("no number"), "{of_rhs} {of_guess}: {error}");
    }
}

#[test]
fn too_few_iterations_are_an_error() {
    let ends = [Ends::Closed(false, false); 3];
    let problem = problem(ends, 12, [false; 3]);
    let (rhs, _) = fields(&problem, ends);
    let mut solver = ConjugateGradients::new(&problem, 1e-12, 2, &SerialTransport);
    solver.set_coefficients(&coefficients(&problem, 0.9), &SerialTransport).unwrap();
    let mut p = Field::new(rhs.layout());
    let error = solver.solve(&rhs, &mut p, &SerialTransport).unwrap_err();
    assert!(matches!(error, SolveError::NotConverged { iterations: 2, .. }), "{error}");
}

#[test]
fn any_ranks_give_the_same_pressure() {
    use Ends::{Closed, Periodic};
    for (ends, stretched) in [
        ([Closed(false, false), Periodic, Closed(true, false)], [false, false, true]),
        ([Periodic, Periodic, Periodic], [false; 3]),
        ([Closed(false, false), Closed(true, true), Closed(false, false)], [true, false, false]),
    ] {
        for varying in [false, true] {
            let solve = |ranks: [usize; 3]| {
                joined(on_ranks(ranks.iter().product(), |transport| {
                    let mut problem = problem(ends, 14, stretched);
                    problem.partition =
                        partition(&problem.grid, ranks, grains_domain::Transport::rank(&transport));
                    let (rhs, _) = fields(&problem, ends);
                    let mut p = Field::new(rhs.layout());
                    if varying {
                        let mut solver = ConjugateGradients::new(&problem, 1e-13, 100, &transport);
                        solver.set_coefficients(&coefficients(&problem, 0.5), &transport).unwrap();
                        solver.solve(&rhs, &mut p, &transport).unwrap();
                    } else {
                        FastSolver::new(&problem, &transport).solve(&rhs, &mut p, &transport).unwrap();
                    }
                    piece(p.data(), p.layout(), problem.partition.first())
                }))
            };
            let serial = solve([1; 3]);
            for ranks in [[2, 1, 1], [1, 2, 1], [1, 1, 2], [1, 1, 4], [2, 2, 1], [3, 1, 2], [2, 2, 2]] {
                let error = difference(&serial, &solve(ranks));
                assert!(error < 1e-11, "{ends:?} {ranks:?} varying {varying}: {error:.2e}");
            }
        }
    }
}
