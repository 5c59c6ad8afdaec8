//! Rates of strain where stresses act, and the velocity gradient at centres.

use crate::Layout;
use crate::metrics::Local;
use std::ops::Range;

/// Squares of the rates of strain (1/s²).
#[derive(Clone, Debug)]
pub(super) struct Rates {
    /// 2 Σ (∂u_a/∂x_a)² at the centres.
    normal: Vec<f64>,
    /// (∂u_a/∂x_b + ∂u_b/∂x_a)² on the edges along each axis: of a cell, that of its upper faces.
    shear: [Vec<f64>; 3],
}

/// Rows of the own cells and of so many layers of the halo below and above, along the axes of the flow.
pub(super) fn rows(local: &Local, layers: [usize; 2]) -> impl Iterator<Item = ([usize; 3], usize)> + '_ {
    let range = |a: usize| -> Range<usize> {
        let (n, h) = (local.layout.cells[a], local.layout.halo);
        if local.active[a] { h - layers[0]..h + n + layers[1] } else { h..h + n }
    };
    let [x, y, z] = [0, 1, 2].map(range);
    let strides = local.layout.strides();
    z.flat_map(move |k| {
        let x = x.clone();
        y.clone().map(move |j| ([x.start, j, k], x.start + j * strides[1] + k * strides[2]))
    })
}

/// Cells of such a row.
pub(super) fn row_length(local: &Local, layers: [usize; 2]) -> usize {
    let n = local.layout.cells[0];
    if local.active[0] { n + layers[0] + layers[1] } else { n }
}

/// The two axes other than one.
pub(super) fn others(axis: usize) -> [usize; 2] {
    [(axis + 1) % 3, (axis + 2) % 3]
}

impl Rates {
    pub fn new(layout: Layout) -> Self {
        let zeros = || vec![0.0; layout.len()];
        Self { normal: zeros(), shear: std::array::from_fn(|_| zeros()) }
    }

    /// Rates of a velocity whose halo is filled two layers deep, in the own cells and one layer more.
    pub fn measure(&mut self, local: &Local, velocity: [&[f64]; 3]) {
        let (strides, n) = (local.layout.strides(), row_length(local, [1, 1]));
        for (place, start) in rows(local, [1, 1]) {
            let normal = &mut self.normal[start..start + n];
            normal.fill(0.0);
            for a in (0..3).filter(|&a| local.active[a]) {
                let u = velocity[a];
                let (high, low) = (&u[start..][..n], &u[start - strides[a]..][..n]);
                let inverse = Along::new(&local.axes[a].inverse_width, a, place);
                for (i, square) in normal.iter_mut().enumerate() {
                    let rate = (high[i] - low[i]) * inverse.at(i);
                    *square += 2.0 * rate * rate;
                }
            }
            for axis in 0..3 {
                let [a, b] = others(axis);
                if !(local.active[a] && local.active[b]) {
                    continue;
                }
                let (u, v) = (velocity[a], velocity[b]);
                let (here, across) = (&u[start..][..n], &u[start + strides[b]..][..n]);
                let (there, along) = (&v[start..][..n], &v[start + strides[a]..][..n]);
                let inverse_a = Along::new(&local.axes[a].inverse_distance, a, place);
                let inverse_b = Along::new(&local.axes[b].inverse_distance, b, place);
                for (i, square) in self.shear[axis][start..start + n].iter_mut().enumerate() {
                    let rate =
                        (across[i] - here[i]) * inverse_b.at(i) + (along[i] - there[i]) * inverse_a.at(i);
                    *square = rate * rate;
                }
            }
        }
    }

    /// γ̇² (1/s²) at the centres of a row.
    pub fn at_centres(&self, local: &Local, start: usize, out: &mut [f64]) {
        let (strides, n) = (local.layout.strides(), out.len());
        out.copy_from_slice(&self.normal[start..start + n]);
        for axis in 0..3 {
            let [a, b] = others(axis);
            if local.active[a] && local.active[b] {
                let [a, b] = [strides[a], strides[b]];
                let shear = &self.shear[axis];
                add_mean(shear, [start, start - a, start - b, start - a - b], out);
            }
        }
    }

    /// γ̇² (1/s²) on the edges along an axis of a row.
    pub fn on_edges(&self, local: &Local, axis: usize, start: usize, out: &mut [f64]) {
        let (strides, n) = (local.layout.strides(), out.len());
        out.copy_from_slice(&self.shear[axis][start..start + n]);
        let [a, b] = others(axis);
        let [sa, sb, sc] = [strides[a], strides[b], strides[axis]];
        add_mean(&self.normal, [start, start + sa, start + sb, start + sa + sb], out);
        if local.active[axis] {
            // Edges along a lie before and after the edge, beside both its cells along a; those along b likewise.
            add_mean(&self.shear[a], [start, start + sa, start - sc, start + sa - sc], out);
            add_mean(&self.shear[b], [start, start + sb, start - sc, start + sb - sc], out);
        }
    }
}

/// Adds the mean of four rows.
fn add_mean(values: &[f64], starts: [usize; 4], out: &mut [f64]) {
    let n = out.len();
    let [a, b, c, d] = starts.map(|start| &values[start..start + n]);
    for (i, sum) in out.iter_mut().enumerate() {
        *sum += 0.25 * ((a[i] + b[i]) + (c[i] + d[i]));
    }
}

/// Metrics along a row of cells: one number, or one for each.
#[derive(Clone, Copy)]
struct Along<'a> {
    values: &'a [f64],
    step: usize,
}

impl<'a> Along<'a> {
    fn new(values: &'a [f64], axis: usize, place: [usize; 3]) -> Self {
        Self { values: &values[place[axis]..], step: usize::from(axis == 0) }
    }

    #[inline(always)]
    fn at(&self, i: usize) -> f64 {
        self.values[i * self.step]
    }
}

/// ∂u_a/∂x_b (1/s) at the centre of the cell at a place of the arrays: across a component the mean of the four edges about it.
pub(super) fn gradient(local: &Local, velocity: [&[f64]; 3], place: [usize; 3], p: usize) -> [[f64; 3]; 3] {
    let strides = local.layout.strides();
    let mut gradient = [[0.0; 3]; 3];
    for (a, row) in gradient.iter_mut().enumerate().filter(|(a, _)| local.active[*a]) {
        let (u, below) = (velocity[a], p - strides[a]);
        for (b, value) in row.iter_mut().enumerate().filter(|(b, _)| local.active[*b]) {
            *value = if a == b {
                (u[p] - u[below]) * local.axes[a].inverse_width[place[a]]
            } else {
                let s = strides[b];
                let inverse = &local.axes[b].inverse_distance;
                let upper = (u[p + s] - u[p]) + (u[below + s] - u[below]);
                let lower = (u[p] - u[p - s]) + (u[below] - u[below - s]);
                0.25 * (upper * inverse[place[b]] + lower * inverse[place[b] - 1])
            };
        }
    }
    gradient
}
