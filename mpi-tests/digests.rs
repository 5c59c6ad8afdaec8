//! Damage to files of snapshots is noticed wherever it is, and many snapshots cost no more than few.

#![allow(clippy::unwrap_used)]

mod grids;
mod ranks;

use grains_comm::Job;
use grains_output::{
    Data, FieldSpec, FileError, GridFile, GridGeometry, GridSnapshotFile, Metadata, PolyDataFile, Precision,
    SnapshotFile, Step,
};
use grids::{folder, rank};
use mpi::topology::SimpleCommunicator;
use ranks::on_ranks;
use std::fs;
use std::path::Path;

const SPECS: [FieldSpec; 3] =
    [FieldSpec::integer("id"), FieldSpec::real("radius", "m", 1), FieldSpec::real("velocity", "m/s", 3)];

fn metadata() -> Metadata {
    let case = "name = \"damaged\"\n# Ångström, µm\n".repeat(40);
    vec![("program".into(), "test".into()), ("case".into(), case)]
}

/// A value of a particle, which is the same on any ranks.
fn value(step: usize, place: usize) -> f64 {
    (0.1 + 0.37 * place as f64 + 1.3 * step as f64).sin()
}

/// Appends a step of some particles, dealt to the ranks in uneven parts; one of them has no number for a radius.
fn append(file: &mut PolyDataFile, step: usize, particles: usize, job: &Job) {
    let (rank, size) = (rank(job), job.size());
    let own =
        (particles * rank * rank / (size * size))..(particles * (rank + 1) * (rank + 1) / (size * size));
    let values = |width: usize| -> Vec<f64> {
        own.clone().flat_map(|k| (0..width).map(move |c| value(step, 3 * k + c))).collect()
    };
    let mut radii = values(1);
    if own.contains(&5) {
        radii[5 - own.start] = f64::NAN;
    }
    let (points, velocities) = (values(3), values(3));
    let ids: Vec<i64> = own.map(|k| (7 * k) as i64).collect();
    let fields = [Data::Integer(&ids), Data::Real(&radii), Data::Real(&velocities)];
    let step = Step { time: 0.1 * step as f64, points: &points, triangles: &[], fields: &fields };
    file.append(&step).unwrap();
}

/// Everything that is read back of a file of particles, its bits as text.
fn particles_of(path: &Path, communicator: &SimpleCommunicator) -> Result<Vec<String>, FileError> {
    let file = SnapshotFile::open(path, communicator)?;
    let bits = |values: Vec<f64>| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    let mut found = vec![format!("{:?} {:?}", file.fields(), bits(file.times()))];
    found.extend(["program", "case"].map(|name| format!("{:?}", file.text(name))));
    for step in 0..file.times().len() {
        found.push(format!("{:?} {:?}", bits(file.points(step)?), file.integer(step, "id")?));
        found.push(format!(
            "{:?} {:?}",
            bits(file.real(step, "radius")?),
            bits(file.real(step, "velocity")?)
        ));
    }
    Ok(found)
}

fn grid(job: &Job) -> GridGeometry {
    let axis = |n: usize, width: f64| (0..=n).map(|k| width * (k as f64).powf(1.2)).collect();
    let nodes = [axis(5, 0.1), axis(4, 0.3), axis(6, 0.2)];
    let (first, last) = (6 * rank(job) / job.size(), 6 * (rank(job) + 1) / job.size());
    GridGeometry { nodes, first: [0, 0, first], own: [5, 4, last - first] }
}

/// Everything that is read back of a file of cells.
fn cells_of(
    path: &Path,
    communicator: &SimpleCommunicator,
    own: &GridGeometry,
) -> Result<Vec<String>, FileError> {
    let file = GridSnapshotFile::open(path, communicator)?;
    let mut found = vec![format!("{:?} {:?} {:?}", file.fields(), file.times(), file.nodes())];
    for step in 0..file.times().len() {
        for field in ["pressure", "velocity"] {
            file.verify(step, field, communicator)?;
            found.push(format!("{:?}", file.block(step, field, &own.block())?));
        }
    }
    Ok(found)
}

/// Flips single bits all over a file, more of them near its beginning and in its metadata; what is read then is what was
/// written, or nothing.
fn assert_damage_is_noticed<T: PartialEq>(path: &Path, read: impl Fn(&Path) -> Result<T, FileError>) {
    let whole = read(path).unwrap();
    let bytes = fs::read(path).unwrap();
    let damaged = path.with_extension("damaged");
    let (mut refused, mut flips) = (0, 0);
    let mut state = 12_345_u64;
    for flip in 0..FLIPS {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let at = (state >> 20) as usize % bytes.len();
        // Bytes that hold something: chunks are mostly room for later steps.
        let Some(at) = (at..bytes.len()).find(|&k| bytes[k] != 0 && bytes[k] != 255) else { continue };
        let bit = flip % 8;
        let mut copy = bytes.clone();
        copy[at] ^= 1 << bit;
        fs::write(&damaged, &copy).unwrap();
        flips += 1;
        match read(&damaged) {
            Ok(found) => assert!(
                found == whole,
                "bit {bit} of byte {at} of {}: read as if nothing were",
                path.display()
            ),
            Err(error) => {
                let text = error.to_string();
                assert!(text.contains("damaged"), "the file is named: {text}");
                refused += 1;
            }
        }
    }
    println!("measured: {refused} of {flips} flips refused, the others without effect");
    assert!(refused > flips / 20, "{refused} of {flips} refused");
}

