//! Loads of wall contacts: the law of particles, against a body of infinite mass.

use super::contacts::{Approach, find_contacts, find_contacts_of_sphere, not_found};
use super::list::WallList;
use super::pairs::{WallPair, WallScene};
use super::seams::hand_over_history;
use super::surface_contact::SurfaceContact;
use super::wall::WallSums;
use super::wall_point::WallPoint;
use crate::catalogue::Catalogue;
use crate::contact_history::LawHistory;
use crate::contacts::{
    ContactPass, ContactPoint, Kept, Overlapping, PairLaw, PatchShare, Screw, SeveralContacts, Wound, either,
};
use crate::films::{Partner, end_bridge, follow_bridge};
use crate::heat::TouchingParts;
use crate::narrow_phase::Pose;
use crate::particles::Particles;
use grains_geometry::{DepthNorm, GjkError, Vec3};
use std::ops::Range;

/// Adds the loads of all wall contacts to particles and walls.
///
/// Contacts of spheres wait for others like them; sums of loads are exact in any order.
pub(crate) fn add_forces(
    particles: &mut Particles,
    list: &mut WallList,
    scene: &WallScene,
    sums: &mut WallSums,
    pass: &mut ContactPass,
) {
    for group in 0..list.groups.len() {
        let Some(approach) = Approach::of(particles, (list, group), scene, pass.catalogue) else { continue };
        let added = match approach.is_sphere() {
            true => add_sphere(particles, (list, group, &approach), (scene, sums), pass),
            false => add_body(particles, (list, group, &approach), (scene, sums), pass),
        };
        if let Err(reason) = added {
            let first = list.groups[group].pairs().start;
            pass.statistics.error = Some(not_found(particles, &list.pairs[first], scene, &reason));
            return;
        }
    }
    let WallList { pairs, laws, batch, .. } = list;
    batch.finish(particles, (pairs, laws), (scene, sums), pass);
}

/// Lets the contacts of a sphere with one surface wait; those that waited are added where there is no more room.
fn add_sphere(
    particles: &mut Particles,
    (list, group, approach): (&mut WallList, usize, &Approach),
    (scene, sums): (&WallScene, &mut WallSums),
    pass: &mut ContactPass,
) -> Result<(), GjkError> {
    let catalogue = pass.catalogue;
    find_contacts_of_sphere(list, group, approach, scene, catalogue)?;
    if list.looked_at.len() > 1 && list.looked_at.iter().any(|(_, touch)| touch.is_none()) {
        // One of them may have ended.
        let (pairs, start) = (list.groups[group].pairs(), list.groups[group].pairs().start);
        let WallList { pairs: all, laws, looked_at, .. } = list;
        let laws = laws.get_mut(pairs.clone()).unwrap_or_default();
        let normal = |k: usize| {
            let (_, touch) = looked_at.iter().find(|(pair, _)| *pair == start + k)?;
            touch.map(|touch| touch.normal)
        };
        hand_over_history((&mut all[pairs], laws), normal, scene);
    }
    let Approach { body, wall, position, .. } = approach;
    let materials = [body.kind.material, wall.material];
    let law = catalogue.contacts.prepared(materials[0], materials[1]);
    let bodies = (approach.particle, Partner::Wall(materials[1]));
    let WallList { pairs, laws, looked_at, batch, .. } = list;
    for (pair, touch) in looked_at.iter() {
        let Some(touch) = touch else {
            if let Some(history) = laws.get_mut(*pair).filter(|law| law.bridge != 0.0) {
                let of_law = (law, &catalogue.contacts);
                end_bridge(particles, bodies, of_law, (&mut history.bridge, pass.liquid));
            }
            forget(&mut pairs[*pair], laws.get_mut(*pair));
            continue;
        };
        if !batch.has_room_for(materials) {
            batch.finish(particles, (pairs, laws), (scene, sums), pass);
        }
        let mut films = 0.0;
        if let Some(history) = laws.get_mut(*pair).filter(|_| particles.is_wet()) {
            let place = (-touch.overlap, [body.radius, f64::INFINITY], [body.radius; 2]);
            let of_law = (law, &catalogue.contacts);
            films = follow_bridge(particles, bodies, of_law, place, (&mut history.bridge, pass.liquid));
        }
        let of_pair = (*pair, &pairs[*pair], laws.get(*pair));
        batch.take(of_pair, (body, position), touch, scene, (materials, law, films));
    }
    Ok(())
}

