//! `import`: cases, particles and meshes from inputs of LAMMPS and LIGGGHTS.

use clap::Args;
use grains_import::{ImportError, Imported, Options};
use grains_simulation::RunError;
use std::path::PathBuf;

#[derive(Args)]
pub struct ImportArguments {
    /// Scripts, data files and text dumps, also packed (`.gz`).
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Folder that is written; the name of the first file by default.
    #[arg(long, value_name = "DIR")]
    to: Option<PathBuf>,
    /// Value of a variable of the script, as `-var` gives it there; may be repeated.
    #[arg(long = "var", value_name = "NAME=VALUE", value_parser = variable)]
    variables: Vec<(String, String)>,
    /// Step of the frame of a dump that becomes the particles; the last one by default.
    #[arg(long)]
    step: Option<u64>,
    /// Units of data and dumps that come without a script: si, cgs, micro, nano or lj.
    #[arg(long)]
    units: Option<String>,
}

fn variable(text: &str) -> Result<(String, String), String> {
    let pair = text.split_once('=').filter(|(name, _)| !name.is_empty());
    pair.map(|(name, value)| (name.to_owned(), value.to_owned()))
        .ok_or_else(|| "must be NAME=VALUE".to_owned())
}

/// Imports files and prints what became of them.
///
/// # Errors
/// Files that cannot be read or written, or make no case.
pub fn import(arguments: &ImportArguments) -> Result<(), RunError> {
    let ImportArguments { files, to, variables, step, units } = arguments;
    let first = files[0].file_name().unwrap_or_default().to_string_lossy();
    let to =
        to.clone().unwrap_or_else(|| PathBuf::from(format!("{}-imported", first.trim_end_matches(".gz"))));
    let options = Options { variables: variables.clone(), step: *step, units: units.clone() };
    let imported = grains_import::import(files, &to, &options).map_err(of_import)?;
    tell(&imported, &to.display().to_string());
    Ok(())
}

fn of_import(error: ImportError) -> RunError {
    match error.is_of_files() {
        true => RunError::files(error.to_string()),
        false => RunError::case(error.to_string()),
    }
}

fn tell(imported: &Imported, to: &str) {
    if let Some(case) = &imported.case {
        let case = case.display();
        say!("{}", imported.report);
        imported.warnings.iter().for_each(|warning| say!("warning: {warning}"));
        say!("{to}: case.toml, import.txt (what is said here){}", particles(imported));
        say!("\nNext:\n  grains-mpi check {case}            # explains the case");
        say!("  mpirun -n 2 grains-mpi {case}      # runs it on two ranks");
    } else if imported.frames > 0 {
        imported.warnings.iter().for_each(|warning| say!("warning: {warning}"));
        say!(
            "{to}: {} frames in particles.pvd for ParaView and in frames.csv{}",
            imported.frames,
            particles(imported)
        );
    } else {
        imported.warnings.iter().for_each(|warning| say!("warning: {warning}"));
        say!("{to}: {}", particles(imported).trim_start_matches(", "));
    }
}

fn particles(imported: &Imported) -> String {
    imported.particles.map_or_else(String::new, |count| format!(", particles.csv with {count} particles"))
}
