//! Walls that give a heat to the particles that touch them.
//!
//! Such a wall conducts well: it has the one temperature T at which Σ G_i (T − T_i) is its heat P, so T = (P + Σ G_i T_i)/Σ G_i.

use super::Thermal;
use super::flows::from_wall;
use crate::particles::Particles;
use crate::walls::{Wall, WallHeat};
use grains_domain::{Quantum, Transport};

/// A contact of an owned particle with a heated wall.
#[derive(Clone, Copy, Debug)]
struct HeatedContact {
    wall: u16,
    particle: u32,
    /// Conductance G (W/K).
    conductance: f64,
}

/// The heated walls of a run, and what touches them.
#[derive(Clone, Debug, Default)]
pub(crate) struct HeatedWalls {
    contacts: Vec<HeatedContact>,
    /// Of each wall Σ G (W/K) and Σ G T (W), coarse and fine parts.
    sums: Vec<f64>,
    /// Temperature of each wall (K); NaN of those that nothing touches, and of those that are not heated.
    pub(crate) temperatures: Vec<f64>,
}

/// Sums that are exact for 2²⁶ contacts, in any order: multiples of a coarse quantum, and what they leave.
#[derive(Clone, Copy, Debug)]
pub(super) struct TwoQuanta {
    coarse: Quantum,
    fine: Quantum,
}

impl TwoQuanta {
    /// Those of terms below a limit.
    pub(super) fn for_terms_below(limit: f64) -> Self {
        let coarse = Quantum::for_sums_below(limit * f64::from(1 << 26));
        Self { coarse, fine: Quantum::for_sums_below(limit) }
    }

    fn split(&self, x: f64) -> [f64; 2] {
        let coarse = self.coarse.round(x);
        [coarse, self.fine.round(x - coarse)]
    }
}

impl HeatedWalls {
    /// None are touched yet.
    pub(crate) fn new(walls: usize) -> Self {
        Self { temperatures: vec![f64::NAN; walls], ..Self::default() }
    }

    /// Begins to note contacts.
    pub(crate) fn clear(&mut self) {
        self.contacts.clear();
    }

    /// Notes a contact of an owned particle through a conductance (W/K).
    pub(super) fn note(&mut self, wall: u16, particle: usize, conductance: f64) {
        self.contacts.push(HeatedContact { wall, particle: particle as u32, conductance });
    }

    /// Finds the temperatures of the walls and lets their heat flow, which is added to what comes from each (W); collective.
    pub(crate) fn warm(
        &mut self,
        particles: &mut Particles,
        (walls, thermal): (&[Wall], &Thermal),
        of_walls: &mut [f64],
        transport: &impl Transport,
    ) {
        if !walls.iter().any(|wall| matches!(wall.heat, Some(WallHeat::Power(_)))) {
            return;
        }
        self.sums.clear();
        self.sums.resize(4 * walls.len(), 0.0);
        for contact in &self.contacts {
            let temperature = particles.temperatures[contact.particle as usize];
            let sums = &mut self.sums[4 * usize::from(contact.wall)..][..4];
            let conductance = thermal.of_conductances.split(contact.conductance);
            let product = thermal.of_flows.split(contact.conductance * temperature);
            sums.iter_mut().zip(conductance.into_iter().chain(product)).for_each(|(sum, part)| *sum += part);
        }
        transport.sum(&mut self.sums);
        for (k, wall) in walls.iter().enumerate() {
            if let Some(WallHeat::Power(power)) = wall.heat {
                let [coarse, fine, product_coarse, product_fine] =
                    [0, 1, 2, 3].map(|part| self.sums[4 * k + part]);
                let conductance = coarse + fine;
                self.temperatures[k] = match conductance > 0.0 {
                    true => (power + (product_coarse + product_fine)) / conductance,
                    false => f64::NAN,
                };
            }
        }
        for contact in &self.contacts {
            let wall = usize::from(contact.wall);
            let flow = (self.temperatures[wall], contact.conductance);
            of_walls[wall] += from_wall(particles, contact.particle as usize, flow, thermal);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Terms of all magnitudes add up to the same bits in any order.
    #[test]
    fn sums_do_not_depend_on_the_order() {
        let quanta = TwoQuanta::for_terms_below(100.0);
        let terms: Vec<f64> = (0..100_000_u64)
            .map(|k| {
                let x = (k.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11) as f64 / (1_u64 << 53) as f64;
                100.0 * x * 10_f64.powi(-((k % 9) as i32))
            })
            .collect();
        let sum = |terms: &mut dyn Iterator<Item = &f64>| {
            terms.map(|&x| quanta.split(x)).fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d])
        };
        let [forwards, backwards] = [sum(&mut terms.iter()), sum(&mut terms.iter().rev())];
        assert_eq!(forwards, backwards);
        let exact: f64 = terms.iter().sum();
        assert!(((forwards[0] + forwards[1]) / exact - 1.0).abs() < 1e-12);
    }
}
