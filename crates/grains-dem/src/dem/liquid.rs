//! Liquid on particles: put on, taken along, and accounted for.

use super::state::Dem;
use crate::error::StepError;
use crate::films::{BodyFilm, FILM_LENGTH, Held, Liquid, Parts, quanta};
use grains_domain::Transport;

impl Dem {
    /// Wets the particle inserted last as its material asks.
    pub(super) fn wet_last(&mut self) {
        let catalogue = &self.setup.catalogue;
        let (Some(films), Some(body)) = (catalogue.contacts.films(), self.particles.bodies.last()) else {
            return;
        };
        let volume = films.on_particle(body.kind.material, catalogue.volume(body));
        self.liquid_ledger.inserted += quanta(volume, films.quantum);
        if let Some(film) = self.particles.films.last_mut() {
            *film = BodyFilm::of_volume(volume);
        }
    }

    /// Gives the particle restored last its film, as of [`BodyFilm::numbers`]; one that has none is wetted anew.
    pub fn restore_film(&mut self, film: Option<[f64; FILM_LENGTH]>) {
        match (film, self.particles.films.last_mut()) {
            (Some(numbers), Some(film)) => *film = BodyFilm::from_numbers(numbers),
            _ => self.wet_last(),
        }
    }

    /// Notes what liquid particles have left with.
    pub(super) fn let_liquid_leave(&mut self, left: &[u32]) {
        let Self { particles, histories, setup, liquid_ledger, .. } = self;
        let Some(parts) = Parts::of(&setup.catalogue, &setup.walls) else { return };
        for i in left.iter().map(|&i| i as usize) {
            let held = Held::in_row(&parts, histories, i, (particles.ids[i], &particles.bodies[i]));
            held.leave(particles.films[i].volume(), liquid_ledger, parts.quantum());
        }
    }

    /// Gives back the liquid of bridges whose bodies are too far apart for the lists just built, or are no longer there.
    ///
    /// `order` has the places of the particles in the histories the lists were built with.
    pub(super) fn break_bridges_out_of_lists(&mut self, order: &[u32]) {
        let Self { particles, histories, neighbours, setup, liquid_ledger, .. } = self;
        let Some(parts) = Parts::of(&setup.catalogue, &setup.walls) else { return };
        let listed = Held::in_lists(&parts, neighbours, particles);
        for (i, now) in listed.iter().enumerate() {
            let before =
                Held::in_row(&parts, histories, order[i] as usize, (particles.ids[i], &particles.bodies[i]));
            particles.films[i].gained += before.own - now.own;
            liquid_ledger.onto_walls += quanta(before.of_walls - now.of_walls, parts.quantum());
            liquid_ledger.broken += before.ends - now.ends;
        }
    }

    /// What each owned particle has of its bridges.
    fn held(&self) -> Vec<Held> {
        let Self { particles, histories, neighbours, setup, .. } = self;
        let Some(parts) = Parts::of(&setup.catalogue, &setup.walls) else { return Vec::new() };
        match self.history_saved {
            true => (0..particles.owned)
                .map(|i| Held::in_row(&parts, histories, i, (particles.ids[i], &particles.bodies[i])))
                .collect(),
            false => Held::in_lists(&parts, neighbours, particles),
        }
    }

    /// Volume (m³) of the film on each owned particle, and with its parts of bridges; empty in a run without films.
    pub fn liquid_of_each(&self) -> Vec<[f64; 2]> {
        let films = self.particles.films.iter().map(BodyFilm::volume);
        films.zip(self.held()).map(|(film, held)| [film, film + held.own]).collect()
    }

    /// Checks that all liquid put on particles is on them, in bridges, on walls or has left; returns where it is, over all ranks.
    ///
    /// # Errors
    /// Liquid or bridges that are unaccounted for.
    pub fn check_liquid(&self, transport: &impl Transport) -> Result<Liquid, StepError> {
        let Some(films) = self.setup.catalogue.contacts.films() else { return Ok(Liquid::default()) };
        let q = films.quantum;
        let (mut on_particles, mut in_bridges, mut ends) = (0, 0, 0);
        for (film, held) in self.particles.films.iter().zip(self.held()) {
            on_particles += quanta(film.volume(), q);
            in_bridges += quanta(held.own, q) + quanta(held.of_walls, q);
            ends += held.ends;
        }
        let [inserted, left, onto_walls, off_walls, formed, broken] = self.liquid_ledger.numbers();
        let volumes = [on_particles, in_bridges, inserted, left, onto_walls, off_walls];
        // In two halves, of which no sum over ranks overflows.
        let mut counts: Vec<u64> = volumes.iter().flat_map(|n| [n & u64::from(u32::MAX), n >> 32]).collect();
        counts.extend([ends, formed, broken]);
        transport.sum_counts(&mut counts);
        let whole = |k: usize| i128::from(counts[2 * k]) + (i128::from(counts[2 * k + 1]) << 32);
        let [on_particles, in_bridges, inserted, left, onto, off] = [0, 1, 2, 3, 4, 5].map(whole);
        let (ends, formed, broken) = (counts[12], counts[13], counts[14]);
        let missing = inserted + off - onto - left - on_particles - in_bridges;
        let cubic_metres = |n: i128| n as f64 * q;
        if missing != 0 || formed != ends + broken {
            return Err(StepError::Liquid {
                missing: cubic_metres(missing),
                inserted: cubic_metres(inserted),
                bridges: (formed as i64 - ends as i64 - broken as i64) / 2,
            });
        }
        Ok(Liquid {
            films: cubic_metres(on_particles),
            bridges: cubic_metres(in_bridges),
            walls: cubic_metres(onto - off),
            inserted: cubic_metres(inserted),
            left: cubic_metres(left),
            count: ends / 2,
            broken: broken / 2,
        })
    }
}
