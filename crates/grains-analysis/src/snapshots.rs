//! The stored states of a run, and the particles of one of them.

use grains_case::Case;
use grains_comm::{Job, MpiTransport};
use grains_dem::{Catalogue, ParticleRecord};
use grains_domain::Transport;
use grains_geometry::{Rotation, Shape, Vec3};
use grains_output::{CheckpointFile, SnapshotFile, latest_valid};
use grains_simulation::{RunError, agreed};
use nalgebra::{Quaternion, Unit};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// A field that not every file of snapshots holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extra {
    /// Number of the material.
    Material,
    /// Velocity (m/s).
    Velocity,
    /// Angular velocity (rad/s).
    AngularVelocity,
    /// Touching particles and walls.
    Contacts,
}

impl Extra {
    /// Keys of `output.fields` that store it.
    fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Material => &["material"],
            Self::Velocity => &["velocity"],
            Self::AngularVelocity => &["angular_velocity"],
            Self::Contacts => &["coordination", "wall_contacts"],
        }
    }
}

/// This rank's particles of a stored state, an entry per particle; extras that were not asked for are empty.
#[derive(Clone, Debug, Default)]
pub struct Snapshot {
    /// Time (s).
    pub time: f64,
    /// Identity.
    pub id: Vec<u64>,
    /// Number of the shape.
    pub shape: Vec<usize>,
    /// Centre of mass, in the domain (m).
    pub position: Vec<Vec3>,
    /// Orientation, body to world.
    pub orientation: Vec<Rotation>,
    /// Size over that of the shape (-).
    pub scale: Vec<f64>,
    /// Number of the material.
    pub material: Vec<usize>,
    /// Velocity (m/s).
    pub velocity: Vec<Vec3>,
    /// Angular velocity (rad/s).
    pub angular_velocity: Vec<Vec3>,
    /// Touching particles (-).
    pub coordination: Vec<u64>,
    /// Touching walls (-).
    pub wall_contacts: Vec<u64>,
}

impl Snapshot {
    /// Number of this rank's particles.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Number of particles over all ranks.
    pub fn total(&self, transport: &impl Transport) -> u64 {
        let mut total = [self.len() as u64];
        transport.sum_counts(&mut total);
        total[0]
    }

    /// Volume of a particle (m³).
    pub fn volume(&self, i: usize, shapes: &[Shape]) -> f64 {
        shapes[self.shape[i]].volume * self.scale[i].powi(3)
    }

    /// Bounding radius of a particle (m).
    pub fn radius(&self, i: usize, shapes: &[Shape]) -> f64 {
        shapes[self.shape[i]].bounding_radius * self.scale[i]
    }

    /// Height of a particle above and below its centre along an axis (m), `[below, above]`; for round bodies
    /// that of their tessellation.
    pub fn reach(&self, i: usize, axis: usize, shapes: &[Shape]) -> [f64; 2] {
        let shape = &shapes[self.shape[i]];
        if shape.is_sphere() {
            return [self.radius(i, shapes); 2];
        }
        let mut direction = Vec3::zeros();
        direction[axis] = self.scale[i];
        let in_body = self.orientation[i].inverse() * direction;
        let heights = shape.surface.vertices.iter().map(|v| v.dot(&in_body));
        heights.fold([0.0, 0.0], |[below, above], h| [f64::max(below, -h), f64::max(above, h)])
    }
}

/// Which stored states are wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Times {
    /// The first.
    First,
    /// The last.
    Last,
    /// All.
    All,
    /// The nearest to a time (s).
    Nearest(f64),
    /// Those from a time up to another (s).
    Between(f64, f64),
}

