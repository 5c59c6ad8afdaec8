//! What solids do to a scalar in a step.

use super::super::advance::is_own;
use super::super::{ScalarSetup, ScalarValue, SolidCondition};
use super::barrier::{Barrier, FIXED, Inside, Surface, Tie};
use super::cells::SolidCells;
use crate::metrics::Local;
use crate::{Centre, Faces, Field, Grid};

/// What comes into a cell by way of a solid: rate − coefficient φ (unit m³/s, m³/s).
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Linear {
    pub cell: usize,
    pub solid: u32,
    pub coefficient: f64,
    pub rate: f64,
    /// Whether it reacts in the solid, else comes out of it.
    pub reacts: bool,
}

/// Middle of a cell (m).
pub(super) fn middle(grid: &Grid, local: &Local, place: usize) -> [f64; 3] {
    let (layout, strides) = (local.layout, local.layout.strides());
    let dims = layout.dims();
    [0, 1, 2].map(|a| {
        let cell = (place / strides[a] % dims[a]) as isize - layout.halo as isize + local.first[a] as isize;
        0.5 * (grid.axis(a).node(cell) + grid.axis(a).node(cell + 1))
    })
}

/// The value on a fixed solid's surface, at a point and a time (s); none of others.
fn on_surface(
    (setup, cells): (&ScalarSetup, &SolidCells),
    of_solids: &[f64],
    solid: u32,
    at: impl FnOnce() -> [f64; 3],
    time: f64,
) -> Option<f64> {
    match setup.solids.of(solid as usize, cells.bodies) {
        SolidCondition::Value(ScalarValue::Uniform(value)) => Some(*value),
        SolidCondition::Value(value) => Some(value.at(at(), time)),
        SolidCondition::OfSolid => of_solids.get(solid as usize).copied(),
        _ => None,
    }
}

impl Barrier {
    /// Sets the values on surfaces at a time (s), of cells that are fixed too.
    pub fn evaluate(
        &mut self,
        (setup, cells): (&ScalarSetup, &SolidCells),
        of_solids: &[f64],
        (grid, local): (&Grid, &Local),
        time: f64,
        value: &mut Field<Centre>,
    ) {
        let strides = local.layout.strides();
        let dims = local.layout.dims();
        let value = value.data_mut();
        for (axis, ties) in self.ties.iter_mut().enumerate() {
            for tie in ties {
                let at = || {
                    let mut at = middle(grid, local, tie.free);
                    let width =
                        1.0 / local.axes[axis].inverse_distance[tie.face / strides[axis] % dims[axis]];
                    at[axis] += tie.side * tie.way * width;
                    at
                };
                let on_surface = || on_surface((setup, cells), of_solids, tie.solid, at, time);
                tie.value = setup.solids.no_film.or_else(on_surface);
                if tie.value.is_none() {
                    value[tie.fixed] = value[tie.free];
                }
            }
        }
        if let Some(outside) = setup.solids.no_film {
            let fixed = value.iter_mut().zip(&self.capacity).filter(|(_, capacity)| **capacity >= FIXED);
            fixed.for_each(|(value, _)| *value = outside);
        }
        for &(place, solid) in &self.fixed {
            let place = place as usize;
            let at = || middle(grid, local, place);
            if let Some(fixed) = on_surface((setup, cells), of_solids, solid, at, time) {
                value[place] = fixed;
            }
        }
    }

