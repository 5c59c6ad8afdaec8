//! PETSc as the pressure solver of the fluid, on 1, 2 and 4 ranks.

#![allow(clippy::unwrap_used)]

mod ranks;

use grains_comm::Job;
use grains_domain::{Decomposition, GlobalBox, Transport};
use grains_fluid::{
    Axis, Boundaries, BoxFace, CellPartition, Centre, Condition, ConjugateGradients, Faces, Field, Flow,
    FlowSetup, Grid, MixtureModel, Outline, Patch, PressureProblem, PressureSolver, Profile, Side,
    SolveError,
};
use grains_petsc::{Options, PetscSolver, Preconditioning, Settings};
use ranks::on_ranks;

const EVERY: [usize; 3] = [1, 2, 4];

fn tight() -> Settings {
    Settings { tolerance: 1e-12, ..Settings::default() }
}

/// The cells of a rank, the ranks along x and z.
fn partition(grid: &Grid, job: &Job) -> CellPartition {
    let ranks = if job.size() == 4 { [2, 1, 2] } else { [1, 1, job.size()] };
    let corner = |last: bool| {
        std::array::from_fn(|a| {
            let nodes = grid.axis(a).nodes();
            nodes[if last { nodes.len() - 1 } else { 0 }]
        })
    };
    let periodic = [0, 1, 2].map(|a| grid.axis(a).is_periodic());
    let global = GlobalBox::new(corner(false), corner(true), periodic);
    let rank = job.new_transport().rank();
    CellPartition::new(grid, &Decomposition::new(global, ranks, rank, 1e-9).unwrap()).unwrap()
}

/// A flow whose pressure equation has all that may happen.
fn setups() -> Vec<(&'static str, FlowSetup)> {
    let outlet = Condition::Outlet { pressure: 0.0 };
    let closed = Grid::uniform([0.0; 3], [1.0, 0.8, 1.2], [13, 10, 18], [false; 3]).unwrap();
    let stretched = Grid::new([
        Axis::clustered(0.0, 1.0, 14, 1.2),
        Axis::uniform(0.0, 0.5, 6, true),
        Axis::clustered(0.0, 2.0, 20, 0.8),
    ]);
    let flat = Grid::uniform([0.0; 3], [1.0, 0.1, 2.0], [16, 1, 30], [true, true, false]).unwrap();
    let window = Patch {
        face: BoxFace { axis: 2, side: Side::High },
        outline: Outline::Rectangle { lower: [0.3, 0.0, 0.0], upper: [0.8, 0.5, 2.0] },
        condition: outlet.clone(),
    };
    let setup = |grid, boundaries| FlowSetup { boundaries, ..FlowSetup::new(grid, 1.0, 0.01) };
    vec![
        ("closed", setup(closed, Boundaries::default())),
        ("stretched, outlet in part", setup(stretched.unwrap(), Boundaries::default().with_patch(window))),
        ("flat, outlet", setup(flat, Boundaries::default().with(2, Side::High, outlet))),
    ]
}

fn shared(mut setup: FlowSetup, job: &Job) -> FlowSetup {
    setup.partition = partition(&setup.grid, job);
    setup
}

/// Coefficients that vary 50-fold, zero on closed faces.
fn coefficients(setup: &FlowSetup) -> Faces {
    let own = &setup.partition;
    let layout = grains_fluid::Layout { cells: own.cells(), halo: setup.halo };
    let (mut faces, dims, first) = (Faces::new(layout), layout.dims(), own.first());
    for axis in 0..3 {
        let imposed = setup.pressure_problem().imposed[axis];
        for (p, value) in faces.component_mut(axis).iter_mut().enumerate() {
            let m = [p % dims[0], p / dims[0] % dims[1], p / dims[0] / dims[1]];
            let cell = [0, 1, 2].map(|a| {
                let (cell, n) = ((m[a] + first[a]) as isize - 2, setup.grid.axis(a).cells() as isize);
                if setup.grid.axis(a).is_periodic() { cell.rem_euclid(n) } else { cell }
            });
            let [x, y, z] = cell.map(|c| c as f64);
            *value = (2.0 * (0.9 * x + axis as f64).sin() * (0.7 * y).cos() * (0.5 * z).sin()).exp();
            let n = setup.grid.axis(axis).cells() as isize;
            let is_end = cell[axis] == -1 || cell[axis] == n - 1;
            let is_outlet = imposed[usize::from(cell[axis] > 0)] && (4..10).contains(&cell[0]);
            if !setup.grid.axis(axis).is_periodic() && is_end && !is_outlet {
                *value = 0.0;
            }
        }
    }
    faces
}

