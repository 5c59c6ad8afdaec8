//! Particles that files list: tables, and the last snapshot of another run. Every rank reads, checks and keeps a share
//! of the rows until they are inserted.

use crate::error::{RunError, agreed};
use grains_case::{Case, Component, CsvShare, FileTotals, Insert, ParticleColumns};
use grains_dem::{Catalogue, Kind, NewParticle};
use grains_domain::Transport;
use grains_geometry::Vec3;
use grains_output::SnapshotFile;
use nalgebra::{Quaternion, Unit};
use std::ops::Range;
use std::path::Path;

/// Shape and material of a component.
pub fn component_kind(component: &Component) -> Kind {
    Kind { shape: component.shape as u16, material: component.material as u16 }
}

/// Consecutive rows of a particle file, those of this rank.
#[derive(Clone, Debug)]
pub struct FileRows {
    columns: ParticleColumns,
    /// Number of the first of them in the file.
    first: u64,
    /// Rows of the whole file.
    pub total: u64,
    /// The largest numbers of the whole file.
    pub extremes: Extremes,
}

/// The largest numbers of a particle file, and the lines where they stand first.
#[derive(Clone, Copy, Debug, Default)]
pub struct Extremes {
    /// Speed (m/s).
    pub speed: (f64, usize),
    /// Angular speed (rad/s).
    pub spin: (f64, usize),
    /// Component of a quaternion, by its amount (-).
    pub quaternion: (f64, usize),
    /// Whether it has temperatures.
    pub has_temperatures: bool,
}

impl Extremes {
    /// Those of all ranks; collective.
    fn of(columns: &ParticleColumns, transport: &impl Transport) -> Self {
        let norm = |vector: &[f64; 3]| Vec3::from(*vector).norm();
        let size = |q: &[f64; 4]| q.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        let lines = &columns.lines;
        Self {
            speed: largest(lines, columns.velocity.iter().flatten().map(norm), transport),
            spin: largest(lines, columns.angular_velocity.iter().flatten().map(norm), transport),
            quaternion: largest(lines, columns.orientation.iter().flatten().map(size), transport),
            has_temperatures: columns.temperature.is_some(),
        }
    }
}

/// The largest of the numbers that lines hold, on any rank, and the first line that holds it.
fn largest(lines: &[usize], numbers: impl Iterator<Item = f64>, transport: &impl Transport) -> (f64, usize) {
    let further = |best: (f64, usize), next: (f64, usize)| if next.0 > best.0 { next } else { best };
    let (number, line) = numbers.zip(lines.iter().copied()).fold((0.0, 0), further);
    let mut all = [number];
    transport.max(&mut all);
    // Later lines count less.
    let mut first = [if number == all[0] { -(line as f64) } else { f64::NEG_INFINITY }];
    transport.max(&mut first);
    (all[0], -first[0] as usize)
}

impl FileRows {
    /// Reads this rank's share of a file and checks it; collective.
    ///
    /// # Errors
    /// What is wrong in the file, with its lines, from the first rank that found something.
    pub fn read(
        case: &Case,
        insert: &Insert,
        path: &Path,
        transport: &impl Transport,
    ) -> Result<Self, RunError> {
        let file = path.display().to_string();
        let share = (transport.rank(), transport.size());
        let mut columns = match path.extension().and_then(|e| e.to_str()) {
            Some("vtkhdf") => agreed(transport, of_snapshot(path, share).map_err(RunError::case))?,
            Some("csv") => {
                let lines = CsvShare::read(path, share).map_err(|e| RunError::case(e.to_string()));
                parse(&agreed(transport, lines)?, 0, &file, transport)?
            }
            _ => {
                let lines = grains_output::read_columns_as_csv(path, share)
                    .map(|(header, rows)| CsvShare::of_rows(header, rows))
                    .map_err(|e| RunError::case(e.to_string()));
                parse(&agreed(transport, lines)?, 1, &file, transport)?
            }
        };
        let mut first = [columns.len() as u64];
        transport.counts_before(&mut first);
        let [first] = first;
        if columns.lines.is_empty() {
            columns.lines = (first as usize..).take(columns.len()).collect();
        }
        let totals = totals(FileTotals::of(&columns, case), transport);
        let checked = columns.check_share(&file, case, insert, &totals);
        agreed(transport, checked.map_err(|e| RunError::case(e.to_string())))?;
        let extremes = Extremes::of(&columns, transport);
        Ok(Self { columns, first, total: totals.rows, extremes })
    }

    /// Numbers of the rows this rank holds.
    pub fn own(&self) -> Range<u64> {
        self.first..self.first + self.columns.len() as u64
    }

    /// Whether they say how large particles are.
    pub fn has_sizes(&self) -> bool {
        self.columns.radius.is_some() || self.columns.scale.is_some()
    }

    /// Whether they say which shapes particles have.
    pub fn has_shapes(&self) -> bool {
        self.columns.shape.is_some()
    }

