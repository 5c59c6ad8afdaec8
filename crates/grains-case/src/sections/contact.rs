//! `[[contact]]`: the contact law of a pair of materials.

use grains_contact::{Damping, Twisting};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Checker, Names};
use crate::sections::contact_law::{Attraction, Capillary, Normal, Rolling, Tangential};
use crate::sections::contact_points::Composite;
use crate::sections::material::Material;

/// The law between two materials: normal force, damping, Coulomb friction, resistance to rolling and twisting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Contact")]
pub struct Contact<Name = usize> {
    /// The two materials, in any order; the same one twice for a material with itself.
    pub between: [Name; 2],
    /// Law of the normal direction.
    #[serde(default)]
    pub normal: Normal,
    /// Normal stiffness k_n (N/m) of a linear spring, on loading; hard collisions do without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e2, 1e11]))]
    pub normal_stiffness: Option<f64>,
    /// Effective modulus E* (Pa), 1/E* = (1 − ν1²)/E1 + (1 − ν2²)/E2; by default from the materials.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e4, 1e12]))]
    pub effective_modulus: Option<f64>,
    /// Effective shear modulus G* (Pa), 1/G* = (2 − ν1)/G1 + (2 − ν2)/G2; by default from the materials.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e3, 1e12]))]
    pub effective_shear_modulus: Option<f64>,
    /// How many times softer than the materials the contact is made (-), for longer time steps: it divides both moduli; 1 by default.
    #[serde(default = "super::one", skip_serializing_if = "super::is_one")]
    #[schemars(extend("minimum" = 1, "x-plausible" = [1, 1e5]))]
    pub softening: f64,
    /// Work of adhesion w (J/m²) of "dmt" and "jkr"; by default 2 √(γ1 γ2) of the surface energies of the materials.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-6, 10]))]
    pub work_of_adhesion: Option<f64>,
    /// Coefficient of restitution e_n (-); 1 is perfectly elastic, 0.1 very dissipative.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-plausible" = [0.05, 1]))]
    pub restitution: f64,
    /// Loss of energy in the normal direction.
    #[serde(default)]
    pub damping: Damping,
    /// Coulomb friction coefficient (-).
    #[schemars(extend("minimum" = 0, "x-plausible" = [0, 2]))]
    pub friction: f64,
    /// Resistance to sliding; by default a spring, that of Mindlin where the normal force is Hertzian.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tangential: Option<Tangential>,
    /// Rolling friction coefficient (-): rolling torque over (effective radius × normal force).
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-plausible" = [0, 1]))]
    pub rolling_friction: f64,
    /// Resistance to rolling below that torque.
    #[serde(default)]
    pub rolling: Rolling,
    /// Resistance to twisting.
    #[serde(default)]
    pub twisting: Twisting,
    /// Pull over a gap.
    #[serde(default)]
    pub attraction: Attraction,
}

impl<Name> Contact<Name> {
    /// Resistance to sliding.
    pub fn tangential(&self) -> Tangential {
        self.tangential.unwrap_or_else(|| Tangential::of(&self.normal))
    }

    /// Whether rolling resistance is that of a tangential damping which is zero.
    pub(crate) fn is_rolling_undamped(&self) -> bool {
        let is_undamped = match self.tangential() {
            Tangential::Spring { damping_ratio, .. } => damping_ratio == 0.0 || self.restitution == 1.0,
            Tangential::Mindlin { damping_ratio, .. } => {
                damping_ratio == Some(0.0) || self.restitution == 1.0
            }
            Tangential::Viscous { gamma_t } => gamma_t == 0.0,
            Tangential::ContactTime { .. } => false,
        };
        matches!(self.rolling, Rolling::Viscous {}) && is_undamped
    }

    /// The same contact with its two materials named otherwise.
    pub(crate) fn rename<Other>(self, mut name: impl FnMut(usize, Name) -> Other) -> Contact<Other> {
        let mut side = 0..;
        let between = self.between.map(|n| name(side.next().unwrap_or_default(), n));
        Contact {
            between,
            normal: self.normal,
            normal_stiffness: self.normal_stiffness,
            effective_modulus: self.effective_modulus,
            effective_shear_modulus: self.effective_shear_modulus,
            softening: self.softening,
            work_of_adhesion: self.work_of_adhesion,
            restitution: self.restitution,
            damping: self.damping,
            friction: self.friction,
            tangential: self.tangential,
            rolling_friction: self.rolling_friction,
            rolling: self.rolling,
            twisting: self.twisting,
            attraction: self.attraction,
        }
    }
}

