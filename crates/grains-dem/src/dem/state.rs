//! The granular phase of one rank: what it holds, and how particles enter it.

use super::agreement::Agreement;
use super::rebuild_times::RebuildTimes;
use super::report::{Ledger, Origin, Passages, StepReport};
use super::setup::DemSetup;
use super::species::SpeciesLedger;
use crate::bonds::BondLedger;
use crate::clock::Clock;
use crate::contact_history::SavedHistories;
use crate::contacts::LoadQuanta;
use crate::error::StepError;
use crate::exchange::Exchange;
use crate::films::LiquidLedger;
use crate::flow_planes::{Crossings, sides};
use crate::hard::Collisions;
use crate::heat::{HeatLedger, HeatedWalls, TouchingParts};
use crate::particles::{ParticleRecord, Particles};
use crate::prescribed::{Course, PrescribedMotion};
use crate::shear::SlidingImages;
use crate::stress::StressSums;
use crate::verlet::{CellList, Extent, VerletLists};
use crate::walls::{Motion, SlidingSums, Travel, WallLoad, WallPlace, WallState};
use grains_domain::{Decomposition, DecompositionError, ExactSum, OtherWork, WorkProfile};
use grains_geometry::Vec3;

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
    /// What loads have made of the walls they move, the same on all ranks.
    pub travels: Vec<Travel>,
    /// Offset (m) of the images of a sheared box at time zero, as if the present rate had been that always.
    pub shear_start: f64,
    /// Sums for the stress of a sheared box on this rank, until it is taken.
    pub stress: StressSums,
    /// Particles in and out on this rank.
    pub ledger: Ledger,
    /// Time step (s) of the step before, where it was another than that of the present one.
    pub dt_before: Option<f64>,
    /// Whether the bonds of each kind have been made.
    pub made_bonds: Vec<bool>,
    /// Ends of bonds on this rank.
    pub bond_ledger: BondLedger,
    /// Liquid in and out on this rank.
    pub liquid_ledger: LiquidLedger,
    /// Heat in and out of the particles on this rank.
    pub heat_ledger: HeatLedger,
    /// Amounts of each species in and out of the particles on this rank.
    pub species_ledgers: Vec<SpeciesLedger>,
    /// Heat from each wall into this rank's particles (W).
    pub wall_heat: Vec<f64>,
    /// Walls of a given heat, and what touches them.
    pub(crate) heated_walls: HeatedWalls,
    /// Particles with cargo that came and went, until they are taken.
    pub passages: Passages,
    /// Time by phase.
    pub clock: Clock,
    /// Loads on the walls by the soft contacts of this rank's particles.
    pub wall_loads: Vec<WallLoad>,
    /// The same of hard collisions: force (N) and torque (N m), along x, y, z.
    pub(crate) collision_loads: Vec<[ExactSum; 6]>,
    /// Whether some rank was asked to stop: set it on any rank, read it on all after [`Dem::advance`], which tells it some steps later.
    pub interrupt: bool,
    /// Result of the last force evaluation.
    pub report: StepReport,
    /// What else borders between subdomains share out when they move.
    pub other_work: OtherWork,
    pub(super) quanta: LoadQuanta,
    pub(super) exchange: Exchange,
    pub(super) neighbours: VerletLists,
    /// The cells that the lists were built from.
    pub(super) cell_list: CellList,
    /// Whether ranks rebuild their lists apart from each other.
    pub(super) are_apart: bool,
    pub(super) times: RebuildTimes,
    pub(super) agreement: Agreement,
    /// Whether there are fewer than two particles, and no wall.
    pub(super) is_alone: bool,
    pub(super) histories: SavedHistories,
    pub(super) collisions: Collisions,
    pub(super) crossings: Vec<Crossings>,
    pub(super) states: Vec<WallState>,
    pub(super) sliding: SlidingSums,
    /// Whether `histories` holds the history of all pairs, and the lists are to be rebuilt.
    pub(super) history_saved: bool,
    /// Whether the lists of all ranks are to be rebuilt, the same on all.
    pub(super) stale: bool,
    /// Whether a bond broke in this step.
    pub(super) has_broken: bool,
    pub(super) steps_since_build: u64,
    pub(super) work: WorkProfile,
    /// First step at which the work is looked at again.
    pub(super) next_balance: u64,
    /// Steps from a build after which walls may have used up their allowance.
    pub(super) wall_steps: u64,
    /// Images of a sheared box.
    pub(super) images: Option<SlidingImages>,
    /// Their offset (m) when the lists were built.
    pub(super) built_at: f64,
    /// Scratch: forces (N) on the walls that loads move.
    pub(super) loaded_forces: Vec<f64>,
    /// Scratch: parts of bodies that touch, for the heat between them.
    pub(super) touching: Vec<TouchingParts>,
    /// Way (m) that loads may still move walls before the lists are rebuilt.
    pub(super) way_left: f64,
    pub(super) error: Option<StepError>,
    /// Step at which it was met.
    pub(super) failed_at: Option<u64>,
}

