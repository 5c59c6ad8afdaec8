//! `[contact_points]`: how bodies touch that have faces, edges or several parts.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What faces, edges and lines do that touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Faces {
    /// They touch in one point of those nearest (Grains3D): fast; bodies at rest creep and spin a little.
    #[default]
    Point,
    /// They touch at the corners of their common face or line, which share the force.
    Patch,
}

/// What the contacts of one composite particle with one other body do together; each plane, tube or mesh of
/// a wall is a body of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Composite {
    /// One potential: forces are continuous and conserve energy; N equal contacts are N^(1/4) times as stiff.
    #[default]
    Potential,
    /// The mean of the forces (model B): as stiff as one contact; makes or takes energy when contacts begin.
    Mean,
    /// The sum (model A), with the damping corrected for their number: N contacts are N times as stiff.
    Sum,
}

/// How bodies touch that have faces, edges or several parts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactPoints {
    /// "point" or "patch": what faces, edges and lines do that touch.
    #[serde(default)]
    pub faces: Faces,
    /// "potential", "mean" or "sum": what the contacts of the parts of a composite do together.
    #[serde(default)]
    pub composite: Composite,
}
