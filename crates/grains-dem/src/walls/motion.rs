//! Prescribed motions, as functions of time alone so that a restart cannot change them; what a load adds is state of the system.

use super::loading::{Loading, Travel};
use super::table::MotionTable;
use grains_geometry::{Mat3, Rotation, Vec3, rotation_about};
use std::f64::consts::TAU;
use std::sync::Arc;

/// How a wall moves.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// Not at all.
    Fixed,
    /// At constant velocity during a window of time.
    Translation {
        /// Velocity (m/s).
        velocity: Vec3,
        /// Begin (s).
        start: f64,
        /// End (s).
        end: f64,
    },
    /// x = A sin(2π f τ + φ) − A sin φ, τ the time since the start, during a window of time.
    Oscillation {
        /// Amplitude A (m).
        amplitude: Vec3,
        /// Frequency f (Hz).
        frequency: f64,
        /// Phase φ (rad).
        phase: f64,
        /// Begin (s).
        start: f64,
        /// End (s).
        end: f64,
    },
    /// About an axis at constant rate during a window of time.
    Rotation {
        /// Point on the axis (m).
        point: Vec3,
        /// Unit vector of the axis.
        axis: Vec3,
        /// Rate (rad/s).
        rate: f64,
        /// Begin (s).
        start: f64,
        /// End (s).
        end: f64,
    },
    /// By displacements and angles given at times.
    Table(Arc<MotionTable>),
    /// By a load along an axis, and at constant velocity across it: the first is state, which [`Motion::at`] leaves out.
    Loaded(Loading),
}

/// Pose and velocity of a wall: a point p of its frame is at `rotation` p + `translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallState {
    /// Rotation from the wall's frame to the world.
    pub rotation: Mat3,
    /// Translation (m).
    pub translation: Vec3,
    /// Velocity of the point at `pivot` (m/s).
    pub velocity: Vec3,
    /// Angular velocity (rad/s).
    pub angular_velocity: Vec3,
    /// Point about which `angular_velocity` turns (m).
    pub pivot: Vec3,
    /// Whether the pose differs from that at time zero.
    pub is_displaced: bool,
}

/// Where a wall's frame lies before its motion moves it: a point p of the frame is at `rotation` p + `translation`.
///
/// A wall whose motion changes at a restart stays where it is and goes on from there: its place is M⁻¹ P, of the pose P it has
/// and the one M that the new motion alone would give it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallPlace {
    /// Rotation.
    pub rotation: Mat3,
    /// Translation (m).
    pub translation: Vec3,
}

impl WallPlace {
    /// The place that gives a wall the pose `now` where its motion alone would give it `alone`; none if they are the same.
    pub fn between(alone: &WallState, now: &WallPlace) -> Option<Self> {
        let place = Self {
            rotation: alone.rotation.tr_mul(&now.rotation),
            translation: alone.rotation.tr_mul(&(now.translation - alone.translation)),
        };
        let is_same = alone.rotation == now.rotation && alone.translation == now.translation;
        (!is_same).then_some(place)
    }

    /// Its numbers, the columns of the rotation first.
    pub fn numbers(&self) -> [f64; 12] {
        let mut numbers = [0.0; 12];
        let values = self.rotation.iter().chain(self.translation.iter());
        numbers.iter_mut().zip(values).for_each(|(to, from)| *to = *from);
        numbers
    }

    /// The place of the numbers.
    pub fn from_numbers(numbers: &[f64; 12]) -> Self {
        let (rotation, translation) = numbers.split_at(9);
        Self {
            rotation: Mat3::from_column_slice(rotation),
            translation: Vec3::from_column_slice(translation),
        }
    }
}

impl WallState {
    /// Its pose.
    pub fn pose(&self) -> WallPlace {
        WallPlace { rotation: self.rotation, translation: self.translation }
    }

    /// The state of a wall whose frame lies elsewhere before this motion.
    pub fn of_place(self, place: &WallPlace) -> Self {
        Self {
            rotation: self.rotation * place.rotation,
            translation: self.rotation * place.translation + self.translation,
            is_displaced: true,
            ..self
        }
    }

    /// The state of a wall that a load has moved besides.
    pub fn travelled(self, loading: &Loading, travel: &Travel) -> Self {
        Self {
            translation: self.translation + loading.axis * travel.way,
            velocity: self.velocity + loading.axis * travel.speed,
            ..self
        }
    }

