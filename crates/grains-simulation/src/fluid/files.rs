//! The files of the fluid: snapshots of its fields, their means, and tables along lines and planes.

use super::FluidPhase;
use super::observe::{Name, Observation};
use crate::error::RunError;
use grains_case::{Case, FluidField};
use grains_comm::MpiTransport;
use grains_dem::Dem;
use grains_domain::Transport;
use grains_output::{
    Data, FieldSpec, FileError, GridFile, GridGeometry, Metadata, Precision, Series, agree_written,
    write_table,
};
use std::path::{Path, PathBuf};

/// Open files of the fluid.
pub struct FluidFiles {
    directory: PathBuf,
    fields: Vec<FluidField>,
    metadata: Metadata,
    snapshots: Option<GridFile>,
    means: Option<GridFile>,
    /// One per profile, on rank 0 only.
    profiles: Vec<Series>,
}

/// How files are opened.
pub struct Opening<'a> {
    /// Folder of the run.
    pub directory: &'a Path,
    /// Precision of snapshots and whether they are compressed.
    pub format: (Precision, bool),
    /// What every file holds beside its values.
    pub metadata: &'a Metadata,
    /// Step and time (s) from which the run is continued, if it is.
    pub restart: Option<(u64, f64)>,
}

impl FluidFiles {
    /// Opens the files, new or continued.
    ///
    /// # Errors
    /// A file that cannot be used.
    pub fn open(
        case: &Case,
        phase: &FluidPhase,
        opening: &Opening,
        transport: &MpiTransport,
    ) -> Result<Self, RunError> {
        let (directory, communicator) = (opening.directory, transport.communicator());
        let output = case.fluid.as_ref().map(|f| f.output.clone()).unwrap_or_default();
        let names = phase.names(&output.fields);
        let specs: Vec<FieldSpec> =
            names.iter().map(|&(name, unit, width)| FieldSpec::real(name, unit, width)).collect();
        let is_first = transport.rank() == 0;
        let geometry = geometry(phase);
        let open = |name: &str| -> Result<GridFile, FileError> {
            let path = directory.join(name);
            match opening.restart {
                Some((_, time)) if transport.any(is_first && path.exists()) => {
                    let file =
                        GridFile::resume(&path, communicator, &geometry, &specs, opening.format.0, time)?;
                    file.record_restart(opening.metadata)?;
                    Ok(file)
                }
                _ => {
                    GridFile::create(&path, communicator, &geometry, &specs, opening.format, opening.metadata)
                }
            }
        };
        let wanted = output.interval.unwrap_or(case.output.particles) > 0.0;
        let snapshots = wanted.then(|| open("fluid.vtkhdf")).transpose()?;
        let means = (wanted && phase.means.is_some()).then(|| open("fluid-mean.vtkhdf")).transpose()?;
        let profiles = if is_first && wanted { profiles(phase, &names, opening) } else { Ok(Vec::new()) };
        Ok(Self {
            directory: directory.to_path_buf(),
            fields: output.fields,
            metadata: opening.metadata.clone(),
            snapshots,
            means,
            profiles: agree_written(communicator, profiles)?,
        })
    }

    /// Changes which cells each rank writes.
    ///
    /// # Errors
    /// Blocks that do not make up the grid.
    pub fn divide(&mut self, phase: &FluidPhase) -> Result<(), RunError> {
        let (first, own) = (phase.flow.first_cell(), phase.flow.layout().cells);
        for file in self.snapshots.iter_mut().chain(&mut self.means) {
            file.divide(first, own)?;
        }
        Ok(())
    }

