//! Which features of two cylinders touch, guessed from how their axes lie.
//!
//! A guess is a simplex that marks the features; whoever solves for their nearest points certifies the answer.

use crate::convex::Rims;
use crate::gjk::Simplex;
use crate::{Placement, Vec3};

/// Largest squared sine of the angles at which the side of a cylinder still lies on the end of another.
const MAX_TILT_SQUARED: f64 = 0.01;

/// Two cylinders, the second placed in the frame of the first.
pub(in crate::gjk) struct Guess<'a> {
    pub a: Rims,
    pub b: Rims,
    pub placement: &'a Placement,
}

/// Points that mark a feature: a rim point, both ends of a line of the side, or a triangle in the disc of an end.
type MarkingPoints = [Vec3; 3];

impl Guess<'_> {
    /// The features nearest each other where the axes are, lines of the sides or rims.
    pub(in crate::gjk) fn beside_axes(&self) -> Option<Simplex> {
        let Self { a, b, placement } = self;
        let (start, along) = (placement.translation, placement.matrix.column(2) * b.half_height);
        let [on_a, on_b] = nearest_on_segments(&(Vec3::z() * a.half_height), &start, &along);
        let v = start + along * on_b - Vec3::z() * (a.half_height * on_a);
        let (of_a, of_b) = (a.line(&v)?, b.line(&-placement.matrix.tr_mul(&v))?);
        let cut = |line: [Vec3; 2], place: f64| match place {
            ..=-1.0 => [line[1]; 2],
            1.0.. => [line[0]; 2],
            _ => line,
        };
        let ([p, q], [r, s]) = (cut(of_a, on_a), cut(of_b, on_b));
        Some(simplex(&[p, p, q], &[r, s, s]))
    }

    /// The features that touch if the side of one lies on the end of the other; `v` is about the way from A to B (m).
    ///
    /// The line of the side nearest the end touches its disc or its rim, at one end of the line or between, and which one it is changes as
    /// they rock: where the lower end of the line is over the disc, it touches that, else the line crosses the rim.
    pub(in crate::gjk) fn side_on_end(&self, v: &Vec3) -> Option<Simplex> {
        let Self { a, b, placement } = self;
        let along_b = placement.matrix.tr_mul(v);
        let scale_squared = placement.matrix.column(2).norm_squared();
        let is_end = |v: &Vec3, squared: f64| v.x * v.x + v.y * v.y <= MAX_TILT_SQUARED * squared;
        let is_side = |v: &Vec3, squared: f64| v.z * v.z <= MAX_TILT_SQUARED * squared;
        let (squared, squared_b) = (v.norm_squared(), v.norm_squared() * scale_squared);
        if is_end(v, squared) && is_side(&along_b, squared_b) {
            let line = b.line(&-along_b)?;
            let (on_end, on_line) = a.under_line(v.z, &line.map(|point| placement.apply(&point)), &line)?;
            return Some(simplex(&on_end, &on_line));
        }
        if is_side(v, squared) && is_end(&along_b, squared_b) {
            let line = a.line(v)?;
            let inverse = 1.0 / scale_squared;
            let seen = line.map(|point| placement.matrix.tr_mul(&(point - placement.translation)) * inverse);
            let (on_end, on_line) = b.under_line(-along_b.z, &seen, &line)?;
            return Some(simplex(&on_line, &on_end));
        }
        None
    }
}

impl Rims {
    /// The line of the side farthest along a direction, by its upper and lower end (m).
    fn line(&self, direction: &Vec3) -> Option<[Vec3; 2]> {
        let norm = direction.xy().norm();
        let scale = self.radius / norm;
        let point = |z: f64| Vec3::new(direction.x * scale, direction.y * scale, z);
        (norm > 0.0).then(|| [point(self.half_height), point(-self.half_height)])
    }

    /// The features that touch of the end along `sign` of the axis and of a line of another cylinder, whose ends are `seen` from here
    /// and at `line` in their own frame (m).
    fn under_line(
        &self,
        sign: f64,
        seen: &[Vec3; 2],
        line: &[Vec3; 2],
    ) -> Option<(MarkingPoints, MarkingPoints)> {
        let Self { radius, half_height } = *self;
        let z = half_height.copysign(sign);
        let low = usize::from(seen[1].z * sign < seen[0].z * sign);
        let (begin, along) = (seen[low].xy(), seen[1 - low].xy() - seen[low].xy());
        let outside = begin.norm_squared() - radius * radius;
        if outside <= 0.0 {
            // A corner of the triangle is towards the end of the line.
            let norm = begin.norm();
            let (x, y) = if norm > 0.0 { (begin.x / norm, begin.y / norm) } else { (1.0, 0.0) };
            let corner =
                |cos: f64, sin: f64| Vec3::new((x * cos - y * sin) * radius, (x * sin + y * cos) * radius, z);
            let sin = 0.75_f64.sqrt();
            return Some(([corner(1.0, 0.0), corner(-0.5, sin), corner(-0.5, -sin)], [line[low]; 3]));
        }
        // |begin + τ along|² = R², the first time.
        let (squared, half) = (along.norm_squared(), begin.dot(&along));
        let discriminant = half * half - squared * outside;
        if half >= 0.0 || discriminant < 0.0 {
            return None;
        }
        let crossing = begin + along * ((-half - discriminant.sqrt()) / squared);
        Some(([Vec3::new(crossing.x, crossing.y, z); 3], [line[0], line[1], line[1]]))
    }
}

