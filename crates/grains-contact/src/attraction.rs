//! Forces between bodies that need not touch, beside those of their contact.

use crate::encounter::Encounter;
use crate::liquid_bridge::{FilmSupply, Formation, LiquidBridge, Supply};
use crate::step_share::share_in_contact;
use crate::van_der_waals::VanDerWaals;
use nalgebra::Vector3;

type Vec3 = Vector3<f64>;

/// How two bodies pull at each other over a gap. Friction and rolling resistance do not feel it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Attraction {
    /// Not at all.
    #[default]
    None,
    /// By a bridge of liquid, which forms on contact, or where films of this thickness (m) on both bodies meet, and breaks at
    /// its rupture distance: that of Lian, which is the same for all radii.
    LiquidBridge {
        /// The liquid and its bridges.
        bridge: LiquidBridge,
        /// Thickness of the films (m) of bridges of one volume.
        film: f64,
    },
    /// By van der Waals forces.
    VanDerWaals(VanDerWaals),
}

/// How two bodies are placed, in a step.
#[derive(Clone, Copy, Debug)]
pub struct Neighbourhood {
    /// Effective radius R* (m).
    pub radius: f64,
    /// Effective mass (kg).
    pub mass: f64,
    /// Time step (s).
    pub dt: f64,
    /// Sum of the thicknesses of their films (m), where bridges take liquid from these.
    pub films: f64,
}

impl Attraction {
    /// Whether there is any.
    #[inline(always)]
    pub fn is_active(&self) -> bool {
        *self != Self::None
    }

    /// Whether a pair keeps the volume of its bridge.
    pub fn keeps_volume(&self) -> bool {
        matches!(self, Self::LiquidBridge { .. })
    }

    /// The bridges, if films feed them.
    #[inline]
    pub fn fed_by_films(&self) -> Option<(&LiquidBridge, &FilmSupply)> {
        match self {
            Self::LiquidBridge { bridge, .. } => match &bridge.supply {
                Supply::Films(supply) => Some((bridge, supply)),
                Supply::PerBridge(_) => None,
            },
            _ => None,
        }
    }

    /// Sets the largest volume (m³) that a body gives to a bridge, if films feed these.
    pub fn bound_shares(&mut self, largest: impl FnOnce(&FilmSupply) -> f64) {
        if let Self::LiquidBridge { bridge: LiquidBridge { supply: Supply::Films(supply), .. }, .. } = self {
            supply.largest = largest(supply);
        }
    }

    /// Largest gap (m) at which bodies of this effective radius (m) act on each other.
    pub fn reach(&self, radius: f64) -> f64 {
        match self {
            Self::None => 0.0,
            Self::LiquidBridge { bridge, film } => match bridge.supply {
                Supply::PerBridge(volume) => bridge.rupture_distance(volume, radius).max(2.0 * film),
                Supply::Films(supply) => bridge.rupture_distance(2.0 * supply.largest, radius),
            },
            Self::VanDerWaals(law) => law.outer,
        }
    }

    /// Largest pull (N) between bodies of this effective radius (m).
    pub fn force_bound(&self, radius: f64) -> f64 {
        match self {
            Self::None => 0.0,
            Self::LiquidBridge { bridge, .. } => bridge.force_bound(radius),
            Self::VanDerWaals(law) => law.pull(0.0, radius),
        }
    }

    /// Pull at contact (N) between bodies of this effective radius (m), of the largest bridge.
    pub fn pull_off(&self, radius: f64) -> f64 {
        match self {
            Self::None => 0.0,
            Self::LiquidBridge { bridge, .. } => match bridge.supply {
                Supply::PerBridge(volume) => bridge.pull(0.0, volume, radius),
                Supply::Films(supply) => bridge.pull(0.0, 2.0 * supply.largest, radius),
            },
            Self::VanDerWaals(law) => law.pull(0.0, radius),
        }
    }

    /// Force on body 1 (N). `volume` is that of the bridge (m³), 0 without one.
    ///
    /// A bridge of one volume forms and breaks here. One fed by films has done so in [`LiquidBridge::exchange`], and has a negative
    /// volume if it has just formed. The pull of a bridge is there at once when it forms, and goes when it breaks: the first and the
    /// last evaluation stand for all of it since, or until. Its dashpots are implicit, c/(1 + c dt/m).
    #[inline]
    pub fn force(&self, encounter: &Encounter, at: &Neighbourhood, volume: &mut f64) -> Vec3 {
        let Encounter { normal, overlap, velocity, .. } = *encounter;
        match self {
            Self::None => Vec3::zeros(),
            Self::VanDerWaals(law) => normal * law.pull(-overlap, at.radius),
            Self::LiquidBridge { bridge, film } => {
                let gap = -overlap;
                let opening = velocity.dot(&normal);
                let is_old = *volume > 0.0;
                let films = match bridge.supply {
                    Supply::PerBridge(of_one) => {
                        bridge.follow(volume, gap, at.radius, of_one, *film);
                        2.0 * film
                    }
                    Supply::Films(_) => at.films,
                };
                let volume = volume.abs();
                if volume == 0.0 {
                    return Vec3::zeros();
                }
                let forming = match bridge.formation {
                    Formation::Contact => 0.0,
                    Formation::Films => films,
                };
                let margin = match is_old {
                    true => bridge.rupture_distance(volume, at.radius) - gap,
                    false => overlap + forming,
                };
                let share = share_in_contact(margin, opening, at.dt);
                let (gap, viscosity) = (gap.max(0.0), &bridge.viscosity);
                let pull = bridge.pull(gap, volume, at.radius) * share;
                if viscosity.viscosity == 0.0 {
                    return normal * pull;
                }
                let implicit = |dashpot: f64| dashpot / (1.0 + dashpot * at.dt / at.mass);
                let squeezing = implicit(viscosity.normal_dashpot(gap, at.radius));
                let shearing = implicit(viscosity.tangential_dashpot(gap, at.radius));
                let sliding = velocity - normal * opening;
                normal * (pull + squeezing * opening) + sliding * shearing
            }
        }
    }
}
