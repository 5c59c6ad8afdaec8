//! When bridges form and rupture, and whose liquid they hold.
//!
//! Volumes of films and of bridges fed by films are multiples of a quantum, a power of two: their sums are exact.

use crate::liquid_bridge::LiquidBridge;
use crate::liquid_bridge::films::{Film, film_thickness};
use std::f64::consts::PI;

/// When a bridge forms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Formation {
    /// When the bodies touch.
    #[default]
    Contact,
    /// When the films on them touch, at a gap of the sum of their thicknesses.
    Films,
}

/// Where the liquid of a bridge comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Supply {
    /// Every bridge has this volume (m³), whatever there is on its bodies.
    PerBridge(f64),
    /// From the films on its bodies.
    Films(FilmSupply),
}

/// How bridges take liquid from films and give it back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmSupply {
    /// Share of a film that a bridge takes.
    pub share: FilmShare,
    /// Largest volume (m³) that a body gives to one bridge.
    pub largest: f64,
    /// Share (-) of a broken bridge with a wall that stays there, in [0, 1]; of two particles each keeps half.
    pub wall_share: f64,
}

/// Share of the film on a body that a bridge takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum FilmShare {
    /// The cap of the film that the other body sees, (1 − √(1 − (R2/(R1 + R2))²))/2 of it (Shi and McCarthy 2008); half of it at
    /// a wall.
    #[default]
    Cap,
    /// This share (-), in (0, 1].
    Constant(f64),
}

/// What is on one of the bodies of a bridge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BridgeEnd {
    /// A particle with a film, of which bridges take a share (-); the radius (m) is that of the sphere of its volume.
    Particle {
        /// Liquid on it.
        film: Film,
        /// Share that a bridge takes (-).
        share: f64,
        /// Radius (m).
        radius: f64,
    },
    /// A wall under a film of a thickness (m), which is not used up; a bridge takes a volume (m³).
    Wall {
        /// Thickness (m).
        thickness: f64,
        /// What a bridge takes (m³).
        volume: f64,
    },
}

/// What a step changes of a bridge fed by films (m³).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BridgeChange {
    /// What a bridge that forms claims from its bodies.
    pub claimed: [f64; 2],
    /// What a bridge that formed in the last step takes from them.
    pub taken: [f64; 2],
    /// Volume of a bridge that broke.
    pub broken: f64,
}

/// Bridges of less than this share (-) of the largest do not form.
const SMALLEST: f64 = 1e-6;

/// The multiple of a quantum at or below a volume.
#[inline]
pub fn whole_quanta(volume: f64, quantum: f64) -> f64 {
    (volume / quantum).floor() * quantum
}

/// What two bodies get of a bridge of this volume that breaks: half, and the quantum that is left over goes to the second.
#[inline]
pub fn halves(volume: f64, quantum: f64) -> [f64; 2] {
    let half = whole_quanta(0.5 * volume, quantum);
    [half, volume - half]
}

impl FilmShare {
    /// The share (-) of the film on a body of radius R1 (m) that touches one of radius R2 (m), infinite of a wall.
    #[inline]
    pub fn of(&self, radius: f64, other: f64) -> f64 {
        match *self {
            Self::Constant(share) => share,
            Self::Cap if other.is_infinite() => 0.5,
            Self::Cap => {
                let sine = other / (radius + other);
                0.5 * (1.0 - (1.0 - sine * sine).sqrt())
            }
        }
    }
}

impl FilmSupply {
    /// Volume (m³) that a body gives to a bridge which takes a share (-) of what is free (m³).
    #[inline]
    pub fn claim(&self, free: f64, share: f64, quantum: f64) -> f64 {
        whole_quanta((share * free).min(self.largest), quantum)
    }

    /// What a particle and a wall get of a bridge of this volume that breaks.
    #[inline]
    pub fn off_wall(&self, volume: f64, quantum: f64) -> [f64; 2] {
        let stays = whole_quanta(self.wall_share * volume, quantum);
        [volume - stays, stays]
    }

