//! What solids make of the faces and cells of one scalar.
//!
//! Middles of cells are where the scalar lies. Three kinds of solids differ:
//!
//! ```text
//! fixed      a value on the surface: cells whose middle is inside have it, and through the faces next to them
//!           D (φ_s − φ)/(θ Δx) passes, θ Δx the distance of the surface along the axis (Gibou et al. 2002)
//! closed    a flux through the surface: faces pass what is open of their areas, cells hold what is open of their volumes
//!           (Papac et al. 2010)
//! interior  it diffuses inside: resistances of both sides in a row, and what the tangential gradient carries (`jump`)
//! ```
//!
//! All fluxes are single-valued, so that what leaves the fluid enters the solid.

use super::super::advance::{for_faces, is_own};
use super::super::{Interior, ScalarSetup, SolidCondition};
use super::cells::{BEYOND, CutFace, NearFace, SolidCells, share_in_front};
use super::jump::Jump;
use crate::metrics::Local;
use std::cmp::Ordering;

/// Mass of a cell whose value no step changes, over that of others.
pub(in super::super) const FIXED: f64 = 1e200;

/// Smallest share of a cell that it is open to fluid where any of it is (-): next to nothing would be emptied in no time.
const MIN_OPEN: f64 = 0.05;
/// Step by which the area of a plane in a cell is found, over the width of the cell (-).
const STEP: f64 = 1e-3;
/// Share below which it is closed (-).
const NONE_OPEN: f64 = 1e-4;

/// A face between a cell that the scalar changes in and one in which it does not.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Tie {
    /// Places of the face, of the cell that changes and of the other.
    pub face: usize,
    pub free: usize,
    pub fixed: usize,
    /// +1 where the fixed cell lies above, else −1.
    pub side: f64,
    /// Number of the solid.
    pub solid: u32,
    /// What conducts between the free cell and the surface (m³/s) where that cell is full of fluid; 0 if the solid is closed.
    pub conductance: f64,
    /// Volume (m³) of fluid in the free cell without particles.
    pub volume: f64,
    /// Share of the way from the free middle to the surface of that to the other middle (-).
    pub way: f64,
    /// Value on the surface; none of a closed solid.
    pub value: Option<f64>,
    /// What flow carries along the axis (unit m³/s) in this step.
    pub carried: f64,
}

/// A piece of the surface of a closed solid.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Surface {
    pub cell: usize,
    pub solid: u32,
    /// Area (m²), and how far the middle of the cell is in the fluid (m).
    pub area: f64,
    pub distance: f64,
}

/// A cell with a part of a solid that it diffuses in.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Inside {
    pub cell: usize,
    pub solid: u32,
    /// Volume (m³) of that part.
    pub volume: f64,
}

/// What a scalar meets.
pub(in super::super) struct Barrier {
    /// What a cell holds per unit of the scalar and of its volume of fluid (-); [`FIXED`] where nothing changes it.
    pub capacity: Vec<f64>,
    /// Conductance of faces that differs from that of the fluid alone (m³/s), per axis; in averaged flows over that (-).
    pub conductance: [Vec<(u32, f64)>; 3],
    pub is_averaged: bool,
    pub ties: [Vec<Tie>; 3],
    /// Places of own cells that are fixed, with their solids.
    pub fixed: Vec<(u32, u32)>,
    pub surfaces: Vec<Surface>,
    pub inside: Vec<Inside>,
    pub jumps: [Vec<Jump>; 3],
    /// For each cell 1 plus the number of the solid whose interior its middle lies in, else 0; halo included. Empty without interiors.
    pub interior: Vec<u32>,
}

/// What a solid is to a scalar.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Fixed,
    Closed,
    Interior(Interior),
}

struct Builder<'a> {
    cells: &'a SolidCells,
    setup: &'a ScalarSetup,
    local: &'a Local,
    kinds: Vec<Kind>,
    barrier: Barrier,
}

