//! The arrays of a temporal VTKHDF file of cells.

use super::GridGeometry;
use crate::arrays::first_rows;
use crate::checkpoint::checksum;
use crate::collective::{Participants, write_rows};
use crate::error::Shared;
use crate::fields::{FieldSpec, Kind, Precision};
use crate::growing::{STEPS_PER_CHUNK, create_root, grow, require_fields, resize, unit};
use hdf5::{Dataset, File, Group, H5Type};

/// Group of the fields.
pub(super) const DATA: &str = "CellData";
/// Group of the coordinates of the nodes, beside `/VTKHDF`.
const GRID: &str = "grid";
const AXES: [&str; 3] = ["x", "y", "z"];
/// Names of the coordinates of nodes of stretched grids.
const COORDINATES: [&str; 3] = ["XCoordinates", "YCoordinates", "ZCoordinates"];
const TOO_FEW: &str = "it has fewer entries than steps";
/// Cells of a chunk: three components of 8 bytes stay below the megabyte that readers cache.
const CELLS_PER_CHUNK: usize = 1 << 15;

/// The open arrays of a file.
pub(super) struct Arrays {
    fields: Vec<(Dataset, usize)>,
    times: Dataset,
    /// First row of the step in every field, which is the number of the step.
    first_rows: Vec<Dataset>,
    /// First coordinate of the step in those of the nodes, which never move.
    first_nodes: Vec<Dataset>,
    steps: Group,
}

impl Arrays {
    /// Creates all arrays of a new file, without steps.
    pub fn create(
        file: &File,
        grid: &GridGeometry,
        specs: &[FieldSpec],
        (precision, compress): (Precision, bool),
    ) -> hdf5::Result<Self> {
        if let Some(spec) = specs.iter().find(|spec| ![1, 3].contains(&spec.components)) {
            return Err(format!("`{}` has {} components, not 1 or 3", spec.name, spec.components).into());
        }
        let root = create_mesh(file, grid)?;
        let cells = grid.cells();
        let chunk = chunk(cells);
        for spec in specs {
            let vector = if spec.components > 1 { &[spec.components][..] } else { &[] };
            let row = [&[cells[2], cells[1], cells[0]], vector].concat();
            let chunk = [&[1, chunk[2], chunk[1], chunk[0]], vector].concat();
            let name = format!("{DATA}/{}", spec.name);
            let dataset = match (spec.kind, precision) {
                (Kind::Integer, _) => grow::<i64>(&root, &name, &row, &chunk, compress),
                (Kind::Real, Precision::F64) => grow::<f64>(&root, &name, &row, &chunk, compress),
                (Kind::Real, Precision::F32) => grow::<f32>(&root, &name, &row, &chunk, compress),
            }?;
            unit(&dataset, spec.unit)?;
            let name = format!("Steps/{DATA}Offsets/{}", spec.name);
            grow::<i64>(&root, &name, &[], &[STEPS_PER_CHUNK], false)?;
        }
        unit(&grow::<f64>(&root, "Steps/Values", &[], &[STEPS_PER_CHUNK], false)?, "s")?;
        Self::open(file, specs)
    }

    /// Opens the arrays of a file that must hold just these fields.
    pub fn open(file: &File, specs: &[FieldSpec]) -> hdf5::Result<Self> {
        let root = file.group("VTKHDF")?;
        require_fields(&root.group(DATA)?, specs.iter().map(|spec| spec.name))?;
        let field = |spec: &FieldSpec| {
            let dataset = root.dataset(&format!("{DATA}/{}", spec.name))?;
            let width = dataset.shape().get(4).copied().unwrap_or(1);
            if width != spec.components {
                return Err(format!("`{}` has {width} values per cell there", spec.name).into());
            }
            Ok((dataset, width))
        };
        let fields = specs.iter().map(field).collect::<hdf5::Result<Vec<_>>>()?;
        let steps = root.group("Steps")?;
        let first_rows = specs.iter().map(|spec| steps.dataset(&format!("{DATA}Offsets/{}", spec.name)));
        let offsets = COORDINATES.map(|name| format!("{name}Offsets"));
        let first_nodes = offsets.iter().filter(|name| steps.link_exists(name));
        Ok(Self {
            fields,
            times: steps.dataset("Values")?,
            first_rows: first_rows.collect::<hdf5::Result<_>>()?,
            first_nodes: first_nodes.map(|name| steps.dataset(name)).collect::<hdf5::Result<_>>()?,
            steps,
        })
    }