/// A right-hand side without structure.
fn rough(problem: &PressureProblem) -> Field<Centre> {
    let layout = grains_fluid::Layout { cells: problem.partition.cells(), halo: problem.halo };
    let (mut rhs, [x, y, z]) = (Field::new(layout), problem.partition.first());
    for k in 0..layout.cells[2] {
        for j in 0..layout.cells[1] {
            for i in 0..layout.cells[0] {
                let at = 37 * (i + x) + 91 * (j + y) * (j + y) + 53 * (k + z) * (i + x);
                rhs.set(i as isize, j as isize, k as isize, (at as f64).sin());
            }
        }
    }
    rhs
}

fn difference(a: impl Iterator<Item = f64>, b: impl Iterator<Item = f64>) -> f64 {
    a.zip(b).fold(0.0, |m, (a, b)| m.max((a - b).abs()))
}

/// Pressures of PETSc and of the fluid's own solver, and PETSc's iterations.
fn both(setup: &FlowSetup, job: &Job, preconditioning: Preconditioning) -> (f64, f64, usize) {
    let (problem, transport) = (setup.pressure_problem(), job.new_transport());
    let (faces, rhs) = (coefficients(setup), rough(&setup.pressure_problem()));
    let mut own = ConjugateGradients::new(&problem, 1e-12, 500, &transport);
    let mut petsc =
        PetscSolver::new(&problem, job.world(), &Options::default(), &tight(), preconditioning).unwrap();
    let solve = |solver: &mut dyn PressureSolver| {
        let mut pressure = Field::new(rhs.layout());
        solver.set_coefficients(&faces, &transport).unwrap();
        let report = solver.solve(&rhs, &mut pressure, &transport).unwrap();
        (pressure, report.iterations)
    };
    let ((a, _), (b, iterations)) = (solve(&mut own), solve(&mut petsc));
    let size = a.own().fold(0.0_f64, |m, p| m.max(p.abs()));
    (difference(a.own(), b.own()), size, iterations)
}

#[test]
fn petsc_agrees_with_the_solver_of_the_fluid() {
    on_ranks(&EVERY, "petsc_agrees_with_the_solver_of_the_fluid", |job| {
        for (name, setup) in setups() {
            let setup = shared(setup, job);
            for preconditioning in [Preconditioning::Multigrid, Preconditioning::Algebraic] {
                let (error, size, iterations) = both(&setup, job, preconditioning);
                println!("measured {name}: error {error:.1e} of {size:.1e}, {iterations} iterations");
                assert!(error < 1e-8 * size && iterations < 80, "{name}: {error:e} {iterations}");
            }
        }
    });
}

#[test]
fn the_fast_transform_preconditions_a_single_phase() {
    on_ranks(&EVERY, "the_fast_transform_preconditions_a_single_phase", |job| {
        let lid = Condition::Wall { velocity: [1.0, 0.0, 0.0] };
        let grid = Grid::uniform([0.0; 3], [1.0; 3], [12, 10, 14], [false; 3]).unwrap();
        let boundaries = Boundaries::default().with(1, Side::High, lid);
        let setup = shared(FlowSetup { boundaries, ..FlowSetup::new(grid, 1.0, 0.02) }, job);
        let transport = job.new_transport();
        let fast = Preconditioning::FastTransform(Box::new(job.new_transport()));
        let problem = setup.pressure_problem();
        let settings = Settings { tolerance: 1e-10, ..Settings::default() };
        let solver = PetscSolver::new(&problem, job.world(), &Options::default(), &settings, fast).unwrap();
        let mut by_petsc = Flow::with_solver(setup.clone(), Box::new(solver), &transport).unwrap();
        let mut direct = Flow::new(setup, &transport).unwrap();
        for _ in 0..5 {
            let report = by_petsc.step(0.02, &transport).unwrap();
            assert!((1..=2).contains(&report.solve.iterations), "{report:?}");
            direct.step(0.02, &transport).unwrap();
        }
        let own = |flow: &Flow| flow.state.velocity.x.own().collect::<Vec<_>>();
        let error = difference(own(&direct).into_iter(), own(&by_petsc).into_iter());
        assert!(error < 1e-9, "{error:e}");
    });
}

