//! The checked case: what the program works with.

use crate::diagnostic::Diagnostic;
use crate::meshes::{Decomposition, Meshes};
use crate::raw::RawCase;
use crate::sections::bond::Bond;
use crate::sections::collisions::Collisions;
use crate::sections::contact::{self, Contact};
use crate::sections::contact_points::ContactPoints;
use crate::sections::domain::Domain;
use crate::sections::fluid::{Fluid, Resolved};
use crate::sections::heat::Heat;
use crate::sections::insert::Insert;
use crate::sections::material::Material;
use crate::sections::output::Output;
use crate::sections::run::{FlowPlane, Limits, Neighbours, Stop};
use crate::sections::shape::{Shape, ShapeKind};
use crate::sections::time::Time;
use crate::sections::wall::{Wall, WallKind};
use crate::source::Source;
use std::path::PathBuf;

/// A checked case: every value in range, every name an index, every default filled in, SI units.
///
/// Equality is that of the values; warnings, where they were found, and what is read of files do not count.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name of the case.
    pub name: String,
    /// Seed of all random numbers (-).
    pub seed: u64,
    /// Acceleration of gravity (m/s²).
    pub gravity: [f64; 3],
    /// The box of the computation.
    pub domain: Domain,
    /// Duration and time step.
    pub time: Time,
    /// Materials; their position is their index.
    pub materials: Vec<Material>,
    /// Soft or hard collisions.
    pub collisions: Collisions,
    /// Contact laws, see [`Case::contact`].
    pub contacts: Vec<Contact>,
    /// Beams between particles.
    pub bonds: Vec<Bond>,
    /// How faces and composites touch.
    pub contact_points: ContactPoints,
    /// Forms of particles; their position is their index.
    pub shapes: Vec<Shape>,
    /// Particles to insert.
    pub inserts: Vec<Insert>,
    /// Walls.
    pub walls: Vec<Wall>,
    /// Planes through which particles are counted.
    pub flow_planes: Vec<FlowPlane>,
    /// Temperatures of particles, if they have one.
    pub heat: Option<Heat>,
    /// The fluid, if there is one.
    pub fluid: Option<Fluid>,
    /// What is written, where and how often.
    pub output: Output,
    /// Limits beyond which the run ends with an error.
    pub limits: Limits,
    /// What ends the run before its time.
    pub stop: Stop,
    /// Neighbour list.
    pub neighbours: Neighbours,
    /// Values that are allowed but unlikely.
    pub warnings: Vec<Diagnostic>,
    /// Meshes of its files that are read already.
    pub meshes: Meshes,
    /// Name and text of the case file.
    pub(crate) written: (String, String),
}

impl PartialEq for Case {
    fn eq(&self, other: &Self) -> bool {
        (&self.name, self.seed, self.gravity) == (&other.name, other.seed, other.gravity)
            && (&self.domain, &self.time) == (&other.domain, &other.time)
            && self.collisions == other.collisions
            && (&self.materials, &self.contacts) == (&other.materials, &other.contacts)
            && self.bonds == other.bonds
            && self.contact_points == other.contact_points
            && (&self.shapes, &self.inserts) == (&other.shapes, &other.inserts)
            && (&self.walls, &self.flow_planes) == (&other.walls, &other.flow_planes)
            && (&self.heat, &self.fluid) == (&other.heat, &other.fluid)
            && (&self.output, &self.limits) == (&other.output, &other.limits)
            && (&self.stop, &self.neighbours) == (&other.stop, &other.neighbours)
    }
}

impl Case {
    /// A remark about a key such as `insert[0].place`, with file and line: for what shows only when the case
    /// is set up.
    pub fn about(&self, key: &str, message: impl Into<String>) -> String {
        let (file, text) = &self.written;
        match Source::parse(file, text) {
            Ok(source) => source.about(key, message.into()).to_string(),
            Err(errors) => errors.to_string(),
        }
    }

    /// The case as a case file with every default spelt out; parsing it gives an equal case.
    pub fn to_toml(&self) -> String {
        // Only a map with keys that are not strings could fail, and there is none.
        toml::to_string(&self.to_raw()).unwrap_or_default()
    }

    /// The contact law between two materials, in either order.
    ///
    /// There is one for every pair that can meet: the materials of particles with each other (given
    /// two particles) and with those of walls.
    pub fn contact(&self, a: usize, b: usize) -> Option<usize> {
        contact::find(&self.contacts, a, b)
    }

