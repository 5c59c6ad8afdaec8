//! What walls leave open of cells and faces, for flows averaged over particles.
//!
//! With V the open share of a cell, V_f its mean on the control volume of a face, A the open share of a face's area, ε the void
//! fraction of what is open and ψ = V ε, a cell keeps its volume and a face its momentum by
//!
//! ```text
//! ∂ψ/∂t + ∇·(A ε u) = 0,     ψ_f ∂u/∂t + … = −ψ_f ∇p/ρ − ν ψ_f S/(V_f d) u
//! ```
//!
//! with ε of a face ψ_f/V_f. S is the area of wall per volume, d the mean distance of the open part of the face from it: no slip, by
//! the shear of a linear profile, implicitly, so that small cut cells limit no step. Stresses between two velocities act
//! through what is open between them, over the distance of the middles of their open parts. Where the fluid slips S is 0.
//!
//! Of a wall that moves with u_w, friction acts on u − u_w, and ∂ψ/∂t is what the wall displaces: V is sampled anew for each
//! step, at its beginning, as the void fraction of the particles is.

use crate::metrics::Local;
use crate::{Centre, Faces, Field, Grid, Layout};

/// Where a point lies seen from the walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Distance (m) from the closest wall, negative in it.
    pub distance: f64,
    /// Unit vector along which it grows.
    pub direction: [f64; 3],
    /// Number of the closest wall.
    pub wall: usize,
}

/// Walls that bound a flow averaged over particles, as they are at one time; closures are walls at rest without slip.
pub trait Enclosure {
    /// Where a point (m) of the box lies.
    fn clearance(&self, at: [f64; 3]) -> Clearance;

    /// Where points within a reach (m) of one lie, of which the distance (m) from the closest wall is known.
    fn clearances(&self, _center: [f64; 3], _distance: f64, _reach: f64, at: &[[f64; 3]]) -> Vec<Clearance> {
        at.iter().map(|&at| self.clearance(at)).collect()
    }

    /// Whether one of them moves.
    fn is_moving(&self) -> bool {
        false
    }

    /// Velocity (m/s) of a wall at a point (m).
    fn velocity(&self, _wall: usize, _at: [f64; 3]) -> [f64; 3] {
        [0.0; 3]
    }

    /// Whether the fluid slips along a wall.
    fn slips(&self, _wall: usize) -> bool {
        false
    }
}

impl<F: Fn([f64; 3]) -> Clearance> Enclosure for F {
    fn clearance(&self, at: [f64; 3]) -> Clearance {
        self(at)
    }
}

/// Parts per axis into which cells and faces are divided to find what of them is open.
const PARTS: usize = 4;
/// Open share (-) below which a cell is closed: walls that move would drive fluid through its slits at any speed.
const CLOSED_CELL: f64 = 0.01;
/// The same of a face.
const CLOSED_FACE: f64 = 1e-3;
/// Largest share of a face over that of its control volume: that of a plane which cuts off a corner (-).
const WIDEST: f64 = 2.0;
/// Smallest distance of velocities from a wall, over the width of a cell (-).
const CLOSEST: f64 = 1e-3;
/// Largest width of a cell over how far its velocity and the next one are apart (-).
const CLOSER: f64 = 4.0;
/// Distance from a wall over the reach of a cell, beyond which no cell beside it is cut, of widths that change gently (-).
const AROUND: f64 = 4.0;
/// Rise of the distance from a wall over the width of a cell, below which the wall runs along an axis (-).
const ALONG: f64 = 0.05;

/// Open shares of the cells and faces of a rank, with its halo.
#[derive(Clone, Debug)]
pub struct Openings {
    /// Open share V of the cells (-).
    pub cells: Field<Centre>,
    /// Open share A of the faces (-).
    pub faces: Faces,
    /// Open share V_f of the control volumes of faces (-): the mean of V, with what closed faces give to open ones.
    pub(crate) volumes: Faces,
    /// V_f over the mean of V (-).
    pub(crate) gains: Faces,
    /// A/V_f, 0 where closed (-).
    pub(crate) ratios: Faces,
    /// S/(V_f d) (1/m²), 0 of walls along which the fluid slips.
    pub(crate) friction: Faces,
    /// Velocity of the closest wall along the normal of cut and closed faces (m/s), if walls move.
    pub(crate) wall_velocity: Option<Faces>,
    /// Numbers of the walls closest to cells and to faces.
    pub(crate) closest: [Vec<u32>; 4],
    /// What is open between two velocities of a component along an axis, by how much closer they are than the faces, over the mean
    /// of V about the edge (-): for edges along an axis a, components a + 1 and a + 2 (mod 3).
    pub(crate) edges: [[Vec<f64>; 2]; 3],
    /// By how much closer the velocities of a component on the two faces of a cell are than these (-).
    pub(crate) centres: [Vec<f64>; 3],
}

