//! The XDMF file beside a VTKHDF file: the same arrays by reference, for readers before VTK 9.3.

use crate::arrays::{Cells, Place};
use crate::error::FileError;
use crate::fields::{FieldSpec, Kind, Precision};
use std::fmt::Write;
use std::path::Path;

/// Writes a description aside and renames it, so that it is always complete.
///
/// `grids` gets the name of the data as XML wants it and returns the grids of all steps.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn write(data: &Path, grids: impl FnOnce(&str) -> String) -> Result<(), FileError> {
    let path = data.with_extension("xdmf");
    let aside = data.with_extension("xdmf.tmp");
    let name = data.file_name().unwrap_or_default().to_string_lossy();
    let text = format!(
        "<?xml version=\"1.0\"?>\n<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" []>\n<Xdmf Version=\"2.0\">\n<Domain>\n<Grid Name=\"steps\" GridType=\"Collection\" CollectionType=\"Temporal\">\n{}</Grid>\n</Domain>\n</Xdmf>\n",
        grids(&escaped(&name))
    );
    std::fs::write(&aside, text)
        .and_then(|()| std::fs::rename(&aside, &path))
        .map_err(|e| FileError::new(&path, format!("cannot be written: {e}")))
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
    pub steps: &'a [Place],
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
    /// The grids of all steps.
    pub fn text(&self, file: &str) -> String {
        let mut text = String::new();
        let end = Place::next(self.steps.last(), 0.0, 0, 0);
        for place in self.steps {
            // A collection may be empty: VTK's reader divides by zero or worse at a grid without points.
            text += "<Grid Name=\"step\" GridType=\"Collection\" CollectionType=\"Spatial\">\n";
            let _ = writeln!(text, "<Time Value=\"{:?}\"/>", place.time);
            if place.cells > 0 {
                text += "<Grid Name=\"all\" GridType=\"Uniform\">\n";
                self.write_grid(&mut text, file, place, &end);
                text += "</Grid>\n";
            }
            text += "</Grid>\n";
        }
        text
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
