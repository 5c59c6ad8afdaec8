//! Tests of shapes and distances against closed forms, certificates and independent routes.
#![allow(clippy::unwrap_used, reason = "a test stops at what it does not expect")]

mod area;
mod capsules_and_cones;
mod closed_surfaces;
mod closest_surface;
mod composites;
mod decomposition;
mod discrete;
mod facets;
mod gjk_certificate;
mod gjk_closed_forms;
mod gjk_common;
mod gjk_obb;
mod gjk_oracle;
mod gjk_penetration;
mod gjk_random;
mod hull_erosion;
mod mass_unions;
mod mesh_files;
mod queries_in_lanes;
mod shapes;
mod starts;
mod superellipsoids;
mod support;
mod walls;
