//! Contacts between bodies that are not both spheres: GJK on their cores, part by part.

use crate::catalogue::FaceContact;
use crate::error::vector;
use crate::forces::{LoadLattice, Tally};
use crate::integrate::inverse_mass_along;
use crate::walls::SurfaceContact;
use crate::{Catalogue, Load, Particles, StepError};
use grains_contact::{Coefficients, Contact, Spread};
use grains_geometry::epa::penetration;
use grains_geometry::gjk::{Separation, distance};
use grains_geometry::obb::boxes_apart;
use grains_geometry::{Core, DiscreteSurface, Footprint, GjkError, Mat3, Placement, Shape, Simplex, Vec3};

/// A part of a particle where it is now.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedPart<'a> {
    pub(crate) core: &'a Core,
    /// Half edges of the box around the part at scale 1 (m).
    pub(crate) half_extents: &'a Vec3,
    /// Rotation from the part's frame.
    pub(crate) rotation: Mat3,
    pub(crate) scale: f64,
    /// Part centre from the particle's centre of mass, in the world frame (m).
    pub(crate) offset: Vec3,
    /// Crust (m), scaled.
    pub(crate) crust: f64,
    /// Radius of a ball about the part's centre that holds it (m), scaled.
    pub(crate) bounding_radius: f64,
    /// Vertices that find contacts in place of the core (Srinivasan 2019, section 2.4).
    pub(crate) vertices: Option<&'a DiscreteSurface>,
}

impl<'a> PlacedPart<'a> {
    pub(crate) fn of(shape: &'a Shape, part: u16, frame: &Mat3, scale: f64) -> Self {
        let is_alone = shape.parts.len() == 1;
        let part = &shape.parts[part as usize];
        // Round bodies and boxes are centred on their principal axes; polyhedra have a box of their own.
        let (rotation, offset) = if is_alone && !matches!(part.core, Core::Polyhedron(_)) {
            (*frame, Vec3::zeros())
        } else {
            (frame * part.rotation, frame * part.center * scale)
        };
        let crust = part.crust * scale;
        let (bounding_radius, vertices) = (part.bounding_radius * scale, shape.discrete.as_deref());
        Self {
            core: &part.core,
            half_extents: &part.half_extents,
            rotation,
            scale,
            offset,
            crust,
            bounding_radius,
            vertices,
        }
    }

    /// Point of the core farthest along a direction, from the part's centre (m).
    pub(crate) fn farthest(&self, direction: &Vec3) -> Vec3 {
        self.rotation * self.core.support(&self.rotation.tr_mul(direction)) * self.scale
    }

    /// Point of the core farthest from an axis through the origin, the part's centre being at `center`:
    /// the point from that centre, its unit direction away from the axis, and its distance (m).
    ///
    /// Each pass asks for the point farthest along the last one's direction; the distance can only grow.
    pub(crate) fn farthest_from_axis(&self, center: &Vec3, axis: &Vec3) -> (Vec3, Vec3, f64) {
        let away = |p: &Vec3| {
            let off = p - axis * p.dot(axis);
            (off, off.norm())
        };
        let (mut off, mut distance) = away(center);
        let mut best = Vec3::zeros();
        for _ in 0..20 {
            let direction =
                if distance > 0.0 { off / distance } else { axis.cross(&Vec3::new(0.36, 0.48, 0.8)) };
            let point = self.farthest(&direction);
            let (next, next_distance) = away(&(center + point));
            let settled = next_distance <= distance * (1.0 + 1e-15) && best != Vec3::zeros();
            (best, off, distance) = (point, next, next_distance);
            if settled {
                break;
            }
        }
        (best, if distance > 0.0 { off / distance } else { Vec3::zeros() }, distance)
    }

    /// Contact of the core point `deepest` lying `depth` (m) behind a wall (negative before it), whose
    /// inward normal is `normal`: the body reaches a crust farther.
    pub(crate) fn contact_behind(&self, deepest: &Vec3, normal: Vec3, depth: f64) -> Option<SurfaceContact> {
        let overlap = depth + self.crust;
        (overlap > 0.0).then(|| SurfaceContact::new(deepest + normal * self.crust, normal, overlap, None))
    }

    /// Contact of the vertices of a part, at `center` (m), that lie behind a plane (Srinivasan 2019, 2.36-2.41).
    pub(crate) fn vertices_behind(
        &self,
        vertices: &DiscreteSurface,
        center: &Vec3,
        point: &Vec3,
        normal: &Vec3,
    ) -> Option<SurfaceContact> {
        let local = self.rotation.tr_mul(&(point - center)) / self.scale;
        let found = vertices.contact_with_plane(&local, &self.rotation.tr_mul(normal))?;
        Some(SurfaceContact {
            normal: -normal,
            overlap: found.overlap * self.scale,
            point: center + self.rotation * found.point * self.scale,
            footprint: None,
        })
    }

