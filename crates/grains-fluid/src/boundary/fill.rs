//! Ghost values beyond the faces of the box.

use super::table::{FaceTable, Kind};
use crate::{Centre, Faces, Field, Layout};

impl FaceTable {
    /// Offset in the array from the inside cell (layer 0) to the ghost of layer `m`, and to its mirror cell.
    fn layers(&self, layout: Layout, m: usize) -> (isize, isize) {
        let (n, stride) = (layout.cells[self.face.axis], layout.strides()[self.face.axis] as isize);
        let outward = self.face.outward() as isize;
        (outward * stride * (m as isize + 1), -outward * stride * m.min(n - 1) as isize)
    }

    /// Imposes the normal velocity on the face; behind it, it is mirrored about the imposed value, or continued.
    pub fn fill_normal(&self, velocity: &mut Faces) {
        let (layout, axis) = (velocity.layout(), self.face.axis);
        let field = velocity.component_mut(axis);
        let step = self.face.outward() as isize * layout.strides()[axis] as isize;
        for m2 in 0..self.extents[1] {
            for m1 in 0..self.extents[0] {
                let e = m2 * self.extents[0] + m1;
                let b = self.boundary(layout, self.inside(layout, m1, m2)) as isize;
                let is_free = self.kinds[axis][e] == Kind::Free;
                if !is_free {
                    field[b as usize] = self.values[axis][e];
                }
                let value = field[b as usize];
                // The low side has one ghost layer less: its first holds the boundary value.
                let ghosts = layout.halo as isize - isize::from(step < 0);
                for m in 1..=ghosts {
                    let mirror = field[(b - step * m) as usize];
                    field[(b + step * m) as usize] = if is_free { value } else { 2.0 * value - mirror };
                }
            }
        }
    }

    /// Ghosts of a tangential velocity: the first on the parabola through the imposed value and two cells, the others
    /// mirrored about it; even for slip and outlets; where fluid comes in through an outlet, mirrored about zero.
    pub fn fill_tangential(&self, velocity: &mut Faces, component: usize) {
        let layout = velocity.layout();
        let reach = layout.strides()[component];
        let inward = self.layers(layout, 1).1;
        for m in 0..layout.halo {
            let (ghost, mirror) = self.layers(layout, m);
            for m2 in 0..self.extents[1] {
                for m1 in 0..self.extents[0] {
                    let e = m2 * self.extents[0] + m1;
                    let p = self.inside(layout, m1, m2);
                    let inner = velocity.component(component)[(p as isize + mirror) as usize];
                    let value = match self.kinds[component][e] {
                        Kind::Fixed if m == 0 => {
                            let [imposed, first, second] = self.wall;
                            let next = velocity.component(component)[(p as isize + inward) as usize];
                            imposed * self.values[component][e] + first * inner + second * next
                        }
                        Kind::Fixed => 2.0 * self.values[component][e] - inner,
                        Kind::Slip => inner,
                        Kind::Free => {
                            let normal = velocity.component(self.face.axis);
                            let b = self.boundary(layout, p);
                            let next = if b + reach < normal.len() { b + reach } else { b };
                            let leaving = self.face.outward() * (normal[b] + normal[next]) >= 0.0;
                            if leaving { inner } else { -inner }
                        }
                    };
                    velocity.component_mut(component)[(p as isize + ghost) as usize] = value;
                }
            }
        }
    }

    /// Ghosts of a quantity at the centres: its mirror image, on outlets about `scale` times the outlet pressure.
    pub fn fill_centre(&self, field: &mut Field<Centre>, scale: f64) {
        let (layout, axis) = (field.layout(), self.face.axis);
        let data = field.data_mut();
        for m in 0..layout.halo {
            let (ghost, mirror) = self.layers(layout, m);
            for m2 in 0..self.extents[1] {
                for m1 in 0..self.extents[0] {
                    let e = m2 * self.extents[0] + m1;
                    let p = self.inside(layout, m1, m2) as isize;
                    let inner = data[(p + mirror) as usize];
                    data[(p + ghost) as usize] = match self.kinds[axis][e] {
                        Kind::Free => 2.0 * scale * self.pressure[e] - inner,
                        _ => inner,
                    };
                }
            }
        }
    }

    /// Ghosts of a quantity without gradient at the face.
    pub fn fill_even(&self, field: &mut Field<Centre>) {
        let layout = field.layout();
        let data = field.data_mut();
        for m in 0..layout.halo {
            let (ghost, mirror) = self.layers(layout, m);
            for m2 in 0..self.extents[1] {
                for m1 in 0..self.extents[0] {
                    let p = self.inside(layout, m1, m2) as isize;
                    data[(p + ghost) as usize] = data[(p + mirror) as usize];
                }
            }
        }
    }
}

/// Ghosts of the velocity beyond all faces the subdomain touches; halos towards other ranks must be filled.
pub(crate) fn fill_velocity(tables: &[FaceTable], velocity: &mut Faces) {
    tables.iter().for_each(|table| table.fill_normal(velocity));
    for table in tables {
        for component in (0..3).filter(|&c| c != table.face.axis) {
            table.fill_tangential(velocity, component);
        }
    }
}

impl FaceTable {
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
