//! Forces of imported laws against those of LIGGGHTS and LAMMPS, as their sources have them, written out here.
//!
//! Springs have been stretched and friction is large, so that every part of a law counts.

#![allow(clippy::unwrap_used)]

mod common;

use common::{Random, folder, imported};
use grains_case::{Case, Contact, Normal, Rolling as CaseRolling, Tangential as CaseTangential};
use grains_contact::{
    Approach, ContactLaw, Elastic, Encounter, Hertz, Linear, Normal as ContactNormal, Rolling,
    RollingContact, Sjkr, Tangential, WoundAngles, effective_modulus, effective_shear_modulus,
};
use grains_geometry::Vec3;
use std::f64::consts::PI;

/// The law of a contact of a case, as the solver makes it.
fn law(case: &Case, contact: &Contact) -> ContactLaw {
    let pair = contact.between.map(|m| &case.materials[m]);
    let constants = pair.map(|m| Elastic {
        youngs_modulus: m.youngs_modulus.unwrap_or(f64::NAN),
        poissons_ratio: m.poissons_ratio.unwrap_or(f64::NAN),
    });
    let modulus = contact.effective_modulus.unwrap_or_else(|| effective_modulus(constants[0], constants[1]));
    let shear = contact
        .effective_shear_modulus
        .unwrap_or_else(|| effective_shear_modulus(constants[0], constants[1]));
    let hertz = Hertz { modulus };
    let normal: ContactNormal = match contact.normal {
        Normal::Linear => Linear { stiffness: contact.normal_stiffness.unwrap() }.into(),
        Normal::Hertz => hertz.into(),
        Normal::Sjkr { energy_density, area } => Sjkr { hertz, energy_density, area }.into(),
        other => panic!("{other:?}"),
    };
    let tangential = match contact.tangential() {
        CaseTangential::Spring { stiffness_ratio, damping_ratio } => {
            Tangential::Spring { stiffness_ratio, damping_ratio }
        }
        CaseTangential::Viscous { gamma_t } => Tangential::Viscous { rate: gamma_t },
        CaseTangential::Mindlin { memory, damping_ratio } => {
            let stiffness_ratio = 4.0 * shear / modulus;
            let damping_ratio = damping_ratio.unwrap_or(stiffness_ratio.sqrt());
            Tangential::Mindlin { stiffness_ratio, damping_ratio, memory }
        }
        other => panic!("{other:?}"),
    };
    let friction = contact.rolling_friction;
    let rolling = match contact.rolling {
        _ if friction == 0.0 => Rolling::None,
        CaseRolling::Spring { stiffness_ratio, damping_ratio } => {
            Rolling::Spring { friction, stiffness_ratio, damping_ratio }
        }
        CaseRolling::Epsd2 {} => Rolling::Tangential { friction },
        CaseRolling::Constant {} => Rolling::Constant { friction },
        CaseRolling::Sds { stiffness, dashpot } => Rolling::Given { friction, stiffness, dashpot },
        other => panic!("{other:?}"),
    };
    ContactLaw::new(normal, contact.restitution, contact.friction, tangential)
        .with_damping(contact.damping)
        .with_rolling(rolling)
}

/// A state of two bodies in contact: overlap (m), speeds of parting and sliding (m/s), tangential displacement (m), and spin (rad/s).
struct State {
    overlap: f64,
    opening: f64,
    sliding: f64,
    displacement: f64,
}

impl State {
    fn random(random: &mut Random, radius: f64) -> Self {
        Self {
            overlap: radius * random.magnitude(1e-5, 1e-2),
            opening: random.between(-1.0, 1.0),
            sliding: random.between(-1.0, 1.0),
            displacement: radius * random.between(1e-6, 1e-4),
        }
    }

