//! The granular phase of one rank and its step.

mod observe;
mod rebuild;

use crate::bodies;
use crate::error::vector;
use crate::exchange::Exchange;
use crate::forces::{LoadLattice, Tally};
use crate::guide::{Course, Guide};
use crate::hard::{CollisionModel, Collisions, HardModel, Site};
use crate::integrate::{self, Rates};
use crate::lubrication;
use crate::measure::{self, Crossings, FlowPlane};
use crate::memory::Memories;
use crate::neighbours::{Inner, Neighbours, Skin};
use crate::passing;
use crate::spheres;
use crate::walls::{self, Motion, Wall, WallLoad, WallPlace, WallScene, WallState};
use crate::{
    Body, Cargo, Catalogue, Clock, ExchangeStrategy, Load, ParticleRecord, Particles, Phase, StepError,
};
use grains_contact::Lubrication;
use grains_domain::{
    Balance, Decomposition, DecompositionError, GlobalBox, OtherWork, Transport, WorkProfile,
};
use grains_geometry::Vec3;
pub(crate) use observe::bytes;
pub use observe::{MemoryUse, Partner, Touch};

/// Everything that defines a granular system, apart from its particles.
#[derive(Clone, Debug)]
pub struct DemSetup {
    /// The box.
    pub global: GlobalBox,
    /// Faces −x, +x, −y, +y, −z, +z through which particles may leave.
    pub outlets: [bool; 6],
    /// Ranks per axis.
    pub ranks: [usize; 3],
    /// Shapes, materials, laws.
    pub catalogue: Catalogue,
    /// Walls.
    pub walls: Vec<Wall>,
    /// Planes through which particles are counted.
    pub planes: Vec<FlowPlane>,
    /// Gravity and time step.
    pub rates: Rates,
    /// Largest bounding radius of any particle (m).
    pub largest_radius: f64,
    /// Largest admissible overlap over inscribed radius (-).
    pub overlap_limit: f64,
    /// Verlet skin.
    pub skin: Skin,
    /// What happens when bodies meet.
    pub collisions: CollisionModel,
    /// Films of fluid between spheres.
    pub lubrication: Option<Lubrication>,
    /// What prescribes the motion of some particles; [`Dem::guide`] changes it.
    pub guides: Vec<Guide>,
    /// How clones are brought up to date.
    pub exchange: ExchangeStrategy,
    /// When borders between subdomains move; they stay if there is none.
    pub balance: Option<Balance>,
}

impl DemSetup {
    /// Distance (m) of the centres up to which particles may act on each other before lists are rebuilt.
    pub fn interaction_range(&self) -> f64 {
        2.0 * self.largest_radius * (1.0 + self.skin.most) + self.film()
    }

    /// The multiples to which forces (N) and torques (N m) of contacts are rounded, so that their sums are exact.
    pub fn load_quanta(&self) -> [f64; 2] {
        self.load_lattice().quanta()
    }

    fn load_lattice(&self) -> LoadLattice {
        // Without particles, as beside a fluid alone, there are no loads.
        let radius = if self.largest_radius > 0.0 { self.largest_radius } else { 1.0 };
        LoadLattice::new(&self.catalogue.contacts, radius, self.overlap_limit)
    }

    /// Thickness (m) of the films that act.
    fn film(&self) -> f64 {
        self.lubrication.map_or(0.0, |film| film.range)
    }
}

/// Why a step could not be done; the same kind of answer on every rank.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure {
    /// This rank met the error.
    Here(StepError),
    /// Another rank did.
    Elsewhere,
}

/// What the last evaluation of the contacts found on this rank.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepReport {
    /// Largest overlap over inscribed radius (-).
    pub largest_overlap: f64,
    /// Largest of these since the start (-).
    pub worst_overlap: f64,
    /// Contacts since the start that the penetration routine had to resolve.
    pub cores_met: u64,
    /// Rebuilds of the lists since the start.
    pub rebuilds: u64,
    /// Those of them before which borders between subdomains moved.
    pub moves: u64,
    /// Work until the last rebuild, in pairs of spheres.
    pub work: u64,
    /// Hard collisions since the start, each counted on one rank.
    pub collisions: u64,
    /// Those of them whose restitution was taken as 0: the bodies rest on each other.
    pub resting_collisions: u64,
    /// Rounds since the start in which hard collisions were worked off, the same on all ranks.
    pub rounds: u64,
}

/// What the ranks agree on after a step: the highest level wins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    Fine,
    Stale,
    Interrupted,
    Failed,
}

/// Whom contacts are with.
#[derive(Clone, Copy)]
enum With {
    Owned,
    Clones,
}

