//! The velocities of the fluid that bodies impose.

use crate::body::others;
use crate::cut_faces::CutFaces;
use crate::interface_stencil::InterfaceStencil;
use crate::near_surface::{Near, extrapolate};
use crate::node::{Depth, Node, RIGID, ROUNDING};
use crate::solid_mask::{Holders, SolidMask};
use crate::subgrid::Positions;
use crate::wall::{ClosestPoint, Solids};
use crate::wall_nodes::WallNodes;
use crate::{Extrapolation, RigidBody, Subgrid};
use grains_fluid::{HeldFaces, SolidStresses};
use grains_geometry::Vec3;
use std::ops::RangeInclusive;

/// Rows of marks that are asked for before they are needed.
const ROWS_AHEAD: usize = 4;

/// From the centres of bodies to nodes of a component.
pub(crate) struct Arms<'a> {
    /// To those inside walls, which come first.
    of_walls: &'a [Vec3],
    bodies: &'a [RigidBody],
    positions: Positions<'a>,
}

impl Arms<'_> {
    /// From the centre of the body to a node of this number (m).
    #[inline]
    pub fn to(&mut self, number: usize, node: &Node) -> Vec3 {
        match self.of_walls.get(number) {
            Some(arm) => *arm,
            None => self.positions.at(node.place as usize) - self.bodies[node.body as usize].center,
        }
    }
}

/// All velocities inside bodies.
#[derive(Clone, Debug)]
pub(crate) struct Nodes {
    /// Own nodes per component.
    pub of: [Vec<Node>; 3],
    interfaces: [Vec<InterfaceStencil>; 3],
    /// Scratch: the closest surface points that the interfaces of a component are made of.
    closest_points: Vec<ClosestPoint>,
    masks: [SolidMask; 3],
    in_walls: [WallNodes; 3],
    pub cut_faces: CutFaces,
}

impl Nodes {
    pub fn new(subgrid: &Subgrid) -> Self {
        let mask = || SolidMask::new(subgrid.layout.len());
        Self {
            of: Default::default(),
            interfaces: Default::default(),
            closest_points: Vec::new(),
            masks: [mask(), mask(), mask()],
            in_walls: Default::default(),
            cut_faces: CutFaces::default(),
        }
    }

    /// Finds the velocities inside walls anew, the first of which that has moved is given; those before it keep what they hold.
    ///
    /// Of several walls that hold a node, the first one has it.
    pub fn find_in_walls(&mut self, first_moved: usize, solids: &Solids) {
        for component in (0..3).filter(|&c| solids.subgrid.active[c]) {
            let (mask, found) = (&mut self.masks[component], &mut self.in_walls[component]);
            found.forget_from(first_moved);
            mask.clear();
            let kept =
                found.own.iter().map(|node| node.place).chain(found.halo.iter().map(|(place, _)| *place));
            kept.for_each(|place| mask.set_halo(place as usize, 0));
            for wall in first_moved..solids.walls.len() {
                found.begin_wall();
                solids.for_each_run(component, wall, |run| {
                    found.add(&run, (component, wall as u32), solids.subgrid, mask);
                });
            }
        }
    }

    /// Finds the velocities inside the bodies and how those next to a surface are extrapolated.
    ///
    /// Walls keep what they hold. Of several bodies that hold a node, the one with the nearest centre has it (Wachs et al. 2009).
    pub fn find(&mut self, solids: &Solids, extrapolation: Extrapolation) {
        self.masks.iter_mut().for_each(SolidMask::clear);
        let (subgrid, first_wall) = (solids.subgrid, solids.bodies.len() - solids.walls.len());
        for component in (0..3).filter(|&c| subgrid.active[c]) {
            self.take_walls(component, first_wall as u32);
            for number in 0..first_wall {
                self.claim(component, number, solids);
            }
            self.extrapolate(component, solids, extrapolation);
        }
        let faces = self.in_walls.each_ref().map(|found| &found.cut[..]);
        let holders = [0, 1, 2].map(|a| Holders { mask: &self.masks[a], nodes: &self.of[a] });
        self.cut_faces.find(faces, holders, solids, extrapolation);
    }

    /// Finds how the velocities of a component next to a surface are extrapolated.
    fn extrapolate(&mut self, component: usize, solids: &Solids, extrapolation: Extrapolation) {
        let (nodes, interfaces) = (&mut self.of[component], &mut self.interfaces[component]);
        // Each is made in its place, which is large; no node has a number beyond those made.
        interfaces.resize_with(self.closest_points.len(), InterfaceStencil::default);
        match extrapolation.rule() {
            Some(rule) => {
                let near = Near { component, mask: &self.masks[component], out: &self.closest_points, rule };
                extrapolate(nodes, &near, interfaces, solids);
            }
            None => nodes.iter_mut().filter(|node| !node.is_deep()).for_each(|node| node.interface = RIGID),
        }
    }

