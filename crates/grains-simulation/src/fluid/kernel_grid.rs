//! The cells of the fluid as the kernels of the coupling see them.

use grains_coupling::{Coupling, CouplingError, End, Grid as KernelGrid, GridAxis, Kernel, Layout as Places};
use grains_fluid::{CellPartition, Grid, Layout};
use std::ops::Range;

/// Width of the halo (cells) that a kernel needs on this grid, for particles of at most `diameter` (m) that may be
/// `drift` (m) outside their rank's subdomain.
///
/// Subdomains end in cells, not between them: another half cell; and the kernel leaves out the lowest layer, whose lower
/// faces no array holds.
pub fn halo_width(kernel: &Kernel, diameter: f64, drift: f64, smallest_cells: [f64; 3]) -> usize {
    let of_axis = |cell: f64| kernel.halo(diameter, drift + 0.5 * cell, cell) + 1;
    smallest_cells.map(of_axis).into_iter().fold(2, usize::max)
}

/// Refuses a kernel that covers too many cells of a rank, for particles of at most `diameter` (m).
///
/// # Errors
/// The kernel, with the cells it covers.
pub fn check_kernel(
    coupling: &Coupling,
    (grid, partition, halo): (&Grid, &CellPartition, usize),
    diameter: f64,
) -> Result<(), CouplingError> {
    let layout = Layout { cells: partition.cells(), halo };
    coupling.kernel.check(&kernel_grid(grid, partition, layout)?.0.axes, diameter)
}

/// The cells of a rank as kernels see them: without what lies beyond a boundary of the domain, and without the lowest layer
/// of the halo, so that face 0 of an axis is the upper face of a cell of the arrays.
pub fn kernel_grid(
    grid: &Grid,
    partition: &CellPartition,
    layout: Layout,
) -> Result<(KernelGrid, [Range<usize>; 3]), CouplingError> {
    let (h, first, strides) = (layout.halo, partition.first(), layout.strides());
    let mut starts = [0; 3];
    let mut axes = Vec::new();
    for a in 0..3 {
        let (axis, n) = (grid.axis(a), layout.cells[a]);
        let ends =
            partition.touches(a).map(|t| if t && !axis.is_periodic() { End::Boundary } else { End::Halo });
        starts[a] = if ends[0] == End::Boundary { h } else { 1 };
        let last = if ends[1] == End::Boundary { n + h } else { n + 2 * h };
        let node = |place: usize| axis.node(first[a] as isize + place as isize - h as isize);
        axes.push(GridAxis::new(a, (starts[a]..=last).map(node).collect(), ends)?);
    }
    let axes: [GridAxis; 3] = axes.try_into().unwrap_or_else(|_| unreachable!("three axes"));
    let offset: usize = (0..3).map(|a| starts[a] * strides[a]).sum();
    let stride = [strides[1], strides[2]];
    let places = |offset| Places { offset, stride };
    let own = std::array::from_fn(|a| h - starts[a]..h - starts[a] + layout.cells[a]);
    let grid = KernelGrid {
        axes,
        cells: places(offset),
        faces: std::array::from_fn(|a| places(offset - strides[a])),
        open: None,
    };
    Ok((grid, own))
}
