//! PETSc's structured grid (DMDA) with the partition of the caller.

use super::bindings as c;
use super::session::Session;
use super::vector::Vector;
use crate::PetscError;
use std::ptr::null_mut;
use std::rc::Rc;

/// A DMDA of one number per cell.
pub(crate) struct DistributedArray {
    raw: c::DM,
    session: Rc<Session>,
}

impl DistributedArray {
    /// The grid in which rank (px, py, pz), x fastest, owns `owned[0][px]` x `owned[1][py]` x `owned[2][pz]`
    /// cells. No ghost cells: matrices are numbered by this crate.
    pub fn new(session: &Rc<Session>, owned: [&[usize]; 3], periodic: [bool; 3]) -> Result<Self, PetscError> {
        let lengths = owned.map(|list| list.iter().map(|&n| n as i32).collect::<std::vec::Vec<i32>>());
        let [x, y, z] = [0, 1, 2].map(|a| lengths[a].iter().sum::<i32>());
        let [px, py, pz] = [0, 1, 2].map(|a| lengths[a].len() as i32);
        let kind = |is: bool| match is {
            true => c::DMBoundaryType::DM_BOUNDARY_PERIODIC,
            false => c::DMBoundaryType::DM_BOUNDARY_NONE,
        };
        let [bx, by, bz] = periodic.map(kind);
        let mut grid = Self { raw: null_mut(), session: Rc::clone(session) };
        let star = c::DMDAStencilType::DMDA_STENCIL_STAR;
        // SAFETY: the lists have as many entries as there are ranks along their axis, and PETSc copies them.
        unsafe {
            let [lx, ly, lz] = [0, 1, 2].map(|a| lengths[a].as_ptr());
            let code = c::DMDACreate3d(
                session.raw(),
                bx,
                by,
                bz,
                star,
                x,
                y,
                z,
                px,
                py,
                pz,
                1,
                0,
                lx,
                ly,
                lz,
                &mut grid.raw,
            );
            session.check("DMDACreate3d", code)?;
            session.check("DMSetUp", c::DMSetUp(grid.raw))?;
        }
        Ok(grid)
    }

    /// First owned cell and number of owned cells per axis.
    pub fn corners(&self) -> Result<([usize; 3], [usize; 3]), PetscError> {
        let [mut x, mut y, mut z, mut nx, mut ny, mut nz] = [0; 6];
        // SAFETY: the grid is set up; PETSc writes six numbers.
        let code = unsafe { c::DMDAGetCorners(self.raw, &mut x, &mut y, &mut z, &mut nx, &mut ny, &mut nz) };
        self.session.check("DMDAGetCorners", code)?;
        Ok(([x, y, z].map(|n| n as usize), [nx, ny, nz].map(|n| n as usize)))
    }

    /// A vector over the cells.
    pub fn vector(&self) -> Result<Vector, PetscError> {
        let mut raw = null_mut();
        // SAFETY: the grid is set up; PETSc makes a vector, which is taken over.
        let code = unsafe { c::DMCreateGlobalVector(self.raw, &mut raw) };
        self.session.check("DMCreateGlobalVector", code)?;
        Vector::adopt(raw, &self.session)
    }
}

impl Drop for DistributedArray {
    fn drop(&mut self) {
        if self.session.is_usable() {
            // SAFETY: destroyed once, while PETSc runs; a null pointer is allowed.
            unsafe { c::DMDestroy(&mut self.raw) };
        }
    }
}
