//! What the temperatures of particles come to.

use crate::heat;
use crate::insertion::KindRange;
use grains_case::Case;
use grains_dem::DemSetup;

/// Heat between the particles of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatReport {
    /// Materials whose contacts conduct: their names, 2 k_m (W/(m K)), and the modulus (Pa) that gives the contact radius where it is
    /// not the law that does.
    pub pairs: Vec<([String; 2], f64, Option<f64>)>,
    /// Shortest time m c/(Σ G) (s) in which a particle follows what it touches, with twelve contacts as wide as limits.overlap allows;
    /// none if nothing conducts.
    pub relaxation: Option<f64>,
    /// Time steps from one evaluation to the next.
    pub every: u64,
    /// The time of these over that (-): the largest Fourier number of a particle.
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
        let rate = heat::largest_rate(case, &setup.catalogue, thermal, kinds);
        let fourier = rate * setup.parameters.dt * thermal.every as f64;
        Some(Self { pairs, every: thermal.every, relaxation: (rate > 0.0).then(|| 1.0 / rate), fourier })
    }
}
