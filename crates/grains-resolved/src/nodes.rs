//! The velocities of the fluid that bodies impose.

use crate::subgrid::Stencil;
use crate::{RigidBody, Subgrid};
use grains_geometry::{Shape, Vec3, WayOut};
use std::ops::RangeInclusive;

/// Marks of faces: outside all bodies, and inside one (for an own face, plus the number of its node).
const OUTSIDE: u32 = 0;
const INSIDE: u32 = 1;
const FIRST: u32 = 2;
/// What the weights of velocities inside bodies may sum to at the near and the far point in the fluid: such velocities
/// are extrapolated themselves, and loops among close bodies must not feed themselves.
const MOST_HIDDEN: [f64; 2] = [0.25, 0.5];

/// How velocities just inside a body follow those in the fluid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extrapolation {
    /// They are those of the body.
    Rigid,
    /// Along a straight line through the surface.
    Linear,
    /// Along a parabola through the surface and two points in the fluid.
    Quadratic,
}

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

/// Extrapolation from the fluid through the surface to a velocity inside: u = b₀ (U + ω × r_s) + Σ b_k u(x_k).
#[derive(Clone, Debug)]
pub(crate) struct Skin {
    /// From the centre of the body to the surface (m).
    pub foot: Vec3,
    /// b₀ (-).
    pub surface: f64,
    /// b_k (-).
    pub weights: [f64; 2],
    /// x_k in the fluid; where there is no second one, its weight is 0.
    fluid: [Stencil; 2],
}

/// All velocities inside bodies.
#[derive(Clone, Debug)]
pub(crate) struct Nodes {
    /// Own nodes per component.
    pub of: [Vec<Node>; 3],
    skins: [Vec<Skin>; 3],
    /// Scratch: the ways out that the skins of a component are made of.
    ways: Vec<WayOut>,
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
            let (marks, skins, strides) =
                (&self.marks[component], &mut self.skins[component], subgrid.layout.strides());
            let hidden = |stencil: &Stencil| {
                stencil.mean(strides, |place| if marks[place] == OUTSIDE { 0.0 } else { 1.0 })
            };
            skins.clear();
            for node in self.of[component].iter_mut().filter(|node| node.skin != DEEP) {
                let (way, center) = (&self.ways[node.skin as usize], &bodies[node.body as usize].center);
                let skin = Skin::new((&node.arm, way), extrapolation, (subgrid, component), center, hidden);
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
        self.marks[component][place] >= FIRST
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
                    let held = marks[place].checked_sub(FIRST).map(|m| m as usize);
                    if held.is_some_and(|m| {
                        let id = bodies[nodes[m].body as usize].id;
                        (nodes[m].arm.norm_squared(), id) <= (rank, body.id)
                    }) {
                        continue;
                    }
                    let local = body.rotation.tr_mul(&arm) / body.scale;
                    let Some(way) = shape.way_out(&local, flat.as_ref()) else { continue };
                    let is_own = [i, j, k].iter().zip(own).all(|(&m, n)| m >= 0 && m < n as isize);
                    if !is_own {
                        marks[place] = INSIDE;
                        continue;
                    }
                    let distance = way.distance * body.scale;
                    let direction = body.rotation * way.direction;
                    let skin = if distance < pitch(&direction, subgrid) {
                        ways.push(WayOut { distance, direction });
                        ways.len() as u32 - 1
                    } else {
                        DEEP
                    };
                    let node = Node { place: place as u32, body: number as u32, arm, skin };
                    match held {
                        Some(m) => nodes[m] = node,
                        None => {
                            marks[place] = FIRST + nodes.len() as u32;
                            nodes.push(node);
                        }
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

impl Skin {
    /// For a node at an arm from the centre of its body with a way out; none where there is no point in the fluid to
    /// extrapolate from.
    ///
    /// The first point in the fluid is so far out, Σ |n_a| Δx_a, that no corner of the cell about it lies behind the
    /// tangent plane.
    fn new(
        (arm, way): (&Vec3, &WayOut),
        extrapolation: Extrapolation,
        (subgrid, component): (&Subgrid, usize),
        center: &Vec3,
        hidden: impl Fn(&Stencil) -> f64,
    ) -> Option<Self> {
        let WayOut { distance: d, direction } = *way;
        let foot = arm + direction * d;
        let pitch = pitch(&direction, subgrid);
        let at = |distance: f64| subgrid.stencil(component, &(center + foot + direction * distance));
        let near = match extrapolation {
            Extrapolation::Rigid => None,
            Extrapolation::Linear | Extrapolation::Quadratic => at(pitch),
        };
        let near = near.filter(|s| hidden(s) <= MOST_HIDDEN[0])?;
        let far = match extrapolation {
            Extrapolation::Quadratic => at(2.0 * pitch).filter(|s| hidden(s) <= MOST_HIDDEN[1]),
            _ => None,
        };
        let x = d / pitch;
        // Lagrange's polynomial through 0, 1 and, if there is one, 2, at −x.
        let weights = match far {
            Some(_) => [-x * (x + 2.0), 0.5 * x * (x + 1.0)],
            None => [-x, 0.0],
        };
        let surface = 1.0 - weights[0] - weights[1];
        Some(Self { foot, surface, weights, fluid: [near, far.unwrap_or(near)] })
    }

    /// The fluid's part Σ b_k u(x_k) (m/s).
    #[inline]
    pub fn fluid_part(&self, velocity: &[f64], strides: [usize; 3]) -> f64 {
        let [near, far] = self.fluid.map(|stencil| stencil.mean(strides, |place| velocity[place]));
        self.weights[0] * near + self.weights[1] * far
    }
}

/// Distance (m) of two parallel planes between which a cell fits.
fn pitch(normal: &Vec3, subgrid: &Subgrid) -> f64 {
    (0..3).filter(|&a| subgrid.active[a]).map(|a| normal[a].abs() * subgrid.spacing[a]).sum()
}
