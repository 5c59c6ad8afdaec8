//! Contact history: what a contact keeps from one step to the next, saved per particle when lists are rebuilt.
//!
//! Between rebuilds a history sits in its pair. For a rebuild, a migration or a checkpoint it is saved
//! in rows, one per owned particle, so that it travels with the particle. Both ranks that share a pair
//! hold the same history, so nothing is lost when one of the two particles moves away.

use crate::memory_use::heap_bytes;
use grains_contact::{BondState, WoundAngles};
use grains_geometry::{Simplex, Vec3};

/// What laws keep of a contact beside its tangential displacement, as seen from its first body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct LawHistory {
    /// Angles rolled and twisted (rad).
    pub(crate) angles: WoundAngles,
    /// The number kept by the law of the normal direction.
    pub(crate) memory: f64,
    /// Volume of the liquid bridge (m³).
    pub(crate) bridge: f64,
}

impl LawHistory {
    /// Numbers in a message.
    pub(crate) const LENGTH: usize = 6;

    /// Whether there is nothing to keep.
    pub(crate) fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The same with one sign of zero, as whether a list has the contact from this body or the other does not matter.
    pub(crate) fn saved(&self) -> Self {
        self.with_rolling(self.angles.rolling + Vec3::zeros())
    }

    /// The same as seen from the other body.
    pub(crate) fn seen_from_other(&self) -> Self {
        self.with_rolling(Vec3::zeros() - self.angles.rolling)
    }

    fn with_rolling(&self, rolling: Vec3) -> Self {
        Self { angles: WoundAngles { rolling, twisting: self.angles.twisting + 0.0 }, ..*self }
    }

    fn write(&self, message: &mut Vec<f64>) {
        let Self { angles: WoundAngles { rolling, twisting }, memory, bridge } = self;
        message.extend([rolling.x, rolling.y, rolling.z, *twisting, *memory, *bridge]);
    }

    fn read(message: &[f64]) -> Self {
        let rolling = Vec3::new(message[0], message[1], message[2]);
        let angles = WoundAngles { rolling, twisting: message[3] };
        Self { angles, memory: message[4], bridge: message[5] }
    }
}

/// Added to the number of points of a simplex in a message where the numbers of the law follow.
pub(crate) const LAW_FOLLOWS: f64 = 16.0;

/// Rows of items, one row per particle.
#[derive(Clone, Debug)]
pub(crate) struct Rows<T> {
    first: Vec<u32>,
    items: Vec<T>,
}

impl<T> Default for Rows<T> {
    fn default() -> Self {
        Self { first: vec![0], items: Vec::new() }
    }
}

impl<T: Copy> Rows<T> {
    /// Fills the rows from entries (row, item) visited in any order, twice the same.
    fn fill(&mut self, rows: usize, blank: T, visit: impl Fn(&mut dyn FnMut(u32, T))) {
        self.first.clear();
        self.first.resize(rows + 1, 0);
        let first = &mut self.first;
        visit(&mut |row, _| first[row as usize + 1] += 1);
        for row in 0..rows {
            first[row + 1] += first[row];
        }
        self.items.clear();
        self.items.resize(first[rows] as usize, blank);
        let items = &mut self.items;
        visit(&mut |row, item| {
            let at = &mut first[row as usize];
            items[*at as usize] = item;
            *at += 1;
        });
        // Every start has moved to its end: shift back.
        first.rotate_right(1);
        first[0] = 0;
    }

    /// Items of a row; a row that was never filled is empty.
    pub(crate) fn row(&self, row: usize) -> &[T] {
        match self.first.get(row + 1) {
            Some(&end) => &self.items[self.first[row] as usize..end as usize],
            None => &[],
        }
    }

    fn bytes(&self) -> usize {
        heap_bytes(&self.first) + heap_bytes(&self.items)
    }

    /// Whether no row has an item.
    pub(crate) fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    fn push_row(&mut self, items: impl IntoIterator<Item = T>) {
        self.items.extend(items);
        self.first.push(self.items.len() as u32);
    }
}

