//! What is odd about walls, flow planes, and faces of the domain.

use super::setting::{LONG_DISPLACEMENT, Remark, Setting};
use grains_case::{Case, Face, FluidSide, Motion, Side, WallKind};
use grains_dem::{OpenTube, Surface, Wall};
use grains_geometry::{Core, TriMesh, Vec3};

pub(super) fn mesh_of_another_size(s: &Setting) -> Vec<Remark> {
    /// Diagonal of a mesh over that of the domain, between units that are a thousand apart.
    const USUAL: [f64; 2] = [1.0 / 300.0, 30.0];
    let meant = |mesh: &TriMesh| mesh.diagonal() / s.diagonal();
    let mut remarks = Vec::new();
    for (i, (wall, built)) in s.case.walls.iter().zip(s.walls).enumerate() {
        let (WallKind::Mesh { .. }, [Surface::Mesh(mesh)]) = (&wall.kind, &built.surfaces[..]) else {
            continue;
        };
        let ratio = meant(mesh.mesh());
        let (what, remedy) = if ratio > USUAL[1] {
            ("larger", "0.001 for a file in millimetres")
        } else if ratio < USUAL[0] {
            ("smaller", "1 for a file in metres")
        } else {
            continue;
        };
        let message = format!(
            "the mesh is {:.3e} m across, {:.0} times {what} than the domain ({:.3e} m), so particles hardly meet it; scale is metres per unit of the file: {remedy}",
            mesh.mesh().diagonal(),
            ratio.max(1.0 / ratio),
            s.diagonal()
        );
        remarks.push((format!("wall[{i}].scale"), message));
    }
    remarks
}

/// Bodies that fill the whole section of a tube or a box around the fluid.
pub(super) fn body_wider_than_its_tube(s: &Setting) -> Vec<Remark> {
    let widest =
        s.insertions.kinds().iter().map(|k| 2.0 * k.largest * s.catalogue.shape(k.kind).inscribed_radius);
    let widest = widest.fold(0.0, f64::max);
    let mut remarks = Vec::new();
    for (i, wall) in s.case.walls.iter().enumerate() {
        let is_around = |side: &Side| match wall.fluid {
            Some(FluidSide::Inside) => true,
            Some(FluidSide::Particles) => *side == Side::Inside,
            _ => false,
        };
        let (key, width) = match &wall.kind {
            WallKind::Cylinder { side, radius, .. } if is_around(side) => ("radius", 2.0 * radius),
            WallKind::Box { side, lower, upper, .. } if is_around(side) => {
                ("upper", (0..3).map(|a| upper[a] - lower[a]).fold(f64::INFINITY, f64::min))
            }
            WallKind::Cone { side, bottom_radius, top_radius, .. } if is_around(side) => {
                ("bottom_radius", 2.0 * bottom_radius.max(*top_radius))
            }
            WallKind::Revolution { side, profile, .. } if is_around(side) => {
                ("profile", 2.0 * profile.iter().fold(0.0, |largest: f64, [_, radius]| largest.max(*radius)))
            }
            _ => continue,
        };
        if widest > width {
            let message = format!(
                "this wall around the fluid is {width:.3e} m wide, and the largest body holds a ball of {widest:.3e} m: it blocks the section and reaches into the wall; take a smaller shape or scale, or a wider wall"
            );
            remarks.push((format!("wall[{i}].{key}"), message));
        }
    }
    remarks
}

pub(super) fn wall_outside(s: &Setting) -> Vec<Remark> {
    let [lower, upper] = s.corners();
    let mut remarks = Vec::new();
    for (i, (wall, built)) in
        s.case.walls.iter().zip(s.walls).enumerate().filter(|(_, (w, _))| w.motion.is_none())
    {
        let boxes: Option<Vec<[Vec3; 2]>> = built.surfaces.iter().map(Surface::extents).collect();
        let Some(boxes) = boxes.filter(|boxes| !boxes.is_empty()) else { continue };
        let is_apart = |[from, to]: &[Vec3; 2]| (0..3).any(|a| from[a] > upper[a] || to[a] < lower[a]);
        if boxes.iter().all(is_apart) {
            let [from, to] = boxes[0];
            let message = format!(
                "lies outside the domain, between ({:.3e}, {:.3e}, {:.3e}) and ({:.3e}, {:.3e}, {:.3e}) m, so no particle meets it; move it, or check its unit",
                from.x, from.y, from.z, to.x, to.y, to.z
            );
            remarks.push((
                format!(
                    "wall[{i}].{}",
                    if matches!(wall.kind, WallKind::Mesh { .. }) { "translate" } else { "kind" }
                ),
                message,
            ));
        }
    }
    remarks
}