    /// Normal force, positive where it pushes, and force along the sliding (N) on body 1.
    fn force(&self, law: &ContactLaw, radius: f64, mass: f64) -> [f64; 2] {
        let dt = 1e-18;
        let velocity = Vec3::new(self.sliding, 0.0, self.opening);
        let encounter = Encounter { normal: Vec3::z(), overlap: self.overlap, velocity, spin: Vec3::zeros() };
        let coefficients = law.prepared().at(mass, &Approach::of(&encounter, radius, dt), &mut 0.0);
        let force = coefficients.force(&encounter, &mut Vec3::new(self.displacement, 0.0, 0.0), dt);
        [-force.z, force.x]
    }
}

/// Two forces are the same but for the twelve digits that a case is written with.
fn assert_same(found: [f64; 2], exact: [f64; 2], what: &str) {
    let scale = exact[0].abs().max(exact[1].abs());
    for (found, exact) in found.into_iter().zip(exact) {
        assert!((found - exact).abs() < 1e-9 * scale, "{what}: {found} N, and {exact} N there");
    }
}

/// Radii and masses of a pair of equal spheres, and of one at a wall: R* and m*.
fn bodies(radius: f64, density: f64) -> [(f64, f64); 2] {
    let mass = density * 4.0 / 3.0 * PI * radius.powi(3);
    [(0.5 * radius, 0.5 * mass), (radius, mass)]
}

/// Too much for the contacts to slide.
const FRICTION: f64 = 1e9;

/// A script of LIGGGHTS of one size of spheres and a wall of type 2, with properties and a style.
fn of_liggghts(radius: f64, density: f64, properties: &str, style: &str) -> String {
    format!(
        "units si\natom_style granular\nboundary f f f\nregion r block 0 1 0 1 0 1\ncreate_box 2 r\ntimestep 1e-6\n{properties}
fix f all property/global coefficientFriction peratomtypepair 2 {FRICTION} {FRICTION} {FRICTION} {FRICTION}
pair_style gran {style}\npair_coeff * *\nfix w all wall/gran {style} primitive type 2 zplane 0\n
fix t all particletemplate/sphere 1 atom_type 1 density constant {density} radius constant {radius}
fix d all particledistribution/discrete 1 1 t 1\nregion i block 0.2 0.8 0.2 0.8 0.2 0.8
fix i all insert/pack seed 1 distributiontemplate d insert_every once particles_in_region 1 region i\nrun 10\n"
    )
}

/// Contacts of the particles with each other and with the wall.
fn contacts(case: &Case) -> [&Contact; 2] {
    let wall = case.walls[0].material;
    [case.contact(0, 0).unwrap(), case.contact(0, wall).unwrap()].map(|i| &case.contacts[i])
}

fn property(name: &str, values: &[f64]) -> String {
    let list: Vec<String> = values.iter().map(f64::to_string).collect();
    let style = if values.len() == 2 { "peratomtype" } else { "peratomtypepair 2" };
    format!("fix {name} all property/global {name} {style} {}\n", list.join(" "))
}

