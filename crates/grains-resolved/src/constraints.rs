//! The constraint at points inside and on the surface of the bodies: rows of the interpolation C.

use crate::nodes::Nodes;
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

/// The points of a rank: rows of C in compressed form, one per point and component.
#[derive(Clone, Debug, Default)]
pub(crate) struct Constraints {
    pub rows: Vec<Row>,
    places: Vec<u32>,
    weights: Vec<f64>,
}

/// One component of the constraint at a point.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub component: u8,
    pub body: u32,
    /// From the centre of the body to the point (m).
    pub arm: Vec3,
    /// End of its entries.
    end: u32,
}

impl Constraints {
    /// Rows for the velocities deep inside the bodies, and for surface points in the own cells.
    pub fn new(
        nodes: &Nodes,
        bodies: &[RigidBody],
        shapes: &[Shape],
        surfaces: &[&[SurfacePoint]],
        subgrid: &Subgrid,
        interpolation: Interpolation,
    ) -> Self {
        let mut constraints = Self::default();
        for component in (0..3).filter(|&c| subgrid.active[c]) {
            let mut arms = nodes.arms(component, bodies, subgrid);
            for (number, node) in nodes.of[component].iter().enumerate().filter(|(_, node)| node.is_deep()) {
                let arm = arms.to(number, node);
                constraints.push(component, node.body, arm, [(node.place as usize, 1.0)].into_iter());
            }
        }
        let hides = |other: &RigidBody, place: &Vec3| {
            let from = place - other.center;
            let local = other.rotation.tr_mul(&from) / other.scale;
            from.norm() < other.radius(shapes)
                && other.shape(shapes).is_some_and(|shape| shape.contains(&local))
        };
        for (number, (body, surface)) in bodies.iter().zip(surfaces).enumerate() {
            let meets = |other: &&RigidBody| {
                let reach = body.radius(shapes) + other.radius(shapes);
                other.id != body.id && (other.center - body.center).norm() < reach
            };
            let near: Vec<&RigidBody> = bodies.iter().filter(meets).collect();
            for point in *surface {
                let arm = body.rotation * point.place * body.scale;
                let place = body.center + arm;
                if !subgrid.owns(&place) || near.iter().any(|other| hides(other, &place)) {
                    continue;
                }
                let normal = body.rotation * point.normal;
                for component in (0..3).filter(|&c| subgrid.active[c]) {
                    constraints.push_point(
                        component,
                        number as u32,
                        arm,
                        (&place, &normal),
                        subgrid,
                        interpolation,
                    );
                }
            }
        }
        constraints
    }

    fn push(&mut self, component: usize, body: u32, arm: Vec3, entries: impl Iterator<Item = (usize, f64)>) {
        for (place, weight) in entries {
            self.places.push(place as u32);
            self.weights.push(weight);
        }
        self.rows.push(Row { component: component as u8, body, arm, end: self.places.len() as u32 });
    }

    fn push_point(
        &mut self,
        component: usize,
        body: u32,
        arm: Vec3,
        (place, normal): (&Vec3, &Vec3),
        subgrid: &Subgrid,
        interpolation: Interpolation,
    ) {
        let outwards = match interpolation {
            Interpolation::Quadratic => subgrid.outward_block(component, place, normal),
            Interpolation::Multilinear => None,
        };
        if let Some(block) = outwards {
            self.push(component, body, arm, block.into_iter());
        } else if let Some(stencil) = subgrid.unknown_stencil(component, place) {
            let corners: Vec<(usize, f64)> = stencil.corners(subgrid.layout.strides()).collect();
            self.push(component, body, arm, corners.into_iter());
        }
    }

    /// Rows with their entries.
    fn entries(&self) -> impl Iterator<Item = (&Row, &[u32], &[f64])> {
        let starts = std::iter::once(0).chain(self.rows.iter().map(|row| row.end as usize));
        self.rows.iter().zip(starts).map(|(row, start)| {
            let own = start..row.end as usize;
            (row, &self.places[own.clone()], &self.weights[own])
        })
    }

    /// y = C u.
    pub fn interpolate(&self, velocity: [&[f64]; 3], values: &mut [f64]) {
        for ((row, places, weights), value) in self.entries().zip(values) {
            let u = velocity[row.component as usize];
            *value = places.iter().zip(weights).map(|(&p, w)| w * u[p as usize]).sum();
        }
    }

    /// Adds Cᵀ Λ to fields, halo included.
    pub fn spread(&self, multipliers: &[f64], fields: [&mut [f64]; 3]) {
        for ((row, places, weights), value) in self.entries().zip(multipliers) {
            let field = &mut *fields[row.component as usize];
            places.iter().zip(weights).for_each(|(&p, w)| field[p as usize] += w * value);
        }
    }
}
