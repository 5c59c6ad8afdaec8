//! The particles of a case: when, where and how they are inserted.

mod kinds;
mod lattice;
mod rows;
mod window;

pub use kinds::KindRange;

use crate::error::RunError;
use crate::random::Draw;
use grains_case::{Case, Component, Insert, Orientation, Place, Scale, default_spacing};
use grains_dem::{Catalogue, Dem, Kind, NewParticle, Occupancy, ParticleRecord, Partner, Touch};
use grains_domain::Transport;
use grains_geometry::{Rotation, Vec3};
use kinds::component_kind;
use lattice::Sites;
use nalgebra::{Quaternion, Unit};
use rows::FileRows;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use window::{bounds, place_in_window};

/// What random numbers are for.
mod purpose {
    pub const KIND: u64 = 1;
    pub const ORIENTATION: u64 = 2;
    pub const NOISE: u64 = 3;
}

/// One `[[insert]]` and how far it has come.
#[derive(Clone, Debug)]
struct Block {
    insert: Insert,
    /// This rank's rows of its file, until all are inserted.
    rows: Option<FileRows>,
    first_id: u64,
    count: u64,
    done: u64,
    /// Step of the last batch and the first id in it.
    last_batch: (u64, u64),
}

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
        let (mut blocks, mut kinds) = (Vec::new(), Vec::new());
        for insert in &case.inserts {
            let rows = match &insert.place {
                Place::File { path } => Some(FileRows::read(case, insert, path, transport)?),
                _ => None,
            };
            for component in &insert.particles {
                match &rows {
                    Some(rows) => kinds.extend(kinds::of_rows(case, catalogue, (rows, component), transport)),
                    None => kinds.push(kinds::of_component(component)),
                }
            }
            let listed = rows.as_ref().map_or(u64::MAX, |rows| rows.total);
            let count = insert.count.unwrap_or(u64::MAX).min(listed);
            let (insert, last_batch) = (insert.clone(), (u64::MAX, 0));
            blocks.push(Block { insert, rows, first_id, count, done: 0, last_batch });
            first_id += count;
        }
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
        let of_block = |block: &Block| -> f64 {
            (block.first_id..block.first_id + block.count)
                .map(|id| block.kind_and_scale(id, case, self.seed, catalogue))
                .map(|(kind, scale)| catalogue.mass(kind, scale))
                .sum()
        };
        self.blocks.iter().map(of_block).sum()
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

impl Block {
    /// Whether its particles come from a file.
    fn is_listed(&self) -> bool {
        matches!(self.insert.place, Place::File { .. })
    }

    /// Takes so many particles for inserted.
    fn advance_to(&mut self, done: u64) {
        self.done = done;
        if done == self.count {
            self.rows = None;
        }
    }

    fn insert_until(
        &mut self,
        until: u64,
        index: usize,
        case: &Case,
        seed: u64,
        dem: &mut Dem,
        transport: &impl Transport,
    ) -> Result<bool, String> {
        let begun_at = self.done;
        let about = |message: String| match message.is_empty() {
            true => message,
            false => case.about(&format!("insert[{index}].place"), message),
        };
        let done = match self.insert.place {
            Place::Window { .. } => self.insert_through_window(until, case, seed, dem, transport),
            _ => self.insert_in_place(until, case, seed, dem, transport).map(|()| until),
        };
        self.advance_to(done.map_err(about)?);
        self.last_batch = (dem.step, self.first_id + begun_at);
        Ok(self.done > begun_at)
    }