/// From where time is counted: t = `time` + (n − `step`) Δt at step n; other than zero after the time step has changed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Origin {
    /// Step.
    pub step: u64,
    /// Time then (s).
    pub time: f64,
}

impl Origin {
    /// Time (s) of a step.
    pub fn time_of(&self, step: u64, dt: f64) -> f64 {
        self.time + (step - self.step) as f64 * dt
    }

    /// The step nearest to a time (s).
    pub fn step_at(&self, time: f64, dt: f64) -> u64 {
        (self.step as f64 + ((time - self.time) / dt).round()) as u64
    }
}

/// Particles in and out, summed over this rank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ledger {
    /// Particles inserted since the case began.
    pub inserted: u64,
    /// Particles that left through outlets.
    pub left: u64,
}

/// Particles with cargo that came and went on this rank, until they are taken: whoever moves them between the phases has to
/// know.
#[derive(Clone, Debug, Default)]
pub struct Passages {
    /// Where they were inserted.
    pub inserted: Vec<Body>,
    /// Where they left through an outlet, with what they carried.
    pub left: Vec<(Body, Cargo)>,
}

/// The granular phase of one rank.
#[derive(Debug)]
pub struct Dem {
    /// Definition of the system.
    pub setup: DemSetup,
    /// Division of the box.
    pub decomposition: Decomposition,
    /// Particles of this rank.
    pub particles: Particles,
    /// Steps done.
    pub step: u64,
    /// From where time is counted.
    pub origin: Origin,
    /// Places of the walls before they move; none for those that lie where the case has them.
    pub wall_places: Vec<Option<WallPlace>>,
    /// Particles in and out on this rank.
    pub ledger: Ledger,
    /// Particles with cargo that came and went, until they are taken.
    pub passages: Passages,
    /// Time by phase.
    pub clock: Clock,
    /// Loads on the walls by this rank's particles.
    pub wall_loads: Vec<WallLoad>,
    /// Whether some rank was asked to stop: set it on any rank, read it on all after [`Dem::advance`].
    pub interrupt: bool,
    /// Result of the last force evaluation.
    pub report: StepReport,
    /// What else borders between subdomains share out when they move.
    pub other_work: OtherWork,
    lattice: LoadLattice,
    exchange: Exchange,
    neighbours: Neighbours,
    memories: Memories,
    collisions: Collisions,
    crossings: Vec<Crossings>,
    states: Vec<WallState>,
    /// Whether `memories` holds what the pairs remember, and the lists are to be rebuilt.
    gathered: bool,
    stale: bool,
    steps_since_build: u64,
    work: WorkProfile,
    /// First step at which the work is looked at again.
    next_balance: u64,
    /// Steps from a build after which walls may have used up their allowance.
    wall_steps: u64,
    error: Option<StepError>,
}

impl Dem {
    /// System without particles on one rank of `ranks[0] ranks[1] ranks[2]`.
    pub fn new(setup: DemSetup, rank: usize) -> Result<Self, DecompositionError> {
        let range = setup.interaction_range();
        let decomposition = Decomposition::new(setup.global.clone(), setup.ranks, rank, range)?;
        let mut dem = Self {
            particles: Particles::new(setup.catalogue.all_spheres()),
            step: 0,
            origin: Origin::default(),
            wall_places: vec![None; setup.walls.len()],
            ledger: Ledger::default(),
            passages: Passages::default(),
            clock: Clock::default(),
            wall_loads: vec![WallLoad::default(); setup.walls.len()],
            interrupt: false,
            report: StepReport::default(),
            other_work: OtherWork::default(),
            lattice: setup.load_lattice(),
            exchange: Exchange::new(&decomposition, setup.outlets, setup.exchange),
            neighbours: Neighbours::default(),
            memories: Memories::default(),
            collisions: Collisions::default(),
            crossings: vec![Crossings::default(); setup.planes.len()],
            states: Vec::new(),
            gathered: true,
            stale: true,
            steps_since_build: 0,
            work: WorkProfile::default(),
            next_balance: 0,
            wall_steps: u64::MAX,
            error: None,
            decomposition,
            setup,
        };
        dem.place_walls();
        let guides = std::mem::take(&mut dem.setup.guides);
        dem.guide(guides);
        Ok(dem)
    }

    /// Prescribes the motion of some particles; to be called on all ranks alike, before there are any.
    pub fn guide(&mut self, guides: Vec<Guide>) {
        self.particles.guided = guides.iter().map(|guide| guide.ids.clone()).collect();
        self.setup.guides = guides;
    }

