//! The time step: what limits it, what is recommended, and whether the case's own will do.

use crate::bonds::BondReport;
use crate::insertion::KindRange;
use grains_case::{Case, TimeStep};
use grains_contact::{Collision, Sharing, reduced_mass};
use grains_dem::{Catalogue, SurfaceMobility};
use grains_geometry::DepthNorm;
use std::fmt;

/// What a particle collides with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partner {
    /// Another that moves freely.
    Free,
    /// A wall.
    Wall,
    /// A particle of prescribed motion, which is met as a wall is.
    Prescribed,
}

/// One collision that can happen in the case, and what it asks of the time step.
#[derive(Clone, Debug)]
pub struct Encounter {
    /// Names of the two materials; the second may be a wall's.
    pub materials: [String; 2],
    /// Number of their contact in the case.
    pub contact: usize,
    /// What the second body is.
    pub partner: Partner,
    /// Restitution.
    pub restitution: f64,
    /// Friction.
    pub friction: f64,
    /// Smallest radius among the bodies (m).
    pub radius: f64,
    /// Mass of the lighter of them (kg).
    pub mass: f64,
    /// Effective radius of the lightest bodies, as their law takes it (m).
    pub effective_radius: f64,
    /// Reduced mass of the lightest bodies (kg).
    pub reduced_mass: f64,
    /// Damping rate γ_n of these (1/s), at the largest overlap.
    pub damping_rate: f64,
    /// Their head-on collision at `time.impact_speed`.
    pub collision: Collision,
    /// Shortest contact time (s): off-centre impacts of bodies that are not spheres are shorter, and so are
    /// those of many parts at once whose forces add up.
    pub shortest_contact: f64,
    /// Largest stable step of the explicit tangential damping (s).
    pub tangential_limit: f64,
}

/// The chosen step and its reasons.
#[derive(Clone, Debug)]
pub struct TimeStepChoice {
    /// Time step (s).
    pub dt: f64,
    /// Step that the case's `steps_per_contact` asks for (s).
    pub recommended: f64,
    /// All collisions that can happen.
    pub encounters: Vec<Encounter>,
    /// What bonds come to.
    pub bonds: Vec<BondReport>,
    /// What decided the recommended step.
    pub reason: TimeStepReason,
    /// Warning about the step of the case.
    pub warning: Option<String>,
}

/// What decided a time step.
#[derive(Clone, Debug, PartialEq)]
pub enum TimeStepReason {
    /// The shortest contact time, which takes a number of steps.
    ContactTime {
        /// Contact time (s).
        time: f64,
        /// Names of the two materials.
        pair: [String; 2],
        /// Steps per contact, `time.steps_per_contact` (-).
        steps: f64,
    },
    /// Half the stability limit of explicit tangential damping.
    TangentialDamping {
        /// Stability limit (s).
        limit: f64,
        /// Names of the two materials.
        pair: [String; 2],
    },
    /// Half the shortest period of a bond, which takes a number of steps.
    BondPeriod {
        /// Half the period (s).
        time: f64,
        /// Name of the bonds.
        name: String,
        /// Steps in it, `time.steps_per_contact` (-).
        steps: f64,
    },
    /// The displacement of hard bodies per step at `time.impact_speed`.
    Displacement {
        /// Displacement over the smallest radius (-).
        over_radius: f64,
    },
    /// A fraction of the longest step of the fluid, as bodies of prescribed motion meet nothing.
    FractionOfFluidStep {
        /// Particle steps in the longest step of the fluid (-).
        steps: f64,
    },
    /// A thousandth of `time.end`, as nothing can touch.
    NoContact,
    /// The step given for a fluid alone.
    FluidStep,
    /// A tick of the clock, of which the step of a fluid alone is a multiple.
    Tick,
}

