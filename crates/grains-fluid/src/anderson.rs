//! Anderson acceleration: pseudo-steps combined so that what still changes is smallest.
//!
//! A pseudo-step takes a state x to g(x); a steady state is x = g(x). With the rates r = (g(x) − x)/Δτ of the last steps
//!
//! ```text
//! γ minimises |r − Σ γ_i Δr_i|,   x ← x + Δτ r − Σ γ_i (Δx_i + Δτ Δr_i)          (Anderson 1965; Walker & Ni 2011)
//! ```
//!
//! The state is the velocities, the pressure, the forces of bodies and the mean pressure gradients, all in m/s: it is linear in
//! them but for advection. Velocities deep inside bodies at rest are zero, and their forces lie in their places. Differences are
//! kept in single precision: they vanish with what changes.

use crate::{Flow, Immersed};
use grains_domain::Transport;

/// A rate so many times the smallest one makes the steps before it worthless (-).
const LOST: f64 = 4.0;
/// Added to the diagonal of the normal equations, of its largest entry (-).
const REGULAR: f64 = 1e-12;
/// Numbers that all ranks hold: the mean pressure gradients.
const SHARED: usize = 3;

/// The last steps towards a steady state.
#[derive(Clone, Debug)]
pub struct Anderson {
    /// Differences of states and of rates, one pair a step.
    history: Vec<[Vec<f32>; 2]>,
    /// Number of pairs there are, and the place of the next one.
    count: usize,
    next: usize,
    before: Vec<f64>,
    rate: Vec<f32>,
    has_rate: bool,
    smallest: f64,
    /// Time (s) by which forces per mass become velocities: the first step.
    unit: f64,
    /// Products of rates that ranks agree on, the normal equations of the weights, and these.
    sums: Vec<f64>,
    matrix: Vec<f64>,
    weights: Vec<f64>,
}

impl Anderson {
    /// Remembers so many steps.
    pub fn new(depth: usize) -> Self {
        Self {
            history: vec![Default::default(); depth],
            count: 0,
            next: 0,
            before: Vec::new(),
            rate: Vec::new(),
            has_rate: false,
            smallest: f64::INFINITY,
            unit: 0.0,
            sums: Vec::new(),
            matrix: Vec::new(),
            weights: Vec::new(),
        }
    }

    /// Notes the state before a pseudo-step `dt` (s).
    pub fn begin(&mut self, flow: &mut Flow, dt: f64) {
        if self.unit == 0.0 {
            self.unit = dt;
        }
        let before = &mut self.before;
        before.clear();
        flow.for_each_part(self.unit, |part, scale| before.extend(part.iter().map(|x| x * scale)));
    }

    /// Combines the state after the step with those before it; collective.
    pub fn combine(&mut self, flow: &mut Flow, dt: f64, transport: &dyn Transport) {
        let size = self.before.len();
        self.rate.resize(size, 0.0);
        let depth = self.history.len();
        for list in self.history.iter_mut().flatten() {
            list.resize(size, 0.0);
        }
        let (rate, before) = (&mut self.rate, &self.before);
        let newest = (self.next + depth - 1) % depth;
        let difference = &mut self.history[newest][1];
        let mut at = 0;
        flow.for_each_part(self.unit, |part, scale| {
            for x in part.iter() {
                let now = ((x * scale - before[at]) / dt) as f32;
                difference[at] = now - rate[at];
                rate[at] = now;
                at += 1;
            }
        });
        if self.has_rate {
            self.count = (self.count + 1).min(depth);
        }
        self.has_rate = true;
        self.weigh(transport);
        let mut at = 0;
        let mut step = std::mem::take(&mut self.history[self.next][0]);
        let history = &self.history;
        let (oldest, count) = (self.next, self.count);
        let old_step = |i: usize, at: usize, step: &[f32]| match i == oldest {
            true => f64::from(step[at]),
            false => f64::from(history[i][0][at]),
        };
        flow.for_each_part(self.unit, |part, scale| {
            for x in part.iter_mut() {
                let mut change = dt * f64::from(self.rate[at]);
                for (i, weight) in places(oldest, depth, count).zip(&self.weights) {
                    let of_rate = f64::from(history[i][1][at]);
                    change -= weight * (old_step(i, at, &step) + dt * of_rate);
                }
                *x = (self.before[at] + change) / scale;
                step[at] = change as f32;
                at += 1;
            }
        });
        self.history[self.next][0] = step;
        self.next = (self.next + 1) % depth;
        flow.settle_parts(transport);
    }

