//! Loads of the contacts between particles that are not both spheres.

use super::batch::PointBatch;
use super::contacts::find_contacts;
use super::ellipsoids::EllipsoidBatch;
use super::found::{Contacts, Found};
use super::histories::{Histories, Springs};
use super::list::PartPairList;
use super::pairs::PartPair;
use super::point_contact::PartPoint;
use crate::catalogue::{Catalogue, ContactTable};
use crate::contact_history::LawHistory;
use crate::contacts::{ContactPass, Kept, Overlapping, PairLaw, PatchShare, Screw, SeveralContacts, either};
use crate::films::{Partner, end_bridge, follow_bridge};
use crate::heat::TouchingParts;
use crate::narrow_phase::{PartContact, Pose};
use crate::particles::Particles;
use grains_contact::PreparedLaw;
use grains_geometry::{ContactPatch, DepthNorm};
use std::ops::Range;

/// Adds the loads of the contacts between particles that are not both spheres, of a range of the list.
///
/// Ellipsoids that touched in the last step wait for others before their distance is found, and particles that touch in one point, the
/// majority, before their loads are; sums of loads are exact in any order.
pub(crate) fn add_forces(
    particles: &mut Particles,
    (list, range): (&mut PartPairList, Range<usize>),
    pass: &mut ContactPass,
) {
    let PartPairList { pairs, histories, found, batch, ellipsoids, has_ellipsoids } = list;
    let mut forces = PairForces { particles, pairs: &mut pairs[range], histories, found, batch, pass };
    let mut start = 0;
    while start < forces.pairs.len() {
        let group = start..end_of_group(forces.pairs, start);
        start = group.end;
        if !(*has_ellipsoids && forces.leaves_to(ellipsoids, &group)) {
            forces.add_group(group);
        } else if ellipsoids.is_full() {
            forces.add_ellipsoids(ellipsoids);
        }
    }
    forces.add_ellipsoids(ellipsoids);
    forces.finish();
}

/// The pairs whose loads are added, and what that takes.
struct PairForces<'a, 'b> {
    particles: &'a mut Particles,
    pairs: &'a mut [PartPair],
    histories: &'a mut Histories,
    found: &'a mut Contacts,
    batch: &'a mut PointBatch,
    pass: &'a mut ContactPass<'b>,
}

impl PairForces<'_, '_> {
    /// Whether the pairs of two particles are one of ellipsoids, which waits for others.
    #[inline(always)]
    fn leaves_to(&self, ellipsoids: &mut EllipsoidBatch, group: &Range<usize>) -> bool {
        let Self { particles, pairs, histories, pass, .. } = self;
        let pair = (group.start, &pairs[group.start]);
        // A bridge fed by films changes these, in the order of the list.
        group.len() == 1
            && !particles.is_wet()
            && ellipsoids.takes(pair, histories, particles, pass.catalogue)
    }

    /// Adds the loads of the ellipsoids that wait.
    fn add_ellipsoids(&mut self, ellipsoids: &mut EllipsoidBatch) {
        for k in 0..ellipsoids.solve() {
            let place = ellipsoids.place(k);
            let Self { particles, pairs, histories, pass, .. } = self;
            let pair = &pairs[place];
            match ellipsoids.contact((k, pair), histories, particles, pass.catalogue) {
                Some(contact) => {
                    note_heat(pass, pair, histories, (contact.overlap, None));
                    self.add_point(place, &contact, 0.0);
                }
                None => self.add_group(place..place + 1),
            }
        }
        ellipsoids.clear();
    }

    /// Adds the loads of the pairs of two particles.
    #[inline(always)]
    fn add_group(&mut self, group: Range<usize>) {
        let Self { particles, pairs, histories, found, pass, .. } = self;
        let pairs = &mut pairs[group.clone()];
        let mut bridge = bridge_of(pairs, histories, particles);
        if let Err(error) = find_contacts(particles, pairs, histories, pass.catalogue, found) {
            pass.statistics.error = Some(error);
            return;
        }
        for item in &found.items {
            note_heat(pass, &pairs[item.place], histories, (item.contact.overlap, found.footprint(item)));
        }
        match found.items[..] {
            [] => {
                if bridge != 0.0 {
                    let [a, b] = [pairs[0].a, pairs[0].b].map(|i| i as usize);
                    let (contacts, law) = law_of(particles, [a, b], pass.catalogue);
                    let bodies = (a, Partner::Particle(b));
                    end_bridge(particles, bodies, (law, contacts), (&mut bridge, pass.liquid));
                }
            }
            [item] if found.footprint(&item).is_none() => {
                self.add_point(group.start + item.place, &item.contact, bridge);
            }
            _ => add_contacts(particles, (pairs, histories, found), &mut bridge, pass),
        }
    }

