//! Temporal VTKHDF 2.0 PolyData: points as vertices, or triangles, one part per step.

use crate::arrays::{Arrays, Cells, Place};
use crate::digests::{of_data, of_reals};
use crate::error::{FileError, Shared};
use crate::fields::{Data, FieldSpec, Precision, fit};
use crate::growing::shortened;
use crate::metadata::Metadata;
use crate::temporal::{Layout, Temporal};
use crate::xdmf::Sidecar;
use hdf5::File;
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::CommunicatorCollectives;
use std::path::Path;

/// One rank's share of a step.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// Time (s).
    pub time: f64,
    /// Positions (m), `[points][3]`.
    pub points: &'a [f64],
    /// Point numbers of this rank, `[triangles][3]`; empty for a cloud of points.
    pub triangles: &'a [i64],
    /// Fields, in the order of the file's specifications: on points of a cloud, on triangles of a surface.
    pub fields: &'a [Data<'a>],
}

/// A growing file of particles or of surfaces; all calls are collective.
///
/// It is complete after each [`PolyDataFile::append`], so that a run may be killed at any time. The
/// `.xdmf` file beside it grows by a text per step, and is written anew where steps are forgotten.
pub struct PolyDataFile(Temporal<PolyData>);

impl PolyDataFile {
    /// Creates a file for clouds of points (`is_surface` false) or triangles; a file of that name is lost.
    ///
    /// # Errors
    /// A file that cannot be created.
    pub fn create(
        path: &Path,
        communicator: &SimpleCommunicator,
        specs: &[FieldSpec],
        is_surface: bool,
        (precision, compress): (Precision, bool),
        metadata: &Metadata,
    ) -> Result<Self, FileError> {
        let layout = PolyData::new(specs, is_surface, precision);
        Temporal::create(path, communicator, layout, compress, metadata).map(Self)
    }

    /// Continues a file, forgetting every step after `time` (s).
    ///
    /// A step at `time` itself stays until it is appended again.
    ///
    /// # Errors
    /// A file that cannot be opened, or that holds other arrays or another precision.
    pub fn resume(
        path: &Path,
        communicator: &SimpleCommunicator,
        specs: &[FieldSpec],
        is_surface: bool,
        precision: Precision,
        time: f64,
    ) -> Result<Self, FileError> {
        let layout = PolyData::new(specs, is_surface, precision);
        Temporal::resume(path, communicator, layout, time).map(Self)
    }

    /// Writes metadata of a continued run into the group `grains-mpi/restart-<n>`.
    ///
    /// # Errors
    /// A full disk.
    pub fn record_restart(&self, metadata: &Metadata) -> Result<(), FileError> {
        self.0.record_restart(metadata)
    }

    /// Whether the file ends with the step at `time` (s), as one that was continued from there.
    pub fn holds(&self, time: f64) -> bool {
        self.0.holds(time)
    }

    /// Appends a step; one at the same time or later, left from an earlier run, is replaced.
    ///
    /// # Errors
    /// A full disk, a file that cannot be written, or fields whose lengths do not fit.
    pub fn append(&mut self, step: &Step) -> Result<(), FileError> {
        self.0.append(step)
    }
}

/// What a file holds.
struct PolyData {
    cells: Cells,
    specs: Vec<FieldSpec>,
    precision: Precision,
}

impl Layout for PolyData {
    type Arrays = Arrays;
    type Place = Place;
    type Step<'a> = Step<'a>;

    fn create(&self, file: &File, compress: bool) -> hdf5::Result<Arrays> {
        Arrays::create(file, self.cells, &self.specs, (self.precision, compress))
    }

    fn open(&self, file: &File) -> hdf5::Result<Arrays> {
        Arrays::open(file, self.cells, &self.specs)
    }

    fn places(&self, file: &File) -> hdf5::Result<Vec<Place>> {
        let arrays = self.open(file)?;
        self.precision.require(arrays.precision()?)?;
        arrays.places(file)
    }

    fn cut(&self, arrays: &Arrays, kept: &[Place]) -> hdf5::Result<()> {
        arrays.cut(kept.last())
    }

    fn time(place: &Place) -> f64 {
        place.time
    }

    fn time_of(step: &Step<'_>) -> f64 {
        step.time
    }

    fn fits(&self, step: &Step<'_>) -> Result<(), String> {
        let points = step.points.len() / 3;
        let rows = match self.cells {
            Cells::Vertices => points,
            Cells::Triangles => step.triangles.len() / 3,
        };
        if [step.points.len() % 3, step.triangles.len() % 3] != [0, 0] {
            return Err("points and triangles have not three numbers each".into());
        }
        fit(&self.specs, step.fields, rows)?;
        match step.triangles.iter().find(|&&p| p < 0 || p as usize >= points) {
            Some(point) => Err(format!("a triangle names point {point} of {points}")),
            None => Ok(()),
        }
    }

