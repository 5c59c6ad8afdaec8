//! From a checked case to a granular system.

use crate::bonds;
use crate::error::RunError;
use crate::fluid;
use crate::heat;
use crate::insertion::KindRange;
use crate::laws;
use crate::liquid;
use crate::shapes::shape;
use crate::species;
use crate::timestep::{self, TimeStepChoice};
use crate::wall_surfaces::surfaces;
use grains_case::{
    Case, Composite, Exchange, Faces, ImpulseScheme as CaseScheme, Motion as CaseMotion, Shear as CaseShear,
};
use grains_comm::{Job, MpiTransport, cartesian};
use grains_contact::{ImpulseScheme, Sharing};
use grains_dem::{
    Catalogue, CollisionModel, ContactTable, Dem, DemSetup, ExchangeStrategy, FaceContact, FlowPlane,
    HardModel, Loading, Motion, MotionTable, Shear, Skin, StepParameters, Wall, WallHeat, Wear,
};
use grains_domain::{Balance, GlobalBox, choose_ranks};
use grains_geometry::Vec3;
use std::sync::Arc;

/// When borders between subdomains move.
const BALANCE: (u64, f64) = (200, 1.1);

/// A system ready to be filled, and how its time step was chosen.
pub struct System {
    /// Definition for the solver.
    pub setup: DemSetup,
    /// The time step and its limits.
    pub step: TimeStepChoice,
}

/// Builds the system of a case for a number of ranks, with its catalogue and the kinds of particles it can insert.
///
/// # Errors
/// Meshes or a time step that cannot be used, naming key, value and remedy.
pub fn build(
    case: &Case,
    ranks: usize,
    mut catalogue: Catalogue,
    kinds: &[KindRange],
) -> Result<System, String> {
    liquid::wet(case, &mut catalogue, kinds);
    let domain = &case.domain;
    let global = GlobalBox::new(domain.lower, domain.upper, domain.periodic);
    resolved_positions(case, &global, &catalogue, kinds)?;
    // Fixed particles touch nobody, however close or large they are.
    let largest_radius = if case.holds_particles() { 0.0 } else { largest_radius(&catalogue, kinds) };
    let step = match case.inserts.is_empty() || case.holds_particles() {
        true => timestep::of_fluid(case),
        false => timestep::choose(case, &catalogue, kinds)?,
    };
    let gravity = Vec3::from(case.gravity);
    // Fixed particles have no lubrication.
    let lubrication = fluid::lubrication(case).filter(|_| largest_radius > 0.0);
    let reach = lubrication.map_or(0.0, |lubrication| lubrication.range);
    let reach = reach.max(catalogue.contacts.reach_up_to(largest_radius));
    let mut thermal = heat::thermal(case, &catalogue);
    if let Some(thermal) = &mut thermal {
        let rate = heat::largest_rate(case, &catalogue, thermal, kinds);
        thermal.every = heat::interval(case, rate, step.dt);
    }
    let reach = reach.max(thermal.as_ref().map_or(0.0, |thermal| thermal.reach(largest_radius)));
    let skin = skin(case, largest_radius, reach);
    let kinds_of_bonds = bonds::kinds(case);
    let longest_bond = kinds_of_bonds.iter().map(|kind| kind.longest(largest_radius)).fold(0.0, f64::max);
    let range = (2.0 * largest_radius * (1.0 + skin.max) + reach).max(longest_bond);
    let shear = domain.shear.map(shear);
    let of_fluid = fluid::min_widths(case, &catalogue, kinds, skin.max * largest_radius)?;
    let mut min_width = of_fluid.map(|width| width.max(2.0 * range));
    if let Some(shear) = &shear {
        min_width[shear.flow] = f64::INFINITY;
    }
    let ranks = match domain.ranks {
        Some(given) => given.map(|n| n as usize),
        None => choose_ranks(&global, ranks, min_width, case.gravity),
    };
    if let Some(shear) = &shear {
        check_shear(case, shear, (&global, ranks), (step.dt, largest_radius))?;
    }
    let mut outlets = [false; 6];
    for face in &domain.outlets {
        outlets[2 * face.axis() + usize::from(face.is_upper())] = true;
    }
    let planes = case.flow_planes.iter().map(|p| FlowPlane {
        name: p.name.clone(),
        point: Vec3::from(p.point),
        normal: Vec3::from(p.normal),
    });
    let parameters = StepParameters { gravity, dt: step.dt };
    // Where nothing but a fluid moves its cells are shared out evenly from the beginning.
    let moves = domain.balance && largest_radius > 0.0;
    let (interval, threshold) = BALANCE;
    let balance =
        moves.then(|| Balance { min_width: of_fluid.map(|width| width.max(range)), interval, threshold });
    let setup = DemSetup {
        walls: walls(case, &global)?,
        planes: planes.collect(),
        parameters,
        collisions: collisions(case, &parameters),
        overlap_limit: case.limits.overlap,
        global,
        shear,
        outlets,
        ranks,
        catalogue,
        largest_radius,
        skin,
        bonds: kinds_of_bonds,
        lubrication,
        prescribed: Vec::new(),
        exchange: exchange(domain.exchange),
        // A step of the fluid is one of all ranks anyway.
        rebuilds_together: case.fluid.is_some(),
        balance,
        thermal,
        species: species::all(case),
    };
    resolved_loads(case, &setup, kinds)?;
    bonds::check_sizes(case, &setup)?;
    Ok(System { setup, step })
}

