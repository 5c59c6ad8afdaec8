//! Distributed Lagrange multipliers: what is kept of them between steps.

use crate::constraints::{Block, Constraints, Interpolation};
use crate::nodes::Nodes;
use crate::overlaps::Overlaps;
use crate::point_stencil::PointStencil;
use crate::points::{SurfacePoint, surface_points};
use crate::shared_places::{CHUNK, SharedPlaces};
use crate::{Form, RigidBody, Subgrid};
use grains_domain::Transport;
use grains_fluid::{Faces, FlowSetup, Halo, Layout};
use grains_geometry::{Shape, Vec3};
use std::collections::{HashMap, HashSet};
use std::ops::Range;

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

/// Layers of the halo that stencils of points in the own cells reach into.
pub(crate) const REACH: usize = 2;

/// What is kept between steps: the points, the multipliers, and room to work in.
pub(crate) struct Multipliers {
    /// The constraint at the points of the surfaces.
    pub constraints: Constraints,
    /// Multipliers of the last step (N), 0 at points that have come since.
    pub values: Vec<f64>,
    /// By how much they changed in it (N), 0 at points that came in it or since.
    pub changes: Vec<f64>,
    /// Ids of the bodies that the rows tell of.
    ids: Vec<u64>,
    /// Surface points of the shapes at a scale, in two dimensions of a section.
    surfaces: HashMap<SurfaceKey, Vec<SurfacePoint>>,
    pub overlaps: Overlaps,
    pub shared: SharedPlaces,
    /// Cᵀ Λ (N), 0 but where rows are shared.
    pub field: Faces,
    pub halo: Halo,
    /// Iterations of the last step.
    pub iterations: usize,
}

impl Multipliers {
    /// Nothing yet, for fields of a layout.
    pub fn new(setup: &FlowSetup, layout: Layout) -> Self {
        Self {
            constraints: Constraints::default(),
            values: Vec::new(),
            changes: Vec::new(),
            ids: Vec::new(),
            surfaces: HashMap::new(),
            overlaps: Overlaps::default(),
            shared: SharedPlaces::default(),
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
        (bodies, shapes): (&[RigidBody], &[Shape]),
        subgrid: &Subgrid,
    ) {
        let last = self.of_points();
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
        self.shared.mark(nodes, subgrid);
        let strides = subgrid.layout.strides();
        let is_shared =
            |component: usize, stencil: &PointStencil| self.shared.is_shared(component, stencil, strides);
        self.constraints.find((bodies, shapes), &surfaces, subgrid, method.interpolation, is_shared);
        self.shared.find_reached(&self.constraints, nodes, subgrid);
        self.overlaps.find(&self.constraints, subgrid);
        self.take_over(&last, bodies);
    }

    /// Multipliers and their changes (N) by the id of the body, the point on its surface and the component.
    fn of_points(&self) -> HashMap<u64, Vec<[[f64; 2]; 3]>> {
        let mut known: HashMap<u64, Vec<[[f64; 2]; 3]>> = HashMap::new();
        for block in &self.constraints.blocks {
            let of_body = known.entry(self.ids[block.body as usize]).or_default();
            for row in block.rows() {
                let point = self.constraints.points[row] as usize;
                of_body.resize(of_body.len().max(point + 1), [[0.0; 2]; 3]);
                of_body[point][usize::from(block.component)] = [self.values[row], self.changes[row]];
            }
        }
        known
    }

    /// Gives points what is known of their multipliers.
    fn take_over(&mut self, known: &HashMap<u64, Vec<[[f64; 2]; 3]>>, bodies: &[RigidBody]) {
        self.ids.clear();
        self.ids.extend(bodies.iter().map(|body| body.id));
        self.values.clear();
        self.changes.clear();
        for block in &self.constraints.blocks {
            let of_body = known.get(&self.ids[block.body as usize]);
            for &point in &self.constraints.points[block.rows()] {
                let of_point = of_body.and_then(|points| points.get(point as usize));
                let [value, change] = of_point.map_or([0.0; 2], |all| all[usize::from(block.component)]);
                self.values.push(value);
                self.changes.push(change);
            }
        }
    }

    /// Clears the field where shared rows of any rank may have reached to.
    fn clear_shared(&mut self) {
        for (component, touched) in self.shared.chunks.iter().enumerate() {
            let (chunks, rest) = self.field.component_mut(component).as_chunks_mut::<CHUNK>();
            for &number in touched {
                match chunks.get_mut(number as usize) {
                    Some(chunk) => *chunk = [0.0; CHUNK],
                    None => rest.fill(0.0),
                }
            }
        }
    }

    /// Fills the halo of the field; collective.
    pub fn fill(&mut self, transport: &dyn Transport) {
        let [x, y, z] = self.field.components_mut();
        self.halo.fill_to(REACH, &mut [x, y, z], transport);
    }

    /// What the multipliers of shared rows do to the fluid, Cᵀ Λ (N), in the own places; collective.
    pub fn spread_shared(&mut self, values: &[f64], transport: &dyn Transport) {
        self.clear_shared();
        self.spread(|block| block.shared.clone(), values, transport);
    }

    /// What all multipliers do to the fluid, Cᵀ Λ (N), in the own places; collective.
    pub fn spread_all(&mut self, values: &[f64], transport: &dyn Transport) {
        self.clear_shared();
        self.spread(Block::rows, values, transport);
    }

    fn spread(&mut self, which: impl Fn(&Block) -> Range<usize>, values: &[f64], transport: &dyn Transport) {
        self.constraints.spread(which, values, &mut self.field);
        let [x, y, z] = self.field.components_mut();
        self.halo.add_to(REACH, &mut [x, y, z], transport);
    }
}
