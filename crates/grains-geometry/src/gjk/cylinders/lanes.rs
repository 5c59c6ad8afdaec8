//! Many pairs of cylinders at once, in the lanes of the processor.

use super::marks::{CylinderMarks, Kind, both_rims};
use super::touching::{Feature, Touching};
use crate::convex::Rims;
use crate::gjk::Separation;
use crate::gjk::columns::{Columns, matrix, set, vector};
use crate::gjk::curved::LAST_STEP;
use crate::gjk::search::apart;
use crate::{Core, Placement};

/// Pairs that wait for each other to be answered: a whole number of times the lanes of any processor.
const GROUP: usize = 16;
/// Steps after which a pair is left to the query of one pair.
const MAX_STEPS: usize = 3;

/// Distances of up to `M` pairs of cylinders, each from the features that touched before.
///
/// Each pair is answered by the arithmetic of [`distance`](crate::gjk::distance), whatever the others are.
#[derive(Clone, Debug)]
pub struct CylinderQueries<const M: usize> {
    len: usize,
    matrices: Columns<9, M>,
    translations: Columns<3, M>,
    /// Radius, half height, and height, reach and disc of the feature (m), of A and of B.
    features: [Columns<5, M>; 2],
    /// Points on the circles as they are marked (m), then their cosines and sines.
    angles: [Columns<2, M>; 2],
    /// Lengths of the last steps (rad).
    steps: [f64; M],
    /// From A to B (m); not a number where there is no answer.
    ways: Columns<3, M>,
    /// Nearest points of A (m).
    points: Columns<3, M>,
}

impl<const M: usize> Default for CylinderQueries<M> {
    fn default() -> Self {
        let (two, three, five) = ([[0.0; M]; 2], [[0.0; M]; 3], [[0.0; M]; 5]);
        Self {
            len: 0,
            matrices: [[0.0; M]; 9],
            translations: three,
            features: [five; 2],
            angles: [two; 2],
            steps: [0.0; M],
            ways: three,
            points: three,
        }
    }
}

impl<const M: usize> CylinderQueries<M> {
    /// Number of queries.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len.min(M)
    }

    /// Whether there is no query.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Forgets all queries.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Takes the query of two cores, the second at `placement` in the frame of the first, if they are cylinders whose marked features can be
    /// solved for.
    ///
    /// # Panics
    /// If there are `M` queries.
    #[inline(always)]
    pub fn takes(&mut self, cores: [&Core; 2], placement: &Placement, marks: &CylinderMarks) -> bool {
        let Some(features) = both_rims(cores).and_then(|rims| Touching::features(rims, marks)) else {
            return false;
        };
        let k = self.len;
        set(&mut self.matrices, k, placement.matrix.as_slice());
        set(&mut self.translations, k, placement.translation.as_slice());
        for (side, Feature { rims, height, reach, disc, angle }) in features.into_iter().enumerate() {
            set(&mut self.features[side], k, &[rims.radius, rims.half_height, height, reach, disc]);
            set(&mut self.angles[side], k, &angle);
        }
        self.len += 1;
        true
    }

    /// Answers all queries that need few steps.
    #[inline(always)]
    pub fn solve(&mut self) {
        for start in (0..self.len()).step_by(GROUP) {
            let end = (start + GROUP).min(M);
            self.begin(start, end);
            for _ in 0..MAX_STEPS {
                if self.step(start, end) == 0 {
                    break;
                }
            }
            self.finish(start, end);
        }
    }

    #[inline(always)]
    fn begin(&mut self, start: usize, end: usize) {
        for k in start..end.min(M) {
            let mut touching = self.touching_with(k, Feature::turned);
            touching.face();
            self.set_angles(k, touching.angles());
            self.steps[k] = 1.0;
        }
    }

    /// Turns the points on the circles of the pairs that are not settled; returns how many those are afterwards.
    #[inline(always)]
    fn step(&mut self, start: usize, end: usize) -> u64 {
        let mut unsettled = 0;
        for k in start..end.min(M) {
            let mut touching = self.touching(k);
            let before = touching.angles();
            let step = touching.turn();
            let (turned, last) = (touching.angles(), self.steps[k]);
            let is_settled = last < LAST_STEP;
            let kept =
                |side: usize, axis: usize| if is_settled { before[side][axis] } else { turned[side][axis] };
            self.set_angles(k, [0, 1].map(|side| [kept(side, 0), kept(side, 1)]));
            let step = if is_settled { last } else { step };
            self.steps[k] = step;
            unsettled += u64::from(step >= LAST_STEP);
        }
        unsettled
    }

    #[inline(always)]
    fn finish(&mut self, start: usize, end: usize) {
        for k in start..end.min(M) {
            let touching = self.touching(k);
            let nearest = touching.nearest();
            let is_answer = touching.is_certain(&nearest) & (self.steps[k] < LAST_STEP);
            for axis in 0..3 {
                self.ways[axis][k] = if is_answer { nearest.v[axis] } else { f64::NAN };
            }
            set(&mut self.points, k, nearest.point_a.as_slice());
        }
    }

    /// The answer to a query; `None` if a search is needed.
    #[inline(always)]
    pub fn answer(&self, k: usize) -> Option<Separation> {
        let v = vector(&self.ways, k);
        (!v.x.is_nan()).then(|| apart(v, v.norm_squared(), vector(&self.points, k)))
    }

    /// Moves the marks of a query that was answered to where the features are nearest now.
    #[inline(always)]
    pub fn refresh(&self, k: usize, CylinderMarks(marks): &mut CylinderMarks) {
        for (side, mark) in marks.iter_mut().enumerate() {
            if !matches!(mark.kind, Kind::Disc { .. }) {
                mark.point = self.angles[side].each_ref().map(|column| column[k] * self.features[side][0][k]);
            }
        }
    }

    #[inline(always)]
    fn set_angles(&mut self, k: usize, angles: [[f64; 2]; 2]) {
        for (columns, angle) in self.angles.iter_mut().zip(angles) {
            set(columns, k, &angle);
        }
    }

    #[inline(always)]
    fn touching(&self, k: usize) -> Touching {
        self.touching_with(k, |feature| feature)
    }

    #[inline(always)]
    fn touching_with(&self, k: usize, prepared: impl Fn(Feature) -> Feature) -> Touching {
        let feature = |side: usize| {
            let [radius, half_height, height, reach, disc] =
                self.features[side].each_ref().map(|column| column[k]);
            let angle = self.angles[side].each_ref().map(|column| column[k]);
            prepared(Feature { rims: Rims { radius, half_height }, height, reach, disc, angle })
        };
        let matrix = matrix(&self.matrices, k);
        Touching::new([feature(0), feature(1)], matrix, vector(&self.translations, k))
    }
}