/// Resolves the names and refuses a pair that is described twice.
pub(crate) fn check(raw: Vec<Contact<String>>, names: &Names, checker: &mut Checker) -> Vec<Contact> {
    let mut contacts: Vec<Contact> = Vec::new();
    for (i, contact) in raw.into_iter().enumerate() {
        let errors_before = checker.error_count();
        let contact = contact.rename(|side, name| {
            checker.reference(&format!("contact[{i}].between[{side}]"), &name, "material", &names.materials)
        });
        if let Some(first) = find(&contacts, contact.between[0], contact.between[1])
            && checker.error_count() == errors_before
        {
            checker.error(
                &format!("contact[{i}].between"),
                format!("this pair is already described by contact[{first}]; remove one of them"),
            );
        }
        contacts.push(contact);
    }
    contacts
}

/// Index of the law between two materials, in either order.
pub(crate) fn find(contacts: &[Contact], a: usize, b: usize) -> Option<usize> {
    contacts.iter().position(|c| c.between == [a, b] || c.between == [b, a])
}

/// Refuses laws without the constants they take, with constants they do not take, and parts that do not go together.
pub(crate) fn check_laws(contacts: &[Contact], materials: &[Material], checker: &mut Checker) {
    for (i, contact) in contacts.iter().enumerate() {
        let key = |name: &str| format!("contact[{i}].{name}");
        let [Some(a), Some(b)] = contact.between.map(|m| materials.get(m)) else { continue };
        check_constants(contact, [a, b], &key, checker);
        check_parts(contact, &key, checker);
        check_attraction(contact, &key("attraction"), checker);
        check_liquid(contact, [a, b], &key("attraction.kind"), checker);
        let is_hertzian = contact.normal.is_hertzian();
        let is_mindlin = matches!(contact.tangential(), Tangential::Mindlin { .. });
        let without_effect = [
            ("effective_modulus", contact.effective_modulus.is_some() && !is_hertzian),
            ("softening", contact.softening != 1.0 && !is_hertzian),
            ("effective_shear_modulus", contact.effective_shear_modulus.is_some() && !is_mindlin),
            ("work_of_adhesion", contact.work_of_adhesion.is_some() && !contact.normal.takes_work()),
        ];
        for (name, _) in without_effect.iter().filter(|(_, given)| *given) {
            checker.error(&key(name), "is not taken by this law; remove it, or set contact.normal".into());
        }
    }
}

/// Refuses laws without their constants.
fn check_constants(
    contact: &Contact,
    [a, b]: [&Material; 2],
    key: &impl Fn(&str) -> String,
    checker: &mut Checker,
) {
    let is_hertzian = contact.normal.is_hertzian();
    let has = |of: fn(&Material) -> Option<f64>| of(a).is_some() && of(b).is_some();
    let is_elastic = has(|m| m.youngs_modulus) && has(|m| m.poissons_ratio);
    let pair = format!("\"{}\" and \"{}\"", a.name, b.name);
    match (is_hertzian, contact.normal_stiffness) {
        (false, None) => checker.error(
            &key("normal_stiffness"),
            "missing key. Normal stiffness k_n (N/m). Only collisions.model = \"hard\" does without it, and Hertzian laws".into(),
        ),
        (true, Some(_)) => checker.error(
            &key("normal_stiffness"),
            "belongs to a linear spring; remove it, as this law takes the elastic constants of the materials".into(),
        ),
        _ => {}
    }
    if is_hertzian && contact.effective_modulus.is_none() && !is_elastic {
        checker.error(
            &key("normal.kind"),
            format!("takes youngs_modulus (Pa) and poissons_ratio of {pair}: give them in [[material]], or effective_modulus (Pa) here"),
        );
    }
    let takes_shear = matches!(contact.tangential(), Tangential::Mindlin { .. }) && contact.friction > 0.0;
    if is_hertzian && takes_shear && contact.effective_shear_modulus.is_none() && !is_elastic {
        checker.error(
            &key("tangential.kind"),
            format!("\"mindlin\" takes youngs_modulus (Pa) and poissons_ratio of {pair}, or effective_shear_modulus (Pa) here"),
        );
    }
    if contact.normal.takes_work() && contact.work_of_adhesion.is_none() && !has(|m| m.surface_energy) {
        checker.error(
            &key("normal.kind"),
            format!("takes surface_energy (J/m2) of {pair}: give it in [[material]], or work_of_adhesion (J/m2) here"),
        );
    }
}

