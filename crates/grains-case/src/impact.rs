//! The speed at which bodies of a case can meet: the default of `time.impact_speed`.

use crate::diagnostic::rounded;
use crate::sections::domain::Domain;
use crate::sections::insert::Insert;
use crate::sections::motion::{Motion, ParticleMotion};
use crate::sections::wall::Wall;
use crate::vector::{cross, dot, norm, sub, unit};

/// Impact speed where nothing moves, and in a fluid, whose drag limits falls (m/s).
const USUAL: f64 = 1.0;

/// Slower than this (m/s) nothing moves: what is left of a height by rounding.
const SLOWEST: f64 = 1e-9;

/// The fastest impact (m/s) of particles that fall freely from where they are inserted, or are hit by a wall:
/// the largest of √(v² + 2 g h) and |v_wall|, with the height h (m) of the insertion above the lowest point of the domain.
///
/// In a fluid falls end at the terminal velocity, which is not known here: only the velocities given count then.
pub(crate) fn fastest_impact(
    (domain, gravity): (&Domain, [f64; 3]),
    inserts: &[Insert],
    walls: &[Wall],
    is_in_fluid: bool,
) -> f64 {
    let is_free = |insert: &&Insert| !insert.motion.as_ref().is_some_and(ParticleMotion::is_prescribed);
    let falls = inserts.iter().filter(is_free).map(|insert| {
        let energy = if is_in_fluid { 0.0 } else { 2.0 * height(domain, gravity, insert) };
        (dot(insert.velocity, insert.velocity) + energy).sqrt()
    });
    let of_particles = inserts.iter().filter_map(|insert| match &insert.motion {
        Some(ParticleMotion::Prescribed(motion)) => Some(motion),
        _ => None,
    });
    let motions = walls.iter().filter_map(|wall| wall.motion.as_ref()).chain(of_particles);
    let moved = motions.map(|motion| speed(motion, domain));
    let fastest = falls.chain(moved).filter(|speed| speed.is_finite()).fold(0.0, f64::max);
    let is_still = fastest < SLOWEST;
    rounded(if is_still || is_in_fluid { fastest.max(USUAL) } else { fastest })
}

/// Potential energy per mass (m²/s²), g h, of an insertion at its highest.
fn height(domain: &Domain, gravity: [f64; 3], insert: &Insert) -> f64 {
    let [lower, upper] = insert.place.extents().unwrap_or([domain.lower, domain.upper]);
    // Along each axis a fall goes from the end of the region against gravity to that of the domain along it.
    let along = |a: usize| match gravity[a] {
        g if g < 0.0 => -g * (upper[a] - domain.lower[a]),
        g => g * (domain.upper[a] - lower[a]),
    };
    (0..3).map(|a| along(a).max(0.0)).sum()
}

/// Largest speed (m/s) of a wall or a particle inside the domain; one that turns about its own centre goes nowhere.
fn speed(motion: &Motion, domain: &Domain) -> f64 {
    let arm = motion.axis().and_then(|(point, axis)| {
        let (axis, point) = (unit(axis).unwrap_or_default(), point?);
        let arms = domain.corners().map(|corner| norm(cross(axis, sub(corner, point))));
        Some(arms.into_iter().fold(0.0, f64::max))
    });
    motion.speed(arm.unwrap_or(0.0)).0
}