pub(super) fn wall_too_late(s: &Setting) -> Vec<Remark> {
    let end = s.case.time.end;
    let mut remarks = Vec::new();
    for (i, wall) in s.case.walls.iter().enumerate() {
        if wall.from >= end {
            let message = format!(
                "not before the end of the run ({end} s): the wall never exists; lower it, or raise time.end"
            );
            remarks.push((format!("wall[{i}].from"), message));
        }
        let Some(((start, _), key)) = wall.motion.as_ref().map(|m| (m.interval(), m.start_key())) else {
            continue;
        };
        if start >= end {
            let message = format!(
                "not before the end of the run ({end} s): the wall never moves; lower it, or raise time.end"
            );
            remarks.push((format!("wall[{i}].motion.{key}"), message));
        }
    }
    remarks
}

pub(super) fn flow_plane_outside(s: &Setting) -> Vec<Remark> {
    let [lower, upper] = s.corners();
    let tolerance = 1e-9 * s.diagonal();
    let planes = s.case.flow_planes.iter().enumerate();
    let is_outside = |plane: &grains_case::FlowPlane| {
        let (point, normal) = (Vec3::from(plane.point), Vec3::from(plane.normal));
        let middle = (normal).dot(&((lower + upper) * 0.5 - point));
        // Half the width of the domain along the normal.
        let reach = normal.abs().dot(&(upper - lower)) * 0.5;
        middle.abs() > reach + tolerance
    };
    planes
        .filter(|(_, plane)| is_outside(plane))
        .map(|(k, _)| {
            let message = "the plane does not cut the domain, so nothing is ever counted; move the point inside the domain";
            (format!("flow_plane[{k}].point"), message.to_string())
        })
        .collect()
}

/// The four corners (m) of a face.
fn corners_of(face: Face, [lower, upper]: [Vec3; 2]) -> [Vec3; 4] {
    let axis = face.axis();
    let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
    std::array::from_fn(|k| {
        let mut corner = if face.is_upper() { upper } else { lower };
        corner[b] = if k & 1 == 0 { lower[b] } else { upper[b] };
        corner[c] = if k & 2 == 0 { lower[c] } else { upper[c] };
        corner
    })
}

/// Whether no centre of a particle on its own side of a surface can be on a face of the domain.
fn shuts(surface: &Surface, face: Face, corners: [Vec3; 2]) -> bool {
    let tolerance = 1e-9 * (corners[1] - corners[0]).norm();
    match surface {
        Surface::Plane { point, normal } => {
            corners_of(face, corners).iter().all(|corner| normal.dot(&(corner - point)) <= tolerance)
        }
        Surface::Tube { center, axis, radius, .. } => {
            let side = if face.is_upper() { 1.0 } else { -1.0 };
            let distance = side * (corners[usize::from(face.is_upper())][face.axis()] - center[face.axis()]);
            axis[face.axis()].abs() < 1e-9 && distance >= radius - tolerance
        }
        Surface::OpenTube(_) | Surface::Solid { .. } | Surface::Mesh(_) => false,
    }
}

pub(super) fn closed_outlet(s: &Setting) -> Vec<Remark> {
    let stays = |(wall, _): &(&grains_case::Wall, &Wall)| {
        wall.motion.is_none() && wall.from <= 0.0 && wall.until >= s.case.time.end
    };
    let mut remarks = Vec::new();
    for (k, face) in s.domain().outlets.iter().enumerate() {
        let mut walls = s.case.walls.iter().zip(s.walls).filter(stays);
        let shut =
            walls.find(|(_, built)| built.surfaces.iter().any(|surface| shuts(surface, *face, s.corners())));
        if let Some((wall, _)) = shut {
            let message = format!(
                "wall \"{}\" closes this face, so no particle leaves; end the wall with until (s), or move it beyond the face",
                wall.name
            );
            remarks.push((format!("domain.outlets[{k}]"), message));
        }
    }
    remarks
}

