//! `[[fluid.boundary]]`: what holds on the faces of the domain.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Expression, Fluid, check_formula};
use crate::check::Checker;
use crate::sections::domain::{Domain, Face};

/// What holds on a face of the domain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum BoundaryKind {
    /// No slip.
    Wall {
        /// Velocity of the wall along itself (m/s).
        #[serde(default)]
        velocity: [f64; 3],
    },
    /// Imposed velocity; among particles the superficial one, as if nothing were behind the face.
    Inlet {
        /// Velocity (m/s), each component a number or a formula in x, y, z, t.
        velocity: [Expression; 3],
    },
    /// Imposed velocity, a parabola across the inlet.
    ParabolicInlet {
        /// Mean speed into the domain (m/s).
        mean: f64,
    },
    /// Imposed pressure.
    Outlet {
        /// Pressure without its hydrostatic part (Pa).
        #[serde(default)]
        pressure: f64,
    },
    /// No flow through and no shear.
    Symmetry,
}

/// A boundary condition, of a whole face or of a rectangle of it; walls at rest elsewhere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(extend("unevaluatedProperties" = false))]
pub struct Boundary {
    /// The face: "-x", "+x", "-y", "+y", "-z" or "+z".
    pub face: Face,
    /// The condition.
    #[serde(flatten)]
    pub kind: BoundaryKind,
    /// Lower corner of the rectangle (m); the coordinate normal to the face is not read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lower: Option<[f64; 3]>,
    /// Upper corner of the rectangle (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub upper: Option<[f64; 3]>,
}

impl Boundary {
    /// Lower and upper corner (m) of the rectangle, if it is not the whole face.
    pub fn patch(&self) -> Option<[[f64; 3]; 2]> {
        Some([self.lower?, self.upper?])
    }

    fn is_whole(&self) -> bool {
        self.lower.is_none() && self.upper.is_none()
    }
}

/// Which of [`Fluid::boundary`] hold somewhere on a face.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OnFace {
    /// That of the whole face; a wall at rest if there is none.
    pub whole: Option<usize>,
    /// Those of rectangles; later ones hold where several do.
    pub patches: Vec<usize>,
}

impl OnFace {
    /// All of them.
    pub(super) fn all(&self) -> impl Iterator<Item = usize> + '_ {
        self.whole.into_iter().chain(self.patches.iter().copied())
    }
}

impl Fluid {
    /// The conditions of a face: a later one of the whole face leaves nothing of those before it.
    pub fn on_face(&self, face: Face) -> OnFace {
        let mut on_face = OnFace::default();
        for (i, boundary) in self.boundary.iter().enumerate().filter(|(_, b)| b.face == face) {
            if boundary.is_whole() {
                on_face = OnFace { whole: Some(i), patches: Vec::new() };
            } else {
                on_face.patches.push(i);
            }
        }
        on_face
    }

    /// Which condition holds at a place (m) of a face; none at the walls elsewhere.
    pub fn boundary_at(&self, face: Face, place: [f64; 3]) -> Option<usize> {
        let on_face = self.on_face(face);
        let holds = |&&k: &&usize| {
            let Some([lower, upper]) = self.boundary[k].patch() else { return false };
            (0..3).filter(|&a| a != face.axis()).all(|a| (lower[a]..=upper[a]).contains(&place[a]))
        };
        on_face.patches.iter().rev().find(holds).copied().or(on_face.whole)
    }
}

/// Checks every condition by itself, and whether the fluid that enters can leave.
pub(super) fn check(fluid: &Fluid, domain: &Domain, checker: &mut Checker) {
    let errors_before = checker.error_count();
    for (i, boundary) in fluid.boundary.iter().enumerate() {
        let path = format!("fluid.boundary[{i}]");
        let axis = boundary.face.axis();
        if domain.periodic[axis] {
            let name = ["x", "y", "z"][axis];
            checker.error(
                &format!("{path}.face"),
                format!(
                    "no boundary there: {name} is periodic; remove the condition or domain.periodic[{axis}]"
                ),
            );
            continue;
        }
        check_kind(boundary, &path, domain, checker);
        check_patch(boundary, &path, fluid, domain, checker);
        let on_face = fluid.on_face(boundary.face);
        if !on_face.all().any(|j| j == i) {
            let later = on_face.whole.unwrap_or_default();
            checker.warn(
                &format!("{path}.face"),
                format!("without effect: fluid.boundary[{later}] holds on the whole face"),
            );
        }
    }
    if checker.error_count() == errors_before && domain.is_upright() {
        check_inflow(fluid, domain, checker);
    }
}

fn check_kind(boundary: &Boundary, path: &str, domain: &Domain, checker: &mut Checker) {
    match &boundary.kind {
        BoundaryKind::Wall { velocity } => {
            let axis = boundary.face.axis();
            if velocity[axis] != 0.0 {
                checker.error(
                    &format!("{path}.velocity[{axis}]"),
                    format!(
                        "a wall moves along itself only, on {} this must be 0; flow through it is an inlet",
                        boundary.face.name()
                    ),
                );
            }
        }
        BoundaryKind::Inlet { velocity } => {
            for (c, component) in velocity.iter().enumerate() {
                check_formula(component, &format!("{path}.velocity[{c}]"), domain, checker);
            }
        }
        BoundaryKind::ParabolicInlet { .. } | BoundaryKind::Outlet { .. } | BoundaryKind::Symmetry => {}
    }
}

