//! The particles of a case: when, where and how they are inserted.

mod block;
mod draws;
mod kinds;
mod lattice;
mod rows;
mod window;

pub use kinds::KindRange;
pub use rows::Extremes;

use crate::changes::{Change, names};
use crate::error::RunError;
use crate::sizes::Sizes;
use block::Block;
pub use block::Progress;
use grains_case::{Case, Component, Insert};
use grains_dem::{Catalogue, Dem, Kind, Partner, PrescribedMotion, Touch};
use grains_domain::Transport;
use std::ops::Range;
use toml::{Table, Value};

/// All insertions of a case.
#[derive(Clone, Debug)]
pub struct Insertions {
    blocks: Vec<Block>,
    /// Beyond the identities of all particles so far, those still to come included.
    next_id: u64,
    kinds: Vec<KindRange>,
    seed: u64,
}

impl Insertions {
    /// Insertions of a case, none done; collective, each rank reads its share of the particle files.
    ///
    /// # Errors
    /// Particle files that cannot be read, or are wrong.
    pub fn read(case: &Case, catalogue: &Catalogue, transport: &impl Transport) -> Result<Self, RunError> {
        let mut first_id = 0;
        let (mut blocks, mut kinds) = (Vec::new(), Vec::<KindRange>::new());
        for insert in &case.inserts {
            let block = Block::read(case, insert, first_id, transport)?;
            first_id += block.count;
            kinds.extend(block.kinds(case, catalogue, transport));
            blocks.push(block);
        }
        let free = blocks.iter().filter(|block| !block.insert.is_prescribed());
        let is_alone = free.map(|block| block.count).sum::<u64>() == 1;
        kinds.iter_mut().for_each(|kind| kind.is_alone = is_alone);
        Ok(Self { blocks, next_id: first_id, kinds, seed: case.seed })
    }

    /// Every kind of particle that can be inserted and the scales it can have; a kind may come several times.
    pub fn kinds(&self) -> &[KindRange] {
        &self.kinds
    }

    /// The components of all insertions whose sizes are drawn, and these; before any is inserted.
    pub fn drawn_sizes(&self) -> impl Iterator<Item = (&Insert, &Component, &Sizes)> {
        self.blocks.iter().flat_map(Block::drawn_sizes)
    }

    /// Particles of all insertions together.
    pub fn total(&self) -> u64 {
        self.blocks.iter().map(|b| b.count).sum()
    }

    /// Particles of all insertions that do not stay where they are inserted.
    pub fn moving(&self) -> u64 {
        self.blocks.iter().filter(|b| !b.insert.is_fixed()).map(|b| b.count).sum()
    }

    /// The largest numbers of the file of an insertion that has one, by the number of the insertion; before any is inserted.
    pub fn file_extremes(&self, insert: usize) -> Option<Extremes> {
        self.blocks.get(insert)?.file_extremes()
    }

    /// Particles that an insertion has inserted so far, by its number.
    pub fn done(&self, insert: usize) -> Option<u64> {
        self.blocks.get(insert).map(|block| block.done)
    }

    /// Particles of an insertion, by its number.
    pub fn count(&self, insert: usize) -> u64 {
        self.blocks.get(insert).map_or(0, |block| block.count)
    }

    /// Mass of all particles (kg), those still to come included, before any is inserted; collective.
    pub fn mass(&self, case: &Case, catalogue: &Catalogue, transport: &impl Transport) -> f64 {
        self.sum(case, catalogue, |kind, scale| catalogue.mass(kind, scale), transport)
    }

    /// Sum of something over the kind and scale of all particles; as for [`Self::mass`].
    pub fn sum(
        &self,
        case: &Case,
        catalogue: &Catalogue,
        of: impl Fn(Kind, f64) -> f64,
        transport: &impl Transport,
    ) -> f64 {
        let share = |block: &Block| block.sum(case, self.seed, catalogue, &of, transport.rank());
        let mut sum = [self.blocks.iter().map(share).sum()];
        transport.sum(&mut sum);
        sum[0]
    }

    /// Whether particles of a kind and of scales (-) are among those that can be inserted, but for rounding.
    pub fn covers(&self, kind: Kind, smallest: f64, largest: f64) -> bool {
        let of_kind = || self.kinds.iter().filter(|range| range.kind == kind);
        let min = of_kind().map(|range| range.smallest).fold(f64::INFINITY, f64::min);
        let max = of_kind().map(|range| range.largest).fold(0.0, f64::max);
        smallest >= min * (1.0 - 1e-9) && largest <= max * (1.0 + 1e-9)
    }

