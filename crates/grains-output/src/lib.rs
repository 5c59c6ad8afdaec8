//! The files of the solver, in forms that ParaView, h5py and pandas read directly.
//!
//! | file | form |
//! |---|---|
//! | `particles.vtkhdf`, `walls.vtkhdf`, `surfaces.vtkhdf` | temporal VTKHDF 2.0 PolyData, for ParaView 5.12 and later |
//! | `*.xdmf` beside each | the same arrays by reference, for ParaView 5.11 and earlier |
//! | `series.csv` | one row per interval, comments with `#` |
//! | `checkpoint-<step>.h5` | complete state, checksummed, written aside and renamed |
//!
//! Nothing here knows of particles: arrays come by name. Every call is collective over the communicator,
//! and all ranks come to the same verdict: an error on one is an error on all.

mod checkpoint;
mod collective;
mod error;
mod polydata;
mod series;
mod shapes;
mod xdmf;

pub use checkpoint::{Array, CheckpointFile, Values, latest_valid, remove_old, write_checkpoint};
pub use error::{FileError, agree};
pub use polydata::{Data, Field, FieldSpec, Kind, Metadata, PolyDataFile, Precision, Step};
pub use series::Series;
pub use shapes::{read_columns_as_csv, write_shape};
