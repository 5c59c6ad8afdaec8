//! Scalars of a flow: how it gets and carries them, and how they move it.

use super::advance::CarrierFlow;
use super::conditions::FaceConditions;
use super::{BEYOND, Scalar, ScalarSetup, Scalars};
use crate::flow::sample;
use crate::metrics::Local;
use crate::momentum::RowPlace;
use crate::{Field, Flow, March, Phase, StepError};
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
        let of_flow = (&self.boundary_data[..], &self.setup.boundaries);
        let conditions = FaceConditions::all((grid, local), of_flow, &setup.boundaries);
        scalars.all.push(Scalar {
            setup,
            previous: field.clone(),
            value: field,
            source: None,
            exchange: None,
            divided: None,
            of_solids: Vec::new(),
            gained: Vec::new(),
            reacted: Vec::new(),
            gained_over: 0.0,
            entered: 0.0,
            produced: 0.0,
            conditions,
            free: None,
            barrier: None,
        });
        let number = scalars.all.len() - 1;
        self.synchronise_scalars(transport);
        number
    }

    /// Begins the accounts of some scalars, by their numbers, with what is there.
    pub fn begin_scalars(&mut self, which: impl Fn(usize) -> bool) {
        let Some(scalars) = &mut self.scalars else { return };
        scalars.set_volumes(&self.local, self.mixture.as_ref().map(|mixture| &mixture.previous));
        for number in (0..scalars.all.len()).filter(|&number| which(number)) {
            let content = scalars.content(number);
            (scalars.all[number].entered, scalars.all[number].produced) = (content, 0.0);
        }
    }

    /// Accounts for what particles that came or went since the last step did to the scalars: to be called before their state is read.
    pub fn settle_scalars(&mut self) {
        if let (Some(scalars), Some(mixture)) = (&mut self.scalars, &self.mixture) {
            scalars.take_volumes(&self.local, &mixture.previous);
        }
    }

    /// Fills the halos of the scalars, and takes the volumes of fluid as they are; collective.
    pub(crate) fn synchronise_scalars(&mut self, transport: &dyn Transport) {
        let Some(scalars) = &mut self.scalars else { return };
        let strides = self.local.layout.strides();
        scalars.set_volumes(&self.local, self.mixture.as_ref().map(|mixture| &mixture.previous));
        for scalar in &mut scalars.all {
            scalar.fill(&mut self.halo, transport);
            scalar.conditions.iter().for_each(|face| face.continue_beyond(scalar.value.data_mut(), strides));
        }
    }

    /// Carries the scalars by the velocity at the end of a step that marches in time; those of a steady flow wait for it. Collective.
    pub(crate) fn carry_along(&mut self, dt: f64, transport: &dyn Transport) -> Result<(), StepError> {
        if self.march == March::Time { self.carry_scalars(dt, transport) } else { Ok(()) }
    }

    /// Lets the scalars settle in a flow that stays as it is, each cell at its own pace, from a step `dt` (s) on; collective.
    ///
    /// Velocities that bodies were given after the last step leave sources in cells beside them, which are taken out first: a source of
    /// a thousandth of what flows changes 300 K by 0.3 K.
    ///
    /// # Errors
    /// Pressures that were not found, and steps that empty cells.
    pub fn settle_scalars_from(&mut self, dt: f64, transport: &dyn Transport) -> Result<(), StepError> {
        if self.immersed.is_some() {
            self.project(dt, transport)?;
        }
        self.with_carrier(dt, |scalars, carrier| scalars.settle_at_own_pace(carrier, transport))
    }

    /// Carries the scalars by the velocity at the end of a step; collective.
    fn carry_scalars(&mut self, dt: f64, transport: &dyn Transport) -> Result<(), StepError> {
        let Some(scalars) = &mut self.scalars else { return Ok(()) };
        for scalar in &mut scalars.all {
            // What solids covered and left since the step before belongs to this one.
            if scalar.gained_over > 0.0 {
                scalar.gained.fill(0.0);
                scalar.reacted.fill(0.0);
            }
            scalar.gained_over = dt;
        }
        self.with_carrier(dt, |scalars, carrier| scalars.advance(carrier, transport))
    }

    /// Hands the scalars to a job with the flow that carries them over a step `dt` (s).
    fn with_carrier(
        &mut self,
        dt: f64,
        job: impl FnOnce(&mut Scalars, CarrierFlow<'_>) -> Result<(), f64>,
    ) -> Result<(), StepError> {
        let Some(scalars) = &mut self.scalars else { return Ok(()) };
        let carrier = CarrierFlow {
            grid: &self.setup.grid,
            local: &self.local,
            halo: &mut self.halo,
            velocity: &self.state.velocity,
            immersed: self.immersed.as_ref(),
            open: self.mixture.as_ref().map(|mixture| (mixture.open_faces(), &mixture.previous)),
            time: self.state.time,
            dt,
        };
        let step = self.state.step;
        job(scalars, carrier).map_err(|parts| StepError::Scalars { step, parts })
    }

    /// Carries the scalars alone for a step `dt` (s) by a flow that stays as it is; collective.
    ///
    /// # Errors
    /// Steps that empty cells.
    pub fn step_scalars(&mut self, dt: f64, transport: &dyn Transport) -> Result<(), StepError> {
        self.clock.start();
        self.carry_scalars(dt, transport)?;
        self.clock.book(Phase::Scalars);
        self.state.time += dt;
        self.state.step += 1;
        Ok(())
    }

    /// Begins the next step of a mixture with the volumes of fluid that the fluxes of this one have left: what a pressure solver leaves
    /// undone the next step does.
    pub(crate) fn keep_volumes(&mut self) {
        let (Some(scalars), Some(mixture)) = (&self.scalars, &mut self.mixture) else { return };
        scalars.give_volumes(&self.local, &mut mixture.previous);
    }
}

impl Scalars {
    /// Acceleration (m/s²) of the fluid along `component` by buoyancy, −Σ β (φ − φ₀) g, φ of a face at a place that is the upper one of a
    /// cell with this number along the axis, from −1 on.
    pub(crate) fn acceleration(&self, local: &Local, component: usize, place: usize, cell: isize) -> f64 {
        let (m, stride) = (&local.axes[component], local.layout.strides()[component]);
        let e = (cell + local.layout.halo as isize) as usize;
        let of_scalar = |scalar: &Scalar| {
            let Some(buoyancy) = scalar.setup.buoyancy else { return 0.0 };
            let value = scalar.value.data();
            let holder = self.solids.as_ref().map(|solids| &solids.holder);
            // Solids are not moved by what fluid would be in their place.
            let rise = |place: usize| match holder {
                Some(holder) if holder[place] != 0 && holder[place] != BEYOND => 0.0,
                _ => value[place] - buoyancy.reference,
            };
            let on_face = m.upper_share[e] * rise(place) + m.lower_share[e] * rise(place + stride);
            -buoyancy.expansion * buoyancy.gravity[component] * on_face
        };
        self.all.iter().map(of_scalar).sum()
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
    let is_moving = |scalar: &Scalar| scalar.setup.buoyancy.is_some();
    let Some(scalars) = scalars.filter(|scalars| scalars.all.iter().any(is_moving)) else { return };
    let start = local.layout.row(place.j, place.k);
    for (i, out) in out.iter_mut().enumerate() {
        let cell = [i, place.j, place.k][place.component] as isize;
        *out += factor(i) * scalars.acceleration(local, place.component, start + i, cell);
    }
}