    /// How far the insertions have come, in their order, for a checkpoint.
    pub fn progress(&self) -> String {
        let lines = self.blocks.iter().map(|block| block.progress().text());
        lines.chain([self.next_id.to_string()]).collect::<Vec<_>>().join("\n")
    }

    /// Continues where the insertions of a checkpoint's case stood at a time (s), as of [`Insertions::progress`].
    ///
    /// They are known by their names. Particles an insertion has inserted count, whatever it says now. The next batch of one that
    /// has changed is due at its start, now at the earliest, and so is the first of a new one. Returns the identities of the
    /// particles whose motion was prescribed and no longer is.
    ///
    /// # Errors
    /// Particles of prescribed motion whose insertion is no longer there, or gets further ones.
    pub fn restore(
        &mut self,
        before: &Table,
        progress: &str,
        changes: &[Change],
        time: f64,
    ) -> Result<Vec<Range<u64>>, String> {
        let names = names(before, "insert");
        let mut lines: Vec<&str> = progress.lines().collect();
        let mut next_id = lines.pop().and_then(|id| id.parse().ok()).unwrap_or(0);
        let known: Vec<Option<Progress>> = lines.into_iter().map(Progress::parse).collect();
        let mut released = Vec::new();
        for (name, old) in names.iter().zip(&known) {
            let Some(old) = old.filter(|old| old.done() > 0) else { continue };
            let was_prescribed = was_prescribed(before, name);
            match self.blocks.iter().find(|block| block.insert.name == *name) {
                None if was_prescribed => {
                    return Err(format!(
                        "insert.{name} is gone: the motion of its particles, which are there, would be known no longer; keep it, with motion = \"free\" to let them go"
                    ));
                }
                Some(block)
                    if (was_prescribed || block.insert.is_prescribed()) && block.count > old.count() =>
                {
                    return Err(format!(
                        "insert.{name}.count = {}, was {}: the motion of its particles is prescribed, and further ones would not be of the same insertion; add another [[insert]]",
                        block.count,
                        old.count()
                    ));
                }
                Some(block) if was_prescribed && !block.insert.is_prescribed() => released.push(old.ids()),
                _ => {}
            }
        }
        for block in &mut self.blocks {
            let old = names.iter().position(|name| *name == block.insert.name);
            let old = old.and_then(|old| known.get(old).copied().flatten());
            // What its particles do changes none of its batches.
            let is_of_batches = |change: &&Change| change.key.get(2).is_none_or(|key| key != "motion");
            let is_changed = changes
                .iter()
                .filter(is_of_batches)
                .any(|change| change.is_within(&["insert", &block.insert.name]));
            block.go_on(old, is_changed, &mut next_id, time);
        }
        self.next_id = next_id;
        Ok(released)
    }

    /// Changes the batches still to come of an insertion: particles per batch, time between them (s), and when the next is due (s).
    ///
    /// # Errors
    /// A name of no insertion.
    pub fn set_batches(&mut self, name: &str, batch: u64, interval: f64, next: f64) -> Result<(), String> {
        let names = || self.blocks.iter().map(|b| b.insert.name.as_str()).collect::<Vec<_>>().join(", ");
        let missing = format!("no insertion is called `{name}`; there are {}", names());
        let block = self.blocks.iter_mut().find(|b| b.insert.name == name).ok_or(missing)?;
        (block.insert.batch, block.insert.interval) = (Some(batch), interval);
        (block.before, block.start) = (block.done, next);
        Ok(())
    }

    /// What prescribes the motion of particles; nothing has to where none of a case moves.
    pub fn prescribed_motions(&self, case: &Case) -> Vec<PrescribedMotion> {
        if case.holds_particles() {
            Vec::new()
        } else {
            self.blocks.iter().filter_map(Block::prescribed_motion).collect()
        }
    }

    /// The insertion a particle comes from, and its index; none if that was one of an earlier case.
    fn origin(&self, id: u64) -> Option<(usize, &Block)> {
        self.blocks.iter().enumerate().find(|(_, b)| id >= b.first_id && id - b.first_id < b.count)
    }

