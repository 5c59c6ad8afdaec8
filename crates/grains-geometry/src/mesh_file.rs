//! Mesh files: STL (ascii and binary) and OBJ.

use crate::Vec3;
use crate::mesh::{MeshError, TriMesh, WELD_TOLERANCE, WeldReport};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Bytes before the triangles of a binary STL file: a free header and their number.
const STL_HEADER: usize = 84;
/// Bytes of a triangle in a binary STL file: normal, three corners, attribute.
const STL_TRIANGLE: usize = 50;

/// Why a mesh file cannot be read.
#[derive(Debug, Error)]
pub enum MeshFileError {
    /// The file cannot be opened or read.
    #[error("cannot read mesh file {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The name tells no known format.
    #[error("mesh file {path} ends neither in .stl nor in .obj: convert it to one of these")]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The content breaks the format.
    #[error("mesh file {path}: {problem}")]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong where.
        problem: ParseError,
    },
}

/// Why the content of a mesh file is refused.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ParseError {
    /// A line of text that does not follow the format.
    #[error("line {line} reads '{text}', but {expected}: correct the line")]
    Line {
        /// Line, counted from 1.
        line: usize,
        /// What it says.
        text: String,
        /// What was expected.
        expected: &'static str,
    },
    /// A binary file that ends before its last triangle.
    #[error(
        "a binary STL of {triangles} triangles has {expected} bytes, but {found} are present: copy the file again"
    )]
    Truncated {
        /// Number of triangles announced.
        triangles: usize,
        /// Size this implies (bytes).
        expected: usize,
        /// Size found (bytes).
        found: usize,
    },
    /// Vertices and faces that form no mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// A mesh read from a file, and what welding changed.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedMesh {
    /// The welded mesh, in the file's units.
    pub mesh: TriMesh,
    /// Vertices merged and triangles dropped.
    pub weld: WeldReport,
}

/// Reads an STL or OBJ file, told by its name, and welds it with [`WELD_TOLERANCE`].
pub fn read_mesh(path: &Path) -> Result<ImportedMesh, MeshFileError> {
    let bytes = fs::read(path).map_err(|source| MeshFileError::Io { path: path.to_path_buf(), source })?;
    parse_mesh(path, &bytes)
}

/// The same of the bytes of the file.
pub fn parse_mesh(path: &Path, bytes: &[u8]) -> Result<ImportedMesh, MeshFileError> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let parsed = match extension.as_str() {
        "stl" => parse_stl(bytes),
        "obj" => parse_obj(&String::from_utf8_lossy(bytes)),
        _ => return Err(MeshFileError::UnknownFormat { path: path.to_path_buf() }),
    };
    parsed
        .and_then(|mesh| Ok(mesh.welded(WELD_TOLERANCE)?))
        .map(|(mesh, weld)| ImportedMesh { mesh, weld })
        .map_err(|problem| MeshFileError::Content { path: path.to_path_buf(), problem })
}

/// Triangles of an STL file, ascii or binary, three vertices each, not welded.
///
/// The length decides, for binary headers may begin with the `solid` of ascii files.
pub fn parse_stl(bytes: &[u8]) -> Result<TriMesh, ParseError> {
    let announced = bytes.get(80..STL_HEADER).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    let expected = announced.map(|n| STL_HEADER + STL_TRIANGLE * n as usize);
    let is_text = bytes.trim_ascii_start().get(..5).is_some_and(|b| b.eq_ignore_ascii_case(b"solid"));
    match (announced, expected) {
        _ if is_text && expected != Some(bytes.len()) => parse_ascii_stl(&String::from_utf8_lossy(bytes)),
        (Some(_), Some(expected)) if expected <= bytes.len() => {
            Ok(parse_binary_stl(&bytes[STL_HEADER..expected]))
        }
        _ => Err(ParseError::Truncated {
            triangles: announced.unwrap_or(0) as usize,
            expected: expected.unwrap_or(STL_HEADER),
            found: bytes.len(),
        }),
    }
}

/// The triangle records of a binary STL file.
fn parse_binary_stl(records: &[u8]) -> TriMesh {
    let real = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let corners = |record: &[u8]| {
        let corner = |k: usize| Vec3::from_fn(|i, _| real(&record[12 + 12 * k + 4 * i..]));
        [corner(0), corner(1), corner(2)]
    };
    soup(records.chunks_exact(STL_TRIANGLE).flat_map(corners).collect())
}

