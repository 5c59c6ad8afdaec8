//! Whether the values of a checkpoint can be those of a run, before any is used.
//!
//! Checksums tell damage. These checks tell a file whose checksums are right and whose values no run has written.

use crate::insertion::Progress;
use crate::numbering::Numbering;
use crate::restart::{INSERTIONS, SHEAR, WALLS, numbers};
use crate::{heat, liquid, species, wear};
use grains_dem::{CARGO_LENGTH, Dem, FILM_LENGTH, ParticleRecord};
use grains_domain::GlobalBox;
use grains_output::CheckpointFile;
use std::collections::BTreeSet;

/// Identities, and all other counts of a checkpoint, are below this one.
const COUNTS: i64 = 1 << 53;
/// How far a quaternion of a run may be from a unit one.
const OFF_UNIT: f64 = 1e-6;

/// What is wrong with the values of this rank's share of a checkpoint, if anything is.
///
/// # Errors
/// The array or text, and its row.
pub fn check_values(file: &CheckpointFile, dem: &Dem, numbering: &Numbering) -> Result<(), String> {
    let lacking = |e: grains_output::FileError| e.to_string();
    let records = file.real("particle").map_err(lacking)?;
    let rows = records.len() / ParticleRecord::LENGTH;
    if !records.len().is_multiple_of(ParticleRecord::LENGTH) {
        return Err("`particle` has rows of another length".into());
    }
    let mut identities = BTreeSet::new();
    for (row, record) in records.chunks_exact(ParticleRecord::LENGTH).enumerate() {
        let about = |problem: &str| format!("row {row} of `particle` on a rank {problem}");
        check_record(record, &dem.setup.global).map_err(about)?;
        if !identities.insert(record[0] as u64) {
            return Err(format!("`particle` has {} twice", record[0]));
        }
    }
    let lengths = file.integer("memory_length").map_err(lacking)?;
    if lengths.len() != rows || lengths.iter().any(|&length| u32::try_from(length).is_err()) {
        return Err("`memory_length` has no length for each particle".into());
    }
    if dem.particles.is_carrying() && file.has("cargo") {
        check_array(file.real("cargo").map_err(lacking)?, "cargo", rows * CARGO_LENGTH)?;
    }
    if let Some(films) = liquid::saved_films(file) {
        check_array(films, "film", rows * FILM_LENGTH)?;
        if films.iter().any(|volume| *volume < 0.0) {
            return Err("`film` has volumes below zero".into());
        }
    }
    check_array(species::amounts(file), "amounts", rows * species::known(file).len())?;
    check_texts(file)?;
    wear::check(dem, file, |wall| numbering.wall(wall))
}

fn check_record(record: &[f64], domain: &GlobalBox) -> Result<(), &'static str> {
    if record.iter().any(|x| !x.is_finite()) {
        return Err("has values that are not finite");
    }
    let is_whole = |x: f64, end: f64| x >= 0.0 && x < end && x.fract() == 0.0;
    if !is_whole(record[0], COUNTS as f64) || record[1..3].iter().any(|&x| !is_whole(x, 65_536.0)) {
        return Err("has an identity, shape or material that is no whole number");
    }
    let particle = ParticleRecord::read(record);
    if !domain.contains(particle.body.position.into()) {
        return Err("lies outside the domain");
    }
    if particle.body.radius <= 0.0 || particle.body.mass <= 0.0 {
        return Err("has no radius or mass above zero");
    }
    if particle.temperature < 0.0 {
        return Err("has a temperature below zero");
    }
    match (particle.orientation.quaternion().norm() - 1.0).abs() < OFF_UNIT {
        true => Ok(()),
        false => Err("has an orientation that is no unit quaternion"),
    }
}

fn check_array(values: &[f64], name: &str, length: usize) -> Result<(), String> {
    if values.len() != length {
        return Err(format!("`{name}` has {} values, not {length}", values.len()));
    }
    match values.iter().all(|x| x.is_finite()) {
        true => Ok(()),
        false => Err(format!("`{name}` has values that are not finite")),
    }
}

fn check_texts(file: &CheckpointFile) -> Result<(), String> {
    let wrong = |name: &str| format!("its text `{name}` is not one that a run has written");
    for (name, length) in [("step", 1), ("ledger", 2)] {
        let counts = numbers(file, name);
        if counts.len() < length || counts.iter().any(|count| !(0..COUNTS).contains(count)) {
            return Err(wrong(name));
        }
    }
    if !file.text("dt").is_some_and(|text| are_all(text, |dt| dt > 0.0 && dt.is_finite())) {
        return Err(wrong("dt"));
    }
    let volumes = [liquid::QUANTUM, wear::QUANTA];
    for name in [SHEAR, WALLS, liquid::QUANTUM, heat::LEDGER, heat::OF_WALLS, wear::QUANTA] {
        // No temperature is known of some walls.
        let is_right = |x: f64| match name {
            heat::OF_WALLS => !x.is_infinite(),
            _ => x.is_finite() && (x >= 0.0 || !volumes.contains(&name)),
        };
        if file.text(name).is_some_and(|text| !are_all(text, is_right)) {
            return Err(wrong(name));
        }
    }
    let mut progress: Vec<&str> = file.text(INSERTIONS).unwrap_or("").lines().collect();
    let next_id = progress.pop().and_then(|id| id.parse().ok()).filter(|&id| id < COUNTS as u64);
    let is_right = |line: &&str| Progress::parse(line).is_some_and(|made| Some(made.ids().end) <= next_id);
    match next_id.is_some() && progress.iter().all(is_right) {
        true => Ok(()),
        false => Err(wrong(INSERTIONS)),
    }
}

/// Whether all numbers of a text of the bits of numbers are right.
fn are_all(text: &str, is_right: impl Fn(f64) -> bool) -> bool {
    let bits = text.split([' ', ';', '\n']).filter(|word| !word.is_empty());
    let mut numbers = bits.map(|word| u64::from_str_radix(word, 16).map(f64::from_bits));
    numbers.all(|number| number.is_ok_and(&is_right))
}
