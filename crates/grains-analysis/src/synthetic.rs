//! States of known answers for the tests of the analyses.

use super::snapshots::Snapshot;
use grains_case::Case;
use grains_geometry::{Rotation, Shape, Vec3};
use std::path::Path;

/// A case with a domain and more text, such as walls; gravity acts along −z.
pub fn case(lower: [f64; 3], upper: [f64; 3], periodic: [bool; 3], more: &str) -> Case {
    let text = format!(
        r#"
[domain]
lower = {lower:?}
upper = {upper:?}
periodic = {periodic:?}
[time]
end = 1.0
[[material]]
name = "glass"
density = 2500
[[contact]]
between = ["glass", "glass"]
normal_stiffness = 1e5
restitution = 0.7
friction = 0.5
[[shape]]
name = "ball"
kind = "sphere"
radius = 0.01
[[insert]]
name = "balls"
particles = [{{ shape = "ball", material = "glass" }}]
count = 1
place = {{ kind = "window", window = {{ kind = "box", lower = {lower:?}, upper = {upper:?} }} }}
{more}
"#
    );
    Case::parse(&text, "synthetic.toml", Path::new("")).unwrap()
}

/// Particles at rest, all of shape 0 and scale 1, not turned.
pub fn particles(positions: Vec<Vec3>) -> Snapshot {
    let n = positions.len();
    Snapshot {
        time: 0.0,
        id: (0..n as u64).collect(),
        shape: vec![0; n],
        position: positions,
        orientation: vec![Rotation::identity(); n],
        scale: vec![1.0; n],
        material: vec![0; n],
        velocity: vec![Vec3::zeros(); n],
        angular_velocity: vec![Vec3::zeros(); n],
        coordination: vec![0; n],
        wall_contacts: vec![0; n],
    }
}

/// Points of a simple cubic lattice, half a spacing from the lower corner.
pub fn lattice(lower: Vec3, number: [usize; 3], spacing: f64) -> Vec<Vec3> {
    let site = |k: usize| {
        Vec3::new(
            (k % number[0]) as f64,
            (k / number[0] % number[1]) as f64,
            (k / (number[0] * number[1])) as f64,
        )
    };
    (0..number.iter().product()).map(|k| lower + (site(k) + Vec3::repeat(0.5)) * spacing).collect()
}

/// One shape, a ball.
pub fn ball(radius: f64) -> Vec<Shape> {
    vec![Shape::sphere(radius).unwrap()]
}

/// Rotations all over the place, the same at every call.
pub fn turns(number: usize) -> Vec<Rotation> {
    let angle = |k: usize, by: f64| (k as f64 * by).rem_euclid(1.0) * std::f64::consts::TAU;
    (0..number)
        .map(|k| Rotation::from_euler_angles(angle(k, 0.618), angle(k, 0.414), angle(k, 0.732)))
        .collect()
}
