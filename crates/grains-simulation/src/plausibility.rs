//! Values that may stand together and yet are seldom meant: each is named with its consequence and a remedy, by `check`
//! and when a run begins.

use crate::fluid::check::imposed::fastest;
use crate::population::Population;
use crate::system::System;
use grains_case::{
    BoundaryKind, Case, Domain, Drive, Expression, Face, Fluid, Insert, Kernel, Motion, TimeStep, WallKind,
};
use grains_dem::{Catalogue, OpenTube, Surface, Wall};
use grains_geometry::{Core, TriMesh, Vec3};

/// A key such as `wall[0].scale`, and what is odd about its value.
type Remark = (String, String);

/// A case as it is set up.
struct Setting<'a> {
    case: &'a Case,
    walls: &'a [Wall],
    catalogue: &'a Catalogue,
    population: &'a Population,
    /// Time step, and the one that "auto" would take (s).
    steps: [f64; 2],
    /// Whether anything can touch anything.
    has_contacts: bool,
}

/// Every rule; each looks at one kind of mistake.
const RULES: [fn(&Setting) -> Vec<Remark>; 18] = [
    mesh_of_another_size,
    wall_outside,
    wall_too_late,
    flow_plane_outside,
    stop_at_once,
    inlet_outwards,
    outlet_alone,
    fine_cells,
    courant_passed,
    endless_acceleration,
    empty_domain,
    closed_outlet,
    bare_face,
    slow_impact,
    fast_insertion,
    fast_wall,
    fine_step,
    many_steps,
];

/// What is odd about a case, with file, line, key, value, consequence and remedy.
pub fn warnings(case: &Case, system: &System, population: &Population) -> Vec<String> {
    let setup = &system.setup;
    let steps = [system.step.dt, system.step.recommended];
    let has_contacts = !system.step.encounters.is_empty();
    let (walls, catalogue) = (&setup.walls, &setup.catalogue);
    let setting = Setting { case, walls, catalogue, population, steps, has_contacts };
    let remarks = RULES.iter().flat_map(|rule| rule(&setting));
    remarks.map(|(key, message)| case.about(&key, message)).collect()
}

impl Setting<'_> {
    fn domain(&self) -> &Domain {
        &self.case.domain
    }

    /// Length of the diagonal of the domain (m).
    fn diagonal(&self) -> f64 {
        let [lower, upper] = self.corners();
        (upper - lower).norm()
    }

    fn corners(&self) -> [Vec3; 2] {
        [Vec3::from(self.domain().lower), Vec3::from(self.domain().upper)]
    }

    /// Whether there are particles that move.
    fn has_moving_particles(&self) -> bool {
        !self.case.inserts.iter().all(Insert::is_fixed)
    }

    /// Particles in all (-).
    fn count(&self) -> u64 {
        self.population.total()
    }

    /// Diameter (m) of the spheres of the volumes of the smallest and the largest particle.
    fn diameters(&self) -> [f64; 2] {
        let kinds = self.population.kinds().iter();
        let of = |k: &crate::population::KindRange| {
            let diameter = self.catalogue.shape(k.kind).sphere_equivalent_diameter();
            [k.smallest * diameter, k.largest * diameter]
        };
        kinds.map(of).fold([f64::INFINITY, 0.0], |[a, b], [c, d]| [a.min(c), b.max(d)])
    }

    /// Radius (m) of the largest ball in the smallest particle.
    fn smallest_radius(&self) -> f64 {
        let kinds = self.population.kinds().iter();
        kinds
            .map(|k| k.smallest * self.catalogue.shape(k.kind).inscribed_radius)
            .fold(f64::INFINITY, f64::min)
    }

    /// Speed (m/s) and index of the fastest insertion.
    fn fastest_insertion(&self) -> (f64, usize) {
        let inserts = self.case.inserts.iter().enumerate();
        let free = inserts.filter(|(_, insert)| !insert.is_prescribed());
        free.map(|(i, insert)| (Vec3::from(insert.velocity).norm(), i))
            .fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a })
    }
}

