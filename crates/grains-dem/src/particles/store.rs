//! The particles of one rank: owned ones first, then clones of neighbours' particles.

use super::body::{Body, CARGO_LENGTH, Cargo, Load};
use super::record::ParticleRecord;
use crate::films::BodyFilm;
use crate::heat::HeatFlow;
use crate::memory_use::heap_bytes;
use crate::rotation::{frame, way_of_turn};
use grains_geometry::{Mat3, Rotation, Vec3};
use std::ops::Range;

/// Struct of arrays of particles; the arrays of owned particles are `owned` long.
#[derive(Clone, Debug, Default)]
pub struct Particles {
    /// Number of owned particles; clones follow in `bodies`, `ids` and `orientations`.
    pub owned: usize,
    /// Mechanical state, owned and clones.
    pub bodies: Vec<Body>,
    /// Identity, owned and clones.
    pub ids: Vec<u64>,
    /// Orientation, body to world, owned and clones; empty if all particles are spheres.
    pub orientations: Vec<Rotation>,
    /// Rotation matrices of `orientations`.
    pub frames: Vec<Mat3>,
    /// What no point of the body has moved farther than since the lists were built, along its path (m), owned and
    /// clones.
    pub(crate) path_length: Vec<f64>,
    /// Contact loads, owned.
    pub loads: Vec<Load>,
    /// Velocity half a step before `position` (m/s), owned.
    pub half_velocity: Vec<Vec3>,
    /// Half a step before: angular velocity (rad/s) of a sphere, angular momentum (kg m²/s) of other shapes; owned.
    pub half_spin: Vec<Vec3>,
    /// Side of each flow plane, one bit per plane; owned.
    pub sides: Vec<u32>,
    /// What a coupling lets particles carry, owned; empty unless [`Particles::carry`] was called.
    pub cargo: Vec<Cargo>,
    /// Liquid, owned and clones; empty unless [`Particles::wet`] was called.
    pub films: Vec<BodyFilm>,
    /// Temperature (K), owned and clones; empty unless [`Particles::warm`] was called.
    pub temperatures: Vec<f64>,
    /// Amounts (mol, kg) of each species in them, owned, particle by particle; empty without species.
    pub amounts: Vec<f64>,
    /// Number of species.
    pub(crate) species: usize,
    /// Heat that flows into them through contacts in this step, owned.
    pub(crate) heat_flows: Vec<HeatFlow>,
    /// Identities of those of prescribed motion, motion by motion.
    pub(crate) prescribed_ids: Vec<Range<u64>>,
    /// Sum of F ⊗ (x_a − x_b) over the contacts of the step (N m), those with clones by half; if it is asked for.
    pub(crate) virial: Option<Mat3>,
    has_orientations: bool,
    carrying: bool,
    is_wet: bool,
    is_warm: bool,
}

impl Particles {
    /// Number of particles held, clones included.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Memory (B).
    pub(crate) fn bytes(&self) -> usize {
        let Self { bodies, ids, orientations, frames, path_length, .. } = self;
        let Self {
            loads,
            half_velocity,
            half_spin,
            sides,
            cargo,
            films,
            temperatures,
            heat_flows,
            amounts,
            ..
        } = self;
        let shared = heap_bytes(bodies)
            + heap_bytes(ids)
            + heap_bytes(orientations)
            + heap_bytes(frames)
            + heap_bytes(path_length);
        shared
            + heap_bytes(loads)
            + heap_bytes(half_velocity)
            + heap_bytes(half_spin)
            + heap_bytes(sides)
            + heap_bytes(cargo)
            + heap_bytes(films)
            + heap_bytes(temperatures)
            + heap_bytes(heat_flows)
            + heap_bytes(amounts)
    }

    /// Whether this rank holds no particle.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Forgets all clones.
    pub fn drop_clones(&mut self) {
        self.bodies.truncate(self.owned);
        self.ids.truncate(self.owned);
        self.orientations.truncate(self.owned);
        self.frames.truncate(self.owned);
        self.path_length.truncate(self.owned);
        self.films.truncate(self.owned);
        self.temperatures.truncate(self.owned);
    }

