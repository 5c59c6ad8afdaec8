//! Reference surfaces of particle shapes, for viewers that glyph points by shape and orientation.
//!
//! They are VTK XML PolyData in ASCII: the text between the tags of the points, then of the connectivity.

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

/// Vertices (m, body frame) and triangles of a surface.
pub type ShapeSurface = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// Reads a surface that [`write_shape`] wrote.
///
/// # Errors
/// A file that cannot be read, or that holds something else.
pub fn read_shape(path: &Path) -> Result<ShapeSurface, FileError> {
    let text = std::fs::read_to_string(path).map_err(|e| FileError::new(path, e))?;
    let wrong = || FileError::new(path, "is no surface as this program writes it");
    let array = |k: usize| {
        let text = text.split("<DataArray").nth(k + 1)?;
        Some(text.split_once('>')?.1.split('<').next()?.split_ascii_whitespace())
    };
    let numbers = array(0).ok_or_else(wrong)?.map(|word| word.parse::<f64>().ok());
    let numbers: Vec<f64> = numbers.collect::<Option<_>>().ok_or_else(wrong)?;
    let corners = array(1).ok_or_else(wrong)?.map(|word| word.parse::<u32>().ok());
    let corners: Vec<u32> = corners.collect::<Option<_>>().ok_or_else(wrong)?;
    let (vertices, triangles) = (numbers.as_chunks::<3>().0.to_vec(), corners.as_chunks::<3>().0.to_vec());
    if triangles.iter().flatten().any(|&k| k as usize >= vertices.len()) {
        return Err(wrong());
    }
    Ok((vertices, triangles))
}
