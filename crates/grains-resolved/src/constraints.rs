//! The constraint at points on the surface of the bodies: rows of the interpolation C, and of R, which gives the velocities of the
//! bodies there.

use crate::body::others;
use crate::overlaps::Overlaps;
use crate::point_stencil::PointStencil;
use crate::points::SurfacePoint;
use crate::{RigidBody, Subgrid};
use grains_fluid::Faces;
use grains_geometry::{Shape, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::Range;

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

/// The rows of one component at the points of one body.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    pub body: u32,
    pub component: u8,
    /// Those that reach to places where rows of other ranks do, or to velocities deep inside bodies.
    pub shared: Range<usize>,
    /// The others, which follow.
    pub alone: Range<usize>,
}

impl Block {
    /// All of them.
    pub fn rows(&self) -> Range<usize> {
        self.shared.start..self.alone.end
    }
}

/// The rows of the surface points in the own cells, block by block.
#[derive(Debug, Default)]
pub(crate) struct Constraints {
    /// Rows of C.
    pub stencils: Vec<PointStencil>,
    /// From the centre of the body to the point of each row (m).
    pub arms: Vec<Vec3>,
    /// Number of the point of each row on the surface of its body.
    pub points: Vec<u32>,
    pub blocks: Vec<Block>,
    /// Scratch: number, arm, place and normal of the points of a body.
    seen: Vec<(u32, Vec3, Vec3, Vec3)>,
    /// Scratch: rows of a block that are not shared.
    alone: Vec<(PointStencil, Vec3, u32)>,
}

impl Constraints {
    /// Finds the rows of all bodies, told which of a component are shared; those of points inside another body are left out.
    pub fn find(
        &mut self,
        (bodies, shapes): (&[RigidBody], &[Shape]),
        surfaces: &[&[SurfacePoint]],
        subgrid: &Subgrid,
        interpolation: Interpolation,
        is_shared: impl Fn(usize, &PointStencil) -> bool,
    ) {
        let Self { stencils, arms, points, blocks, seen, alone } = self;
        stencils.clear();
        arms.clear();
        points.clear();
        blocks.clear();
        let near = Neighbourhood::new(bodies, shapes);
        for (number, (body, surface)) in bodies.iter().zip(surfaces).enumerate() {
            let numbered = surface.iter().enumerate().map(|(k, point)| {
                let arm = body.rotation * point.place * body.scale;
                (k as u32, arm, body.center + arm, body.rotation * point.normal)
            });
            let others = near.of(body);
            seen.clear();
            seen.extend(numbered.filter(|(_, _, place, _)| {
                subgrid.owns(place) && !others.iter().any(|other| other.holds(place, shapes))
            }));
            for component in (0..3).filter(|&c| subgrid.active[c]) {
                let first = stencils.len();
                for (point, arm, place, normal) in &*seen {
                    let outwards = match interpolation {
                        Interpolation::Quadratic => subgrid.outward_block(component, place, normal),
                        Interpolation::Multilinear => None,
                    };
                    match outwards.or_else(|| subgrid.block_about(component, place)) {
                        None => {}
                        Some(stencil) if is_shared(component, &stencil) => {
                            stencils.push(stencil);
                            arms.push(*arm);
                            points.push(*point);
                        }
                        Some(stencil) => alone.push((stencil, *arm, *point)),
                    }
                }
                let shared = first..stencils.len();
                for (stencil, arm, point) in alone.drain(..) {
                    stencils.push(stencil);
                    arms.push(arm);
                    points.push(point);
                }
                let alone = shared.end..stencils.len();
                blocks.push(Block { body: number as u32, component: component as u8, shared, alone });
            }
        }
    }

    /// Sets R X − C u (m/s), of velocities of the bodies and of the fluid.
    pub fn set_residual(&self, bodies: &[[f64; 6]], velocity: &Faces, residual: &mut [f64]) {
        residual.fill(0.0);
        let strides = velocity.layout().strides();
        for block in &self.blocks {
            let (rows, component) = (block.rows(), velocity.component(usize::from(block.component)));
            let residual = &mut residual[rows.clone()];
            add_means(&self.stencils[rows.clone()], strides, component, residual);
            subtract_rigid(&self.arms[rows], block, &bodies[block.body as usize], residual);
            residual.iter_mut().for_each(|r| *r = -*r);
        }
    }