    /// Writes the fields now, their means so far and the profiles of both, unless the files hold them.
    ///
    /// # Errors
    /// A full disk, or a particle beyond the halo.
    pub fn snapshot(
        &mut self,
        phase: &mut FluidPhase,
        dem: &Dem,
        transport: &MpiTransport,
    ) -> Result<(), RunError> {
        let Some(file) = &mut self.snapshots else { return Ok(()) };
        let time = dem.time();
        let now = phase.sample(dem, transport)?.into_observations(&self.fields);
        let rows_of = |fields: &[Observation]| -> Vec<Vec<Vec<f64>>> {
            phase.profiles.iter().map(|sampler| sampler.rows(fields, transport)).collect()
        };
        let rows_now = rows_of(&now);
        append(file, time, now)?;
        let means = phase.means.clone().filter(|m| m.samples > 0).map(|m| m.into_observations(&self.fields));
        let rows_of_means = means.as_deref().map(rows_of);
        if let (Some(file), Some(means)) = (&mut self.means, means) {
            append(file, time, means)?;
        }
        for (k, (sampler, rows)) in phase.profiles.iter().zip(rows_now).enumerate() {
            let with_time: Vec<f64> =
                rows.iter().flat_map(|row| std::iter::once(time).chain(row.iter().copied())).collect();
            let written = match self.profiles.get_mut(k) {
                Some(series) if !series.holds(dem.step) => series.append_block(dem.step, &with_time),
                _ => Ok(()),
            };
            agree_written(transport.communicator(), written)?;
            if let Some(rows) = rows_of_means.as_ref().and_then(|rows| rows.get(k)) {
                let rows = rows.concat();
                let path = self.directory.join(format!("profile-{}-mean.csv", sampler.name));
                let (columns, units) = profile_columns(&phase.names(&self.fields));
                let written = match transport.rank() {
                    0 => write_table(&path, &columns, &comments(&self.metadata, &units), &rows),
                    _ => Ok(()),
                };
                agree_written(transport.communicator(), written)?;
            }
        }
        Ok(())
    }
}

/// Appends the fields at a time (s), unless the file holds them; each makes way for what is written of it.
fn append(file: &mut GridFile, time: f64, fields: Vec<Observation>) -> Result<(), FileError> {
    if file.holds(time) {
        return Ok(());
    }
    let values: Vec<Vec<f64>> = fields.into_iter().map(Observation::interleaved).collect();
    let data: Vec<Data> = values.iter().map(|v| Data::Real(v)).collect();
    file.append(time, &data)
}

fn geometry(phase: &FluidPhase) -> GridGeometry {
    let setup = &phase.flow.setup;
    GridGeometry {
        nodes: std::array::from_fn(|a| setup.grid.axis(a).nodes().to_vec()),
        first: phase.flow.first_cell(),
        own: phase.flow.layout().cells,
    }
}

/// Columns of a mean profile and their units; tables over time have step and time before.
fn profile_columns(names: &[Name]) -> (Vec<String>, Vec<&'static str>) {
    let mut columns: Vec<(String, &str)> = ["x", "y", "z"].map(|c| (c.to_string(), "m")).into();
    for &(name, unit, width) in names {
        match width {
            1 => columns.push((name.to_string(), unit)),
            _ => columns.extend(["x", "y", "z"].map(|c| (format!("{name}_{c}"), unit))),
        }
    }
    columns.into_iter().unzip()
}

fn comments(metadata: &Metadata, units: &[&str]) -> Metadata {
    metadata.iter().cloned().chain([("units".into(), units.join(","))]).collect()
}

fn profiles(phase: &FluidPhase, names: &[Name], opening: &Opening) -> Result<Vec<Series>, FileError> {
    let (mut columns, mut units) = profile_columns(names);
    columns.splice(0..0, ["step".to_string(), "time".to_string()]);
    units.splice(0..0, ["-", "s"]);
    let open = |name: &str| {
        let path = opening.directory.join(format!("profile-{name}.csv"));
        match opening.restart {
            Some((step, _)) if path.exists() => Series::resume(&path, &columns, step),
            _ => Series::create(&path, &columns, &comments(opening.metadata, &units)),
        }
    };
    phase.profiles.iter().map(|sampler| open(&sampler.name)).collect()
}