/// A contact of two spheres, seen from the particle that holds it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SphereHistory {
    pub(crate) partner: u64,
    pub(crate) tangential_displacement: Vec3,
}

/// History of a contact of bodies that are not both spheres, while it lasts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ContactHistory {
    /// Tangential displacement (m).
    pub(crate) tangential_displacement: Vec3,
    /// Torsional angle about the normal (rad).
    pub(crate) torsional_angle: f64,
    /// What laws keep beside them.
    pub(crate) law: LawHistory,
    /// Simplex of the last distance query.
    pub(crate) simplex: Simplex,
}

/// A contact of two parts, seen from the particle of lower id.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartHistory {
    pub(crate) partner: u64,
    pub(crate) parts: [u16; 2],
    pub(crate) contact: ContactHistory,
}

/// A contact with a wall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallHistory {
    pub(crate) wall: u16,
    pub(crate) surface: u16,
    pub(crate) part: u16,
    pub(crate) element: u32,
    /// Periodic image as seen from the wrapped position, a code of [`crate::periodic_images`].
    pub(crate) image: u8,
    pub(crate) contact: ContactHistory,
}

/// A bond, as seen from the particle of lower id.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BondHistory {
    pub(crate) partner: u64,
    pub(crate) kind: u16,
    pub(crate) state: BondState,
}

impl BondHistory {
    /// Numbers in a message.
    pub(crate) const LENGTH: usize = 2 + BondState::NUMBERS;

    fn write(&self, message: &mut Vec<f64>) {
        message.extend([self.partner as f64, f64::from(self.kind)]);
        message.extend(<[f64; BondState::NUMBERS]>::from(self.state));
    }

    fn read(message: &[f64]) -> Self {
        let state: [f64; BondState::NUMBERS] = std::array::from_fn(|k| message[2 + k]);
        Self { partner: message[0] as u64, kind: message[1] as u16, state: state.into() }
    }
}

/// What tells apart the contacts of a particle with walls: wall, surface, part, element, and periodic image.
pub(crate) type WallKey = (u16, u16, u16, u32, u8);

impl WallHistory {
    pub(crate) fn key(&self) -> WallKey {
        (self.wall, self.surface, self.part, self.element, self.image)
    }
}

/// The histories of all owned particles, in rows by particle.
#[derive(Clone, Debug, Default)]
pub(crate) struct SavedHistories {
    pub(crate) spheres: Rows<SphereHistory>,
    /// What laws keep of the contacts of `spheres` beside the tangential displacement; empty if nothing.
    pub(crate) sphere_laws: Rows<LawHistory>,
    pub(crate) part_pairs: Rows<PartHistory>,
    pub(crate) walls: Rows<WallHistory>,
    pub(crate) bonds: Rows<BondHistory>,
}

/// Contact history of a particle, as of [`Dem::packed_history`](crate::Dem::packed_history), with walls that have
/// other numbers now; those without one are dropped.
pub fn renumber_walls(packed: &[f64], number: impl Fn(u16) -> Option<u16>) -> Vec<f64> {
    let mut histories = SavedHistories::default();
    histories.read(packed);
    let walls =
        histories.walls.row(0).iter().filter_map(|m| Some(WallHistory { wall: number(m.wall)?, ..*m }));
    let mut renumbered = Rows::default();
    renumbered.push_row(walls);
    histories.walls = renumbered;
    let mut packed = Vec::new();
    histories.write(0, &mut packed);
    packed
}

/// Contact history of a particle, as of [`Dem::packed_history`](crate::Dem::packed_history), without bridges.
pub fn without_bridges(packed: &[f64]) -> Vec<f64> {
    let mut histories = SavedHistories::default();
    histories.read(packed);
    let SavedHistories { sphere_laws, part_pairs, walls, .. } = &mut histories;
    let laws = sphere_laws.items.iter_mut();
    let laws = laws.chain(part_pairs.items.iter_mut().map(|history| &mut history.contact.law));
    let laws = laws.chain(walls.items.iter_mut().map(|history| &mut history.contact.law));
    laws.for_each(|law| law.bridge = 0.0);
    let mut packed = Vec::new();
    histories.write(0, &mut packed);
    packed
}