impl fmt::Display for TimeStepReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ContactTime { time, pair: [a, b], steps } => {
                write!(f, "shortest contact time {time:.4e} s ({a} - {b}) over {steps} steps")
            }
            Self::BondPeriod { time, name, steps } => {
                write!(f, "half the shortest period {time:.4e} s of bonds ({name}) over {steps} steps")
            }
            Self::TangentialDamping { limit, pair: [a, b] } => {
                write!(f, "half the stability limit {limit:.4e} s of tangential damping ({a} - {b})")
            }
            Self::Displacement { over_radius } => {
                write!(f, "{} % of the smallest radius per step at time.impact_speed", 100.0 * over_radius)
            }
            Self::FractionOfFluidStep { steps } => write!(
                f,
                "1/{steps} of the longest step of the fluid, as bodies of prescribed motion meet nothing"
            ),
            Self::NoContact => f.write_str("a thousandth of time.end, as nothing can touch"),
            Self::FluidStep => f.write_str("the step of the fluid"),
            Self::Tick => f.write_str("a tick of the clock; the fluid's step is a multiple of it"),
        }
    }
}

/// How finely a time step resolves collisions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resolution {
    /// Shortest contact time over the time step (-).
    StepsPerContact(f64),
    /// Displacement of hard bodies per step at `time.impact_speed` over the smallest radius (-).
    Displacement(f64),
}

impl fmt::Display for Resolution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StepsPerContact(steps) => write!(f, "T_c/dt = {steps:.2}"),
            Self::Displacement(over_radius) => {
                write!(f, "{:.2} % of the smallest radius at impact_speed", 100.0 * over_radius)
            }
        }
    }
}

impl TimeStepChoice {
    /// Shortest contact time, or half period of a bond, over the time step (-).
    fn steps_per_contact(&self) -> f64 {
        let contacts = self.encounters.iter().map(|e| e.shortest_contact);
        let bonds = self.bonds.iter().map(|bond| bond.half_period);
        contacts.chain(bonds).fold(f64::INFINITY, f64::min) / self.dt
    }

    /// How finely the step resolves collisions.
    pub fn resolution(&self, case: &Case) -> Resolution {
        match case.collisions.is_hard() {
            true => Resolution::Displacement(self.displacement_over_radius(case)),
            false => Resolution::StepsPerContact(self.steps_per_contact()),
        }
    }

    /// Displacement at the impact speed in one step over the smallest radius (-): the overlap of a hard collision.
    fn displacement_over_radius(&self, case: &Case) -> f64 {
        case.time.impact_speed * self.dt / smallest_radius(&self.encounters)
    }
}

fn smallest_radius(encounters: &[Encounter]) -> f64 {
    encounters.iter().map(|e| e.radius).fold(f64::INFINITY, f64::min)
}

/// The particles of a material that ask for the smallest step.
#[derive(Clone, Copy)]
struct Lightest {
    /// Smallest mass (kg).
    mass: f64,
    /// Inscribed radius (m) of the lightest particle, and that which laws take.
    radius: f64,
    contact_radius: f64,
    /// Smallest mass (kg) felt anywhere on the surface, 1/(n·K n).
    felt_mass: f64,
    /// Largest t·K t/(n·K n) anywhere on the surface (-).
    along_surface: f64,
    /// Contacts that may act at once as so many springs side by side.
    springs: f64,
}

