//! Distributed Lagrange multipliers: the constraint at points inside and on the surface of the bodies, by conjugate gradients
//! (Uzawa) on the multipliers (Wachs et al. 2009; Rakotonirina 2016, 7.3).
//!
//! With C the interpolation to the points, R the velocities of the bodies there, M their inertia, V the volume of a cell,
//! and the multipliers Λ (N) at the points:
//!
//! ```text
//!  u = û + Δt/(ρ V) Cᵀ Λ,   M X = b − Δt Rᵀ Λ,   C u = R X      →      (Δt/(ρ V) C Cᵀ + Δt R M⁻¹ Rᵀ) Λ = R M⁻¹ b − C û
//! ```

use crate::balance::unit_row;
use crate::nodes::Nodes;
use crate::points::{SurfacePoint, surface_points};
use crate::{Action, BodyMotion, ConstraintError, Method, Resolved, RigidBody, Subgrid};
use grains_domain::Transport;
use grains_fluid::{Faces, Flow, FlowSetup, Halo, Layout};
use grains_geometry::{Shape, Vec3};
use nalgebra::Vector6;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::{HashMap, HashSet};

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

/// How multipliers are found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultiplierMethod {
    /// How velocities are found at points of the surface.
    pub interpolation: Interpolation,
    /// Distance τ of the points (cells).
    pub spacing: f64,
    /// Residual of the constraint over that without multipliers (-).
    pub tolerance: f64,
    /// Most iterations.
    pub iterations: usize,
}

/// Shape, bits of the scale, and the axis of the section in the body frame (10⁻⁶).
type SurfaceKey = (u16, u64, Option<[i64; 3]>);

/// What is kept between steps: the points, the multipliers, and room to work in.
pub(crate) struct Multipliers {
    constraints: Constraints,
    /// Multipliers of the last step (N), if its points are still these.
    values: Vec<f64>,
    /// Surface points of the shapes at a scale, in two dimensions of a section.
    surfaces: HashMap<SurfaceKey, Vec<SurfacePoint>>,
    field: Faces,
    halo: Halo,
    /// Iterations of the last step.
    pub iterations: usize,
}

impl Multipliers {
    /// Nothing yet; direct forcing needs no room.
    pub fn new(setup: &FlowSetup, layout: Layout, method: Method) -> Self {
        let layout = match method {
            Method::Direct { .. } => Layout { cells: [0; 3], halo: 0 },
            Method::Multiplier(_) => layout,
        };
        Self {
            constraints: Constraints::default(),
            values: Vec::new(),
            surfaces: HashMap::new(),
            field: Faces::new(layout),
            halo: Halo::new(&setup.grid, &setup.partition, layout),
            iterations: 0,
        }
    }

    /// Sets the points for the places of the bodies.
    pub fn place(
        &mut self,
        method: &MultiplierMethod,
        nodes: &Nodes,
        bodies: &[RigidBody],
        shapes: &[Shape],
        subgrid: &Subgrid,
    ) {
        let widest = (0..3).filter(|&a| subgrid.active[a]).map(|a| subgrid.spacing[a]).fold(0.0, f64::max);
        let flat = (0..3).find(|&a| !subgrid.active[a]);
        let across = |body: &RigidBody| flat.map(|a| Vec3::from(body.rotation.row(a).transpose()));
        let key = |body: &RigidBody| -> SurfaceKey {
            let rounded = across(body).map(|axis| axis.map(|x| (1e6 * x).round() as i64).into());
            (body.shape, body.scale.to_bits(), rounded)
        };
        for body in bodies {
            self.surfaces.entry(key(body)).or_insert_with(|| {
                let across = across(body);
                let spacing = method.spacing * widest / body.scale;
                surface_points(&shapes[body.shape as usize], spacing, across.as_ref())
            });
        }
        // Sizes that are drawn at random and bodies that turn in two dimensions would bring ever more.
        let there: HashSet<SurfaceKey> = bodies.iter().map(key).collect();
        self.surfaces.retain(|key, _| there.contains(key));
        let surfaces: Vec<&[SurfacePoint]> = bodies.iter().map(|body| &*self.surfaces[&key(body)]).collect();
        self.constraints = Constraints::new(nodes, bodies, shapes, &surfaces, subgrid, method.interpolation);
        self.values.clear();
    }