    /// Begins with the velocities inside walls, the first of which is a body with this number.
    fn take_walls(&mut self, component: usize, first_wall: u32) {
        let (found, mask, nodes) =
            (&self.in_walls[component], &mut self.masks[component], &mut self.of[component]);
        nodes.clear();
        nodes.extend(found.own.iter().map(|node| Node { body: first_wall + node.body, ..node.clone() }));
        self.closest_points.clone_from(&found.closest_points);
        for (number, node) in nodes.iter().enumerate() {
            mask.set_own(node.place as usize, number as u32);
        }
        for (place, wall) in &found.halo {
            mask.set_halo(*place as usize, first_wall + wall);
        }
    }

    /// The way from the centres of bodies to the own nodes of a component.
    pub fn arms<'a>(&'a self, component: usize, bodies: &'a [RigidBody], subgrid: &'a Subgrid) -> Arms<'a> {
        let positions = subgrid.positions(component);
        Arms { of_walls: &self.in_walls[component].arms, bodies, positions }
    }

    /// The own nodes of a component inside walls, with the arms from the centres of these (m).
    pub fn in_walls(&self, component: usize) -> (&[Node], &[Vec3]) {
        let arms = &self.in_walls[component].arms[..];
        (&self.of[component][..arms.len()], arms)
    }

    /// Whether a body holds a velocity, halo included.
    #[inline]
    pub fn holds(&self, component: usize, place: usize) -> bool {
        self.masks[component].contains(place)
    }

    /// Whether a place is that of an own node not next to the surface.
    #[inline]
    pub fn is_deep(&self, component: usize, place: usize) -> bool {
        let number = self.masks[component].own_node(place);
        number.is_some_and(|number| self.of[component][number as usize].is_deep())
    }

    /// The body that holds a velocity, halo included.
    pub fn holder(&self, component: usize, place: usize) -> Option<u32> {
        self.holders(component).body(place)
    }

    fn holders(&self, component: usize) -> Holders<'_> {
        Holders { mask: &self.masks[component], nodes: &self.of[component] }
    }

    /// Places of the own nodes per component, those with the velocity of the body apart.
    pub fn held(&self) -> [HeldFaces; 3] {
        self.of.each_ref().map(|nodes| {
            let places = |is_deep: bool| {
                let nodes = nodes.iter().filter(move |node| (node.interface >= RIGID) == is_deep);
                nodes.map(|node| node.place).collect()
            };
            HeldFaces { deep: places(true), near: places(false) }
        })
    }

    /// Where stresses act between velocities that bodies or walls hold, of the own cells and one layer about them.
    pub fn solid_stresses(&self, subgrid: &Subgrid) -> SolidStresses {
        let (layout, strides, active) = (subgrid.layout, subgrid.layout.strides(), subgrid.active);
        let range = |a: usize| if active[a] { -1..layout.cells[a] as isize + 1 } else { 0..1 };
        let holds = |component: usize, place: usize| self.holds(component, place);
        let mut solid = SolidStresses::default();
        for (k, j) in range(2).flat_map(|k| range(1).map(move |j| (k, j))) {
            for place in range(0).map(|i| layout.index(i, j, k)) {
                if (0..3).all(|a| !active[a] || holds(a, place) && holds(a, place - strides[a])) {
                    solid.centres.push(place as u32);
                }
                for (axis, edges) in solid.edges.iter_mut().enumerate() {
                    let [a, b] = others(axis);
                    let is_between = |a: usize, b: usize| holds(a, place) && holds(a, place + strides[b]);
                    if active[a] && active[b] && is_between(a, b) && is_between(b, a) {
                        edges.push(place as u32);
                    }
                }
            }
        }
        solid
    }

    /// Places of the own cells between faces of which one and the same wall holds all, in ascending order.
    pub fn sealed_cells(&self, bodies: &[RigidBody], subgrid: &Subgrid) -> Vec<u32> {
        if !bodies.iter().any(RigidBody::is_wall) {
            return Vec::new();
        }
        let strides = subgrid.layout.strides();
        let axes: Vec<usize> = (0..3).filter(|&a| subgrid.active[a]).collect();
        let is_sealed = |&place: &usize| {
            let mut faces =
                axes.iter().flat_map(|&a| [self.holder(a, place), self.holder(a, place - strides[a])]);
            let Some(Some(first)) = faces.next() else { return false };
            bodies[first as usize].is_wall() && faces.all(|body| body == Some(first))
        };
        let rows = subgrid.layout.rows().flat_map(|row| row..row + subgrid.layout.cells[0]);
        rows.filter(is_sealed).map(|place| place as u32).collect()
    }

    /// What is extrapolated at a node of a component; none if it has the velocity of the body.
    #[inline]
    pub fn interface(&self, component: usize, node: &Node) -> Option<&InterfaceStencil> {
        self.interfaces[component].get(node.interface as usize)
    }

    /// Marks the nodes of one component inside a body, and keeps the own ones.
    fn claim(&mut self, component: usize, number: usize, solids: &Solids) {
        let (body, subgrid) = (&solids.bodies[number], solids.subgrid);
        let radius = body.radius(solids.shapes);
        // From here the way out is longer than a cell in any direction.
        let deep = (solids.inscribed_radius(number) - subgrid.diagonal()).max(0.0);
        let own = subgrid.unknowns(component).map(|n| 0..n as isize);
        let [_, y, z] = ball_indices(subgrid, component, &body.center, radius);
        for (j, k) in z.flat_map(|k| y.clone().map(move |j| (j, k))) {
            let (row, is_own) = (subgrid.layout.index(0, j, k), own[1].contains(&j) && own[2].contains(&k));
            let coordinate = |a: usize, i: isize| subgrid.coordinate(component, a, i);
            let across = Vec3::new(body.center.x, coordinate(1, j), coordinate(2, k));
            // A little more than half the chord: rounding of the squares counts where it is short.
            let square = radius * radius - (across - body.center).norm_squared();
            let half = square.max(0.0).sqrt() + ROUNDING.sqrt() * radius;
            let x = subgrid.indices_between(component, 0, [across.x - half, across.x + half]);
            let later = row + ROWS_AHEAD * subgrid.layout.strides()[1];
            self.masks[component].prefetch(later.wrapping_add_signed(*x.start()));
            for i in x {
                let position = Vec3::new(coordinate(0, i), across.y, across.z);
                let square = (position - body.center).norm_squared();
                let depth = if square < deep * deep {
                    Some(Depth::Deep)
                } else if square < radius * radius {
                    solids.closest_point(number, &position).map(|out| Depth::of(&out, subgrid))
                } else {
                    None
                };
                if let Some(depth) = depth {
                    let (place, is_own) = (row.wrapping_add_signed(i), is_own && own[0].contains(&i));
                    self.give((component, place), is_own, (number, square), &depth, solids);
                }
            }
        }
    }

    /// Gives a node at this depth in a body to it, unless a wall or a body with a nearer centre has it; the squared distance (m²)
    /// is from the centre of the body of this number.
    #[inline(always)]
    fn give(
        &mut self,
        (component, place): (usize, usize),
        is_own: bool,
        (number, square): (usize, f64),
        depth: &Depth,
        solids: &Solids,
    ) {
        let (nodes, mask) = (&mut self.of[component], &mut self.masks[component]);
        let held = Holders { mask, nodes }.body(place).map(|m| &solids.bodies[m as usize]);
        if held.is_some_and(|other| {
            let from_other = (solids.subgrid.position(component, place) - other.center).norm_squared();
            other.is_wall() || (from_other, other.id) <= (square, solids.bodies[number].id)
        }) {
            return;
        }
        if !is_own {
            mask.set_halo(place, number as u32);
            return;
        }
        let node = Node::new(place, number as u32, depth, &mut self.closest_points);
        match mask.own_node(place) {
            None => {
                mask.set_own(place, nodes.len() as u32);
                nodes.push(node);
            }
            Some(number) => nodes[number as usize] = node,
        }
    }
}

