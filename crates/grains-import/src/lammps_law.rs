//! Contact laws of LAMMPS: `gran/hooke`, `gran/hooke/history`, `gran/hertz/history` and `granular`.

use crate::laws::{Adhesion, Dashpot, Elastic, PairLaw, RollingModel, Sliding};
use crate::units::{DASHPOT, Dimension, PRESSURE, RATE, RATE_PER_LENGTH, STIFFNESS, Units};
use grains_contact::{Elastic as Constants, Memory, effective_modulus, effective_shear_modulus};

/// Words that are read one after the other as numbers.
struct Words<'a, 'n> {
    rest: &'a [String],
    number: &'n dyn Fn(&str) -> Result<f64, String>,
}

impl<'a> Words<'a, '_> {
    fn word(&mut self) -> Option<&'a str> {
        let (first, rest) = self.rest.split_first()?;
        self.rest = rest;
        Some(first)
    }

    fn number(&mut self, what: &str) -> Result<f64, String> {
        let value = self.optional(what)?;
        value.ok_or_else(|| format!("{what} is NULL"))
    }

    /// A number, or none for NULL.
    fn optional(&mut self, what: &str) -> Result<Option<f64>, String> {
        let number = self.number;
        let word = self.word().ok_or_else(|| format!("{what} is missing"))?;
        if word == "NULL" { Ok(None) } else { number(word).map(Some) }
    }
}

/// The law of `gran/hooke`, `gran/hooke/history` or `gran/hertz/history` (with or without `gran/`) and the words that it leaves.
///
/// # Errors
/// Other styles, and numbers that are missing.
pub fn gran<'a>(
    style: &str,
    words: &'a [String],
    units: &Units,
    number: &dyn Fn(&str) -> Result<f64, String>,
) -> Result<(PairLaw, &'a [String]), String> {
    let style = style.trim_start_matches("gran/").trim_end_matches("/omp").trim_end_matches("/kk");
    let has_history = match style {
        "hooke" => false,
        "hooke/history" | "hertz/history" => true,
        other => return Err(format!("style gran/{other} has no counterpart")),
    };
    let is_hertz = style == "hertz/history";
    let mut words = Words { rest: words, number };
    let normal = words.number("K_n")?;
    let tangential = words.optional("K_t")?.unwrap_or(2.0 / 7.0 * normal);
    let along = words.number("gamma_n")?;
    let across = words.optional("gamma_t")?.unwrap_or(0.5 * along);
    let friction = words.number("xmu")?;
    let damps = words.number("dampflag")? != 0.0;
    if words.rest.first().is_some_and(|word| word == "limit_damping") {
        words.word();
    }
    let damping_ratio = if damps && along > 0.0 { across / along } else { 0.0 };
    let (elastic, dashpot, stiffness) = if is_hertz {
        (
            Elastic::Hertz { modulus: 0.75 * units.si(normal, PRESSURE), of_materials: false },
            Dashpot::PerMassAndRadius(units.si(along, RATE_PER_LENGTH)),
            units.si(tangential, PRESSURE),
        )
    } else {
        (
            Elastic::Linear { stiffness: units.si(normal, STIFFNESS) },
            Dashpot::PerMass(units.si(along, RATE)),
            units.si(tangential, STIFFNESS),
        )
    };
    let sliding = match has_history {
        true => {
            Sliding::Spring { stiffness, damping_ratio: Some(damping_ratio), memory: Memory::Displacement }
        }
        false => Sliding::Viscous { damping_ratio },
    };
    let law = PairLaw {
        elastic,
        dashpot,
        sliding,
        friction,
        rolling: (RollingModel::Off, 0.0),
        twists: false,
        adhesion: Adhesion::Off,
    };
    Ok((law, words.rest))
}

/// Words at which the models of `granular` end.
const ENDS: [&str; 8] =
    ["xplane", "yplane", "zplane", "xcylinder", "ycylinder", "zcylinder", "region", "cutoff"];

/// Dashpots of `granular`.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Damping {
    Velocity,
    MassVelocity,
    Viscoelastic,
    Tsuji,
    Restitution,
}