    /// What the multipliers do to the fluid, Cᵀ Λ (N), in all places of the arrays; collective.
    fn spread(&mut self, values: &[f64], transport: &dyn Transport) {
        self.field.fill(0.0);
        self.constraints.spread(values, self.field.components_mut());
        let [x, y, z] = self.field.components_mut();
        self.halo.add(&mut [x, y, z], transport);
        let [x, y, z] = self.field.components_mut();
        self.halo.fill(&mut [x, y, z], transport);
    }
}

impl Resolved {
    /// Solves for the multipliers, and applies them to fluid and bodies; collective.
    pub(crate) fn solve_multipliers(
        &mut self,
        method: &MultiplierMethod,
        motions: Option<&[BodyMotion]>,
        flow: &mut Flow,
        dt: f64,
        transport: &dyn Transport,
    ) -> Result<Vec<Action>, ConstraintError> {
        self.take_back(flow, dt);
        flow.refresh_velocity(transport);
        let inverse_diagonal = dt / (flow.setup.density * self.subgrid.cell_volume());
        self.velocities_without_flow(motions, transport);
        let count = self.multipliers.constraints.rows.len();
        let mut residual = vec![0.0; count];
        self.multipliers.constraints.interpolate(flow.state.velocity.components(), &mut residual);
        for (value, row) in residual.iter_mut().zip(&self.multipliers.constraints.rows) {
            let body = &self.bodies[row.body as usize];
            *value = body.velocity_at(&row.arm)[row.component as usize] - *value;
        }
        let wanted = sum_of_squares(&residual, transport);
        let mut values = std::mem::take(&mut self.multipliers.values);
        values.resize(count, 0.0);
        let mut response = vec![0.0; count];
        if transport.any(values.iter().any(|v| *v != 0.0)) {
            self.respond(&values, &mut response, inverse_diagonal, dt, motions, transport);
            residual.iter_mut().zip(&response).for_each(|(r, s)| *r -= s);
        }
        let mut direction = residual.clone();
        let mut squared = sum_of_squares(&residual, transport);
        let enough = method.tolerance * method.tolerance * wanted;
        let mut iterations = 0;
        // A residual that is no number is never enough.
        while squared.is_nan() || squared > enough {
            if iterations == method.iterations || squared.is_nan() {
                return Err(ConstraintError::NotConverged {
                    iterations,
                    residual: (squared / wanted).sqrt(),
                });
            }
            self.respond(&direction, &mut response, inverse_diagonal, dt, motions, transport);
            let mut curvature = [direction.iter().zip(&response).map(|(d, s)| d * s).sum::<f64>()];
            transport.sum(&mut curvature);
            let step = squared / curvature[0];
            for k in 0..count {
                values[k] += step * direction[k];
                residual[k] -= step * response[k];
            }
            let next = sum_of_squares(&residual, transport);
            let beta = next / squared;
            direction.iter_mut().zip(&residual).for_each(|(d, r)| *d = r + beta * *d);
            squared = next;
            iterations += 1;
        }
        self.multipliers.iterations = iterations;
        let actions = self.apply(values, motions, flow, dt, transport);
        flow.refresh_velocity(transport);
        Ok(actions)
    }

    /// Takes the explicit force back from the velocities.
    fn take_back(&mut self, flow: &mut Flow, dt: f64) {
        let Some(immersed) = &mut flow.immersed else { return };
        for component in 0..3 {
            let velocity = flow.state.velocity.component_mut(component);
            let force = immersed.force.component_mut(component);
            for &place in &self.forced[component] {
                velocity[place] -= dt / flow.setup.density * force[place];
                force[place] = 0.0;
            }
        }
    }

    /// Gives free bodies the velocities they would have without the flow; collective.
    fn velocities_without_flow(&mut self, motions: Option<&[BodyMotion]>, transport: &dyn Transport) {
        let Some(motions) = motions else { return };
        let mut values = vec![[0.0; 6]; self.bodies.len()];
        for (value, motion) in values.iter_mut().zip(motions) {
            let (matrix, right) = motion.balance();
            *value = motion.solved(matrix, right).into();
        }
        self.ghosts.scatter(&mut values, &self.subgrid, transport);
        for (body, value) in self.bodies.iter_mut().zip(&values) {
            body.velocity = Vec3::from_column_slice(&value[..3]);
            body.spin = Vec3::from_column_slice(&value[3..]);
        }
    }

