//! Ghosts of bodies on all ranks that they reach into.

use crate::body::RECORD;
use crate::{RigidBody, Subgrid};
use grains_domain::Transport;
use grains_geometry::Shape;
use std::ops::Range;

/// One passing-on of bodies along an axis, to the ranks below (0) and above (1).
#[derive(Clone, Debug)]
struct Hop {
    axis: usize,
    sent: [Vec<usize>; 2],
    /// Places of what came from below and above.
    received: [Range<usize>; 2],
}

/// How ghosts of bodies came to this rank, and the way back: along x, then y, then z, passed on from neighbour to
/// neighbour as far as they reach, periodic images included. Nothing depends on the number of ranks.
#[derive(Clone, Debug, Default)]
pub(crate) struct BodyGhosts {
    hops: Vec<Hop>,
}

impl BodyGhosts {
    /// Appends to the bodies that this rank owns the ghosts that reach into its cells or halo; collective.
    pub fn new(
        bodies: &mut Vec<RigidBody>,
        shapes: &[Shape],
        subgrid: &Subgrid,
        transport: &dyn Transport,
    ) -> Self {
        let mut hops = Vec::new();
        for axis in 0..3 {
            let [low, high] = subgrid.reach(axis);
            let leaving = |bodies: &[RigidBody], among: Range<usize>, side: usize| {
                let goes = |body: &RigidBody| {
                    let (at, radius) = (body.center[axis], body.radius(shapes));
                    if side == 0 { at - radius < low } else { at + radius > high }
                };
                let has_neighbour = subgrid.neighbours[axis][side].is_some();
                among.filter(|&k| has_neighbour && goes(&bodies[k])).collect::<Vec<usize>>()
            };
            let mut sent = [0, 1].map(|side| leaving(bodies, 0..bodies.len(), side));
            while transport.any(sent.iter().any(|s| !s.is_empty())) {
                let messages = [0, 1].map(|side| {
                    let mut message = Vec::with_capacity(RECORD * sent[side].len());
                    for &k in &sent[side] {
                        let mut body = bodies[k].clone();
                        body.center[axis] += subgrid.shifts[axis][side];
                        body.write(&mut message);
                    }
                    message
                });
                let arrived = subgrid.pass(axis, messages, transport);
                let received = arrived.map(|message| {
                    let first = bodies.len();
                    bodies.extend(message.chunks_exact(RECORD).map(RigidBody::read));
                    first..bodies.len()
                });
                // What came from above goes on downwards.
                let [below, above] = received.clone();
                let next = [leaving(bodies, above, 0), leaving(bodies, below, 1)];
                hops.push(Hop { axis, sent: std::mem::replace(&mut sent, next), received });
            }
        }
        Self { hops }
    }

    /// Adds the numbers of ghosts to those of their bodies; collective.
    pub fn gather<const N: usize>(
        &self,
        sums: &mut [[f64; N]],
        subgrid: &Subgrid,
        transport: &dyn Transport,
    ) {
        for hop in self.hops.iter().rev() {
            let messages = hop.received.clone().map(|places| sums[places].concat());
            let arrived = subgrid.pass(hop.axis, messages, transport);
            for (places, message) in hop.sent.iter().zip(arrived) {
                for (&place, sum) in places.iter().zip(message.chunks_exact(N)) {
                    sums[place].iter_mut().zip(sum).for_each(|(to, from)| *to += from);
                }
            }
        }
    }

    /// Gives ghosts the numbers of their bodies; collective.
    pub fn scatter<const N: usize>(
        &self,
        values: &mut [[f64; N]],
        subgrid: &Subgrid,
        transport: &dyn Transport,
    ) {
        for hop in &self.hops {
            let messages = hop
                .sent
                .clone()
                .map(|places| places.iter().flat_map(|&place| values[place]).collect::<Vec<f64>>());
            let arrived = subgrid.pass(hop.axis, messages, transport);
            for (places, message) in hop.received.iter().zip(arrived) {
                for (place, value) in places.clone().zip(message.chunks_exact(N)) {
                    values[place].copy_from_slice(value);
                }
            }
        }
    }
}
