//! How the surfaces of solids cut cells and the ways between their middles, from the depths of these.

use super::super::advance::for_faces;
use super::cells::{BEYOND, CutFace, NearCell, NearFace, SolidCells, share_in_front};
use crate::metrics::Local;
use std::collections::HashMap;

/// Smallest share of a way between two middles that is left on either side of a surface (-).
const MIN_SHARE: f64 = 1e-3;

/// A cell's middle and the surface of a solid near it.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Place of the cell in the arrays.
    pub place: usize,
    /// Number of the solid.
    pub solid: u32,
    /// Distance (m) from the surface, negative in the solid.
    pub distance: f64,
    /// Unit normal of the surface, out of the solid.
    pub normal: [f64; 3],
}

/// The solids of a rank, as they are found.
pub struct SolidCellsBuilder {
    cells: SolidCells,
    points: Vec<SurfacePoint>,
    has_shares: bool,
}

impl SolidCellsBuilder {
    /// None yet of so many bodies and solids in all; with the shares of cells and faces if these are asked for.
    pub fn new(len: usize, [bodies, count]: [usize; 2], has_shares: bool) -> Self {
        let cells = SolidCells {
            holder: vec![0; len],
            cut: Default::default(),
            near_cells: Vec::new(),
            near_faces: Default::default(),
            is_averaged: false,
            bodies,
            count,
        };
        Self { cells, points: Vec::new(), has_shares }
    }

    /// The walls of a flow averaged over particles, which has their shares already.
    pub(crate) fn averaged(mut self) -> Self {
        self.cells.is_averaged = true;
        self
    }

    /// The solid that holds a cell's middle so far.
    pub fn holder(&self, place: usize) -> Option<u32> {
        self.cells.holder[place].checked_sub(1)
    }

    /// Gives a cell's middle to a solid.
    pub fn hold(&mut self, place: usize, solid: u32) {
        self.cells.holder[place] = solid + 1;
    }

    /// Notes where the surface of a solid is from a cell's middle; those farther than two widths away say nothing.
    pub fn note(&mut self, point: SurfacePoint) {
        self.points.push(point);
    }

    /// What the surfaces cut.
    pub(crate) fn finish(mut self, local: &Local) -> SolidCells {
        self.mark_beyond(local);
        self.points.sort_unstable_by_key(|point| (point.place, point.solid));
        self.points.dedup_by_key(|point| (point.place, point.solid));
        self.continue_outwards(local);
        for axis in (0..3).filter(|&a| local.active[a]) {
            self.cells.cut[axis] = self.cut_faces(local, axis);
        }
        if self.has_shares {
            self.cells.near_cells = self.near_cells(local);
            for axis in (0..3).filter(|&a| local.active[a]) {
                self.cells.near_faces[axis] = self.near_faces(local, axis);
            }
        }
        self.cells
    }

    /// The surface of a solid near a cell.
    fn at(&self, place: usize, solid: u32) -> Option<&SurfacePoint> {
        let found = self.points.binary_search_by_key(&(place, solid), |point| (point.place, point.solid));
        found.ok().map(|number| &self.points[number])
    }

    fn mark_beyond(&mut self, local: &Local) {
        let (layout, dims) = (local.layout, local.layout.dims());
        let strides = layout.strides();
        for a in (0..3).filter(|&a| local.active[a] && local.ends[a] != [false; 2]) {
            for (place, holder) in self.cells.holder.iter_mut().enumerate() {
                let i = place / strides[a] % dims[a];
                let is_beyond = (local.ends[a][0] && i < layout.halo)
                    || (local.ends[a][1] && i >= layout.halo + layout.cells[a]);
                if is_beyond {
                    *holder = BEYOND;
                }
            }
        }
    }

    /// Continues the surfaces to the neighbours of the middles in solids: the nearest tangent plane tells their distance.
    fn continue_outwards(&mut self, local: &Local) {
        let (dims, strides) = (local.layout.dims(), local.layout.strides());
        let steps = |a: usize| if local.active[a] { -1..=1 } else { 0..=0 };
        // By cell and solid: square of the way along the plane, and the point; of equal ways that of the lower place counts.
        let mut found: HashMap<(usize, u32), (f64, SurfacePoint)> = HashMap::new();
        for point in self.points.iter().filter(|point| point.distance <= 0.0) {
            let at = [0, 1, 2].map(|a| point.place / strides[a] % dims[a]);
            for dz in steps(2) {
                for dy in steps(1) {
                    for dx in steps(0) {
                        let step: [isize; 3] = [dx, dy, dz];
                        let to = [0, 1, 2].map(|a| at[a] as isize + step[a]);
                        if (0..3).any(|a| to[a] < 0 || to[a] >= dims[a] as isize) {
                            continue;
                        }
                        let place: usize = (0..3).map(|a| to[a] as usize * strides[a]).sum();
                        let is_inside = self.cells.holder[place] == point.solid + 1;
                        if is_inside || self.at(place, point.solid).is_some() {
                            continue;
                        }
                        let way: [f64; 3] =
                            [0, 1, 2].map(|a| step[a] as f64 / local.axes[a].inverse_distance[at[a]]);
                        let along: f64 = (0..3).map(|a| way[a] * point.normal[a]).sum();
                        let square: f64 = way.iter().map(|x| x * x).sum();
                        // Beyond an edge planes of its other side say that it is inside.
                        let distance = point.distance + along;
                        if distance <= 0.0 {
                            continue;
                        }
                        let new = (square - along * along, SurfacePoint { place, distance, ..*point });
                        let best = found.entry((place, point.solid)).or_insert(new);
                        if new.0 < best.0 {
                            *best = new;
                        }
                    }
                }
            }
        }
        self.points.extend(found.into_values().map(|(_, point)| point));
        self.points.sort_unstable_by_key(|point| (point.place, point.solid));
    }

