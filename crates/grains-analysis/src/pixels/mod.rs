//! Counting the cells of a fine grid that lie in particles (Rakotonirina 2016, ch. 3.4.1).
//!
//! The grid is never held as a whole. Its layers along the axis come in blocks, dealt out to the ranks in
//! turn; a rank draws into one block at a time, a bit per cell, all particles that reach it. A convex part
//! meets a row of cells in one interval, whose ends are found by bisection, so the cost goes with the
//! number of rows in particles. A cell covered twice counts once.

mod bounds;
mod line;

use super::region::{Region, across};
use super::snapshots::Snapshot;
use bounds::{Bounded, bounded};
use grains_case::Domain;
use grains_domain::Transport;
use grains_geometry::{Mat3, Rotation, Shape, Vec3};
use line::Line;
use nalgebra::{Quaternion, Unit};
use std::collections::BTreeMap;
use std::ops::Range;

/// Cells of equal size that fill the box of a region.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// Axes of rows, of the rows of a layer, and of layers.
    axes: [usize; 3],
    /// Number of cells along these axes.
    cells: [usize; 3],
    lower: Vec3,
    /// Edges of a cell along x, y, z (m).
    spacing: Vec3,
}

impl Grid {
    /// Grid of nearly cubic cells of an edge (m) or a little less.
    pub fn new(region: &Region, edge: f64) -> Self {
        let [v, u] = across(region.axis);
        let axes = [u, v, region.axis];
        let size = region.upper - region.lower;
        // A whole number of edges, but for rounding, makes as many cells.
        let cells = axes.map(|a| (size[a] / edge * (1.0 - 1e-12)).ceil().max(1.0) as usize);
        let mut spacing = Vec3::zeros();
        axes.iter().zip(cells).for_each(|(&a, n)| spacing[a] = size[a] / n as f64);
        Self { axes, cells, lower: region.lower, spacing }
    }

    /// Largest edge of a cell (m).
    pub fn edge(&self) -> f64 {
        self.spacing.max()
    }

    /// Number of layers.
    pub fn layers(&self) -> usize {
        self.cells[2]
    }

    /// Middle of cell `k` along one of the three axes of the grid (m).
    fn middle(&self, direction: usize, k: usize) -> f64 {
        let a = self.axes[direction];
        self.lower[a] + (k as f64 + 0.5) * self.spacing[a]
    }

    /// Cells along a direction whose middles lie between two coordinates (m).
    fn between(&self, direction: usize, lower: f64, upper: f64) -> Range<usize> {
        let (a, last) = (self.axes[direction], self.cells[direction] as f64);
        let first = ((lower - self.lower[a]) / self.spacing[a] - 0.5).ceil().clamp(0.0, last);
        let end = ((upper - self.lower[a]) / self.spacing[a] - 0.5).floor() + 1.0;
        first as usize..end.clamp(first, last) as usize
    }
}

/// Cells in rings about a line along the axis.
#[derive(Clone, Debug)]
pub struct Rings {
    /// Centre across the axis, in the order of [`across`] (m).
    pub center: [f64; 2],
    /// Outer radii, rising (m).
    pub edges: Vec<f64>,
}

/// Numbers of cells, of the region and of those in particles.
#[derive(Clone, Debug, PartialEq)]
pub struct Counted {
    /// Per layer along the axis, `[all, solid]`.
    pub layers: Vec<[u64; 2]>,
    /// Per ring, `[all, solid]`; empty if none were asked for.
    pub rings: Vec<[u64; 2]>,
}

/// A particle, or a periodic image of one.
#[derive(Clone, Copy, Debug)]
struct Body {
    shape: usize,
    scale: f64,
    center: Vec3,
    orientation: Rotation,
}

impl Body {
    const LENGTH: usize = 9;

    fn write(&self, message: &mut Vec<f64>) {
        let (q, c) = (self.orientation.quaternion(), self.center);
        message.extend([self.shape as f64, self.scale, c.x, c.y, c.z, q.w, q.i, q.j, q.k]);
    }

    fn read(m: &[f64]) -> Self {
        Self {
            shape: m[0] as usize,
            scale: m[1],
            center: Vec3::new(m[2], m[3], m[4]),
            // As it was, so that the same bits are drawn wherever it is.
            orientation: Unit::new_unchecked(Quaternion::new(m[5], m[6], m[7], m[8])),
        }
    }
}

/// Bytes of the largest block, unless one layer is larger.
const LARGEST_BLOCK: usize = 1 << 26;

