//! Which rank owns which cells.

use crate::axis::Axis;
use crate::ffi::{DistributedArray, Session, Vector};
use crate::levels::Layout;
use crate::{Petsc, PetscError};
use mpi::traits::Communicator;
use std::rc::Rc;

/// Cells of one rank.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// First cell along x, y, z.
    pub lower: [usize; 3],
    /// Number of cells along x, y, z.
    pub counts: [usize; 3],
}

/// A Cartesian grid of cells divided among the ranks (PETSc's DMDA).
pub struct Grid {
    pub(crate) session: Rc<Session>,
    pub(crate) layout: Layout,
    array: DistributedArray,
}

impl Grid {
    /// The grid in which rank (px, py, pz), numbered with x fastest, owns the cells
    /// `owned[0][px]` x `owned[1][py]` x `owned[2][pz]`. Collective.
    ///
    /// Errors if the ranks are not as many as the communicator has, if one would own nothing, or if there
    /// are more cells than PETSc's 32-bit numbers can count.
    pub fn new(petsc: &Petsc, owned: [&[usize]; 3], periodic: [bool; 3]) -> Result<Self, PetscError> {
        let (rank, size) = {
            let communicator = petsc.session.communicator();
            (communicator.rank() as usize, communicator.size() as usize)
        };
        let ranks = owned.map(<[usize]>::len);
        if ranks.iter().product::<usize>() != size {
            return Err(PetscError::Grid(format!(
                "it is divided among {} x {} x {} ranks, but there are {size}",
                ranks[0], ranks[1], ranks[2]
            )));
        }
        for (list, axis) in owned.iter().zip(["x", "y", "z"]) {
            if let Some(k) = list.iter().position(|&n| n == 0) {
                return Err(PetscError::Grid(format!(
                    "rank {k} of {} along {axis} would own no cells: use fewer ranks or more cells there",
                    list.len()
                )));
            }
        }
        let cells: f64 = owned.iter().map(|list| list.iter().sum::<usize>() as f64).product();
        if cells > f64::from(i32::MAX) {
            return Err(PetscError::Grid(format!(
                "{cells:.3e} cells are more than PETSc counts here (2.1e9)"
            )));
        }
        let axes = std::array::from_fn(|a| Axis::new(owned[a], periodic[a]));
        let place = [rank % ranks[0], rank / ranks[0] % ranks[1], rank / (ranks[0] * ranks[1])];
        let session = Rc::clone(&petsc.session);
        let array = DistributedArray::new(&session, owned, periodic)?;
        let grid = Self { session, layout: Layout { axes, place }, array };
        let (lower, counts) = grid.array.corners()?;
        let own = grid.owned();
        if (own.lower, own.counts) != (lower, counts) {
            return Err(PetscError::Grid(format!(
                "rank {rank} was to own {own:?}, PETSc gives it {counts:?} cells from {lower:?}: ranks must be numbered with x fastest"
            )));
        }
        Ok(grid)
    }

    /// Number of cells along x, y, z.
    pub fn cells(&self) -> [usize; 3] {
        self.layout.axes.each_ref().map(Axis::cells)
    }

    /// The own cells.
    pub fn owned(&self) -> Block {
        Block { lower: self.layout.lower(), counts: self.layout.counts() }
    }

    /// Which axes are periodic.
    pub fn periodic(&self) -> [bool; 3] {
        self.layout.axes.each_ref().map(|axis| axis.is_periodic)
    }

    /// A vector with a number per cell, zero at first. Collective.
    pub(crate) fn vector(&self) -> Result<Vector, PetscError> {
        self.array.vector()
    }
}