/// Adds the loads of the contacts of another body with one surface.
fn add_body(
    particles: &mut Particles,
    (list, group, approach): (&mut WallList, usize, &Approach),
    (scene, sums): (&WallScene, &mut WallSums),
    pass: &mut ContactPass,
) -> Result<(), GjkError> {
    let catalogue = pass.catalogue;
    find_contacts(particles, list, group, approach, scene, catalogue)?;
    let group = list.groups[group].pairs();
    let parts = touching_parts(list, group.clone(), scene);
    let mut bridge = bridge_of(list, group.clone(), particles);
    let films = follow(&mut bridge, parts, (list, group.clone()), (particles, scene), pass);
    if parts == 0 {
        group.for_each(|k| forget(&mut list.pairs[k], list.laws.get_mut(k)));
        return Ok(());
    }
    if let (Some(touching), Some(_)) = (&mut pass.touching, approach.wall.heat) {
        let found = list.touching.iter().zip(group.clone());
        let touches = found.filter_map(|(contact, k)| {
            let (contact, pair) = (contact.as_ref()?, &list.pairs[k]);
            let memory = list.laws.get(k).map_or(0.0, |law| law.memory);
            let place = (contact.overlap, contact.footprint.as_ref());
            Some(TouchingParts::at_wall((pair.particle, pair.wall), place, memory))
        });
        touching.extend(touches);
    }
    let first = &list.pairs[group.start];
    let body = &particles.bodies[first.particle as usize];
    let center = approach.position;
    let law = catalogue.contacts.prepared(body.kind.material, approach.wall.material);
    let inverse_inertia = catalogue.inverse_inertia([body], law);
    let effective_radius = catalogue.contact_radius(body, law);
    let mut law = PairLaw { law, mass: body.mass, effective_radius, dt: pass.dt, films };
    let touching = (first, &list.touching[..], parts);
    let several = together(particles, touching, &center, (&mut law, scene), catalogue);
    let laws = list.laws.get(group.clone()).unwrap_or_default().iter();
    let mut kept = several.is_one().then(|| several.kept(laws.copied()));
    if let Some(kept) = kept.as_mut().filter(|_| particles.is_wet()) {
        kept[1] = bridge;
    }
    let wound = wound(&several, list, group.clone());
    for k in group.clone() {
        let contact = list.touching[k - group.start].filter(|contact| !several.is_idle(contact.overlap));
        let Some(contact) = contact else {
            forget(&mut list.pairs[k], list.laws.get_mut(k));
            continue;
        };
        let (pair, mut history) = (&mut list.pairs[k], list.laws.get(k).copied().unwrap_or_default());
        [history.memory, history.bridge] = kept.unwrap_or([history.memory, history.bridge]);
        if several.is_one() {
            kept_by(pair, &mut history).begin_with(&wound);
        }
        let met = (pair, &mut history, &contact, &center);
        add_contact(particles, met, (scene, sums), (&several, &law, inverse_inertia), pass);
        if let Some(kept) = list.laws.get_mut(k) {
            *kept = history;
        }
    }
    Ok(())
}

/// The bridge of a body and a surface whose liquid came from films: all their contacts have the same.
fn bridge_of(list: &WallList, group: Range<usize>, particles: &Particles) -> f64 {
    let laws = list.laws.get(group).filter(|_| particles.is_wet()).unwrap_or_default();
    laws.iter().fold(0.0, |bridge, law| either(bridge, law.bridge))
}

/// Lets the bridge of a body and a surface form or break, if films feed it; returns the thicknesses of the films (m).
fn follow(
    bridge: &mut f64,
    parts: usize,
    (list, group): (&WallList, Range<usize>),
    (particles, scene): (&mut Particles, &WallScene),
    pass: &mut ContactPass,
) -> f64 {
    if !particles.is_wet() {
        return 0.0;
    }
    let first = &list.pairs[group.start];
    let (i, wall) = (first.particle as usize, scene.walls[first.wall as usize].material);
    let (catalogue, body) = (pass.catalogue, &particles.bodies[i]);
    let bodies = (i, Partner::Wall(wall));
    if parts == 0 && *bridge == 0.0 {
        return 0.0;
    }
    let law = catalogue.contacts.prepared(body.kind.material, wall);
    let of_law = (law, &catalogue.contacts);
    if parts == 0 {
        end_bridge(particles, bodies, of_law, (bridge, pass.liquid));
        return 0.0;
    }
    let depth = DepthNorm::of(list.touching.iter().flatten().map(|contact| contact.overlap)).depth;
    let radii = [catalogue.contact_radius(body, law), f64::INFINITY];
    let place = (-depth, radii, [catalogue.solid_radius(body); 2]);
    follow_bridge(particles, bodies, of_law, place, (bridge, pass.liquid))
}

