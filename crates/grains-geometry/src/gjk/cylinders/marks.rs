//! What touches of two cylinders, in few words.

use crate::convex::Rims;
use crate::gjk::Simplex;
use crate::gjk::curved::SAME_POINT;
use crate::{Core, Vec3};

/// Words of the marks of two cylinders.
pub(in crate::gjk) const WORDS: usize = 5;
/// Corners of the triangle that marks an end, in radii.
const CORNERS: [[f64; 2]; 3] =
    [[1.0, 0.0], [-0.5, 0.866_025_403_784_438_6], [-0.5, -0.866_025_403_784_438_6]];

/// A kind of feature of a cylinder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// The rim of the upper or lower end.
    Rim { is_upper: bool },
    /// A line of the side.
    Line,
    /// The disc of the upper or lower end.
    Disc { is_upper: bool },
}

impl Kind {
    /// Its number, from 1.
    fn number(self) -> u64 {
        match self {
            Self::Line => 1,
            Self::Rim { is_upper } => 2 + u64::from(is_upper),
            Self::Disc { is_upper } => 4 + u64::from(is_upper),
        }
    }

    fn of_number(number: u64) -> Option<Self> {
        match number {
            1 => Some(Self::Line),
            2 | 3 => Some(Self::Rim { is_upper: number == 3 }),
            4 | 5 => Some(Self::Disc { is_upper: number == 5 }),
            _ => None,
        }
    }
}

/// A feature of a cylinder, and the point of its circle that is nearest the other one, as x and y in the frame of the cylinder (m); any point
/// of a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mark {
    pub kind: Kind,
    pub point: [f64; 2],
}

impl Mark {
    /// What points of a cylinder mark; `None` if it is none of these features.
    #[inline(always)]
    pub(super) fn of(rims: Rims, points: &[Vec3]) -> Option<Self> {
        let (first, squared) = (points[0], rims.radius * rims.radius);
        let (mut is_one_end, mut is_one, mut is_same, mut x, mut y) = (true, true, true, 0.0, 0.0);
        for point in points {
            is_one_end &= point.z == first.z;
            is_one &= point.x * first.x + point.y * first.y >= SAME_POINT * squared;
            is_same &= (point.x == first.x) & (point.y == first.y);
            (x, y) = (x + point.x, y + point.y);
        }
        let is_upper = first.z > 0.0;
        let kind = match (is_one, is_one_end) {
            (true, true) => Kind::Rim { is_upper },
            (true, false) => Kind::Line,
            (false, true) => return Some(Self { kind: Kind::Disc { is_upper }, point: [rims.radius, 0.0] }),
            (false, false) => return None,
        };
        if is_same {
            return Some(Self { kind, point: [first.x, first.y] });
        }
        let scale = rims.radius / (x * x + y * y).sqrt();
        Some(Self { kind, point: [x * scale, y * scale] })
    }

    /// Three points that mark it, the first `first` of them at the upper end of a line.
    fn points(&self, rims: Rims, first: usize) -> [Vec3; 3] {
        let [x, y] = self.point;
        std::array::from_fn(|k| match self.kind {
            Kind::Rim { is_upper } => Vec3::new(x, y, rims.height(is_upper)),
            Kind::Line => Vec3::new(x, y, rims.height(k < first)),
            Kind::Disc { is_upper } => {
                let [x, y] = CORNERS[k].map(|x| x * rims.radius);
                Vec3::new(x, y, rims.height(is_upper))
            }
        })
    }
}

/// The features of two cylinders that touched: the start of their next query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CylinderMarks(pub(super) [Mark; 2]);

impl CylinderMarks {
    /// What a simplex of two cylinders marks.
    #[inline(always)]
    pub(super) fn of(rims: [Rims; 2], simplex: &Simplex) -> Option<Self> {
        let len = simplex.len as usize;
        if len == 0 {
            return None;
        }
        Some(Self([Mark::of(rims[0], &simplex.a[..len])?, Mark::of(rims[1], &simplex.b[..len])?]))
    }

    /// Reads marks that were written; `None` if the start is cold.
    #[inline(always)]
    pub fn read(words: &[u64]) -> Option<Self> {
        let point = |k: usize| [f64::from_bits(words[k]), f64::from_bits(words[k + 1])];
        let [a, b] = [Kind::of_number(words[0] & 0xff)?, Kind::of_number(words[0] >> 8)?];
        Some(Self([Mark { kind: a, point: point(1) }, Mark { kind: b, point: point(3) }]))
    }

    /// Writes marks, or that the start is cold.
    #[inline(always)]
    pub fn write(marks: Option<&Self>, words: &mut [u64]) {
        match (marks, words) {
            (Some(Self([a, b])), [kinds, ax, ay, bx, by, ..]) => {
                *kinds = a.kind.number() | b.kind.number() << 8;
                (*ax, *ay) = (a.point[0].to_bits(), a.point[1].to_bits());
                (*bx, *by) = (b.point[0].to_bits(), b.point[1].to_bits());
            }
            (_, words) => words[0] = 0,
        }
    }

    /// The simplex that has these marks.
    pub(in crate::gjk) fn simplex(&self, rims: [Rims; 2]) -> Simplex {
        let [a, b] = &self.0;
        super::guess::simplex(&a.points(rims[0], 2), &b.points(rims[1], 1))
    }
}

/// Writes the start of a query of two cylinders; a cold one where it marks no features.
pub(in crate::gjk) fn write(cores: [&Core; 2], start: &Simplex, words: &mut [u64]) {
    let marks = both_rims(cores).and_then(|rims| CylinderMarks::of(rims, start));
    CylinderMarks::write(marks.as_ref(), words);
}

/// Reads the start of a query of two cylinders.
pub(in crate::gjk) fn read(cores: [&Core; 2], words: &[u64], start: &mut Simplex) {
    if let (Some(rims), Some(marks)) = (both_rims(cores), CylinderMarks::read(words)) {
        *start = marks.simplex(rims);
    }
}

/// The rims of two cylinders.
#[inline(always)]
pub(super) fn both_rims(cores: [&Core; 2]) -> Option<[Rims; 2]> {
    Some([cores[0].rims()?, cores[1].rims()?])
}
