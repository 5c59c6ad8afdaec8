//! The conditions of one face, spelt out for every boundary cell of a subdomain.

use super::{Boundaries, BoxFace, Condition, Profile, Side, image_from};
use crate::metrics::Local;
use crate::{Grid, Layout};

/// How a velocity component behaves on a boundary cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Imposed.
    Fixed,
    /// No gradient; a normal component is zero.
    Slip,
    /// Outlet.
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
    /// Per velocity component.
    pub kinds: [Vec<Kind>; 3],
    /// Imposed velocities (m/s).
    pub values: [Vec<f64>; 3],
    /// Their change over the last step (m/s).
    pub increments: [Vec<f64>; 3],
    /// Ghost of a tangential velocity: weights of the imposed value, the first and the second cell.
    pub wall: [f64; 3],
    /// Pressure of outlet cells (Pa).
    pub pressure: Vec<f64>,
    /// Whether imposed velocities may change in time.
    pub is_unsteady: bool,
    /// Whether some cell is an outlet.
    pub has_outlet: bool,
}

impl BoundaryData {
    /// Tables of the faces the subdomain touches, at a time (s).
    pub fn all(grid: &Grid, local: &Local, boundaries: &Boundaries, time: f64) -> Vec<BoundaryData> {
        // Across an axis of one cell nothing is read.
        let touched = |face: &BoxFace| {
            local.active[face.axis] && local.ends[face.axis][usize::from(face.side == Side::High)]
        };
        BoxFace::all()
            .filter(touched)
            .map(|face| {
                let mut face_data = BoundaryData::new(face, local);
                face_data.classify(grid, local, boundaries);
                face_data.evaluate(grid, local, boundaries, time);
                face_data
            })
            .collect()
    }

    fn new(face: BoxFace, local: &Local) -> Self {
        let layout = local.layout;
        let tangents = match face.axis {
            0 => [1, 2],
            1 => [0, 2],
            _ => [0, 1],
        };
        let extents = tangents.map(|t| layout.dims()[t]);
        let size = extents[0] * extents[1];
        let zeros = || std::array::from_fn(|_| vec![0.0; size]);
        Self {
            face,
            tangents,
            extents,
            kinds: std::array::from_fn(|_| vec![Kind::Fixed; size]),
            values: zeros(),
            increments: zeros(),
            wall: local.walls[face.axis][usize::from(face.side == Side::High)],
            pressure: vec![0.0; size],
            is_unsteady: false,
            has_outlet: false,
        }
    }

