//! Temperatures of a case: what they depend on, their columns, and the heat ledger in a checkpoint and back.

use crate::insertion::KindRange;
use crate::restart::{State, exact_sums, exact_words, reals, words};
use grains_case::{Case, Contact, Material};
use grains_comm::MpiTransport;
use grains_contact::{Conduction, Elastic, GasLens, effective_modulus};
use grains_dem::{Catalogue, Dem, Heat, HeatLedger, Thermal, Wall, WallHeat};
use grains_domain::sum_exact;
use grains_output::CheckpointFile;

/// Text of a checkpoint: the ledger (J), then the heat from each wall (W).
pub const LEDGER: &str = "heat";

/// The same: the words of the sums of the ledger.
const EXACT: &str = "heat_words";

/// The same: the temperature of each wall (K).
pub const OF_WALLS: &str = "wall_temperatures";

/// What the temperatures of the particles of a case depend on, if they have one.
pub fn thermal(case: &Case, catalogue: &Catalogue) -> Option<Thermal> {
    let heat = case.heat.as_ref()?;
    let lens = heat.gas.map(|gas| GasLens {
        conductivity: gas.conductivity,
        thickness: gas.thickness,
        smallest_gap: gas.smallest_gap,
    });
    let surroundings = heat.radiation.map(|radiation| radiation.surroundings);
    let mut thermal = Thermal::new(case.materials.len(), lens, surroundings);
    let each = |of: fn(&Material) -> Option<f64>| -> Vec<f64> {
        case.materials.iter().map(|material| of(material).unwrap_or(0.0)).collect()
    };
    thermal.heat_capacities = each(|material| material.heat_capacity);
    thermal.emissivities = each(|material| material.emissivity);
    thermal.sources = each(|material| material.heat_source);
    if heat.gas.is_some_and(|gas| gas.through_solid) {
        thermal.conductivities =
            case.materials.iter().map(|m| m.conductivity.unwrap_or(f64::INFINITY)).collect();
    }
    let is_used = |shape: usize| case.inserts.iter().flat_map(|i| &i.particles).any(|p| p.shape == shape);
    thermal.areas = catalogue
        .shapes
        .iter()
        .enumerate()
        .map(|(k, shape)| if is_used(k) { shape.area() } else { 0.0 })
        .collect();
    for contact in &case.contacts {
        if let Some(conduction) = conduction(case, contact) {
            thermal.set_conduction(contact.between, conduction);
        }
    }
    Some(thermal)
}

/// Contacts of a particle of which time scales are told.
const CONTACTS: f64 = 12.0;
/// Largest Fourier number (-) and steps from one evaluation of the heat to the next, where the case does not say.
const SMALL: f64 = 0.01;
const SELDOM: u64 = 5;

/// Largest rate Σ G/(m c) (1/s) at which particles of some kinds follow what they touch: of twelve contacts as wide as limits.overlap
/// allows.
pub(crate) fn largest_rate(
    case: &Case,
    catalogue: &Catalogue,
    thermal: &Thermal,
    kinds: &[KindRange],
) -> f64 {
    let of_kind = |kind: &KindRange| {
        let (material, shape) = (kind.kind.material, catalogue.shape(kind.kind));
        [kind.smallest, kind.largest].map(|scale| {
            let radius = shape.bounding_radius * scale;
            let contact_radius = radius * case.limits.overlap.min(1.0).sqrt();
            let conductances = (0..case.materials.len() as u16).filter_map(|other| {
                let contact = thermal.conduction(material, other)?.conductance(contact_radius);
                let lens = thermal.lens.map_or(0.0, |lens| lens.conductance(0.0, [radius; 2], 0.0, 0.0));
                Some(contact + lens)
            });
            let capacity = catalogue.mass(kind.kind, scale) * thermal.heat_capacities[usize::from(material)];
            CONTACTS * conductances.fold(0.0, f64::max) / capacity
        })
    };
    kinds.iter().flat_map(of_kind).fold(0.0, f64::max)
}

/// Steps of `dt` (s) from one evaluation of the heat to the next.
pub fn interval(case: &Case, rate: f64, dt: f64) -> u64 {
    let given = case.heat.as_ref().and_then(|heat| heat.every);
    given.unwrap_or_else(|| ((SMALL / (rate * dt)) as u64).clamp(1, SELDOM))
}

