//! The halo of a subdomain: filled from the owners, or added back to them.

use crate::{CellPartition, Grid, Layout, Real};
use grains_domain::Transport;

/// Exchange along one axis with the ranks below and above.
#[derive(Clone, Debug)]
struct AxisExchange {
    neighbours: [Option<usize>; 2],
    peers: Vec<usize>,
    /// Side (0 low, 1 high) that each outgoing message leaves by, and each incoming one arrives at.
    leaves: Vec<usize>,
    arrives: Vec<usize>,
    sent: Vec<Vec<f64>>,
    received: Vec<Vec<f64>>,
}

/// Exchange of halos; several fields travel in one message per neighbour, three rounds (x, y, z) fill edges and
/// corners too. After its first use with as many fields it allocates nothing.
#[derive(Clone, Debug)]
pub struct Halo {
    layout: Layout,
    own: usize,
    axes: [AxisExchange; 3],
}

impl Halo {
    /// Exchange among the ranks of a partition.
    pub fn new(grid: &Grid, partition: &CellPartition, layout: Layout) -> Self {
        let own = partition.rank_at(partition.coordinates);
        let axes = std::array::from_fn(|a| {
            let neighbours = partition.neighbours(a, grid.axis(a).is_periodic());
            let leaves: Vec<usize> =
                (0..2).filter(|&s| neighbours[s].is_some_and(|rank| rank != own)).collect();
            let peers: Vec<usize> = leaves.iter().filter_map(|&s| neighbours[s]).collect();
            // One rank on both sides sends its low slab first, which belongs into the high halo here.
            let arrives = if peers.len() == 2 && peers[0] == peers[1] { vec![1, 0] } else { leaves.clone() };
            let buffers = vec![Vec::new(); peers.len()];
            AxisExchange { neighbours, peers, leaves, arrives, sent: buffers.clone(), received: buffers }
        });
        Self { layout, own, axes }
    }

    /// The same exchange with other numbers of the ranks.
    pub(crate) fn renumbered(mut self, rank: impl Fn(usize) -> usize) -> Self {
        self.own = rank(self.own);
        for axis in &mut self.axes {
            axis.neighbours = axis.neighbours.map(|neighbour| neighbour.map(&rank));
            axis.peers.iter_mut().for_each(|peer| *peer = rank(*peer));
        }
        self
    }

    /// Fills the halos of all fields from the owners; sides without a neighbour stay as they are.
    pub fn fill<T: Real>(&mut self, fields: &mut [&mut [T]], transport: &dyn Transport) {
        self.fill_to(self.layout.halo, fields, transport);
    }

    /// The same for so many layers next to the own cells alone.
    pub fn fill_to<T: Real>(&mut self, depth: usize, fields: &mut [&mut [T]], transport: &dyn Transport) {
        for a in 0..3 {
            self.fill_axis(a, depth.min(self.layout.halo), fields, transport);
        }
    }

    fn fill_axis<T: Real>(
        &mut self,
        axis: usize,
        depth: usize,
        fields: &mut [&mut [T]],
        transport: &dyn Transport,
    ) {
        let (layout, own) = (self.layout, self.own);
        let (n, h) = (layout.cells[axis], layout.halo);
        let exchange = &mut self.axes[axis];
        // Own slabs next to the faces leave, layers 0..h count in array places.
        let inner = |side: usize| if side == 0 { h } else { n + h - depth };
        let outer = |side: usize| if side == 0 { h - depth } else { n + h };
        exchange.pack(layout, (axis, depth), fields, inner);
        exchange.communicate(transport);
        exchange.unpack(layout, (axis, depth), fields, outer, |to, from| {
            to.iter_mut().zip(from).for_each(|(t, f)| *t = T::nearest(*f));
        });
        if exchange.neighbours.contains(&Some(own)) {
            for field in fields.iter_mut() {
                for layer in 0..depth {
                    // A subdomain thinner than the halo repeats itself.
                    let low = (-1 - layer as isize).rem_euclid(n as isize) as usize;
                    copy_layer(layout, axis, field, h + low, h - 1 - layer);
                    copy_layer(layout, axis, field, h + layer % n, n + h + layer);
                }
            }
        }
    }

    /// Adds what the halos hold to the owners' cells and clears it; what lies beyond a side without neighbour
    /// stays in the halo.
    pub fn add<T: Real>(&mut self, fields: &mut [&mut [T]], transport: &dyn Transport) {
        self.add_to(self.layout.halo, fields, transport);
    }

