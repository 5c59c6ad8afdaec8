//! The constraint at points on the surface of the bodies: rows of the interpolation C.

use crate::body::others;
use crate::point_stencil::PointStencil;
use crate::points::SurfacePoint;
use crate::{RigidBody, Subgrid};
use grains_geometry::{Shape, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How velocities are found at surface points of multipliers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// By parabolas that reach outwards: 27 velocities.
    #[default]
    Quadratic,
    /// From the eight velocities around.
    Multilinear,
}

/// One component of the constraint at a point.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub component: u8,
    pub body: u32,
    /// Number of the point on the surface of the body.
    pub point: u32,
    /// From the centre of the body to the point (m).
    pub arm: Vec3,
    pub stencil: PointStencil,
}

impl Row {
    /// Components of (U, ω) on which the velocity of the body at the point depends, and their factors (-, m, m):
    /// e·(U + ω × r) = U_a + ω_b r_c − ω_c r_b.
    #[inline]
    pub fn of_body(&self) -> ([usize; 3], [f64; 3]) {
        let a = usize::from(self.component);
        let [b, c] = others(a);
        ([a, 3 + b, 3 + c], [1.0, self.arm[c], -self.arm[b]])
    }
}

/// Rows for surface points in the own cells.
pub(crate) fn rows(
    bodies: &[RigidBody],
    shapes: &[Shape],
    surfaces: &[&[SurfacePoint]],
    subgrid: &Subgrid,
    interpolation: Interpolation,
) -> Vec<Row> {
    let mut rows = Vec::new();
    let hides = |other: &RigidBody, place: &Vec3| {
        let from = place - other.center;
        let local = other.rotation.tr_mul(&from) / other.scale;
        from.norm() < other.radius(shapes) && other.shape(shapes).is_some_and(|shape| shape.contains(&local))
    };
    for (number, (body, surface)) in bodies.iter().zip(surfaces).enumerate() {
        let meets = |other: &&RigidBody| {
            let reach = body.radius(shapes) + other.radius(shapes);
            other.id != body.id && (other.center - body.center).norm() < reach
        };
        let near: Vec<&RigidBody> = bodies.iter().filter(meets).collect();
        for (k, point) in surface.iter().enumerate() {
            let arm = body.rotation * point.place * body.scale;
            let place = body.center + arm;
            if !subgrid.owns(&place) || near.iter().any(|other| hides(other, &place)) {
                continue;
            }
            let normal = body.rotation * point.normal;
            for component in (0..3).filter(|&c| subgrid.active[c]) {
                let outwards = match interpolation {
                    Interpolation::Quadratic => subgrid.outward_block(component, &place, &normal),
                    Interpolation::Multilinear => None,
                };
                if let Some(stencil) = outwards.or_else(|| subgrid.block_about(component, &place)) {
                    let (component, body) = (component as u8, number as u32);
                    rows.push(Row { component, body, point: k as u32, arm, stencil });
                }
            }
        }
    }
    rows
}
