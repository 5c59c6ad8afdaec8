//! Temporal VTKHDF 2.0 PolyData: points as vertices, or triangles, one part per step.

use crate::collective::write_rows;
use crate::error::{FileError, agree};
use crate::xdmf;
use hdf5::types::{FixedAscii, VarLenUnicode};
use hdf5::{Dataset, File, Group};
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{AsRaw, Communicator, CommunicatorCollectives};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// What a file says of its origin: names and texts.
pub type Metadata = Vec<(String, String)>;

/// Floating-point format of the arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 64 bits.
    F64,
    /// 32 bits.
    F32,
}

/// Type of a field's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Floating point.
    Real,
    /// Whole numbers, 64 bits.
    Integer,
}

/// An array that goes with every step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldSpec {
    /// Name.
    pub name: &'static str,
    /// SI unit, `-` for pure numbers.
    pub unit: &'static str,
    /// Values per point or triangle.
    pub components: usize,
    /// Type.
    pub kind: Kind,
}

/// Values of a field on this rank, `[points or triangles][components]`.
#[derive(Clone, Copy, Debug)]
pub enum Data<'a> {
    /// Floating point.
    Real(&'a [f64]),
    /// Whole numbers.
    Integer(&'a [i64]),
}

/// A field of a step.
pub type Field<'a> = (FieldSpec, Data<'a>);

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

/// A step that was written: its time (s), first point, points, first triangle, triangles.
pub(crate) type Written = (f64, [usize; 4]);

/// A growing file.
pub struct PolyDataFile {
    path: PathBuf,
    communicator: SimpleCommunicator,
    file: File,
    specs: Vec<FieldSpec>,
    precision: Precision,
    is_surface: bool,
    pub(crate) steps: Vec<Written>,
}

const TOPOLOGIES: [&str; 4] = ["Vertices", "Lines", "Polygons", "Strips"];
const CHUNK: usize = 4096;