impl FromStr for Times {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("`{text}` is none of first, last, all, a time in s, or FROM:TO in s");
        let seconds = |word: &str| word.trim().parse::<f64>().ok().filter(|t| !t.is_nan()).ok_or_else(wrong);
        Ok(match text {
            "first" => Self::First,
            "last" => Self::Last,
            "all" => Self::All,
            _ => match text.split_once(':') {
                None => Self::Nearest(seconds(text)?),
                Some((from, to)) => {
                    let from = if from.is_empty() { f64::NEG_INFINITY } else { seconds(from)? };
                    Self::Between(from, if to.is_empty() { f64::INFINITY } else { seconds(to)? })
                }
            },
        })
    }
}

impl Times {
    /// Numbers of the wanted among states at rising times (s).
    pub fn select(self, times: &[f64]) -> Vec<usize> {
        // A time written with few digits means the state it was read from.
        let slack = 1e-9 * times.last().map_or(0.0, |t| t.abs());
        let all = 0..times.len();
        match self {
            Self::First => all.take(1).collect(),
            Self::Last => all.rev().take(1).collect(),
            Self::All => all.collect(),
            Self::Nearest(wanted) => {
                let distance = |k: &usize| (times[*k] - wanted).abs();
                all.min_by(|a, b| distance(a).total_cmp(&distance(b))).into_iter().collect()
            }
            Self::Between(from, to) => {
                all.filter(|&k| (from - slack..=to + slack).contains(&times[k])).collect()
            }
        }
    }
}

enum Stored {
    Snapshots(SnapshotFile),
    Checkpoint(Box<CheckpointFile>),
}

/// The stored states of a run and the case they belong to.
pub struct StoredRun {
    /// The file.
    pub path: PathBuf,
    /// The case.
    pub case: Case,
    /// Shapes and densities of the case.
    pub catalogue: Catalogue,
    times: Vec<f64>,
    stored: Stored,
}

impl StoredRun {
    /// Opens a run: its output directory, its `particles.vtkhdf`, or a checkpoint; the case is the one stored
    /// with the states unless another file is given.
    ///
    /// # Errors
    /// Nothing to read there, or a case that no longer fits, for instance because a mesh has been moved.
    pub fn open(run: &Path, case: Option<&Path>, job: &Job) -> Result<Self, RunError> {
        let transport = job.transport();
        let (path, stored) = open_states(run, transport)?;
        let text = match &stored {
            Stored::Snapshots(file) => file.text("case"),
            Stored::Checkpoint(file) => file.text("case"),
        };
        let case = match case {
            Some(file) => grains_simulation::load(file, job)?,
            None => {
                let label = format!("{} (the case stored in it)", path.display());
                let parsed = Case::parse_stored(text.unwrap_or(""), &label, Path::new(""));
                let remedy = "paths in it are relative to where the run was started: analyse from there, or give the case with --case FILE";
                agreed(transport, parsed.map_err(|e| RunError::case(format!("{e}\n{remedy}"))))?
            }
        };
        let catalogue = agreed(transport, grains_simulation::catalogue(&case).map_err(RunError::case))?;
        let times = match &stored {
            Stored::Snapshots(file) => file.times(),
            Stored::Checkpoint(file) => {
                vec![file.text("time").and_then(|t| t.parse().ok()).unwrap_or(f64::NAN)]
            }
        };
        Ok(Self { path, case, catalogue, times, stored })
    }

    /// Numbers of the wanted states.
    ///
    /// # Errors
    /// None stored then, naming the times there are.
    pub fn select(&self, wanted: Times) -> Result<Vec<usize>, RunError> {
        let found = wanted.select(&self.times);
        if !found.is_empty() {
            return Ok(found);
        }
        let there = match (self.times.first(), self.times.last()) {
            (Some(first), Some(last)) => {
                format!("it holds {} from {first} s to {last} s", self.times.len())
            }
            _ => "it holds none yet".into(),
        };
        Err(RunError::case(format!(
            "{}: no state at the times asked for, {there}: give another --time",
            self.path.display()
        )))
    }

    /// Time of a state (s).
    pub fn time(&self, state: usize) -> f64 {
        self.times[state]
    }

