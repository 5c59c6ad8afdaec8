//! The search for the nearest simplex, compiled once for each pair of kinds of cores.

use super::curved::{self, Touch};
use super::cylinders::{Guess, Touching};
use super::nearest::{Nearest, nearest};
use super::query::{Bounds, Query, combine};
use super::{MAX_ITERATIONS, MEETING, PATIENCE, ROUNDING, STALLED_TOLERANCE, Separation, Simplex, TOLERANCE};
use super::{boxes, ellipsoids, polyhedra, smooth, superellipsoids};
use crate::convex::Support;
use crate::core::with_convex;
use crate::{Core, Superellipsoid, Vec3};

/// The bounds did not close.
pub(super) struct Stall {
    /// Smallest difference of the bounds (m).
    pub gap: f64,
    /// Iteration that reached it.
    pub iterations: usize,
    /// Another answer that is acceptable, for all its wider gap, as its points are nearer each other.
    nearer: Option<Separation>,
}

/// A point of each core, in its own coordinates, and their difference B − A in the frame of A.
struct Pair {
    a: Vec3,
    b: Vec3,
    w: Vec3,
}

/// What the support point in direction −v says of v.
enum Verdict {
    Beyond,
    Nearest,
    Improvable { gap: f64 },
}

impl Query<'_> {
    #[inline]
    pub(super) fn with_first<A: Support>(
        &self,
        a: &A,
        b: &Core,
        simplex: &mut Simplex,
    ) -> Result<Separation, Stall> {
        with_convex!(b, second => self.search(a, second, simplex))
    }

    /// Rounding may trap the search in a skinny simplex left by an earlier step: it then starts afresh.
    #[inline]
    fn search<A: Support, B: Support>(
        &self,
        a: &A,
        b: &B,
        simplex: &mut Simplex,
    ) -> Result<Separation, Stall> {
        let warm = simplex.len > 0;
        let answer = self.start_smooth(a, b, simplex);
        let answer = answer.or_else(|| self.start_boxes(a, b, simplex));
        let answer = answer.or_else(|| self.start_polyhedra(a, b, simplex));
        let answer = answer.or_else(|| self.start_faced(a, b, simplex));
        if let Some(answer) = answer.or_else(|| self.start_curved(a, b, simplex)) {
            return Ok(answer);
        }
        match self.descend(a, b, simplex) {
            Err(stall) => self.descend_again(a, b, (simplex, warm), stall),
            answer => answer,
        }
    }

    /// The search once more after a stall: without the simplex of an earlier step, then from elsewhere; at last what was acceptable.
    #[cold]
    #[inline(never)]
    fn descend_again<A: Support, B: Support>(
        &self,
        a: &A,
        b: &B,
        (simplex, warm): (&mut Simplex, bool),
        stall: Stall,
    ) -> Result<Separation, Stall> {
        let afresh = if warm {
            *simplex = Simplex::default();
            self.descend(a, b, simplex)
        } else {
            Err(stall)
        };
        afresh
            .or_else(|stall| self.descend_from_elsewhere(a, b, simplex).ok_or(stall))
            .or_else(|stall| stall.nearer.ok_or(stall))
    }

    /// The search from points along each axis, until one of them is not trapped.
    fn descend_from_elsewhere<A: Support, B: Support>(
        &self,
        a: &A,
        b: &B,
        simplex: &mut Simplex,
    ) -> Option<Separation> {
        (0..3).find_map(|axis| {
            let start = self.support(a, b, &Vec3::ith(axis, 1.0));
            (simplex.len, simplex.a[0], simplex.b[0]) = (1, start.a, start.b);
            self.descend(a, b, simplex).ok()
        })
    }

    /// Answers for a warm pair with a superellipsoid; if it cannot, the points of the simplex, which lie on
    /// the bodies, are moved into the cores.
    #[inline(always)]
    fn start_smooth<A: Support, B: Support>(
        &self,
        a: &A,
        b: &B,
        simplex: &mut Simplex,
    ) -> Option<Separation> {
        let bodies = (a.superellipsoid(), b.superellipsoid());
        if simplex.len == 0 || bodies.0.or(bodies.1).is_none() {
            return None;
        }
        let answer = self.touch_smooth(a, b, simplex, None);
        if answer.is_none() {
            let shrink = |body: Option<&Superellipsoid>, points: &mut [Vec3; 4]| {
                let factor = body.map_or(1.0, Superellipsoid::shrinking);
                points.iter_mut().for_each(|point| *point *= factor);
            };
            shrink(bodies.0, &mut simplex.a);
            shrink(bodies.1, &mut simplex.b);
        }
        answer
    }

    /// Answers for two boxes that touched corner on face or edge on edge, if they still do.
    #[inline(always)]
    fn start_boxes<A: Support, B: Support>(&self, a: &A, b: &B, simplex: &mut Simplex) -> Option<Separation> {
        boxes::pair([a.half_edges()?, b.half_edges()?], self, simplex)
    }

    /// Answers for two polyhedra that touched corner on face or edge on edge, if they still do.
    #[inline(always)]
    fn start_polyhedra<A: Support, B: Support>(
        &self,
        a: &A,
        b: &B,
        simplex: &mut Simplex,
    ) -> Option<Separation> {
        polyhedra::pair([a.polyhedron()?, b.polyhedron()?], self, simplex)
    }

    /// Answers for a pair that may meet corner on face, cold, or if it did in the last step.
    #[inline(always)]
    fn start_faced<A: Support, B: Support>(&self, a: &A, b: &B, simplex: &mut Simplex) -> Option<Separation> {
        if !(A::FACED || B::FACED) {
            return None;
        }
        let size = self.size(a, b);
        let v = match simplex.len {
            0 => self.placement.translation,
            1 => self.placement.apply(&simplex.b[0]) - simplex.a[0],
            _ => return None,
        };
        let answer = self.corner_on_face((a, b), &v, size, simplex);
        if answer.is_some() || simplex.len == 1 {
            return answer;
        }
        // Centres say too little of where edges cross.
        let along = a.facing(&v)?.normal;
        self.edge_on_edge((a, b), &along, size, simplex)
    }

    /// Answers for a pair with a cylinder: cold, from the features that are guessed; if it touched in the last step, from those that touched.
    ///
    /// Those of three points of which not both are of cylinders wait for the search, which often ends where it begins.
    #[inline(always)]
    fn start_curved<A: Support, B: Support>(
        &self,
        a: &A,
        b: &B,
        simplex: &mut Simplex,
    ) -> Option<Separation> {
        let is_smooth = a.superellipsoid().is_some() || b.superellipsoid().is_some();
        if is_smooth || !(A::CURVED || B::CURVED) {
            return None;
        }
        let size = self.size(a, b);
        match simplex.len {
            0 => self.guess(a, b, size, simplex, |pair| pair.beside_axes()),
            1 | 2 => self.touch(a, b, simplex, &[0.0; 4], size),
            3 if a.rims().is_some() && b.rims().is_some() => self.touch(a, b, simplex, &[0.0; 4], size),
            _ => None,
        }
    }

    /// Newton's method for a pair with a superellipsoid, from the points of the simplex with the given
    /// weights, else from those nearest now.
    #[inline(always)]
    fn touch_smooth<A: Support, B: Support>(
        &self,
        a: &A,
        b: &B,
        simplex: &mut Simplex,
        weights: Option<&[f64; 4]>,
    ) -> Option<Separation> {
        let size = self.size(a, b);
        match (a.superellipsoid(), b.superellipsoid()) {
            (Some(a), Some(b)) if weights.is_none() && a.is_ellipsoid() && b.is_ellipsoid() => {
                ellipsoids::pair(a, b, self, simplex)
                    .or_else(|| smooth::pair(a, b, self, size, simplex, weights))
            }
            (Some(a), Some(b)) if weights.is_none() && !(a.is_sharp() || b.is_sharp()) => {
                superellipsoids::pair(a, b, self, simplex)
                    .or_else(|| smooth::pair(a, b, self, size, simplex, weights))
            }
            (Some(a), Some(b)) => smooth::pair(a, b, self, size, simplex, weights),
            (Some(a), None) => smooth::feature(a, b, self, size, simplex),
            (None, Some(b)) => smooth::feature_first(a, b, self, size, simplex),
            (None, None) => None,
        }
    }

    /// The search proper. The simplex is left as the start for the next step on every way out.
    #[inline]
    fn descend<A: Support, B: Support>(
        &self,
        a: &A,
        b: &B,
        simplex: &mut Simplex,
    ) -> Result<Separation, Stall> {
        let curved = A::CURVED || B::CURVED;
        let size = self.size(a, b);
        let is_off_face = simplex.len == 1;
        let mut w = self.start(a, b, simplex);
        let mut best = Stall { gap: f64::INFINITY, iterations: 0, nearer: None };
        let mut narrowest = None;
        for iteration in 0..MAX_ITERATIONS {
            let Some(found) = nearest(simplex.len as usize, &w) else {
                return Ok(Separation::Meeting);
            };
            let v = found.point;
            let squared = v.norm_squared();
            let weights = keep(simplex, &mut w, &found);
            if squared <= (MEETING * size).powi(2) {
                return Ok(Separation::Meeting);
            }
            match self.judge(a, b, &v, squared, TOLERANCE * size) {
                Verdict::Beyond => return Ok(Separation::Beyond { axis: v }),
                Verdict::Nearest => return Ok(apart(v, squared, combine(simplex, &weights))),
                Verdict::Improvable { gap } => {
                    let answer = || Some(apart(v, squared, combine(simplex, &weights)));
                    let is_acceptable =
                        gap <= STALLED_TOLERANCE * size + ROUNDING * size * size / squared.sqrt();
                    if gap < best.gap {
                        (best.gap, best.iterations) = (gap, iteration);
                        narrowest = if is_acceptable { answer() } else { narrowest };
                    } else if is_acceptable {
                        best.nearer = answer();
                    }
                }
            }
            // Early, for a warm start; later now and then, as the simplex settles on the features.
            if curved
                && iteration % 3 == 0
                && let Some(answer) = self
                    .touch(a, b, simplex, &weights, size)
                    .or_else(|| self.guess(a, b, size, simplex, |pair| pair.side_on_end(&v)))
            {
                return Ok(answer);
            }
            if (A::FACED || B::FACED) && iteration == 0 {
                // A lone pair of points has been tried.
                let on_face = if is_off_face { None } else { self.corner_on_face((a, b), &v, size, simplex) };
                if let Some(answer) = on_face.or_else(|| self.edge_on_edge((a, b), &v, size, simplex)) {
                    return Ok(answer);
                }
            }
            let pair = self.support(a, b, &v);
            if contains(simplex, &pair) || iteration > best.iterations + PATIENCE {
                break;
            }
            let len = simplex.len as usize;
            (simplex.a[len], simplex.b[len], w[len]) = (pair.a, pair.b, pair.w);
            simplex.len += 1;
        }
        narrowest.ok_or(best)
    }

    /// The differences of the pairs of the simplex, which gets a first pair if it is cold.
    #[inline(always)]
    fn start<A: Support, B: Support>(&self, a: &A, b: &B, simplex: &mut Simplex) -> [Vec3; 4] {
        if simplex.len == 0 {
            let start = self.support(a, b, &self.placement.translation);
            (simplex.a[0], simplex.b[0], simplex.len) = (start.a, start.b, 1);
        }
        let mut w = [Vec3::zeros(); 4];
        for (i, w) in w.iter_mut().enumerate().take(simplex.len as usize) {
            *w = self.placement.apply(&simplex.b[i]) - simplex.a[i];
        }
        w
    }

    /// A length like the largest coordinate that enters the query (m).
    #[inline(always)]
    fn size<A: Support, B: Support>(&self, a: &A, b: &B) -> f64 {
        let scale = self.placement.matrix.column(0).lp_norm(1);
        let t = &self.placement.translation;
        a.extent() + b.extent() * scale + t.x.abs() + t.y.abs() + t.z.abs()
    }

    /// The pair of points of smallest v·(b − a).
    #[inline(always)]
    fn support<A: Support, B: Support>(&self, a: &A, b: &B, v: &Vec3) -> Pair {
        let a = a.farthest(v);
        let b = b.farthest(&-self.placement.matrix.tr_mul(v));
        Pair { a, b, w: self.placement.apply(&b) - a }
    }

    /// What the support points in direction ∓v say of v.
    #[inline(always)]
    fn judge<A: Support, B: Support>(&self, a: &A, b: &B, v: &Vec3, squared: f64, tolerance: f64) -> Verdict {
        let reach = b.height(&-self.placement.matrix.tr_mul(v));
        let bounds = Bounds { squared, height: v.dot(&self.placement.translation) - a.height(v) - reach };
        if bounds.are_beyond(self.cutoff) {
            Verdict::Beyond
        } else if bounds.are_closed(tolerance) {
            Verdict::Nearest
        } else {
            Verdict::Improvable { gap: bounds.slack().abs() / squared.sqrt() }
        }
    }

    /// Solves the touching features as equations and certifies the result like any other.
    fn touch<A: Support, B: Support>(
        &self,
        a: &A,
        b: &B,
        simplex: &mut Simplex,
        weights: &[f64; 4],
        size: f64,
    ) -> Option<Separation> {
        if a.superellipsoid().is_some() || b.superellipsoid().is_some() {
            return self.touch_smooth(a, b, simplex, Some(weights));
        }
        let lines_or_rims = match (a.rims(), b.rims()) {
            (Some(first), Some(second)) => Touching::of([first, second], self.placement, simplex),
            _ => None,
        };
        let touch: Touch = match lines_or_rims {
            Some(touching) => touching.solved()?,
            None => curved::touch(a, b, self.placement, simplex)?,
        };
        let squared = touch.v.norm_squared();
        if squared <= (MEETING * size).powi(2) {
            return None;
        }
        let answer = self.certified(a, b, &touch.v, touch.point_a, size)?;
        touch.refresh(simplex);
        Some(answer)
    }

    /// The answer of the features that are guessed of two cylinders, of which the simplex is left.
    #[cold]
    #[inline(never)]
    fn guess<A: Support, B: Support>(
        &self,
        a: &A,
        b: &B,
        size: f64,
        simplex: &mut Simplex,
        features: impl Fn(&Guess) -> Option<Simplex>,
    ) -> Option<Separation> {
        let pair = Guess { a: a.rims()?, b: b.rims()?, placement: self.placement };
        let mut guessed = features(&pair)?;
        let answer = self.touch(a, b, &mut guessed, &[0.0; 4], size)?;
        *simplex = guessed;
        Some(answer)
    }

    /// The answer that the nearest points are v apart, if no plane speaks against it.
    #[inline(always)]
    pub(super) fn certified<A: Support, B: Support>(
        &self,
        a: &A,
        b: &B,
        v: &Vec3,
        point_a: Vec3,
        size: f64,
    ) -> Option<Separation> {
        let squared = v.norm_squared();
        match self.judge(a, b, v, squared, TOLERANCE * size) {
            Verdict::Beyond => Some(Separation::Beyond { axis: *v }),
            Verdict::Nearest => Some(apart(*v, squared, point_a)),
            Verdict::Improvable { .. } => None,
        }
    }
}

#[inline(always)]
pub(super) fn apart(v: Vec3, squared: f64, point_a: Vec3) -> Separation {
    let distance = squared.sqrt();
    Separation::Apart { distance, normal: v / distance, point_a, point_b: point_a + v }
}

/// Drops the vertices without weight; returns the weights of those left.
#[inline(always)]
fn keep(simplex: &mut Simplex, w: &mut [Vec3; 4], found: &Nearest) -> [f64; 4] {
    let mut weights = found.weights;
    let mut kept = 0;
    for i in 0..simplex.len as usize {
        if weights[i] > 0.0 {
            if kept < i {
                (simplex.a[kept], simplex.b[kept], w[kept]) = (simplex.a[i], simplex.b[i], w[i]);
                weights[kept] = weights[i];
            }
            kept += 1;
        }
    }
    simplex.len = kept as u8;
    weights
}

fn contains(simplex: &Simplex, pair: &Pair) -> bool {
    (0..simplex.len as usize).any(|i| simplex.a[i] == pair.a && simplex.b[i] == pair.b)
}