impl Barrier {
    /// That of a scalar.
    pub fn new(cells: &SolidCells, setup: &ScalarSetup, local: &Local) -> Self {
        let kind = |number: usize| match setup.solids.of(number, cells.bodies) {
            SolidCondition::Value(_) | SolidCondition::OfSolid => Kind::Fixed,
            SolidCondition::Flux(_) | SolidCondition::Transfer { .. } => Kind::Closed,
            SolidCondition::Interior(interior) => Kind::Interior(*interior),
        };
        let kinds: Vec<Kind> = (0..cells.count).map(kind).collect();
        let barrier = Self {
            capacity: vec![1.0; local.layout.len()],
            conductance: Default::default(),
            is_averaged: cells.is_averaged,
            ties: Default::default(),
            fixed: Vec::new(),
            surfaces: Vec::new(),
            inside: Vec::new(),
            jumps: Default::default(),
            interior: Vec::new(),
        };
        let mut builder = Builder { cells, setup, local, kinds, barrier };
        builder.set_capacities();
        for axis in (0..3).filter(|&a| local.active[a]) {
            builder.set_faces(axis);
        }
        builder.find_surfaces();
        builder.barrier
    }

    /// Whether a step changes the scalar in a cell.
    pub fn is_free(&self, place: usize) -> bool {
        self.capacity[place] < FIXED
    }
}