    /// This rank's share of a state, with some extras; `what` is the analysis that wants them.
    ///
    /// # Errors
    /// A field that was not stored, naming the key that stores it, or a damaged file.
    pub fn read(
        &self,
        transport: &MpiTransport,
        state: usize,
        extras: &[Extra],
        what: &str,
    ) -> Result<Snapshot, RunError> {
        let mut snapshot = match &self.stored {
            Stored::Snapshots(file) => from_snapshots(file, state, extras, (&self.path, what))?,
            Stored::Checkpoint(file) => from_checkpoint(file, extras, (&self.path, what))?,
        };
        snapshot.time = self.times[state];
        let shapes = &self.catalogue.shapes;
        if transport.any(snapshot.shape.iter().any(|&shape| shape >= shapes.len())) {
            let (path, count) = (self.path.display(), shapes.len());
            return Err(RunError::case(format!(
                "{path}: names a shape the case lacks (it has {count}): give the case of this run"
            )));
        }
        if matches!(self.stored, Stored::Snapshots(_)) {
            // Snapshots turn the shape as the case gives it.
            for (turn, &shape) in snapshot.orientation.iter_mut().zip(&snapshot.shape) {
                *turn *= shapes[shape].user_to_body.0;
            }
        } else {
            // A checkpoint holds radii where a snapshot holds scales.
            for (scale, &shape) in snapshot.scale.iter_mut().zip(&snapshot.shape) {
                *scale /= shapes[shape].bounding_radius;
            }
        }
        Ok(snapshot)
    }
}

impl StoredRun {
    /// A field of real numbers of this rank's share of the particles of a state; `what` is the analysis that wants it.
    ///
    /// # Errors
    /// A field that was not stored, or a damaged file.
    pub fn real(&self, state: usize, name: &str, what: &str) -> Result<Vec<f64>, RunError> {
        match &self.stored {
            Stored::Snapshots(file) if file.fields().iter().any(|field| field == name) => {
                Ok(file.real(state, name)?)
            }
            _ => Err(RunError::case(format!(
                "{}: lacks the field `{name}`, which `analyse {what}` needs: give particles.vtkhdf of a run that exchanges it",
                self.path.display()
            ))),
        }
    }
}

fn open_states(run: &Path, transport: &MpiTransport) -> Result<(PathBuf, Stored), RunError> {
    let communicator = transport.communicator();
    let is_first = transport.rank() == 0;
    // Rank 0 looks: on a network file system the ranks may see different files for a while.
    let is = |there: bool| transport.any(is_first && there);
    if !is(run.exists()) {
        let message = format!("{}: does not exist; give the output directory of a run", run.display());
        return Err(RunError::files(message));
    }
    let snapshots = if run.is_dir() { run.join("particles.vtkhdf") } else { run.to_path_buf() };
    if is(run.is_dir()) && !is(snapshots.exists()) {
        let (file, _) = latest_valid(run, communicator).map_err(|error| {
            let mut error = RunError::from(error);
            if !error.message.is_empty() {
                error.message = format!(
                    "{}: holds neither particles.vtkhdf (output.particles > 0 writes it) nor a valid checkpoint; give the output directory of a run",
                    run.display()
                );
            }
            error
        })?;
        return Ok((file.path.clone(), Stored::Checkpoint(Box::new(file))));
    }
    if snapshots.extension().is_some_and(|e| e == "h5") {
        let file = CheckpointFile::read(&snapshots, communicator)?;
        return Ok((snapshots, Stored::Checkpoint(Box::new(file))));
    }
    let file = SnapshotFile::open(&snapshots, communicator)?;
    Ok((snapshots, Stored::Snapshots(file)))
}

fn vectors(values: &[f64]) -> Vec<Vec3> {
    values.chunks_exact(3).map(Vec3::from_column_slice).collect()
}

