//! The strategies that tell of all buffer particles, whoever needs them.

use super::link::Link;
use super::updates::{ExchangeStrategy, LONGEST_UPDATE, Updates, fill, take};
use crate::particles::{Image, Particles};
use grains_domain::Transport;

impl Updates {
    /// Tells of all buffer particles and picks what concerns own clones; a message begins with its length.
    pub(super) fn gather(&mut self, links: &[Link], particles: &mut Particles, transport: &impl Transport) {
        self.own[0] = self.own.len() as f64;
        fill(&mut self.own[1..], self.length, particles, self.buffer.iter().map(|&i| (i, Image::default())));
        let mut receivers = self.peers.len();
        match self.strategy {
            ExchangeStrategy::AllGatherGlobal => {
                receivers = transport.size() - 1;
                let mut all = Vec::new();
                self.timed(|u| all = transport.gather(&u.own));
                let (mut rest, mut rank) = (&all[..], 0);
                while let Some(&length) = rest.first() {
                    let (message, after) = rest.split_at(length as usize);
                    if let Ok(k) = self.peers.binary_search(&rank) {
                        self.pick(k, message, links, particles);
                    }
                    (rest, rank) = (after, rank + 1);
                }
            }
            ExchangeStrategy::AllGatherLocal => {
                self.timed(|u| transport.gather_near(&u.peers, &u.own, &mut u.received));
            }
            _ => {
                let Self { sent, own, .. } = self;
                sent.iter_mut().for_each(|message| message.clone_from(own));
                self.timed(|u| transport.exchange_unsized(&u.peers, &u.sent, &mut u.received));
            }
        }
        self.count(receivers, receivers * self.own.len());
        if self.strategy != ExchangeStrategy::AllGatherGlobal {
            (0..self.peers.len()).for_each(|k| self.pick(k, &self.received[k], links, particles));
        }
    }

    /// Takes the updates of the clones of peer `k` out of those of all its buffer particles.
    fn pick(&self, k: usize, message: &[f64], links: &[Link], particles: &mut Particles) {
        for (origin, clone) in self.origins[k].iter().zip(self.filled[k].clone()) {
            let at = 1 + origin.slot as usize * self.length;
            let mut record = [0.0; LONGEST_UPDATE];
            record[..self.length].copy_from_slice(&message[at..at + self.length]);
            let image = links[origin.link as usize].image.opposite();
            (0..3).for_each(|a| record[a] += image.shift[a]);
            if let Some((axis, speed)) = image.sliding {
                record[3 + axis] += speed;
            }
            take(particles, clone, &record[..self.length]);
        }
    }
}
