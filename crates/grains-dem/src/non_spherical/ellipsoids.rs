//! Ellipsoids that touched in the last step: their distances are found together.

use super::histories::Histories;
use super::list::cores;
use super::pairs::PartPair;
use crate::catalogue::Catalogue;
use crate::contacts::BLOCK;
use crate::narrow_phase::{Meeting, PartContact, PlacedPart, Pose, across_gap};
use crate::particles::Particles;
use grains_geometry::gjk::EllipsoidQueries;
use multiversion::multiversion;

/// Pairs of ellipsoids that wait for others.
#[derive(Clone, Debug)]
pub(super) struct EllipsoidBatch {
    queries: EllipsoidQueries<BLOCK>,
    /// Places of the pairs in the list.
    places: [u32; BLOCK],
}

impl Default for EllipsoidBatch {
    fn default() -> Self {
        Self { queries: EllipsoidQueries::default(), places: [0; BLOCK] }
    }
}

impl EllipsoidBatch {
    /// Takes the pair at `place` if it is one of ellipsoids that touched in the last step and there is room.
    #[inline(always)]
    pub(super) fn takes(
        &mut self,
        (place, pair): (usize, &PartPair),
        histories: &Histories,
        particles: &Particles,
        catalogue: &Catalogue,
    ) -> bool {
        if !pair.is_touching() {
            return false;
        }
        let cores = cores(pair, particles, catalogue);
        let (Some(first), Some(second)) = (cores[0].ellipsoid(), cores[1].ellipsoid()) else { return false };
        let poses = poses(pair, particles, catalogue);
        let [a, b] = [0, 1].map(|k| PlacedPart::of(&poses[k], pair.parts[k]));
        let Some(start) = histories.start_of_ellipsoids(pair) else { return false };
        if a.vertices.is_some() || b.vertices.is_some() || self.queries.is_full() {
            return false;
        }
        let separation =
            particles.bodies[pair.b as usize].position - particles.bodies[pair.a as usize].position;
        let between = separation + (b.offset - a.offset);
        let placement = a.placement(&b.rotation, b.scale, &between);
        self.places[self.queries.len()] = place as u32;
        self.queries.push([first, second], &placement, &start);
        true
    }

    /// Whether no other pair can be taken.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.queries.is_full()
    }

    /// Finds the distances of all pairs; returns how many there are.
    pub(super) fn solve(&mut self) -> usize {
        solve(&mut self.queries);
        self.queries.len()
    }

    /// Place of pair `k` in the list.
    #[inline(always)]
    pub(super) fn place(&self, k: usize) -> usize {
        self.places[k] as usize
    }

    /// Contact of pair `k`, its point from the centre of mass of the first body; `None` if another query must say whether it touches.
    #[inline(always)]
    pub(super) fn contact(
        &self,
        (k, pair): (usize, &PartPair),
        histories: &mut Histories,
        particles: &Particles,
        catalogue: &Catalogue,
    ) -> Option<PartContact> {
        let poses = poses(pair, particles, catalogue);
        let [a, b] = [0, 1].map(|k| PlacedPart::of(&poses[k], pair.parts[k]));
        let (gap, nearest) = self.queries.answer(k)?;
        let Meeting::Touching(mut contact) = across_gap(&a, b.crust, &gap)? else { return None };
        histories.set_start_of_ellipsoids(pair, &nearest);
        contact.point += a.offset;
        Some(contact)
    }

    /// Forgets all pairs.
    pub(super) fn clear(&mut self) {
        self.queries.clear();
    }
}

/// How the particles of a pair lie.
#[inline(always)]
fn poses<'a>(pair: &PartPair, particles: &'a Particles, catalogue: &'a Catalogue) -> [Pose<'a>; 2] {
    [pair.a, pair.b].map(|i| Pose::of(particles, i as usize, catalogue))
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx2", "x86_64+avx2"))]
fn solve(queries: &mut EllipsoidQueries<BLOCK>) {
    queries.solve();
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use grains_geometry::gjk::distance;
    use grains_geometry::{Core, Placement, Rotation, Simplex, Superellipsoid, Vec3};

    /// Whatever lanes the processor has, the numbers are those of one lane, and those of the query of one pair.
    #[test]
    fn lanes_of_any_width_find_the_same_contacts() {
        let mut state = 7_u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut answered = 0;
        for _ in 0..100 {
            let mut queries = EllipsoidQueries::<BLOCK>::default();
            let mut asked = Vec::new();
            while !queries.is_full() {
                let cores = [0; 2].map(|_| {
                    let axes = Vec3::new(0.4 + 0.6 * unit(), 0.4 + 0.6 * unit(), 0.4 + 0.6 * unit());
                    Core::superellipsoid(Superellipsoid::new(axes, [1.0; 2]).unwrap().eroded(0.01))
                });
                let mut vector = |size: f64| Vec3::new(unit() - 0.5, unit() - 0.5, unit() - 0.5) * size;
                let matrix = Rotation::from_scaled_axis(vector(6.0)).to_rotation_matrix().into_inner();
                let mut placement = Placement { matrix, translation: vector(1.0).normalize() * 1.7 };
                let mut start = Simplex::default();
                distance(&cores[0], &cores[1], &placement, f64::INFINITY, &mut start).unwrap();
                if start.len != 1 {
                    continue;
                }
                placement.translation += vector(1e-3);
                queries.push(cores.each_ref().map(|core| core.ellipsoid().unwrap()), &placement, &start.a[0]);
                asked.push((cores, placement, start));
            }
            let mut plain = queries.clone();
            solve(&mut queries);
            plain.solve();
            for (k, (cores, placement, mut start)) in asked.into_iter().enumerate() {
                let found = queries.answer(k);
                assert_eq!(found, plain.answer(k));
                if let Some((answer, left)) = found {
                    let alone =
                        distance(&cores[0], &cores[1], &placement, f64::INFINITY, &mut start).unwrap();
                    assert_eq!((answer, left), (alone, [start.a[0], start.b[0]]));
                    answered += 1;
                }
            }
        }
        assert!(answered > 4000, "{answered}");
    }
}
