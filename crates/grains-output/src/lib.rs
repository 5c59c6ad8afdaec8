//! The files of the solver, in forms that ParaView, h5py and pandas read directly.
//!
//! | file | form |
//! |---|---|
//! | `particles.vtkhdf`, `walls.vtkhdf`, `surfaces.vtkhdf` | temporal VTKHDF 2.0 PolyData, for ParaView 5.12 and later |
//! | `fluid.vtkhdf` | temporal VTKHDF 2.0 ImageData; of unequal cells 2.7 RectilinearGrid, for ParaView 6.2 and later |
//! | `*.xdmf` beside each | the same arrays by reference, for ParaView 5.11 and earlier, and 6.1 if cells are unequal |
//! | `shapes/<id>.vtp`, `view.py` | reference surfaces, and the script that glyphs particles with them in ParaView |
//! | `series.csv` | one row per interval, comments with `#` |
//! | `profile-<name>.csv` | a block of rows per output; `profile-<name>-mean.csv` is written anew each time |
//! | `checkpoint-<step>.h5` | complete state, checksummed, written aside and renamed |
//!
//! Nothing here knows of particles or fluids: arrays come by name. Every call is collective over the
//! communicator unless it says otherwise, and all ranks come to the same verdict: an error on one is an error
//! on all, and rank 0 has its text.
//!
//! After an error of writing end the job by `MPI_Abort` rather than properly: HDF5 tries once more to write
//! what it could not when MPI ends, and may wait for ever.

mod arrays;
mod checkpoint;
mod collective;
mod columns;
mod digests;
mod error;
mod fields;
mod grid;
mod growing;
mod metadata;
mod parallel_file;
mod polydata;
mod series;
mod shapes;
mod snapshots;
mod surfaces;
mod temporal;
mod watch;
mod writers;
mod xdmf;

pub use checkpoint::{
    Array, CheckpointFile, GridArray, Values, abandon_later, checkpoints, checksum_of_bytes, latest_valid,
    remove_old, write_checkpoint,
};
pub use columns::read_columns_as_csv;
pub use error::{FileError, agree, agree_written, from_rank};
pub use fields::{Data, FieldSpec, Kind, Precision};
pub use grid::{GridBlock, GridFile, GridGeometry, GridSnapshotFile};
pub use metadata::{Metadata, utc_now};
pub use polydata::{PolyDataFile, Step};
pub use series::{Series, write_table};
pub use shapes::{ShapeSurface, read_shape, write_shape};
pub use snapshots::SnapshotFile;
pub use surfaces::{SurfaceFile, Triangles};
