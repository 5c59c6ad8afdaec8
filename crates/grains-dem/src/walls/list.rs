//! All wall pairs of a rank.
//!
//! Most listed pairs are apart. When a pair is looked at and does not touch, what keeps it apart says how far its particle may go,
//! in the wall's frame, before it can: the gap, or on a mesh the way to where the triangle owns a minimum of the distance. Until the
//! particle has gone so far nobody looks at the pair again; a pair that touches is looked at in every step. This changes
//! the time of an answer, not the answer.

use super::pairs::WallPair;
use super::sphere_batch::SphereBatch;
use super::surface_contact::{SphereTouch, SurfaceContact};
use crate::contact_history::{ContactHistory, LawHistory, WallKey};
use crate::memory_use::heap_bytes;
use grains_geometry::{Mat3, Simplex, Vec3};
use std::ops::Range;

/// All wall pairs of a rank, those of one particle and surface side by side, triangles ascending.
#[derive(Clone, Debug, Default)]
pub(crate) struct WallList {
    pub(crate) pairs: Vec<WallPair>,
    /// Way (m) of the particle, as its group counts it, up to which each pair is apart; none of one that touches.
    pub(super) apart_until: Vec<f64>,
    pub(super) groups: Vec<WallGroup>,
    /// Rotations of the particles from their frames to those of the walls where their groups were `seen`; empty if all are spheres.
    seen_frames: Vec<Mat3>,
    /// What laws keep of the pairs beside their displacements; empty if nothing.
    pub(crate) laws: Vec<LawHistory>,
    pub(crate) keep_laws: bool,
    pub(crate) simplexes: Vec<Simplex>,
    /// Shift (m) of each periodic image.
    pub(crate) shifts: Vec<Vec3>,
    pub(super) touching: Vec<Option<SurfaceContact>>,
    /// Pairs of a sphere that were looked at, in their order.
    pub(super) looked_at: Vec<(usize, Option<SphereTouch>)>,
    pub(super) batch: Box<SphereBatch>,
}

/// The pairs of one particle, image and surface.
#[derive(Clone, Debug)]
pub(super) struct WallGroup {
    start: u32,
    end: u32,
    /// Where the particle's centre was in the wall's frame (m) when it had gone `gone`.
    seen: Vec3,
    /// Way (m) since the lists were built, straight from one place where pairs were found apart to the next.
    gone: f64,
    /// Way (m) up to which no pair need be looked at.
    pub(super) apart_until: f64,
    /// Way (m) up to which the same facets stand for their triangles.
    pub(super) rim_until: f64,
}

impl WallGroup {
    pub(super) fn pairs(&self) -> Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// Way (m) up to which a pair is apart, whose particle of a radius (m) has gone `way` and may go a `free_path` from where it
/// lies, in the world and in the wall's frame.
///
/// A share, and that of the coordinates it is computed from, cover rounding.
#[inline(always)]
pub(crate) fn apart_until(way: f64, free_path: f64, [position, center]: [&Vec3; 2], radius: f64) -> f64 {
    way + 0.999 * free_path - 1e-12 * (position.amax() + center.amax() + radius)
}

impl WallList {
    /// Forgets all pairs.
    pub(crate) fn clear(&mut self) {
        self.pairs.clear();
        self.apart_until.clear();
        self.groups.clear();
        self.seen_frames.clear();
        self.laws.clear();
        self.simplexes.clear();
    }

    /// Memory (B).
    pub(crate) fn bytes(&self) -> usize {
        let Self { pairs, apart_until, groups, seen_frames, laws, simplexes, .. } = self;
        heap_bytes(pairs)
            + heap_bytes(apart_until)
            + heap_bytes(groups)
            + heap_bytes(seen_frames)
            + heap_bytes(laws)
            + heap_bytes(simplexes)
    }

