//! Bridges in a pass over the contacts.

use super::ledger::{LiquidLedger, quanta};
use crate::catalogue::ContactTable;
use crate::particles::Particles;
use grains_contact::{BridgeEnd, PreparedLaw, halves};

/// The other end of a bridge of a particle.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Partner {
    /// A particle, owned or clone.
    Particle(usize),
    /// A wall of this material.
    Wall(u16),
}

/// Lets the bridge of particle `i` and another body form or break, if films feed it; returns the sum of the thicknesses of the films
/// (m) where bridges form between films.
///
/// `radii` (m) are those that the law takes for the two, infinite of a wall, and `solid` (m) those of the spheres of their volumes.
#[inline]
pub(crate) fn follow_bridge(
    particles: &mut Particles,
    (i, partner): (usize, Partner),
    (law, contacts): (&PreparedLaw, &ContactTable),
    (gap, radii, solid): (f64, [f64; 2], [f64; 2]),
    (bridge, ledger): (&mut f64, &mut LiquidLedger),
) -> f64 {
    let (Some((liquid, supply)), Some(films)) = (law.attraction.fed_by_films(), contacts.films()) else {
        return 0.0;
    };
    let end = |k: usize, side: usize| BridgeEnd::Particle {
        film: particles.films[k].film,
        share: supply.share.of(radii[side], radii[1 - side]),
        radius: solid[side],
    };
    let (other, effective_radius) = match partner {
        Partner::Particle(j) => (end(j, 1), radii[0] * radii[1] / (radii[0] + radii[1])),
        Partner::Wall(material) => (supply.wall(films.on_wall(material), radii[0]), radii[0]),
    };
    let ends = [end(i, 0), other];
    let before = *bridge;
    let change = liquid.exchange(supply, bridge, gap, effective_radius, (&ends, films.quantum));
    if change.broken > 0.0 {
        give_back(particles, (i, partner), (law, films.quantum), change.broken, ledger);
    }
    let forms = before < 0.0 && *bridge > 0.0;
    if forms || *bridge < 0.0 {
        let mut note = |k: usize, side: usize| {
            if k < particles.owned {
                particles.films[k].gained -= change.taken[side];
                particles.films[k].claims += change.claimed[side];
                ledger.formed += u128::from(forms);
            }
        };
        note(i, 0);
        match partner {
            Partner::Particle(j) => note(j, 1),
            Partner::Wall(_) => {
                ledger.off_walls += quanta(change.taken[1], films.quantum);
                ledger.formed += u128::from(forms);
            }
        }
    }
    match liquid.formation {
        grains_contact::Formation::Contact => 0.0,
        grains_contact::Formation::Films => ends.iter().map(BridgeEnd::thickness).sum(),
    }
}

/// Breaks the bridge of particle `i` and a body that is out of reach, if films feed it; one that only claimed its liquid holds none.
#[inline]
pub(crate) fn end_bridge(
    particles: &mut Particles,
    (i, partner): (usize, Partner),
    (law, contacts): (&PreparedLaw, &ContactTable),
    (bridge, ledger): (&mut f64, &mut LiquidLedger),
) {
    let volume = std::mem::take(bridge);
    if let Some(films) = contacts.films().filter(|_| volume > 0.0) {
        give_back(particles, (i, partner), (law, films.quantum), volume, ledger);
    }
}

/// Gives the liquid of a broken bridge (m³) to the bodies at its ends.
fn give_back(
    particles: &mut Particles,
    (i, partner): (usize, Partner),
    (law, quantum): (&PreparedLaw, f64),
    volume: f64,
    ledger: &mut LiquidLedger,
) {
    let mut give = |k: usize, part: f64| {
        if k < particles.owned {
            particles.films[k].gained += part;
            ledger.broken += 1;
        }
    };
    match partner {
        Partner::Particle(j) => {
            let (first, second) = if particles.ids[i] < particles.ids[j] { (i, j) } else { (j, i) };
            let [low, high] = halves(volume, quantum);
            give(first, low);
            give(second, high);
        }
        Partner::Wall(_) => {
            let Some((_, supply)) = law.attraction.fed_by_films() else { return };
            let [own, stays] = supply.off_wall(volume, quantum);
            give(i, own);
            ledger.onto_walls += quanta(stays, quantum);
            ledger.broken += 1;
        }
    }
}
