//! The rebuild: particles change hands, are sorted, cloned, and listed anew.

use super::rebuild_times::STRAY_STEPS;
use super::report::Failure;
use super::setup::DemSetup;
use super::state::Dem;
use crate::bonds::{BondKind, Forming};
use crate::clock::Phase;
use crate::contact_history::{BondHistory, SavedHistories};
use crate::error::{StepError, vector};
use crate::exchange::KeptClones;
use crate::tunnelling;
use crate::verlet::{BondChanges, Extent, ListContext, Stray, cutoffs, sort};
use grains_domain::{Cells, Transport};

/// Neighbours whose lists are rebuilt in the same step, and the clones of the particles of others.
struct Partners {
    /// Per peer, whether it is one.
    rebuilding: Vec<bool>,
    /// None if all ranks rebuild.
    kept: Option<KeptClones>,
}

impl Dem {
    /// Rebuilds the lists of all ranks; collective.
    pub(super) fn rebuild_all(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        self.is_alone = self.is_alone(transport);
        self.report.common_rebuilds += 1;
        self.save_history();
        let rebuilding = vec![true; self.exchange.neighbours()];
        self.rebuild(Partners { rebuilding, kept: None }, transport)
    }

    /// Rebuilds the lists of this rank, while neighbours say with their updates whether they do so too.
    pub(super) fn rebuild_own(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        let Self { exchange, particles, times, .. } = self;
        exchange.start_notices(|peer| times.notice(true, peer), transport);
        exchange.finish_update(particles, transport);
        let rebuilding = exchange.notices().iter().map(|notice| notice.rebuilds).collect();
        self.clock.charge(Phase::Clones);
        self.store_history(Extent::All);
        let kept = self.exchange.take_clones(&mut self.particles, &mut self.neighbours.references);
        self.rebuild(Partners { rebuilding, kept: Some(kept) }, transport)?;
        self.consider_notices();
        Ok(())
    }

    fn rebuild(&mut self, partners: Partners, transport: &impl Transport) -> Result<(), Failure> {
        self.count_crossings();
        self.times.used = 0.0;
        if !self.is_alone {
            self.check_jumps();
        }
        self.report.work = self.work();
        let Self { particles, histories, exchange, .. } = self;
        let migration = exchange.migrate(particles, histories, &partners.rebuilding, transport);
        self.ledger.left += migration.left.len() as u64;
        self.bond_ledger.left += migration.bonds_left;
        self.passages.left.extend(migration.carriers_left);
        self.error = self.error.take().or(migration.failure);
        self.note_failure();
        if !self.are_apart {
            self.settle(transport)?;
        }
        self.let_liquid_leave(&migration.left);
        self.let_heat_leave(&migration.left);
        self.let_species_leave(&migration.left);
        self.sort_and_list(&migration.stays, migration.bonds_left > 0, &partners, transport)?;
        // The history is in the lists now.
        self.histories = SavedHistories::default();
        self.history_saved = false;
        self.note_rebuild();
        Ok(())
    }

    /// Moves borders between subdomains, if that is due and worth it; returns whether they moved, the same on all ranks: all have to
    /// rebuild their lists then.
    pub(super) fn balance(&mut self, transport: &impl Transport) -> bool {
        let Some(balance) = self.setup.balance.filter(|_| transport.size() > 1) else { return false };
        if self.step < self.next_balance {
            return false;
        }
        let Self { particles, neighbours, setup, work, other_work, .. } = self;
        work.clear();
        let own = particles.bodies.iter().take(particles.owned);
        for (body, contacts) in own.zip(neighbours.work_of_each(particles.owned)) {
            work.add(&setup.global, body.position.into(), contacts + other_work.per_particle);
        }
        work.sum(transport);
        other_work.add_cells(work, &setup.global);
        match self.decomposition.rebalanced(work, &balance) {
            None => {
                self.next_balance = self.step + balance.interval;
                false
            }
            Some(cuts) => {
                self.decomposition.cuts = cuts;
                self.exchange.divide(&self.decomposition);
                self.report.moves += 1;
                true
            }
        }
    }

