//! Grids shared among ranks.

#![allow(dead_code)] // each test program uses its part

use grains_domain::{Decomposition, GlobalBox};
use grains_fluid::{Axis, CellPartition, Centre, Field, Grid};

/// A channel between walls across z, refined there and periodic along x, with this axis along y.
pub fn refined_channel(y: Axis) -> Grid {
    Grid::new([Axis::uniform(0.0, 1.0, 12, true), y, Axis::clustered(0.0, 1.0, 10, 1.1)]).unwrap()
}

/// Cells of a rank by the decomposition of the particles.
pub fn partition(grid: &Grid, ranks: [usize; 3], rank: usize) -> CellPartition {
    let corner = |end: bool| {
        std::array::from_fn(|a| {
            let nodes = grid.axis(a).nodes();
            nodes[if end { nodes.len() - 1 } else { 0 }]
        })
    };
    let periodic = std::array::from_fn(|a| grid.axis(a).is_periodic());
    let global = GlobalBox::new(corner(false), corner(true), periodic);
    let decomposition = Decomposition::new(global, ranks, rank, 1e-9).unwrap();
    CellPartition::new(grid, &decomposition).unwrap()
}

/// Own values with their global cells: pieces of one global array.
pub fn piece(values: &[f64], layout: grains_fluid::Layout, first: [usize; 3]) -> Vec<([usize; 3], f64)> {
    let [nx, ny, nz] = layout.cells;
    let mut out = Vec::new();
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                out.push(([i + first[0], j + first[1], k + first[2]], values[layout.row(j, k) + i]));
            }
        }
    }
    out
}

/// The pieces of all ranks in one order.
pub fn joined(pieces: Vec<Vec<([usize; 3], f64)>>) -> Vec<f64> {
    let mut all: Vec<_> = pieces.into_iter().flatten().collect();
    all.sort_by_key(|(cell, _)| [cell[2], cell[1], cell[0]]);
    all.into_iter().map(|(_, value)| value).collect()
}

/// Largest difference of two arrays.
pub fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |m, (x, y)| f64::max(m, (x - y).abs()))
}

/// Sets the own cells of a field by a function of the global cell.
pub fn set(field: &mut Field<Centre>, first: [usize; 3], value: impl Fn([usize; 3]) -> f64) {
    let layout = field.layout();
    let [nx, ny, nz] = layout.cells;
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let cell = [i + first[0], j + first[1], k + first[2]];
                field.set(i as isize, j as isize, k as isize, value(cell));
            }
        }
    }
}

/// Order of convergence from errors on two grids refined by `ratio`.
pub fn order(coarse: f64, fine: f64, ratio: f64) -> f64 {
    (coarse / fine).ln() / ratio.ln()
}
