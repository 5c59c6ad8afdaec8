//! Vectors over the cells of all ranks, each rank holding its own.

use super::bindings as c;
use super::session::Session;
use crate::PetscError;
use std::ops::{Deref, DerefMut};
use std::rc::Rc;

/// A number per cell of the grid, owned cells on each rank, x fastest.
pub struct Vector {
    raw: c::Vec,
    session: Rc<Session>,
    length: usize,
}

/// Read access to the owned cells of a [`Vector`].
pub struct ReadGuard<'a> {
    vector: &'a Vector,
    pointer: *const f64,
}

/// Access to the owned cells of a [`Vector`].
pub struct WriteGuard<'a> {
    vector: &'a mut Vector,
    pointer: *mut f64,
}

impl Vector {
    /// Takes over a vector made by PETSc.
    pub(super) fn adopt(raw: c::Vec, session: &Rc<Session>) -> Result<Self, PetscError> {
        let mut vector = Self { raw, session: Rc::clone(session), length: 0 };
        let mut length = 0;
        // SAFETY: the vector exists; PETSc writes its local length.
        session.check("VecGetLocalSize", unsafe { c::VecGetLocalSize(raw, &mut length) })?;
        vector.length = length as usize;
        Ok(vector)
    }

    pub(super) fn raw(&self) -> c::Vec {
        self.raw
    }

    /// The owned cells, to read.
    pub fn read(&self) -> Result<ReadGuard<'_>, PetscError> {
        let mut pointer = std::ptr::null();
        // SAFETY: the vector exists and is borrowed until the guard gives the array back.
        self.session.check("VecGetArrayRead", unsafe { c::VecGetArrayRead(self.raw, &mut pointer) })?;
        Ok(ReadGuard { vector: self, pointer })
    }

    /// The owned cells, to write.
    pub fn write(&mut self) -> Result<WriteGuard<'_>, PetscError> {
        let mut pointer = std::ptr::null_mut();
        // SAFETY: the vector exists and is borrowed mutably until the guard gives the array back.
        self.session.check("VecGetArray", unsafe { c::VecGetArray(self.raw, &mut pointer) })?;
        Ok(WriteGuard { vector: self, pointer })
    }

    /// Euclidean norm over all ranks.
    pub fn norm(&self) -> Result<f64, PetscError> {
        let mut norm = 0.0;
        // SAFETY: the vector exists; PETSc writes one number.
        let code = unsafe { c::VecNorm(self.raw, c::NormType::NORM_2, &mut norm) };
        self.session.check("VecNorm", code)?;
        Ok(norm)
    }

    /// Lets the vector stand for an array of the caller while `work` runs.
    pub(crate) fn with_array<T>(
        &self,
        array: &mut [f64],
        work: impl FnOnce(&Self) -> Result<T, PetscError>,
    ) -> Result<T, PetscError> {
        assert_eq!(array.len(), self.length, "an entry per owned cell");
        // SAFETY: the array is as long as the vector and borrowed mutably until it is taken back below;
        // a panic in `work` ends in the guard, which takes it back too.
        self.session.check("VecPlaceArray", unsafe { c::VecPlaceArray(self.raw, array.as_mut_ptr()) })?;
        let placed = Placed(self);
        let done = work(self);
        drop(placed);
        done
    }
}

struct Placed<'a>(&'a Vector);

impl Drop for Placed<'_> {
    fn drop(&mut self) {
        // SAFETY: an array was placed before, once.
        unsafe { c::VecResetArray(self.0.raw) };
    }
}

impl Drop for Vector {
    fn drop(&mut self) {
        if self.session.is_usable() {
            // SAFETY: destroyed once, while PETSc runs.
            unsafe { c::VecDestroy(&mut self.raw) };
        }
    }
}

impl Deref for ReadGuard<'_> {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        slice(self.pointer, self.vector.length)
    }
}

impl Drop for ReadGuard<'_> {
    fn drop(&mut self) {
        // SAFETY: the array came from VecGetArrayRead of this vector.
        unsafe { c::VecRestoreArrayRead(self.vector.raw, &mut self.pointer) };
    }
}

impl Deref for WriteGuard<'_> {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        slice(self.pointer, self.vector.length)
    }
}

impl DerefMut for WriteGuard<'_> {
    fn deref_mut(&mut self) -> &mut [f64] {
        if self.vector.length == 0 {
            return &mut [];
        }
        // SAFETY: PETSc's array of that length, borrowed mutably with the vector until the guard is dropped.
        unsafe { std::slice::from_raw_parts_mut(self.pointer, self.vector.length) }
    }
}

impl Drop for WriteGuard<'_> {
    fn drop(&mut self) {
        // SAFETY: the array came from VecGetArray of this vector.
        unsafe { c::VecRestoreArray(self.vector.raw, &mut self.pointer) };
    }
}

/// A slice over PETSc's array; empty arrays may be null.
fn slice<'a>(pointer: *const f64, length: usize) -> &'a [f64] {
    if length == 0 {
        return &[];
    }
    // SAFETY: called by the guards only, with an array of PETSc of that length that lives until they are
    // dropped.
    unsafe { std::slice::from_raw_parts(pointer, length) }
}