    /// Force and torque of multipliers on the fluid per body, ghosts included; collective.
    fn loads(&self, values: &[f64], transport: &dyn Transport) -> Vec<[f64; 6]> {
        let mut loads = vec![[0.0; 6]; self.bodies.len()];
        for (row, value) in self.multipliers.constraints.rows.iter().zip(values) {
            let along = unit_row(&row.arm, row.component as usize);
            let load = &mut loads[row.body as usize];
            (0..6).for_each(|a| load[a] += along[a] * value);
        }
        self.ghosts.gather(&mut loads, &self.subgrid, transport);
        loads
    }

    /// Change of the bodies' velocities by loads of theirs on the fluid; collective.
    fn recoil(
        &self,
        loads: &[[f64; 6]],
        dt: f64,
        motions: &[BodyMotion],
        transport: &dyn Transport,
    ) -> Vec<[f64; 6]> {
        let mut values = vec![[0.0; 6]; self.bodies.len()];
        for ((value, load), motion) in values.iter_mut().zip(loads).zip(motions) {
            *value = motion.change(motion.balance().0, Vector6::from_column_slice(load) * -dt).into();
        }
        self.ghosts.scatter(&mut values, &self.subgrid, transport);
        values
    }

    /// (Δt/(ρ V) C Cᵀ + Δt R M⁻¹ Rᵀ) Λ; collective.
    fn respond(
        &mut self,
        values: &[f64],
        response: &mut [f64],
        inverse_diagonal: f64,
        dt: f64,
        motions: Option<&[BodyMotion]>,
        transport: &dyn Transport,
    ) {
        self.multipliers.spread(values, transport);
        let Multipliers { constraints, field, .. } = &self.multipliers;
        constraints.interpolate(field.components(), response);
        response.iter_mut().for_each(|r| *r *= inverse_diagonal);
        let Some(motions) = motions else { return };
        let recoil = self.recoil(&self.loads(values, transport), dt, motions, transport);
        for (r, row) in response.iter_mut().zip(&constraints.rows) {
            let change = Vector6::from_column_slice(&recoil[row.body as usize]);
            *r -= unit_row(&row.arm, row.component as usize).dot(&change);
        }
    }

    /// Applies the multipliers to fluid and bodies, and keeps them; collective.
    fn apply(
        &mut self,
        values: Vec<f64>,
        motions: Option<&[BodyMotion]>,
        flow: &mut Flow,
        dt: f64,
        transport: &dyn Transport,
    ) -> Vec<Action> {
        self.multipliers.spread(&values, transport);
        let loads = self.loads(&values, transport);
        if let Some(motions) = motions {
            let recoil = self.recoil(&loads, dt, motions, transport);
            for (body, change) in self.bodies.iter_mut().zip(&recoil) {
                body.velocity += Vec3::from_column_slice(&change[..3]);
                body.spin += Vec3::from_column_slice(&change[3..]);
            }
        }
        self.multipliers.values = values;
        let (layout, volume) = (self.subgrid.layout, self.subgrid.cell_volume());
        let density = flow.setup.density;
        if let Some(immersed) = &mut flow.immersed {
            for component in (0..3).filter(|&c| self.subgrid.active[c]) {
                let own = self.multipliers.field.component(component);
                let velocity = flow.state.velocity.component_mut(component);
                let force = immersed.force.component_mut(component);
                let forced = &mut self.forced[component];
                forced.clear();
                for row in layout.rows() {
                    for place in (row..row + layout.cells[0]).filter(|&place| own[place] != 0.0) {
                        let f = own[place] / volume;
                        velocity[place] += dt / density * f;
                        force[place] = self.forcing.explicit * f;
                        forced.push(place);
                    }
                }
            }
        }
        let action = |load: &[f64; 6]| {
            let mut sums = [0.0; 12];
            sums[..6].copy_from_slice(load);
            Action::read(&sums)
        };
        loads[..self.owned].iter().map(action).collect()
    }
}

fn sum_of_squares(values: &[f64], transport: &dyn Transport) -> f64 {
    let mut sum = [values.iter().map(|v| v * v).sum::<f64>()];
    transport.sum(&mut sum);
    sum[0]
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
            for node in nodes.of[component].iter().filter(|node| node.is_deep()) {
                constraints.push(component, node.body, node.arm, [(node.place as usize, 1.0)].into_iter());
            }
        }
        let hides = |other: &RigidBody, place: &Vec3| {
            let from = place - other.center;
            from.norm() < other.radius(shapes)
                && shapes[other.shape as usize].contains(&(other.rotation.tr_mul(&from) / other.scale))
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