/// Refuses parts of a law that do not go together.
fn check_parts(contact: &Contact, key: &impl Fn(&str) -> String, checker: &mut Checker) {
    let tangential = contact.tangential();
    let has_spring = matches!(tangential, Tangential::Spring { .. } | Tangential::Mindlin { .. });
    let is_plastic = matches!(contact.normal, Normal::ElasticPlastic { .. });
    let misfits = [
        (
            matches!(tangential, Tangential::Mindlin { .. }) && !contact.normal.is_hertzian(),
            "tangential.kind",
            "\"mindlin\" goes with Hertzian laws: set contact.normal, or take \"spring\"",
        ),
        (
            matches!(tangential, Tangential::ContactTime { .. }) && contact.normal != Normal::Linear,
            "tangential.kind",
            "\"contact_time\" goes with a linear spring, whose contact time is the same at any speed",
        ),
        (
            matches!(contact.rolling, Rolling::Epsd2 {}) && contact.rolling_friction > 0.0 && !has_spring,
            "rolling.kind",
            "\"epsd2\" takes the stiffness of a tangential spring, and there is none",
        ),
        (
            is_plastic && contact.damping != Damping::Restitution,
            "damping",
            "goes with elastic laws: \"elastic_plastic\" loses energy by its two stiffnesses",
        ),
    ];
    for (_, name, message) in misfits.into_iter().filter(|(is_misfit, ..)| *is_misfit) {
        checker.error(&key(name), message.into());
    }
}

/// Refuses bridges of one volume between films, and bridges from films where there are none.
fn check_liquid(contact: &Contact, [a, b]: [&Material; 2], key: &str, checker: &mut Checker) {
    let wet = [a, b].into_iter().find(|m| m.film.is_some());
    match (&contact.attraction, wet) {
        (Attraction::LiquidBridge { .. }, Some(wet)) => checker.error(
            key,
            format!(
                "bridges of one volume leave the film of \"{}\" as it is: take \"film_bridge\", or remove material.film",
                wet.name
            ),
        ),
        (Attraction::FilmBridge { .. }, None) => {
            let dry = match a.name == b.name {
                true => format!("\"{}\" has none", a.name),
                false => format!("neither \"{}\" nor \"{}\" has one", a.name, b.name),
            };
            checker.error(
                key,
                format!(
                    "takes liquid from films, and {dry}: give film in [[material]], or take \"liquid_bridge\" with a volume"
                ),
            );
        }
        _ => {}
    }
}

/// Refuses what does not go with bridges that films feed: bridges of one volume, contacts of parts each on its own.
pub(crate) fn check_budget(contacts: &[Contact], composite: Composite, checker: &mut Checker) {
    if !contacts.iter().any(|c| matches!(c.attraction, Attraction::FilmBridge { .. })) {
        return;
    }
    if let Some(i) = contacts.iter().position(|c| matches!(c.attraction, Attraction::LiquidBridge { .. })) {
        checker.error(
            &format!("contact[{i}].attraction.kind"),
            "another contact has bridges that films feed, whose liquid is accounted for: take \"film_bridge\" everywhere, or \"liquid_bridge\"".into(),
        );
    }
    if composite != Composite::Potential {
        checker.error(
            "contact_points.composite",
            "two bodies have one bridge, however many of their parts touch: \"film_bridge\" takes \"potential\"".into(),
        );
    }
}

/// Refuses a pull that its law cannot have.
fn check_attraction(contact: &Contact, key: &str, checker: &mut Checker) {
    /// Largest contact angle of Willett's fit (rad).
    const WIDEST: f64 = 50.0 * std::f64::consts::PI / 180.0;
    match contact.attraction {
        Attraction::None => return,
        Attraction::LiquidBridge { contact_angle, force: Capillary::Willett, .. }
        | Attraction::FilmBridge { contact_angle, force: Capillary::Willett, .. }
            if contact_angle > WIDEST =>
        {
            checker.error(
                &format!("{key}.contact_angle"),
                "beyond 50 degrees (0.873), where Willett's fit ends: take force = \"rabinovich\"; the unit is rad"
                    .into(),
            );
        }
        Attraction::VanDerWaals { inner, outer, .. } if outer <= inner => {
            checker.error(
                &format!("{key}.outer"),
                format!("must be above inner = {inner:e} m, below which the force grows no more"),
            );
        }
        Attraction::LiquidBridge { .. } | Attraction::FilmBridge { .. } | Attraction::VanDerWaals { .. } => {}
    }
    if contact.normal.takes_work() {
        checker.error(
            &format!("{key}.kind"),
            "goes with laws without adhesion of their own: take \"hertz\" or \"linear\", or remove it".into(),
        );
    }
}
