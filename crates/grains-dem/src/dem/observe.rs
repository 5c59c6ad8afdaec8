//! What can be asked of the granular phase between two steps: sums, counts, loads, contacts.

use super::report::Ledger;
use super::setup::DemSetup;
use super::state::Dem;
use crate::bonds::BondLedger;
use crate::error::StepError;
use crate::exchange::Traffic;
use crate::flow_planes::{Crossings, count_crossings};
use crate::memory_use::MemoryUse;
use crate::non_spherical;
use crate::totals::Totals;
use crate::walls::{self, WallLoad};
use grains_domain::{ExactSum, Transport, sum_exact, sum_wide};
use grains_geometry::Vec3;

/// The other side of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partner {
    /// A particle of this rank's arrays, owned or clone.
    Particle(usize),
    /// A wall.
    Wall(usize),
}

/// A contact of an owned particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// The owned particle.
    pub particle: usize,
    /// What it touches.
    pub other: Partner,
    /// Overlap (m).
    pub overlap: f64,
    /// Smaller inscribed radius of the two (m).
    pub radius: f64,
}

impl Dem {
    /// Quaternion (w, x, y, z) that turns the shape of an owned particle, as the case gives it and insertions take it, to the world.
    pub fn orientation_in_case(&self, i: usize) -> [f64; 4] {
        let to_user = self.setup.catalogue.shape(self.particles.bodies[i].kind).user_to_body.0.inverse();
        let turn = (self.particles.record(i).orientation * to_user).into_inner();
        [turn.w, turn.i, turn.j, turn.k]
    }

    /// Sums over all ranks.
    pub fn totals(&self, transport: &impl Transport) -> Totals {
        let (gravity, global) = (&self.setup.parameters.gravity, &self.setup.global);
        Totals::of(&self.particles, &self.setup.catalogue, gravity, global, transport)
    }

    /// Checks that every particle inserted is inside or has left; returns the sums of all ranks.
    pub fn check_ledger(&self, transport: &impl Transport) -> Result<Ledger, StepError> {
        let mut counts = [self.ledger.inserted, self.ledger.left, self.particles.owned as u64];
        transport.sum_counts(&mut counts);
        let [inserted, left, inside] = counts;
        if inserted == left + inside {
            return Ok(Ledger { inserted, left });
        }
        let missing = inserted as i64 - left as i64 - inside as i64;
        Err(StepError::Ledger { inserted, inside, left, missing })
    }

    /// Checks that every bond made is there, has broken or has left; returns bonds there and broken, of all ranks.
    ///
    /// # Errors
    /// Bonds that are unaccounted for.
    pub fn check_bonds(&self, transport: &impl Transport) -> Result<[u64; 2], StepError> {
        let BondLedger { made, broken, left } = self.bond_ledger;
        let there = self.bonds_of_each().into_iter().map(u64::from).sum();
        let mut counts = [made, there, broken, left];
        transport.sum_counts(&mut counts);
        let [made, there, broken, left] = counts;
        match made == there + broken + left {
            true => Ok([there / 2, broken / 2]),
            false => Err(StepError::BondLedger { made, there, broken, left }),
        }
    }

    /// Number of bonds of each owned particle.
    pub fn bonds_of_each(&self) -> Vec<u32> {
        let owned = self.particles.owned;
        match self.history_saved {
            true => (0..owned).map(|i| self.histories.bonds.row(i).len() as u32).collect(),
            false => self.neighbours.bonds.of_each(owned),
        }
    }

    /// Net number and mass that crossed each flow plane since the case began, over all ranks; collective.
    pub fn crossings(&mut self, transport: &impl Transport) -> Vec<Crossings> {
        self.count_crossings();
        let numbers = self.crossings.iter().flat_map(|c| [i128::from(c.count), c.quanta]);
        let mut sums: Vec<u128> = numbers.map(i128::cast_unsigned).collect();
        sum_wide(&mut sums, transport);
        let crossings =
            |&[count, quanta]: &[u128; 2]| Crossings { count: count as i64, quanta: quanta.cast_signed() };
        sums.as_chunks().0.iter().map(crossings).collect()
    }

    /// The quantum of masses that are counted (kg).
    pub fn mass_quantum(&self) -> f64 {
        self.setup.mass_quantum()
    }

    pub(super) fn count_crossings(&mut self) {
        let DemSetup { planes, global, .. } = &self.setup;
        let quantum = self.setup.mass_quantum();
        count_crossings(&mut self.particles, planes, (global, quantum), &mut self.crossings);
    }

    /// Sets the crossings counted so far (on one rank; zero on the others), as after a restart.
    pub fn restore_crossings(&mut self, counts: &[Crossings]) {
        self.crossings.copy_from_slice(counts);
    }

    /// Force (N) and torque about the origin (N m) on each wall, over all ranks.
    pub fn wall_loads(&self, transport: &impl Transport) -> Vec<WallLoad> {
        let mut sums = self.collision_loads.clone();
        for (sums, load) in sums.iter_mut().zip(&self.wall_loads) {
            sums.iter_mut().zip(load.force.iter().chain(&load.torque)).for_each(|(sum, x)| *sum += *x);
        }
        summed(sums, transport)
    }