/// A rectangle has two corners in order, lies on the face, and holds the centre of a cell unless it is an inlet.
fn check_patch(boundary: &Boundary, path: &str, fluid: &Fluid, domain: &Domain, checker: &mut Checker) {
    let (lower, upper) = match (boundary.lower, boundary.upper) {
        (None, None) => return,
        (Some(lower), Some(upper)) => (lower, upper),
        (lower, _) => {
            let missing = if lower.is_none() { "lower" } else { "upper" };
            let message = "missing key; a rectangle has both corners, the whole face none".into();
            return checker.error(&format!("{path}.{missing}"), message);
        }
    };
    let is_inlet = matches!(boundary.kind, BoundaryKind::Inlet { .. } | BoundaryKind::ParabolicInlet { .. });
    for a in (0..3).filter(|a| *a != boundary.face.axis()) {
        let [low, high] = [domain.lower[a], domain.upper[a]];
        // What is written as the corner of the domain must not be outside by rounding.
        let slack = 1e-9 * (high - low);
        if lower[a] >= upper[a] {
            checker
                .error(&format!("{path}.upper[{a}]"), format!("must be above lower[{a}] = {} m", lower[a]));
        } else if domain.is_upright() && lower[a] < low - slack {
            checker
                .error(&format!("{path}.lower[{a}]"), format!("outside the domain, which begins at {low} m"));
        } else if domain.is_upright() && upper[a] > high + slack {
            checker
                .error(&format!("{path}.upper[{a}]"), format!("outside the domain, which ends at {high} m"));
        } else if domain.is_upright() && !is_inlet && !fluid.has_centre_in(domain, a, [lower[a], upper[a]]) {
            checker.error(
                &format!("{path}.upper[{a}]"),
                format!(
                    "no cell has its centre between {} and {} m; widen the rectangle or raise fluid.cells[{a}]",
                    lower[a], upper[a]
                ),
            );
        }
    }
}

/// Without an outlet, what flows in must flow out; formulas are left to the run.
fn check_inflow(fluid: &Fluid, domain: &Domain, checker: &mut Checker) {
    let mut rates: Vec<(usize, f64)> = Vec::new();
    let mut has_patches = false;
    for face in domain.open_faces() {
        let on_face = fluid.on_face(face);
        has_patches |= !on_face.patches.is_empty();
        for i in on_face.all() {
            match inflow(&fluid.boundary[i], domain) {
                Inflow::Rate(rate) => rates.push((i, rate)),
                Inflow::Balanced => {}
                Inflow::Unknown => return,
            }
        }
    }
    let sums = |sign: f64| rates.iter().map(|r| (sign * r.1).max(0.0)).sum::<f64>();
    let (inwards, outwards) = (sums(1.0), sums(-1.0));
    let (net, gross) = (inwards - outwards, inwards + outwards);
    // Rectangles may overlap and are cut by cells: only their signs are sure.
    let is_sure = !has_patches || inwards == 0.0 || outwards == 0.0;
    if !is_sure || net.abs() <= 1e-9 * gross {
        return;
    }
    let (first, _) = rates.iter().find(|r| r.1 * net > 0.0).copied().unwrap_or_default();
    let (verb, other) = if net > 0.0 { ("enter", "lets them out") } else { ("leave", "lets others in") };
    checker.error(
        &format!("fluid.boundary[{first}].kind"),
        format!(
            "an inlet faces a closed box: {:.3e} m³/s more {verb} and nothing {other}; add [[fluid.boundary]] with \
             kind = \"outlet\", or balance the inlets",
            net.abs()
        ),
    );
}

/// What comes in through a part of the boundary.
enum Inflow {
    /// This much (m³/s).
    Rate(f64),
    /// Nothing.
    Balanced,
    /// What balances the rest, or a formula.
    Unknown,
}

fn inflow(boundary: &Boundary, domain: &Domain) -> Inflow {
    let axis = boundary.face.axis();
    let inwards = if boundary.face.is_upper() { -1.0 } else { 1.0 };
    let speed = match &boundary.kind {
        BoundaryKind::Outlet { .. } => return Inflow::Unknown,
        BoundaryKind::Wall { .. } | BoundaryKind::Symmetry => return Inflow::Balanced,
        BoundaryKind::ParabolicInlet { mean } => *mean,
        BoundaryKind::Inlet { velocity } => match velocity[axis] {
            Expression::Number(normal) => inwards * normal,
            Expression::Formula(_) => return Inflow::Unknown,
        },
    };
    let [lower, upper] = boundary.patch().unwrap_or([domain.lower, domain.upper]);
    Inflow::Rate(speed * (0..3).filter(|a| *a != axis).map(|a| upper[a] - lower[a]).product::<f64>())
}