    /// Adds the pair of a particle and what `key` names, with its contact history.
    pub(crate) fn push(
        &mut self,
        particle: u32,
        key: WallKey,
        known: ContactHistory,
        is_closed_form: bool,
        apart_until: f64,
    ) {
        let (wall, surface, part, element, image) = key;
        let ContactHistory { tangential_displacement, torsional_angle, law, simplex } = known;
        if self.keep_laws {
            self.laws.push(law);
        }
        let simplex = if is_closed_form {
            WallPair::CLOSED_FORM
        } else {
            self.simplexes.push(simplex);
            self.simplexes.len() as u32 - 1
        };
        self.apart_until.push(apart_until);
        self.pairs.push(WallPair {
            particle,
            element,
            wall,
            surface,
            part,
            image,
            tangential_displacement,
            torsional_angle,
            simplex,
        });
    }

    /// Makes a group of the pairs from `start` on, whose particle lies so in the wall's frame; which facets stand for their triangles
    /// is known up to a way (m).
    pub(crate) fn close_group(&mut self, start: usize, (seen, frame): (Vec3, Option<&Mat3>), rim_until: f64) {
        let end = self.pairs.len();
        if start == end {
            return;
        }
        self.groups.push(WallGroup {
            start: start as u32,
            end: end as u32,
            seen,
            gone: 0.0,
            apart_until: 0.0,
            rim_until,
        });
        self.seen_frames.extend(frame);
        self.leave(self.groups.len() - 1);
    }

    /// Way (m) of a group's particle of a radius (m) that lies so in the wall's frame: no point of it has gone farther.
    #[inline(always)]
    pub(super) fn way(&self, group: usize, center: &Vec3, turned: Option<(&Mat3, f64)>) -> f64 {
        let WallGroup { seen, gone, .. } = &self.groups[group];
        // The norm of the difference of two rotations is √2 times what it does to a unit vector at most.
        let turning = turned.map_or(0.0, |(frame, radius)| radius * (frame - self.seen_frames[group]).norm());
        gone + (center - seen).norm() + turning
    }

    /// Counts a group's way on from where its particle, which has gone `way` (m), lies now in the wall's frame.
    #[inline(always)]
    pub(super) fn see(&mut self, group: usize, way: f64, center: &Vec3, frame: Option<&Mat3>) {
        let seen = &mut self.groups[group];
        (seen.seen, seen.gone) = (*center, way);
        if let Some(frame) = frame {
            self.seen_frames[group] = *frame;
        }
    }

    /// Finds up to which way no pair of a group need be looked at.
    #[inline(always)]
    pub(super) fn leave(&mut self, group: usize) {
        let WallGroup { start, end, apart_until, rim_until, .. } = &mut self.groups[group];
        let pairs = &self.apart_until[*start as usize..*end as usize];
        *apart_until = pairs.iter().fold(*rim_until, |min, &way| min.min(way));
    }

    /// What a pair keeps of its contact.
    pub(crate) fn history_of(&self, pair: usize) -> ContactHistory {
        let WallPair { tangential_displacement, torsional_angle, simplex, .. } = self.pairs[pair];
        let simplex = self.simplexes.get(simplex as usize).copied().unwrap_or_default();
        let law = self.laws.get(pair).copied().unwrap_or_default();
        ContactHistory { tangential_displacement, torsional_angle, law, simplex }
    }

    /// Drops the simplexes of a range of pairs.
    pub(super) fn drop_simplexes(&mut self, group: Range<usize>) {
        for pair in &self.pairs[group] {
            if let Some(simplex) = self.simplexes.get_mut(pair.simplex as usize) {
                simplex.len = 0;
            }
        }
    }

    /// End of the pairs of one part of the particle that begin at `start`.
    pub(super) fn part_end(&self, start: usize, group_end: usize) -> usize {
        let part = self.pairs[start].part;
        let others = self.pairs[start..group_end].iter().position(|p| p.part != part);
        others.map_or(group_end, |n| start + n)
    }
}
