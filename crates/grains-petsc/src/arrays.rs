//! Fields with halo to and from arrays of the own cells and their faces.

use grains_fluid::{Centre, Faces, Field, PressureProblem};

/// Copies the own cells of a field into an array, x fastest, each times its factor.
pub(crate) fn gather(field: &Field<Centre>, factors: &[f64], array: &mut [f64]) {
    let nx = field.layout().cells[0];
    let rows = array.chunks_exact_mut(nx).zip(factors.chunks_exact(nx));
    for ((out, factors), start) in rows.zip(field.layout().rows()) {
        let from = &field.data()[start..start + nx];
        out.iter_mut().zip(from).zip(factors).for_each(|((out, value), factor)| *out = value * factor);
    }
}

/// Copies an array of the own cells into a field, each divided by its factor.
pub(crate) fn scatter(array: &[f64], factors: &[f64], field: &mut Field<Centre>) {
    let nx = field.layout().cells[0];
    let rows = array.chunks_exact(nx).zip(factors.chunks_exact(nx));
    for ((values, factors), start) in rows.zip(field.layout().rows()) {
        let to = &mut field.data_mut()[start..start + nx];
        to.iter_mut().zip(values).zip(factors).for_each(|((to, value), factor)| *to = value / factor);
    }
}

/// Copies all faces of the own cells normal to an axis, from the lower face of the first cell on.
pub(crate) fn gather_faces(faces: &Faces, axis: usize, array: &mut [f64]) {
    let layout = faces.layout();
    let [nx, ny, nz] = layout.cells.map(|n| n as isize);
    let mut from = [0; 3];
    from[axis] = -1;
    let count = (nx - from[0]) as usize;
    let mut rows = array.chunks_exact_mut(count);
    for k in from[2]..nz {
        for (j, row) in (from[1]..ny).zip(&mut rows) {
            row.copy_from_slice(&faces.component(axis)[layout.index(from[0], j, k)..][..count]);
        }
    }
}

/// Widths (m) of all cells along an axis.
pub(crate) fn widths(problem: &PressureProblem, axis: usize) -> Vec<f64> {
    let axis = problem.grid.axis(axis);
    (0..axis.cells() as isize).map(|cell| axis.width(cell)).collect()
}

/// Inverse volumes (1/m³) of the own cells.
pub(crate) fn inverse_volumes(problem: &PressureProblem) -> Vec<f64> {
    let (first, cells) = (problem.partition.first(), problem.partition.cells());
    let own = |a: usize| {
        let axis = problem.grid.axis(a);
        (0..cells[a]).map(move |cell| axis.width((first[a] + cell) as isize))
    };
    let across = own(2).flat_map(|z| own(1).map(move |y| y * z));
    across.flat_map(|area| own(0).map(move |x| 1.0 / (x * area))).collect()
}
