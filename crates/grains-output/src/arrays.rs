//! The arrays of a temporal VTKHDF PolyData file and what each holds per step.

use crate::checkpoint::checksum;
use crate::collective::{Participants, read_rows, write_rows};
use crate::error::Shared;
use crate::fields::{FieldSpec, Kind, Precision};
use crate::growing::{STEPS_PER_CHUNK, create_root, grow, require_fields, resize, unit};
use crate::writers::Number;
use hdf5::{Dataset, File, Group, H5Type};

const TOPOLOGIES: [&str; 4] = ["Vertices", "Lines", "Polygons", "Strips"];
/// Rows of a chunk of arrays that grow by particles.
const ROWS_PER_CHUNK: usize = 8192;

/// What the cells of a file are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cells {
    /// A vertex on each point; fields lie on points.
    Vertices,
    /// Triangles; fields lie on triangles.
    Triangles,
}

impl Cells {
    pub fn corners(self) -> usize {
        match self {
            Cells::Vertices => 1,
            Cells::Triangles => 3,
        }
    }

    /// Place among VTK's four topologies.
    fn topology(self) -> usize {
        match self {
            Cells::Vertices => 0,
            Cells::Triangles => 2,
        }
    }

    /// The group of the topology in use.
    pub fn name(self) -> &'static str {
        TOPOLOGIES[self.topology()]
    }

    /// The group of the fields.
    pub fn data(self) -> &'static str {
        match self {
            Cells::Vertices => "PointData",
            Cells::Triangles => "CellData",
        }
    }
}

/// Where a step lies in the arrays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Place {
    /// Number of the step, which is that of its only part.
    pub step: usize,
    /// Time (s).
    pub time: f64,
    pub first_point: usize,
    pub points: usize,
    pub first_cell: usize,
    pub cells: usize,
    /// First cell as the topology counts: a step without cells counts as one there.
    ///
    /// VTK from 9.5 on finds a step's `Offsets` by adding up the cells of the parts before until it
    /// reaches this number, and so would overlook empty parts just before the step. VTK 9.3 and 9.4 count
    /// all parts. With this number above the sum, both count all parts.
    first_counted: usize,
}

impl Place {
    /// Place of the step after this one.
    pub fn next(previous: Option<&Self>, time: f64, points: usize, cells: usize) -> Self {
        let Some(last) = previous else { return Self { time, points, cells, ..Self::default() } };
        Self {
            step: last.step + 1,
            time,
            first_point: last.first_point + last.points,
            points,
            first_cell: last.first_cell + last.cells,
            cells,
            first_counted: last.first_counted + last.cells.max(1),
        }
    }

    /// Checksum of when and where the step is.
    pub fn digest(&self) -> u64 {
        let sizes = [self.first_point, self.points, self.first_cell, self.cells].map(|n| n as u64);
        checksum(self.step, std::iter::once(self.time.to_bits()).chain(sizes))
    }

    /// First row in `Offsets`, which has one more row than cells per step.
    pub fn first_offset(&self) -> usize {
        self.first_counted + self.step
    }

    /// Rows of the step in `Offsets`.
    pub fn offsets(&self) -> usize {
        self.cells.max(1) + 1
    }
}

/// What an array with one row per step holds.
#[derive(Clone, Copy)]
enum Entry {
    Time,
    Step,
    One,
    Zero,
    Points,
    Cells,
    ConnectivityIds,
    FirstPoint,
    FirstRow,
    /// Of the four topologies.
    FirstCells,
    FirstConnectivityIds,
}

/// The open arrays of a file.
pub(crate) struct Arrays {
    cells: Cells,
    points: Dataset,
    fields: Vec<(Dataset, usize)>,
    connectivity: Dataset,
    offsets: Dataset,
    per_step: Vec<(Dataset, Entry)>,
    steps: Group,
}

/// Names of the arrays with one row per step.
fn per_step(cells: Cells, specs: &[FieldSpec]) -> Vec<(String, Entry)> {
    let mut list: Vec<(String, Entry)> = [
        ("NumberOfPoints", Entry::Points),
        ("Steps/Values", Entry::Time),
        ("Steps/PartOffsets", Entry::Step),
        ("Steps/NumberOfParts", Entry::One),
        ("Steps/PointOffsets", Entry::FirstPoint),
        ("Steps/CellOffsets", Entry::FirstCells),
        ("Steps/ConnectivityIdOffsets", Entry::FirstConnectivityIds),
    ]
    .map(|(name, entry)| (name.to_string(), entry))
    .into();
    for topology in TOPOLOGIES {
        let is_used = topology == cells.name();
        let used = |entry| if is_used { entry } else { Entry::Zero };
        list.push((format!("{topology}/NumberOfCells"), used(Entry::Cells)));
        list.push((format!("{topology}/NumberOfConnectivityIds"), used(Entry::ConnectivityIds)));
        if !is_used {
            list.push((format!("{topology}/Offsets"), Entry::Zero));
        }
    }
    let offsets =
        |spec: &FieldSpec| (format!("Steps/{}Offsets/{}", cells.data(), spec.name), Entry::FirstRow);
    list.extend(specs.iter().map(offsets));
    list
}

