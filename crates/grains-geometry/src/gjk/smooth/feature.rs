//! Distance of a superellipsoid from a vertex, an edge or a face, solved as equations.

use super::super::search::{Query, apart};
use super::super::{MEETING, Separation, Simplex, TOLERANCE};
use super::{MAX_STEPS, Matrix2, PATIENCE, apply, limit, solve};
use crate::core::Support;
use crate::superellipsoid::{Local, Superellipsoid, tangents};
use crate::{Placement, Vec3};

/// The vertices of a feature, at most three, in the frame of the superellipsoid (m).
struct Feature {
    count: usize,
    points: [Vec3; 3],
}

impl Feature {
    /// Of the distinct points; `None` if there are more than three, or of a curved core.
    #[inline(always)]
    fn of(points: &[Vec3; 4], len: usize, placement: &Placement) -> Option<(Self, [Vec3; 3])> {
        let mut own = [points[0]; 3];
        let mut count = 1;
        for point in &points[1..len] {
            if own[..count].contains(point) {
                continue;
            }
            if count == 3 {
                return None;
            }
            own[count] = *point;
            count += 1;
        }
        Some((Self { count, points: own.map(|point| placement.apply(&point)) }, own))
    }

    /// The point of the feature nearest `from`; `None` if that is off its end.
    #[inline(always)]
    fn nearest(&self, from: &Vec3) -> Option<Vec3> {
        let [p, q, r] = &self.points;
        match self.count {
            1 => Some(*p),
            2 => {
                let edge = q - p;
                let t = (from - p).dot(&edge) / edge.norm_squared();
                (0.0..=1.0).contains(&t).then(|| p + edge * t)
            }
            _ => {
                let found = super::super::nearest::on_triangle(&(p - from), &(q - from), &(r - from));
                found.weights[..3].iter().all(|weight| *weight > 0.0).then(|| from + found.point)
            }
        }
    }
}

/// Distance of the superellipsoid `a`, less its inset, from the vertex, edge or face of `b` whose vertices
/// are in the simplex.
#[inline(always)]
pub(crate) fn feature<B: Support>(
    a: &Superellipsoid,
    b: &B,
    query: &Query,
    size: f64,
    simplex: &mut Simplex,
) -> Option<Separation> {
    if B::CURVED || !a.is_smooth() {
        return None;
    }
    let (feature, vertices) = Feature::of(&simplex.b, simplex.len as usize, query.placement)?;
    let len = simplex.len as usize;
    let near = simplex.a[..len].iter().sum::<Vec3>();
    let lowest =
        |n: &Vec3| n.dot(&query.placement.translation) - b.height(&-query.placement.matrix.tr_mul(n));
    let (answer, point) = nearest(a, &feature, near, lowest, [query.cutoff, size])?;
    simplex.len = feature.count as u8;
    for i in 0..feature.count {
        (simplex.a[i], simplex.b[i]) = (point, vertices[i]);
    }
    Some(answer)
}

/// The same with the superellipsoid second.
#[inline(always)]
pub(crate) fn feature_first<A: Support>(
    a: &A,
    b: &Superellipsoid,
    query: &Query,
    size: f64,
    simplex: &mut Simplex,
) -> Option<Separation> {
    if A::CURVED {
        return None;
    }
    let placement = query.placement.inverse();
    let scale = query.placement.matrix.column(0).norm();
    let turned = Query { placement: &placement, cutoff: query.cutoff / scale };
    let mut swapped = Simplex { len: simplex.len, a: simplex.b, b: simplex.a };
    let answer = feature(b, a, &turned, size / scale, &mut swapped)?;
    *simplex = Simplex { len: swapped.len, a: swapped.b, b: swapped.a };
    Some(match answer {
        Separation::Apart { distance, normal, point_a, point_b } => Separation::Apart {
            distance: distance * scale,
            normal: query.placement.matrix * -normal / scale,
            point_a: query.placement.apply(&point_b),
            point_b: query.placement.apply(&point_a),
        },
        other => other,
    })
}

