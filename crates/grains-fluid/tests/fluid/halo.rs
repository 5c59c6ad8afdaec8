//! Halos filled from owners and added back to them, on any ranks.

use crate::common::{joined, partition, piece};
use grains_domain::Transport;
use grains_fluid::{Centre, Field, Grid, Halo, Layout};
use grains_testing::on_ranks;

const CELLS: [usize; 3] = [9, 7, 8];

fn grid(periodic: [bool; 3]) -> Grid {
    Grid::uniform([0.0; 3], [9.0, 7.0, 8.0], CELLS, periodic).unwrap()
}

/// Number of a global cell, wrapped; none beyond a closed face.
fn number(cell: [isize; 3], periodic: [bool; 3]) -> Option<f64> {
    let mut number = 0;
    for a in (0..3).rev() {
        let n = CELLS[a] as isize;
        if !periodic[a] && !(0..n).contains(&cell[a]) {
            return None;
        }
        number = number * n + cell[a].rem_euclid(n);
    }
    Some(number as f64)
}

fn places(layout: Layout) -> Vec<[isize; 3]> {
    let [nx, ny, nz] = layout.cells.map(|n| n as isize);
    let h = layout.halo as isize;
    let mut all = Vec::new();
    for k in -h..nz + h {
        for j in -h..ny + h {
            all.extend((-h..nx + h).map(|i| [i, j, k]));
        }
    }
    all
}

#[test]
fn every_halo_cell_gets_its_owners_value_and_gives_back_what_is_put_in() {
    for periodic in [[true; 3], [false; 3], [true, false, true]] {
        for ranks in [[1, 1, 1], [2, 1, 1], [1, 2, 2], [3, 1, 2], [2, 3, 2]] {
            for halo in [2, 3] {
                if CELLS.iter().zip(ranks).any(|(n, r)| r > 1 && n / r < halo) {
                    continue;
                }
                check(periodic, ranks, halo);
            }
        }
    }
}

fn check(periodic: [bool; 3], ranks: [usize; 3], halo: usize) {
    let grid = grid(periodic);
    let counts = on_ranks(ranks.iter().product(), |transport| {
        let own = partition(&grid, ranks, transport.rank());
        let layout = Layout { cells: own.cells(), halo };
        let first = own.first().map(|f| f as isize);
        let global = |p: [isize; 3]| std::array::from_fn(|a| p[a] + first[a]);
        let mut exchange = Halo::new(&grid, &own, layout);
        let (mut one, mut two) = (Field::<Centre>::new(layout), Field::<Centre>::new(layout));
        one.fill(f64::NAN);
        two.fill(f64::NAN);
        for p in places(layout) {
            if (0..3).all(|a| (0..layout.cells[a] as isize).contains(&p[a])) {
                let value = number(global(p), periodic).unwrap();
                one.set(p[0], p[1], p[2], value);
                two.set(p[0], p[1], p[2], -value);
            }
        }
        exchange.fill(&mut [one.data_mut(), two.data_mut()], &transport);
        for [i, j, k] in places(layout) {
            if let Some(value) = number(global([i, j, k]), periodic) {
                assert_eq!(
                    [one.at(i, j, k), two.at(i, j, k)],
                    [value, -value],
                    "{periodic:?} {ranks:?} {i} {j} {k}"
                );
            }
        }
        for depth in 1..halo {
            check_layers((&mut exchange, layout), depth, |p| number(global(p), periodic), &transport);
        }
        // One into every place that stands for a cell: owners find how often they are seen.
        for [i, j, k] in places(layout) {
            one.set(i, j, k, f64::from(u8::from(number(global([i, j, k]), periodic).is_some())));
        }
        let seen: f64 = one.data().iter().sum();
        exchange.add(&mut [one.data_mut()], &transport);
        let left: f64 = one.data().iter().sum();
        assert_eq!(left, one.own().sum::<f64>(), "halos are cleared");
        (seen, piece(one.data(), layout, own.first()))
    });
    let seen: f64 = counts.iter().map(|c| c.0).sum();
    let sums = joined(counts.into_iter().map(|c| c.1).collect());
    assert_eq!(seen, sums.iter().sum::<f64>(), "nothing is lost");
    assert!(sums.iter().all(|s| *s >= 1.0));
}

/// So many layers next to the own cells are filled and given back as they are with all others.
fn check_layers(
    (exchange, layout): (&mut Halo, Layout),
    depth: usize,
    number: impl Fn([isize; 3]) -> Option<f64>,
    transport: &dyn Transport,
) {
    let is_within = |p: &[isize; 3], depth: usize| {
        let d = depth as isize;
        (0..3).all(|a| (-d..layout.cells[a] as isize + d).contains(&p[a]))
    };
    let mut some = Field::<Centre>::new(layout);
    for p in places(layout).into_iter().filter(|p| is_within(p, 0)) {
        some.set(p[0], p[1], p[2], number(p).unwrap());
    }
    exchange.fill_to(depth, &mut [some.data_mut()], transport);
    for p in places(layout).into_iter().filter(|p| is_within(p, depth)) {
        assert_eq!(some.at(p[0], p[1], p[2]), number(p).unwrap_or(0.0), "{depth} {p:?}");
    }
    some.fill(0.0);
    for (n, p) in places(layout).into_iter().filter(|p| is_within(p, depth)).enumerate() {
        some.set(p[0], p[1], p[2], number(p).map_or(0.0, |_| (n % 17) as f64));
    }
    let mut all = some.clone();
    exchange.add_to(depth, &mut [some.data_mut()], transport);
    exchange.add(&mut [all.data_mut()], transport);
    assert_eq!(some, all, "{depth}");
}

#[test]
fn a_rank_with_fewer_cells_than_the_halo_is_refused() {
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [5, 8, 8], [false; 3]).unwrap();
    let error = partition(&grid, [4, 1, 1], 0).check(2).unwrap_err();
    assert!(error.to_string().contains("fewer than the halo of 2"), "{error}");
}
