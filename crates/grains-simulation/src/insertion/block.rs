//! One insertion: when its particles are due, and how they get to the ranks that own them.

use super::draws::{choose, orientation, purpose};
use super::kinds::{KindRange, of_component, of_rows};
use super::lattice::Sites;
use super::rows::{Extremes, FileRows, component_kind};
use super::window::{Round, Turns, bounds};
use crate::error::RunError;
use crate::heat;
use crate::random::Draw;
use crate::sizes::Sizes;
use crate::system;
use grains_case::{
    Basis, Case, Component, Insert, Motion as CaseMotion, ParticleMotion, Place, default_spacing,
};
use grains_dem::{Catalogue, Dem, Kind, Motion, NewParticle, Occupancy, ParticleRecord, PrescribedMotion};
use grains_domain::Transport;
use grains_geometry::Vec3;
use std::collections::BTreeMap;
use std::ops::Range;

/// How far an insertion has come, as of [`Block`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    first_id: u64,
    count: u64,
    done: u64,
    before: u64,
    start: f64,
}

impl Progress {
    /// As a checkpoint holds it.
    pub fn text(&self) -> String {
        let Self { first_id, count, done, before, start } = self;
        format!("{first_id} {count} {done} {before} {:x}", start.to_bits())
    }

    /// Particles inserted so far.
    pub fn done(&self) -> u64 {
        self.done
    }

    /// Particles in all.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Their identities.
    pub fn ids(&self) -> Range<u64> {
        self.first_id..self.first_id + self.count
    }

    /// From a checkpoint; none if no run has written it.
    pub fn parse(text: &str) -> Option<Self> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let count = |k: usize| words.get(k)?.parse::<u64>().ok();
        let start = f64::from_bits(u64::from_str_radix(words.get(4)?, 16).ok()?);
        let read = Self { first_id: count(0)?, count: count(1)?, done: count(2)?, before: count(3)?, start };
        let Self { first_id, count, done, before, .. } = read;
        (before <= done && done <= count && first_id.checked_add(count).is_some()).then_some(read)
    }
}

/// One `[[insert]]` and how far it has come.
#[derive(Clone, Debug)]
pub struct Block {
    /// What the case says of it.
    pub insert: Insert,
    /// Identity of its first particle.
    pub first_id: u64,
    /// Its particles.
    pub count: u64,
    /// Those inserted so far.
    pub done: u64,
    /// Those inserted before its batches were counted: others than none after a restart that changed it.
    pub before: u64,
    /// Time at which the first of these batches is due (s).
    pub start: f64,
    /// Step of the last batch and the first id in it.
    pub last_batch: (u64, u64),
    /// Sizes of its components.
    sizes: Vec<Sizes>,
    /// This rank's rows of its file, until all are inserted.
    rows: Option<FileRows>,
}

impl Block {
    /// An insertion of which nothing is done; collective, each rank reads its share of the file.
    ///
    /// # Errors
    /// A particle file that cannot be read, or is wrong.
    pub fn read(
        case: &Case,
        insert: &Insert,
        first_id: u64,
        transport: &impl Transport,
    ) -> Result<Self, RunError> {
        let rows = match &insert.place {
            Place::File { path } => Some(FileRows::read(case, insert, path, transport)?),
            _ => None,
        };
        let listed = rows.as_ref().map_or(u64::MAX, |rows| rows.total);
        let count = insert.count.unwrap_or(u64::MAX).min(listed);
        Ok(Self {
            insert: insert.clone(),
            first_id,
            count,
            done: 0,
            before: 0,
            start: insert.start,
            last_batch: (u64::MAX, 0),
            sizes: insert.particles.iter().map(|component| Sizes::of(&component.scale)).collect(),
            rows,
        })
    }

