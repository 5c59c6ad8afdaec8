//! Rows in the order of their values, shared out among all ranks.

use grains_domain::Transport;

/// Intervals of values for each rank, between which shares are cut.
const INTERVALS: usize = 64;

/// Rows of a table or points of a picture; longer ones are thinned out.
const MAX_ROWS: u64 = 10_000;

/// This rank's share of all rows in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Share<const N: usize> {
    /// Rows, each by its first value, then by its second.
    pub rows: Vec<[f64; N]>,
    /// Rows of the ranks before, which come before these (-).
    pub before: u64,
    /// Rows of all ranks (-).
    pub all: u64,
}

impl<const N: usize> Share<N> {
    /// Brings the rows of all ranks, whose values are finite, into order; collective.
    ///
    /// Ranks get about as many each if values are spread; no rank holds all.
    pub fn of(rows: &[[f64; N]], transport: &impl Transport) -> Self {
        let ranks = transport.size();
        let mut ends = [f64::NEG_INFINITY; 2];
        for row in rows {
            ends = [ends[0].max(-row[0]), ends[1].max(row[0])];
        }
        transport.max(&mut ends);
        let (low, intervals) = (-ends[0], INTERVALS * ranks);
        let per_value = intervals as f64 / (ends[1] - low);
        // Rises with the value, so that ranks follow one another.
        let interval = |row: &[f64; N]| (((row[0] - low) * per_value) as usize).min(intervals - 1);
        let mut counts = vec![0_u64; intervals];
        rows.iter().for_each(|row| counts[interval(row)] += 1);
        transport.sum_counts(&mut counts);
        let all: u64 = counts.iter().sum();
        let mut before = 0;
        let owners: Vec<usize> = counts
            .iter()
            .map(|count| {
                let middle = u128::from(2 * before + count) * ranks as u128 / u128::from(2 * all).max(1);
                before += count;
                (middle as usize).min(ranks - 1)
            })
            .collect();
        let mut sent: Vec<(usize, Vec<f64>)> = Vec::new();
        let mut sorted: Vec<&[f64; N]> = rows.iter().collect();
        sorted.sort_by_key(|row| interval(row));
        for row in sorted {
            let owner = owners[interval(row)];
            match sent.last_mut().filter(|(rank, _)| *rank == owner) {
                Some((_, message)) => message.extend(row),
                None => sent.push((owner, row.to_vec())),
            }
        }
        let received = transport.exchange_sparse(sent);
        let rows = received.iter().flat_map(|(_, message)| message.as_chunks().0);
        let mut rows: Vec<[f64; N]> = rows.copied().collect();
        rows.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        let mut before = [rows.len() as u64];
        transport.counts_before(&mut before);
        Self { rows, before: before[0], all }
    }

    /// One in so many rows of all ranks and the last of them, in order and on every rank: at most 10,001; collective.
    pub fn thinned(&self, transport: &impl Transport) -> Vec<[f64; N]> {
        let stride = self.all.div_ceil(MAX_ROWS).max(1);
        let is_kept = |place: u64| place.is_multiple_of(stride) || place + 1 == self.all;
        let kept = self.rows.iter().zip(self.before..).filter(|(_, place)| is_kept(*place));
        transport.gather(&kept.flat_map(|(row, _)| *row).collect::<Vec<_>>()).as_chunks().0.to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use grains_testing::on_ranks;

    #[test]
    fn shares_one_after_the_other_are_all_rows_in_order() {
        let height = |k: usize| match k % 3 {
            0 => (k as f64).sin(),
            1 => 0.25,
            _ => 1e3 * (k as f64 * 0.37).fract().powi(9),
        };
        for count in [0, 1, 2, 5, 3000] {
            let all: Vec<[f64; 3]> = (0..count).map(|k| [height(k), k as f64, 0.5 * k as f64]).collect();
            let mut wanted = all.clone();
            wanted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
            for ranks in [1, 2, 3, 7] {
                let shares = on_ranks(ranks, |transport| {
                    let own = all.iter().skip(transport.rank()).step_by(ranks).copied();
                    Share::of(&own.collect::<Vec<_>>(), &transport)
                });
                assert!(shares.iter().all(|share| share.all == count as u64));
                let mut found = Vec::new();
                for share in shares {
                    assert_eq!(share.before, found.len() as u64, "{count} rows on {ranks} ranks");
                    found.extend(share.rows);
                }
                assert_eq!(found, wanted, "{count} rows on {ranks} ranks");
            }
        }
    }

    #[test]
    fn long_tables_are_thinned_out_evenly_to_the_last_row() {
        for (count, stride) in [(0, 1), (1, 1), (9_999, 1), (10_000, 1), (10_001, 2), (35_000, 4)] {
            let all: Vec<[f64; 2]> = (0..count).map(|k| [(k as f64).sqrt(), k as f64]).collect();
            let mut wanted: Vec<[f64; 2]> = all.iter().copied().step_by(stride).collect();
            if wanted.last() != all.last() {
                wanted.push(all[count - 1]);
            }
            for ranks in [1, 3] {
                let found = on_ranks(ranks, |transport| {
                    let own = all.iter().rev().skip(transport.rank()).step_by(ranks).copied();
                    Share::of(&own.collect::<Vec<_>>(), &transport).thinned(&transport)
                });
                assert!(found.iter().all(|rows| *rows == wanted), "{count} rows on {ranks} ranks");
            }
        }
    }
}
