//! Sums over all particles: mass, energies, momenta.

use crate::catalogue::Catalogue;
use crate::particles::Particles;
use grains_domain::{GlobalBox, Transport, sum_wide};
use grains_geometry::Vec3;

/// Sums over all particles of all ranks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// Particles inside.
    pub particles: u64,
    /// Mass (kg).
    pub mass: f64,
    /// Kinetic energy of translation (J).
    pub kinetic_translation: f64,
    /// Kinetic energy of rotation (J).
    pub kinetic_rotation: f64,
    /// Potential energy in gravity, −M g·x (J).
    pub potential: f64,
    /// Momentum (kg m/s).
    pub momentum: Vec3,
    /// Angular momentum about the origin (kg m²/s), of the images in the box where axes are periodic.
    pub angular_momentum: Vec3,
    /// Largest speed (m/s).
    pub max_speed: f64,
}

impl Totals {
    /// Sums over the owned particles of all ranks, the same in every bit however particles are shared out among them; collective.
    pub(crate) fn of(
        particles: &Particles,
        catalogue: &Catalogue,
        gravity: &Vec3,
        global: &GlobalBox,
        transport: &impl Transport,
    ) -> Self {
        let terms = |i: usize| terms(particles, i, catalogue, (gravity, global));
        let mut largest = [0.0_f64; TERMS + 1];
        for (i, body) in particles.bodies[..particles.owned].iter().enumerate() {
            largest[..TERMS].iter_mut().zip(terms(i)).for_each(|(max, term)| *max = max.max(term.abs()));
            largest[TERMS] = largest[TERMS].max(body.velocity.norm());
        }
        transport.max(&mut largest);
        let quanta = std::array::from_fn::<_, TERMS, _>(|k| quantum_below(largest[k]));
        let mut sums = [0_i128; TERMS + 1];
        sums[TERMS] = particles.owned as i128;
        for i in 0..particles.owned {
            for ((sum, term), quantum) in sums.iter_mut().zip(terms(i)).zip(quanta) {
                *sum += (term / quantum) as i128;
            }
        }
        let mut sums = sums.map(i128::cast_unsigned);
        sum_wide(&mut sums, transport);
        let sums = sums.map(u128::cast_signed);
        let of = |k: usize| sums[k] as f64 * quanta[k];
        let vector = |k: usize| Vec3::new(of(k), of(k + 1), of(k + 2));
        Self {
            particles: sums[TERMS] as u64,
            mass: of(0),
            kinetic_translation: of(1),
            kinetic_rotation: of(2),
            potential: of(3),
            momentum: vector(4),
            angular_momentum: vector(7),
            max_speed: largest[TERMS],
        }
    }
}

/// Numbers that are summed over the particles.
const TERMS: usize = 10;

/// Those of an owned particle: mass, energies of translation, rotation and in gravity, momentum, angular momentum.
fn terms(
    particles: &Particles,
    i: usize,
    catalogue: &Catalogue,
    (gravity, global): (&Vec3, &GlobalBox),
) -> [f64; TERMS] {
    let body = &particles.bodies[i];
    let (m, v, w) = (body.mass, body.velocity, body.angular_velocity);
    // Which image a rank holds depends on when lists were rebuilt.
    let position = Vec3::from(global.wrap(body.position.into()));
    let inertia = catalogue.inertia(body);
    let spin = match particles.frames.get(i) {
        Some(frame) => frame * inertia.component_mul(&frame.tr_mul(&w)),
        None => inertia.component_mul(&w),
    };
    let (p, l) = (v * m, position.cross(&v) * m + spin);
    let energies = [0.5 * m * v.norm_squared(), 0.5 * w.dot(&spin), -m * gravity.dot(&position)];
    [m, energies[0], energies[1], energies[2], p.x, p.y, p.z, l.x, l.y, l.z]
}

/// A power of two of which sums of multiples are exact in 128 bits: 2⁻⁷⁵ of the power above the largest of up to 2⁵¹ terms. What it cuts
/// off a term is below the rounding of any sum.
pub(crate) fn quantum_below(largest: f64) -> f64 {
    // The exponent of the power of two at or below it; numbers below 1e-280 are nothing here.
    let exponent = (largest.max(1e-280).to_bits() >> 52) as i32 - 1023;
    2.0_f64.powi(exponent + 1 - 75)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_quanta_do_not_depend_on_the_order_and_are_right() {
        let terms: Vec<f64> =
            (1..2000).map(|k| (f64::from(k) * 0.7).sin() * 10.0_f64.powi(k % 12 - 6)).collect();
        let largest = terms.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let quantum = quantum_below(largest);
        let sum = |terms: &[f64]| terms.iter().map(|x| (x / quantum) as i128).sum::<i128>();
        let (front, back) = terms.split_at(731);
        let whole = sum(&terms);
        assert_eq!(whole, sum(back) + sum(front));
        let plain: f64 = terms.iter().sum();
        assert!((whole as f64 * quantum - plain).abs() < 1e-12 * terms.iter().map(|x| x.abs()).sum::<f64>());
        assert!(largest / quantum < 2.0_f64.powi(75) && largest / quantum >= 2.0_f64.powi(74));
        assert_eq!(0.0 / quantum_below(0.0), 0.0);
    }
}
