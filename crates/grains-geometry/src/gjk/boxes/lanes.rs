//! Many pairs of boxes at once, in the lanes of the processor.

use super::start::axes_of;
use super::{BoxStart, PAIRS_OF_EDGES, Pair, Touched, unit_vector};
use crate::gjk::Separation;
use crate::gjk::columns::{Columns, matrix, set, vector};
use crate::{Placement, Vec3};

/// Pairs that are answered together: a whole number of times the lanes of any processor.
const GROUP: usize = 8;

/// Distances of up to `M` pairs of boxes that touched corner on face, and as many edge on edge.
///
/// Each pair is answered by the arithmetic of [`distance`](crate::gjk::distance), whatever the others are.
#[derive(Clone, Debug, Default)]
pub struct BoxQueries<const M: usize> {
    corners: Queries<M>,
    edges: Queries<M>,
    /// Those of which something else touches.
    others: Queries<M>,
}

/// Distances of pairs of boxes that touched in one of these ways.
#[derive(Clone, Debug)]
struct Queries<const M: usize> {
    len: usize,
    matrices: Columns<9, M>,
    translations: Columns<3, M>,
    /// Half edges (m).
    halves: [Columns<3, M>; 2],
    /// Ways from A to B, of any length.
    ways: Columns<3, M>,
    /// Unit vectors along the edges that touch, in the frames of the boxes; zero if a corner is on a face.
    edges: [Columns<3, M>; 2],
    /// Distances (m); not a number where there is no answer.
    distances: [f64; M],
    normals: Columns<3, M>,
    /// Nearest points, in the frames of the boxes (m).
    points: [Columns<3, M>; 2],
}

impl<const M: usize> Default for Queries<M> {
    fn default() -> Self {
        let three = [[0.0; M]; 3];
        Self {
            len: 0,
            matrices: [[0.0; M]; 9],
            translations: three,
            halves: [three; 2],
            ways: three,
            edges: [three; 2],
            distances: [0.0; M],
            normals: three,
            points: [three; 2],
        }
    }
}

impl<const M: usize> BoxQueries<M> {
    /// Forgets all queries.
    #[inline(always)]
    pub fn clear(&mut self) {
        (self.corners.len, self.edges.len) = (0, 0);
    }

    /// Adds the query of two boxes of half edges (m), the second at `placement` in the frame of the first; returns its number.
    ///
    /// # Panics
    /// If there are `M` queries of those that touched in the same way.
    #[inline(always)]
    pub fn push(&mut self, halves: &[Vec3; 2], placement: &Placement, start: &BoxStart) -> usize {
        let pair = Pair { halves: *halves, matrix: placement.matrix, translation: placement.translation };
        match start {
            BoxStart::CornerOnFace(points) => {
                self.corners.push(&pair, &pair.between(points), &[Vec3::zeros(); 2]);
                2 * (self.corners.len - 1)
            }
            BoxStart::EdgeOnEdge(corners) => {
                self.edges.push(&pair, &Vec3::zeros(), &axes_of(corners).map(unit_vector));
                2 * (self.edges.len - 1) + 1
            }
        }
    }

    /// Answers all queries for which no search is needed.
    #[inline(always)]
    pub fn solve(&mut self) {
        let Self { corners, edges, others } = self;
        corners.solve_corners();
        edges.solve_edges();
        for k in 0..edges.len.min(M) {
            let way = edges.pair(k).across(&edges.edges(k));
            set(&mut edges.ways, k, way.as_slice());
        }
        for queries in [corners, edges] {
            queries.solve_others(others);
        }
    }

    /// The answer to the query of a number, and the start of the next one. `None` if a search is needed.
    #[inline(always)]
    pub fn answer(&self, number: usize) -> Option<(Separation, BoxStart)> {
        let (queries, k) = self.place(number);
        let touched = queries.touched(k);
        Some((touched.answer()?, touched.start(&self.halves(number))))
    }

    /// Half edges of the boxes of the query of a number (m).
    #[inline(always)]
    pub fn halves(&self, number: usize) -> [Vec3; 2] {
        let (queries, k) = self.place(number);
        [0, 1].map(|side| vector(&queries.halves[side], k))
    }