/// Chooses the time step of a case for the kinds of particles it can insert.
///
/// # Errors
/// A given step below 5 steps per contact, or in which hard bodies exceed limits.overlap, unless the case
/// accepts it.
pub fn choose(case: &Case, catalogue: &Catalogue, kinds: &[KindRange]) -> Result<TimeStepChoice, String> {
    let encounters = encounters(case, catalogue, kinds);
    if case.collisions.is_hard() {
        return choose_for_impulses(case, encounters);
    }
    let wanted = case.time.steps_per_contact;
    let mut recommended = (f64::INFINITY, TimeStepReason::NoContact);
    for e in &encounters {
        let pair = || e.materials.clone();
        let by_contact = e.shortest_contact / wanted;
        if by_contact < recommended.0 {
            let reason =
                TimeStepReason::ContactTime { time: e.shortest_contact, pair: pair(), steps: wanted };
            recommended = (by_contact, reason);
        }
        if 0.5 * e.tangential_limit < recommended.0 {
            let reason = TimeStepReason::TangentialDamping { limit: e.tangential_limit, pair: pair() };
            recommended = (0.5 * e.tangential_limit, reason);
        }
    }
    let bonds = BondReport::of_all(case, catalogue, kinds);
    for bond in &bonds {
        let by_bond = bond.half_period / wanted;
        if by_bond < recommended.0 {
            let (time, name) = (bond.half_period, bond.name.clone());
            recommended = (by_bond, TimeStepReason::BondPeriod { time, name, steps: wanted });
        }
    }
    let (dt, reason) = recommended;
    let (dt, reason) = if dt.is_finite() { (dt, reason) } else { of_free_flight(case, kinds) };
    let mut choice = TimeStepChoice { dt, recommended: dt, encounters, bonds, reason, warning: None };
    match case.time.dt {
        TimeStep::Auto => choice.dt = rounded_down(dt),
        TimeStep::Seconds(given) => {
            choice.dt = given;
            judge(&mut choice, case.time.accept_coarse_dt).map_err(|e| case.about("time.dt", e))?;
            choice.warning = choice.warning.map(|w| case.about("time.dt", w));
        }
    }
    Ok(choice)
}

/// The step (s) that would be recommended if no kind had the finest tenth of its mass.
pub fn recommended_without_fines(case: &Case, catalogue: &Catalogue, kinds: &[KindRange]) -> Option<f64> {
    let mut case = case.clone();
    case.time.dt = TimeStep::Auto;
    let coarser: Vec<KindRange> =
        kinds.iter().map(|kind| KindRange { smallest: kind.tenth, ..*kind }).collect();
    choose(&case, catalogue, &coarser).ok().map(|choice| choice.recommended)
}

/// The step where particles meet nothing (s), and its reason; where the flow around driven bodies is resolved, short beside the
/// longest step of the fluid, which is a multiple of it.
fn of_free_flight(case: &Case, kinds: &[KindRange]) -> (f64, TimeStepReason) {
    /// Steps in the longest one of the fluid.
    const SHARE: f64 = 64.0;
    let usual = 1e-3 * case.time.end;
    let of_fluid = crate::fluid::max_body_time_step(case).map(|longest| longest / SHARE);
    match of_fluid.filter(|dt| *dt < usual && kinds.iter().all(|kind| kind.is_prescribed)) {
        Some(dt) => (dt, TimeStepReason::FractionOfFluidStep { steps: SHARE }),
        None => (usual, TimeStepReason::NoContact),
    }
}

/// The tick of the clock where there are no particles: the step given, or a small fraction of the shortest time between
/// outputs, of which a step of the fluid takes as many as it may.
pub fn of_fluid(case: &Case) -> TimeStepChoice {
    /// Ticks per output.
    const TICKS: f64 = 65536.0;
    /// Min. ticks per longest step of the fluid: flow may become that much faster than what is imposed.
    const MIN_PER_STEP: f64 = 1024.0;
    let out = &case.output;
    let fluid = case.fluid.as_ref().and_then(|f| f.output.interval);
    let times = [Some(out.particles), Some(out.series), Some(out.checkpoint), fluid];
    let shortest = times.into_iter().flatten().filter(|&t| t > 0.0).fold(case.time.end, f64::min);
    // Halved, so that outputs stay whole numbers of ticks, until the fluid's longest step has many.
    let longest = case.fluid.as_ref().map_or(f64::INFINITY, |f| crate::fluid::max_dt(case, f).step);
    let halvings = libm::log2(MIN_PER_STEP * shortest / (TICKS * longest)).ceil().max(0.0);
    let (dt, reason) = match case.time.dt {
        TimeStep::Seconds(given) => (given, TimeStepReason::FluidStep),
        TimeStep::Auto => (shortest / TICKS / libm::exp2(halvings), TimeStepReason::Tick),
    };
    TimeStepChoice { dt, recommended: dt, encounters: Vec::new(), bonds: Vec::new(), reason, warning: None }
}

