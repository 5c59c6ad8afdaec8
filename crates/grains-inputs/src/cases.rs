//! Case files, their formulas and their tables.

use crate::{Folders, text};
use grains_case::{Case, Formula, Insert, ParticleColumns, Place};
use std::path::Path;
use std::sync::LazyLock;

/// A case whose particles stand in a table.
const CASE_OF_TABLE: &str = r#"
domain = { lower = [0, 0, 0], upper = [1, 1, 1] }
time = { end = 1 }
material = [{ name = "glass", density = 2500 }, { name = "steel", density = 7800 }, { name = "wall" }]
contact = [{ between = ["glass", "glass"], normal_stiffness = 1e4, restitution = 0.9, friction = 0.3 }]
shape = [{ name = "ball", kind = "sphere", radius = 0.01 }, { name = "cube", kind = "box", edges = [0.01, 0.01, 0.01] }]
insert = [{ name = "all", particles = [{ shape = "ball", material = "glass" }], place = { kind = "file", path = "beads.csv" } }]
"#;

/// A case file: one that is accepted says the same when it is written with all defaults and read again.
pub fn case(bytes: &[u8], folders: &Folders) -> bool {
    let Some(case) = parsed(bytes, folders) else { return false };
    let again = Case::parse(&case.to_toml(), "again.toml", Path::new("/"));
    assert_eq!(again.as_ref(), Ok(&case));
    true
}

/// A case file up to the values that `grains-mpi check` prints, if the case is a small one.
pub fn check(bytes: &[u8], folders: &Folders) -> bool {
    let Some(case) = parsed(bytes, folders) else { return false };
    is_small(&case) && grains_simulation::check::report(&case, 2).is_ok()
}

fn parsed(bytes: &[u8], folders: &Folders) -> Option<Case> {
    match Case::parse(text(bytes)?, "case.toml", &folders.given) {
        Ok(case) => Some(case),
        Err(errors) => {
            assert!(!errors.0.is_empty() && !errors.to_string().is_empty());
            None
        }
    }
}

/// Whether a case is of few particles and cells, so that its check is quick.
fn is_small(case: &Case) -> bool {
    let of_particles = |insert: &Insert| insert.count.is_some_and(|count| count <= 50);
    let cells = case.fluid.as_ref().map_or(0.0, |fluid| fluid.cells.iter().map(|&n| n as f64).product());
    case.inserts.iter().all(of_particles) && cells <= 5e3
}

/// A formula: its text, and its values at some places and times.
pub fn formula(bytes: &[u8], _: &Folders) -> bool {
    let Some(Ok(formula)) = text(bytes).map(Formula::parse) else { return false };
    for x in [0.0, -1.5, 1e300, f64::MIN_POSITIVE] {
        let value = formula.at([x, 0.5, -x], 2.0 * x);
        let again = formula.at([x, 0.5, -x], 2.0 * x);
        assert!(value == again || value.is_nan());
    }
    let _ = (formula.is_local(), formula.is_unsteady());
    true
}

/// A table of particles (CSV), read and checked against a case of spheres and cubes.
pub fn table(bytes: &[u8], _: &Folders) -> bool {
    static CASE: LazyLock<Case> = LazyLock::new(|| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../grains-case/tests/data");
        Case::parse(CASE_OF_TABLE, "table.toml", &folder).unwrap_or_else(|errors| panic!("{errors}"))
    });
    let Some(Ok(columns)) = text(bytes).map(|text| ParticleColumns::parse_csv(text, "table.csv")) else {
        return false;
    };
    let insert = CASE.inserts.iter().find(|insert| matches!(insert.place, Place::File { .. }));
    insert.is_some_and(|insert| columns.check("table.csv", &CASE, insert).is_ok())
}