    /// Leaves the only contact of two particles, in a point, to the batch; `bridge` is the volume of their bridge (m³), if films feed it.
    #[inline(always)]
    fn add_point(&mut self, place: usize, contact: &PartContact, mut bridge: f64) {
        let pair = self.pairs[place];
        let [a, b] = [pair.a, pair.b].map(|i| i as usize);
        if !self.batch.has_room_for([a, b].map(|i| &self.particles.bodies[i])) {
            self.finish();
        }
        let Self { particles, histories, batch, pass, .. } = self;
        let films = follow(&mut bridge, -contact.overlap, [a, b], particles, pass);
        let bodies = [a, b].map(|i| &particles.bodies[i]);
        let poses = [a, b].map(|i| Pose::of(particles, i, pass.catalogue));
        let springs = histories.springs(&pair);
        springs.torsional_angle = 0.0;
        let displacement = springs.tangential_displacement;
        let mut law = histories.law(&pair);
        if particles.is_wet() {
            law.bridge = bridge;
        }
        pass.statistics.deep_penetrations += u64::from(contact.is_deep_penetration);
        batch.take((place, contact), bodies, &poses, (&displacement, &law, films), pass.catalogue);
    }

    /// Adds the loads of the contacts that wait.
    fn finish(&mut self) {
        let Self { particles, pairs, histories, batch, pass, .. } = self;
        batch.finish((pairs, histories), pass, |pass, pair, depth, loads| {
            loads.add_to(particles, [pair.a, pair.b]);
            let catalogue = pass.catalogue;
            pass.statistics.note(depth, || overlapping(particles, pair, catalogue));
        });
    }
}

/// Notes that parts of two particles overlap (m), in a point or over a patch, where heat flows between them.
#[inline(always)]
fn note_heat(
    pass: &mut ContactPass,
    pair: &PartPair,
    histories: &Histories,
    place: (f64, Option<&ContactPatch>),
) {
    if let Some(touching) = &mut pass.touching {
        let memory = histories.law(pair).memory;
        touching.push(TouchingParts::of_particles([pair.a, pair.b], place, memory));
    }
}

/// Adds the loads of all contacts of two particles that touch in several points, or over a patch.
fn add_contacts(
    particles: &mut Particles,
    (group, histories, found): (&[PartPair], &mut Histories, &Contacts),
    bridge: &mut f64,
    pass: &mut ContactPass,
) {
    let (a, b) = (group[0].a as usize, group[0].b as usize);
    let (catalogue, quanta, dt) = (pass.catalogue, pass.quanta, pass.dt);
    let films = match particles.is_wet() {
        true => {
            let depth = DepthNorm::of(found.items.iter().map(|item| item.contact.overlap)).depth;
            follow(bridge, -depth, [a, b], particles, pass)
        }
        false => 0.0,
    };
    let poses = [a, b].map(|i| Pose::of(particles, i, catalogue));
    let bodies = [a, b].map(|i| &particles.bodies[i]);
    let prepared = catalogue.contacts.prepared(bodies[0].kind.material, bodies[1].kind.material);
    let inverse_inertia = catalogue.inverse_inertia(bodies, prepared);
    let point = |item: &Found| PartPoint::of(bodies, &item.contact, inverse_inertia);
    let patch = |item: &Found| found.footprint(item).map_or(1.0, |patch| patch.weight);
    let points = found.items.iter().map(|item| (point(item), Screw::of(found.footprint(item))));
    let several = SeveralContacts::of(catalogue.sharing, found.items.len(), points);
    let inverse = |side: usize| several.inverse_mass(&poses[side], bodies[side].contact_mass(), side);
    let law = PairLaw {
        law: prepared,
        mass: 1.0 / (inverse(0) + inverse(1)),
        effective_radius: catalogue.effective_radius(bodies, prepared),
        dt,
        films,
    };
    let mut kept = several.kept(found.items.iter().map(|item| histories.law(&group[item.place])));
    if particles.is_wet() {
        kept[1] = *bridge;
    }
    let wound = several.wound(found.items.iter().map(|item| {
        let pair = &group[item.place];
        let mut law = histories.law(pair);
        let wound = kept_by(histories.springs(pair), &mut law).wound();
        (item.contact.overlap, patch(item), wound)
    }));
    let radius = poses[0].inscribed_radius().min(poses[1].inscribed_radius());
    let mut deepest = 0.0_f64;
    for item in &found.items {
        let Found { place, contact, .. } = item;
        pass.statistics.deep_penetrations += u64::from(contact.is_deep_penetration);
        deepest = deepest.max(contact.overlap);
        let pair = &group[*place];
        let (mut springs, mut history) = (*histories.springs(pair), histories.law(pair));
        if several.is_idle(contact.overlap) {
            // It bears no force.
            *histories.springs(pair) = Springs::default();
            histories.set_law(pair, &LawHistory::default());
            continue;
        }
        if several.is_one() {
            [history.memory, history.bridge] = kept;
        }
        let point = PartPoint::of([a, b].map(|i| &particles.bodies[i]), contact, inverse_inertia);
        let patch = found.footprint(item).map(|f| PatchShare { screw: Screw::of(Some(f)), second: f.second });
        let mut kept = kept_by(&mut springs, &mut history);
        if several.is_one() {
            kept.begin_with(&wound);
        }
        let loads = several.loads(&point, patch, &law, kept, &quanta);
        *histories.springs(pair) = springs;
        histories.set_law(pair, &history);
        loads.add_to(particles, [group[0].a, group[0].b]);
    }
    pass.statistics.note(deepest / radius, || overlapping(particles, &group[0], catalogue));
}

