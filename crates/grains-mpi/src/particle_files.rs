//! Files that particles are taken from: tables, and the last snapshot of another run.

use grains_case::{Case, Insert, ParticleColumns, Place};
use grains_output::SnapshotFile;
use mpi::topology::SimpleCommunicator;
use std::path::Path;

/// The particle files of a case, one entry per insertion.
///
/// # Errors
/// What is wrong in a file, with its lines.
pub fn files(case: &Case) -> Result<Vec<Option<ParticleColumns>>, String> {
    let read = |insert: &Insert| match &insert.place {
        Place::File { path } => {
            let file = path.display().to_string();
            let columns = match path.extension().and_then(|e| e.to_str()) {
                Some("csv") => ParticleColumns::read_csv(path).map_err(|e| e.to_string())?,
                Some("vtkhdf") => of_snapshot(path)?,
                _ => {
                    let text = grains_output::read_columns_as_csv(path).map_err(|e| e.to_string())?;
                    ParticleColumns::parse_csv(&text, &file).map_err(|e| e.to_string())?
                }
            };
            columns.check(&file, case, insert).map_err(|e| e.to_string())?;
            Ok(Some(columns))
        }
        _ => Ok(None),
    };
    case.inserts.iter().map(read).collect()
}

/// The particles of the last snapshot of a run: shapes and materials by the names they had there.
fn of_snapshot(path: &Path) -> Result<ParticleColumns, String> {
    let file = SnapshotFile::open(path, &SimpleCommunicator::self_comm()).map_err(|e| e.to_string())?;
    let Some(last) = file.times().len().checked_sub(1) else {
        return Err(format!("{}: holds no snapshot; take another file", path.display()));
    };
    let text = file.text("case").unwrap_or_default();
    let base = path.parent().unwrap_or(Path::new(""));
    let source = Case::parse(text, &path.display().to_string(), base).map_err(|e| e.to_string())?;
    let has = |name: &str| file.fields().iter().any(|field| field == name);
    let real = |name: &str| file.real(last, name).map_err(|e| e.to_string());
    let vectors = |name: &str| if has(name) { real(name).map(|v| Some(rows(&v))) } else { Ok(None) };
    let names = |field: &str, of: &dyn Fn(usize) -> String| -> Result<Option<Vec<String>>, String> {
        let numbers =
            if has(field) { file.integer(last, field).map_err(|e| e.to_string())? } else { Vec::new() };
        Ok((!numbers.is_empty()).then(|| numbers.iter().map(|&k| of(k as usize)).collect()))
    };
    let position: Vec<[f64; 3]> = rows(&file.points(last).map_err(|e| e.to_string())?);
    Ok(ParticleColumns {
        lines: (0..position.len()).collect(),
        position,
        radius: None,
        scale: Some(real("scale")?),
        orientation: Some(rows(&real("orientation_wxyz")?)),
        velocity: vectors("velocity")?,
        angular_velocity: vectors("angular_velocity")?,
        shape: names("shape", &|k| source.shapes[k].name.clone())?,
        material: names("material", &|k| source.materials[k].name.clone())?,
    })
}

fn rows<const N: usize>(values: &[f64]) -> Vec<[f64; N]> {
    values.chunks_exact(N).map(|row| std::array::from_fn(|k| row[k])).collect()
}