    fn write(
        &self,
        shared: &Shared,
        arrays: &Arrays,
        before: &[Place],
        step: &Step<'_>,
    ) -> Result<(Place, Vec<u64>), FileError> {
        let own_points = step.points.len() / 3;
        let (first_point, points) = share(shared, own_points);
        let (first_cell, own_cells, cells) = match self.cells {
            Cells::Vertices => (first_point, own_points, points),
            Cells::Triangles => {
                let own = step.triangles.len() / 3;
                let (first, all) = share(shared, own);
                (first, own, all)
            }
        };
        let place = Place::next(before.last(), step.time, points, cells);
        shared.written(arrays.extend(&place))?;
        shared.written(self.write_points((shared, arrays), place.first_point + first_point, step.points))?;
        let row = first_cell
            + match self.cells {
                Cells::Vertices => place.first_point,
                Cells::Triangles => place.first_cell,
            };
        let mut digests = vec![of_reals(3 * first_point, step.points, self.precision)];
        for (spec, data) in self.specs.iter().zip(step.fields) {
            digests.push(of_data(first_cell * spec.components, data, self.precision));
        }
        for (field, data) in step.fields.iter().enumerate() {
            shared.written(self.write_field((shared, arrays), (field, row), data))?;
        }
        self.write_cells(shared, arrays, &place, step, [first_point, first_cell, own_cells])?;
        let entries = if shared.is_first() { arrays.write_step(&place) } else { Ok(()) };
        shared.written(entries)?;
        Ok((place, digests))
    }

    fn arrays(&self) -> Vec<String> {
        std::iter::once("Points").chain(self.specs.iter().map(|spec| spec.name)).map(String::from).collect()
    }

    fn digest(&self, place: &Place) -> u64 {
        place.digest()
    }

    fn publish(&self, arrays: &Arrays, steps: usize) -> hdf5::Result<()> {
        arrays.publish(steps)
    }

    fn description(&self, file: &str, _step: usize, place: &Place) -> String {
        let Self { cells, specs, precision } = self;
        Sidecar { cells: *cells, specs, precision: *precision }.text(file, place)
    }
}

impl PolyData {
    fn new(specs: &[FieldSpec], is_surface: bool, precision: Precision) -> Self {
        let cells = if is_surface { Cells::Triangles } else { Cells::Vertices };
        Self { cells, specs: specs.to_vec(), precision }
    }

    fn write_points(
        &self,
        (shared, arrays): (&Shared, &Arrays),
        at: usize,
        points: &[f64],
    ) -> hdf5::Result<()> {
        match self.precision {
            Precision::F64 => arrays.write_points(shared, at, points),
            Precision::F32 => arrays.write_points(shared, at, &shortened(points)),
        }
    }

    fn write_field(
        &self,
        (shared, arrays): (&Shared, &Arrays),
        place: (usize, usize),
        data: &Data,
    ) -> hdf5::Result<()> {
        match (data, self.precision) {
            (Data::Integer(values), _) => arrays.write_field(shared, place, values),
            (Data::Real(values), Precision::F64) => arrays.write_field(shared, place, values),
            (Data::Real(values), Precision::F32) => arrays.write_field(shared, place, &shortened(values)),
        }
    }

    /// Writes this rank's cells; `own` is its first point and first cell within the step, and its cells.
    fn write_cells(
        &self,
        shared: &Shared,
        arrays: &Arrays,
        place: &Place,
        step: &Step,
        own: [usize; 3],
    ) -> Result<(), FileError> {
        let [first_point, first_cell, cells] = own;
        let connectivity: Vec<i64> = match self.cells {
            Cells::Vertices => (first_point as i64..(first_point + cells) as i64).collect(),
            Cells::Triangles => step.triangles.iter().map(|p| p + first_point as i64).collect(),
        };
        shared.written(arrays.write_connectivity(shared, place.first_cell + first_cell, &connectivity))?;
        let corners = self.cells.corners();
        let ends = (first_cell + 1..=first_cell + cells).map(|k| (k * corners) as i64);
        // Rank 0 writes the leading zero as well, and a second one if there are no cells.
        let zeros = if shared.is_first() { place.offsets() - place.cells } else { 0 };
        let offsets: Vec<i64> = std::iter::repeat_n(0, zeros).chain(ends).collect();
        let start = place.first_offset() + if zeros > 0 { 0 } else { first_cell + 1 };
        shared.written(arrays.write_offsets(shared, start, &offsets))
    }
}

/// First row of this rank and number of rows over all ranks.
fn share(shared: &Shared, own: usize) -> (usize, usize) {
    let (own, mut through, mut all) = (own as u64, 0_u64, 0_u64);
    shared.communicator.scan_into(&own, &mut through, SystemOperation::sum());
    shared.communicator.all_reduce_into(&own, &mut all, SystemOperation::sum());
    ((through - own) as usize, all as usize)
}