#[test]
fn hertz_and_hooke_of_liggghts_have_the_same_forces() {
    let home = folder("laws_liggghts");
    let mut random = Random(1);
    for round in 0..12 {
        let (radius, density) = (random.magnitude(1e-3, 1e-2), random.between(1e3, 4e3));
        let young = [random.magnitude(1e6, 1e9), random.magnitude(1e6, 1e9)];
        let poisson = [random.between(0.1, 0.4), random.between(0.1, 0.4)];
        let [own, wall] = [random.between(0.1, 0.95), random.between(0.1, 0.95)];
        let speed = random.between(0.5, 4.0);
        let properties = property("youngsModulus", &young)
            + &property("poissonsRatio", &poisson)
            + &property("coefficientRestitution", &[own, wall, wall, own])
            + &format!("fix v all property/global characteristicVelocity scalar {speed}\n");
        let is_hertz = round % 2 == 0;
        let style =
            if is_hertz { "model hertz tangential history" } else { "model hooke tangential history" };
        let (case, _) = imported(&home, &of_liggghts(radius, density, &properties, style));
        let pairs = contacts(&case).into_iter().zip(bodies(radius, density)).zip([(0, own), (1, wall)]);
        for ((contact, (r, m)), (other, e)) in pairs {
            let y = 1.0
                / ((1.0 - poisson[0] * poisson[0]) / young[0]
                    + (1.0 - poisson[other] * poisson[other]) / young[other]);
            let compliance = |k: usize| 2.0 * (2.0 - poisson[k]) * (1.0 + poisson[k]) / young[k];
            let g = 1.0 / (compliance(0) + compliance(other));
            let beta = e.ln() / (e.ln() * e.ln() + PI * PI).sqrt();
            let law = law(&case, contact);
            for _ in 0..20 {
                let state = State::random(&mut random, radius);
                let [kn, kt, gn, gt] = if is_hertz {
                    let root = (r * state.overlap).sqrt();
                    let (sn, st) = (2.0 * y * root, 8.0 * g * root);
                    let damping = |s: f64| -2.0 * (5.0_f64 / 6.0).sqrt() * beta * (s * m).sqrt();
                    [4.0 / 3.0 * y * root, st, damping(sn), damping(st)]
                } else {
                    let kn = 16.0 / 15.0
                        * r.sqrt()
                        * y
                        * (15.0 * m * speed * speed / (16.0 * r.sqrt() * y)).powf(0.2);
                    let damping = (4.0 * m * kn * e.ln() * e.ln() / (e.ln() * e.ln() + PI * PI)).sqrt();
                    [kn, kn, damping, damping]
                };
                let exact =
                    [kn * state.overlap - gn * state.opening, kt * state.displacement + gt * state.sliding];
                assert_same(state.force(&law, r, m), exact, style);
            }
        }
    }
}

#[test]
fn given_stiffnesses_of_liggghts_and_lammps_have_the_same_forces() {
    let home = folder("laws_stiffness");
    let mut random = Random(2);
    for _ in 0..8 {
        let (radius, density) = (random.magnitude(1e-3, 1e-2), random.between(1e3, 4e3));
        let mass = bodies(radius, density)[0].1;
        let kn = random.magnitude(1e3, 1e6);
        let kt = kn * random.between(0.1, 0.9);
        // Below the critical dashpot of both contacts.
        let gn = random.between(0.05, 0.9) * 2.0 * (kn / (2.0 * mass)).sqrt();
        let gt = gn * random.between(0.1, 1.0);
        let four = |x: f64| [x; 4];
        let properties = property("kn", &four(kn))
            + &property("kt", &four(kt))
            + &property("gamman", &four(gn))
            + &property("gammat", &four(gt));
        let liggghts = of_liggghts(radius, density, &properties, "model hooke/stiffness tangential history");
        let lammps = format!(
            "units si\natom_style sphere\nboundary f f f\nregion r block 0 1 0 1 0 1\ncreate_box 1 r\ntimestep 1e-6
fix g all gravity 9.81 vector 0 0 -1\npair_style gran/hooke/history {kn} {kt} {gn} {gt} {FRICTION} 1\npair_coeff * *
fix w all wall/gran hooke/history {kn} {kt} {gn} {gt} {FRICTION} 1 zplane 0 NULL\nregion i block 0.2 0.8 0.2 0.8 0.2 0.8
fix i all pour 1 1 1 region i diam one {} dens {density} {density}\nrun 10\n",
            2.0 * radius
        );
        for script in [liggghts, lammps] {
            let (case, _) = imported(&home, &script);
            for (contact, (r, m)) in contacts(&case).into_iter().zip(bodies(radius, density)) {
                let law = law(&case, contact);
                for _ in 0..20 {
                    let state = State::random(&mut random, radius);
                    let exact = [
                        kn * state.overlap - m * gn * state.opening,
                        kt * state.displacement + m * gt * state.sliding,
                    ];
                    assert_same(state.force(&law, r, m), exact, "stiffness");
                }
            }
        }
    }
}

