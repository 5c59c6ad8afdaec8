//! The files of a run.

use hdf5::File;
use std::fs;
use std::path::{Path, PathBuf};

/// Values per particle in a checkpoint.
const COLUMNS: usize = 26;

/// Checkpoints of a folder, oldest first.
pub fn checkpoints(folder: &Path) -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap_or_else(|e| panic!("{}: {e}", folder.display()))
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "h5"))
        .collect();
    found.sort();
    found
}

/// Step of a checkpoint.
pub fn step_of(checkpoint: &Path) -> u64 {
    let name = checkpoint.file_stem().unwrap().to_str().unwrap();
    name.rsplit('-').next().unwrap().parse().unwrap()
}

/// One particle of a checkpoint.
#[derive(Clone, Debug, PartialEq)]
pub struct Particle {
    pub id: u64,
    /// Bits of all columns.
    pub state: Vec<u64>,
    /// Bits of what its contacts remember, one list per contact; a contact begins with its partner.
    pub memory: Vec<Vec<u64>>,
}

/// Numbers that a law keeps of a contact beside its tangential displacement.
const OF_LAW: usize = 6;

/// Numbers of a bond: partner, kind, and state.
const OF_BOND: usize = 9;

/// Contacts in the packed memory of a particle, in an order that does not depend on neighbour lists:
/// counts of sphere, body and wall contacts, then for each its key, tangential displacement and (not for spheres) torsional
/// angle and simplex. A negative count of spheres, or 16 added to the points of a simplex, says that the numbers
/// of the law follow; a negative count of walls, less one, that bonds do.
fn contacts(packed: &[f64]) -> Vec<Vec<u64>> {
    let (counts, mut rest) = packed.split_at(3);
    let mut contacts = Vec::new();
    for (kind, &count) in counts.iter().enumerate() {
        let count = if kind == 2 && count < 0.0 { -1.0 - count } else { count };
        for _ in 0..count.abs() as usize {
            let fixed = [4, 7, 9][kind];
            let length = if kind == 0 {
                fixed + if count < 0.0 { OF_LAW } else { 0 }
            } else {
                let points = rest[fixed] as usize;
                fixed + 1 + 6 * (points % 16) + OF_LAW * (points / 16)
            };
            let (contact, after) = rest.split_at(length);
            contacts.push([&[kind as u64], &*bits(contact)].concat());
            rest = after;
        }
    }
    if counts[2] < 0.0 {
        let (count, bonds) = rest.split_at(1);
        assert_eq!(bonds.len(), OF_BOND * count[0] as usize, "bonds in the packed memory");
        contacts.extend(bonds.chunks_exact(OF_BOND).map(|bond| [&[3], &*bits(bond)].concat()));
        rest = &[];
    }
    assert!(rest.is_empty(), "the packed memory has another form");
    contacts.sort();
    contacts
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|x| x.to_bits()).collect()
}

/// Particles of a checkpoint in the order of their ids.
pub fn state(checkpoint: &Path) -> Vec<Particle> {
    let read = || -> hdf5::Result<Vec<Particle>> {
        let file = File::open(checkpoint)?;
        let rows = file.dataset("state/particle")?.read_raw::<f64>()?;
        let lengths = file.dataset("state/memory_length")?.read_raw::<i64>()?;
        let memory = file.dataset("state/memory")?.read_raw::<f64>()?;
        let films = file.dataset("state/film").and_then(|films| films.read_raw::<f64>()).unwrap_or_default();
        let mut films = films.chunks_exact(4);
        let mut rest = &memory[..];
        let particles = rows.chunks_exact(COLUMNS).zip(lengths).map(|(row, length)| {
            let (own, after) = rest.split_at(length as usize);
            rest = after;
            let state = [bits(row), bits(films.next().unwrap_or_default())].concat();
            Particle { id: row[0] as u64, state, memory: contacts(own) }
        });
        Ok(particles.collect())
    };
    let mut particles = read().unwrap_or_else(|e| panic!("{}: {e}", checkpoint.display()));
    particles.sort_by_key(|p| p.id);
    particles
}

