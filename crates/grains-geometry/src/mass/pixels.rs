//! Mass properties by counting the cells of a grid whose centres lie in the body
//! (Rakotonirina 2016, ch. 3, section 2.3).

use super::MassProperties;
use super::chord::Solid;
use crate::{Mat3, Part, Vec3};
use std::thread;

/// Cells per direction, more than the 500 of the thesis: the volume of a ball is then within 1e-4.
///
/// A number with many divisors, so that bodies of simple proportions have few cell centres on their faces.
pub const PIXELS: u32 = 600;

/// Numbers of cells and of cell indices, and their products, summed over the cells inside.
///
/// They are whole numbers, so that their sums do not depend on the order.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// Cells.
    count: u128,
    /// Σ i, Σ j, Σ k.
    first: [u128; 3],
    /// Σ ii, Σ jj, Σ kk, Σ ij, Σ ik, Σ jk.
    second: [u128; 6],
}

impl Sums {
    /// Adds the cells `start..=end` of the row (j, k).
    fn add_cells(&mut self, start: u64, end: u64, j: u128, k: u128) {
        let below = |n: u64| u128::from(n);
        // Σ i and Σ i² of i < n.
        let sum = |n: u128| if n == 0 { 0 } else { n * (n - 1) / 2 };
        let squares = |n: u128| if n == 0 { 0 } else { (n - 1) * n * (2 * n - 1) / 6 };
        let (start, end) = (below(start), below(end) + 1);
        let count = end - start;
        let i = sum(end) - sum(start);
        let ii = squares(end) - squares(start);
        self.count += count;
        for (total, value) in self.first.iter_mut().zip([i, count * j, count * k]) {
            *total += value;
        }
        let products = [ii, count * j * j, count * k * k, i * j, i * k, count * j * k];
        for (total, value) in self.second.iter_mut().zip(products) {
            *total += value;
        }
    }

    fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.first.iter_mut().zip(other.first).for_each(|(a, b)| *a += b);
        self.second.iter_mut().zip(other.second).for_each(|(a, b)| *a += b);
    }
}

/// Grid of N³ cells over the box around the body.
struct Grid {
    /// Centre of the first cell (m).
    first: Vec3,
    /// Edges of a cell (m).
    cell: Vec3,
    cells: u32,
}

impl Grid {
    fn centre(&self, i: i64, j: u32, k: u32) -> Vec3 {
        self.first + self.cell.component_mul(&Vec3::new(i as f64, f64::from(j), f64::from(k)))
    }
}

impl MassProperties {
    /// Of the union of convex parts by the pixel rule: V = Σ v, X_g = Σ X_i v/V and
    /// J = Σ (|r_i|² 1 − r_i r_iᵀ) v with r_i = X_i − X_g, over the cells of volume v whose centre X_i
    /// lies in a part with sharp edges; the box around the union has `cells` cells per direction
    /// (thesis eqs 3.11-3.12, for unit density and about the centre of mass).
    ///
    /// A row of cells crosses a convex part in one interval, so that a row costs as much as the parts
    /// it meets; the result is that of testing every cell, whatever the number of threads. Without
    /// parts or cells all is NaN.
    pub fn of_pixels(parts: &[Part], cells: u32) -> Self {
        let solids: Vec<Solid> = parts.iter().map(Solid::new).collect();
        let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        let (lower, upper) = solids.iter().fold(start, |(l, u), s| (l.inf(&s.lower), u.sup(&s.upper)));
        let cell = (upper - lower) / f64::from(cells);
        let grid = Grid { first: lower + cell / 2.0, cell, cells };
        grid.mass(&count(&solids, &grid))
    }
}

/// Counts all rows, slabs of them on each core.
fn count(solids: &[Solid], grid: &Grid) -> Sums {
    let threads = thread::available_parallelism().map_or(1, |n| n.get() as u32).clamp(1, grid.cells.max(1));
    let slab = |t: u32| {
        let mut sums = Sums::default();
        let mut intervals = Vec::with_capacity(solids.len());
        // Every n-th layer, for the middle ones cost more than the outer.
        for k in (t..grid.cells).step_by(threads as usize) {
            for j in 0..grid.cells {
                add_row(solids, grid, [j, k], &mut intervals, &mut sums);
            }
        }
        sums
    };
    let mut total = Sums::default();
    thread::scope(|scope| {
        let slab = &slab;
        let workers: Vec<_> = (1..threads).map(|t| scope.spawn(move || slab(t))).collect();
        total.add(&slab(0));
        for worker in workers {
            match worker.join() {
                Ok(sums) => total.add(&sums),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
    });
    total
}

/// Adds the cells of one row along x: the union of the intervals of the parts.
fn add_row(solids: &[Solid], grid: &Grid, [j, k]: [u32; 2], intervals: &mut Vec<[u64; 2]>, sums: &mut Sums) {
    intervals.clear();
    let row = grid.centre(0, j, k);
    for solid in solids.iter().filter(|s| s.meets_row(&row)) {
        intervals.extend(cells_inside(solid, grid, [j, k]));
    }
    intervals.sort_unstable();
    let mut covered = 0;
    for &[start, end] in intervals.iter() {
        if end >= covered {
            sums.add_cells(start.max(covered), end, u128::from(j), u128::from(k));
            covered = end + 1;
        }
    }
}

/// First and last cell of a row whose centre is in the part.
fn cells_inside(solid: &Solid, grid: &Grid, [j, k]: [u32; 2]) -> Option<[u64; 2]> {
    let (step, last) = (grid.cell.x, i64::from(grid.cells) - 1);
    let is_inside = |i: i64| (0..=last).contains(&i) && solid.contains(&grid.centre(i, j, k));
    let (near, far) = solid.chord(&grid.centre(0, j, k))?;
    let (mut start, mut end) = ((near / step).ceil() as i64, (far / step).floor() as i64);
    (start, end) = (start.clamp(0, last), end.clamp(0, last));
    // What the test of the point says counts, not the rounding of the chord.
    while start <= end && !is_inside(start) {
        start += 1;
    }
    while is_inside(start - 1) {
        start -= 1;
    }
    while end >= start && !is_inside(end) {
        end -= 1;
    }
    while is_inside(end + 1) {
        end += 1;
    }
    (start <= end).then_some([start as u64, end as u64])
}

impl Grid {
    fn mass(&self, sums: &Sums) -> MassProperties {
        let count = sums.count as f64;
        let mean = Vec3::from(sums.first.map(|s| s as f64 / count));
        let [xx, yy, zz, xy, xz, yz] = sums.second.map(|s| s as f64 / count);
        let moments = Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) - mean * mean.transpose();
        let volume = count * self.cell.product();
        let second = Mat3::from_fn(|a, b| moments[(a, b)] * self.cell[a] * self.cell[b]) * volume;
        MassProperties {
            volume,
            center: self.first + self.cell.component_mul(&mean),
            inertia: Mat3::identity() * second.trace() - second,
        }
    }
}