/// The law of `granular`: its normal, tangential, rolling, twisting and damping models, the words that it leaves, and what of it a
/// case does not have.
///
/// # Errors
/// Normal models without a counterpart, and numbers that are missing.
pub fn granular<'a>(
    words: &'a [String],
    units: &Units,
    number: &dyn Fn(&str) -> Result<f64, String>,
) -> Result<(PairLaw, &'a [String], Vec<String>), String> {
    let mut words = Words { rest: words, number };
    let normal = words.word().ok_or("the normal model is missing")?.to_owned();
    let mut without = Vec::new();
    let mut adhesion = Adhesion::Off;
    let mut constants = None;
    let (elastic, eta) = match normal.as_str() {
        "hooke" => {
            let stiffness = units.si(words.number("k_n")?, STIFFNESS);
            (Elastic::Linear { stiffness }, words.number("eta_n0")?)
        }
        "hertz" => {
            let modulus = 0.75 * units.si(words.number("k_n")?, PRESSURE);
            (Elastic::Hertz { modulus, of_materials: false }, words.number("eta_n0")?)
        }
        "hertz/material" | "dmt" | "jkr" => {
            let youngs_modulus = units.si(words.number("E")?, PRESSURE);
            let eta = words.number("eta_n0")?;
            let material = Constants { youngs_modulus, poissons_ratio: words.number("nu")? };
            if normal != "hertz/material" {
                let work = 2.0 * units.si(words.number("gamma")?, STIFFNESS);
                adhesion = match normal.as_str() {
                    _ if work == 0.0 => Adhesion::Off,
                    "dmt" => Adhesion::Dmt(work),
                    _ => Adhesion::Jkr(work),
                };
            }
            constants = Some(material);
            let modulus = effective_modulus(material, material);
            (Elastic::Hertz { modulus, of_materials: false }, eta)
        }
        other => {
            return Err(format!(
                "normal model {other} has no counterpart; hooke, hertz, hertz/material, dmt and jkr do"
            ));
        }
    };
    let is_linear = matches!(elastic, Elastic::Linear { .. });
    let stiffness: Dimension = if is_linear { STIFFNESS } else { PRESSURE };
    let mut sliding = Sliding::Viscous { damping_ratio: 0.0 };
    let (mut friction, mut rolling, mut twists) = (0.0, (RollingModel::Off, 0.0), false);
    let mut damping = Damping::Viscoelastic;
    while let Some(key) = words.rest.first().map(String::as_str).filter(|word| !ENDS.contains(word)) {
        words.word();
        let model = words.word().unwrap_or_default().to_owned();
        match (key, model.as_str()) {
            ("tangential", "linear_nohistory") => {
                sliding = Sliding::Viscous { damping_ratio: words.number("x_gammat")? };
                friction = words.number("mu_s")?;
            }
            ("tangential", "linear_history") => {
                let mut given = units.si(words.number("k_t")?, STIFFNESS);
                if let Elastic::Hertz { .. } = elastic {
                    without.push("a tangential spring that does not grow with the contact: taken is one of Mindlin, of G* = E*/4".to_owned());
                    given = of_mindlin(elastic);
                }
                sliding = spring(given, words.number("x_gammat")?, Memory::Displacement);
                friction = words.number("mu_s")?;
            }
            ("tangential", name) if name.starts_with("mindlin") => {
                let memory = match name {
                    "mindlin" => Memory::Displacement,
                    "mindlin_rescale" => Memory::DisplacementRescaled,
                    "mindlin/force" => Memory::Force,
                    "mindlin_rescale/force" => Memory::ForceRescaled,
                    other => return Err(format!("tangential model {other} has no counterpart")),
                };
                let given = words.optional("k_t")?.map(|k| units.si(k, stiffness));
                let of_constants = constants.map(|c| 8.0 * effective_shear_modulus(c, c));
                let stiffness = given
                    .or(of_constants)
                    .ok_or("mindlin with NULL takes a normal model with material constants")?;
                sliding = spring(stiffness, words.number("x_gammat")?, memory);
                friction = words.number("mu_s")?;
            }
            ("rolling", "sds") => {
                let k = units.si(words.number("k_roll")?, STIFFNESS);
                let dashpot = units.si(words.number("gamma_roll")?, DASHPOT);
                rolling = (RollingModel::Sds { stiffness: k, dashpot }, words.number("mu_roll")?);
            }
            ("twisting", "marshall") => twists = true,
            ("twisting", "sds") => {
                words.rest = words.rest.get(3..).unwrap_or_default();
                twists = true;
                without.push("twisting sds with coefficients of its own: taken is marshall".to_owned());
            }
            ("damping", "velocity") => damping = Damping::Velocity,
            ("damping", "mass_velocity") => damping = Damping::MassVelocity,
            ("damping", "viscoelastic") => damping = Damping::Viscoelastic,
            ("damping", "tsuji") => damping = Damping::Tsuji,
            ("damping", "coeff_restitution") => damping = Damping::Restitution,
            ("rolling" | "twisting" | "tangential" | "heat", "none") => {}
            ("heat", _) => {
                words.word();
                without.push("heat of the contact".to_owned());
            }
            _ => without.push(format!("{key} {model}")),
        }
    }
    let dashpot = match damping {
        Damping::Velocity => Dashpot::Constant(units.si(eta, DASHPOT)),
        Damping::MassVelocity => Dashpot::PerMass(units.si(eta, RATE)),
        Damping::Viscoelastic => Dashpot::PerMassAndRadius(units.si(eta, RATE_PER_LENGTH)),
        Damping::Restitution => Dashpot::Restitution(eta),
        Damping::Tsuji => Dashpot::Restitution(of_tsuji(eta, is_linear)),
    };
    let law = PairLaw { elastic, dashpot, sliding, friction, rolling, twists, adhesion };
    Ok((law, words.rest, without))
}

fn spring(stiffness: f64, damping_ratio: f64, memory: Memory) -> Sliding {
    Sliding::Spring { stiffness, damping_ratio: Some(damping_ratio), memory }
}

/// k_t/a (Pa) of a body of ν = 0.29 or so: 2 E*.
fn of_mindlin(elastic: Elastic) -> f64 {
    match elastic {
        Elastic::Hertz { modulus, .. } => 2.0 * modulus,
        Elastic::Linear { stiffness } => stiffness,
    }
}

/// The restitution (-) whose dashpot is that of `damping tsuji` for `eta`, c = α √(m F/δ) with the published polynomial α as LAMMPS
/// codes it, without the root of 2.
pub fn of_tsuji(eta: f64, is_linear: bool) -> f64 {
    const FIT: [f64; 7] = [1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218];
    let alpha = FIT.iter().rev().fold(0.0, |sum, c| sum * eta + c).max(0.0);
    let ratio = if is_linear { 0.5 * alpha } else { alpha / 5.0_f64.sqrt() };
    crate::laws::restitution(ratio).unwrap_or(0.01).min(1.0)
}
