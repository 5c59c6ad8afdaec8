//! Ghost values beyond the faces of the box.

use super::data::{BoundaryData, Kind};
use crate::{Centre, Faces, Field, Layout};

impl BoundaryData {
    /// Offset in the array from the inside cell (layer 0) to the ghost of layer `m`, and to its mirror cell.
    fn layers(&self, layout: Layout, m: usize) -> (isize, isize) {
        let (n, stride) = (layout.cells[self.face.axis], layout.strides()[self.face.axis] as isize);
        let outward = self.face.outward() as isize;
        (outward * stride * (m as isize + 1), -outward * stride * m.min(n - 1) as isize)
    }

    /// Entries side by side along the first tangential axis at which a component is of one kind, with the array places of the cells inside.
    fn runs(
        &self,
        layout: Layout,
        component: usize,
    ) -> impl Iterator<Item = (Kind, impl Iterator<Item = (usize, usize)> + Clone)> {
        let (length, stride) = (self.extents[0], layout.strides()[self.tangents[0]]);
        let [along, rows] = self.read.clone();
        rows.flat_map(move |m2| {
            let row = m2 * length;
            let (mut m1, first) = (along.start, self.inside(layout, 0, m2));
            self.kinds[component][row..][along.clone()].chunk_by(PartialEq::eq).map(move |run| {
                let entries = m1..m1 + run.len();
                m1 = entries.end;
                (run[0], entries.map(move |m1| (row + m1, first + m1 * stride)))
            })
        })
    }

    /// Imposes the normal velocity on the face; behind it, it is mirrored about the imposed value, or continued.
    pub fn fill_normal(&self, velocity: &mut Faces, ghosts: usize) {
        let (layout, axis) = (velocity.layout(), self.face.axis);
        let field = velocity.component_mut(axis);
        let step = self.face.outward() as isize * layout.strides()[axis] as isize;
        // The low side has one ghost layer less: its first holds the boundary value.
        let ghosts = ghosts as isize - isize::from(step < 0);
        for (kind, run) in self.runs(layout, axis) {
            let is_free = kind == Kind::Free;
            for (e, p) in run {
                let b = self.boundary(layout, p) as isize;
                if !is_free {
                    field[b as usize] = self.values[axis][e];
                }
                let value = field[b as usize];
                for m in 1..=ghosts {
                    let mirror = field[(b - step * m) as usize];
                    field[(b + step * m) as usize] = if is_free { value } else { 2.0 * value - mirror };
                }
            }
        }
    }

    /// Ghosts of a tangential velocity: the first on the parabola through the imposed value and two cells, the others
    /// mirrored about it; even for slip and outlets; where fluid comes in through an outlet, mirrored about zero.
    pub fn fill_tangential(&self, velocity: &mut Faces, component: usize, ghosts: usize) {
        let layout = velocity.layout();
        let reach = layout.strides()[component];
        let inward = self.layers(layout, 1).1;
        let [imposed, first, second] = self.wall;
        let values = &self.values[component];
        let (field, normal) = velocity.two_components(component, self.face.axis);
        let at = |p: usize, offset: isize| (p as isize + offset) as usize;
        for (kind, run) in self.runs(layout, component) {
            for m in 0..ghosts {
                let (ghost, mirror) = self.layers(layout, m);
                match kind {
                    Kind::Fixed if m == 0 => run.clone().for_each(|(e, p)| {
                        let [nearest, next] = [mirror, inward].map(|offset| field[at(p, offset)]);
                        field[at(p, ghost)] = imposed * values[e] + first * nearest + second * next;
                    }),
                    Kind::Fixed => run.clone().for_each(|(e, p)| {
                        field[at(p, ghost)] = 2.0 * values[e] - field[at(p, mirror)];
                    }),
                    Kind::Slip => run.clone().for_each(|(_, p)| field[at(p, ghost)] = field[at(p, mirror)]),
                    Kind::Free => run.clone().for_each(|(_, p)| {
                        let b = self.boundary(layout, p);
                        let next = if b + reach < normal.len() { b + reach } else { b };
                        let leaving = self.face.outward() * (normal[b] + normal[next]) >= 0.0;
                        let inner = field[at(p, mirror)];
                        field[at(p, ghost)] = if leaving { inner } else { -inner };
                    }),
                }
            }
        }
    }

    /// First ghost of a pressure: its mirror image, on outlets about `scale` times the outlet pressure.
    pub fn fill_pressure(&self, field: &mut Field<Centre>, scale: f64) {
        let layout = field.layout();
        let data = field.data_mut();
        let (ghost, _) = self.layers(layout, 0);
        for (kind, run) in self.runs(layout, self.face.axis) {
            let ghosts = run.map(|(e, p)| (e, p, (p as isize + ghost) as usize));
            match kind {
                Kind::Free => ghosts.for_each(|(e, p, g)| data[g] = 2.0 * scale * self.pressure[e] - data[p]),
                Kind::Fixed | Kind::Slip => ghosts.for_each(|(_, p, g)| data[g] = data[p]),
            }
        }
    }

    /// Ghosts of a quantity without gradient at the face.
    pub fn fill_even(&self, field: &mut Field<Centre>) {
        let layout = field.layout();
        let data = field.data_mut();
        for m2 in 0..self.extents[1] {
            for m1 in 0..self.extents[0] {
                let p = self.inside(layout, m1, m2) as isize;
                for m in 0..layout.halo {
                    let (ghost, mirror) = self.layers(layout, m);
                    data[(p + ghost) as usize] = data[(p + mirror) as usize];
                }
            }
        }
    }
}

/// Ghosts of the velocity, so many layers, beyond all faces the subdomain touches; halos towards other ranks must be
/// filled.
pub(crate) fn fill_velocity(boundary_data: &[BoundaryData], velocity: &mut Faces, ghosts: usize) {
    boundary_data.iter().for_each(|face_data| face_data.fill_normal(velocity, ghosts));
    for face_data in boundary_data {
        for component in (0..3).filter(|&c| c != face_data.face.axis) {
            face_data.fill_tangential(velocity, component, ghosts);
        }
    }
}

impl BoundaryData {
    /// Adds the increments of the normal velocity on the face.
    pub fn add_boundary(&self, increments: &[f64], velocity: &mut Faces) {
        let layout = velocity.layout();
        let field = velocity.component_mut(self.face.axis);
        for m2 in layout.halo..self.extents[1] - layout.halo {
            for m1 in layout.halo..self.extents[0] - layout.halo {
                let b = self.boundary(layout, self.inside(layout, m1, m2));
                field[b] += increments[b];
            }
        }
    }
}