impl Dem {
    /// System without particles on one rank of `ranks[0] ranks[1] ranks[2]`.
    pub fn new(mut setup: DemSetup, rank: usize) -> Result<Self, DecompositionError> {
        setup.catalogue.contacts.prepare(setup.largest_radius);
        setup.thermal.iter_mut().for_each(|thermal| thermal.prepare(setup.largest_radius));
        if let Some(shear) = setup.shear.filter(|shear| setup.ranks[shear.flow] != 1) {
            let (axis, ranks) = (['x', 'y', 'z'][shear.flow], setup.ranks[shear.flow]);
            return Err(DecompositionError::FlowDivided { axis, ranks });
        }
        let range = setup.interaction_range();
        let decomposition = Decomposition::new(setup.global.clone(), setup.ranks, rank, range)?;
        let are_apart = setup.are_apart(&decomposition);
        let mut dem = Self {
            particles: Particles::new(setup.catalogue.all_spheres()),
            step: 0,
            origin: Origin::default(),
            wall_places: vec![None; setup.walls.len()],
            travels: vec![Travel::default(); setup.walls.len()],
            shear_start: 0.0,
            stress: StressSums::default(),
            ledger: Ledger::default(),
            dt_before: None,
            made_bonds: vec![false; setup.bonds.len()],
            bond_ledger: BondLedger::default(),
            liquid_ledger: LiquidLedger::default(),
            heat_ledger: HeatLedger::default(),
            species_ledgers: vec![SpeciesLedger::default(); setup.species.len()],
            wall_heat: vec![0.0; setup.walls.len()],
            heated_walls: HeatedWalls::new(setup.walls.len()),
            passages: Passages::default(),
            clock: Clock::default(),
            wall_loads: vec![WallLoad::default(); setup.walls.len()],
            collision_loads: vec![[ExactSum::default(); 6]; setup.walls.len()],
            interrupt: false,
            report: StepReport::default(),
            other_work: OtherWork::default(),
            quanta: setup.quanta(),
            exchange: Exchange::new(&decomposition, setup.outlets, setup.exchange, are_apart),
            neighbours: VerletLists::default(),
            cell_list: CellList::default(),
            are_apart,
            times: RebuildTimes::default(),
            agreement: Agreement::default(),
            is_alone: false,
            histories: SavedHistories::default(),
            collisions: Collisions::default(),
            crossings: vec![Crossings::default(); setup.planes.len()],
            states: Vec::new(),
            sliding: SlidingSums::new(&setup.walls, setup.torque_quantum()),
            history_saved: true,
            stale: true,
            has_broken: false,
            steps_since_build: 0,
            work: WorkProfile::new(decomposition.ranks),
            next_balance: 0,
            wall_steps: u64::MAX,
            images: setup.sliding_images(),
            built_at: 0.0,
            loaded_forces: Vec::new(),
            touching: Vec::new(),
            way_left: 0.0,
            error: None,
            failed_at: None,
            decomposition,
            setup,
        };
        if dem.setup.catalogue.contacts.films().is_some() {
            dem.particles.wet();
        }
        dem.particles.species = dem.setup.species.len();
        if dem.setup.thermal.is_some() {
            dem.particles.warm();
        }
        dem.place_walls();
        let prescribed = std::mem::take(&mut dem.setup.prescribed);
        dem.prescribe(prescribed);
        Ok(dem)
    }

    /// Prescribes the motion of some particles; to be called on all ranks alike, before there are any.
    pub fn prescribe(&mut self, prescribed: Vec<PrescribedMotion>) {
        self.particles.prescribed_ids = prescribed.iter().map(|motion| motion.ids.clone()).collect();
        self.setup.prescribed = prescribed;
    }

    /// Time of the present positions (s).
    pub fn time(&self) -> f64 {
        self.origin.time_of(self.step, self.setup.parameters.dt)
    }

    /// Time of the positions at a step (s).
    pub fn time_of(&self, step: u64) -> f64 {
        self.origin.time_of(step, self.setup.parameters.dt)
    }

    /// Continues from a step, as after a restart: the walls take their places.
    pub fn resume_at(&mut self, step: u64) {
        self.step = step;
        self.place_walls();
    }

