//! Resistance to twisting: to relative rotation about the normal.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a contact resists twisting.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Twisting {
    /// Not at all.
    #[default]
    None,
    /// By the tangential spring, dashpot and slider over the circle of contact (Marshall 2009).
    Marshall,
}
