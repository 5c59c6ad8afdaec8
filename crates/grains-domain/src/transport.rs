//! What the solver asks of message passing; `grains-comm` answers with MPI.

use std::any::Any;

/// Messages of fixed lengths between a rank and some peers, exchanged again and again.
///
/// Buffers stay where they are, so that a transport may prepare its requests once.
#[derive(Debug, Default)]
pub struct Channel {
    /// What a transport has prepared; dropped before the buffers it may point to.
    prepared: Option<Box<dyn Any>>,
    peers: Vec<usize>,
    sent: Vec<Vec<f64>>,
    received: Vec<Vec<f64>>,
    is_open: bool,
}

impl Channel {
    /// Channel to `peers` with the numbers of f64 sent to and received from each.
    pub fn new(peers: &[usize], sent: &[usize], received: &[usize]) -> Self {
        let buffers = |lengths: &[usize]| lengths.iter().map(|&n| vec![0.0; n]).collect();
        let (sent, received) = (buffers(sent), buffers(received));
        Self { prepared: None, peers: peers.to_vec(), sent, received, is_open: false }
    }

    /// The message to peer `k`, to be filled; not between [`Transport::start`] and [`Transport::finish`].
    pub fn outgoing(&mut self, k: usize) -> &mut [f64] {
        assert!(!self.is_open, "messages on their way must not change");
        &mut self.sent[k]
    }

    /// The message from peer `k`, after [`Transport::finish`].
    pub fn incoming(&self, k: usize) -> &[f64] {
        assert!(!self.is_open, "messages have not arrived");
        &self.received[k]
    }

    /// Number of f64 sent in one exchange.
    pub fn numbers_sent(&self) -> usize {
        self.sent.iter().map(Vec::len).sum()
    }

    /// Number of f64 of all messages.
    pub fn numbers_held(&self) -> usize {
        self.numbers_sent() + self.received.iter().map(Vec::len).sum::<usize>()
    }

    /// Messages sent in one exchange: empty ones are left out.
    pub fn messages_sent(&self) -> usize {
        self.sent.iter().filter(|message| !message.is_empty()).count()
    }

    /// For a transport: marks the messages as being on their way, or as arrived.
    pub fn set_open(&mut self, is_open: bool) {
        assert_ne!(self.is_open, is_open, "start and finish take turns");
        self.is_open = is_open;
    }

    /// For a transport: what it needs to exchange the messages.
    ///
    /// What it prepares is dropped before the buffers, which nobody resizes.
    pub fn parts(&mut self) -> ChannelParts<'_> {
        let Self { prepared, peers, sent, received, .. } = self;
        ChannelParts { peers, sent, received, prepared }
    }
}

/// What a transport sees of a channel; it must leave the buffers where they are, and as long as they are.
#[derive(Debug)]
pub struct ChannelParts<'a> {
    /// The ranks at the other ends.
    pub peers: &'a [usize],
    /// Messages to them.
    pub sent: &'a [Vec<f64>],
    /// Messages from them.
    pub received: &'a mut [Vec<f64>],
    /// What the transport prepared for these buffers.
    pub prepared: &'a mut Option<Box<dyn Any>>,
}