    /// Inserts particles one by one where a window has room; returns how many are done.
    fn insert_through_window(
        &self,
        until: u64,
        case: &Case,
        seed: u64,
        dem: &mut Dem,
        transport: &impl Transport,
    ) -> Result<u64, String> {
        let Place::Window { window, attempts, retry } = &self.insert.place else { return Ok(self.done) };
        let (attempts, mut done) = (*attempts, self.done);
        let pause = retry.map_or(1, |t| (t / dem.setup.rates.dt).round().max(1.0) as u64);
        if !dem.step.is_multiple_of(pause) {
            return Ok(done);
        }
        let (lower, upper) = bounds(window);
        let mut occupancy = Occupancy::near(dem, &lower, &upper);
        while done < until {
            let new = self.particle(self.first_id + done, case, seed, dem);
            match place_in_window(new, window, attempts, seed, &occupancy, dem, transport) {
                Some(placed) => {
                    // The owner alone keeps its place: all ranks ask each other what is in the way.
                    if dem.owns(&placed.position) {
                        dem.insert(&placed.record(dem));
                        occupancy.add(placed);
                    }
                    done += 1;
                }
                // During the run the rest waits for room; at the first batch there is nothing to wait for.
                None if retry.is_some() || dem.step > 0 || self.insert.interval > 0.0 => break,
                None => {
                    return Err(format!(
                        "no room for particle {} of {} after {attempts} attempts; enlarge the window, insert fewer, or give place.retry (s) to wait for room",
                        done + 1,
                        self.count
                    ));
                }
            }
        }
        Ok(done)
    }

    /// Inserts the particles whose places are given: on a lattice each rank its own, from a file each rank those of its
    /// rows, wherever they belong.
    fn insert_in_place(
        &self,
        until: u64,
        case: &Case,
        seed: u64,
        dem: &mut Dem,
        transport: &impl Transport,
    ) -> Result<(), String> {
        let own = dem.decomposition.rank_at(dem.decomposition.coordinates);
        let mut sent: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        let mut outside: Option<NewParticle> = None;
        for id in self.own_ids(until, dem)? {
            let mut new = self.particle(id, case, seed, dem);
            new.position = Vec3::from(dem.setup.global.wrap(new.position.into()));
            let owner = dem.decomposition.owner(new.position.into());
            if owner != own && !self.is_listed() {
                continue;
            }
            if !dem.setup.global.contains(new.position.into()) {
                outside.get_or_insert(new);
            } else if owner == own {
                dem.insert(&new.record(dem));
            } else {
                new.record(dem).write(sent.entry(owner).or_default());
            }
        }
        refuse(outside, transport)?;
        if self.is_listed() {
            for (_, message) in transport.exchange_sparse(sent.into_iter().collect()) {
                let records = message.chunks_exact(ParticleRecord::LENGTH);
                records.for_each(|record| dem.insert(&ParticleRecord::read(record)));
            }
        }
        Ok(())
    }

    /// The next identities this rank has to look at, ascending: of its rows of a file, or on sites near its subdomain.
    fn own_ids(&self, until: u64, dem: &Dem) -> Result<Vec<u64>, String> {
        let due = self.done..until;
        if let Some(rows) = &self.rows {
            let (first, end) = (rows.own().start.max(due.start), rows.own().end.min(due.end));
            return Ok((first..end).map(|row| self.first_id + row).collect());
        }
        let sites =
            self.sites(dem).ok_or("room for no particle at all; enlarge the region or lower the spacing")?;
        let before = due.start - due.start % self.batch();
        let near = sites.near(&dem.decomposition, due.start - before..due.end - before);
        Ok(near.map(|site| self.first_id + before + site).collect())
    }

    /// Particles of a batch, which a lattice holds at once.
    fn batch(&self) -> u64 {
        self.insert.batch.unwrap_or(self.count).max(1)
    }

    fn sites(&self, dem: &Dem) -> Option<Sites> {
        let Place::Lattice { lower, upper, spacing, noise } = self.insert.place else { return None };
        let spacing = spacing.unwrap_or_else(|| default_spacing(dem.setup.largest_radius, noise));
        Sites::new(lower, upper, spacing, noise)
    }

    fn kind_and_scale(&self, id: u64, case: &Case, seed: u64, catalogue: &Catalogue) -> (Kind, f64) {
        let mut draw = Draw::new(seed, id, purpose::KIND);
        let component = choose(&self.insert.particles, draw.next());
        match &self.rows {
            Some(rows) => {
                let (kind, scale) = rows.kind(case, catalogue, id - self.first_id, component);
                (kind, scale.unwrap_or_else(|| sample(&component.scale, &mut draw)))
            }
            None => (component_kind(component), sample(&component.scale, &mut draw)),
        }
    }

