//! What cells hold of bodies.

use crate::{Resolved, Subgrid};
use grains_geometry::{Shape, Vec3};

/// Points along each axis of a cell by which the part of it inside a body is counted.
const SAMPLES: usize = 4;

impl Resolved {
    /// Calls `add` with the place of every own cell that a body reaches into, the volume (m³) it has there and its velocity
    /// (m/s) at the centre of the cell.
    ///
    /// Cells on the surface are counted by four points along each axis, eq. 7.30.
    pub fn for_each_solid(&self, shapes: &[Shape], mut add: impl FnMut(usize, f64, Vec3)) {
        let Subgrid { layout, spacing, active, .. } = &self.subgrid;
        let (cell, reach) = (self.subgrid.cell_volume(), 0.5 * spacing.norm());
        let offsets = |a: usize| {
            let n = if active[a] { SAMPLES } else { 1 };
            (0..n).map(move |m| ((m as f64 + 0.5) / n as f64 - 0.5) * spacing[a])
        };
        let samples: Vec<Vec3> = offsets(0)
            .flat_map(|x| offsets(1).flat_map(move |y| offsets(2).map(move |z| Vec3::new(x, y, z))))
            .collect();
        for body in &self.bodies {
            let shape = &shapes[body.shape as usize];
            let radius = body.radius(shapes);
            let local = |arm: &Vec3| body.rotation.tr_mul(arm) / body.scale;
            let range = |a: usize| {
                let place = |x: f64| ((x - self.subgrid.lower[a]) / spacing[a]).floor().max(0.0) as usize;
                place(body.center[a] - radius)..(place(body.center[a] + radius) + 1).min(layout.cells[a])
            };
            for k in range(2) {
                for j in range(1) {
                    for i in range(0) {
                        let center = Vec3::from_fn(|a, _| {
                            self.subgrid.lower[a] + ([i, j, k][a] as f64 + 0.5) * spacing[a]
                        });
                        let arm = center - body.center;
                        if !shape.is_near(&local(&arm), reach / body.scale) {
                            continue;
                        }
                        let inside = samples.iter().filter(|s| shape.contains(&local(&(arm + **s)))).count();
                        if inside > 0 {
                            let volume = cell * inside as f64 / samples.len() as f64;
                            add(
                                layout.index(i as isize, j as isize, k as isize),
                                volume,
                                body.velocity_at(&arm),
                            );
                        }
                    }
                }
            }
        }
    }
}