    /// Takes off the clones; frames are not among what is kept of them.
    pub(crate) fn split_off_clones(&mut self) -> Self {
        fn taken<T: Clone>(items: &mut Vec<T>, owned: usize) -> Vec<T> {
            items.split_off(owned.min(items.len()))
        }
        let owned = self.owned;
        let clones = Self {
            bodies: taken(&mut self.bodies, owned),
            ids: taken(&mut self.ids, owned),
            orientations: taken(&mut self.orientations, owned),
            films: taken(&mut self.films, owned),
            temperatures: taken(&mut self.temperatures, owned),
            ..Self::default()
        };
        self.drop_clones();
        clones
    }

    /// Appends one of the clones taken off.
    pub(crate) fn push_clone_from(&mut self, clones: &Self, k: usize) {
        let orientation = clones.orientations.get(k).copied().unwrap_or_else(Rotation::identity);
        self.push_clone(clones.ids[k], clones.bodies[k], orientation);
        if let (Some(film), Some(kept)) = (self.films.last_mut(), clones.films.get(k)) {
            *film = *kept;
        }
        if let (Some(temperature), Some(kept)) = (self.temperatures.last_mut(), clones.temperatures.get(k)) {
            *temperature = *kept;
        }
    }

    /// Particles without orientation if all shapes are spheres.
    pub fn new(all_spheres: bool) -> Self {
        Self { has_orientations: !all_spheres, ..Self::default() }
    }

    /// Lets every particle, also those to come, carry cargo: zeros until somebody sets them.
    ///
    /// All ranks must do so before the first step.
    pub fn carry(&mut self) {
        self.carrying = true;
        self.cargo.resize(self.owned, [0.0; CARGO_LENGTH]);
    }

    /// Lets every particle, also those to come, carry a film of liquid; dry until somebody wets it.
    ///
    /// All ranks must do so before there are any.
    pub fn wet(&mut self) {
        self.is_wet = true;
    }

    /// Lets every particle, also those to come, have a temperature; 0 K until somebody sets it.
    ///
    /// All ranks must do so before there are any.
    pub fn warm(&mut self) {
        self.is_warm = true;
    }

    /// Whether particles have temperatures.
    #[inline(always)]
    pub fn is_warm(&self) -> bool {
        self.is_warm
    }

    /// Amounts (mol, kg) of all species in an owned particle.
    pub fn amounts_of(&self, i: usize) -> &[f64] {
        &self.amounts[i * self.species..(i + 1) * self.species]
    }

    /// Sets the amounts of all species in the particle that came last.
    pub(crate) fn set_last_amounts(&mut self, amounts: &[f64]) {
        let first = self.amounts.len() - self.species;
        self.amounts[first..].copy_from_slice(amounts);
    }

    /// Whether particles carry films of liquid.
    #[inline(always)]
    pub fn is_wet(&self) -> bool {
        self.is_wet
    }

    /// Whether particles have orientations, as some are not spheres.
    pub fn has_orientations(&self) -> bool {
        self.has_orientations
    }

    /// Whether particles carry cargo.
    pub fn is_carrying(&self) -> bool {
        self.carrying
    }

    /// Appends an owned particle; there must be no clones.
    pub fn push(&mut self, record: &ParticleRecord) {
        debug_assert_eq!(self.owned, self.bodies.len(), "owned particles come before clones");
        self.push_clone(record.id, record.body, record.orientation);
        self.loads.push(Load::default());
        self.half_velocity.push(record.half_velocity);
        self.half_spin.push(record.half_spin);
        self.sides.push(record.sides);
        if let Some(temperature) = self.temperatures.last_mut() {
            *temperature = record.temperature;
        }
        if self.carrying {
            self.cargo.push([0.0; CARGO_LENGTH]);
        }
        self.amounts.extend((0..self.species).map(|_| 0.0));
        if self.is_warm {
            self.heat_flows.push(HeatFlow::default());
        }
        self.owned += 1;
    }

