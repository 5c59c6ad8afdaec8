//! Ranks as threads of one process, and grids shared among them.

#![allow(dead_code)] // each test program uses its part

use grains_domain::{Decomposition, GlobalBox, Transport};
use grains_fluid::{CellPartition, Centre, Field, Grid};
use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex};

type Post = Arc<(Mutex<HashMap<(usize, usize), VecDeque<Vec<f64>>>>, Condvar)>;

/// A rank that is a thread of this process.
#[derive(Clone)]
pub struct ThreadTransport {
    rank: usize,
    size: usize,
    post: Post,
}

impl ThreadTransport {
    fn send(&self, to: usize, message: Vec<f64>) {
        self.post.0.lock().unwrap().entry((self.rank, to)).or_default().push_back(message);
        self.post.1.notify_all();
    }

    fn receive(&self, from: usize) -> Vec<f64> {
        let mut boxes = self.post.0.lock().unwrap();
        loop {
            if let Some(message) = boxes.get_mut(&(from, self.rank)).and_then(VecDeque::pop_front) {
                return message;
            }
            boxes = self.post.1.wait(boxes).unwrap();
        }
    }

    /// What all ranks send here, in rank order.
    fn all_to_all(&self, sent: &[Vec<f64>]) -> Vec<Vec<f64>> {
        (0..self.size).for_each(|r| self.send(r, sent[r].clone()));
        (0..self.size).map(|r| self.receive(r)).collect()
    }
}

impl Transport for ThreadTransport {
    fn rank(&self) -> usize {
        self.rank
    }
    fn size(&self) -> usize {
        self.size
    }
    fn exchange(&self, peers: &[usize], sent: &[Vec<f64>], received: &mut [Vec<f64>]) {
        peers.iter().zip(sent).for_each(|(&p, m)| self.send(p, m.clone()));
        for (&peer, buffer) in peers.iter().zip(received) {
            let message = self.receive(peer);
            assert_eq!(message.len(), buffer.len(), "rank {} expects another length from {peer}", self.rank);
            *buffer = message;
        }
    }
    fn exchange_unsized(&self, peers: &[usize], sent: &[Vec<f64>], received: &mut [Vec<f64>]) {
        peers.iter().zip(sent).for_each(|(&p, m)| self.send(p, m.clone()));
        peers.iter().zip(received).for_each(|(&p, buffer)| *buffer = self.receive(p));
    }
    fn exchange_sparse(&self, sent: Vec<(usize, Vec<f64>)>) -> Vec<(usize, Vec<f64>)> {
        let mut outgoing = vec![Vec::new(); self.size];
        sent.into_iter().for_each(|(rank, message)| outgoing[rank].extend(message));
        let received = self.all_to_all(&outgoing).into_iter().enumerate();
        received.filter(|(_, message)| !message.is_empty()).collect()
    }
    fn highest(&self, level: u8) -> u8 {
        self.gather(&[f64::from(level)]).iter().fold(0, |m, &l| m.max(l as u8))
    }
    fn max(&self, values: &mut [f64]) {
        let (all, n) = (self.gather(values), values.len());
        for (k, v) in values.iter_mut().enumerate() {
            *v = all.iter().skip(k).step_by(n).fold(f64::NEG_INFINITY, |m, &x| m.max(x));
        }
    }
    fn sum(&self, values: &mut [f64]) {
        let (all, n) = (self.gather(values), values.len());
        for (k, v) in values.iter_mut().enumerate() {
            *v = all.iter().skip(k).step_by(n).sum();
        }
    }
    fn sum_counts(&self, values: &mut [u64]) {
        let mut numbers: Vec<f64> = values.iter().map(|&v| v as f64).collect();
        self.sum(&mut numbers);
        values.iter_mut().zip(numbers).for_each(|(v, n)| *v = n as u64);
    }
    fn counts_before(&self, values: &mut [u64]) {
        let own: Vec<f64> = values.iter().map(|&v| v as f64).collect();
        let before = &self.gather(&own)[..self.rank * own.len()];
        for (k, v) in values.iter_mut().enumerate() {
            *v = before.iter().skip(k).step_by(own.len()).sum::<f64>() as u64;
        }
    }
    fn gather(&self, values: &[f64]) -> Vec<f64> {
        self.all_to_all(&vec![values.to_vec(); self.size]).concat()
    }
}

/// Runs `job` on `size` ranks and returns their results in rank order.
pub fn on_ranks<R: Send>(size: usize, job: impl Fn(ThreadTransport) -> R + Sync) -> Vec<R> {
    let post: Post = Arc::default();
    std::thread::scope(|scope| {
        let ranks: Vec<_> = (0..size)
            .map(|rank| {
                let (transport, job) = (ThreadTransport { rank, size, post: post.clone() }, &job);
                scope.spawn(move || job(transport))
            })
            .collect();
        ranks.into_iter().map(|r| r.join().unwrap()).collect()
    })
}

/// Cells of a rank by the decomposition of the particles.
pub fn partition(grid: &Grid, ranks: [usize; 3], rank: usize) -> CellPartition {
    let corner = |end: bool| {
        std::array::from_fn(|a| {
            let nodes = grid.axis(a).nodes();
            nodes[if end { nodes.len() - 1 } else { 0 }]
        })
    };
    let periodic = std::array::from_fn(|a| grid.axis(a).is_periodic());
    let global = GlobalBox::new(corner(false), corner(true), periodic);
    let decomposition = Decomposition::new(global, ranks, rank, 1e-9).unwrap();
    CellPartition::new(grid, &decomposition).unwrap()
}

/// Own values with their global cells: pieces of one global array.
pub fn piece(values: &[f64], layout: grains_fluid::Layout, first: [usize; 3]) -> Vec<([usize; 3], f64)> {
    let [nx, ny, nz] = layout.cells;
    let mut out = Vec::new();
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                out.push(([i + first[0], j + first[1], k + first[2]], values[layout.row(j, k) + i]));
            }
        }
    }
    out
}

/// The pieces of all ranks in one order.
pub fn joined(pieces: Vec<Vec<([usize; 3], f64)>>) -> Vec<f64> {
    let mut all: Vec<_> = pieces.into_iter().flatten().collect();
    all.sort_by_key(|(cell, _)| [cell[2], cell[1], cell[0]]);
    all.into_iter().map(|(_, value)| value).collect()
}

/// Largest difference of two arrays.
pub fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |m, (x, y)| f64::max(m, (x - y).abs()))
}

/// Sets the own cells of a field by a function of the global cell.
pub fn set(field: &mut Field<Centre>, first: [usize; 3], value: impl Fn([usize; 3]) -> f64) {
    let layout = field.layout();
    let [nx, ny, nz] = layout.cells;
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let cell = [i + first[0], j + first[1], k + first[2]];
                field.set(i as isize, j as isize, k as isize, value(cell));
            }
        }
    }
}

/// Order of convergence from errors on two grids refined by `ratio`.
pub fn order(coarse: f64, fine: f64, ratio: f64) -> f64 {
    (coarse / fine).ln() / ratio.ln()
}