/// Faces through which particles would be lost: without wall, outlet or periodicity, below them or, of a bed, beside them.
pub fn bare_faces(case: &Case, walls: &[Wall]) -> Vec<Face> {
    let corners = [Vec3::from(case.domain.lower), Vec3::from(case.domain.upper)];
    let regions: Vec<_> = case.inserts.iter().filter_map(|insert| insert.place.extents()).collect();
    // Meshes may hold particles where they reach beyond the region these come from.
    let shields = |surface: &Surface, face: Face| match surface {
        Surface::Mesh(mesh) => {
            let (lower, upper) = mesh.mesh().extents();
            let across = (0..3).filter(|&a| a != face.axis());
            across
                .into_iter()
                .all(|a| regions.iter().all(|[from, to]| lower[a] <= from[a] && to[a] <= upper[a]))
        }
        surface => shuts(surface, face, corners),
    };
    let is_bare = |face: &Face| {
        !case.domain.periodic[face.axis()]
            && !case.domain.outlets.contains(face)
            && case.fluid.as_ref().is_none_or(|fluid| fluid.cells[face.axis()] > 1)
            && !walls.iter().any(|wall| {
                wall.motion != grains_dem::Motion::Fixed
                    || wall.surfaces.iter().any(|surface| shields(surface, *face))
            })
    };
    Face::ALL.into_iter().filter(is_bare).collect()
}

pub(super) fn bare_face(s: &Setting) -> Vec<Remark> {
    /// Particles that make a bed, which spreads.
    const BED: u64 = 100;
    if !s.has_moving_particles() {
        return Vec::new();
    }
    let gravity = Vec3::from(s.case.gravity);
    let falls = |face: &Face| {
        let along = gravity[face.axis()] * if face.is_upper() { 1.0 } else { -1.0 };
        along > 0.1 * gravity.norm()
            || s.count() >= BED && along >= -0.1 * gravity.norm() && gravity.norm() > 0.0
    };
    let bare: Vec<&str> = bare_faces(s.case, s.walls).into_iter().filter(falls).map(Face::name).collect();
    if bare.is_empty() {
        return Vec::new();
    }
    let message = format!(
        "neither wall nor outlet nor periodic at {}: the run ends when a particle gets there; add [[wall]], or name the face in domain.outlets",
        bare.join(", ")
    );
    vec![("domain".into(), message)]
}

pub(super) fn fast_wall(s: &Setting) -> Vec<Remark> {
    /// Steps per period of an oscillation below which it is not followed.
    const STEPS: f64 = 20.0;
    if !s.has_contacts {
        return Vec::new();
    }
    let (dt, radius) = (s.steps[0], s.smallest_radius());
    let mut remarks = Vec::new();
    for (i, wall) in s.case.walls.iter().enumerate() {
        let Some(motion) = &wall.motion else { continue };
        if let Motion::Oscillation { frequency, .. } = motion
            && frequency * dt > 1.0 / STEPS
        {
            let message = format!(
                "{:.1} time steps per period: the wall jumps; lower it (Hz), or time.dt",
                1.0 / (frequency * dt)
            );
            remarks.push((format!("wall[{i}].motion.frequency"), message));
            continue;
        }
        let arm = s.walls[i].surfaces.iter().map(reach).fold(0.0, f64::max).min(s.diagonal());
        let (speed, key) = motion.speed(arm);
        if speed * dt > LONG_DISPLACEMENT * radius {
            let message = format!(
                "the wall goes {:.1} radii of the smallest particle per time step ({dt:.2e} s): it passes particles by; SI units are m, s and rad/s, or lower time.dt",
                speed * dt / radius
            );
            remarks.push((format!("wall[{i}].motion.{key}"), message));
        }
    }
    remarks
}

