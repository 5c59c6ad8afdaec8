//! `[[fluid.boundary]]`: what holds on the faces of the domain.

use grains_fluid::FanCurve;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::outline::{Part, Wants};
use super::{Expression, Fluid, check_formula};
use crate::check::Checker;
use crate::sections::domain::{Domain, Face};

/// What holds on a face of the domain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
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
    /// A stated flow into the domain, normal to the face, through what walls leave open of the inlet.
    FlowInlet {
        /// Mass flow (kg/s), a number or a formula in t.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        mass_flow: Option<Expression>,
        /// Volume flow (m³/s), in its place.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        volume_flow: Option<Expression>,
        /// How it is distributed.
        #[serde(default)]
        profile: FlowProfile,
    },
    /// Imposed total pressure: p0 - density u²/2 where fluid enters, along the normal, and p0 where it leaves.
    PressureInlet {
        /// Total pressure p0 without its hydrostatic part (Pa); of a fan that on its suction side.
        pressure: f64,
        /// Pressure rise of a fan over the flow it lets in: points (m³/s, Pa), of ascending flow and pressures that do not rise.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        fan: Option<Vec<[f64; 2]>>,
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

/// How a stated flow is distributed over its inlet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FlowProfile {
    /// Evenly.
    #[default]
    Uniform,
    /// As a parabola, 0 at the edges.
    Parabolic,
}

impl BoundaryKind {
    /// Whether it imposes a pressure, so that fluid may come and go as it likes.
    pub fn imposes_pressure(&self) -> bool {
        matches!(self, BoundaryKind::Outlet { .. } | BoundaryKind::PressureInlet { .. })
    }

    /// Whether it imposes what flows in.
    pub fn imposes_flow(&self) -> bool {
        matches!(
            self,
            BoundaryKind::Inlet { .. } | BoundaryKind::ParabolicInlet { .. } | BoundaryKind::FlowInlet { .. }
        )
    }

    /// The stated flow of a flow inlet, and what of it is a volume flow (m³/s), of a density (kg/m³).
    pub fn flow(&self, density: f64) -> Option<(&Expression, f64)> {
        match self {
            BoundaryKind::FlowInlet { volume_flow: Some(flow), .. } => Some((flow, 1.0)),
            BoundaryKind::FlowInlet { mass_flow: Some(flow), .. } => Some((flow, 1.0 / density)),
            _ => None,
        }
    }

    /// Whether the velocity is a parabola across the inlet.
    pub fn is_parabolic(&self) -> bool {
        matches!(
            self,
            BoundaryKind::ParabolicInlet { .. }
                | BoundaryKind::FlowInlet { profile: FlowProfile::Parabolic, .. }
        )
    }
}

/// A boundary condition, of a whole face or of a part of it; walls at rest elsewhere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(extend("unevaluatedProperties" = false))]
pub struct Boundary {
    /// The face: "-x", "+x", "-y", "+y", "-z" or "+z".
    pub face: Face,
    /// The condition.
    #[serde(flatten)]
    pub kind: BoundaryKind,
    /// Where on the face it holds, if not on the whole.
    #[serde(flatten)]
    pub part: Part,
}

/// Which of [`Fluid::boundary`] hold somewhere on a face.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OnFace {
    /// That of the whole face; a wall at rest if there is none.
    pub whole: Option<usize>,
    /// Those of parts; later ones hold where several do.
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
            if boundary.part.is_whole() {
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
            self.boundary[k].part.outline().is_some_and(|outline| outline.holds(face.axis(), place))
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
        let wants = Wants { parabola: boundary.kind.is_parabolic(), cells: !boundary.kind.imposes_flow() };
        boundary.part.check(boundary.face, wants, &path, fluid, domain, checker);
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
        BoundaryKind::FlowInlet { mass_flow, volume_flow, .. } => {
            let flows = [("mass_flow", mass_flow), ("volume_flow", volume_flow)];
            match (mass_flow, volume_flow) {
                (None, None) => {
                    checker
                        .error(&format!("{path}.mass_flow"), "missing key; state this or volume_flow".into());
                }
                (Some(_), Some(_)) => checker.error(
                    &format!("{path}.volume_flow"),
                    "the flow is stated twice; remove this or mass_flow".into(),
                ),
                _ => {}
            }
            for (key, flow) in flows.into_iter().filter_map(|(key, flow)| Some((key, flow.as_ref()?))) {
                let path = format!("{path}.{key}");
                check_formula(flow, &path, domain, checker);
                if flow.compile().is_ok_and(|formula| formula.is_local()) {
                    checker.error(
                        &path,
                        "a flow is that of the whole inlet; use t alone, or an inlet with a velocity".into(),
                    );
                }
            }
        }
        BoundaryKind::PressureInlet { fan: Some(points), .. } => {
            if let Err(fault) = FanCurve::new(points.clone()) {
                checker.error(&format!("{path}.fan"), fault);
            }
        }
        BoundaryKind::PressureInlet { fan: None, .. }
        | BoundaryKind::ParabolicInlet { .. }
        | BoundaryKind::Outlet { .. }
        | BoundaryKind::Symmetry => {}
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
            match inflow(&fluid.boundary[i], fluid.density, domain) {
                Inflow::Rate(rate) => rates.push((i, rate)),
                Inflow::Balanced => {}
                Inflow::Unknown => return,
            }
        }
    }
    let sums = |sign: f64| rates.iter().map(|r| (sign * r.1).max(0.0)).sum::<f64>();
    let (inwards, outwards) = (sums(1.0), sums(-1.0));
    let (net, gross) = (inwards - outwards, inwards + outwards);
    // Parts may overlap, and walls may cover them: only their signs are sure.
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

fn inflow(boundary: &Boundary, density: f64, domain: &Domain) -> Inflow {
    let axis = boundary.face.axis();
    let inwards = if boundary.face.is_upper() { -1.0 } else { 1.0 };
    let speed = match &boundary.kind {
        BoundaryKind::Outlet { .. } | BoundaryKind::PressureInlet { .. } => return Inflow::Unknown,
        kind @ BoundaryKind::FlowInlet { .. } => {
            return match kind.flow(density) {
                Some((Expression::Number(flow), factor)) => Inflow::Rate(flow * factor),
                _ => Inflow::Unknown,
            };
        }
        BoundaryKind::Wall { .. } | BoundaryKind::Symmetry => return Inflow::Balanced,
        BoundaryKind::ParabolicInlet { mean } => *mean,
        BoundaryKind::Inlet { velocity } => match velocity[axis] {
            Expression::Number(normal) => inwards * normal,
            Expression::Formula(_) => return Inflow::Unknown,
        },
    };
    let whole = || (0..3).filter(|a| *a != axis).map(|a| domain.extents()[a]).product();
    Inflow::Rate(speed * boundary.part.outline().map_or_else(whole, |outline| outline.area(axis)))
}
