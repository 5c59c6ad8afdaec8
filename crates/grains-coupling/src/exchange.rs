//! The semi-implicit exchange of momentum between one particle and the fluid; the crate's documentation derives it.

use crate::Coefficient;
use grains_dem::{CARGO_LENGTH, Cargo, Particles, StepParameters};
use grains_geometry::Vec3;

/// Share E(x) = (1 − e^−x)/x of a force that is left, on average over a time x τ, of one that decays with e^(−t/τ) (-).
///
/// The velocity of a particle under a constant acceleration a and drag of relaxation time τ towards w changes in dt
/// by exactly E(dt/τ) dt (a + (w − v)/τ).
#[inline]
pub fn relaxation(x: f64) -> f64 {
    // Below, what follows of the series, x⁹/10!, is less than the rounding of 1; particle steps are mostly that short.
    if x < 0.06 {
        // Σ (−x)^k/(k + 1)! in pairs, which do not wait for each other.
        let pair = |a: f64, b: f64| 1.0 / a - x * (1.0 / b);
        let (square, fourth) = (x * x, x * x * x * x);
        let first = pair(1.0, 2.0) + square * pair(6.0, 24.0);
        let second = pair(120.0, 720.0) + square * pair(5040.0, 40_320.0);
        first + fourth * (second + fourth * (1.0 / 362_880.0))
    } else {
        -(-x).exp_m1() / x
    }
}

/// The drag of one particle over one step of the fluid: F = K (w − v), and the account of what it was given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DragLink {
    /// Slope K of the drag with the slip (N s/m).
    pub coefficient: f64,
    /// Velocity w at which the drag vanishes (m/s); between [`DragLink::linearise`] and [`DragLink::set_fluid_velocity`] less that of the
    /// fluid.
    pub target: Vec3,
    /// Pressure-gradient force and buoyancy (N), constant over the fluid's step.
    pub pressure: Vec3,
    /// Impulse given to the particle that the fluid has not paid yet (N s).
    pub unpaid: Vec3,
}

impl DragLink {
    /// The link as the cargo of its particle.
    #[inline]
    pub fn write(&self) -> Cargo {
        let [t, p, o] = [self.target, self.pressure, self.unpaid];
        let mut cargo = [0.0; CARGO_LENGTH];
        cargo[..10].copy_from_slice(&[self.coefficient, t.x, t.y, t.z, p.x, p.y, p.z, o.x, o.y, o.z]);
        cargo
    }

    /// Writes what [`DragLink::force`] has changed back to its cargo.
    #[inline]
    fn write_unpaid(&self, cargo: &mut Cargo) {
        cargo[7..10].copy_from_slice(self.unpaid.as_slice());
    }

    /// Reads what [`DragLink::write`] wrote.
    #[inline]
    pub fn read(numbers: &Cargo) -> Self {
        let vector = |k: usize| Vec3::new(numbers[k], numbers[k + 1], numbers[k + 2]);
        const { assert!(CARGO_LENGTH >= 10, "a link is ten numbers") };
        Self { coefficient: numbers[0], target: vector(1), pressure: vector(4), unpaid: vector(7) }
    }

    /// Takes the tangent of the drag at the present slip u − v (m/s): K = β (1 + p), offset −p/(1 + p) (u − v).
    pub fn linearise(&mut self, drag: &Coefficient, slip: &Vec3) {
        let steeper = 1.0 + drag.exponent;
        self.coefficient = drag.value * steeper;
        self.target = slip * (-drag.exponent / steeper);
    }

    /// Coefficient K (N s/m) and explicit force K v̂ − unpaid/Δt (N) for the fluid's momentum equation, with the
    /// particle at the velocity v (m/s): the fluid loses (K u − explicit) Δt.
    pub fn fluid_terms(&self, velocity: &Vec3, time_step: f64) -> (f64, Vec3) {
        (self.coefficient, (velocity - self.target) * self.coefficient - self.unpaid / time_step)
    }

    /// Takes the new velocity of the fluid (m/s); what it has paid in advance for its step Δt (s) counts as unpaid, reversed.
    pub fn set_fluid_velocity(&mut self, fluid_velocity: &Vec3, velocity: &Vec3, time_step: f64) {
        self.target += fluid_velocity;
        self.unpaid = (velocity - self.target) * (self.coefficient * time_step);
    }

    /// Drag (N) over a DEM step dt (s) beside constant `other` forces (N), and charges it.
    ///
    /// v + dt (other + drag)/m is the exact solution of m dv/dt = other + K (w − v) after dt.
    #[inline]
    pub fn force(&mut self, velocity: &Vec3, other: &Vec3, mass: f64, dt: f64) -> Vec3 {
        let left = relaxation(self.coefficient * dt / mass);
        let drag = (self.target - velocity) * (self.coefficient * left) - other * (1.0 - left);
        self.unpaid += drag * dt;
        drag
    }
}

/// Momentum between particles and fluid on one rank.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MomentumLedger {
    /// Impulse that drag gave to particles (N s).
    pub given: Vec3,
    /// Impulse taken from the fluid (N s), see [`impulse_taken`].
    pub taken: Vec3,
}

impl MomentumLedger {
    /// What is left of given − taken − unpaid (N s), summed over all ranks by the caller: rounding.
    pub fn imbalance(&self, particles: &Particles) -> Vec3 {
        self.given - self.taken - unpaid_impulse(particles)
    }
}

/// Impulse (N s) that the fluid owes the particles of a rank.
pub fn unpaid_impulse(particles: &Particles) -> Vec3 {
    particles.cargo.iter().map(|cargo| DragLink::read(cargo).unpaid).sum()
}

/// Impulse (N s) along one axis that the faces of the fluid lose in its step Δt (s): Σ (B u − S) Δt, over the faces this
/// rank owns, with B (N s/m) and S (N) as deposited, before any division by volumes.
pub fn impulse_taken(coefficient: &[f64], explicit: &[f64], velocity: &[f64], time_step: f64) -> f64 {
    let forces = coefficient.iter().zip(explicit).zip(velocity).map(|((b, s), u)| b * u - s);
    forces.sum::<f64>() * time_step
}

/// Pressure gradient (Pa/m) along the normal between a boundary of the domain and the centre of its cell, that balances the
/// force (N) of the particles on the fluid at that face: `half_volume` (m³) is that of half the cell, `factor` what multiplies
/// −∇p there, ε in model A and 1 in model B.
pub fn boundary_gradient(force: f64, factor: f64, half_volume: f64) -> f64 {
    force / (factor * half_volume)
}

/// Adds drag, pressure gradient and buoyancy to the loads of all owned particles, between `Dem::add_forces` and
/// `Dem::advance`: the leap-frog kick then is the exact relaxation.
///
/// The particles carry their [`DragLink`]s. Soft collisions only: with hard ones loads move nothing.
pub fn add_drag(particles: &mut Particles, rates: &StepParameters, ledger: &mut MomentumLedger) {
    assert_eq!(particles.cargo.len(), particles.owned, "coupled particles carry their links");
    let Particles { bodies, half_velocity, loads, cargo, .. } = particles;
    for (((load, cargo), body), velocity) in loads.iter_mut().zip(cargo).zip(bodies).zip(half_velocity) {
        let mut link = DragLink::read(cargo);
        load.force += link.pressure;
        let other = load.force + rates.gravity * body.mass;
        let drag = link.force(velocity, &other, body.contact_mass(), rates.dt);
        load.force += drag;
        ledger.given += drag * rates.dt;
        link.write_unpaid(cargo);
    }
}