    /// Precision of the fields of real numbers, if there are any.
    pub fn precision(&self, specs: &[FieldSpec]) -> hdf5::Result<Option<Precision>> {
        let real = specs.iter().zip(&self.fields).find(|(spec, _)| spec.kind == Kind::Real);
        let Some((_, (field, _))) = real else { return Ok(None) };
        Ok(Some(if field.dtype()?.size() == 4 { Precision::F32 } else { Precision::F64 }))
    }

    /// Times (s) of the steps.
    pub fn times(&self) -> hdf5::Result<Vec<f64>> {
        let times = read_times(&self.steps)?;
        if self.fields.iter().any(|(field, _)| field.shape()[0] < times.len()) {
            return Err(TOO_FEW.into());
        }
        Ok(times)
    }

    /// Cuts every array to a number of steps; all ranks take part.
    pub fn cut(&self, steps: usize) -> hdf5::Result<()> {
        // First, so that a run killed in between leaves a readable file.
        self.publish(steps)?;
        self.resize(steps)
    }

    /// Makes every array hold a number of steps; all ranks take part.
    pub fn resize(&self, steps: usize) -> hdf5::Result<()> {
        let fields = self.fields.iter().map(|(field, _)| field);
        let mut all = fields.chain([&self.times]).chain(&self.first_rows).chain(&self.first_nodes);
        all.try_for_each(|dataset| resize(dataset, steps))
    }

    /// Writes this rank's block of a field; all ranks take part.
    pub fn write_field<T: H5Type>(
        &self,
        shared: &Shared,
        (field, step): (usize, usize),
        grid: &GridGeometry,
        values: &[T],
    ) -> hdf5::Result<()> {
        let (dataset, width) = &self.fields[field];
        shared.write_block(dataset, &grid.block().part(&[step], *width), values)
    }

    /// Writes what there is once per step; rank 0 alone does.
    pub fn write_step(&self, step: usize, time: f64) -> hdf5::Result<()> {
        let me = Participants::ThisRank;
        write_rows(&self.times, step, 1, &[time], me)?;
        self.first_rows.iter().try_for_each(|dataset| write_rows(dataset, step, 1, &[step as i64], me))?;
        self.first_nodes.iter().try_for_each(|dataset| write_rows(dataset, step, 1, &[0_i64], me))
    }

    /// Lets readers see the steps; all ranks take part.
    pub fn publish(&self, steps: usize) -> hdf5::Result<()> {
        self.steps.attr("NSteps")?.write_scalar(&(steps as i64))
    }
}

/// Describes the grid: equal cells as VTKHDF 2.0 ImageData, others as VTKHDF 2.7 RectilinearGrid.
fn create_mesh(file: &File, grid: &GridGeometry) -> hdf5::Result<Group> {
    let coordinates = file.create_group(GRID)?;
    for (nodes, axis) in grid.nodes.iter().zip(AXES) {
        unit(&coordinates.new_dataset::<f64>().shape(nodes.len()).create(axis)?, "m")?;
    }
    let cells = grid.cells().map(|n| n as i64);
    if let Some(spacing) = grid.spacing() {
        let root = create_root::<9>(file, "ImageData", [2, 0], DATA)?;
        let origin = grid.nodes.each_ref().map(|nodes| nodes[0]);
        let extent = cells.map(|n| [0, n]).concat();
        root.new_attr::<i64>().shape(6).create("WholeExtent")?.write_raw(&extent)?;
        let unit_axes: [f64; 9] = std::array::from_fn(|k| if k % 4 == 0 { 1.0 } else { 0.0 });
        for (name, values) in [("Origin", &origin[..]), ("Spacing", &spacing), ("Direction", &unit_axes)] {
            root.new_attr::<f64>().shape(values.len()).create(name)?.write_raw(values)?;
        }
        return Ok(root);
    }
    let root = create_root::<15>(file, "RectilinearGrid", [2, 7], DATA)?;
    root.new_attr::<i64>().shape(3).create("Dimensions")?.write_raw(&cells.map(|n| n + 1))?;
    for (name, axis) in COORDINATES.into_iter().zip(AXES) {
        root.link_hard(&format!("/{GRID}/{axis}"), name)?;
        grow::<i64>(&root, &format!("Steps/{name}Offsets"), &[], &[STEPS_PER_CHUNK], false)?;
    }
    Ok(root)
}

