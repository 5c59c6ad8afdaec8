//! Volumes of cells and of the control volumes of faces.

use grains_fluid::{CellPartition, Centre, Faces, Field, Grid, Layout};

/// Volumes of the own cells (m³).
pub fn volumes(grid: &Grid, partition: &CellPartition, layout: Layout) -> Field<Centre> {
    let (mut volumes, first) = (Field::new(layout), partition.first());
    for k in 0..layout.cells[2] {
        for j in 0..layout.cells[1] {
            for i in 0..layout.cells[0] {
                let width = |a: usize| grid.axis(a).width(([i, j, k][a] + first[a]) as isize);
                volumes.set(i as isize, j as isize, k as isize, width(0) * width(1) * width(2));
            }
        }
    }
    volumes
}

/// 1/V_f (1/m³) of the own faces: half of the cell on either side.
pub fn inverse_volumes(grid: &Grid, partition: &CellPartition, layout: Layout) -> Faces {
    let mut inverse = Faces::new(layout);
    let first = partition.first();
    for component in 0..3 {
        for k in 0..layout.cells[2] {
            for j in 0..layout.cells[1] {
                let row = layout.row(j, k);
                for i in 0..layout.cells[0] {
                    let volume: f64 = (0..3)
                        .map(|a| {
                            let cell = ([i, j, k][a] + first[a]) as isize;
                            let width = |c: isize| grid.axis(a).width(c);
                            if a == component { 0.5 * (width(cell) + width(cell + 1)) } else { width(cell) }
                        })
                        .product();
                    inverse.component_mut(component)[row + i] = 1.0 / volume;
                }
            }
        }
    }
    inverse
}
