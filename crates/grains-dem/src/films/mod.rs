//! Liquid on particles and in the bridges between them.
//!
//! Every volume is a whole number of quanta, a power of two, so that sums are exact and have no order. A particle's film, with what
//! bridges of the last step claimed of it, travels to its clones with their position. Both ranks of a pair so find the same bridge;
//! what bridges take and give back the owner of each particle adds up, for the end of the step.

mod held;
mod ledger;
mod pass;

pub(crate) use held::{Held, Parts, bridges_with_walls};
pub(crate) use ledger::quanta;
pub use ledger::{Liquid, LiquidLedger};
pub(crate) use pass::{Partner, end_bridge, follow_bridge};

use grains_contact::{Film, FilmAmount, whole_quanta};

/// The liquid on the materials of a run.
#[derive(Clone, Debug)]
pub struct MaterialFilms {
    /// Volume (m³), a power of two, of which all volumes of liquid are multiples.
    pub quantum: f64,
    /// How much is on bodies of each material, if any; of walls the thickness counts.
    pub of_material: Vec<Option<FilmAmount>>,
}

impl MaterialFilms {
    /// Films of which the largest on any particle has this volume (m³).
    ///
    /// It is 2³⁸ quanta, 1/2³⁸ = 3.6e-12. A film may grow 2¹² times as large before sums lose exactness.
    pub fn new(of_material: Vec<Option<FilmAmount>>, largest: f64) -> Self {
        let mut quantum = 2.0_f64.powi(-38);
        while quantum * 2.0_f64.powi(38) < largest {
            quantum *= 2.0;
        }
        while quantum * 2.0_f64.powi(37) >= largest {
            quantum *= 0.5;
        }
        Self { quantum, of_material }
    }

    /// Volume (m³) on a particle of a material that has this volume (m³).
    pub(crate) fn on_particle(&self, material: u16, volume: f64) -> f64 {
        let amount = self.of_material.get(usize::from(material)).copied().flatten();
        whole_quanta(amount.map_or(0.0, |amount| amount.volume(volume)), self.quantum)
    }

    /// Thickness (m) of the film on walls of a material.
    pub(crate) fn on_wall(&self, material: u16) -> f64 {
        match self.of_material.get(usize::from(material)) {
            Some(Some(FilmAmount::Thickness(thickness))) => *thickness,
            _ => 0.0,
        }
    }
}

/// Liquid on a particle, and what the contacts of a step change of it (m³).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyFilm {
    /// The film at the beginning of the step.
    pub film: Film,
    /// What broken bridges have given back in this step less what new ones have taken.
    pub(crate) gained: f64,
    /// What bridges that form in this step claim.
    pub(crate) claims: f64,
}

/// Numbers that tell of the film on a particle.
pub const FILM_LENGTH: usize = 4;
/// Numbers that tell a clone of it.
pub(crate) const FILM_UPDATE_LENGTH: usize = 3;

impl BodyFilm {
    /// A film of this volume (m³) of which nothing is claimed.
    pub(crate) fn of_volume(volume: f64) -> Self {
        Self { film: Film { volume, claimed: 0.0, offered: volume }, ..Self::default() }
    }

    /// Volume (m³) on the particle now.
    pub fn volume(&self) -> f64 {
        self.film.volume + self.gained
    }

    /// The film between two steps, as numbers.
    pub fn numbers(&self) -> [f64; FILM_LENGTH] {
        let Film { volume, claimed, offered } = self.film;
        [volume, claimed, offered, self.gained]
    }

    /// The film of these numbers.
    pub fn from_numbers([volume, claimed, offered, gained]: [f64; FILM_LENGTH]) -> Self {
        Self { film: Film { volume, claimed, offered }, gained, claims: 0.0 }
    }

    /// What a clone is told.
    #[inline(always)]
    pub(crate) fn update(&self) -> [f64; FILM_UPDATE_LENGTH] {
        let Film { volume, claimed, offered } = self.film;
        [volume, claimed, offered]
    }

    /// The film of a clone.
    #[inline(always)]
    pub(crate) fn of_update(update: &[f64]) -> Self {
        let film = Film { volume: update[0], claimed: update[1], offered: update[2] };
        Self { film, ..Self::default() }
    }

    /// Ends the step.
    #[inline]
    pub(crate) fn settle(&mut self) {
        let Self { film, gained, claims } = *self;
        let film = Film { volume: film.volume + gained, claimed: claims, offered: film.free() };
        *self = Self { film, ..Self::default() };
    }
}
