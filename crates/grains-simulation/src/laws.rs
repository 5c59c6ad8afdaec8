//! From the contacts of a case to contact laws.

use grains_case::{
    Attraction as CaseAttraction, Capillary as CaseCapillary, Case, Contact, Formation as CaseFormation,
    Material, Normal as CaseNormal, Rolling as CaseRolling, Tangential as CaseTangential,
};
use grains_contact::{
    Attraction, BridgeViscosity, Capillary, ContactLaw, Dmt, Elastic, ElasticPlastic, FilmShare, FilmSupply,
    Formation, Hertz, Jkr, Linear, LiquidBridge, Normal, Rabinovich, Rolling, Rupture, Sjkr, Supply,
    Tangential, VanDerWaals, Willett, WillettShort, effective_modulus, effective_shear_modulus,
    work_of_adhesion,
};

/// The law of a contact of a case.
pub(crate) fn law(case: &Case, contact: &Contact) -> ContactLaw {
    let (restitution, friction) = (contact.restitution, contact.friction);
    if case.collisions.is_hard() {
        return ContactLaw::rigid(restitution, friction);
    }
    let pair = contact.between.map(|m| &case.materials[m]);
    ContactLaw::new(normal(contact, pair), restitution, friction, tangential(contact, pair))
        .with_damping(contact.damping)
        .with_rolling(rolling(contact))
        .with_twisting(contact.twisting)
        .with_attraction(attraction(contact))
}

/// Elastic constants of two materials that have them.
fn elastic(pair: [&Material; 2]) -> [Elastic; 2] {
    pair.map(|m| Elastic {
        youngs_modulus: m.youngs_modulus.unwrap_or(f64::NAN),
        poissons_ratio: m.poissons_ratio.unwrap_or(f64::NAN),
    })
}

/// Effective modulus E* (Pa) of a Hertzian contact, softened as the case asks.
pub(crate) fn modulus(contact: &Contact, pair: [&Material; 2]) -> f64 {
    let [a, b] = elastic(pair);
    contact.effective_modulus.unwrap_or_else(|| effective_modulus(a, b)) / contact.softening
}

/// Work of adhesion w (J/m²) of a contact that takes one.
pub(crate) fn adhesion(contact: &Contact, pair: [&Material; 2]) -> f64 {
    let [a, b] = pair.map(|m| m.surface_energy.unwrap_or(f64::NAN));
    contact.work_of_adhesion.unwrap_or_else(|| work_of_adhesion(a, b))
}

fn normal(contact: &Contact, pair: [&Material; 2]) -> Normal {
    let stiffness = contact.normal_stiffness.unwrap_or(0.0);
    let hertz = Hertz { modulus: modulus(contact, pair) };
    match contact.normal {
        CaseNormal::Linear => Linear { stiffness }.into(),
        CaseNormal::Hertz => hertz.into(),
        CaseNormal::Dmt => Dmt { hertz, work: adhesion(contact, pair) }.into(),
        CaseNormal::Jkr { tear } => {
            Jkr { modulus: hertz.modulus, work: adhesion(contact, pair), tear }.into()
        }
        CaseNormal::Sjkr { energy_density, area } => Sjkr { hertz, energy_density, area }.into(),
        CaseNormal::ElasticPlastic { adhesive_stiffness } => {
            ElasticPlastic::with_restitution(stiffness, contact.restitution, adhesive_stiffness).into()
        }
    }
}

