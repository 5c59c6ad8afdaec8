//! The surfaces of the particle shapes.

use crate::block::{Array, Block};
use grains_output::{FileError, ShapeSurface, read_shape};
use serde::Serialize;
use std::path::Path;

/// A shape as the page reads it.
#[derive(Debug, Serialize)]
pub struct Shape {
    /// Its name in the case.
    name: String,
    /// Radius (m) of a sphere; the page draws a sphere exactly.
    radius: Option<f64>,
    /// Vertices (m) and triangles of any other.
    vertices: Option<Array>,
    triangles: Option<Array>,
}

impl Shape {
    /// Whether it is a sphere, which has no orientation.
    pub fn is_round(&self) -> bool {
        self.radius.is_some()
    }
}

/// Vertices from which on a round surface is taken for that of a sphere.
const ROUND: usize = 40;

/// Reads the surfaces in the directory `shapes`; one without a file is drawn as a sphere of the radius of its particles.
///
/// # Errors
/// A file that cannot be read.
pub fn read(directory: &Path, names: &[String], block: &mut Block) -> Result<Vec<Shape>, FileError> {
    let mut shapes = Vec::new();
    for k in 0.. {
        let path = directory.join(format!("{k}.vtp"));
        if !path.exists() {
            break;
        }
        let name = names.get(k).cloned().unwrap_or_else(|| format!("shape {k}"));
        shapes.push(shape(name, &read_shape(&path)?, block));
    }
    Ok(shapes)
}

fn shape(name: String, (vertices, triangles): &ShapeSurface, block: &mut Block) -> Shape {
    let radii = vertices.iter().map(|v| v.iter().map(|x| x * x).sum::<f64>().sqrt());
    let (min, max) = radii.fold((f64::INFINITY, 0.0), |(a, b), r| (f64::min(a, r), f64::max(b, r)));
    if vertices.len() >= ROUND && max - min < 1e-6 * max {
        return Shape { name, radius: Some(max), vertices: None, triangles: None };
    }
    Shape {
        name,
        radius: None,
        vertices: Some(block.reals(vertices.as_flattened().iter().copied())),
        triangles: Some(block.integers(triangles.as_flattened().iter().copied())),
    }
}