/// What is open of a rectangle or a box.
#[derive(Clone, Copy, Debug, Default)]
struct Open {
    share: f64,
    /// Mean distance from the wall (m) of what is open.
    distance: f64,
    /// Unit vector away from the wall.
    direction: [f64; 3],
    /// Number of the closest wall, whether the fluid slips along it, and of a face its velocity along the normal (m/s).
    wall: usize,
    slips: bool,
    velocity: f64,
}

impl Open {
    /// All or nothing of what lies within a reach (m) of a place, unless a wall does too.
    fn whole(Clearance { distance, direction, wall }: Clearance, reach: f64) -> Option<Self> {
        match distance {
            _ if distance >= reach => Some(Self { share: 1.0, distance, direction, wall, ..Self::default() }),
            _ if distance <= -reach => Some(Self { wall, ..Self::default() }),
            _ => None,
        }
    }

    /// The open part of a box about `center` (m) of edges `widths` (m), some of them 0.
    fn of(center: [f64; 3], widths: [f64; 3], walls: &dyn Enclosure) -> Self {
        let middle = walls.clearance(center);
        if let Some(whole) = Self::whole(middle, reach(widths)) {
            return whole;
        }
        let Clearance { direction, wall, .. } = middle;
        let parts = widths.map(|w| if w > 0.0 { PARTS } else { 1 });
        let all: usize = parts.iter().product();
        let points: Vec<[f64; 3]> = (0..all)
            .map(|number| {
                let place = [number % parts[0], number / parts[0] % parts[1], number / (parts[0] * parts[1])];
                let offset = |a: usize| widths[a] * ((place[a] as f64 + 0.5) / parts[a] as f64 - 0.5);
                std::array::from_fn(|a| center[a] + offset(a))
            })
            .collect();
        let mut open = Self { direction, wall, ..Self::default() };
        for at in walls.clearances(center, middle.distance, reach(widths), &points) {
            // The distance changes by so much across the part.
            let across: f64 =
                (0..3).map(|a| (at.direction[a] * widths[a]).abs() / parts[a] as f64).sum::<f64>();
            let [lower, upper] = [at.distance - 0.5 * across, at.distance + 0.5 * across];
            let share = match across > 0.0 {
                true => (upper.max(0.0) - lower.max(0.0)) / across,
                false => f64::from(u8::from(at.distance > 0.0)),
            };
            open.share += share;
            open.distance += share * 0.5 * (upper.max(0.0) + lower.max(0.0));
        }
        if open.share > 0.0 {
            open.distance /= open.share;
            open.share /= all as f64;
        }
        open
    }
}

/// Distance (m) of the corners of a box of edges `widths` (m) from its middle.
fn reach(widths: [f64; 3]) -> f64 {
    0.5 * widths.iter().map(|w| w * w).sum::<f64>().sqrt()
}

/// Layers of cells more than a rank holds, so that what closed faces give to those in its halo is that of any ranks: such faces, what
/// is open about these, and the walls of cells.
const MORE_LAYERS: usize = 3;

/// What places along an axis stand for.
struct Places {
    /// The cell, and the node of its face above: beyond the box faces are mirrored too, and the lower end of it is the upper face of the
    /// cell beyond.
    of: Vec<[isize; 2]>,
    /// The first place that stands for the same cell.
    first_cell: Vec<usize>,
    /// The first one that stands for the same cell and face.
    first_face: Vec<usize>,
}

impl Places {
    /// Those of cells of these numbers, some of them beyond the box.
    fn new(grid: &Grid, axis: usize, numbers: impl Iterator<Item = isize>) -> Self {
        let (n, is_periodic) = (grid.cells()[axis] as isize, grid.axis(axis).is_periodic());
        let stands_for = |i: isize| match i {
            _ if is_periodic => [i.rem_euclid(n), i.rem_euclid(n) + 1],
            _ if i < 0 => [(-1 - i).min(n - 1); 2],
            _ if i >= n => [(2 * n - 1 - i).max(0); 2],
            _ => [i, i + 1],
        };
        let of: Vec<[isize; 2]> = numbers.map(stands_for).collect();
        let first = |is_same: fn(&[isize; 2], &[isize; 2]) -> bool| -> Vec<usize> {
            of.iter().map(|one| of.iter().position(|other| is_same(one, other)).unwrap_or(0)).collect()
        };
        let (first_cell, first_face) =
            (first(|one, other| one[0] == other[0]), first(|one, other| one == other));
        Self { of, first_cell, first_face }
    }
}

