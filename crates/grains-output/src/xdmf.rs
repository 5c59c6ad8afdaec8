//! The XDMF file beside a VTKHDF file: the same arrays by reference, for readers before VTK 9.3.

use crate::error::FileError;
use crate::polydata::{Kind, PolyDataFile, Precision};
use std::fmt::Write;

/// Writes the description of all steps aside and renames it, so that it is always complete.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn write(file: &PolyDataFile) -> Result<(), FileError> {
    let path = file.path().with_extension("xdmf");
    let aside = file.path().with_extension("xdmf.tmp");
    let text = describe(file);
    std::fs::write(&aside, text)
        .and_then(|()| std::fs::rename(&aside, &path))
        .map_err(|e| FileError::new(&path, format!("cannot be written: {e}")))
}

fn describe(file: &PolyDataFile) -> String {
    let (specs, precision, is_surface) = file.description();
    let name = file.path().file_name().unwrap_or_default().to_string_lossy();
    let bytes = if precision == Precision::F64 { 8 } else { 4 };
    let (_, last) = file.steps.last().copied().unwrap_or((0.0, [0; 4]));
    let (all_points, all_triangles) = (last[0] + last[1], last[2] + last[3]);
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" []>\n<Xdmf Version=\"2.0\">\n<Domain>\n<Grid Name=\"steps\" GridType=\"Collection\" CollectionType=\"Temporal\">\n",
    );
    for (time, [first_point, points, first_triangle, triangles]) in &file.steps {
        let _ = writeln!(text, "<Grid Name=\"step\" GridType=\"Uniform\">\n<Time Value=\"{time:?}\"/>");
        if is_surface {
            let _ = writeln!(text, "<Topology TopologyType=\"Triangle\" NumberOfElements=\"{triangles}\">");
            let slab = [3 * first_triangle, 3 * triangles, 3 * all_triangles];
            text += &slab_item(&name, "Polygons/Connectivity", slab, 1, "Int", 8);
        } else {
            let _ = writeln!(text, "<Topology TopologyType=\"Polyvertex\" NumberOfElements=\"{points}\">");
            text +=
                &slab_item(&name, "Vertices/Connectivity", [*first_point, *points, all_points], 1, "Int", 8);
        }
        text += "</Topology>\n<Geometry GeometryType=\"XYZ\">\n";
        text += &slab_item(&name, "Points", [*first_point, *points, all_points], 3, "Float", bytes);
        text += "</Geometry>\n";
        for spec in specs {
            let kind = match spec.components {
                1 => "Scalar",
                3 => "Vector",
                _ => "Matrix",
            };
            let (center, data, slab) = if is_surface {
                ("Cell", "CellData", [*first_triangle, *triangles, all_triangles])
            } else {
                ("Node", "PointData", [*first_point, *points, all_points])
            };
            let (number, width) = if spec.kind == Kind::Real { ("Float", bytes) } else { ("Int", 8) };
            let _ = writeln!(
                text,
                "<Attribute Name=\"{}\" AttributeType=\"{kind}\" Center=\"{center}\">",
                spec.name
            );
            text += &slab_item(&name, &format!("{data}/{}", spec.name), slab, spec.components, number, width);
            text += "</Attribute>\n";
        }
        text += "</Grid>\n";
    }
    text + "</Grid>\n</Domain>\n</Xdmf>\n"
}

/// Rows `[first, count, of all]` of an array.
fn slab_item(
    file: &str,
    array: &str,
    [first, count, all]: [usize; 3],
    width: usize,
    number: &str,
    bytes: usize,
) -> String {
    let kind = format!("NumberType=\"{number}\" Precision=\"{bytes}\"");
    let (dimensions, whole, slab, rank) = if width == 1 {
        (format!("{count}"), format!("{all}"), format!("{first} 1 {count}"), 1)
    } else {
        (format!("{count} {width}"), format!("{all} {width}"), format!("{first} 0 1 1 {count} {width}"), 2)
    };
    format!(
        "<DataItem ItemType=\"HyperSlab\" Dimensions=\"{dimensions}\" {kind}>\n<DataItem Dimensions=\"3 {rank}\" Format=\"XML\">{slab}</DataItem>\n<DataItem Dimensions=\"{whole}\" {kind} Format=\"HDF\">{file}:/VTKHDF/{array}</DataItem>\n</DataItem>\n"
    )
}
