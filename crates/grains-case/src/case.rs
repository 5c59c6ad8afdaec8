//! From the text of a case file to a checked [`Case`].

use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Checker, Names, nearby_file};
use crate::diagnostic::{CaseErrors, Diagnostic};
use crate::fit;
use crate::impact::fastest_impact;
use crate::sections::collisions::Collisions;
use crate::sections::contact::{self, Contact};
use crate::sections::contact_points::ContactPoints;
use crate::sections::domain::Domain;
use crate::sections::fluid::{self, Fluid};
use crate::sections::insert::{self, Insert};
use crate::sections::material::Material;
use crate::sections::motion::ParticleMotion;
use crate::sections::output::{Field, Output, RawOutput};
use crate::sections::run::{self, FlowPlane, Limits, Neighbours, Stop};
use crate::sections::shape::{self, Shape, ShapeKind};
use crate::sections::time::{RawTime, Time};
use crate::sections::wall::{self, Wall};
use crate::source::Source;
use crate::structure;
use crate::vector::norm;

/// A case as written in the file, with keys and ranges checked but names unresolved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "grains-mpi case file", rename = "Case")]
#[schemars(extend(
    "if" = {"not": {"required": ["fluid"]}},
    "then" = {"required": ["material", "shape", "insert"]}
))]
pub struct RawCase {
    /// Name of the case; the name of the file by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Seed (-): random numbers depend on it and on the particle's id alone.
    #[serde(default = "first_seed")]
    #[schemars(extend("minimum" = 0))]
    pub seed: u64,
    /// Acceleration of gravity (m/s²).
    #[serde(default = "downwards")]
    pub gravity: [f64; 3],
    /// The box of the computation.
    pub domain: Domain,
    /// Duration and time step.
    pub time: RawTime,
    /// Materials.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub material: Vec<Material>,
    /// Soft or hard collisions.
    #[serde(default)]
    pub collisions: Collisions,
    /// Contact laws, one per pair of materials that can meet.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub contact: Vec<Contact<String>>,
    /// How faces and composites touch.
    #[serde(default)]
    pub contact_points: ContactPoints,
    /// Forms of particles.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shape: Vec<Shape>,
    /// Particles to insert.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub insert: Vec<Insert<String>>,
    /// Walls.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub wall: Vec<Wall<String>>,
    /// Planes through which particles are counted.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub flow_plane: Vec<FlowPlane>,
    /// The fluid, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fluid: Option<Fluid>,
    /// What is written, where and how often.
    #[serde(default = "default_output")]
    pub output: RawOutput,
    /// Limits beyond which the run ends with an error.
    #[serde(default)]
    pub limits: Limits,
    /// What ends the run before its time.
    #[serde(default)]
    pub stop: Stop<String>,
    /// Neighbour list.
    #[serde(default)]
    pub neighbours: Neighbours,
}

fn first_seed() -> u64 {
    1
}

fn downwards() -> [f64; 3] {
    [0.0, 0.0, -9.81]
}

fn default_output() -> RawOutput {
    RawOutput { keep_checkpoints: 2, fields: Field::ALL.to_vec(), ..RawOutput::default() }
}

/// A checked case: every value in range, every name an index, every default filled in, SI units.
///
/// Equality is that of the values; warnings and where they were found do not count.
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
    /// Name and text of the case file.
    written: (String, String),
}

impl PartialEq for Case {
    fn eq(&self, other: &Self) -> bool {
        (&self.name, self.seed, self.gravity) == (&other.name, other.seed, other.gravity)
            && (&self.domain, &self.time) == (&other.domain, &other.time)
            && self.collisions == other.collisions
            && (&self.materials, &self.contacts) == (&other.materials, &other.contacts)
            && self.contact_points == other.contact_points
            && (&self.shapes, &self.inserts) == (&other.shapes, &other.inserts)
            && (&self.walls, &self.flow_planes) == (&other.walls, &other.flow_planes)
            && self.fluid == other.fluid
            && (&self.output, &self.limits) == (&other.output, &other.limits)
            && (&self.stop, &self.neighbours) == (&other.stop, &other.neighbours)
    }
}

impl Case {
    /// Reads and checks a case file.
    ///
    /// # Errors
    /// Everything found wrong, in file order, or why the file cannot be read.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, CaseErrors> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|error| {
            let remedy = match nearby_file(path) {
                Some(name) if !path.exists() => format!("; did you mean `{name}`, which is in that folder?"),
                _ => String::new(),
            };
            CaseErrors::of_file(&file, format!("cannot read the case file: {error}{remedy}"))
        })?;
        Self::parse(&text, &file, path.parent().unwrap_or(Path::new("")))
    }

    /// Checks the text of a case file.
    ///
    /// `file` is its name for messages and defaults, `base` the folder to which paths in it refer.
    ///
    /// # Errors
    /// Everything found wrong, in file order.
    pub fn parse(text: &str, file: &str, base: &Path) -> Result<Self, CaseErrors> {
        let source = Source::parse(file, text)?;
        let mut checker = Checker::new(&source, base);
        let case = structure::read(&mut checker).map(|raw| resolve(raw, file, &mut checker));
        let Checker { mut errors, mut warnings, .. } = checker;
        in_file_order(&mut errors);
        in_file_order(&mut warnings);
        match case {
            Some(case) if errors.is_empty() => {
                Ok(Self { warnings, written: (file.to_owned(), text.to_owned()), ..case })
            }
            _ => Err(CaseErrors(errors)),
        }
    }

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

    /// Index of the material of this name.
    pub fn material_index(&self, name: &str) -> Option<usize> {
        self.materials.iter().position(|material| material.name == name)
    }

    /// Index of the shape of this name.
    pub fn shape_index(&self, name: &str) -> Option<usize> {
        self.shapes.iter().position(|shape| shape.name == name)
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
            contact_points: self.contact_points.clone(),
            shape: self.shapes.clone(),
            insert: self.inserts.iter().map(insert).collect(),
            wall: self.walls.iter().map(|w| w.clone().rename(material)).collect(),
            flow_plane: self.flow_planes.clone(),
            fluid: self.fluid.clone(),
            output: self.output.to_raw(),
            limits: self.limits.clone(),
            stop: self.stop.clone().rename(plane),
            neighbours: self.neighbours.clone(),
        }
    }
}

