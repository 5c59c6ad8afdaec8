//! The particles of a case: when, where and how they are inserted.

mod block;
mod draws;
mod kinds;
mod lattice;
mod rows;
mod window;

pub use kinds::KindRange;

use crate::error::RunError;
use block::Block;
use grains_case::Case;
use grains_dem::{Catalogue, Dem, Partner, Touch};
use grains_domain::Transport;

/// All insertions of a case.
#[derive(Clone, Debug)]
pub struct Population {
    blocks: Vec<Block>,
    kinds: Vec<KindRange>,
    seed: u64,
}

impl Population {
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
        let is_alone = first_id == 1;
        kinds.iter_mut().for_each(|kind| kind.is_alone = is_alone);
        Ok(Self { blocks, kinds, seed: case.seed })
    }

    /// Every kind of particle that can be inserted and the scales it can have; a kind may come several times.
    pub fn kinds(&self) -> &[KindRange] {
        &self.kinds
    }

    /// Particles of all insertions together.
    pub fn total(&self) -> u64 {
        self.blocks.iter().map(|b| b.count).sum()
    }

    /// Mass of all particles (kg), those still to come included; for a single rank, and before any is inserted.
    pub fn mass(&self, case: &Case, catalogue: &Catalogue) -> f64 {
        self.blocks.iter().map(|block| block.mass(case, self.seed, catalogue)).sum()
    }

    /// Particles inserted so far, per insertion.
    pub fn done(&self) -> Vec<i64> {
        self.blocks.iter().map(|b| b.done as i64).collect()
    }

    /// Continues where a checkpoint stood.
    pub fn restore(&mut self, done: &[i64]) {
        for (block, &done) in self.blocks.iter_mut().zip(done) {
            block.advance_to(done as u64);
        }
    }

    /// Index of the insertion a particle comes from.
    fn origin(&self, id: u64) -> usize {
        self.blocks.partition_point(|b| id >= b.first_id && id - b.first_id >= b.count)
    }

    /// What is wrong with the particles inserted at the present step, if one starts inside another or a wall;
    /// each rank knows of its own.
    pub fn starting_overlap(&self, case: &Case, dem: &Dem) -> Option<String> {
        let mut worst: Option<(f64, Touch)> = None;
        dem.for_each_contact(|touch| {
            let ids = [Some(dem.particles.ids[touch.particle]), partner_id(dem, touch)];
            let is_new = |id: u64| {
                let block = &self.blocks[self.origin(id)];
                block.last_batch.0 == dem.step && id >= block.last_batch.1
            };
            // A settled state from a file may overlap a little.
            let is_listed = ids.into_iter().flatten().all(|id| self.blocks[self.origin(id)].is_listed());
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
                format!("particle {other} of insert `{}`", self.blocks[self.origin(other)].insert.name)
            }
        };
        let x = dem.particles.bodies[touch.particle].position;
        let message = format!(
            "particle {id} at ({:.6}, {:.6}, {:.6}) starts {:.3e} m inside {other}, {:.2} % of its radius: move the insertion region away, or raise `spacing` or lower `noise`",
            x.x,
            x.y,
            x.z,
            touch.overlap,
            100.0 * ratio
        );
        Some(case.about(&format!("insert[{}].place", self.origin(id)), message))
    }

    /// Insertions that are not complete: their names, and how many particles each still lacks.
    pub fn missing(&self) -> impl Iterator<Item = (&str, u64)> {
        self.blocks.iter().filter(|b| b.done < b.count).map(|b| (&*b.insert.name, b.count - b.done))
    }

    /// Whether every insertion is complete.
    pub fn is_complete(&self) -> bool {
        self.blocks.iter().all(|b| b.done == b.count)
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
            let batches = block.done / batch;
            let due = block.insert.start + batches as f64 * block.insert.interval;
            if block.done == block.count || dem.step < (due / dem.setup.rates.dt).round() as u64 {
                continue;
            }
            let until = ((batches + 1) * batch).min(block.count);
            inserted |= block.insert_until(until, index, case, self.seed, dem, transport)?;
        }
        if inserted {
            dem.announce_insertion();
        }
        Ok(inserted)
    }
}

fn partner_id(dem: &Dem, touch: &Touch) -> Option<u64> {
    match touch.other {
        Partner::Particle(j) => Some(dem.particles.ids[j]),
        Partner::Wall(_) => None,
    }
}