/// Walls under a load that are so light that they swing on the particles within few steps.
///
/// N = A/(2 r)² contacts of stiffness k give a period 2π √(m/(N k)).
pub(super) fn light_wall(s: &Setting) -> Vec<Remark> {
    /// Steps per period below which the motion is not followed.
    const STEPS: f64 = 20.0;
    if !s.has_contacts {
        return Vec::new();
    }
    let stiffness = s.case.contacts.iter().filter_map(|law| law.normal_stiffness).fold(0.0, f64::max);
    let contact_area = 4.0 * s.smallest_radius() * s.smallest_radius();
    let remark = |(i, wall): (usize, &grains_case::Wall)| {
        let Some(Motion::Load { area: Some(area), mass, .. }) = wall.motion else { return None };
        let contacts = (area / contact_area).max(1.0);
        let period = std::f64::consts::TAU * (mass / (contacts * stiffness)).sqrt();
        let min_mass = mass * (STEPS * s.steps[0] / period).powi(2);
        (period < STEPS * s.steps[0]).then(|| {
            let message = format!(
                "on {contacts:.0} contacts, as many as its area holds, the wall swings with a period of {:.1} time steps: it may not come to rest; take {min_mass:.1e} kg or more, or lower time.dt",
                period / s.steps[0]
            );
            (format!("wall[{i}].motion.mass"), message)
        })
    };
    s.case.walls.iter().enumerate().filter_map(remark).collect()
}

/// Radius (m) of a surface about its middle.
fn reach(surface: &Surface) -> f64 {
    match surface {
        Surface::Plane { .. } => f64::INFINITY,
        Surface::Tube { radius, .. } | Surface::OpenTube(OpenTube { radius, .. }) => *radius,
        Surface::Solid { core: Core::Cylinder { radius, .. }, .. } => *radius,
        Surface::Solid { bounding_radius, .. } => *bounding_radius,
        Surface::Mesh(mesh) => 0.5 * mesh.mesh().diagonal(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Draw;

    /// Points of a face, those of its edges included.
    fn points_of(face: Face, corners: [Vec3; 2]) -> impl Iterator<Item = Vec3> {
        let [a, b, c, d] = corners_of(face, corners);
        (0..=20).flat_map(move |i| {
            (0..=20).map(move |j| {
                let (u, v) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                (a * (1.0 - u) + b * u) * (1.0 - v) + (c * (1.0 - u) + d * u) * v
            })
        })
    }

    #[test]
    fn a_face_is_shut_where_no_point_of_it_is_on_the_particles_side() {
        let mut found = [[0; 2]; 2];
        for id in 0..20_000 {
            let mut draw = Draw::new(3, id, 1);
            let mut vector = |size: f64| Vec3::from_fn(|_, _| size * (2.0 * draw.next() - 1.0));
            let corners = [vector(1.0) - Vec3::repeat(1.5), vector(1.0) + Vec3::repeat(1.5)];
            let (point, direction) = (vector(3.0), vector(1.0).normalize());
            let face = Face::ALL[id as usize % 6];
            let plane = Surface::Plane { point, normal: direction };
            let side = |p: Vec3| direction.dot(&(p - point)) <= 0.0;
            let is_shut = points_of(face, corners).all(side);
            assert_eq!(shuts(&plane, face, corners), is_shut, "{face:?} {plane:?} {corners:?}");
            found[0][usize::from(is_shut)] += 1;
            // Tubes along the face.
            let mut axis = direction;
            axis[face.axis()] = 0.0;
            let axis = axis.normalize();
            let radius = 0.2 + 2.5 * vector(1.0).x.abs();
            let tube = Surface::Tube { center: point, axis, radius, half_length: f64::INFINITY };
            let is_outside = |p: Vec3| (p - point).cross(&axis).norm() >= radius;
            let is_shut = shuts(&tube, face, corners);
            // The other way round a tube beside the domain would shut what it does not hold.
            assert!(!is_shut || points_of(face, corners).all(is_outside), "{face:?} {tube:?} {corners:?}");
            found[1][usize::from(is_shut)] += 1;
        }
        assert!(found.iter().flatten().all(|&count| count > 500), "{found:?}");
    }
}
