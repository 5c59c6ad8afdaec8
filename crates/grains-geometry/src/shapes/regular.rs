//! The five regular solids.

use crate::error::check_length;
use crate::{Shape, ShapeError, Vec3};

/// A regular (Platonic) solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegularSolid {
    /// Four triangles.
    Tetrahedron,
    /// Six squares.
    Cube,
    /// Eight triangles.
    Octahedron,
    /// Twelve pentagons.
    Dodecahedron,
    /// Twenty triangles.
    Icosahedron,
}

impl RegularSolid {
    /// Name in lower case.
    pub fn name(self) -> &'static str {
        match self {
            RegularSolid::Tetrahedron => "tetrahedron",
            RegularSolid::Cube => "cube",
            RegularSolid::Octahedron => "octahedron",
            RegularSolid::Dodecahedron => "dodecahedron",
            RegularSolid::Icosahedron => "icosahedron",
        }
    }

    /// Corners on the unit sphere, symmetric about the axes (-).
    pub fn vertices(self) -> Vec<Vec3> {
        let golden = (1.0 + 5f64.sqrt()) / 2.0;
        let corners: Vec<Vec3> = match self {
            RegularSolid::Tetrahedron => signed(&Vec3::repeat(1.0)).filter(|v| v.product() > 0.0).collect(),
            RegularSolid::Cube => signed(&Vec3::repeat(1.0)).collect(),
            RegularSolid::Octahedron => cyclic(Vec3::x()).collect(),
            RegularSolid::Dodecahedron => {
                signed(&Vec3::repeat(1.0)).chain(cyclic(Vec3::new(0.0, 1.0 / golden, golden))).collect()
            }
            RegularSolid::Icosahedron => cyclic(Vec3::new(0.0, 1.0, golden)).collect(),
        };
        corners.iter().map(|v| v.normalize()).collect()
    }
}

/// All choices of sign of the non-zero components.
fn signed(v: &Vec3) -> impl Iterator<Item = Vec3> + use<> {
    let v = *v;
    (0..8usize).filter_map(move |bits| {
        let negative = |k: usize| bits >> k & 1 == 1;
        let duplicate = (0..3).any(|k| v[k] == 0.0 && negative(k));
        (!duplicate).then(|| Vec3::from_fn(|k, _| if negative(k) { -v[k] } else { v[k] }))
    })
}

/// All choices of sign of the three cyclic permutations.
fn cyclic(v: Vec3) -> impl Iterator<Item = Vec3> {
    [v, Vec3::new(v.z, v.x, v.y), Vec3::new(v.y, v.z, v.x)].into_iter().flat_map(|p| signed(&p))
}

impl Shape {
    /// Regular solid whose corners lie on a sphere of the given radius (m).
    pub fn regular(solid: RegularSolid, circumradius: f64, crust_fraction: f64) -> Result<Self, ShapeError> {
        check_length("circumradius", circumradius)?;
        if solid == RegularSolid::Cube {
            // The box core costs less than its eight vertices.
            let edge = circumradius * (2.0 / 3f64.sqrt());
            return Ok(Shape::cuboid(Vec3::repeat(edge), crust_fraction)?.named(solid.name()));
        }
        let vertices: Vec<Vec3> = solid.vertices().iter().map(|v| v * circumradius).collect();
        Ok(Shape::hull(&vertices, crust_fraction)?.named(solid.name()))
    }
}