/// The law of two bodies, in the table of all.
fn law_of<'a>(
    particles: &Particles,
    bodies: [usize; 2],
    catalogue: &'a Catalogue,
) -> (&'a ContactTable, &'a PreparedLaw) {
    let [m, n] = bodies.map(|i| particles.bodies[i].kind.material);
    (&catalogue.contacts, catalogue.contacts.prepared(m, n))
}

/// The bridge of two bodies whose liquid came from films: all their contacts have the same.
fn bridge_of(group: &[PartPair], histories: &Histories, particles: &Particles) -> f64 {
    match particles.is_wet() {
        true => group.iter().fold(0.0, |bridge, pair| either(bridge, histories.law(pair).bridge)),
        false => 0.0,
    }
}

/// Lets the bridge of two bodies form or break at a gap (m), if films feed it; returns the thicknesses of their films (m).
fn follow(
    bridge: &mut f64,
    gap: f64,
    [a, b]: [usize; 2],
    particles: &mut Particles,
    pass: &mut ContactPass,
) -> f64 {
    if !particles.is_wet() {
        return 0.0;
    }
    let catalogue = pass.catalogue;
    let (contacts, law) = law_of(particles, [a, b], catalogue);
    let radii = [a, b].map(|i| catalogue.contact_radius(&particles.bodies[i], law));
    let solid = [a, b].map(|i| catalogue.solid_radius(&particles.bodies[i]));
    let (pair, of_law) = ((a, Partner::Particle(b)), (law, contacts));
    follow_bridge(particles, pair, of_law, (gap, radii, solid), (bridge, pass.liquid))
}

fn kept_by<'a>(springs: &'a mut Springs, law: &'a mut LawHistory) -> Kept<'a> {
    let Springs { tangential_displacement, torsional_angle } = springs;
    Kept { displacement: tangential_displacement, torsional_angle, history: law }
}

#[cold]
fn overlapping(particles: &Particles, pair: &PartPair, catalogue: &Catalogue) -> Overlapping {
    let (a, b) = (pair.a as usize, pair.b as usize);
    Overlapping {
        id: particles.ids[a],
        other: format!("particle {}", particles.ids[b]),
        radius: catalogue.smaller_inscribed_radius([a, b].map(|i| &particles.bodies[i])),
        position: particles.bodies[a].position,
    }
}

/// End of the pairs of the same two bodies from `start` on.
#[inline(always)]
fn end_of_group(pairs: &[PartPair], start: usize) -> usize {
    let is_other = |pair: &PartPair| !pair.is_of_same_particles(&pairs[start]);
    pairs[start + 1..].iter().position(is_other).map_or(pairs.len(), |length| start + 1 + length)
}