/// Forgets a contact that ended.
#[inline(always)]
fn forget(pair: &mut WallPair, law: Option<&mut LawHistory>) {
    pair.reset_displacements();
    if let Some(law) = law {
        *law = LawHistory::default();
    }
}

/// What the contacts of a particle with one surface have wound up together.
fn wound(several: &SeveralContacts, list: &WallList, group: Range<usize>) -> Wound {
    several.wound(group.clone().filter_map(|k| {
        let contact = list.touching[k - group.start].as_ref()?;
        let WallPair { tangential_displacement: displacement, torsional_angle, .. } = list.pairs[k];
        let angles = list.laws.get(k).copied().unwrap_or_default().angles;
        let patch = contact.footprint.as_ref().map_or(1.0, |f| f.weight);
        Some((contact.overlap, patch, Wound { displacement, torsional_angle, angles }))
    }))
}

fn kept_by<'a>(pair: &'a mut WallPair, history: &'a mut LawHistory) -> Kept<'a> {
    Kept {
        displacement: &mut pair.tangential_displacement,
        torsional_angle: &mut pair.torsional_angle,
        history,
    }
}

/// The contacts of a particle with one surface together; their law gets their mass.
fn together(
    particles: &Particles,
    (pair, touching, parts): (&WallPair, &[Option<SurfaceContact>], usize),
    center: &Vec3,
    (law, scene): (&mut PairLaw, &WallScene),
    catalogue: &Catalogue,
) -> SeveralContacts {
    let (i, w) = (pair.particle as usize, pair.wall as usize);
    let (state, body) = (&scene.states[w], &particles.bodies[i]);
    let points = touching
        .iter()
        .flatten()
        .map(|found| (WallPoint::of((body, center), state, found, 0.0), Screw::of(found.footprint.as_ref())));
    let several = SeveralContacts::of(catalogue.sharing, parts, points);
    let pose = Pose::of(particles, i, catalogue);
    law.mass = 1.0 / several.inverse_mass(&pose, body.mass, 0);
    several
}

/// Adds the load of one contact of a particle whose image is at `center` (m).
#[inline]
fn add_contact(
    particles: &mut Particles,
    (pair, history, found, center): (&mut WallPair, &mut LawHistory, &SurfaceContact, &Vec3),
    (scene, sums): (&WallScene, &mut WallSums),
    (several, law, inverse_inertia): (&SeveralContacts, &PairLaw, f64),
    pass: &mut ContactPass,
) {
    let (i, w) = (pair.particle as usize, pair.wall as usize);
    let (wall, state, body) = (&scene.walls[w], &scene.states[w], &particles.bodies[i]);
    let contact = WallPoint::of((body, center), state, found, inverse_inertia);
    let point = center + contact.arm;
    let quanta = &pass.quanta;
    let patch = found.footprint.as_ref().map(|patch| PatchShare {
        screw: Screw::of(Some(patch)),
        second: state.rotation * patch.second * state.rotation.transpose(),
    });
    let loads = several.loads(&contact, patch, law, kept_by(pair, history), quanta);
    let radius = pass.catalogue.inscribed_radius(body);
    pass.statistics.note(found.overlap / radius, || {
        let other = format!("wall `{}`", wall.name);
        Overlapping { id: particles.ids[i], other, radius, position: body.position }
    });
    let load = &mut particles.loads[i];
    load.force += loads.force;
    load.torque += loads.torques[0];
    sums.add(pair.wall, &loads, &point, quanta);
    if sums.sliding.counts(pair.wall) {
        let surface = &wall.surfaces[usize::from(pair.surface)];
        let worn = (&*pair, surface.worn_element(pair.element, &found.point));
        sums.sliding.note(worn, &contact.encounter(), &loads.force, pass.dt);
    }
}

/// Number of parts of the particle that touch; each part's history follows its contacts.
fn touching_parts(list: &mut WallList, group: Range<usize>, scene: &WallScene) -> usize {
    let (mut parts, mut start) = (0, group.start);
    while start < group.end {
        let end = list.part_end(start, group.end);
        let touching = &list.touching[start - group.start..end - group.start];
        parts += usize::from(touching.iter().any(Option::is_some));
        if end > start + 1 {
            let laws = list.laws.get_mut(start..end).unwrap_or_default();
            let normal = |k: usize| touching[k].as_ref().map(|contact: &SurfaceContact| contact.normal);
            hand_over_history((&mut list.pairs[start..end], laws), normal, scene);
        }
        start = end;
    }
    parts
}
