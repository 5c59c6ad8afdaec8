//! When a rank rebuilds its lists, where ranks do so apart from each other.
//!
//! The state does not depend on when lists are rebuilt. So a rank does so when its own particles need it, and no other rank waits:
//! its neighbours take its new clones and build the lists of their pairs with clones anew. Particles change hands only between two
//! neighbours that rebuild in the same step. Until then one that has crossed a border stays with its rank, and the allowance of its
//! reference, the nearest place inside, covers how far it is beyond.
//!
//! So that neighbours do meet, each tells with every update of clones at which step it means to rebuild next, as soon as its particles
//! are few steps from the ends of their allowances. A neighbour joins it if half of its own lists' life is over, or if it holds
//! particles for it. Of one whose particles cannot wait it is asked to.

use super::state::Dem;
use crate::exchange::Notice;
use grains_geometry::Vec3;

/// Steps by which a rebuild is announced beforehand.
const AHEAD: u64 = 4;

/// Steps from a rebuild until one that neighbours were asked for then.
const REQUEST: u64 = 2;

/// Steps at its present speed for which a particle beyond a border must have room: more than pass from a request until both ranks
/// rebuild.
pub(super) const STRAY_STEPS: f64 = 8.0;

/// When the lists of this rank are rebuilt.
#[derive(Clone, Debug, Default)]
pub(super) struct RebuildTimes {
    /// Whether they must be in this step.
    pub(super) is_due: bool,
    /// Step at which they are to be.
    pub(super) plan: Option<u64>,
    /// Step at which allowances are looked at again.
    next_look: u64,
    /// Steps that the lists before lasted, or would have (-).
    lifetime: f64,
    /// Largest share of an allowance used when they were rebuilt (-).
    pub(super) used: f64,
    /// Per peer, whether it is asked to rebuild at the planned step.
    pub(super) asks: Vec<bool>,
    /// Per peer, whether particles beyond the border are to go there.
    pub(super) holds: Vec<bool>,
}

impl RebuildTimes {
    /// What a peer is told.
    pub(super) fn notice(&self, rebuilds: bool, peer: usize) -> Notice {
        Notice { rebuilds, plan: self.plan, asks: self.asks.get(peer).is_some_and(|asks| *asks) }
    }

    fn plan_for(&mut self, step: u64) {
        self.plan = Some(self.plan.map_or(step, |plan| plan.min(step)));
    }
}

impl Dem {
    /// Whether this rank rebuilds its lists in this step.
    pub(super) fn rebuilds_now(&self) -> bool {
        self.times.is_due || self.times.plan.is_some_and(|plan| plan <= self.step)
    }

    /// Joins neighbours in what they have planned.
    pub(super) fn consider_notices(&mut self) {
        let Self { exchange, times, step, .. } = self;
        let is_ripe = 2.0 * self.steps_since_build as f64 >= times.lifetime;
        for (peer, notice) in exchange.notices().iter().enumerate() {
            let Some(plan) = notice.plan.filter(|plan| plan > step) else { continue };
            if notice.asks || is_ripe || times.holds.get(peer).is_some_and(|holds| *holds) {
                times.plan_for(plan);
            }
        }
    }

    /// Begins to count anew after a rebuild.
    pub(super) fn note_rebuild(&mut self) {
        let steps = self.steps_since_build as f64;
        self.steps_since_build = 0;
        self.report.rebuilds += 1;
        let times = &mut self.times;
        times.lifetime = if times.used > 0.0 { steps / times.used } else { f64::INFINITY };
        times.is_due = false;
        times.plan = times.plan.filter(|&plan| plan > self.step);
        times.next_look = self.step + 1;
        if times.asks.contains(&true) {
            self.times.plan_for(self.step + REQUEST);
        }
    }

    /// Plans a rebuild if particles are about to use up their allowances.
    ///
    /// |d + v t| = a at t = (√((d·v)² + v² (a² − d²)) − d·v) / v², if a particle goes on as it does now.
    pub(super) fn look_ahead(&mut self) {
        if !self.are_apart || self.step < self.times.next_look || self.times.plan.is_some() {
            return;
        }
        let Self { particles, neighbours, setup, .. } = &*self;
        let mut shortest = f64::INFINITY;
        let references = &neighbours.references;
        for (i, (body, reference)) in
            particles.bodies[..particles.owned].iter().zip(&references.places).enumerate()
        {
            let (way, v) = (body.position - reference.position, body.velocity);
            let turned = references.turned(particles, i);
            // What turning takes of the allowance grows by R ω.
            let turning = turned.map_or(0.0, |_| body.radius * body.angular_velocity.norm());
            let left = reference.allowance - turned.unwrap_or(0.0);
            shortest = shortest.min(time_until(&way, &v, left, turning));
        }
        let of_walls = self.wall_steps.saturating_sub(self.steps_since_build);
        let steps = (shortest / setup.parameters.dt).min(1e6).min(of_walls as f64);
        if steps <= AHEAD as f64 {
            self.times.plan_for(self.step + (steps as u64).max(1));
        } else {
            self.times.next_look = self.step + ((0.5 * steps) as u64).max(1);
        }
    }
}

/// Time (s) until a particle is an allowance (m) away from its reference, which shrinks at a rate (m/s).
fn time_until(way: &Vec3, velocity: &Vec3, allowance: f64, rate: f64) -> f64 {
    let left = allowance * allowance - way.norm_squared();
    if left <= 0.0 || allowance <= 0.0 {
        return 0.0;
    }
    if rate > 0.0 {
        return (allowance - way.norm()) / (velocity.norm() + rate);
    }
    let (along, speed) = (way.dot(velocity), velocity.norm_squared());
    if speed == 0.0 {
        return f64::INFINITY;
    }
    ((along * along + speed * left).sqrt() - along) / speed
}
