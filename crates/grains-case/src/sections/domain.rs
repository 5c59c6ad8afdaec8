//! `[domain]`: the box of the computation.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::yes;
use crate::check::Checker;

/// A face of the domain, named by its outward direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Face {
    /// Lower x.
    #[serde(rename = "-x")]
    LowerX,
    /// Upper x.
    #[serde(rename = "+x")]
    UpperX,
    /// Lower y.
    #[serde(rename = "-y")]
    LowerY,
    /// Upper y.
    #[serde(rename = "+y")]
    UpperY,
    /// Lower z.
    #[serde(rename = "-z")]
    LowerZ,
    /// Upper z.
    #[serde(rename = "+z")]
    UpperZ,
}

impl Face {
    /// All of them, lower before upper.
    pub const ALL: [Self; 6] =
        [Self::LowerX, Self::UpperX, Self::LowerY, Self::UpperY, Self::LowerZ, Self::UpperZ];

    /// Axis the face is normal to: 0, 1 or 2.
    pub fn axis(self) -> usize {
        self as usize / 2
    }

    /// Whether the face is the upper one of its axis.
    pub fn is_upper(self) -> bool {
        self as usize % 2 == 1
    }

    /// The face as a case file names it.
    pub fn name(self) -> &'static str {
        ["-x", "+x", "-y", "+y", "-z", "+z"][self as usize]
    }
}

/// An axis of coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// x.
    X,
    /// y.
    Y,
    /// z.
    Z,
}

impl Axis {
    /// The axis as a case file names it.
    pub fn name(self) -> &'static str {
        ["x", "y", "z"][self as usize]
    }
}

/// Simple shear of a box that is periodic along flow and gradient: its images across the gradient slide along the flow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Shear {
    /// Axis along which the particles flow: "x", "y" or "z".
    pub flow: Axis,
    /// Axis along which the velocity grows.
    pub gradient: Axis,
    /// Rate (1/s): velocity per height.
    pub rate: f64,
}

/// The box that holds all particles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// Lower corner (m).
    pub lower: [f64; 3],
    /// Upper corner (m), above the lower one along every axis.
    pub upper: [f64; 3],
    /// Whether what leaves through one face of an axis enters at the other, per axis (x, y, z).
    #[serde(default)]
    pub periodic: [bool; 3],
    /// Simple shear of the particles; the box is not divided along the flow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shear: Option<Shear>,
    /// Faces through which particles may leave; anywhere else a leaving particle is an error.
    #[serde(default)]
    pub outlets: Vec<Face>,
    /// Number of ranks along each axis (-); chosen by the program if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(schema_with = "ranks_per_axis")]
    pub ranks: Option<[u64; 3]>,
    /// Whether borders between ranks move to where the work is; the cells of a fluid follow them.
    #[serde(default = "yes")]
    pub balance: bool,
    /// How ranks tell each other of particles near their borders; the results are the same.
    #[serde(default)]
    pub exchange: Exchange,
}

/// How ranks tell each other, in every step, of particles near their borders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Exchange {
    /// Each tells all others of all of them, by one collective call (Rakotonirina 2016: AllGatherGlobal).
    AllGatherGlobal,
    /// Each tells its neighbours of all of them, by one neighbourhood collective (AllGatherLocal).
    AllGatherLocal,
    /// The same by sends that do not wait.
    AllGatherLocalNonblocking,
    /// Each tells a neighbour of those it needs, by sends that do not wait (SendRecv_Local_Geoloc).
    SendRecvLocalGeoloc,
    /// The same by messages prepared once for many steps, while contacts within the rank are worked on.
    #[default]
    Persistent,
}

fn ranks_per_axis(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({
        "type": "array", "minItems": 3, "maxItems": 3,
        "items": {"type": "integer", "minimum": 1, "maximum": 1_000_000}
    })
}

impl Domain {
    /// Edges of the box (m).
    pub fn extents(&self) -> [f64; 3] {
        [0, 1, 2].map(|a| self.upper[a] - self.lower[a])
    }

    /// Reports a point (m) that must lie in the domain and does not.
    pub(crate) fn must_hold(&self, checker: &mut Checker, path: &str, point: [f64; 3]) {
        if self.is_upright() && !self.contains(point) {
            checker.error(path, format!("outside the domain {:?} to {:?} m", self.lower, self.upper));
        }
    }

    /// Whether a point (m) lies in the box, faces included.
    pub fn contains(&self, point: [f64; 3]) -> bool {
        (0..3).all(|a| self.lower[a] <= point[a] && point[a] <= self.upper[a])
    }

    /// The faces of the axes that are not periodic.
    pub(crate) fn open_faces(&self) -> impl Iterator<Item = Face> + '_ {
        Face::ALL.into_iter().filter(|face| !self.periodic[face.axis()])
    }

    /// Whether the upper corner is above the lower one; if not, checks against the box say nothing.
    pub(crate) fn is_upright(&self) -> bool {
        self.extents().iter().all(|extent| *extent > 0.0)
    }

    /// The corners of the box (m).
    pub fn corners(&self) -> [[f64; 3]; 8] {
        std::array::from_fn(|i| {
            [0, 1, 2].map(|a| if i >> a & 1 == 1 { self.upper[a] } else { self.lower[a] })
        })
    }

    fn check_shear(&self, shear: &Shear, checker: &mut Checker) {
        let Shear { flow, gradient, rate } = *shear;
        let axes = [("flow", flow), ("gradient", gradient)];
        for (key, axis) in axes.into_iter().filter(|(_, axis)| !self.periodic[*axis as usize]) {
            let message = format!("{} is not periodic; make it so in domain.periodic", axis.name());
            checker.error(&format!("domain.shear.{key}"), message);
        }
        if flow == gradient {
            checker.error("domain.shear.gradient", "is the axis of the flow; choose one across it".into());
        }
        if rate == 0.0 {
            checker.error("domain.shear.rate", "shears nothing; remove domain.shear".into());
        }
        if self.ranks.is_some_and(|ranks| ranks[flow as usize] != 1) {
            let message = format!(
                "divides {}, the axis of the flow of domain.shear, along which images slide; take 1 there",
                flow.name()
            );
            checker.error("domain.ranks", message);
        }
    }

    pub(crate) fn check(&self, checker: &mut Checker) {
        checker.ordered_corners("domain", self.lower, self.upper);
        self.shear.iter().for_each(|shear| self.check_shear(shear, checker));
        for (i, face) in self.outlets.iter().enumerate() {
            let path = format!("domain.outlets[{i}]");
            if self.periodic[face.axis()] {
                let axis = ["x", "y", "z"][face.axis()];
                checker.error(
                    &path,
                    format!("no particle can leave along {axis}, which is periodic; remove one of the two"),
                );
            }
            if self.outlets[..i].contains(face) {
                checker.error(&path, "named twice; remove one".into());
            }
        }
    }
}