fn from_snapshots(
    file: &SnapshotFile,
    state: usize,
    extras: &[Extra],
    (path, what): (&Path, &str),
) -> Result<Snapshot, RunError> {
    let keys = extras.iter().flat_map(|extra| extra.keys());
    if let Some(key) = keys.clone().find(|key| !file.fields().iter().any(|f| f == *key)) {
        return Err(RunError::case(format!(
            "{}: the snapshots lack `{key}`, which `analyse {what}` needs: add \"{key}\" to output.fields of the case and run it again, or analyse a checkpoint",
            path.display()
        )));
    }
    let numbers = |name: &str| -> Result<Vec<usize>, RunError> {
        Ok(file.integer(state, name)?.into_iter().map(|k| k as usize).collect())
    };
    let orientation = file.real(state, "orientation_wxyz")?;
    // Numbers stored in 32 bits are of unit length to 1e-7 only.
    let turn = |q: &[f64]| Unit::new_normalize(Quaternion::new(q[0], q[1], q[2], q[3]));
    let mut snapshot = Snapshot {
        id: file.integer(state, "id")?.into_iter().map(|k| k as u64).collect(),
        shape: numbers("shape")?,
        position: vectors(&file.points(state)?),
        orientation: orientation.chunks_exact(4).map(turn).collect(),
        scale: file.real(state, "scale")?,
        ..Snapshot::default()
    };
    for extra in extras {
        match extra {
            Extra::Material => snapshot.material = numbers("material")?,
            Extra::Velocity => snapshot.velocity = vectors(&file.real(state, "velocity")?),
            Extra::AngularVelocity => {
                snapshot.angular_velocity = vectors(&file.real(state, "angular_velocity")?);
            }
            Extra::Contacts => {
                let counts = |name| -> Result<Vec<u64>, RunError> {
                    Ok(file.integer(state, name)?.into_iter().map(|k| k as u64).collect())
                };
                snapshot.coordination = counts("coordination")?;
                snapshot.wall_contacts = counts("wall_contacts")?;
            }
        }
    }
    Ok(snapshot)
}

fn from_checkpoint(
    file: &CheckpointFile,
    extras: &[Extra],
    (path, what): (&Path, &str),
) -> Result<Snapshot, RunError> {
    if extras.contains(&Extra::Contacts) {
        return Err(RunError::case(format!(
            "{}: a checkpoint holds no numbers of contacts, which `analyse {what}` needs: give particles.vtkhdf, written with output.particles > 0",
            path.display()
        )));
    }
    let mut snapshot = Snapshot::default();
    for row in file.real("particle")?.chunks_exact(ParticleRecord::LENGTH) {
        let record = ParticleRecord::read(row);
        let body = record.body;
        snapshot.id.push(record.id);
        snapshot.shape.push(body.kind.shape.into());
        snapshot.material.push(body.kind.material.into());
        snapshot.position.push(body.position);
        snapshot.orientation.push(record.orientation);
        snapshot.scale.push(body.radius);
        snapshot.velocity.push(body.velocity);
        snapshot.angular_velocity.push(body.angular_velocity);
    }
    Ok(snapshot)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_selected_by_word_number_and_range() {
        let stored = [0.0, 0.1, 0.2, 0.30000000000000004];
        let select = |text: &str| text.parse::<Times>().map(|t| t.select(&stored)).unwrap();
        assert_eq!(select("first"), [0]);
        assert_eq!(select("last"), [3]);
        assert_eq!(select("all"), [0, 1, 2, 3]);
        assert_eq!(select("0.16"), [2]);
        assert_eq!(select("0.1:0.3"), [1, 2, 3]);
        assert_eq!(select(":0.1"), [0, 1]);
        assert_eq!(select("5:6"), [0_usize; 0]);
        assert!("soon".parse::<Times>().is_err());
        assert!(Times::Last.select(&[]).is_empty());
    }
}
