//! Adding what was deposited in a rank's halo to the values of the neighbours it belongs to.

use grains_domain::{Decomposition, Direction, Transport};

/// One axis of an array: a halo of `lower` values, `own` values, a halo of `upper` values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Extent {
    lower: usize,
    own: usize,
    upper: usize,
}

impl Extent {
    fn total(&self) -> usize {
        self.lower + self.own + self.upper
    }
}

/// Sums of the halo of one kind of field, x fastest, with buffers of its own.
///
/// Axis by axis the layers beyond either end go to the neighbour there, which adds them to its own outermost values;
/// what lies in edges and corners travels along two and three axes. Faces normal to an axis belong to the cell
/// above them, so that their upper halo has one layer more than that of cells.
#[derive(Clone, Debug)]
pub struct HaloSum {
    extents: [Extent; 3],
    /// Ranks below and above along each axis; `None` at a boundary of the domain.
    neighbours: [[Option<usize>; 2]; 3],
    rank: usize,
    sent: Vec<Vec<f64>>,
    received: Vec<Vec<f64>>,
    /// Both messages of a rank that is the neighbour on either side.
    both: Vec<f64>,
}

impl HaloSum {
    /// For arrays with, along each axis, `lower` halo values, `own` ones and `upper` halo values.
    ///
    /// The widths of the halos must be the same on all ranks, also at boundaries of the domain, where they hold nothing,
    /// and no rank may own fewer values than they are wide.
    pub fn new(decomposition: &Decomposition, counts: [[usize; 3]; 3]) -> Self {
        let extents = counts.map(|[lower, own, upper]| Extent { lower, own, upper });
        let rank_at = |axis: usize, side: i8| {
            let mut step = [0; 3];
            step[axis] = side;
            decomposition.neighbour(Direction(step)).map(|(rank, _)| rank)
        };
        Self {
            extents,
            neighbours: std::array::from_fn(|a| [rank_at(a, -1), rank_at(a, 1)]),
            rank: decomposition.rank_at(decomposition.coordinates),
            sent: vec![Vec::new(); 2],
            received: vec![Vec::new(); 2],
            both: Vec::new(),
        }
    }

    /// Adds the halos of `field` to the values they belong to, on all ranks; the halos are 0 afterwards.
    pub fn add(&mut self, field: &mut [f64], transport: &impl Transport) {
        for axis in 0..3 {
            self.add_along(axis, field, transport);
        }
    }

    fn add_along(&mut self, axis: usize, field: &mut [f64], transport: &impl Transport) {
        let Extent { lower, own, upper } = self.extents[axis];
        // Where the halos lie, and where a neighbour's halos are to be added.
        let halos = [(0, lower), (lower + own, upper)];
        let edges = [(lower, upper), (own, lower)];
        let [below, above] = self.neighbours[axis];
        for (side, (first, count)) in halos.into_iter().enumerate() {
            self.sent[side].clear();
            let (slab, sent) = (self.slab(axis, first, count), &mut self.sent[side]);
            slab.for_each(|from, length| {
                let values = &mut field[from..from + length];
                sent.extend_from_slice(values);
                values.fill(0.0);
            });
        }
        // `received[0]` comes from below: the upper halo of the rank there.
        for (side, (_, count)) in edges.into_iter().enumerate() {
            let length = self.slab(axis, 0, count).values();
            self.received[side].clear();
            self.received[side].resize(length, 0.0);
        }
        self.exchange(below, above, transport);
        for (side, (first, count)) in edges.into_iter().enumerate() {
            if [below, above][side].is_none() {
                continue;
            }
            let (slab, mut at) = (self.slab(axis, first, count), 0);
            slab.for_each(|from, length| {
                let values = field[from..from + length].iter_mut();
                values.zip(&self.received[side][at..at + length]).for_each(|(f, r)| *f += r);
                at += length;
            });
        }
    }

    /// Swaps messages with the ranks below and above, which may be one rank, or this one.
    fn exchange(&mut self, below: Option<usize>, above: Option<usize>, transport: &impl Transport) {
        let Self { sent, received, both, .. } = self;
        match (below, above) {
            (Some(b), Some(a)) if b == a && b == self.rank => {
                let [low, high] = [0, 1].map(|side| std::mem::take(&mut sent[side]));
                received[0].copy_from_slice(&high);
                received[1].copy_from_slice(&low);
                (sent[0], sent[1]) = (low, high);
            }
            (Some(b), Some(a)) if b == a => {
                // Two messages to one rank would arrive in the order of the sender.
                let (first, second) = (sent[0].len(), received[1].len());
                let high = std::mem::take(&mut sent[1]);
                sent[0].extend_from_slice(&high);
                both.resize(second + received[0].len(), 0.0);
                transport.exchange(&[b], &sent[..1], std::slice::from_mut(both));
                received[1].copy_from_slice(&both[..second]);
                received[0].copy_from_slice(&both[second..]);
                sent[0].truncate(first);
                sent[1] = high;
            }
            (Some(b), Some(a)) => transport.exchange(&[b, a], sent, received),
            (Some(b), None) => transport.exchange(&[b], &sent[..1], &mut received[..1]),
            (None, Some(a)) => transport.exchange(&[a], &sent[1..], &mut received[1..]),
            (None, None) => {}
        }
    }

    fn slab(&self, axis: usize, first: usize, count: usize) -> Slab {
        let mut slab = Slab { first: [0; 3], counts: self.extents.map(|e| e.total()), totals: [0; 3] };
        slab.totals = slab.counts;
        (slab.first[axis], slab.counts[axis]) = (first, count);
        slab
    }
}

/// A block of an array.
struct Slab {
    first: [usize; 3],
    counts: [usize; 3],
    totals: [usize; 3],
}

impl Slab {
    fn values(&self) -> usize {
        self.counts.iter().product()
    }

    /// Visits the runs of neighbouring values: index of the first, and length.
    fn for_each(&self, mut visit: impl FnMut(usize, usize)) {
        for k in self.first[2]..self.first[2] + self.counts[2] {
            for j in self.first[1]..self.first[1] + self.counts[1] {
                let row = (k * self.totals[1] + j) * self.totals[0];
                visit(row + self.first[0], self.counts[0]);
            }
        }
    }
}