/// The shear of a case.
fn shear(given: CaseShear) -> Shear {
    Shear { flow: given.flow as usize, gradient: given.gradient as usize, rate: given.rate }
}

/// Refuses a flow axis that is divided, and images that slide past particles unseen in a step of `dt` (s).
fn check_shear(
    case: &Case,
    shear: &Shear,
    (global, ranks): (&GlobalBox, [usize; 3]),
    (dt, largest_radius): (f64, f64),
) -> Result<(), String> {
    if ranks[shear.flow] != 1 {
        let axis = ['x', 'y', 'z'][shear.flow];
        let message = format!(
            "the ranks of this job cannot be arranged without dividing {axis}, the axis of the flow: take another number of ranks"
        );
        return Err(case.about("domain.shear", message));
    }
    let way = (shear.rate * global.length(shear.gradient)).abs() * dt;
    if way > largest_radius {
        let message = format!(
            "images slide {way:.2e} m in a time step, more than the radius of the largest particle ({largest_radius:.2e} m): lower time.dt to {:.1e} s, or the rate",
            dt * largest_radius / way
        );
        return Err(case.about("domain.shear.rate", message));
    }
    Ok(())
}

fn exchange(given: Exchange) -> ExchangeStrategy {
    match given {
        Exchange::AllGatherGlobal => ExchangeStrategy::AllGatherGlobal,
        Exchange::AllGatherLocal => ExchangeStrategy::AllGatherLocal,
        Exchange::AllGatherLocalNonblocking => ExchangeStrategy::AllGatherLocalNonblocking,
        Exchange::SendRecvLocalGeoloc => ExchangeStrategy::SendRecvLocalGeoloc,
        Exchange::Persistent => ExchangeStrategy::Persistent,
    }
}

/// The granular phase of one rank, without particles.
///
/// # Errors
/// A domain that cannot be divided like this.
pub fn dem(case: &Case, setup: DemSetup, rank: usize) -> Result<Dem, String> {
    let mut dem = Dem::new(setup, rank).map_err(|e| case.about("domain", e.to_string()))?;
    if let Some(nodes) = fluid::shared_nodes(case)? {
        dem.share_cells(&nodes);
    }
    Ok(dem)
}