fn tangential(contact: &Contact, pair: [&Material; 2]) -> Tangential {
    match contact.tangential() {
        CaseTangential::Spring { stiffness_ratio, damping_ratio } => {
            Tangential::Spring { stiffness_ratio, damping_ratio }
        }
        CaseTangential::Viscous { gamma_t } => Tangential::Viscous { rate: gamma_t },
        CaseTangential::ContactTime { stiffness_ratio } => Tangential::ContactTime { stiffness_ratio },
        // Without friction there is nothing to resist, and the constants may be missing.
        CaseTangential::Mindlin { .. } if contact.friction == 0.0 => Tangential::Viscous { rate: 0.0 },
        CaseTangential::Mindlin { memory, damping_ratio } => {
            let [a, b] = elastic(pair);
            let shear = contact.effective_shear_modulus.unwrap_or_else(|| effective_shear_modulus(a, b));
            let stiffness_ratio = 4.0 * shear / contact.softening / modulus(contact, pair);
            Tangential::Mindlin {
                stiffness_ratio,
                damping_ratio: damping_ratio.unwrap_or_else(|| Tangential::equal_damping(stiffness_ratio)),
                memory,
            }
        }
    }
}

fn rolling(contact: &Contact) -> Rolling {
    let friction = contact.rolling_friction;
    match contact.rolling {
        _ if friction == 0.0 => Rolling::None,
        CaseRolling::Viscous {} => Rolling::Viscous { friction },
        CaseRolling::Spring { stiffness_ratio, damping_ratio } => {
            Rolling::Spring { friction, stiffness_ratio, damping_ratio }
        }
        CaseRolling::Sds { stiffness, dashpot } => Rolling::Given { friction, stiffness, dashpot },
        CaseRolling::Epsd2 {} => Rolling::Tangential { friction },
        CaseRolling::Constant {} => Rolling::Constant { friction },
    }
}

/// Whether films feed the bridges of a contact.
pub(crate) fn is_fed_by_films(contact: &Contact) -> bool {
    matches!(contact.attraction, CaseAttraction::FilmBridge { .. })
}

/// Largest volume of a bridge (m³) that the case gives.
pub(crate) fn max_volume(contact: &Contact) -> Option<f64> {
    match contact.attraction {
        CaseAttraction::FilmBridge { max_volume, .. } => max_volume,
        _ => None,
    }
}

fn capillary(force: CaseCapillary, contact_angle: f64) -> Capillary {
    match force {
        CaseCapillary::Willett => Capillary::Willett(Willett::new(contact_angle)),
        CaseCapillary::WillettShort => Capillary::WillettShort(WillettShort::new(contact_angle)),
        CaseCapillary::Rabinovich => Capillary::Rabinovich(Rabinovich::new(contact_angle)),
    }
}

fn attraction(contact: &Contact) -> Attraction {
    match contact.attraction {
        CaseAttraction::None => Attraction::None,
        CaseAttraction::VanDerWaals { hamaker, asperity, inner, outer } => {
            Attraction::VanDerWaals(VanDerWaals { hamaker, asperity, inner, outer })
        }
        CaseAttraction::LiquidBridge {
            volume,
            surface_tension,
            contact_angle,
            force,
            viscosity,
            min_gap,
            film,
        } => {
            let bridge = LiquidBridge {
                surface_tension,
                contact_angle,
                capillary: capillary(force, contact_angle),
                rupture: Rupture::Lian,
                viscosity: BridgeViscosity { viscosity, min_gap },
                formation: if film > 0.0 { Formation::Films } else { Formation::Contact },
                supply: Supply::PerBridge(volume),
            };
            Attraction::LiquidBridge { bridge, film }
        }
        CaseAttraction::FilmBridge {
            share,
            max_volume,
            wall_share,
            formation,
            surface_tension,
            contact_angle,
            force,
            viscosity,
            min_gap,
        } => {
            let supply = FilmSupply {
                share: share.map_or(FilmShare::Cap, FilmShare::Constant),
                largest: 0.5 * max_volume.unwrap_or(0.0),
                wall_share,
            };
            let bridge = LiquidBridge {
                surface_tension,
                contact_angle,
                capillary: capillary(force, contact_angle),
                rupture: Rupture::Lian,
                viscosity: BridgeViscosity { viscosity, min_gap },
                formation: match formation {
                    CaseFormation::Contact => Formation::Contact,
                    CaseFormation::Films => Formation::Films,
                },
                supply: Supply::Films(supply),
            };
            Attraction::LiquidBridge { bridge, film: 0.0 }
        }
    }
}