/// LAMMPS: `gran/hertz/history`, whose normal force is the same; `granular` with the restitution of coeff_restitution and tsuji.
#[test]
fn hertz_of_lammps_has_the_same_forces() {
    let home = folder("laws_lammps");
    let mut random = Random(3);
    for round in 0..9 {
        let (radius, density) = (random.magnitude(1e-3, 1e-2), random.between(1e3, 4e3));
        let (young, poisson): (f64, f64) = (random.magnitude(1e6, 1e9), random.between(0.1, 0.4));
        let (kn, kt) = (random.magnitude(1e6, 1e9), random.magnitude(1e6, 1e9));
        let (gamma, eta, share) =
            (random.magnitude(1e2, 1e5), random.between(0.3, 0.9), random.between(0.1, 1.0));
        let style = match round % 3 {
            0 => format!("hertz/history {kn} {kt} {gamma} {} {FRICTION} 1", share * gamma),
            1 => format!(
                "granular hertz/material {young} {eta} {poisson} tangential mindlin NULL {share} {FRICTION} damping coeff_restitution"
            ),
            _ => format!(
                "granular hertz/material {young} {eta} {poisson} tangential mindlin NULL {share} {FRICTION} damping tsuji"
            ),
        };
        let pair = match style.strip_prefix("granular ") {
            Some(coefficients) => format!("pair_style granular\npair_coeff * * {coefficients}"),
            None => format!("pair_style gran/{style}\npair_coeff * *"),
        };
        let script = format!(
            "units si\natom_style sphere\nboundary f f f\nregion r block 0 1 0 1 0 1\ncreate_box 1 r\ntimestep 1e-6
fix g all gravity 9.81 vector 0 0 -1\n{pair}\nfix w all wall/gran {style} zplane 0 NULL\nregion i block 0.2 0.8 0.2 0.8 0.2 0.8
fix i all pour 1 1 1 region i diam one {} dens {density} {density}\nrun 10\n",
            2.0 * radius
        );
        let (case, _) = imported(&home, &script);
        for (contact, (r, m)) in contacts(&case).into_iter().zip(bodies(radius, density)) {
            let law = law(&case, contact);
            for _ in 0..20 {
                let state = State::random(&mut random, radius);
                let a = (r * state.overlap).sqrt();
                let found = state.force(&law, r, m);
                if round % 3 == 0 {
                    let [elastic, damping] = [kn * state.overlap, m * gamma * state.opening].map(|f| a * f);
                    let error = (found[0] - elastic + damping).abs() / (elastic + damping.abs());
                    assert!(error < 1e-9, "gran/hertz/history: {} N, {error}", found[0]);
                    // The tangential spring is the same; its dashpot is so at one contact radius alone.
                    let still = State { sliding: 0.0, ..state };
                    let exact = a * kt * still.displacement;
                    assert_same([0.0, still.force(&law, r, m)[1]], [0.0, exact], "gran/hertz/history");
                    continue;
                }
                let stiffness = 4.0 / 3.0 * young / (2.0 * (1.0 - poisson * poisson));
                let elastic = stiffness * a * state.overlap;
                let alpha = if round % 3 == 1 {
                    let log = eta.ln();
                    -(1.5_f64).sqrt() * 2.0 * (5.0_f64 / 6.0).sqrt() * log / (PI * PI + log * log).sqrt()
                } else {
                    let powers: [f64; 7] = std::array::from_fn(|k| eta.powi(k as i32));
                    let fit = [1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218];
                    fit.iter().zip(powers).map(|(c, p)| c * p).sum()
                };
                let damping = alpha * (m * elastic / state.overlap).sqrt();
                let kt = 8.0 * young / (4.0 * (2.0 - poisson) * (1.0 + poisson));
                let exact = [
                    elastic - damping * state.opening,
                    kt * a * state.displacement + share * damping * state.sliding,
                ];
                assert_same(found, exact, &style);
            }
        }
    }
}

