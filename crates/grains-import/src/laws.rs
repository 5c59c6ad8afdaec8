//! Contact laws of pairs, and the contacts of a case that have the same forces.

use crate::report::Report;
use grains_case::{Attraction, Contact, Normal, Rolling, Tangential};
use grains_contact::{CohesionArea, ContactLaw, Damping, Hertz, Memory, Tear, Twisting};
use std::f64::consts::PI;

/// A law as other codes have it.
#[derive(Clone, Debug, PartialEq)]
pub struct PairLaw {
    /// Elastic force.
    pub elastic: Elastic,
    /// Dashpot of the normal direction.
    pub dashpot: Dashpot,
    /// Resistance to sliding.
    pub sliding: Sliding,
    /// Coefficient of friction (-).
    pub friction: f64,
    /// Resistance to rolling, and its coefficient (-).
    pub rolling: (RollingModel, f64),
    /// Whether contacts resist twisting as Marshall has it.
    pub twists: bool,
    /// Adhesion.
    pub adhesion: Adhesion,
}

/// An elastic force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Elastic {
    /// k δ
    Linear {
        /// k (N/m).
        stiffness: f64,
    },
    /// (4/3) E* a δ, a² = R* δ
    Hertz {
        /// E* (Pa).
        modulus: f64,
        /// Whether E* and G* follow from the constants of the materials, which the case has.
        of_materials: bool,
    },
}

/// A dashpot: a force over the rate v of the overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dashpot {
    /// So that bodies part with this restitution (-).
    Restitution(f64),
    /// m* γ v (1/s)
    PerMass(f64),
    /// η v (N s/m)
    Constant(f64),
    /// m* γ a v (1/(m s)), a the contact radius
    PerMassAndRadius(f64),
}

/// A force against sliding below friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sliding {
    /// A spring and a dashpot.
    Spring {
        /// k_t (N/m) of a linear contact; k_t/a (Pa) of a Hertzian one.
        stiffness: f64,
        /// Dashpot over that of the normal direction (-); none gives both the same share of the critical.
        damping_ratio: Option<f64>,
        /// What is kept while the contact radius changes.
        memory: Memory,
    },
    /// A dashpot alone, over that of the normal direction (-).
    Viscous {
        /// That ratio (-).
        damping_ratio: f64,
    },
}

/// A torque against rolling, at most μ_r R* F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RollingModel {
    /// None.
    Off,
    /// The whole torque against any rolling (cdt).
    Constant,
    /// A spring 2.25 k_n μ_r² R*² and a share of the critical damping of 7/5 m R² (epsd).
    Epsd {
        /// That share (-).
        damping: f64,
    },
    /// A spring k_t R*² (epsd2).
    Epsd2,
    /// Spring and dashpot in the displacement rolled (sds).
    Sds {
        /// k (N/m).
        stiffness: f64,
        /// γ (N s/m).
        dashpot: f64,
    },
}

/// A pull while bodies touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Adhesion {
    /// None.
    Off,
    /// An energy density (J/m³) times an area of contact.
    Sjkr(f64, CohesionArea),
    /// Derjaguin, Muller and Toporov, with the work of adhesion (J/m²).
    Dmt(f64),
    /// Johnson, Kendall and Roberts, with the work of adhesion (J/m²).
    Jkr(f64),
}

/// A sphere, or a body taken for one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Radius (m).
    pub radius: f64,
    /// Mass (kg).
    pub mass: f64,
}

/// What the forces of two bodies depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bodies {
    /// R* (m): R against a wall.
    pub radius: f64,
    /// m* (kg): m against a wall.
    pub mass: f64,
    /// 1/(1/I1 + 1/I2) (kg m²): I against a wall.
    pub inertia: f64,
}

impl Bodies {
    /// A particle at a wall.
    pub fn at_wall(body: Body) -> Self {
        Self { radius: body.radius, mass: body.mass, inertia: 0.4 * body.mass * body.radius.powi(2) }
    }

    /// Two particles.
    pub fn pair(a: Body, b: Body) -> Self {
        let reduced = |a: f64, b: f64| a * b / (a + b);
        let [one, other] = [a, b].map(Self::at_wall);
        Self {
            radius: reduced(one.radius, other.radius),
            mass: reduced(one.mass, other.mass),
            inertia: reduced(one.inertia, other.inertia),
        }
    }
}

