//! Who holds the velocities of a component, halo included.

use crate::nodes::Node;
use grains_domain::prefetch;

/// Of a mark: the rest is the place of a body in the list, not the number of an own node.
const HALO: u32 = 1 << 31;

/// The places that bodies hold.
///
/// A bit for each lies in cache for all that looks whether velocities near a surface are held; what is held has a mark beside it.
#[derive(Clone, Debug)]
pub(crate) struct Marks {
    /// Eight places in each, and one more.
    bits: Vec<u8>,
    /// Without meaning at places that are not held.
    marks: Vec<u32>,
}

impl Marks {
    /// None of so many places is held.
    pub fn new(places: usize) -> Self {
        Self { bits: vec![0; places / 8 + 2], marks: vec![0; places] }
    }

    /// Forgets what is held.
    pub fn clear(&mut self) {
        self.bits.fill(0);
    }

    /// Whether a place is held.
    #[inline(always)]
    pub fn holds(&self, place: usize) -> bool {
        self.bits[place / 8] >> (place % 8) & 1 != 0
    }

    /// Whether a place is held, and the one after it.
    #[inline(always)]
    pub fn holds_edge(&self, place: usize) -> [bool; 2] {
        let bits = u16::from_le_bytes([self.bits[place / 8], self.bits[place / 8 + 1]]) >> (place % 8);
        [bits & 1 != 0, bits & 2 != 0]
    }

    /// Number of the own node at a place.
    #[inline]
    pub fn own(&self, place: usize) -> Option<u32> {
        Some(self.marks[place]).filter(|mark| self.holds(place) && *mark < HALO)
    }

    /// Marks the place of an own node of this number.
    pub fn hold(&mut self, place: usize, number: u32) {
        self.marks[place] = number;
        self.bits[place / 8] |= 1 << (place % 8);
    }

    /// Marks a place that a body of this place in the list holds, and another rank has.
    pub fn hold_halo(&mut self, place: usize, body: u32) {
        self.hold(place, HALO | body);
    }

    /// Asks the memory for the mark of a place.
    #[inline(always)]
    pub fn prefetch(&self, place: usize) {
        prefetch(&self.marks, place);
    }
}

/// Who holds the velocities of a component.
#[derive(Clone, Copy)]
pub(crate) struct Holders<'a> {
    pub marks: &'a Marks,
    /// The own nodes.
    pub nodes: &'a [Node],
}

impl Holders<'_> {
    /// Whether a body holds a place.
    #[inline(always)]
    pub fn holds(&self, place: usize) -> bool {
        self.marks.holds(place)
    }

    /// The body that holds a place.
    #[inline]
    pub fn body(&self, place: usize) -> Option<u32> {
        self.holds(place).then(|| match self.marks.marks[place] {
            mark @ HALO.. => mark - HALO,
            own => self.nodes[own as usize].body,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places are held by whom they were marked for last, whatever their neighbours; nothing is after they were cleared.
    #[test]
    fn places_are_held_as_they_are_marked() {
        let places = 203;
        let mut marks = Marks::new(places);
        for round in 0..3_usize {
            let mark = |place: usize| match (place * (7 + round)) % 5 {
                0 => Some((false, (place + round) as u32)),
                1 => Some((true, (3 * place + round) as u32)),
                _ => None,
            };
            for (place, (is_halo, number)) in (0..places).filter_map(|place| Some((place, mark(place)?))) {
                if is_halo { marks.hold_halo(place, number) } else { marks.hold(place, number) }
            }
            let nodes: Vec<Node> = (0..2 * places).map(|n| Node::deep(n, 1000 + n as u32)).collect();
            let holders = Holders { marks: &marks, nodes: &nodes };
            for place in 0..places {
                assert_eq!(holders.holds(place), mark(place).is_some());
                let next = place + 1 < places && mark(place + 1).is_some();
                assert_eq!(marks.holds_edge(place), [mark(place).is_some(), next]);
                let own = mark(place).filter(|(is_halo, _)| !is_halo).map(|(_, number)| number);
                assert_eq!(marks.own(place), own);
                let body = mark(place).map(|(is_halo, n)| if is_halo { n } else { 1000 + n });
                assert_eq!(holders.body(place), body);
            }
            marks.clear();
            assert!((0..places).all(|place| !marks.holds(place) && marks.own(place).is_none()));
        }
    }
}
