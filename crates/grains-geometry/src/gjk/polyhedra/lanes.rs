//! Many pairs of polyhedra at once, in the lanes of the processor.

use super::start::PolyhedronStart;
use super::{Pair, Touched};
use crate::gjk::Separation;
use crate::gjk::start::FOOT;
use crate::lanes::{LANES, Lanes, Matrix, Number as _, Vector};
use crate::{Placement, Polyhedron};
use std::sync::Arc;

/// How two polyhedra touched.
#[derive(Clone, Copy, Debug)]
enum Way {
    OnFirst,
    OnSecond,
    EdgeOnEdge,
}

/// Distances of pairs of polyhedra that touched corner on face or edge on edge.
///
/// Pairs of the same two polyhedra that touched in the same way are answered side by side, each by the arithmetic of
/// [`distance`](crate::gjk::distance), whatever the others are.
#[derive(Clone, Debug, Default)]
pub struct PolyhedronQueries<const GROUPS: usize> {
    groups: Vec<Group>,
    /// Number of groups that have queries.
    len: usize,
    /// The groups that were added to last, for each way in which two touched.
    open: [Option<usize>; 3],
}

/// Queries side by side.
#[derive(Clone, Debug)]
struct Group {
    hulls: [Arc<Polyhedron>; 2],
    way: Way,
    len: usize,
    pair: Pair<Lanes>,
    /// Points of the features that touched, in the frames of the bodies (m).
    points: [[Vector<Lanes>; 2]; 2],
    /// Numbers of the ends of the edges that touched.
    ends: [[[u16; 2]; 2]; LANES],
    touched: Touched<Lanes>,
}

impl Group {
    fn new(hulls: [Arc<Polyhedron>; 2]) -> Self {
        let zero = Lanes::of(0.0);
        let vector = Vector([zero; 3]);
        Self {
            hulls,
            way: Way::OnFirst,
            len: 0,
            pair: Pair { matrix: Matrix([vector; 3]), translation: vector },
            points: [[vector; 2]; 2],
            ends: [[[0; 2]; 2]; LANES],
            touched: Touched { distance: zero, normal: vector, point_a: vector, foot: vector, place: zero },
        }
    }
}

impl<const GROUPS: usize> PolyhedronQueries<GROUPS> {
    /// Whether there can be queries of a polyhedron.
    #[inline(always)]
    pub fn are_for(hull: &Polyhedron) -> bool {
        !hull.faces().is_empty() && hull.vertices().len() < FOOT as usize
    }

    /// Forgets all queries.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.len = 0;
        self.open = [None; 3];
    }

    /// Adds the query of two polyhedra, the second at `placement` in the frame of the first; returns its number, or `None` if there is no room.
    // Not in the loop over pairs, which takes 1.03 of its time for cubes and ellipsoids with it.
    #[inline(never)]
    pub fn push(
        &mut self,
        hulls: [&Arc<Polyhedron>; 2],
        placement: &Placement,
        start: &PolyhedronStart,
    ) -> Option<u32> {
        let way = match start {
            PolyhedronStart::OnFirst(..) => Way::OnFirst,
            PolyhedronStart::OnSecond(..) => Way::OnSecond,
            PolyhedronStart::EdgeOnEdge(..) => Way::EdgeOnEdge,
        };
        let place = self.group_for(hulls, way)?;
        let group = &mut self.groups[place];
        let lane = group.len;
        group.len += 1;
        group.pair.matrix.set(lane, &placement.matrix);
        group.pair.translation.set(lane, &placement.translation);
        let corner = |side: usize, number: u16| &hulls[side].vertices()[number as usize];
        match start {
            PolyhedronStart::OnFirst(number, foot) => {
                group.points[0][0].set(lane, foot);
                group.points[1][0].set(lane, corner(1, *number));
            }
            PolyhedronStart::OnSecond(number, foot) => {
                group.points[0][0].set(lane, corner(0, *number));
                group.points[1][0].set(lane, foot);
            }
            PolyhedronStart::EdgeOnEdge(ends, _) => {
                group.ends[lane] = *ends;
                for (side, (points, numbers)) in group.points.iter_mut().zip(ends).enumerate() {
                    for (point, number) in points.iter_mut().zip(numbers) {
                        point.set(lane, corner(side, *number));
                    }
                }
            }
        }
        Some((place * LANES + lane) as u32)
    }

    /// The group to which a query is added.
    #[inline(always)]
    fn group_for(&mut self, hulls: [&Arc<Polyhedron>; 2], way: Way) -> Option<usize> {
        let are_its = |group: &Group| (0..2).all(|side| Arc::ptr_eq(&group.hulls[side], hulls[side]));
        if let Some(place) = self.open[way as usize]
            .filter(|&place| self.groups[place].len < LANES && are_its(&self.groups[place]))
        {
            return Some(place);
        }
        if self.len == GROUPS {
            return None;
        }
        let place = self.len;
        if place == self.groups.len() {
            self.groups.reserve_exact(GROUPS - place);
            self.groups.push(Group::new(hulls.map(Arc::clone)));
        } else if !are_its(&self.groups[place]) {
            self.groups[place].hulls = hulls.map(Arc::clone);
        }
        (self.groups[place].way, self.groups[place].len) = (way, 0);
        self.open[way as usize] = Some(place);
        self.len += 1;
        Some(place)
    }

    /// Answers all queries for which no search is needed.
    #[inline(always)]
    pub fn solve(&mut self) {
        for group in &mut self.groups[..self.len] {
            let hulls = group.hulls.each_ref().map(|hull| &**hull);
            let [[on_a, _], [on_b, _]] = group.points;
            group.touched = match group.way {
                Way::OnFirst => group.pair.over_first(hulls, &group.pair.between(&[on_a, on_b])),
                Way::OnSecond => group.pair.over_second(hulls, &group.pair.between(&[on_a, on_b])),
                Way::EdgeOnEdge => group.pair.edge_on_edge(hulls, &group.points),
            };
        }
    }

    /// The answer to the query of a number, and the start of the next one. `None` if a search is needed.
    #[inline(always)]
    pub fn answer(&self, number: u32) -> Option<(Separation, PolyhedronStart)> {
        let (group, lane) = (&self.groups[number as usize / LANES], number as usize % LANES);
        let touched = &group.touched;
        let distance = touched.distance.0[lane];
        if distance.is_nan() {
            return None;
        }
        let (normal, point_a) = (touched.normal.get(lane), touched.point_a.get(lane));
        let point_b = point_a + normal * distance;
        let (place, foot) = (touched.place.0[lane], touched.foot.get(lane));
        let start = match group.way {
            Way::OnFirst => PolyhedronStart::OnFirst(place as u16, foot),
            Way::OnSecond => PolyhedronStart::OnSecond(place as u16, foot),
            Way::EdgeOnEdge => PolyhedronStart::EdgeOnEdge(group.ends[lane], place > 0.5),
        };
        Some((Separation::Apart { distance, normal, point_a, point_b }, start))
    }
}
