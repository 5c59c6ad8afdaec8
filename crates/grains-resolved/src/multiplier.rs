//! Distributed Lagrange multipliers: what is kept of them between steps.

use crate::constraints::{Interpolation, Row, rows};
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

/// Layers of the halo that stencils of points in the own cells reach into.
pub(crate) const REACH: usize = 2;

/// What is kept between steps: the points, the multipliers, and room to work in.
pub(crate) struct Multipliers {
    /// The constraint at the points of the surfaces.
    pub rows: Vec<Row>,
    /// Multipliers of the last step (N), 0 at points that have come since.
    pub values: Vec<f64>,
    /// Ids of the bodies that the rows tell of, and numbers of points on their surfaces.
    bodies: Vec<(u64, usize)>,
    /// Surface points of the shapes at a scale, in two dimensions of a section.
    surfaces: HashMap<SurfaceKey, Vec<SurfacePoint>>,
    /// Cᵀ Λ (N).
    pub field: Faces,
    /// Places per component, halo included, that rows of any rank reach to.
    pub touched: [Vec<u32>; 3],
    /// Numbers of the own nodes among them that are deep.
    pub deep: [Vec<u32>; 3],
    pub halo: Halo,
    /// Iterations of the last step.
    pub iterations: usize,
}

impl Multipliers {
    /// Nothing yet, for fields of a layout.
    pub fn new(setup: &FlowSetup, layout: Layout) -> Self {
        Self {
            rows: Vec::new(),
            values: Vec::new(),
            bodies: Vec::new(),
            surfaces: HashMap::new(),
            field: Faces::new(layout),
            touched: Default::default(),
            deep: Default::default(),
            halo: Halo::new(&setup.grid, &setup.partition, layout),
            iterations: 0,
        }
    }

    /// Sets the points for the places of the bodies; collective.
    pub fn place(
        &mut self,
        method: &MultiplierMethod,
        nodes: &Nodes,
        (bodies, shapes): (&[RigidBody], &[Shape]),
        subgrid: &Subgrid,
        transport: &dyn Transport,
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
        let rows = rows(bodies, shapes, &surfaces, subgrid, method.interpolation);
        let told = bodies.iter().zip(&surfaces).map(|(body, surface)| (body.id, surface.len())).collect();
        self.take_rows(rows, told);
        self.find_touched(nodes, subgrid, transport);
    }

    /// Takes new rows, with the multipliers that the points had in the last step.
    fn take_rows(&mut self, rows: Vec<Row>, bodies: Vec<(u64, usize)>) {
        let mut starts: HashMap<u64, usize> = HashMap::new();
        let mut last: Vec<f64> = Vec::new();
        let of_bodies = |bodies: &[(u64, usize)], starts: &mut HashMap<u64, usize>, last: &mut Vec<f64>| {
            let start = |&(id, points): &(u64, usize)| {
                *starts.entry(id).or_insert_with(|| {
                    last.resize(last.len() + 3 * points, 0.0);
                    last.len() - 3 * points
                })
            };
            bodies.iter().map(start).collect::<Vec<usize>>()
        };
        let place = |starts: &[usize], row: &Row| {
            starts[row.body as usize] + 3 * row.point as usize + usize::from(row.component)
        };
        let before = of_bodies(&self.bodies, &mut starts, &mut last);
        for (row, value) in self.rows.iter().zip(&self.values) {
            last[place(&before, row)] = *value;
        }
        let now = of_bodies(&bodies, &mut starts, &mut last);
        self.values.clear();
        self.values.extend(rows.iter().map(|row| last.get(place(&now, row)).copied().unwrap_or(0.0)));
        (self.rows, self.bodies) = (rows, bodies);
    }

    /// Finds what rows reach to, those of other ranks included; collective.
    fn find_touched(&mut self, nodes: &Nodes, subgrid: &Subgrid, transport: &dyn Transport) {
        let strides = subgrid.layout.strides();
        self.field.fill(0.0);
        for row in &self.rows {
            let field = self.field.component_mut(usize::from(row.component));
            row.stencil.abs().spread(strides, 1.0, field);
        }
        self.exchange(transport);
        for component in (0..3).filter(|&c| subgrid.active[c]) {
            let field = self.field.component_mut(component);
            let (touched, deep) = (&mut self.touched[component], &mut self.deep[component]);
            touched.clear();
            touched.extend((0..field.len() as u32).filter(|&place| field[place as usize] != 0.0));
            let is_deep = |&number: &u32| {
                let node = &nodes.of[component][number as usize];
                node.is_deep() && field[node.place as usize] != 0.0
            };
            deep.clear();
            deep.extend((0..nodes.of[component].len() as u32).filter(is_deep));
            touched.iter().for_each(|&place| field[place as usize] = 0.0);
        }
    }

    /// Gives what the rows of all ranks have added to their owners, and to the halos of these; collective.
    fn exchange(&mut self, transport: &dyn Transport) {
        let [x, y, z] = self.field.components_mut();
        self.halo.add_to(REACH, &mut [x, y, z], transport);
        self.fill(transport);
    }

    /// Fills the halo of the field; collective.
    pub fn fill(&mut self, transport: &dyn Transport) {
        let [x, y, z] = self.field.components_mut();
        self.halo.fill_to(REACH, &mut [x, y, z], transport);
    }

    /// What the multipliers do to the fluid, Cᵀ Λ (N), in the own places; collective.
    pub fn spread(&mut self, values: &[f64], transport: &dyn Transport) {
        let strides = self.field.layout().strides();
        for (component, touched) in self.touched.iter().enumerate() {
            let field = self.field.component_mut(component);
            touched.iter().for_each(|&place| field[place as usize] = 0.0);
        }
        for (row, value) in self.rows.iter().zip(values) {
            row.stencil.spread(strides, *value, self.field.component_mut(usize::from(row.component)));
        }
        let [x, y, z] = self.field.components_mut();
        self.halo.add_to(REACH, &mut [x, y, z], transport);
    }
}
