//! The velocities of the fluid that bodies impose.

use crate::interface_stencil::{InterfaceStencil, Profile, pitch};
use crate::{Extrapolation, RigidBody, Subgrid};
use grains_geometry::{ClosestSurface, Shape, Vec3};
use std::ops::RangeInclusive;

/// Marks of faces: outside all bodies; for an own face inside one, 1 plus the number of its node; for others [`HALO`] plus
/// the place of the body in the list.
const OUTSIDE: u32 = 0;
const HALO: u32 = 1 << 31;

/// A velocity of the fluid that a body imposes.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    /// Place in the arrays.
    pub place: u32,
    /// Place of the body in the list.
    pub body: u32,
    /// From the centre of the body to the velocity (m).
    pub arm: Vec3,
    /// Number of its [`InterfaceStencil`], or one of the two below.
    interface: u32,
}

/// A node that is not next to the surface.
const DEEP: u32 = u32::MAX;
/// A node next to the surface that has the velocity of the body all the same.
const RIGID: u32 = u32::MAX - 1;

/// All velocities inside bodies.
#[derive(Clone, Debug)]
pub(crate) struct Nodes {
    /// Own nodes per component.
    pub of: [Vec<Node>; 3],
    interfaces: [Vec<InterfaceStencil>; 3],
    /// Scratch: the ways out that the interfaces of a component are made of.
    ways: Vec<ClosestSurface>,
    marks: [Vec<u32>; 3],
}

impl Nodes {
    pub fn new(subgrid: &Subgrid) -> Self {
        let marks = || vec![OUTSIDE; subgrid.layout.len()];
        Self {
            of: Default::default(),
            interfaces: Default::default(),
            ways: Vec::new(),
            marks: [marks(), marks(), marks()],
        }
    }

    /// Finds the velocities inside the bodies and how those next to a surface are extrapolated.
    ///
    /// Of several bodies that hold a node, the one with the nearest centre has it (Wachs et al. 2009).
    pub fn find(
        &mut self,
        bodies: &[RigidBody],
        shapes: &[Shape],
        subgrid: &Subgrid,
        extrapolation: Extrapolation,
    ) {
        self.marks.iter_mut().for_each(|marks| marks.fill(OUTSIDE));
        for component in (0..3).filter(|&c| subgrid.active[c]) {
            self.of[component].clear();
            self.ways.clear();
            for number in 0..bodies.len() {
                self.claim(component, number, bodies, shapes, subgrid);
            }
            let (marks, interfaces) = (&self.marks[component], &mut self.interfaces[component]);
            interfaces.clear();
            let made: Vec<Option<InterfaceStencil>> = {
                let nodes = &self.of[component];
                let next_to_surface = nodes.iter().filter(|node| node.interface != DEEP);
                let make = |node: &Node| {
                    let way = self.ways[node.interface as usize];
                    let center = bodies[node.body as usize].center;
                    let start = center + node.arm + way.direction * way.distance;
                    let holder = |place: usize| holder(marks[place], nodes);
                    let rule =
                        extrapolation.rule()?.at(node.place as usize, subgrid, |p| marks[p] != OUTSIDE);
                    Profile { rule, subgrid, component, bodies, shapes, holder, center, start, way }
                        .interface_stencil()
                };
                next_to_surface.map(make).collect()
            };
            let next_to_surface = self.of[component].iter_mut().filter(|node| node.interface != DEEP);
            for (node, interface) in next_to_surface.zip(made) {
                node.interface = interface.map_or(RIGID, |interface| {
                    interfaces.push(interface);
                    interfaces.len() as u32 - 1
                });
            }
        }
    }

    /// Whether a body holds an own node.
    #[inline]
    pub fn holds(&self, component: usize, place: usize) -> bool {
        matches!(self.marks[component][place], 1..HALO)
    }

    /// What is extrapolated at a node of a component; none if it has the velocity of the body.
    #[inline]
    pub fn interface(&self, component: usize, node: &Node) -> Option<&InterfaceStencil> {
        self.interfaces[component].get(node.interface as usize)
    }

