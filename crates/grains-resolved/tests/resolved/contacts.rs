//! Contacts of bodies, as fast as a step of the fluid and faster.

use crate::common::{MULTIPLIERS, QUADRATIC, Scene, body};
use grains_domain::SerialTransport;
use grains_fluid::{FlowSetup, Grid};
use grains_geometry::{Shape, Vec3};
use grains_resolved::Forcing;
use nalgebra::Rotation3;

/// Step of the fluid (s).
const DT: f64 = 0.01;
/// Damping of the springs, as that of a contact with a restitution of 0.85 (-).
const DAMPING: f64 = 0.05;

/// A displacement, or an angle, on a spring: mass or inertia, position, velocity, and force or torque of the flow.
struct Spring {
    inertia: f64,
    rate: f64,
    at: f64,
    velocity: f64,
    flow: f64,
}

impl Spring {
    fn energy(&self) -> f64 {
        self.inertia * (self.velocity.powi(2) + (self.rate * self.at).powi(2))
    }

    /// Goes through a step of the fluid as particles do; returns the impulse of the spring.
    fn advance(&mut self) -> f64 {
        let steps = 40.max((20.0 * self.rate * DT) as usize);
        let h = DT / steps as f64;
        let mut impulse = 0.0;
        for _ in 0..steps {
            let acceleration = -self.rate.powi(2) * self.at - 2.0 * DAMPING * self.rate * self.velocity;
            impulse += self.inertia * acceleration * h;
            self.velocity += (acceleration + self.flow / self.inertia) * h;
            self.at += self.velocity * h;
        }
        impulse
    }

    /// Takes over the velocity after the fluid's step.
    fn correct(&mut self, velocity: f64) {
        self.flow += self.inertia * (velocity - self.velocity) / DT;
        self.velocity = velocity;
    }
}

/// Largest energies of displacement and rotation in steps 40 to 60, over the first ones, of a body of a density over that of the fluid
/// on springs whose phase goes on by `angle` (rad) in a step of the fluid.
fn energies_left((shape, center): (&Shape, Vec3), density: f64, angle: f64, forcing: Forcing) -> [f64; 2] {
    let grid = Grid::uniform([0.0; 3], [1.0; 3], [16; 3], [false; 3]).unwrap();
    let setup = FlowSetup::new(grid, 1.0, 1e-3);
    let mut scene = Scene::new(&setup, [1; 3], (shape, &[body(1, center)]), forcing, &SerialTransport);
    let (mass, inertia) = (density * shape.volume, density * shape.inertia.z);
    // Less than a third of a cell per step.
    let spring = |inertia: f64, at: f64| Spring {
        inertia,
        rate: angle / DT,
        at: at / angle.max(1.0),
        velocity: 0.0,
        flow: 0.0,
    };
    let [mut along, mut about] = [spring(mass, 0.005), spring(inertia, 0.02)];
    let first = [along.energy(), about.energy()];
    let mut last = [0.0_f64; 2];
    for step in 0..60 {
        scene.contacts = vec![[along.advance(), 0.0, 0.0, 0.0, 0.0, about.advance()]];
        scene.own[0].center = center + Vec3::new(along.at, 0.0, 0.0);
        scene.own[0].rotation = *Rotation3::from_axis_angle(&Vec3::z_axis(), about.at).matrix();
        scene.follow((mass, inertia, density), Vec3::zeros(), DT, &SerialTransport);
        along.correct(scene.own[0].velocity.x);
        about.correct(scene.own[0].spin.z);
        if step >= 40 {
            let now = [along.energy() / first[0], about.energy() / first[1]];
            (0..2).for_each(|k| last[k] = last[k].max(now[k]));
        }
    }
    last
}

/// The fluid is nearly without friction. Beside a wall it adds more mass to the body; that of a turning sphere none.
#[test]
fn bodies_on_springs_of_any_stiffness_come_to_rest_in_any_step_of_the_fluid() {
    let shapes = [
        (Shape::sphere(0.25).unwrap(), Vec3::new(0.47, 0.52, 0.51)),
        (Shape::cuboid([0.4; 3].into(), 0.02).unwrap(), Vec3::new(0.53, 0.48, 0.5)),
        (Shape::cuboid([0.3, 0.4, 0.4].into(), 0.02).unwrap(), Vec3::new(0.26, 0.49, 0.51)),
    ];
    let mut restless = Vec::new();
    for (shape, center) in &shapes {
        for forcing in [QUADRATIC, MULTIPLIERS] {
            for density in [0.03, 0.3, 0.6, 1.0, 1.5, 8.0] {
                for angle in [0.1, 0.37, 1.1, 1.9, 2.7, 6.0, 31.0] {
                    let left = energies_left((shape, *center), density, angle, forcing);
                    if !left.iter().all(|&left| left < 0.9) {
                        restless
                            .push(format!("{} {density} {angle}: {left:?} {:?}", shape.name, forcing.method));
                    }
                }
            }
        }
    }
    assert!(restless.is_empty(), "{restless:#?}");
}
