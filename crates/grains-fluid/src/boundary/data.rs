//! The conditions of one face, spelt out for every boundary cell of a subdomain.

use super::outline::tangents_of;
use super::pieces::{Outlines, Piece};
use super::{Boundaries, BoxFace, Condition, Profile, Side};
use crate::metrics::Local;
use crate::{Grid, Layout};
use std::ops::Range;

/// Layers of ghosts that are ever read beyond an end of the box.
pub(crate) const MAX_GHOSTS: usize = 2;

/// How a velocity component behaves on a boundary cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Imposed.
    Fixed,
    /// No gradient; a normal component is zero.
    Slip,
    /// Outlet, or inlet of imposed pressure.
    Free,
}

/// Conditions on the own part of a face, halo included: entry m₂ d₁ + m₁ for array places m₁, m₂ along the two
/// tangential axes.
#[derive(Clone, Debug)]
pub(crate) struct BoundaryData {
    pub face: BoxFace,
    /// Tangential axes and the extents of the arrays along them.
    pub tangents: [usize; 2],
    pub extents: [usize; 2],
    /// Those entries along them whose ghosts are read: all but those further beyond the ends of the box.
    pub(super) read: [Range<usize>; 2],
    /// Per velocity component.
    pub kinds: [Vec<Kind>; 3],
    /// Imposed velocities (m/s).
    pub values: [Vec<f64>; 3],
    /// Their change over the last step (m/s).
    pub increments: [Vec<f64>; 3],
    /// Ghost of a tangential velocity: weights of the imposed value, the first and the second cell.
    pub wall: [f64; 3],
    /// Pressure that is imposed on cells of outlets and pressure inlets (Pa).
    pub pressure: Vec<f64>,
    /// Whether imposed velocities may change in time.
    pub is_unsteady: bool,
    /// Whether on some cell a pressure is imposed.
    pub has_outlet: bool,
    /// Whether imposed velocities depend on what walls leave open.
    pub depends_on_walls: bool,
    /// Numbers of the conditions at the places of the components, see [`Boundaries::condition`].
    pub(super) conditions: [Vec<u32>; 3],
    /// What patches cut the faces of cells into: those of entry e from place `first_piece[e]` on.
    pieces: Vec<Piece>,
    first_piece: Vec<u32>,
    /// Total pressures (Pa) of cells of pressure inlets, if there are any; not a number on others.
    pub(super) totals: Option<Vec<f64>>,
    /// What walls leave of the velocity through the face of a cell (-), see [`BoundaryData::weigh`].
    pub(super) masks: Vec<f64>,
    /// Factors of the profiles of the conditions, by their numbers: (-), of flow rates (1/m²).
    pub(super) scales: Vec<f64>,
}

impl BoundaryData {
    /// Tables of the faces the subdomain touches; imposed velocities are 0 until they are evaluated.
    pub fn all(grid: &Grid, local: &Local, boundaries: &Boundaries) -> Vec<BoundaryData> {
        // Across an axis of one cell nothing is read.
        let touched = |face: &BoxFace| {
            local.active[face.axis] && local.ends[face.axis][usize::from(face.side == Side::High)]
        };
        BoxFace::all()
            .filter(touched)
            .map(|face| {
                let mut face_data = BoundaryData::new(face, local, boundaries);
                face_data.classify(grid, local, boundaries);
                face_data
            })
            .collect()
    }

    fn new(face: BoxFace, local: &Local, boundaries: &Boundaries) -> Self {
        let layout = local.layout;
        let tangents = tangents_of(face.axis);
        let extents = tangents.map(|t| layout.dims()[t]);
        let size = extents[0] * extents[1];
        let read = tangents.map(|t| {
            let [below, above] =
                local.ends[t].map(|is_end| if is_end { layout.halo.saturating_sub(MAX_GHOSTS) } else { 0 });
            below..layout.dims()[t] - above
        });
        let zeros = || std::array::from_fn(|_| vec![0.0; size]);
        Self {
            face,
            tangents,
            extents,
            read,
            kinds: std::array::from_fn(|_| vec![Kind::Fixed; size]),
            values: zeros(),
            increments: zeros(),
            wall: local.walls[face.axis][usize::from(face.side == Side::High)],
            pressure: vec![0.0; size],
            is_unsteady: false,
            has_outlet: false,
            depends_on_walls: false,
            conditions: std::array::from_fn(|_| vec![0; size]),
            pieces: Vec::new(),
            first_piece: vec![0; size + 1],
            totals: None,
            masks: vec![1.0; size],
            scales: vec![1.0; boundaries.conditions().count()],
        }
    }

    /// Whether fluid may pass the face of a cell: an inlet or outlet, if only in part.
    pub fn is_passed(&self, e: usize, boundaries: &Boundaries) -> bool {
        let is_inlet =
            |piece: &Piece| matches!(boundaries.condition(piece.condition), Condition::Inlet { .. });
        self.kinds[self.face.axis][e] == Kind::Free || self.pieces_of(e).iter().any(is_inlet)
    }

