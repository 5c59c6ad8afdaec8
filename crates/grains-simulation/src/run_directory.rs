//! The directory of a run, and what lies in it beside time series, snapshots and checkpoints.

use crate::lock::DirectoryLock;
use grains_case::Case;
use grains_dem::Dem;
use grains_geometry::Vec3;
use grains_output::{FileError, write_shape};
use std::path::{Path, PathBuf};

/// The case with every default spelt out; a directory that holds one holds a run.
const RESOLVED_CASE: &str = "case.resolved.toml";

/// Makes the directory and takes it; results of an earlier run are moved aside, unless this run continues them.
pub fn prepare_directory(directory: &Path, is_restart: bool) -> Result<DirectoryLock, FileError> {
    let make = || {
        std::fs::create_dir_all(directory.join("shapes")).map_err(|e| {
            FileError::new(directory, format!("cannot be created: {e}; choose another output.directory"))
        })
    };
    make()?;
    let lock = DirectoryLock::take(directory)?;
    if is_restart || !directory.join(RESOLVED_CASE).exists() {
        return Ok(lock);
    }
    let free = (1..).map(|k| PathBuf::from(format!("{}.{k}", directory.display()))).find(|p| !p.exists());
    let aside = free.unwrap_or_else(|| directory.with_extension("old"));
    std::fs::rename(directory, &aside).map_err(|e| {
        FileError::new(directory, format!("holds an earlier run that cannot be moved aside: {e}"))
    })?;
    log::info!("the earlier results in {} are now in {}", directory.display(), aside.display());
    make()?;
    // The earlier results stay locked until the new directory is.
    DirectoryLock::take(directory)
}

/// The resolved case, the reference surfaces of the shapes, and a script that shows all in ParaView.
pub fn write_side_files(case: &Case, program: &str, dem: &Dem, directory: &Path) -> Result<(), FileError> {
    let write = |name: &str, text: &str| {
        let path = directory.join(name);
        std::fs::write(&path, text).map_err(|e| FileError::new(&path, format!("cannot be written: {e}")))
    };
    let dt = dem.setup.parameters.dt;
    write(RESOLVED_CASE, &format!("# {program}; time step {dt:e} s\n{}", case.to_toml()))?;
    write("view.py", include_str!("view.py"))?;
    for (index, shape) in dem.setup.catalogue.shapes.iter().enumerate() {
        // Turned as the case gives the shape, about its centre of mass.
        let turned = |v: &Vec3| <[f64; 3]>::from(shape.user_to_body.0 * v);
        let vertices: Vec<[f64; 3]> = shape.surface.vertices.iter().map(turned).collect();
        write_shape(&directory.join(format!("shapes/{index}.vtp")), &vertices, &shape.surface.triangles)?;
    }
    Ok(())
}
