//! The pairs of features that touch, and the wrench of their forces.

use super::{ContactPatch, Nearest};
use crate::convex::feature::{Feature, SIDES, to_segment};
use crate::{Core, Mat3, Placement, Vec3};

/// Squared sine of the angle of two edges below which they are parallel: their ends stand for them.
const PARALLEL: f64 = 1e-20;
/// Share of the overlap by which a pair is the nearest points themselves.
const SAME: f64 = 1e-9;
/// Most pairs that the nearest points of curved bodies are compared with.
pub(super) const PAIRS: usize = 48;

/// A core in a frame.
pub(super) struct PlacedCore<'a> {
    core: &'a Core,
    placement: Option<&'a Placement>,
    scale: f64,
}

impl<'a> PlacedCore<'a> {
    pub(super) fn unmoved(core: &'a Core) -> Self {
        Self { core, placement: None, scale: 1.0 }
    }

    pub(super) fn at(core: &'a Core, placement: &'a Placement) -> Self {
        Self { core, placement: Some(placement), scale: placement.matrix.column(0).norm() }
    }

    /// Finds the face or line that looks most along a unit direction.
    pub(super) fn feature(&self, direction: &Vec3, found: &mut Feature) -> Option<()> {
        let Some(placement) = self.placement else { return self.core.contact_feature(direction, found) };
        self.core.contact_feature(&(placement.matrix.tr_mul(direction) / self.scale), found)?;
        found.transform(|point| placement.apply(point), |normal| placement.matrix * normal / self.scale);
        Some(())
    }

    /// From a point to the nearest of the core, or of its feature (m).
    pub(super) fn offset_from(&self, feature: &Feature, point: &Vec3) -> Vec3 {
        let found = match self.placement {
            None => self.core.offset_from(point),
            Some(placement) => {
                let squared = self.scale * self.scale;
                let local = placement.matrix.tr_mul(&(point - placement.translation)) / squared;
                self.core.offset_from(&local).map(|offset| placement.matrix * offset)
            }
        };
        found.unwrap_or_else(|| feature.offset_from(point))
    }
}

/// The edges of a feature: of a face all around, of a line the line.
pub(super) struct Edges<'a> {
    points: &'a [Vec3],
    /// Unit normals of the edges in the plane of the face, away from it; zero of a line (-).
    outward: [Vec3; SIDES],
    count: usize,
}

impl<'a> Edges<'a> {
    pub(super) fn of(feature: &'a Feature) -> Self {
        let points = feature.points();
        let count = if points.len() > 2 { points.len() } else { points.len() / 2 };
        let mut edges = Self { points, outward: [Vec3::zeros(); SIDES], count };
        if let Some(normal) = feature.normal() {
            for k in 0..count {
                let [p, q] = edges.ends(k);
                edges.outward[k] = (q - p).cross(&normal).normalize();
            }
        }
        edges
    }

    #[inline]
    fn ends(&self, k: usize) -> [&'a Vec3; 2] {
        [&self.points[k], &self.points[if k + 1 < self.points.len() { k + 1 } else { 0 }]]
    }

    /// Whether two points lie off edge `k` by more than `reach` (m) to the same side in the plane of the face.
    #[inline]
    fn are_beside(&self, k: usize, others: [&Vec3; 2], reach: f64) -> bool {
        let [s, t] = others.map(|x| self.outward[k].dot(&(x - self.points[k])));
        s.min(t) > reach || s.max(t) < -reach
    }
}

/// The nearest points of two features.
#[derive(Clone, Copy)]
pub(super) struct Pair {
    /// Midway between them, from the nearest points of the bodies (m).
    arm: Vec3,
    /// Unit vector from the one of A to the one of B (-).
    normal: Vec3,
    /// Overlap over that of the bodies, u ≤ 1 (-).
    ratio: f64,
}

impl Pair {
    /// One that does not touch.
    pub(super) const NONE: Self =
        Self { arm: Vec3::new(0.0, 0.0, 0.0), normal: Vec3::new(0.0, 0.0, 0.0), ratio: 0.0 };
}

#[inline]
fn seventh_power(x: f64) -> f64 {
    let square = x * x;
    square * square * square * x
}

/// Sums over the pairs, lengths from the nearest points of the bodies, overlaps u in units of theirs.
pub(super) struct Sum<'a> {
    nearest: Nearest,
    overlap: f64,
    /// Largest distance along the surface of features that touch (m).
    reach: f64,
    /// Σ T = (D/δ)⁸ (-).
    eighth: f64,
    /// Σ g n and Σ g x × n with g = (1/8) ∂ΣT/∂u.
    push: Vec3,
    turn: Vec3,
    /// Σ g, Σ g x and Σ g (x × n)(x × n)ᵀ.
    total: f64,
    first: Vec3,
    second: Mat3,
    /// The pairs, if there may be others between them as deep.
    pairs: Option<&'a mut [Pair; PAIRS]>,
    len: usize,
    /// Largest u (-).
    deepest: f64,
}