    /// Global cell and position (m) of a component at an entry, within the period of periodic axes.
    pub fn place(
        &self,
        grid: &Grid,
        local: &Local,
        component: usize,
        entry: [usize; 2],
    ) -> ([isize; 3], [f64; 3]) {
        let (axis, n) = (self.face.axis, grid.cells()[self.face.axis] as isize);
        let mut cell = [0; 3];
        cell[axis] = if self.face.side == Side::High { n - 1 } else { 0 };
        let mut at = [0.0; 3];
        at[axis] = grid.axis(axis).node(if self.face.side == Side::High { n } else { 0 });
        for (t, m) in self.tangents.into_iter().zip(entry) {
            cell[t] = m as isize - local.layout.halo as isize + local.first[t] as isize;
            if grid.axis(t).is_periodic() {
                cell[t] = cell[t].rem_euclid(grid.cells()[t] as isize);
            }
            at[t] =
                if t == component { grid.axis(t).node(cell[t] + 1) } else { grid.axis(t).centre(cell[t]) };
        }
        (cell, at)
    }

    pub(super) fn entries(&self) -> impl Iterator<Item = (usize, [usize; 2])> + use<> {
        let [d1, d2] = self.extents;
        (0..d2).flat_map(move |m2| (0..d1).map(move |m1| (m2 * d1 + m1, [m1, m2])))
    }

    fn classify(&mut self, grid: &Grid, local: &Local, boundaries: &Boundaries) {
        let outlines = Outlines::new(grid, boundaries, self.face);
        for component in 0..3 {
            for (e, entry) in self.entries() {
                let (cell, at) = self.place(grid, local, component, entry);
                let number = outlines.condition_at(at);
                let condition = boundaries.condition(number);
                self.conditions[component][e] = number as u32;
                // What comes in through a part of the cell's face counts, whatever lies at its middle.
                let (mut is_inlet, mut is_unsteady) = (false, condition.is_unsteady());
                if component == self.face.axis {
                    for piece in outlines.pieces(cell, at) {
                        let condition = boundaries.condition(piece.condition);
                        is_inlet |= matches!(condition, Condition::Inlet { .. });
                        self.depends_on_walls |= is_inlet;
                        is_unsteady |= condition.is_unsteady();
                        self.pieces.push(piece);
                    }
                    self.first_piece[e + 1] = self.pieces.len() as u32;
                }
                self.kinds[component][e] = match condition {
                    _ if is_inlet => Kind::Fixed,
                    Condition::Wall { .. } | Condition::Inlet { .. } => Kind::Fixed,
                    Condition::Symmetry => Kind::Slip,
                    Condition::Outlet { pressure } | Condition::PressureInlet { pressure, .. } => {
                        if component == self.face.axis {
                            self.pressure[e] = *pressure;
                            self.has_outlet = true;
                            if let Condition::PressureInlet { .. } = condition {
                                let size = self.pressure.len();
                                self.totals.get_or_insert_with(|| vec![f64::NAN; size])[e] = *pressure;
                            }
                        }
                        Kind::Free
                    }
                };
                self.is_unsteady |= is_unsteady;
            }
        }
    }

    /// Sets the imposed velocities to those of a time (s), and their change since the last call.
    pub fn evaluate(&mut self, grid: &Grid, local: &Local, boundaries: &Boundaries, time: f64) {
        for component in 0..3 {
            for (e, entry) in self.entries() {
                let value = if component == self.face.axis {
                    let pieces = self.pieces_of(e).iter();
                    self.masks[e]
                        * pieces.map(|piece| piece.share * self.normal(boundaries, piece, time)).sum::<f64>()
                } else {
                    match boundaries.condition(self.conditions[component][e] as usize) {
                        Condition::Wall { velocity } => velocity[component],
                        Condition::Inlet { profile: Profile::Uniform(velocity) } => velocity[component],
                        Condition::Inlet { profile: Profile::Function(f) } => {
                            f(self.place(grid, local, component, entry).1, time)[component]
                        }
                        Condition::Inlet { profile: Profile::SteadyFunction(f) } => {
                            f(self.place(grid, local, component, entry).1)[component]
                        }
                        _ => 0.0,
                    }
                };
                self.increments[component][e] = value - self.values[component][e];
                self.values[component][e] = value;
            }
        }
    }