/// Counts the cells of a region; the same on any number of ranks.
pub fn count(
    region: &Region,
    grid: &Grid,
    rings: Option<&Rings>,
    (snapshot, shapes): (&Snapshot, &[Shape]),
    domain: &Domain,
    transport: &impl Transport,
) -> Counted {
    let mut largest = [0.0];
    (0..snapshot.len()).for_each(|i| largest[0] = f64::max(largest[0], snapshot.radius(i, shapes)));
    transport.max(&mut largest);
    let masks = masks(region, grid, rings);
    let mut block = Block::new(grid, 0.5 * largest[0]);
    let (parts, radii): (Vec<_>, Vec<f64>) = shapes.iter().map(bounded).unzip();
    let bodies = deal_out(&block, (snapshot, &radii), (region, domain), transport);
    let ring_count = rings.map_or(0, |r| r.edges.len());
    let mut totals = vec![0_u64; 2 * (grid.layers() + ring_count)];
    let (of_layers, of_rings) = totals.split_at_mut(2 * grid.layers());
    let blocks = grid.layers().div_ceil(block.depth);
    let mut reaching = vec![Vec::new(); blocks];
    for body in &bodies {
        for b in block.reached_by(body, &radii) {
            reaching[b].push(body);
        }
    }
    for b in (transport.rank()..blocks).step_by(transport.size()) {
        block.clear(b);
        for body in &reaching[b] {
            parts[body.shape].iter().for_each(|part| block.draw(body, part));
        }
        block.count(&masks, of_layers, of_rings);
    }
    transport.sum_counts(&mut totals);
    let pairs = |list: &[u64]| list.chunks_exact(2).map(|c| [c[0], c[1]]).collect();
    Counted { layers: pairs(&totals[..2 * grid.layers()]), rings: pairs(&totals[2 * grid.layers()..]) }
}

/// For each row of a layer the cells inside each ring, nested, then those inside the region.
fn masks(region: &Region, grid: &Grid, rings: Option<&Rings>) -> Vec<Vec<Range<usize>>> {
    let row = |j: usize| {
        // `across` names the axis of rows second, see `Grid::new`.
        let v = grid.middle(1, j);
        let within = |center: [f64; 2], radius: f64| {
            let half = (radius * radius - (v - center[0]).powi(2)).max(-1.0);
            if half < 0.0 {
                return 0..0;
            }
            grid.between(0, center[1] - half.sqrt(), center[1] + half.sqrt())
        };
        let whole = match region.cylinder {
            Some((center, radius)) => within(center, radius),
            None => 0..grid.cells[0],
        };
        let clipped = |r: Range<usize>| {
            let start = r.start.clamp(whole.start, whole.end);
            start..r.end.clamp(start, whole.end)
        };
        let ring_ranges =
            rings.iter().flat_map(|r| r.edges.iter().map(|&edge| clipped(within(r.center, edge))));
        let mut ranges: Vec<Range<usize>> = ring_ranges.collect();
        ranges.push(whole.clone());
        ranges
    };
    (0..grid.cells[1]).map(row).collect()
}

/// The bodies of all ranks, periodic images included, that reach a block of this rank; `radii` are those of
/// balls that hold the shapes (m).
fn deal_out(
    block: &Block,
    (snapshot, radii): (&Snapshot, &[f64]),
    (region, domain): (&Region, &Domain),
    transport: &impl Transport,
) -> Vec<Body> {
    let mut sent: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    let period = domain.extents();
    for i in 0..snapshot.len() {
        let (center, radius) = (snapshot.position[i], radii[snapshot.shape[i]] * snapshot.scale[i]);
        let images = |a: usize| {
            if !domain.periodic[a] {
                return 0..=0;
            }
            let first = ((region.lower[a] - radius - center[a]) / period[a]).ceil() as i64;
            first..=((region.upper[a] + radius - center[a]) / period[a]).floor() as i64
        };
        for (x, y, z) in images(0)
            .flat_map(|x| images(1).flat_map(move |y| images(2).map(move |z| (x, y, z)).collect::<Vec<_>>()))
        {
            let shift = Vec3::new(x as f64 * period[0], y as f64 * period[1], z as f64 * period[2]);
            let body = Body {
                shape: snapshot.shape[i],
                scale: snapshot.scale[i],
                center: center + shift,
                orientation: snapshot.orientation[i],
            };
            let reached = block.reached_by(&body, radii);
            reached
                .take(transport.size())
                .for_each(|b| body.write(sent.entry(b % transport.size()).or_default()));
        }
    }
    let received = transport.exchange_sparse(sent.into_iter().collect());
    received.iter().flat_map(|(_, message)| message.chunks_exact(Body::LENGTH).map(Body::read)).collect()
}

/// Some layers of the grid, a bit per cell.
struct Block {
    grid: Grid,
    /// Layers of a block; the last may have fewer.
    depth: usize,
    /// Words of a row.
    words: usize,
    /// Layers that are drawn now.
    layers: Range<usize>,
    /// `[layer][row][word]`
    bits: Vec<u64>,
}

