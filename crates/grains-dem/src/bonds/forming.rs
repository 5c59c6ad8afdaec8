//! How bonds are made.

use super::forces::{bonded_pair, half_period};
use super::kind::{BondKind, Bonded};
use super::list::{BondList, ListedBond};
use crate::catalogue::Catalogue;
use crate::contact_history::SavedHistories;
use crate::error::StepError;
use crate::particles::Particles;
use grains_contact::BondState;
use grains_domain::Transport;

/// Steps in half the shortest period of a bond below which a bonded packing is unstable.
const FEWEST_STEPS: f64 = 5.0;

/// The kinds of bonds that are made in a step.
pub(crate) struct Forming<'a> {
    pub(crate) kinds: &'a [BondKind],
    /// Whether each of them is due.
    pub(crate) is_due: Vec<bool>,
    pub(crate) dt: f64,
}

/// Bonds made on this rank.
#[derive(Debug, Default)]
pub(crate) struct Made {
    /// Ends of owned particles.
    pub(crate) ends: u64,
    pub(crate) error: Option<StepError>,
}

impl Forming<'_> {
    /// Largest gap (m) of bounding spheres over which one is made.
    pub(crate) fn reach(&self) -> f64 {
        self.due().map(|(_, kind)| kind.distance).fold(0.0, f64::max)
    }

    fn due(&self) -> impl Iterator<Item = (usize, &BondKind)> {
        self.kinds.iter().enumerate().filter(|(k, _)| self.is_due[*k])
    }

    /// Makes a bond between owned particle `i` and `j` if one is due; returns whether it did.
    pub(crate) fn bond(
        &self,
        bonds: &mut BondList,
        particles: &Particles,
        [i, j]: [usize; 2],
        catalogue: &Catalogue,
        made: &mut Made,
    ) -> bool {
        // The particle of lower id comes first: both ranks of a pair must find the same gap, bit for bit.
        let ordered = if particles.ids[i] < particles.ids[j] { [i, j] } else { [j, i] };
        let (ids, bodies) = (ordered.map(|k| particles.ids[k]), ordered.map(|k| &particles.bodies[k]));
        let materials = bodies.map(|body| body.kind.material);
        let gap = (bodies[1].position - bodies[0].position).norm() - bodies[0].radius - bodies[1].radius;
        let is_wanted = |(_, kind): &(usize, &BondKind)| gap <= kind.distance && kind.joins(ids, materials);
        let Some((k, kind)) = self.due().find(is_wanted).filter(|_| ids[0] != ids[1]) else { return false };
        let time = half_period(kind, bodies, catalogue);
        if time < FEWEST_STEPS * self.dt {
            let [id, other] = ids;
            let dt = time / (4.0 * FEWEST_STEPS);
            made.error = made.error.take().or(Some(StepError::StiffBond { id, other, time, dt }));
        }
        bonds.push(particles, [i, j], k as u16, BondState::new(&bonded_pair(bodies, catalogue), self.dt));
        made.ends += bonds.bonds.last().map_or(0, |bond| bond.owned_ends(particles.owned));
        true
    }

    /// Whether all that was to be bonded is, on all ranks; collective.
    ///
    /// # Errors
    /// A kind that bonded nothing, a pair of a table that was not bonded.
    pub(crate) fn check(
        &self,
        bonds: &BondList,
        particles: &Particles,
        transport: &impl Transport,
    ) -> Result<(), StepError> {
        let ids = |bond: &ListedBond| bond.ends.map(|end| particles.ids[end as usize]);
        for (k, kind) in self.due() {
            // A pair that is bonded already keeps the bond it has.
            let is_wanted = |bond: &&ListedBond| match &kind.bonded {
                Bonded::Materials(_) => usize::from(bond.kind) == k,
                Bonded::Pairs(pairs) => pairs.binary_search(&ids(bond)).is_ok(),
            };
            let wanted = || bonds.bonds.iter().filter(is_wanted);
            let mut ends = [wanted().map(|bond| bond.owned_ends(particles.owned)).sum::<u64>()];
            transport.sum_counts(&mut ends);
            let count = ends[0] / 2;
            if let Bonded::Pairs(pairs) = &kind.bonded
                && count < pairs.len() as u64
            {
                let mut found = vec![0; pairs.len()];
                wanted()
                    .filter_map(|bond| pairs.binary_search(&ids(bond)).ok())
                    .for_each(|row| found[row] = 1);
                transport.sum_counts(&mut found);
                let first = found.iter().position(|&times| times == 0).unwrap_or(0);
                let missing = found.iter().filter(|&&times| times == 0).count();
                return Err(StepError::Unbonded { kind: k, pair: pairs[first], missing, pairs: pairs.len() });
            }
            if count == 0 {
                return Err(StepError::NothingBonded { kind: k, distance: kind.distance });
            }
        }
        Ok(())
    }
}

/// Whether particles of a row of `histories` and of this id are bonded.
#[inline]
pub(crate) fn are_bonded(histories: &SavedHistories, row: usize, id: u64) -> bool {
    histories.bonds.row(row).iter().any(|bond| bond.partner == id)
}
