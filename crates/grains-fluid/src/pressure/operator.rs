//! The operator div(c grad p) itself, for iterations and residuals.

use super::PressureProblem;
use crate::metrics::Local;
use crate::{Centre, Faces, Field};

/// Σ_faces c A (p_neighbour − p)/d of every cell.
#[derive(Clone, Debug)]
pub struct PressureOperator {
    local: Local,
    /// Conductances c A/d of the upper faces (m³/(Pa s)); zero where a face closes the box.
    conductances: Faces,
    /// Sum of the conductances of imposed boundary pressures per cell.
    imposed: Field<Centre>,
}

impl PressureOperator {
    /// Operator with coefficients zero.
    pub fn new(problem: &PressureProblem) -> Self {
        let local = Local::new(&problem.grid, &problem.ownership, problem.halo);
        let layout = local.layout;
        Self { local, conductances: Faces::new(layout), imposed: Field::new(layout) }
    }

    /// Takes coefficients; halos must be filled, the lower boundary faces have index −1.
    pub fn set(&mut self, coefficients: &Faces) {
        self.imposed.fill(0.0);
        for axis in 0..3 {
            self.set_axis(axis, coefficients.component(axis));
        }
    }

    fn set_axis(&mut self, axis: usize, coefficients: &[f64]) {
        let (local, layout) = (&self.local, self.local.layout);
        let [nx, ny, nz] = layout.cells.map(|n| n as isize);
        let h = layout.halo as isize;
        let mut from = [0_isize; 3];
        from[axis] = -1;
        for k in from[2]..nz {
            for j in from[1]..ny {
                for i in from[0]..nx {
                    let place = [i, j, k];
                    let entry = |a: usize| (place[a] + h) as usize;
                    let area: f64 =
                        (0..3).filter(|&a| a != axis).map(|a| local.axes[a].width[entry(a)]).product();
                    let p = layout.index(i, j, k);
                    let conductance = coefficients[p] * area * local.axes[axis].inverse_distance[entry(axis)];
                    let n = layout.cells[axis] as isize;
                    let is_low_end = place[axis] == -1 && local.ends[axis][0];
                    let is_high_end = place[axis] == n - 1 && local.ends[axis][1];
                    let is_end = is_low_end || is_high_end || !local.active[axis];
                    self.conductances.component_mut(axis)[p] = if is_end { 0.0 } else { conductance };
                    let stride = layout.strides()[axis];
                    if is_low_end {
                        self.imposed.data_mut()[p + stride] += 2.0 * conductance;
                    }
                    if is_high_end {
                        self.imposed.data_mut()[p] += 2.0 * conductance;
                    }
                }
            }
        }
    }

    /// out = A p in the own cells, and Σ p A p over them; the halo of p must be filled.
    pub fn apply(&self, p: &Field<Centre>, out: &mut Field<Centre>) -> f64 {
        let (layout, strides) = (self.local.layout, self.local.layout.strides());
        let n = layout.cells[0];
        let mut product = 0.0;
        for start in layout.rows() {
            let at = |start: usize| &p.data()[start..start + n];
            let here = at(start);
            let row = &mut out.data_mut()[start..start + n];
            let imposed = &self.imposed.data()[start..start + n];
            row.iter_mut().zip(here).zip(imposed).for_each(|((o, x), c)| *o = -c * x);
            for (axis, &stride) in strides.iter().enumerate().filter(|a| self.local.active[a.0]) {
                let conductance = self.conductances.component(axis);
                let (upper, lower) = (&conductance[start..start + n], &conductance[start - stride..][..n]);
                let (next, previous) = (at(start + stride), at(start - stride));
                for i in 0..n {
                    row[i] += upper[i] * (next[i] - here[i]) - lower[i] * (here[i] - previous[i]);
                }
            }
            product += row.iter().zip(here).map(|(a, b)| a * b).sum::<f64>();
        }
        product
    }
}