impl PolyDataFile {
    /// Creates a file for clouds of points (`is_surface` false) or triangles.
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
        let created = (|| -> hdf5::Result<File> {
            let file =
                File::with_options().with_fapl(|p| p.mpio(communicator.as_raw(), None)).create(path)?;
            layout(&file, specs, is_surface, precision, compress)?;
            write_metadata(&file, metadata)?;
            file.flush()?;
            Ok(file)
        })();
        let file = agree(communicator, created.map_err(|e| FileError::new(path, e)))?;
        let communicator = communicator.duplicate();
        let specs = specs.to_vec();
        Ok(Self {
            path: path.to_path_buf(),
            communicator,
            file,
            specs,
            precision,
            is_surface,
            steps: Vec::new(),
        })
    }

    /// Continues a file, forgetting every step at or after `time` (s).
    ///
    /// # Errors
    /// A file that cannot be opened, or that holds other arrays.
    pub fn resume(
        path: &Path,
        communicator: &SimpleCommunicator,
        specs: &[FieldSpec],
        is_surface: bool,
        precision: Precision,
        time: f64,
    ) -> Result<Self, FileError> {
        let opened = (|| -> hdf5::Result<(File, Vec<Written>)> {
            let file =
                File::with_options().with_fapl(|p| p.mpio(communicator.as_raw(), None)).open_rw(path)?;
            let steps = truncate(&file, specs, is_surface, time)?;
            Ok((file, steps))
        })();
        let opened = opened.map_err(|e| {
            FileError::new(
                path,
                format!("cannot be continued ({e}): move it aside, or run without --restart"),
            )
        });
        let (file, steps) = agree(communicator, opened)?;
        let communicator = communicator.duplicate();
        let specs = specs.to_vec();
        Ok(Self { path: path.to_path_buf(), communicator, file, specs, precision, is_surface, steps })
    }

    /// Appends a step and brings the XDMF file beside up to date.
    ///
    /// A step without any cell is left out: VTK 9.5 and 9.7 read the step after one wrongly.
    ///
    /// # Errors
    /// A full disk, or a file that cannot be written.
    pub fn append(&mut self, step: &Step) -> Result<(), FileError> {
        let own = if self.is_surface { step.triangles.len() } else { step.points.len() } / 3;
        if place(&self.communicator, own).1 == 0 {
            return Ok(());
        }
        let written = self.write(step);
        let path = self.path.clone();
        let outcome = written.map_err(|e| FileError::new(&path, format!("cannot be written: {e}")));
        agree(&self.communicator, outcome)?;
        let sidecar = if self.communicator.rank() == 0 { xdmf::write(self) } else { Ok(()) };
        agree(&self.communicator, sidecar)
    }

    fn write(&mut self, step: &Step) -> hdf5::Result<()> {
        let own = [step.points.len() / 3, step.triangles.len() / 3];
        let [(first_point, points), (first_triangle, triangles)] = own.map(|n| place(&self.communicator, n));
        let previous = self.steps.last().map_or([0; 4], |s| s.1);
        let (point_start, triangle_start) = (previous[0] + previous[1], previous[2] + previous[3]);
        let root = self.file.group("VTKHDF")?;
        let rank = self.communicator.rank();
        self.append_real(
            &root.dataset("Points")?,
            point_start + first_point,
            3,
            step.points,
            point_start + points,
        )?;
        let (data, cell_start, cells) = if self.is_surface {
            ("CellData", triangle_start, triangles)
        } else {
            ("PointData", point_start, points)
        };
        let first = if self.is_surface { first_triangle } else { first_point };
        for (spec, values) in self.specs.iter().zip(step.fields) {
            let dataset = root.dataset(&format!("{data}/{}", spec.name))?;
            let (at, end) = (cell_start + first, cell_start + cells);
            match values {
                Data::Real(values) => self.append_real(&dataset, at, spec.components, values, end)?,
                Data::Integer(values) => append_rows(&dataset, at, spec.components, values, end)?,
            }
        }
        let connectivity: Vec<i64> = if self.is_surface {
            step.triangles.iter().map(|p| p + first_point as i64).collect()
        } else {
            (first_point as i64..(first_point + own[0]) as i64).collect()
        };
        self.append_cells(&root, &connectivity, first, cells, cell_start)?;
        let starts = [point_start, cell_start];
        append_step(
            &root,
            self.steps.len(),
            step.time,
            starts,
            (points, self.is_surface),
            &self.specs,
            rank == 0,
        )?;
        self.steps.push((step.time, [point_start, points, triangle_start, triangles]));
        self.file.flush()
    }

    fn append_real(
        &self,
        dataset: &Dataset,
        at: usize,
        width: usize,
        values: &[f64],
        end: usize,
    ) -> hdf5::Result<()> {
        match self.precision {
            Precision::F64 => append_rows(dataset, at, width, values, end),
            Precision::F32 => {
                let short: Vec<f32> = values.iter().map(|&x| x as f32).collect();
                append_rows(dataset, at, width, &short, end)
            }
        }
    }

    /// Appends the cells of a step: each topology has one more offset than cells per step.
    fn append_cells(
        &self,
        root: &Group,
        connectivity: &[i64],
        first: usize,
        cells: usize,
        cell_start: usize,
    ) -> hdf5::Result<()> {
        let used = if self.is_surface { "Polygons" } else { "Vertices" };
        let corners = if self.is_surface { 3 } else { 1 };
        let step = self.steps.len();
        let is_first = self.communicator.rank() == 0;
        for topology in TOPOLOGIES {
            let group = root.group(topology)?;
            let count = if topology == used { cells } else { 0 };
            let one = |value: usize| if is_first { vec![value as i64] } else { Vec::new() };
            append_rows(&group.dataset("NumberOfCells")?, step, 1, &one(count), step + 1)?;
            append_rows(
                &group.dataset("NumberOfConnectivityIds")?,
                step,
                1,
                &one(count * corners),
                step + 1,
            )?;
            let offsets = group.dataset("Offsets")?;
            if topology == used {
                let (at, end) = ((cell_start + first) * corners, (cell_start + cells) * corners);
                append_rows(&group.dataset("Connectivity")?, at, 1, connectivity, end)?;
                let own = connectivity.len() / corners;
                // Rank 0 writes the leading zero as well.
                let mine: Vec<i64> = if is_first { vec![0] } else { Vec::new() };
                let mine: Vec<i64> =
                    mine.into_iter().chain((1..=own).map(|k| ((first + k) * corners) as i64)).collect();
                let start = cell_start + step + first + usize::from(!is_first);
                append_rows(&offsets, start, 1, &mine, cell_start + step + cells + 1)?;
            } else {
                append_rows(&offsets, step, 1, &one(0), step + 1)?;
            }
        }
        Ok(())
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    pub(crate) fn description(&self) -> (&[FieldSpec], Precision, bool) {
        (&self.specs, self.precision, self.is_surface)
    }
}

/// First row of this rank and number of rows over all ranks.
fn place(communicator: &SimpleCommunicator, own: usize) -> (usize, usize) {
    let (own, mut before, mut all) = (own as u64, 0_u64, 0_u64);
    communicator.scan_into(&own, &mut before, SystemOperation::sum());
    communicator.all_reduce_into(&own, &mut all, SystemOperation::sum());
    ((before - own) as usize, all as usize)
}