/// The places of the steps of a file, whatever its fields.
pub(crate) fn places(file: &File, cells: Cells) -> hdf5::Result<Vec<Place>> {
    let root = file.group("VTKHDF")?;
    let steps = root.group("Steps")?.attr("NSteps")?.read_scalar::<i64>()? as usize;
    let rows = root.dataset("Points")?.shape()[0];
    let ids = root.dataset(&format!("{}/Connectivity", cells.name()))?.shape()[0];
    let times: Vec<f64> = first_rows(&root.dataset("Steps/Values")?, steps)?;
    let points: Vec<i64> = first_rows(&root.dataset("NumberOfPoints")?, steps)?;
    let counts: Vec<i64> = first_rows(&root.dataset(&format!("{}/NumberOfCells", cells.name()))?, steps)?;
    let mut places: Vec<Place> = Vec::with_capacity(steps);
    for k in 0..steps {
        let (points, counts) = (points[k] as usize, counts[k] as usize);
        // Before they are added: damaged numbers must not overflow.
        if points > rows || counts > ids {
            return Err("its steps have more rows than it".into());
        }
        places.push(Place::next(places.last(), times[k], points, counts));
    }
    Ok(places)
}

/// The first rows of an array with one row per step.
pub(crate) fn first_rows<T: H5Type + Default + Clone>(
    dataset: &Dataset,
    rows: usize,
) -> hdf5::Result<Vec<T>> {
    if dataset.ndim() != 1 || dataset.shape()[0] < rows {
        return Err("it has fewer entries than steps".into());
    }
    let mut values = vec![T::default(); rows];
    read_rows(dataset, 0, 1, &mut values)?;
    Ok(values)
}

impl Arrays {
    /// Creates all arrays of a new file, without rows.
    pub fn create(
        file: &File,
        cells: Cells,
        specs: &[FieldSpec],
        (precision, compress): (Precision, bool),
    ) -> hdf5::Result<Self> {
        let root = create_root::<8>(file, "PolyData", [2, 0], cells.data())?;
        TOPOLOGIES.into_iter().try_for_each(|group| root.create_group(group).map(drop))?;
        let real = |name: &str, width| match precision {
            Precision::F64 => grow_rows::<f64>(&root, name, width, ROWS_PER_CHUNK, compress),
            Precision::F32 => grow_rows::<f32>(&root, name, width, ROWS_PER_CHUNK, compress),
        };
        unit(&real("Points", 3)?, "m")?;
        for spec in specs {
            let name = format!("{}/{}", cells.data(), spec.name);
            let dataset = match spec.kind {
                Kind::Real => real(&name, spec.components)?,
                Kind::Integer => grow_rows::<i64>(&root, &name, spec.components, ROWS_PER_CHUNK, compress)?,
            };
            unit(&dataset, spec.unit)?;
        }
        for topology in TOPOLOGIES {
            let is_used = topology == cells.name();
            let chunk = if is_used { ROWS_PER_CHUNK } else { STEPS_PER_CHUNK };
            grow_rows::<i64>(&root, &format!("{topology}/Connectivity"), 1, chunk, compress && is_used)?;
        }
        let offsets = format!("{}/Offsets", cells.name());
        grow_rows::<i64>(&root, &offsets, 1, ROWS_PER_CHUNK, compress)?;
        for (name, entry) in per_step(cells, specs) {
            match entry {
                Entry::Time => unit(&grow_rows::<f64>(&root, &name, 1, STEPS_PER_CHUNK, false)?, "s")?,
                Entry::FirstCells | Entry::FirstConnectivityIds => {
                    grow_rows::<i64>(&root, &name, 4, STEPS_PER_CHUNK, false)?;
                }
                _ => {
                    grow_rows::<i64>(&root, &name, 1, STEPS_PER_CHUNK, false)?;
                }
            }
        }
        Self::open(file, cells, specs)
    }

    /// Opens the arrays of a file that must hold just these fields.
    pub fn open(file: &File, cells: Cells, specs: &[FieldSpec]) -> hdf5::Result<Self> {
        let root = file.group("VTKHDF")?;
        require_fields(&root.group(cells.data())?, specs.iter().map(|spec| spec.name))?;
        let field = |spec: &FieldSpec| {
            let dataset = root.dataset(&format!("{}/{}", cells.data(), spec.name))?;
            let width = dataset.shape().get(1).copied().unwrap_or(1);
            if width != spec.components {
                return Err(format!("`{}` has {width} values per row there", spec.name).into());
            }
            Ok((dataset, width))
        };
        let opened = |(name, entry): (String, Entry)| Ok((root.dataset(&name)?, entry));
        Ok(Self {
            cells,
            points: root.dataset("Points")?,
            fields: specs.iter().map(field).collect::<hdf5::Result<_>>()?,
            connectivity: root.dataset(&format!("{}/Connectivity", cells.name()))?,
            offsets: root.dataset(&format!("{}/Offsets", cells.name()))?,
            per_step: per_step(cells, specs).into_iter().map(opened).collect::<hdf5::Result<_>>()?,
            steps: root.group("Steps")?,
        })
    }

