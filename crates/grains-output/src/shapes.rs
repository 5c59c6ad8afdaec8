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

/// The one-dimensional datasets at the root of an HDF5 file as a CSV text, a column each.
///
/// # Errors
/// A file that cannot be read, or datasets of different lengths.
pub fn read_columns_as_csv(path: &Path) -> Result<String, FileError> {
    let columns = (|| -> hdf5::Result<Vec<(String, Vec<f64>)>> {
        let file = hdf5::File::open(path)?;
        file.member_names()?
            .into_iter()
            .map(|name| Ok((name.clone(), file.dataset(&name)?.read_raw::<f64>()?)))
            .collect()
    })();
    let columns = columns.map_err(|e| FileError::new(path, format!("cannot be read as columns: {e}")))?;
    let rows = columns.first().map_or(0, |c| c.1.len());
    if let Some((name, _)) = columns.iter().find(|c| c.1.len() != rows) {
        return Err(FileError::new(path, format!("`{name}` has another length than `{}`", columns[0].0)));
    }
    let names: Vec<&str> = columns.iter().map(|c| c.0.as_str()).collect();
    let mut text = names.join(",") + "\n";
    for row in 0..rows {
        let values: Vec<String> = columns.iter().map(|c| format!("{:?}", c.1[row])).collect();
        text += &(values.join(",") + "\n");
    }
    Ok(text)
}
