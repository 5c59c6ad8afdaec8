//! What the solver asks of message passing; `grains-comm` answers with MPI.

/// Collective communication among the ranks of a job, all called by all ranks in the same order.
pub trait Transport {
    /// Own rank.
    fn rank(&self) -> usize;
    /// Number of ranks.
    fn size(&self) -> usize;
    /// Exchange with each peer a message whose length both know: `received[k]` arrives filled from `peers[k]`.
    fn exchange(&self, peers: &[usize], sent: &[Vec<f64>], received: &mut [Vec<f64>]);
    /// Exchange with each peer a message whose length only the sender knows; `received[k]` is resized.
    fn exchange_unsized(&self, peers: &[usize], sent: &[Vec<f64>], received: &mut [Vec<f64>]);
    /// Send `sent[r]` to every rank r and return what they sent here, in rank order.
    fn all_to_all(&self, sent: &[Vec<f64>]) -> Vec<Vec<f64>>;
    /// Highest level over the ranks.
    fn highest(&self, level: u8) -> u8;
    /// Whether the statement holds on any rank.
    fn any(&self, statement: bool) -> bool {
        self.highest(u8::from(statement)) > 0
    }
    /// Largest value over the ranks, per entry.
    fn max(&self, values: &mut [f64]);
    /// Sum over the ranks, per entry.
    fn sum(&self, values: &mut [f64]);
    /// Sum over the ranks, per entry.
    fn sum_counts(&self, values: &mut [u64]);
    /// The arrays of all ranks, in rank order, on every rank.
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
    fn exchange_unsized(&self, _: &[usize], _: &[Vec<f64>], _: &mut [Vec<f64>]) {}
    fn all_to_all(&self, sent: &[Vec<f64>]) -> Vec<Vec<f64>> {
        sent.to_vec()
    }
    fn highest(&self, level: u8) -> u8 {
        level
    }
    fn max(&self, _: &mut [f64]) {}
    fn sum(&self, _: &mut [f64]) {}
    fn sum_counts(&self, _: &mut [u64]) {}
    fn gather(&self, values: &[f64]) -> Vec<f64> {
        values.to_vec()
    }
}
