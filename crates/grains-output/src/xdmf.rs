//! The XDMF file beside a VTKHDF file: the same arrays by reference, for readers before VTK 9.3.

use crate::arrays::{Cells, Place};
use crate::error::FileError;
use crate::fields::{FieldSpec, Kind, Precision};
use std::fmt::Write;
use std::path::Path;

/// What the XDMF file says.
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
    number: &'static str,
    bytes: usize,
}

impl Sidecar<'_> {
    /// Writes the description of all steps aside and renames it, so that it is always complete.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, data: &Path) -> Result<(), FileError> {
        let path = data.with_extension("xdmf");
        let aside = data.with_extension("xdmf.tmp");
        let name = data.file_name().unwrap_or_default().to_string_lossy();
        std::fs::write(&aside, self.text(&escaped(&name)))
            .and_then(|()| std::fs::rename(&aside, &path))
            .map_err(|e| FileError::new(&path, format!("cannot be written: {e}")))
    }

    fn text(&self, file: &str) -> String {
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" []>\n<Xdmf Version=\"2.0\">\n<Domain>\n<Grid Name=\"steps\" GridType=\"Collection\" CollectionType=\"Temporal\">\n",
        );
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
        text + "</Grid>\n</Domain>\n</Xdmf>\n"
    }

    fn write_grid(&self, text: &mut String, file: &str, place: &Place, end: &Place) {
        let bytes = if self.precision == Precision::F64 { 8 } else { 4 };
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
            number: "Int",
            bytes: 8,
        };
        connectivity.write(text, file);
        text.push_str("</Topology>\n<Geometry GeometryType=\"XYZ\">\n");
        let of_points = (place.first_point, place.points, end.first_point);
        let (first, rows, all) = of_points;
        Slab { array: "Points", first, rows, all, width: 3, number: "Float", bytes }.write(text, file);
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
            let (number, bytes) = if spec.kind == Kind::Real { ("Float", bytes) } else { ("Int", 8) };
            let array = &format!("{}/{name}", self.cells.data());
            Slab { array, first, rows, all, width: spec.components, number, bytes }.write(text, file);
            text.push_str("</Attribute>\n");
        }
    }
}

impl Slab<'_> {
    fn write(&self, text: &mut String, file: &str) {
        let Self { array, first, rows, all, width, number, bytes } = self;
        let kind = format!("NumberType=\"{number}\" Precision=\"{bytes}\"");
        let (part, whole, slab, rank) = match width {
            1 => (format!("{rows}"), format!("{all}"), format!("{first} 1 {rows}"), 1),
            3 => (format!("{rows} 3"), format!("{all} 3"), format!("{first} 0 1 1 {rows} 3"), 2),
            // A matrix per row: VTK's reader makes values per row of the last two dimensions.
            width => (
                format!("{rows} 1 {width}"),
                format!("{all} {width}"),
                format!("{first} 0 1 1 {rows} {width}"),
                2,
            ),
        };
        let _ = writeln!(
            text,
            "<DataItem ItemType=\"HyperSlab\" Dimensions=\"{part}\" {kind}>\n<DataItem Dimensions=\"3 {rank}\" Format=\"XML\">{slab}</DataItem>\n<DataItem Dimensions=\"{whole}\" {kind} Format=\"HDF\">{file}:/VTKHDF/{array}</DataItem>\n</DataItem>"
        );
    }
}

/// A name as XML wants it.
fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
