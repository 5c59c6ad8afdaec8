//! What the temperatures of particles come to.

use crate::heat;
use crate::insertion::KindRange;
use grains_case::Case;
use grains_dem::DemSetup;

/// Contacts of a particle of which time scales are told.
const CONTACTS: f64 = 12.0;

/// Heat between the particles of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatReport {
    /// Materials whose contacts conduct: their names, 2 k_m (W/(m K)), and the modulus (Pa) that gives the contact radius where it is
    /// not the law that does.
    pub pairs: Vec<([String; 2], f64, Option<f64>)>,
    /// Shortest time m c/(Σ G) (s) in which a particle follows what it touches, with twelve contacts as wide as limits.overlap allows;
    /// none if nothing conducts.
    pub relaxation: Option<f64>,
    /// Time step over that (-): the largest Fourier number of a particle.
    pub fourier: f64,
}

impl HeatReport {
    /// That of a case whose particles have temperatures.
    pub fn of(case: &Case, setup: &DemSetup, kinds: &[KindRange]) -> Option<Self> {
        let thermal = setup.thermal.as_ref()?;
        let name = |material: usize| case.materials[material].name.clone();
        let pairs = case.contacts.iter().filter_map(|contact| {
            let conduction = heat::conduction(case, contact)?;
            Some((contact.between.map(name), conduction.conductivity, conduction.true_modulus))
        });
        let pairs = pairs.collect();
        let rates = kinds.iter().flat_map(|kind| {
            let (material, shape) = (kind.kind.material, setup.catalogue.shape(kind.kind));
            [kind.smallest, kind.largest].map(|scale| {
                let radius = shape.bounding_radius * scale;
                let contact_radius = radius * case.limits.overlap.min(1.0).sqrt();
                let conductances = (0..case.materials.len() as u16).filter_map(|other| {
                    let contact = thermal.conduction(material, other)?.conductance(contact_radius);
                    let lens = thermal.lens.map_or(0.0, |lens| lens.conductance(0.0, [radius; 2], 0.0, 0.0));
                    Some(contact + lens)
                });
                let capacity =
                    setup.catalogue.mass(kind.kind, scale) * thermal.heat_capacities[usize::from(material)];
                CONTACTS * conductances.fold(0.0, f64::max) / capacity
            })
        });
        let rate = rates.fold(0.0, f64::max);
        let fourier = rate * setup.parameters.dt;
        Some(Self { pairs, relaxation: (rate > 0.0).then(|| 1.0 / rate), fourier })
    }
}
