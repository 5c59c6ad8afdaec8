//! Whether numbers are the contact history of a particle.

use crate::bonds::BondKind;
use crate::contact_history::{BondHistory, LAW_FOLLOWS, LawHistory};
use crate::walls::Wall;

/// Largest number of points of a simplex.
const MAX_SIMPLEX_POINTS: f64 = 4.0;
/// Identities are whole numbers below this one, as a f64 holds all of these.
const IDENTITIES: f64 = 9_007_199_254_740_992.0;
/// Codes of periodic images.
const IMAGES: f64 = 27.0;

/// What the numbers of a contact history may refer to.
pub struct HistoryBounds<'a, F> {
    /// The wall of a number, if the history of its contacts is kept.
    pub wall: F,
    /// How many walls there were.
    pub walls: usize,
    /// Bonds of the case.
    pub bonds: &'a [BondKind],
}

impl<'a, F: Fn(u16) -> Option<&'a Wall>> HistoryBounds<'a, F> {
    /// Whether numbers are a contact history as of [`Dem::packed_history`](crate::Dem::packed_history), to the last one.
    pub fn admit(&self, packed: &[f64]) -> bool {
        packed.iter().all(|x| x.is_finite()) && self.rest(packed).is_some_and(<[f64]>::is_empty)
    }

    /// What follows a history; none if it is none.
    fn rest<'m>(&self, packed: &'m [f64]) -> Option<&'m [f64]> {
        let mut message = Message(packed);
        let &[spheres, bodies, walls] = message.take(3)? else { return None };
        let (with_laws, with_bonds) = (spheres < 0.0, walls < 0.0);
        let of_walls = if with_bonds { -1.0 - walls } else { walls };
        for _ in 0..message.count(spheres.abs())? {
            message.whole(IDENTITIES)?;
            message.take(3 + if with_laws { LawHistory::LENGTH } else { 0 })?;
        }
        for _ in 0..message.count(bodies)? {
            message.whole(IDENTITIES)?;
            message.whole(f64::from(u16::MAX))?;
            message.whole(f64::from(u16::MAX))?;
            message.contact()?;
        }
        for _ in 0..message.count(of_walls)? {
            let wall = message.whole(self.walls as f64)? as u16;
            let surface = message.whole(f64::from(u16::MAX))? as usize;
            message.whole(f64::from(u16::MAX))?;
            let element = message.whole(f64::from(u32::MAX))?;
            message.whole(IMAGES)?;
            if let Some(wall) = (self.wall)(wall)
                && !wall.surfaces.get(surface)?.has_element(element as u32)
            {
                return None;
            }
            message.contact()?;
        }
        if with_bonds {
            let bonds = message.take(1)?[0];
            for _ in 0..message.count(bonds)? {
                message.whole(IDENTITIES)?;
                message.whole(self.bonds.len() as f64)?;
                message.take(BondHistory::LENGTH - 2)?;
            }
        }
        Some(message.0)
    }
}

struct Message<'m>(&'m [f64]);

impl<'m> Message<'m> {
    fn take(&mut self, count: usize) -> Option<&'m [f64]> {
        let (head, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(head)
    }

    /// A whole number of at least 0 and below `end`.
    fn whole(&mut self, end: f64) -> Option<f64> {
        let number = self.take(1)?[0];
        (number >= 0.0 && number < end && number.fract() == 0.0).then_some(number)
    }

    /// How many items follow: no more than there are numbers.
    fn count(&self, number: f64) -> Option<usize> {
        (number >= 0.0 && number <= self.0.len() as f64 && number.fract() == 0.0).then_some(number as usize)
    }

    /// History of a contact of bodies.
    fn contact(&mut self) -> Option<()> {
        let points = self.take(5)?[4];
        let has_law = points >= LAW_FOLLOWS;
        let points = if has_law { points - LAW_FOLLOWS } else { points };
        if !(0.0..=MAX_SIMPLEX_POINTS).contains(&points) || points.fract() != 0.0 {
            return None;
        }
        self.take(if has_law { LawHistory::LENGTH } else { 0 } + 6 * points as usize).map(drop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn admits(packed: &[f64]) -> bool {
        let bounds = HistoryBounds { wall: |_| None, walls: 3, bonds: &[] };
        bounds.admit(packed)
    }

    #[test]
    fn every_cut_and_every_wrong_count_of_a_history_is_refused() {
        let contact = [0.5, 0.25, 0.125, 2.0, 2.0];
        let simplex = [1.0; 12];
        let law = [0.1; 6];
        let wall = [2.0, 1.0, 0.0, 5.0, 13.0, 0.5, 0.25, 0.125, 2.0, 17.0];
        let packed = [
            &[-1.0, 1.0, 1.0, 7.0, 0.1, 0.2, 0.3][..],
            &law,
            &[9.0, 0.0, 1.0],
            &contact,
            &simplex,
            &wall,
            &law,
            &[1.0; 6],
        ]
        .concat();
        assert!(admits(&packed) && admits(&[0.0; 3]));
        for end in 0..packed.len() {
            assert!(!admits(&packed[..end]), "{end}");
        }
        assert!(!admits(&[&packed[..], &[0.0]].concat()));
        // Counts, identities, numbers of parts, walls and surfaces, images, and points of simplexes.
        for place in [0, 1, 2, 3, 13, 14, 15, 20, 33, 34, 35, 36, 37, 42] {
            for wrong in [-7.0, 0.5, 1e300, f64::NAN, f64::INFINITY] {
                let mut other = packed.clone();
                other[place] = wrong;
                assert!(!admits(&other), "{place}: {wrong}");
            }
        }
        for place in 0..packed.len() {
            let mut other = packed.clone();
            other[place] = f64::NAN;
            assert!(!admits(&other), "{place}");
        }
    }
}