/// Indices, halo included, of the velocities of a component in the box about a ball (m).
pub(crate) fn ball_indices(
    subgrid: &Subgrid,
    component: usize,
    center: &Vec3,
    radius: f64,
) -> [RangeInclusive<isize>; 3] {
    std::array::from_fn(|a| subgrid.indices_between(component, a, [center[a] - radius, center[a] + radius]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Form;
    use crate::profile::{Normals, Profile, Target};
    use crate::spectrum::Random;
    use grains_fluid::{FlowSetup, Grid};
    use grains_geometry::lanes::Vector;
    use grains_geometry::{Mat3, Shape};
    use nalgebra::Rotation3;

    /// Extrapolations found side by side are those found one by one, among close and overlapping bodies of several shapes.
    #[test]
    fn profiles_side_by_side_are_those_one_by_one() {
        let mut random = Random(8);
        let shapes = [Shape::sphere(1.6).unwrap(), Shape::cuboid(Vec3::new(2.4, 2.8, 3.2), 0.01).unwrap()];
        let (mut made, mut passages, mut rigid) = (0, 0, 0);
        for k in 0..40 {
            let grid = Grid::uniform([0.0; 3], [14.0; 3], [14; 3], [true, false, true]).unwrap();
            let subgrid = Subgrid::new(&FlowSetup { halo: 7, ..FlowSetup::new(grid, 1.0, 1.0) }).unwrap();
            let (velocity, spin) = (Vec3::zeros(), Vec3::zeros());
            let bodies: Vec<RigidBody> = (0..6)
                .map(|id| RigidBody {
                    id,
                    form: Form::Shape((id % 2) as u16),
                    scale: 1.0 + 0.5 * random.next(),
                    center: Vec3::from_fn(|_, _| 14.0 * random.next()),
                    rotation: *Rotation3::from_scaled_axis(Vec3::from_fn(|_, _| random.next())).matrix(),
                    velocity,
                    spin,
                })
                .collect();
            let solids = Solids { bodies: &bodies, shapes: &shapes, walls: &[], subgrid: &subgrid };
            let extrapolation =
                [Extrapolation::Linear, Extrapolation::Quadratic, Extrapolation::Cubic][k % 3];
            let mut nodes = Nodes::new(&subgrid);
            nodes.find(&solids, extrapolation);
            for component in 0..3 {
                let holders = nodes.holders(component);
                for node in nodes.of[component].iter().filter(|node| !node.is_deep()) {
                    let (place, rule) = (node.place as usize, extrapolation.rule().unwrap());
                    let position = subgrid.position(component, place);
                    let out = solids.closest_point(node.body as usize, &position).unwrap();
                    let (direction, distance) = (Vector::of(&out.surface.direction), out.surface.distance);
                    let normal =
                        Normals::through(&Vector::of(&position), (&direction, distance.max(0.0)), &subgrid);
                    let target = Target { subgrid: &subgrid, place, holders, rule, out: &out };
                    let mut found = InterfaceStencil::default();
                    let is_made = Profile { target, component, solids: &solids, normal }.find(&mut found);
                    let side_by_side = nodes.interface(component, node);
                    assert_eq!(side_by_side.is_some(), is_made, "{k} {component} {place}");
                    assert!(
                        side_by_side.is_none_or(|stencil| stencil.is_as(&found)),
                        "{side_by_side:?} {found:?}"
                    );
                    made += usize::from(is_made);
                    passages += usize::from(is_made && found.opposite().is_some());
                    rigid += usize::from(!is_made);
                }
            }
        }
        assert!(made > 20_000 && passages > 200 && rigid > 500, "{made} {passages} {rigid}");
    }

    /// A ball holds all velocities in it, halo included, also where it grazes them.
    #[test]
    fn balls_hold_all_velocities_in_them() {
        let mut random = Random(4);
        let grid = Grid::uniform([0.0; 3], [12.0; 3], [12; 3], [true; 3]).unwrap();
        let subgrid = Subgrid::new(&FlowSetup { halo: 3, ..FlowSetup::new(grid, 1.0, 1.0) }).unwrap();
        for k in 0..200 {
            // Every other ball is on the lines of the grid, so that its radius may end on velocities.
            let on_lines = |x: f64| if k % 2 == 0 { (2.0 * x).round() / 2.0 } else { x };
            let radius = on_lines(1.0 + 3.0 * random.next());
            let center = Vec3::from_fn(|_, _| on_lines(12.0 * random.next()));
            let shape = Shape::sphere(radius).unwrap();
            let (zero, rotation) = (Vec3::zeros(), Mat3::identity());
            let form = Form::Shape(0);
            let body = RigidBody { id: 1, form, scale: 1.0, center, rotation, velocity: zero, spin: zero };
            let radius = body.radius(std::slice::from_ref(&shape));
            let mut nodes = Nodes::new(&subgrid);
            let solids = Solids { bodies: &[body], shapes: &[shape], walls: &[], subgrid: &subgrid };
            nodes.find(&solids, Extrapolation::Quadratic);
            for (component, place) in (0..3).flat_map(|c| (0..subgrid.layout.len()).map(move |p| (c, p))) {
                let square = (subgrid.position(component, place) - center).norm_squared();
                let is_in = square < radius * radius;
                assert_eq!(nodes.holder(component, place).is_some(), is_in, "{center:?} {radius} {place}");
            }
        }
    }
}