/// The simplex of three pairs of points, neighbours that are alike once.
pub(super) fn simplex(a: &MarkingPoints, b: &MarkingPoints) -> Simplex {
    let mut simplex = Simplex::default();
    for k in 0..3 {
        let is_known = k > 0 && a[k] == a[k - 1] && b[k] == b[k - 1];
        if !is_known {
            let len = usize::from(simplex.len);
            (simplex.a[len], simplex.b[len]) = (a[k], b[k]);
            simplex.len += 1;
        }
    }
    simplex
}

/// Places from −1 to 1 of the nearest points of the segments ±`a` and `start` ± `b`.
fn nearest_on_segments(a: &Vec3, start: &Vec3, b: &Vec3) -> [f64; 2] {
    let (aa, bb, ab) = (a.norm_squared(), b.norm_squared(), a.dot(b));
    let (on_a, on_b) = (a.dot(start), b.dot(start));
    let determinant = aa * bb - ab * ab;
    // Parallel ones: any points, here the middle of A.
    let first = if determinant > 1e-12 * aa * bb { (on_a * bb - on_b * ab) / determinant } else { 0.0 };
    let second = ((first.clamp(-1.0, 1.0) * ab - on_b) / bb).clamp(-1.0, 1.0);
    [((on_a + second * ab) / aa).clamp(-1.0, 1.0), second]
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::gjk::{Separation, distance};
    use crate::{Core, Rotation};
    use std::f64::consts::FRAC_PI_2;

    /// Numbers from −1 to 1.
    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Whatever is guessed, the answer is that of a search which begins at rim points of any angle: beside each other at random, with a side
    /// that rocks on an end, with parallel axes and with crossed ones.
    #[test]
    fn guesses_change_no_answer() {
        let (mut state, mut guessed) = (3_u64, 0);
        for k in 0..20_000 {
            let mut number = || random(&mut state);
            let sizes = [0; 2].map(|_| [1.0, 1.0].map(|size| size * 3_f64.powf(number())));
            let cores = sizes.map(|[radius, half_height]| Core::Cylinder { radius, half_height });
            let tilt = if k % 2 == 0 { 1e-3 } else { 3.0 };
            let turn = Rotation::from_scaled_axis(Vec3::new(number(), number(), number()) * tilt)
                * Rotation::from_scaled_axis(Vec3::x() * (FRAC_PI_2 * f64::from(k / 2 % 2)))
                * Rotation::from_scaled_axis(Vec3::z() * (3.0 * number()));
            let scale = 2_f64.powf(number());
            let matrix = turn.to_rotation_matrix().into_inner() * scale;
            // Anywhere beside the first, a little off.
            let way = match k % 3 {
                0 => Vec3::new(0.06 * number(), 0.06 * number(), 1.0),
                _ => Vec3::new(number(), number(), number()),
            };
            let away = way * (1.0 / way.norm());
            let reach = cores[0].support_value(&away) + cores[1].support_value(&matrix.tr_mul(&-away));
            let placement = Placement { matrix, translation: way * ((reach + 0.02) / way.dot(&away)) };
            let [a, b] = sizes.map(|[radius, half_height]| Rims { radius, half_height });
            let pair = Guess { a, b, placement: &placement };
            guessed += usize::from(pair.side_on_end(&away).is_some());
            let mut cold = Simplex::default();
            let Separation::Apart { distance: wanted, normal: across, .. } =
                distance(&cores[0], &cores[1], &placement, f64::INFINITY, &mut cold).unwrap()
            else {
                continue;
            };
            let size = sizes
                .as_flattened()
                .iter()
                .fold(placement.translation.norm(), |m, x| m.max(x * scale.max(1.0)));
            for start in 0..4 {
                let mut warm = pair.side_on_end(&away).filter(|_| start == 0).unwrap_or_else(|| {
                    let point = |[radius, half]: [f64; 2], angle: f64, end: f64| {
                        Vec3::new(radius * angle.cos(), radius * angle.sin(), half.copysign(end))
                    };
                    let a = point(sizes[0], 3.2 * number(), number());
                    let b = point(sizes[1], 3.2 * number(), number());
                    simplex(&[a; 3], &[b; 3])
                });
                let found = distance(&cores[0], &cores[1], &placement, f64::INFINITY, &mut warm).unwrap();
                let Separation::Apart { distance, normal, .. } = found else {
                    panic!("pair {k} meets instead of {wanted}");
                };
                assert!((distance - wanted).abs() <= 1e-9 * size, "pair {k}: {distance}, {wanted}");
                assert!((normal - across).norm() * wanted <= 1e-5 * size, "pair {k}: {normal}, {across}");
            }
        }
        assert!(guessed > 1000, "{guessed} sides on ends");
    }

    /// Points of segments between which nothing is nearer.
    #[test]
    fn nearest_points_of_segments_are_nearest() {
        let mut state = 5_u64;
        for k in 0..5000 {
            let mut vector = || Vec3::from_fn(|_, _| random(&mut state));
            let (a, start) = (vector(), vector());
            let b = if k % 5 == 0 { a * 0.7 } else { vector() };
            let way = |[on_a, on_b]: [f64; 2]| start + b * on_b - a * on_a;
            let found = nearest_on_segments(&a, &start, &b);
            let shortest = way(found).norm();
            let grid =
                (0..=40).flat_map(|i| (0..=40).map(move |j| [i, j].map(|n| f64::from(n) / 20.0 - 1.0)));
            let smallest = grid.map(|places| way(places).norm()).fold(f64::INFINITY, f64::min);
            assert!(shortest <= smallest + 1e-12, "{k}: {shortest} instead of {smallest} at {found:?}");
        }
    }
}
