//! Random places in a window, tried until particles fit.
//!
//! Particles take their turns in the order of their identities: each gets the first of its places at which it overlaps no wall, no
//! particle that is there and none that had its turn before. All ranks get the same particles, as a place depends on seed, identity
//! and attempt alone.
//!
//! Rounds ask for many places of many particles at once whether they are free: each rank compares them with its own particles, the
//! owner of a place with the walls, and one reduction makes the answers known. The places are then given away on all ranks alike,
//! which takes a comparison with those of the same round. The first round asks for one particle: a window that is full, into which
//! others wait to fall, costs its places alone. Each further round asks for twice as many places as the one before.

use super::draws::purpose;
use crate::random::Draw;
use grains_case::Window;
use grains_dem::{Dem, NewParticle, Occupancy, is_wall_in_the_way};
use grains_domain::Transport;
use grains_geometry::Vec3;
use std::f64::consts::TAU;

/// Largest number of places asked about in a round.
const PLACES: usize = 4096;
/// Places of each particle in the first round, and the fewest.
const FIRST_TRIES: usize = 4;

/// Turns of particles at places in a window.
pub struct Turns<'a> {
    window: &'a Window,
    /// Places of each particle before it gives up.
    attempts: usize,
    seed: u64,
    /// Places of the particle whose turn it is that were asked about before.
    tried: usize,
    /// Places of each particle in the next round.
    tries: usize,
    /// Places asked about in the next round.
    places: usize,
}

/// Particles that had their turns in a round.
pub struct Round {
    /// Those that found places, in the order of their turns.
    pub placed: Vec<NewParticle>,
    /// Whether the next one has no place at all.
    pub is_full: bool,
}

impl<'a> Turns<'a> {
    /// Turns of which none was taken.
    pub fn new(window: &'a Window, attempts: u64, seed: u64) -> Self {
        let attempts = usize::try_from(attempts).unwrap_or(usize::MAX);
        Self { window, attempts, seed, tried: 0, tries: FIRST_TRIES, places: FIRST_TRIES }
    }

    /// Particles that take part in the next round, if there are as many.
    pub fn takers(&self) -> usize {
        (self.places / self.tries).max(1)
    }

    /// Gives places to the first of some particles, as far as those of one round suffice; collective.
    pub fn take(
        &mut self,
        mut takers: Vec<NewParticle>,
        occupancy: &Occupancy,
        dem: &Dem,
        transport: &impl Transport,
    ) -> Round {
        let Self { window, attempts, seed, tried, tries: width, .. } = *self;
        // A later batch must not repeat the attempts that found no room before.
        let first_attempt = dem.step.wrapping_mul(attempts as u64);
        let place = |new: &NewParticle, k: usize| {
            attempted_position(new, window, seed, first_attempt.wrapping_add(k as u64), dem)
        };
        let tries = |taker: usize| {
            let begin = if taker == 0 { tried } else { 0 };
            begin..attempts.min(begin + width)
        };
        let mut blocked = vec![0.0; takers.len() * width];
        for (taker, blocked) in blocked.chunks_exact_mut(width).enumerate() {
            let new = &mut takers[taker];
            for (k, blocked) in tries(taker).zip(blocked) {
                new.position = place(new, k);
                *blocked = f64::from(u8::from(is_blocked(new, occupancy, dem)));
            }
        }
        transport.max(&mut blocked);
        let largest = takers.iter().map(|new| new.radius(&dem.setup.catalogue)).fold(0.0, f64::max);
        let mut placed_before = Occupancy::empty(largest);
        let mut placed = Vec::with_capacity(takers.len());
        for (taker, (mut new, blocked)) in takers.into_iter().zip(blocked.chunks_exact(width)).enumerate() {
            let mut fits = |(k, blocked): (usize, &f64)| {
                new.position = place(&new, k);
                *blocked == 0.0 && !placed_before.is_in_the_way(&new, dem)
            };
            let tries = tries(taker);
            if tries.clone().zip(blocked).any(&mut fits) {
                placed_before.add(new, &dem.setup.catalogue);
                placed.push(new);
                continue;
            }
            let is_full = tries.end == attempts;
            self.prepare(tries.end, 2 * width);
            return Round { placed, is_full };
        }
        self.prepare(0, width / 2);
        Round { placed, is_full: false }
    }

    /// Prepares the next round, before which so many places of its first particle were asked about.
    fn prepare(&mut self, tried: usize, tries: usize) {
        (self.tried, self.tries) = (tried, tries.clamp(FIRST_TRIES, PLACES));
        self.places = (2 * self.places).min(PLACES);
    }
}

/// Whether a particle lies outside the domain, overlaps an own particle, or, at a place of this rank, a wall.
fn is_blocked(new: &NewParticle, occupancy: &Occupancy, dem: &Dem) -> bool {
    !dem.setup.global.contains(new.position.into())
        || occupancy.is_in_the_way(new, dem)
        || (dem.owns(&new.position) && is_wall_in_the_way(new, dem))
}

/// Position of a particle at an attempt, wrapped and on the lattice.
fn attempted_position(new: &NewParticle, window: &Window, seed: u64, attempt: u64, dem: &Dem) -> Vec3 {
    let mut draw = Draw::new(seed, new.id, purpose::ATTEMPT + attempt);
    let wrapped = dem.setup.global.wrap(point_in(window, &mut draw).into());
    Vec3::from(wrapped.map(|x| dem.setup.global.quantum.snap(x)))
}

