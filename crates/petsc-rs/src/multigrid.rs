//! The coarser grids: their matrices and the transfers between them.
//!
//! Coarse operators are discretised anew. PETSc's own, Pᵀ A P (`-pc_mg_galerkin both`), are twice too stiff with transfers that
//! are constant in a coarse cell: 22 iterations instead of 7 in a bed of void fraction 0.4.

use crate::PetscError;
use crate::ffi::{Matrix, Rows, Session, Vector};
use crate::levels::{Layout, Stencil};
use crate::pressure::{Boundary, Faces, Geometry, PressureMatrix};
use std::rc::Rc;

/// The way from one grid to the next coarser one.
struct Transfer {
    /// Coarse values to the cells within (piecewise constant); its transpose sums over them.
    matrix: Matrix,
    fine: Vector,
    coarse: Vector,
    /// Own cells along each axis that are the first, or the last, of their coarse cell: 1, else 0.
    ends: [[Vec<f64>; 2]; 3],
}

/// A coarse grid and its operator, discretised anew with coefficients averaged over the faces.
struct Level {
    layout: Layout,
    geometry: Geometry,
    stencil: Stencil,
    matrix: Matrix,
    /// Coefficients on the lower and upper face of each own cell.
    faces: [[Vec<f64>; 2]; 3],
    /// From the next finer grid.
    transfer: Transfer,
}

/// All grids coarser than that of the equation.
pub(crate) struct Hierarchy {
    /// From fine to coarse.
    levels: Vec<Level>,
}

impl Hierarchy {
    /// Coarsens while it pays, to at most `max_levels` grids with the finest.
    pub fn new(pressure: &PressureMatrix, max_levels: usize) -> Result<Self, PetscError> {
        let mut levels: Vec<Level> = Vec::new();
        let mut finer = pressure.layout.clone();
        while levels.len() + 1 < max_levels {
            let Some((layout, parents)) = finer.coarsened() else { break };
            levels.push(Level::new(
                &pressure.session,
                pressure.boundaries,
                &finer,
                layout.clone(),
                &parents,
            )?);
            finer = layout;
        }
        Ok(Self { levels })
    }

    /// Number of grids with the finest.
    pub fn count(&self) -> usize {
        self.levels.len() + 1
    }

    /// Averages the coefficients of the equation down to every level and fills the matrices.
    pub fn refresh(&mut self, pressure: &PressureMatrix) -> Result<(), PetscError> {
        let shared = Faces::shared(pressure.layout.counts(), pressure.faces.each_ref().map(|list| &list[..]));
        for l in 0..self.levels.len() {
            let (finer, coarser) = self.levels.split_at_mut(l);
            let level = &mut coarser[0];
            match finer.last() {
                None => level.average(&pressure.geometry, &shared)?,
                Some(finer) => {
                    let faces = Faces::per_cell(finer.layout.counts(), &finer.faces);
                    level.average(&finer.geometry, &faces)?;
                }
            }
            level.fill(pressure.scale)?;
            level.matrix.set_constant_null_space(pressure.is_singular)?;
        }
        Ok(())
    }

    /// Operators of the coarse grids, coarsest first.
    pub fn operators(&self) -> Vec<&Matrix> {
        self.levels.iter().rev().map(|level| &level.matrix).collect()
    }

    /// Transfers from each grid to the next finer one, coarsest first.
    pub fn transfers(&self) -> Vec<&Matrix> {
        self.levels.iter().rev().map(|level| &level.transfer.matrix).collect()
    }
}

impl Level {
    fn new(
        session: &Rc<Session>,
        boundaries: [[Boundary; 2]; 3],
        finer: &Layout,
        layout: Layout,
        parents: &[Vec<usize>; 3],
    ) -> Result<Self, PetscError> {
        let (geometry, cells) = (Geometry::new(&layout, boundaries), layout.counts().iter().product());
        let (columns, stencil) = layout.stencil();
        let rows = Rows { local_columns: cells, starts: &stencil.starts, columns: &columns };
        let mut matrix = Matrix::new(session, &rows, 0.0)?;
        matrix.set_symmetric()?;
        let faces = std::array::from_fn(|_| [vec![0.0; cells], vec![0.0; cells]]);
        let transfer = Transfer::new(session, finer, &layout, parents)?;
        Ok(Self { layout, geometry, stencil, matrix, faces, transfer })
    }