/// Asserts that two checkpoints hold the same particles, bit for bit.
pub fn assert_same_state(wanted: &Path, found: &Path) {
    let (wanted_state, found_state) = (state(wanted), state(found));
    let place = format!("{} against {}", found.display(), wanted.display());
    assert!(!wanted_state.is_empty(), "{place}: particles are left to compare");
    let ids = |particles: &[Particle]| particles.iter().map(|p| p.id).collect::<Vec<_>>();
    assert_eq!(ids(&wanted_state), ids(&found_state), "{place}: ids");
    for (a, b) in wanted_state.iter().zip(&found_state) {
        for (column, (x, y)) in a.state.iter().zip(&b.state).enumerate() {
            let values = (f64::from_bits(*x), f64::from_bits(*y));
            assert_eq!(x, y, "{place}: particle {}, column {column}: {values:?}", a.id);
        }
        assert_eq!(a.memory, b.memory, "{place}: memory of particle {}", a.id);
    }
}

/// The time series of a folder.
pub struct Series {
    pub columns: Vec<String>,
    pub rows: Vec<Vec<f64>>,
}

/// Reads the time series of a folder.
pub fn series(folder: &Path) -> Series {
    let text = fs::read_to_string(folder.join("series.csv")).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let columns: Vec<String> = lines.next().unwrap().split(',').map(String::from).collect();
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    assert!(rows.iter().all(|row| row.len() == columns.len()), "a value per column");
    Series { columns, rows }
}

impl Series {
    /// Values of a column.
    pub fn column(&self, name: &str) -> Vec<f64> {
        let index = self.columns.iter().position(|c| c == name).unwrap_or_else(|| panic!("column {name}"));
        self.rows.iter().map(|row| row[index]).collect()
    }

    /// Last step, 0 if there is no row.
    pub fn last_step(&self) -> u64 {
        self.rows.last().map_or(0, |row| row[0] as u64)
    }
}

/// Last complete step in a series that is being written, 0 if there is none.
pub fn last_step(folder: &Path) -> u64 {
    let text = fs::read_to_string(folder.join("series.csv")).unwrap_or_default();
    let rows = text.split_inclusive('\n').filter(|line| line.ends_with('\n'));
    rows.filter_map(|row| row.split(',').next()?.parse().ok()).next_back().unwrap_or(0)
}

/// Asserts that two series are equal in every bit, but for the stress of a sheared box, which is summed rank by rank: to 1e-12 of the
/// largest normal stress or temperature. `deep_penetrations` counts the work of the ranks, of which two may share a pair.
pub fn assert_same_series(wanted: &Series, found: &Series) {
    assert_eq!(wanted.columns, found.columns);
    let steps = |series: &Series| series.column("step");
    assert_eq!(steps(wanted), steps(found), "steps of the series");
    for name in wanted.columns.iter().filter(|name| *name != "deep_penetrations") {
        let (a, b) = (wanted.column(name), found.column(name));
        let largest = |name: &str| wanted.column(name).iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let tolerance = match name {
            name if name.contains("stress_") => 1e-12 * largest("stress_xx"),
            name if name.contains("granular_temperature") => 1e-12 * largest(name),
            _ => 0.0,
        };
        for ((x, y), step) in a.iter().zip(&b).zip(steps(wanted)) {
            let are_equal = (x - y).abs() <= tolerance || x.is_nan() && y.is_nan();
            assert!(are_equal, "column {name} at step {step}: {x:?} instead of {y:?}");
        }
    }
}

/// Times (s) and numbers of points of the snapshots in a file.
pub fn snapshots(file: &Path) -> (Vec<f64>, Vec<i64>) {
    let read = || -> hdf5::Result<(Vec<f64>, Vec<i64>)> {
        let root = File::open(file)?.group("VTKHDF")?;
        let steps = root.group("Steps")?.attr("NSteps")?.read_scalar::<i64>()? as usize;
        let mut times = root.dataset("Steps/Values")?.read_raw::<f64>()?;
        let mut counts = root.dataset("NumberOfPoints")?.read_raw::<i64>()?;
        times.truncate(steps);
        counts.truncate(steps);
        Ok((times, counts))
    };
    read().unwrap_or_else(|e| panic!("{}: {e}", file.display()))
}
