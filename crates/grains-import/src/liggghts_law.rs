//! Contact laws of LIGGGHTS: `gran model …` with properties of types and pairs of types.

use crate::laws::{Adhesion, Bodies, Dashpot, Elastic, PairLaw, RollingModel, Sliding};
use crate::units::{DASHPOT, Dimension, PRESSURE, RATE, RATE_PER_LENGTH, STIFFNESS, Units, VELOCITY};
use grains_contact::{
    CohesionArea, Elastic as Constants, Memory, effective_modulus, effective_shear_modulus,
};
use std::collections::BTreeMap;

/// Numbers of a property.
#[derive(Clone, Debug)]
enum Values {
    Scalar(f64),
    PerType(Vec<f64>),
    PerPair(usize, Vec<f64>),
}

/// Names of properties that some law or the heat of a case takes.
const KNOWN: [&str; 17] = [
    "youngsModulus",
    "poissonsRatio",
    "coefficientRestitution",
    "coefficientFriction",
    "coefficientRollingFriction",
    "coefficientRollingViscousDamping",
    "cohesionEnergyDensity",
    "characteristicVelocity",
    "kn",
    "kt",
    "gamman",
    "gammat",
    "gamman_abs",
    "gammat_abs",
    "thermalConductivity",
    "thermalCapacity",
    "coefficientMaxRestitution",
];

/// Properties of types and pairs of types (`fix property/global`), in units of the script.
#[derive(Clone, Debug, Default)]
pub struct Properties(BTreeMap<String, Values>);

impl Properties {
    /// Takes the words behind `property/global`.
    ///
    /// # Errors
    /// Properties that no law has, and numbers that are missing.
    pub fn set(&mut self, words: &[String], numbers: &[f64]) -> Result<(), String> {
        let [name, style, ..] = words else {
            return Err("name and style of the property are missing".into());
        };
        let values = match style.as_str() {
            "scalar" => Values::Scalar(*numbers.first().ok_or("the number is missing")?),
            "vector" | "peratomtype" | "atomtype" => Values::PerType(numbers.to_vec()),
            "matrix" | "peratomtypepair" | "atomtypepair" => {
                let (count, rest) = numbers.split_first().ok_or("the number of types is missing")?;
                let count = *count as usize;
                let pairs = count.saturating_mul(count);
                if rest.len() != pairs {
                    return Err(format!("{} numbers, but {count} types have {pairs} pairs", rest.len()));
                }
                Values::PerPair(count, rest.to_vec())
            }
            other => return Err(format!("property style {other} is none")),
        };
        if !KNOWN.contains(&name.as_str()) {
            return Err(format!("no contact law of a case takes {name}"));
        }
        self.0.insert(name.clone(), values);
        Ok(())
    }

    fn missing(name: &str) -> String {
        format!("the law takes {name}: add `fix … property/global {name}`")
    }

    /// A number.
    ///
    /// # Errors
    /// A property that is missing.
    fn scalar(&self, name: &str) -> Result<f64, String> {
        match self.0.get(name) {
            Some(Values::Scalar(value)) => Ok(*value),
            Some(Values::PerType(values)) => values.first().copied().ok_or_else(|| Self::missing(name)),
            _ => Err(Self::missing(name)),
        }
    }

    /// The number of a type (from 1).
    ///
    /// # Errors
    /// A property that is missing, or has no number for the type.
    pub fn of_type(&self, name: &str, kind: usize) -> Result<f64, String> {
        match self.0.get(name) {
            Some(Values::PerType(values)) => {
                let value = kind.checked_sub(1).and_then(|k| values.get(k)).copied();
                value.ok_or_else(|| format!("{name} has no number for type {kind}"))
            }
            Some(Values::Scalar(value)) => Ok(*value),
            _ => Err(Self::missing(name)),
        }
    }

    fn of_pair(&self, name: &str, [i, j]: [usize; 2]) -> Result<f64, String> {
        match self.0.get(name) {
            Some(Values::PerPair(count, values))
                if (1..=*count).contains(&i) && (1..=*count).contains(&j) =>
            {
                Ok(values[(i - 1) * count + j - 1])
            }
            Some(Values::PerPair(..)) => Err(format!("{name} has no number for types {i} and {j}")),
            _ => Err(Self::missing(name)),
        }
    }
}

/// Normal force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Model {
    Hertz,
    Hooke,
    HookeStiffness,
    HertzStiffness,
}

/// Tangential force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Friction {
    History,
    NoHistory,
    Off,
}