/// Chooses the time step of hard collisions, which last no time: bodies must not get far into each other.
fn choose_for_impulses(case: &Case, encounters: Vec<Encounter>) -> Result<TimeStepChoice, String> {
    /// Way per step over the smallest radius that "auto" aims at.
    const WAY: f64 = 0.02;
    let way = WAY.min(0.2 * case.limits.overlap);
    let dt = way * smallest_radius(&encounters) / case.time.impact_speed;
    let dt = if dt.is_finite() { dt } else { 1e-3 * case.time.end };
    let reason = TimeStepReason::Displacement { over_radius: way };
    let bonds = Vec::new();
    let mut choice = TimeStepChoice { dt, recommended: dt, encounters, bonds, reason, warning: None };
    let TimeStep::Seconds(given) = case.time.dt else {
        choice.dt = rounded_down(dt);
        return Ok(choice);
    };
    choice.dt = given;
    let (overlap, limit) = (choice.displacement_over_radius(case), case.limits.overlap);
    let message = format!(
        "bodies at time.impact_speed = {} m/s get {:.1} % of the smallest radius into each other in one step, limits.overlap is {:.1} %; take \"auto\" or at most {:.2e}",
        case.time.impact_speed,
        100.0 * overlap,
        100.0 * limit,
        rounded_down(dt)
    );
    if overlap > limit && !case.time.accept_coarse_dt {
        return Err(case.about("time.dt", format!("{message}, or set time.accept_coarse_dt = true")));
    }
    choice.warning = (overlap > 0.5 * limit).then(|| case.about("time.dt", message));
    Ok(choice)
}

/// A step with two leading digits: easier to read, and to repeat.
fn rounded_down(dt: f64) -> f64 {
    let unit = libm::pow(10.0, libm::log10(dt).floor() - 1.0);
    format!("{:.1e}", (dt / unit).floor() * unit).parse().unwrap_or(dt)
}

fn judge(choice: &mut TimeStepChoice, accept_coarse: bool) -> Result<(), String> {
    let ratio = choice.steps_per_contact();
    let remedy = format!("take \"auto\" or at most {:.2e}", rounded_down(choice.recommended));
    let limit = choice.encounters.iter().map(|e| e.tangential_limit).fold(f64::INFINITY, f64::min);
    if choice.dt > limit {
        return Err(format!("beyond the stability limit {limit:.3e} s of the tangential damping; {remedy}"));
    }
    if ratio < 5.0 && !accept_coarse {
        return Err(format!(
            "only {ratio:.2} steps per contact, below 5; {remedy}, or set time.accept_coarse_dt = true"
        ));
    }
    if ratio < 10.0 {
        choice.warning = Some(format!("{ratio:.2} steps per contact, below the usual 10; {remedy}"));
    }
    Ok(())
}

