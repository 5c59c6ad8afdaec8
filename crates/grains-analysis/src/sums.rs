//! Sums over all particles whose bits depend neither on the order of the particles nor on the ranks.

use grains_domain::{Transport, sum_wide, sum_wide_before};

/// Bits below the largest term that still count: a sum of 2^40 terms stays within 127 bits.
const BITS: i32 = 86;

/// Sums per slot, over the terms of all ranks; `each` hands every term (slot, value) to the function it gets,
/// and is called twice.
///
/// Terms are cut to multiples of 2^-86 times a power of two above the largest term, and added as whole
/// numbers. A term that is not finite makes every sum NaN.
pub fn exact_sums(
    transport: &impl Transport,
    slots: usize,
    each: impl Fn(&mut dyn FnMut(usize, f64)),
) -> Vec<f64> {
    let mut largest = 0.0_f64;
    each(&mut |_, value| largest = larger(largest, value));
    let quantum = match Quantum::of(largest, transport) {
        Ok(quantum) => quantum,
        Err(sum) => return vec![sum; slots],
    };
    let mut sums = vec![0_i128; slots];
    each(&mut |slot, value| sums[slot] += quantum.whole(value));
    let mut sums: Vec<u128> = sums.into_iter().map(i128::cast_unsigned).collect();
    sum_wide(&mut sums, transport);
    sums.into_iter().map(|sum| quantum.real(sum.cast_signed())).collect()
}

/// For each value the sum of it and all before it, those of the ranks before included, with the exactness of [`exact_sums`].
pub fn running_sums(transport: &impl Transport, values: &[f64]) -> Vec<f64> {
    let quantum = match Quantum::of(values.iter().copied().fold(0.0, larger), transport) {
        Ok(quantum) => quantum,
        Err(sum) => return vec![sum; values.len()],
    };
    let mut before = [values.iter().map(|value| quantum.whole(*value)).sum::<i128>().cast_unsigned()];
    sum_wide_before(&mut before, transport);
    let mut sum = before[0].cast_signed();
    let running = values.iter().map(|value| {
        sum += quantum.whole(*value);
        quantum.real(sum)
    });
    running.collect()
}

/// The larger magnitude; infinity if one is not finite, as `max` would drop a NaN.
fn larger(largest: f64, value: f64) -> f64 {
    if value.is_finite() { largest.max(value.abs()) } else { f64::INFINITY }
}

/// What terms are counted in: a power of two, as two factors of its inverse, either of which could leave the range of f64 otherwise.
struct Quantum([f64; 2]);

impl Quantum {
    /// That of terms up to the largest of any rank; or what all sums are, if that is zero or not finite.
    fn of(largest: f64, transport: &impl Transport) -> Result<Self, f64> {
        let mut largest = [largest];
        transport.max(&mut largest);
        match largest[0] {
            0.0 => Err(0.0),
            f64::INFINITY => Err(f64::NAN),
            largest => {
                let shift = BITS - largest.log2().ceil() as i32;
                Ok(Self([2.0_f64.powi(shift / 2), 2.0_f64.powi(shift - shift / 2)]))
            }
        }
    }

    fn whole(&self, value: f64) -> i128 {
        (value * self.0[0] * self.0[1]) as i128
    }

    fn real(&self, whole: i128) -> f64 {
        whole as f64 / self.0[0] / self.0[1]
    }
}

/// The sum of one value per particle over all ranks, with the exactness of [`exact_sums`].
pub fn exact_sum(transport: &impl Transport, values: impl Iterator<Item = f64> + Clone) -> f64 {
    exact_sums(transport, 1, |add| values.clone().for_each(|value| add(0, value)))[0]
}

/// How often each slot is named, over all ranks.
pub fn counts(transport: &impl Transport, slots: usize, named: impl Iterator<Item = usize>) -> Vec<u64> {
    let mut counts = vec![0_u64; slots];
    named.for_each(|slot| counts[slot] += 1);
    transport.sum_counts(&mut counts);
    counts
}

#[cfg(test)]
mod tests {
    use super::*;
    use grains_domain::SerialTransport;

    #[test]
    fn sums_do_not_depend_on_the_order_and_cancel_exactly() {
        let mut values: Vec<f64> =
            (0..1000).map(|k| (f64::from(k)).sin() * 10.0_f64.powi(k % 20 - 10)).collect();
        let forward = exact_sum(&SerialTransport, values.iter().copied());
        values.reverse();
        assert_eq!(forward, exact_sum(&SerialTransport, values.iter().copied()));
        let plain: f64 = values.iter().sum();
        assert!((forward - plain).abs() < 1e-12 * plain.abs().max(1e9), "{forward} {plain}");
        let powers = [20, -50, 20].map(|k| 2.0_f64.powi(k));
        assert_eq!(exact_sum(&SerialTransport, [powers[0], powers[1], -powers[2]].into_iter()), powers[1]);
        assert_eq!(exact_sum(&SerialTransport, [-0.5, -1e-300].into_iter()), -0.5);
        assert_eq!(exact_sum(&SerialTransport, [1e-300, 2e-300].into_iter()), 3e-300);
        assert!(exact_sum(&SerialTransport, [1.0, f64::NAN, 2.0].into_iter()).is_nan());
        assert_eq!(exact_sum(&SerialTransport, std::iter::empty()), 0.0);
    }

    #[test]
    fn running_sums_do_not_depend_on_the_ranks_and_end_with_the_whole() {
        let values: Vec<f64> = (0..500).map(|k| f64::from(k).sin() * 10.0_f64.powi(k % 16 - 8)).collect();
        let alone = running_sums(&SerialTransport, &values);
        for (k, sum) in alone.iter().enumerate().step_by(37) {
            let plain: f64 = values[..=k].iter().sum();
            assert!((sum - plain).abs() < 1e-12 * plain.abs().max(1e8), "{k}: {sum} {plain}");
        }
        assert_eq!(alone[499], exact_sum(&SerialTransport, values.iter().copied()));
        for ranks in [2, 3, 8] {
            let parts = grains_testing::on_ranks(ranks, |transport| {
                let rank = transport.rank();
                running_sums(
                    &transport,
                    &values[500 * rank * rank / (ranks * ranks)..500 * (rank + 1).pow(2) / (ranks * ranks)],
                )
            });
            assert_eq!(parts.concat(), alone, "{ranks} ranks");
        }
    }

    #[test]
    fn slots_are_separate() {
        let terms = [(0, 1.5), (2, -2.0), (0, 0.25)];
        let sums =
            exact_sums(&SerialTransport, 3, |add| terms.iter().for_each(|&(slot, value)| add(slot, value)));
        assert_eq!(sums, [1.75, 0.0, -2.0]);
        assert_eq!(counts(&SerialTransport, 3, [2, 0, 2].into_iter()), [1, 0, 2]);
    }
}