/// `gran model … tangential … rolling_friction … cohesion …` and its switches.
#[derive(Clone, Debug, PartialEq)]
pub struct Style {
    model: Model,
    friction: Friction,
    rolling: Option<&'static str>,
    cohesion: Option<&'static str>,
    tangential_damping: bool,
    absolute_damping: bool,
    two_sevenths: bool,
    /// What the style asks for that a case does not have.
    pub without: Vec<String>,
}

impl Style {
    /// Reads the words from `model` on, up to `primitive`, `mesh` or the end.
    ///
    /// # Errors
    /// Normal forces that a case does not have.
    pub fn parse(words: &[String]) -> Result<Self, String> {
        let mut style = Self {
            model: Model::Hertz,
            friction: Friction::Off,
            rolling: None,
            cohesion: None,
            tangential_damping: true,
            absolute_damping: false,
            two_sevenths: false,
            without: Vec::new(),
        };
        let mut pairs = words.iter().take_while(|word| !matches!(word.as_str(), "primitive" | "mesh"));
        while let Some(key) = pairs.next() {
            let value = pairs.next().map_or("", String::as_str);
            style.take(key, value)?;
        }
        Ok(style)
    }

    fn take(&mut self, key: &str, value: &str) -> Result<(), String> {
        let is_on = value == "on";
        match (key, value) {
            ("model", "hertz") => self.model = Model::Hertz,
            ("model", "hooke") => self.model = Model::Hooke,
            ("model", "hooke/stiffness") => self.model = Model::HookeStiffness,
            ("model", "hertz/stiffness") => self.model = Model::HertzStiffness,
            ("model", "hooke/hysteresis") => {
                self.model = Model::Hooke;
                self.without.push("hysteresis, taken for hooke: normal = { kind = \"elastic_plastic\" } of a case is near it".to_owned());
            }
            ("model", other) => {
                return Err(format!(
                    "normal model {other} has no counterpart; hertz, hooke and both with /stiffness do"
                ));
            }
            ("tangential", "history") => self.friction = Friction::History,
            ("tangential", "no_history") => self.friction = Friction::NoHistory,
            ("rolling_friction", "cdt") => self.rolling = Some("cdt"),
            ("rolling_friction", "epsd") => self.rolling = Some("epsd"),
            ("rolling_friction", "epsd2") => self.rolling = Some("epsd2"),
            ("cohesion", "sjkr") => self.cohesion = Some("sjkr"),
            ("cohesion", "sjkr2") => self.cohesion = Some("sjkr2"),
            ("tangential" | "rolling_friction" | "cohesion", "off") | ("surface", _) => {}
            ("tangential_damping", _) => self.tangential_damping = is_on,
            ("absolute_damping", _) => self.absolute_damping = is_on,
            ("ktToKnUser", _) => self.two_sevenths = is_on,
            (_, "off") => {}
            _ => self.without.push(format!("{key} {value}")),
        }
        Ok(())
    }