/// The cells about a rank, and some layers more than it holds: where those beyond the box are those mirrored or repeated.
struct Sampled {
    layout: Layout,
    /// Widths of the cells along each axis (m).
    widths: [Vec<f64>; 3],
    cells: Vec<f64>,
    /// Numbers of the walls closest to the cells.
    closest: Vec<u32>,
    faces: [Vec<Open>; 3],
}

impl Sampled {
    fn new(grid: &Grid, local: &Local, walls: &dyn Enclosure) -> Self {
        let layout = Layout { cells: local.layout.cells, halo: local.layout.halo + MORE_LAYERS };
        let mut cells = vec![0.0; layout.len()];
        let mut closest = vec![0; layout.len()];
        let mut faces: [Vec<Open>; 3] = std::array::from_fn(|_| vec![Open::default(); layout.len()]);
        let (h, dims) = (layout.halo as isize, layout.dims().map(|n| n as isize));
        // Walls that move are looked at in each step, mirrored and repeated cells once.
        let along =
            [0, 1, 2].map(|a| Places::new(grid, a, (0..dims[a]).map(|i| i - h + local.first[a] as isize)));
        let (strides, active) = (layout.strides(), [0, 1, 2].map(|a| grid.is_active(a)));
        for p in 0..layout.len() {
            let place = [p % dims[0] as usize, p / strides[1] % dims[1] as usize, p / strides[2]];
            let first = |axis: Option<usize>| -> usize {
                let of = |a: usize| {
                    let Places { first_cell, first_face, .. } = &along[a];
                    if axis == Some(a) { first_face[place[a]] } else { first_cell[place[a]] }
                };
                (0..3).map(|a| of(a) * strides[a]).sum()
            };
            let axes = (0..3).filter(|&a| active[a]);
            let same_cell = first(None);
            if same_cell < p && axes.clone().all(|axis| first(Some(axis)) < p) {
                (cells[p], closest[p]) = (cells[same_cell], closest[same_cell]);
                axes.for_each(|axis| faces[axis][p] = faces[axis][first(Some(axis))]);
                continue;
            }
            let cell = [0, 1, 2].map(|a| along[a].of[place[a]][0]);
            let center: [f64; 3] = std::array::from_fn(|a| grid.axis(a).centre(cell[a]));
            let widths: [f64; 3] =
                std::array::from_fn(|a| if active[a] { grid.axis(a).width(cell[a]) } else { 0.0 });
            // Where even the cells around are whole, a face is as its cell.
            let far = Open::whole(walls.clearance(center), AROUND * reach(widths));
            let cell_open = far.unwrap_or_else(|| Open::of(center, widths, walls));
            (cells[p], closest[p]) = (cell_open.share, cell_open.wall as u32);
            for axis in axes {
                let (mut center, mut widths) = (center, widths);
                (center[axis], widths[axis]) = (grid.axis(axis).node(along[axis].of[place[axis]][1]), 0.0);
                let mut face = far.unwrap_or_else(|| Open::of(center, widths, walls));
                (face.slips, face.velocity) =
                    (walls.slips(face.wall), walls.velocity(face.wall, center)[axis]);
                faces[axis][p] = face;
            }
        }
        let widths = std::array::from_fn(|a| {
            let number = |place: isize| place - h + local.first[a] as isize;
            (0..dims[a]).map(|place| grid.axis(a).width(number(place))).collect()
        });
        let mut sampled = Self { layout, widths, cells, closest, faces };
        sampled.close();
        sampled
    }

    /// Closes what is too narrow: cells without volume or open faces, and the faces of closed cells.
    fn close(&mut self) {
        let strides = self.layout.strides();
        let active: Vec<usize> = (0..3).filter(|&a| self.faces[a].iter().any(|f| f.share > 0.0)).collect();
        let is_closed = |cells: &[f64], p: usize| cells.get(p).is_none_or(|share| *share < CLOSED_CELL);
        for &a in &active {
            for p in 0..self.layout.len() {
                let face = &mut self.faces[a][p];
                if face.share < CLOSED_FACE
                    || is_closed(&self.cells, p)
                    || is_closed(&self.cells, p + strides[a])
                {
                    face.share = 0.0;
                }
            }
        }
        for p in 0..self.layout.len() {
            let is_shut = |a: &usize| {
                let below = p.checked_sub(strides[*a]);
                self.faces[*a][p].share == 0.0 && below.is_none_or(|q| self.faces[*a][q].share == 0.0)
            };
            if self.cells[p] < CLOSED_CELL || active.iter().all(is_shut) {
                self.cells[p] = 0.0;
            }
        }
    }
}