    /// Where the query of a number is: even numbers are those of corners on faces.
    #[inline(always)]
    fn place(&self, number: usize) -> (&Queries<M>, usize) {
        (if number.is_multiple_of(2) { &self.corners } else { &self.edges }, number / 2)
    }
}

impl<const M: usize> Queries<M> {
    #[inline(always)]
    fn push(&mut self, pair: &Pair, way: &Vec3, edges: &[Vec3; 2]) {
        let k = self.len;
        set(&mut self.matrices, k, pair.matrix.as_slice());
        set(&mut self.translations, k, pair.translation.as_slice());
        set(&mut self.ways, k, way.as_slice());
        for (columns, half) in self.halves.iter_mut().zip(&pair.halves) {
            set(columns, k, half.as_slice());
        }
        for (columns, edge) in self.edges.iter_mut().zip(edges) {
            set(columns, k, edge.as_slice());
        }
        self.len += 1;
    }

    /// Looks at the faces that look at each other along the ways.
    #[inline(always)]
    fn solve_corners(&mut self) {
        for start in (0..self.len.min(M)).step_by(GROUP) {
            for k in start..(start + GROUP).min(M) {
                let touched = self.pair(k).corner_on_face(&vector(&self.ways, k));
                self.set(k, &touched);
            }
        }
    }

    /// Looks at the edges.
    #[inline(always)]
    fn solve_edges(&mut self) {
        for start in (0..self.len.min(M)).step_by(GROUP) {
            for k in start..(start + GROUP).min(M) {
                let touched = self.pair(k).edge_on_edge(&self.edges(k));
                self.set(k, &touched);
            }
        }
    }

    /// Answers the queries that have no answer yet, if something else touches.
    #[inline(always)]
    fn solve_others(&mut self, others: &mut Self) {
        let mut places = [0; M];
        others.len = 0;
        for k in 0..self.len.min(M) {
            if self.distances[k].is_nan() {
                places[others.len] = k;
                others.push(&self.pair(k), &vector(&self.ways, k), &[Vec3::zeros(); 2]);
            }
        }
        let places = &places[..others.len];
        others.solve_corners();
        for number in 0..PAIRS_OF_EDGES {
            if self.take_answers(others, places) == 0 {
                return;
            }
            for k in 0..others.len.min(M) {
                let edges = others.pair(k).edges_about(&vector(&others.ways, k), number);
                for (columns, edge) in others.edges.iter_mut().zip(&edges) {
                    set(columns, k, edge.as_slice());
                }
            }
            others.solve_edges();
        }
        self.take_answers(others, places);
    }

    /// Takes the answers to queries in places that have none; returns how many have none afterwards.
    #[inline(always)]
    fn take_answers(&mut self, others: &Self, places: &[usize]) -> usize {
        let mut unanswered = 0;
        for (k, &place) in places.iter().enumerate() {
            if self.distances[place].is_nan() {
                self.set(place, &others.touched(k));
                unanswered += usize::from(others.distances[k].is_nan());
            }
        }
        unanswered
    }

    #[inline(always)]
    fn set(&mut self, k: usize, touched: &Touched) {
        self.distances[k] = touched.distance;
        set(&mut self.normals, k, touched.normal.as_slice());
        for (columns, point) in self.points.iter_mut().zip(&touched.points) {
            set(columns, k, point.as_slice());
        }
        for (columns, edge) in self.edges.iter_mut().zip(&touched.edges) {
            set(columns, k, edge.as_slice());
        }
    }

    #[inline(always)]
    fn touched(&self, k: usize) -> Touched {
        Touched {
            distance: self.distances[k],
            normal: vector(&self.normals, k),
            points: [0, 1].map(|side| vector(&self.points[side], k)),
            edges: self.edges(k),
        }
    }

    #[inline(always)]
    fn edges(&self, k: usize) -> [Vec3; 2] {
        [0, 1].map(|side| vector(&self.edges[side], k))
    }

    #[inline(always)]
    fn pair(&self, k: usize) -> Pair {
        Pair {
            halves: [0, 1].map(|side| vector(&self.halves[side], k)),
            matrix: matrix(&self.matrices, k),
            translation: vector(&self.translations, k),
        }
    }
}