/// The facets of an ascii STL file.
fn parse_ascii_stl(text: &str) -> Result<TriMesh, ParseError> {
    let mut vertices = Vec::new();
    let mut facet_start = 0;
    for (i, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        let keyword = words.next().unwrap_or_default().to_ascii_lowercase();
        match keyword.as_str() {
            "vertex" => vertices.push(numbers(i, line, words)?),
            "facet" => facet_start = vertices.len(),
            "endfacet" if vertices.len() != facet_start + 3 => {
                return Err(line_error(i, line, "a facet must have exactly three vertices"));
            }
            _ => {}
        }
    }
    if vertices.len() % 3 != 0 {
        let last = text.lines().count().saturating_sub(1);
        return Err(line_error(
            last,
            text.lines().last().unwrap_or_default(),
            "the last facet is not complete",
        ));
    }
    Ok(soup(vertices))
}

/// Every three points form a triangle.
fn soup(vertices: Vec<Vec3>) -> TriMesh {
    let triangles = (0..vertices.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    TriMesh { vertices, triangles }
}

/// Vertices and faces of an OBJ file; polygons are cut into triangles, all else is ignored.
pub fn parse_obj(text: &str) -> Result<TriMesh, ParseError> {
    let mut vertices: Vec<Vec3> = Vec::new();
    let mut polygons: Vec<Vec<usize>> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => vertices.push(numbers(i, line, words)?),
            Some("f") => {
                let corner = |word| obj_index(word, vertices.len());
                let polygon: Option<Vec<usize>> =
                    words.take_while(|w| !w.starts_with('#')).map(corner).collect();
                let expected = "a face lists vertex numbers, from 1 or negative from the last";
                polygons.push(polygon.ok_or_else(|| line_error(i, line, expected))?);
            }
            _ => {}
        }
    }
    Ok(TriMesh::from_polygons(vertices, &polygons)?)
}

/// Vertex index, from 0, of a face corner `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn obj_index(word: &str, count: usize) -> Option<usize> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    match number {
        1.. => usize::try_from(number - 1).ok(),
        0 => None,
        _ => count.checked_sub(usize::try_from(-number).ok()?),
    }
}

/// The next three words as coordinates.
fn numbers<'a>(i: usize, line: &str, words: impl Iterator<Item = &'a str>) -> Result<Vec3, ParseError> {
    let values: Vec<f64> = words.take(3).map_while(|w| w.parse().ok()).collect();
    match values[..] {
        [x, y, z] => Ok(Vec3::new(x, y, z)),
        _ => Err(line_error(i, line, "a vertex needs three numbers")),
    }
}

/// Error at a line counted from 0.
fn line_error(i: usize, line: &str, expected: &'static str) -> ParseError {
    ParseError::Line { line: i + 1, text: line.trim().chars().take(80).collect(), expected }
}

/// Writes a mesh as binary STL: 32-bit coordinates, unit normals from the corners' sense.
pub fn write_stl(out: &mut impl Write, mesh: &TriMesh) -> io::Result<()> {
    let mut header = [0; 80];
    header[..15].copy_from_slice(b"binary STL file");
    out.write_all(&header)?;
    out.write_all(&(mesh.triangles.len() as u32).to_le_bytes())?;
    for t in 0..mesh.triangles.len() {
        let corners = mesh.corners(t);
        for v in std::iter::once(facet_normal(&corners)).chain(corners) {
            for x in v.iter() {
                out.write_all(&(*x as f32).to_le_bytes())?;
            }
        }
        out.write_all(&[0, 0])?;
    }
    Ok(())
}

/// Writes a mesh as ascii STL with all digits of the coordinates.
pub fn write_stl_ascii(out: &mut impl Write, mesh: &TriMesh, name: &str) -> io::Result<()> {
    writeln!(out, "solid {name}")?;
    for t in 0..mesh.triangles.len() {
        let corners = mesh.corners(t);
        let n = facet_normal(&corners);
        writeln!(out, "facet normal {:e} {:e} {:e}\n outer loop", n.x, n.y, n.z)?;
        for v in corners {
            writeln!(out, "  vertex {:e} {:e} {:e}", v.x, v.y, v.z)?;
        }
        writeln!(out, " endloop\nendfacet")?;
    }
    writeln!(out, "endsolid {name}")
}

/// Unit normal of a triangle, zero if it has no area.
fn facet_normal(p: &[Vec3; 3]) -> Vec3 {
    (p[1] - p[0]).cross(&(p[2] - p[0])).try_normalize(0.0).unwrap_or_default()
}