    /// Moves a wall otherwise from now on, from where it is; all ranks must do so together.
    pub fn set_wall_motion(&mut self, wall: usize, motion: Motion) {
        let pose = self.states[wall].pose();
        let axes = [&self.setup.walls[wall].motion, &motion].map(|m| m.loading().map(|loading| loading.axis));
        self.travels[wall] = match axes {
            [Some(before), Some(now)] => self.travels[wall].along(now.dot(&before)),
            _ => Travel::default(),
        };
        self.wall_places[wall] = WallPlace::between(&motion.at(self.time()), &pose);
        self.setup.walls[wall].motion = motion;
        self.quanta = self.setup.quanta();
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

    /// Takes a particle that this rank owns; its contacts have no history.
    ///
    /// Every rank must call [`Dem::announce_insertion`] when particles were inserted anywhere.
    pub fn insert(&mut self, record: &ParticleRecord) {
        self.restore(record, &[0.0; 3]);
        let last = self.particles.owned - 1;
        let body = &self.particles.bodies[last];
        if body.is_prescribed() {
            self.particles.half_velocity[last] = body.velocity;
        }
        self.ledger.inserted += 1;
        self.wet_last();
        self.account_heat_of_last();
        self.fill_last();
        if self.particles.is_carrying() {
            self.passages.inserted.extend(self.particles.bodies.last());
        }
    }

    /// Takes a particle with its contact history, as written by [`Dem::packed_history`].
    pub fn restore(&mut self, record: &ParticleRecord, history: &[f64]) {
        self.save_history();
        let mut record = *record;
        let snap = |x: f64| self.setup.global.quantum.snap(x);
        record.body.position = record.body.position.map(snap);
        self.images.iter().for_each(|images| images.round(&mut record.body.velocity));
        record.sides = sides(&self.setup.planes, &record.body.position, &self.setup.global);
        self.particles.push(&record);
        self.histories.read(history);
        self.prescribe_last();
    }

    /// Gives the last particle the velocity that is prescribed, if one is.
    fn prescribe_last(&mut self) {
        let time = self.time();
        let Some(body) = self.particles.bodies.last_mut().filter(|body| body.is_prescribed()) else { return };
        let motion = &self.setup.prescribed[usize::from(body.prescribed) - 1];
        let course = Course::new(motion, [time; 2], &self.setup.global);
        [body.velocity, body.angular_velocity] = course.velocities(&body.position, &self.setup.global);
    }

    /// Courses of the prescribed motions between two times (s).
    pub(super) fn courses(&self, times: [f64; 2]) -> Vec<Course> {
        self.setup.prescribed.iter().map(|motion| Course::new(motion, times, &self.setup.global)).collect()
    }

    /// Declares the lists stale on this rank; all ranks must do so together.
    pub fn announce_insertion(&mut self) {
        self.stale = true;
    }

    /// Saves the contact history and drops the clones, if that has not been done.
    pub(super) fn save_history(&mut self) {
        if !self.history_saved {
            self.store_history(Extent::All);
            self.history_saved = true;
        }
        self.stale = true;
        self.particles.drop_clones();
        self.neighbours.references.split_off(self.particles.owned);
    }

    /// Stores the contact history of pairs in rows.
    pub(super) fn store_history(&mut self, extent: Extent) {
        let Self { particles, setup, histories, neighbours, .. } = self;
        let definition = (&setup.catalogue, &setup.walls[..]);
        neighbours.save_history(particles, definition, &setup.global, histories, extent);
    }

    /// Contact history of each owned particle, packed; for a checkpoint.
    pub fn packed_history(&self) -> (Vec<u32>, Vec<f64>) {
        let mut history_saved = SavedHistories::default();
        let histories = if self.history_saved {
            &self.histories
        } else {
            self.neighbours.save_history(
                &self.particles,
                (&self.setup.catalogue, &self.setup.walls),
                &self.setup.global,
                &mut history_saved,
                Extent::All,
            );
            &history_saved
        };
        let (mut lengths, mut packed) = (Vec::new(), Vec::new());
        for i in 0..self.particles.owned {
            let before = packed.len();
            histories.write(i, &mut packed);
            lengths.push((packed.len() - before) as u32);
        }
        (lengths, packed)
    }

    /// Moves the walls to where they are now.
    pub(super) fn place_walls(&mut self) {
        let mut states = std::mem::take(&mut self.states);
        states.clear();
        states.extend((0..self.setup.walls.len()).map(|wall| self.wall_state_at(wall, self.time())));
        self.states = states;
    }

    /// Pose and velocity of a wall at a time (s), of one that a load moves as far as it has travelled now.
    pub fn wall_state_at(&self, wall: usize, time: f64) -> WallState {
        let motion = &self.setup.walls[wall].motion;
        let state = motion.at(time);
        let state = self.wall_places[wall].as_ref().map_or(state, |place| state.of_place(place));
        motion.loading().map_or(state, |loading| state.travelled(loading, &self.travels[wall]))
    }
}
