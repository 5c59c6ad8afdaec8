//! Sparse matrices, rows distributed over the ranks.

use super::bindings as c;
use super::session::Session;
use super::vector::Vector;
use crate::PetscError;
use std::ptr::{null, null_mut};
use std::rc::Rc;

/// Rows of a matrix that this rank holds: columns ascend within each row.
pub(crate) struct Rows<'a> {
    /// Number of columns that this rank holds of the vectors the matrix is applied to.
    pub local_columns: usize,
    /// Where each row begins in `columns`, and where the last ends.
    pub starts: &'a [i32],
    /// Global columns.
    pub columns: &'a [i32],
}

/// A matrix whose pattern is fixed and whose values may change.
pub(crate) struct Matrix {
    raw: c::Mat,
    session: Rc<Session>,
    entries: usize,
    /// Values on their way to PETSc, which on several ranks keeps them in two blocks.
    staged: Vec<f64>,
}

impl Matrix {
    /// A matrix of the given pattern, all entries `value`.
    pub fn new(session: &Rc<Session>, rows: &Rows, value: f64) -> Result<Self, PetscError> {
        let (count, width) = (rows.starts.len() as i32 - 1, rows.local_columns as i32);
        let staged = vec![value; rows.columns.len()];
        let (starts, columns, values) = (rows.starts.as_ptr(), rows.columns.as_ptr(), staged.as_ptr());
        let mut matrix =
            Self { raw: null_mut(), session: Rc::clone(session), entries: staged.len(), staged: Vec::new() };
        let (communicator, raw) = (session.raw(), &mut matrix.raw);
        // SAFETY: the three arrays describe `count` rows as PETSc expects them and are copied by it.
        unsafe {
            if session.is_serial() {
                let empty = c::MatCreateSeqAIJ(communicator, count, width, 0, null(), raw);
                session.check("MatCreateSeqAIJ", empty)?;
                let code = c::MatSeqAIJSetPreallocationCSR(*raw, starts, columns, values);
                session.check("MatSeqAIJSetPreallocationCSR", code)?;
            } else {
                let determined = c::PETSC_DETERMINE;
                let code = c::MatCreateMPIAIJWithArrays(
                    communicator,
                    count,
                    width,
                    determined,
                    determined,
                    starts,
                    columns,
                    values,
                    raw,
                );
                session.check("MatCreateMPIAIJWithArrays", code)?;
            }
        }
        if !session.is_serial() {
            matrix.staged = staged;
        }
        Ok(matrix)
    }

    pub(super) fn raw(&self) -> c::Mat {
        self.raw
    }

    /// Lets `fill` write all values, in the order of the pattern's columns.
    pub fn update(&mut self, fill: impl FnOnce(&mut [f64])) -> Result<(), PetscError> {
        if !self.session.is_serial() {
            fill(&mut self.staged);
            // SAFETY: as many values as the pattern has, in its order; PETSc copies them.
            let code = unsafe { c::MatUpdateMPIAIJWithArray(self.raw, self.staged.as_ptr()) };
            return self.session.check("MatUpdateMPIAIJWithArray", code);
        }
        let mut pointer = null_mut();
        // SAFETY: a sequential matrix, whose values lie in the order of its pattern; the array is given back
        // before anything else uses the matrix.
        unsafe {
            self.session.check("MatSeqAIJGetArray", c::MatSeqAIJGetArray(self.raw, &mut pointer))?;
            fill(std::slice::from_raw_parts_mut(pointer, self.entries));
            self.session.check("MatSeqAIJRestoreArray", c::MatSeqAIJRestoreArray(self.raw, &mut pointer))
        }
    }

    /// Two vectors: one the matrix can be applied to, one for the result.
    pub fn vectors(&self) -> Result<(Vector, Vector), PetscError> {
        let (mut right, mut left) = (null_mut(), null_mut());
        // SAFETY: PETSc makes two vectors, which are taken over.
        self.session.check("MatCreateVecs", unsafe { c::MatCreateVecs(self.raw, &mut right, &mut left) })?;
        Ok((Vector::adopt(right, &self.session)?, Vector::adopt(left, &self.session)?))
    }

    /// y = A x.
    pub fn multiply(&self, x: &Vector, y: &Vector) -> Result<(), PetscError> {
        // SAFETY: three objects that exist; PETSc checks that their sizes agree.
        self.session.check("MatMult", unsafe { c::MatMult(self.raw, x.raw(), y.raw()) })
    }

    /// y = Aᵀ x.
    pub fn multiply_transposed(&self, x: &Vector, y: &Vector) -> Result<(), PetscError> {
        // SAFETY: three objects that exist; PETSc checks that their sizes agree.
        self.session.check("MatMultTranspose", unsafe { c::MatMultTranspose(self.raw, x.raw(), y.raw()) })
    }

    /// Declares the matrix symmetric, as PETSc then stores no transpose.
    pub fn set_symmetric(&mut self) -> Result<(), PetscError> {
        for option in [c::MatOption::MAT_SYMMETRIC, c::MatOption::MAT_SYMMETRY_ETERNAL] {
            // SAFETY: the matrix exists.
            let code = unsafe { c::MatSetOption(self.raw, option, c::PetscBool::PETSC_TRUE) };
            self.session.check("MatSetOption", code)?;
        }
        Ok(())
    }

    /// Declares that the matrix maps constants to zero, or that it does not.
    pub fn set_constant_null_space(&mut self, is_singular: bool) -> Result<(), PetscError> {
        let (session, mut space) = (&self.session, null_mut());
        // SAFETY: the matrix takes a reference to the space of its own; a null pointer removes the old one.
        unsafe {
            if is_singular {
                let truth = c::PetscBool::PETSC_TRUE;
                let code = c::MatNullSpaceCreate(session.raw(), truth, 0, null(), &mut space);
                session.check("MatNullSpaceCreate", code)?;
            }
            session.check("MatSetNullSpace", c::MatSetNullSpace(self.raw, space))?;
            session.check("MatNullSpaceDestroy", c::MatNullSpaceDestroy(&mut space))
        }
    }
}

impl Drop for Matrix {
    fn drop(&mut self) {
        if self.session.is_usable() {
            // SAFETY: destroyed once, while PETSc runs; a null pointer is allowed.
            unsafe { c::MatDestroy(&mut self.raw) };
        }
    }
}