/// Corners (m) of the box about a surface that ends somewhere.
fn extents(surface: &Surface) -> Option<[Vec3; 2]> {
    match surface {
        Surface::Mesh(mesh) => Some(mesh.mesh().extents().into()),
        Surface::Solid { center, bounding_radius, .. } => {
            let reach = Vec3::repeat(*bounding_radius);
            Some([center - reach, center + reach])
        }
        Surface::OpenTube(tube) => {
            let reach = Vec3::repeat(tube.half_length.hypot(tube.radius));
            Some([tube.center - reach, tube.center + reach])
        }
        Surface::Plane { .. } | Surface::Tube { .. } => None,
    }
}

fn mesh_of_another_size(s: &Setting) -> Vec<Remark> {
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

fn wall_outside(s: &Setting) -> Vec<Remark> {
    let [lower, upper] = s.corners();
    let mut remarks = Vec::new();
    for (i, (wall, built)) in
        s.case.walls.iter().zip(s.walls).enumerate().filter(|(_, (w, _))| w.motion.is_none())
    {
        let boxes: Option<Vec<[Vec3; 2]>> = built.surfaces.iter().map(extents).collect();
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

fn wall_too_late(s: &Setting) -> Vec<Remark> {
    let end = s.case.time.end;
    let mut remarks = Vec::new();
    for (i, wall) in s.case.walls.iter().enumerate() {
        if wall.from >= end {
            let message = format!(
                "not before the end of the run ({end} s): the wall never exists; lower it, or raise time.end"
            );
            remarks.push((format!("wall[{i}].from"), message));
        }
        let Some((start, _)) = wall.motion.as_ref().map(Motion::interval) else { continue };
        if start >= end {
            let message = format!(
                "not before the end of the run ({end} s): the wall never moves; lower it, or raise time.end"
            );
            remarks.push((format!("wall[{i}].motion.start"), message));
        }
    }
    remarks
}

fn flow_plane_outside(s: &Setting) -> Vec<Remark> {
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

fn stop_at_once(s: &Setting) -> Vec<Remark> {
    let stop = &s.case.stop;
    let is_at_rest = |insert: &Insert| {
        let starts = insert.start == 0.0 && insert.batch.is_none_or(|batch| Some(batch) == insert.count);
        // A file may bring velocities, and a window may have to wait for room.
        let is_sure = matches!(
            insert.place,
            grains_case::Place::Lattice { .. } | grains_case::Place::Window { retry: None, .. }
        );
        let rests = [insert.velocity, insert.angular_velocity] == [[0.0; 3]; 2];
        starts && (insert.is_fixed() || is_sure && rests && !insert.is_prescribed())
    };
    let is_met = stop.kinetic_energy_below.is_some() && stop.after == 0.0 && !s.case.inserts.is_empty();
    if !is_met || !s.case.inserts.iter().all(is_at_rest) || s.case.output.series == 0.0 {
        return Vec::new();
    }
    let message = "particles start at rest, so the run ends at t = 0; give stop.after (s), the time they need to get moving";
    vec![("stop.kinetic_energy_below".into(), message.into())]
}

/// Conditions that hold somewhere on the boundary of the fluid, by their index in the case.
fn conditions<'a>(case: &'a Case, fluid: &'a Fluid) -> Vec<usize> {
    let open = Face::ALL.into_iter().filter(|face| !case.domain.periodic[face.axis()]);
    open.flat_map(|face| {
        let on_face = fluid.on_face(face);
        on_face.whole.into_iter().chain(on_face.patches)
    })
    .collect()
}

/// Speed into the domain (m/s) that an inlet imposes, if it is a number.
fn speed_inwards(fluid: &Fluid, index: usize) -> Option<f64> {
    let boundary = &fluid.boundary[index];
    match &boundary.kind {
        BoundaryKind::ParabolicInlet { mean } => Some(*mean),
        BoundaryKind::Inlet { velocity } => match velocity[boundary.face.axis()] {
            Expression::Number(normal) => Some(if boundary.face.is_upper() { -normal } else { normal }),
            Expression::Formula(_) => None,
        },
        _ => None,
    }
}

fn inlet_outwards(s: &Setting) -> Vec<Remark> {
    let Some(fluid) = &s.case.fluid else { return Vec::new() };
    let all = conditions(s.case, fluid);
    // Without an outlet, what one inlet blows in another has to take out.
    if !all.iter().any(|&i| matches!(fluid.boundary[i].kind, BoundaryKind::Outlet { .. })) {
        return Vec::new();
    }
    let outwards = all.into_iter().filter(|&i| speed_inwards(fluid, i).is_some_and(|speed| speed < 0.0));
    outwards
        .map(|i| {
            let boundary = &fluid.boundary[i];
            let (axis, face) = (boundary.face.axis(), boundary.face.name());
            let key = match boundary.kind {
                BoundaryKind::ParabolicInlet { .. } => format!("fluid.boundary[{i}].mean"),
                _ => format!("fluid.boundary[{i}].velocity[{axis}]"),
            };
            (key, format!("this inlet on {face} blows out of the domain, so fluid is sucked in through the outlet; change the sign"))
        })
        .collect()
}

fn outlet_alone(s: &Setting) -> Vec<Remark> {
    let Some(fluid) = &s.case.fluid else { return Vec::new() };
    let all = conditions(s.case, fluid);
    let mut pressures = all.iter().filter_map(|&i| match fluid.boundary[i].kind {
        BoundaryKind::Outlet { pressure } => Some((i, pressure)),
        _ => None,
    });
    let Some((first, pressure)) = pressures.next() else { return Vec::new() };
    let is_driven = all.iter().any(|&i| match &fluid.boundary[i].kind {
        BoundaryKind::Inlet { .. } | BoundaryKind::ParabolicInlet { .. } => true,
        BoundaryKind::Wall { velocity } => *velocity != [0.0; 3],
        _ => false,
    });
    let still = [Expression::Number(0.0), Expression::Number(0.0), Expression::Number(0.0)];
    let is_set_going = fluid.initial.velocity != still || pressures.any(|(_, other)| other != pressure);
    let has_drive = match &fluid.drive {
        Some(Drive::PressureGradient { gradient }) => *gradient != [0.0; 3],
        Some(Drive::MeanVelocity { velocity, .. } | Drive::MeanFlux { velocity, .. }) => {
            *velocity != [0.0; 3]
        }
        None => false,
    };
    // Particles that come or go later displace fluid.
    let come = |insert: &Insert| insert.start > 0.0 || insert.batch.is_some() || insert.velocity != [0.0; 3];
    let is_displaced =
        s.has_moving_particles() && (s.case.inserts.iter().any(come) || !s.domain().outlets.is_empty());
    if is_driven || is_set_going || has_drive || is_displaced {
        return Vec::new();
    }
    let message = "an outlet, but nothing lets fluid in: it stays at rest, or moves with the particles alone; add [[fluid.boundary]] with kind = \"inlet\"";
    vec![(format!("fluid.boundary[{first}].kind"), message.into())]
}

fn fine_cells(s: &Setting) -> Vec<Remark> {
    let Some((fluid, coupling)) = s.case.fluid.as_ref().and_then(|f| Some((f, f.coupling.as_ref()?))) else {
        return Vec::new();
    };
    if s.case.inserts.is_empty() || fluid.resolved.is_some() {
        return Vec::new();
    }
    let widths = (0..3).filter(|&a| fluid.cells[a] > 1).map(|a| fluid.cell_widths(&s.case.domain, a)[0]);
    let ratio = widths.fold(f64::INFINITY, f64::min) / s.diameters()[1];
    match coupling.kernel {
        Kernel::Cube if ratio < 3.0 => vec![(
            "fluid.coupling.kernel".into(),
            format!(
                "embedded cubes are for cells of three diameters and more, here some are {ratio:.2}: void fractions will be rough; take {{ kind = \"smooth\" }} or larger cells"
            ),
        )],
        Kernel::Smooth { .. } if ratio < 1.0 => vec![(
            "fluid.cells".into(),
            format!(
                "some cells are {ratio:.2} diameters wide, and drag laws are for flow averaged over several particles: cost without accuracy; take cells of 1.5 diameters and more, or [fluid] resolved with 8 cells across a particle"
            ),
        )],
        _ => Vec::new(),
    }
}

/// Steps of the fluid that pass its Courant number by what the case imposes alone.
fn courant_passed(s: &Setting) -> Vec<Remark> {
    let Some(fluid) = &s.case.fluid else { return Vec::new() };
    let is_alone = s.case.inserts.is_empty() || s.case.holds_particles();
    let fastest = fastest(s.case, fluid);
    let (limit, dt) = (fluid.courant / fastest.rate, s.steps[0]);
    if dt > (1.0 + 1e-9) * limit && (!is_alone || s.case.time.dt != TimeStep::Auto) {
        let message = format!(
            "a step of {dt:.3e} s has Courant number {:.3} at the {:.4} m/s imposed, beyond fluid.courant = {}: the run ends where the flow gets so fast; take {limit:.2e} or less, or raise fluid.courant, up to 1",
            fastest.rate * dt,
            fastest.speed,
            fluid.courant
        );
        return vec![("time.dt".into(), message)];
    }
    let given = fluid.coupling.as_ref().filter(|_| !is_alone).and_then(|coupling| coupling.particle_steps);
    match given {
        Some(count) if count as f64 * dt > (1.0 + 1e-9) * limit => {
            let message = format!(
                "{:.3e} s have Courant number {:.3} at the {:.4} m/s imposed, beyond fluid.courant = {}: the fluid takes fewer particle steps there; {} would do, or raise fluid.courant, up to 1",
                count as f64 * dt,
                fastest.rate * dt * count as f64,
                fastest.speed,
                fluid.courant,
                (limit / dt) as u64
            );
            vec![("fluid.coupling.particle_steps".into(), message)]
        }
        _ => Vec::new(),
    }
}

/// A periodic mixture that gravity accelerates for ever, as neither a wall nor a drive holds it.
fn endless_acceleration(s: &Setting) -> Vec<Remark> {
    let Some(fluid) = s.case.fluid.as_ref().filter(|_| s.has_moving_particles()) else { return Vec::new() };
    let domain = s.domain();
    // What does not slip on a face that is not periodic holds the flow along the other axes.
    let holds = |face: Face| {
        let on_face = fluid.on_face(face);
        let is_slippery = |i: usize| matches!(fluid.boundary[i].kind, BoundaryKind::Symmetry);
        let conditions: Vec<usize> = on_face.whole.into_iter().chain(on_face.patches).collect();
        !domain.periodic[face.axis()]
            && fluid.cells[face.axis()] > 1
            && (conditions.is_empty() || !conditions.into_iter().all(is_slippery))
    };
    let mut remarks = Vec::new();
    for a in (0..3).filter(|&a| domain.periodic[a] && s.case.gravity[a] != 0.0 && fluid.cells[a] > 1) {
        let is_driven = match &fluid.drive {
            Some(Drive::PressureGradient { gradient }) => gradient[a] != 0.0,
            Some(Drive::MeanVelocity { axes, .. } | Drive::MeanFlux { axes, .. }) => axes[a],
            None => false,
        };
        if is_driven
            || Face::ALL.into_iter().any(holds)
            || s.walls.iter().any(|wall| !wall.surfaces.is_empty())
        {
            continue;
        }
        let axis = ["x", "y", "z"][a];
        let message = format!(
            "the domain is periodic along {axis}, nothing holds particles or fluid there and nothing drives them against gravity: both accelerate for ever; add [fluid.drive] with kind = \"mean_flux\", velocity = [0, 0, 0] and axes[{a}] = true to let particles settle while the mixture as a whole stays"
        );
        remarks.push((format!("gravity[{a}]"), message));
    }
    remarks
}

fn empty_domain(s: &Setting) -> Vec<Remark> {
    /// Longest edge of the domain over that of the bed, for beds and for a few particles.
    const USUAL: [f64; 2] = [300.0, 3000.0];
    let [smallest, largest] = s.diameters();
    if s.case.inserts.is_empty() || smallest.is_infinite() {
        return Vec::new();
    }
    let edge = |[lower, upper]: [[f64; 3]; 2]| (0..3).map(|a| upper[a] - lower[a]).fold(0.0, f64::max);
    let regions = s.case.inserts.iter().filter_map(|insert| insert.place.extents());
    let packed = (s.count() as f64).cbrt() * largest;
    let bed = regions.map(edge).fold(packed, f64::max);
    let extents = s.domain().extents();
    let axis = (0..3).fold(0, |best, a| if extents[a] > extents[best] { a } else { best });
    let ratio = extents[axis] / bed;
    if ratio < USUAL[usize::from(s.count() < 10)] {
        return Vec::new();
    }
    let message = format!(
        "the domain is {:.3e} m long there, {ratio:.0} times the particles' region ({bed:.3e} m): ranks get empty space, and places are rounded to {:.0e} of a diameter; lengths are in metres (80 mm are 0.08)",
        extents[axis],
        extents[axis] * f64::EPSILON / smallest
    );
    vec![(format!("domain.upper[{axis}]"), message)]
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

fn closed_outlet(s: &Setting) -> Vec<Remark> {
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

fn bare_face(s: &Setting) -> Vec<Remark> {
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

fn slow_impact(s: &Setting) -> Vec<Remark> {
    let (speed, index) = s.fastest_insertion();
    let given = s.case.time.impact_speed;
    if !s.has_moving_particles() || given >= 0.5 * speed {
        return Vec::new();
    }
    let message = format!(
        "insert[{index}] moves at {speed:.3} m/s: overlaps will be {:.1} times those that check foresees; raise it, or leave it out",
        speed / given
    );
    vec![("time.impact_speed".into(), message)]
}

/// Way per step over the smallest radius (-) beyond which contacts begin deep.
const LONG_WAY: f64 = 0.2;

fn fast_insertion(s: &Setting) -> Vec<Remark> {
    let (speed, index) = s.fastest_insertion();
    let way = speed * s.steps[0] / s.smallest_radius();
    if !s.has_contacts || way <= LONG_WAY {
        return Vec::new();
    }
    let message = format!(
        "particles go {way:.1} radii per time step ({:.2e} s): contacts begin deep or are missed; velocities are in m/s, or lower time.dt",
        s.steps[0]
    );
    vec![(format!("insert[{index}].velocity"), message)]
}

fn fast_wall(s: &Setting) -> Vec<Remark> {
    /// Steps per period of an oscillation below which it is not followed.
    const STEPS: f64 = 20.0;
    if !s.has_contacts {
        return Vec::new();
    }
    let (dt, radius) = (s.steps[0], s.smallest_radius());
    let mut remarks = Vec::new();
    for (i, wall) in s.case.walls.iter().enumerate() {
        let (key, speed) = match &wall.motion {
            Some(Motion::Translation { velocity, .. }) => ("velocity", Vec3::from(*velocity).norm()),
            Some(Motion::Oscillation { amplitude, frequency, .. }) => {
                if frequency * dt > 1.0 / STEPS {
                    let message = format!(
                        "{:.1} time steps per period: the wall jumps; lower it (Hz), or time.dt",
                        1.0 / (frequency * dt)
                    );
                    remarks.push((format!("wall[{i}].motion.frequency"), message));
                    continue;
                }
                ("amplitude", std::f64::consts::TAU * frequency * Vec3::from(*amplitude).norm())
            }
            Some(Motion::Rotation { angular_velocity, .. }) => {
                let reach = s.walls[i].surfaces.iter().map(reach).fold(0.0, f64::max).min(s.diagonal());
                ("angular_velocity", angular_velocity.abs() * reach)
            }
            None => continue,
        };
        if speed * dt > LONG_WAY * radius {
            let message = format!(
                "the wall goes {:.1} radii of the smallest particle per time step ({dt:.2e} s): it passes particles by; SI units are m, s and rad/s, or lower time.dt",
                speed * dt / radius
            );
            remarks.push((format!("wall[{i}].motion.{key}"), message));
        }
    }
    remarks
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

fn fine_step(s: &Setting) -> Vec<Remark> {
    /// "auto" over the step given.
    const USUAL: f64 = 1000.0;
    let [dt, recommended] = s.steps;
    let (TimeStep::Seconds(_), true) = (s.case.time.dt, s.has_moving_particles()) else { return Vec::new() };
    if recommended / dt <= USUAL {
        return Vec::new();
    }
    let message = format!(
        "{:.0} times shorter than \"auto\" ({recommended:.2e} s), and the run that much longer; times are in seconds",
        recommended / dt
    );
    vec![("time.dt".into(), message)]
}

fn many_steps(s: &Setting) -> Vec<Remark> {
    /// Steps of a run of years.
    const USUAL: f64 = 1e11;
    let steps = s.case.time.end / s.steps[0];
    if steps <= USUAL || !s.has_moving_particles() {
        return Vec::new();
    }
    vec![(
        "time.end".into(),
        format!("{steps:.1e} time steps of {:.1e} s take years; times are in seconds", s.steps[0]),
    )]
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
