//! Random places in a window, tried until a particle fits.

use super::draws::purpose;
use crate::random::Draw;
use grains_case::Window;
use grains_dem::{Dem, NewParticle, Occupancy, wall_in_the_way};
use grains_domain::Transport;
use grains_geometry::Vec3;
use std::f64::consts::TAU;

/// Attempts between two agreements of the ranks.
const ATTEMPTS_AT_A_TIME: u64 = 64;

/// Tries places in a window until the particle fits between particles and walls, on all ranks alike; collective.
pub fn place_in_window(
    mut new: NewParticle,
    window: &Window,
    attempts: u64,
    seed: u64,
    occupancy: &Occupancy,
    dem: &Dem,
    transport: &impl Transport,
) -> Option<NewParticle> {
    // A later batch must not repeat the attempts that found no room before.
    let round = dem.step.wrapping_mul(attempts);
    let mut blocked = Vec::new();
    for first in (0..attempts).step_by(ATTEMPTS_AT_A_TIME as usize) {
        let last = attempts.min(first + ATTEMPTS_AT_A_TIME);
        blocked.clear();
        blocked.extend((first..last).map(|attempt| {
            new.position = attempted_position(&new, window, seed, round + attempt, dem);
            let is_blocked = !dem.setup.global.contains(new.position.into())
                || occupancy.in_the_way(&new, dem, 0.0).is_some()
                || wall_in_the_way(&new, dem, 0.0).is_some();
            f64::from(u8::from(is_blocked))
        }));
        transport.max(&mut blocked);
        if let Some(free) = blocked.iter().position(|&b| b == 0.0) {
            new.position = attempted_position(&new, window, seed, round + first + free as u64, dem);
            return Some(new);
        }
    }
    None
}

/// Position of a particle at an attempt, wrapped and on the lattice.
fn attempted_position(new: &NewParticle, window: &Window, seed: u64, attempt: u64, dem: &Dem) -> Vec3 {
    let mut draw = Draw::new(seed, new.id, purpose::ATTEMPT + attempt);
    let wrapped = dem.setup.global.wrap(point_in(window, &mut draw).into());
    Vec3::from(wrapped.map(|x| dem.setup.global.quantum.snap(x)))
}

/// Corners of the box around a window (m).
pub fn bounds(window: &Window) -> (Vec3, Vec3) {
    match window {
        Window::Box { lower, upper } => (Vec3::from(*lower), Vec3::from(*upper)),
        Window::Disc { center, normal, radius } => {
            let reach = Vec3::from(normal.map(|n| radius * (1.0 - n * n).max(0.0).sqrt()));
            (Vec3::from(*center) - reach, Vec3::from(*center) + reach)
        }
        Window::Point { at } => (Vec3::from(*at), Vec3::from(*at)),
    }
}

fn point_in(window: &Window, draw: &mut Draw) -> Vec3 {
    match window {
        Window::Box { lower, upper } => Vec3::from_fn(|a, _| lower[a] + (upper[a] - lower[a]) * draw.next()),
        Window::Disc { center, normal, radius } => {
            let normal = Vec3::from(*normal);
            let helper = if normal.x.abs() < 0.6 { Vec3::x() } else { Vec3::y() };
            let (u, angle) = (draw.next().sqrt() * radius, TAU * draw.next());
            let first = normal.cross(&helper).normalize();
            Vec3::from(*center) + (first * libm::cos(angle) + normal.cross(&first) * libm::sin(angle)) * u
        }
        Window::Point { at } => Vec3::from(*at),
    }
}