    /// Precision of the file.
    pub fn precision(&self) -> hdf5::Result<Precision> {
        Ok(if self.points.dtype()?.size() == 4 { Precision::F32 } else { Precision::F64 })
    }

    /// The places of the steps of a file.
    pub fn places(&self, file: &File) -> hdf5::Result<Vec<Place>> {
        places(file, self.cells)
    }

    /// Cuts every array to the steps up to `last`; all ranks take part.
    pub fn cut(&self, last: Option<&Place>) -> hdf5::Result<()> {
        let end = Place::next(last, 0.0, 0, 0);
        // First, so that a run killed in between leaves a readable file.
        self.steps.attr("NSteps")?.write_scalar(&(end.step as i64))?;
        self.resize(&end)?;
        for (dataset, _) in &self.per_step {
            resize(dataset, end.step)?;
        }
        Ok(())
    }

    /// Makes the arrays that grow by points or cells end where `end` begins.
    fn resize(&self, end: &Place) -> hdf5::Result<()> {
        resize(&self.points, end.first_point)?;
        let rows = match self.cells {
            Cells::Vertices => end.first_point,
            Cells::Triangles => end.first_cell,
        };
        for (dataset, _) in &self.fields {
            resize(dataset, rows)?;
        }
        resize(&self.connectivity, end.first_cell * self.cells.corners())?;
        resize(&self.offsets, end.first_offset())
    }

    /// Makes room for the step at `place`; all ranks take part.
    pub fn extend(&self, place: &Place) -> hdf5::Result<()> {
        self.resize(&Place::next(Some(place), 0.0, 0, 0))?;
        self.per_step.iter().try_for_each(|(dataset, _)| resize(dataset, place.step + 1))
    }

    /// Writes positions from row `at`; all ranks take part.
    pub fn write_points<T: Number>(&self, shared: &Shared, at: usize, points: &[T]) -> hdf5::Result<()> {
        shared.write_rows(&self.points, (at, 3), points)
    }

    /// Writes a field from row `at`; all ranks take part.
    pub fn write_field<T: Number>(
        &self,
        shared: &Shared,
        (field, at): (usize, usize),
        values: &[T],
    ) -> hdf5::Result<()> {
        let (dataset, width) = &self.fields[field];
        shared.write_rows(dataset, (at, *width), values)
    }

    /// Writes the corners of cells from cell `at`; all ranks take part.
    pub fn write_connectivity(&self, shared: &Shared, at: usize, points: &[i64]) -> hdf5::Result<()> {
        shared.write_rows(&self.connectivity, (at * self.cells.corners(), 1), points)
    }

    /// Writes rows of `Offsets`; all ranks take part.
    pub fn write_offsets(&self, shared: &Shared, at: usize, offsets: &[i64]) -> hdf5::Result<()> {
        shared.write_rows(&self.offsets, (at, 1), offsets)
    }

    /// Writes the step's row of every array that has one row per step; rank 0 alone does.
    pub fn write_step(&self, place: &Place) -> hdf5::Result<()> {
        let corners = self.cells.corners();
        let of_topologies = |value: usize| {
            let mut row = vec![0_i64; 4];
            row[self.cells.topology()] = value as i64;
            row
        };
        let first_row = match self.cells {
            Cells::Vertices => place.first_point,
            Cells::Triangles => place.first_cell,
        };
        let me = Participants::ThisRank;
        for (dataset, entry) in &self.per_step {
            let number = match entry {
                Entry::Time => {
                    write_rows(dataset, place.step, 1, &[place.time], me)?;
                    continue;
                }
                Entry::FirstCells => {
                    write_rows(dataset, place.step, 4, &of_topologies(place.first_counted), me)?;
                    continue;
                }
                Entry::FirstConnectivityIds => {
                    write_rows(dataset, place.step, 4, &of_topologies(place.first_cell * corners), me)?;
                    continue;
                }
                Entry::Step => place.step,
                Entry::One => 1,
                Entry::Zero => 0,
                Entry::Points => place.points,
                Entry::Cells => place.cells,
                Entry::ConnectivityIds => place.cells * corners,
                Entry::FirstPoint => place.first_point,
                Entry::FirstRow => first_row,
            };
            write_rows(dataset, place.step, 1, &[number as i64], me)?;
        }
        Ok(())
    }

    /// Lets readers see the step; all ranks take part.
    pub fn publish(&self, steps: usize) -> hdf5::Result<()> {
        self.steps.attr("NSteps")?.write_scalar(&(steps as i64))
    }
}

/// A growing dataset of `width` values per row.
fn grow_rows<T: H5Type>(
    group: &Group,
    name: &str,
    width: usize,
    chunk: usize,
    compress: bool,
) -> hdf5::Result<Dataset> {
    if width == 1 {
        grow::<T>(group, name, &[], &[chunk], compress)
    } else {
        grow::<T>(group, name, &[width], &[chunk, width], compress)
    }
}