    /// The particle of an id; in a window its position is still to be found.
    fn particle(&self, id: u64, case: &Case, seed: u64, dem: &Dem) -> NewParticle {
        let catalogue = &dem.setup.catalogue;
        let insert = &self.insert;
        let (kind, scale) = self.kind_and_scale(id, case, seed, catalogue);
        let mut new = NewParticle {
            id,
            kind,
            scale,
            position: Vec3::zeros(),
            orientation: orientation(&insert.orientation, &mut Draw::new(seed, id, purpose::ORIENTATION)),
            velocity: Vec3::from(insert.velocity),
            angular_velocity: Vec3::from(insert.angular_velocity),
        };
        if let Some(rows) = &self.rows {
            rows.apply(id - self.first_id, &mut new);
        } else if let Some(sites) = self.sites(dem) {
            let site = (id - self.first_id) % self.batch();
            new.position = sites.position(site, &mut Draw::new(seed, id, purpose::NOISE));
        }
        if case.holds_particles() {
            // A packing brings the velocities of its last moments.
            (new.velocity, new.angular_velocity) = (Vec3::zeros(), Vec3::zeros());
        }
        // The user's orientation is that of the shape as given; ours is that of its principal frame.
        let (to_user, center) = &catalogue.shapes[kind.shape as usize].user_to_body;
        if self.is_listed() {
            new.position += new.orientation * (center * scale);
        }
        new.orientation *= to_user;
        new
    }
}

/// An error of all ranks if any has met a particle outside the domain; the one of lowest id is named.
fn refuse(outside: Option<NewParticle>, transport: &impl Transport) -> Result<(), String> {
    let own = outside.map_or(f64::NEG_INFINITY, |new| -(new.id as f64));
    let mut lowest = [own];
    transport.max(&mut lowest);
    match outside {
        _ if lowest[0] == f64::NEG_INFINITY => Ok(()),
        Some(NewParticle { id, position, .. }) if own == lowest[0] => Err(format!(
            "particle {id} at ({}, {}, {}) lies outside the domain",
            position.x, position.y, position.z
        )),
        _ => Err(String::new()),
    }
}

fn partner_id(dem: &Dem, touch: &Touch) -> Option<u64> {
    match touch.other {
        Partner::Particle(j) => Some(dem.particles.ids[j]),
        Partner::Wall(_) => None,
    }
}

/// The component in whose share of [0, 1) a number falls.
fn choose(components: &[Component], number: f64) -> &Component {
    let total: f64 = components.iter().map(|c| c.share).sum();
    let mut rest = number * total;
    components
        .iter()
        .find(|c| {
            rest -= c.share;
            rest < 0.0
        })
        .unwrap_or(&components[components.len() - 1])
}

fn sample(scale: &Scale, draw: &mut Draw) -> f64 {
    match scale {
        Scale::Constant { value } => *value,
        Scale::Uniform { min, max } => min + (max - min) * draw.next(),
        Scale::Normal { mean, deviation, min, max } => loop {
            let value = mean + deviation * draw.normal();
            if (*min..=*max).contains(&value) {
                return value;
            }
        },
        Scale::Table { values, shares } => {
            let mut rest = draw.next() * shares.iter().sum::<f64>();
            let found = shares.iter().position(|s| {
                rest -= s;
                rest < 0.0
            });
            values[found.unwrap_or(values.len() - 1)]
        }
    }
}

fn orientation(wanted: &Orientation, draw: &mut Draw) -> Rotation {
    match wanted {
        Orientation::Aligned => Rotation::identity(),
        Orientation::Quaternion(q) => quaternion(*q),
        Orientation::Random => {
            // Uniform over all rotations (Shoemake 1992).
            let (u, v, w) = (draw.next(), TAU * draw.next(), TAU * draw.next());
            let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
            quaternion([a * v.sin(), a * v.cos(), b * w.sin(), b * w.cos()])
        }
    }
}

fn quaternion([w, x, y, z]: [f64; 4]) -> Rotation {
    Unit::new_normalize(Quaternion::new(w, x, y, z))
}
