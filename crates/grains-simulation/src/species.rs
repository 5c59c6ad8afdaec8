//! Species that particles contain: which there are, their columns, and their amounts in a checkpoint and back.

use crate::fluid::interned;
use crate::restart::{State, exact_sums, exact_words, reals, words};
use grains_case::{Case, Fluid, ParticleTransfer, Scalar};
use grains_comm::MpiTransport;
use grains_dem::{Dem, Species, SpeciesContent, SpeciesLedger};
use grains_domain::{ExactSum, sum_exact};
use grains_output::{Array, CheckpointFile, FieldSpec, Values};

/// Array of a checkpoint: the amounts of all species of each particle.
const AMOUNTS: &str = "amounts";
/// Text of a checkpoint: a line per species, its ledger and its name.
const LEDGERS: &str = "species";
/// The same: a line per species, the words of the sums of its ledger.
const EXACT: &str = "species_words";

/// Species in the particles of a case: the scalars of the fluid that they keep some of, and what the fluid tells of those that resolved
/// particles exchange with it.
pub fn all(case: &Case) -> Vec<Species> {
    let Some(fluid) = &case.fluid else { return Vec::new() };
    let of = |scalar: &Scalar| {
        let kept = scalar.particles.as_ref().and_then(ParticleTransfer::initial);
        let kept =
            kept.map(|initial| Species { name: scalar.name.clone(), unit: "-", initial, is_told: false });
        let told = told(fluid, scalar).into_iter().map(|(what, unit)| Species {
            name: format!("{}_{what}", scalar.name),
            unit,
            initial: 0.0,
            is_told: true,
        });
        kept.into_iter().chain(told).collect::<Vec<_>>()
    };
    fluid.scalar.iter().flat_map(of).collect()
}

/// What the fluid tells resolved particles of a scalar, with units: the flow into each, with the heat that one has not taken yet; or what
/// one in which it diffuses holds, and what reacts there.
pub fn told(fluid: &Fluid, scalar: &Scalar) -> Vec<(&'static str, &'static str)> {
    let [unit, of_content] = scalar.units();
    let of_flow = if unit == "K" { "W" } else { "1/s" };
    match (&fluid.resolved, &scalar.particles) {
        (Some(_), Some(particles)) if particles.inside.is_some() => {
            vec![("content", of_content), ("reaction", of_flow)]
        }
        (Some(_), Some(particles)) if particles.uniform => vec![("flow", of_flow), ("due", of_content)],
        (Some(_), Some(_)) => vec![("flow", of_flow)],
        _ => Vec::new(),
    }
}

/// Fields of the particle snapshots.
pub fn fields(case: &Case) -> impl Iterator<Item = FieldSpec> {
    all(case).into_iter().map(|species| FieldSpec::real(interned(field_name(&species)), species.unit, 1))
}

/// Name of the field of a species.
pub fn field_name(species: &Species) -> String {
    if species.is_told { species.name.clone() } else { format!("{}_amount", species.name) }
}

/// Names of the columns of the time series.
pub fn columns(dem: &Dem) -> impl Iterator<Item = (String, &'static str)> + '_ {
    const COLUMNS: [&str; 7] = ["content", "min", "max", "inserted", "left", "from_fluid", "unaccounted"];
    let of = |species: &Species| COLUMNS.map(|what| (format!("particle_{}_{what}", species.name), "-"));
    dem.setup.species.iter().filter(|species| !species.is_told).flat_map(of)
}

/// Values of these columns; collective.
pub fn row(dem: &Dem, transport: &MpiTransport) -> Vec<f64> {
    let of = |found: SpeciesContent| {
        let (SpeciesContent { content, ends: [min, max], ledger }, lost) = (found, found.unaccounted());
        [content, min, max, ledger[0], ledger[1], ledger[2], lost]
    };
    let found = dem.species(transport).into_iter().zip(&dem.setup.species);
    found.filter(|(_, species)| !species.is_told).flat_map(|(found, _)| of(found)).collect()
}

/// Adds the amounts to a checkpoint, if particles contain species.
pub fn save(dem: &Dem, (arrays, texts): &mut State, transport: &MpiTransport) {
    let species = &dem.setup.species;
    if species.is_empty() {
        return;
    }
    let values = Values::Real(dem.particles.amounts.clone());
    arrays.push(Array { name: AMOUNTS, unit: "-", width: species.len(), values });
    let mut sums: Vec<ExactSum> = dem.species_ledgers.iter().flat_map(SpeciesLedger::sums).collect();
    sum_exact(&mut sums, transport);
    let line = |(species, ledger): (&Species, &[ExactSum; 3])| {
        format!("{} {}", words(&ledger.map(|sum| sum.total())), species.name)
    };
    let lines: Vec<String> = species.iter().zip(sums.as_chunks().0).map(line).collect();
    texts.push((LEDGERS.into(), lines.join("\n")));
    let exact: Vec<String> = sums.as_chunks::<3>().0.iter().map(|ledger| exact_words(ledger)).collect();
    texts.push((EXACT.into(), exact.join("\n")));
}

/// Species of a checkpoint: their names and ledgers, in the order of the amounts of its particles.
pub fn known(file: &CheckpointFile) -> Vec<(String, SpeciesLedger)> {
    let mut exact = file.text(EXACT).unwrap_or("").lines();
    let line = |line: &str| {
        let mut words = line.splitn(4, ' ');
        let numbers: Vec<String> = words.by_ref().take(3).map(String::from).collect();
        let sums = exact_sums(&reals(&numbers.join(" "))?, exact.next().unwrap_or(""));
        Some((words.next()?.to_string(), SpeciesLedger::from_sums(sums.try_into().ok()?)))
    };
    file.text(LEDGERS).unwrap_or("").lines().filter_map(line).collect()
}

/// Amounts of the particles of a checkpoint; none without species.
pub fn amounts(file: &CheckpointFile) -> &[f64] {
    if file.has(AMOUNTS) { file.real(AMOUNTS).unwrap_or_default() } else { &[] }
}

/// Gives the particle restored last the amounts (of the species of a checkpoint) that the case knows too; others are as in particles
/// that are inserted.
pub fn restore_last(dem: &mut Dem, known: &[(String, SpeciesLedger)], amounts: &[f64]) {
    dem.fill_last();
    for ((name, _), amount) in known.iter().zip(amounts) {
        if let Some(number) = dem.setup.species.iter().position(|species| species.name == *name) {
            dem.restore_amount(number, *amount);
        }
    }
}

/// Gives the first rank the ledgers of a checkpoint.
pub fn restore_ledgers(dem: &mut Dem, known: &[(String, SpeciesLedger)]) {
    for (name, ledger) in known {
        if let Some(number) = dem.setup.species.iter().position(|species| species.name == *name) {
            dem.species_ledgers[number].add(ledger);
        }
    }
}
