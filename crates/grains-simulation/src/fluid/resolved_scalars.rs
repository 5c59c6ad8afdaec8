//! Scalars of the fluid and the particles that the grid resolves: values that these have, and what the fluid tells them.

use super::resolved::ResolvedBodies;
use crate::species::told;
use grains_case::{Fluid as CaseFluid, Scalar as CaseScalar};
use grains_comm::MpiTransport;
use grains_dem::Dem;
use grains_fluid::Flow;

/// What resolved particles exchange with one scalar.
#[derive(Clone, Debug)]
pub struct BodyScalar {
    /// Number of the scalar.
    scalar: usize,
    /// What a volume of fluid holds per unit (J/(m³ K), or 1).
    capacity: f64,
    /// What it is that bodies are told.
    told: Told,
    /// Number of the first species that is told.
    species: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Told {
    /// The flow into a body.
    Flow,
    /// That too, which warms it; and the heat that it has not taken yet.
    Heat,
    /// What it holds and what reacts in it.
    Inside,
}

impl BodyScalar {
    /// Those of a case.
    pub fn all(fluid: &CaseFluid) -> Vec<Self> {
        let mut species = 0;
        let of = |(number, scalar): (usize, &CaseScalar)| {
            let first = species;
            species += told(fluid, scalar).len();
            let particles = scalar.particles.as_ref()?;
            let told = match (particles.uniform, particles.inside.is_some()) {
                (true, _) => Told::Heat,
                (false, true) => Told::Inside,
                (false, false) => Told::Flow,
            };
            Some(Self { scalar: number, capacity: scalar.capacity(fluid.density), told, species: first })
        };
        fluid.scalar.iter().enumerate().filter_map(of).collect()
    }
}

impl ResolvedBodies {
    /// Values of the own particles for each scalar of the flow.
    fn values(&self, dem: &Dem, flow: &Flow) -> Vec<Vec<f64>> {
        let mut values = vec![Vec::new(); flow.scalars.as_ref().map_or(0, |scalars| scalars.all.len())];
        for scalar in self.scalars.iter().filter(|scalar| scalar.told == Told::Heat) {
            values[scalar.scalar] = dem.particles.temperatures[..dem.particles.owned].to_vec();
        }
        values
    }

    /// Tells the scalars where particles and walls are, and what they are at; collective.
    pub(super) fn place_for_scalars(&self, dem: &Dem, flow: &mut Flow, transport: &MpiTransport) {
        if flow.scalars.is_some() {
            let shapes = &dem.setup.catalogue.shapes[..];
            let there = self.bodies.on_walls.iter().map(|on_wall| on_wall.wall);
            let all = self.walls.all();
            let numbers: Vec<usize> =
                there.filter_map(|number| all.iter().position(|wall| wall.number as u64 == number)).collect();
            self.bodies.place_for_scalars((shapes, &numbers), &self.values(dem, flow), flow, transport);
        }
    }

    /// Tells particles what they got of the scalars in a step of the fluid `dt` (s); collective.
    pub fn after_scalars(&self, dem: &mut Dem, flow: &mut Flow, dt: f64, transport: &MpiTransport) {
        let Some(scalars) = &flow.scalars else { return };
        for scalar in &self.scalars {
            let found = &scalars.all[scalar.scalar];
            let inside = match scalar.told {
                Told::Inside => scalars.content_of_solids(scalar.scalar),
                Told::Heat => scalars.responses(scalar.scalar, dt),
                Told::Flow => vec![0.0; found.gained.len()],
            };
            let parts = found.gained.iter().zip(&found.reacted).zip(&inside);
            let parts = parts.map(|((gained, reacted), inside)| [-gained, *reacted, *inside]).collect();
            let sums = self.bodies.sum_over_bodies(parts, transport);
            for (i, [got, reacted, inside]) in sums.into_iter().enumerate() {
                let [got, reacted, inside] = [got, reacted, inside].map(|x| x * scalar.capacity);
                let (first, count) = (scalar.species, dem.setup.species.len());
                let told = &mut dem.particles.amounts[i * count + first..];
                match scalar.told {
                    Told::Flow => told[0] = got / dt,
                    Told::Inside => (told[0], told[1]) = (inside, reacted / dt),
                    Told::Heat => {
                        let due = got + told[1];
                        let Some(thermal) = &dem.setup.thermal else { continue };
                        let capacity = thermal.capacity(&dem.particles.bodies[i]);
                        // A body lighter than what the fluid can give it in a step would swing about its temperature: the rest waits.
                        let taken =
                            if capacity.is_finite() { due / (inside / capacity).max(1.0) } else { 0.0 };
                        (told[0], told[1]) = (got / dt, if capacity.is_finite() { due - taken } else { 0.0 });
                        dem.particles.temperatures[i] += taken / capacity;
                        dem.heat_ledger.fluid += taken;
                    }
                }
            }
        }
        if self.is_fixed {
            // Those that move are placed anew.
            for scalar in self.scalars.iter().filter(|scalar| scalar.told == Told::Heat) {
                let own = &dem.particles.temperatures[..dem.particles.owned];
                self.bodies.tell_scalar(scalar.scalar, own, flow, transport);
            }
        }
    }
}
