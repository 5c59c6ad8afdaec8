//! Contacts of one pair of materials, evaluated several at a time in the lanes of the processor.

use super::lanes::{BLOCK, Columns, set, vector_at, whole_lanes};
use super::load_quanta::LoadQuanta;
use super::loads::{ContactLoads, ContactPoint};
use crate::contact_history::LawHistory;
use grains_contact::{Approach, Neighbourhood, NormalLaw, NormalVisitor, PreparedLaw, WoundAngles};
use grains_geometry::Vec3;

/// What is known of the contacts of a batch, column by column.
pub(crate) trait ContactColumns {
    type Point: ContactPoint;

    /// Contact `k` of the batch.
    fn contact(&self, k: usize) -> BatchedContact<Self::Point>;
}

/// A contact of a batch.
pub(crate) struct BatchedContact<Point> {
    pub(crate) point: Point,
    /// Effective mass at the contact point (kg).
    pub(crate) effective_mass: f64,
    /// Effective radius R1 R2/(R1 + R2) (m).
    pub(crate) effective_radius: f64,
    /// Overlap over the smaller inscribed radius (-).
    pub(crate) depth: f64,
}

/// Contacts under one law, side by side: what the law needs, and what it answers.
#[derive(Clone, Debug)]
pub(crate) struct Batch<C> {
    pub(crate) len: usize,
    /// Place of the pair in its list.
    pub(crate) pair: [u32; BLOCK],
    pub(crate) columns: C,
    /// Tangential displacements (m), before and after.
    tangential_displacements: Columns<3>,
    /// What laws keep beside them, see [`LawHistory`], before and after.
    law_histories: Columns<6>,
    /// Sum of the thicknesses of the films (m), where bridges take liquid from these.
    films: [f64; BLOCK],
    /// Pull on the first body over a gap (N), of a law that has one.
    pulls: Columns<3>,
    /// Force on the first body (N).
    forces: Columns<3>,
    /// Torques (N m).
    torques: [Columns<3>; 2],
    /// Overlap over the smaller inscribed radius (-).
    depth: [f64; BLOCK],
}

impl<C: Default> Default for Batch<C> {
    fn default() -> Self {
        let three = [[0.0; BLOCK]; 3];
        Self {
            len: 0,
            pair: [0; BLOCK],
            columns: C::default(),
            tangential_displacements: three,
            law_histories: [[0.0; BLOCK]; 6],
            films: [0.0; BLOCK],
            pulls: three,
            forces: three,
            torques: [three; 2],
            depth: [0.0; BLOCK],
        }
    }
}

impl<C> Batch<C> {
    /// Adds a contact, whose columns are set for place `len`.
    #[inline(always)]
    pub(crate) fn push(&mut self, pair: u32, tangential_displacement: &Vec3) {
        self.pair[self.len] = pair;
        set(&mut self.tangential_displacements, self.len, (*tangential_displacement).into());
        self.len += 1;
    }

    /// Sets what the law keeps of the contact added last, if it does.
    #[inline(always)]
    pub(crate) fn set_law_history(&mut self, history: &LawHistory) {
        let LawHistory { angles: WoundAngles { rolling, twisting }, memory, bridge } = history;
        let row = [rolling.x, rolling.y, rolling.z, *twisting, *memory, *bridge];
        set(&mut self.law_histories, self.len - 1, row);
    }

    /// Sets the sum of the thicknesses (m) of the films on the bodies of the contact added last.
    #[inline(always)]
    pub(crate) fn set_films(&mut self, thicknesses: f64) {
        self.films[self.len - 1] = thicknesses;
    }

    /// What the law keeps of contact `k` after the step.
    #[inline(always)]
    pub(crate) fn law_history(&self, k: usize) -> LawHistory {
        let [memory, bridge] = [4, 5].map(|column: usize| self.law_histories[column][k]);
        LawHistory { angles: angles_at(&self.law_histories, k), memory, bridge }
    }

    /// Tangential displacement (m) of contact `k` after the step.
    #[inline(always)]
    pub(crate) fn tangential_displacement(&self, k: usize) -> Vec3 {
        vector_at(&self.tangential_displacements, k)
    }

    /// Loads of contact `k`.
    #[inline(always)]
    pub(crate) fn loads(&self, k: usize) -> ContactLoads {
        let torques = [vector_at(&self.torques[0], k), vector_at(&self.torques[1], k)];
        ContactLoads { force: vector_at(&self.forces, k), torques }
    }