/// The ranks of the job as the Cartesian grid of a system.
///
/// # Errors
/// A number of ranks per axis that is not that of the job.
pub fn transport(case: &Case, setup: &DemSetup, job: &Job) -> Result<MpiTransport, RunError> {
    let (product, size) = (setup.ranks.iter().product::<usize>(), job.size());
    if product != size {
        let message = format!(
            "makes {product} subdomains for {size} ranks: start mpirun with -n {product}, or change or remove the key"
        );
        return Err(RunError::case(case.about("domain.ranks", message)));
    }
    let widths = std::array::from_fn(|a| setup.global.length(a) / setup.ranks[a] as f64);
    Ok(MpiTransport::new(cartesian(job.world(), setup.ranks, widths)))
}

/// Shapes, densities and laws of a case.
///
/// # Errors
/// A shape that cannot be built.
pub fn catalogue(case: &Case) -> Result<Catalogue, String> {
    countable(case)?;
    let mut contacts = ContactTable::new(case.materials.len());
    for contact in &case.contacts {
        let [a, b] = contact.between;
        contacts.set(a, b, laws::law(case, contact));
    }
    let shapes = case.shapes.iter().enumerate();
    let shapes = shapes.map(|(k, s)| {
        let built = shape(s, &case.meshes).and_then(|built| match built.parts.len() {
            parts if parts > MAX_COUNT => Err(format!("parts: {}", too_many(parts))),
            _ => Ok(built),
        });
        built.map_err(|e| case.about(&format!("shape[{k}]"), e))
    });
    let shapes = shapes.collect::<Result<Vec<_>, _>>()?;
    let densities = case.materials.iter().map(|m| m.density.unwrap_or(f64::NAN)).collect();
    let faces = match case.contact_points.faces {
        Faces::Point => FaceContact::Point,
        Faces::Patch => FaceContact::MultiPoint,
    };
    let sharing = match case.contact_points.composite {
        Composite::Potential => Sharing::Potential,
        Composite::Mean => Sharing::Mean,
        Composite::Sum => Sharing::Sum,
    };
    Ok(Catalogue { shapes, densities, contacts, faces, sharing })
}

/// Refuses more shapes, materials, walls or parts of one body than their numbers can count.
fn countable(case: &Case) -> Result<(), String> {
    let of = [("shape", case.shapes.len()), ("material", case.materials.len()), ("wall", case.walls.len())];
    match of.into_iter().find(|(_, count)| *count > MAX_COUNT) {
        Some((key, count)) => Err(case.about(key, too_many(count))),
        None => Ok(()),
    }
}

/// Shapes, materials, walls, surfaces of a wall and parts of a body are numbered in 16 bits.
const MAX_COUNT: usize = u16::MAX as usize;

fn too_many(count: usize) -> String {
    format!("{count} of them; at most {MAX_COUNT} can be told apart")
}

fn collisions(case: &Case, rates: &StepParameters) -> CollisionModel {
    let given = &case.collisions;
    if case.holds_particles() {
        return CollisionModel::Fixed;
    }
    if !given.is_hard() {
        return CollisionModel::Soft;
    }
    let default = HardModel::new(rates);
    CollisionModel::Hard(HardModel {
        scheme: match given.scheme.unwrap_or_default() {
            CaseScheme::Sequential => ImpulseScheme::Sequential,
            CaseScheme::Exact => ImpulseScheme::Exact,
        },
        sweeps: given.sweeps.map_or(default.sweeps, |sweeps| sweeps as u32),
        rest_speed: given.rest_speed.unwrap_or(default.rest_speed),
    })
}

/// Largest bounding radius any particle of the case can have (m).
fn largest_radius(catalogue: &Catalogue, kinds: &[KindRange]) -> f64 {
    kinds.iter().map(|k| catalogue.shape(k.kind).bounding_radius * k.largest).fold(0.0, f64::max)
}