/// Sorts remarks by place and drops those said twice.
fn in_file_order(remarks: &mut Vec<Diagnostic>) {
    remarks.sort_by_key(|r| (r.line, r.column));
    remarks.dedup();
}

/// Names of the shapes that are inserted and no spheres.
fn names_of_other_shapes(raw: &RawCase) -> Vec<String> {
    let others = raw.shape.iter().filter(|shape| !matches!(shape.kind, ShapeKind::Sphere { .. }));
    let inserted = |name: &String| raw.insert.iter().flat_map(|i| &i.particles).any(|p| p.shape == *name);
    others.map(|shape| shape.name.clone()).filter(inserted).collect()
}

/// Resolves names and defaults and checks what the schema cannot express.
fn resolve(raw: RawCase, file: &str, checker: &mut Checker) -> Case {
    let stem = Path::new(file).file_stem().map_or("case".into(), |s| s.to_string_lossy());
    let names = check_names(&raw, checker);
    let end = raw.time.end;
    let not_spheres = names_of_other_shapes(&raw);
    raw.domain.check(checker);
    check_gravity(raw.gravity, checker);
    let output = raw.output.check(&stem, end, checker);
    let fluid_context = fluid::Context {
        domain: &raw.domain,
        has_particles: !raw.insert.is_empty(),
        not_spheres,
        is_hard: raw.collisions.is_hard(),
        interval: output.particles,
        end,
    };
    let resolved = raw.fluid.as_ref().and_then(|fluid| fluid.resolved.as_ref());
    let motion = resolved.map_or(ParticleMotion::Free, |resolved| resolved.motion.into());
    let context =
        insert::Context { domain: &raw.domain, materials: &raw.material, names: &names, end, motion };
    let inserts = insert::check(raw.insert, &context, checker);
    let fluid = raw.fluid.map(|fluid| fluid.check(&fluid_context, &inserts, checker));
    let walls = wall::check(raw.wall, &raw.domain, &names, checker);
    let fastest = fastest_impact((&raw.domain, raw.gravity), &inserts, &walls, fluid.is_some());
    let time = raw.time.check(fastest, checker);
    let mut case = Case {
        name: raw.name.unwrap_or_else(|| stem.to_string()),
        seed: raw.seed,
        gravity: raw.gravity,
        collisions: raw.collisions.check(checker),
        contacts: contact::check(raw.contact, &names, checker),
        contact_points: raw.contact_points,
        shapes: shape::check(raw.shape, checker),
        inserts,
        walls,
        flow_planes: run::check_flow_planes(raw.flow_plane, &raw.domain, checker),
        fluid,
        output,
        limits: raw.limits,
        stop: raw.stop.check(&names, end, checker),
        neighbours: raw.neighbours,
        domain: raw.domain,
        time,
        materials: raw.material,
        warnings: Vec::new(),
        written: Default::default(),
    };
    case.collisions.check_contacts(&case.contacts, checker);
    // Sizes and pairs only make sense once every name stands for something.
    if checker.error_count() == 0 {
        fit::check_sizes(&case, checker);
        fit::check_pairs(&case, checker);
        fit::check_fluid(&case, checker);
    }
    if checker.error_count() == 0 {
        for (i, insert) in case.inserts.iter_mut().enumerate() {
            insert.check_lattice(&format!("insert[{i}]"), &case.shapes, checker);
        }
    }
    case
}

/// Checks every name and keeps those that others refer to.
fn check_names(raw: &RawCase, checker: &mut Checker) -> Names {
    checker.names("insert", raw.insert.iter().map(|i| i.name.clone()).collect());
    checker.names("wall", raw.wall.iter().map(|w| w.name.clone()).collect());
    Names {
        materials: checker.names("material", raw.material.iter().map(|m| m.name.clone()).collect()),
        shapes: checker.names("shape", raw.shape.iter().map(|s| s.name.clone()).collect()),
        flow_planes: checker.names("flow_plane", raw.flow_plane.iter().map(|p| p.name.clone()).collect()),
    }
}

fn check_gravity(gravity: [f64; 3], checker: &mut Checker) {
    let magnitude = norm(gravity);
    if magnitude > 100.0 {
        checker.warn("gravity", format!("{magnitude} m/s² is ten times that of the Earth or more"));
    }
    if gravity[2] > 0.0 {
        checker.warn("gravity", "points up (+z); on the Earth it is [0, 0, -9.81]".into());
    }
}
