//! Distributed Lagrange multipliers: what is kept of them between steps.

use crate::constraints::{Constraints, Interpolation};
use crate::nodes::Nodes;
use crate::points::{SurfacePoint, surface_points};
use crate::{Form, RigidBody, Subgrid};
use grains_domain::Transport;
use grains_fluid::{Faces, FlowSetup, Halo, Layout};
use grains_geometry::{Shape, Vec3};
use std::collections::{HashMap, HashSet};

/// How multipliers are found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultiplierMethod {
    /// How velocities are found at points of the surface.
    pub interpolation: Interpolation,
    /// Distance τ of the points (cells).
    pub spacing: f64,
    /// Residual of the constraint over that without multipliers (-).
    pub tolerance: f64,
    /// Largest number of iterations.
    pub iterations: usize,
}

/// Shape, bits of the scale, and the axis of the section in the body frame (10⁻⁶).
type SurfaceKey = (Form, u64, Option<[i64; 3]>);

/// What is kept between steps: the points, the multipliers, and room to work in.
pub(crate) struct Multipliers {
    pub constraints: Constraints,
    /// Multipliers of the last step (N), if its points are still these.
    pub values: Vec<f64>,
    /// Surface points of the shapes at a scale, in two dimensions of a section.
    surfaces: HashMap<SurfaceKey, Vec<SurfacePoint>>,
    /// Cᵀ Λ (N).
    pub field: Faces,
    halo: Halo,
    /// Iterations of the last step.
    pub iterations: usize,
}

impl Multipliers {
    /// Nothing yet, for fields of a layout.
    pub fn new(setup: &FlowSetup, layout: Layout) -> Self {
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
            (body.form, body.scale.to_bits(), rounded)
        };
        for body in bodies {
            self.surfaces.entry(key(body)).or_insert_with(|| {
                let across = across(body);
                let spacing = method.spacing * widest / body.scale;
                body.shape(shapes)
                    .map_or_else(Vec::new, |shape| surface_points(shape, spacing, across.as_ref()))
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
    pub fn spread(&mut self, values: &[f64], transport: &dyn Transport) {
        self.field.fill(0.0);
        self.constraints.spread(values, self.field.components_mut());
        let [x, y, z] = self.field.components_mut();
        self.halo.add(&mut [x, y, z], transport);
        let [x, y, z] = self.field.components_mut();
        self.halo.fill(&mut [x, y, z], transport);
    }
}