/// Restitution of a linear contact of a damping ratio ζ (-): exp(−π ζ/√(1 − ζ²)).
pub fn restitution(ratio: f64) -> Option<f64> {
    (ratio < 1.0).then(|| (-PI * ratio / (1.0 - ratio * ratio).sqrt()).exp())
}

/// Restitution that stands for none: it is as critically damped as a step can resolve.
const STICKS: f64 = 0.01;

/// Impact speed (m/s) at which laws whose restitution depends on it are compared.
pub const IMPACT: f64 = 1.0;

/// Rounds a number for people to five digits.
pub fn shown(number: f64) -> String {
    let rounded: f64 = format!("{number:.4e}").parse().unwrap_or(number);
    match rounded.abs() {
        0.0 | 1e-3..1e6 => rounded.to_string(),
        _ => format!("{rounded:e}"),
    }
}

/// The contact of a case between two materials that has the forces of `law` for `bodies`; `report` gets what differs.
pub fn contact(law: &PairLaw, between: [String; 2], bodies: &Bodies, report: &mut Report) -> Contact<String> {
    let pair = format!("{} on {}", between[0], between[1]);
    let mut contact = Contact {
        between,
        normal: Normal::Linear,
        normal_stiffness: None,
        effective_modulus: None,
        effective_shear_modulus: None,
        softening: 1.0,
        work_of_adhesion: None,
        restitution: 1.0,
        damping: Damping::Restitution,
        friction: law.friction,
        tangential: None,
        rolling_friction: 0.0,
        rolling: Rolling::default(),
        twisting: if law.twists { Twisting::Marshall } else { Twisting::None },
        attraction: Attraction::None,
    };
    match law.elastic {
        Elastic::Linear { stiffness } => linear(&mut contact, law, stiffness, bodies, &pair, report),
        Elastic::Hertz { modulus, of_materials } => {
            if !of_materials {
                contact.effective_modulus = Some(modulus);
            }
            hertz(&mut contact, law, modulus, bodies, &pair, report);
            if let (Sliding::Spring { stiffness, .. }, false) = (law.sliding, of_materials) {
                contact.effective_shear_modulus = Some(stiffness / 8.0);
            }
        }
    }
    rolling(&mut contact, law, bodies, &pair, report);
    contact
}

fn linear(
    contact: &mut Contact<String>,
    law: &PairLaw,
    stiffness: f64,
    bodies: &Bodies,
    pair: &str,
    report: &mut Report,
) {
    contact.normal_stiffness = Some(stiffness);
    let root = (bodies.mass * stiffness).sqrt();
    let ratio = match law.dashpot {
        Dashpot::Restitution(e) => {
            contact.restitution = e;
            let log = e.ln();
            -log / log.hypot(PI)
        }
        Dashpot::PerMass(rate) => 0.5 * rate * bodies.mass / root,
        Dashpot::Constant(dashpot) => 0.5 * dashpot / root,
        Dashpot::PerMassAndRadius(rate) => {
            // Of a typical contact radius: that at the overlap of an impact at IMPACT.
            let overlap = IMPACT * (bodies.mass / stiffness).sqrt();
            0.5 * rate * bodies.mass * (bodies.radius * overlap).sqrt() / root
        }
    };
    if !matches!(law.dashpot, Dashpot::Restitution(_)) {
        contact.restitution = restitution(ratio).unwrap_or(STICKS).max(STICKS);
        let m = shown(bodies.mass);
        match restitution(ratio).is_some_and(|e| e >= STICKS) {
            true => report.remark(format!(
                "{pair}: the dashpot is given there, the restitution here: {} for a reduced mass of {m} kg, and the same for all masses",
                shown(contact.restitution)
            )),
            false => report.remark(format!(
                "{pair}: the dashpot is {} times the critical one for a reduced mass of {m} kg, so that bodies hardly part; here the restitution is {STICKS}",
                shown(ratio)
            )),
        }
    }
    if let Dashpot::PerMassAndRadius(_) = law.dashpot {
        report.remark(format!(
            "{pair}: a dashpot that grows with the contact radius goes with no linear spring here; taken is that of an impact at {IMPACT} m/s"
        ));
    }
    contact.tangential = Some(match law.sliding {
        Sliding::Spring { stiffness: tangential, damping_ratio, .. } if tangential > 0.0 => {
            Tangential::Spring {
                stiffness_ratio: tangential / stiffness,
                damping_ratio: damping_ratio.unwrap_or((tangential / stiffness).sqrt()),
            }
        }
        Sliding::Spring { damping_ratio, .. } => viscous(damping_ratio.unwrap_or(0.0), ratio * root, bodies),
        Sliding::Viscous { damping_ratio } => viscous(damping_ratio, ratio * root, bodies),
    });
    if !matches!(law.adhesion, Adhesion::Off) {
        report.remark(format!(
            "{pair}: adhesion goes with Hertzian laws here and was left out of a linear spring"
        ));
    }
}

