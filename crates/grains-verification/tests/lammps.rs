//! Forces of pairs of spheres against those of LAMMPS, in `cases/laws/lammps_forces.csv` (`cases/laws/lammps_forces.py`).
//!
//! Both are given the same relative velocity at the contact point: LAMMPS takes whole radii for the arms, the solver the distances
//! to the contact point. Tangential springs are not stretched yet, as a run of no steps leaves them.

#![allow(clippy::unwrap_used)]

use grains_contact::{
    Approach, ContactLaw, Dmt, Elastic, Encounter, Hertz, Jkr, Memory, Rolling, RollingContact, Tangential,
    Tear, Twisting, WoundAngles, effective_modulus, effective_shear_modulus,
};
use grains_geometry::Vec3;
use std::f64::consts::PI;

const MATERIAL: Elastic = Elastic { youngs_modulus: 1e8, poissons_ratio: 0.3 };
const WORK: f64 = 2.0 * 0.05;

/// A sphere of the table.
struct Sphere {
    position: Vec3,
    velocity: Vec3,
    spin: Vec3,
    radius: f64,
    force: Vec3,
    torque: Vec3,
}

impl Sphere {
    fn read(fields: &[&str]) -> Self {
        let number = |k: usize| fields[k].parse::<f64>().unwrap();
        let vector = |k: usize| Vec3::new(number(k), number(k + 1), number(k + 2));
        Self {
            position: vector(2),
            velocity: vector(5),
            spin: vector(8),
            radius: number(11),
            force: vector(12),
            torque: vector(15),
        }
    }

    fn mass(&self) -> f64 {
        2500.0 * 4.0 / 3.0 * PI * self.radius.powi(3)
    }
}

/// The restitution of our Hertzian dashpot that is LAMMPS' of `tsuji` for 0.6: c = α √(m F/δ) with the published polynomial.
fn restitution_of_tsuji() -> f64 {
    let e: f64 = 0.6;
    let fit = [1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218];
    let alpha = fit.iter().rev().fold(0.0, |sum, c| sum * e + c);
    let ratio = alpha / 5.0_f64.sqrt();
    (-PI * ratio / (1.0 - ratio * ratio).sqrt()).exp()
}

fn law(name: &str, mass: f64) -> ContactLaw {
    let modulus = effective_modulus(MATERIAL, MATERIAL);
    let stiffness_ratio = 4.0 * effective_shear_modulus(MATERIAL, MATERIAL) / modulus;
    let mindlin = Tangential::Mindlin { stiffness_ratio, damping_ratio: 0.7, memory: Memory::Displacement };
    let none = Tangential::Viscous { rate: 0.0 };
    match name {
        // 2 γ m = 0.2 N s/m for all masses.
        "hooke" => {
            let ratio = 0.2 / (2.0 * (1e4 * mass).sqrt());
            let restitution = (-PI * ratio / (1.0 - ratio * ratio).sqrt()).exp();
            ContactLaw::linear(1e4, restitution, 1e6, Tangential::Viscous { rate: 0.5 * 0.7 * 0.2 / mass })
        }
        "hertz" => ContactLaw::new(Hertz { modulus }, restitution_of_tsuji(), 1e6, mindlin),
        "hertz_couples" => ContactLaw::new(Hertz { modulus }, restitution_of_tsuji(), 1e6, mindlin)
            .with_rolling(Rolling::Given { friction: 1e6, stiffness: 200.0, dashpot: 0.03 })
            .with_twisting(Twisting::Marshall),
        "dmt" => ContactLaw::new(Dmt { hertz: Hertz { modulus }, work: WORK }, 1.0, 0.0, none),
        "jkr" => ContactLaw::new(Jkr { modulus, work: WORK, tear: Tear::Load }, 1.0, 0.0, none),
        other => panic!("no law {other}"),
    }
}

#[test]
fn forces_of_pairs_are_those_of_lammps() {
    let table = include_str!("../../../cases/laws/lammps_forces.csv");
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let mut worst: std::collections::BTreeMap<&str, [f64; 2]> = Default::default();
    for pair in rows.chunks_exact(2) {
        let [a, b] = [0, 1].map(|k| Sphere::read(&pair[k]));
        let between = b.position - a.position;
        let normal = between.normalize();
        let spins = a.spin * a.radius + b.spin * b.radius;
        let encounter = Encounter {
            normal,
            overlap: a.radius + b.radius - between.norm(),
            velocity: (b.velocity - a.velocity) - spins.cross(&normal),
            spin: a.spin - b.spin,
        };
        let (mass, dt) = (a.mass() * b.mass() / (a.mass() + b.mass()), 1e-15);
        let radius = a.radius * b.radius / (a.radius + b.radius);
        let approach = Approach::of(&encounter, radius, dt);
        let law = law(pair[0][0], mass).prepared().at(mass, &approach, &mut 0.0);
        let force = law.force(&encounter, &mut Vec3::zeros(), dt);
        let rolling = RollingContact { effective_radius: radius, inverse_inertia: 1.0 };
        let couple = law.couple(&encounter, &rolling, &mut WoundAngles::default(), dt);
        // Torques are those of the force at the contact point, and the couple.
        let [arm, other_arm] = [&a, &b].map(|sphere| sphere.radius - 0.5 * encounter.overlap);
        let of_couple = (a.torque * other_arm - b.torque * arm) / (arm + other_arm);
        let worst = worst.entry(pair[0][0]).or_default();
        worst[0] = worst[0].max((force - a.force).norm() / a.force.norm());
        let scale = a.force.norm() * radius;
        worst[1] = worst[1].max((couple - of_couple).norm() / scale);
    }
    println!("largest differences of force and couple: {worst:?}");
    assert!(worst.len() == 5);
    assert!(worst.values().flatten().all(|difference| *difference < 1e-10), "{worst:?}");
}
