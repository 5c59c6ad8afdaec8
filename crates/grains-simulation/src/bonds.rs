//! From the bonds of a case to kinds of bonds, and what they come to.

use crate::insertion::KindRange;
use grains_case::{Bond as CaseBond, Case};
use grains_contact::{Bond, Section, Strength, reduced_mass};
use grains_dem::{BondKind, BondRadius, Bonded, Catalogue, DemSetup};

/// The kinds of bonds of a case.
pub(crate) fn kinds(case: &Case) -> Vec<BondKind> {
    case.bonds.iter().map(kind).collect()
}

fn kind(given: &CaseBond) -> BondKind {
    let young = given.youngs_modulus;
    let shear_modulus = young / (2.0 * (1.0 + given.poissons_ratio));
    // The radius is that of each pair.
    let section = Section { radius: f64::NAN, young, shear_modulus, shear: given.shear };
    let strength = Strength { tensile: given.tensile_strength, shear: given.shear_strength };
    BondKind {
        bond: Bond { section, damping: given.damping_ratio, strength },
        radius: match (given.radius, given.radius_ratio) {
            (Some(radius), _) => BondRadius::Length(radius),
            (None, ratio) => BondRadius::OverSmaller(ratio.unwrap_or(1.0)),
        },
        time: given.at,
        distance: given.distance,
        bonded: match given.between {
            Some(pair) => Bonded::Materials(pair.map(|material| material as u16)),
            None => Bonded::Pairs(given.pairs.clone().into()),
        },
    }
}

/// Refuses bonds so long that a particle could be bonded to two images of another, or so thick that sums of their moments are
/// not exact.
pub(crate) fn check_sizes(case: &Case, setup: &DemSetup) -> Result<(), String> {
    let thickest = 2.0 * setup.largest_radius;
    let radius = |kind: &BondKind| kind.section_radius(setup.largest_radius);
    if let Some(k) = setup.bonds.iter().position(|kind| radius(kind) > thickest) {
        let message = format!(
            "thicker than the largest particle, of {thickest:.3e} m: lower it; lengths are in metres"
        );
        return Err(case.about(&format!("bond[{k}].radius"), message));
    }
    let global = &setup.global;
    let periodic = (0..3).filter(|&axis| global.periodic[axis]).map(|axis| global.length(axis));
    let shortest = periodic.fold(f64::INFINITY, f64::min);
    let longest = setup.longest_bond();
    let Some(worst) =
        (0..setup.bonds.len()).find(|&k| setup.bonds[k].longest(setup.largest_radius) == longest)
    else {
        return Ok(());
    };
    if longest <= 0.5 * shortest {
        return Ok(());
    }
    let message = format!(
        "bonds may get {longest:.3e} m long before they break, more than half the periodic domain ({shortest:.3e} m): lower it, make the domain wider, or give a tensile_strength far below youngs_modulus"
    );
    Err(case.about(&format!("bond[{worst}].distance"), message))
}

/// What bonds of a kind come to between the lightest particles they join, touching spheres of their mass.
#[derive(Clone, Debug)]
pub struct BondReport {
    /// Their name in the case.
    pub name: String,
    /// Radius of the section (m).
    pub radius: f64,
    /// Stiffness along the axis (N/m), against shear (N/m), bending (N m) and torsion (N m).
    pub stiffnesses: [f64; 4],
    /// Half the shortest period of a pair (s).
    pub half_period: f64,
    /// Force that tears one apart (N).
    pub strength: f64,
    /// That over the weight of the lighter particle (-), if there is gravity.
    pub weights: Option<f64>,
}

impl BondReport {
    /// Of all bonds of a case, between particles that are inserted.
    pub(crate) fn of_all(case: &Case, catalogue: &Catalogue, kinds: &[KindRange]) -> Vec<Self> {
        case.bonds.iter().filter_map(|given| Self::of(case, given, catalogue, kinds)).collect()
    }

    fn of(case: &Case, given: &CaseBond, catalogue: &Catalogue, kinds: &[KindRange]) -> Option<Self> {
        let ends = match given.between {
            Some(pair) => pair.map(|material| lightest(catalogue, kinds, Some(material))),
            None => [lightest(catalogue, kinds, None); 2],
        };
        let [Some((mass, radius)), Some((other_mass, other_radius))] = ends else { return None };
        let kind = kind(given);
        let mut bond = kind.bond;
        bond.section.radius = kind.section_radius(radius.min(other_radius));
        let length = radius + other_radius;
        let inverse_inertia =
            2.5 / (mass * radius * radius) + 2.5 / (other_mass * other_radius * other_radius);
        let stiffness = bond.section.stiffness(length);
        let strength = given.tensile_strength * bond.section.area();
        let gravity = case.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
        Some(Self {
            name: given.name.clone(),
            radius: bond.section.radius,
            stiffnesses: [stiffness.axial, stiffness.shear, stiffness.bending, stiffness.torsion],
            half_period: bond.half_period(length, reduced_mass(mass, other_mass), inverse_inertia),
            strength,
            weights: (gravity > 0.0).then(|| strength / (mass.min(other_mass) * gravity)),
        })
    }
}

/// Mass (kg) and radius (m), that of the bounding sphere, of the lightest particle, of a material if one is given.
fn lightest(catalogue: &Catalogue, kinds: &[KindRange], material: Option<usize>) -> Option<(f64, f64)> {
    let of_material = kinds.iter().filter(|k| material.is_none_or(|m| usize::from(k.kind.material) == m));
    let sizes = of_material.map(|k| {
        let radius = catalogue.shape(k.kind).bounding_radius * k.smallest;
        (catalogue.mass(k.kind, k.smallest), radius)
    });
    sizes.min_by(|a, b| a.0.total_cmp(&b.0))
}
