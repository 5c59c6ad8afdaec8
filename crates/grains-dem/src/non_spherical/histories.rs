//! Contact histories of the pairs of a list.
//!
//! There is room for one of every pair, so that no step has to make any: hence a start is kept in as few words as the cores of the pair
//! allow, and what laws keep only where they do.

use super::pairs::PartPair;
use crate::contact_history::{ContactHistory, LawHistory};
use crate::contacts::Wound;
use crate::memory_use::{heap_bytes, make_room};
use grains_geometry::gjk::{
    BoxStart, CylinderMarks, PolyhedronStart, StartForm, read_surfaces, write_surfaces,
};
use grains_geometry::{Core, Polyhedron, Simplex, Vec3};

/// Of the place of a start: it is that of a whole simplex.
const WHOLE: u32 = 1 << 31;

/// Histories of pairs, each at the place of its pair; of one that does not touch it has no meaning.
#[derive(Clone, Debug, Default)]
pub(super) struct Histories {
    springs: Vec<Springs>,
    /// What laws keep beside; empty if nothing.
    laws: Vec<LawHistory>,
    /// Where the start of the next query begins in `words`, or its place in `simplexes`.
    starts: Vec<u32>,
    words: Vec<u64>,
    /// Starts that are kept whole.
    simplexes: Vec<Simplex>,
    /// Whether laws keep something.
    pub(super) keep_laws: bool,
}

/// The springs of a contact of parts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Springs {
    /// Tangential displacement (m).
    pub(super) tangential_displacement: Vec3,
    /// Torsional angle about the normal (rad).
    pub(super) torsional_angle: f64,
}

impl Histories {
    /// Memory (B).
    pub(super) fn bytes(&self) -> usize {
        let Self { springs, laws, starts, words, simplexes, .. } = self;
        let of_starts = heap_bytes(starts) + heap_bytes(words) + heap_bytes(simplexes);
        heap_bytes(springs) + heap_bytes(laws) + of_starts
    }

    /// Forgets all but the first ones.
    pub(super) fn truncate(&mut self, kept: usize) {
        let others = self.starts.get(kept..).unwrap_or_default();
        let word = others.iter().find(|&&start| start & WHOLE == 0).map(|&start| start as usize);
        let simplex =
            others.iter().find(|&&start| start & WHOLE != 0).map(|&start| (start & !WHOLE) as usize);
        self.words.truncate(word.unwrap_or(self.words.len()));
        self.simplexes.truncate(simplex.unwrap_or(self.simplexes.len()));
        self.springs.truncate(kept);
        self.laws.truncate(kept);
        self.starts.truncate(kept);
    }

    /// Makes room for the history of a pair whose parts have these cores, and fills it with what is known.
    pub(super) fn push(&mut self, cores: [&Core; 2], known: &ContactHistory) {
        let &ContactHistory { tangential_displacement, torsional_angle, law, simplex } = known;
        make_room(&mut self.springs, 1);
        self.springs.push(Springs { tangential_displacement, torsional_angle });
        if self.keep_laws {
            make_room(&mut self.laws, 1);
            self.laws.push(law);
        }
        make_room(&mut self.starts, 1);
        match StartForm::of(cores[0], cores[1]) {
            Some(form) => {
                let first = self.words.len();
                self.starts.push(first as u32);
                make_room(&mut self.words, form.words());
                self.words.resize(first + form.words(), 0);
                form.write(cores, &simplex, &mut self.words[first..]);
            }
            None => {
                self.starts.push(self.simplexes.len() as u32 | WHOLE);
                make_room(&mut self.simplexes, 1);
                self.simplexes.push(simplex);
            }
        }
    }

    /// Begins the history of a pair that did not touch.
    pub(super) fn begin(&mut self, pair: &mut PartPair) {
        if !pair.is_touching() {
            pair.separated_until = PartPair::TOUCHING;
            self.springs[pair.place as usize] = Springs::default();
            self.set_law(pair, &LawHistory::default());
        }
    }

    /// Springs of a pair that touches.
    #[inline(always)]
    pub(super) fn springs(&mut self, pair: &PartPair) -> &mut Springs {
        &mut self.springs[pair.place as usize]
    }

    /// What laws keep of a pair, if it touched.
    #[inline(always)]
    pub(super) fn law(&self, pair: &PartPair) -> LawHistory {
        let kept = self.laws.get(pair.place as usize).filter(|_| pair.is_touching());
        kept.copied().unwrap_or_default()
    }

    /// What the contact of a pair that touches has wound up.
    #[inline(always)]
    pub(super) fn wound(&self, pair: &PartPair) -> Wound {
        let Springs { tangential_displacement, torsional_angle } = self.springs[pair.place as usize];
        Wound { displacement: tangential_displacement, torsional_angle, angles: self.law(pair).angles }
    }