    /// The kinds of particles it can insert, before any is inserted; collective.
    pub fn kinds(&self, case: &Case, catalogue: &Catalogue, transport: &impl Transport) -> Vec<KindRange> {
        let of = |(component, sizes)| match &self.rows {
            Some(rows) => of_rows(case, catalogue, (rows, component, sizes), transport),
            None => vec![of_component(component, sizes)],
        };
        let is_prescribed = self.insert.is_prescribed();
        let kinds = self.insert.particles.iter().zip(&self.sizes).flat_map(of);
        kinds.map(|kind| KindRange { is_prescribed, ..kind }).collect()
    }

    /// The components whose sizes are drawn, and these.
    pub fn drawn_sizes(&self) -> impl Iterator<Item = (&Insert, &Component, &Sizes)> {
        let is_drawn = self.rows.as_ref().is_none_or(|rows| !rows.has_sizes() && !rows.has_shapes());
        let components = self.insert.particles.iter().zip(&self.sizes).filter(move |_| is_drawn);
        components.map(|(component, sizes)| (&self.insert, component, sizes))
    }

    /// What prescribes the motion of its particles, if anything does.
    pub fn prescribed_motion(&self) -> Option<PrescribedMotion> {
        let (motion, about_centres) = match self.insert.motion.as_ref()? {
            ParticleMotion::Free => return None,
            ParticleMotion::Fixed => (Motion::Fixed, false),
            ParticleMotion::Prescribed(given) => {
                (system::motion(given), matches!(given, CaseMotion::Rotation { point: None, .. }))
            }
        };
        let ids = self.first_id..self.first_id + self.count;
        Some(PrescribedMotion { name: self.insert.name.clone(), ids, motion, about_centres })
    }

    /// Sum of something over the kind and scale of all its particles, before any is inserted: this rank's share of it. Of more than a
    /// million that are not in a file it is that of the first million, scaled up.
    pub fn sum(
        &self,
        case: &Case,
        seed: u64,
        catalogue: &Catalogue,
        of: impl Fn(Kind, f64) -> f64,
        rank: usize,
    ) -> f64 {
        const SAMPLE: u64 = 1_000_000;
        let (numbers, weight) = match &self.rows {
            Some(rows) => (rows.own().start.min(self.count)..rows.own().end.min(self.count), 1.0),
            None if rank == 0 => {
                let sample = self.count.min(SAMPLE);
                (0..sample, self.count as f64 / sample.max(1) as f64)
            }
            None => (0..0, 0.0),
        };
        let of_numbers: f64 = numbers
            .map(|number| self.kind_and_scale(self.first_id + number, case, seed, catalogue))
            .map(|(kind, scale)| of(kind, scale))
            .sum();
        of_numbers * weight
    }

    /// The largest numbers of its file, if it has one.
    pub fn file_extremes(&self) -> Option<Extremes> {
        self.rows.as_ref().map(|rows| rows.extremes)
    }

    /// Whether its particles come from a file.
    pub fn is_listed(&self) -> bool {
        matches!(self.insert.place, Place::File { .. })
    }

    /// Whether all its particles are inserted.
    pub fn is_complete(&self) -> bool {
        self.done >= self.count
    }

    /// How far it has come.
    pub fn progress(&self) -> Progress {
        let Self { first_id, count, done, before, start, .. } = *self;
        Progress { first_id, count, done, before, start }
    }

    /// Goes on where the insertion of the same name stood at a time (s), or begins if there was none; `next_id` is the first
    /// identity that no particle has.
    pub fn go_on(&mut self, old: Option<Progress>, is_changed: bool, next_id: &mut u64, time: f64) {
        if let Some(old) = old {
            self.first_id = old.first_id;
            // Further particles get identities beyond all others.
            if self.count > old.count {
                self.first_id = *next_id - old.done;
                *next_id += self.count - old.done;
            }
            (self.before, self.start) = (old.before, old.start);
            self.advance_to(old.done);
        } else {
            self.first_id = *next_id;
            *next_id += self.count;
        }
        if is_changed {
            (self.before, self.start) = (self.done, self.insert.start.max(time));
        }
    }

