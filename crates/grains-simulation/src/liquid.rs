//! Films of a case: what they come to, and the liquid in a checkpoint and back.

use crate::insertion::KindRange;
use crate::laws;
use crate::restart::{State, reals, words};
use grains_case::{Case, Film};
use grains_comm::MpiTransport;
use grains_contact::{
    BridgeEnd, ContactLaw, Film as FilmState, FilmAmount, FilmSupply, LiquidBridge, sphere_radius,
};
use grains_dem::{BodyFilm, Catalogue, Dem, FILM_LENGTH, LiquidLedger, MaterialFilms};
use grains_domain::sum_wide;
use grains_output::{Array, CheckpointFile, Values};
use std::f64::consts::PI;

/// Array of a checkpoint: film, claims, what was offered to these, and what is still to be given back (m³).
const FILM: &str = "film";
/// Texts of a checkpoint: the quantum (m³), and the ledger in quanta.
pub const QUANTUM: &str = "liquid_quantum";
const LEDGER: &str = "liquid";

/// A particle that films are on.
#[derive(Clone, Copy)]
struct WetBody {
    /// Radius (m) that laws take.
    radius: f64,
    /// Radius (m) of the sphere of its volume.
    solid: f64,
    /// Volume (m³) of its film.
    film: f64,
}

/// Puts the films of a case on its materials, and gives bridges that have none the bound of their volume.
pub fn wet(case: &Case, catalogue: &mut Catalogue, kinds: &[KindRange]) {
    if !case.contacts.iter().any(laws::is_fed_by_films) {
        return;
    }
    let amounts = amounts(case);
    let largest = kinds.iter().map(|kind| body(catalogue, &amounts, kind, kind.largest).film);
    let largest = largest.fold(f64::MIN_POSITIVE, f64::max);
    for contact in case.contacts.iter().filter(|contact| laws::is_fed_by_films(contact)) {
        let [a, b] = contact.between;
        let mut law = *catalogue.contacts.law(a as u16, b as u16);
        if laws::max_volume(contact).is_none() {
            let of = (&*catalogue, &amounts[..]);
            // Half of a bridge may come from either body: one twice as large as at the beginning holds.
            law.attraction.bound_shares(|supply| largest_bridge(case, of, [a, b], kinds, supply));
            catalogue.contacts.set(a, b, law);
        }
    }
    catalogue.contacts.wet(MaterialFilms::new(amounts, largest));
}

/// How much is on bodies of each material.
fn amounts(case: &Case) -> Vec<Option<FilmAmount>> {
    let amount = |material: &grains_case::Material| {
        Some(match material.film? {
            Film::Volume { volume } => FilmAmount::Volume(volume),
            Film::Thickness { thickness } => FilmAmount::Thickness(thickness),
            Film::Content { content } => FilmAmount::Content(content),
            Film::MassContent { content, liquid_density } => {
                FilmAmount::Content(content * material.density.unwrap_or(0.0) / liquid_density)
            }
        })
    };
    case.materials.iter().map(amount).collect()
}

fn body(catalogue: &Catalogue, amounts: &[Option<FilmAmount>], kind: &KindRange, scale: f64) -> WetBody {
    let shape = catalogue.shape(kind.kind);
    let volume = shape.volume * scale.powi(3);
    let amount = amounts[usize::from(kind.kind.material)];
    WetBody {
        radius: shape.part_radius() * scale,
        solid: sphere_radius(volume),
        film: amount.map_or(0.0, |amount| amount.volume(volume)),
    }
}

fn wall_thickness(amounts: &[Option<FilmAmount>], material: usize) -> f64 {
    match amounts[material] {
        Some(FilmAmount::Thickness(thickness)) => thickness,
        _ => 0.0,
    }
}

/// Volume (m³) of the largest bridge that forms between two materials as films are at the beginning.
fn largest_bridge(
    case: &Case,
    (catalogue, amounts): (&Catalogue, &[Option<FilmAmount>]),
    between: [usize; 2],
    kinds: &[KindRange],
    supply: &FilmSupply,
) -> f64 {
    let of = |material: usize| {
        let kinds = kinds.iter().filter(move |kind| usize::from(kind.kind.material) == material);
        kinds.map(|kind| body(catalogue, amounts, kind, kind.largest))
    };
    let share = |own: &WetBody, other: f64| supply.share.of(own.radius, other) * own.film;
    let mut largest = 0.0_f64;
    for (own, other) in [(between[0], between[1]), (between[1], between[0])] {
        let has_walls = case.walls.iter().any(|wall| wall.material == other);
        let thickness = wall_thickness(amounts, other);
        for one in of(own) {
            for partner in of(other) {
                largest = largest.max(share(&one, partner.radius) + share(&partner, one.radius));
            }
            if has_walls {
                let of_wall = PI * one.radius * one.radius * thickness;
                largest = largest.max(share(&one, f64::INFINITY) + of_wall);
            }
        }
    }
    largest
}