    /// Kind of one of its rows, and its scale if the file has sizes; columns it lacks come from a component of the
    /// insertion.
    pub fn kind(
        &self,
        case: &Case,
        catalogue: &Catalogue,
        row: u64,
        component: &Component,
    ) -> (Kind, Option<f64>) {
        let (columns, row) = (&self.columns, self.place(row));
        let mut kind = component_kind(component);
        if let Some(shape) = columns.shape.as_ref().and_then(|names| case.shape_index(&names[row])) {
            kind.shape = shape as u16;
        }
        if let Some(material) = columns.material.as_ref().and_then(|names| case.material_index(&names[row])) {
            kind.material = material as u16;
        }
        let scale = match (&columns.radius, &columns.scale) {
            (Some(radii), _) => Some(radii[row] / catalogue.shape(kind).bounding_radius),
            (_, Some(scales)) => Some(scales[row]),
            _ => None,
        };
        (kind, scale)
    }

    /// Whether rows tell velocities.
    pub fn have_velocities(&self) -> bool {
        self.columns.velocity.is_some()
    }

    /// Gives a particle the place and motion of one of its rows.
    pub fn apply(&self, row: u64, new: &mut NewParticle) {
        let (columns, row) = (&self.columns, self.place(row));
        new.position = Vec3::from(columns.position[row]);
        if let Some(q) = &columns.orientation {
            let [w, x, y, z] = q[row];
            new.orientation = Unit::new_normalize(Quaternion::new(w, x, y, z));
        }
        if let Some(v) = &columns.velocity {
            new.velocity = Vec3::from(v[row]);
        }
        if let Some(w) = &columns.angular_velocity {
            new.angular_velocity = Vec3::from(w[row]);
        }
        if let Some(temperatures) = &columns.temperature {
            new.temperature = temperatures[row];
        }
    }

    fn place(&self, row: u64) -> usize {
        (row - self.first) as usize
    }
}

/// Parses a rank's lines of a file, `before` of which no rank holds; collective.
fn parse(
    lines: &CsvShare,
    before: u64,
    file: &str,
    transport: &impl Transport,
) -> Result<ParticleColumns, RunError> {
    let mut counts = [lines.lines() as u64];
    transport.counts_before(&mut counts);
    let columns = ParticleColumns::parse_share(lines, (counts[0] + before) as usize, file);
    agreed(transport, columns.map_err(|e| RunError::case(e.to_string())))
}

/// The totals of all ranks.
fn totals(own: FileTotals, transport: &impl Transport) -> FileTotals {
    let mut rows = [own.rows];
    transport.sum_counts(&mut rows);
    let mut first: Vec<f64> =
        own.material_lines.iter().map(|line| line.map_or(f64::NEG_INFINITY, |line| -(line as f64))).collect();
    transport.max(&mut first);
    let material_lines = first.iter().map(|&line| line.is_finite().then_some(-line as usize)).collect();
    FileTotals { rows: rows[0], material_lines }
}

/// A share of the particles of the last snapshot of a run, their lines left open: shapes and materials by the names
/// they had there.
fn of_snapshot(path: &Path, share: (usize, usize)) -> Result<ParticleColumns, String> {
    let file = SnapshotFile::open_share(path, share).map_err(|e| e.to_string())?;
    let Some(last) = file.times().len().checked_sub(1) else {
        return Err(format!("{}: holds no snapshot; take another file", path.display()));
    };
    let text = file.text("case").unwrap_or_default();
    let base = path.parent().unwrap_or(Path::new(""));
    let source = Case::parse_stored(text, &path.display().to_string(), base).map_err(|e| e.to_string())?;
    let has = |name: &str| file.fields().iter().any(|field| field == name);
    let real = |name: &str| file.real(last, name).map_err(|e| e.to_string());
    let vectors = |name: &str| if has(name) { real(name).map(|v| Some(rows(&v))) } else { Ok(None) };
    let names = |field: &str, of: &dyn Fn(usize) -> Option<String>| -> Result<Option<Vec<String>>, String> {
        if !has(field) {
            return Ok(None);
        }
        let numbers = file.integer(last, field).map_err(|e| e.to_string())?;
        let name = |&k: &i64| {
            let foreign = || {
                format!(
                    "{}: a particle has {field} {k}, which its case has not; take another file",
                    path.display()
                )
            };
            usize::try_from(k).ok().and_then(of).ok_or_else(foreign)
        };
        numbers.iter().map(name).collect::<Result<_, _>>().map(Some)
    };
    Ok(ParticleColumns {
        lines: Vec::new(),
        position: rows(&file.points(last).map_err(|e| e.to_string())?),
        radius: None,
        scale: Some(real("scale")?),
        orientation: Some(rows(&real("orientation_wxyz")?)),
        velocity: vectors("velocity")?,
        angular_velocity: vectors("angular_velocity")?,
        temperature: if has("temperature") { Some(real("temperature")?) } else { None },
        shape: names("shape", &|k| Some(source.shapes.get(k)?.name.clone()))?,
        material: names("material", &|k| Some(source.materials.get(k)?.name.clone()))?,
    })
}

fn rows<const N: usize>(values: &[f64]) -> Vec<[f64; N]> {
    values.chunks_exact(N).map(|row| std::array::from_fn(|k| row[k])).collect()
}
