//! The XDMF file beside a VTKHDF file: the same arrays by reference, for readers before VTK 9.3.

use crate::arrays::{Cells, Place};
use crate::error::FileError;
use crate::fields::{FieldSpec, Kind, Precision};
use std::fmt::Write;
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Seek, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

const HEADER: &str = "<?xml version=\"1.0\"?>\n<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" []>\n<Xdmf Version=\"2.0\">\n<Domain>\n<Grid Name=\"steps\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
const FOOTER: &str = "</Grid>\n</Domain>\n</Xdmf>\n";

/// A description that grows by the grids of a step: their text is written once and not kept.
pub(crate) struct Description {
    path: PathBuf,
    file: File,
    /// Where the footer begins.
    end: u64,
}

impl Description {
    /// Writes the description of a number of steps aside and renames it, so that it is always complete.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn create(data: &Path, steps: impl Iterator<Item = String>) -> Result<Self, FileError> {
        let path = data.with_extension("xdmf");
        let aside = data.with_extension("xdmf.tmp");
        let written = (|| {
            let file = OpenOptions::new().write(true).create(true).truncate(true).open(&aside)?;
            let mut text = BufWriter::new(&file);
            text.write_all(HEADER.as_bytes())?;
            let mut end = HEADER.len() as u64;
            for step in steps {
                text.write_all(step.as_bytes())?;
                end += step.len() as u64;
            }
            text.write_all(FOOTER.as_bytes())?;
            text.flush()?;
            drop(text);
            std::fs::rename(&aside, &path)?;
            Ok((file, end))
        })();
        let (file, end) = written.map_err(|e| unwritten(&path, &e))?;
        Ok(Self { path, file, end })
    }

    /// Appends the grids of a step and the footer, in one write.
    ///
    /// # Errors
    /// A full disk; the steps before stay described.
    pub fn append(&mut self, step: &str) -> Result<(), FileError> {
        self.put(&[step, FOOTER].concat()).map_err(|e| {
            let _ = self.put(FOOTER);
            let _ = self.file.set_len(self.end + FOOTER.len() as u64);
            unwritten(&self.path, &e)
        })?;
        self.end += step.len() as u64;
        Ok(())
    }

    fn put(&mut self, text: &str) -> std::io::Result<()> {
        self.file.seek(SeekFrom::Start(self.end))?;
        self.file.write_all(text.as_bytes())
    }
}

fn unwritten(path: &Path, error: &std::io::Error) -> FileError {
    FileError::new(path, format!("cannot be written: {error}; free space, then --restart latest"))
}

/// The name of the data of a description as XML wants it.
pub(crate) fn name_of(data: &Path) -> String {
    escaped(&data.file_name().unwrap_or_default().to_string_lossy())
}

/// Number type of an array as XDMF names it.
#[derive(Clone, Copy)]
pub(crate) struct Number {
    kind: Kind,
    bytes: usize,
}

impl Number {
    /// Number type of a field.
    pub fn of(kind: Kind, precision: Precision) -> Self {
        Self { kind, bytes: if kind == Kind::Real { precision.bytes() } else { 8 } }
    }

    /// XML attributes.
    pub fn text(self) -> String {
        let name = if self.kind == Kind::Real { "Float" } else { "Int" };
        format!("NumberType=\"{name}\" Precision=\"{}\"", self.bytes)
    }
}

/// A part of an array by reference: first places, counts and the size of the whole, along each dimension.
pub(crate) struct HyperSlab<'a> {
    /// Path in the file.
    pub array: &'a str,
    pub number: Number,
    pub first: &'a [usize],
    pub count: &'a [usize],
    pub whole: &'a [usize],
    /// Dimensions of the part as readers are to see them.
    pub shape: &'a [usize],
}

impl HyperSlab<'_> {
    /// Appends the item; `file` is the name of the data.
    pub fn write(&self, text: &mut String, file: &str) {
        let Self { array, first, .. } = self;
        let (kind, dimensions) = (self.number.text(), first.len());
        let [shape, first, count, whole] = [self.shape, first, self.count, self.whole].map(joined);
        let strides = joined(&vec![1; dimensions]);
        let _ = writeln!(
            text,
            "<DataItem ItemType=\"HyperSlab\" Dimensions=\"{shape}\" {kind}>\n<DataItem Dimensions=\"3 {dimensions}\" Format=\"XML\">{first} {strides} {count}</DataItem>\n<DataItem Dimensions=\"{whole}\" {kind} Format=\"HDF\">{file}:{array}</DataItem>\n</DataItem>"
        );
    }
}

