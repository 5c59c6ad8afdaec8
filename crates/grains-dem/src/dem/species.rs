//! What particles are made of beside their material: amounts of species that they exchange with a fluid.

use super::state::Dem;
use grains_domain::{ExactSum, Transport, sum_exact};

/// A species that particles contain.
#[derive(Clone, Debug, PartialEq)]
pub struct Species {
    /// Its name.
    pub name: String,
    /// Unit of the amount.
    pub unit: &'static str,
    /// Amount per volume of a particle that is inserted (1/m³).
    pub initial: f64,
    /// Whether the particle does not keep it: the fluid tells it at each of its steps.
    pub is_told: bool,
}

/// Amounts of a species in and out of the particles of one rank.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpeciesLedger {
    /// In particles when they were inserted.
    pub inserted: ExactSum,
    /// In particles that left through outlets.
    pub left: ExactSum,
    /// From the fluid.
    pub fluid: ExactSum,
}

impl SpeciesLedger {
    /// The sums, in the order above.
    pub fn sums(&self) -> [ExactSum; 3] {
        [self.inserted, self.left, self.fluid]
    }

    /// The ledger of these sums.
    pub fn from_sums([inserted, left, fluid]: [ExactSum; 3]) -> Self {
        Self { inserted, left, fluid }
    }

    /// Adds what another ledger has.
    pub fn add(&mut self, other: &Self) {
        self.inserted.add(&other.inserted);
        self.left.add(&other.left);
        self.fluid.add(&other.fluid);
    }
}

/// A species in the particles, over all ranks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpeciesContent {
    /// Amount in all particles.
    pub content: f64,
    /// Smallest and largest amount in a particle.
    pub ends: [f64; 2],
    /// Inserted, left, and from the fluid.
    pub ledger: [f64; 3],
}

impl SpeciesContent {
    /// Amount that nothing accounts for.
    pub fn unaccounted(&self) -> f64 {
        let [inserted, left, fluid] = self.ledger;
        self.content - (inserted - left + fluid)
    }
}

impl Dem {
    /// Gives the particle that came last the amounts with which particles are inserted.
    pub fn fill_last(&mut self) {
        let Some(body) = self.particles.bodies.last() else { return };
        let volume = self.setup.catalogue.volume(body);
        let amounts: Vec<f64> = self.setup.species.iter().map(|species| species.initial * volume).collect();
        self.particles.set_last_amounts(&amounts);
        for (ledger, amount) in self.species_ledgers.iter_mut().zip(amounts) {
            ledger.inserted += amount;
        }
    }

    /// Gives the particle restored last one of its amounts.
    pub fn restore_amount(&mut self, species: usize, amount: f64) {
        let last = self.particles.amounts.len() - self.setup.species.len();
        let inserted = std::mem::replace(&mut self.particles.amounts[last + species], amount);
        self.species_ledgers[species].inserted += -inserted;
    }

    /// Notes the amounts that particles have left with.
    pub(super) fn let_species_leave(&mut self, left: &[u32]) {
        for &i in left {
            for (ledger, amount) in self.species_ledgers.iter_mut().zip(self.particles.amounts_of(i as usize))
            {
                ledger.left += *amount;
            }
        }
    }

    /// The species in the particles and where they came from, over all ranks.
    pub fn species(&self, transport: &impl Transport) -> Vec<SpeciesContent> {
        let count = self.setup.species.len();
        let of = |k: usize| {
            let amounts = self.particles.amounts.iter().skip(k).step_by(count);
            let mut ends =
                amounts.clone().fold([f64::NEG_INFINITY; 2], |[low, high], x| [low.max(-x), high.max(*x)]);
            let mut content = ExactSum::default();
            amounts.for_each(|amount| content += *amount);
            let mut sums = [content].into_iter().chain(self.species_ledgers[k].sums()).collect::<Vec<_>>();
            sum_exact(&mut sums, transport);
            transport.max(&mut ends);
            let total = |k: usize| sums[k].total();
            let (content, ledger) = (total(0), [total(1), total(2), total(3)]);
            let ends = if ends[1] == f64::NEG_INFINITY { [0.0; 2] } else { [-ends[0], ends[1]] };
            SpeciesContent { content, ends, ledger }
        };
        (0..count).map(of).collect()
    }
}
