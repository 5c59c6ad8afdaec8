//! Temporal VTKHDF 2.0 PolyData: points as vertices, or triangles, one part per step.

use crate::arrays::{Arrays, Cells, Place};
use crate::error::{FileError, Shared, agree};
use crate::fields::{FieldSpec, Kind, Precision};
use crate::metadata::{GROUP, Metadata, write_metadata};
use crate::xdmf::Sidecar;
use hdf5::File;
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{AsRaw, Communicator, CommunicatorCollectives};
use std::path::Path;

/// Values of a field on this rank, `[points or triangles][components]`.
#[derive(Clone, Copy, Debug)]
pub enum Data<'a> {
    /// Floating point.
    Real(&'a [f64]),
    /// Whole numbers.
    Integer(&'a [i64]),
}

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

const UNFIT: &str = "cannot be continued (move it aside, or run without --restart)";

/// The arrays come first: the file closes only when nothing in it is open any more.
struct Opened {
    arrays: Arrays,
    file: File,
}

/// A growing file of particles or of surfaces; all calls are collective.
///
/// It is complete after each [`PolyDataFile::append`], so that a run may be killed at any time. The
/// `.xdmf` file beside it is renewed at each step up to step 200, then each time it lags by 0.5 %, and when
/// the file is dropped.
pub struct PolyDataFile {
    shared: Shared,
    /// Open for all ranks; none after a failed [`PolyDataFile::keep`].
    opened: Option<Opened>,
    cells: Cells,
    specs: Vec<FieldSpec>,
    precision: Precision,
    steps: Vec<Place>,
    /// Steps the XDMF file knew when it was last written.
    described: usize,
}

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
        let shared = Shared::new(path, communicator);
        let cells = if is_surface { Cells::Triangles } else { Cells::Vertices };
        shared.create_empty()?;
        shared.has_room()?;
        let raw = shared.communicator.as_raw();
        let file = File::with_options().with_fapl(|p| p.mpio(raw, None)).create(path);
        let file = shared.all("cannot be created", file)?;
        let begun = (|| {
            let arrays =
                Arrays::create(&file, cells, specs, (precision, compress), shared.communicator.size());
            let arrays = shared.all("cannot be written", arrays)?;
            shared.all("cannot be written", write_metadata(&file, GROUP, metadata))?;
            shared.all("cannot be written", file.flush())?;
            Ok(arrays)
        })();
        let arrays = match begun {
            Ok(arrays) => arrays,
            Err(error) => {
                std::mem::forget(file);
                return Err(error);
            }
        };
        let (opened, specs) = (Some(Opened { arrays, file }), specs.to_vec());
        Ok(Self { shared, opened, cells, specs, precision, steps: Vec::new(), described: 0 })
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
        let shared = Shared::new(path, communicator);
        let cells = if is_surface { Cells::Triangles } else { Cells::Vertices };
        // Each rank alone first: a file that is no HDF5 must not stop the ranks at different calls.
        let found = (|| {
            let file = File::open(path)?;
            let arrays = Arrays::open(&file, cells, specs, 1)?;
            let found = arrays.precision()?;
            if found != precision {
                return Err(format!("its precision is {found:?}, this run writes {precision:?}").into());
            }
            arrays.places(&file)
        })();
        let steps = shared.all(UNFIT, found)?;
        let specs = specs.to_vec();
        let mut file = Self { shared, opened: None, cells, specs, precision, steps, described: 0 };
        let kept = file.steps.iter().take_while(|p| p.time <= time || is_same_time(p.time, time)).count();
        file.keep(kept)?;
        file.describe()?;
        Ok(file)
    }

    /// Writes metadata of a continued run into the group `grains-mpi/restart-<n>`.
    ///
    /// # Errors
    /// A full disk.
    pub fn record_restart(&self, metadata: &Metadata) -> Result<(), FileError> {
        let file = &self.opened()?.file;
        let written = (|| {
            let before = file.group(GROUP)?.member_names()?.len();
            write_metadata(file, &format!("{GROUP}/restart-{}", before + 1), metadata)?;
            file.flush()
        })();
        self.shared.all("cannot be written", written)
    }

    /// Appends a step; one at the same time or later, left from an earlier run, is replaced.
    ///
    /// # Errors
    /// A full disk, a file that cannot be written, or fields whose lengths do not fit.
    pub fn append(&mut self, step: &Step) -> Result<(), FileError> {
        agree(&self.shared.communicator, self.fits(step))?;
        self.shared.has_room()?;
        let outcome = self.append_fitting(step);
        if outcome.is_err() {
            // Closing would write again, fail on some ranks and leave the others waiting.
            std::mem::forget(self.opened.take());
        }
        outcome
    }

    fn append_fitting(&mut self, step: &Step) -> Result<(), FileError> {
        let kept = self.steps.iter().rposition(|p| p.time < step.time && !is_same_time(p.time, step.time));
        let kept = kept.map_or(0, |last| last + 1);
        if kept < self.steps.len() {
            self.keep(kept)?;
        }
        let own_points = step.points.len() / 3;
        let (first_point, points) = self.share(own_points);
        let (first_cell, own_cells, cells) = match self.cells {
            Cells::Vertices => (first_point, own_points, points),
            Cells::Triangles => {
                let own = step.triangles.len() / 3;
                let (first, all) = self.share(own);
                (first, own, all)
            }
        };
        let place = Place::next(self.steps.last(), step.time, points, cells);
        let Opened { file, arrays } = self.opened()?;
        self.written(arrays.extend(&place))?;
        self.written(self.write_points(arrays, place.first_point + first_point, step.points))?;
        let row = first_cell
            + match self.cells {
                Cells::Vertices => place.first_point,
                Cells::Triangles => place.first_cell,
            };
        for (field, data) in step.fields.iter().enumerate() {
            self.written(self.write_field(arrays, field, row, data))?;
        }
        self.write_cells(arrays, &place, step, [first_point, first_cell, own_cells])?;
        let entries = if self.shared.is_first() { arrays.write_step(&place) } else { Ok(()) };
        self.written(entries)?;
        self.written(arrays.publish(place.step + 1))?;
        self.written(file.flush())?;
        self.steps.push(place);
        if self.steps.len() > self.described + self.steps.len() / 200 {
            self.describe()?;
        }
        Ok(())
    }

    /// Brings the XDMF file up to date.
    fn describe(&mut self) -> Result<(), FileError> {
        self.described = self.steps.len();
        self.shared.first(|| self.sidecar().write(&self.shared.path))
    }

    fn sidecar(&self) -> Sidecar<'_> {
        Sidecar { cells: self.cells, specs: &self.specs, precision: self.precision, steps: &self.steps }
    }

    /// Whether this rank's arrays are as long as the file's specifications want.
    fn fits(&self, step: &Step) -> Result<(), FileError> {
        let refuse = |problem: String| Err(FileError::new(&self.shared.path, problem));
        let points = step.points.len() / 3;
        let rows = match self.cells {
            Cells::Vertices => points,
            Cells::Triangles => step.triangles.len() / 3,
        };
        if step.fields.len() != self.specs.len() {
            return refuse(format!("{} fields given, {} wanted", step.fields.len(), self.specs.len()));
        }
        for (spec, data) in self.specs.iter().zip(step.fields) {
            let (kind, length) = match data {
                Data::Real(values) => (Kind::Real, values.len()),
                Data::Integer(values) => (Kind::Integer, values.len()),
            };
            if (kind, length) != (spec.kind, rows * spec.components) {
                let (name, wanted) = (spec.name, rows * spec.components);
                return refuse(format!(
                    "`{name}` has {length} values of type {kind:?}, wanted are {wanted} of {:?}",
                    spec.kind
                ));
            }
        }
        match step.triangles.iter().find(|&&p| p < 0 || p as usize >= points) {
            Some(point) => refuse(format!("a triangle names point {point} of {points}")),
            None => Ok(()),
        }
    }

    /// Keeps the first `kept` steps and opens the file for all ranks.
    ///
    /// Rank 0 alone cuts it: HDF5 1.10 spoils compressed chunks that shrink in a file open for many ranks.
    fn keep(&mut self, kept: usize) -> Result<(), FileError> {
        self.opened = None;
        self.shared.communicator.barrier();
        if kept < self.steps.len() {
            self.steps.truncate(kept);
            self.described = 0;
            let cut = || {
                let file = File::open_rw(&self.shared.path)?;
                Arrays::open(&file, self.cells, &self.specs, 1)?.cut(self.steps.last())?;
                file.close()
            };
            let outcome = if self.shared.is_first() { cut() } else { Ok(()) };
            self.shared.all(UNFIT, outcome)?;
        }
        let (raw, ranks) = (self.shared.communicator.as_raw(), self.shared.communicator.size());
        let file = File::with_options().with_fapl(|p| p.mpio(raw, None)).open_rw(&self.shared.path);
        let file = self.shared.all(UNFIT, file)?;
        let arrays = self.shared.all(UNFIT, Arrays::open(&file, self.cells, &self.specs, ranks))?;
        self.opened = Some(Opened { arrays, file });
        Ok(())
    }

    fn opened(&self) -> Result<&Opened, FileError> {
        let closed = || FileError::new(&self.shared.path, "is closed after an earlier error");
        self.opened.as_ref().ok_or_else(closed)
    }

    fn written(&self, outcome: hdf5::Result<()>) -> Result<(), FileError> {
        self.shared.all("cannot be written", outcome)
    }

    /// First row of this rank and number of rows over all ranks.
    fn share(&self, own: usize) -> (usize, usize) {
        let (own, mut through, mut all) = (own as u64, 0_u64, 0_u64);
        self.shared.communicator.scan_into(&own, &mut through, SystemOperation::sum());
        self.shared.communicator.all_reduce_into(&own, &mut all, SystemOperation::sum());
        ((through - own) as usize, all as usize)
    }

    fn write_points(&self, arrays: &Arrays, at: usize, points: &[f64]) -> hdf5::Result<()> {
        match self.precision {
            Precision::F64 => arrays.write_points(at, points),
            Precision::F32 => arrays.write_points(at, &shortened(points)),
        }
    }

    fn write_field(&self, arrays: &Arrays, field: usize, at: usize, data: &Data) -> hdf5::Result<()> {
        match (data, self.precision) {
            (Data::Integer(values), _) => arrays.write_field(field, at, values),
            (Data::Real(values), Precision::F64) => arrays.write_field(field, at, values),
            (Data::Real(values), Precision::F32) => arrays.write_field(field, at, &shortened(values)),
        }
    }

    /// Writes this rank's cells; `own` is its first point and first cell within the step, and its cells.
    fn write_cells(
        &self,
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
        self.written(arrays.write_connectivity(place.first_cell + first_cell, &connectivity))?;
        let corners = self.cells.corners();
        let ends = (first_cell + 1..=first_cell + cells).map(|k| (k * corners) as i64);
        // Rank 0 writes the leading zero as well, and a second one if there are no cells.
        let zeros = if self.shared.is_first() { place.offsets() - place.cells } else { 0 };
        let offsets: Vec<i64> = std::iter::repeat_n(0, zeros).chain(ends).collect();
        let start = place.first_offset() + if zeros > 0 { 0 } else { first_cell + 1 };
        self.written(arrays.write_offsets(start, &offsets))
    }
}

impl Drop for PolyDataFile {
    fn drop(&mut self) {
        if self.shared.is_first() && self.described < self.steps.len() {
            // Nobody is left to hear of a failure; the data of record are complete without.
            let _ = self.sidecar().write(&self.shared.path);
        }
    }
}

fn is_same_time(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * a.abs().max(b.abs())
}

fn shortened(values: &[f64]) -> Vec<f32> {
    values.iter().map(|&x| x as f32).collect()
}
