//! Crosses of square beams (Rakotonirina 2016, fig. 3.12).

use crate::error::check_length;
use crate::glued::{Component, glue};
use crate::{MassProperties, MassSource, Shape, ShapeError, Vec3};

impl Shape {
    /// Cross of two or three square beams along x, y and, for three, z, that share their middle; lengths in m.
    ///
    /// The mass properties are those of the beams less the cube w³ they share, once for each beam but
    /// the first. Errors: other than 2 or 3 beams, beams not longer than wide, crust out of (0, 0.5].
    pub fn cross(beams: u32, width: f64, length: f64, crust_fraction: f64) -> Result<Self, ShapeError> {
        check_length("width of a beam", width)?;
        check_length("length of a beam", length)?;
        if !(2..=3).contains(&beams) {
            let (value, remedy) = (f64::from(beams), "take 2 for a flat cross, 3 for one in space");
            return Err(ShapeError::OutOfRange {
                quantity: "number of beams",
                value,
                allowed: "2 or 3",
                remedy,
            });
        }
        // Beams as short as wide would be a cube, and edges that nearly coincide no cross.
        if length < 1.001 * width {
            let remedy = "make the beams longer or narrower, or take a box";
            return Err(ShapeError::OutOfRange {
                quantity: "length over width of a beam",
                value: length / width,
                allowed: "above 1.001",
                remedy,
            });
        }
        let edges = |axis: usize| Vec3::from_fn(|a, _| if a == axis { length } else { width });
        let mut components = Vec::new();
        let (mut volume, mut inertia) = (0.0, Vec3::zeros());
        for axis in 0..beams as usize {
            let beam = Shape::cuboid(edges(axis), crust_fraction)?.named("beam");
            volume += beam.volume;
            inertia += beam.inertia;
            components.push(Component::new(beam, Vec3::zeros()));
        }
        let shared = Shape::cuboid(Vec3::repeat(width), crust_fraction)?;
        let again = f64::from(beams - 1);
        let mass = MassProperties::in_body_frame(
            volume - again * shared.volume,
            &(inertia - shared.inertia * again),
        );
        Ok(glue(&components, crust_fraction, Some((mass, MassSource::ClosedForm)))?.named("cross"))
    }
}