    /// Overlap over the smaller inscribed radius of contact `k` (-).
    #[inline(always)]
    pub(crate) fn depth(&self, k: usize) -> f64 {
        self.depth[k]
    }
}

/// The angles of a contact.
#[inline(always)]
fn angles_at(histories: &Columns<6>, k: usize) -> WoundAngles {
    WoundAngles { rolling: vector_at(histories, k), twisting: histories[3][k] }
}

#[inline(always)]
fn set_angles(histories: &mut Columns<6>, k: usize, angles: &WoundAngles) {
    let WoundAngles { rolling, twisting } = angles;
    (histories[0][k], histories[1][k], histories[2][k]) = (rolling.x, rolling.y, rolling.z);
    histories[3][k] = *twisting;
}

impl<C: ContactColumns> Batch<C> {
    /// Finds the loads of all contacts; the same arithmetic as one by one, in lanes of any width.
    #[inline(always)]
    pub(crate) fn evaluate(&mut self, law: &PreparedLaw, quanta: &LoadQuanta, dt: f64) {
        if law.attraction.is_active() {
            self.attract(law, dt);
        }
        law.normal.visit(Evaluation { batch: self, law, quanta, dt });
    }

    /// Finds the pulls over gaps, which know functions that do not go through the lanes.
    #[inline(never)]
    fn attract(&mut self, law: &PreparedLaw, dt: f64) {
        for k in 0..self.len.min(BLOCK) {
            let BatchedContact { point, effective_mass, effective_radius, .. } = self.columns.contact(k);
            let films = self.films[k];
            let at = Neighbourhood { radius: effective_radius, mass: effective_mass, dt, films };
            let bridge = &mut self.law_histories[5][k];
            let pull = law.attraction.force(&point.encounter(), &at, bridge);
            set(&mut self.pulls, k, pull.into());
        }
    }

    /// Finds the loads under the law's normal direction, with couples and with pulls over gaps, or without.
    #[inline(always)]
    fn evaluate_under<L: NormalLaw, const COUPLES: bool, const PULLS: bool>(
        &mut self,
        normal: &L,
        law: &PreparedLaw,
        quanta: &LoadQuanta,
        dt: f64,
    ) {
        let Self { columns, tangential_displacements, law_histories, pulls, forces, torques, depth, .. } =
            self;
        for k in whole_lanes(self.len) {
            let contact = columns.contact(k);
            let BatchedContact { point, effective_mass, effective_radius, .. } = &contact;
            let encounter = point.encounter();
            let approach = Approach::of(&encounter, *effective_radius, dt);
            let mut memory = if L::KEEPS_MEMORY { law_histories[4][k] } else { 0.0 };
            let now = law.under::<L, PULLS>(normal, *effective_mass, &approach, &mut memory);
            let mut displacement = vector_at(tangential_displacements, k);
            let mut force = now.force(&encounter, &mut displacement, dt);
            if PULLS {
                force += vector_at(pulls, k);
            }
            let mut loads = ContactLoads::of(point, &force, quanta);
            if COUPLES {
                let mut angles = angles_at(law_histories, k);
                loads.add_couple(&encounter, &now, (&point.rolling(), &mut angles), quanta, dt);
                set_angles(law_histories, k, &angles);
            }
            if L::KEEPS_MEMORY {
                law_histories[4][k] = memory;
            }
            set(tangential_displacements, k, displacement.into());
            set(forces, k, loads.force.into());
            set(&mut torques[0], k, loads.torques[0].into());
            set(&mut torques[1], k, loads.torques[1].into());
            depth[k] = contact.depth;
        }
    }
}

/// A batch to evaluate.
struct Evaluation<'a, C> {
    batch: &'a mut Batch<C>,
    law: &'a PreparedLaw,
    quanta: &'a LoadQuanta,
    dt: f64,
}

impl<C: ContactColumns> NormalVisitor for Evaluation<'_, C> {
    type Output = ();

    #[inline(always)]
    fn with<L: NormalLaw>(self, normal: &L) {
        let Self { batch, law, quanta, dt } = self;
        match (law.has_couples(), law.attraction.is_active()) {
            (false, false) => batch.evaluate_under::<L, false, false>(normal, law, quanta, dt),
            (true, false) => batch.evaluate_under::<L, true, false>(normal, law, quanta, dt),
            (_, true) => batch.evaluate_under::<L, true, true>(normal, law, quanta, dt),
        }
    }
}
