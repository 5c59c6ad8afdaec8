//! Temporal VTKHDF files of fields on the cells of a grid.

use super::arrays::{Arrays, digest_of_step, read_nodes, write_nodes};
use super::xdmf::Sidecar;
use super::{GridBlock, GridGeometry};
use crate::digests::of_data;
use crate::error::{FileError, Shared};
use crate::fields::{Data, FieldSpec, Precision, fit};
use crate::growing::shortened;
use crate::metadata::Metadata;
use crate::temporal::{Layout, Temporal};
use hdf5::File;
use mpi::topology::SimpleCommunicator;
use std::path::Path;

/// A growing file of fields on the cells of a Cartesian grid; all calls are collective.
///
/// ```text
/// /VTKHDF                       ImageData (version 2.0) if the cells of each axis are equal,
///                               else RectilinearGrid (version 2.7, VTK 9.7)
/// /VTKHDF/CellData/<field>      [steps][z][y][x] or [steps][z][y][x][3], attribute `unit`
/// /VTKHDF/Steps/Values          times (s)
/// /grid/x, /grid/y, /grid/z     coordinates of the nodes (m), one more than cells
/// /grains-mpi                   metadata
/// ```
///
/// It is complete after each [`GridFile::append`], so that a run may be killed at any time. The `.xdmf` file
/// beside it, which grows as that of a [`PolyDataFile`](crate::PolyDataFile), describes a 3DCoRectMesh or a
/// 3DRectMesh.
pub struct GridFile(Temporal<Cells>);

impl GridFile {
    /// Creates a file; one of that name is lost. Fields have one component or three.
    ///
    /// # Errors
    /// A file that cannot be created, nodes that do not ascend, or blocks that do not make up the grid.
    pub fn create(
        path: &Path,
        communicator: &SimpleCommunicator,
        grid: &GridGeometry,
        specs: &[FieldSpec],
        (precision, compress): (Precision, bool),
        metadata: &Metadata,
    ) -> Result<Self, FileError> {
        grid.check(path, communicator)?;
        let layout = Cells::new(grid, specs, precision);
        Temporal::create(path, communicator, layout, compress, metadata).map(Self)
    }

    /// Continues a file, forgetting every step after `time` (s).
    ///
    /// A step at `time` itself stays until it is appended again.
    ///
    /// # Errors
    /// A file that cannot be opened, or that holds other arrays, another grid or another precision.
    pub fn resume(
        path: &Path,
        communicator: &SimpleCommunicator,
        grid: &GridGeometry,
        specs: &[FieldSpec],
        precision: Precision,
        time: f64,
    ) -> Result<Self, FileError> {
        grid.check(path, communicator)?;
        Temporal::resume(path, communicator, Cells::new(grid, specs, precision), time).map(Self)
    }

    /// Writes metadata of a continued run into the group `grains-mpi/restart-<n>`.
    ///
    /// # Errors
    /// A full disk.
    pub fn record_restart(&self, metadata: &Metadata) -> Result<(), FileError> {
        self.0.record_restart(metadata)
    }

    /// Changes the cells of this rank: those of all ranks still make up the grid.
    ///
    /// # Errors
    /// Blocks that do not.
    pub fn divide(&mut self, first: [usize; 3], own: [usize; 3]) -> Result<(), FileError> {
        let grid = &mut self.0.layout.grid;
        (grid.first, grid.own) = (first, own);
        grid.check(&self.0.shared.path, &self.0.shared.communicator)
    }

    /// Whether the file ends with the step at `time` (s), as one that was continued from there.
    pub fn holds(&self, time: f64) -> bool {
        self.0.holds(time)
    }

    /// Appends a step at `time` (s); one at the same time or later, left from an earlier run, is replaced.
    ///
    /// `fields` come in the order of the file's specifications, `[z][y][x][components]` of the own cells.
    ///
    /// # Errors
    /// A full disk, a file that cannot be written, or fields whose lengths do not fit.
    pub fn append(&mut self, time: f64, fields: &[Data]) -> Result<(), FileError> {
        self.0.append(&Step { time, fields })
    }
}

/// One rank's share of a step.
struct Step<'a> {
    time: f64,
    fields: &'a [Data<'a>],
}