    /// Footprint on a wall deepest along `normal`, where `gap` is the distance (m) before it of a point given
    /// from the part's centre; the footprint's centre is on the core, in the frame `center` (m) is in.
    pub(crate) fn footprint(
        &self,
        center: &Vec3,
        normal: &Vec3,
        gap: impl Fn(&Vec3) -> f64,
    ) -> Option<Footprint> {
        let local = |p: &Vec3| gap(&(self.rotation * p * self.scale)) / self.scale;
        let direction = self.rotation.tr_mul(normal);
        let found = Footprint::on_surface(self.core, &direction, self.crust / self.scale, local)?;
        Some(found.moved(&self.rotation, self.scale, center))
    }

    /// Placement of another frame (its rotation, scale, and centre from ours in the world) in this part's.
    #[inline]
    pub(crate) fn placement(&self, rotation: &Mat3, scale: f64, separation: &Vec3) -> Placement {
        let inverse = 1.0 / self.scale;
        Placement {
            matrix: self.rotation.tr_mul(rotation) * (scale * inverse),
            translation: self.rotation.tr_mul(separation) * inverse,
        }
    }
}

/// Where two bodies touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartContact {
    /// Unit normal from the first to the second, in the world.
    pub(crate) normal: Vec3,
    /// Overlap (m), positive.
    pub(crate) overlap: f64,
    /// Contact point from the centre of the first part, in the world (m).
    pub(crate) point: Vec3,
    /// Whether the cores met and the penetration routine answered.
    pub(crate) cores_met: bool,
    /// Where the bodies touch if not in a point; its centre is `point`.
    pub(crate) footprint: Option<Footprint>,
}

/// Contact of a part with another core placed in its frame: δ = r1 + r2 − d (thesis eqs 3.14-3.16).
///
/// `other_crust` is in metres. The contact point is midway between the two deepest surface points.
pub(crate) fn touch(
    part: &PlacedPart,
    other: &Core,
    placement: &Placement,
    other_crust: f64,
    simplex: &mut Simplex,
    faces: FaceContact,
) -> Result<Option<PartContact>, GjkError> {
    let crusts = part.crust + other_crust;
    let (gap, normal, point_a, point_b, cores_met) =
        match distance(part.core, other, placement, crusts / part.scale, simplex)? {
            Separation::Beyond => return Ok(None),
            Separation::Apart { distance, normal, point_a, point_b } => {
                (distance, normal, point_a, point_b, false)
            }
            Separation::Meeting => {
                let p = penetration(part.core, other, placement, simplex)?;
                (-p.depth, p.normal, p.point_a, p.point_b, true)
            }
        };
    let overlap = crusts - gap * part.scale;
    if overlap <= 0.0 {
        return Ok(None);
    }
    let footprint = match faces {
        FaceContact::Point => None,
        FaceContact::Spread => {
            Footprint::of_cores(part.core, other, placement, &normal, gap, crusts / part.scale)
        }
    };
    // From between the cores to between the surfaces.
    let surfaces = |normal: &Vec3| normal * (0.5 * (part.crust - other_crust));
    if let Some(footprint) = footprint {
        let mut footprint = footprint.moved(&part.rotation, part.scale, &Vec3::zeros());
        let Footprint { normal, center, overlap, .. } = footprint;
        footprint.center = center + surfaces(&normal);
        let point = footprint.center;
        return Ok(Some(PartContact { normal, overlap, point, cores_met, footprint: Some(footprint) }));
    }
    let normal = part.rotation * normal;
    let point = part.rotation * (point_a + point_b) * (0.5 * part.scale) + surfaces(&normal);
    Ok(Some(PartContact { normal, overlap, point, cores_met, footprint }))
}

/// A pair of parts that may touch; `a` is the particle of lower id.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodyPair {
    pub(crate) a: u32,
    pub(crate) b: u32,
    pub(crate) parts: [u16; 2],
    /// Separating axis tried first; it changes the speed of the answer, not the answer.
    pub(crate) hint: u8,
    /// Tangential spring (m).
    pub(crate) spring: Vec3,
    /// Spring against twisting about the normal (rad).
    pub(crate) twist: f64,
    /// Simplex of the last step; cold unless the boxes were not apart in the last step.
    pub(crate) simplex: Simplex,
}

impl BodyPair {
    /// Whether two pairs are of the same two particles.
    fn is_of_same_bodies(&self, other: &Self) -> bool {
        (self.a, self.b) == (other.a, other.b)
    }

    /// Whether the pair carries anything over to the next step.
    pub(crate) fn remembers(&self) -> bool {
        self.simplex.len > 0 || self.twist != 0.0 || self.spring != Vec3::zeros()
    }

