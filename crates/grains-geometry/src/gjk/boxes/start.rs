//! What touches of two boxes, in few words.

use crate::Vec3;
use crate::convex::Convex as _;
use crate::convex::cuboid::Cuboid;
use crate::gjk::Simplex;
use crate::gjk::start::{FOOT, NONE, read_numbers, write_numbers};

/// Number of corners of a box.
const CORNERS: u16 = 8;

/// What two boxes touched with: the start of their next query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BoxStart {
    /// A corner of one and its foot on a face of the other, in the frames of their boxes (m).
    CornerOnFace([Vec3; 2]),
    /// Numbers of three corners of each, which are ends of an edge.
    EdgeOnEdge([[u16; 3]; 2]),
}

impl BoxStart {
    /// That of a simplex of two boxes of half edges (m), if it is one of these.
    #[inline(always)]
    pub(super) fn of(halves: &[Vec3; 2], simplex: &Simplex) -> Option<Self> {
        let Simplex { len, a, b } = simplex;
        match len {
            1 => Some(Self::CornerOnFace([a[0], b[0]])),
            3 => {
                let numbers = |half: &Vec3, points: &[Vec3; 4]| {
                    let number = |k: usize| Cuboid(*half).number_of(&points[k]);
                    Some([number(0)?, number(1)?, number(2)?])
                };
                Self::of_corners([numbers(&halves[0], a)?, numbers(&halves[1], b)?])
            }
            _ => None,
        }
    }

    /// That of corners, if they are of one edge of each box.
    #[inline(always)]
    fn of_corners(corners: [[u16; 3]; 2]) -> Option<Self> {
        let [a, b] = axes_of(&corners);
        (a.is_power_of_two() & b.is_power_of_two()).then_some(Self::EdgeOnEdge(corners))
    }

    /// Edges of boxes of half edges (m) along axes, given as bits, that are nearest each other in points in the frames of their boxes (m).
    #[inline(always)]
    pub(super) fn of_edges(halves: &[Vec3; 2], axes: [u16; 2], points: &[Vec3; 2]) -> Self {
        let ends = |side: usize| {
            let bit = |axis: usize| u16::from(points[side][axis].is_sign_negative()) << axis;
            let corner = (bit(0) | bit(1) | bit(2)) & !axes[side];
            [corner | axes[side], corner]
        };
        let [along_a, along_b] = axes.map(|axis| usize::from(axis >> 1));
        let ([a0, a1], [b0, b1]) = (ends(0), ends(1));
        // The triangle of the parallelogram of differences that holds the answer.
        let is_farther_on_a =
            points[0][along_a] * halves[1][along_b] >= points[1][along_b] * halves[0][along_a];
        let (middle_a, middle_b) = if is_farther_on_a { (a1, b0) } else { (a0, b1) };
        Self::EdgeOnEdge([[a0, middle_a, a1], [b0, middle_b, b1]])
    }

    /// Reads the start of boxes of half edges (m) that was written; `None` if they touched in another way.
    #[inline(always)]
    pub fn read(halves: &[Vec3; 2], words: &[u64]) -> Option<Self> {
        let (numbers, len, foot) = read_numbers(words);
        match len {
            1 => {
                let point = |side: usize| match numbers[side][0] {
                    FOOT => foot,
                    number => Cuboid(halves[side]).vertex(number as usize),
                };
                Some(Self::CornerOnFace([point(0), point(1)]))
            }
            3 => {
                let corners = numbers.map(|[p, q, r, _]| [p, q, r]);
                let are_corners = corners.as_flattened().iter().all(|&number| number < CORNERS);
                if are_corners { Self::of_corners(corners) } else { None }
            }
            _ => None,
        }
    }

    /// Writes the start of boxes of half edges (m).
    #[inline(always)]
    pub fn write(&self, halves: &[Vec3; 2], words: &mut [u64]) {
        let mut foot = Vec3::zeros();
        let mut number = |side: usize, point: &Vec3| {
            Cuboid(halves[side]).number_of(point).unwrap_or_else(|| {
                foot = *point;
                FOOT
            })
        };
        let numbers = match self {
            Self::CornerOnFace([a, b]) => {
                [number(0, a), number(1, b)].map(|number| [number, NONE, NONE, NONE])
            }
            Self::EdgeOnEdge(corners) => corners.map(|[p, q, r]| [p, q, r, NONE]),
        };
        write_numbers(&numbers, &foot, words);
    }

    /// Leaves it in a simplex of boxes of half edges (m).
    #[inline(always)]
    pub(super) fn put_in(&self, halves: &[Vec3; 2], simplex: &mut Simplex) {
        match self {
            Self::CornerOnFace([a, b]) => (simplex.len, simplex.a[0], simplex.b[0]) = (1, *a, *b),
            Self::EdgeOnEdge(corners) => {
                simplex.len = 3;
                for (side, points) in [&mut simplex.a, &mut simplex.b].into_iter().enumerate() {
                    for (point, number) in points.iter_mut().zip(corners[side]) {
                        *point = Cuboid(halves[side]).vertex(number as usize);
                    }
                }
            }
        }
    }
}

/// Axes along which corners of either box differ, as bits.
#[inline(always)]
pub(super) fn axes_of(corners: &[[u16; 3]; 2]) -> [u16; 2] {
    corners.map(|[p, q, r]| (p ^ q) | (p ^ r))
}