impl Openings {
    /// What walls leave open, of where points (m) of the box lie seen from them.
    pub(crate) fn new(grid: &Grid, local: &Local, walls: &dyn Enclosure) -> Self {
        let sampled = Sampled::new(grid, local, walls);
        let layout = local.layout;
        let control_volumes: [Vec<ControlVolume>; 3] = std::array::from_fn(|axis| match local.active[axis] {
            true => sampled.control_volumes(local.active, axis),
            false => Vec::new(),
        });
        let mut openings = Self {
            cells: Field::new(layout),
            faces: Faces::new(layout),
            volumes: Faces::new(layout),
            gains: Faces::new(layout),
            ratios: Faces::new(layout),
            friction: Faces::new(layout),
            wall_velocity: walls.is_moving().then(|| Faces::new(layout)),
            closest: std::array::from_fn(|_| vec![0; layout.len()]),
            edges: std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; layout.len()])),
            centres: std::array::from_fn(|_| vec![1.0; layout.len()]),
        };
        let (wide, h) = (sampled.layout.strides(), layout.halo as isize);
        let [nx, ny, nz] = layout.cells.map(|n| n as isize);
        for k in -h..nz + h {
            for j in -h..ny + h {
                for i in -h..nx + h {
                    let place = [i, j, k].map(|m| (m + h) as usize);
                    let (p, q) = (layout.index(i, j, k), sampled.layout.index(i, j, k));
                    openings.cells.data_mut()[p] = sampled.cells[q];
                    openings.closest[3][p] = sampled.closest[q];
                    for axis in (0..3).filter(|&a| local.active[a]) {
                        let width = local.axes[axis].width[place[axis]];
                        openings.set_face(
                            axis,
                            p,
                            (&sampled.faces[axis][q], &control_volumes[axis][q]),
                            width,
                        );
                    }
                    for axis in (0..3).filter(|&a| local.active[a]) {
                        let below = &sampled.faces[axis][q - wide[axis]];
                        let width = local.axes[axis].width[place[axis]];
                        openings.centres[axis][p] = closer(below, &sampled.faces[axis][q], axis, width);
                    }
                    for along in 0..3 {
                        for (number, shift) in [1, 2].into_iter().enumerate() {
                            let component = (along + shift) % 3;
                            let across = 3 - along - component;
                            openings.edges[along][number][p] =
                                sampled.between([component, across], q, wide, &|a| {
                                    local.axes[a].width[place[a]]
                                });
                        }
                    }
                }
            }
        }
        openings
    }

    fn set_face(&mut self, axis: usize, p: usize, (face, control): (&Open, &ControlVolume), width: f64) {
        self.volumes.component_mut(axis)[p] = control.volume + control.gained;
        self.gains.component_mut(axis)[p] =
            if control.volume > 0.0 { 1.0 + control.gained / control.volume } else { 1.0 };
        self.closest[axis][p] = face.wall as u32;
        let is_beside = face.share < 1.0 || control.wall > 0.0;
        if let (Some(velocity), true) = (&mut self.wall_velocity, is_beside) {
            velocity.component_mut(axis)[p] = face.velocity;
        }
        if face.share > 0.0 {
            let volume = control.volume + control.gained;
            let share = face.share.min(WIDEST * volume);
            self.faces.component_mut(axis)[p] = share;
            self.ratios.component_mut(axis)[p] = share / volume;
            let distance = face.distance.max(CLOSEST * width);
            let friction = if face.slips { 0.0 } else { control.wall / (volume * distance) };
            self.friction.component_mut(axis)[p] = friction;
        }
    }
}

/// What the control volume of a face holds.
#[derive(Clone, Copy, Debug, Default)]
struct ControlVolume {
    /// Mean V_f of the open shares of its cells (-).
    volume: f64,
    /// What it gains from closed faces beside it, or gives to open ones if it is closed (-).
    gained: f64,
    /// Area of wall per volume (1/m).
    wall: f64,
}