    /// The pose at time zero, at rest.
    pub fn at_rest() -> Self {
        Self {
            rotation: Mat3::identity(),
            translation: Vec3::zeros(),
            velocity: Vec3::zeros(),
            angular_velocity: Vec3::zeros(),
            pivot: Vec3::zeros(),
            is_displaced: false,
        }
    }

    /// Velocity of the wall at a point of space (m/s).
    #[inline(always)]
    pub fn velocity_at(&self, point: &Vec3) -> Vec3 {
        self.velocity + self.angular_velocity.cross(&(point - self.pivot))
    }

    /// A point of space (m) in the wall's frame.
    #[inline(always)]
    pub fn to_wall(&self, point: &Vec3) -> Vec3 {
        if self.is_displaced { self.rotation.tr_mul(&(point - self.translation)) } else { *point }
    }

    /// A direction of the wall's frame in the world.
    #[inline(always)]
    pub fn to_world(&self, direction: &Vec3) -> Vec3 {
        if self.is_displaced { self.rotation * direction } else { *direction }
    }
}

impl Motion {
    /// State at a time (s).
    pub fn at(&self, time: f64) -> WallState {
        let rest = WallState::at_rest();
        match *self {
            Motion::Fixed => rest,
            Motion::Translation { velocity, start, end }
            | Motion::Loaded(Loading { velocity, start, end, .. }) => WallState {
                translation: velocity * (time.min(end) - start).max(0.0),
                velocity: if time >= start && time < end { velocity } else { Vec3::zeros() },
                is_displaced: true,
                ..rest
            },
            Motion::Oscillation { amplitude, frequency, phase, start, end } => {
                let angle = TAU * frequency * (time.min(end) - start).max(0.0) + phase;
                let speed =
                    if time >= start && time < end { TAU * frequency * libm::cos(angle) } else { 0.0 };
                WallState {
                    translation: amplitude * (libm::sin(angle) - libm::sin(phase)),
                    velocity: amplitude * speed,
                    is_displaced: true,
                    ..rest
                }
            }
            Motion::Rotation { point, axis, rate, start, end } => {
                let angle = rate * (time.min(end) - start).max(0.0);
                let rotation = rotation_about(&axis.normalize(), angle).to_rotation_matrix().into_inner();
                let turning = time >= start && time < end;
                WallState {
                    rotation,
                    translation: point - rotation * point,
                    angular_velocity: if turning { axis.normalize() * rate } else { Vec3::zeros() },
                    pivot: point,
                    is_displaced: true,
                    ..rest
                }
            }
            Motion::Table(ref table) => {
                let [(displacement, angle), (velocity, rate)] = table.at(time);
                let rotation =
                    rotation_about(&table.axis.normalize(), angle).to_rotation_matrix().into_inner();
                WallState {
                    rotation,
                    translation: table.point + displacement - rotation * table.point,
                    velocity,
                    angular_velocity: table.axis.normalize() * rate,
                    pivot: table.point + displacement,
                    is_displaced: true,
                }
            }
        }
    }

    /// Turn since time zero, at a time (s).
    pub fn turned_at(&self, time: f64) -> Rotation {
        match *self {
            Motion::Rotation { axis, rate, start, end, .. } => {
                let angle = rate * (time.min(end) - start).max(0.0);
                rotation_about(&axis.normalize(), angle)
            }
            Motion::Table(ref table) => {
                let [(_, angle), _] = table.at(time);
                rotation_about(&table.axis.normalize(), angle)
            }
            Motion::Fixed | Motion::Translation { .. } | Motion::Oscillation { .. } | Motion::Loaded(_) => {
                Rotation::identity()
            }
        }
    }

    /// The load that moves it, if one does.
    pub fn loading(&self) -> Option<&Loading> {
        if let Motion::Loaded(loading) = self { Some(loading) } else { None }
    }

    /// Bound on the speed (m/s) of the wall's points within `reach` (m) of the origin, while it moves; that by a load left out.
    pub fn max_speed(&self, reach: f64) -> f64 {
        match *self {
            Motion::Fixed => 0.0,
            Motion::Translation { velocity, .. } | Motion::Loaded(Loading { velocity, .. }) => {
                velocity.norm()
            }
            Motion::Oscillation { amplitude, frequency, .. } => amplitude.norm() * TAU * frequency,
            Motion::Rotation { point, rate, .. } => rate.abs() * (reach + point.norm()),
            Motion::Table(ref table) => {
                let [speed, turning, displacement] = table.bounds();
                speed + turning * (reach + table.point.norm() + displacement)
            }
        }
    }

