//! GEOLOC: the 26 directions in which a subdomain has neighbours (thesis ch. 5, figs 5.1-5.4).

/// An offset in {−1, 0, 1}³ other than zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Direction(pub [i8; 3]);

impl Direction {
    /// Number of directions.
    pub const COUNT: usize = 26;

    /// All directions, x fastest, in the order of [`Direction::index`].
    pub fn all() -> impl Iterator<Item = Direction> {
        (0..27)
            .filter(|&code| code != 13)
            .map(|code: i8| Direction([code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1]))
    }

    /// Position in [`Direction::all`]; the opposite direction has index 25 − index.
    pub fn index(self) -> usize {
        let [x, y, z] = self.0.map(|c| (c + 1) as usize);
        let code = x + 3 * y + 9 * z;
        code - usize::from(code > 13)
    }

    /// The direction back.
    pub fn opposite(self) -> Direction {
        Direction(self.0.map(|c| -c))
    }

    /// The direction without its step along an axis.
    pub fn without(self, axis: usize) -> Direction {
        let mut steps = self.0;
        steps[axis] = 0;
        Direction(steps)
    }

    /// Whether the neighbour in this direction needs a clone of a particle in the buffers of these sides.
    ///
    /// `low` and `high` say per axis whether the particle lies in the buffer of that side: one side gives
    /// 1 direction, an edge 3, a corner 7; a thin subdomain may have both sides at once.
    pub fn needs_clone(&self, low: [bool; 3], high: [bool; 3]) -> bool {
        (0..3).all(|a| match self.0[a] {
            -1 => low[a],
            1 => high[a],
            _ => true,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_number_themselves_and_their_opposites() {
        assert_eq!(Direction::all().count(), Direction::COUNT);
        for (index, direction) in Direction::all().enumerate() {
            assert_eq!(direction.index(), index);
            assert_eq!(direction.opposite().index(), 25 - index);
        }
    }

    #[test]
    fn faces_edges_and_corners_have_one_three_and_seven_targets() {
        let count = |low, high| Direction::all().filter(|d| d.needs_clone(low, high)).count();
        let none = [false; 3];
        assert_eq!(count([true, false, false], none), 1);
        assert_eq!(count([true, false, false], [false, true, false]), 3);
        assert_eq!(count([true; 3], none), 7);
        assert_eq!(count([true; 3], [true; 3]), 26);
    }
}
