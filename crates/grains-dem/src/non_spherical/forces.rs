//! Loads of the contacts between particles that are not both spheres.

use super::batch::PointBatch;
use super::contacts::find_contacts;
use super::found::{Contacts, Found};
use super::list::PartPairList;
use super::pairs::{Histories, PartPair};
use super::point_contact::PartPoint;
use crate::catalogue::{Catalogue, ContactTable};
use crate::contact_history::ContactHistory;
use crate::contacts::{ContactPass, Kept, Overlapping, PairLaw, PatchShare, Screw, SeveralContacts, either};
use crate::films::{Partner, end_bridge, follow_bridge};
use crate::heat::TouchingParts;
use crate::narrow_phase::Pose;
use crate::particles::Particles;
use grains_contact::PreparedLaw;
use grains_geometry::DepthNorm;
use std::ops::Range;

/// Adds the loads of the contacts between particles that are not both spheres, of a range of the list.
///
/// Particles that touch in one point, the majority, wait for others like them; sums of loads are exact in any order.
pub(crate) fn add_forces(
    particles: &mut Particles,
    (list, range): (&mut PartPairList, Range<usize>),
    pass: &mut ContactPass,
) {
    let PartPairList { pairs, histories, found, batch } = list;
    let pairs = &mut pairs[range];
    let catalogue = pass.catalogue;
    let mut start = 0;
    while start < pairs.len() {
        let group = start..end_of_group(pairs, start);
        start = group.end;
        let mut bridge = bridge_of(&pairs[group.clone()], histories, particles);
        if let Err(error) = find_contacts(particles, &mut pairs[group.clone()], histories, catalogue, found) {
            pass.statistics.error = Some(error);
            continue;
        }
        if let Some(touching) = &mut pass.touching {
            let touches = found.items.iter().map(|item| {
                let pair = &pairs[group.start + item.place];
                let memory = histories.law_of(pair).memory;
                let place = (item.contact.overlap, found.footprint(item));
                TouchingParts::of_particles([pair.a, pair.b], place, memory)
            });
            touching.extend(touches);
        }
        let pair = pairs[group.start];
        let (a, b) = (pair.a as usize, pair.b as usize);
        match &found.items[..] {
            [] => {
                if bridge != 0.0 {
                    let (contacts, law) = law_of(particles, [a, b], catalogue);
                    let bodies = (a, Partner::Particle(b));
                    end_bridge(particles, bodies, (law, contacts), (&mut bridge, pass.liquid));
                }
            }
            [item] if found.footprint(item).is_none() => {
                if !batch.has_room_for([a, b].map(|i| &particles.bodies[i])) {
                    finish(batch, (pairs, histories), particles, pass);
                }
                let films = follow(&mut bridge, -item.contact.overlap, [a, b], particles, pass);
                let bodies = [a, b].map(|i| &particles.bodies[i]);
                let poses = [a, b].map(|i| Pose::of(particles, i, catalogue));
                let place = group.start + item.place;
                let history = histories.of(&mut pairs[place]);
                history.torsional_angle = 0.0;
                if particles.is_wet() {
                    history.law.bridge = bridge;
                }
                pass.statistics.deep_penetrations += u64::from(item.contact.is_deep_penetration);
                batch.take((place, &item.contact), bodies, &poses, (history, films), catalogue);
            }
            _ => add_contacts(particles, (&mut pairs[group], histories, found), &mut bridge, pass),
        }
    }
    finish(batch, (pairs, histories), particles, pass);
}

/// Adds the loads of the contacts that wait.
fn finish(
    batch: &mut PointBatch,
    waiting: (&mut [PartPair], &mut Histories),
    particles: &mut Particles,
    pass: &mut ContactPass,
) {
    batch.finish(waiting, pass, |pass, pair, depth, loads| {
        loads.add_to(particles, [pair.a, pair.b]);
        let catalogue = pass.catalogue;
        pass.statistics.note(depth, || overlapping(particles, pair, catalogue));
    });
}

/// Adds the loads of all contacts of two particles that touch in several points, or over a patch.
fn add_contacts(
    particles: &mut Particles,
    (group, histories, found): (&mut [PartPair], &mut Histories, &Contacts),
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
    let mut kept = several.kept(found.items.iter().map(|item| histories.of(&mut group[item.place]).law));
    if particles.is_wet() {
        kept[1] = *bridge;
    }
    let wound = several.wound(found.items.iter().map(|item| {
        let wound = kept_by(histories.of(&mut group[item.place])).wound();
        (item.contact.overlap, patch(item), wound)
    }));
    let radius = poses[0].inscribed_radius().min(poses[1].inscribed_radius());
    let mut deepest = 0.0_f64;
    for item in &found.items {
        let Found { place, contact, .. } = item;
        pass.statistics.deep_penetrations += u64::from(contact.is_deep_penetration);
        deepest = deepest.max(contact.overlap);
        let history = histories.of(&mut group[*place]);
        if several.is_idle(contact.overlap) {
            history.rest();
            continue;
        }
        if several.is_one() {
            [history.law.memory, history.law.bridge] = kept;
        }
        let point = PartPoint::of([a, b].map(|i| &particles.bodies[i]), contact, inverse_inertia);
        let patch = found.footprint(item).map(|f| PatchShare { screw: Screw::of(Some(f)), second: f.second });
        let mut kept = kept_by(history);
        if several.is_one() {
            kept.begin_with(&wound);
        }
        let loads = several.loads(&point, patch, &law, kept, &quanta);
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
        true => group.iter().fold(0.0, |bridge, pair| either(bridge, histories.law_of(pair).bridge)),
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

fn kept_by(history: &mut ContactHistory) -> Kept<'_> {
    Kept {
        displacement: &mut history.tangential_displacement,
        torsional_angle: &mut history.torsional_angle,
        history: &mut history.law,
    }
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
