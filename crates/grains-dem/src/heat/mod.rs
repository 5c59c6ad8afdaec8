//! Temperatures of particles, and the heat between those that touch or are near.
//!
//! Every particle has one temperature. A flow of heat between two of them is rounded to a quantum of which sums are exact, as forces
//! are, and what one gets the other loses. The temperature travels to clones with their position.

mod flows;
mod heated_walls;
mod ledger;
mod pass;

pub(crate) use flows::HeatFlow;
pub(crate) use heated_walls::HeatedWalls;
pub use ledger::{Heat, HeatLedger};
pub(crate) use pass::{HeatPass, TouchingParts};

use crate::catalogue::Catalogue;
use crate::particles::Body;
use grains_contact::{Conduction, GasLens};
use grains_domain::Quantum;
use heated_walls::TwoQuanta;

/// Stefan-Boltzmann constant σ (W/(m² K⁴)).
const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;

/// What temperatures of particles depend on.
#[derive(Clone, Debug)]
pub struct Thermal {
    /// Specific heat capacity c (J/(kg K)) of each material of particles; 0 of others.
    pub heat_capacities: Vec<f64>,
    /// Emissivity (-) of each material.
    pub emissivities: Vec<f64>,
    /// Heat produced per mass of each material (W/kg).
    pub sources: Vec<f64>,
    /// Area of the surface of each shape at scale 1 (m²).
    pub areas: Vec<f64>,
    conduction: Vec<Option<Conduction>>,
    /// Gas around contacts of spheres.
    pub lens: Option<GasLens>,
    /// Conductivity (W/(m K)) of each material, where heat passes through spheres to the gas; infinite where these have one temperature.
    pub conductivities: Vec<f64>,
    /// Steps from one evaluation of the heat to the next.
    pub every: u64,
    /// Temperature (K) of the surroundings with which particles exchange radiation.
    pub surroundings: Option<f64>,
    quantum: Quantum,
    /// For sums over all contacts with a wall.
    of_conductances: TwoQuanta,
    of_flows: TwoQuanta,
}

/// Temperature (K) up to which flows of heat are summed exactly.
const HOTTEST: f64 = 2e4;

impl Thermal {
    /// That of a number of materials of which nothing is known yet, with particles up to a radius (m).
    pub fn new(materials: usize, lens: Option<GasLens>, surroundings: Option<f64>) -> Self {
        Self {
            areas: Vec::new(),
            conductivities: vec![f64::INFINITY; materials],
            heat_capacities: vec![0.0; materials],
            emissivities: vec![0.0; materials],
            sources: vec![0.0; materials],
            conduction: vec![None; materials * materials],
            lens,
            every: 1,
            surroundings,
            quantum: Quantum::for_sums_below(1.0),
            of_conductances: TwoQuanta::for_terms_below(1.0),
            of_flows: TwoQuanta::for_terms_below(1.0),
        }
    }

    /// Sets how two materials conduct heat into each other.
    pub fn set_conduction(&mut self, [a, b]: [usize; 2], conduction: Conduction) {
        let materials = self.heat_capacities.len();
        self.conduction[a * materials + b] = Some(conduction);
        self.conduction[b * materials + a] = Some(conduction);
    }

    /// How two materials conduct heat into each other.
    #[inline(always)]
    pub fn conduction(&self, a: u16, b: u16) -> Option<&Conduction> {
        self.conduction[usize::from(a) * self.heat_capacities.len() + usize::from(b)].as_ref()
    }

    /// Sum of 1/k (m K/W) of the spheres of a pair, of which the second may be a wall.
    #[inline]
    pub(crate) fn resistivity(&self, [a, b]: [u16; 2], at_wall: bool) -> f64 {
        let [own, other] = [a, b].map(|material| 1.0 / self.conductivities[usize::from(material)]);
        if at_wall { own } else { own + other }
    }

    /// Chooses the quantum of flows of heat for bodies up to this bounding radius (m): sums of the flows through a hundred contacts as
    /// wide as the largest body are exact.
    pub(crate) fn prepare(&mut self, largest_radius: f64) {
        let conductivity = self.conduction.iter().flatten().map(|c| c.conductivity).fold(0.0, f64::max);
        let of_lens = self.lens.map_or(0.0, |lens| {
            lens.conductance(0.0, [largest_radius; 2], 0.0, 0.0).max(lens.conductivity * largest_radius)
        });
        let conductance = conductivity * largest_radius + of_lens;
        let of_hundred = (400.0 * conductance).max(f64::MIN_POSITIVE * 1e30);
        self.quantum = Quantum::for_sums_below(of_hundred * HOTTEST);
        self.of_conductances = TwoQuanta::for_terms_below(of_hundred);
        self.of_flows = TwoQuanta::for_terms_below(of_hundred * HOTTEST);
    }

    /// Heat capacity m c (J/K) of a body.
    #[inline(always)]
    pub fn capacity(&self, body: &Body) -> f64 {
        body.mass * self.heat_capacities[usize::from(body.kind.material)]
    }

    /// Area (m²) of the surface of a body.
    #[inline]
    pub fn area(&self, body: &Body, catalogue: &Catalogue) -> f64 {
        let scale = body.radius / catalogue.shape(body.kind).bounding_radius;
        self.areas[usize::from(body.kind.shape)] * (scale * scale)
    }

    /// Heat (W) that a body at a temperature (K) gets by radiation, and its derivative −dQ/dT (W/K).
    ///
    /// Q = ε σ A (Ts⁴ − T⁴), with the area A of its surface.
    pub(crate) fn radiation(&self, body: &Body, temperature: f64, catalogue: &Catalogue) -> [f64; 2] {
        let Some(surroundings) = self.surroundings else { return [0.0; 2] };
        let emissivity = self.emissivities[usize::from(body.kind.material)];
        let factor = emissivity * STEFAN_BOLTZMANN * self.area(body, catalogue);
        [factor * (surroundings.powi(4) - temperature.powi(4)), 4.0 * factor * temperature.powi(3)]
    }

    /// Largest gap (m) over which bodies up to a radius (m) exchange heat.
    pub fn reach(&self, radius: f64) -> f64 {
        self.lens.map_or(0.0, |lens| lens.reach(radius))
    }
}