/// epsd, epsd2 and cdt of LIGGGHTS: the torque of an angle that has been rolled, and of rolling on; and sjkr, to the order of δ/R.
#[test]
fn rolling_and_cohesion_of_liggghts_are_the_same() {
    let home = folder("laws_rolling");
    let mut random = Random(4);
    for model in ["epsd", "epsd2", "cdt"] {
        let (radius, density) = (random.magnitude(1e-3, 1e-2), 2500.0);
        let (young, poisson, e): (f64, f64, f64) = (random.magnitude(1e6, 1e8), 0.3, 0.5);
        let (friction, damping) = (random.between(0.1, 0.3), random.between(0.1, 0.5));
        let cohesion = random.magnitude(1e2, 1e4);
        let four = |x: f64| [x; 4];
        let properties = property("youngsModulus", &[young; 2])
            + &property("poissonsRatio", &[poisson; 2])
            + &property("coefficientRestitution", &four(e))
            + &property("coefficientRollingFriction", &four(friction))
            + &property("coefficientRollingViscousDamping", &four(damping))
            + &property("cohesionEnergyDensity", &four(cohesion));
        let style = format!("model hertz tangential history rolling_friction {model} cohesion sjkr");
        let (case, _) = imported(&home, &of_liggghts(radius, density, &properties, &style));
        let y = young / (2.0 * (1.0 - poisson * poisson));
        let g = young / (4.0 * (2.0 - poisson) * (1.0 + poisson));
        let both = contacts(&case).into_iter().zip(bodies(radius, density)).zip([0.2, 0.4]);
        for ((contact, (r, m)), inertia) in both {
            let law = law(&case, contact);
            let inertia = inertia * bodies(radius, density)[1].1 * radius * radius;
            let (overlap, angle, spin, dt) = (1e-3 * radius, 1e-6, 1e-3, 1e-18);
            let a = (r * overlap).sqrt();
            let (kn, kt) = (4.0 / 3.0 * y * a, 8.0 * g * a);
            let encounter = Encounter {
                normal: Vec3::z(),
                overlap,
                velocity: Vec3::zeros(),
                spin: Vec3::new(spin, 0.0, 0.0),
            };
            let coefficients = law.prepared().at(m, &Approach::of(&encounter, r, dt), &mut 0.0);
            let at = RollingContact { effective_radius: r, inverse_inertia: 1.0 / inertia };
            let mut wound = WoundAngles { rolling: Vec3::new(angle, 0.0, 0.0), twisting: 0.0 };
            let found = -coefficients.couple(&encounter, &at, &mut wound, dt).x;
            let exact = match model {
                "epsd" => {
                    let kr = 2.25 * kn * friction * friction * r * r;
                    // 7/5 m R² at a wall, 7/10 m R² of two equal spheres.
                    kr * angle + 2.0 * damping * (3.5 * inertia * kr).sqrt() * spin
                }
                "epsd2" => kt * r * r * angle,
                _ => friction * kn * overlap * r,
            };
            assert!((found / exact - 1.0).abs() < 1e-9, "{model}: {found} N m, and {exact} N m there");
            // Area of the circle in which two spheres, or a sphere and a plane, intersect.
            let state = State { overlap, opening: 0.0, sliding: 0.0, displacement: 0.0 };
            let is_wall = r == radius;
            let distance = if is_wall { radius - overlap } else { 2.0 * radius - overlap };
            let area = match is_wall {
                true => PI * (radius * radius - distance * distance),
                false => PI * (radius * radius - 0.25 * distance * distance),
            };
            let pull = kn * overlap - state.force(&law, r, m)[0];
            assert!(
                (pull / (cohesion * area) - 1.0).abs() < 1e-3,
                "{pull} N, and {} N there",
                cohesion * area
            );
        }
    }
}