    /// Sorts the particles that stay, takes clones, and builds the lists. Bonded particles `have_left` the box, or not.
    fn sort_and_list(
        &mut self,
        stays: &[u32],
        have_left: bool,
        partners: &Partners,
        transport: &impl Transport,
    ) -> Result<(), Failure> {
        let (wall_allowance, wall_steps) = self.wall_allowance();
        let loaded_allowance = self.loaded_allowance();
        let (slide, slide_steps) = self.slide_allowance();
        (self.wall_steps, self.way_left) = (wall_steps.min(slide_steps), loaded_allowance);
        let due: Vec<bool> = self.due_bonds().collect();
        let dt_of_bonds = self.dt_before.unwrap_or(self.setup.parameters.dt);
        let is_of_all = partners.kept.is_none();
        let speed =
            stays.iter().map(|&i| self.particles.bodies[i as usize].velocity.norm()).fold(0.0, f64::max);
        let stray = STRAY_STEPS * speed.max(self.wall_speed()) * self.setup.parameters.dt;
        let (bonds_way, mut have_left) = self.bonds_way(speed, have_left, transport);
        let largest_range = if self.are_apart { self.largest_range() } else { f64::INFINITY };
        let Self { particles, histories, decomposition, setup, exchange, neighbours, agreement, .. } = self;
        let forming = due.contains(&true).then(|| Forming {
            kinds: &setup.bonds,
            is_due: due.clone(),
            dt: dt_of_bonds,
        });
        let reach = setup.reach().max(forming.as_ref().map_or(0.0, Forming::reach));
        let mut context = ListContext {
            slide,
            forming: forming.as_ref(),
            stray,
            ..ListContext::new(setup, decomposition, (&self.states, self.images.as_ref()), reach)
        };
        context.is_apart = self.are_apart;
        context.time = self.origin.time_of(self.step, setup.parameters.dt);
        let (needs, counts) = cutoffs(particles, stays, &context);
        agreement.needs = needs;
        if is_of_all {
            agreement.agree_on_ranges(largest_range, transport);
        }
        let ranges = &agreement.ranges;
        let cells = Cells::new(decomposition, setup.largest_radius, ranges, &counts);
        let (cell_list, order) = sort(particles, stays, cells);
        particles.reorder(&order);
        neighbours.wall_allowance = wall_allowance + loaded_allowance;
        neighbours.references.choose(particles, &context, context.is_apart.then_some(ranges));
        let largest = ranges.iter().fold(0.0, |w: f64, &x| w.max(x));
        let of_each = |i: usize| {
            let of_contacts = neighbours.references.range_of(particles, i, context.gap()) + largest;
            let way = bonds_way.unwrap_or(neighbours.references.places[i].allowance + largest);
            let longest = |bond: &BondHistory| {
                setup.bonds[usize::from(bond.kind)].longest_stretch() * bond.state.length + way
            };
            histories.bonds.row(order[i] as usize).iter().map(longest).fold(of_contacts, f64::max)
        };
        let of_each: Vec<f64> = (0..particles.owned).map(of_each).collect();
        let others = (&partners.rebuilding[..], partners.kept.as_ref());
        let both = (&mut *particles, &mut neighbours.references);
        have_left |= exchange.create_clones(both, &of_each, others, have_left, transport);
        context.may_leave = have_left;
        let BondChanges { made, left, error } =
            neighbours.build(particles, &cell_list, (histories, &order), &context);
        let checked =
            forming.map_or(Ok(()), |forming| forming.check(&neighbours.bonds, particles, transport));
        if self.are_apart {
            self.cell_list = cell_list;
        }
        if checked.is_ok() {
            self.made_bonds.iter_mut().zip(due).for_each(|(made, is_due)| *made |= is_due);
        }
        self.break_bridges_out_of_lists(Some(&order));
        self.bond_ledger.made += made.ends;
        self.bond_ledger.left += left;
        self.error = self.error.take().or(error).or(made.error).or(checked.err());
        if self.are_apart {
            self.hold_strays();
            self.note_failure();
            return Ok(());
        }
        self.settle(transport)
    }

    /// Takes the new clones of neighbours that have rebuilt their lists, and builds those of the pairs with clones anew.
    pub(super) fn rebuild_border(&mut self, transport: &impl Transport) {
        let rebuilding: Vec<bool> = self.exchange.notices().iter().map(|notice| notice.rebuilds).collect();
        // Bridges are counted over all pairs.
        let extent = if self.particles.is_wet() { Extent::All } else { Extent::Border };
        self.store_history(extent);
        let Self { particles, histories, decomposition, setup, exchange, neighbours, .. } = self;
        let kept = exchange.take_clones(particles, &mut neighbours.references);
        let both = (&mut *particles, &mut neighbours.references);
        let may_leave = exchange.take_new_clones(both, (&rebuilding, &kept), transport);
        let images = self.images.as_ref();
        let context = ListContext {
            may_leave,
            ..ListContext::new(setup, decomposition, (&self.states, images), setup.reach())
        };
        let changes = neighbours.rebuild_border(particles, &self.cell_list, histories, &context);
        self.report.border_rebuilds += 1;
        self.break_bridges_out_of_lists(None);
        self.bond_ledger.left += changes.left;
        self.error = self.error.take().or(changes.error);
        self.histories = SavedHistories::default();
    }