    /// Coefficients of the faces between coarse cells: means, weighted by area, over the fine faces that
    /// make them up.
    fn average(&mut self, fine: &Geometry, faces: &Faces) -> Result<(), PetscError> {
        for axis in 0..3 {
            for side in 0..2 {
                self.transfer.collect(fine, faces, axis, side)?;
                let sums = self.transfer.coarse.read()?;
                for_each_face(&self.geometry, axis, |cell, _, area| {
                    self.faces[axis][side][cell] = sums[cell] / area;
                });
            }
        }
        Ok(())
    }

    fn fill(&mut self, scale: f64) -> Result<(), PetscError> {
        let faces = Faces::per_cell(self.layout.counts(), &self.faces);
        let (geometry, stencil) = (&self.geometry, &self.stencil);
        self.matrix.update(|values| geometry.fill(stencil, &faces, scale, values))
    }
}

impl Transfer {
    fn new(
        session: &Rc<Session>,
        fine: &Layout,
        coarse: &Layout,
        parents: &[Vec<usize>; 3],
    ) -> Result<Self, PetscError> {
        let cells: usize = fine.counts().iter().product();
        let mut columns = Vec::with_capacity(cells);
        fine.for_each_cell(|_, cell| {
            columns.push(coarse.row([0, 1, 2].map(|a| parents[a][cell[a]])) as i32);
        });
        let (starts, local_columns): (Vec<i32>, _) =
            ((0..=cells as i32).collect(), coarse.counts().iter().product());
        let rows = Rows { local_columns, starts: &starts, columns: &columns };
        let matrix = Matrix::new(session, &rows, 1.0)?;
        let (coarse, fine_vector) = matrix.vectors()?;
        let ends = std::array::from_fn(|a| {
            let (first, parents) = (fine.lower()[a], &parents[a]);
            let own = first..first + fine.counts()[a];
            let is_end =
                |cell: usize, other: Option<usize>| other.is_none_or(|o| parents[o] != parents[cell]);
            let mark = |is: bool| f64::from(u8::from(is));
            let above = |cell: usize| (cell + 1 < parents.len()).then_some(cell + 1);
            [
                own.clone().map(|cell| mark(is_end(cell, cell.checked_sub(1)))).collect(),
                own.map(|cell| mark(is_end(cell, above(cell)))).collect(),
            ]
        });
        Ok(Self { matrix, fine: fine_vector, coarse, ends })
    }

    /// Sums coefficient times area of the fine faces on one side of every coarse cell.
    fn collect(
        &mut self,
        fine: &Geometry,
        faces: &Faces,
        axis: usize,
        side: usize,
    ) -> Result<(), PetscError> {
        let (nx, ny) = (fine.widths[0].len(), fine.widths[1].len());
        let marks = &self.ends[axis][side];
        let mut values = self.fine.write()?;
        let mut line: &[f64] = &[];
        for_each_face(fine, axis, |cell, [i, j, k], area| {
            if i == 0 {
                line = faces.line(axis, side, [j, k], nx);
            }
            debug_assert!(j < ny);
            values[cell] = line[i] * area * marks[[i, j, k][axis]];
        });
        drop(values);
        self.matrix.multiply_transposed(&self.fine, &self.coarse)
    }
}

/// Calls `visit` with own index, own place and area of a face normal to an axis of every own cell.
fn for_each_face(geometry: &Geometry, axis: usize, mut visit: impl FnMut(usize, [usize; 3], f64)) {
    let [wx, wy, wz] = &geometry.widths;
    let unless = |a: usize, width: f64| if a == axis { 1.0 } else { width };
    let mut cell = 0;
    for (k, z) in wz.iter().enumerate() {
        for (j, y) in wy.iter().enumerate() {
            let across = unless(1, *y) * unless(2, *z);
            for (i, x) in wx.iter().enumerate() {
                visit(cell, [i, j, k], across * unless(0, *x));
                cell += 1;
            }
        }
    }
}
