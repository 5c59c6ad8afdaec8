//! Simple shear of a periodic box: the sliding images of Lees and Edwards, J. Phys. C 5, 1921 (1972).
//!
//! The images across the gradient move along the flow with U = γ H and lie, H the height of the box and L its length along the
//! flow, by the offset S(t) = U t mod L beyond those of a box at rest:
//!
//! ```text
//!  x → x ± (H e_g + S e_f),    v → v ± U e_f
//! ```
//!
//! A particle that leaves through the upper face comes in through the lower one with x − S and v − U, in the very step, so that
//! its state does not depend on when lists are rebuilt. Offsets are multiples of the quantum of positions, velocities along the
//! flow and U multiples of a quantum of their own: separations and relative velocities of two particles are exact from either
//! side of the border.

use crate::particles::{ParticleRecord, Particles};
use grains_domain::{GlobalBox, Quantum};
use grains_geometry::Vec3;

/// Simple shear v_f = γ x_g of a box that is periodic along both axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shear {
    /// Axis of the flow f: 0, 1 or 2.
    pub flow: usize,
    /// Axis of the gradient g.
    pub gradient: usize,
    /// Rate γ (1/s).
    pub rate: f64,
}

/// The images of one box under shear.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlidingImages {
    pub(crate) shear: Shear,
    /// Velocity U (m/s) of the images above.
    pub(crate) speed: f64,
    /// Faces (m) across the gradient.
    faces: [f64; 2],
    /// Length (m) along the flow.
    length: f64,
    positions: Quantum,
    velocities: Quantum,
}

impl SlidingImages {
    /// Images of a box whose particles stay below a speed (m/s).
    pub(crate) fn new(shear: Shear, global: &GlobalBox, fastest: f64) -> Self {
        let speed = shear.rate * global.length(shear.gradient);
        // Velocities are rounded below a quarter of the limit.
        let velocities = Quantum::for_sums_below(8.0 * speed.abs().max(fastest));
        Self {
            shear,
            speed: velocities.snap(speed),
            faces: [global.lower[shear.gradient], global.upper[shear.gradient]],
            length: global.length(shear.flow),
            positions: global.quantum,
            velocities,
        }
    }

    /// The nearest image of a way (m) along the flow: in [−L/2, L/2); exact.
    pub(crate) fn nearest(&self, way: f64) -> f64 {
        way - self.length * (way / self.length + 0.5).floor()
    }

    /// Offset S (m) of the images above at a time (s), in [−L/2, L/2).
    pub(crate) fn offset(&self, time: f64) -> f64 {
        self.nearest(self.positions.snap((self.speed * time) % self.length))
    }

    /// Mean velocity (m/s) at a place (m): at rest in the middle of the box.
    pub(crate) fn mean_flow(&self, position: &Vec3) -> Vec3 {
        let middle = 0.5 * (self.faces[0] + self.faces[1]);
        let mut velocity = Vec3::zeros();
        velocity[self.shear.flow] = self.shear.rate * (position[self.shear.gradient] - middle);
        velocity
    }

    /// Rounds the velocity (m/s) along the flow.
    pub(crate) fn round(&self, velocity: &mut Vec3) {
        velocity[self.shear.flow] = self.velocities.round(velocity[self.shear.flow]);
    }

    /// On which side of the box a position (m) lies: −1 below it, 1 above, 0 inside.
    #[inline(always)]
    pub(crate) fn side(&self, position: &Vec3) -> f64 {
        let x = position[self.shear.gradient];
        f64::from(i8::from(x >= self.faces[1]) - i8::from(x < self.faces[0]))
    }

    /// Brings a particle that crossed a face back into the box, while the images above lie at an offset (m).
    pub(crate) fn wrap(&self, position: &mut Vec3, velocities: [&mut Vec3; 2], offset: f64) {
        let Shear { flow, gradient, .. } = self.shear;
        let side = self.side(position);
        if side != 0.0 {
            position[gradient] -= side * (self.faces[1] - self.faces[0]);
            position[flow] -= side * offset;
            velocities.into_iter().for_each(|velocity| velocity[flow] -= side * self.speed);
        }
    }

    /// The same of a record.
    pub(crate) fn wrap_record(&self, record: &mut ParticleRecord, offset: f64) {
        let ParticleRecord { body, half_velocity, .. } = record;
        self.wrap(&mut body.position, [&mut body.velocity, half_velocity], offset);
    }

    /// Rounds the velocities of owned particles; returns whether one has crossed a face.
    pub(crate) fn follow(&self, particles: &mut Particles) -> bool {
        let mut has_crossed = false;
        for body in &mut particles.bodies[..particles.owned] {
            self.round(&mut body.velocity);
            has_crossed |= self.side(&body.position) != 0.0;
        }
        has_crossed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn images() -> (GlobalBox, SlidingImages) {
        let global = GlobalBox::new([-0.1, 0.0, 0.2], [0.3, 0.1, 0.9], [true; 3]);
        let shear = Shear { flow: 0, gradient: 2, rate: 3.7 };
        let images = SlidingImages::new(shear, &global, 10.0);
        (global, images)
    }

    #[test]
    fn offsets_are_multiples_of_the_quantum_and_go_round_with_the_flow() {
        let (global, images) = images();
        for k in 0..10_000 {
            let time = f64::from(k) * 1.37e-3;
            let offset = images.offset(time);
            assert_eq!(global.quantum.snap(offset), offset);
            assert!((-0.2..0.2).contains(&offset));
            let turns = (images.speed * time - offset) / 0.4;
            assert!((turns - turns.round()).abs() < 1e-9, "{turns} turns at {time} s");
        }
    }

    #[test]
    fn crossing_there_and_back_changes_nothing_and_one_crossing_keeps_the_velocity_to_the_flow() {
        let (_, images) = images();
        let offset = images.offset(0.123);
        for z in [0.95, 0.15] {
            let (start, mut velocity) = (Vec3::new(0.05, 0.02, z), Vec3::new(1.5, 0.3, -0.2));
            images.round(&mut velocity);
            let start = start.map(|x| images.positions.snap(x));
            let (mut position, mut half, mut now) = (start, velocity, velocity);
            images.wrap(&mut position, [&mut now, &mut half], offset);
            assert_eq!(images.side(&position), 0.0);
            let peculiar = [velocity - images.mean_flow(&start), now - images.mean_flow(&position)];
            assert!((peculiar[0] - peculiar[1]).norm() < 1e-12, "{peculiar:?}");
            let mut own = velocity;
            own[images.shear.flow] -= images.side(&start) * images.speed;
            assert_eq!(own, now);
        }
    }
}
