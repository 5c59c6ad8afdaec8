//! Many pairs of ellipsoids at once, in the lanes of the processor.

use super::Pair;
use crate::gjk::Separation;
use crate::gjk::columns::{Columns, matrix, set, vector};
use crate::{Placement, Superellipsoid, Vec3};

/// Pairs that wait for each other to be answered: a whole number of times the lanes of any processor.
const GROUP: usize = 16;
/// Steps after which a pair is left to the query of one pair.
const MAX_STEPS: usize = 4;

/// Distances of up to `M` pairs of ellipsoids less their insets, each from where it touched before.
///
/// Each pair is answered by the arithmetic of [`distance`](crate::gjk::distance), whatever the others are.
#[derive(Clone, Debug)]
pub struct EllipsoidQueries<const M: usize> {
    len: usize,
    matrices: Columns<9, M>,
    translations: Columns<3, M>,
    /// Semi-axes and inset (m) of A and of B.
    bodies: [Columns<4, M>; 2],
    /// Points of A to start from (m), and then its unit normals there.
    normals: Columns<3, M>,
    /// Distances (m); not a number where there is no answer.
    distances: [f64; M],
    /// Nearest points of the surfaces without inset, in the frames of their bodies (m).
    points: [Columns<3, M>; 2],
}

impl<const M: usize> Default for EllipsoidQueries<M> {
    fn default() -> Self {
        let (three, four) = ([[0.0; M]; 3], [[0.0; M]; 4]);
        Self {
            len: 0,
            matrices: [[0.0; M]; 9],
            translations: three,
            bodies: [four; 2],
            normals: three,
            distances: [0.0; M],
            points: [three; 2],
        }
    }
}

impl<const M: usize> EllipsoidQueries<M> {
    /// Number of queries.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len.min(M)
    }

    /// Whether there is no query.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Whether no other query can be taken.
    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.len >= M
    }

    /// Forgets all queries.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Adds the query of two ellipsoids, the second at `placement` in the frame of the first, that starts from a point of the surface of
    /// the first, without inset (m).
    ///
    /// # Panics
    /// If there are `M` queries.
    #[inline(always)]
    pub fn push(&mut self, bodies: [&Superellipsoid; 2], placement: &Placement, start: &Vec3) {
        let k = self.len;
        set(&mut self.matrices, k, placement.matrix.as_slice());
        set(&mut self.translations, k, placement.translation.as_slice());
        for (columns, body) in self.bodies.iter_mut().zip(bodies) {
            let axes = body.semi_axes();
            set(columns, k, &[axes.x, axes.y, axes.z, body.inset()]);
        }
        set(&mut self.normals, k, start.as_slice());
        self.len += 1;
    }

    /// Answers all queries that need few steps.
    #[inline(always)]
    pub fn solve(&mut self) {
        for start in (0..self.len()).step_by(GROUP) {
            let end = (start + GROUP).min(M);
            for k in start..end {
                let normal = self.pair(k).normal_at(&vector(&self.normals, k));
                set(&mut self.normals, k, normal.as_slice());
            }
            for _ in 0..MAX_STEPS {
                if self.step(start, end) == 0 {
                    break;
                }
            }
        }
    }

    /// Looks whether the normals are those of the answers, and turns the others; returns how many those are.
    #[inline(always)]
    fn step(&mut self, start: usize, end: usize) -> u64 {
        let mut unsettled = 0;
        for k in start..end.min(M) {
            let (pair, matrix) = (self.pair(k), matrix(&self.matrices, k));
            let normal = vector(&self.normals, k);
            let plane = pair.across(&normal);
            let turned = pair.turned(&normal, &plane);
            let is_answer = pair.has_nearest_points(&plane);
            self.distances[k] = if is_answer { plane.lower } else { f64::NAN };
            for axis in 0..3 {
                self.normals[axis][k] = if is_answer { normal[axis] } else { turned[axis] };
            }
            set(&mut self.points[0], k, plane.point_a.as_slice());
            set(&mut self.points[1], k, pair.in_frame_of_b(&matrix, &plane.point_b).as_slice());
            unsettled += u64::from(!is_answer);
        }
        unsettled
    }

    /// The answer to a query, and the points of the surfaces without inset that are nearest each other, in the frames of their bodies (m):
    /// the start of the next one. `None` if it needs more steps or the cores meet.
    #[inline(always)]
    pub fn answer(&self, k: usize) -> Option<(Separation, [Vec3; 2])> {
        let distance = self.distances[k];
        if distance.is_nan() {
            return None;
        }
        let normal = vector(&self.normals, k);
        let points = [0, 1].map(|side| vector(&self.points[side], k));
        let point_a = points[0] - normal * self.bodies[0][3][k];
        Some((Separation::Apart { distance, normal, point_a, point_b: point_a + normal * distance }, points))
    }

    #[inline(always)]
    fn pair(&self, k: usize) -> Pair {
        let [a, b] = &self.bodies;
        let axes = [a, b].map(|body| Vec3::new(body[0][k], body[1][k], body[2][k]));
        Pair::new(axes, [a[3][k], b[3][k]], &matrix(&self.matrices, k), vector(&self.translations, k))
    }
}