/// Writes the coordinates of the nodes of a new file; all ranks take part, the first has the values.
pub(super) fn write_nodes(file: &File, grid: &GridGeometry, is_first: bool) -> hdf5::Result<()> {
    grid.nodes.iter().zip(AXES).try_for_each(|(nodes, axis)| {
        let dataset = file.dataset(&format!("{GRID}/{axis}"))?;
        let own = if is_first { &nodes[..] } else { &[] };
        write_rows(&dataset, 0, 1, own, Participants::ThisRank)
    })
}

/// Checksum of the time (s) of a step and of the nodes of its grid.
pub(super) fn digest_of_step(time: f64, nodes: &[Vec<f64>; 3]) -> u64 {
    let nodes = nodes.iter().flat_map(|axis| [axis.len() as f64].into_iter().chain(axis.iter().copied()));
    checksum(0, std::iter::once(time).chain(nodes).map(f64::to_bits))
}

/// Times (s) of the steps of a file, from their group.
pub(super) fn read_times(steps: &Group) -> hdf5::Result<Vec<f64>> {
    let count = steps.attr("NSteps")?.read_scalar::<i64>()? as usize;
    first_rows(&steps.dataset("Values")?, count)
}

/// The coordinates of the nodes of a file.
pub(super) fn read_nodes(file: &File) -> hdf5::Result<[Vec<f64>; 3]> {
    let [x, y, z] = AXES.map(|axis| {
        let dataset = file.dataset(&format!("{GRID}/{axis}"))?;
        // A damaged number must not be taken for a size.
        if dataset.size().saturating_mul(8) as u64 > file.size() {
            return Err(format!("`{GRID}/{axis}` has more values than the file").into());
        }
        dataset.read_raw::<f64>()
    });
    Ok([x?, y?, z?])
}

/// Cells of a chunk along x, y, z: whole rows, then layers, in even parts so that none is mostly empty.
fn chunk(cells: [usize; 3]) -> [usize; 3] {
    let mut left = CELLS_PER_CHUNK;
    cells.map(|n| {
        let parts = n.div_ceil(left.max(1)).max(1);
        let own = n.div_ceil(parts).max(1);
        left /= own;
        own
    })
}

#[cfg(test)]
mod tests {
    use super::{CELLS_PER_CHUNK, chunk};

    #[test]
    fn chunks_are_small_and_waste_little() {
        assert_eq!(chunk([15, 10, 53]), [15, 10, 53]);
        assert_eq!(chunk([128, 128, 128]), [128, 128, 2]);
        assert_eq!(chunk([100_000, 3, 1]), [25_000, 1, 1]);
        for cells in [[101, 101, 101], [33, 1, 40_000], [1, 1, 1], [7, 4000, 900]] {
            let [x, y, z] = chunk(cells);
            assert!(x * y * z <= CELLS_PER_CHUNK, "{cells:?}");
            let stored: usize = cells.iter().zip([x, y, z]).map(|(&n, c)| n.div_ceil(c) * c).product();
            assert!(stored as f64 <= 1.1 * cells.iter().product::<usize>() as f64, "{cells:?}: {stored}");
        }
    }
}