/// What the bridges of two materials come to, of the smallest and the largest particles.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmReport {
    /// Film on a particle (m³), its thickness (m), and its volume over that of the particle (-).
    pub films: [[f64; 3]; 2],
    /// A bridge between two such particles, or one and a wall, as films are at the beginning (m³), and where it breaks (m).
    pub bridges: [[f64; 2]; 2],
    /// Largest volume of a bridge (m³).
    pub largest: f64,
    /// Pull at contact (N) of the bridge of the smallest.
    pub(crate) pull: f64,
}

impl FilmReport {
    /// Of a law between two materials, the second that of a wall if it is one.
    pub(crate) fn of(
        case: &Case,
        catalogue: &Catalogue,
        kinds: &[KindRange],
        (law, materials, is_wall): (&ContactLaw, [usize; 2], bool),
    ) -> Option<Self> {
        let (bridge, supply) = law.attraction.fed_by_films()?;
        let amounts = amounts(case);
        let of = |material: usize| kinds.iter().filter(move |k| usize::from(k.kind.material) == material);
        let wet = |material: usize, is_largest: bool| {
            let bodies = of(material).map(|k| {
                let scale = if is_largest { k.largest } else { k.smallest };
                body(catalogue, &amounts, k, scale)
            });
            bodies.reduce(|a, b| if (a.solid < b.solid) == is_largest { b } else { a })
        };
        let pair = |is_largest: bool| -> Option<(WetBody, f64, f64)> {
            let one = wet(materials[0], is_largest)?;
            let (other, effective) = match is_wall {
                true => (supply.wall(wall_thickness(&amounts, materials[1]), one.radius), one.radius),
                false => {
                    let other = wet(materials[1], is_largest)?;
                    (end(&other, one.radius, supply), one.radius * other.radius / (one.radius + other.radius))
                }
            };
            let radius = if is_wall { f64::INFINITY } else { wet(materials[1], is_largest)?.radius };
            Some((one, bridge_volume(bridge, supply, [end(&one, radius, supply), other]), effective))
        };
        let [small, large] = [pair(false)?, pair(true)?];
        let film = |(one, ..): &(WetBody, f64, f64)| {
            let thickness = grains_contact::film_thickness(one.film, one.solid);
            [one.film, thickness, one.film / (4.0 / 3.0 * PI * one.solid.powi(3))]
        };
        let held = |(_, volume, effective): &(WetBody, f64, f64)| {
            [*volume, if *volume > 0.0 { bridge.rupture_distance(*volume, *effective) } else { 0.0 }]
        };
        Some(Self {
            films: [film(&small), film(&large)],
            bridges: [held(&small), held(&large)],
            largest: 2.0 * supply.largest,
            pull: if small.1 > 0.0 { bridge.pull(0.0, small.1, small.2) } else { 0.0 },
        })
    }
}

fn end(body: &WetBody, other: f64, supply: &FilmSupply) -> BridgeEnd {
    BridgeEnd::Particle {
        film: FilmState { volume: body.film, claimed: 0.0, offered: body.film },
        share: supply.share.of(body.radius, other),
        radius: body.solid,
    }
}

/// Volume (m³) of a bridge that forms between two bodies that touch.
fn bridge_volume(bridge: &LiquidBridge, supply: &FilmSupply, ends: [BridgeEnd; 2]) -> f64 {
    let mut volume = 0.0;
    bridge.exchange(supply, &mut volume, 0.0, 1.0, (&ends, f64::MIN_POSITIVE));
    -volume
}

/// Adds the liquid to a checkpoint, if there is any.
pub fn save(dem: &Dem, (arrays, texts): &mut State, transport: &MpiTransport) {
    let Some(films) = dem.setup.catalogue.contacts.films() else { return };
    let own = dem.particles.films.iter().take(dem.particles.owned);
    let values = Values::Real(own.flat_map(BodyFilm::numbers).collect());
    arrays.push(Array { name: FILM, unit: "m3", width: FILM_LENGTH, values });
    texts.push((QUANTUM.into(), words(&[films.quantum])));
    let mut ledger = dem.liquid_ledger.numbers();
    sum_wide(&mut ledger, transport);
    texts.push((LEDGER.into(), ledger.map(|count| count.to_string()).join(" ")));
}

/// Films of a checkpoint, in the order of its particles; none if it has none or the case is dry. All volumes stay multiples of its
/// quantum.
pub fn films<'a>(file: &'a CheckpointFile, dem: &mut Dem) -> Option<&'a [f64]> {
    let quantum = file.text(QUANTUM).and_then(reals)?.first().copied()?;
    let contacts = &mut dem.setup.catalogue.contacts;
    let films = MaterialFilms { quantum, ..contacts.films()?.clone() };
    contacts.wet(films);
    saved_films(file)
}

/// Films of a checkpoint, in the order of its particles.
pub fn saved_films(file: &CheckpointFile) -> Option<&[f64]> {
    file.text(QUANTUM).and_then(|_| file.real(FILM).ok())
}

/// The ledger of a checkpoint.
pub fn ledger(file: &CheckpointFile) -> Option<LiquidLedger> {
    let counts: Vec<u128> = file.text(LEDGER)?.split_whitespace().filter_map(|n| n.parse().ok()).collect();
    Some(LiquidLedger::from_numbers(counts.try_into().ok()?))
}