    /// Takes so many particles for inserted.
    fn advance_to(&mut self, done: u64) {
        self.done = done;
        if self.is_complete() {
            self.rows = None;
        }
    }

    /// Inserts its particles up to a number, as far as there is room; returns whether any was. Collective; `index` is its
    /// place in the case.
    ///
    /// # Errors
    /// As for [`Insertions::insert_due`](super::Insertions::insert_due).
    pub fn insert_until(
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

    /// Inserts particles where a window has room; returns how many are done.
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
        let pause = retry.map_or(1, |t| (t / dem.setup.parameters.dt).round().max(1.0) as u64);
        if !dem.step.is_multiple_of(pause) {
            return Ok(done);
        }
        let (lower, upper) = bounds(window);
        let coming = done..if dem.setup.largest_radius > 0.0 { done } else { until };
        let radius = |k: u64| self.particle(self.first_id + k, case, seed, dem).radius(&dem.setup.catalogue);
        let largest = coming.map(radius).fold(dem.setup.largest_radius, f64::max);
        let mut occupancy = Occupancy::near(dem, [&lower, &upper], largest);
        let mut turns = Turns::new(window, attempts, seed);
        while done < until {
            let takers = done..until.min(done + turns.takers() as u64);
            let takers = takers.map(|k| self.particle(self.first_id + k, case, seed, dem)).collect();
            let Round { placed, is_full } = turns.take(takers, &occupancy, dem, transport);
            done += placed.len() as u64;
            for new in placed {
                if dem.owns(&new.position) {
                    occupancy.add(new, &dem.setup.catalogue);
                    dem.insert(&new.record(dem));
                }
            }
            // During the run the rest waits for room; at the first batch there is nothing to wait for.
            let may_wait = retry.is_some() || dem.step > 0 || self.insert.interval > 0.0;
            match is_full {
                false => {}
                true if may_wait => break,
                true => {
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
        let before = due.start - (due.start - self.before) % self.batch();
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
        let chosen = choose(&self.insert.particles, draw.next());
        let component = &self.insert.particles[chosen];
        let mut drawn = || self.sizes[chosen].quantile(Basis::Number, draw.next());
        match &self.rows {
            Some(rows) => {
                let (kind, scale) = rows.kind(case, catalogue, id - self.first_id, component);
                (kind, scale.unwrap_or_else(drawn))
            }
            None => (component_kind(component), drawn()),
        }
    }

    /// The particle of an id; in a window its position is still to be found.
    pub fn particle(&self, id: u64, case: &Case, seed: u64, dem: &Dem) -> NewParticle {
        let catalogue = &dem.setup.catalogue;
        let insert = &self.insert;
        let (kind, scale) = self.kind_and_scale(id, case, seed, catalogue);
        let mut new = NewParticle {
            id,
            kind,
            scale,
            position: Vec3::zeros(),
            orientation: orientation(insert.orientation, &mut Draw::new(seed, id, purpose::ORIENTATION)),
            velocity: Vec3::from(insert.velocity),
            angular_velocity: Vec3::from(insert.angular_velocity),
            temperature: heat::initial(case, insert.temperature),
        };
        if let Some(rows) = &self.rows {
            rows.apply(id - self.first_id, &mut new);
            if rows.have_velocities() {
                // Those of a file include the mean flow of a sheared box.
                new.velocity -= dem.mean_flow(&new.position);
            }
        } else if let Some(sites) = self.sites(dem) {
            let site = (id - self.first_id) % self.batch();
            new.position = sites.position(site, &mut Draw::new(seed, id, purpose::NOISE));
        }
        if insert.is_prescribed() {
            // A packing brings the velocities of its last moments.
            (new.velocity, new.angular_velocity) = (Vec3::zeros(), Vec3::zeros());
        }
        // The user's orientation is that of the shape as given; ours is that of its principal frame. Places are those of
        // centres of mass in both.
        new.orientation *= catalogue.shapes[kind.shape as usize].user_to_body.0;
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