    /// What is wrong with the particles inserted at the present step, if one starts inside another or a wall;
    /// each rank knows of its own.
    pub fn starting_overlap(&self, case: &Case, dem: &Dem) -> Option<String> {
        let mut worst: Option<(f64, Touch)> = None;
        dem.for_each_contact(|touch| {
            let ids = [Some(dem.particles.ids[touch.particle]), partner_id(dem, touch)];
            let is_new = |id: u64| {
                let block = self.origin(id).map(|(_, block)| block);
                block.is_some_and(|block| block.last_batch.0 == dem.step && id >= block.last_batch.1)
            };
            // A settled state from a file may overlap a little.
            let is_listed =
                ids.into_iter().flatten().all(|id| self.origin(id).is_some_and(|(_, b)| b.is_listed()));
            let allowed = if is_listed { dem.setup.overlap_limit } else { 1e-9 };
            let ratio = touch.overlap / touch.radius;
            if ids.into_iter().flatten().any(is_new)
                && ratio > allowed
                && worst.as_ref().is_none_or(|(w, _)| ratio > *w)
            {
                worst = Some((ratio, *touch));
            }
        });
        let (ratio, touch) = worst?;
        let id = dem.particles.ids[touch.particle];
        let other = match (touch.other, partner_id(dem, &touch)) {
            (Partner::Wall(w), _) => format!("wall `{}`", dem.setup.walls[w].name),
            (_, other) => {
                let other = other.unwrap_or(0);
                let name = self.origin(other).map_or("(earlier)", |(_, block)| &block.insert.name);
                format!("particle {other} of insert `{name}`")
            }
        };
        let x = dem.particles.bodies[touch.particle].position;
        let remedy = match self.origin(id).is_some_and(|(_, block)| block.is_listed()) {
            true => "mend the file, whose radii are half the diameters, or move the wall",
            false => "move the insertion region away, or raise `spacing` or lower `noise`",
        };
        let message = format!(
            "particle {id} at ({:.6}, {:.6}, {:.6}) starts {:.3e} m inside {other}, {:.2} % of its radius: {remedy}",
            x.x,
            x.y,
            x.z,
            touch.overlap,
            100.0 * ratio
        );
        let index = self.origin(id).map_or(0, |(index, _)| index);
        Some(case.about(&format!("insert[{index}].place"), message))
    }

    /// Insertions that are not complete: their names, and how many particles each still lacks.
    pub fn missing(&self) -> impl Iterator<Item = (&str, u64)> {
        self.blocks.iter().filter(|b| !b.is_complete()).map(|b| (&*b.insert.name, b.count - b.done))
    }

    /// Whether every insertion is complete.
    pub fn is_complete(&self) -> bool {
        self.blocks.iter().all(Block::is_complete)
    }

    /// Inserts what is due at the present step; returns whether anything was. Collective.
    ///
    /// # Errors
    /// A particle of a first batch for which there is no room, or one outside the domain: an error of all ranks, without
    /// text on those that did not meet it.
    pub fn insert_due(
        &mut self,
        case: &Case,
        dem: &mut Dem,
        transport: &impl Transport,
    ) -> Result<bool, String> {
        let mut inserted = false;
        for (index, block) in self.blocks.iter_mut().enumerate() {
            let batch = block.insert.batch.unwrap_or(block.count).max(1);
            let batches = (block.done.max(block.before) - block.before) / batch;
            let due = block.start + batches as f64 * block.insert.interval;
            if block.is_complete() || dem.step < dem.origin.step_at(due, dem.setup.parameters.dt) {
                continue;
            }
            let until = (block.before + (batches + 1) * batch).min(block.count);
            inserted |= block.insert_until(until, index, case, self.seed, dem, transport)?;
        }
        if inserted {
            dem.announce_insertion();
        }
        Ok(inserted)
    }
}

/// Whether an earlier case prescribed the motion of the particles of an insertion.
fn was_prescribed(before: &Table, name: &str) -> bool {
    let inserts = before.get("insert").and_then(Value::as_array).into_iter().flatten();
    let mut own = inserts.filter(|insert| insert.get("name").and_then(Value::as_str) == Some(name));
    let usual = || before.get("fluid")?.get("resolved")?.get("motion");
    let motion = own.next().and_then(|insert| insert.get("motion").or_else(usual));
    motion.is_some_and(|motion| motion.as_str() != Some("free"))
}

fn partner_id(dem: &Dem, touch: &Touch) -> Option<u64> {
    match touch.other {
        Partner::Particle(j) => Some(dem.particles.ids[j]),
        Partner::Wall(_) => None,
    }
}