/// Refuses a box so large that its positions, multiples of one length, are too coarse for contacts of its particles.
fn resolved_positions(
    case: &Case,
    global: &GlobalBox,
    catalogue: &Catalogue,
    kinds: &[KindRange],
) -> Result<(), String> {
    /// Largest spacing of positions over the smallest inscribed radius (-).
    const COARSEST: f64 = 1e-8;
    let radius = |k: &KindRange| catalogue.shape(k.kind).inscribed_radius * k.smallest;
    let (spacing, smallest) = (global.quantum.size(), kinds.iter().map(radius).fold(f64::INFINITY, f64::min));
    if spacing <= COARSEST * smallest {
        return Ok(());
    }
    let message = format!(
        "positions in a domain of this size are multiples of {spacing:.1e} m, too coarse for particles with an inscribed radius of {smallest:.1e} m: make the domain smaller, at most {:.0e} radii wide, or check the unit of the radius",
        COARSEST * 2.0_f64.powi(53)
    );
    Err(case.about("domain.upper", message))
}

/// How many of the multiples to which contact forces are rounded make up the weight of the smallest particle, and how many
/// of those of torques its weight times its inscribed radius; nothing if it has no weight or feels no contact force.
pub fn quanta_of_weight(case: &Case, setup: &DemSetup, kinds: &[KindRange]) -> Option<[f64; 2]> {
    let gravity = Vec3::from(case.gravity).norm();
    if setup.collisions != CollisionModel::Soft
        || setup.catalogue.contacts.laws().next().is_none()
        || gravity == 0.0
    {
        return None;
    }
    let [force, torque] = setup.load_quanta();
    let of_kind = |k: &KindRange| {
        let weight = gravity * setup.catalogue.mass(k.kind, k.smallest);
        let radius = setup.catalogue.shape(k.kind).inscribed_radius * k.smallest;
        [weight / force, weight * radius / torque]
    };
    kinds.iter().map(of_kind).reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1])])
}

/// Refuses particles so small beside the largest and its stiffness that rounded forces would not carry them.
fn resolved_loads(case: &Case, setup: &DemSetup, kinds: &[KindRange]) -> Result<(), String> {
    /// Smallest weight in multiples of the rounding (-).
    const COARSEST: f64 = 1e3;
    let Some([force, torque]) = quanta_of_weight(case, setup, kinds) else { return Ok(()) };
    if force >= COARSEST && torque >= COARSEST {
        return Ok(());
    }
    let message = format!(
        "forces are rounded to multiples that follow the stiffest contact or bond of the largest particle, or the largest load on a wall, and the weight of the smallest particle is {force:.1e} of them (its torque {torque:.1e}), fewer than {COARSEST:.0e}: lower the stiffness, the load, or the ratio of the largest to the smallest particle"
    );
    let force = |k: &usize| {
        let [a, b] = case.contacts[*k].between.map(|m| m as u16);
        let normal = setup.catalogue.contacts.law(a, b).normal;
        normal.force_bound(setup.largest_radius, setup.overlap_limit * setup.largest_radius)
    };
    let stiffest = (0..case.contacts.len()).max_by(|a, b| force(a).total_cmp(&force(b))).unwrap_or(0);
    let of_bond = |k: &usize| setup.bonds[*k].force_bound(setup.largest_radius);
    let stiffest_bond = (0..setup.bonds.len()).max_by(|a, b| of_bond(a).total_cmp(&of_bond(b)));
    if let Some(k) = stiffest_bond.filter(|k| of_bond(k) > force(&stiffest)) {
        return Err(case.about(&format!("bond[{k}].youngs_modulus"), message));
    }
    let key = match case.contacts[stiffest].normal.is_hertzian() {
        true => format!("contact[{stiffest}].normal"),
        false => format!("contact[{stiffest}].normal_stiffness"),
    };
    Err(case.about(&key, message))
}

