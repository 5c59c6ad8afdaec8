//! The liquid that bridges hold, particle by particle: each end has what it gets when the bridge breaks.

use super::MaterialFilms;
use super::ledger::{LiquidLedger, quanta};
use crate::catalogue::Catalogue;
use crate::contact_history::{SavedHistories, WallHistory};
use crate::particles::{Body, Particles};
use crate::verlet::VerletLists;
use crate::walls::Wall;
use grains_contact::halves;

/// What a particle has of its bridges.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Held {
    /// Its parts of them (m³).
    pub(crate) own: f64,
    /// The parts of walls (m³).
    pub(crate) of_walls: f64,
    /// Its ends of bridges, and those of walls.
    pub(crate) ends: u128,
}

/// What tells the parts of a bridge.
pub(crate) struct Parts<'a> {
    films: &'a MaterialFilms,
    catalogue: &'a Catalogue,
    walls: &'a [Wall],
}

impl<'a> Parts<'a> {
    /// Those of a run whose particles carry films.
    pub(crate) fn of(catalogue: &'a Catalogue, walls: &'a [Wall]) -> Option<Self> {
        catalogue.contacts.films().map(|films| Self { films, catalogue, walls })
    }

    /// Volume (m³) of which all are multiples.
    pub(crate) fn quantum(&self) -> f64 {
        self.films.quantum
    }
}

impl Held {
    /// Adds the end of a bridge between particles.
    fn add(&mut self, parts: &Parts, bridge: f64, [id, other]: [u64; 2]) {
        if bridge > 0.0 {
            self.own += halves(bridge, parts.films.quantum)[usize::from(id > other)];
            self.ends += 1;
        }
    }

    /// Adds a bridge of a body with a wall.
    fn add_wall(&mut self, parts: &Parts, bridge: f64, (body, wall): (&Body, u16)) {
        let contacts = &parts.catalogue.contacts;
        let law = contacts.prepared(body.kind.material, parts.walls[usize::from(wall)].material);
        let Some((_, supply)) = law.attraction.fed_by_films().filter(|_| bridge > 0.0) else { return };
        let [own, stays] = supply.off_wall(bridge, parts.films.quantum);
        self.own += own;
        self.of_walls += stays;
        self.ends += 2;
    }

    /// That of a particle in a row of saved histories.
    pub(crate) fn in_row(
        parts: &Parts,
        histories: &SavedHistories,
        row: usize,
        (id, body): (u64, &Body),
    ) -> Self {
        let mut held = Self::default();
        for (history, law) in histories.spheres.row(row).iter().zip(histories.sphere_laws.row(row)) {
            held.add(parts, law.bridge, [id, history.partner]);
        }
        for history in firsts(histories.part_pairs.row(row), |h| (h.partner, h.contact.law.bridge)) {
            held.add(parts, history.contact.law.bridge, [id, history.partner]);
        }
        let is_sphere = parts.catalogue.shape(body.kind).is_sphere();
        for (wall, bridge) in bridges_with_walls(histories, row, is_sphere) {
            held.add_wall(parts, bridge, (body, wall));
        }
        held
    }

    /// That of every owned particle in the lists.
    pub(crate) fn in_lists(parts: &Parts, lists: &VerletLists, particles: &Particles) -> Vec<Self> {
        let mut all = vec![Self::default(); particles.owned];
        let mut add = |ends: [u32; 2], bridge: f64| {
            for [own, other] in [ends, [ends[1], ends[0]]].map(|ends| ends.map(|end| end as usize)) {
                if let Some(held) = all.get_mut(own) {
                    held.add(parts, bridge, [own, other].map(|k| particles.ids[k]));
                }
            }
        };
        for (pair, law) in lists.spheres.iter().zip(&lists.sphere_laws) {
            add([pair.a, pair.b], law.bridge);
        }
        let mut counted = None;
        for (pair, law) in lists.part_pairs.with_laws() {
            let ends = [pair.a, pair.b];
            if law.bridge > 0.0 && counted != Some(ends) {
                add(ends, law.bridge);
                counted = Some(ends);
            }
        }
        let mut counted = None;
        for (pair, law) in lists.walls.pairs.iter().zip(&lists.walls.laws) {
            let body = &particles.bodies[pair.particle as usize];
            let group = (pair.particle, pair.wall, pair.surface, pair.image);
            let is_sphere = parts.catalogue.shape(body.kind).is_sphere();
            if law.bridge > 0.0 && (is_sphere || counted != Some(group)) {
                all[pair.particle as usize].add_wall(parts, law.bridge, (body, pair.wall));
                counted = Some(group);
            }
        }
        all
    }

    /// Notes that a particle has left with what it held; walls keep their parts.
    pub(crate) fn leave(&self, film: f64, ledger: &mut LiquidLedger, quantum: f64) {
        ledger.left += quanta(film + self.own, quantum);
        ledger.onto_walls += quanta(self.of_walls, quantum);
        ledger.broken += self.ends;
    }
}

/// The first with a bridge of those of one key: contacts of the parts of two bodies share it.
fn firsts<T, Key: PartialEq>(rows: &[T], key: impl Fn(&T) -> (Key, f64)) -> impl Iterator<Item = &T> {
    let is_first = move |k: usize| {
        let (own, bridge) = key(&rows[k]);
        let has_been = |other: &T| matches!(key(other), (before, volume) if before == own && volume > 0.0);
        bridge > 0.0 && !rows[..k].iter().any(has_been)
    };
    (0..rows.len()).filter(move |&k| is_first(k)).map(|k| &rows[k])
}

/// Walls and volumes (m³) of the bridges with walls in a row of saved histories. A sphere has one with each element it touches,
/// another body one with a surface.
pub(crate) fn bridges_with_walls(
    histories: &SavedHistories,
    row: usize,
    is_sphere: bool,
) -> impl Iterator<Item = (u16, f64)> {
    let key = move |h: &WallHistory| {
        let element = if is_sphere { Some((h.element, h.part)) } else { None };
        ((h.wall, h.surface, h.image, element), h.contact.law.bridge)
    };
    firsts(histories.walls.row(row), key).map(|h| (h.wall, h.contact.law.bridge))
}
