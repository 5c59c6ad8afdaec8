//! The rebuild: particles change hands, are sorted, cloned, and listed anew.

use super::report::Failure;
use super::state::Dem;
use crate::bonds::{BondKind, Forming};
use crate::contact_history::{BondHistory, SavedHistories};
use crate::error::{StepError, vector};
use crate::flow_planes::count_crossings;
use crate::tunnelling;
use crate::verlet::{BondChanges, CellList, ListContext, cutoffs};
use grains_domain::{Cells, Transport};

impl Dem {
    pub(super) fn rebuild(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        count_crossings(&mut self.particles, &self.setup.planes, &self.setup.global, &mut self.crossings);
        if !self.is_alone(transport) {
            self.check_jumps();
        }
        self.report.work = self.work();
        let has_moved = self.balance(transport);
        self.save_history();
        let Self { particles, histories, exchange, .. } = self;
        let (mut stays, mut left) = (Vec::new(), Vec::new());
        match exchange.migrate(particles, histories, transport) {
            Ok(migration) => {
                left = migration.left;
                self.ledger.left += left.len() as u64;
                self.bond_ledger.left += migration.bonds_left;
                self.passages.left.extend(migration.carriers_left);
                stays = migration.stays;
            }
            Err(error) => self.error = self.error.take().or(Some(error)),
        }
        self.check(transport)?;
        self.let_liquid_leave(&left);
        self.let_heat_leave(&left);
        self.let_species_leave(&left);
        let bonded = self.since_bonds_were_seen(left.len() as u64, transport);
        self.sort_and_list(&stays, bonded, transport)?;
        // The history is in the lists now.
        self.histories = SavedHistories::default();
        self.history_saved = false;
        // Borders that went as far as they may go on in the next step.
        self.stale = has_moved;
        self.steps_since_build = 0;
        self.report.rebuilds += 1;
        Ok(())
    }

    /// Moves borders between subdomains, if that is due and worth it; returns whether they moved, the same on all ranks.
    fn balance(&mut self, transport: &impl Transport) -> bool {
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

    /// Bonds may be longer by `way` (m) than when they were last seen; partners are missing only if some `have_left`.
    fn sort_and_list(
        &mut self,
        stays: &[u32],
        (way, have_left): (f64, bool),
        transport: &impl Transport,
    ) -> Result<(), Failure> {
        let (wall_allowance, wall_steps) = self.wall_allowance();
        let loaded_allowance = self.loaded_allowance();
        let (slide, slide_steps) = self.slide_allowance();
        (self.wall_steps, self.way_left) = (wall_steps.min(slide_steps), loaded_allowance);
        let due: Vec<bool> = self.due_bonds().collect();
        let dt_of_bonds = self.dt_before.unwrap_or(self.setup.parameters.dt);
        let Self { particles, histories, decomposition, setup, exchange, neighbours, .. } = self;
        let forming = due.contains(&true).then(|| Forming {
            kinds: &setup.bonds,
            is_due: due.clone(),
            dt: dt_of_bonds,
        });
        let context = ListContext {
            decomposition,
            catalogue: &setup.catalogue,
            walls: &setup.walls,
            states: &self.states,
            skin: setup.skin,
            largest_radius: setup.largest_radius,
            reach: setup.reach().max(forming.as_ref().map_or(0.0, Forming::reach)),
            images: self.images.as_ref(),
            slide,
            forming: forming.as_ref(),
            conducts: setup.thermal.is_some(),
            may_leave: have_left,
            dt: setup.parameters.dt,
            time: self.origin.time_of(self.step, setup.parameters.dt),
        };
        let (mut ranges, counts) = cutoffs(particles, stays, &context);
        transport.max(&mut ranges);
        let cells = Cells::new(decomposition, setup.largest_radius, &ranges, &counts);
        let cell_list = CellList::new(particles, stays, cells);
        particles.reorder(&cell_list.order);
        neighbours.wall_allowance = wall_allowance + loaded_allowance;
        neighbours.choose_allowances(particles, &context);
        let largest = ranges.iter().fold(0.0, |w: f64, &x| w.max(x));
        let range = |i: usize| {
            let of_contacts = neighbours.range_of(particles, i, context.gap()) + largest;
            let row = histories.bonds.row(cell_list.order[i] as usize);
            let longest = |bond: &BondHistory| {
                setup.bonds[usize::from(bond.kind)].longest_stretch() * bond.state.length + way
            };
            row.iter().map(longest).fold(of_contacts, f64::max)
        };
        let ranges: Vec<f64> = (0..particles.owned).map(range).collect();
        exchange.create_clones(particles, &ranges, transport);
        let BondChanges { made, left, error } = neighbours.build(particles, &cell_list, histories, &context);
        let checked =
            forming.map_or(Ok(()), |forming| forming.check(&neighbours.bonds, particles, transport));
        if checked.is_ok() {
            self.made_bonds.iter_mut().zip(due).for_each(|(made, is_due)| *made |= is_due);
        }
        self.break_bridges_out_of_lists(&cell_list.order);
        self.bond_ledger.made += made.ends;
        self.bond_ledger.left += left;
        self.error = self.error.take().or(error).or(made.error).or(checked.err());
        self.check(transport)
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

    /// Twice the way (m) that the fastest particle of all ranks goes in a step, and whether particles have just left the box on any
    /// rank, if there are bonds.
    fn since_bonds_were_seen(&self, left: u64, transport: &impl Transport) -> (f64, bool) {
        if self.setup.bonds.is_empty() {
            return (0.0, false);
        }
        let speeds = self.particles.bodies.iter().map(|body| body.velocity.norm());
        let mut numbers = [speeds.fold(0.0, f64::max), left as f64];
        transport.max(&mut numbers);
        (2.0 * numbers[0] * self.setup.parameters.dt, numbers[1] > 0.0)
    }

    /// Whether there is one particle at most, and no wall: nothing can be missed, however far it goes.
    fn is_alone(&self, transport: &impl Transport) -> bool {
        let mut count = [self.particles.owned as u64];
        if self.setup.walls.is_empty() {
            transport.sum_counts(&mut count);
        }
        self.setup.walls.is_empty() && count[0] < 2
    }

    /// A particle that outran a cell since the last check may have passed through another.
    fn check_jumps(&mut self) {
        let references = &self.neighbours.references;
        for (i, reference) in references.iter().enumerate().take(self.particles.owned) {
            let body = &self.particles.bodies[i];
            let mut distance = (body.position - reference.position).norm();
            if let Some(before) = self.neighbours.reference_orientations.get(i) {
                // A rotation by θ changes the quaternion by 2 sin(θ/4), and moves no point by more than R θ.
                let turned = (self.particles.orientations[i].coords - before.coords).norm();
                distance += 2.0 * body.radius * turned;
            }
            let thickness = tunnelling::half_thickness(&self.setup.catalogue, body);
            if distance > reference.allowance + thickness {
                self.error = Some(StepError::Jump {
                    id: self.particles.ids[i],
                    distance,
                    allowed: reference.allowance + thickness,
                    place: vector(&body.position),
                    velocity: vector(&body.velocity),
                });
            }
        }
    }

    /// How far (m) walls may move before the lists are rebuilt, and after how many steps that is due.
    fn wall_allowance(&self) -> (f64, u64) {
        let (global, dt, now) = (&self.setup.global, self.setup.parameters.dt, self.time());
        let corner =
            (0..3).map(|a| global.lower[a].abs().max(global.upper[a].abs()).powi(2)).sum::<f64>().sqrt();
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
