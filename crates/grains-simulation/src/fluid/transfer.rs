//! Heat and mass between particles smaller than the cells and the scalars of the fluid.
//!
//! The fluid gets K (φ_p − φ) of each particle in its step, φ taken at the end of it, and particles get the same once the step is done.
//! Temperatures of particles relax exactly towards that of the fluid, so that no step is too long and nothing overshoots.

use grains_case::{Evaporation, Fluid as CaseFluid, ParticleTransfer, Scalar as CaseScalar, ScalarKind};
use grains_coupling::{Coupling, Passing, TransferLaw, TransferLink};
use grains_dem::{Body, HeatLedger, Particles, SpeciesLedger, Thermal};

/// What one scalar of the fluid exchanges with particles.
#[derive(Clone, Debug)]
pub struct Transfer {
    /// Number of the scalar.
    pub scalar: usize,
    law: TransferLaw,
    /// Prandtl or Schmidt number (-).
    prandtl: f64,
    /// Diffusivity of the scalar (m²/s).
    diffusivity: f64,
    with: With,
    /// Links of the particles in this step.
    pub links: Vec<TransferLink>,
}

/// What it is in the particle that exchanges.
#[derive(Clone, Copy, Debug)]
enum With {
    /// Its temperature; heat per volume of fluid and kelvin (J/(m³ K)).
    Temperature { capacity: f64 },
    /// A first-order reaction: rate (1/s), diffusivity in the particle (m²/s) if that hinders, heat released per amount (J).
    Reaction { rate: f64, diffusivity: Option<f64>, heat: f64 },
    /// What is in solution, of species `species` of the particles.
    Uptake { species: usize, partition: f64 },
    /// Liquid, species `species` of the particles.
    Evaporation { species: usize, evaporation: Evaporation },
}

/// What changes of particles.
pub struct Changed<'a> {
    pub bodies: &'a [Body],
    pub temperatures: &'a mut [f64],
    pub thermal: Option<&'a Thermal>,
    pub heat_ledger: &'a mut HeatLedger,
    /// Amounts of all species, particle by particle, and their ledgers.
    pub amounts: &'a mut [f64],
    pub species_ledgers: &'a mut [SpeciesLedger],
}

impl Changed<'_> {
    fn add(&mut self, i: usize, species: usize, gain: f64) {
        self.amounts[i * self.species_ledgers.len() + species] += gain;
        self.species_ledgers[species].fluid += gain;
    }
}

impl Transfer {
    /// Those of a case.
    pub fn all(fluid: &CaseFluid) -> Vec<Self> {
        let mut species = 0;
        let of = |(number, scalar): (usize, &CaseScalar)| {
            let ParticleTransfer { law, reaction, uptake, evaporation, .. } = scalar.particles.clone()?;
            let law = law?;
            let own = species;
            species += usize::from(uptake.is_some() || evaporation.is_some());
            let diffusivity = scalar.diffusivity(fluid.density);
            let with = match (&scalar.kind, reaction) {
                (ScalarKind::Temperature { .. }, _) => {
                    With::Temperature { capacity: scalar.capacity(fluid.density) }
                }
                (_, Some(reaction)) => With::Reaction {
                    rate: reaction.rate,
                    diffusivity: reaction.diffusivity,
                    heat: reaction.heat,
                },
                (_, None) => match (uptake, evaporation) {
                    (Some(uptake), _) => With::Uptake { species: own, partition: uptake.partition },
                    (None, Some(evaporation)) => With::Evaporation { species: own, evaporation },
                    (None, None) => return None,
                },
            };
            let prandtl = fluid.viscosity / (fluid.density * diffusivity);
            Some(Self { scalar: number, law, prandtl, diffusivity, with, links: Vec::new() })
        };
        fluid.scalar.iter().enumerate().filter_map(of).collect()
    }

    /// Finds the links of all owned particles for a step `dt` (s) of the fluid; `passings` has the Reynolds number and the void fraction
    /// of each.
    pub fn link(
        &mut self,
        coupling: &Coupling,
        (particles, thermal): (&Particles, Option<&Thermal>),
        passings: &[[f64; 2]],
        dt: f64,
    ) {
        self.links.clear();
        for (i, &[reynolds, void_fraction]) in passings.iter().enumerate() {
            let body = &particles.bodies[i];
            let passing = Passing { reynolds, prandtl: self.prandtl, void_fraction };
            let area = coupling.area(body);
            let film =
                self.law.nusselt(&passing) * self.diffusivity * area / coupling.equivalent_diameter(body);
            self.links.push(match self.with {
                With::Temperature { capacity } => {
                    let of_body = thermal.map_or(f64::INFINITY, |thermal| thermal.capacity(body) / capacity);
                    TransferLink::following(film, particles.temperatures[i], of_body, dt)
                }
                With::Uptake { species, partition } => {
                    let capacity = coupling.volume(body) * partition;
                    TransferLink::following(film, particles.amounts_of(i)[species] / capacity, capacity, dt)
                }
                With::Evaporation { species, evaporation } => {
                    // No more than there is leaves, even into dry gas.
                    let value = evaporation.saturation(particles.temperatures[i]);
                    let most = particles.amounts_of(i)[species] / (value * dt);
                    TransferLink { coefficient: film.min(most), value }
                }
                With::Reaction { rate, diffusivity, .. } => {
                    let volume = coupling.volume(body);
                    let effectiveness = diffusivity.map_or(1.0, |diffusivity| {
                        grains_coupling::effectiveness(volume / area * (rate / diffusivity).sqrt())
                    });
                    let inside = effectiveness * rate * volume;
                    let coefficient = if inside > 0.0 { 1.0 / (1.0 / film + 1.0 / inside) } else { 0.0 };
                    TransferLink { coefficient, value: 0.0 }
                }
            });
        }
    }

    /// Gives a particle what it got in a step `dt` (s), the scalar being at `mean` around it.
    pub fn give(&self, i: usize, mean: f64, changed: &mut Changed, dt: f64) {
        let gain = self.links[i].gain(mean, dt);
        let heat = match self.with {
            With::Temperature { capacity } => gain * capacity,
            With::Reaction { heat, .. } => gain * heat,
            With::Uptake { species, .. } => {
                changed.add(i, species, gain);
                0.0
            }
            With::Evaporation { species, evaporation } => {
                changed.add(i, species, gain);
                gain * evaporation.latent_heat
            }
        };
        let Some(thermal) = changed.thermal.filter(|_| heat != 0.0) else { return };
        changed.temperatures[i] += heat / thermal.capacity(&changed.bodies[i]);
        match self.with {
            With::Temperature { .. } => changed.heat_ledger.fluid += heat,
            _ => changed.heat_ledger.produced += heat,
        }
    }
}
