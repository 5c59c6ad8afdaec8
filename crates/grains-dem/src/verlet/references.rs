//! Where particles were when their owners last rebuilt their lists, and how far they may go from there.

use super::list_context::ListContext;
use crate::memory_use::heap_bytes;
use crate::particles::{Body, Particles};
use crate::rotation::way_of_turn;
use grains_domain::{Decomposition, SIZE_CLASSES, size_class};
use grains_geometry::{Rotation, Vec3};

/// How far particles may be beyond the border of their rank, beside their allowance, over it (-): for that they are cloned farther.
pub(super) const STRAY_SHARE: f64 = 0.25;

/// Where a particle was when its owner last rebuilt its lists, and how far it may go from there.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Reference {
    pub(crate) position: Vec3,
    /// Allowance (m).
    pub(crate) allowance: f64,
}

/// The references of a rank: of owned particles first, then of clones, as their owners have them.
#[derive(Clone, Debug, Default)]
pub(crate) struct References {
    pub(crate) places: Vec<Reference>,
    /// Orientations then; empty if all shapes are spheres.
    pub(crate) orientations: Vec<Rotation>,
    /// Owned particles beyond the border of their rank.
    pub(crate) strays: Vec<Stray>,
}

/// An owned particle beyond the border of its rank.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stray {
    pub(crate) particle: u32,
    /// Distance (m) from the border.
    pub(crate) beyond: f64,
    /// Whether it can wait for the rank's next rebuild but one for a neighbour to take it over.
    pub(crate) can_wait: bool,
}

impl References {
    /// Memory (B).
    pub(crate) fn bytes(&self) -> usize {
        heap_bytes(&self.places) + heap_bytes(&self.orientations)
    }

    /// What turning has taken of the allowance of an owned particle (m); none where all shapes are spheres.
    #[inline(always)]
    pub(crate) fn turned(&self, particles: &Particles, i: usize) -> Option<f64> {
        let before = self.orientations.get(i)?;
        Some(way_of_turn(particles.bodies[i].radius, before, &particles.orientations[i]))
    }

    /// Takes the present poses of all owned particles for their references, and forgets clones.
    ///
    /// A particle beyond the border of its rank has the nearest place within as its reference, so that neighbours, who know the border,
    /// know what it may meet; its allowance covers the way back. `ranges` (m) are what allowances must fit in, per class of sizes, where
    /// ranks rebuild their lists apart.
    pub(crate) fn choose(
        &mut self,
        particles: &Particles,
        context: &ListContext,
        ranges: Option<&[f64; SIZE_CLASSES]>,
    ) {
        let global = &context.decomposition.global;
        self.places.clear();
        self.orientations.clear();
        self.strays.clear();
        self.places.reserve_exact(particles.owned);
        for (i, body) in particles.bodies[..particles.owned].iter().enumerate() {
            let mut allowance = nominal_allowance(body, context);
            for a in (0..3).filter(|&a| !global.periodic[a]) {
                // The lists are rebuilt in the very step in which a particle crosses a face.
                allowance =
                    allowance.min(body.position[a] - global.lower[a]).min(global.upper[a] - body.position[a]);
            }
            let mut position = body.position;
            if let Some(ranges) = ranges {
                let room = ranges[size_class(body.radius, context.largest_radius)]
                    - body.radius
                    - 0.5 * context.gap();
                allowance = allowance.min(room / (1.0 + STRAY_SHARE)).min(room - context.stray).max(0.0);
                position = nearest_within(context.decomposition, &body.position);
                if position != body.position {
                    let beyond = (body.position - position).norm();
                    // At the next rebuild there must be room left for as long as a request takes.
                    let can_wait = beyond + 2.0 * context.stray <= room;
                    let end = if can_wait { room - context.stray } else { room };
                    allowance = (allowance + beyond).min(end);
                    self.strays.push(Stray { particle: i as u32, beyond, can_wait });
                }
            }
            self.places.push(Reference { position, allowance });
        }
        self.orientations.extend(particles.orientations.iter().take(particles.owned));
    }

    /// Distance (m) from the reference within which owned particle `i` may act before its lists are rebuilt.
    pub(crate) fn range_of(&self, particles: &Particles, i: usize, gap: f64) -> f64 {
        particles.bodies[i].radius + self.places[i].allowance + 0.5 * gap
    }

    /// Makes room for just so many clones.
    pub(crate) fn make_room(&mut self, clones: usize) {
        self.places.reserve_exact(clones);
        if !self.orientations.is_empty() {
            self.orientations.reserve_exact(clones);
        }
    }

    /// Takes off the references of clones.
    pub(crate) fn split_off(&mut self, owned: usize) -> Self {
        let places = self.places.split_off(owned.min(self.places.len()));
        let orientations = self.orientations.split_off(owned.min(self.orientations.len()));
        Self { places, orientations, strays: Vec::new() }
    }

    /// Appends that of a clone.
    pub(crate) fn push(&mut self, reference: Reference, orientation: Option<Rotation>) {
        self.places.push(reference);
        self.orientations.extend(orientation);
    }

    /// Appends one of another list.
    pub(crate) fn push_from(&mut self, others: &Self, k: usize) {
        self.push(others.places[k], others.orientations.get(k).copied());
    }
}

/// The place in a subdomain next to a position (m): the position itself if it is inside.
fn nearest_within(decomposition: &Decomposition, position: &Vec3) -> Vec3 {
    let (lower, upper) = (decomposition.lower(), decomposition.upper());
    Vec3::from(std::array::from_fn(|a| position[a].clamp(lower[a], upper[a])))
}

/// Allowance of a body (m) by its size and speed.
pub(super) fn nominal_allowance(body: &Body, context: &ListContext) -> f64 {
    let ListContext { catalogue, skin, dt, .. } = context;
    let mut speed = body.velocity.norm();
    if !catalogue.shape(body.kind).is_sphere() {
        speed += body.radius * body.angular_velocity.norm();
    }
    (speed * skin.horizon * dt).clamp(skin.min * body.radius, skin.max * body.radius)
}