/// Extends a dataset to `end` rows and writes this rank's rows from `at`.
fn append_rows<T: hdf5::H5Type>(
    dataset: &Dataset,
    at: usize,
    width: usize,
    rows: &[T],
    end: usize,
) -> hdf5::Result<()> {
    resize(dataset, end)?;
    write_rows(dataset, at, width, rows)
}

fn resize(dataset: &Dataset, rows: usize) -> hdf5::Result<()> {
    let mut shape = dataset.shape();
    shape[0] = rows;
    dataset.resize(shape)
}

/// Appends the entries of a step to the group `Steps`.
fn append_step(
    root: &Group,
    step: usize,
    time: f64,
    [point_start, cell_start]: [usize; 2],
    (_, is_surface): (usize, bool),
    specs: &[FieldSpec],
    is_first: bool,
) -> hdf5::Result<()> {
    let steps = root.group("Steps")?;
    let one = |value: usize| if is_first { vec![value as i64] } else { Vec::new() };
    append_rows(&root.dataset("NumberOfPoints")?, step, 1, &one(point_count(root, point_start)?), step + 1)?;
    let times = if is_first { vec![time] } else { Vec::new() };
    append_rows(&steps.dataset("Values")?, step, 1, &times, step + 1)?;
    append_rows(&steps.dataset("PartOffsets")?, step, 1, &one(step), step + 1)?;
    append_rows(&steps.dataset("NumberOfParts")?, step, 1, &one(1), step + 1)?;
    append_rows(&steps.dataset("PointOffsets")?, step, 1, &one(point_start), step + 1)?;
    let (used, corners) = if is_surface { (2, 3) } else { (0, 1) };
    let four = |value: usize| {
        let mut row = vec![0; if is_first { 4 } else { 0 }];
        if let Some(entry) = row.get_mut(used) {
            *entry = value as i64;
        }
        row
    };
    append_rows(&steps.dataset("CellOffsets")?, step, 4, &four(cell_start), step + 1)?;
    append_rows(&steps.dataset("ConnectivityIdOffsets")?, step, 4, &four(cell_start * corners), step + 1)?;
    let group = if is_surface { "CellDataOffsets" } else { "PointDataOffsets" };
    for spec in specs {
        append_rows(&steps.dataset(&format!("{group}/{}", spec.name))?, step, 1, &one(cell_start), step + 1)?;
    }
    steps.attr("NSteps")?.write_scalar(&(step as i64 + 1))
}

/// Points of the step that begins at `start`: the points array has just been extended to hold it.
fn point_count(root: &Group, start: usize) -> hdf5::Result<usize> {
    Ok(root.dataset("Points")?.shape()[0] - start)
}

/// Creates the groups and empty datasets.
fn layout(
    file: &File,
    specs: &[FieldSpec],
    is_surface: bool,
    precision: Precision,
    compress: bool,
) -> hdf5::Result<()> {
    let root = file.create_group("VTKHDF")?;
    let kind = FixedAscii::<8>::from_ascii("PolyData").map_err(|e| e.to_string())?;
    root.new_attr::<FixedAscii<8>>().create("Type")?.write_scalar(&kind)?;
    root.new_attr::<i64>().shape(2).create("Version")?.write_raw(&[2_i64, 0])?;
    grow::<i64>(&root, "NumberOfPoints", 1, false)?;
    let real = |group: &Group, name: &str, width: usize| match precision {
        Precision::F64 => grow::<f64>(group, name, width, compress),
        Precision::F32 => grow::<f32>(group, name, width, compress),
    };
    unit(&real(&root, "Points", 3)?, "m")?;
    for topology in TOPOLOGIES {
        let group = root.create_group(topology)?;
        for name in ["NumberOfCells", "NumberOfConnectivityIds", "Connectivity", "Offsets"] {
            grow::<i64>(&group, name, 1, false)?;
        }
    }
    let steps = root.create_group("Steps")?;
    steps.new_attr::<i64>().create("NSteps")?.write_scalar(&0_i64)?;
    unit(&grow::<f64>(&steps, "Values", 1, false)?, "s")?;
    for name in ["PartOffsets", "NumberOfParts", "PointOffsets"] {
        grow::<i64>(&steps, name, 1, false)?;
    }
    for name in ["CellOffsets", "ConnectivityIdOffsets"] {
        grow::<i64>(&steps, name, 4, false)?;
    }
    let data = root.create_group(if is_surface { "CellData" } else { "PointData" })?;
    let offsets = steps.create_group(if is_surface { "CellDataOffsets" } else { "PointDataOffsets" })?;
    for spec in specs {
        let dataset = match spec.kind {
            Kind::Real => real(&data, spec.name, spec.components)?,
            Kind::Integer => grow::<i64>(&data, spec.name, spec.components, compress)?,
        };
        unit(&dataset, spec.unit)?;
        grow::<i64>(&offsets, spec.name, 1, false)?;
    }
    Ok(())
}