    /// Time of the present positions (s).
    pub fn time(&self) -> f64 {
        self.origin.time_of(self.step, self.setup.rates.dt)
    }

    /// Continues from a step, as after a restart: the walls take their places.
    pub fn resume_at(&mut self, step: u64) {
        self.step = step;
        self.place_walls();
    }

    /// Moves a wall otherwise from now on, from where it is; all ranks must do so together.
    pub fn set_wall_motion(&mut self, wall: usize, motion: Motion) {
        let pose = self.states[wall].pose();
        self.wall_places[wall] = WallPlace::between(&motion.at(self.time()), &pose);
        self.setup.walls[wall].motion = motion;
        self.place_walls();
        // How long the lists are good depends on how fast walls move.
        self.stale = true;
    }

    /// Moves the borders between ranks so that they share cells between nodes (m) by number, see
    /// [`Decomposition::share_cells`]; before there are particles.
    pub fn share_cells(&mut self, nodes: &[Vec<f64>; 3]) {
        self.decomposition.share_cells(nodes);
        self.exchange.divide(&self.decomposition);
    }

    /// Whether this rank owns a position inside the box.
    pub fn owns(&self, position: &Vec3) -> bool {
        let rank = self.decomposition.rank_at(self.decomposition.coordinates);
        self.decomposition.owner((*position).into()) == rank
    }

    /// Poses of the walls now.
    pub fn wall_states(&self) -> &[WallState] {
        &self.states
    }

    /// Takes a particle that this rank owns; its contacts remember nothing.
    ///
    /// Every rank must call [`Dem::announce_insertion`] when particles were inserted anywhere.
    pub fn insert(&mut self, record: &ParticleRecord) {
        self.restore(record, &[0.0; 3]);
        let last = self.particles.owned - 1;
        let body = &self.particles.bodies[last];
        if body.is_guided() {
            self.particles.half_velocity[last] = body.velocity;
        }
        self.ledger.inserted += 1;
        if self.particles.is_carrying() {
            self.passages.inserted.extend(self.particles.bodies.last());
        }
    }

    /// Takes a particle with what its contacts remember, as written by [`Dem::packed_memory`].
    pub fn restore(&mut self, record: &ParticleRecord, memory: &[f64]) {
        self.gather();
        let mut record = *record;
        let snap = |x: f64| self.setup.global.lattice.snap(x);
        record.body.position = record.body.position.map(snap);
        record.sides = measure::sides(&self.setup.planes, &record.body.position, &self.setup.global);
        self.particles.push(&record);
        self.memories.read(memory);
        self.guide_last();
    }

    /// Gives the last particle the velocity that is prescribed, if one is.
    fn guide_last(&mut self) {
        let time = self.time();
        let Some(body) = self.particles.bodies.last_mut().filter(|body| body.is_guided()) else { return };
        let guide = &self.setup.guides[usize::from(body.guide) - 1];
        let course = Course::new(guide, [time; 2], &self.setup.global);
        [body.velocity, body.angular_velocity] = course.velocities(&body.position, &self.setup.global);
    }

    /// Courses of the guides between two times (s).
    fn courses(&self, times: [f64; 2]) -> Vec<Course> {
        self.setup.guides.iter().map(|guide| Course::new(guide, times, &self.setup.global)).collect()
    }

    /// Declares the lists stale on this rank; all ranks must do so together.
    pub fn announce_insertion(&mut self) {
        self.stale = true;
    }

    /// Gathers what contacts remember and drops the clones, if that has not been done.
    fn gather(&mut self) {
        if !self.gathered {
            self.neighbours.remember(
                &self.particles,
                &self.setup.walls,
                &self.setup.global,
                &mut self.memories,
            );
            self.gathered = true;
        }
        self.stale = true;
        self.particles.drop_clones();
    }

    /// What the contacts of each owned particle remember, packed; for a checkpoint.
    pub fn packed_memory(&self) -> (Vec<u32>, Vec<f64>) {
        let mut gathered = Memories::default();
        let memories = if self.gathered {
            &self.memories
        } else {
            self.neighbours.remember(&self.particles, &self.setup.walls, &self.setup.global, &mut gathered);
            &gathered
        };
        let (mut lengths, mut packed) = (Vec::new(), Vec::new());
        for i in 0..self.particles.owned {
            let before = packed.len();
            memories.write(i, &mut packed);
            lengths.push((packed.len() - before) as u32);
        }
        (lengths, packed)
    }

    /// One leap-frog step: refreshes lists or clones, adds the contact loads, kicks and drifts.
    pub fn step(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        self.start_refresh(transport)?;
        self.add_forces(transport);
        self.advance(transport)
    }

