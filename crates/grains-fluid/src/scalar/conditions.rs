//! The conditions of a scalar, spelt out for every boundary cell of a subdomain.

use super::{ScalarBoundaries, ScalarCondition};
use crate::boundary::BoundaryData;
use crate::metrics::Local;
use crate::{Boundaries, Grid};

/// A boundary cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoundaryCell {
    /// Places of the cell and of its face on the boundary in the arrays.
    pub cell: usize,
    pub face: usize,
    /// Middle of the face (m).
    at: [f64; 3],
    /// Area of the face (m²), and width of the cell along the normal (m).
    area: f64,
    width: f64,
    /// Number of its condition; that of the patch after the face's own.
    condition: usize,
    /// Whether fluid may pass.
    pub is_open: bool,
    /// Whether steps change the cell: what a solid holds does not count.
    pub is_free: bool,
    /// Value behind the face; that of the cell if none is imposed.
    pub outside: Option<f64>,
    /// What conducts between the cell and that value (m³/s), without the void fraction.
    pub conductance: f64,
    /// Flux into the fluid (unit m³/s), without the void fraction.
    pub influx: f64,
}

/// The conditions on one face of the box.
#[derive(Clone, Debug)]
pub(super) struct FaceConditions {
    /// Axis normal to the face, and +1 where it points out of the box along it, else −1.
    pub axis: usize,
    pub outward: f64,
    pub cells: Vec<BoundaryCell>,
}

impl FaceConditions {
    /// Those of all faces of the box that a subdomain touches.
    pub fn all(
        (grid, local): (&Grid, &Local),
        (flow, of_flow): (&[BoundaryData], &Boundaries),
        boundaries: &ScalarBoundaries,
    ) -> Vec<Self> {
        let layout = local.layout;
        let of_face = |data: &BoundaryData| {
            let axis = data.face.axis;
            let cell = |(entry, place): (usize, [usize; 2])| {
                let inside = data.inside(layout, place[0], place[1]);
                let (_, at) = data.place(grid, local, axis, place);
                let patches = boundaries.patches.iter().enumerate().rev();
                let holds = patches
                    .filter(|(_, (face, ..))| *face == data.face)
                    .find(|(_, (_, outline, _))| outline.contains(grid, axis, at));
                let last = if data.face.outward() > 0.0 { layout.cells[axis] - 1 } else { 0 };
                BoundaryCell {
                    cell: inside,
                    face: data.boundary(layout, inside),
                    at,
                    area: data.area(local, place),
                    width: local.axes[axis].width[local.entry(last)],
                    condition: holds.map_or(data.face.index(), |(number, _)| 6 + number),
                    is_free: true,
                    is_open: data.is_passed(entry, of_flow),
                    outside: None,
                    conductance: 0.0,
                    influx: 0.0,
                }
            };
            let cells = data.own_entries(layout).map(cell).collect();
            Self { axis, outward: data.face.outward(), cells }
        };
        flow.iter().map(of_face).collect()
    }

    /// Sets what holds at a time (s), of a scalar of a diffusivity (m²/s).
    pub fn evaluate(&mut self, boundaries: &ScalarBoundaries, diffusivity: f64, time: f64) {
        for cell in &mut self.cells {
            let condition = match cell.condition.checked_sub(6) {
                Some(number) => &boundaries.patches[number].2,
                None => &boundaries.faces[cell.condition],
            };
            let resistance = 0.5 * cell.width / diffusivity;
            let (outside, conductance, influx) = match condition {
                ScalarCondition::Insulated => (None, 0.0, 0.0),
                ScalarCondition::Value(value) => (Some(value.at(cell.at, time)), 1.0 / resistance, 0.0),
                ScalarCondition::Flux(flux) => (None, 0.0, flux.at(cell.at, time)),
                ScalarCondition::Transfer { coefficient, ambient } if *coefficient > 0.0 => {
                    (Some(ambient.at(cell.at, time)), 1.0 / (resistance + 1.0 / coefficient), 0.0)
                }
                ScalarCondition::Transfer { .. } => (None, 0.0, 0.0),
            };
            cell.outside = outside;
            // Nothing diffuses against what flows in.
            cell.conductance = if cell.is_open { 0.0 } else { conductance * cell.area };
            cell.influx = influx * cell.area;
        }
    }
}

impl FaceConditions {
    /// Notes the cells that steps change; through the faces of others nothing diffuses.
    pub fn note_free(&mut self, is_free: impl Fn(usize) -> bool) {
        for cell in &mut self.cells {
            cell.is_free = is_free(cell.cell);
            if !cell.is_free {
                (cell.conductance, cell.influx) = (0.0, 0.0);
            }
        }
    }

    /// Place of what is behind the face of a cell.
    pub fn beyond(&self, cell: &BoundaryCell, strides: [usize; 3]) -> usize {
        if self.outward > 0.0 { cell.cell + strides[self.axis] } else { cell.cell - strides[self.axis] }
    }

    /// Gives places behind the face the value that is imposed, or that of their cell.
    pub fn set_beyond(&self, values: &mut [f64], strides: [usize; 3]) {
        for cell in &self.cells {
            values[self.beyond(cell, strides)] = cell.outside.unwrap_or(values[cell.cell]);
        }
    }

    /// Continues values beyond the face.
    pub fn continue_beyond(&self, values: &mut [f64], strides: [usize; 3]) {
        self.cells.iter().for_each(|cell| values[self.beyond(cell, strides)] = values[cell.cell]);
    }

    /// What a volume flux along the axis carries: what is behind where it enters, else what the cell has.
    pub fn carried(&self, cell: &BoundaryCell, flux: f64, own: f64) -> f64 {
        if flux * self.outward < 0.0 { cell.outside.unwrap_or(own) } else { own }
    }

    /// Sum of fluxes along the axis into the box.
    pub fn entering(&self, fluxes: &[f64]) -> f64 {
        let free = self.cells.iter().filter(|cell| cell.is_free);
        -self.outward * free.map(|cell| fluxes[cell.face]).sum::<f64>()
    }
}
