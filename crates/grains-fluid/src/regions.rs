//! Regions of open cells that no outlet is part of, where what flows in must flow out.

use crate::boundary::Kind;
use crate::flow::Flow;
use crate::{Centre, Field, SetupError};
use grains_domain::Transport;

/// What a net inflow may be of what flows and pass for rounding (-).
const IMBALANCE: f64 = 1e-9;

/// Label of what is connected to an outlet, and of what is solid.
const OUTSIDE: f64 = 0.0;
const SOLID: f64 = f64::INFINITY;

impl Flow {
    /// Refuses a region of open cells into which more flows than leaves it: of the whole box, or of what is shut off from its
    /// outlets. Cells are open where `is_open` says so by their array places, halo included, and walls leave something.
    /// Collective.
    ///
    /// # Errors
    /// Such a region, with a place in it.
    pub fn check_regions(
        &self,
        is_open: impl Fn(usize) -> bool,
        transport: &dyn Transport,
    ) -> Result<(), SetupError> {
        let mut gross = [0.0];
        self.for_inflows(|_, inflow| gross[0] += inflow.abs());
        transport.sum(&mut gross);
        if gross[0] == 0.0 {
            return Ok(());
        }
        let labels = self.labels(&is_open, transport);
        let mut known = OUTSIDE;
        loop {
            // The next region with an inlet, in ascending order of labels on all ranks.
            let mut next = [f64::NEG_INFINITY];
            self.for_inflows(|cell, _| {
                let label = labels.data()[cell];
                if label > known && label < SOLID {
                    next[0] = next[0].max(-label);
                }
            });
            transport.max(&mut next);
            let label = -next[0];
            if label == f64::INFINITY {
                return Ok(());
            }
            let mut sums = [0.0; 2];
            self.for_inflows(|cell, inflow| {
                if labels.data()[cell] == label {
                    sums = [sums[0] + inflow, sums[1] + inflow.abs()];
                }
            });
            transport.sum(&mut sums);
            if sums[0].abs() > IMBALANCE * sums[1] {
                return Err(self.closed(label, sums[0]));
            }
            known = label;
        }
    }

    fn closed(&self, label: f64, net: f64) -> SetupError {
        let grid = &self.setup.grid;
        if !self.setup.boundaries.has_outlet(grid) {
            return SetupError::ClosedBox { net };
        }
        let ([nx, ny, _], cell) = (grid.cells(), label as usize - 1);
        let place = [cell % nx, cell / nx % ny, cell / (nx * ny)];
        let at = std::array::from_fn(|a| grid.axis(a).centre(place[a] as isize));
        SetupError::ClosedRegion { net, at }
    }

    /// Array places of own cells into which flows are imposed, with these (m³/s).
    fn for_inflows(&self, mut job: impl FnMut(usize, f64)) {
        let openings = self.mixture.as_ref().and_then(|mixture| mixture.openings.as_ref());
        for face_data in &self.boundary_data {
            let axis = face_data.face.axis;
            let stride = self.local.layout.strides()[axis];
            face_data.for_normal_values(&self.local, |face, inwards, area| {
                let open = openings.map_or(1.0, |openings| openings.faces.component(axis)[face]);
                let cell = if face_data.face.outward() > 0.0 { face } else { face + stride };
                if inwards * open != 0.0 {
                    job(cell, inwards * open * area);
                }
            });
        }
    }

    /// The labels of the own cells: one for all cells of a region; collective.
    fn labels(&self, is_open: &impl Fn(usize) -> bool, transport: &dyn Transport) -> Field<Centre> {
        let (layout, grid) = (self.local.layout, &self.setup.grid);
        let openings = self.mixture.as_ref().and_then(|mixture| mixture.openings.as_ref());
        let is_open = |p: usize| is_open(p) && openings.is_none_or(|o| o.cells.data()[p] > 0.0);
        let passes = |axis: usize, p: usize| openings.is_none_or(|o| o.faces.component(axis)[p] > 0.0);
        let mut labels: Field<Centre> = Field::new(layout);
        labels.fill(SOLID);
        let [nx, ny, _] = grid.cells();
        let [mx, my, _] = layout.cells;
        let own: Vec<usize> = layout.rows().flat_map(|row| row..row + mx).collect();
        for (number, &p) in own.iter().enumerate() {
            let cell = [number % mx, number / mx % my, number / (mx * my)];
            let [i, j, k] = std::array::from_fn(|a| cell[a] + self.local.first[a]);
            labels.data_mut()[p] = if is_open(p) { (1 + i + nx * (j + ny * k)) as f64 } else { SOLID };
        }
        for face_data in &self.boundary_data {
            let axis = face_data.face.axis;
            for (e, m) in face_data.own_entries(layout) {
                let cell = face_data.inside(layout, m[0], m[1]);
                let face = face_data.boundary(layout, cell);
                if face_data.kinds[axis][e] == Kind::Free && passes(axis, face) && is_open(cell) {
                    labels.data_mut()[cell] = OUTSIDE;
                }
            }
        }
        let strides = layout.strides();
        let active: Vec<usize> = (0..3).filter(|&a| self.local.active[a]).collect();
        let mut halo = self.halo.clone();
        loop {
            halo.fill_to(1, &mut [labels.data_mut()], transport);
            let mut has_changed = [0.0];
            // Back and forth until nothing changes on this rank.
            loop {
                let mut changes = false;
                let data = labels.data_mut();
                let mut visit = |p: usize| {
                    if data[p] == SOLID {
                        return;
                    }
                    let mut smallest = data[p];
                    for &a in &active {
                        // Solid neighbours and what lies beyond the box have the largest label.
                        if passes(a, p) {
                            smallest = smallest.min(data[p + strides[a]]);
                        }
                        if passes(a, p - strides[a]) {
                            smallest = smallest.min(data[p - strides[a]]);
                        }
                    }
                    if smallest < data[p] {
                        (data[p], changes) = (smallest, true);
                    }
                };
                own.iter().for_each(|&p| visit(p));
                own.iter().rev().for_each(|&p| visit(p));
                if !changes {
                    break;
                }
                has_changed[0] = 1.0;
            }
            transport.max(&mut has_changed);
            if has_changed[0] == 0.0 {
                return labels;
            }
        }
    }
}