    /// Makes room for just so many clones.
    pub(crate) fn make_room(&mut self, clones: usize) {
        self.bodies.reserve_exact(clones);
        self.ids.reserve_exact(clones);
        if self.has_orientations {
            self.orientations.reserve_exact(clones);
            self.frames.reserve_exact(clones);
            self.path_length.reserve_exact(clones);
        }
        if self.is_wet {
            self.films.reserve_exact(clones);
        }
        if self.is_warm {
            self.temperatures.reserve_exact(clones);
        }
    }

    /// Appends a clone.
    pub(crate) fn push_clone(&mut self, id: u64, body: Body, orientation: Rotation) {
        self.ids.push(id);
        self.bodies.push(Body { prescribed: self.prescribed_number(id), ..body });
        if self.has_orientations {
            self.orientations.push(orientation);
            self.frames.push(frame(&orientation));
            self.path_length.push(0.0);
        }
        if self.is_wet {
            self.films.push(BodyFilm::default());
        }
        if self.is_warm {
            self.temperatures.push(0.0);
        }
    }

    /// Number of the motion prescribed to a particle, from 1; 0 for one that moves freely.
    fn prescribed_number(&self, id: u64) -> u16 {
        self.prescribed_ids.iter().position(|ids| ids.contains(&id)).map_or(0, |k| k as u16 + 1)
    }

    /// Gives a body that has come from a position (m) a new orientation.
    #[inline(always)]
    pub(crate) fn turn_to(&mut self, i: usize, before: &Vec3, orientation: Rotation) {
        let body = &self.bodies[i];
        let turned = way_of_turn(body.radius, &self.orientations[i], &orientation);
        self.path_length[i] += (body.position - before).norm() + turned;
        self.orientations[i] = orientation;
        self.frames[i] = frame(&orientation);
    }

    /// Ends a step of the films.
    pub(crate) fn settle_films(&mut self) {
        self.films.iter_mut().take(self.owned).for_each(BodyFilm::settle);
    }

    /// The packed form of an owned particle.
    pub fn record(&self, i: usize) -> ParticleRecord {
        ParticleRecord {
            id: self.ids[i],
            body: self.bodies[i],
            orientation: self.orientations.get(i).copied().unwrap_or_else(Rotation::identity),
            half_velocity: self.half_velocity[i],
            half_spin: self.half_spin[i],
            sides: self.sides[i],
            temperature: self.temperatures.get(i).copied().unwrap_or(0.0),
        }
    }

    /// Reorders the owned particles: the new i-th is the old `order[i]`. There must be no clones.
    pub(crate) fn reorder(&mut self, order: &[u32]) {
        permute(&mut self.bodies, order);
        permute(&mut self.ids, order);
        if self.has_orientations {
            permute(&mut self.orientations, order);
            permute(&mut self.frames, order);
            permute(&mut self.path_length, order);
        }
        permute(&mut self.loads, order);
        permute(&mut self.half_velocity, order);
        permute(&mut self.half_spin, order);
        permute(&mut self.sides, order);
        if self.carrying {
            permute(&mut self.cargo, order);
        }
        if self.is_wet {
            permute(&mut self.films, order);
        }
        if self.is_warm {
            permute(&mut self.temperatures, order);
            permute(&mut self.heat_flows, order);
        }
        if self.species > 0 {
            let row = |&k: &u32| {
                let first = k as usize * self.species;
                &self.amounts[first..first + self.species]
            };
            self.amounts = order.iter().flat_map(row).copied().collect();
        }
        self.owned = order.len();
    }
}

fn permute<T: Copy>(items: &mut Vec<T>, order: &[u32]) {
    let sorted: Vec<T> = order.iter().map(|&k| items[k as usize]).collect();
    *items = sorted;
}
