//! The particles of a case: when, where and how they are inserted.

use crate::particle_files::files;
use crate::random::Draw;
use grains_case::{
    Case, Component, Insert, Orientation, ParticleColumns, Place, Scale, Window, default_spacing,
    lattice_sites,
};
use grains_dem::{Catalogue, Dem, Kind, NewParticle, Occupancy, Partner, Touch, wall_in_the_way};
use grains_domain::Transport;
use grains_geometry::{Rotation, Vec3};
use nalgebra::{Quaternion, Unit};
use std::f64::consts::TAU;

/// What random numbers are for.
mod purpose {
    pub const KIND: u64 = 1;
    pub const ORIENTATION: u64 = 2;
    pub const NOISE: u64 = 3;
    /// Attempts to place a particle count up from here.
    pub const ATTEMPT: u64 = 16;
}

/// One `[[insert]]` and how far it has come.
#[derive(Clone, Debug)]
struct Block {
    insert: Insert,
    columns: Option<ParticleColumns>,
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
    seed: u64,
}

/// Kind of a row of a particle file, and its scale if the file has sizes; columns it lacks come from a
/// component of the insertion.
pub fn row_kind(
    case: &Case,
    catalogue: &Catalogue,
    columns: &ParticleColumns,
    row: usize,
    component: &Component,
) -> (Kind, Option<f64>) {
    let named = |names: &Option<Vec<String>>, index: &dyn Fn(&str) -> Option<usize>, default: usize| {
        names.as_ref().and_then(|n| index(&n[row])).unwrap_or(default)
    };
    let shape = named(&columns.shape, &|n| case.shape_index(n), component.shape);
    let material = named(&columns.material, &|n| case.material_index(n), component.material);
    let scale = match (&columns.radius, &columns.scale) {
        (Some(radii), _) => Some(radii[row] / catalogue.shapes[shape].bounding_radius),
        (_, Some(scales)) => Some(scales[row]),
        _ => None,
    };
    (Kind { shape: shape as u16, material: material as u16 }, scale)
}

/// Calls `visit` with every kind of particle the case can insert and the scales it can have.
///
/// # Errors
/// Particle files that cannot be read.
pub fn for_each_kind(
    case: &Case,
    catalogue: &Catalogue,
    mut visit: impl FnMut(Kind, &Scale),
) -> Result<(), String> {
    for (insert, columns) in case.inserts.iter().zip(files(case)?) {
        for component in &insert.particles {
            match &columns {
                None => visit(component_kind(component), &component.scale),
                Some(columns) => (0..columns.len()).for_each(|row| {
                    let (kind, scale) = row_kind(case, catalogue, columns, row, component);
                    match scale {
                        Some(value) => visit(kind, &Scale::Constant { value }),
                        None => visit(kind, &component.scale),
                    }
                }),
            }
        }
    }
    Ok(())
}

fn component_kind(component: &Component) -> Kind {
    Kind { shape: component.shape as u16, material: component.material as u16 }
}

impl Population {
    /// Insertions of a case, none done.
    ///
    /// # Errors
    /// Particle files that cannot be read.
    pub fn new(case: &Case) -> Result<Self, String> {
        let mut first_id = 0;
        let mut blocks = Vec::new();
        for (insert, columns) in case.inserts.iter().zip(files(case)?) {
            let listed = columns.as_ref().map_or(u64::MAX, |c| c.position.len() as u64);
            let count = insert.count.unwrap_or(u64::MAX).min(listed);
            blocks.push(Block {
                insert: insert.clone(),
                columns,
                first_id,
                count,
                done: 0,
                last_batch: (u64::MAX, 0),
            });
            first_id += count;
        }
        Ok(Self { blocks, seed: case.seed })
    }

    /// Particles of all insertions together.
    pub fn total(&self) -> u64 {
        self.blocks.iter().map(|b| b.count).sum()
    }

    /// Mass of all particles (kg), those still to come included.
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
            block.done = done as u64;
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
            let is_listed =
                ids.into_iter().flatten().all(|id| self.blocks[self.origin(id)].columns.is_some());
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