/// Corners of the box around a window (m).
pub fn bounds(window: &Window) -> (Vec3, Vec3) {
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
            Vec3::from(*center) + (first * libm::cos(angle) + normal.cross(&first) * libm::sin(angle)) * u
        }
        Window::Point { at } => Vec3::from(*at),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::insertion::Insertions;
    use crate::system;
    use grains_case::{Case, Place};
    use grains_domain::SerialTransport;
    use std::path::Path;

    /// Balls and boxes through a window of a kind into a periodic box with a rod across it.
    fn text(window: &str, count: u64, attempts: u64) -> String {
        format!(
            r#"
name = "shower"
seed = {count}
[domain]
lower = [0, 0, 0]
upper = [1, 1, 2]
periodic = [true, false, false]
[time]
end = 1
dt = 1e-5
[[material]]
name = "m"
density = 1000
[[contact]]
between = ["m", "m"]
normal_stiffness = 1e5
restitution = 0.5
friction = 0.3
[[shape]]
name = "ball"
kind = "sphere"
radius = 0.05
[[shape]]
name = "box"
kind = "box"
edges = [0.1, 0.06, 0.04]
[[wall]]
name = "rod"
material = "m"
kind = "cylinder"
center = [0.5, 0.5, 1]
axis = [0, 1, 0]
radius = 0.15
height = 0.8
side = "outside"
[[insert]]
name = "shower"
particles = [
    {{ shape = "ball", material = "m", scale = {{ kind = "uniform", min = 0.3, max = 1 }} }},
    {{ shape = "box", material = "m" }},
]
count = {count}
place = {{ kind = "window", window = {window}, attempts = {attempts}, retry = 1e-5 }}
[output]
directory = "results"
"#
        )
    }

    /// The particles one by one, each at the first attempt at which it fits.
    fn one_by_one(takers: Vec<NewParticle>, turns: &Turns, dem: &Dem) -> Vec<NewParticle> {
        let mut there =
            Occupancy::empty(takers.iter().map(|new| new.radius(&dem.setup.catalogue)).fold(0.0, f64::max));
        let mut placed = Vec::new();
        for mut new in takers {
            let fits = (0..turns.attempts).any(|k| {
                new.position = attempted_position(&new, turns.window, turns.seed, k as u64, dem);
                !is_blocked(&new, &there, dem)
            });
            if !fits {
                break;
            }
            there.add(new, &dem.setup.catalogue);
            placed.push(new);
        }
        placed
    }

    #[test]
    fn rounds_place_the_same_particles_as_one_turn_after_the_other() {
        let (slot, disc) = (
            "{ kind = \"box\", lower = [0, 0.05, 0.3], upper = [1, 0.95, 1.7] }",
            "{ kind = \"disc\", center = [0.3, 0.5, 0.9], normal = [1, 0, 2], radius = 0.3 }",
        );
        let mut ends = [0, 0];
        for (window, count, attempts) in
            [(slot, 60, 100), (slot, 2000, 3), (slot, 2000, 300), (disc, 300, 1), (disc, 300, 9000)]
        {
            let case = Case::parse(&text(window, count, attempts), "shower.toml", Path::new("")).unwrap();
            let catalogue = system::catalogue(&case).unwrap();
            let insertions = Insertions::read(&case, &catalogue, &SerialTransport).unwrap();
            let setup = system::build(&case, 1, catalogue, insertions.kinds()).unwrap().setup;
            let dem = system::dem(&case, setup, 0).unwrap();
            let block = &insertions.blocks[0];
            let Place::Window { window, attempts, .. } = &block.insert.place else { panic!("a window") };
            let particles = |numbers: std::ops::Range<u64>| -> Vec<NewParticle> {
                numbers.map(|id| block.particle(id, &case, case.seed, &dem)).collect()
            };
            let mut turns = Turns::new(window, *attempts, case.seed);
            let wanted = one_by_one(particles(0..count), &turns, &dem);

            // However many wait before a window that is full.
            assert_eq!(turns.takers(), 1);
            let (mut found, mut rounds) = (Vec::new(), 0);
            let mut there = Occupancy::near(&dem, [&Vec3::zeros(), &Vec3::from_element(2.0)], 0.1);
            while (found.len() as u64) < count {
                let first = found.len() as u64;
                let takers = particles(first..count.min(first + turns.takers() as u64));
                let Round { placed, is_full } = turns.take(takers, &there, &dem, &SerialTransport);
                placed.iter().for_each(|new| there.add(*new, &dem.setup.catalogue));
                found.extend(placed);
                rounds += 1;
                ends[usize::from(is_full)] += 1;
                if is_full {
                    break;
                }
            }
            let state = |all: &[NewParticle]| -> Vec<(u64, [u64; 3])> {
                all.iter().map(|new| (new.id, <[f64; 3]>::from(new.position).map(f64::to_bits))).collect()
            };
            assert_eq!(state(&found), state(&wanted), "{count} particles, {attempts} attempts");
            assert!(found.len() > 5 && rounds < 60, "{} in {rounds} rounds", found.len());
        }
        // Some windows got full, and some rounds ended before.
        assert!(ends[0] > 3 && ends[1] > 2, "{ends:?}");
    }
}