/// What a file holds.
struct Cells {
    grid: GridGeometry,
    specs: Vec<FieldSpec>,
    precision: Precision,
}

impl Cells {
    fn new(grid: &GridGeometry, specs: &[FieldSpec], precision: Precision) -> Self {
        Self { grid: grid.clone(), specs: specs.to_vec(), precision }
    }
}

impl Layout for Cells {
    type Arrays = Arrays;
    type Place = f64;
    type Step<'a> = Step<'a>;

    fn create(&self, file: &File, compress: bool) -> hdf5::Result<Arrays> {
        Arrays::create(file, &self.grid, &self.specs, (self.precision, compress))
    }

    fn begin(&self, shared: &Shared, file: &File) -> hdf5::Result<()> {
        write_nodes(file, &self.grid, shared.is_first())
    }

    fn open(&self, file: &File) -> hdf5::Result<Arrays> {
        Arrays::open(file, &self.specs)
    }

    fn places(&self, file: &File) -> hdf5::Result<Vec<f64>> {
        let arrays = self.open(file)?;
        if let Some(precision) = arrays.precision(&self.specs)? {
            self.precision.require(precision)?;
        }
        let nodes = read_nodes(file)?;
        if !self.grid.has_nodes(&nodes) {
            let [x, y, z] = nodes.map(|nodes| nodes.len().saturating_sub(1));
            let wanted = self.grid.cells();
            return Err(format!(
                "it holds another grid (of {x} x {y} x {z} cells, this run's: {} x {} x {})",
                wanted[0], wanted[1], wanted[2]
            )
            .into());
        }
        arrays.times()
    }

    fn cut(&self, arrays: &Arrays, kept: &[f64]) -> hdf5::Result<()> {
        arrays.cut(kept.len())
    }

    fn time(place: &f64) -> f64 {
        *place
    }

    fn time_of(step: &Step<'_>) -> f64 {
        step.time
    }

    fn fits(&self, step: &Step<'_>) -> Result<(), String> {
        fit(&self.specs, step.fields, self.grid.block().count())
    }

    fn write(
        &self,
        shared: &Shared,
        arrays: &Arrays,
        before: &[f64],
        step: &Step<'_>,
    ) -> Result<(f64, Vec<u64>), FileError> {
        let at = before.len();
        shared.written(arrays.resize(at + 1))?;
        for (field, data) in step.fields.iter().enumerate() {
            shared.written(match (data, self.precision) {
                (Data::Integer(values), _) => arrays.write_field(shared, (field, at), &self.grid, values),
                (Data::Real(values), Precision::F64) => {
                    arrays.write_field(shared, (field, at), &self.grid, values)
                }
                (Data::Real(values), Precision::F32) => {
                    arrays.write_field(shared, (field, at), &self.grid, &shortened(values))
                }
            })?;
        }
        let entries = if shared.is_first() { arrays.write_step(at, step.time) } else { Ok(()) };
        shared.written(entries)?;
        let digests =
            self.specs.iter().zip(step.fields).map(|(spec, data)| {
                digest_of_block(&self.grid.block(), spec.components, data, self.precision)
            });
        Ok((step.time, digests.collect()))
    }

    fn arrays(&self) -> Vec<String> {
        self.specs.iter().map(|spec| spec.name.to_string()).collect()
    }

    fn digest(&self, time: &f64) -> u64 {
        digest_of_step(*time, &self.grid.nodes)
    }

    fn publish(&self, arrays: &Arrays, steps: usize) -> hdf5::Result<()> {
        arrays.publish(steps)
    }

    fn description(&self, file: &str, step: usize, time: &f64) -> String {
        let Self { grid, specs, precision } = self;
        Sidecar { grid, specs, precision: *precision }.text(file, step, *time)
    }
}

/// This rank's part of the checksum of a field, by the places of the values in the whole array.
fn digest_of_block(block: &GridBlock, width: usize, data: &Data, precision: Precision) -> u64 {
    let length = block.own[0] * width;
    block.rows().enumerate().fold(0, |sum: u64, (k, first)| {
        let own = k * length..(k + 1) * length;
        let row = match data {
            Data::Real(values) => Data::Real(&values[own]),
            Data::Integer(values) => Data::Integer(&values[own]),
        };
        sum.wrapping_add(of_data(first * width, &row, precision))
    })
}