impl Block {
    /// Blocks about as thick as a length (m). How thick must not depend on the ranks.
    fn new(grid: &Grid, thickness: f64) -> Self {
        let words = grid.cells[0].div_ceil(64);
        let layer = 8 * words * grid.cells[1];
        let wanted = (thickness / grid.spacing[grid.axes[2]]) as usize;
        let depth = wanted.min(LARGEST_BLOCK / layer).clamp(1, grid.layers());
        Self { grid: *grid, depth, words, layers: 0..0, bits: Vec::new() }
    }

    fn clear(&mut self, block: usize) {
        let first = block * self.depth;
        self.layers = first..(first + self.depth).min(self.grid.layers());
        self.bits.clear();
        self.bits.resize(self.layers.len() * self.grid.cells[1] * self.words, 0);
    }

    /// Blocks whose layers a body reaches.
    fn reached_by(&self, body: &Body, radii: &[f64]) -> Range<usize> {
        let radius = radii[body.shape] * body.scale;
        let middle = body.center[self.grid.axes[2]];
        let layers = self.grid.between(2, middle - radius, middle + radius);
        if layers.is_empty() {
            return 0..0;
        }
        layers.start / self.depth..(layers.end - 1) / self.depth + 1
    }

    /// Sets the bits of the cells whose middles lie in a part of a body.
    fn draw(&mut self, body: &Body, bounded: &Bounded) {
        let (grid, part) = (self.grid, bounded.part);
        let turn: Mat3 = body.orientation.to_rotation_matrix().into_inner();
        let to_part = part.rotation.transpose() * turn.transpose() / body.scale;
        let offset = part.rotation.transpose() * part.center;
        let middle = body.center + turn * part.center * body.scale;
        let box_half_extents = (turn * part.rotation).abs() * bounded.half_extents;
        let half_extents = box_half_extents.map(|x| x.min(bounded.radius)) * body.scale;
        let cells = |direction: usize| {
            let a = grid.axes[direction];
            grid.between(direction, middle[a] - half_extents[a], middle[a] + half_extents[a])
        };
        let (rows, layers) = (cells(1), cells(2));
        let [u, v, w] = grid.axes;
        let step = to_part.column(u) * grid.spacing[u];
        for k in layers.start.max(self.layers.start)..layers.end.min(self.layers.end) {
            for j in rows.clone() {
                let mut first = Vec3::zeros();
                (first[u], first[v], first[w]) = (grid.middle(0, 0), grid.middle(1, j), grid.middle(2, k));
                let line = Line { start: to_part * (first - body.center) - offset, step };
                if let Some((from, to)) = line.inside(bounded, grid.cells[0]) {
                    let row = ((k - self.layers.start) * grid.cells[1] + j) * self.words;
                    set(&mut self.bits[row..row + self.words], from, to);
                }
            }
        }
    }

    /// Adds up the cells of each layer and ring.
    fn count(&self, masks: &[Vec<Range<usize>>], layers: &mut [u64], rings: &mut [u64]) {
        for (k, layer) in self.bits.chunks_exact(self.words * masks.len()).enumerate() {
            let total = 2 * (self.layers.start + k);
            for (row, ranges) in layer.chunks_exact(self.words).zip(masks) {
                let mut inner = [0, 0];
                for (r, range) in ranges.iter().enumerate() {
                    let found = [range.len() as u64, ones(row, range)];
                    if r + 1 < ranges.len() {
                        rings[2 * r] += found[0] - inner[0];
                        rings[2 * r + 1] += found[1] - inner[1];
                        inner = found;
                    } else {
                        layers[total] += found[0];
                        layers[total + 1] += found[1];
                    }
                }
            }
        }
    }
}

/// Sets bits `from..=to`.
fn set(row: &mut [u64], from: usize, to: usize) {
    let (first, last) = (from / 64, to / 64);
    let (head, tail) = (u64::MAX << (from % 64), u64::MAX >> (63 - to % 64));
    if first == last {
        row[first] |= head & tail;
        return;
    }
    row[first] |= head;
    row[first + 1..last].fill(u64::MAX);
    row[last] |= tail;
}

/// Number of bits set in a range.
fn ones(row: &[u64], range: &Range<usize>) -> u64 {
    if range.is_empty() {
        return 0;
    }
    let (first, last) = (range.start / 64, (range.end - 1) / 64);
    let head = u64::MAX << (range.start % 64);
    let tail = u64::MAX >> (63 - (range.end - 1) % 64);
    if first == last {
        return u64::from((row[first] & head & tail).count_ones());
    }
    let inner: u32 = row[first + 1..last].iter().map(|word| word.count_ones()).sum();
    u64::from((row[first] & head).count_ones() + inner + (row[last] & tail).count_ones())
}

#[cfg(test)]
mod tests;