    /// The same for so many layers next to the own cells alone; there is nothing in those beyond.
    pub fn add_to<T: Real>(&mut self, depth: usize, fields: &mut [&mut [T]], transport: &dyn Transport) {
        for a in (0..3).rev() {
            self.add_axis(a, depth.min(self.layout.halo), fields, transport);
        }
    }

    fn add_axis<T: Real>(
        &mut self,
        axis: usize,
        depth: usize,
        fields: &mut [&mut [T]],
        transport: &dyn Transport,
    ) {
        let (layout, own) = (self.layout, self.own);
        let (n, h) = (layout.cells[axis], layout.halo);
        let exchange = &mut self.axes[axis];
        let inner = |side: usize| if side == 0 { h } else { n + h - depth };
        let outer = |side: usize| if side == 0 { h - depth } else { n + h };
        exchange.pack(layout, (axis, depth), fields, outer);
        exchange.communicate(transport);
        exchange.unpack(layout, (axis, depth), fields, inner, |to, from| {
            to.iter_mut().zip(from).for_each(|(t, f)| *t += T::nearest(*f));
        });
        for side in 0..2 {
            let Some(rank) = exchange.neighbours[side] else { continue };
            for field in fields.iter_mut() {
                for layer in 0..depth {
                    let at = outer(side) + layer;
                    let home = h + (at as isize - h as isize).rem_euclid(n as isize) as usize;
                    take_layer(layout, axis, field, at, (rank == own).then_some(home));
                }
            }
        }
    }
}

impl AxisExchange {
    fn pack<T: Real>(
        &mut self,
        layout: Layout,
        (axis, depth): (usize, usize),
        fields: &mut [&mut [T]],
        first: impl Fn(usize) -> usize,
    ) {
        let size = layout.len() / layout.dims()[axis] * depth * fields.len();
        for (message, &side) in self.sent.iter_mut().zip(&self.leaves) {
            message.clear();
            for field in fields.iter() {
                for_runs(layout, axis, first(side), depth, |run| {
                    message.extend(field[run].iter().map(|value| -> f64 { (*value).into() }));
                });
            }
        }
        self.received.iter_mut().for_each(|m| m.resize(size, 0.0));
    }

    fn communicate(&mut self, transport: &dyn Transport) {
        if !self.peers.is_empty() {
            transport.exchange(&self.peers, &self.sent, &mut self.received);
        }
    }

    fn unpack<T: Real>(
        &self,
        layout: Layout,
        (axis, depth): (usize, usize),
        fields: &mut [&mut [T]],
        first: impl Fn(usize) -> usize,
        store: impl Fn(&mut [T], &[f64]),
    ) {
        for (message, &side) in self.received.iter().zip(&self.arrives) {
            let mut at = 0;
            for field in fields.iter_mut() {
                for_runs(layout, axis, first(side), depth, |run| {
                    let length = run.len();
                    store(&mut field[run], &message[at..at + length]);
                    at += length;
                });
            }
        }
    }
}

/// Contiguous runs of `count` layers beginning at array place `first` along an axis, all other extents full.
fn for_runs(
    layout: Layout,
    axis: usize,
    first: usize,
    count: usize,
    mut job: impl FnMut(std::ops::Range<usize>),
) {
    let (dims, strides) = (layout.dims(), layout.strides());
    let above: usize = dims[axis + 1..].iter().product();
    let period = strides[axis] * dims[axis];
    for block in 0..above {
        let start = block * period + first * strides[axis];
        job(start..start + count * strides[axis]);
    }
}

fn copy_layer<T: Real>(layout: Layout, axis: usize, field: &mut [T], from: usize, to: usize) {
    let (from, to, stride) = (from as isize, to as isize, layout.strides()[axis] as isize);
    for_runs(layout, axis, to as usize, 1, |run| {
        let source = (run.start as isize + (from - to) * stride) as usize;
        field.copy_within(source..source + run.len(), run.start);
    });
}

/// Clears a layer, adding it first to the layer `home` if there is one.
fn take_layer<T: Real>(layout: Layout, axis: usize, field: &mut [T], at: usize, home: Option<usize>) {
    let stride = layout.strides()[axis] as isize;
    for_runs(layout, axis, at, 1, |run| {
        for p in run {
            let value = std::mem::take(&mut field[p]);
            if let Some(home) = home {
                field[(p as isize + (home as isize - at as isize) * stride) as usize] += value;
            }
        }
    });
}