    /// Time (s) from `now` on at which the wall moves next: `now` if it is moving, infinity if never again.
    pub fn moves_next(&self, now: f64) -> f64 {
        let [start, end] = self.interval();
        if now < end { now.max(start) } else { f64::INFINITY }
    }

    /// Time (s) at which the wall begins to move, and the one at which it ends; both in the past if it never does.
    fn interval(&self) -> [f64; 2] {
        match *self {
            Motion::Fixed => [f64::NEG_INFINITY; 2],
            Motion::Translation { start, end, .. }
            | Motion::Oscillation { start, end, .. }
            | Motion::Rotation { start, end, .. }
            | Motion::Loaded(Loading { start, end, .. }) => [start, end],
            Motion::Table(ref table) => table.interval(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_goes_on_from_where_it_is_when_its_motion_changes() {
        let drum = |rate: f64| Motion::Rotation {
            point: Vec3::new(0.3, 0.1, -0.2),
            axis: Vec3::new(0.0, 0.6, 0.8),
            rate,
            start: 0.0,
            end: f64::INFINITY,
        };
        let lift = Motion::Translation { velocity: Vec3::new(1.0, -2.0, 0.5), start: 0.0, end: 1.5 };
        let p = Vec3::new(0.7, -0.4, 0.9);
        let (mut place, mut time): (Option<WallPlace>, f64) = (None, 0.0);
        let motions = [drum(1.0), drum(2.5), lift, drum(-1.0), Motion::Fixed, drum(0.5)];
        let state = |motion: &Motion, place: &Option<WallPlace>, t: f64| match place {
            Some(place) => motion.at(t).of_place(place),
            None => motion.at(t),
        };
        for pair in motions.windows(2) {
            time += 0.4;
            let before = state(&pair[0], &place, time);
            place = WallPlace::between(&pair[1].at(time), &before.pose());
            let after = state(&pair[1], &place, time);
            let at = |s: &WallState| s.rotation * p + s.translation;
            assert!((at(&before) - at(&after)).norm() < 1e-14);
            // What it does from then on is the new motion.
            let h = 1e-6;
            let slope = (at(&state(&pair[1], &place, time + h)) - at(&after)) / h;
            assert!((after.velocity_at(&at(&after)) - slope).norm() < 1e-5, "{pair:?}");
            let numbers = after.pose().numbers();
            assert_eq!(WallPlace::from_numbers(&numbers), after.pose());
        }
        assert_eq!(WallPlace::between(&drum(2.0).at(0.7), &drum(2.0).at(0.7).pose()), None);
    }

    #[test]
    fn velocities_are_the_derivatives_of_the_poses() {
        let motions = [
            Motion::Translation { velocity: Vec3::new(1.0, -2.0, 0.5), start: 0.1, end: 2.0 },
            Motion::Oscillation {
                amplitude: Vec3::new(0.1, 0.0, 0.2),
                frequency: 3.0,
                phase: 0.4,
                start: 0.1,
                end: 9.0,
            },
            Motion::Rotation {
                point: Vec3::new(0.3, 0.1, -0.2),
                axis: Vec3::new(0.0, 0.6, 0.8),
                rate: 2.5,
                start: 0.2,
                end: 5.0,
            },
            Motion::Table(Arc::new(MotionTable::new(
                &[
                    (0.1, Vec3::zeros(), 0.0),
                    (0.8, Vec3::new(0.1, -0.2, 0.0), 0.7),
                    (1.7, Vec3::new(0.3, -0.2, 0.5), 0.2),
                ],
                Vec3::new(0.3, 0.1, -0.2),
                Vec3::new(0.0, 0.6, 0.8),
            ))),
        ];
        let (p, h) = (Vec3::new(0.7, -0.4, 0.9), 1e-6);
        for motion in motions {
            let place = |t: f64| motion.at(t).rotation * p + motion.at(t).translation;
            let slope = (place(1.0 + h) - place(1.0 - h)) / (2.0 * h);
            let state = motion.at(1.0);
            assert!((state.velocity_at(&place(1.0)) - slope).norm() < 1e-7 * (1.0 + slope.norm()));
            assert!((state.to_wall(&place(1.0)) - p).norm() < 1e-14);
            assert!(slope.norm() <= motion.max_speed(2.0) + 1e-9);
        }
    }
}