    /// The velocity along the axis (m/s) that is imposed on a piece.
    fn normal(&self, boundaries: &Boundaries, piece: &Piece, time: f64) -> f64 {
        let axis = self.face.axis;
        let inwards = -self.face.outward() * self.scales[piece.condition];
        match boundaries.condition(piece.condition) {
            Condition::Wall { velocity } => velocity[axis],
            Condition::Inlet { profile } => match profile {
                Profile::Uniform(velocity) => velocity[axis],
                Profile::Function(f) => f(piece.at, time)[axis],
                Profile::SteadyFunction(f) => f(piece.at)[axis],
                Profile::Parabolic { mean } => inwards * mean * piece.parabola,
                Profile::FlowRate { rate, .. } => inwards * rate.at(time) * piece.parabola,
            },
            Condition::Symmetry | Condition::Outlet { .. } | Condition::PressureInlet { .. } => 0.0,
        }
    }

    /// What patches cut the face of a cell into.
    pub(super) fn pieces_of(&self, e: usize) -> &[Piece] {
        &self.pieces[self.first_piece[e] as usize..self.first_piece[e + 1] as usize]
    }

    /// Own entries with their array places along the tangential axes.
    pub fn own_entries(&self, layout: Layout) -> impl Iterator<Item = (usize, [usize; 2])> + use<> {
        let ([d1, d2], h) = (self.extents, layout.halo);
        (h..d2 - h).flat_map(move |m2| (h..d1 - h).map(move |m1| (m2 * d1 + m1, [m1, m2])))
    }

    /// Area (m²) of the face of the cell at tangential places m₁, m₂.
    pub fn area(&self, local: &Local, [m1, m2]: [usize; 2]) -> f64 {
        let [t1, t2] = self.tangents;
        local.axes[t1].width[m1] * local.axes[t2].width[m2]
    }

    /// Array place of the own cell next to the face at tangential places m₁, m₂.
    #[inline]
    pub fn inside(&self, layout: Layout, m1: usize, m2: usize) -> usize {
        let (s, n) = (layout.strides(), layout.cells[self.face.axis]);
        let normal = layout.halo + if self.face.side == Side::High { n - 1 } else { 0 };
        normal * s[self.face.axis] + m1 * s[self.tangents[0]] + m2 * s[self.tangents[1]]
    }

    /// Array place of the boundary value of the normal component for a place given by [`BoundaryData::inside`].
    #[inline]
    pub fn boundary(&self, layout: Layout, inside: usize) -> usize {
        if self.face.side == Side::High { inside } else { inside - layout.strides()[self.face.axis] }
    }
}

impl BoundaryData {
    /// Places in the arrays of the own boundary faces whose normal velocity is free.
    pub fn own_outlets(&self, layout: Layout) -> impl Iterator<Item = usize> {
        let [n1, n2] = self.extents;
        let own = (layout.halo..n2 - layout.halo)
            .flat_map(move |m2| (layout.halo..n1 - layout.halo).map(move |m1| [m1, m2]));
        let is_free = move |&[m1, m2]: &[usize; 2]| self.kinds[self.face.axis][m2 * n1 + m1] == Kind::Free;
        own.filter(is_free).map(move |[m1, m2]| self.boundary(layout, self.inside(layout, m1, m2)))
    }

    /// Places in the arrays of all boundary faces, halo included, whose normal velocity is imposed.
    pub fn for_imposed(&self, layout: Layout, mut job: impl FnMut(usize)) {
        for (entry, [m1, m2]) in self.entries() {
            if self.kinds[self.face.axis][entry] == Kind::Fixed {
                job(self.boundary(layout, self.inside(layout, m1, m2)));
            }
        }
    }

    /// Largest Σ |u|/Δx (1/s) of the imposed velocities in the own cells behind the face; infinite if one is no number.
    pub fn largest_rate(&self, local: &Local) -> f64 {
        let (axis, h) = (self.face.axis, local.layout.halo);
        let [t1, t2] = self.tangents;
        let last = if self.face.side == Side::High { local.layout.cells[axis] - 1 } else { 0 };
        let mut largest = 0.0_f64;
        for m2 in h..self.extents[1] - h {
            for m1 in h..self.extents[0] - h {
                let e = m2 * self.extents[0] + m1;
                let rate: f64 = [(axis, local.entry(last)), (t1, m1), (t2, m2)]
                    .into_iter()
                    .filter(|(a, _)| local.active[*a])
                    .map(|(a, entry)| self.values[a][e].abs() * local.axes[a].inverse_width[entry])
                    .sum();
                largest = if rate.is_nan() { f64::INFINITY } else { largest.max(rate) };
            }
        }
        largest
    }

    /// Imposed normal velocities (m/s, positive into the box) with the areas of their faces (m²).
    pub fn for_normal_values(&self, local: &Local, mut job: impl FnMut(usize, f64, f64)) {
        let axis = self.face.axis;
        for (e, [m1, m2]) in self.own_entries(local.layout) {
            if self.kinds[axis][e] != Kind::Free {
                let face = self.boundary(local.layout, self.inside(local.layout, m1, m2));
                job(face, -self.face.outward() * self.values[axis][e], self.area(local, [m1, m2]));
            }
        }
    }
}