    /// Notes which neighbours the particles beyond the borders are to go to, and asks for it where they cannot wait.
    fn hold_strays(&mut self) {
        let peers = self.exchange.neighbours();
        let Self { particles, decomposition, neighbours, exchange, times, error, .. } = self;
        (times.asks, times.holds) = (vec![false; peers], vec![false; peers]);
        for &Stray { particle, beyond, can_wait } in &neighbours.references.strays {
            let i = particle as usize;
            let body = &particles.bodies[i];
            let owner = decomposition.owner(decomposition.global.wrap(body.position.into()));
            let Some(peer) = exchange.peer(owner) else { continue };
            times.holds[peer] = true;
            times.asks[peer] |= !can_wait;
            if neighbours.references.places[i].allowance < beyond {
                let (place, velocity) = (vector(&body.position), vector(&body.velocity));
                let found = StepError::FarJump { id: particles.ids[i], place, velocity };
                *error = error.take().or(Some(found));
            }
        }
    }

    /// Whether the bonds of each kind are to be made now.
    fn due_bonds(&self) -> impl Iterator<Item = bool> {
        let is_due = |kind: &BondKind| self.origin.step_at(kind.time, self.setup.parameters.dt) <= self.step;
        self.setup.bonds.iter().zip(&self.made_bonds).map(move |(kind, is_made)| !is_made && is_due(kind))
    }

    /// Whether bonds of some kind are to be made now.
    pub(super) fn is_bond_due(&self) -> bool {
        self.due_bonds().any(|is_due| is_due)
    }

    /// How much longer (m) bonds may be than when they were last seen, where all ranks rebuild their lists at once: twice the way of the
    /// fastest particle in a step; and whether bonded particles may be gone, as some `have_left` the box. Elsewhere each rank tells
    /// its neighbours of the latter.
    fn bonds_way(&self, speed: f64, have_left: bool, transport: &impl Transport) -> (Option<f64>, bool) {
        if self.setup.bonds.is_empty() || self.are_apart {
            return (None, have_left);
        }
        let mut numbers = [speed, f64::from(u8::from(have_left))];
        transport.max(&mut numbers);
        (Some(2.0 * numbers[0] * self.setup.parameters.dt), numbers[1] > 0.0)
    }

    /// Whether there is one particle at most, and no wall: nothing can be missed, however far it goes.
    fn is_alone(&self, transport: &impl Transport) -> bool {
        let mut count = [self.particles.owned as u64];
        if self.setup.walls.is_empty() {
            transport.sum_counts(&mut count);
        }
        self.setup.walls.is_empty() && count[0] < 2
    }

    /// Looks how much of their allowances particles have used. One that outran a cell since the last check may have passed through
    /// another.
    fn check_jumps(&mut self) {
        let references = &self.neighbours.references;
        for (i, reference) in references.places.iter().enumerate().take(self.particles.owned) {
            let body = &self.particles.bodies[i];
            let mut distance = (body.position - reference.position).norm();
            distance += references.turned(&self.particles, i).unwrap_or(0.0);
            self.times.used = self.times.used.max(distance / reference.allowance);
            let thickness = tunnelling::half_thickness(&self.setup.catalogue, body);
            if distance > reference.allowance + thickness {
                let found = StepError::Jump {
                    id: self.particles.ids[i],
                    distance,
                    allowed: reference.allowance + thickness,
                    place: vector(&body.position),
                    velocity: vector(&body.velocity),
                };
                self.error = self.error.take().or(Some(found));
            }
        }
    }

    /// Largest speed (m/s) of any wall in the steps to come.
    fn wall_speed(&self) -> f64 {
        let now = self.time();
        let horizon = self.setup.skin.horizon.max(1.0) * self.setup.parameters.dt;
        let moving = self.setup.walls.iter().filter(|w| now < w.until);
        let soon = moving.filter(|wall| wall.motion.moves_next(now) - now <= horizon);
        soon.map(|wall| wall.motion.max_speed(corner(&self.setup))).fold(0.0, f64::max)
    }

    /// How far (m) walls may move before the lists are rebuilt, and after how many steps that is due.
    fn wall_allowance(&self) -> (f64, u64) {
        let (dt, now) = (self.setup.parameters.dt, self.time());
        let corner = corner(&self.setup);
        let horizon = self.setup.skin.horizon.max(1.0);
        let (mut speed, mut pause) = (0.0_f64, f64::INFINITY);
        for wall in self.setup.walls.iter().filter(|w| now < w.until) {
            let wait = (wall.motion.moves_next(now) - now) / dt;
            if wait <= horizon {
                speed = speed.max(wall.motion.max_speed(corner));
            } else {
                pause = pause.min(wait);
            }
        }
        if speed == 0.0 {
            return (0.0, pause as u64);
        }
        let max = self.setup.skin.max * self.setup.largest_radius;
        let steps = (max / (speed * dt)).min(horizon).max(1.0).floor();
        (speed * dt * steps, steps as u64)
    }
}

/// Distance (m) from the origin that no point of the box exceeds.
fn corner(setup: &DemSetup) -> f64 {
    let global = &setup.global;
    let squares = (0..3).map(|a| global.lower[a].abs().max(global.upper[a].abs()).powi(2));
    squares.sum::<f64>().sqrt()
}
