//! The case file: TOML text in, checked SI values out.
//!
//! ```text
//! text ── toml ──▶ spanned tree ── structure ──▶ RawCase ── sections::*::check ──▶ Case
//!                                  (JSON schema)            (names, geometry, files)
//! ```
//!
//! The serde types of [`sections`] are the one description of the format. Their JSON schema
//! ([`schema`]) serves editors and, here, the `structure` pass, which reports every unknown key, wrong
//! type and value out of range at once, with file, line and remedy. What a schema cannot say (names,
//! geometry, files) is checked afterwards, section by section. The core only ever meets a [`Case`].

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod case;
mod check;
mod csv_numbers;
mod csv_share;
mod diagnostic;
mod editor_schema;
mod fit;
mod impact;
mod meshes;
mod particle_file;
mod raw;
mod reading;
mod renamed;
pub mod sections;
mod slips;
mod source;
mod structure;
mod text_file;
mod toml_file;
mod values;
mod vector;

pub use grains_coupling::{DragLaw, Kernel, TransferLaw};
pub use grains_fluid::{Advection, Diffusion, MixtureModel};
pub use grains_resolved::{Extrapolation, Interpolation};

pub use case::{Case, inline};
pub use csv_share::CsvShare;
pub use diagnostic::{CaseErrors, Diagnostic, closest};
pub use meshes::{Decomposition, Meshes};
pub use particle_file::{FileTotals, ParticleColumns};
pub use raw::RawCase;
pub use renamed::with_names_of_today;
pub use sections::bond::Bond;
pub use sections::collisions::{Collisions, Model as CollisionModel, Scheme as ImpulseScheme};
pub use sections::composite::{GluedPart, beam_size, layer_radius};
pub use sections::contact::Contact;
pub use sections::contact_law::{Attraction, Capillary, Formation, Normal, Rolling, Tangential};
pub use sections::contact_points::{Composite, ContactPoints, Faces};
pub use sections::domain::{Axis, Domain, Exchange, Face, Shear};
pub use sections::fluid::{
    BodyMotion, Boundary, BoundaryKind, Coupling, Drive, Evaporation, Expression, FlowProfile, Fluid,
    FluidField, FluidOutput, Formula, FormulaError, Initial, Inside, OnFace, ParticleTransfer, Pressure,
    PressureMethod, Profile, ProfileKind, Reaction, Resolved, ResolvedMethod, Scalar, ScalarBoundary,
    ScalarBoundaryKind, ScalarBuoyancy, ScalarKind, Steady, Uptake,
};
pub use sections::heat::{GasLens, Heat, Radiation};
pub use sections::insert::{Component, Insert, Orientation};
pub use sections::material::{Film, Material};
pub use sections::motion::{Motion, ParticleMotion};
pub use sections::motion_table::TableRow;
pub use sections::output::{Field, Output, Precision};
pub use sections::place::{Place, Window, default_spacing, lattice_sites};
pub use sections::run::{FlowPlane, Limits, Neighbours, Stop};
pub use sections::shape::{Shape, ShapeKind, Solid, SurfaceVertices, VertexSpacing};
pub use sections::size_distribution::{Basis, SizeDistribution};
pub use sections::time::{Time, TimeStep};
pub use sections::wall::{FluidSide, Side, Wall, WallKind, Wear};
pub use structure::schema;
pub use text_file::{no_text, oddity, read_text, text_of};
pub use toml_file::{read_toml, remark, schema_of};
