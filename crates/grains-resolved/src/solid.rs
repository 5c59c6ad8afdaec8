//! What cells hold of bodies.

use crate::wall::Solids;
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
            let Some(shape) = body.shape(shapes) else { continue };
            let radius = body.radius(shapes);
            let local = |arm: &Vec3| body.rotation.tr_mul(arm) / body.scale;
            let range = |a: usize| {
                let place = |x: f64| ((x - self.subgrid.lower[a]) / spacing[a]).floor().max(0.0) as usize;
                place(body.center[a] - radius)..(place(body.center[a] + radius) + 1).min(layout.cells[a])
            };
            self.subgrid.for_each_cell([0, 1, 2].map(range), |place, center| {
                let arm = center - body.center;
                if !shape.is_near(&local(&arm), reach / body.scale) {
                    return;
                }
                let inside = samples.iter().filter(|s| shape.contains(&local(&(arm + **s)))).count();
                if inside > 0 {
                    let volume = cell * inside as f64 / samples.len() as f64;
                    add(place, volume, body.velocity_at(&arm));
                }
            });
        }
        let solids = Solids { bodies: &self.bodies, shapes, walls: &self.walls, subgrid: &self.subgrid };
        let all = layout.cells.map(|n| 0..n);
        for (wall, placed) in self.walls.iter().enumerate() {
            self.subgrid.for_each_cell(all.clone(), |place, center| {
                let depth = solids.depth_in_wall(wall, &center);
                let share = match depth.abs() >= reach {
                    true => f64::from(u8::from(depth > 0.0)),
                    false => {
                        let is_inside = |s: &&Vec3| solids.depth_in_wall(wall, &(center + **s)) > 0.0;
                        samples.iter().filter(is_inside).count() as f64 / samples.len() as f64
                    }
                };
                if share > 0.0 {
                    let arm = center - placed.body.center;
                    add(place, cell * share, placed.body.velocity_at(&arm));
                }
            });
        }
    }
}
