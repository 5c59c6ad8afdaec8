//! What touches of two polyhedra, in few words.

use crate::gjk::start::{FOOT, NONE, read_numbers, write_numbers};
use crate::{Polyhedron, Vec3};

/// What two polyhedra touched with: the start of their next query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PolyhedronStart {
    /// Number of a corner of the second and its foot on a face of the first, in the frame of the first (m).
    OnFirst(u16, Vec3),
    /// Number of a corner of the first and its foot on a face of the second, in the frame of the second (m).
    OnSecond(u16, Vec3),
    /// Numbers of the corners at the ends of an edge of each, and whether the nearest point is farther along that of the first.
    EdgeOnEdge([[u16; 2]; 2], bool),
}

impl PolyhedronStart {
    /// Reads the start of two polyhedra that was written; `None` if they touched in another way.
    #[inline(always)]
    pub fn read(hulls: [&Polyhedron; 2], words: &[u64]) -> Option<Self> {
        let (numbers, len, foot) = read_numbers(words);
        match len {
            1 => Some(match numbers.map(|numbers| numbers[0]) {
                [FOOT, corner] => Self::OnFirst(corner, foot),
                [corner, FOOT] => Self::OnSecond(corner, foot),
                [corner, other] => Self::OnSecond(corner, hulls[1].vertices()[other as usize]),
            }),
            3 => {
                let [a, b] = numbers.map(|[p, q, r, _]| ends([p, q, r]).filter(|ends| !ends.contains(&FOOT)));
                Some(Self::EdgeOnEdge([a?, b?], false))
            }
            _ => None,
        }
    }

    /// Writes it.
    #[inline(always)]
    pub fn write(&self, words: &mut [u64]) {
        let (numbers, foot) = match self {
            Self::OnFirst(corner, foot) => ([[FOOT, NONE, NONE, NONE], [*corner, NONE, NONE, NONE]], *foot),
            Self::OnSecond(corner, foot) => ([[*corner, NONE, NONE, NONE], [FOOT, NONE, NONE, NONE]], *foot),
            Self::EdgeOnEdge(edges, is_farther_on_a) => {
                (triangle(*edges, *is_farther_on_a).map(|[p, q, r]| [p, q, r, NONE]), Vec3::zeros())
            }
        };
        write_numbers(&numbers, &foot, words);
    }
}

/// The two that three corners are of.
#[inline(always)]
pub(super) fn ends<P: PartialEq + Copy>([p, q, r]: [P; 3]) -> Option<[P; 2]> {
    if p == q { (p != r).then_some([p, r]) } else { (r == p || r == q).then_some([p, q]) }
}

/// Corners of the triangle of the parallelogram of differences of two edges that holds the way between them, whose end on A is farther
/// along the edge or not.
#[inline(always)]
pub(super) fn triangle<P: Copy>([[a0, a1], [b0, b1]]: [[P; 2]; 2], is_farther_on_a: bool) -> [[P; 3]; 2] {
    let (middle_a, middle_b) = if is_farther_on_a { (a1, b0) } else { (a0, b1) };
    [[a0, middle_a, a1], [b0, middle_b, b1]]
}
