//! Whole lines along an axis that several ranks share: sent to one rank each, transformed there, sent back.

use crate::CellPartition;
use grains_domain::Transport;

/// Exchange of the lines along one axis of a block `[nz][ny][nx]` without halo.
#[derive(Clone)]
pub(crate) struct PencilTranspose {
    axis: usize,
    cells: [usize; 3],
    own: usize,
    /// Cells of every rank of the row, and the lines each of them gets.
    starts: Vec<usize>,
    shares: Vec<usize>,
    peers: Vec<usize>,
    sent: Vec<Vec<f64>>,
    received: Vec<Vec<f64>>,
    /// Own lines, each contiguous: `[line][n]`.
    pencils: Vec<f64>,
}

impl PencilTranspose {
    /// Transpose along an axis.
    pub fn new(partition: &CellPartition, axis: usize) -> Self {
        let (row, cells) = (partition.row(axis), partition.cells());
        let own = partition.coordinates[axis];
        let lines = cells.iter().product::<usize>() / cells[axis];
        let shares: Vec<usize> = (0..=row.len()).map(|r| lines * r / row.len()).collect();
        let starts = partition.starts[axis].clone();
        let n = starts[row.len()];
        let mine = shares[own + 1] - shares[own];
        let others = || (0..row.len()).filter(move |&r| r != own);
        Self {
            axis,
            cells,
            own,
            peers: others().map(|r| row[r]).collect(),
            sent: others().map(|r| vec![0.0; (shares[r + 1] - shares[r]) * cells[axis]]).collect(),
            received: others().map(|r| vec![0.0; mine * (starts[r + 1] - starts[r])]).collect(),
            pencils: vec![0.0; mine * n],
            starts,
            shares,
        }
    }

    /// Place in the block of the first cell of a line, and the distance of its cells.
    fn line(&self, number: usize) -> (usize, usize) {
        let [nx, ny, _] = self.cells;
        match self.axis {
            0 => (number * nx, 1),
            1 => (number / nx * nx * ny + number % nx, nx),
            _ => (number, nx * ny),
        }
    }

    /// Applies `transform` to every line of the block, whoever owns its cells.
    pub fn for_lines(
        &mut self,
        block: &mut [f64],
        transport: &dyn Transport,
        mut transform: impl FnMut(&mut [f64]),
    ) {
        let n = *self.starts.last().unwrap_or(&0);
        self.transpose(block, transport);
        self.pencils.chunks_exact_mut(n).for_each(&mut transform);
        self.transpose_back(block, transport);
    }

    fn transpose(&mut self, block: &[f64], transport: &dyn Transport) {
        let (n, part) = (*self.starts.last().unwrap_or(&0), self.cells[self.axis]);
        let mut sent = std::mem::take(&mut self.sent);
        for (message, r) in sent.iter_mut().zip((0..self.shares.len() - 1).filter(|&r| r != self.own)) {
            let lines = self.shares[r]..self.shares[r + 1];
            for (values, line) in message.chunks_exact_mut(part).zip(lines) {
                let (start, stride) = self.line(line);
                values.iter_mut().zip(block[start..].iter().step_by(stride)).for_each(|(v, b)| *v = *b);
            }
        }
        transport.exchange(&self.peers, &sent, &mut self.received);
        self.sent = sent;
        let mut whole = std::mem::take(&mut self.pencils);
        for (l, values) in whole.chunks_exact_mut(n).enumerate() {
            let (start, stride) = self.line(self.shares[self.own] + l);
            let own = &mut values[self.starts[self.own]..self.starts[self.own + 1]];
            own.iter_mut().zip(block[start..].iter().step_by(stride)).for_each(|(v, b)| *v = *b);
            for (message, r) in
                self.received.iter().zip((0..self.shares.len() - 1).filter(|&r| r != self.own))
            {
                let count = self.starts[r + 1] - self.starts[r];
                values[self.starts[r]..self.starts[r + 1]].copy_from_slice(&message[l * count..][..count]);
            }
        }
        self.pencils = whole;
    }

    fn transpose_back(&mut self, block: &mut [f64], transport: &dyn Transport) {
        let (n, part) = (*self.starts.last().unwrap_or(&0), self.cells[self.axis]);
        let mine = self.shares[self.own];
        for (l, values) in self.pencils.chunks_exact(n).enumerate() {
            let (start, stride) = self.line(mine + l);
            let own = &values[self.starts[self.own]..self.starts[self.own + 1]];
            block[start..].iter_mut().step_by(stride).zip(own).for_each(|(b, v)| *b = *v);
            for (message, r) in
                self.received.iter_mut().zip((0..self.shares.len() - 1).filter(|&r| r != self.own))
            {
                let count = self.starts[r + 1] - self.starts[r];
                message[l * count..][..count].copy_from_slice(&values[self.starts[r]..self.starts[r + 1]]);
            }
        }
        // The way back swaps the buffers: what had arrived leaves again.
        transport.exchange(&self.peers, &self.received, &mut self.sent);
        for (message, r) in self.sent.iter().zip((0..self.shares.len() - 1).filter(|&r| r != self.own)) {
            let lines = self.shares[r]..self.shares[r + 1];
            for (values, line) in message.chunks_exact(part).zip(lines) {
                let (start, stride) = self.line(line);
                block[start..].iter_mut().step_by(stride).zip(values).for_each(|(b, v)| *b = *v);
            }
        }
    }
}
