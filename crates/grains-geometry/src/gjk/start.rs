//! What is kept of a simplex from one query to the next, in few words.
//!
//! The points of a simplex are corners of the cores, told by their numbers, or the foot of a corner on a face. Of two
//! superellipsoids they are the nearest points of the surfaces, of two cylinders the features that touch. Only simplexes with one body of
//! revolution, or with cones, are kept whole.

use super::{Simplex, cylinders};
use crate::convex::Convex;
use crate::core::with_convex;
use crate::{Core, Vec3};

/// In place of the number of a corner: the words after the numbers are the point.
pub(super) const FOOT: u16 = u16::MAX - 1;
/// In place of the number of a corner: none.
pub(super) const NONE: u16 = u16::MAX;
/// Pairs of corners whose numbers are in a word.
const PAIRS: usize = 2;
/// Words of the numbers of four pairs.
const NUMBERS: usize = 2;

/// In which form the start of a query of two cores is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartForm {
    /// Numbers of corners, and a foot.
    Corners,
    /// A point of each surface.
    Surfaces,
    /// Rims, lines or discs of two cylinders.
    Marks,
}

impl StartForm {
    /// The form for two cores; `None` if their simplex is to be kept whole.
    #[inline]
    pub fn of(a: &Core, b: &Core) -> Option<Self> {
        let is_smooth = |core: &Core| matches!(core, Core::Superellipsoid(body) if body.is_smooth());
        if is_smooth(a) && is_smooth(b) {
            Some(Self::Surfaces)
        } else if matches!((a, b), (Core::Cylinder { .. }, Core::Cylinder { .. })) {
            Some(Self::Marks)
        } else {
            (has_few_corners(a) && has_few_corners(b)).then_some(Self::Corners)
        }
    }

    /// Number of words of a start.
    #[inline]
    pub fn words(self) -> usize {
        match self {
            Self::Corners => NUMBERS + 3,
            Self::Surfaces => 6,
            Self::Marks => cylinders::WORDS,
        }
    }

    /// Writes a start; of superellipsoids whose surfaces were not followed, or cylinders whose features are not marked, and thus a search
    /// will be needed again, a cold one.
    ///
    /// # Panics
    /// If there are not as many words as the form has.
    #[inline]
    pub fn write(self, cores: [&Core; 2], start: &Simplex, words: &mut [u64]) {
        match self {
            Self::Corners => write_corners(cores, start, words),
            Self::Surfaces if start.len == 1 => write_surfaces(&[start.a[0], start.b[0]], words),
            Self::Surfaces => write_surfaces(&[Vec3::repeat(f64::NAN); 2], words),
            Self::Marks => cylinders::write(cores, start, words),
        }
    }

    /// Reads a start that was written; only the points it has are set.
    #[inline]
    pub fn read(self, cores: [&Core; 2], words: &[u64], start: &mut Simplex) {
        start.len = 0;
        match self {
            Self::Corners => read_corners(cores, words, start),
            Self::Surfaces => {
                if let Some([a, b]) = read_surfaces(words) {
                    (start.len, start.a[0], start.b[0]) = (1, a, b);
                }
            }
            Self::Marks => cylinders::read(cores, words, start),
        }
    }
}

/// Writes a start of the form [`StartForm::Surfaces`]: a point of each surface, in the frame of its body (m).
#[inline(always)]
pub fn write_surfaces([a, b]: &[Vec3; 2], words: &mut [u64]) {
    write_point(a, words);
    write_point(b, &mut words[3..]);
}

/// Reads a start of the form [`StartForm::Surfaces`]; `None` if it is cold.
#[inline(always)]
pub fn read_surfaces(words: &[u64]) -> Option<[Vec3; 2]> {
    let points = [point(words), point(&words[3..])];
    (!points[0].x.is_nan()).then_some(points)
}

