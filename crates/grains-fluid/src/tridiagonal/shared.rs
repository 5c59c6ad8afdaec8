//! Tridiagonal lines shared by several ranks, or closed into a ring.
//!
//! Each rank solves its part of a line with zero beyond its ends; the true solution is x = y − v x₋ − w x₊, with
//! the values x₋, x₊ just before and after the part, and v, w the influence vectors of unit values there. The end values of
//! all parts give x₋ and x₊: exact, with two numbers per line and rank exchanged.

use grains_domain::Transport;

/// First and last value of a part of a line as functions of the values before and after it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Segment {
    /// With zeros beyond the ends.
    pub y: [f64; 2],
    /// Influence of the value before (subtracted).
    pub v: [f64; 2],
    /// Influence of the value after (subtracted).
    pub w: [f64; 2],
}

impl Segment {
    /// The part made of this and the next, and the first value of the next as such a function [y, v, w].
    fn then(&self, next: &Segment) -> (Segment, [f64; 3]) {
        let (a, b) = (self, next);
        let s = 1.0 / (1.0 - a.w[1] * b.v[0]);
        // Last value of a and first of b.
        let at_a = [s * (a.y[1] - a.w[1] * b.y[0]), s * a.v[1], -s * a.w[1] * b.w[0]];
        let at_b = [s * (b.y[0] - b.v[0] * a.y[1]), -s * b.v[0] * a.v[1], s * b.w[0]];
        let joined = Segment {
            y: [a.y[0] - a.w[0] * at_b[0], b.y[1] - b.v[1] * at_a[0]],
            v: [a.v[0] - a.w[0] * at_b[1], -b.v[1] * at_a[1]],
            w: [-a.w[0] * at_b[2], b.w[1] - b.v[1] * at_a[2]],
        };
        (joined, at_b)
    }

    /// Last and first value of a segment whose ends meet.
    fn closed(&self) -> [f64; 2] {
        let (a, b) = (1.0 + self.w[0], self.v[0]);
        let (c, d) = (self.w[1], 1.0 + self.v[1]);
        let det = a * d - b * c;
        let first = (self.y[0] * d - b * self.y[1]) / det;
        let last = (a * self.y[1] - c * self.y[0]) / det;
        [last, first]
    }
}

/// Values before and after part `own` of a line whose parts lie in a ring; where a line ends, the first part does
/// not depend on what is before it, nor the last on what is after it.
pub(crate) fn values_around(parts: usize, own: usize, part: impl Fn(usize) -> Segment) -> [f64; 2] {
    let me = part(own);
    if parts == 1 {
        return me.closed();
    }
    let mut others = part((own + 1) % parts);
    for step in 2..parts {
        others = others.then(&part((own + step) % parts)).0;
    }
    let (ring, first_of_others) = me.then(&others);
    let [before, first] = ring.closed();
    let after = first_of_others[0] - first_of_others[1] * before - first_of_others[2] * first;
    [before, after]
}

/// Gathers equally long messages among the ranks of a row.
#[derive(Clone, Debug, Default)]
pub(crate) struct RowAllGather {
    /// Own place in the row.
    pub own: usize,
    peers: Vec<usize>,
    sent: Vec<Vec<f64>>,
    received: Vec<Vec<f64>>,
}

impl RowAllGather {
    /// Among `row`, the own rank being `row[own]`.
    pub fn new(row: &[usize], own: usize) -> Self {
        let peers: Vec<usize> = row.iter().copied().filter(|&r| r != row[own]).collect();
        let buffers = vec![Vec::new(); peers.len()];
        Self { own, peers, sent: buffers.clone(), received: buffers }
    }

    /// Number of ranks in the row.
    pub fn len(&self) -> usize {
        self.peers.len() + 1
    }

    /// Exchanges the own message with the others.
    pub fn gather(&mut self, message: &[f64], transport: &dyn Transport) {
        for (sent, received) in self.sent.iter_mut().zip(&mut self.received) {
            sent.clear();
            sent.extend_from_slice(message);
            received.resize(message.len(), 0.0);
        }
        if !self.peers.is_empty() {
            transport.exchange(&self.peers, &self.sent, &mut self.received);
        }
    }

    /// Message of a place in the row; `own` is the message given.
    pub fn message<'a>(&'a self, place: usize, own: &'a [f64]) -> &'a [f64] {
        match place.cmp(&self.own) {
            std::cmp::Ordering::Less => &self.received[place],
            std::cmp::Ordering::Equal => own,
            std::cmp::Ordering::Greater => &self.received[place - 1],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// −x_{i−1} + 3 x_i − x_{i+1} = d_i in parts of two cells, each solved by hand.
    fn parts(d: &[f64], ring: bool) -> Vec<Segment> {
        let count = d.len() / 2;
        let solve = |a: f64, b: f64| [(3.0 * a + b) / 8.0, (a + 3.0 * b) / 8.0];
        let part = |k: usize| {
            let v = if ring || k > 0 { solve(-1.0, 0.0) } else { [0.0; 2] };
            let w = if ring || k + 1 < count { solve(0.0, -1.0) } else { [0.0; 2] };
            Segment { y: solve(d[2 * k], d[2 * k + 1]), v, w }
        };
        (0..count).map(part).collect()
    }

    #[test]
    fn parts_of_a_line_and_of_a_ring_meet() {
        let x = [0.3, -1.0, 2.0, 0.7, 5.0, -0.2, 0.9, 1.1];
        for (count, ring) in [(1, true), (2, true), (4, true), (2, false), (4, false)] {
            let n = 2 * count;
            let at = |i: isize| match ring {
                true => x[i.rem_euclid(n as isize) as usize],
                false if i < 0 || i >= n as isize => 0.0,
                false => x[i as usize],
            };
            let d: Vec<f64> = (0..n as isize).map(|i| 3.0 * at(i) - at(i - 1) - at(i + 1)).collect();
            let parts = parts(&d, ring);
            for own in 0..count {
                let [before, after] = values_around(count, own, |k| parts[k]);
                if ring || own > 0 {
                    assert!((before - at(2 * own as isize - 1)).abs() < 1e-13, "{count} {ring} {own}");
                }
                if ring || own + 1 < count {
                    assert!((after - at(2 * own as isize + 2)).abs() < 1e-13, "{count} {ring} {own}");
                }
            }
        }
    }
}
