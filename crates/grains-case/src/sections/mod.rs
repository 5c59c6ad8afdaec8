//! The sections of a case file: one module each, with its keys, defaults and checks.
//!
//! A type that names materials, shapes or planes is generic in the name: `String` in the file, an
//! index (`usize`) once checked. Keywords of the schema that belong to no standard: `x-plausible`, the
//! range outside which a value draws a warning, and `x-infinite`, set where `inf` is a sensible value.

pub mod bond;
pub mod collisions;
pub mod composite;
pub mod contact;
pub mod contact_law;
pub mod contact_points;
pub mod domain;
pub mod fluid;
pub mod heat;
pub mod insert;
pub mod material;
pub mod motion;
pub mod motion_table;
pub mod output;
pub mod place;
pub mod run;
pub mod shape;
mod sieve;
pub mod size_distribution;
pub mod time;
pub mod wall;

use schemars::{Schema, json_schema};

pub(crate) fn one() -> f64 {
    1.0
}

/// Whether a factor changes nothing.
pub(crate) fn is_one(factor: &f64) -> bool {
    *factor == 1.0
}

pub(crate) fn infinity() -> f64 {
    f64::INFINITY
}

pub(crate) fn yes() -> bool {
    true
}

/// Schema of a vector of three positive lengths (m).
pub(crate) fn three_lengths(_: &mut schemars::SchemaGenerator) -> Schema {
    json_schema!({
        "type": "array", "minItems": 3, "maxItems": 3,
        "items": {"type": "number", "exclusiveMinimum": 0, "x-plausible": [1e-7, 1.0]}
    })
}

/// Schema of the two exponents of a superellipsoid (-), in the range where it is convex.
pub(crate) fn two_exponents(_: &mut schemars::SchemaGenerator) -> Schema {
    json_schema!({
        "type": "array", "minItems": 2, "maxItems": 2,
        "items": {"type": "number", "minimum": 0.05, "maximum": 2}
    })
}

/// Schema of a list of positive numbers, not empty.
pub(crate) fn positive_list(_: &mut schemars::SchemaGenerator) -> Schema {
    json_schema!({
        "type": "array", "minItems": 1, "items": {"type": "number", "exclusiveMinimum": 0}
    })
}

/// Schema of a list of non-negative numbers, not empty.
pub(crate) fn share_list(_: &mut schemars::SchemaGenerator) -> Schema {
    json_schema!({"type": "array", "minItems": 1, "items": {"type": "number", "minimum": 0}})
}

/// Schema of the rows [size, passing fraction (-)] of a sieve analysis.
pub(crate) fn sieve_rows(_: &mut schemars::SchemaGenerator) -> Schema {
    json_schema!({
        "type": "array",
        "items": {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number", "minimum": 0}}
    })
}