    /// Makes clones and lists fit the positions.
    pub fn refresh(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        self.start_refresh(transport)?;
        self.clock.start();
        self.finish_update(transport);
        Ok(())
    }

    /// Waits for the clones of other ranks' particles, if they were sent for.
    fn finish_update(&mut self, transport: &impl Transport) {
        self.exchange.finish_update(&mut self.particles, transport);
        self.clock.charge(Phase::Clones);
    }

    /// The same, but clones of other ranks' particles may be up to date only after [`Dem::add_forces`].
    pub fn start_refresh(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        if self.setup.collisions == CollisionModel::Held {
            return Ok(());
        }
        self.clock.start();
        self.finish_update(transport);
        if self.stale {
            self.rebuild(transport)?;
            self.clock.charge(Phase::Lists);
        } else {
            self.exchange.start_update(&mut self.particles, transport);
            self.clock.charge(Phase::Clones);
        }
        Ok(())
    }

    /// Adds the loads of all contacts at the present positions; hard contacts change velocities instead.
    pub fn add_forces(&mut self, transport: &impl Transport) {
        if self.setup.collisions == CollisionModel::Held {
            return;
        }
        self.clock.start();
        if let CollisionModel::Hard(model) = self.setup.collisions {
            self.finish_update(transport);
            return self.collide(&model, transport);
        }
        let mut tally = Tally::new(self.setup.overlap_limit);
        self.add_pair_forces(With::Owned, &mut tally);
        self.clock.charge(Phase::Contacts);
        self.add_wall_forces(&mut tally);
        self.clock.charge(Phase::Walls);
        self.finish_update(transport);
        self.add_pair_forces(With::Clones, &mut tally);
        self.clock.charge(Phase::Contacts);
        self.add_films(&mut tally);
        self.clock.charge(Phase::Walls);
        self.note(tally);
        if self.particles.is_carrying() {
            self.check_contact_forces();
        }
    }

    /// Looks for a sum of contact forces that is not exact, before other forces join it.
    fn check_contact_forces(&mut self) {
        let largest = self.lattice.largest_force;
        let is_beyond = |load: &Load| load.force.amax() > largest;
        if let Some(i) = self.particles.loads.iter().position(is_beyond) {
            let force = self.particles.loads[i].force.norm();
            self.overloaded(i, force);
        }
    }

    /// Looks for what particles that went far in this step may have passed through.
    fn check_passing(&mut self, fast: &[usize]) {
        let scene = WallScene::new(&self.setup, &self.states, self.time());
        let (catalogue, step) = (&self.setup.catalogue, self.step + 1);
        let found = passing::check(&self.particles, &self.neighbours, fast, &scene, catalogue, step);
        self.error = self.error.take().or(found);
    }

    fn overloaded(&mut self, i: usize, force: f64) {
        let (id, place) = (self.particles.ids[i], vector(&self.particles.bodies[i].position));
        self.error = self.error.take().or(Some(StepError::Load { id, place, force }));
    }

    /// Adds the loads of the contacts of owned particles with each other, or with clones.
    fn add_pair_forces(&mut self, with: With, tally: &mut Tally) {
        let Self { particles, neighbours, setup, lattice, .. } = self;
        let (catalogue, dt) = (&setup.catalogue, setup.rates.dt);
        let Inner { spheres, bodies } = neighbours.inner;
        let (spheres, bodies) = match with {
            With::Owned => (&mut neighbours.spheres[..spheres], 0..bodies),
            With::Clones => (&mut neighbours.spheres[spheres..], bodies..neighbours.bodies.pairs.len()),
        };
        spheres::add_forces(particles, spheres, &catalogue.contacts, lattice, dt, tally);
        bodies::add_forces(particles, (&mut neighbours.bodies, bodies), catalogue, lattice, dt, tally);
    }

    fn add_films(&mut self, tally: &mut Tally) {
        let time = self.time();
        let Self { particles, neighbours, setup, lattice, states, wall_loads, .. } = self;
        let Some(film) = &setup.lubrication else { return };
        lubrication::add_between_spheres(particles, &neighbours.spheres, film, lattice, setup.rates.dt);
        let scene = WallScene::new(setup, states, time);
        let (walls, catalogue) = (&neighbours.walls, &setup.catalogue);
        let found = lubrication::add_at_walls(particles, walls, &scene, catalogue, film, lattice, wall_loads);
        tally.error = tally.error.take().or(found.err());
    }

    fn note(&mut self, tally: Tally) {
        self.report.largest_overlap = tally.largest_overlap();
        self.report.worst_overlap = self.report.worst_overlap.max(self.report.largest_overlap);
        self.report.cores_met += tally.cores_met;
        self.error = self.error.take().or(tally.error);
    }

