//! Which velocities of a component lie in bodies and walls, halo included, and in which.

use crate::node::Node;
use grains_domain::prefetch;

/// Of a mark: the rest is the place of a body in the list, not the number of an own node.
const HALO: u32 = 1 << 31;

/// The places of velocities in bodies: a bit for each, which lies in cache for all that looks at the neighbours of a velocity, and beside it
/// the node or body of those that are set.
#[derive(Clone, Debug)]
pub(crate) struct SolidMask {
    /// Eight places in each, and one more.
    bits: Vec<u8>,
    /// Without meaning at places that are not set.
    marks: Vec<u32>,
}

impl SolidMask {
    /// The mask of so many places, with none set.
    pub fn new(places: usize) -> Self {
        Self { bits: vec![0; places / 8 + 2], marks: vec![0; places] }
    }

    /// Takes all places for fluid.
    pub fn clear(&mut self) {
        self.bits.fill(0);
    }

    /// Whether a place is in a body.
    #[inline(always)]
    pub fn contains(&self, place: usize) -> bool {
        self.bits[place / 8] >> (place % 8) & 1 != 0
    }

    /// Whether a place is in a body, and the next one along x.
    #[inline(always)]
    pub fn contains_edge(&self, place: usize) -> [bool; 2] {
        let bits = u16::from_le_bytes([self.bits[place / 8], self.bits[place / 8 + 1]]) >> (place % 8);
        [bits & 1 != 0, bits & 2 != 0]
    }

    /// Number of the own node at a place.
    #[inline]
    pub fn own_node(&self, place: usize) -> Option<u32> {
        self.contains(place).then(|| self.marks[place]).filter(|mark| *mark < HALO)
    }

    /// Sets the place of an own node of this number.
    pub fn set_own(&mut self, place: usize, number: u32) {
        self.marks[place] = number;
        self.bits[place / 8] |= 1 << (place % 8);
    }

    /// Sets a place of another rank in the body with this place in the list.
    pub fn set_halo(&mut self, place: usize, body: u32) {
        self.set_own(place, HALO | body);
    }

    /// Asks the memory for the mark of a place.
    #[inline(always)]
    pub fn prefetch(&self, place: usize) {
        prefetch(&self.marks, place);
    }
}

/// Which body each velocity of a component lies in.
#[derive(Clone, Copy)]
pub(crate) struct Holders<'a> {
    pub mask: &'a SolidMask,
    /// The own nodes.
    pub nodes: &'a [Node],
}

impl Holders<'_> {
    /// Whether a body holds a place.
    #[inline(always)]
    pub fn holds(&self, place: usize) -> bool {
        self.mask.contains(place)
    }

    /// The body that holds a place.
    #[inline]
    pub fn body(&self, place: usize) -> Option<u32> {
        self.holds(place).then(|| match self.mask.marks[place] {
            mark @ HALO.. => mark - HALO,
            own => self.nodes[own as usize].body,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places are in the body they were set for last, whatever their neighbours, and in none after the mask was cleared.
    #[test]
    fn places_are_in_the_body_they_were_set_for() {
        let places = 203;
        let mut mask = SolidMask::new(places);
        for round in 0..3_usize {
            let wanted = |place: usize| match (place * (7 + round)) % 5 {
                0 => Some((false, (place + round) as u32)),
                1 => Some((true, (3 * place + round) as u32)),
                _ => None,
            };
            for (place, (is_halo, number)) in (0..places).filter_map(|place| Some((place, wanted(place)?))) {
                if is_halo { mask.set_halo(place, number) } else { mask.set_own(place, number) }
            }
            let nodes: Vec<Node> = (0..2 * places).map(|n| Node::deep(n, 1000 + n as u32)).collect();
            let holders = Holders { mask: &mask, nodes: &nodes };
            for place in 0..places {
                assert_eq!(holders.holds(place), wanted(place).is_some());
                let next = place + 1 < places && wanted(place + 1).is_some();
                assert_eq!(mask.contains_edge(place), [wanted(place).is_some(), next]);
                let own = wanted(place).filter(|(is_halo, _)| !is_halo).map(|(_, number)| number);
                assert_eq!(mask.own_node(place), own);
                let body = wanted(place).map(|(is_halo, n)| if is_halo { n } else { 1000 + n });
                assert_eq!(holders.body(place), body);
            }
            mask.clear();
            assert!((0..places).all(|place| !mask.contains(place) && mask.own_node(place).is_none()));
        }
    }
}
