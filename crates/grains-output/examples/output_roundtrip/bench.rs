//! Time of an append of 100 000 particles with the fields of a usual snapshot.

use grains_output::{
    Array, CheckpointFile, Data, FieldSpec, Kind, PolyDataFile, Precision, Step, Values, write_checkpoint,
};
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives};
use std::path::Path;
use std::time::Instant;

const PARTICLES: usize = 100_000;
const STEPS: usize = 10;

const fn field(name: &'static str, components: usize, kind: Kind) -> FieldSpec {
    FieldSpec { name, unit: "-", components, kind }
}

const FIELDS: [FieldSpec; 10] = [
    field("id", 1, Kind::Integer),
    field("shape", 1, Kind::Integer),
    field("material", 1, Kind::Integer),
    field("coordination", 1, Kind::Integer),
    field("scale", 1, Kind::Real),
    field("orientation_wxyz", 4, Kind::Real),
    field("velocity", 3, Kind::Real),
    field("angular_velocity", 3, Kind::Real),
    field("force", 3, Kind::Real),
    field("torque", 3, Kind::Real),
];

/// Prints seconds per append of each format, and of a checkpoint.
pub fn bench(directory: &Path, world: &SimpleCommunicator) {
    let own = PARTICLES / world.size() as usize;
    let integers: Vec<i64> = (0..own as i64).collect();
    let reals: Vec<f64> = (0..4 * own).map(|k| (k as f64).sin()).collect();
    let fields: Vec<Data> = FIELDS
        .iter()
        .map(|spec| match spec.kind {
            Kind::Integer => Data::Integer(&integers),
            Kind::Real => Data::Real(&reals[..own * spec.components]),
        })
        .collect();
    for (name, format) in [
        ("f64", (Precision::F64, false)),
        ("f32", (Precision::F32, false)),
        ("f64, deflate", (Precision::F64, true)),
    ] {
        let path = directory.join("bench.vtkhdf");
        let mut file =
            PolyDataFile::create(&path, world, &FIELDS, false, format, &Vec::new()).expect("a file");
        for particles in [own, 0] {
            world.barrier();
            let begun = Instant::now();
            for step in 0..STEPS {
                let fields: Vec<Data> = fields
                    .iter()
                    .zip(&FIELDS)
                    .map(|(data, spec)| cut(data, particles * spec.components))
                    .collect();
                let time = file.steps() as f64 + step as f64 * 1e-3;
                let points = &reals[..3 * particles];
                file.append(&Step { time, points, triangles: &[], fields: &fields }).expect("a step");
            }
            let milliseconds = 1e3 * begun.elapsed().as_secs_f64() / STEPS as f64;
            if world.rank() == 0 {
                println!(
                    "{name}: {milliseconds:.1} ms per append of {} particles",
                    particles * world.size() as usize
                );
            }
        }
        drop(file);
        if world.rank() == 0 {
            let bytes = std::fs::metadata(&path).map_or(0, |m| m.len());
            println!("{name}: {:.2} MB per step of {PARTICLES}", bytes as f64 / 1e6 / STEPS as f64);
        }
    }
    let state = Values::Real((0..own * 30).map(|k| k as f64).collect());
    let arrays = [Array { name: "particle", unit: "SI", width: 30, values: state }];
    let begun = Instant::now();
    let path = write_checkpoint(directory, 1, world, &arrays, &Vec::new()).expect("a checkpoint");
    let written = begun.elapsed().as_secs_f64();
    CheckpointFile::read(&path, world).expect("it is valid");
    let read = begun.elapsed().as_secs_f64() - written;
    if world.rank() == 0 {
        println!("checkpoint of {PARTICLES} x 30: {:.1} ms write, {:.1} ms read", 1e3 * written, 1e3 * read);
    }
}

fn cut<'a>(data: &Data<'a>, length: usize) -> Data<'a> {
    match data {
        Data::Real(values) => Data::Real(&values[..length]),
        Data::Integer(values) => Data::Integer(&values[..length]),
    }
}