    /// Gives all contacts at the present positions their impulses.
    ///
    /// The loads of particles and walls are what was exchanged over the time step; nothing moves by them.
    fn collide(&mut self, model: &HardModel, transport: &impl Transport) {
        self.wall_loads.fill(WallLoad::default());
        let mut tally = Tally::new(self.setup.overlap_limit);
        let time = self.time();
        let Self { particles, neighbours, setup, states, wall_loads, collisions, exchange, .. } = self;
        let (scene, catalogue) = (WallScene::new(setup, states, time), &setup.catalogue);
        collisions.find(particles, neighbours, &scene, catalogue, &mut tally);
        let (positions, dt) = (&setup.global.lattice, setup.rates.dt);
        let mut site = Site { particles, catalogue, wall_loads, positions, dt };
        let counts = collisions.resolve(&mut site, model, exchange, &mut tally, transport);
        self.report.collisions += counts.collisions;
        self.report.resting_collisions += counts.resting;
        self.report.rounds += counts.rounds;
        self.note(tally);
        self.clock.charge(Phase::Contacts);
    }

    fn add_wall_forces(&mut self, tally: &mut Tally) {
        self.wall_loads.fill(WallLoad::default());
        let time = self.time();
        let Self { particles, neighbours, setup, lattice, states, wall_loads, .. } = self;
        let scene = WallScene::new(setup, states, time);
        walls::add_forces(
            particles,
            &mut neighbours.walls,
            &scene,
            &setup.catalogue,
            lattice,
            wall_loads,
            tally,
        );
    }

    /// Kicks and drifts, moves the walls, and agrees with the other ranks on errors and stale lists.
    pub fn advance(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        self.clock.start();
        let dt = self.setup.rates.dt;
        let courses = self.courses([self.step, self.step + 1].map(|step| self.origin.time_of(step, dt)));
        let Self { particles, neighbours, setup, lattice, collisions, .. } = self;
        if setup.collisions != CollisionModel::Soft {
            collisions.relocate(particles);
            particles.loads.fill(Load::default());
        }
        // What a fluid adds is no contact force: those were looked at before.
        let largest_force = if particles.is_carrying() { f64::INFINITY } else { lattice.largest_force };
        let outcome = integrate::advance(
            particles,
            neighbours,
            &setup.catalogue,
            (&setup.global, &courses),
            &setup.rates,
            largest_force,
        );
        if let Some((i, force)) = outcome.overloaded {
            self.overloaded(i, force);
        }
        if !outcome.fast.is_empty() && self.setup.collisions != CollisionModel::Held {
            self.check_passing(&outcome.fast);
        }
        self.step += 1;
        self.steps_since_build += 1;
        self.place_walls();
        self.clock.charge(Phase::Motion);
        let own = if self.error.is_some() {
            Level::Failed
        } else if self.interrupt {
            Level::Interrupted
        } else if outcome.is_stale || self.steps_since_build >= self.wall_steps {
            Level::Stale
        } else {
            Level::Fine
        };
        let level = transport.highest(own as u8);
        self.clock.charge(Phase::Agreement);
        self.stale |= level >= Level::Stale as u8;
        self.interrupt = level >= Level::Interrupted as u8;
        self.agreed(level >= Level::Failed as u8)
    }

    /// Whether the contact loads just added are sound on all ranks, as [`Dem::advance`] would say.
    pub fn check(&mut self, transport: &impl Transport) -> Result<(), Failure> {
        let failed = transport.highest(u8::from(self.error.is_some())) > 0;
        self.agreed(failed)
    }

    fn agreed(&mut self, failed: bool) -> Result<(), Failure> {
        match (failed, self.error.take()) {
            (false, _) => Ok(()),
            (true, Some(error)) => Err(Failure::Here(error)),
            (true, None) => Err(Failure::Elsewhere),
        }
    }

    fn place_walls(&mut self) {
        let time = self.time();
        self.states.clear();
        let walls = self.setup.walls.iter().zip(&self.wall_places);
        self.states.extend(walls.map(|(wall, place)| match place {
            Some(place) => wall.motion.at(time).of_place(place),
            None => wall.motion.at(time),
        }));
    }

    /// What this rank has worked since the start, in units of a pair of spheres in a step.
    pub fn work(&self) -> u64 {
        let owned = self.particles.owned;
        let in_a_step = self.neighbours.work(owned) + self.other_work.of_rank(owned, &self.decomposition);
        self.report.work + self.steps_since_build * in_a_step
    }
}
