//! Scalars of a flow: how it gets and carries them, and how they move it.

use super::advance::Surroundings;
use super::conditions::FaceConditions;
use super::{Scalar, ScalarSetup, Scalars};
use crate::flow::sample;
use crate::metrics::Local;
use crate::momentum::RowPlace;
use crate::{Field, Flow};
use grains_domain::Transport;

impl Flow {
    /// Lets the fluid carry a scalar, of which `value` is that at a position (m); returns its number. Collective.
    pub fn add_scalar(
        &mut self,
        setup: ScalarSetup,
        value: impl Fn([f64; 3]) -> f64,
        transport: &dyn Transport,
    ) -> usize {
        let (grid, local) = (&self.setup.grid, &self.local);
        let scalars = self.scalars.get_or_insert_with(|| Scalars::new(grid, &self.setup.partition, local));
        let mut field = Field::new(local.layout);
        sample(grid, local, &mut field, value);
        self.halo.fill(&mut [field.data_mut()], transport);
        let of_flow = (&self.boundary_data[..], &self.setup.boundaries);
        let conditions = FaceConditions::all((grid, local), of_flow, &setup.boundaries);
        scalars.all.push(Scalar {
            setup,
            previous: field.clone(),
            value: field,
            source: None,
            exchange: None,
            entered: 0.0,
            produced: 0.0,
            conditions,
        });
        scalars.set_volumes(local, self.mixture.as_ref().map(|mixture| &mixture.previous));
        scalars.all.len() - 1
    }

    /// Begins the accounts of the scalars with what is there.
    pub fn begin_scalars(&mut self) {
        let Some(scalars) = &mut self.scalars else { return };
        scalars.set_volumes(&self.local, self.mixture.as_ref().map(|mixture| &mixture.previous));
        for number in 0..scalars.all.len() {
            let content = scalars.content(number);
            (scalars.all[number].entered, scalars.all[number].produced) = (content, 0.0);
        }
    }

    /// Fills the halos of the scalars, and takes the volumes of fluid as they are; collective.
    pub(crate) fn synchronise_scalars(&mut self, transport: &dyn Transport) {
        let Some(scalars) = &mut self.scalars else { return };
        scalars.set_volumes(&self.local, self.mixture.as_ref().map(|mixture| &mixture.previous));
        for scalar in &mut scalars.all {
            self.halo.fill(&mut [scalar.value.data_mut(), scalar.previous.data_mut()], transport);
        }
    }

    /// Carries the scalars by the velocity at the end of a step; collective.
    pub(crate) fn carry_scalars(&mut self, dt: f64, transport: &dyn Transport) {
        let Some(scalars) = &mut self.scalars else { return };
        let open = self.mixture.as_ref().map(|mixture| (mixture.open_faces(), &mixture.previous));
        let around = Surroundings {
            local: &self.local,
            halo: &mut self.halo,
            velocity: &self.state.velocity,
            open,
            time: self.state.time,
            dt,
        };
        scalars.advance(around, transport);
    }

    /// Begins the next step of a mixture with the volumes of fluid that the fluxes of this one have left: what a pressure solver leaves
    /// undone the next step does.
    pub(crate) fn keep_volumes(&mut self) {
        let (Some(scalars), Some(mixture)) = (&self.scalars, &mut self.mixture) else { return };
        scalars.give_volumes(&self.local, &mut mixture.previous);
    }
}

/// Adds to a row of velocities what scalars do to the fluid in a step, of which a force per mass makes the factor (s).
pub(crate) fn add_buoyancy(
    scalars: Option<&Scalars>,
    local: &Local,
    place: RowPlace,
    out: &mut [f64],
    factor: impl Fn(usize) -> f64,
) {
    let (component, start) = (place.component, local.layout.row(place.j, place.k));
    let (m, stride) = (&local.axes[component], local.layout.strides()[component]);
    for scalar in scalars.iter().flat_map(|scalars| &scalars.all) {
        let Some(buoyancy) = scalar.setup.buoyancy.filter(|b| b.gravity[component] != 0.0) else { continue };
        let value = scalar.value.data();
        let strength = -buoyancy.expansion * buoyancy.gravity[component];
        for (i, out) in out.iter_mut().enumerate() {
            let (p, e) = (start + i, local.entry([i, place.j, place.k][component]));
            let on_face = m.upper_share[e] * value[p] + m.lower_share[e] * value[p + stride];
            *out += factor(i) * strength * (on_face - buoyancy.reference);
        }
    }
}
