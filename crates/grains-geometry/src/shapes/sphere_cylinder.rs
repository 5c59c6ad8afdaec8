//! Cylinders imitated by glued spheres (Kodam et al. 2010; Rakotonirina 2016, fig. 3.10).

use crate::error::check_length;
use crate::glued::{Component, glue};
use crate::{Shape, ShapeError, Vec3};
use std::f64::consts::TAU;

/// How spheres fill a cylinder: like layers from bottom to top, each of concentric rings.
#[derive(Clone, Debug, PartialEq)]
pub struct SphereArrangement {
    /// Number of layers; a single one lies in the middle.
    pub layers: u32,
    /// Spheres in each ring, from the axis outwards.
    ///
    /// The outermost ring touches the wall of the cylinder and the others are spaced evenly; a first
    /// ring of one sphere is on the axis.
    pub rings: Vec<u32>,
    /// Radius of the spheres (m).
    pub sphere_radius: f64,
}

impl SphereArrangement {
    /// Layers of spheres that touch each other and both ends of a cylinder of a given height (m).
    pub fn touching(layers: u32, rings: Vec<u32>, height: f64) -> Self {
        Self { layers, rings, sphere_radius: height / (2.0 * f64::from(layers.max(1))) }
    }

    /// Distances of the rings from the axis in a cylinder of a given radius (m).
    fn ring_radii(&self, radius: f64) -> Vec<f64> {
        let is_on_axis = self.rings.first() == Some(&1) && self.rings.len() > 1;
        let skipped = usize::from(!is_on_axis);
        let steps = (self.rings.len() - 1 + skipped).max(1);
        let outermost = radius - self.sphere_radius;
        (0..self.rings.len()).map(|k| outermost * (k + skipped) as f64 / steps as f64).collect()
    }

    fn check(&self, radius: f64, height: f64) -> Result<(), ShapeError> {
        check_length("sphere radius", self.sphere_radius)?;
        let count = u64::from(self.layers) * self.rings.iter().map(|&n| u64::from(n)).sum::<u64>();
        if count == 0 || self.rings.contains(&0) {
            return Err(ShapeError::NoComponents);
        }
        let room = radius.min(height / 2.0);
        if self.sphere_radius > room * (1.0 + 1e-12) {
            return Err(ShapeError::OutOfRange {
                quantity: "sphere radius over the largest that fits the cylinder",
                value: self.sphere_radius / room,
                allowed: "at most 1",
                remedy: "take smaller spheres or more layers",
            });
        }
        Ok(())
    }
}

impl Shape {
    /// Glued spheres that imitate a cylinder about z; lengths in m.
    ///
    /// Errors: no spheres, spheres that do not fit the cylinder or do not touch each other.
    pub fn spheres_of_cylinder(
        radius: f64,
        height: f64,
        arrangement: &SphereArrangement,
    ) -> Result<Self, ShapeError> {
        check_length("cylinder radius", radius)?;
        check_length("cylinder height", height)?;
        arrangement.check(radius, height)?;
        let sphere = Shape::sphere(arrangement.sphere_radius)?;
        let rise = height - 2.0 * arrangement.sphere_radius;
        let layers = arrangement.layers;
        let mut components = Vec::new();
        for layer in 0..layers {
            let z = if layers > 1 { rise * (f64::from(layer) / f64::from(layers - 1) - 0.5) } else { 0.0 };
            for (&count, ring) in arrangement.rings.iter().zip(arrangement.ring_radii(radius)) {
                components.extend((0..count).map(|k| {
                    let (sine, cosine) = libm::sincos(TAU * f64::from(k) / f64::from(count));
                    Component::new(sphere.clone(), Vec3::new(ring * cosine, ring * sine, z))
                }));
            }
        }
        Ok(glue(&components, SPHERES_CRUST, None)?.named("spheres_of_cylinder"))
    }
}

/// Any allowed crust fraction: spheres are all crust.
const SPHERES_CRUST: f64 = 0.5;