    /// Keeps what laws keep of a pair.
    #[inline(always)]
    pub(super) fn set_law(&mut self, pair: &PartPair, law: &LawHistory) {
        if let Some(kept) = self.laws.get_mut(pair.place as usize) {
            *kept = *law;
        }
    }

    /// Start of the query of a pair, cold if it did not touch; one that is kept in few words is read to `room`.
    #[inline(always)]
    pub(super) fn start<'a>(
        &'a mut self,
        pair: &PartPair,
        cores: [&Core; 2],
        room: &'a mut Simplex,
    ) -> &'a mut Simplex {
        let place = self.starts[pair.place as usize];
        if place & WHOLE != 0 {
            let whole = &mut self.simplexes[(place & !WHOLE) as usize];
            if !pair.is_touching() {
                whole.len = 0;
            }
            return whole;
        }
        room.len = 0;
        if let (true, Some(form)) = (pair.is_touching(), StartForm::of(cores[0], cores[1])) {
            form.read(cores, &self.words[place as usize..], room);
        }
        room
    }

    /// Keeps the start of the next query of a pair that was read to `room`.
    #[inline(always)]
    pub(super) fn keep_start(&mut self, pair: &PartPair, cores: [&Core; 2], room: &Simplex) {
        let place = self.starts[pair.place as usize];
        if let (0, Some(form)) = (place & WHOLE, StartForm::of(cores[0], cores[1])) {
            form.write(cores, room, &mut self.words[place as usize..]);
        }
    }

    /// Features of two cylinders that touched from which their query starts; `None` if it is cold.
    #[inline(always)]
    pub(super) fn start_of_cylinders(&self, pair: &PartPair) -> Option<CylinderMarks> {
        let first = self.starts[pair.place as usize] as usize;
        CylinderMarks::read(&self.words[first..])
    }

    /// Keeps the features of two cylinders that touch.
    #[inline(always)]
    pub(super) fn set_start_of_cylinders(&mut self, pair: &PartPair, marks: &CylinderMarks) {
        let first = self.starts[pair.place as usize] as usize;
        CylinderMarks::write(Some(marks), &mut self.words[first..]);
    }

    /// Points of two superellipsoids that touched from which their query starts, in the frames of the bodies (m); `None` if it is cold.
    #[inline(always)]
    pub(super) fn start_of_surfaces(&self, pair: &PartPair) -> Option<[Vec3; 2]> {
        let first = self.starts[pair.place as usize] as usize;
        read_surfaces(&self.words[first..])
    }

    /// Keeps the nearest points (m) of two superellipsoids, in the frames of the bodies.
    #[inline(always)]
    pub(super) fn set_start_of_surfaces(&mut self, pair: &PartPair, points: &[Vec3; 2]) {
        let first = self.starts[pair.place as usize] as usize;
        write_surfaces(points, &mut self.words[first..]);
    }

    /// What two boxes of half edges (m) touched with, from which their query starts; `None` if it is neither corner on face nor edge on edge.
    #[inline(always)]
    pub(super) fn start_of_boxes(&self, pair: &PartPair, halves: &[Vec3; 2]) -> Option<BoxStart> {
        let first = self.starts[pair.place as usize] as usize;
        BoxStart::read(halves, &self.words[first..])
    }

    /// Keeps what two boxes of half edges (m) touch with.
    #[inline(always)]
    pub(super) fn set_start_of_boxes(&mut self, pair: &PartPair, halves: &[Vec3; 2], start: &BoxStart) {
        let first = self.starts[pair.place as usize] as usize;
        start.write(halves, &mut self.words[first..]);
    }

    /// What two polyhedra touched with, from which their query starts; `None` if it is neither corner on face nor edge on edge.
    #[inline(always)]
    pub(super) fn start_of_polyhedra(
        &self,
        pair: &PartPair,
        hulls: [&Polyhedron; 2],
    ) -> Option<PolyhedronStart> {
        let first = self.starts[pair.place as usize] as usize;
        PolyhedronStart::read(hulls, &self.words[first..])
    }

    /// Keeps what two polyhedra touch with.
    #[inline(always)]
    pub(super) fn set_start_of_polyhedra(&mut self, pair: &PartPair, start: &PolyhedronStart) {
        let first = self.starts[pair.place as usize] as usize;
        start.write(&mut self.words[first..]);
    }

    /// All that is kept of a pair that touches.
    pub(super) fn of(&self, pair: &PartPair, cores: [&Core; 2]) -> ContactHistory {
        let Springs { tangential_displacement, torsional_angle } = self.springs[pair.place as usize];
        let (place, mut simplex) = (self.starts[pair.place as usize], Simplex::default());
        match StartForm::of(cores[0], cores[1]) {
            Some(form) => form.read(cores, &self.words[place as usize..], &mut simplex),
            None => simplex = self.simplexes[(place & !WHOLE) as usize],
        }
        ContactHistory { tangential_displacement, torsional_angle, law: self.law(pair), simplex }
    }
}
