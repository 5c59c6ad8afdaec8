//! Reference surfaces of particle shapes, for viewers that glyph points by shape and orientation, and the
//! script that makes ParaView do so.

use crate::error::FileError;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A triangle surface in the frame of a body.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceSurface<'a> {
    /// Vertices (m).
    pub vertices: &'a [[f64; 3]],
    /// Vertex numbers, anticlockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
}

/// Writes a triangle surface (m, body frame) as VTK XML PolyData.
///
/// [`write_view_script`] wants it in `shapes/<shape id>.vtp` or `shapes/<shape id>-<name>.vtp`.
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
    write_text(path, &text)
}

/// Writes a triangle surface (m, body frame) as ASCII STL, for CAD programs.
///
/// # Errors
/// A file that cannot be written.
pub fn write_stl(path: &Path, name: &str, surface: ReferenceSurface) -> Result<(), FileError> {
    let mut text = format!("solid {name}\n");
    for triangle in surface.triangles {
        let [a, b, c] = triangle.map(|k| surface.vertices[k as usize]);
        let [x, y, z] = unit_normal(a, b, c);
        let _ = writeln!(text, "facet normal {x:e} {y:e} {z:e}\nouter loop");
        for [x, y, z] in [a, b, c] {
            let _ = writeln!(text, "vertex {x:e} {y:e} {z:e}");
        }
        text += "endloop\nendfacet\n";
    }
    write_text(path, &(text + &format!("endsolid {name}\n")))
}

/// Unit vector along (b − a) × (c − a); zero for a degenerate triangle.
fn unit_normal(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> [f64; 3] {
    let minus = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    let (u, v) = (minus(b, a), minus(c, a));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
    n.map(|x| if length > 0.0 { x / length } else { 0.0 })
}

/// Writes `view.py` into a directory of results: `paraview --script=view.py` shows particles as their
/// shapes, and the walls.
///
/// It expects `particles.vtkhdf` or `particles.xdmf` with the point arrays `shape` (number), `scale` and
/// `orientation_wxyz`, the surfaces of [`write_shape`], and `walls.vtkhdf` or `walls.xdmf` if there are any.
///
/// # Errors
/// A file that cannot be written.
pub fn write_view_script(directory: &Path) -> Result<PathBuf, FileError> {
    let path = directory.join("view.py");
    write_text(&path, include_str!("view.py"))?;
    Ok(path)
}

fn write_text(path: &Path, text: &str) -> Result<(), FileError> {
    std::fs::write(path, text).map_err(|e| FileError::new(path, format!("cannot be written: {e}")))
}
