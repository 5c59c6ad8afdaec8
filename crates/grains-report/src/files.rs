//! The files of a run that are texts, and all of them together.

use crate::block::Block;
use crate::{Contents, ReportError};
use crate::{curves, pictures, scene};
use serde::Deserialize;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// The page.
pub const REPORT: &str = "report.html";
/// What was run, what `check` said, what came of it.
pub const RUN: &str = "run.json";
/// How far a run is.
pub const STATUS: &str = "status.json";
/// The case with every default spelt out; a directory that holds one holds a run.
const CASE: &str = "case.resolved.toml";

/// What a page needs to know of a case.
#[derive(Debug, Default, PartialEq)]
pub struct Case {
    /// Its name.
    pub name: String,
    /// Corners of the domain (m).
    pub lower: [f64; 3],
    /// The opposite corner (m).
    pub upper: [f64; 3],
    /// Axes along which the domain is periodic.
    pub periodic: [bool; 3],
    /// Names of the shapes.
    pub shapes: Vec<String>,
    /// Names of the materials.
    pub materials: Vec<String>,
    /// Names of the walls.
    pub walls: Vec<String>,
}

#[derive(Deserialize)]
struct RawCase {
    #[serde(default)]
    name: String,
    domain: RawDomain,
    #[serde(default)]
    shape: Vec<Named>,
    #[serde(default)]
    material: Vec<Named>,
    #[serde(default)]
    wall: Vec<Named>,
}

#[derive(Deserialize)]
struct RawDomain {
    lower: [f64; 3],
    upper: [f64; 3],
    #[serde(default)]
    periodic: [bool; 3],
}

#[derive(Deserialize)]
struct Named {
    #[serde(default)]
    name: String,
}

impl Case {
    /// That of a text, also of an earlier or later version: only what a page needs is read.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(text: &str) -> Result<Self, String> {
        let RawCase { name, domain, shape, material, wall } =
            toml::from_str(text).map_err(|e| e.message().to_string())?;
        let names = |list: Vec<Named>| list.into_iter().map(|named| named.name).collect();
        Ok(Self {
            name,
            lower: domain.lower,
            upper: domain.upper,
            periodic: domain.periodic,
            shapes: names(shape),
            materials: names(material),
            walls: names(wall),
        })
    }
}

/// All that a page shows of a directory, with particles of at most so many bytes.
///
/// # Errors
/// A directory of no run.
pub fn contents(directory: &Path, budget: usize) -> Result<Contents, ReportError> {
    let path = directory.join(CASE);
    let text = fs::read_to_string(&path).map_err(|error| {
        ReportError::new(&path, format!("{error}; give the directory of results of a run"))
    })?;
    let mut notes = Vec::new();
    let case = Case::read(&text).unwrap_or_else(|problem| {
        notes.push(format!("{CASE} cannot be read: {problem}."));
        Case::default()
    });
    let mut block = Block::default();
    let series = directory.join("series.csv");
    let series = series.exists().then(|| curves::series(&series, &mut block)).transpose();
    let series = series.unwrap_or_else(|error| {
        notes.push(format!("series.csv cannot be read: {error}."));
        None
    });
    let profiles = curves::profiles(directory, &mut block).unwrap_or_else(|error| {
        notes.push(format!("A profile cannot be read: {error}."));
        Vec::new()
    });
    let scene = scene::read(directory, &case, budget, (&mut block, &mut notes));
    let is_thinned = scene.as_ref().is_some_and(|scene| scene.is_thinned);
    let (pictures, left_out) = pictures::read(directory);
    if !left_out.is_empty() {
        notes.push(format!("Pictures that are not here: {}.", left_out.join(", ")));
    }
    let name = directory.canonicalize().unwrap_or_else(|_| directory.to_path_buf());
    let description = json!({
        "name": case.name,
        "directory": name.file_name().map(|name| name.to_string_lossy()),
        "case": text,
        "run": read_json(&directory.join(RUN)),
        "status": read_json(&directory.join(STATUS)),
        "series": series.flatten(),
        "profiles": profiles,
        "pictures": pictures,
        "scene": scene,
        "notes": notes,
    });
    Ok(Contents { description, block: block.text(), is_thinned })
}

/// A file of JSON; null if there is none, as in results of earlier versions.
pub fn read_json(path: &Path) -> Value {
    fs::read_to_string(path).ok().and_then(|text| serde_json::from_str(&text).ok()).unwrap_or(Value::Null)
}
