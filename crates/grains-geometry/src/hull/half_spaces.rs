//! Corners of an intersection of half-spaces, through the hull of its dual points.

use super::triangulated::triangulated_hull;
use super::{extent, spread_points};
use crate::Vec3;
use crate::mesh::leaders;

/// Corners closer than this are one (relative to the size of the intersection, which is about 1).
const COINCIDENT: f64 = 1e-10;

/// Corners of `{x : n_i·x <= e_i}` for unit normals, e_i > 0 and a size of about 1; for an unbounded or flat
/// intersection the thickness of the dual points.
///
/// A plane is the dual point n_i/e_i, and a triangle of the dual hull a corner. The hull is exact, and corners
/// are solved with twice the digits of f64: where many planes meet almost in a point, or in a line, as at tips and
/// between near-parallel faces, none of them is lost and none lies elsewhere.
pub(super) fn corners(planes: &[(Vec3, f64)]) -> Result<Vec<Vec3>, f64> {
    let dual: Vec<Vec3> = planes.iter().map(|(n, e)| n / *e).collect();
    let (_, size) = extent(&dual);
    // A power of two, so that no digit is lost.
    let unit = f64::from_bits(size.to_bits() & 0x7ff0_0000_0000_0000);
    let dual: Vec<Vec3> = dual.iter().map(|y| y / unit).collect();
    let triangles = triangulated_hull(&dual, spread_points(&dual)?);
    let corner = |triangle: &[u32; 3]| pole(triangle.map(|k| dual[k as usize])).map(|x| x / unit);
    let all: Vec<Vec3> = triangles.iter().map(corner).collect::<Option<_>>().ok_or(0.0)?;
    let leader = leaders(&all, COINCIDENT);
    let kept = all.iter().zip(&leader).enumerate().filter(|(i, (_, leader))| *i as u32 == **leader);
    Ok(kept.map(|(_, (x, _))| *x).collect())
}

/// The point x with y·x = 1 for three points y, counter-clockwise seen from the far side of the origin:
/// x = (y₂ − y₁)×(y₃ − y₁)/det(y₁, y₂, y₃); `None` if the origin is not behind them.
fn pole([p, q, r]: [Vec3; 3]) -> Option<Vec3> {
    let difference = |a: &Vec3| [0, 1, 2].map(|k| Double::sum(a[k], -p[k]));
    let (a, b) = (difference(&q), difference(&r));
    let normal = [(1, 2), (2, 0), (0, 1)].map(|(j, k)| a[j].times(b[k]).plus(a[k].times(b[j]).negative()));
    let along = [0, 1, 2].map(|k| normal[k].times(Double::from(p[k])));
    let determinant = along[0].plus(along[1]).plus(along[2]);
    (determinant.high > 0.0).then(|| Vec3::from(normal.map(|n| n.over(determinant))))
}

/// The unevaluated sum of two f64, the lower at most half a unit in the last place of the higher (Dekker 1971).
#[derive(Clone, Copy)]
struct Double {
    high: f64,
    low: f64,
}

impl Double {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }

    /// a + b, exactly.
    fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let part = high - a;
        Self { high, low: (a - (high - part)) + (b - part) }
    }

    fn plus(self, other: Self) -> Self {
        let sum = Self::sum(self.high, other.high);
        let low = Self::sum(self.low, other.low);
        let sum = Self::sum(sum.high, sum.low + low.high);
        Self::sum(sum.high, sum.low + low.low)
    }

    fn times(self, other: Self) -> Self {
        let high = self.high * other.high;
        let low = self.high.mul_add(other.high, -high);
        Self::sum(high, low + (self.high * other.low + self.low * other.high))
    }

    fn negative(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }

    /// The quotient, rounded.
    fn over(self, other: Self) -> f64 {
        let first = self.high / other.high;
        let rest = self.plus(other.times(Self::from(first)).negative());
        first + rest.high / other.high
    }
}