fn encounters(case: &Case, catalogue: &Catalogue, kinds: &[KindRange]) -> Vec<Encounter> {
    let [lightest, held] = [false, true].map(|is_prescribed| {
        let of = kinds.iter().filter(|kind| kind.is_prescribed == is_prescribed).copied().collect::<Vec<_>>();
        lightest(case, catalogue, &of)
    });
    let is_alone = kinds.iter().all(|kind| kind.is_alone);
    let name = |m: usize| case.materials[m].name.clone();
    let mut found = Vec::new();
    for (number, contact) in case.contacts.iter().enumerate() {
        let [a, b] = contact.between;
        let law = catalogue.contacts.law(a as u16, b as u16);
        let mut add = |materials: [usize; 2], partner: Partner, body: Lightest, other: Option<Lightest>| {
            let reduced = other.map_or(body.mass, |o| reduced_mass(body.mass, o.mass));
            let felt = other.map_or(body.felt_mass, |o| reduced_mass(body.felt_mass, o.felt_mass));
            let share = other.map_or(body.along_surface, |o| body.along_surface.max(o.along_surface));
            let springs = other.map_or(body.springs, |o| body.springs.max(o.springs));
            let contact_radius =
                other.map_or(body.contact_radius, |o| reduced_mass(body.contact_radius, o.contact_radius));
            let speed = case.time.impact_speed;
            let collision = law.collision(reduced, contact_radius, speed);
            let off_centre = law.collision(felt, contact_radius, speed);
            // The slip of a sphere decays at 7/2 of the rate of tangential damping: its spin helps (errata R16-21).
            let rate = law.tangential_rate(felt, collision.stiffness);
            found.push(Encounter {
                materials: materials.map(name),
                contact: number,
                partner,
                restitution: law.restitution,
                reduced_mass: reduced,
                damping_rate: law.damping_rate(reduced, collision.stiffness),
                friction: law.friction,
                radius: other.map_or(body.radius, |o| body.radius.min(o.radius)),
                mass: other.map_or(body.mass, |o| body.mass.min(o.mass)),
                effective_radius: contact_radius,
                shortest_contact: off_centre.shortest_time / springs.sqrt(),
                tangential_limit: if rate > 0.0 { 1.0 / (share * rate) } else { f64::INFINITY },
                collision,
            });
        };
        if let (Some(body), Some(other), false) = (lightest[a], lightest[b], is_alone) {
            add([a, b], Partner::Free, body, Some(other));
        }
        let is_wall = |m: usize| case.walls.iter().any(|w| w.material == m);
        let mut sides = vec![[a, b], [b, a]];
        sides.dedup();
        for [m, wall] in sides {
            let Some(body) = lightest[m] else { continue };
            if is_wall(wall) {
                add([m, wall], Partner::Wall, body, None);
            }
            if let Some(other) = held[wall] {
                let (radius, springs) = (body.radius.min(other.radius), body.springs.max(other.springs));
                add([m, wall], Partner::Prescribed, Lightest { radius, springs, ..body }, None);
            }
        }
    }
    found
}

/// The lightest particles of each material.
fn lightest(case: &Case, catalogue: &Catalogue, kinds: &[KindRange]) -> Vec<Option<Lightest>> {
    let mut lightest: Vec<Option<Lightest>> = vec![None; case.materials.len()];
    let mobilities: Vec<_> = catalogue.shapes.iter().map(SurfaceMobility::of).collect();
    let mut consider = |material: usize, shape: usize, scale: f64| {
        let form = &catalogue.shapes[shape];
        let mass = catalogue.densities[material] * form.volume * scale.powi(3);
        let SurfaceMobility { along_normal, along_surface } = mobilities[shape];
        let felt_mass = mass / along_normal;
        let (radius, contact_radius) = (form.inscribed_radius * scale, form.part_radius() * scale);
        let springs = match catalogue.sharing {
            Sharing::Potential => DepthNorm::stiffening(form.parts.len()),
            Sharing::Mean => 1.0,
            Sharing::Sum => form.parts.len() as f64,
        };
        let new = Lightest { mass, radius, contact_radius, felt_mass, along_surface, springs };
        let known = lightest[material].get_or_insert(new);
        if mass < known.mass {
            (known.mass, known.radius, known.contact_radius) = (mass, radius, contact_radius);
        }
        known.felt_mass = known.felt_mass.min(felt_mass);
        known.along_surface = known.along_surface.max(along_surface);
        known.springs = known.springs.max(springs);
    };
    for range in kinds {
        consider(range.kind.material as usize, range.kind.shape as usize, range.smallest);
    }
    lightest
}
