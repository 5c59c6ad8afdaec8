//! The velocities of the fluid that bodies impose.

use crate::skin::{Profile, Skin, pitch};
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
    /// Number of its [`Skin`], or one of the two below.
    skin: u32,
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
    skins: [Vec<Skin>; 3],
    /// Scratch: the ways out that the skins of a component are made of.
    ways: Vec<ClosestSurface>,
    marks: [Vec<u32>; 3],
}

impl Nodes {
    pub fn new(subgrid: &Subgrid) -> Self {
        let marks = || vec![OUTSIDE; subgrid.layout.len()];
        Self {
            of: Default::default(),
            skins: Default::default(),
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
            let (marks, skins) = (&self.marks[component], &mut self.skins[component]);
            skins.clear();
            let made: Vec<Option<Skin>> = {
                let nodes = &self.of[component];
                let next_to_surface = nodes.iter().filter(|node| node.skin != DEEP);
                let make = |node: &Node| {
                    let way = self.ways[node.skin as usize];
                    let center = bodies[node.body as usize].center;
                    let start = center + node.arm + way.direction * way.distance;
                    let holder = |place: usize| holder(marks[place], nodes);
                    let rule =
                        extrapolation.rule()?.at(node.place as usize, subgrid, |p| marks[p] != OUTSIDE);
                    Profile { rule, subgrid, component, bodies, shapes, holder, center, start, way }.skin()
                };
                next_to_surface.map(make).collect()
            };
            let next_to_surface = self.of[component].iter_mut().filter(|node| node.skin != DEEP);
            for (node, skin) in next_to_surface.zip(made) {
                node.skin = skin.map_or(RIGID, |skin| {
                    skins.push(skin);
                    skins.len() as u32 - 1
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
    pub fn skin(&self, component: usize, node: &Node) -> Option<&Skin> {
        self.skins[component].get(node.skin as usize)
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
        let shape = &shapes[body.shape as usize];
        let radius = body.radius(shapes);
        let layout = subgrid.layout;
        let own = subgrid.unknowns(component);
        let flat = (0..3).find(|&a| !subgrid.active[a]).map(|a| {
            let mut axis = Vec3::zeros();
            axis[a] = 1.0;
            body.rotation.tr_mul(&axis)
        });
        let ranges: [RangeInclusive<isize>; 3] = std::array::from_fn(|a| {
            let (h, n) = (layout.halo as isize, layout.cells[a] as isize);
            if !subgrid.active[a] {
                return 0..=0;
            }
            let place = |x: f64| (x - subgrid.coordinate(component, a, 0)) / subgrid.spacing[a];
            let low = place(body.center[a] - radius).ceil().max(-h as f64) as isize;
            low..=(place(body.center[a] + radius).floor().min((n + h - 1) as f64) as isize)
        });
        let (nodes, marks, ways) = (&mut self.of[component], &mut self.marks[component], &mut self.ways);
        for k in ranges[2].clone() {
            for j in ranges[1].clone() {
                for i in ranges[0].clone() {
                    let arm =
                        Vec3::from_fn(|a, _| subgrid.coordinate(component, a, [i, j, k][a])) - body.center;
                    let rank = arm.norm_squared();
                    if rank >= radius * radius {
                        continue;
                    }
                    let place = layout.index(i, j, k);
                    let held = holder(marks[place], nodes).map(|m| &bodies[m as usize]);
                    if held.is_some_and(|other| {
                        ((body.center + arm - other.center).norm_squared(), other.id) <= (rank, body.id)
                    }) {
                        continue;
                    }
                    let local = body.rotation.tr_mul(&arm) / body.scale;
                    let Some(way) = shape.closest_surface(&local, flat.as_ref()) else { continue };
                    let is_own = [i, j, k].iter().zip(own).all(|(&m, n)| m >= 0 && m < n as isize);
                    if !is_own {
                        marks[place] = HALO | number as u32;
                        continue;
                    }
                    let distance = way.distance * body.scale;
                    let direction = body.rotation * way.direction;
                    let skin = if distance < pitch(&direction, subgrid) {
                        ways.push(ClosestSurface { distance, direction });
                        ways.len() as u32 - 1
                    } else {
                        DEEP
                    };
                    let node = Node { place: place as u32, body: number as u32, arm, skin };
                    match marks[place] {
                        OUTSIDE => {
                            nodes.push(node);
                            marks[place] = nodes.len() as u32;
                        }
                        mark => nodes[mark as usize - 1] = node,
                    }
                }
            }
        }
    }
}

impl Node {
    /// Whether it is not next to the surface.
    pub fn is_deep(&self) -> bool {
        self.skin == DEEP
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