    /// The law of two types whose particles are `bodies`, at a wall if `is_wall`.
    ///
    /// # Errors
    /// Properties that are missing.
    pub fn law(
        &self,
        properties: &Properties,
        units: &Units,
        types: [usize; 2],
        bodies: &Bodies,
        is_wall: bool,
    ) -> Result<PairLaw, String> {
        let pair = |name: &str, dimension: Dimension| {
            Ok::<_, String>(units.si(properties.of_pair(name, types)?, dimension))
        };
        let plain = |name: &str| properties.of_pair(name, types);
        let (elastic, dashpot, stiffness, damping_ratio) = match self.model {
            Model::Hertz => {
                let [a, b] = self.constants(properties, units, types)?;
                let elastic = Elastic::Hertz { modulus: effective_modulus(a, b), of_materials: true };
                let dashpot = Dashpot::Restitution(plain("coefficientRestitution")?);
                (elastic, dashpot, 8.0 * effective_shear_modulus(a, b), None)
            }
            Model::Hooke => {
                let [a, b] = self.constants(properties, units, types)?;
                let speed = units.si(properties.scalar("characteristicVelocity")?, VELOCITY);
                let stiffness = hooke_stiffness(effective_modulus(a, b), speed, bodies);
                let dashpot = Dashpot::Restitution(plain("coefficientRestitution")?);
                let share = if self.two_sevenths { 2.0 / 7.0 } else { 1.0 };
                (Elastic::Linear { stiffness }, dashpot, share * stiffness, Some(1.0))
            }
            Model::HookeStiffness => {
                let (n, t, dimension) = match self.absolute_damping {
                    true => ("gamman_abs", "gammat_abs", DASHPOT),
                    false => ("gamman", "gammat", RATE),
                };
                let [along, across] = [pair(n, dimension)?, pair(t, dimension).unwrap_or(0.0)];
                let dashpot =
                    if self.absolute_damping { Dashpot::Constant(along) } else { Dashpot::PerMass(along) };
                let elastic = Elastic::Linear { stiffness: pair("kn", STIFFNESS)? };
                (elastic, dashpot, pair("kt", STIFFNESS)?, Some(ratio(across, along)))
            }
            Model::HertzStiffness => {
                let [along, across] =
                    [pair("gamman", RATE_PER_LENGTH)?, pair("gammat", RATE_PER_LENGTH).unwrap_or(0.0)];
                let modulus = 0.75 * pair("kn", PRESSURE)?;
                let elastic = Elastic::Hertz { modulus, of_materials: false };
                let dashpot = Dashpot::PerMassAndRadius(along);
                (elastic, dashpot, pair("kt", PRESSURE)?, Some(ratio(across, along)))
            }
        };
        let damping_ratio = if self.tangential_damping { damping_ratio } else { Some(0.0) };
        let sliding = match self.friction {
            Friction::History => Sliding::Spring { stiffness, damping_ratio, memory: Memory::Displacement },
            Friction::NoHistory => Sliding::Viscous {
                damping_ratio: damping_ratio.unwrap_or_else(|| equal_damping(elastic, stiffness)),
            },
            Friction::Off => Sliding::Viscous { damping_ratio: 0.0 },
        };
        let friction = if self.friction == Friction::Off { 0.0 } else { plain("coefficientFriction")? };
        let rolling = match self.rolling {
            None => (RollingModel::Off, 0.0),
            Some(model) => {
                let damping = || plain("coefficientRollingViscousDamping");
                let model = match model {
                    "cdt" => RollingModel::Constant,
                    "epsd" => RollingModel::Epsd { damping: damping()? },
                    _ => RollingModel::Epsd2,
                };
                (model, plain("coefficientRollingFriction")?)
            }
        };
        let adhesion = match self.cohesion {
            None => Adhesion::Off,
            Some(model) => {
                let area =
                    if model == "sjkr2" && !is_wall { CohesionArea::DoubleLens } else { CohesionArea::Lens };
                Adhesion::Sjkr(pair("cohesionEnergyDensity", PRESSURE)?, area)
            }
        };
        Ok(PairLaw { elastic, dashpot, sliding, friction, rolling, twists: false, adhesion })
    }

    fn constants(
        &self,
        properties: &Properties,
        units: &Units,
        types: [usize; 2],
    ) -> Result<[Constants; 2], String> {
        let of = |kind: usize| {
            Ok::<_, String>(Constants {
                youngs_modulus: units.si(properties.of_type("youngsModulus", kind)?, PRESSURE),
                poissons_ratio: properties.of_type("poissonsRatio", kind)?,
            })
        };
        Ok([of(types[0])?, of(types[1])?])
    }

    /// Whether the stiffness of the law depends on the size of the particles, and how.
    pub fn depends_on_size(&self) -> Option<&'static str> {
        (self.model == Model::Hooke).then_some(
            "LIGGGHTS hooke has k_n = (16/15) √R* E* (15 m* v²/(16 √R* E*))^(1/5) of each pair of particles, v the characteristicVelocity",
        )
    }
}

fn ratio(above: f64, below: f64) -> f64 {
    if below > 0.0 { above / below } else { 0.0 }
}

fn equal_damping(elastic: Elastic, stiffness: f64) -> f64 {
    match elastic {
        Elastic::Hertz { modulus, .. } => (stiffness / (2.0 * modulus)).sqrt(),
        Elastic::Linear { stiffness: normal } => (stiffness / normal).sqrt(),
    }
}

/// k_n = (16/15) √R* E* (15 m* v²/(16 √R* E*))^(1/5) (N/m): a linear spring as deep as Hertz at the speed v (m/s).
pub fn hooke_stiffness(modulus: f64, speed: f64, bodies: &Bodies) -> f64 {
    let scale = bodies.radius.sqrt() * modulus;
    16.0 / 15.0 * scale * (15.0 * bodies.mass * speed * speed / (16.0 * scale)).powf(0.2)
}