/// Numbers with spaces between.
pub(crate) fn joined(numbers: &[usize]) -> String {
    numbers.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
}

/// A name as XML wants it.
pub(crate) fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// What the XDMF file of points or triangles says.
pub(crate) struct Sidecar<'a> {
    pub cells: Cells,
    pub specs: &'a [FieldSpec],
    pub precision: Precision,
}

/// Rows of an array that belong to a step.
struct Slab<'a> {
    array: &'a str,
    first: usize,
    rows: usize,
    /// Rows of the whole array.
    all: usize,
    width: usize,
    number: Number,
}

impl Sidecar<'_> {
    /// The grids of a step; the sizes of the arrays are those at its end, and grow no more in this text.
    pub fn text(&self, file: &str, place: &Place) -> String {
        let end = Place::next(Some(place), 0.0, 0, 0);
        // A collection may be empty: VTK's reader divides by zero or worse at a grid without points.
        let mut text =
            String::from("<Grid Name=\"step\" GridType=\"Collection\" CollectionType=\"Spatial\">\n");
        let _ = writeln!(text, "<Time Value=\"{:?}\"/>", place.time);
        if place.cells > 0 {
            text += "<Grid Name=\"all\" GridType=\"Uniform\">\n";
            self.write_grid(&mut text, file, place, &end);
            text += "</Grid>\n";
        }
        text + "</Grid>\n"
    }

    fn write_grid(&self, text: &mut String, file: &str, place: &Place, end: &Place) {
        let [real, integer] = [Kind::Real, Kind::Integer].map(|kind| Number::of(kind, self.precision));
        let (kind, corners) = match self.cells {
            Cells::Vertices => ("Polyvertex", 1),
            Cells::Triangles => ("Triangle", 3),
        };
        let _ = writeln!(text, "<Topology TopologyType=\"{kind}\" NumberOfElements=\"{}\">", place.cells);
        let (first, rows, all) = (place.first_cell, place.cells, end.first_cell);
        let connectivity = Slab {
            array: &format!("{}/Connectivity", self.cells.name()),
            first: corners * first,
            rows: corners * rows,
            all: corners * all,
            width: 1,
            number: integer,
        };
        connectivity.write(text, file);
        text.push_str("</Topology>\n<Geometry GeometryType=\"XYZ\">\n");
        let of_points = (place.first_point, place.points, end.first_point);
        let (first, rows, all) = of_points;
        Slab { array: "Points", first, rows, all, width: 3, number: real }.write(text, file);
        text.push_str("</Geometry>\n");
        let (center, (first, rows, all)) = match self.cells {
            Cells::Vertices => ("Node", of_points),
            Cells::Triangles => ("Cell", (place.first_cell, place.cells, end.first_cell)),
        };
        for spec in self.specs {
            let shape = match spec.components {
                1 => "Scalar",
                3 => "Vector",
                _ => "Matrix",
            };
            let name = escaped(spec.name);
            let _ =
                writeln!(text, "<Attribute Name=\"{name}\" AttributeType=\"{shape}\" Center=\"{center}\">");
            let number = if spec.kind == Kind::Real { real } else { integer };
            let array = &format!("{}/{name}", self.cells.data());
            Slab { array, first, rows, all, width: spec.components, number }.write(text, file);
            text.push_str("</Attribute>\n");
        }
    }
}

impl Slab<'_> {
    fn write(&self, text: &mut String, file: &str) {
        let &Self { array, first, rows, all, width, number } = self;
        let array = &format!("/VTKHDF/{array}");
        let (first, count, whole) = (&[first, 0][..], &[rows, width][..], &[all, width][..]);
        let slab = match width {
            1 => HyperSlab {
                array,
                number,
                first: &first[..1],
                count: &count[..1],
                whole: &whole[..1],
                shape: &[rows],
            },
            3 => HyperSlab { array, number, first, count, whole, shape: &[rows, 3] },
            // A matrix per row: VTK's reader makes values per row of the last two dimensions.
            _ => HyperSlab { array, number, first, count, whole, shape: &[rows, 1, width] },
        };
        slab.write(text, file);
    }
}