    /// Global cell and position (m) of a component at an entry, within the period of periodic axes.
    fn place(
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

    fn entries(&self) -> impl Iterator<Item = (usize, [usize; 2])> + use<> {
        let [d1, d2] = self.extents;
        (0..d2).flat_map(move |m2| (0..d1).map(move |m1| (m2 * d1 + m1, [m1, m2])))
    }

    fn classify(&mut self, grid: &Grid, local: &Local, boundaries: &Boundaries) {
        for component in 0..3 {
            for (e, entry) in self.entries() {
                let (cell, at) = self.place(grid, local, component, entry);
                let (condition, _) = condition_at(grid, boundaries, self.face, at);
                // What comes in through a part of the cell's face counts, whatever lies at its middle.
                let (mut is_inlet, mut is_unsteady) = (false, condition.is_unsteady());
                if component == self.face.axis {
                    self.for_pieces(grid, boundaries, (cell, at), |piece| {
                        is_inlet |= matches!(piece.condition, Condition::Inlet { .. });
                        is_unsteady |= piece.condition.is_unsteady();
                    });
                }
                self.kinds[component][e] = match condition {
                    _ if is_inlet => Kind::Fixed,
                    Condition::Wall { .. } | Condition::Inlet { .. } => Kind::Fixed,
                    Condition::Symmetry => Kind::Slip,
                    Condition::Outlet { pressure } => {
                        if component == self.face.axis {
                            self.pressure[e] = *pressure;
                            self.has_outlet = true;
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
                let (cell, at) = self.place(grid, local, component, entry);
                let mut value = 0.0;
                if component == self.face.axis {
                    self.for_pieces(grid, boundaries, (cell, at), |piece| {
                        value += piece.share * self.imposed(grid, component, &piece, time);
                    });
                } else {
                    let (condition, extent) = condition_at(grid, boundaries, self.face, at);
                    let piece = Piece { condition, extent, at, bounds: [[0.0; 2]; 3], share: 1.0 };
                    value = self.imposed(grid, component, &piece, time);
                }
                self.increments[component][e] = value - self.values[component][e];
                self.values[component][e] = value;
            }
        }
    }

    /// A component of the velocity (m/s) that is imposed on a piece, its mean over it for a parabola.
    fn imposed(&self, grid: &Grid, component: usize, piece: &Piece<'_>, time: f64) -> f64 {
        match piece.condition {
            Condition::Wall { velocity } => velocity[component],
            Condition::Inlet { profile: Profile::Uniform(velocity) } => velocity[component],
            Condition::Inlet { profile: Profile::Function(f) } => f(piece.at, time)[component],
            Condition::Inlet { profile: Profile::Parabolic { mean } } => {
                let is_normal = component == self.face.axis;
                if is_normal { -self.face.outward() * mean * self.parabola(grid, piece) } else { 0.0 }
            }
            Condition::Symmetry | Condition::Outlet { .. } => 0.0,
        }
    }

    /// Mean over a piece of Π 6 s (1 − s) across the inlet, along the axes that are not periodic.
    fn parabola(&self, grid: &Grid, piece: &Piece<'_>) -> f64 {
        let across =
            |&t: &usize| grid.is_active(t) && (piece.extent.is_some() || !grid.axis(t).is_periodic());
        let factors = self.tangents.iter().filter(|t| across(t)).map(|&t| {
            let axis = grid.axis(t);
            let (lower, upper) = match piece.extent {
                Some((lower, upper)) if axis.is_periodic() => (lower[t], upper[t]),
                Some((lower, upper)) => {
                    (lower[t].max(axis.nodes()[0]), upper[t].min(axis.nodes()[axis.cells()]))
                }
                None => (axis.nodes()[0], axis.nodes()[axis.cells()]),
            };
            let [begin, end] = piece.bounds[t];
            let middle = 0.5 * (begin + end);
            let shift = image_from(axis, lower, middle) - middle;
            let scaled = |x: f64| ((x + shift - lower) / (upper - lower)).clamp(0.0, 1.0);
            let integral = |s: f64| s * s * (3.0 - 2.0 * s);
            (integral(scaled(end)) - integral(scaled(begin))) * (upper - lower) / (end - begin)
        });
        factors.product()
    }

    /// Visits the rectangles into which the edges of patches cut the boundary face of a cell, given with its middle (m): what
    /// flows through a patch is then its velocity times its area, wherever its edges lie.
    fn for_pieces<'a>(
        &self,
        grid: &Grid,
        boundaries: &'a Boundaries,
        (cell, at): ([isize; 3], [f64; 3]),
        mut visit: impl FnMut(Piece<'a>),
    ) {
        let [t1, t2] = self.tangents;
        let whole = self.tangents.map(|t| [grid.axis(t).node(cell[t]), grid.axis(t).node(cell[t] + 1)]);
        let mut bounds = [[0.0; 2]; 3];
        let mut low1 = whole[0][0];
        while low1 < whole[0][1] {
            bounds[t1] = [low1, self.next_edge(grid, boundaries, t1, low1, whole[0])];
            let mut low2 = whole[1][0];
            while low2 < whole[1][1] {
                bounds[t2] = [low2, self.next_edge(grid, boundaries, t2, low2, whole[1])];
                let (mut middle, mut share) = (at, 1.0);
                for (t, whole) in self.tangents.into_iter().zip(whole) {
                    if bounds[t] != whole {
                        let [begin, end] = bounds[t];
                        middle[t] = 0.5 * (begin + end);
                        share *= (end - begin) / (whole[1] - whole[0]);
                    }
                }
                let (condition, extent) = condition_at(grid, boundaries, self.face, middle);
                visit(Piece { condition, extent, at: middle, bounds, share });
                low2 = bounds[t2][1];
            }
            low1 = bounds[t1][1];
        }
    }

    /// The first edge of a patch (m) beyond a place along a tangential axis, within the face of a cell; else the end of that.
    fn next_edge(
        &self,
        grid: &Grid,
        boundaries: &Boundaries,
        axis: usize,
        place: f64,
        [begin, end]: [f64; 2],
    ) -> f64 {
        /// What is left of a cell beside an edge and counts as nothing (-).
        const SLIVER: f64 = 1e-9;
        let room = SLIVER * (end - begin);
        let patches = boundaries.patches.iter().filter(|patch| patch.face == self.face);
        let edges = patches.flat_map(|patch| [patch.lower[axis], patch.upper[axis]]);
        let images = edges.map(|edge| image_from(grid.axis(axis), begin, edge));
        images.filter(|&edge| place + room < edge && edge < end - room).fold(end, f64::min)
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

/// A rectangle of the boundary face of a cell under one condition.
struct Piece<'a> {
    condition: &'a Condition,
    /// Extent of its patch.
    extent: Option<Extent>,
    /// Middle (m).
    at: [f64; 3],
    /// Begin and end along the tangential axes (m).
    bounds: [[f64; 2]; 3],
    /// Part of the area of the cell's face (-).
    share: f64,
}

/// Lower and upper corner of a patch (m).
type Extent = ([f64; 3], [f64; 3]);

/// The condition at a point of a face, and the extent of its patch.
fn condition_at<'a>(
    grid: &Grid,
    boundaries: &'a Boundaries,
    face: BoxFace,
    at: [f64; 3],
) -> (&'a Condition, Option<Extent>) {
    match boundaries.patches.iter().rev().find(|p| p.face == face && p.contains(grid, at)) {
        Some(patch) => (&patch.condition, Some((patch.lower, patch.upper))),
        None => (&boundaries.faces[face.index()], None),
    }
}

impl BoundaryData {
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
        let (axis, h) = (self.face.axis, local.layout.halo);
        let [t1, t2] = self.tangents;
        for m2 in h..self.extents[1] - h {
            for m1 in h..self.extents[0] - h {
                let e = m2 * self.extents[0] + m1;
                if self.kinds[axis][e] != Kind::Free {
                    let area = local.axes[t1].width[m1] * local.axes[t2].width[m2];
                    let face = self.boundary(local.layout, self.inside(local.layout, m1, m2));
                    job(face, -self.face.outward() * self.values[axis][e], area);
                }
            }
        }
    }
}
