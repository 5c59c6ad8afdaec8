//! What a run will take: memory and disk. Sizes are those of the arrays, or measured where libraries share in them;
//! `mpi-tests/check.rs` compares them with what runs take.

use crate::files::particle_fields;
use crate::fluid;
use crate::insertion::Insertions;
use crate::wall_triangles::{WallTriangles, wall_fields};
use grains_case::{Case, Precision};
use grains_dem::Catalogue;
use grains_domain::Transport;
use grains_geometry::Shape;
use grains_output::{FieldSpec, Kind};

/// Bytes of a process before its first particle or cell, with the libraries of MPI, HDF5 and PETSc.
const PROCESS: f64 = 50e6;

/// Bytes per particle of a settled bed at the peak, when lists are rebuilt or a snapshot is written, for spheres and for
/// other shapes.
const MEMORY: [f64; 2] = [950.0, 5000.0];

/// Bytes per particle of a checkpoint, for spheres and for other shapes.
const CHECKPOINT: [f64; 2] = [370.0, 1250.0];

/// Bytes of a bond in memory, at the peak, and in a checkpoint.
const BOND: [f64; 2] = [250.0, 150.0];

/// Bytes of a number of a table, and of the description of a snapshot in the files beside it.
const TEXT: [f64; 2] = [12.0, 8e3];

/// Memory and disk of a run.
#[derive(Clone, Copy, Debug)]
pub struct Cost {
    /// Memory of all ranks at the peak (bytes).
    pub memory: f64,
    /// Snapshots of the particles.
    pub snapshots: f64,
    /// Checkpoints that are kept.
    pub checkpoints: f64,
    /// All files, uncompressed (bytes).
    pub disk: f64,
}

impl Cost {
    /// That of a case with all its particles on a number of ranks, with the walls as they are drawn and the bonds there are at the
    /// beginning; collective.
    pub fn of(
        case: &Case,
        catalogue: &Catalogue,
        insertions: &Insertions,
        (walls, bonds): (&WallTriangles, u64),
        ranks: usize,
        transport: &impl Transport,
    ) -> Self {
        let out = &case.output;
        let particles = insertions.total() as f64;
        let other = usize::from(!catalogue.all_spheres());
        let snapshots = if case.inserts.is_empty() { 0.0 } else { times(case, out.particles) };
        let checkpoints = times(case, out.checkpoint).max(1.0).min(out.keep_checkpoints as f64);
        let real = bytes_per_real(case);
        let surfaces = match out.surfaces > 0.0 {
            true => {
                let bytes = |kind: grains_dem::Kind, _: f64| surface_bytes(catalogue.shape(kind), real);
                insertions.sum(case, catalogue, bytes, transport)
            }
            false => 0.0,
        };
        let of_walls = match case.walls.is_empty() {
            true => 0.0,
            false => {
                let triangles = walls.walls.len() as f64;
                let fields = wall_fields(case.walls.iter().any(|wall| wall.wear.is_some()));
                walls.points.len() as f64 * real + triangles * (TRIANGLE + bytes_of(&fields, real))
            }
        };
        let columns = 20.0 + 6.0 * case.walls.len() as f64 + 2.0 * case.flow_planes.len() as f64;
        // Written at the beginning, at each interval, and at the end.
        let disk = snapshots * (particles * particle_bytes(case) + of_walls + TEXT[1])
            + times(case, out.surfaces) * (surfaces + TEXT[1])
            + times(case, out.series) * columns * TEXT[0]
            + checkpoints * particles * CHECKPOINT[other]
            + fluid::check::bytes_on_disk(case)
            + page(case, snapshots * particles);
        // What is written at once is in memory at once, and more than half of it a second time.
        let at_once = 1.6 * surfaces / real * 8.0;
        let memory = PROCESS * ranks as f64
            + particles * MEMORY[other]
            + at_once
            + fluid::check::bytes_in_memory(case, ranks)
            + fluid::check::bytes_at_surfaces(case, catalogue, insertions, transport);
        Self { memory, snapshots, checkpoints, disk }.with_bonds(bonds)
    }

    /// That of a case whose particles have so many bonds more at the beginning.
    pub fn with_bonds(self, bonds: u64) -> Self {
        let [memory, disk] = BOND.map(|bytes| bonds as f64 * bytes);
        Self { memory: self.memory + memory, disk: self.disk + self.checkpoints * disk, ..self }
    }
}

/// Bytes of `report.html` of so many particles in all snapshots.
fn page(case: &Case, particles: f64) -> f64 {
    /// Without particles, of a particle in a snapshot, and at most.
    const BYTES: [f64; 3] = [0.15e6, 10.0, 7e6];
    if case.output.report { BYTES[0] + (BYTES[1] * particles).min(BYTES[2]) } else { 0.0 }
}

/// How often something is written with an interval (s), at the beginning too; 0 for never.
pub fn times(case: &Case, interval: f64) -> f64 {
    if interval > 0.0 { (case.time.end / interval + 1e-4).floor() + 1.0 } else { 0.0 }
}

/// Bytes of a floating-point number of a snapshot.
pub fn bytes_per_real(case: &Case) -> f64 {
    if case.output.precision == Precision::F32 { 4.0 } else { 8.0 }
}

/// Bytes of a triangle without its points and fields: three numbers of points, and where they begin.
const TRIANGLE: f64 = 32.0;

fn bytes_of(fields: &[FieldSpec], real: f64) -> f64 {
    fields.iter().map(|f| f.components as f64 * if f.kind == Kind::Integer { 8.0 } else { real }).sum()
}

/// Bytes of a particle in a snapshot.
fn particle_bytes(case: &Case) -> f64 {
    /// The number of its point, and where it begins.
    const VERTEX: f64 = 16.0;
    let real = bytes_per_real(case);
    bytes_of(&particle_fields(case), real) + 3.0 * real + VERTEX
}

/// Bytes of the true surface of a particle.
fn surface_bytes(shape: &Shape, real: f64) -> f64 {
    let (points, triangles) = (shape.surface.vertices.len() as f64, shape.surface.triangles.len() as f64);
    points * 3.0 * real + triangles * (TRIANGLE + bytes_of(&crate::files::SURFACE_FIELDS, real))
}

/// Peak memory of this process (bytes), where the system tells.
pub fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(1024.0 * peak.split_whitespace().next()?.parse::<f64>().ok()?)
}