    /// γ of the pairs there are; forgets them all where they lead away. Collective.
    fn weigh(&mut self, transport: &dyn Transport) {
        let (next, depth, n) = (self.next, self.history.len(), self.count);
        let is_first = transport.rank() == 0;
        let own = self.rate.len() - if is_first { 0 } else { SHARED };
        let dot = |a: &[f32], b: &[f32]| {
            a[..own].iter().zip(&b[..own]).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum::<f64>()
        };
        let Self { sums, matrix, weights, history, rate, .. } = self;
        sums.clear();
        sums.push(dot(rate, rate));
        for (k, i) in places(next, depth, n).enumerate() {
            sums.push(dot(&history[i][1], rate));
            sums.extend(places(next, depth, k + 1).map(|j| dot(&history[i][1], &history[j][1])));
        }
        transport.sum(sums);
        weights.clear();
        let size = sums[0].sqrt();
        if size.is_nan() || size > LOST * self.smallest {
            (self.count, self.smallest) = (0, size);
            return;
        }
        self.smallest = self.smallest.min(size);
        matrix.clear();
        matrix.resize(n * n, 0.0);
        let mut at = 1;
        for i in 0..n {
            weights.push(sums[at]);
            matrix[i * n..=i * n + i].copy_from_slice(&sums[at + 1..at + 2 + i]);
            at += i + 2;
        }
        let largest = (0..n).map(|i| matrix[i * n + i]).fold(0.0, f64::max);
        (0..n).for_each(|i| matrix[i * n + i] += REGULAR * largest);
        solve(matrix, weights);
    }
}

/// Places of so many of the last pairs, the newest first.
fn places(next: usize, depth: usize, count: usize) -> impl Iterator<Item = usize> {
    (1..=count).map(move |k| (next + depth - k) % depth)
}

/// Solution in place with a symmetric matrix of which the lower half is given, by Cholesky; zeros of what has no pivot.
fn solve(matrix: &mut [f64], x: &mut [f64]) {
    let n = x.len();
    for i in 0..n {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| matrix[i * n + k] * matrix[j * n + k]).sum();
            let rest = matrix[i * n + j] - sum;
            matrix[i * n + j] = match i == j {
                true if rest > 0.0 => rest.sqrt(),
                true => f64::INFINITY,
                false => rest / matrix[j * n + j],
            };
        }
        let sum: f64 = (0..i).map(|k| matrix[i * n + k] * x[k]).sum();
        x[i] = (x[i] - sum) / matrix[i * n + i];
    }
    for i in (0..n).rev() {
        let sum: f64 = (i + 1..n).map(|k| matrix[k * n + i] * x[k]).sum();
        x[i] = (x[i] - sum) / matrix[i * n + i];
    }
}

impl Flow {
    /// All numbers of the own state in a fixed order, each list with the factor that makes velocities (m/s) of it.
    fn for_each_part(&mut self, unit: f64, mut job: impl FnMut(&mut [f64], f64)) {
        let layout = self.layout();
        let (n, by_force) = (layout.cells[0], unit / self.setup.density);
        let axes = (0..3).filter(|&a| self.setup.grid.is_active(a));
        let width = axes.map(|a| self.setup.grid.axis(a).width(0)).fold(f64::INFINITY, f64::min);
        for component in (0..3).filter(|&c| self.local.active[c]) {
            let velocity = self.state.velocity.component_mut(component);
            let mut immersed =
                self.immersed.as_mut().map(|i| (&i.held[component], i.force.component_mut(component)));
            if let Some((held, force)) = &mut immersed {
                held.deep.iter().for_each(|&p| velocity[p as usize] = force[p as usize] * by_force);
            }
            layout.rows().for_each(|row| job(&mut velocity[row..row + n], 1.0));
            if let Some((held, force)) = &mut immersed {
                for p in held.deep.iter().map(|&p| p as usize) {
                    force[p] = std::mem::take(&mut velocity[p]) / by_force;
                }
                for &p in &held.near {
                    job(std::slice::from_mut(&mut force[p as usize]), by_force);
                }
            }
        }
        let pressure = self.state.pressure.data_mut();
        layout.rows().for_each(|row| job(&mut pressure[row..row + n], by_force / width));
        job(&mut self.state.force, by_force);
    }

    /// Takes what follows from a state that was changed; collective.
    fn settle_parts(&mut self, transport: &dyn Transport) {
        for component in 0..3 {
            let velocity = self.state.velocity.component(component);
            let Some(Immersed { held, extrapolated: Some(extrapolated), .. }) = &mut self.immersed else {
                break;
            };
            let extrapolated = extrapolated.component_mut(component);
            held[component].near.iter().for_each(|&p| extrapolated[p as usize] = velocity[p as usize]);
        }
        let depth = self.layers_of_step();
        self.refresh_velocity(depth, transport);
        self.refresh_pressure(transport);
        self.refresh_extrapolated(transport);
    }
}