/// How two materials that touch conduct heat, if both do.
pub(crate) fn conduction(case: &Case, contact: &Contact) -> Option<Conduction> {
    let pair = contact.between.map(|material| &case.materials[material]);
    let [a, b] = pair.map(|material| material.conductivity);
    Some(Conduction::between(a?, b?, true_modulus(contact, pair)))
}

/// Effective modulus (Pa) of two materials as they are, where their law is softer than that or knows none.
fn true_modulus(contact: &Contact, pair: [&Material; 2]) -> Option<f64> {
    let elastic = pair.map(|material| {
        Some(Elastic { youngs_modulus: material.youngs_modulus?, poissons_ratio: material.poissons_ratio? })
    });
    let of_materials = || Some(effective_modulus(elastic[0]?, elastic[1]?));
    let is_as_it_is = contact.softening == 1.0 && contact.normal_stiffness.is_none();
    if is_as_it_is { None } else { contact.effective_modulus.or_else(of_materials) }
}

/// Temperature (K) of the particles of an insertion that no file tells.
pub fn initial(case: &Case, of_insert: Option<f64>) -> f64 {
    of_insert.or(case.heat.as_ref().map(|heat| heat.temperature)).unwrap_or(0.0)
}

/// Names and units of the columns of the time series.
pub fn columns(dem: &Dem) -> Vec<(String, &'static str)> {
    const FIXED: [(&str, &str); 11] = [
        ("temperature_mean", "K"),
        ("temperature_min", "K"),
        ("temperature_max", "K"),
        ("heat_content", "J"),
        ("heat_inserted", "J"),
        ("heat_left", "J"),
        ("heat_from_walls", "J"),
        ("heat_from_radiation", "J"),
        ("heat_produced", "J"),
        ("heat_from_fluid", "J"),
        ("heat_unaccounted", "J"),
    ];
    if dem.setup.thermal.is_none() {
        return Vec::new();
    }
    let fixed = FIXED.iter().map(|&(name, unit)| (format!("particle_{name}"), unit));
    let of_walls = dem.setup.walls.iter().flat_map(|wall| {
        let flow = wall.heat.map(|_| (format!("{}_heat_flow", wall.name), "W"));
        flow.into_iter().chain(is_heated(wall).then(|| (format!("{}_temperature", wall.name), "K")))
    });
    fixed.chain(of_walls).collect()
}

/// Values of these columns; collective.
pub fn row(dem: &Dem, transport: &MpiTransport) -> Vec<f64> {
    let Some(heat) = dem.heat(transport) else { return Vec::new() };
    let Heat { mean, ends, content, ledger } = heat;
    let mut row = vec![mean, ends[0], ends[1], content];
    row.extend(ledger);
    row.push(heat.unaccounted());
    let flows = dem.wall_heat(transport);
    let walls = dem.setup.walls.iter().zip(flows).zip(dem.wall_temperatures());
    row.extend(walls.flat_map(|((wall, flow), &temperature)| {
        let flow = wall.heat.map(|_| flow);
        flow.into_iter().chain(is_heated(wall).then_some(temperature))
    }));
    row
}

/// Whether a wall has a given heat, from which its temperature follows.
fn is_heated(wall: &Wall) -> bool {
    matches!(wall.heat, Some(WallHeat::Power(_)))
}

/// Adds the ledger to a checkpoint, if particles have temperatures.
pub fn save(dem: &Dem, (_, texts): &mut State, transport: &MpiTransport) {
    if dem.setup.thermal.is_some() {
        let mut sums = dem.heat_ledger.sums();
        sum_exact(&mut sums, transport);
        let flows = dem.wall_heat(transport);
        texts.push((LEDGER.into(), words(&[&sums.map(|sum| sum.total())[..], &flows].concat())));
        texts.push((EXACT.into(), exact_words(&sums)));
        texts.push((OF_WALLS.into(), words(dem.wall_temperatures())));
    }
}

/// Temperature of each wall of a checkpoint (K), NaN where none is known.
pub fn wall_temperatures(file: &CheckpointFile) -> Vec<f64> {
    file.text(OF_WALLS).and_then(reals).unwrap_or_default()
}

/// The ledger of a checkpoint, and the heat from each of its walls (W); none if its particles had no temperatures.
pub fn ledger(file: &CheckpointFile) -> Option<(HeatLedger, Vec<f64>)> {
    let numbers = reals(file.text(LEDGER)?)?;
    let (ledger, walls) = numbers.split_at_checked(6)?;
    let sums = exact_sums(ledger, file.text(EXACT).unwrap_or(""));
    Some((HeatLedger::from_sums(sums.try_into().ok()?), walls.to_vec()))
}
