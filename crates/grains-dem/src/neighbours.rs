//! Verlet lists with a skin per particle, built from linked cells.
//!
//! A particle may move by its *reach* before the lists must be rebuilt; fast particles get a larger reach,
//! so that a few falling grains do not force a dense bed to rebuild. Reaches, and so the times of rebuilds,
//! cannot change a result: a pair remembers something only while its positions in consecutive steps say so.

mod search;

use crate::bodies::{BodyList, BodyPair};
use crate::dem::bytes;
use crate::images;
use crate::memory::{BodyMemory, ContactMemory, Memories, SphereMemory, WallMemory};
use crate::spheres::SpherePair;
use crate::walls::{Wall, WallList, WallPair};
use crate::{Body, Particles};
use grains_domain::GlobalBox;
use grains_geometry::{Rotation, Vec3};
pub(crate) use search::{Sorted, Surroundings, widest};

/// Time that a particle, a pair of parts of bodies and a pair with a wall take in a step, over that of a pair of spheres:
/// of settled spheres 0.5 (and a share of the next sorting), of cubes 3, 13 and 4, in units of 0.014 microseconds.
const WORK_OF_PARTICLE: u64 = 2;
const WORK_OF_PARTS: u64 = 13;
const WORK_AT_WALL: u64 = 4;

/// How far particles may move before lists are rebuilt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Skin {
    /// Smallest reach over radius (-).
    pub least: f64,
    /// Largest reach over radius (-).
    pub most: f64,
    /// Steps a particle should go at its present speed (-).
    pub horizon: f64,
}

impl Default for Skin {
    fn default() -> Self {
        Self { least: 0.025, most: 0.4, horizon: 60.0 }
    }
}

/// Where a particle was when the lists were built, and how far it may go from there.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Reference {
    pub(crate) position: Vec3,
    /// Reach (m).
    pub(crate) reach: f64,
}

/// The lists of one rank.
#[derive(Clone, Debug, Default)]
pub(crate) struct Neighbours {
    pub(crate) references: Vec<Reference>,
    /// Orientations when the lists were built; empty if all shapes are spheres.
    pub(crate) reference_orientations: Vec<Rotation>,
    pub(crate) spheres: Vec<SpherePair>,
    pub(crate) bodies: BodyList,
    pub(crate) walls: WallList,
    /// How many pairs, at the beginning of the lists, are of two owned particles.
    pub(crate) inner: Inner,
    /// Distance any wall may move before the lists are rebuilt (m).
    pub(crate) wall_reach: f64,
    /// Scratch: parts of two bodies near each other.
    near_parts: [Vec<u16>; 2],
}

/// Numbers of pairs of spheres, and of parts of bodies.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Inner {
    pub(crate) spheres: usize,
    pub(crate) bodies: usize,
}

impl Neighbours {
    /// Reach of every owned particle (m), from its speed and the faces it must not cross unseen.
    pub(crate) fn choose_reaches(&mut self, particles: &Particles, around: &Surroundings) {
        let global = &around.decomposition.global;
        self.references.clear();
        self.reference_orientations.clear();
        for i in 0..particles.owned {
            let body = &particles.bodies[i];
            let mut reach = nominal_reach(body, around);
            for a in (0..3).filter(|&a| !global.periodic[a]) {
                // The lists are rebuilt in the very step in which a particle crosses a face.
                reach = reach.min(body.position[a] - global.lower[a]).min(global.upper[a] - body.position[a]);
            }
            self.references.push(Reference { position: body.position, reach });
        }
        self.reference_orientations.extend(particles.orientations.iter().take(particles.owned));
    }

    /// Distance (m) from the centre within which owned particle `i` may act before the lists are rebuilt.
    pub(crate) fn range_of(&self, particles: &Particles, i: usize, film: f64) -> f64 {
        particles.bodies[i].radius + self.references[i].reach + 0.5 * film
    }