    /// Adds Cᵀ Λ (N) of some rows of each block to a field.
    pub fn spread(&self, which: impl Fn(&Block) -> Range<usize>, values: &[f64], field: &mut Faces) {
        let strides = field.layout().strides();
        for block in &self.blocks {
            let (rows, component) = (which(block), field.component_mut(usize::from(block.component)));
            spread(&self.stencils[rows.clone()], strides, &values[rows], component);
        }
    }

    /// Adds Rᵀ Λ (N, N m) to the loads of the bodies.
    pub fn add_loads(&self, values: &[f64], loads: &mut [[f64; 6]]) {
        for block in &self.blocks {
            let (rows, a) = (block.rows(), usize::from(block.component));
            let [b, c] = others(a);
            let load = &mut loads[block.body as usize];
            for (arm, value) in self.arms[rows.clone()].iter().zip(&values[rows]) {
                load[a] += value;
                load[3 + b] += arm[c] * value;
                load[3 + c] -= arm[b] * value;
            }
        }
    }

    /// Sets s C Cᵀ Λ − R X, of velocities X of the bodies (none: 0), and returns its product with Λ: a field holds Cᵀ Λ of the rows
    /// that are shared, what others do to it included.
    pub fn respond(
        &self,
        values: &[f64],
        overlaps: &Overlaps,
        (scale, field): (f64, &Faces),
        bodies: Option<&[[f64; 6]]>,
        response: &mut [f64],
    ) -> f64 {
        response.fill(0.0);
        overlaps.multiply(values, response);
        let strides = field.layout().strides();
        let mut product = 0.0;
        for block in &self.blocks {
            let shared = block.shared.clone();
            let component = field.component(usize::from(block.component));
            add_means(&self.stencils[shared.clone()], strides, component, &mut response[shared]);
            let rows = block.rows();
            let own = &mut response[rows.clone()];
            own.iter_mut().for_each(|r| *r *= scale);
            if let Some(bodies) = bodies {
                subtract_rigid(&self.arms[rows.clone()], block, &bodies[block.body as usize], own);
            }
            product += values[rows].iter().zip(own).map(|(value, r)| value * *r).sum::<f64>();
        }
        product
    }
}

/// Bodies in the order of their height.
struct Neighbourhood<'a> {
    upwards: Vec<&'a RigidBody>,
    shapes: &'a [Shape],
    largest: f64,
}

impl<'a> Neighbourhood<'a> {
    fn new(bodies: &'a [RigidBody], shapes: &'a [Shape]) -> Self {
        let mut upwards: Vec<&RigidBody> = bodies.iter().collect();
        upwards.sort_by(|a, b| a.center.z.total_cmp(&b.center.z));
        let largest = bodies.iter().map(|body| body.radius(shapes)).fold(0.0, f64::max);
        Self { upwards, shapes, largest }
    }

    /// The others that a body may overlap.
    fn of(&self, body: &RigidBody) -> Vec<&'a RigidBody> {
        let radius = body.radius(self.shapes);
        let [low, high] = [-1.0, 1.0].map(|side| body.center.z + side * (radius + self.largest));
        let first = self.upwards.partition_point(|other| other.center.z < low);
        let level = self.upwards[first..].iter().take_while(|other| other.center.z <= high);
        let meets = |other: &&&RigidBody| {
            other.id != body.id && (other.center - body.center).norm() < radius + other.radius(self.shapes)
        };
        level.filter(meets).copied().collect()
    }
}

/// Subtracts the velocities (m/s) of a body at the points of a block.
fn subtract_rigid(arms: &[Vec3], block: &Block, velocity: &[f64; 6], result: &mut [f64]) {
    let a = usize::from(block.component);
    let [b, c] = others(a);
    for (arm, result) in arms.iter().zip(result) {
        *result -= velocity[a] + velocity[3 + b] * arm[c] - velocity[3 + c] * arm[b];
    }
}

/// Adds C u of some rows.
fn add_means(stencils: &[PointStencil], strides: [usize; 3], component: &[f64], result: &mut [f64]) {
    for (stencil, result) in stencils.iter().zip(result) {
        *result += stencil.mean(strides, component);
    }
}

/// Adds Cᵀ Λ of some rows to a component.
fn spread(stencils: &[PointStencil], strides: [usize; 3], values: &[f64], component: &mut [f64]) {
    for (stencil, value) in stencils.iter().zip(values) {
        stencil.spread(strides, *value, component);
    }
}