/// A dataset without rows that can grow.
fn grow<T: hdf5::H5Type>(group: &Group, name: &str, width: usize, compress: bool) -> hdf5::Result<Dataset> {
    let builder = group.new_dataset::<T>();
    let builder = if compress { builder.deflate(4) } else { builder };
    let chunk = if name == "Values" || width == 4 { 256 } else { CHUNK };
    if width == 1 {
        builder.chunk(chunk).shape(0..).create(name)
    } else {
        builder.chunk((chunk, width)).shape((0.., width)).create(name)
    }
}

fn unit(dataset: &Dataset, unit: &str) -> hdf5::Result<()> {
    text(unit).and_then(|value| dataset.new_attr::<VarLenUnicode>().create("unit")?.write_scalar(&value))
}

fn text(value: &str) -> hdf5::Result<VarLenUnicode> {
    VarLenUnicode::from_str(&value.replace('\0', " ")).map_err(|e| e.to_string().into())
}

/// Writes the texts that say where a file comes from into the group `grains-mpi`.
pub(crate) fn write_metadata(file: &File, metadata: &Metadata) -> hdf5::Result<()> {
    let group = file.create_group("grains-mpi")?;
    for (name, value) in metadata {
        if value.len() < 4096 {
            group.new_attr::<VarLenUnicode>().create(name.as_str())?.write_scalar(&text(value)?)?;
        } else {
            // Attributes are small; a long text is an array of bytes.
            let bytes = value.as_bytes();
            let dataset = group.new_dataset::<u8>().shape(bytes.len()).create(name.as_str())?;
            write_rows(&dataset, 0, 1, bytes)?;
        }
    }
    Ok(())
}

/// Cuts off every step at or after `time`; returns those that remain.
fn truncate(
    file: &File,
    specs: &[FieldSpec],
    is_surface: bool,
    time: f64,
) -> hdf5::Result<Vec<Written>> {
    let root = file.group("VTKHDF")?;
    let steps = root.group("Steps")?;
    let data = if is_surface { "CellData" } else { "PointData" };
    let present = root.group(data)?.member_names()?;
    if specs.len() != present.len() || specs.iter().any(|s| !present.iter().any(|p| p == s.name)) {
        return Err(format!("it holds the arrays {}", present.join(", ")).into());
    }
    let values = steps.dataset("Values")?.read_raw::<f64>()?;
    let points = root.dataset("NumberOfPoints")?.read_raw::<i64>()?;
    let cells = root.dataset("Polygons/NumberOfCells")?.read_raw::<i64>()?;
    let keep = values.iter().take_while(|&&t| t < time * (1.0 - 1e-12)).count();
    let mut kept: Vec<Written> = Vec::new();
    for k in 0..keep {
        let [p, n, c, m] = kept.last().map_or([0; 4], |s| s.1);
        kept.push((values[k], [p + n, points[k] as usize, c + m, cells[k] as usize]));
    }
    let [p, n, c, m] = kept.last().map_or([0; 4], |s| s.1);
    let (all_points, all_triangles) = (p + n, c + m);
    steps.attr("NSteps")?.write_scalar(&(keep as i64))?;
    resize(&root.dataset("NumberOfPoints")?, keep)?;
    resize(&root.dataset("Points")?, all_points)?;
    let offsets = if is_surface { "CellDataOffsets" } else { "PointDataOffsets" };
    for spec in specs {
        let rows = if is_surface { all_triangles } else { all_points };
        resize(&root.dataset(&format!("{data}/{}", spec.name))?, rows)?;
        resize(&steps.dataset(&format!("{offsets}/{}", spec.name))?, keep)?;
    }
    for topology in TOPOLOGIES {
        let group = root.group(topology)?;
        let count = match (topology, is_surface) {
            ("Vertices", false) => all_points,
            ("Polygons", true) => all_triangles,
            _ => 0,
        };
        let corners = if is_surface { 3 } else { 1 };
        resize(&group.dataset("NumberOfCells")?, keep)?;
        resize(&group.dataset("NumberOfConnectivityIds")?, keep)?;
        resize(&group.dataset("Connectivity")?, count * corners)?;
        resize(&group.dataset("Offsets")?, count + keep)?;
    }
    for name in
        ["Values", "PartOffsets", "NumberOfParts", "PointOffsets", "CellOffsets", "ConnectivityIdOffsets"]
    {
        resize(&steps.dataset(name)?, keep)?;
    }
    file.flush()?;
    Ok(kept)
}
