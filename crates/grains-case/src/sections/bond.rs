//! `[[bond]]`: elastic beams between particles.

use std::path::{Path, PathBuf};

use grains_contact::BeamShear;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Checker, Names};
use crate::csv_numbers;

/// The columns of a table of pairs.
const COLUMNS: [&str; 2] = ["id1", "id2"];

/// Beams that join the centres of near particles from one moment on, until they break.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Bond")]
pub struct Bond<Name = usize> {
    /// Name of the bonds.
    pub name: String,
    /// Materials of the two particles, in any order: all near pairs of these are bonded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub between: Option<[Name; 2]>,
    /// CSV file of the pairs instead, with columns `id1` and `id2`: ids as in the snapshots.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path: Option<PathBuf>,
    /// Time at which they are made (s).
    #[serde(default)]
    #[schemars(extend("minimum" = 0))]
    pub at: f64,
    /// Largest gap (m) at which two particles are bonded, that of their bounding spheres if they are no spheres.
    #[schemars(extend("minimum" = 0, "x-plausible" = [0, 0.1]))]
    pub distance: f64,
    /// Radius of their circular section (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-8, 1]))]
    pub radius: Option<f64>,
    /// The same over the radius of the smaller particle (-), that of its bounding sphere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 2, "x-plausible" = [0.05, 1]))]
    pub radius_ratio: Option<f64>,
    /// Young's modulus E of the beams (Pa).
    #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e4, 2e12]))]
    pub youngs_modulus: f64,
    /// Poisson's ratio ν of the beams (-): shear modulus E/(2 (1 + ν)).
    #[schemars(extend("minimum" = 0, "maximum" = 0.5))]
    pub poissons_ratio: f64,
    /// What their stiffness against shear is made of.
    #[serde(default)]
    pub shear: BeamShear,
    /// Dashpots, as a share of critical damping (-).
    #[serde(default = "usual_damping")]
    #[schemars(extend("minimum" = 0, "maximum" = 1))]
    pub damping_ratio: f64,
    /// Tensile stress (Pa) at which a beam breaks, tension and bending together.
    #[serde(default = "super::infinity")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-infinite" = true, "x-plausible" = [1e2, 1e11]))]
    pub tensile_strength: f64,
    /// Shear stress (Pa) at which a beam breaks, shear and torsion together.
    #[serde(default = "super::infinity")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-infinite" = true, "x-plausible" = [1e2, 1e11]))]
    pub shear_strength: f64,
    /// The pairs of the file, the lower id first, sorted.
    #[serde(skip)]
    pub pairs: Vec<[u64; 2]>,
}

fn usual_damping() -> f64 {
    0.1
}

impl<Name> Bond<Name> {
    /// The same with its materials named otherwise.
    pub(crate) fn rename<Other>(self, mut name: impl FnMut(usize, Name) -> Other) -> Bond<Other> {
        let mut side = 0..;
        Bond {
            between: self.between.map(|pair| pair.map(|n| name(side.next().unwrap_or_default(), n))),
            name: self.name,
            path: self.path,
            at: self.at,
            distance: self.distance,
            radius: self.radius,
            radius_ratio: self.radius_ratio,
            youngs_modulus: self.youngs_modulus,
            poissons_ratio: self.poissons_ratio,
            shear: self.shear,
            damping_ratio: self.damping_ratio,
            tensile_strength: self.tensile_strength,
            shear_strength: self.shear_strength,
            pairs: self.pairs,
        }
    }
}

/// What a check of bonds needs to know of the rest of the case.
pub(crate) struct Context<'a> {
    pub names: &'a Names,
    pub is_hard: bool,
    /// End of the run (s).
    pub end: f64,
}

/// Resolves names, reads tables, and refuses bonds that are not described once and whole.
pub(crate) fn check(raw: Vec<Bond<String>>, context: &Context, checker: &mut Checker) -> Vec<Bond> {
    let mut bonds = Vec::new();
    for (i, bond) in raw.into_iter().enumerate() {
        let key = |name: &str| format!("bond[{i}].{name}");
        let mut bond = bond.rename(|side, name| {
            let key = format!("bond[{i}].between[{side}]");
            checker.reference(&key, &name, "material", &context.names.materials)
        });
        if context.is_hard {
            let message = "takes forces; remove it, or set collisions.model = \"soft\"";
            checker.error(&format!("bond[{i}]"), message.into());
        }
        let given = [bond.between.is_some(), bond.path.is_some()];
        let what = "The two materials whose near particles are bonded; or path, a table of pairs";
        check_either(given, [key("between"), key("path")], what, checker);
        let given = [bond.radius.is_some(), bond.radius_ratio.is_some()];
        let what = "Radius of the section of a beam (m); or radius_ratio, over the smaller particle's";
        check_either(given, [key("radius"), key("radius_ratio")], what, checker);
        if bond.at >= context.end {
            checker.error(&key("at"), format!("must be before time.end = {} s", context.end));
        }
        if let Some(file) = &mut bond.path {
            let errors = checker.error_count();
            *file = checker.file(&key("path"), file, &["csv"]);
            if checker.error_count() == errors {
                match read(file) {
                    Ok(pairs) => bond.pairs = pairs,
                    Err(message) => checker.error(&key("path"), message),
                }
            }
        }
        bonds.push(bond);
    }
    bonds
}

/// Refuses both of two keys, and none of them.
fn check_either(given: [bool; 2], [key, other]: [String; 2], what: &str, checker: &mut Checker) {
    match given {
        [false, false] => checker.error(&key, format!("missing key. {what}")),
        [true, true] => {
            let name = key.rsplit('.').next().unwrap_or(&key);
            checker.error(&other, format!("excludes {name}; remove one or the other"));
        }
        _ => {}
    }
}

/// The pairs of a file, the lower id first, sorted.
fn read(file: &Path) -> Result<Vec<[u64; 2]>, String> {
    let mut pairs = Vec::new();
    for (row, ids) in csv_numbers::read(file, &COLUMNS)?.into_iter().enumerate() {
        let [Some(a), Some(b)] = ids else { return Err("the file lacks a column id1 or id2".into()) };
        let is_id = |id: f64| (0.0..9e15).contains(&id) && id.fract() == 0.0;
        if !is_id(a) || !is_id(b) || a == b {
            return Err(format!("row {} bonds {a} and {b}: two different ids are wanted", row + 1));
        }
        pairs.push([a.min(b) as u64, a.max(b) as u64]);
    }
    pairs.sort_unstable();
    match pairs.windows(2).find(|two| two[0] == two[1]) {
        _ if pairs.is_empty() => Err("the file holds no pair".into()),
        Some([[a, b], _]) => Err(format!("the pair {a}, {b} is there twice")),
        _ => Ok(pairs),
    }
}
