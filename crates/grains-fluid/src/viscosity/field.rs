//! The viscosity of a subdomain, where stresses act.

use super::rates::{Rates, gradient, others, row_length, rows};
use super::{Rheology, Turbulence, ViscosityLaw};
use crate::boundary::{BoundaryData, BoxFace, Kind};
use crate::metrics::Local;
use crate::momentum::StressWeights;
use crate::{Boundaries, Centre, Condition, Field, Grid, Layout, SolidStresses};

/// Kinematic viscosity ν at centres and edges (m²/s); among particles ε ν.
#[derive(Clone, Debug)]
pub(crate) struct ViscosityField {
    law: ViscosityLaw,
    density: f64,
    /// ν of the fluid itself (m²/s), to which that of eddies is added.
    own: f64,
    centres: Field<Centre>,
    /// On the edges along each axis: of a cell, that of its upper faces normal to the other two.
    edges: [Vec<f64>; 3],
    /// Of fluids whose viscosity depends on the rate of shear.
    rates: Option<Rates>,
    /// Distance (m) of the cells along each axis from the closest end of the box without slip.
    distances: [Vec<f64>; 3],
}

impl ViscosityField {
    /// The field of a law, of a fluid of density ρ (kg/m³) and own viscosity (Pa s).
    pub fn new(
        law: ViscosityLaw,
        [density, viscosity]: [f64; 2],
        (grid, local): (&Grid, &Local),
        boundaries: &Boundaries,
    ) -> Self {
        let layout = local.layout;
        Self {
            law,
            density,
            own: viscosity / density,
            centres: Field::new(layout),
            edges: std::array::from_fn(|_| vec![0.0; layout.len()]),
            rates: matches!(law, ViscosityLaw::Rheology(_)).then(|| Rates::new(layout)),
            distances: std::array::from_fn(|a| wall_distances(grid, local, boundaries, a)),
        }
    }