    /// Forgets what the pair remembered: it was apart in this step.
    fn forget(&mut self) {
        self.simplex.len = 0;
        self.release();
    }

    /// Forgets the springs of a contact that has ended.
    fn release(&mut self) {
        self.spring = Vec3::zeros();
        self.twist = 0.0;
    }
}

/// All pairs of parts of a rank, those of two particles side by side.
#[derive(Clone, Debug, Default)]
pub(crate) struct BodyList {
    pub(crate) pairs: Vec<BodyPair>,
    /// Contacts of the pairs of two particles.
    found: Vec<Option<PartContact>>,
}

/// Adds the loads of all contacts between bodies that are not both spheres.
pub(crate) fn add_forces(
    particles: &mut Particles,
    list: &mut BodyList,
    catalogue: &Catalogue,
    lattice: &LoadLattice,
    dt: f64,
    tally: &mut Tally,
) {
    let BodyList { pairs, found } = list;
    for group in pairs.chunk_by_mut(BodyPair::is_of_same_bodies) {
        let (a, b) = (group[0].a as usize, group[0].b as usize);
        if let Err(error) = find_contacts(particles, group, catalogue, found) {
            tally.error = Some(error);
            continue;
        }
        if found.iter().all(Option::is_none) {
            continue;
        }
        let law = coefficients(particles, a, b, found, catalogue);
        let mut deepest = 0.0_f64;
        for (pair, contact) in group.iter_mut().zip(found.iter()) {
            let Some(contact) = contact else { continue };
            tally.cores_met += u64::from(contact.cores_met);
            deepest = deepest.max(contact.overlap);
            let (load_a, load_b) = loads(particles, pair, &law, contact, lattice, dt);
            for (index, load) in [(a, load_a), (b, load_b)] {
                if index < particles.owned {
                    particles.loads[index].force += load.force;
                    particles.loads[index].torque += load.torque;
                }
            }
        }
        let radius = smaller_radius(particles, a, b, catalogue);
        if tally.note(deepest, radius) {
            tally.error = Some(StepError::Overlap {
                id: particles.ids[a],
                other: format!("particle {}", particles.ids[b]),
                overlap: deepest,
                percent: 100.0 * deepest / radius,
                limit: 100.0 * tally.limit(),
                place: vector(&particles.bodies[a].position),
            });
        }
    }
}

/// Calls `visit` with every pair of parts that touch and their contact.
///
/// # Errors
/// A distance that could not be found.
pub(crate) fn meet(
    particles: &Particles,
    list: &mut BodyList,
    catalogue: &Catalogue,
    mut visit: impl FnMut(&BodyPair, &PartContact),
) -> Result<(), StepError> {
    let BodyList { pairs, found } = list;
    for group in pairs.chunk_by_mut(BodyPair::is_of_same_bodies) {
        find_contacts(particles, group, catalogue, found)?;
        for (pair, contact) in group.iter().zip(found.iter()) {
            if let Some(contact) = contact {
                visit(pair, contact);
            }
        }
    }
    Ok(())
}

/// Smaller inscribed radius of two particles (m).
pub(crate) fn smaller_radius(particles: &Particles, a: usize, b: usize, catalogue: &Catalogue) -> f64 {
    let radius = |i: usize| catalogue.inscribed_radius(&particles.bodies[i]);
    radius(a).min(radius(b))
}

/// The law of each of the contacts of two particles, for the mass felt amid them.
fn coefficients(
    particles: &Particles,
    a: usize,
    b: usize,
    found: &[Option<PartContact>],
    catalogue: &Catalogue,
) -> Coefficients {
    let count = found.iter().flatten().count();
    let (mut normal, mut arm) = (Vec3::zeros(), Vec3::zeros());
    for contact in found.iter().flatten() {
        normal += contact.normal;
        arm += contact.point;
    }
    if count > 1 {
        // Of normals that cancel any direction will do.
        normal = normal.try_normalize(f64::EPSILON).unwrap_or_else(Vec3::zeros);
        arm /= count as f64;
    }
    let (body_a, body_b) = (&particles.bodies[a], &particles.bodies[b]);
    let arm_b = arm - (body_b.position - body_a.position);
    let inverse = inverse_mass_along(particles, a, &arm, &normal, catalogue)
        + inverse_mass_along(particles, b, &arm_b, &normal, catalogue);
    let law = catalogue.contacts.law(body_a.kind.material, body_b.kind.material);
    law.coefficients(1.0 / inverse).shared(count, catalogue.sharing)
}

