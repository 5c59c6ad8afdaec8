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
use std::ops::Range;

/// A rate so many times the smallest one makes the steps before it worthless (-).
const LOST: f64 = 4.0;
/// Added to the diagonal of the normal equations, of its largest entry (-).
const REGULAR: f64 = 1e-12;
/// Faces next to surfaces whose forces are combined at a time.
const SOME: usize = 256;

/// The last steps towards a steady state.
#[derive(Clone, Debug)]
pub struct Anderson {
    /// Differences of states and of rates, one pair a step; of the newest the rate itself, until the next one is known.
    history: Vec<[Vec<f32>; 2]>,
    /// Number of pairs there are, and the place of the next one.
    count: usize,
    next: usize,
    /// The state before the step, but for what the flow keeps of its velocities.
    before: Vec<f64>,
    has_rate: bool,
    smallest: f64,
    /// Time (s) by which forces per mass become velocities: the first step.
    unit: f64,
    /// Products of rates that ranks agree on, the normal equations of the weights, and these.
    sums: Vec<f64>,
    matrix: Vec<f64>,
    weights: Vec<f64>,
    /// Rates of a part.
    rates: Vec<f32>,
}

impl Anderson {
    /// Remembers so many steps.
    pub fn new(depth: usize) -> Self {
        Self {
            history: vec![Default::default(); depth],
            count: 0,
            next: 0,
            before: Vec::new(),
            has_rate: false,
            smallest: f64::INFINITY,
            unit: 0.0,
            sums: Vec::new(),
            matrix: Vec::new(),
            weights: Vec::new(),
            rates: Vec::new(),
        }
    }

    /// Notes the state before a pseudo-step `dt` (s).
    pub fn begin(&mut self, flow: &Flow, dt: f64) {
        if self.unit == 0.0 {
            self.unit = dt;
        }
        flow.note_before(self.unit, &mut self.before);
    }

    /// Combines the state after the step with those before it; collective.
    pub fn combine(&mut self, flow: &mut Flow, dt: f64, transport: &dyn Transport) {
        let (depth, next) = (self.history.len(), self.next);
        if !self.has_rate {
            let size = flow.size_of_parts();
            self.history.iter_mut().flatten().for_each(|list| *list = vec![0.0; size]);
        }
        flow.resume_before(&self.before);
        if self.has_rate {
            self.count = (self.count + 1).min(depth);
        }
        self.has_rate = true;
        let (count, newest) = (self.count, (next + depth - 1) % depth);
        let Self { history, before, sums, rates, unit, .. } = self;
        let (unit, is_first) = (*unit, transport.rank() == 0);
        sums.clear();
        sums.resize(1 + count * (count + 3) / 2, 0.0);
        let mut at = 0;
        flow.for_each_part(unit, before, |part| {
            let own = at..at + part.values.len();
            rates.clear();
            rates.extend(part.rates(dt));
            let latest = history[newest][1][own.clone()].iter_mut();
            latest.zip(&*rates).for_each(|(latest, now)| *latest = now - *latest);
            if is_first || !part.is_shared {
                add_products(rates, history, places(next, depth, count), own.clone(), sums);
            }
            at = own.end;
        });
        self.weigh(transport);
        let Self { history, before, weights, rates, count, .. } = self;
        let mut at = 0;
        flow.for_each_part(unit, before, |part| {
            let own = at..at + part.values.len();
            rates.clear();
            rates.extend(part.rates(dt));
            for (k, value) in part.values.iter_mut().enumerate() {
                let mut change = dt * f64::from(rates[k]);
                for (i, weight) in places(next, depth, *count).zip(&*weights) {
                    let [of_state, of_rate] = [0, 1].map(|o| f64::from(history[i][o][at + k]));
                    change -= weight * (of_state + dt * of_rate);
                }
                *value = (part.before[k] + change) / part.scale;
                // The oldest pair has had its last use.
                history[next][0][at + k] = change as f32;
                history[next][1][at + k] = rates[k];
            }
            at = own.end;
        });
        self.next = (next + 1) % depth;
        flow.settle_parts(transport);
    }

