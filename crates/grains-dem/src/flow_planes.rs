//! Planes through which particles are counted.

use crate::particles::Particles;
use grains_domain::GlobalBox;
use grains_geometry::Vec3;

/// A plane through which particles are counted.
#[derive(Clone, Debug, PartialEq)]
pub struct FlowPlane {
    /// Name in the case.
    pub name: String,
    /// A point of the plane (m).
    pub point: Vec3,
    /// Normal: the counted direction.
    pub normal: Vec3,
}

impl FlowPlane {
    /// Signed distance (m) from the plane, along a periodic axis from its nearest image.
    ///
    /// The sides meet a second time half a period away, where nothing is counted.
    fn distance(&self, position: &Vec3, global: &GlobalBox) -> f64 {
        let distance = (position - self.point).dot(&self.normal);
        match self.period(global) {
            Some(length) => distance - length * (distance / length).round(),
            None => distance,
        }
    }

    /// Period (m) along the normal, which must lie along an axis for this.
    fn period(&self, global: &GlobalBox) -> Option<f64> {
        let axis = self.normal.iamax();
        (global.periodic[axis] && self.normal[axis].abs() > 1.0 - 1e-12).then(|| global.length(axis))
    }

    /// Whether a change of sides here is a crossing of the plane.
    fn is_at(&self, position: &Vec3, global: &GlobalBox) -> bool {
        self.period(global).is_none_or(|length| self.distance(position, global).abs() < 0.25 * length)
    }
}

/// Bits telling on which side of each plane a position lies.
pub(crate) fn sides(planes: &[FlowPlane], position: &Vec3, global: &GlobalBox) -> u32 {
    let is_beyond = |plane: &FlowPlane| plane.distance(position, global) >= 0.0;
    planes.iter().enumerate().fold(0, |bits, (k, plane)| bits | u32::from(is_beyond(plane)) << k)
}

/// Net number and mass of particles that crossed a plane along its normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Crossings {
    /// Number (-).
    pub count: i64,
    /// Mass, in the quanta of [`Dem::mass_quantum`](crate::Dem::mass_quantum): so its sums are exact, and the same on any ranks.
    pub quanta: i128,
}

impl Crossings {
    /// Mass (kg), of this quantum (kg).
    pub fn mass(&self, quantum: f64) -> f64 {
        self.quanta as f64 * quantum
    }
}

/// Counts what crossed the planes since the last count.
pub(crate) fn count_crossings(
    particles: &mut Particles,
    planes: &[FlowPlane],
    (global, mass_quantum): (&GlobalBox, f64),
    crossings: &mut [Crossings],
) {
    if planes.is_empty() {
        return;
    }
    for i in 0..particles.owned {
        let position = particles.bodies[i].position;
        let now = sides(planes, &position, global);
        let changed = now ^ particles.sides[i];
        if changed == 0 {
            continue;
        }
        let crossed = |k: usize| changed >> k & 1 == 1 && planes[k].is_at(&position, global);
        for (k, crossing) in crossings.iter_mut().enumerate().filter(|(k, _)| crossed(*k)) {
            let step = if now >> k & 1 == 1 { 1 } else { -1 };
            crossing.count += step;
            let mass = (particles.bodies[i].mass / mass_quantum) as i128;
            // A checkpoint may hold any number.
            crossing.quanta = crossing.quanta.saturating_add(i128::from(step).saturating_mul(mass));
        }
        particles.sides[i] = now;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Crossings of a plane across x seen along a way, wrapped or not, in a box of 1 m periodic along x.
    fn counted(plane_x: f64, way: &[f64]) -> i64 {
        let global = GlobalBox::new([0.0; 3], [1.0; 3], [true, false, false]);
        let (point, normal) = (Vec3::new(plane_x, 0.5, 0.5), Vec3::x());
        let planes = [FlowPlane { name: "plane".into(), point, normal }];
        let side = |x: f64| sides(&planes, &Vec3::new(x, 0.5, 0.5), &global);
        way.windows(2)
            .filter(|w| side(w[0]) != side(w[1]) && planes[0].is_at(&Vec3::new(w[1], 0.5, 0.5), &global))
            .map(|w| if side(w[1]) == 1 { 1 } else { -1 })
            .sum()
    }

    #[test]
    fn a_plane_in_a_periodic_box_is_crossed_once_per_round() {
        let round: Vec<f64> = (0..=20).map(|k| (0.03 + 0.05 * f64::from(k)) % 1.0).collect();
        let back: Vec<f64> = round.iter().rev().copied().collect();
        // In the middle, at the periodic face, and just beyond it.
        for plane_x in [0.5, 0.0, 0.0005] {
            assert_eq!((counted(plane_x, &round), counted(plane_x, &back)), (1, -1), "plane at {plane_x}");
        }
    }

    #[test]
    fn a_crossing_counts_the_same_before_and_after_the_particle_is_wrapped() {
        for plane_x in [0.0, 0.0005] {
            assert_eq!(counted(plane_x, &[0.99, 1.002]), 1);
            assert_eq!(counted(plane_x, &[0.99, 0.002]), 1);
            assert_eq!(counted(plane_x, &[0.99, 1.002, 0.002]), 1);
            assert_eq!(counted(plane_x, &[1.002, 0.99]), -1);
        }
    }
}
