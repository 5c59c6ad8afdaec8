//! Reference surfaces of particle shapes, for viewers that glyph points by shape and orientation.

use crate::error::FileError;
use std::fmt::Write;
use std::path::Path;

/// Writes a triangle surface (m, body frame) as VTK XML PolyData.
///
/// # Errors
/// A file that cannot be written.
pub fn write_shape(path: &Path, vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<(), FileError> {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\">\n<PolyData>\n",
    );
    let _ =
        writeln!(text, "<Piece NumberOfPoints=\"{}\" NumberOfPolys=\"{}\">", vertices.len(), triangles.len());
    text += "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n";
    vertices.iter().for_each(|[x, y, z]| text += &format!("{x:?} {y:?} {z:?}\n"));
    text +=
        "</DataArray></Points>\n<Polys><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">\n";
    triangles.iter().for_each(|[a, b, c]| text += &format!("{a} {b} {c}\n"));
    text += "</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">\n";
    (1..=triangles.len()).for_each(|k| text += &format!("{}\n", 3 * k));
    text += "</DataArray></Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n";
    std::fs::write(path, text).map_err(|e| FileError::new(path, format!("cannot be written: {e}")))
}
