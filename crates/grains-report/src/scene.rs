//! What the player shows: particles, walls and fluid at some times.

use crate::block::Block;
use crate::files::Case;
use crate::fluid::{self, Fluid};
use crate::particles::{self, Particles};
use crate::shapes::{self, Shape};
use crate::walls::{self, Wall};
use grains_output::FileError;
use serde::Serialize;
use std::path::Path;

/// A scene as the page reads it.
#[derive(Debug, Default, Serialize)]
pub struct Scene {
    /// Corners of the domain (m).
    lower: [f64; 3],
    upper: [f64; 3],
    /// Axes along which it is periodic.
    periodic: [bool; 3],
    /// Times of the states (s).
    times: Vec<f64>,
    particles: Option<Particles>,
    shapes: Vec<Shape>,
    materials: Vec<String>,
    walls: Vec<Wall>,
    /// Whether states or particles were left out.
    #[serde(skip)]
    pub is_thinned: bool,
    fluid: Option<Fluid>,
}

/// The scene of a directory, with particles of at most so many bytes; none without states. Files that cannot be read, and what is
/// left out, go to the notes.
pub fn read(
    directory: &Path,
    case: &Case,
    budget: usize,
    (block, notes): (&mut Block, &mut Vec<String>),
) -> Option<Scene> {
    let file = |name: &str| Some(directory.join(name)).filter(|path| path.exists());
    let mut scene = Scene {
        lower: case.lower,
        upper: case.upper,
        periodic: case.periodic,
        materials: case.materials.clone(),
        ..Scene::default()
    };
    if let Some(path) = file("particles.vtkhdf") {
        scene.shapes =
            told(shapes::read(&directory.join("shapes"), &case.shapes, block), notes).unwrap_or_default();
        let round: Vec<bool> = scene.shapes.iter().map(Shape::is_round).collect();
        if let Some(taken) = told(particles::take(&path, &round, budget, block), notes).flatten() {
            scene.times = taken.times;
            scene.particles = Some(taken.particles);
            scene.is_thinned = !taken.notes.is_empty();
            notes.extend(taken.notes);
        }
    }
    if let Some(path) = file("fluid.vtkhdf") {
        if scene.times.is_empty() {
            scene.times = told(fluid::times(&path), notes).unwrap_or_default();
        }
        let found = fluid::read(&path, &scene.times, (block, notes));
        scene.fluid = told(found, notes).flatten();
    }
    if let Some(path) = file("walls.vtkhdf").filter(|_| !scene.times.is_empty()) {
        let found = walls::read(&path, &scene.times, &case.walls, (block, notes));
        scene.walls = told(found, notes).unwrap_or_default();
    }
    (!scene.times.is_empty()).then_some(scene)
}

/// What was read; an error becomes a note.
fn told<T>(found: Result<T, FileError>, notes: &mut Vec<String>) -> Option<T> {
    found.map_err(|error| notes.push(format!("Left out: {error}."))).ok()
}