    /// Gathers what all pairs remember into rows by owned particle.
    pub(crate) fn remember(
        &self,
        particles: &Particles,
        walls: &[Wall],
        global: &GlobalBox,
        memories: &mut Memories,
    ) {
        let owned = particles.owned as u32;
        let ids = &particles.ids;
        memories.fill(
            particles.owned,
            |add| {
                for pair in self.spheres.iter().filter(|p| p.spring != Vec3::zeros()) {
                    add(pair.a, SphereMemory { partner: ids[pair.b as usize], spring: pair.spring });
                    if pair.b < owned {
                        add(pair.b, SphereMemory { partner: ids[pair.a as usize], spring: -pair.spring });
                    }
                }
            },
            |add| {
                for (&BodyPair { a, b, parts, .. }, contact) in self.bodies.remembered() {
                    for (own, other) in [(a, b), (b, a)] {
                        if own < owned {
                            add(own, BodyMemory { partner: ids[other as usize], parts, contact: *contact });
                        }
                    }
                }
            },
            |add| {
                for pair in &self.walls.pairs {
                    let &WallPair { wall, surface, part, element, spring, twist, .. } = pair;
                    let simplex = self.walls.simplexes.get(pair.simplex as usize).copied();
                    let contact = ContactMemory { spring, twist, simplex: simplex.unwrap_or_default() };
                    if contact.is_empty() {
                        continue;
                    }
                    let wrapped =
                        walls[wall as usize].wrapped_axes(&walls[wall as usize].surfaces[surface as usize]);
                    let position = &particles.bodies[pair.particle as usize].position;
                    if let Some(image) = images::seen_from_wrapped(pair.image, position, global, wrapped) {
                        add(pair.particle, WallMemory { wall, surface, part, element, image, contact });
                    }
                }
            },
        );
    }

    /// What each owned particle costs in a step, in units of a pair of spheres.
    ///
    /// Pairs and particles are counted, not timed, so that borders lie alike in every run of a case.
    pub(crate) fn work_of_each(&self, owned: usize) -> Vec<u64> {
        let mut work = vec![WORK_OF_PARTICLE; owned];
        let mut add = |particle: u32, cost: u64| {
            if let Some(sum) = work.get_mut(particle as usize) {
                *sum += cost;
            }
        };
        self.spheres.iter().for_each(|pair| add(pair.a, 1));
        // One of two bodies may be a clone.
        self.bodies.pairs.iter().for_each(|pair| add(pair.a.min(pair.b), WORK_OF_PARTS));
        self.walls.pairs.iter().for_each(|pair| add(pair.particle, WORK_AT_WALL));
        work
    }

    /// The sum of it.
    pub(crate) fn work(&self, owned: usize) -> u64 {
        let [spheres, bodies, walls] = self.sizes().map(|n| n as u64);
        WORK_OF_PARTICLE * owned as u64 + spheres + WORK_OF_PARTS * bodies + WORK_AT_WALL * walls
    }

    /// Memory (B).
    pub(crate) fn bytes(&self) -> usize {
        let Self { references, reference_orientations, spheres, bodies, walls, .. } = self;
        let walls = bytes(&walls.pairs) + bytes(&walls.simplexes);
        bytes(references) + bytes(reference_orientations) + bytes(spheres) + bodies.bytes() + walls
    }

    /// Number of pairs in the lists: spheres, bodies, walls.
    pub(crate) fn sizes(&self) -> [usize; 3] {
        [self.spheres.len(), self.bodies.pairs.len(), self.walls.pairs.len()]
    }
}

/// Reach of a body (m) by its size and speed: owner and clone agree on it, bit for bit.
fn nominal_reach(body: &Body, around: &Surroundings) -> f64 {
    let Surroundings { catalogue, skin, dt, .. } = around;
    let mut speed = body.velocity.norm();
    if !catalogue.shape(body.kind).is_sphere() {
        speed += body.radius * body.angular_velocity.norm();
    }
    (speed * skin.horizon * dt).clamp(skin.least * body.radius, skin.most * body.radius)
}
