//! Loads of wall contacts: the law of particles, against a body of infinite mass.

use super::contacts::{find_contacts, not_found};
use super::motion::WallState;
use super::pairs::{WallList, WallPair, WallScene};
use super::surface_contact::SurfaceContact;
use super::wall::WallLoad;
use crate::catalogue::Catalogue;
use crate::contact_history::LawHistory;
use crate::contacts::{ContactLoads, ContactPass, ContactPoint, Overlapping, PairLaw, SeveralContacts};
use crate::narrow_phase::Pose;
use crate::particles::{Body, Particles};
use grains_contact::{Encounter, RollingContact};
use grains_geometry::Vec3;
use std::ops::Range;

/// The point in which a particle touches a wall.
struct WallPoint {
    /// Unit normal into the wall (-).
    normal: Vec3,
    /// Overlap (m).
    overlap: f64,
    /// The point from the centre of mass of the particle (m).
    arm: Vec3,
    /// Velocities of the particle's centre and of the wall at the point (m/s).
    velocities: [Vec3; 2],
    /// Angular velocities of both (rad/s).
    spins: [Vec3; 2],
    /// Largest inverse moment of inertia of the particle (1/(kg m²)).
    inverse_inertia: f64,
}

impl WallPoint {
    /// A contact that was found, of a body whose image is at `center` (m).
    #[inline(always)]
    fn of(
        (body, center): (&Body, &Vec3),
        state: &WallState,
        found: &SurfaceContact,
        inverse_inertia: f64,
    ) -> Self {
        let arm = state.to_world(&(found.point - state.to_wall(center)));
        Self {
            normal: state.to_world(&found.normal),
            overlap: found.overlap,
            arm,
            velocities: [body.velocity, state.velocity_at(&(center + arm))],
            spins: [body.angular_velocity, state.angular_velocity],
            inverse_inertia,
        }
    }
}

impl ContactPoint for WallPoint {
    #[inline(always)]
    fn encounter(&self) -> Encounter {
        let Self { normal, overlap, arm, velocities: [v, wall_v], spins: [w, wall_w], .. } = *self;
        Encounter { normal, overlap, velocity: wall_v - (v + w.cross(&arm)), spin: w - wall_w }
    }

    /// That on the wall, which is about the origin, is left out: the second torque is that of couples alone.
    #[inline(always)]
    fn torques(&self, force: &Vec3) -> [Vec3; 2] {
        [self.arm.cross(force), Vec3::zeros()]
    }

    #[inline(always)]
    fn rolling(&self) -> RollingContact {
        RollingContact { effective_radius: self.arm.norm(), inverse_inertia: self.inverse_inertia }
    }
}