    /// The end of a bridge at a wall under a film (m), at a body of this radius (m): it takes what lies on a disc as wide as the
    /// body, π R² t, to which the cap of Shi and McCarthy tends for ever flatter bodies.
    #[inline]
    pub fn wall(&self, thickness: f64, radius: f64) -> BridgeEnd {
        BridgeEnd::Wall { thickness, volume: PI * radius * radius * thickness }
    }

    fn claim_of(&self, end: &BridgeEnd, quantum: f64) -> f64 {
        match *end {
            BridgeEnd::Particle { film, share, .. } => self.claim(film.free(), share, quantum),
            BridgeEnd::Wall { volume, .. } => self.claim(volume, 1.0, quantum),
        }
    }

    /// What a body gives of the claim of the last step.
    fn taken_from(&self, end: &BridgeEnd, quantum: f64) -> f64 {
        match *end {
            BridgeEnd::Particle { film, share, .. } => {
                whole_quanta(self.claim(film.offered, share, quantum) * film.granted(), quantum)
            }
            BridgeEnd::Wall { volume, .. } => self.claim(volume, 1.0, quantum),
        }
    }
}

impl BridgeEnd {
    /// Thickness (m) of the film.
    #[inline]
    pub fn thickness(&self) -> f64 {
        match *self {
            Self::Particle { film, radius, .. } => film_thickness(film.free(), radius),
            Self::Wall { thickness, .. } => thickness,
        }
    }
}

impl LiquidBridge {
    /// Whether a bridge forms at this gap (m), given the films' thicknesses (m).
    #[inline(always)]
    pub fn forms(&self, gap: f64, thicknesses: impl FnOnce() -> [f64; 2]) -> bool {
        match self.formation {
            Formation::Contact => gap <= 0.0,
            Formation::Films => gap <= thicknesses().iter().sum(),
        }
    }

    /// Lets a bridge of one volume (m³) form between films of a thickness (m), or break; its volume is 0 without one.
    #[inline]
    pub fn follow(&self, bridge: &mut f64, gap: f64, effective_radius: f64, volume: f64, film: f64) {
        if *bridge > 0.0 {
            if gap > self.rupture_distance(*bridge, effective_radius) {
                *bridge = 0.0;
            }
        } else if gap <= self.rupture_distance(volume, effective_radius) && self.forms(gap, || [film; 2]) {
            *bridge = volume;
        } else {
            *bridge = 0.0;
        }
    }

    /// Lets a bridge fed by films form or break, and returns what that changes.
    ///
    /// `bridge` is its volume (m³), 0 without one; the negative of its claims in the step in which it forms. Claims that the films
    /// could meet become its volume in the next step; those of bodies that are too far apart by then are dropped.
    #[inline]
    pub fn exchange(
        &self,
        supply: &FilmSupply,
        bridge: &mut f64,
        gap: f64,
        effective_radius: f64,
        (ends, quantum): (&[BridgeEnd; 2], f64),
    ) -> BridgeChange {
        let mut change = BridgeChange::default();
        let holds = |volume: f64| volume > 0.0 && gap <= self.rupture_distance(volume, effective_radius);
        if *bridge < 0.0 {
            let taken = ends.map(|end| supply.taken_from(&end, quantum));
            let volume = taken[0] + taken[1];
            *bridge = 0.0;
            if holds(volume) {
                (*bridge, change.taken) = (volume, taken);
            }
        } else if *bridge > 0.0 {
            if !holds(*bridge) {
                change.broken = std::mem::take(bridge);
            }
        } else if self.forms(gap, || ends.map(|end| end.thickness())) {
            let claims = ends.map(|end| supply.claim_of(&end, quantum));
            let volume = claims[0] + claims[1];
            // Films that touch farther apart than their liquid can reach make no bridge.
            if volume >= SMALLEST * supply.largest && holds(volume) {
                (*bridge, change.claimed) = (-volume, claims);
            }
        }
        change
    }
}
