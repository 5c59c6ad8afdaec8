//! Cylinders and boxes cut into like pieces: composites that must move as the whole does.

use crate::glued::{Component, glue};
use crate::{Shape, ShapeError, Vec3};

impl Shape {
    /// Cylinder about z cut into `slices` thinner cylinders; lengths in m.
    ///
    /// Errors: no slice, lengths or crust out of range.
    pub fn sliced_cylinder(
        radius: f64,
        height: f64,
        slices: u32,
        crust_fraction: f64,
    ) -> Result<Self, ShapeError> {
        let thickness = height / f64::from(slices.max(1));
        let slice = Shape::cylinder(radius, thickness, crust_fraction)?.named("slice");
        let place = |k: u32| (f64::from(k) + 0.5) * thickness - height / 2.0;
        let components: Vec<_> =
            (0..slices).map(|k| Component::new(slice.clone(), Vec3::new(0.0, 0.0, place(k)))).collect();
        Ok(glue(&components, crust_fraction, None)?.named("sliced_cylinder"))
    }

    /// Box of the given edges (m) cut into `pieces`³ like boxes.
    ///
    /// Errors: no piece, lengths or crust out of range.
    pub fn sliced_cuboid(edges: Vec3, pieces: u32, crust_fraction: f64) -> Result<Self, ShapeError> {
        let small = edges / f64::from(pieces.max(1));
        let piece = Shape::cuboid(small, crust_fraction)?.named("piece");
        let place = |i: [u32; 3]| Vec3::from_fn(|a, _| (f64::from(i[a]) + 0.5) * small[a] - edges[a] / 2.0);
        let numbers = (0..pieces).flat_map(|k| (0..pieces).map(move |j| (j, k)));
        let numbers = numbers.flat_map(|(j, k)| (0..pieces).map(move |i| [i, j, k]));
        let components: Vec<_> = numbers.map(|i| Component::new(piece.clone(), place(i))).collect();
        Ok(glue(&components, crust_fraction, None)?.named("sliced_cuboid"))
    }
}