    /// What stresses act through.
    pub fn weights(&self) -> StressWeights<'_> {
        let edges = |c: usize, a: usize| if a == c { &[][..] } else { &self.edges[3 - c - a][..] };
        StressWeights {
            centres: [self.centres.data(); 3],
            edges: std::array::from_fn(|c| std::array::from_fn(|a| edges(c, a))),
        }
    }

    /// See [`ViscosityLaw::implicitness`].
    pub fn implicitness(&self) -> f64 {
        self.law.implicitness()
    }

    /// Lower bound of μ (Pa s).
    pub fn smallest_viscosity(&self) -> f64 {
        self.law.smallest_viscosity(self.own * self.density)
    }

    /// Sets the field to that of a velocity whose halo and ghosts are filled two layers deep; not collective.
    pub fn update(&mut self, local: &Local, boundary_data: &[BoundaryData], velocity: [&[f64]; 3]) {
        match self.law {
            ViscosityLaw::Rheology(rheology) => self.set_by_rates(rheology, local, velocity),
            ViscosityLaw::Turbulence(model) => self.set_by_eddies(model, local, boundary_data, velocity),
        }
    }

    /// Sets the field to one value (m²/s) where bodies hold all velocities.
    ///
    /// No stress there acts on the fluid. That of fluid at rest would be the largest by far, and forces on the fluid inside, which
    /// outweigh it, would settle slowly or not at all.
    pub fn thin(&mut self, solid: &SolidStresses, viscosity: f64) {
        let centres = self.centres.data_mut();
        solid.centres.iter().for_each(|&place| centres[place as usize] = viscosity);
        for (edges, solid) in self.edges.iter_mut().zip(&solid.edges) {
            solid.iter().for_each(|&place| edges[place as usize] = viscosity);
        }
    }

    /// Weighs the field by the void fraction ε among particles.
    pub fn weigh(&mut self, porosity: StressWeights<'_>) {
        let weigh = |values: &mut [f64], eps: &[f64]| {
            values.iter_mut().zip(eps).for_each(|(nu, eps)| *nu *= eps);
        };
        weigh(self.centres.data_mut(), porosity.centres[0]);
        for (axis, edges) in self.edges.iter_mut().enumerate() {
            let [a, b] = others(axis);
            weigh(edges, porosity.edges[a][b]);
        }
    }

    /// μ (Pa s) at the centres of the own cells of a velocity as in [`ViscosityField::update`].
    pub fn dynamic_viscosity(
        &mut self,
        local: &Local,
        boundary_data: &[BoundaryData],
        velocity: [&[f64]; 3],
    ) -> Field<Centre> {
        self.update(local, boundary_data, velocity);
        let mut viscosity = self.centres.clone();
        viscosity.data_mut().iter_mut().for_each(|nu| *nu *= self.density);
        viscosity
    }

    fn set_by_rates(&mut self, rheology: Rheology, local: &Local, velocity: [&[f64]; 3]) {
        let Some(rates) = &mut self.rates else { return };
        rates.measure(local, velocity);
        let (law, specific) = (rheology.law(), 1.0 / self.density);
        let n = row_length(local, [0, 1]);
        for (_, start) in rows(local, [0, 1]) {
            let row = &mut self.centres.data_mut()[start..start + n];
            rates.at_centres(local, start, row);
            law.apply(specific, row);
        }
        let n = row_length(local, [1, 0]);
        for (axis, edges) in self.edges.iter_mut().enumerate() {
            let [a, b] = others(axis);
            if !(local.active[a] && local.active[b]) {
                continue;
            }
            for (place, start) in rows(local, [1, 0]) {
                // No stress acts on the edges before the first cell along their own axis.
                if axis != 0 && local.active[axis] && place[axis] < local.layout.halo {
                    continue;
                }
                let row = &mut edges[start..start + n];
                rates.on_edges(local, axis, start, row);
                law.apply(specific, row);
            }
        }
    }

    fn set_by_eddies(
        &mut self,
        turbulence: Turbulence,
        local: &Local,
        boundary_data: &[BoundaryData],
        velocity: [&[f64]; 3],
    ) {
        let (model, n) = (turbulence.model(), row_length(local, [1, 1]));
        let [dx, dy, dz] = &self.distances;
        for (place, start) in rows(local, [1, 1]) {
            let [x, y, z] = place;
            let area = local.axes[1].width[y] * local.axes[2].width[z];
            for i in 0..n {
                let gradient = gradient(local, velocity, [x + i, y, z], start + i);
                let width = (local.axes[0].width[x + i] * area).cbrt();
                let distance = dx[x + i].min(dy[y]).min(dz[z]);
                self.centres.data_mut()[start + i] = model.eddy_viscosity(&gradient, width, distance);
            }
        }
        for face_data in boundary_data {
            face_data.fill_by_wall(&mut self.centres);
        }
        let (strides, own) = (local.layout.strides(), self.own);
        let n = row_length(local, [1, 0]);
        for (axis, edges) in self.edges.iter_mut().enumerate() {
            let [a, b] = others(axis);
            if !(local.active[a] && local.active[b]) {
                continue;
            }
            for (_, start) in rows(local, [1, 0]) {
                let corners = [0, strides[a], strides[b], strides[a] + strides[b]];
                let [c0, c1, c2, c3] =
                    corners.map(|offset| &self.centres.data()[start + offset..start + offset + n]);
                for (i, nu) in edges[start..start + n].iter_mut().enumerate() {
                    *nu = own + 0.25 * ((c0[i] + c1[i]) + (c2[i] + c3[i])).max(0.0);
                }
            }
        }
        self.centres.data_mut().iter_mut().for_each(|nu| *nu = own + nu.max(0.0));
    }
}

/// Distance (m) of the cells along an axis from the closest end without slip.
fn wall_distances(grid: &Grid, local: &Local, boundaries: &Boundaries, axis: usize) -> Vec<f64> {
    let ends = (0..2).filter(|&side| {
        let face = BoxFace::all().nth(2 * axis + side);
        let is_open = grid.axis(axis).is_periodic() || !grid.is_active(axis);
        let is_wall = |c: &Condition| matches!(c, Condition::Wall { .. });
        !is_open && face.is_some_and(|face| boundaries.on(face).any(is_wall))
    });
    let ends: Vec<f64> = ends
        .map(|side| grid.axis(axis).nodes()[if side == 0 { 0 } else { grid.axis(axis).cells() }])
        .collect();
    let layout: Layout = local.layout;
    let distance = |m: usize| {
        let centre = grid.axis(axis).centre(m as isize - layout.halo as isize + local.first[axis] as isize);
        ends.iter().map(|end| (centre - end).abs()).fold(f64::INFINITY, f64::min)
    };
    (0..layout.dims()[axis]).map(distance).collect()
}

impl BoundaryData {
    /// First ghost of a quantity that is 0 on faces with an imposed velocity and has no gradient on others.
    fn fill_by_wall(&self, field: &mut Field<Centre>) {
        let layout = field.layout();
        let step = self.face.outward() as isize * layout.strides()[self.face.axis] as isize;
        let (kinds, data) = (&self.kinds[self.face.axis], field.data_mut());
        for m2 in 0..self.extents[1] {
            for m1 in 0..self.extents[0] {
                let p = self.inside(layout, m1, m2);
                let is_fixed = kinds[m2 * self.extents[0] + m1] == Kind::Fixed;
                data[(p as isize + step) as usize] = if is_fixed { -data[p] } else { data[p] };
            }
        }
    }
}
