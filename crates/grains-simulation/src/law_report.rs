//! What contact laws come to in a case.

use crate::insertion::KindRange;
use crate::laws;
use crate::liquid::FilmReport;
use crate::timestep::Partner;
use crate::timestep::{Encounter, TimeStepChoice};
use grains_case::{Attraction, Case, Contact, Material, Rolling, Tangential};
use grains_contact::{ContactLaw, Twisting};
use grains_dem::{Catalogue, CollisionModel, DemSetup};

/// What a law comes to for the lightest bodies it acts on.
#[derive(Clone, Debug)]
pub struct LawReport {
    /// The two materials; the second may be a wall's.
    pub materials: [String; 2],
    /// What the second body is.
    pub partner: Partner,
    /// The parts of the law as the case names them, with their coefficients.
    pub parts: Vec<String>,
    /// The law.
    pub law: ContactLaw,
    /// Effective modulus (Pa), of a Hertzian law.
    pub modulus: Option<f64>,
    /// How many times softer than its materials the case makes the contact (-).
    pub softening: f64,
    /// Force that separates them (N).
    pub pull_off: f64,
    /// That over the weight of the lighter one (-), if there is gravity.
    pub bond_number: Option<f64>,
    /// Largest gap over which they hold on to each other (m).
    pub reach: f64,
    /// Speed below which bodies that touch stay together (m/s), of laws that lose energy by the tear.
    pub sticking_speed: Option<f64>,
    /// Volume of a liquid bridge over that of the cube of 2 R* (-).
    pub bridge_volume: Option<f64>,
    /// What bridges come to that films feed.
    pub films: Option<FilmReport>,
    /// Time of a Rayleigh wave over the smaller body (s), where the elastic constants of its material are known; √softening times as long where it is softened.
    pub rayleigh_time: Option<f64>,
}

impl LawReport {
    /// Of all encounters of a case of soft collisions.
    pub(crate) fn of_all(
        case: &Case,
        setup: &DemSetup,
        kinds: &[KindRange],
        step: &TimeStepChoice,
    ) -> Vec<Self> {
        match setup.collisions {
            CollisionModel::Soft => {
                step.encounters.iter().map(|e| Self::of(case, &setup.catalogue, kinds, e)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Of an encounter of the case.
    fn of(case: &Case, catalogue: &Catalogue, kinds: &[KindRange], encounter: &Encounter) -> Self {
        let contact = &case.contacts[encounter.contact];
        let [a, b] = contact.between;
        let law = *catalogue.contacts.law(a as u16, b as u16);
        let gravity = case.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
        let radius = encounter.effective_radius;
        let number = |name: &String| case.materials.iter().position(|m| m.name == *name).unwrap_or(0);
        let materials = [number(&encounter.materials[0]), number(&encounter.materials[1])];
        let is_wall = encounter.partner == Partner::Wall;
        let films = FilmReport::of(case, catalogue, kinds, (&law, materials, is_wall));
        let pull = films.as_ref().map_or_else(|| law.attraction.pull_off(radius), |films| films.pull);
        let pull_off = law.normal.pull_off(radius) + pull;
        let modulus =
            law.normal.is_hertzian().then(|| laws::modulus(contact, [a, b].map(|m| &case.materials[m])));
        let of_body = case.materials.iter().find(|m| m.name == encounter.materials[0]);
        Self {
            materials: encounter.materials.clone(),
            partner: encounter.partner,
            parts: parts(contact, &law),
            modulus,
            softening: contact.softening,
            pull_off,
            bond_number: (gravity > 0.0).then(|| pull_off / (encounter.mass * gravity)),
            reach: law.reach(radius),
            sticking_speed: (law.normal.reach(radius) > 0.0)
                .then(|| sticking_speed(&law, encounter.reduced_mass, radius, case.time.impact_speed)),
            bridge_volume: match contact.attraction {
                Attraction::LiquidBridge { volume, .. } => Some(volume / (2.0 * radius).powi(3)),
                Attraction::FilmBridge { .. } => {
                    films.as_ref().map(|films| films.bridges[0][0] / (2.0 * radius).powi(3))
                }
                _ => None,
            },
            films,
            rayleigh_time: of_body
                .and_then(|m| rayleigh_time(m, encounter.radius))
                .map(|time| time * contact.softening.sqrt()),
            law,
        }
    }
}

/// The parts of a law as the case names them, with their coefficients, but for those that do nothing.
fn parts(contact: &Contact, law: &ContactLaw) -> Vec<String> {
    let tangential = match contact.tangential() {
        Tangential::Spring { .. } => "spring",
        Tangential::Mindlin { .. } => "mindlin",
        Tangential::Viscous { .. } => "viscous",
        Tangential::ContactTime { .. } => "contact_time",
    };
    let rolling = match contact.rolling {
        Rolling::Spring { .. } => "spring",
        Rolling::Viscous {} => "viscous",
        Rolling::Sds { .. } => "sds",
        Rolling::Epsd2 {} => "epsd2",
        Rolling::Constant {} => "constant",
    };
    let attraction = match contact.attraction {
        Attraction::None => None,
        Attraction::LiquidBridge { .. } => Some("liquid_bridge".to_string()),
        Attraction::FilmBridge { .. } => Some("film_bridge".to_string()),
        Attraction::VanDerWaals { .. } => Some("van_der_waals".to_string()),
    };
    let resistance = |what: &str, coefficient: f64, kind: &str| {
        (coefficient > 0.0).then(|| format!("{what} {coefficient} ({kind})"))
    };
    let parts = [
        Some(law.normal.name().to_string()),
        resistance("friction", contact.friction, tangential),
        resistance("rolling friction", contact.rolling_friction, rolling),
        (contact.twisting == Twisting::Marshall).then(|| "twisting marshall".to_string()),
        attraction,
    ];
    parts.into_iter().flatten().collect()
}

/// π R √(ρ/G)/(0.1631 ν + 0.8766), G = E/(2 (1 + ν)).
fn rayleigh_time(material: &Material, radius: f64) -> Option<f64> {
    let (e, nu, density) = (material.youngs_modulus?, material.poissons_ratio?, material.density?);
    let shear = e / (2.0 * (1.0 + nu));
    Some(std::f64::consts::PI * radius * (density / shear).sqrt() / (0.1631 * nu + 0.8766))
}

/// Largest speed (m/s) at which bodies that collide head on stay together, to a percent, up to a thousand times `speed`.
fn sticking_speed(law: &ContactLaw, mass: f64, radius: f64, speed: f64) -> f64 {
    let sticks = |speed: f64| law.collision(mass, radius, speed).restitution == 0.0;
    let (mut low, mut high) = (1e-6 * speed, 1e3 * speed);
    if !sticks(low) {
        return 0.0;
    }
    while high > 1.01 * low {
        let middle = (low * high).sqrt();
        if sticks(middle) { low = middle } else { high = middle }
    }
    low
}