impl Builder<'_> {
    fn kind_at(&self, place: usize) -> Option<Kind> {
        match self.cells.holder[place] {
            0 | BEYOND => None,
            holder => match self.kinds[holder as usize - 1] {
                // What is open of it is fluid like all else.
                Kind::Closed if self.cells.is_averaged => None,
                kind => Some(kind),
            },
        }
    }

    /// Volume (m³) of fluid in a cell without particles.
    fn open_volume(&self, place: usize) -> f64 {
        if !self.cells.is_averaged {
            return self.local.volume_at(place);
        }
        let near = &self.cells.near_cells;
        let first = near.partition_point(|cell| (cell.place as usize) < place);
        let here = near[first..].iter().take_while(|cell| cell.place as usize == place);
        self.local.volume_at(place) * (1.0 - here.map(|cell| cell.share).sum::<f64>()).max(MIN_OPEN)
    }

    /// Whether the scalar changes in solids alone.
    fn has_no_film(&self) -> bool {
        self.setup.solids.no_film.is_some()
    }

    fn set_capacities(&mut self) {
        let has_interiors = self.kinds.iter().any(|kind| matches!(kind, Kind::Interior(_)));
        if has_interiors {
            self.barrier.interior = vec![0; self.cells.holder.len()];
        }
        for place in 0..self.cells.holder.len() {
            match self.kind_at(place) {
                None if self.has_no_film() => self.barrier.capacity[place] = FIXED,
                None => {}
                Some(Kind::Fixed | Kind::Closed) => self.barrier.capacity[place] = FIXED,
                Some(Kind::Interior(interior)) => {
                    self.barrier.capacity[place] = interior.capacity;
                    self.barrier.interior[place] = self.cells.holder[place];
                }
            }
        }
        for group in self.cells.near_cells.chunk_by(|a, b| a.place == b.place) {
            let place = group[0].place as usize;
            let is_fixed = matches!(self.kind_at(place), Some(Kind::Fixed));
            let is_point = self.cells.is_averaged || self.has_no_film();
            if is_fixed || self.cells.holder[place] == BEYOND || is_point {
                continue;
            }
            let (mut open, mut inner) = (1.0_f64, 0.0);
            for cell in group {
                match self.kinds[cell.solid as usize] {
                    Kind::Fixed => {}
                    Kind::Closed => open -= cell.share,
                    Kind::Interior(interior) => {
                        open -= cell.share;
                        inner += cell.share * interior.capacity;
                    }
                }
            }
            let capacity = inner + open.max(0.0);
            self.barrier.capacity[place] = match capacity {
                x if inner <= 0.0 && x < NONE_OPEN => FIXED,
                x => x.max(MIN_OPEN),
            };
        }
        for place in 0..self.cells.holder.len() {
            if !is_own(self.local.layout, place) {
                continue;
            }
            let holder = self.cells.holder[place];
            if matches!(self.kind_at(place), Some(Kind::Fixed)) {
                self.barrier.fixed.push((place as u32, holder - 1));
            }
        }
        if has_interiors {
            self.find_inside();
        }
    }

    /// The cells with parts of solids that the scalar diffuses in.
    fn find_inside(&mut self) {
        let mut near = self.cells.near_cells.iter().peekable();
        for place in 0..self.cells.holder.len() {
            let is_own = is_own(self.local.layout, place);
            let mut is_near = false;
            while let Some(cell) = near.next_if(|cell| cell.place as usize <= place) {
                let is_interior = matches!(self.kinds[cell.solid as usize], Kind::Interior(_));
                is_near |= cell.solid + 1 == self.cells.holder[place];
                let counts = self.barrier.is_free(place) || self.has_no_film();
                if is_own && is_interior && cell.share > 0.0 && counts {
                    let volume = cell.share * self.local.volume_at(place);
                    self.barrier.inside.push(Inside { cell: place, solid: cell.solid, volume });
                }
            }
            if is_own && !is_near && matches!(self.kind_at(place), Some(Kind::Interior(_))) {
                let (solid, volume) = (self.cells.holder[place] - 1, self.local.volume_at(place));
                self.barrier.inside.push(Inside { cell: place, solid, volume });
            }
        }
    }

    /// The solid that holds a cell's middle, or one that shuts it.
    fn solid_of(&self, place: usize) -> Option<u32> {
        let near = &self.cells.near_cells;
        let shuts = || {
            let first = near.partition_point(|cell| (cell.place as usize) < place);
            near.get(first).filter(|cell| cell.place as usize == place).map(|cell| cell.solid)
        };
        self.cells.holder[place].checked_sub(1).or_else(shuts)
    }

    /// Diffusivity of what is at a cell's middle, of φ.
    fn diffusivity(&self, place: usize) -> f64 {
        match self.kind_at(place) {
            Some(Kind::Interior(interior)) => interior.capacity * interior.diffusivity,
            _ => self.setup.diffusivity,
        }
    }

    fn set_faces(&mut self, axis: usize) {
        let (local, stride) = (self.local, self.local.layout.strides()[axis]);
        let mut cut = self.cells.cut[axis].iter().peekable();
        let mut near = &self.cells.near_faces[axis][..];
        let (mut ties, mut conductances, mut jumps) = (Vec::new(), Vec::new(), Vec::new());
        for_faces(local, axis, |face, area, e| {
            while cut.next_if(|cut| (cut.place as usize) < face).is_some() {}
            let cut = cut.peek().filter(|cut| cut.place as usize == face);
            let first = near.partition_point(|near| (near.place as usize) < face);
            near = &near[first..];
            let about = &near[..near.partition_point(|near| near.place as usize == face)];
            let cells = [face, face + stride];
            if cells.iter().any(|&p| self.cells.holder[p] == BEYOND) {
                return;
            }
            let is_free = cells.map(|p| self.barrier.is_free(p));
            let geometry = area * local.axes[axis].inverse_distance[e];
            match is_free {
                [false, false] => conductances.push((face as u32, 0.0)),
                [true, true] if self.cells.is_averaged => {
                    // Middles are points: beside a surface with a value all of a face conducts.
                    let fixed = about.iter().filter(|near| self.kinds[near.solid as usize] == Kind::Fixed);
                    let open = 1.0 - fixed.map(|near| near.share).sum::<f64>();
                    if open < 1.0 {
                        conductances.push((face as u32, 1.0 / open.max(MIN_OPEN)));
                    }
                }
                [true, true] => {
                    let of_both = self.between(face, cells, geometry, cut.copied().copied(), about, axis);
                    let Some((conductance, jump)) = of_both else { return };
                    conductances.push((face as u32, conductance));
                    jumps.extend(jump);
                }
                [below_is_free, _] => {
                    let (free, fixed) =
                        if below_is_free { (cells[0], cells[1]) } else { (cells[1], cells[0]) };
                    // Without a film the surface is that of the solid in which the free cell lies.
                    let of = if self.has_no_film() { free } else { fixed };
                    let Some(solid) = self.solid_of(of) else { return };
                    let way = match self.has_no_film() {
                        true => cut.map_or(0.5, |cut| cut.solid[usize::from(!below_is_free)]),
                        false => cut.map_or(0.5, |cut| 1.0 - cut.solid[usize::from(below_is_free)]),
                    };
                    let is_fixed = self.kinds[solid as usize] == Kind::Fixed || self.has_no_film();
                    let conductance = if is_fixed { self.diffusivity(free) * geometry / way } else { 0.0 };
                    let side = if below_is_free { 1.0 } else { -1.0 };
                    conductances.push((face as u32, 0.0));
                    let volume = self.open_volume(free);
                    ties.push(Tie {
                        face,
                        free,
                        fixed,
                        side,
                        solid,
                        conductance,
                        volume,
                        way,
                        value: None,
                        carried: 0.0,
                    });
                }
            }
        });
        self.barrier.ties[axis] = ties;
        self.barrier.conductance[axis] = conductances;
        self.barrier.jumps[axis] = jumps;
    }

    /// Conductance (m³/s) between two cells that both change, and what the tangential gradient adds; none if nothing is in the way.
    fn between(
        &self,
        face: usize,
        cells: [usize; 2],
        geometry: f64,
        cut: Option<CutFace>,
        about: &[NearFace],
        axis: usize,
    ) -> Option<(f64, Option<Jump>)> {
        let fluid = self.setup.diffusivity;
        let closed: f64 = about
            .iter()
            .filter(|near| self.kinds[near.solid as usize] == Kind::Closed)
            .map(|near| near.share)
            .sum();
        let is_closed = |p: usize| self.kind_at(p) == Some(Kind::Closed);
        let closed = match cells.iter().all(|&p| is_closed(p)) && about.is_empty() {
            true => 1.0,
            false => closed.min(1.0),
        };
        if self.has_no_film() {
            return Some((self.diffusivity(cells[0]) * geometry, None));
        }
        if self.barrier.interior.is_empty() {
            return (closed > 0.0).then_some((fluid * geometry * (1.0 - closed), None));
        }
        let solids = cells.map(|p| self.barrier.interior[p]);
        // Shares of the way, and of the face, in interiors.
        let way = if solids[0] == solids[1] { None } else { cut.map(|cut| cut.solid) };
        // Of several the one that takes most of the face: not the first, as numbers of solids differ from rank to rank.
        let of_interiors =
            about.iter().filter(|near| matches!(self.kinds[near.solid as usize], Kind::Interior(_)));
        let order = |near: &&NearFace| (near.share, near.normal);
        let inner = of_interiors.max_by(|a, b| order(a).partial_cmp(&order(b)).unwrap_or(Ordering::Equal));
        let diffusivities = cells.map(|p| self.diffusivity(p));
        let straight = match way {
            Some([below, above]) => {
                let [below, above] = [0, 1].map(|n| if solids[n] > 0 { [below, above][n] } else { 0.0 });
                let gap = (1.0 - below - above).max(0.0);
                1.0 / (below / diffusivities[0] + gap / fluid + above / diffusivities[1])
            }
            None if solids[0] == 0 => fluid * (1.0 - closed),
            None => diffusivities[0],
        };
        let Some(near) = inner else {
            let differs = straight != fluid;
            return differs.then_some((straight * geometry, None));
        };
        let Kind::Interior(interior) = self.kinds[near.solid as usize] else { return None };
        let inside = interior.capacity * interior.diffusivity;
        if solids.iter().any(|&s| s > 0 && s != near.solid + 1) {
            return Some((straight * geometry, None));
        }
        let open = 1.0 - near.share;
        // q = straight Δφ/Δx + tangential g, g the tangential gradient along the axis (see `jump`).
        let tangential = match (way, solids) {
            (Some([below, above]), _) => {
                let theta = 1.0 - if solids[0] > 0 { below } else { above };
                -straight * (fluid - inside) * (theta * (1.0 - open) / fluid - (1.0 - theta) * open / inside)
            }
            (None, [0, 0]) => -(1.0 - open) * (fluid - inside),
            (None, _) => open * (fluid - inside),
        };
        let n = near.normal[axis];
        let implicit = 2.0 * tangential.max(0.0) * (1.0 - n * n);
        let is_denser = inside > fluid;
        let preferred = cells.iter().copied().find(|&p| (self.barrier.interior[p] > 0) == is_denser);
        let source = preferred.unwrap_or_else(|| self.across(cells[0], near, is_denser));
        let area = geometry / self.local.axes[axis].inverse_distance[self.entry(face, axis)];
        let jump = Jump {
            face,
            cell: source,
            normal: near.normal,
            tangential: area * tangential,
            implicit: geometry * implicit,
        };
        Some(((straight + implicit) * geometry, Some(jump)))
    }

    fn entry(&self, place: usize, axis: usize) -> usize {
        place / self.local.layout.strides()[axis] % self.local.layout.dims()[axis]
    }

    /// The cell across the surface from one, or itself: the one whose gradient is the smoother tells that along the surface.
    fn across(&self, cell: usize, near: &NearFace, is_denser: bool) -> usize {
        let sizes = near.normal.map(f64::abs);
        let axes = (0..3).filter(|&a| self.local.active[a]);
        let Some(a) = axes.max_by(|&a, &b| sizes[a].total_cmp(&sizes[b])) else { return cell };
        let stride = self.local.layout.strides()[a];
        // Into the solid where that conducts better, else out of it.
        let is_up = (near.normal[a] > 0.0) != is_denser;
        let other = if is_up { cell + stride } else { cell - stride };
        let is_there = (self.barrier.interior[other] > 0) == is_denser && self.cells.holder[other] != BEYOND;
        if is_there { other } else { cell }
    }

    /// Pieces of the surfaces of closed solids: the part of each tangent plane in its cell, which is how fast the share of that grows with
    /// the distance.
    fn find_surfaces(&mut self) {
        let layout = self.local.layout;
        let (strides, dims) = (layout.strides(), layout.dims());
        let passes = |number: usize| {
            let condition = self.setup.solids.of(number, self.cells.bodies);
            !condition.is_insulated() && self.kinds[number] == Kind::Closed
        };
        let mut surfaces = Vec::new();
        for cell in self.cells.near_cells.iter().filter(|cell| passes(cell.solid as usize)) {
            let place = cell.place as usize;
            let widths = [0, 1, 2].map(|a| match self.local.active[a] {
                true => self.local.axes[a].width[place / strides[a] % dims[a]],
                false => 0.0,
            });
            let step = STEP * widths.iter().copied().fold(0.0, f64::max);
            let [more, less] =
                [step, -step].map(|d| share_in_front(cell.distance + d, &cell.normal, &widths));
            let area = self.local.volume_at(place) * (more - less) / (2.0 * step);
            let mut add = |to: usize, area: f64, distance: f64| {
                if area > 0.0 && is_own(layout, to) && self.barrier.is_free(to) {
                    surfaces.push(Surface { cell: to, solid: cell.solid, area, distance });
                }
            };
            if cell.distance >= 0.0 {
                add(place, area, cell.distance);
                continue;
            }
            // What lies in a cell that is solid for the most part comes into those in front of it.
            let sizes = [0, 1, 2].map(|a| (cell.normal[a] * widths[a]).abs());
            let sum: f64 = sizes.iter().sum();
            for a in (0..3).filter(|&a| sizes[a] > 0.0) {
                let (e, is_up) = (place / strides[a] % dims[a], cell.normal[a] > 0.0);
                if (is_up && e + 1 < dims[a]) || (!is_up && e > 0) {
                    let to = if is_up { place + strides[a] } else { place - strides[a] };
                    add(to, area * sizes[a] / sum, cell.distance + sizes[a]);
                }
            }
        }
        self.barrier.surfaces = surfaces;
    }
}
