//! When bridges form and rupture, and whose liquid they hold.

use crate::cube_root::cube_root;
use crate::liquid_bridge::LiquidBridge;
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

/// How much liquid a bridge takes from the films of its bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Supply {
    /// This volume (m³), half of it from each body, as far as its film goes.
    PerBridge(f64),
    /// This share (-) of the film of each body, in (0, 1].
    ShareOfFilms(f64),
}

/// The liquid on one of the bodies when a bridge may form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film {
    /// Volume (m³); infinite for a body that never runs dry, with [`Supply::PerBridge`] only.
    pub volume: f64,
    /// Thickness (m).
    pub thickness: f64,
    /// Number of bridges that this body begins in this step, this one among them.
    pub beginning: u32,
}

/// What a bridge keeps from one step to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BridgeState {
    /// Volume of its liquid (m³); 0 without a bridge.
    pub volume: f64,
}

/// Thickness (m) of a volume (m³) spread evenly on a sphere of this radius (m): ∛(R³ + 3V/4π) − R.
#[inline]
pub fn film_thickness(volume: f64, radius: f64) -> f64 {
    let cubes = volume * (3.0 / (4.0 * PI));
    let outer = cube_root(radius * radius * radius + cubes);
    cubes / (outer * outer + (outer + radius) * radius)
}

impl Supply {
    /// Volume (m³) that a body gives to each of the bridges that it begins in one step.
    ///
    /// What all of them take is never more than the film, in whatever order they begin.
    #[inline]
    pub fn offer(&self, film: &Film) -> f64 {
        let part = 1.0 / f64::from(film.beginning.max(1));
        match *self {
            Self::PerBridge(volume) => (0.5 * volume).min(part * film.volume),
            Self::ShareOfFilms(share) => share.min(part) * film.volume,
        }
    }
}

impl LiquidBridge {
    /// Whether a bridge forms at this gap (m), given the films' thicknesses (m).
    #[inline(always)]
    pub fn forms(&self, gap: f64, thicknesses: [f64; 2]) -> bool {
        match self.formation {
            Formation::Contact => gap <= 0.0,
            Formation::Films => gap <= thicknesses[0] + thicknesses[1],
        }
    }

    /// Lets a bridge form or rupture, and returns what both films gain (m³).
    ///
    /// A bridge that forms takes the offers of both bodies; one that ruptures returns half to each. The gains and the change
    /// of the bridge's volume add up to zero but for rounding.
    #[inline]
    pub fn exchange(
        &self,
        state: &mut BridgeState,
        gap: f64,
        effective_radius: f64,
        films: &[Film; 2],
    ) -> [f64; 2] {
        let volume = state.volume;
        if volume > 0.0 {
            if gap <= self.rupture_distance(volume, effective_radius) {
                return [0.0; 2];
            }
            state.volume = 0.0;
            return [0.5 * volume; 2];
        }
        let [first, second] = films.map(|film| self.supply.offer(&film));
        let offered = first + second;
        // Films that touch farther apart than their liquid can reach make no bridge.
        let holds = offered > 0.0 && gap <= self.rupture_distance(offered, effective_radius);
        if !holds || !self.forms(gap, films.map(|film| film.thickness)) {
            return [0.0; 2];
        }
        state.volume = offered;
        [-first, -second]
    }
}