impl<'a> Sum<'a> {
    pub(super) fn new(nearest: &Nearest) -> Self {
        let Nearest { gap, crusts, .. } = *nearest;
        Self {
            nearest: *nearest,
            overlap: crusts - gap,
            reach: ((crusts - gap) * (crusts + gap)).max(0.0).sqrt(),
            eighth: 0.0,
            push: Vec3::zeros(),
            turn: Vec3::zeros(),
            total: 0.0,
            first: Vec3::zeros(),
            second: Mat3::zeros(),
            pairs: None,
            len: 0,
            deepest: 0.0,
        }
    }

    /// Keeps the pairs, for [`Sum::add_nearest`].
    pub(super) fn keep_in(&mut self, pairs: &'a mut [Pair; PAIRS]) {
        self.pairs = Some(pairs);
    }

    /// The sum of two patches.
    pub(super) fn of_patches(patches: [&ContactPatch; 2]) -> Self {
        let deeper = patches[usize::from(patches[1].overlap > patches[0].overlap)];
        let ContactPatch { normal, center: point, overlap, .. } = *deeper;
        let mut sum = Self::new(&Nearest { normal, point, gap: 0.0, crusts: overlap });
        for patch in patches {
            let ratio = patch.overlap / overlap;
            let pair = Pair { arm: patch.center - point, normal: patch.normal, ratio };
            let weight = seventh_power(ratio) * patch.weight;
            sum.eighth += seventh_power(ratio) * ratio;
            sum.add(&pair, weight);
            sum.turn += patch.normal * (patch.pitch * weight);
            sum.second += patch.second * weight;
        }
        sum.len = 2;
        sum
    }

    #[inline]
    fn add(&mut self, pair: &Pair, weight: f64) {
        let Pair { arm, normal, .. } = pair;
        let force = normal * weight;
        self.push += force;
        self.turn += arm.cross(&force);
        self.total += weight;
        self.first += arm * weight;
        let lever = arm.cross(&self.nearest.normal);
        self.second += lever * (lever * weight).transpose();
    }

    /// Adds u⁸ of a pair.
    #[inline]
    fn add_whole(&mut self, pair: &Pair) {
        let weight = seventh_power(pair.ratio);
        self.eighth += weight * pair.ratio;
        self.add(pair, weight);
        self.keep(pair);
    }

    fn keep(&mut self, pair: &Pair) {
        if let Some(place) = self.pairs.as_mut().and_then(|pairs| pairs.get_mut(self.len)) {
            *place = *pair;
        }
        self.len += 1;
        self.deepest = self.deepest.max(pair.ratio);
    }

    /// Adds u⁸ Π (1 − (u_k/u)⁸) of a pair that others stand for where they are as deep.
    fn add_remainder(&mut self, pair: &Pair, others: &[Pair]) {
        let mut gaps = [1.0; PAIRS];
        for (gap, other) in gaps.iter_mut().zip(others) {
            let x = (other.ratio / pair.ratio).clamp(0.0, 1.0);
            *gap = 1.0 - seventh_power(x) * x;
        }
        let gaps = &gaps[..others.len().min(PAIRS)];
        let all: f64 = gaps.iter().product();
        let mut own = all;
        for (k, other) in others.iter().enumerate().filter(|(_, other)| other.ratio > 0.0) {
            let rest: f64 = gaps[..k].iter().chain(&gaps[k + 1..]).product();
            own += (1.0 - gaps[k]) * rest;
            self.add(other, -seventh_power(other.ratio.min(pair.ratio)) * rest);
        }
        let weight = seventh_power(pair.ratio);
        self.eighth += weight * pair.ratio * all;
        self.add(pair, weight * own);
    }

    /// The pair of a point of A and the point `offset` (m) from it, or of one of B if `side` is −1.
    fn pair(&self, point: &Vec3, offset: &Vec3, side: f64) -> Pair {
        let distance = offset.norm();
        let normal = if distance > 0.0 { offset * (side / distance) } else { self.nearest.normal };
        let ratio = (self.nearest.crusts - distance) / self.overlap;
        Pair { arm: point + offset * 0.5 - self.nearest.point, normal, ratio }
    }

    /// Adds a corner at `gap` (m) from a surface behind it along a unit normal.
    pub(super) fn add_corner(&mut self, corner: &Vec3, normal: &Vec3, gap: f64) {
        let ratio = (self.nearest.crusts - gap) / self.overlap;
        if ratio > 0.0 {
            self.add_whole(&Pair { arm: corner - self.nearest.point, normal: *normal, ratio });
        }
    }

    /// Distance (m) of a point behind the deepest of its body, which is A, or B if `side` is −1.
    fn behind(&self, point: &Vec3, side: f64) -> f64 {
        let Nearest { normal, point: middle, gap, .. } = &self.nearest;
        -side * normal.dot(&(point - middle)) - 0.5 * gap
    }