const FLIPS: usize = 600;

#[test]
fn a_flipped_bit_of_particles_is_noticed() {
    on_ranks(&[1], "a_flipped_bit_of_particles_is_noticed", |job| {
        let folder = folder(job, "digests-particles");
        for (name, format) in [("plain", (Precision::F64, false)), ("short", (Precision::F32, true))] {
            let path = folder.join(format!("{name}.vtkhdf"));
            let mut file =
                PolyDataFile::create(&path, job.world(), &SPECS, false, format, &metadata()).unwrap();
            (0..3).for_each(|step| append(&mut file, step, 20, job));
            drop(file);
            assert_damage_is_noticed(&path, |path| particles_of(path, job.world()));
        }
    });
}

#[test]
fn a_flipped_bit_of_cells_is_noticed() {
    on_ranks(&[1], "a_flipped_bit_of_cells_is_noticed", |job| {
        let (path, grid) = (folder(job, "digests-cells").join("fluid.vtkhdf"), grid(job));
        let specs = [FieldSpec::real("pressure", "Pa", 1), FieldSpec::real("velocity", "m/s", 3)];
        let format = (Precision::F64, false);
        let mut file = GridFile::create(&path, job.world(), &grid, &specs, format, &metadata()).unwrap();
        for step in 0..2 {
            let values: Vec<f64> = (0..360).map(|k| value(step, k)).collect();
            file.append(step as f64, &[Data::Real(&values[..120]), Data::Real(&values)]).unwrap();
        }
        drop(file);
        assert_damage_is_noticed(&path, |path| cells_of(path, job.world(), &grid));
    });
}

#[test]
fn checksums_do_not_depend_on_ranks_and_survive_a_restart() {
    on_ranks(&[1, 3, 4], "checksums_do_not_depend_on_ranks_and_survive_a_restart", |job| {
        let world = job.world();
        let folder = folder(job, "digests-ranks");
        for (name, format) in [("plain", (Precision::F64, false)), ("short", (Precision::F32, true))] {
            let path = folder.join(format!("{name}.vtkhdf"));
            let mut file = PolyDataFile::create(&path, world, &SPECS, false, format, &metadata()).unwrap();
            (0..6).for_each(|step| append(&mut file, step, 17 * (step % 3), job));
            drop(file);
            // Steps 4 and 5 are forgotten; 3 is replaced, 4 comes again with other particles.
            let mut file = PolyDataFile::resume(&path, world, &SPECS, false, format.0, 0.3).unwrap();
            file.record_restart(&metadata()).unwrap();
            append(&mut file, 3, 9, job);
            append(&mut file, 4, 40, job);
            drop(file);
            let found = particles_of(&path, world).unwrap();
            assert_eq!(found.len(), 3 + 2 * 5);
            // As shares that are read one after the other.
            for k in 0..3 {
                let share = SnapshotFile::open_share(&path, (k, 3)).unwrap();
                assert_eq!(share.points(4).unwrap().len(), 3 * (40 * (k + 1) / 3 - 40 * k / 3));
            }
        }
    });
}

/// Bytes written by this process, and its memory (bytes).
fn written_and_held() -> (u64, u64) {
    let number = |file: &str, word: &str| {
        let text = fs::read_to_string(file).unwrap();
        let line = text.lines().find(|line| line.starts_with(word)).unwrap().to_string();
        line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap()
    };
    (number("/proc/self/io", "wchar:"), 1024 * number("/proc/self/status", "VmRSS:"))
}

#[test]
fn the_thousandth_snapshot_costs_no_more_than_the_tenth() {
    on_ranks(&[1], "the_thousandth_snapshot_costs_no_more_than_the_tenth", |job| {
        let path = folder(job, "digests-growth").join("particles.vtkhdf");
        let format = (Precision::F64, false);
        let mut file = PolyDataFile::create(&path, job.world(), &SPECS, false, format, &metadata()).unwrap();
        let count = std::env::var("SNAPSHOTS").map_or(4000, |text| text.parse().unwrap());
        let mut marks = Vec::new();
        for step in 0..count {
            if step % (count / 4) == 0 {
                marks.push(written_and_held());
            }
            append(&mut file, step, 10, job);
        }
        marks.push(written_and_held());
        let quarters: Vec<(u64, i64)> =
            marks.windows(2).map(|w| (w[1].0 - w[0].0, w[1].1 as i64 - w[0].1 as i64)).collect();
        println!("measured: bytes written and kept in each quarter of {count} snapshots: {quarters:?}");
        // The last against the second: the first fills buffers.
        assert!(quarters[3].0 < quarters[1].0 + quarters[1].0 / 20, "writing grows: {quarters:?}");
        // The text of a snapshot has some 3000 bytes here.
        assert!(quarters[3].1 < 500 * (count as i64 / 4), "memory grows: {quarters:?}");
    });
}
