//! Walls that a given load moves along an axis, against the particles they press on.
//!
//! ```text
//!  m dv/dt = F + n·Σ f − c v,    dx/dt = v
//! ```
//!
//! with the load F along the unit vector n, the forces f of particles on the wall, and a damping c. The leap-frog of particles,
//! v(t + Δt/2) from v(t − Δt/2), takes the damping at their mean: it is of second order, and stable for any c. The sum of the
//! forces is exact, so that all ranks find the same bits.

use grains_geometry::Vec3;

/// A load that moves a wall along an axis during a window of time, while it moves across the axis at constant velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loading {
    /// Unit vector n along which the load pushes the wall.
    pub axis: Vec3,
    /// Load F (N).
    pub force: f64,
    /// Mass m of the wall (kg); its weight is part of the load.
    pub mass: f64,
    /// Damping c (kg/s).
    pub damping: f64,
    /// Largest speed along the axis (m/s), or infinity.
    pub max_speed: f64,
    /// Velocity across the axis (m/s).
    pub velocity: Vec3,
    /// Begin (s).
    pub start: f64,
    /// End (s), after which the wall rests.
    pub end: f64,
}

/// What a load has made of a wall along its axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Travel {
    /// Way since the load took the wall (m).
    pub way: f64,
    /// Speed half a step before the present (m/s).
    pub half_speed: f64,
    /// Speed at the present (m/s).
    pub speed: f64,
}

impl Loading {
    /// Whether the load moves the wall at a time (s).
    pub(crate) fn acts_at(&self, time: f64) -> bool {
        time >= self.start && time < self.end
    }

    /// The wall after a step of `dt` (s) in which particles push it by `contact` (N) along the axis.
    pub(crate) fn advance(&self, travel: &Travel, contact: f64, dt: f64) -> Travel {
        let Self { force, mass, damping, max_speed, .. } = *self;
        let within = |speed: f64| speed.clamp(-max_speed, max_speed);
        let half_damping = 0.5 * damping * dt / mass;
        let kick = (force + contact) / mass * dt;
        let half_speed = within((travel.half_speed * (1.0 - half_damping) + kick) / (1.0 + half_damping));
        let speed = within(half_speed + 0.5 * (half_speed - travel.half_speed));
        Travel { way: travel.way + half_speed * dt, half_speed, speed }
    }
}

impl Travel {
    /// The same for a time step that is `ratio` times that before.
    pub fn with_other_step(self, ratio: f64) -> Self {
        Self { half_speed: self.speed - (self.speed - self.half_speed) * ratio, ..self }
    }

    /// The speeds along another axis, at `cosine` to that before, from where the wall is.
    pub fn along(self, cosine: f64) -> Self {
        Self { way: 0.0, half_speed: cosine * self.half_speed, speed: cosine * self.speed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loading(damping: f64, max_speed: f64) -> Loading {
        Loading {
            axis: Vec3::z(),
            force: 2.0,
            mass: 0.5,
            damping,
            max_speed,
            velocity: Vec3::zeros(),
            start: 0.0,
            end: f64::INFINITY,
        }
    }

    /// Way and speed at t = 1 s on a spring k x, by steps of `dt` (s) from rest.
    fn on_a_spring(damping: f64, stiffness: f64, dt: f64) -> Travel {
        let loading = loading(damping, f64::INFINITY);
        let acceleration = loading.force / loading.mass;
        let mut travel = Travel { half_speed: -0.5 * acceleration * dt, ..Travel::default() };
        for _ in 0..(1.0 / dt).round() as u64 {
            travel = loading.advance(&travel, -stiffness * travel.way, dt);
        }
        travel
    }

    #[test]
    fn a_loaded_wall_on_a_spring_is_the_damped_oscillator_to_second_order() {
        let (damping, stiffness) = (0.8, 30.0);
        let Loading { force, mass, .. } = loading(damping, 1.0);
        let (rate, rest) = (0.5 * damping / mass, force / stiffness);
        let frequency = (stiffness / mass - rate * rate).sqrt();
        let exact = rest * (1.0 - (-rate).exp() * (frequency.cos() + rate / frequency * frequency.sin()));
        let error = |dt: f64| (on_a_spring(damping, stiffness, dt).way - exact).abs();
        let order = (error(1e-2) / error(5e-3)).log2();
        assert!((order - 2.0).abs() < 0.1, "order {order}");
        assert!(error(1e-4) < 1e-8, "{}", error(1e-4));
    }

    #[test]
    fn any_damping_is_stable_and_ends_at_the_terminal_speed() {
        let strong = loading(1e6, f64::INFINITY);
        let mut travel = Travel::default();
        for _ in 0..1_000_000 {
            travel = strong.advance(&travel, 0.0, 1e-3);
            assert!(travel.half_speed.abs() <= 2.0 * strong.force / strong.damping);
        }
        assert!((travel.half_speed * strong.damping / strong.force - 1.0).abs() < 1e-3, "{travel:?}");
    }

    #[test]
    fn the_speed_keeps_to_its_limit() {
        let slow = loading(0.0, 0.01);
        let mut travel = Travel::default();
        for _ in 0..100 {
            travel = slow.advance(&travel, 0.0, 1e-2);
            assert!(travel.half_speed <= 0.01 && travel.speed <= 0.01);
        }
        assert!((travel.way - 0.01).abs() < 1e-4, "{travel:?}");
    }
}