impl SavedHistories {
    /// Saves entries (owned particle, history) in rows; those of spheres with what laws keep, if they do.
    pub(crate) fn fill(
        &mut self,
        owned: usize,
        keeps_law_history: bool,
        spheres: impl Fn(&mut dyn FnMut(u32, SphereHistory, &LawHistory)),
        part_pairs: impl Fn(&mut dyn FnMut(u32, PartHistory)),
        walls: impl Fn(&mut dyn FnMut(u32, WallHistory)),
        bonds: impl Fn(&mut dyn FnMut(u32, BondHistory)),
    ) {
        self.spheres.fill(
            owned,
            SphereHistory { partner: 0, tangential_displacement: Vec3::zeros() },
            |add| spheres(&mut |row, history, _| add(row, history)),
        );
        // There is a row of each particle also where no pair keeps anything: arrivals follow with rows that do.
        self.sphere_laws.fill(owned, LawHistory::default(), |add| {
            if keeps_law_history {
                spheres(&mut |row, _, law| add(row, *law));
            }
        });
        let contact = ContactHistory::default();
        self.part_pairs.fill(owned, PartHistory { partner: 0, parts: [0; 2], contact }, part_pairs);
        let (wall, surface, part, element, image) = (0, 0, 0, 0, 0);
        self.walls.fill(owned, WallHistory { wall, surface, part, element, image, contact }, walls);
        let state = BondState::from([0.0; BondState::NUMBERS]);
        self.bonds.fill(owned, BondHistory { partner: 0, kind: 0, state }, bonds);
    }

    /// Memory (B).
    pub(crate) fn bytes(&self) -> usize {
        let contacts = self.spheres.bytes() + self.sphere_laws.bytes() + self.part_pairs.bytes();
        contacts + self.walls.bytes() + self.bonds.bytes()
    }

    /// Appends one particle's histories to a message. A negative number of spheres says that the numbers of the law follow
    /// each, a negative number of walls that bonds follow all.
    pub(crate) fn write(&self, row: usize, message: &mut Vec<f64>) {
        let (spheres, part_pairs, walls) =
            (self.spheres.row(row), self.part_pairs.row(row), self.walls.row(row));
        let laws = self.sphere_laws.row(row);
        let count = spheres.len() as f64;
        let count = if laws.is_empty() { count } else { -count };
        let bonds = self.bonds.row(row);
        // −1 for none, so that the number tells also where there are no walls.
        let of_walls = if bonds.is_empty() { walls.len() as f64 } else { -1.0 - walls.len() as f64 };
        message.extend([count, part_pairs.len() as f64, of_walls]);
        for (k, m) in spheres.iter().enumerate() {
            message.extend([
                m.partner as f64,
                m.tangential_displacement.x,
                m.tangential_displacement.y,
                m.tangential_displacement.z,
            ]);
            if let Some(law) = laws.get(k) {
                law.write(message);
            }
        }
        for m in part_pairs {
            message.extend([m.partner as f64, f64::from(m.parts[0]), f64::from(m.parts[1])]);
            m.contact.write(message);
        }
        for m in walls {
            message.extend([m.wall, m.surface, m.part].map(f64::from));
            message.extend([f64::from(m.element), f64::from(m.image)]);
            m.contact.write(message);
        }
        if !bonds.is_empty() {
            message.push(bonds.len() as f64);
            bonds.iter().for_each(|bond| bond.write(message));
        }
    }

