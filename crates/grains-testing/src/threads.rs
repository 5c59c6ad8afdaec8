//! Ranks that are threads of one process.

#![allow(clippy::unwrap_used)] // a test that cannot go on ends

use grains_domain::Transport;
use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex};

/// Messages under way, by sender and receiver, and the news that there is another.
type Mailboxes = Arc<(Mutex<HashMap<(usize, usize), VecDeque<Vec<f64>>>>, Condvar)>;

/// A rank that is a thread of this process.
#[derive(Clone)]
pub struct ThreadTransport {
    rank: usize,
    size: usize,
    post: Mailboxes,
    /// Of reductions that are ended later than they are begun.
    reductions: Mailboxes,
}

impl ThreadTransport {
    fn send(&self, to: usize, message: Vec<f64>) {
        self.post_to(&self.post, to, message);
    }

    fn receive(&self, from: usize) -> Vec<f64> {
        self.take_from(&self.post, from)
    }

    fn post_to(&self, post: &Mailboxes, to: usize, message: Vec<f64>) {
        post.0.lock().unwrap().entry((self.rank, to)).or_default().push_back(message);
        post.1.notify_all();
    }

    fn take_from(&self, post: &Mailboxes, from: usize) -> Vec<f64> {
        let mut boxes = post.0.lock().unwrap();
        loop {
            if let Some(message) = boxes.get_mut(&(from, self.rank)).and_then(VecDeque::pop_front) {
                return message;
            }
            boxes = post.1.wait(boxes).unwrap();
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
        let sent = peers.iter().zip(sent).filter(|(_, message)| !message.is_empty());
        sent.for_each(|(&p, m)| self.send(p, m.clone()));
        for (&peer, buffer) in peers.iter().zip(received).filter(|(_, buffer)| !buffer.is_empty()) {
            let message = self.receive(peer);
            assert_eq!(message.len(), buffer.len(), "rank {} expects another length from {peer}", self.rank);
            *buffer = message;
        }
    }
    fn send_and_receive(
        &self,
        (receivers, sent): (&[usize], &[Vec<f64>]),
        (senders, received): (&[usize], &mut [Vec<f64>]),
    ) {
        receivers.iter().zip(sent).for_each(|(&rank, message)| self.send(rank, message.clone()));
        senders.iter().zip(received).for_each(|(&rank, buffer)| *buffer = self.receive(rank));
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
    fn begin_max(&self, values: &[f64]) {
        (0..self.size).for_each(|rank| self.post_to(&self.reductions, rank, values.to_vec()));
    }
    fn end_max(&self, values: &mut [f64]) {
        values.fill(f64::NEG_INFINITY);
        for rank in 0..self.size {
            let of_rank = self.take_from(&self.reductions, rank);
            values.iter_mut().zip(of_rank).for_each(|(v, x)| *v = v.max(x));
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
    let (post, reductions) = (Mailboxes::default(), Mailboxes::default());
    std::thread::scope(|scope| {
        let ranks: Vec<_> = (0..size)
            .map(|rank| {
                let (post, reductions) = (post.clone(), reductions.clone());
                let (transport, job) = (ThreadTransport { rank, size, post, reductions }, &job);
                scope.spawn(move || job(transport))
            })
            .collect();
        ranks.into_iter().map(|r| r.join().unwrap()).collect()
    })
}