    /// Ways between middles that lie in different solids, or in one and the fluid.
    fn cut_faces(&self, local: &Local, axis: usize) -> Vec<CutFace> {
        let (stride, holder) = (local.layout.strides()[axis], &self.cells.holder);
        let mut cut = Vec::new();
        for_faces(local, axis, |place, _, e| {
            let [below, above] = [place, place + stride].map(|p| holder[p]);
            if below == above || below == BEYOND || above == BEYOND {
                return;
            }
            let width = 1.0 / local.axes[axis].inverse_distance[e];
            let share = |holder: u32, here: usize, there: usize, sign: f64| {
                let Some(solid) = holder.checked_sub(1) else { return 0.0 };
                let Some(point) = self.at(here, solid) else { return 0.5 };
                let depth = -point.distance;
                let of_plane = depth / (sign * point.normal[axis] * width);
                let share = match self.at(there, solid) {
                    Some(other) if other.distance > 0.0 => depth / (depth + other.distance),
                    _ if of_plane > 0.0 && of_plane < 1.0 => of_plane,
                    _ => 0.5,
                };
                share.clamp(MIN_SHARE, 1.0 - MIN_SHARE)
            };
            let mut solid =
                [share(below, place, place + stride, 1.0), share(above, place + stride, place, -1.0)];
            let sum = solid[0] + solid[1];
            if sum > 1.0 {
                solid = solid.map(|share| share / sum);
            }
            cut.push(CutFace { place: place as u32, solid });
        });
        cut
    }

    fn near_cells(&self, local: &Local) -> Vec<NearCell> {
        let (dims, strides) = (local.layout.dims(), local.layout.strides());
        let cell = |point: &SurfacePoint| {
            let widths = [0, 1, 2].map(|a| match local.active[a] {
                true => local.axes[a].width[point.place / strides[a] % dims[a]],
                false => 0.0,
            });
            // The surface curves away from its tangent plane, by the mean of t²/2 over the cell times its curvatures.
            let width = widths.iter().copied().fold(0.0, f64::max);
            let limit = if width > 0.0 { 1.0 / width } else { 0.0 };
            let curved = self.curvature(point, local).clamp(-limit, limit) * width * width / 24.0;
            NearCell {
                place: point.place as u32,
                solid: point.solid,
                share: 1.0 - share_in_front(point.distance + curved, &point.normal, &widths),
                distance: point.distance,
                normal: point.normal,
            }
        };
        self.points.iter().map(cell).collect()
    }

    /// Sum of the principal curvatures (1/m), positive of a convex solid: ∇·n of the normals around.
    fn curvature(&self, point: &SurfacePoint, local: &Local) -> f64 {
        let (dims, strides) = (local.layout.dims(), local.layout.strides());
        let along = |a: usize| {
            let (stride, e) = (strides[a], point.place / strides[a] % dims[a]);
            let inverse = &local.axes[a].inverse_distance;
            let up = (e + 1 < dims[a]).then(|| self.at(point.place + stride, point.solid)).flatten();
            let down = (e > 0).then(|| self.at(point.place - stride, point.solid)).flatten();
            let up = up.map(|next| (next.normal[a] - point.normal[a]) * inverse[e]);
            let down = down.map(|next| (point.normal[a] - next.normal[a]) * inverse[e - 1]);
            match (up, down) {
                (Some(up), Some(down)) => 0.5 * (up + down),
                (Some(one), None) | (None, Some(one)) => one,
                (None, None) => 0.0,
            }
        };
        (0..3).filter(|&a| local.active[a]).map(along).sum()
    }

    fn near_faces(&self, local: &Local, axis: usize) -> Vec<NearFace> {
        let (stride, strides) = (local.layout.strides()[axis], local.layout.strides());
        let dims = local.layout.dims();
        let mut faces = Vec::new();
        for_faces(local, axis, |place, _, e| {
            let of = |p: usize| {
                let first = self.points.partition_point(|point| point.place < p);
                self.points[first..].iter().take_while(move |point| point.place == p)
            };
            let half = 0.5 / local.axes[axis].inverse_distance[e];
            let widths = [0, 1, 2].map(|a| match local.active[a] && a != axis {
                true => local.axes[a].width[place / strides[a] % dims[a]],
                false => 0.0,
            });
            let mut add = |solid: u32, distance: f64, normal: [f64; 3]| {
                let share = 1.0 - share_in_front(distance, &normal, &widths);
                if share > 0.0 {
                    faces.push(NearFace { place: place as u32, solid, share, normal });
                }
            };
            for point in of(place) {
                match self.at(place + stride, point.solid) {
                    Some(other) => {
                        let sum: [f64; 3] = [0, 1, 2].map(|a| point.normal[a] + other.normal[a]);
                        let size = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
                        let normal = if size > 0.5 { sum.map(|x| x / size) } else { point.normal };
                        add(point.solid, 0.5 * (point.distance + other.distance), normal);
                    }
                    None => add(point.solid, point.distance + half * point.normal[axis], point.normal),
                }
            }
            for point in of(place + stride).filter(|point| self.at(place, point.solid).is_none()) {
                add(point.solid, point.distance - half * point.normal[axis], point.normal);
            }
        });
        faces
    }
}
