//! Lines shared along a row of ranks: each rank has the ends of a share of the lines and finds what lies around all their parts.

use super::Couplings;
use grains_domain::Transport;
use std::ops::Range;

/// The ends of all parts of the lines along a row of ranks, shared out among these.
///
/// Every rank sends the others two or more numbers per line of their shares and gets two back for each of its own parts.
#[derive(Clone, Debug, Default)]
pub(crate) struct SharedLines {
    own: usize,
    peers: Vec<usize>,
    lines: usize,
    width: usize,
    sent: Vec<Vec<f64>>,
    /// Ends by part, the own one last.
    ends: Vec<Vec<f64>>,
    /// Values around the parts of other ranks, the own ones last; and those that arrive.
    found: Vec<Vec<f64>>,
    received: Vec<Vec<f64>>,
    /// Values before and after the own part of every line.
    around: Vec<[f64; 2]>,
}

/// One line of the own share.
pub(crate) struct SharedLine<'a> {
    lines: &'a SharedLines,
    number: usize,
}

impl SharedLine<'_> {
    /// What a part of the line has sent.
    pub fn part(&self, part: usize) -> &[f64] {
        let SharedLines { ends, width, .. } = self.lines;
        &ends[self.lines.slot(part)][self.number * width..][..*width]
    }
}

impl SharedLines {
    /// Among `row`, the own rank being `row[own]`.
    pub fn new(row: &[usize], own: usize) -> Self {
        let peers: Vec<usize> = row.iter().copied().filter(|&r| r != row[own]).collect();
        let (others, all) = (vec![Vec::new(); peers.len()], vec![Vec::new(); row.len()]);
        Self {
            own,
            peers,
            sent: others.clone(),
            received: others,
            ends: all.clone(),
            found: all,
            ..Self::default()
        }
    }

    /// Number of ranks in the row, and of parts of a line.
    pub fn parts(&self) -> usize {
        self.ends.len()
    }

    /// Lines of the share of a rank of the row.
    fn share(&self, rank: usize) -> Range<usize> {
        let parts = self.parts();
        self.lines * rank / parts..self.lines * (rank + 1) / parts
    }

    /// Number of lines of the own share.
    pub fn count(&self) -> usize {
        self.share(self.own).len()
    }

    /// Place of a rank of the row in lists that have the own one last.
    fn slot(&self, rank: usize) -> usize {
        match rank.cmp(&self.own) {
            std::cmp::Ordering::Less => rank,
            std::cmp::Ordering::Equal => self.peers.len(),
            std::cmp::Ordering::Greater => rank - 1,
        }
    }

    /// Sends so many numbers per line, those of the own parts, to the ranks that share the lines out.
    pub fn collect(&mut self, ends: &[f64], width: usize, transport: &dyn Transport) {
        (self.lines, self.width) = (ends.len() / width, width);
        let count = self.count() * width;
        for rank in (0..self.parts()).filter(|&rank| rank != self.own) {
            let (slot, share) = (self.slot(rank), self.share(rank));
            self.sent[slot].clear();
            self.sent[slot].extend_from_slice(&ends[share.start * width..share.end * width]);
            self.ends[slot].resize(count, 0.0);
        }
        let (share, others) = (self.share(self.own), self.peers.len());
        self.ends[others].clear();
        self.ends[others].extend_from_slice(&ends[share.start * width..share.end * width]);
        if others > 0 {
            transport.exchange(&self.peers, &self.sent, &mut self.ends[..others]);
        }
    }

    /// A line of the own share.
    pub fn line(&self, number: usize) -> SharedLine<'_> {
        SharedLine { lines: self, number }
    }

    /// Solves the lines of the own share and sends the values around their parts to the ranks that have these;
    /// `solve(number, line, put)` hands the values before and after each part to `put`.
    pub fn solve(
        &mut self,
        transport: &dyn Transport,
        mut solve: impl FnMut(usize, SharedLine<'_>, &mut dyn FnMut(usize, [f64; 2])),
    ) {
        let (count, others) = (self.count(), self.peers.len());
        let mut found = std::mem::take(&mut self.found);
        found.iter_mut().for_each(|values| values.resize(2 * count, 0.0));
        for number in 0..count {
            solve(number, self.line(number), &mut |part, around| {
                found[self.slot(part)][2 * number..][..2].copy_from_slice(&around);
            });
        }
        for rank in (0..self.parts()).filter(|&rank| rank != self.own) {
            let (slot, share) = (self.slot(rank), self.share(rank));
            self.received[slot].resize(2 * share.len(), 0.0);
        }
        if others > 0 {
            transport.exchange(&self.peers, &found[..others], &mut self.received);
        }
        self.found = found;
        self.around.clear();
        for rank in 0..self.parts() {
            let values = if rank == self.own { &self.found[others] } else { &self.received[self.slot(rank)] };
            self.around.extend_from_slice(values.as_chunks::<2>().0);
        }
    }

    /// Finds the values around the own parts of all lines, of which `ends` has first and last value, and those of the influence vectors of
    /// what is before and after the part; collective where lines are shared.
    pub fn join(&mut self, ends: &[f64], couplings: &mut Couplings, transport: &dyn Transport) {
        self.collect(ends, 6, transport);
        let parts = self.parts();
        self.solve(transport, |_, line, put| {
            couplings.join(parts, |part| {
                let e = line.part(part);
                [[e[2], e[3]], [e[4], e[5]]]
            });
            couplings.solve(|part| [line.part(part)[0], line.part(part)[1]], put);
        });
    }

    /// Values before and after the own part of every line.
    pub fn around(&self) -> &[[f64; 2]] {
        &self.around
    }
}