/// Adds the loads of all wall contacts to particles and walls.
pub(crate) fn add_forces(
    particles: &mut Particles,
    list: &mut WallList,
    scene: &WallScene,
    wall_loads: &mut [WallLoad],
    pass: &mut ContactPass,
) {
    let catalogue = pass.catalogue;
    let mut start = 0;
    while start < list.pairs.len() {
        let end = list.group_end(start);
        if let Err(reason) = find_contacts(particles, list, start..end, scene, catalogue) {
            pass.statistics.error = Some(not_found(particles, &list.pairs[start], scene, &reason));
            return;
        }
        let parts = touching_parts(list, start..end, scene);
        let first = &list.pairs[start];
        let body = &particles.bodies[first.particle as usize];
        let center = scene.center(first, &body.position, &list.shifts);
        let law = catalogue.contacts.prepared(body.kind.material, scene.walls[first.wall as usize].material);
        let inverse_inertia = catalogue.inverse_inertia([body], law);
        let effective_radius = catalogue.contact_radius(body, law);
        let mut law = PairLaw { law, mass: body.mass, effective_radius, dt: pass.dt };
        let several = (parts > 0 && !catalogue.shape(body.kind).is_sphere()).then(|| {
            let touching = (first, &list.touching[..], parts);
            together(particles, touching, &center, (&mut law, scene), catalogue)
        });
        let kept = several.as_ref().filter(|several| several.is_one());
        let kept = kept.map(|several| {
            let laws = list.laws.get(start..end).unwrap_or_default().iter();
            several.memory(laws.map(|law| law.memory))
        });
        for (k, contact) in (start..end).zip(&list.touching) {
            let (pair, mut history) = (&mut list.pairs[k], list.laws.get(k).copied().unwrap_or_default());
            match contact {
                Some(contact) if !several.as_ref().is_some_and(|all| all.is_idle(contact.overlap)) => {
                    history.memory = kept.unwrap_or(history.memory);
                    let load = &mut wall_loads[pair.wall as usize];
                    let met = (pair, &mut history, contact, &center);
                    let law = (several.as_ref(), &law, inverse_inertia);
                    add_contact(particles, met, (scene, load), law, pass);
                }
                _ => {
                    pair.reset_displacements();
                    history = LawHistory::default();
                }
            }
            if let Some(kept) = list.laws.get_mut(k) {
                *kept = history;
            }
        }
        start = end;
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
    let points = touching.iter().flatten().map(|found| {
        (WallPoint::of((body, center), state, found, 0.0), found.footprint.as_ref().map_or(1.0, |f| f.weight))
    });
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
    (scene, wall_load): (&WallScene, &mut WallLoad),
    (several, law, inverse_inertia): (Option<&SeveralContacts>, &PairLaw, f64),
    pass: &mut ContactPass,
) {
    let (i, w) = (pair.particle as usize, pair.wall as usize);
    let (wall, state, body) = (&scene.walls[w], &scene.states[w], &particles.bodies[i]);
    let contact = WallPoint::of((body, center), state, found, inverse_inertia);
    let point = center + contact.arm;
    let (quanta, dt) = (&pass.quanta, pass.dt);
    let weight = found.footprint.as_ref().map_or(1.0, |patch| patch.weight);
    let (encounter, law) = match several {
        Some(several) => several.one(&contact, weight, law, &mut history.memory),
        None => {
            let encounter = contact.encounter();
            (encounter, law.of(&encounter, &mut history.memory))
        }
    };
    let displacement = &mut pair.tangential_displacement;
    let mut loads = ContactLoads::of(&contact, &encounter, &law, displacement, quanta, dt);
    if law.has_couples() {
        loads.add_couple(&encounter, &law, (&contact.rolling(), &mut history.angles), quanta, dt);
    }
    if let Some(patch) = &found.footprint {
        let second = state.rotation * patch.second * state.rotation.transpose();
        loads.add_patch(&encounter, &law, (&second, &mut pair.torsional_angle), quanta, dt);
    }
    let radius = pass.catalogue.inscribed_radius(body);
    pass.statistics.note(found.overlap / radius, || {
        let other = format!("wall `{}`", wall.name);
        Overlapping { id: particles.ids[i], other, radius, position: body.position }
    });
    let load = &mut particles.loads[i];
    load.force += loads.force;
    load.torque += loads.torques[0];
    wall_load.force -= loads.force;
    wall_load.torque += loads.torques[1] - quanta.torque(&point.cross(&loads.force));
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
            hand_over_history((&mut list.pairs[start..end], laws), touching, scene);
        }
        start = end;
    }
    parts
}

/// Gives the history of a contact that ended to one that began beside it on the same surface, as when a
/// ball rolls from one triangle of a flat floor to the next.
fn hand_over_history(
    (pairs, laws): (&mut [WallPair], &mut [LawHistory]),
    touching: &[Option<SurfaceContact>],
    scene: &WallScene,
) {
    let surface = &scene.walls[pairs[0].wall as usize].surfaces[pairs[0].surface as usize];
    for k in 0..pairs.len() {
        let has_history = |l: usize| {
            pairs[l].tangential_displacement != Vec3::zeros()
                || laws.get(l).is_some_and(|law| !law.is_empty())
        };
        let Some(contact) = touching[k] else { continue };
        if has_history(k) {
            continue;
        }
        let orphan = (0..pairs.len()).find(|&l| {
            touching[l].is_none()
                && has_history(l)
                && surface.goes_on(pairs[l].element, pairs[k].element, &contact.normal)
        });
        if let Some(l) = orphan {
            (pairs[k].tangential_displacement, pairs[k].torsional_angle) =
                (pairs[l].tangential_displacement, pairs[l].torsional_angle);
            pairs[l].reset_displacements();
            if let Some(law) = laws.get_mut(l).map(std::mem::take) {
                laws[k] = law;
            }
        }
    }
}
