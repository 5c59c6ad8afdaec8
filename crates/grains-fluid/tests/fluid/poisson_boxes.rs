//! The pressure in boxes of any numbers of cells, with outlets that are closed all the same, and cut in two.

use crate::common::{difference, joined, partition, piece, set};
use crate::poisson::{Ends, coefficients, problem, residual};
use grains_domain::SerialTransport;
use grains_fluid::{
    Axis, ConjugateGradients, Field, Grid, Preconditioner, PressureOperator, PressureProblem, PressureSolver,
};
use grains_testing::on_ranks;

/// Boxes of any numbers of cells, periodic and closed, thin or not; of every three, one whose outlets are closed all the same, and
/// one that a closed plane cuts in two: corrections fall towards outlets, which costs iterations where these are closed.
#[test]
fn multigrid_takes_few_iterations_in_boxes_of_any_numbers_of_cells() {
    use Ends::{Closed, Periodic};
    let kinds = [Periodic, Closed(false, false), Closed(false, true), Closed(true, true)];
    let mut largest = [0; 3];
    for case in 0..1500_usize {
        let ends = [0, 1, 2].map(|a| kinds[(case >> (2 * a)) % 4]);
        let cells = [1 + (7 * case + case / 3) % 23, 1 + (5 * case) % 7, 2 + (11 * case) % 41];
        let cells =
            [0, 1, 2].map(|a| if matches!(ends[a], Closed(_, true)) { cells[a].max(2) } else { cells[a] });
        let axes = [0, 1, 2].map(|a| {
            let length = cells[a] as f64 * [1.0, 0.9, 1.1][(case + a) % 3];
            Axis::uniform(0.0, length, cells[a], matches!(ends[a], Periodic))
        });
        let grid = Grid::new(axes).unwrap();
        let whole = partition(&grid, [1; 3], 0);
        let problem = PressureProblem { grid, partition: whole, halo: 2, imposed: ends.map(Ends::imposed) };
        let mut faces = coefficients(&problem, 0.5);
        let (layout, strides) = (faces.layout(), faces.layout().strides());
        let index = |a: usize, p: usize| (p / strides[a] % layout.dims()[a]) as isize - 2;
        for a in 0..3 {
            let is_closed = |p: usize| match case % 3 {
                1 => !matches!(ends[a], Periodic) && [-1, cells[a] as isize - 1].contains(&index(a, p)),
                2 => a == 2 && index(2, p).rem_euclid(cells[2] as isize) == cells[2] as isize / 2 - 1,
                _ => false,
            };
            let all = faces.component_mut(a).iter_mut().enumerate();
            all.filter(|(p, _)| is_closed(*p)).for_each(|(_, c)| *c = 0.0);
        }
        // What some pressure balances.
        let mut operator = PressureOperator::new(&problem);
        operator.set(&faces);
        let [mut rhs, mut wave, mut p] = [0; 3].map(|_| Field::new(layout));
        set(&mut wave, [0; 3], |[i, j, k]| ((3 * i + 5 * j + 7 * k + case) as f64).sin());
        let mut halo = grains_fluid::Halo::new(&problem.grid, &problem.partition, layout);
        halo.fill(&mut [wave.data_mut()], &SerialTransport);
        operator.apply(&wave, &mut rhs);
        let limits = [1e-8, 60.0];
        let mut solver =
            ConjugateGradients::preconditioned(&problem, limits, Preconditioner::Multigrid, &SerialTransport);
        solver.set_coefficients(&faces, &SerialTransport).unwrap();
        let report = solver.solve(&rhs, &mut p, &SerialTransport);
        let report = report.unwrap_or_else(|error| panic!("{case} {cells:?} {ends:?}: {error}"));
        assert!(residual(&problem, &faces, &rhs, &mut p) < 1.01e-8, "{case} {cells:?} {ends:?}");
        largest[case % 3] = largest[case % 3].max(report.iterations);
    }
    println!("measured largest iterations: {largest:?}, closed outlets and boxes cut in two apart");
    assert!(largest[0] <= 16 && largest[1] <= 52 && largest[2] <= 32, "{largest:?}");
}

/// An outlet that is closed all the same leaves no pressure tied: on any ranks it is that of one rank but for a constant.
#[test]
fn closed_outlets_give_the_same_pressure_on_any_ranks() {
    let ends = [Ends::Periodic, Ends::Closed(false, false), Ends::Closed(false, true)];
    let solve = |ranks: [usize; 3]| {
        let pieces = on_ranks(ranks.iter().product(), |transport| {
            let mut problem = problem(ends, 13, [false; 3]);
            problem.partition = partition(&problem.grid, ranks, grains_domain::Transport::rank(&transport));
            let (first, top) = (problem.partition.first(), problem.grid.axis(2).cells());
            let mut faces = coefficients(&problem, 0.5);
            let (layout, stride) = (faces.layout(), faces.layout().strides()[2]);
            let all = faces.component_mut(2).iter_mut().enumerate();
            all.filter(|(p, _)| p / stride + first[2] == top + 1).for_each(|(_, c)| *c = 0.0);
            let mut operator = PressureOperator::new(&problem);
            operator.set(&faces);
            let [mut rhs, mut wave, mut p] = [0; 3].map(|_| Field::new(layout));
            set(&mut wave, first, |[i, j, k]| ((3 * i + 5 * j + 7 * k) as f64).sin());
            let mut halo = grains_fluid::Halo::new(&problem.grid, &problem.partition, layout);
            halo.fill(&mut [wave.data_mut()], &transport);
            operator.apply(&wave, &mut rhs);
            let mut solver = ConjugateGradients::new(&problem, 1e-10, 80, &transport);
            solver.set_coefficients(&faces, &transport).unwrap();
            let report = solver.solve(&rhs, &mut p, &transport).unwrap();
            assert!(report.residual <= 1e-10, "{ranks:?}: {report:?}");
            piece(p.data(), layout, first)
        });
        let mut pressure = joined(pieces);
        let mean = pressure.iter().sum::<f64>() / pressure.len() as f64;
        pressure.iter_mut().for_each(|p| *p -= mean);
        pressure
    };
    let serial = solve([1; 3]);
    for ranks in [[2, 1, 1], [1, 2, 2], [1, 1, 8], [3, 2, 2], [5, 3, 4]] {
        let error = difference(&serial, &solve(ranks));
        assert!(error < 1e-8, "{ranks:?}: {error:.2e}");
    }
}