#[test]
fn a_bed_flows_alike_with_both() {
    on_ranks(&[1, 2], "a_bed_flows_alike_with_both", |job| {
        let grid = Grid::uniform([0.0; 3], [0.02, 0.02, 0.06], [8, 8, 24], [false; 3]).unwrap();
        let profile = Profile::Uniform([0.0, 0.0, 0.6]);
        let boundaries = Boundaries::default().with(2, Side::Low, Condition::Inlet { profile }).with(
            2,
            Side::High,
            Condition::Outlet { pressure: 0.0 },
        );
        let mixture = Some(MixtureModel::A);
        let setup = shared(FlowSetup { boundaries, mixture, ..FlowSetup::new(grid, 1.2, 1.8e-5) }, job);
        let (problem, transport) = (setup.pressure_problem(), job.new_transport());
        let petsc = PetscSolver::new(
            &problem,
            job.world(),
            &Options::default(),
            &tight(),
            Preconditioning::Multigrid,
        );
        let own = ConjugateGradients::new(&problem, 1e-12, 200, &transport);
        let solvers: [Box<dyn PressureSolver>; 2] = [Box::new(petsc.unwrap()), Box::new(own)];
        let pressures = solvers.map(|solver| {
            let mut flow = Flow::with_solver(setup.clone(), solver, &transport).unwrap();
            let first = flow.first_cell()[2];
            for step in 0..5 {
                let mixture = flow.mixture.as_mut().unwrap();
                let layout = mixture.void_fraction.layout();
                for start in layout.rows() {
                    let k = start / (layout.dims()[0] * layout.dims()[1]) - layout.halo + first;
                    for p in start..start + layout.cells[0] {
                        let eps = if k < 9 { 0.45 + 0.05 * (p as f64).sin() } else { 1.0 };
                        mixture.void_fraction.data_mut()[p] = eps;
                        mixture.drag.components_mut().into_iter().for_each(|c| c[p] = 6e3 * (1.0 - eps));
                    }
                }
                if step == 0 {
                    mixture.begin();
                }
                flow.step(1e-3, &transport).unwrap();
            }
            flow.state.pressure.own().collect::<Vec<_>>()
        });
        let size = pressures[0].iter().fold(0.0_f64, |m, p| m.max(p.abs()));
        let mut sizes = [size];
        transport.max(&mut sizes);
        let [a, b] = pressures;
        let error = difference(a.into_iter(), b.into_iter());
        assert!(sizes[0] > 10.0 && error < 1e-7 * sizes[0], "{error:e} of {sizes:?}");
    });
}

/// A solve with options of PETSc.
fn with_options(job: &Job, text: &str) -> Result<usize, SolveError> {
    let setup = shared(setups().remove(0).1, job);
    let (problem, transport) = (setup.pressure_problem(), job.new_transport());
    let options = Options::parse(text).unwrap();
    let mut solver =
        PetscSolver::new(&problem, job.world(), &options, &Settings::default(), Preconditioning::Multigrid)?;
    solver.set_coefficients(&coefficients(&setup), &transport)?;
    let rhs = rough(&problem);
    Ok(solver.solve(&rhs, &mut Field::new(rhs.layout()), &transport)?.iterations)
}

#[test]
fn options_reach_petsc_and_its_refusals_the_fluid() {
    on_ranks(&[1, 2], "options_reach_petsc_and_its_refusals_the_fluid", |job| {
        let usual = with_options(job, "").unwrap();
        assert!(with_options(job, "-ksp_rtol 1e-10").unwrap() > usual);
        let message = |text: &str| with_options(job, text).unwrap_err().to_string();
        let unknown = message("-ksp_rtoll 1e-9");
        assert!(unknown.contains("-ksp_rtoll") && unknown.contains("did you mean -ksp_rtol?"), "{unknown}");
        let short = with_options(job, "-ksp_max_it 2").unwrap_err();
        assert!(matches!(short, SolveError::NotConverged { iterations: 2, .. }), "{short}");
        let rejected = message("-ksp_type cgg");
        assert!(rejected.contains("cgg"), "{rejected}");
    });
}
