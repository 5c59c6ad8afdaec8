//! Fluid among particles: void fraction, drag and sources (Rakotonirina 2016, eqs 5.10-5.11).

use crate::boundary::FaceTable;
use crate::metrics::Local;
use crate::momentum::{Capacity, FaceTerms};
use crate::{Centre, Faces, Field, Halo, Layout, StepError};
use grains_domain::Transport;

/// Who carries the pressure gradient.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MixtureModel {
    /// The fluid feels −ε ∇p, each particle −V ∇p besides its drag.
    A,
    /// The fluid feels the whole −∇p, the drag of the particles is divided by ε.
    B,
}

/// What the particles do to the fluid; the caller sets the public fields in the own cells before every step.
#[derive(Clone, Debug)]
pub struct Mixture {
    /// Sharing of the pressure gradient.
    pub model: MixtureModel,
    /// Void fraction ε at the end of the coming step.
    pub void_fraction: Field<Centre>,
    /// Force on the fluid per volume of mixture (N/m³), explicit.
    pub source: Faces,
    /// Implicit drag coefficient β ≥ 0 per volume of mixture (kg/(m³ s)): the force −β u at the end of the step; what
    /// belongs to the particles' velocity, +β U, goes into `source`.
    pub drag: Faces,
    pub(crate) previous: Field<Centre>,
    pub(crate) middle: Field<Centre>,
    /// ε on the faces at the end and the beginning of the step.
    pub(crate) faces: Faces,
    pub(crate) old_faces: Faces,
    /// ε u at the beginning of the step (m/s).
    pub(crate) flux: Faces,
    /// 1/(ε/Δt + β/ρ) (s).
    pub(crate) inverse: Faces,
    /// Coefficients of the pressure equation (m⁴/(N s)).
    pub(crate) coefficients: Faces,
    /// ∂ε/∂t (1/s).
    pub(crate) rate: Field<Centre>,
}

impl Mixture {
    /// Pure fluid, ε = 1.
    pub fn new(model: MixtureModel, layout: Layout) -> Self {
        let mut ones = Faces::new(layout);
        ones.fill(1.0);
        let mut one = Field::new(layout);
        one.fill(1.0);
        Self {
            model,
            void_fraction: one.clone(),
            source: Faces::new(layout),
            drag: Faces::new(layout),
            previous: one.clone(),
            middle: one,
            faces: ones.clone(),
            old_faces: ones,
            flux: Faces::new(layout),
            inverse: Faces::new(layout),
            coefficients: Faces::new(layout),
            rate: Field::new(layout),
        }
    }

    /// Takes the present void fraction as that of the beginning: no change in the first step.
    pub fn begin(&mut self) {
        let (from, to) = (&self.void_fraction, &mut self.previous);
        to.data_mut().copy_from_slice(from.data());
    }

    /// Void fraction at the beginning of the coming step, for checkpoints.
    pub fn previous_void_fraction(&self) -> &Field<Centre> {
        &self.previous
    }

    /// Sets the void fraction of the beginning of the coming step, from a checkpoint.
    pub fn set_previous_void_fraction(&mut self, values: &Field<Centre>) {
        self.previous.data_mut().copy_from_slice(values.data());
    }

    /// Factor of −∇p on a face: ε in the middle of the step, or 1.
    #[inline(always)]
    pub(crate) fn gradient_factor(&self, component: usize, p: usize) -> f64 {
        match self.model {
            MixtureModel::A => {
                0.5 * (self.faces.component(component)[p] + self.old_faces.component(component)[p])
            }
            MixtureModel::B => 1.0,
        }
    }

    /// Coefficients of the momentum equation of a face, over the density.
    #[inline(always)]
    pub(crate) fn face_terms(&self, component: usize, p: usize, density: f64, dt: f64) -> FaceTerms {
        let (new, old) = (self.faces.component(component)[p], self.old_faces.component(component)[p]);
        FaceTerms {
            void_fraction: new,
            gradient: self.gradient_factor(component, p),
            capacity: 1.0 / self.inverse.component(component)[p],
            source: self.source.component(component)[p] / density,
            // ∂(εu)/∂t = ε Δu/Δt + u ∂ε/∂t, and the drag on the old velocity.
            friction: (new - old) / dt + self.drag.component(component)[p] / density,
        }
    }