    /// Marks the nodes of one component inside a body, and keeps the own ones.
    fn claim(
        &mut self,
        component: usize,
        number: usize,
        bodies: &[RigidBody],
        shapes: &[Shape],
        subgrid: &Subgrid,
    ) {
        let body = &bodies[number];
        let (shape, radius) = (&shapes[body.shape as usize], body.radius(shapes));
        let flat = (0..3).find(|&a| !subgrid.active[a]).map(|a| {
            let mut axis = Vec3::zeros();
            axis[a] = 1.0;
            body.rotation.tr_mul(&axis)
        });
        let way_out = |arm: &Vec3| {
            let local = body.rotation.tr_mul(arm) / body.scale;
            let way = shape.closest_surface(&local, flat.as_ref())?;
            Some(ClosestSurface {
                distance: way.distance * body.scale,
                direction: body.rotation * way.direction,
            })
        };
        let [x, y, z] = ball_indices(subgrid, component, &body.center, radius);
        for k in z {
            for j in y.clone() {
                for i in x.clone() {
                    let index = [i, j, k];
                    let position = Vec3::from_fn(|a, _| subgrid.coordinate(component, a, index[a]));
                    let arm = position - body.center;
                    if arm.norm_squared() >= radius * radius {
                        continue;
                    }
                    self.claim_node((component, index), (number, bodies), arm, way_out, subgrid);
                }
            }
        }
    }

    /// Gives a node inside a body to it, unless a body with a nearer centre has it.
    fn claim_node(
        &mut self,
        (component, index): (usize, [isize; 3]),
        (number, bodies): (usize, &[RigidBody]),
        arm: Vec3,
        way_out: impl Fn(&Vec3) -> Option<ClosestSurface>,
        subgrid: &Subgrid,
    ) {
        let (nodes, marks, body) = (&mut self.of[component], &mut self.marks[component], &bodies[number]);
        let place = subgrid.layout.index(index[0], index[1], index[2]);
        let held = holder(marks[place], nodes).map(|m| &bodies[m as usize]);
        if held.is_some_and(|other| {
            let from_other = (body.center + arm - other.center).norm_squared();
            (from_other, other.id) <= (arm.norm_squared(), body.id)
        }) {
            return;
        }
        let Some(way) = way_out(&arm) else { return };
        let own = subgrid.unknowns(component);
        if !index.iter().zip(own).all(|(&m, n)| m >= 0 && m < n as isize) {
            marks[place] = HALO | number as u32;
            return;
        }
        let interface = if way.distance < pitch(&way.direction, subgrid) {
            self.ways.push(way);
            self.ways.len() as u32 - 1
        } else {
            DEEP
        };
        let node = Node { place: place as u32, body: number as u32, arm, interface };
        match marks[place] {
            OUTSIDE => {
                nodes.push(node);
                marks[place] = nodes.len() as u32;
            }
            mark => nodes[mark as usize - 1] = node,
        }
    }
}

/// Indices, halo included, of the velocities of a component in the box about a ball (m).
fn ball_indices(
    subgrid: &Subgrid,
    component: usize,
    center: &Vec3,
    radius: f64,
) -> [RangeInclusive<isize>; 3] {
    let layout = subgrid.layout;
    std::array::from_fn(|a| {
        let (h, n) = (layout.halo as isize, layout.cells[a] as isize);
        if !subgrid.active[a] {
            return 0..=0;
        }
        let place = |x: f64| (x - subgrid.coordinate(component, a, 0)) / subgrid.spacing[a];
        let low = place(center[a] - radius).ceil().max(-h as f64) as isize;
        low..=(place(center[a] + radius).floor().min((n + h - 1) as f64) as isize)
    })
}

impl Node {
    /// Whether it is not next to the surface.
    pub fn is_deep(&self) -> bool {
        self.interface == DEEP
    }
}

/// The body that holds a face with a mark.
#[inline]
fn holder(mark: u32, nodes: &[Node]) -> Option<u32> {
    match mark {
        OUTSIDE => None,
        HALO.. => Some(mark - HALO),
        own => Some(nodes[own as usize - 1].body),
    }
}
