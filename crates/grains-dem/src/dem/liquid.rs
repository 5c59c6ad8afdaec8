//! Liquid on particles: put on, taken along, and accounted for.

use super::state::Dem;
use crate::contact_history::SavedHistories;
use crate::error::StepError;
use crate::films::{BodyFilm, FILM_LENGTH, Held, Liquid, Parts, bridges_with_walls, quanta};
use crate::particles::Kind;
use grains_domain::{Transport, sum_wide};

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

    /// Leaves the bridges of a particle with walls that are no longer there on these: `number` is that of a wall now, `packed` the
    /// contact history as of [`Dem::packed_history`], before.
    pub fn leave_on_walls(&mut self, packed: &[f64], kind: Kind, number: impl Fn(u16) -> Option<u16>) {
        let catalogue = &self.setup.catalogue;
        let Some(films) = catalogue.contacts.films() else { return };
        let mut histories = SavedHistories::default();
        histories.read(packed);
        let is_gone = |wall: u16| number(wall).is_none();
        let volumes = bridges_with_walls(&histories, 0, catalogue.shape(kind).is_sphere());
        let volumes = volumes.filter(|(wall, _)| is_gone(*wall)).map(|(_, volume)| volume);
        for volume in volumes {
            self.liquid_ledger.onto_walls += quanta(volume, films.quantum);
            self.liquid_ledger.broken += 2;
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
    /// `order` has the places of the particles in the histories the lists were built with, if they were sorted.
    pub(super) fn break_bridges_out_of_lists(&mut self, order: Option<&[u32]>) {
        let Self { particles, histories, neighbours, setup, liquid_ledger, .. } = self;
        let Some(parts) = Parts::of(&setup.catalogue, &setup.walls) else { return };
        let listed = Held::in_lists(&parts, neighbours, particles);
        for (i, now) in listed.iter().enumerate() {
            let row = order.map_or(i, |order| order[i] as usize);
            let before = Held::in_row(&parts, histories, row, (particles.ids[i], &particles.bodies[i]));
            particles.films[i].gained += before.own - now.own;
            liquid_ledger.onto_walls += quanta(before.of_walls - now.of_walls, parts.quantum());
            // There are more ends than before where a checkpoint has a bridge on one side alone: the check of the liquid tells it.
            liquid_ledger.broken = liquid_ledger.broken.wrapping_add(before.ends).wrapping_sub(now.ends);
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
        let [inserted, left, onto, off, formed, broken] = self.liquid_ledger.numbers();
        let mut counts = [on_particles, in_bridges, inserted, left, onto, off, ends, formed, broken];
        sum_wide(&mut counts, transport);
        let counts = counts.map(u128::cast_signed);
        let [on_particles, in_bridges, inserted, left, onto, off, ends, formed, broken] = counts;
        let missing = inserted + off - onto - left - on_particles - in_bridges;
        let cubic_metres = |n: i128| n as f64 * q;
        if missing != 0 || formed != ends + broken {
            return Err(StepError::Liquid {
                missing: cubic_metres(missing),
                inserted: cubic_metres(inserted),
                bridges: ((formed - ends - broken) / 2) as i64,
            });
        }
        Ok(Liquid {
            films: cubic_metres(on_particles),
            bridges: cubic_metres(in_bridges),
            walls: cubic_metres(onto - off),
            inserted: cubic_metres(inserted),
            left: cubic_metres(left),
            count: (ends / 2) as u64,
            broken: (broken / 2) as u64,
        })
    }
}