    /// Force (N) and torque about the origin (N m) of all contacts on the particles of each prescribed motion, of the images in the box, over
    /// all ranks.
    pub fn prescribed_loads(&self, transport: &impl Transport) -> Vec<WallLoad> {
        let mut sums = vec![[ExactSum::default(); 6]; self.setup.prescribed.len()];
        let own = self.particles.bodies.iter().zip(&self.particles.loads);
        for (body, load) in own.filter(|(body, _)| body.is_prescribed()) {
            let place = Vec3::from(self.setup.global.wrap(body.position.into()));
            let torque = load.torque + place.cross(&load.force);
            let sum = &mut sums[usize::from(body.prescribed) - 1];
            sum.iter_mut().zip(load.force.iter().chain(&torque)).for_each(|(sum, x)| *sum += *x);
        }
        summed(sums, transport)
    }

    /// Touching neighbours and touching walls of each owned particle, at the present positions.
    pub fn coordination(&self) -> (Vec<u32>, Vec<u32>) {
        let owned = self.particles.owned;
        let (mut neighbours, mut touching_walls) = (vec![0; owned], vec![0; owned]);
        self.for_each_contact(|touch| match touch.other {
            Partner::Wall(_) => touching_walls[touch.particle] += 1,
            Partner::Particle(other) => {
                for i in [touch.particle, other].into_iter().filter(|&i| i < owned) {
                    neighbours[i] += 1;
                }
            }
        });
        (neighbours, touching_walls)
    }

    /// Calls `visit` with every contact of an owned particle at the present positions.
    pub fn for_each_contact(&self, mut visit: impl FnMut(&Touch)) {
        let bodies = &self.particles.bodies;
        let catalogue = &self.setup.catalogue;
        for pair in &self.neighbours.spheres {
            let (i, j) = (pair.a as usize, pair.b as usize);
            let overlap =
                bodies[i].radius + bodies[j].radius - (bodies[j].position - bodies[i].position).norm();
            if overlap > 0.0 {
                let radius = bodies[i].radius.min(bodies[j].radius);
                visit(&Touch { particle: i, other: Partner::Particle(j), overlap, radius });
            }
        }
        // Parts of two bodies that touch are one contact, the deepest of theirs. A distance that cannot be found is
        // not reported here: the step that adds the forces at these positions fails with it.
        let mut touch: Option<Touch> = None;
        let mut list = self.neighbours.part_pairs.clone();
        let _ = non_spherical::meet(&self.particles, &mut list, catalogue, |pair, contact, _| {
            if contact.overlap <= 0.0 {
                return;
            }
            let (a, b) = (pair.a as usize, pair.b as usize);
            let (particle, other) = if a < self.particles.owned { (a, b) } else { (b, a) };
            let (other, overlap) = (Partner::Particle(other), contact.overlap);
            let radius = catalogue.smaller_inscribed_radius([a, b].map(|i| &bodies[i]));
            let new = Touch { particle, other, overlap, radius };
            match &mut touch {
                Some(same) if (same.particle, same.other) == (particle, other) => {
                    same.overlap = same.overlap.max(overlap);
                }
                last => last.replace(new).iter().for_each(&mut visit),
            }
        });
        touch.iter().for_each(&mut visit);
        let scene = self.setup.wall_scene(&self.states, self.time());
        let mut list = self.neighbours.walls.clone();
        walls::for_each_contact(&self.particles, &mut list, &scene, catalogue, |i, wall, overlap| {
            let radius = catalogue.inscribed_radius(&bodies[i]);
            visit(&Touch { particle: i, other: Partner::Wall(wall), overlap, radius });
        });
    }

    /// Lengths of the lists (sphere pairs, body pairs, wall pairs) and clones sent per step.
    pub fn list_sizes(&self) -> ([usize; 3], usize) {
        (self.neighbours.sizes(), self.exchange.clones_sent())
    }

    /// Share of the listed pairs of particles that are of two owned ones: those are worked on while clones are updated.
    pub fn inner_share(&self) -> f64 {
        let ([spheres, bodies, _], inner) = (self.neighbours.sizes(), self.neighbours.inner);
        (inner.spheres + inner.part_pairs) as f64 / (spheres + bodies).max(1) as f64
    }

    /// What the updates of clones cost this rank so far.
    pub fn traffic(&self) -> Traffic {
        self.exchange.traffic()
    }

    /// Number of ranks this rank exchanges messages with.
    pub fn neighbour_ranks(&self) -> usize {
        self.exchange.neighbours()
    }

    /// Memory (B) this rank holds for particles, lists and messages.
    pub fn memory_use(&self) -> MemoryUse {
        MemoryUse {
            particles: self.particles.bytes(),
            lists: self.neighbours.bytes() + self.histories.bytes() + self.cell_list.bytes(),
            messages: self.exchange.bytes(),
        }
    }

    /// What this rank has worked since the start, in units of a pair of spheres in a step.
    pub fn work(&self) -> u64 {
        let owned = self.particles.owned;
        let in_a_step = self.neighbours.work(owned) + self.other_work.of_rank(owned, &self.decomposition);
        self.report.work + self.steps_since_build * in_a_step
    }
}

/// Forces and torques over all ranks, of those of this one.
fn summed(mut sums: Vec<[ExactSum; 6]>, transport: &impl Transport) -> Vec<WallLoad> {
    sum_exact(sums.as_flattened_mut(), transport);
    let vector = |s: &[ExactSum]| Vec3::new(s[0].total(), s[1].total(), s[2].total());
    sums.iter().map(|s| WallLoad { force: vector(s), torque: vector(&s[3..]) }).collect()
}