impl Sampled {
    /// What the control volumes of the faces normal to an axis hold. Nothing moves through closed faces: what is open about them, and
    /// the wall there, goes to the open faces beside them, by the squares of what is open in between, as momentum flows from a
    /// linear profile.
    fn control_volumes(&self, active: [bool; 3], axis: usize) -> Vec<ControlVolume> {
        let (layout, strides) = (self.layout, self.layout.strides());
        let place = |q: usize| [q % strides[1], q % strides[2] / strides[1], q / strides[2]];
        let stride = strides[axis];
        let mut volumes = vec![ControlVolume::default(); layout.len()];
        let width = |a: usize, q: usize| self.widths[a][place(q)[a]];
        for (q, control) in volumes.iter_mut().enumerate().take(layout.len() - stride) {
            let [below, above] = [width(axis, q), width(axis, q + stride)];
            let mean = |of: &dyn Fn(usize) -> f64| (above * of(q) + below * of(q + stride)) / (below + above);
            control.volume = mean(&|q| self.cells[q]);
            control.wall = mean(&|q| self.wall_area(q, &|a| width(a, q)));
        }
        let size = |q: usize| {
            let along = 0.5 * (width(axis, q) + width(axis, q + stride));
            (0..3).map(|a| if a == axis { along } else { width(a, q) }).product::<f64>()
        };
        for q in 0..layout.len() {
            let place = place(q);
            let is_inner = (0..3).all(|a| place[a] > 0 && place[a] + 2 < layout.dims()[a]);
            if !is_inner || self.faces[axis][q].share > 0.0 || volumes[q].volume + volumes[q].wall == 0.0 {
                continue;
            }
            let beside = (0..3).filter(|&a| active[a]).flat_map(|a| {
                let area = size(q) / width(a, q);
                let open = |below: usize| match a == axis {
                    true => self.cells[below],
                    false => 0.5 * (self.faces[a][below].share + self.faces[a][below + stride].share),
                };
                let low = if a == axis { q } else { q - strides[a] };
                let high = if a == axis { q + stride } else { q };
                [(q - strides[a], open(low) * area), (q + strides[a], open(high) * area)]
            });
            let beside = beside.filter(|&(r, _)| self.faces[axis][r].share > 0.0);
            let all: f64 = beside.clone().map(|(_, area)| area * area).sum();
            if all > 0.0 {
                let given = volumes[q];
                for (r, area) in beside {
                    let share = area * area / all * size(q) / size(r);
                    volumes[r].gained += share * given.volume;
                    volumes[r].wall += share * given.wall;
                }
                volumes[q].gained = -given.volume;
                volumes[q].wall = 0.0;
            }
        }
        volumes
    }
}

impl Sampled {
    /// Area of wall per volume of a cell (1/m): what its faces lack of one another.
    fn wall_area(&self, q: usize, width: &dyn Fn(usize) -> f64) -> f64 {
        let strides = self.layout.strides();
        let lacking = |a: usize| {
            let below = q.checked_sub(strides[a]).map_or(0.0, |q| self.faces[a][q].share);
            (self.faces[a][q].share - below) / width(a)
        };
        (0..3).map(|a| lacking(a).powi(2)).sum::<f64>().sqrt()
    }

    /// What is open between the velocities of a component on the faces of cells `q` and the next one across, by how much closer
    /// they are, over the mean of V about their edge.
    fn between(
        &self,
        [component, across]: [usize; 2],
        q: usize,
        strides: [usize; 3],
        width: &dyn Fn(usize) -> f64,
    ) -> f64 {
        let [a, b] = [strides[component], strides[across]];
        if q + a + b >= self.cells.len() {
            return 0.0;
        }
        let mean = 0.25 * (self.cells[q] + self.cells[q + a] + self.cells[q + b] + self.cells[q + a + b]);
        let open = 0.5 * (self.faces[across][q].share + self.faces[across][q + a].share);
        let [here, next] = [q, q + b].map(|q| self.faces[component][q]);
        match closer(&here, &next, across, width(across)) {
            0.0 => 0.0,
            closer => open * closer / mean,
        }
    }
}

/// By how much closer two velocities are than the width of a cell (m) that lies along an axis between their faces; 0 if one is
/// closed. Beside a wall velocities are as their distances from it, and so is the shear.
fn closer(here: &Open, next: &Open, axis: usize, width: f64) -> f64 {
    let smaller = here.share.min(next.share);
    if smaller == 0.0 {
        return 0.0;
    } else if smaller == 1.0 || here.slips || next.slips {
        return 1.0;
    }
    let slope = 0.5 * (here.direction[axis] + next.direction[axis]) * width;
    let rise = next.distance - here.distance;
    match slope.abs().max(rise.abs()) > ALONG * width {
        true => (slope / rise).clamp(0.0, CLOSER),
        false => 1.0,
    }
}
