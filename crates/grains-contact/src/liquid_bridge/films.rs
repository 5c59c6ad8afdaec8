//! Films of liquid on bodies.

use crate::cube_root::cube_root;
use std::f64::consts::PI;

/// How much liquid is on a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FilmAmount {
    /// This volume (m³) on every body.
    Volume(f64),
    /// A film of this thickness (m) on the sphere of the body's volume.
    Thickness(f64),
    /// This share (-) of the body's volume.
    Content(f64),
}

impl FilmAmount {
    /// Volume (m³) on a body of this volume (m³).
    pub fn volume(&self, body: f64) -> f64 {
        match *self {
            Self::Volume(volume) => volume,
            Self::Thickness(thickness) => {
                let radius = sphere_radius(body);
                4.0 * PI * thickness * (radius * radius + thickness * (radius + thickness / 3.0))
            }
            Self::Content(share) => share * body,
        }
    }
}

/// Radius (m) of a sphere of this volume (m³).
pub fn sphere_radius(volume: f64) -> f64 {
    cube_root(volume * (3.0 / (4.0 * PI)))
}

/// Thickness (m) of a volume (m³) spread evenly on a sphere of this radius (m): ∛(R³ + 3V/4π) − R.
#[inline]
pub fn film_thickness(volume: f64, radius: f64) -> f64 {
    let cubes = volume * (3.0 / (4.0 * PI));
    let outer = cube_root(radius * radius * radius + cubes);
    cubes / (outer * outer + (outer + radius) * radius)
}

/// Liquid on a body at the beginning of a step (m³).
///
/// Bridges that form in a step claim their shares of what is free at its beginning. They take them at the beginning of the next
/// step, all by the same factor if the claims are more than there is. So it does not matter in which order they form.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Film {
    /// Volume, with what was claimed in the last step.
    pub volume: f64,
    /// Sum of these claims.
    pub claimed: f64,
    /// What was free when they were made.
    pub offered: f64,
}

impl Film {
    /// Volume (m³) that no bridge has claimed.
    #[inline]
    pub fn free(&self) -> f64 {
        self.volume - self.claimed.min(self.volume)
    }

    /// Share (-) of the claims that can be met.
    #[inline]
    pub(super) fn granted(&self) -> f64 {
        if self.claimed <= self.volume { 1.0 } else { self.volume / self.claimed }
    }
}