    /// Whether the flow resolves particles that all stay where they are inserted: nothing moves but the fluid.
    pub fn holds_particles(&self) -> bool {
        let resolved = self.fluid.as_ref().and_then(|fluid| fluid.resolved.as_ref());
        resolved.is_some_and(|resolved| resolved.holds_all(&self.inserts))
    }

    /// Walls that bound the fluid, with their numbers.
    pub fn walls_of_fluid(&self) -> impl Iterator<Item = (usize, &Wall)> {
        self.walls.iter().enumerate().filter(|(_, wall)| wall.fluid.is_some())
    }

    /// How the flow resolves particles or walls, if there are any.
    pub fn resolved(&self) -> Option<&Resolved> {
        let has_solids = !self.inserts.is_empty() || self.walls_of_fluid().next().is_some();
        self.fluid.as_ref().and_then(|fluid| fluid.resolved.as_ref()).filter(|_| has_solids)
    }

    /// Index of the material of this name.
    pub fn material_index(&self, name: &str) -> Option<usize> {
        self.materials.iter().position(|material| material.name == name)
    }

    /// Index of the shape of this name.
    pub fn shape_index(&self, name: &str) -> Option<usize> {
        self.shapes.iter().position(|shape| shape.name == name)
    }

    /// The files of meshes that walls and shapes of the case are made of, each once.
    pub fn mesh_files(&self) -> Vec<PathBuf> {
        let of_walls = self.walls.iter().filter_map(|wall| match &wall.kind {
            WallKind::Mesh { path, .. } => Some(path),
            _ => None,
        });
        let kinds = self.shapes.iter().flat_map(|shape| match &shape.kind {
            ShapeKind::Glued { parts } => parts.iter().map(|part| &part.kind).collect(),
            kind => vec![kind],
        });
        let of_shapes = kinds.filter_map(|kind| match kind {
            ShapeKind::HullFile { path, .. } | ShapeKind::Mesh { path, .. } => Some(path),
            _ => None,
        });
        let mut files: Vec<PathBuf> = of_walls.chain(of_shapes).cloned().collect();
        files.sort();
        files.dedup();
        files
    }

    /// The case, its meshes to be read again when they are asked for.
    pub fn without_meshes(&self) -> Self {
        Self { meshes: Meshes::default(), ..self.clone() }
    }

    /// The meshes that shapes of the case are cut from, each once.
    pub fn decompositions(&self) -> Vec<Decomposition> {
        let mut all: Vec<_> = self.shapes.iter().filter_map(|shape| shape.kind.decomposition()).collect();
        all.sort();
        all.dedup();
        all
    }

    fn to_raw(&self) -> RawCase {
        let material = |index: usize| self.materials[index].name.clone();
        let shape = |index: usize| self.shapes[index].name.clone();
        let plane = |index: usize| self.flow_planes[index].name.clone();
        let insert = |i: &Insert| {
            i.clone().rename(|_, key, index| if key == "shape" { shape(index) } else { material(index) })
        };
        RawCase {
            name: Some(self.name.clone()),
            seed: self.seed,
            gravity: self.gravity,
            domain: self.domain.clone(),
            time: self.time.to_raw(),
            material: self.materials.clone(),
            collisions: self.collisions.clone(),
            contact: self.contacts.iter().map(|c| c.clone().rename(|_, index| material(index))).collect(),
            bond: self.bonds.iter().map(|b| b.clone().rename(|_, index| material(index))).collect(),
            contact_points: self.contact_points.clone(),
            shape: self.shapes.clone(),
            insert: self.inserts.iter().map(insert).collect(),
            wall: self.walls.iter().map(|w| w.clone().rename(material)).collect(),
            flow_plane: self.flow_planes.clone(),
            heat: self.heat.clone(),
            fluid: self.fluid.clone(),
            output: self.output.to_raw(),
            limits: self.limits.clone(),
            stop: self.stop.clone().rename(plane),
            neighbours: self.neighbours.clone(),
        }
    }
}

/// A table of a case as its file has it, on one line.
pub fn inline(table: &impl serde::Serialize) -> String {
    let mut text = String::new();
    // As little could fail as of a whole case.
    let _ = table.serialize(toml::ser::ValueSerializer::new(&mut text));
    text
}