/// −2 γ_t m v with 2 γ_t m the share `ratio` of 2 × `half`.
fn viscous(ratio: f64, half: f64, bodies: &Bodies) -> Tangential {
    Tangential::Viscous { gamma_t: ratio * half / bodies.mass }
}

fn hertz(
    contact: &mut Contact<String>,
    law: &PairLaw,
    modulus: f64,
    bodies: &Bodies,
    pair: &str,
    report: &mut Report,
) {
    contact.normal = match law.adhesion {
        Adhesion::Off => Normal::Hertz,
        Adhesion::Sjkr(energy_density, area) => Normal::Sjkr { energy_density, area },
        Adhesion::Dmt(_) => Normal::Dmt,
        Adhesion::Jkr(_) => Normal::Jkr { tear: Tear::Load },
    };
    if let Adhesion::Dmt(work) | Adhesion::Jkr(work) = law.adhesion {
        contact.work_of_adhesion = Some(work);
    }
    // Tangential dashpot over normal dashpot as the case counts it, at a typical contact.
    let scale = match law.dashpot {
        Dashpot::Restitution(e) => {
            contact.restitution = e;
            1.0
        }
        Dashpot::PerMassAndRadius(rate) => {
            let time = rate * bodies.mass / (2.0 * modulus);
            contact.damping = Damping::Viscoelastic { time };
            let of_rate = |radius: f64| rate * bodies.mass * radius;
            let scale = of_speed(contact, modulus, bodies, of_rate);
            report.remark(format!(
                "{pair}: the dashpot m* γ a v is A dF/dδ v here with A = γ m*/(2 E*), for a reduced mass of {} kg; the restitution of {} at {IMPACT} m/s sets tangential dashpots alone",
                shown(bodies.mass),
                shown(contact.restitution)
            ));
            scale
        }
        Dashpot::PerMass(_) | Dashpot::Constant(_) => {
            let dashpot = match law.dashpot {
                Dashpot::PerMass(rate) => rate * bodies.mass,
                Dashpot::Constant(dashpot) => dashpot,
                _ => 0.0,
            };
            let scale = of_speed(contact, modulus, bodies, |_| dashpot);
            report.remark(format!(
                "{pair}: a dashpot that does not grow with the contact goes with no Hertzian law here; taken is one of the restitution {}, which has the same force where an impact at {IMPACT} m/s is deepest, for a reduced mass of {} kg",
                shown(contact.restitution),
                shown(bodies.mass)
            ));
            scale
        }
    };
    contact.tangential = Some(match law.sliding {
        Sliding::Spring { stiffness, damping_ratio, memory } if stiffness > 0.0 => {
            Tangential::Mindlin { memory, damping_ratio: damping_ratio.map(|ratio| ratio * scale) }
        }
        Sliding::Spring { damping_ratio, .. } => memoryless(
            damping_ratio.unwrap_or(0.0) * scale,
            contact.restitution,
            modulus,
            bodies,
            pair,
            report,
        ),
        Sliding::Viscous { damping_ratio } => {
            memoryless(damping_ratio * scale, contact.restitution, modulus, bodies, pair, report)
        }
    });
}

/// The damping ratio ζ (-) of a restitution.
fn damping_ratio(restitution: f64) -> f64 {
    let log = restitution.ln();
    -log / log.hypot(PI)
}

/// Contact radius (m) where an impact at [`IMPACT`] is deepest without losses.
fn deepest_radius(modulus: f64, bodies: &Bodies) -> f64 {
    let depth = (15.0 * bodies.mass * IMPACT * IMPACT / (16.0 * modulus * bodies.radius.sqrt())).powf(0.4);
    (bodies.radius * depth).sqrt()
}