    /// Reads one particle's histories as a new last row; returns the rest of the message.
    pub(crate) fn read<'a>(&mut self, message: &'a [f64]) -> &'a [f64] {
        let (with_laws, with_bonds) = (message[0] < 0.0, message[2] < 0.0);
        let of_walls = if with_bonds { -1.0 - message[2] } else { message[2] };
        let counts = [message[0].abs(), message[1], of_walls].map(|count| count as usize);
        let mut rest = &message[3..];
        let mut take = |n: usize| {
            let (head, tail) = rest.split_at(n);
            rest = tail;
            head
        };
        let mut laws = Vec::new();
        self.spheres.push_row((0..counts[0]).map(|_| {
            let m = take(4);
            if with_laws {
                laws.push(LawHistory::read(take(LawHistory::LENGTH)));
            }
            SphereHistory { partner: m[0] as u64, tangential_displacement: Vec3::new(m[1], m[2], m[3]) }
        }));
        self.sphere_laws.push_row(laws);
        self.part_pairs.push_row((0..counts[1]).map(|_| {
            let m = take(3);
            let (partner, parts) = (m[0] as u64, [m[1] as u16, m[2] as u16]);
            PartHistory { partner, parts, contact: ContactHistory::read(&mut take) }
        }));
        self.walls.push_row((0..counts[2]).map(|_| {
            let m = take(5);
            let [wall, surface, part] = [0, 1, 2].map(|k| m[k] as u16);
            let (element, image) = (m[3] as u32, m[4] as u8);
            WallHistory { wall, surface, part, element, image, contact: ContactHistory::read(&mut take) }
        }));
        let bonds = if with_bonds { take(1)[0] as usize } else { 0 };
        self.bonds.push_row((0..bonds).map(|_| BondHistory::read(take(BondHistory::LENGTH))));
        rest
    }
}

impl ContactHistory {
    /// Whether there is nothing to keep.
    pub(crate) fn is_empty(&self) -> bool {
        let Self { tangential_displacement, torsional_angle, law, simplex } = self;
        simplex.len == 0
            && *torsional_angle == 0.0
            && *tangential_displacement == Vec3::zeros()
            && law.is_empty()
    }

    fn write(&self, message: &mut Vec<f64>) {
        let Self { tangential_displacement, torsional_angle, law, simplex } = self;
        let has_law = !law.is_empty();
        message.extend([
            tangential_displacement.x,
            tangential_displacement.y,
            tangential_displacement.z,
            *torsional_angle,
            f64::from(simplex.len) + if has_law { LAW_FOLLOWS } else { 0.0 },
        ]);
        if has_law {
            law.write(message);
        }
        for k in 0..simplex.len as usize {
            for p in [&simplex.a[k], &simplex.b[k]] {
                message.extend([p.x, p.y, p.z]);
            }
        }
    }