/// Whether the core is the hull of corners that have numbers.
#[inline]
fn has_few_corners(core: &Core) -> bool {
    match core {
        Core::Point | Core::Segment { .. } | Core::Box(_) | Core::Triangle(_) => true,
        Core::Polyhedron(hull) => hull.vertices().len() < FOOT as usize,
        Core::Cylinder { .. } | Core::Cone(_) | Core::Superellipsoid(_) => false,
    }
}

/// Numbers of the corners of up to four pairs, a foot in place of one of them; a start of other points is cold.
#[inline]
fn write_corners([a, b]: [&Core; 2], start: &Simplex, words: &mut [u64]) {
    let len = start.len as usize;
    let (mut numbers, mut feet) = ([[NONE; 4]; 2], 0);
    let mut foot = Vec3::zeros();
    with_convex!(a, convex => number(convex, &start.a[..len], &mut numbers[0], (&mut feet, &mut foot)));
    with_convex!(b, convex => number(convex, &start.b[..len], &mut numbers[1], (&mut feet, &mut foot)));
    if feet > 1 {
        numbers = [[NONE; 4]; 2];
    }
    write_numbers(&numbers, &foot, words);
}

/// Writes the numbers of the corners of up to four pairs, and a foot (m).
#[inline(always)]
pub(super) fn write_numbers(numbers: &[[u16; 4]; 2], foot: &Vec3, words: &mut [u64]) {
    let word = |k: usize| {
        let pair = |k: usize| u64::from(numbers[0][k]) | u64::from(numbers[1][k]) << 16;
        pair(k) | pair(k + 1) << 32
    };
    (words[0], words[1]) = (word(0), word(PAIRS));
    write_point(foot, &mut words[NUMBERS..]);
}

/// Reads the numbers of the corners of up to four pairs, how many those are, and a foot (m).
#[inline(always)]
pub(super) fn read_numbers(words: &[u64]) -> ([[u16; 4]; 2], usize, Vec3) {
    let (mut numbers, mut len) = ([[NONE; 4]; 2], 0);
    for (k, pair) in [words[0], words[0] >> 32, words[1], words[1] >> 32].into_iter().enumerate() {
        let pair = [pair as u16, (pair >> 16) as u16];
        if pair[0] == NONE {
            break;
        }
        (numbers[0][k], numbers[1][k], len) = (pair[0], pair[1], k + 1);
    }
    (numbers, len, point(&words[NUMBERS..]))
}

/// Numbers of points that are corners; counts those that are not.
#[inline(always)]
fn number(
    convex: &impl Convex,
    points: &[Vec3],
    numbers: &mut [u16; 4],
    (feet, foot): (&mut usize, &mut Vec3),
) {
    for (number, point) in numbers.iter_mut().zip(points) {
        *number = convex.number_of(point).unwrap_or_else(|| {
            (*feet, *foot) = (*feet + 1, *point);
            FOOT
        });
    }
}

#[inline]
fn read_corners([a, b]: [&Core; 2], words: &[u64], start: &mut Simplex) {
    let (numbers, len, foot) = read_numbers(words);
    start.len = len as u8;
    with_convex!(a, convex => place(convex, &numbers[0], &foot, &mut start.a[..len]));
    with_convex!(b, convex => place(convex, &numbers[1], &foot, &mut start.b[..len]));
}

/// The points of numbers.
#[inline(always)]
fn place(convex: &impl Convex, numbers: &[u16; 4], foot: &Vec3, points: &mut [Vec3]) {
    for (point, number) in points.iter_mut().zip(numbers) {
        *point = if *number == FOOT { *foot } else { convex.vertex(*number as usize) };
    }
}

/// Writes the numbers one by one: a copy of them all would wait for them to reach the cache.
#[inline(always)]
fn write_point(point: &Vec3, words: &mut [u64]) {
    if let [x, y, z, ..] = words {
        (*x, *y, *z) = (point.x.to_bits(), point.y.to_bits(), point.z.to_bits());
    }
}

#[inline(always)]
fn point(words: &[u64]) -> Vec3 {
    Vec3::new(f64::from_bits(words[0]), f64::from_bits(words[1]), f64::from_bits(words[2]))
}
