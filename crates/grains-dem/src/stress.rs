//! The mean stress of a sheared box: what contacts and motion carry through it.
//!
//! ```text
//!  σ = (1/V) ⟨ Σ_contacts F ⊗ (x_a − x_b) + Σ_particles m v' ⊗ v' ⟩,    v' = v − γ x_g e_f
//! ```
//!
//! with the force F on the first of two particles, means over steps, and pressure counted as positive.

use crate::particles::Particles;
use crate::shear::SlidingImages;
use grains_geometry::{Mat3, Vec3};

/// Sums over steps and the particles of this rank.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StressSums {
    /// Steps (-).
    pub steps: f64,
    /// Σ F ⊗ (x_a − x_b) (N m), by columns.
    pub contacts: Mat3,
    /// Σ m v' ⊗ v' (J), by columns.
    pub kinetic: Mat3,
    /// Σ m v' (kg m/s).
    pub momentum: Vec3,
    /// Σ m (kg).
    pub mass: f64,
}

/// Mean stress of the box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stress {
    /// Of contacts and motion, symmetrised: xx, yy, zz, xy, xz, yz (Pa).
    pub total: [f64; 6],
    /// That of motion alone (Pa).
    pub kinetic: [f64; 6],
    /// Granular temperature ⟨v'²⟩/3 (m²/s²), by mass.
    pub temperature: f64,
}

impl StressSums {
    /// Numbers of the sums.
    pub const LENGTH: usize = 23;

    /// Adds the present step, of whose contacts the sum F ⊗ (x_a − x_b) (N m) is given.
    pub(crate) fn add(&mut self, particles: &Particles, contacts: &Mat3, images: &SlidingImages) {
        self.steps += 1.0;
        self.contacts += contacts;
        for body in &particles.bodies[..particles.owned] {
            let peculiar = body.velocity - images.mean_flow(&body.position);
            let momentum = peculiar * body.mass;
            self.kinetic += momentum * peculiar.transpose();
            self.momentum += momentum;
            self.mass += body.mass;
        }
    }

    /// The sums as plain numbers.
    pub fn numbers(&self) -> [f64; Self::LENGTH] {
        let mut numbers = [0.0; Self::LENGTH];
        let matrices = self.contacts.iter().chain(&self.kinetic).chain(&self.momentum);
        let values = [self.steps, self.mass].into_iter().chain(matrices.copied());
        numbers.iter_mut().zip(values).for_each(|(to, from)| *to = from);
        numbers
    }

    /// The sums of the numbers.
    pub fn from_numbers(numbers: &[f64; Self::LENGTH]) -> Self {
        let matrix = |from: usize| Mat3::from_column_slice(&numbers[from..from + 9]);
        Self {
            steps: numbers[0],
            mass: numbers[1],
            contacts: matrix(2),
            kinetic: matrix(11),
            momentum: Vec3::from_column_slice(&numbers[20..]),
        }
    }

    /// The stress in a volume (m³), of the sums of all ranks.
    pub(crate) fn mean(&self, volume: f64) -> Stress {
        let steps = self.steps;
        if steps == 0.0 || self.mass == 0.0 {
            return Stress::default();
        }
        // The particles together may move: their common velocity is no agitation.
        let kinetic = self.kinetic - self.momentum * self.momentum.transpose() / self.mass;
        let parts = |sum: &Mat3| {
            let mean = (sum + sum.transpose()) * (0.5 / (volume * steps));
            [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|place| mean[place])
        };
        Stress {
            total: parts(&(self.contacts + kinetic)),
            kinetic: parts(&kinetic),
            temperature: kinetic.trace() / (3.0 * self.mass),
        }
    }
}