/// How far particles may go before lists are rebuilt, where bodies act on each other over gaps up to `reach` (m).
fn skin(case: &Case, largest_radius: f64, reach: f64) -> Skin {
    let mut skin = Skin::default();
    // A narrow periodic box leaves less room: images of a particle must be out of each other's neighbours' reach.
    let periodic = (0..3).filter(|&a| case.domain.periodic[a]);
    let half = |a: usize| 0.5 * (case.domain.upper[a] - case.domain.lower[a]);
    let room = periodic.map(|a| (half(a) - reach) / (2.0 * largest_radius) - 1.0);
    let room = 0.999 * room.fold(f64::INFINITY, f64::min);
    if room > skin.min {
        skin.max = skin.max.min(room);
    }
    if let Some(distance) = case.neighbours.skin.filter(|_| largest_radius > 0.0) {
        // The case gives the distance of two bodies; each may use up half of it.
        skin.max = 0.5 * distance / largest_radius;
        skin.min = skin.min.min(skin.max);
    }
    if let Some(steps) = case.neighbours.horizon {
        skin.horizon = steps as f64;
    }
    skin
}

fn walls(case: &Case, global: &GlobalBox) -> Result<Vec<Wall>, String> {
    let mut walls = Vec::new();
    for (i, wall) in case.walls.iter().enumerate() {
        let (surfaces, extents) =
            surfaces(&wall.kind, &case.meshes).map_err(|e| case.about(&format!("wall[{i}]"), e))?;
        if surfaces.len() > MAX_COUNT {
            return Err(case.about(&format!("wall[{i}]"), format!("surfaces: {}", too_many(surfaces.len()))));
        }
        let reaches = |a: usize| {
            extents.map_or([false; 2], |(lower, upper)| {
                [lower[a] <= global.lower[a], upper[a] >= global.upper[a]]
            })
        };
        let spans = std::array::from_fn(|a| global.periodic[a] && reaches(a) == [true; 2]);
        let crosses = |a: usize| {
            extents.is_some_and(|(lower, upper)| lower[a] < global.lower[a] || upper[a] > global.upper[a])
        };
        if let Some(a) = (0..3).find(|&a| global.periodic[a] && crosses(a) && !spans[a]) {
            let axis = ['x', 'y', 'z'][a];
            let message = format!(
                "crosses one periodic face across {axis}: keep it inside the domain, or let it reach over all of it on both sides"
            );
            return Err(case.about(&format!("wall[{i}]"), message));
        }
        walls.push(Wall {
            name: wall.name.clone(),
            material: wall.material as u16,
            surfaces,
            motion: wall.motion.as_ref().map_or(Motion::Fixed, motion),
            from: wall.from,
            until: wall.until,
            spans,
            heat: wall.temperature.map(WallHeat::Temperature).or(wall.heating.map(WallHeat::Power)),
            wear: wall.wear.map(|wear| Wear { coefficient: wear.coefficient, hardness: wear.hardness }),
        });
    }
    Ok(walls)
}

/// A motion of a case; one that turns bodies about their own centres has an axis through the origin.
pub fn motion(motion: &CaseMotion) -> Motion {
    match *motion {
        CaseMotion::Table { ref rows, point, axis, .. } => {
            let rows: Vec<_> =
                rows.iter().map(|row| (row.time, Vec3::from(row.displacement), row.angle)).collect();
            let point = point.map_or_else(Vec3::zeros, Vec3::from);
            Motion::Table(Arc::new(MotionTable::new(&rows, point, axis.map_or_else(Vec3::z, Vec3::from))))
        }
        CaseMotion::Translation { velocity, start, end } => {
            Motion::Translation { velocity: Vec3::from(velocity), start, end }
        }
        CaseMotion::Oscillation { amplitude, frequency, phase, start, end } => {
            Motion::Oscillation { amplitude: Vec3::from(amplitude), frequency, phase, start, end }
        }
        CaseMotion::Rotation { point, axis, angular_velocity, start, end } => Motion::Rotation {
            point: point.map_or_else(Vec3::zeros, Vec3::from),
            axis: Vec3::from(axis),
            rate: angular_velocity,
            start,
            end,
        },
        CaseMotion::Load { axis, mass, damping, max_speed, velocity, start, end, .. } => {
            let force = motion.load().unwrap_or(0.0);
            let (axis, velocity) = (Vec3::from(axis), Vec3::from(velocity));
            Motion::Loaded(Loading { axis, force, mass, damping, max_speed, velocity, start, end })
        }
    }
}
