//! Wear of walls by the particles that slide on them.
//!
//! ```text
//!  dV/dt = K/H Σ Fₙ |v_t|      (Archard 1953)
//! ```
//!
//! with the worn volume V, the wear coefficient K, the hardness H, and over the contacts the normal force Fₙ that presses on
//! the wall and the velocity v_t along it, relative to the wall. What slides is counted in whole quanta of Fₙ |v_t| Δt, so
//! that sums over contacts, steps and ranks are exact in any order. A step counts once it is done.

use super::pairs::WallPair;
use super::wall::Wall;
use grains_contact::Encounter;
use grains_domain::{Transport, sum_wide};
use grains_geometry::Vec3;

/// How a wall wears (Archard 1953).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wear {
    /// Wear coefficient K (-).
    pub coefficient: f64,
    /// Hardness H of the wall (Pa).
    pub hardness: f64,
}

impl Wear {
    /// Worn volume (m³) per normal force times sliding distance (J): K/H.
    pub fn volume_per_work(&self) -> f64 {
        self.coefficient / self.hardness
    }
}

/// What has worn off a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WornWall {
    /// Worn volume since the beginning (m³), of the steps that are done.
    pub volume: f64,
    /// Σ Fₙ |v_t| of the last contacts that were evaluated (W).
    pub sliding_power: f64,
}

/// What has slid on an element of a wall, a triangle of a mesh or all of another surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WornElement {
    /// Number of the wall.
    pub wall: u16,
    /// Number of the surface in the wall.
    pub surface: u16,
    /// Triangle of a mesh, else 0.
    pub element: u32,
    /// Quanta of normal force times sliding distance.
    pub quanta: u128,
}

/// A contact that slides in a step.
#[derive(Clone, Copy, Debug)]
struct Slide {
    wall: u16,
    surface: u16,
    element: u32,
    /// Fₙ |v_t| Δt, a whole number of quanta.
    quanta: f64,
}

/// What slides on the walls that wear, on one rank.
#[derive(Clone, Debug)]
pub(crate) struct SlidingSums {
    /// Quantum of normal force times sliding distance (J), a power of two.
    pub(crate) quantum: f64,
    /// Contacts of the step that was evaluated last.
    slides: Vec<Slide>,
    /// Quanta of the steps done on each element of each surface of each wall; no surface of a wall that does not wear,
    /// and no wall if none does.
    done: Vec<Vec<Vec<u128>>>,
}

impl SlidingSums {
    /// Sums of walls on which nothing has slid.
    ///
    /// A contact of the largest force that slides by the largest radius has a work of some 2⁵² times `torque_quantum` (N m).
    pub(crate) fn new(walls: &[Wall], torque_quantum: f64) -> Self {
        // Room for 2⁴⁴ such contacts, and twelve digits of those whose work is a trillionth of theirs.
        let quantum = torque_quantum * 2.0_f64.powi(-32);
        let elements = |wall: &Wall| match wall.wear {
            Some(_) => wall.surfaces.iter().map(|surface| vec![0; surface.worn_elements()]).collect(),
            None => Vec::new(),
        };
        let is_any = walls.iter().any(|wall| wall.wear.is_some());
        let done = if is_any { walls.iter().map(elements).collect() } else { Vec::new() };
        Self { quantum, slides: Vec::new(), done }
    }

    /// Whether a wall wears.
    #[inline(always)]
    pub(crate) fn counts(&self, wall: u16) -> bool {
        self.done.get(usize::from(wall)).is_some_and(|surfaces| !surfaces.is_empty())
    }

    /// A step begins.
    pub(crate) fn begin(&mut self) {
        self.slides.clear();
    }

    /// Notes a contact with an element that wears, which exerts a force (N) on its particle through a step of `dt` (s).
    #[inline]
    pub(super) fn note(
        &mut self,
        (pair, element): (&WallPair, u32),
        encounter: &Encounter,
        force: &Vec3,
        dt: f64,
    ) {
        let Encounter { normal, overlap, velocity, .. } = encounter;
        // What presses over a gap is liquid.
        if *overlap <= 0.0 {
            return;
        }
        let pressing = (-force.dot(normal)).max(0.0);
        let sliding = velocity - normal * velocity.dot(normal);
        let quanta = (pressing * sliding.norm() * dt / self.quantum).round();
        if quanta > 0.0 {
            let WallPair { wall, surface, .. } = *pair;
            self.slides.push(Slide { wall, surface, element, quanta });
        }
    }

    /// The step is done; to be called once in each.
    pub(crate) fn finish(&mut self) {
        for &Slide { wall, surface, element, quanta } in &self.slides {
            add(&mut self.done, WornElement { wall, surface, element, quanta: quanta as u128 });
        }
    }

    /// Quanta on each wall of the step evaluated last, and of all steps done, over all ranks.
    pub(crate) fn of_walls(&self, transport: &impl Transport) -> Vec<[u128; 2]> {
        let done = self.done.iter().map(|surfaces| [0, surfaces.iter().flatten().sum()]);
        let mut sums: Vec<[u128; 2]> = done.collect();
        for slide in &self.slides {
            sums[usize::from(slide.wall)][0] += slide.quanta as u128;
        }
        sum_wide(sums.as_flattened_mut(), transport);
        sums
    }

    /// Quanta of the steps done on each element, over all ranks.
    pub(crate) fn of_elements(&self, transport: &impl Transport) -> Vec<Vec<Vec<u128>>> {
        let mut flat: Vec<u128> = self.done.iter().flatten().flatten().copied().collect();
        sum_wide(&mut flat, transport);
        let mut flat = flat.into_iter();
        let mut of_surface = |surface: &Vec<u128>| flat.by_ref().take(surface.len()).collect();
        self.done.iter().map(|wall| wall.iter().map(&mut of_surface).collect()).collect()
    }

    /// Adds what slid on an element in an earlier run.
    pub(crate) fn restore(&mut self, worn: WornElement) {
        if self.counts(worn.wall) {
            add(&mut self.done, worn);
        }
    }
}

/// Adds to an element; a surface that counts as one has but the first.
fn add(done: &mut [Vec<Vec<u128>>], worn: WornElement) {
    let elements = &mut done[usize::from(worn.wall)][usize::from(worn.surface)];
    let element = if elements.len() == 1 { 0 } else { worn.element as usize };
    elements[element] += worn.quanta;
}