    /// Adds the corners of a feature of A, or of B if `side` is −1, that touch the other body.
    pub(super) fn add_corners(
        &mut self,
        feature: &Feature,
        side: f64,
        offset_of: impl Fn(&Vec3) -> Option<Vec3>,
    ) {
        for corner in feature.points() {
            if self.behind(corner, side) >= self.overlap {
                continue;
            }
            let Some(offset) = offset_of(corner) else { continue };
            let pair = self.pair(corner, &offset, side);
            if pair.ratio > 0.0 {
                self.add_whole(&pair);
            }
        }
    }

    /// Adds the edges of A and B that cross; `counts` tells which of B, for a vector towards A, do.
    pub(super) fn add_edges(&mut self, first: &Edges, second: &Edges, counts: impl Fn(usize, &Vec3) -> bool) {
        // Behind which of B an edge is too far for all of A, and the other way round.
        let mut heights = [f64::INFINITY; SIDES];
        for (k, height) in heights.iter_mut().enumerate().take(second.count) {
            *height = second.ends(k).map(|x| self.behind(x, -1.0)).into_iter().fold(f64::INFINITY, f64::min);
        }
        for j in 0..first.count {
            let [a, b] = first.ends(j);
            let height = self.behind(a, 1.0).min(self.behind(b, 1.0));
            if height >= self.overlap {
                continue;
            }
            for (k, other) in heights.iter().enumerate().take(second.count) {
                if height + other >= self.overlap
                    || second.are_beside(k, [a, b], self.reach)
                    || first.are_beside(j, second.ends(k), self.reach)
                {
                    continue;
                }
                self.add_crossing([a, b], second.ends(k), |toward| counts(k, toward));
            }
        }
    }

    /// Adds two edges whose nearest points are none of their ends.
    fn add_crossing(&mut self, [a, b]: [&Vec3; 2], [c, d]: [&Vec3; 2], counts: impl Fn(&Vec3) -> bool) {
        let (along, other, between) = (b - a, d - c, c - a);
        let normal = along.cross(&other);
        let squared = normal.norm_squared();
        if squared <= PARALLEL * along.norm_squared() * other.norm_squared() {
            return;
        }
        let s = between.cross(&other).dot(&normal) / squared;
        let t = between.cross(&along).dot(&normal) / squared;
        if !(0.0..=1.0).contains(&s) || !(0.0..=1.0).contains(&t) {
            return;
        }
        let on_first = a + along * s;
        let offset = c + other * t - on_first;
        let pair = self.pair(&on_first, &offset, 1.0);
        if pair.ratio <= 0.0 || !counts(&-offset) {
            return;
        }
        // Across the other edge the ends are this far off, beside the gap.
        let is_far = |share: f64, other: &Vec3| {
            share * share * squared > self.reach * self.reach * other.norm_squared()
        };
        if is_far(s.min(1.0 - s), &other) && is_far(t.min(1.0 - t), &along) {
            self.add_whole(&pair);
            return;
        }
        let ends = [
            self.pair(a, &to_segment(a, c, d), 1.0),
            self.pair(b, &to_segment(b, c, d), 1.0),
            self.pair(c, &to_segment(c, a, b), -1.0),
            self.pair(d, &to_segment(d, a, b), -1.0),
        ];
        self.add_remainder(&pair, &ends);
        self.keep(&pair);
    }

    /// Adds the nearest points of the bodies, as far as no pair stands for them: those of curved ones.
    pub(super) fn add_nearest(&mut self) {
        let Some(pairs) = self.pairs.take().filter(|_| self.deepest < 1.0 - SAME) else { return };
        let whole = Pair { arm: Vec3::zeros(), normal: self.nearest.normal, ratio: 1.0 };
        self.add_remainder(&whole, &pairs[..self.len.min(PAIRS)]);
        self.len += 1;
    }

    /// Whether no more than one pair touches.
    pub(super) fn is_point(&self) -> bool {
        self.len <= 1
    }

    /// The norm of the overlaps and the wrench of the forces; `None` if nothing touches.
    /// B has been moved by `lift` (m) to find them.
    pub(super) fn patch(&self, lift: &Vec3) -> Option<ContactPatch> {
        let push = self.push.norm();
        if self.eighth <= 0.0 || push <= 0.0 || self.total <= 0.0 {
            return None;
        }
        let root = self.eighth.sqrt().sqrt().sqrt();
        let normal = self.push / push;
        let mean = self.first / self.total;
        let couple = (self.turn - mean.cross(&self.push)) / push;
        let lever = mean.cross(&self.nearest.normal);
        let second = self.second / self.total - lever * lever.transpose();
        Some(ContactPatch {
            normal,
            center: self.nearest.point + mean + normal.cross(&couple) - lift * 0.5,
            overlap: self.overlap * root,
            weight: push * root / self.eighth,
            pitch: normal.dot(&couple),
            second: if self.is_point() { Mat3::zeros() } else { second },
        })
    }
}