/// Collective communication among the ranks of a job, all called by all ranks in the same order.
pub trait Transport {
    /// Own rank.
    fn rank(&self) -> usize;
    /// Number of ranks.
    fn size(&self) -> usize;
    /// Exchange with each peer a message whose length both know: `received[k]` arrives filled from `peers[k]`. Empty messages
    /// do not travel; ranks with none need not call.
    fn exchange(&self, peers: &[usize], sent: &[Vec<f64>], received: &mut [Vec<f64>]);
    /// Prepares the exchanges of a channel.
    fn prepare(&self, _: &mut Channel) {}
    /// Sends the messages of a channel on their way; all ranks between which it is do so.
    fn start(&self, channel: &mut Channel) {
        channel.set_open(true);
    }
    /// The same, where receivers need no more than the first `length` numbers of each message sent here.
    fn start_heads(&self, channel: &mut Channel, _length: usize) {
        self.start(channel);
    }
    /// Lets the messages of a channel that are on their way go on, without waiting for them.
    fn advance(&self, _: &mut Channel) {}
    /// Waits until the messages of a channel have arrived.
    fn finish(&self, channel: &mut Channel) {
        let ChannelParts { peers, sent, received, .. } = channel.parts();
        self.exchange(peers, sent, received);
        channel.set_open(false);
    }
    /// Sends one message, of a length that only the sender knows, to all `peers` and receives theirs; peers are mutual and
    /// stay the same in all calls.
    fn gather_near(&self, peers: &[usize], own: &[f64], received: &mut [Vec<f64>]) {
        self.exchange_unsized(peers, &vec![own.to_vec(); peers.len()], received);
    }
    /// Exchange with each peer a message whose length only the sender knows; `received[k]` is resized.
    fn exchange_unsized(&self, peers: &[usize], sent: &[Vec<f64>], received: &mut [Vec<f64>]) {
        self.send_and_receive((peers, sent), (peers, received));
    }
    /// Sends messages to some ranks, and receives from others ones whose length only the sender knows; both sides know that they
    /// come.
    fn send_and_receive(&self, to: (&[usize], &[Vec<f64>]), from: (&[usize], &mut [Vec<f64>]));
    /// Send messages to some ranks, at most one to each, as (rank, message), and return those sent here by rank of the
    /// sender. Nobody need know who sends to whom, and nothing grows with the number of ranks; empty messages do not
    /// travel.
    fn exchange_sparse(&self, sent: Vec<(usize, Vec<f64>)>) -> Vec<(usize, Vec<f64>)>;
    /// Highest level over the ranks.
    fn highest(&self, level: u8) -> u8;
    /// Whether the statement holds on any rank.
    fn any(&self, statement: bool) -> bool {
        self.highest(u8::from(statement)) > 0
    }
    /// Largest value over the ranks, per entry.
    fn max(&self, values: &mut [f64]);
    /// Begins [`Transport::max`] without waiting for any rank; [`Transport::end_max`] ends what was begun first.
    fn begin_max(&self, values: &[f64]);
    /// Largest values over the ranks, per entry, of the earliest [`Transport::begin_max`] that has not been ended.
    fn end_max(&self, values: &mut [f64]);
    /// Sum over the ranks, per entry.
    fn sum(&self, values: &mut [f64]);
    /// Sum over the ranks, per entry.
    fn sum_counts(&self, values: &mut [u64]);
    /// Sum over the ranks before this one, per entry.
    fn counts_before(&self, values: &mut [u64]);
    /// The lowest rank on which the statement holds.
    fn first_rank_with(&self, statement: bool) -> Option<usize> {
        let mut lowest = [if statement { -(self.rank() as f64) } else { f64::NEG_INFINITY }];
        self.max(&mut lowest);
        lowest[0].is_finite().then_some(-lowest[0] as usize)
    }
    /// The arrays of all ranks, in rank order, on every rank: for what every rank must hold as a whole.
    fn gather(&self, values: &[f64]) -> Vec<f64>;
}

/// The single rank of a job without MPI.
#[derive(Clone, Copy, Debug, Default)]
pub struct SerialTransport;

impl Transport for SerialTransport {
    fn rank(&self) -> usize {
        0
    }
    fn size(&self) -> usize {
        1
    }
    fn exchange(&self, _: &[usize], _: &[Vec<f64>], _: &mut [Vec<f64>]) {}
    fn send_and_receive(&self, _: (&[usize], &[Vec<f64>]), _: (&[usize], &mut [Vec<f64>])) {}
    fn exchange_sparse(&self, mut sent: Vec<(usize, Vec<f64>)>) -> Vec<(usize, Vec<f64>)> {
        sent.retain(|(_, message)| !message.is_empty());
        sent
    }
    fn highest(&self, level: u8) -> u8 {
        level
    }
    fn max(&self, _: &mut [f64]) {}
    fn begin_max(&self, _: &[f64]) {}
    /// The values of one rank are the largest: the caller holds them.
    fn end_max(&self, _: &mut [f64]) {}
    fn sum(&self, _: &mut [f64]) {}
    fn sum_counts(&self, _: &mut [u64]) {}
    fn counts_before(&self, values: &mut [u64]) {
        values.fill(0);
    }
    fn gather(&self, values: &[f64]) -> Vec<f64> {
        values.to_vec()
    }
}
