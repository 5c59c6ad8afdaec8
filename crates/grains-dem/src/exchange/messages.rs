//! The messages of one rank.

use super::link::Link;
use super::updates::{ExchangeStrategy, Traffic, Updates};
use crate::memory_use::heap_bytes;
use crate::particles::Image;
use crate::shear::SlidingImages;
use grains_domain::{Decomposition, Direction};
use grains_geometry::Vec3;

/// The messages of one rank.
#[derive(Debug)]
pub(crate) struct Exchange {
    pub(super) decomposition: Decomposition,
    pub(super) outlets: [bool; 6],
    /// Images that slide, and their offset (m), if they do.
    pub(super) sliding: Option<(SlidingImages, f64)>,
    pub(super) links: Vec<Link>,
    pub(super) own_rank: usize,
    /// Neighbour ranks other than the own one, ascending.
    pub(super) peers: Vec<usize>,
    pub(super) sent: Vec<Vec<f64>>,
    pub(super) received: Vec<Vec<f64>>,
    /// What keeps clones of other ranks' particles up to date.
    pub(super) updates: Updates,
    /// Per self link, the first clone it fills.
    pub(super) own_clones: Vec<(usize, usize)>,
    /// What one clone of this rank's own particles is told.
    pub(super) update: Vec<f64>,
    /// Numbers of the peers that take part in what is told within a step, and their ranks.
    pub(super) told: Vec<usize>,
    pub(super) told_ranks: Vec<usize>,
}

impl Exchange {
    /// Messages of a subdomain; particles may leave the box through the faces that are `outlets`.
    ///
    /// `are_apart` tells whether ranks rebuild their lists apart from each other.
    pub(crate) fn new(
        decomposition: &Decomposition,
        outlets: [bool; 6],
        strategy: ExchangeStrategy,
        are_apart: bool,
    ) -> Self {
        let own_rank = decomposition.rank_at(decomposition.coordinates);
        let links: Vec<Link> = Direction::all()
            .filter_map(|direction| {
                let (rank, shift) = decomposition.neighbour(direction)?;
                let shift = Vec3::from(shift);
                let image = Image { shift, sliding: None };
                Some(Link { direction, rank, image, at_rest: shift, sent: Vec::new() })
            })
            .collect();
        let mut peers: Vec<usize> = links.iter().map(|l| l.rank).filter(|&r| r != own_rank).collect();
        peers.sort_unstable();
        peers.dedup();
        let buffers = vec![Vec::new(); peers.len()];
        Self {
            decomposition: decomposition.clone(),
            outlets,
            sliding: None,
            links,
            own_rank,
            updates: Updates::new(&peers, strategy, are_apart),
            peers,
            sent: buffers.clone(),
            received: buffers,
            own_clones: Vec::new(),
            update: Vec::new(),
            told: Vec::new(),
            told_ranks: Vec::new(),
        }
    }

    /// Takes over borders that moved; neighbours stay who they are.
    pub(crate) fn divide(&mut self, decomposition: &Decomposition) {
        self.decomposition.cuts.clone_from(&decomposition.cuts);
    }

    /// Lets the images across the gradient of a shear slide, those above to an offset (m).
    pub(crate) fn slide(&mut self, images: &SlidingImages, offset: f64) {
        let (flow, gradient) = (images.shear.flow, images.shear.gradient);
        self.sliding = Some((*images, offset));
        for link in self.links.iter_mut().filter(|link| link.at_rest[gradient] != 0.0) {
            let side = link.at_rest[gradient].signum();
            link.image.shift[flow] = link.at_rest[flow] + side * offset;
            link.image.sliding = Some((flow, side * images.speed));
        }
    }

    /// What the updates of clones cost so far.
    pub(crate) fn traffic(&self) -> Traffic {
        self.updates.traffic
    }

    /// Memory (B) of messages.
    pub(crate) fn bytes(&self) -> usize {
        let links = self.links.iter().map(|link| heap_bytes(&link.sent)).sum::<usize>();
        links + self.sent.iter().chain(&self.received).map(heap_bytes).sum::<usize>() + self.updates.bytes()
    }

    /// Place of a rank among the peers.
    pub(crate) fn peer(&self, rank: usize) -> Option<usize> {
        self.peers.binary_search(&rank).ok()
    }

    /// Number of neighbour ranks.
    pub(crate) fn neighbours(&self) -> usize {
        self.peers.len()
    }

    /// Number of clones of this rank's particles, its own periodic images included.
    pub(crate) fn clones_sent(&self) -> usize {
        self.links.iter().map(|l| l.sent.len()).sum()
    }
}
