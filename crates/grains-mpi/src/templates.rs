//! Cases to begin with, which `grains-mpi new` writes.

use grains_simulation::RunError;
use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::PathBuf;

/// A commented case, whose first line says what it is.
struct Template {
    name: &'static str,
    text: &'static str,
}

const TEMPLATES: [Template; 4] = [
    Template { name: "silo", text: include_str!("../templates/silo.toml") },
    Template { name: "drum", text: include_str!("../templates/drum.toml") },
    Template { name: "bed", text: include_str!("../templates/bed.toml") },
    Template { name: "reactor", text: include_str!("../templates/reactor.toml") },
];

impl Template {
    fn summary(&self) -> &str {
        self.text.lines().next().unwrap_or_default().trim_start_matches("# ")
    }
}

/// Names of all templates.
pub fn names() -> impl Iterator<Item = &'static str> {
    TEMPLATES.iter().map(|template| template.name)
}

/// The JSON schema beside a case, by which editors complete keys, explain them and mark mistakes.
const SCHEMA: &str = "grains-mpi.schema.json";

/// Prints the templates, and how to begin with one.
pub fn list() {
    let width = names().map(str::len).max().unwrap_or(0);
    TEMPLATES.iter().for_each(|template| say!("{:width$}  {}", template.name, template.summary()));
    say!("\n`grains-mpi new silo` writes silo.toml, a case of your own.");
}

/// Writes the case called `name` to a file that must not be there, `NAME.toml` if `to` says nothing, with the schema for editors beside
/// it, and prints what comes next.
///
/// # Errors
/// A file that is there, or that cannot be written.
pub fn write(name: &str, to: Option<PathBuf>) -> Result<(), RunError> {
    let Some(template) = TEMPLATES.iter().find(|template| template.name == name) else {
        return Err(RunError::case(format!("`{name}` is no example; `grains-mpi examples` lists them")));
    };
    let path = to.unwrap_or_else(|| PathBuf::from(format!("{name}.toml")));
    let shown = path.display();
    let failed = |e: std::io::Error| match e.kind() {
        ErrorKind::AlreadyExists => RunError::files(format!("{shown} is there already; give another name")),
        _ => RunError::files(format!("cannot write {shown}: {e}")),
    };
    let mut file = OpenOptions::new().write(true).create_new(true).open(&path).map_err(failed)?;
    write!(file, "#:schema {SCHEMA}\n{}", template.text).map_err(failed)?;
    let schema = path.with_file_name(SCHEMA);
    fs::write(&schema, format!("{:#}\n", grains_case::schema()))
        .map_err(|e| RunError::files(format!("cannot write {}: {e}", schema.display())))?;
    say!("{shown}: {}", template.summary());
    say!("{}: its keys, for editors\n\nNext:", schema.display());
    say!("  grains-mpi check {shown}            # explains the case");
    say!("  mpirun -n 2 grains-mpi {shown}      # runs it on two ranks");
    Ok(())
}