    /// Inserts what is due at the present step; returns whether anything was.
    ///
    /// # Errors
    /// A particle of a first batch for which there is no room.
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
        if let Place::Window { window, attempts, retry } = self.insert.place.clone() {
            let pause = retry.map_or(1, |t| (t / dem.setup.rates.dt).round().max(1.0) as u64);
            if !dem.step.is_multiple_of(pause) {
                return Ok(false);
            }
            let (lower, upper) = bounds(&window);
            let mut occupancy = Occupancy::near(dem, &lower, &upper);
            while self.done < until {
                let id = self.first_id + self.done;
                let new = self.particle(id, case, seed, dem);
                match place_in_window(new, &window, attempts, seed, &occupancy, dem, transport) {
                    Some(placed) => {
                        if dem.owns(&placed.position) {
                            dem.insert(&placed.record(dem));
                        }
                        occupancy.add(placed);
                        self.done += 1;
                    }
                    // During the run the rest waits for room; at the first batch there is nothing to wait for.
                    None if retry.is_some() || dem.step > 0 || self.insert.interval > 0.0 => break,
                    None => {
                        let message = format!(
                            "no room for particle {} of {} after {attempts} attempts; enlarge the window, insert fewer, or give place.retry (s) to wait for room",
                            self.done + 1,
                            self.count
                        );
                        return Err(case.about(&format!("insert[{index}].place"), message));
                    }
                }
            }
        } else {
            for k in self.done..until {
                let mut new = self.particle(self.first_id + k, case, seed, dem);
                new.position = Vec3::from(dem.setup.global.wrap(new.position.into()));
                if !dem.setup.global.contains(new.position.into()) {
                    let message = format!(
                        "particle {} at ({}, {}, {}) lies outside the domain",
                        new.id, new.position.x, new.position.y, new.position.z
                    );
                    return Err(case.about(&format!("insert[{index}].place"), message));
                }
                if dem.owns(&new.position) {
                    dem.insert(&new.record(dem));
                }
            }
            self.done = until;
        }
        self.last_batch = (dem.step, self.first_id + begun_at);
        Ok(self.done > begun_at)
    }

    fn kind_and_scale(&self, id: u64, case: &Case, seed: u64, catalogue: &Catalogue) -> (Kind, f64) {
        let mut draw = Draw::new(seed, id, purpose::KIND);
        let component = choose(&self.insert.particles, draw.next());
        match &self.columns {
            Some(columns) => {
                let row = (id - self.first_id) as usize;
                let (kind, scale) = row_kind(case, catalogue, columns, row, component);
                (kind, scale.unwrap_or_else(|| sample(&component.scale, &mut draw)))
            }
            None => (component_kind(component), sample(&component.scale, &mut draw)),
        }
    }

    /// The particle of an id; in a window its position is still to be found.
    fn particle(&self, id: u64, case: &Case, seed: u64, dem: &Dem) -> NewParticle {
        let catalogue = &dem.setup.catalogue;
        let insert = &self.insert;
        let row = (id - self.first_id) as usize;
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
        if let Some(columns) = &self.columns {
            new.position = Vec3::from(columns.position[row]);
            if let Some(q) = &columns.orientation {
                new.orientation = quaternion(q[row]);
            }
            if let Some(v) = &columns.velocity {
                new.velocity = Vec3::from(v[row]);
            }
            if let Some(w) = &columns.angular_velocity {
                new.angular_velocity = Vec3::from(w[row]);
            }
        } else if let Place::Lattice { lower, upper, spacing, noise } = &insert.place {
            let spacing = &spacing.unwrap_or_else(|| default_spacing(dem.setup.largest_radius, *noise));
            let batch = insert.batch.unwrap_or(self.count).max(1);
            let site = (id - self.first_id) % batch;
            let [nx, ny, _] = lattice_sites(*lower, *upper, *spacing);
            let place = [site % nx, site / nx % ny, site / (nx * ny)];
            let mut draw = Draw::new(seed, id, purpose::NOISE);
            new.position = Vec3::from_fn(|a, _| {
                lower[a] + (place[a] as f64 + 0.5 + noise * (2.0 * draw.next() - 1.0)) * spacing
            });
        }
        if case.holds_particles() {
            // A packing brings the velocities of its last moments.
            (new.velocity, new.angular_velocity) = (Vec3::zeros(), Vec3::zeros());
        }
        // The user's orientation is that of the shape as given; ours is that of its principal frame.
        let (to_user, center) = &catalogue.shapes[kind.shape as usize].user_to_body;
        if self.columns.is_some() {
            new.position += new.orientation * (center * scale);
        }
        new.orientation *= to_user;
        new
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

/// Attempts between two agreements of the ranks.
const ATTEMPTS_AT_A_TIME: u64 = 64;

/// Tries places in a window until the particle fits between particles and walls, on all ranks alike.
fn place_in_window(
    mut new: NewParticle,
    window: &Window,
    attempts: u64,
    seed: u64,
    occupancy: &Occupancy,
    dem: &Dem,
    transport: &impl Transport,
) -> Option<NewParticle> {
    // A later batch must not repeat the attempts that found no room before.
    let round = dem.step.wrapping_mul(attempts);
    let mut blocked = Vec::new();
    for first in (0..attempts).step_by(ATTEMPTS_AT_A_TIME as usize) {
        let last = attempts.min(first + ATTEMPTS_AT_A_TIME);
        blocked.clear();
        blocked.extend((first..last).map(|attempt| {
            new.position = attempted_position(&new, window, seed, round + attempt, dem);
            let is_blocked = !dem.setup.global.contains(new.position.into())
                || occupancy.in_the_way(&new, dem, 0.0).is_some()
                || wall_in_the_way(&new, dem, 0.0).is_some();
            f64::from(u8::from(is_blocked))
        }));
        transport.max(&mut blocked);
        if let Some(free) = blocked.iter().position(|&b| b == 0.0) {
            new.position = attempted_position(&new, window, seed, round + first + free as u64, dem);
            return Some(new);
        }
    }
    None
}

/// Position of a particle at an attempt, wrapped and on the lattice.
fn attempted_position(new: &NewParticle, window: &Window, seed: u64, attempt: u64, dem: &Dem) -> Vec3 {
    let mut draw = Draw::new(seed, new.id, purpose::ATTEMPT + attempt);
    let wrapped = dem.setup.global.wrap(point_in(window, &mut draw).into());
    Vec3::from(wrapped.map(|x| dem.setup.global.lattice.snap(x)))
}

/// Corners of the box around a window (m).
fn bounds(window: &Window) -> (Vec3, Vec3) {
    match window {
        Window::Box { lower, upper } => (Vec3::from(*lower), Vec3::from(*upper)),
        Window::Disc { center, normal, radius } => {
            let reach = Vec3::from(normal.map(|n| radius * (1.0 - n * n).max(0.0).sqrt()));
            (Vec3::from(*center) - reach, Vec3::from(*center) + reach)
        }
        Window::Point { at } => (Vec3::from(*at), Vec3::from(*at)),
    }
}

fn point_in(window: &Window, draw: &mut Draw) -> Vec3 {
    match window {
        Window::Box { lower, upper } => Vec3::from_fn(|a, _| lower[a] + (upper[a] - lower[a]) * draw.next()),
        Window::Disc { center, normal, radius } => {
            let normal = Vec3::from(*normal);
            let helper = if normal.x.abs() < 0.6 { Vec3::x() } else { Vec3::y() };
            let (u, angle) = (draw.next().sqrt() * radius, TAU * draw.next());
            let first = normal.cross(&helper).normalize();
            Vec3::from(*center) + (first * angle.cos() + normal.cross(&first) * angle.sin()) * u
        }
        Window::Point { at } => Vec3::from(*at),
    }
}