    /// γ of the pairs there are, of the products of their rates; forgets them all where they lead away. Collective.
    fn weigh(&mut self, transport: &dyn Transport) {
        let n = self.count;
        let Self { sums, matrix, weights, .. } = self;
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

/// Adds |r|², and of each pair Δr_i·r and Δr_i·Δr_j with itself and those before it, of some places.
fn add_products(
    rates: &[f32],
    history: &[[Vec<f32>; 2]],
    pairs: impl Iterator<Item = usize> + Clone,
    own: Range<usize>,
    sums: &mut [f64],
) {
    let mut sums = sums.iter_mut();
    let mut add = |a: &[f32], b: &[f32]| {
        if let Some(sum) = sums.next() {
            *sum += dot(a, b);
        }
    };
    add(rates, rates);
    for (k, i) in pairs.clone().enumerate() {
        let of_pair = &history[i][1][own.clone()];
        add(of_pair, rates);
        pairs.clone().take(k + 1).for_each(|j| add(of_pair, &history[j][1][own.clone()]));
    }
}

/// Σ a b, with partial sums kept apart, so that additions need not wait for one another.
fn dot(a: &[f32], b: &[f32]) -> f64 {
    const LANES: usize = 8;
    let mut lanes = [0.0; LANES];
    let ((a, rest_of_a), (b, rest_of_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in a.iter().zip(b) {
        (0..LANES).for_each(|l| lanes[l] += f64::from(a[l]) * f64::from(b[l]));
    }
    let rest: f64 = rest_of_a.iter().zip(rest_of_b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum();
    lanes.iter().sum::<f64>() + rest
}

/// Places of so many of the last pairs, the newest first.
fn places(next: usize, depth: usize, count: usize) -> impl Iterator<Item = usize> + Clone {
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

/// Some numbers of the state.
struct Part<'a> {
    values: &'a mut [f64],
    /// These before the step (m/s).
    before: &'a [f64],
    /// What makes velocities (m/s) of the values.
    scale: f64,
    /// Whether all ranks hold them.
    is_shared: bool,
}

impl Part<'_> {
    /// (g(x) − x)/Δτ (m/s²).
    fn rates(&self, dt: f64) -> impl Iterator<Item = f32> {
        self.values.iter().zip(self.before).map(move |(x, before)| ((x * self.scale - before) / dt) as f32)
    }
}

impl Flow {
    /// Factors that make velocities (m/s) of forces (N/m³) and of pressures (Pa).
    fn scales(&self, unit: f64) -> [f64; 2] {
        let by_force = unit / self.setup.density;
        let axes = (0..3).filter(|&a| self.setup.grid.is_active(a));
        let width = axes.map(|a| self.setup.grid.axis(a).width(0)).fold(f64::INFINITY, f64::min);
        [by_force, by_force / width]
    }

    /// Number of all numbers of the own state.
    fn size_of_parts(&self) -> usize {
        let fields = 1 + self.local.active.iter().filter(|is_active| **is_active).count();
        let near = self.immersed.iter().flat_map(|bodies| &bodies.held).map(|held| held.near.len());
        fields * self.local.layout.cells.iter().product::<usize>() + near.sum::<usize>() + 3
    }

    /// Notes the state (m/s) before a step, without the velocities: forces, of each component deep in bodies and next to their
    /// surface, the pressure, and the mean pressure gradients.
    fn note_before(&self, unit: f64, before: &mut Vec<f64>) {
        let (layout, [by_force, by_pressure]) = (self.local.layout, self.scales(unit));
        before.clear();
        if before.capacity() == 0 {
            let held = self.immersed.iter().flat_map(|bodies| &bodies.held);
            let of_bodies: usize = held.map(|held| held.deep.len() + held.near.len()).sum();
            before.reserve_exact(of_bodies + layout.cells.iter().product::<usize>() + 3);
        }
        for component in (0..3).filter(|&c| self.local.active[c]) {
            if let Some(Immersed { held, force, .. }) = &self.immersed {
                let (held, force) = (&held[component], force.component(component));
                let places = held.deep.iter().chain(&held.near);
                before.extend(places.map(|&p| force[p as usize] * by_force));
            }
        }
        let pressure = self.state.pressure.own();
        before.extend(pressure.map(|p| p * by_pressure));
        before.extend(self.state.force.map(|f| f * by_force));
    }

    /// Puts the forces deep in bodies among the velocities before the step.
    fn resume_before(&mut self, before: &[f64]) {
        let Some(Immersed { held, .. }) = &self.immersed else { return };
        let mut rest = before;
        for component in (0..3).filter(|&c| self.local.active[c]) {
            let velocity = self.increments.component_mut(component);
            let deep = &held[component].deep;
            deep.iter().zip(rest).for_each(|(&p, &value)| velocity[p as usize] = value);
            rest = &rest[deep.len() + held[component].near.len()..];
        }
    }

    /// All numbers of the own state in a fixed order.
    fn for_each_part(&mut self, unit: f64, before: &[f64], mut job: impl FnMut(Part<'_>)) {
        let (layout, [by_force, by_pressure]) = (self.local.layout, self.scales(unit));
        let n = layout.cells[0];
        let mut rest = before;
        let mut take = |count: usize| {
            let (taken, left) = rest.split_at(count);
            rest = left;
            taken
        };
        let mut some = [0.0; SOME];
        for component in (0..3).filter(|&c| self.local.active[c]) {
            let velocity = self.state.velocity.component_mut(component);
            let before = self.increments.component(component);
            let mut immersed =
                self.immersed.as_mut().map(|i| (&i.held[component], i.force.component_mut(component)));
            if let Some((held, force)) = &mut immersed {
                held.deep.iter().for_each(|&p| velocity[p as usize] = force[p as usize] * by_force);
                take(held.deep.len());
            }
            for row in layout.rows() {
                let (values, before) = (&mut velocity[row..row + n], &before[row..row + n]);
                job(Part { values, before, scale: 1.0, is_shared: false });
            }
            if let Some((held, force)) = &mut immersed {
                for p in held.deep.iter().map(|&p| p as usize) {
                    force[p] = std::mem::take(&mut velocity[p]) / by_force;
                }
                for places in held.near.chunks(SOME) {
                    let values = &mut some[..places.len()];
                    values.iter_mut().zip(places).for_each(|(value, &p)| *value = force[p as usize]);
                    let before = take(places.len());
                    job(Part { values: &mut *values, before, scale: by_force, is_shared: false });
                    values.iter().zip(places).for_each(|(value, &p)| force[p as usize] = *value);
                }
            }
        }
        let pressure = self.state.pressure.data_mut();
        for row in layout.rows() {
            let values = &mut pressure[row..row + n];
            job(Part { values, before: take(n), scale: by_pressure, is_shared: false });
        }
        job(Part { values: &mut self.state.force, before: take(3), scale: by_force, is_shared: true });
    }

    /// Takes what follows from a state that was changed; collective.
    fn settle_parts(&mut self, transport: &dyn Transport) {
        for component in 0..3 {
            let velocity = self.state.velocity.component(component);
            let Some(Immersed { held, extrapolated: Some(extrapolated), .. }) = &mut self.immersed else {
                break;
            };
            let values = held[component].near.iter().map(|&p| (p, velocity[p as usize]));
            extrapolated[component].clear();
            extrapolated[component].extend(values);
        }
        let depth = self.layers_of_step();
        self.refresh_velocity(depth, transport);
        self.refresh_pressure(transport);
    }
}
