//! Many pairs of superellipsoids at once, in the lanes of the processor.

use super::{MAX_STEPS, Pair};
use crate::gjk::Separation;
use crate::lanes::{LANES, Lanes, Matrix, Number as _, Vector};
use crate::superellipsoid::RoundBody;
use crate::{Placement, Superellipsoid, Vec3};

/// Distances of pairs of superellipsoids less their insets, each from where it touched before.
///
/// Pairs of the same two bodies are answered side by side, each by the arithmetic of [`distance`](crate::gjk::distance), whatever the others
/// are.
#[derive(Clone, Debug, Default)]
pub struct SuperellipsoidQueries<const GROUPS: usize> {
    groups: Vec<Group>,
    /// Number of groups that have queries.
    len: usize,
}

/// Queries side by side.
#[derive(Clone, Debug)]
struct Group {
    bodies: [RoundBody; 2],
    /// Where the bodies are in memory, as long as queries are added.
    addresses: [usize; 2],
    len: usize,
    matrix: Matrix<Lanes>,
    translation: Vector<Lanes>,
    /// Points of the surfaces that may be nearest each other, in the frames of the bodies (m).
    points: [Vector<Lanes>; 2],
    /// Distances (m); not a number where there is no answer.
    distances: Lanes,
    normals: Vector<Lanes>,
    /// Nearest points of the first cores (m).
    nearest: Vector<Lanes>,
}

impl<const GROUPS: usize> SuperellipsoidQueries<GROUPS> {
    /// Forgets all queries.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Adds the query of two superellipsoids, the second at `placement` in the frame of the first, that starts from points of the surfaces in
    /// the frames of the bodies (m); returns its number, or `None` if there is no room or a body has edges.
    // Not in the loop over pairs, which takes 1.03 of its time for cubes and ellipsoids with it.
    #[inline(never)]
    pub fn push(
        &mut self,
        bodies: [&Superellipsoid; 2],
        placement: &Placement,
        start: &[Vec3; 2],
    ) -> Option<u32> {
        let place = self.group_for(bodies)?;
        let group = &mut self.groups[place];
        let lane = group.len;
        group.len += 1;
        group.matrix.set(lane, &placement.matrix);
        group.translation.set(lane, &placement.translation);
        for (points, start) in group.points.iter_mut().zip(start) {
            points.set(lane, start);
        }
        Some((place * LANES + lane) as u32)
    }

    /// The group to which a query is added.
    #[inline(always)]
    fn group_for(&mut self, bodies: [&Superellipsoid; 2]) -> Option<usize> {
        let addresses = bodies.map(|body| std::ptr::from_ref(body) as usize);
        if let Some(last) = self.len.checked_sub(1) {
            let group = &self.groups[last];
            if group.len < LANES && group.addresses == addresses {
                return Some(last);
            }
        }
        if self.len == GROUPS {
            return None;
        }
        let bodies = [bodies[0].round()?, bodies[1].round()?];
        let place = self.len;
        if place == self.groups.len() {
            self.groups.reserve_exact(GROUPS - place);
            let zero = Lanes::of(0.0);
            let vector = Vector([zero; 3]);
            self.groups.push(Group {
                bodies,
                addresses,
                len: 0,
                matrix: Matrix([vector; 3]),
                translation: vector,
                points: [vector; 2],
                distances: zero,
                normals: vector,
                nearest: vector,
            });
        }
        let group = &mut self.groups[place];
        (group.bodies, group.addresses, group.len) = (bodies, addresses, 0);
        self.len += 1;
        Some(place)
    }

    /// Answers all queries that need few steps.
    #[inline(always)]
    pub fn solve(&mut self) {
        for group in &mut self.groups[..self.len] {
            group.solve();
        }
    }

    /// The answer to the query of a number, and the points of the surfaces without inset that are nearest each other, in the frames of their
    /// bodies (m): the start of the next one. `None` if it needs more steps or the cores meet.
    #[inline(always)]
    pub fn answer(&self, number: u32) -> Option<(Separation, [Vec3; 2])> {
        let (group, lane) = (&self.groups[number as usize / LANES], number as usize % LANES);
        let distance = group.distances.0[lane];
        if distance.is_nan() {
            return None;
        }
        let (normal, point_a) = (group.normals.get(lane), group.nearest.get(lane));
        let point_b = point_a + normal * distance;
        let points = group.points.each_ref().map(|points| points.get(lane));
        Some((Separation::Apart { distance, normal, point_a, point_b }, points))
    }
}

impl Group {
    #[inline(always)]
    fn solve(&mut self) {
        let pair = Pair::new(&self.bodies, self.matrix, self.translation);
        let none = Lanes::of(f64::NAN);
        self.distances = none;
        let mut near = self.points;
        for _ in 0..MAX_STEPS {
            let facing = pair.facing(&near);
            let distance = facing.distance();
            let at = facing.at.each_ref().map(|at| at.point);
            // What has an answer keeps it.
            for lane in 0..LANES {
                let is_answer = self.distances.0[lane].is_nan() & !distance.0[lane].is_nan();
                if is_answer {
                    self.distances.0[lane] = distance.0[lane];
                    self.normals.set(lane, &facing.at[0].normal.get(lane));
                    self.nearest.set(lane, &facing.nearest_of_a().get(lane));
                    for (points, at) in self.points.iter_mut().zip(&at) {
                        points.set(lane, &at.get(lane));
                    }
                }
            }
            if self.distances.0[..self.len].iter().all(|distance| !distance.is_nan()) {
                return;
            }
            near = facing.step();
        }
    }
}
