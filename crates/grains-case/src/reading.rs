//! From the text of a case file to a checked case.

use std::path::Path;

use crate::case::Case;
use crate::check::{Checker, Names};
use crate::diagnostic::{CaseErrors, Diagnostic};
use crate::fit;
use crate::impact::fastest_impact;
use crate::meshes::Meshes;
use crate::raw::RawCase;
use crate::renamed::with_names_of_today;
use crate::sections::motion::ParticleMotion;
use crate::sections::shape::ShapeKind;
use crate::sections::wall::Wall;
use crate::sections::{bond, contact, fluid, heat, insert, material, run, shape, wall};
use crate::source::Source;
use crate::structure;
use crate::text_file::read_text;
use crate::vector::norm;

impl Case {
    /// Reads and checks a case file.
    ///
    /// # Errors
    /// Everything found wrong, in file order, or why the file cannot be read.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, CaseErrors> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let text = read_text(path)
            .map_err(|error| CaseErrors::of_file(&file, format!("cannot read the case file: {error}")))?;
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
        if source.root().contains_key("vary") && !source.root().contains_key("domain") {
            let message = format!(
                "a study, not a case: `grains-mpi sweep {file}` runs it; `case` names the case that it varies"
            );
            return Err(CaseErrors(vec![source.about("vary", message)]));
        }
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

    /// Checks the text of a case that is stored with results. Its keys may have the names of earlier versions.
    ///
    /// # Errors
    /// Everything found wrong, in file order.
    pub fn parse_stored(text: &str, file: &str, base: &Path) -> Result<Self, CaseErrors> {
        let Ok(mut case) = text.parse() else { return Self::parse(text, file, base) };
        with_names_of_today(&mut case);
        Self::parse(&case.to_string(), file, base)
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
    check_shear(&raw, checker);
    check_gravity(raw.gravity, checker);
    let output = raw.output.check(&stem, end, checker);
    let of_fluid = raw.wall.iter().filter(|wall| wall.fluid.is_some());
    let mut fluid_context = fluid::Context {
        gravity: raw.gravity,
        domain: &raw.domain,
        has_particles: !raw.insert.is_empty(),
        has_heat: raw.heat.is_some(),
        has_walls: raw.wall.iter().any(|wall| wall.fluid.is_some()),
        walls_move: raw.wall.iter().any(Wall::moves_fluid),
        fluid_walls: of_fluid.map(|wall| (wall.name.clone(), wall.moves_fluid())).collect(),
        particles_are_fixed: false,
        not_spheres,
        is_hard: raw.collisions.is_hard(),
        interval: output.particles,
        end,
    };
    let resolved = raw.fluid.as_ref().and_then(|fluid| fluid.resolved.as_ref());
    let motion = resolved.map_or(ParticleMotion::Free, |resolved| resolved.motion.into());
    let context = insert::Context {
        domain: &raw.domain,
        materials: &raw.material,
        shapes: &raw.shape,
        names: &names,
        end,
        motion,
    };
    let inserts = insert::check(raw.insert, &context, checker);
    fluid_context.particles_are_fixed = inserts.iter().all(insert::Insert::is_fixed);
    let fluid = raw.fluid.map(|fluid| fluid.check(&fluid_context, &inserts, checker));
    let walls = wall::check(raw.wall, (&raw.domain, raw.collisions.is_hard()), &names, checker);
    let fastest = fastest_impact((&raw.domain, raw.gravity), &inserts, &walls, fluid.is_some());
    let time = raw.time.check(fastest, checker);
    let bonds = bond::Context { names: &names, is_hard: raw.collisions.is_hard(), end };
    let mut case = Case {
        name: raw.name.unwrap_or_else(|| stem.to_string()),
        seed: raw.seed,
        gravity: raw.gravity,
        collisions: raw.collisions.check(checker),
        contacts: contact::check(raw.contact, &names, checker),
        bonds: bond::check(raw.bond, &bonds, checker),
        contact_points: raw.contact_points,
        shapes: shape::check(raw.shape, checker),
        inserts,
        walls,
        flow_planes: run::check_flow_planes(raw.flow_plane, &raw.domain, checker),
        heat: raw.heat,
        fluid,
        output,
        limits: raw.limits,
        stop: raw.stop.check(&names, end, checker),
        neighbours: raw.neighbours,
        domain: raw.domain,
        time,
        materials: raw.material,
        warnings: Vec::new(),
        meshes: Meshes::default(),
        written: Default::default(),
    };
    if !case.collisions.is_hard() {
        contact::check_laws(&case.contacts, &case.materials, checker);
        contact::check_budget(&case.contacts, case.contact_points.composite, checker);
    } else if let Some(i) = case.materials.iter().position(|material| material.film.is_some()) {
        let message =
            "bridges pull, and hard collisions know no forces; remove it, or set collisions.model = \"soft\"";
        checker.error(&format!("material[{i}].film"), message.into());
    }
    material::check_films(&case.materials, checker);
    heat::check(case.heat.as_ref(), &case.materials, (&case.inserts, &case.walls), checker);
    case.collisions.check_contacts(&case.contacts, checker);
    // Sizes and pairs only make sense once every name stands for something.
    if checker.error_count() == 0 {
        fit::check_sizes(&case, checker);
        fit::check_films(&case, checker);
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
    checker.names("bond", raw.bond.iter().map(|b| b.name.clone()).collect());
    checker.names("wall", raw.wall.iter().map(|w| w.name.clone()).collect());
    Names {
        materials: checker.names("material", raw.material.iter().map(|m| m.name.clone()).collect()),
        shapes: checker.names("shape", raw.shape.iter().map(|s| s.name.clone()).collect()),
        flow_planes: checker.names("flow_plane", raw.flow_plane.iter().map(|p| p.name.clone()).collect()),
    }
}

/// Refuses what a sheared box cannot hold: what has a place of its own, which images would not share.
fn check_shear(raw: &RawCase, checker: &mut Checker) {
    if raw.domain.shear.is_none() {
        return;
    }
    let mut refuse = |is_there: bool, what: &str| {
        if is_there {
            let message = format!("a sheared box holds free particles alone; remove {what}");
            checker.error("domain.shear", message);
        }
    };
    refuse(!raw.wall.is_empty(), "[[wall]]");
    refuse(!raw.flow_plane.is_empty(), "[[flow_plane]]");
    refuse(raw.fluid.is_some(), "[fluid]");
    refuse(raw.collisions.is_hard(), "collisions.model = \"hard\"");
    for (i, insert) in raw.insert.iter().enumerate() {
        let is_moved = insert.motion.as_ref().is_some_and(ParticleMotion::is_prescribed);
        refuse(is_moved, &format!("insert[{i}].motion"));
        let is_late = insert.start > 0.0 || insert.interval > 0.0;
        refuse(
            is_late,
            &format!("start and interval of insert[{i}], whose particles are there from the beginning"),
        );
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
