//! Distance of a superellipsoid from a vertex, edge or face, or from a cylinder, solved as equations.

use super::super::query::Query;
use super::super::{MEETING, STALLED_TOLERANCE, Separation, Simplex, TOLERANCE};
use super::element::Element;
use super::{MAX_STEPS, Matrix2, PATIENCE, apply, limit, solve};
use crate::Vec3;
use crate::convex::Support;
use crate::superellipsoid::{Local, Superellipsoid, tangents};

/// Distance of the superellipsoid `a`, less its inset, from the element of `b` that the simplex marks.
#[inline(always)]
pub(crate) fn feature<B: Support>(
    a: &Superellipsoid,
    b: &B,
    query: &Query,
    size: f64,
    simplex: &mut Simplex,
) -> Option<Separation> {
    if !a.is_smooth() {
        return None;
    }
    let len = simplex.len as usize;
    let element = Element::of(b, &simplex.b[..len], query.placement)?;
    let near = simplex.a[..len].iter().sum::<Vec3>();
    let lowest =
        |n: &Vec3| n.dot(&query.placement.translation) - b.height(&-query.placement.matrix.tr_mul(n));
    let (answer, local) = nearest(a, &element, near, lowest, [query.cutoff, size])?;
    let on_rim = match &answer {
        Separation::Apart { point_b, .. } => *point_b,
        _ => element.nearest(&local.point)? - local.normal * element.reach(),
    };
    let towards = query.placement.matrix.tr_mul(&(on_rim - query.placement.translation));
    let count = element.mark(b, &mut simplex.b, len, &towards)?;
    simplex.len = count as u8;
    simplex.a[..count].fill(local.point);
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
        Separation::Beyond { axis } => Separation::Beyond { axis: query.placement.matrix * -axis },
        Separation::Meeting => Separation::Meeting,
    })
}

/// The answer and the surface at its nearest point; `lowest` is the smallest n·x of the other core.
#[inline(always)]
fn nearest(
    body: &Superellipsoid,
    element: &Element,
    near: Vec3,
    lowest: impl Fn(&Vec3) -> f64,
    [cutoff, size]: [f64; 2],
) -> Option<(Separation, Local)> {
    let plane = element.plane();
    let mut local = body.local(&match &plane {
        Some(normal) if normal.norm_squared() > 0.0 => body.dual(normal).1,
        Some(_) => return None,
        None => near,
    });
    let (reach, inset) = (element.reach(), body.inset());
    let mut best = (f64::INFINITY, 0);
    for step in 0..MAX_STEPS {
        let core_point = local.point - local.normal * inset;
        let x = element.nearest(&core_point)?;
        let v = x - core_point;
        let length = v.norm();
        let n = v / length;
        // Above the plane across n: h(n) = n·y + excess.
        let lower = lowest(&n) - n.dot(&local.point) - body.excess(&local, &n) + inset;
        if lower > cutoff {
            return Some((Separation::Beyond { axis: n }, local));
        }
        let distance = length - reach;
        let slack = distance - lower;
        // A bound clearly above the distance is that of other bodies.
        let is_certain = slack <= TOLERANCE * size && slack >= -STALLED_TOLERANCE * size;
        if is_certain && lower > MEETING * size {
            let point_b = core_point + n * distance;
            return Some((Separation::Apart { distance, normal: n, point_a: core_point, point_b }, local));
        }
        // A ball of the depth in the core that rolls inside the body holds the point of the element.
        let depth = reach - v.dot(&local.normal);
        let aside = v - local.normal * v.dot(&local.normal);
        if depth > MEETING * size && depth < inset && aside.norm() < 0.5 * depth {
            return Some((Separation::Meeting, local));
        }
        if slack < best.0 {
            best = (slack, step);
        } else if step > best.1 + PATIENCE || slack.is_nan() || plane.is_some() {
            return None;
        }
        local = advance(body, element, &local, &x)?;
    }
    None
}

/// A step of Newton's method. At a vertex the point of the superellipsoid moves by α, (1 + d W) α = w_t. On a
/// curve that holds across it; along its tangent τ the normal stays at a right angle with the curve, which
/// turns by its curvature κ towards n: W α − κ (1 + d W) α = −n·τ − κ w_t.
#[inline(always)]
fn advance(body: &Superellipsoid, element: &Element, local: &Local, x: &Vec3) -> Option<Local> {
    let normal = &local.normal;
    let [e, f] = tangents(normal);
    let curvature = local.curvature(&e, &f);
    let w = x - local.point;
    let (across, gap) = ([e.dot(&w), f.dot(&w)], w.dot(normal));
    let mut longer = curvature.map(|row| row.map(|x| x * gap));
    (longer[0][0], longer[1][1]) = (longer[0][0] + 1.0, longer[1][1] + 1.0);
    let step = match element.tangent(x, normal) {
        None => solve(&longer, across)?,
        Some((tangent, turn)) => {
            let flat = [e.dot(&tangent), f.dot(&tangent)];
            let length = (flat[0] * flat[0] + flat[1] * flat[1]).sqrt();
            let along = flat.map(|t| t / length);
            let aside = [-along[1], along[0]];
            let row = |of: &Matrix2, t: [f64; 2]| [0, 1].map(|k| t[0] * of[0][k] + t[1] * of[1][k]);
            let (turned, moved) = (row(&curvature, along), row(&longer, along));
            let matrix = [row(&longer, aside), [0, 1].map(|k| turned[k] - turn * moved[k])];
            let part = |t: [f64; 2]| t[0] * across[0] + t[1] * across[1];
            solve(&matrix, [part(aside), -normal.dot(&tangent) / length - turn * part(along)])?
        }
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