/// Dashpot (N s/m) of a case for a restitution at a contact radius (m): 2 √(5/6) ζ √(m dF/dδ).
fn dashpot_of(restitution: f64, radius: f64, modulus: f64, bodies: &Bodies) -> f64 {
    2.0 * (5.0_f64 / 6.0).sqrt() * damping_ratio(restitution) * (bodies.mass * 2.0 * modulus * radius).sqrt()
}

/// Gives the contact a restitution that has the same dashpot as `dashpot` (N s/m, of a contact radius in m) where an impact is
/// deepest, or for viscoelastic bodies that of the impact; returns by what the ratio of tangential to normal dashpots changes.
fn of_speed(
    contact: &mut Contact<String>,
    modulus: f64,
    bodies: &Bodies,
    dashpot: impl Fn(f64) -> f64,
) -> f64 {
    let radius = deepest_radius(modulus, bodies);
    let wanted = dashpot(radius);
    if let Damping::Viscoelastic { .. } = contact.damping {
        let none = grains_contact::Tangential::Viscous { rate: 0.0 };
        let law = ContactLaw::new(Hertz { modulus }, 1.0, 0.0, none).with_damping(contact.damping);
        let found = law.collision(bodies.mass, bodies.radius, IMPACT).restitution;
        contact.restitution = found.clamp(STICKS, 1.0);
    } else {
        let full = 2.0 * (5.0_f64 / 6.0).sqrt() * (bodies.mass * 2.0 * modulus * radius).sqrt();
        contact.restitution = restitution(wanted / full).unwrap_or(STICKS).max(STICKS);
    }
    let own = dashpot_of(contact.restitution, radius, modulus, bodies);
    if own > 0.0 { wanted / own } else { 1.0 }
}

/// A dashpot without a spring: that of an impact, as it has one rate here.
fn memoryless(
    ratio: f64,
    restitution: f64,
    modulus: f64,
    bodies: &Bodies,
    pair: &str,
    report: &mut Report,
) -> Tangential {
    if ratio > 0.0 {
        report.remark(format!(
            "{pair}: a tangential dashpot without a spring has one rate here, that of an impact at {IMPACT} m/s where it is deepest"
        ));
    }
    let radius = deepest_radius(modulus, bodies);
    viscous(ratio, 0.5 * dashpot_of(restitution, radius, modulus, bodies), bodies)
}

fn rolling(contact: &mut Contact<String>, law: &PairLaw, bodies: &Bodies, pair: &str, report: &mut Report) {
    let (model, friction) = law.rolling;
    if friction == 0.0 || matches!(model, RollingModel::Off) {
        return;
    }
    contact.rolling_friction = friction;
    contact.rolling = match model {
        RollingModel::Off => return,
        RollingModel::Constant => Rolling::Constant {},
        RollingModel::Epsd2 => Rolling::Epsd2 {},
        RollingModel::Sds { stiffness, dashpot } => Rolling::Sds { stiffness, dashpot },
        RollingModel::Epsd { damping } => {
            // k_n there is F/δ, of which dF/dδ is 3/2 for Hertz; the frequency ratio here is (k_r/I)/(k_n/m).
            let secant = if contact.normal_stiffness.is_some() { 1.0 } else { 2.0 / 3.0 };
            let spring = 2.25 * friction * friction * secant * bodies.radius.powi(2);
            let stiffness_ratio = spring * bodies.mass / bodies.inertia;
            let damping_ratio = damping * 3.5_f64.sqrt();
            report.remark(format!(
                "{pair}: epsd has k_r = 2.25 k_n μ_r² R*²; here stiffness_ratio is (k_r/I)/(k_n/m) = {}, exact for spheres of one size; its damping is a share of that of 7/5 m R², √3.5 of that of 2/5 m R² here",
                shown(stiffness_ratio)
            ));
            if stiffness_ratio > 1.0 || damping_ratio > 1.0 {
                report.remark(format!(
                    "{pair}: stiffness_ratio and damping_ratio of rolling are at most 1 here, not {} and {}",
                    shown(stiffness_ratio),
                    shown(damping_ratio)
                ));
            }
            Rolling::Spring {
                stiffness_ratio: stiffness_ratio.min(1.0),
                damping_ratio: damping_ratio.min(1.0),
            }
        }
    };
}