/// Finds which pairs of parts of two particles touch; their points are taken from the centre of mass of the first.
fn find_contacts(
    particles: &Particles,
    group: &mut [BodyPair],
    catalogue: &Catalogue,
    found: &mut Vec<Option<PartContact>>,
) -> Result<(), StepError> {
    found.clear();
    let (a, b) = (group[0].a as usize, group[0].b as usize);
    let (body_a, body_b) = (&particles.bodies[a], &particles.bodies[b]);
    let separation = body_b.position - body_a.position;
    let reach = body_a.radius + body_b.radius;
    if separation.norm_squared() >= reach * reach {
        group.iter_mut().for_each(BodyPair::forget);
        return Ok(());
    }
    let (shape_a, shape_b) = (catalogue.shape(body_a.kind), catalogue.shape(body_b.kind));
    let scales = [body_a.radius / shape_a.bounding_radius, body_b.radius / shape_b.bounding_radius];
    for pair in group {
        let part_a = PlacedPart::of(shape_a, pair.parts[0], &particles.frames[a], scales[0]);
        let part_b = PlacedPart::of(shape_b, pair.parts[1], &particles.frames[b], scales[1]);
        let contact = pair_contact(pair, &part_a, &part_b, &separation, catalogue.faces);
        found.push(contact.map_err(|reason| StepError::Distance {
            id: particles.ids[a],
            other: format!("particle {}", particles.ids[b]),
            place: vector(&body_a.position),
            reason: reason.to_string(),
        })?);
    }
    Ok(())
}

/// Contact of a pair of parts, its point taken from the centre of mass of `a`.
fn pair_contact(
    pair: &mut BodyPair,
    part_a: &PlacedPart,
    part_b: &PlacedPart,
    separation: &Vec3,
    faces: FaceContact,
) -> Result<Option<PartContact>, GjkError> {
    let between = separation + (part_b.offset - part_a.offset);
    let reach = part_a.bounding_radius + part_b.bounding_radius;
    if between.norm_squared() >= reach * reach {
        pair.forget();
        return Ok(None);
    }
    let placement = part_a.placement(&part_b.rotation, part_b.scale, &between);
    let mut are_boxes_apart =
        || boxes_apart(part_a.half_extents, part_b.half_extents, &placement, 0.0, &mut pair.hint);
    // Touching bodies are best asked for their distance at once: their boxes are not apart.
    let is_warm = pair.simplex.len > 0;
    if !is_warm && are_boxes_apart() {
        pair.forget();
        return Ok(None);
    }
    let contact = match (part_a.vertices, part_b.vertices) {
        (Some(a), Some(b)) => a.contact(b, &placement).map(|found| PartContact {
            normal: part_a.rotation * found.normal,
            overlap: found.overlap * part_a.scale,
            point: part_a.rotation * found.point * part_a.scale,
            cores_met: false,
            footprint: None,
        }),
        _ => touch(part_a, part_b.core, &placement, part_b.crust, &mut pair.simplex, faces)?,
    };
    if contact.is_none() {
        if is_warm && are_boxes_apart() {
            pair.simplex.len = 0;
        }
        pair.release();
    }
    Ok(contact.map(|c| PartContact { point: c.point + part_a.offset, ..c }))
}

/// Loads on the two bodies of a contact whose point is given from the centre of mass of `a`.
fn loads(
    particles: &Particles,
    pair: &mut BodyPair,
    law: &Coefficients,
    found: &PartContact,
    lattice: &LoadLattice,
    dt: f64,
) -> (Load, Load) {
    let (a, b) = (&particles.bodies[pair.a as usize], &particles.bodies[pair.b as usize]);
    let arm_a = found.point;
    let arm_b = found.point - (b.position - a.position);
    let velocity =
        (b.velocity + b.angular_velocity.cross(&arm_b)) - (a.velocity + a.angular_velocity.cross(&arm_a));
    let contact = Contact { normal: found.normal, overlap: found.overlap, velocity };
    let force = lattice.force(&law.force(&contact, &mut pair.spring, dt));
    let mut torque_a = lattice.torque(&arm_a.cross(&force));
    let mut torque_b = -lattice.torque(&arm_b.cross(&force));
    if let Some(Footprint { moment, second, .. }) = found.footprint {
        let spin = b.angular_velocity - a.angular_velocity;
        let spread = Spread { moment, second };
        let torque = lattice.torque(&law.spread_torque(&contact, &spread, &spin, &mut pair.twist, dt));
        torque_a += torque;
        torque_b -= torque;
    }
    if law.resists_rolling() {
        let (length_a, length_b) = (arm_a.norm(), arm_b.norm());
        let spin = a.angular_velocity - b.angular_velocity;
        let arm = length_a * length_b / (length_a + length_b);
        let rolling = lattice.torque(&law.rolling_torque(&contact, &spin, arm));
        torque_a += rolling;
        torque_b -= rolling;
    }
    (Load { force, torque: torque_a }, Load { force: -force, torque: torque_b })
}
