//! Pressures where fluid enters by itself.

use super::data::BoundaryData;
use super::{Boundaries, Condition, Kind};
use crate::metrics::Local;
use crate::{Centre, Faces, Field};

impl BoundaryData {
    /// Whether fluid enters the face of a cell at an array place with what a pressure inlet gives it; else what comes in through
    /// an outlet brings no momentum.
    #[inline]
    pub fn brings_momentum(&self, e: usize) -> bool {
        self.totals.as_ref().is_some_and(|totals| !totals[e].is_nan())
    }

    /// Sets the pressures of pressure inlets, p₀ + rise − ρ u²/2 where fluid enters, of a density (kg/m³), the rises (Pa) of the
    /// fans by the numbers of the conditions, and the velocity (m/s) on the face.
    pub fn set_pressures(&mut self, density: f64, rise: impl Fn(usize) -> f64, velocity: &Faces) {
        let Some(totals) = &self.totals else { return };
        let (axis, layout) = (self.face.axis, velocity.layout());
        let u = velocity.component(axis);
        for (e, [m1, m2]) in self.entries() {
            if totals[e].is_nan() {
                continue;
            }
            let number = self.conditions[axis][e] as usize;
            let inwards = -self.face.outward() * u[self.boundary(layout, self.inside(layout, m1, m2))];
            self.pressure[e] = totals[e] + rise(number) - 0.5 * density * inwards.max(0.0).powi(2);
        }
    }

    /// First ghost of a pressure that is 1 on the cells of one condition and 0 on other outlets.
    pub fn fill_unit(&self, field: &mut Field<Centre>, condition: usize) {
        let (layout, axis) = (field.layout(), self.face.axis);
        let data = field.data_mut();
        let step = self.face.outward() as isize * layout.strides()[axis] as isize;
        for (e, [m1, m2]) in self.entries() {
            let p = self.inside(layout, m1, m2);
            data[(p as isize + step) as usize] = match self.kinds[axis][e] {
                Kind::Free if self.conditions[axis][e] as usize == condition => 2.0 - data[p],
                Kind::Free => -data[p],
                _ => data[p],
            };
        }
    }

    /// Flow (m³/s) into the box through the own cells of one condition on which a pressure is imposed; what is open of the
    /// faces is given where it is not all.
    pub fn inflow_of(&self, local: &Local, condition: usize, velocity: &Faces, open: Option<&Faces>) -> f64 {
        let axis = self.face.axis;
        let mut inflow = 0.0;
        self.for_free(local, |e, face, area| {
            if self.conditions[axis][e] as usize == condition {
                let open = open.map_or(1.0, |open| open.component(axis)[face]);
                inflow -= self.face.outward() * open * area * velocity.component(axis)[face];
            }
        });
        inflow
    }

    /// What enters and what leaves (m³/s) through the own cells of outlets.
    pub fn outlet_flows(
        &self,
        local: &Local,
        boundaries: &Boundaries,
        velocity: &Faces,
        open: Option<&Faces>,
    ) -> [f64; 2] {
        let axis = self.face.axis;
        let mut flows = [0.0; 2];
        self.for_free(local, |e, face, area| {
            if let Condition::Outlet { .. } = boundaries.condition(self.conditions[axis][e] as usize) {
                let open = open.map_or(1.0, |open| open.component(axis)[face]);
                let leaving = self.face.outward() * open * area * velocity.component(axis)[face];
                flows[usize::from(leaving > 0.0)] += leaving.abs();
            }
        });
        flows
    }

    /// Own entries on which a pressure is imposed, with the array place of the face and its area (m²).
    fn for_free(&self, local: &Local, mut job: impl FnMut(usize, usize, f64)) {
        for (e, [m1, m2]) in self.own_entries(local.layout) {
            if self.kinds[self.face.axis][e] == Kind::Free {
                let face = self.boundary(local.layout, self.inside(local.layout, m1, m2));
                job(e, face, self.area(local, [m1, m2]));
            }
        }
    }
}