    /// Checks the void fraction and works out what a step needs of it; collective.
    pub(crate) fn prepare(
        &mut self,
        local: &Local,
        tables: &[FaceTable],
        halo: &mut Halo,
        (velocity, density, dt, step): (&Faces, f64, f64, u64),
        transport: &dyn Transport,
    ) -> Result<(), StepError> {
        self.check(local, step, transport)?;
        let [x, y, z] = self.drag.components_mut();
        halo.fill(&mut [self.void_fraction.data_mut(), self.previous.data_mut(), x, y, z], transport);
        for table in tables {
            table.fill_even(&mut self.void_fraction);
            table.fill_even(&mut self.previous);
        }
        let (new, old) = (self.void_fraction.data(), self.previous.data());
        for (p, (middle, rate)) in self.middle.data_mut().iter_mut().zip(self.rate.data_mut()).enumerate() {
            *middle = 0.5 * (new[p] + old[p]);
            *rate = (new[p] - old[p]) / dt;
        }
        for axis in 0..3 {
            to_faces(local, axis, &self.void_fraction, self.faces.component_mut(axis));
            to_faces(local, axis, &self.previous, self.old_faces.component_mut(axis));
            let carried = self.flux.component_mut(axis).iter_mut().zip(self.old_faces.component(axis));
            carried.zip(velocity.component(axis)).for_each(|((q, eps), u)| *q = eps * u);
            let rows = self.inverse.component_mut(axis).iter_mut().zip(self.drag.component(axis));
            for ((inverse, beta), eps) in rows.zip(self.faces.component(axis)) {
                *inverse = 1.0 / (eps / dt + beta / density);
            }
            for p in 0..new.len() {
                let eps = self.faces.component(axis)[p];
                let factor = self.gradient_factor(axis, p);
                self.coefficients.component_mut(axis)[p] =
                    eps * factor * self.inverse.component(axis)[p] / density;
            }
        }
        Ok(())
    }

    fn check(&self, local: &Local, step: u64, transport: &dyn Transport) -> Result<(), StepError> {
        let [nx, ny, nz] = local.layout.cells;
        let mut worst: Option<(f64, [usize; 3])> = None;
        for k in 0..nz {
            for j in 0..ny {
                for (i, &eps) in self.void_fraction.row(j, k).iter().enumerate().take(nx) {
                    if !(eps > 0.0 && eps <= 1.0 + 1e-9) && worst.is_none() {
                        worst = Some((eps, [i, j, k]));
                    }
                }
            }
        }
        // All ranks fail alike; each names its own cell, those without one the first they are told of.
        let found = match worst {
            Some((value, cell)) => {
                let at: [usize; 3] = std::array::from_fn(|a| cell[a] + local.first[a]);
                vec![value, at[0] as f64, at[1] as f64, at[2] as f64]
            }
            None => Vec::new(),
        };
        if !transport.any(worst.is_some()) {
            return Ok(());
        }
        let all = transport.gather(&found);
        let cell = std::array::from_fn(|a| all[a + 1] as usize);
        Err(StepError::VoidFraction { step, value: all[0], cell })
    }

    /// After the step, its end is the next one's beginning.
    pub(crate) fn finish(&mut self) {
        self.begin();
    }

    pub(crate) fn capacity(&self, dt: f64, viscosity: f64) -> Capacity<'_> {
        Capacity {
            inverse: Some(&self.inverse),
            dt,
            void_fraction: Some(self.void_fraction.data()),
            viscosity,
        }
    }
}

/// Linear interpolation of centre values to the upper faces along an axis, wherever both neighbours are in the array.
fn to_faces(local: &Local, axis: usize, centre: &Field<Centre>, faces: &mut [f64]) {
    let (dims, strides) = (local.layout.dims(), local.layout.strides());
    let (stride, m, data) = (strides[axis], &local.axes[axis], centre.data());
    for k in 0..dims[2] {
        for j in 0..dims[1] {
            let start = j * strides[1] + k * strides[2];
            for i in 0..dims[0] {
                let (p, e) = (start + i, [i, j, k][axis]);
                // The last layer has no neighbour above; no stencil reads that face.
                let next = if e + 1 < dims[axis] { data[p + stride] } else { data[p] };
                faces[p] = m.upper_share[e] * data[p] + m.lower_share[e] * next;
            }
        }
    }
}