    fn read<'a>(take: &mut impl FnMut(usize) -> &'a [f64]) -> Self {
        let m = take(5);
        let has_law = m[4] >= LAW_FOLLOWS;
        let points = if has_law { m[4] - LAW_FOLLOWS } else { m[4] };
        let law = if has_law { LawHistory::read(take(LawHistory::LENGTH)) } else { LawHistory::default() };
        let mut simplex = Simplex { len: points as u8, ..Simplex::default() };
        for k in 0..simplex.len as usize {
            let p = take(6);
            simplex.a[k] = Vec3::new(p[0], p[1], p[2]);
            simplex.b[k] = Vec3::new(p[3], p[4], p[5]);
        }
        Self { tangential_displacement: Vec3::new(m[0], m[1], m[2]), torsional_angle: m[3], law, simplex }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn histories_survive_saving_and_packing() {
        let tangential_displacement = |k: f64| Vec3::new(k, -k, 2.0 * k);
        let simplex =
            Simplex { len: 2, a: [tangential_displacement(1.0); 4], b: [tangential_displacement(2.0); 4] };
        let mut gathered = SavedHistories::default();
        let angles = WoundAngles { rolling: tangential_displacement(0.7), twisting: 0.2 };
        let law = LawHistory { angles, memory: 1e-5, bridge: 2e-12 };
        gathered.fill(
            3,
            true,
            |add| {
                for (row, partner, k) in [(2, 7, 0.5), (0, 8, 0.25), (2, 9, 0.125)] {
                    let tangential_displacement = tangential_displacement(k);
                    add(row, SphereHistory { partner, tangential_displacement }, &law);
                }
            },
            |add| {
                let contact = ContactHistory {
                    tangential_displacement: tangential_displacement(3.0),
                    torsional_angle: 0.1,
                    law,
                    simplex,
                };
                add(1, PartHistory { partner: 3, parts: [4, 5], contact })
            },
            |add| {
                let contact = ContactHistory {
                    tangential_displacement: tangential_displacement(5.0),
                    torsional_angle: -0.3,
                    law: LawHistory::default(),
                    simplex,
                };
                add(2, WallHistory { wall: 1, surface: 2, part: 3, element: 4, image: 5, contact })
            },
            |add| {
                let state = BondState::from([2e-3, 0.6, 0.0, 0.8, 1e-3, -2e-3, 3e-3]);
                for (row, partner) in [(0, 8), (2, 7), (0, 9)] {
                    add(row, BondHistory { partner, kind: 1, state });
                }
            },
        );
        assert_eq!(gathered.bonds.row(0).iter().map(|m| m.partner).collect::<Vec<_>>(), [8, 9]);
        assert_eq!(gathered.spheres.row(2).iter().map(|m| m.partner).collect::<Vec<_>>(), [7, 9]);
        assert_eq!(gathered.sphere_laws.row(2), [law; 2]);
        assert!(gathered.spheres.row(1).is_empty() && gathered.spheres.row(99).is_empty());
        let mut again = SavedHistories::default();
        for row in 0..3 {
            let (mut message, mut copy) = (Vec::new(), Vec::new());
            gathered.write(row, &mut message);
            assert!(again.read(&message).is_empty());
            again.write(row, &mut copy);
            assert_eq!(message, copy);
            assert_eq!(again.bonds.row(row).len(), gathered.bonds.row(row).len());
        }
    }

    #[test]
    fn what_laws_keep_of_an_arrival_stays_with_it() {
        let (mut own, mut of_other) = (SavedHistories::default(), SavedHistories::default());
        own.fill(2, false, |_| {}, |_| {}, |_| {}, |_| {});
        let law = LawHistory { memory: 1e-5, ..LawHistory::default() };
        let pair = SphereHistory { partner: 7, tangential_displacement: Vec3::zeros() };
        of_other.fill(1, true, |add| add(0, pair, &law), |_| {}, |_| {}, |_| {});
        let mut message = Vec::new();
        of_other.write(0, &mut message);
        assert!(own.read(&message).is_empty());
        assert_eq!((own.spheres.row(2).len(), own.sphere_laws.row(2)), (1, &[law][..]));
    }

    /// Memory of a particle with a sphere, and of walls 0, 1 and 2, without simplexes.
    fn history(walls: &[f64]) -> Vec<f64> {
        let mut packed = vec![1.0, 0.0, walls.len() as f64, 7.0, 0.1, 0.2, 0.3];
        for (k, wall) in walls.iter().enumerate() {
            packed.extend([*wall, 1.0, 0.0, 5.0, 13.0, 0.5 + k as f64, 0.25, 0.125, 2.0, 0.0]);
        }
        packed
    }

    #[test]
    fn contacts_keep_to_their_walls_when_others_come_and_go() {
        let packed = history(&[0.0, 1.0, 2.0]);
        assert_eq!(renumber_walls(&packed, Some), packed);
        assert_eq!(renumber_walls(&packed, |wall| Some(wall + 3)), history(&[3.0, 4.0, 5.0]));
        // The first is gone: the displacements of the others stay with them.
        let moved = renumber_walls(&packed, |wall| wall.checked_sub(1));
        let wanted: Vec<f64> =
            [&[1.0, 0.0, 2.0], &packed[3..7], &[0.0], &packed[18..27], &[1.0], &packed[28..]].concat();
        assert_eq!(moved, wanted);
    }
}