/// The answer and the nearest point of the surface; `lowest` is the least n·x of the other core.
#[inline(always)]
fn nearest(
    body: &Superellipsoid,
    feature: &Feature,
    near: Vec3,
    lowest: impl Fn(&Vec3) -> f64,
    [cutoff, size]: [f64; 2],
) -> Option<(Separation, Vec3)> {
    let mut local = body.local(&if feature.count == 3 { facing(body, feature)? } else { near });
    let mut best = (f64::INFINITY, 0);
    for step in 0..MAX_STEPS {
        let normal = local.normal;
        let core_point = local.point - normal * body.inset();
        let x = feature.nearest(&core_point)?;
        let v = x - core_point;
        let squared = v.norm_squared();
        let distance = squared.sqrt();
        let n = v / distance;
        // Above the plane across n: h(n) = n·y + excess.
        let lower = lowest(&n) - n.dot(&local.point) - body.excess(&local, &n) + body.inset();
        if lower > cutoff {
            return Some((Separation::Beyond, local.point));
        }
        let slack = distance - lower;
        if slack <= TOLERANCE * size && lower > MEETING * size {
            return Some((apart(v, squared, core_point), local.point));
        }
        if slack < best.0 {
            best = (slack, step);
        } else if step > best.1 + PATIENCE || slack.is_nan() || feature.count == 3 {
            return None;
        }
        local = advance(body, feature, &local, &normal, &x)?;
    }
    None
}

/// The support point towards a face.
#[inline(always)]
fn facing(body: &Superellipsoid, feature: &Feature) -> Option<Vec3> {
    let [p, q, r] = &feature.points;
    let across = (q - p).cross(&(r - p));
    let outward = if across.dot(p) < 0.0 { -across } else { across };
    (outward.norm_squared() > 0.0).then(|| body.dual(&outward).1)
}

/// A step of Newton's method: with P across and Q along the edge, P = 1 and Q = 0 at a vertex,
/// [P (1 + d W) + Q W] α = P w_t + Q β, where β turns the normal to a right angle with the edge.
#[inline(always)]
fn advance(
    body: &Superellipsoid,
    feature: &Feature,
    local: &Local,
    normal: &Vec3,
    x: &Vec3,
) -> Option<Local> {
    let [e, f] = tangents(normal);
    let curvature = local.curvature(&e, &f);
    let w = x - local.point;
    let (across, gap) = ([e.dot(&w), f.dot(&w)], w.dot(normal));
    let mut longer = curvature.map(|row| row.map(|x| x * gap));
    (longer[0][0], longer[1][1]) = (longer[0][0] + 1.0, longer[1][1] + 1.0);
    let step = if feature.count == 1 {
        solve(&longer, across)?
    } else {
        let edge = feature.points[1] - feature.points[0];
        let flat = [e.dot(&edge), f.dot(&edge)];
        let along = flat.map(|t| t / (flat[0] * flat[0] + flat[1] * flat[1]).sqrt());
        let aside = [-along[1], along[0]];
        let squared = flat[0] * along[0] + flat[1] * along[1];
        let row = |of: &Matrix2, t: [f64; 2]| {
            [t[0] * of[0][0] + t[1] * of[1][0], t[0] * of[0][1] + t[1] * of[1][1]]
        };
        let matrix = [row(&longer, aside), row(&curvature, along)];
        solve(&matrix, [aside[0] * across[0] + aside[1] * across[1], -normal.dot(&edge) / squared])?
    };
    let damping = limit(step, body).min(1.0);
    let step = step.map(|x| x * damping);
    let near = if body.is_sharp() {
        let turn = apply(&curvature, step);
        body.dual(&(normal + e * turn[0] + f * turn[1])).1
    } else {
        local.point + e * step[0] + f * step[1]
    };
    Some(body.local(&near))
}