    /// What comes in through surfaces, and what reacts in solids, as functions of the values at the end of the step; of values at its
    /// beginning and volumes of fluid (m³).
    pub fn linear(
        &self,
        (setup, cells): (&ScalarSetup, &SolidCells),
        (grid, local): (&Grid, &Local),
        time: f64,
        (value, volume): (&[f64], &[f64]),
        out: &mut Vec<Linear>,
    ) {
        out.clear();
        for tie in self.ties.iter().flatten().filter(|tie| is_own(local.layout, tie.free)) {
            let (cell, solid) = (tie.free, tie.solid);
            let coefficient = tie.conductance * volume[cell] / tie.volume;
            if let Some(value) = tie.value.filter(|_| coefficient > 0.0) {
                out.push(Linear { cell, solid, coefficient, rate: coefficient * value, reacts: false });
            }
        }
        for &Surface { cell, solid, area, distance } in &self.surfaces {
            if volume[cell] <= 0.0 {
                continue;
            }
            let at = || middle(grid, local, cell);
            let [coefficient, rate] = match setup.solids.of(solid as usize, cells.bodies) {
                SolidCondition::Flux(flux) => [0.0, area * flux.at(at(), time)],
                SolidCondition::Transfer { coefficient, ambient } if *coefficient > 0.0 => {
                    let through = 1.0 / (1.0 / coefficient + distance.max(0.0) / setup.diffusivity);
                    [area * through, area * through * ambient.at(at(), time)]
                }
                _ => continue,
            };
            out.push(Linear { cell, solid, coefficient, rate, reacts: false });
        }
        for &Inside { cell, solid, volume } in &self.inside {
            let SolidCondition::Interior(interior) = setup.solids.of(solid as usize, cells.bodies) else {
                continue;
            };
            let Some(reaction) = interior.reaction else { continue };
            // k (K φ)ⁿ = [k Kⁿ φ₀ⁿ⁻¹] φ; what is next to nothing does not react faster than a step takes.
            let here = (interior.capacity * value[cell]).max(f64::MIN_POSITIVE);
            let factor = reaction.rate * here.powf(reaction.order - 1.0) * interior.capacity;
            let coefficient = volume * factor.min(FIXED.sqrt());
            out.push(Linear { cell, solid, coefficient, rate: 0.0, reacts: true });
        }
    }

    /// Sets the fluxes of high order at the beginning of a step through faces that solids tie, and what runs along surfaces.
    pub fn set_high(
        &self,
        axis: usize,
        flux: &[f64],
        (value, previous, weights): (&[f64], &[f64], [f64; 2]),
        local: &Local,
        high: &mut [f64],
    ) {
        for tie in &self.ties[axis] {
            let mean = weights[0] * value[tie.free] + weights[1] * previous[tie.free];
            let on_face = match tie.value {
                None => mean,
                Some(there) if tie.way > 0.5 => mean + (there - mean) * 0.5 / tie.way,
                Some(there) => there,
            };
            high[tie.face] = flux[tie.face] * on_face;
        }
        let stride = local.layout.strides()[axis];
        for jump in &self.jumps[axis] {
            let difference = value[jump.face + stride] - value[jump.face];
            high[jump.face] += jump.flux(axis, self.gradient(jump.cell, value, local), difference);
        }
    }

    /// Gradient of φ at a cell by differences that do not cross surfaces (unit/m).
    fn gradient(&self, cell: usize, value: &[f64], local: &Local) -> [f64; 3] {
        let strides = local.layout.strides();
        let dims = local.layout.dims();
        [0, 1, 2].map(|a| {
            if !local.active[a] {
                return 0.0;
            }
            let (stride, e) = (strides[a], cell / strides[a] % dims[a]);
            let inverse = &local.axes[a].inverse_distance;
            let is_there = |other: usize| self.interior[other] == self.interior[cell] && self.is_free(other);
            let up = is_there(cell + stride).then(|| (value[cell + stride] - value[cell]) * inverse[e]);
            let down = is_there(cell - stride).then(|| (value[cell] - value[cell - stride]) * inverse[e - 1]);
            match (up, down) {
                (Some(up), Some(down)) => 0.5 * (up + down),
                (Some(one), None) | (None, Some(one)) => one,
                (None, None) => 0.0,
            }
        })
    }

    /// Notes what flow carries through the tied faces along the axes (unit m³/s).
    pub fn set_carried(&mut self, flux: &Faces) {
        for (axis, ties) in self.ties.iter_mut().enumerate() {
            ties.iter_mut().for_each(|tie| tie.carried = flux.component(axis)[tie.face]);
        }
    }

    /// The tied faces of an axis, with what upwind differences carry through them (unit m³/s).
    pub fn upwind<'a>(
        &'a self,
        axis: usize,
        flux: &'a [f64],
        value: &'a [f64],
    ) -> impl Iterator<Item = (&'a Tie, f64)> {
        self.ties[axis].iter().map(move |tie| {
            let flux = flux[tie.face];
            let own = value[tie.free];
            let comes_in = flux * tie.side < 0.0;
            (tie, flux * if comes_in { tie.value.unwrap_or(own) } else { own })
        })
    }
}
