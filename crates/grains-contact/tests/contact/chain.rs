//! Chains and lattices of bonded spheres, moved by a leap-frog step as that of the solver.

use grains_contact::{Bond, BondLoad, BondState, BondedPair};
use nalgebra::Vector3;

pub type Vec3 = Vector3<f64>;

/// Equal bonded spheres.
pub struct Chain {
    /// The spheres of each bond.
    pub pairs: Vec<[usize; 2]>,
    pub bond: Bond,
    pub mass: f64,
    pub inertia: f64,
    pub position: Vec<Vec3>,
    pub velocity: Vec<Vec3>,
    pub spin: Vec<Vec3>,
    pub states: Vec<BondState>,
    /// Whether the first sphere is held.
    pub is_clamped: bool,
    /// Rate of a drag on velocities and spins (1/s).
    pub drag: f64,
    /// Force on each sphere (N).
    pub load: Vec<Vec3>,
    pub broken: usize,
    acceleration: Vec<[Vec3; 2]>,
}

impl Chain {
    /// A straight chain along x at rest.
    pub fn new(bond: Bond, count: usize, radius: f64, density: f64, spacing: f64) -> Self {
        let position = (0..count).map(|i| Vec3::x() * (spacing * i as f64)).collect();
        Self::of((1..count).map(|k| [k - 1, k]).collect(), position, bond, radius, density)
    }

    /// A simple cubic lattice of touching spheres at rest, of 6 bonds of each sphere inside.
    pub fn cubic(bond: Bond, side: usize, radius: f64, density: f64) -> Self {
        let at = |i: usize| [i % side, i / side % side, i / (side * side)];
        let count = side.pow(3);
        let place = |i: usize| Vec3::from(at(i).map(|k| 2.0 * radius * k as f64));
        let next = |i: usize, axis: usize| [i, i + side.pow(axis as u32)];
        let pairs = (0..3)
            .flat_map(|axis| (0..count).filter(move |i| at(*i)[axis] + 1 < side).map(move |i| next(i, axis)));
        Self::of(pairs.collect(), (0..count).map(place).collect(), bond, radius, density)
    }

    fn of(pairs: Vec<[usize; 2]>, position: Vec<Vec3>, bond: Bond, radius: f64, density: f64) -> Self {
        let count = position.len();
        let mass = density * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        let mut chain = Self {
            bond,
            mass,
            inertia: 0.4 * mass * radius * radius,
            position,
            pairs,
            velocity: vec![Vec3::zeros(); count],
            spin: vec![Vec3::zeros(); count],
            states: Vec::new(),
            is_clamped: false,
            drag: 0.0,
            load: vec![Vec3::zeros(); count],
            broken: 0,
            acceleration: vec![[Vec3::zeros(); 2]; count],
        };
        chain.make_bonds(0.0);
        chain
    }

    /// Bonds without stress between the spheres as they are.
    pub fn make_bonds(&mut self, dt: f64) {
        self.states = (0..self.pairs.len()).map(|k| BondState::new(&self.pair(k), dt)).collect();
    }

    pub fn pair(&self, k: usize) -> BondedPair {
        let [i, j] = self.pairs[k];
        let apart = self.position[j] - self.position[i];
        let distance = apart.norm();
        let held = self.is_clamped && i == 0;
        BondedPair {
            normal: apart / distance,
            distance,
            velocity: self.velocity[j] - self.velocity[i],
            spins: [self.spin[i], self.spin[j]],
            mass: if held { self.mass } else { 0.5 * self.mass },
            inverse_inertia: if held { 1.0 } else { 2.0 } / self.inertia,
        }
    }

    /// Forces from velocities extrapolated to this time, kick, drift.
    pub fn step(&mut self, dt: f64) {
        let mut force = self.load.clone();
        let mut torque = vec![Vec3::zeros(); force.len()];
        for k in 0..self.states.len() {
            let pair = self.pair(k);
            let unbroken = self.states[k].length > 0.0;
            let Some(BondLoad { force: pull, torques }) =
                unbroken.then(|| self.bond.load(&mut self.states[k], &pair, dt)).flatten()
            else {
                self.broken += usize::from(unbroken);
                self.states[k].length = 0.0;
                continue;
            };
            let [i, j] = self.pairs[k];
            force[i] += pull;
            force[j] -= pull;
            torque[i] += torques[0];
            torque[j] += torques[1];
        }
        for i in usize::from(self.is_clamped)..force.len() {
            let now = [
                force[i] / self.mass - self.velocity[i] * self.drag,
                torque[i] / self.inertia - self.spin[i] * self.drag,
            ];
            // The stored velocity is v(t) = v(t − dt/2) + a(t − dt) dt/2: the step's kick, and half of it again.
            let before = self.acceleration[i];
            let half = [
                self.velocity[i] + (now[0] - before[0] * 0.5) * dt,
                self.spin[i] + (now[1] - before[1] * 0.5) * dt,
            ];
            self.position[i] += half[0] * dt;
            self.velocity[i] = half[0] + now[0] * (0.5 * dt);
            self.spin[i] = half[1] + now[1] * (0.5 * dt);
            self.acceleration[i] = now;
        }
    }

    pub fn energy(&self, dt: f64) -> f64 {
        let elastic: f64 =
            (0..self.states.len()).map(|k| self.bond.energy(&self.states[k], &self.pair(k), dt)).sum();
        let moving: f64 = self.velocity.iter().map(Vec3::norm_squared).sum::<f64>() * self.mass;
        let turning: f64 = self.spin.iter().map(Vec3::norm_squared).sum::<f64>() * self.inertia;
        elastic + 0.5 * (moving + turning)
    }

    pub fn momentum(&self) -> Vec3 {
        self.velocity.iter().sum::<Vec3>() * self.mass
    }

    /// With the velocities of the half step before: those of full steps are extrapolated.
    pub fn angular_momentum(&self, dt: f64) -> Vec3 {
        let half = |i: usize, which: usize| self.acceleration[i][which] * (0.5 * dt);
        (0..self.position.len())
            .map(|i| {
                let orbit = self.position[i].cross(&(self.velocity[i] - half(i, 0))) * self.mass;
                orbit + (self.spin[i] - half(i, 1)) * self.inertia
            })
            .sum()
    }
}
