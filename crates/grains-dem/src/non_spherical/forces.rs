//! Loads of the contacts between particles that are not both spheres.

use super::batch::PointBatch;
use super::contacts::find_contacts;
use super::found::{Contacts, Found};
use super::histories::{Histories, Springs};
use super::list::PartPairList;
use super::pairs::PartPair;
use super::point_contact::PartPoint;
use super::window::Window;
use crate::catalogue::{Catalogue, ContactTable, FaceContact};
use crate::contact_history::LawHistory;
use crate::contacts::{ContactPass, Kept, Overlapping, PairLaw, PatchShare, Screw, SeveralContacts, either};
use crate::films::{Partner, end_bridge, follow_bridge};
use crate::heat::TouchingParts;
use crate::narrow_phase::{PartContact, Pose};
use crate::particles::Particles;
use grains_contact::PreparedLaw;
use grains_geometry::{ContactPatch, DepthNorm, Vec3};
use std::ops::Range;

/// Adds the loads of the contacts between particles that are not both spheres, of a range of the list.
///
/// The distances of some parts that touched in the last step are found together for a window of the list, and particles that touch in one
/// point, the majority, wait for others before their loads are found; sums of loads are exact in any order.
pub(crate) fn add_forces(
    particles: &mut Particles,
    (list, range): (&mut PartPairList, Range<usize>),
    pass: &mut ContactPass,
) {
    let PartPairList { pairs, histories, found, batch, window, has_windows } = list;
    let mut forces = PairForces { particles, pairs: &mut pairs[range], histories, found, batch, pass };
    let mut start = 0;
    while let Some(group) = forces.next_group(window, *has_windows, &mut start) {
        forces.add_group(group, has_windows.then_some(&mut **window));
    }
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
    /// Contact of a lone pair of parts that the window has, from the centre of the first part, and that centre (m); none where faces and films
    /// matter.
    #[inline(always)]
    fn contact_in(&mut self, window: &mut Window, place: usize) -> Option<(PartContact, Vec3)> {
        let Self { particles, pairs, histories, pass, .. } = self;
        let is_plain = pass.catalogue.faces != FaceContact::MultiPoint && !particles.is_wet();
        is_plain.then(|| window.contact(&pairs[place], histories)).flatten()
    }

    /// The next pairs of two particles from `start` on; `has_windows` leaves out those that are known to be apart.
    #[inline(always)]
    fn next_group(&self, window: &mut Window, has_windows: bool, start: &mut usize) -> Option<Range<usize>> {
        let Self { particles, pairs, histories, pass, .. } = self;
        if has_windows {
            while *start < pairs.len() && !window.has_groups() {
                *start = window.fill(pairs, *start, histories, particles, pass.catalogue);
            }
            return window.next_group();
        }
        let first = pairs.get(*start)?;
        let group = *start..*start + first.number_of_same_particles(&pairs[*start..]);
        *start = group.end;
        Some(group)
    }

    /// Adds the loads of the pairs of two particles.
    #[inline(always)]
    fn add_group(&mut self, group: Range<usize>, mut window: Option<&mut Window>) {
        if let Some(window) = &mut window
            && group.len() == 1
            && let Some((mut contact, offset)) = self.contact_in(window, group.start)
        {
            contact.point += offset;
            note_heat(self.pass, &self.pairs[group.start], self.histories, (contact.overlap, None));
            self.add_point(group.start, &contact, 0.0);
            return;
        }
        let Self { particles, pairs, histories, found, pass, .. } = self;
        let pairs = &mut pairs[group.clone()];
        let mut bridge = bridge_of(pairs, histories, particles);
        if let Err(error) = find_contacts(particles, pairs, histories, pass.catalogue, (found, window)) {
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
        let law = histories.keep_laws.then(|| {
            let law = histories.law(&pair);
            if particles.is_wet() { LawHistory { bridge, ..law } } else { law }
        });
        pass.statistics.deep_penetrations += u64::from(contact.is_deep_penetration);
        batch.take((place, contact), bodies, &poses, (&displacement, law.as_ref(), films), pass.catalogue);
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
        (item.contact.overlap, patch(item), histories.wound(pair))
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
#[inline(always)]
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
