//! Temperatures of particles: given, changed by the heat that flows, and accounted for.

use super::state::Dem;
use crate::contacts::PassStatistics;
use crate::error::{StepError, vector};
use crate::heat::{Heat, HeatFlow, HeatPass};
use crate::verlet::VerletLists;
use grains_domain::{ExactSum, Transport, sum_exact};

impl Dem {
    /// Accounts for the heat of the particle that came last.
    pub fn account_heat_of_last(&mut self) {
        if let (Some(thermal), Some(body)) = (&self.setup.thermal, self.particles.bodies.last()) {
            let temperature = self.particles.temperatures.last().copied().unwrap_or(0.0);
            self.heat_ledger.inserted += thermal.capacity(body) * temperature;
        }
    }

    /// Adds the heat that flows through contacts, gaps and from walls at the present positions.
    pub(super) fn conduct(&mut self, statistics: &mut PassStatistics, transport: &impl Transport) {
        let time = self.time();
        let Self { particles, neighbours, setup, states, wall_heat, heated_walls, touching, .. } = self;
        let Some(thermal) = setup.thermal.as_ref().filter(|thermal| self.step.is_multiple_of(thermal.every))
        else {
            return;
        };
        particles.heat_flows.fill(HeatFlow::default());
        wall_heat.fill(0.0);
        let reach = thermal.reach(setup.largest_radius).max(setup.catalogue.contacts.reach());
        let scene = setup.wall_scene(states, time);
        let (catalogue, dt) = (&setup.catalogue, setup.parameters.dt);
        heated_walls.clear();
        let mut pass = HeatPass { thermal, catalogue, dt, of_walls: wall_heat, heated: heated_walls };
        let VerletLists { spheres, sphere_laws, walls, bonds, resting, .. } = neighbours;
        pass.between_spheres(particles, spheres, sphere_laws, reach);
        pass.along_bonds(particles, &bonds.bonds, &setup.bonds);
        pass.through_parts(particles, touching, &scene);
        let done = pass
            .at_walls(particles, walls, &scene, reach)
            .and_then(|()| pass.of_resting(particles, resting, (touching, &scene), reach));
        if let Err(error) = done {
            statistics.error = statistics.error.take().or(Some(error));
        }
        heated_walls.warm(particles, (&setup.walls, thermal), wall_heat, transport);
    }

    /// Temperature (K) of each heated wall; NaN of those that nothing touches, and of other walls.
    pub fn wall_temperatures(&self) -> &[f64] {
        &self.heated_walls.temperatures
    }

    /// Sets the temperature (K) of a heated wall: that of a checkpoint.
    pub fn set_wall_temperature(&mut self, wall: usize, temperature: f64) {
        self.heated_walls.temperatures[wall] = temperature;
    }

    /// Changes temperatures by the heat that flows until it is evaluated again.
    ///
    /// m c dT/dt = Σ G (T_j − T) + ε σ A (Ts⁴ − T⁴) + m q, explicit but for the radiation.
    pub(super) fn heat_up(&mut self) {
        let Self { particles, setup, heat_ledger, wall_heat, error, .. } = self;
        let Some(thermal) = setup.thermal.as_ref().filter(|thermal| self.step.is_multiple_of(thermal.every))
        else {
            return;
        };
        let dt = setup.parameters.dt * thermal.every as f64;
        for (i, flow) in particles.heat_flows.iter().enumerate() {
            let (body, temperature) = (&particles.bodies[i], &mut particles.temperatures[i]);
            let capacity = thermal.capacity(body);
            let [radiated, slope] = thermal.radiation(body, *temperature, &setup.catalogue);
            let radiation = radiated / (1.0 + slope * dt / capacity);
            let produced = body.mass * thermal.sources[usize::from(body.kind.material)];
            let before = *temperature;
            *temperature += dt / capacity * (flow.power + radiation + produced);
            heat_ledger.radiation += dt * radiation;
            heat_ledger.produced += dt * produced;
            let is_stable = flow.conductance * dt <= capacity;
            if !(is_stable && *temperature >= 0.0 && temperature.is_finite()) {
                let share = flow.conductance * dt / capacity;
                let (id, place) = (particles.ids[i], vector(&body.position));
                let found = StepError::Temperature { id, place, before, after: *temperature, share };
                *error = error.take().or(Some(found));
            }
        }
        wall_heat.iter().for_each(|power| heat_ledger.walls.add_product(dt, *power));
    }

    /// Notes the heat that particles have left with.
    pub(super) fn let_heat_leave(&mut self, left: &[u32]) {
        let Self { particles, setup, heat_ledger, .. } = self;
        let Some(thermal) = &setup.thermal else { return };
        for i in left.iter().map(|&i| i as usize) {
            heat_ledger.left += thermal.capacity(&particles.bodies[i]) * particles.temperatures[i];
        }
    }

    /// The heat in the particles and where it came from, over all ranks; none where particles have no temperature.
    pub fn heat(&self, transport: &impl Transport) -> Option<Heat> {
        let thermal = self.setup.thermal.as_ref()?;
        let [mut capacity, mut content] = [ExactSum::default(); 2];
        let mut ends = [f64::NEG_INFINITY; 2];
        for (body, &temperature) in
            self.particles.bodies.iter().zip(&self.particles.temperatures).take(self.particles.owned)
        {
            let own = thermal.capacity(body);
            capacity += own;
            content += own * temperature;
            ends = [ends[0].max(-temperature), ends[1].max(temperature)];
        }
        let mut sums = [capacity, content].into_iter().chain(self.heat_ledger.sums()).collect::<Vec<_>>();
        sum_exact(&mut sums, transport);
        transport.max(&mut ends);
        let total = |k: usize| sums[k].total();
        let [capacity, content] = [total(0), total(1)];
        let is_empty = capacity == 0.0;
        Some(Heat {
            mean: if is_empty { 0.0 } else { content / capacity },
            ends: if is_empty { [0.0; 2] } else { [-ends[0], ends[1]] },
            content,
            ledger: std::array::from_fn(|k| total(2 + k)),
        })
    }

    /// Heat from each wall into particles (W), over all ranks.
    pub fn wall_heat(&self, transport: &impl Transport) -> Vec<f64> {
        let mut sums = self.wall_heat.clone();
        transport.sum(&mut sums);
        sums
    }
}
