//! Rounding to multiples of a power of two, of which sums and differences in f64 are exact.

/// A power of two: bounded sums of its multiples are exact, and independent of their order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantum {
    size: f64,
    magic: f64,
}

impl Quantum {
    /// The smallest quantum of which every multiple |x| ≤ `limit` and every sum below `limit` is exact.
    ///
    /// `limit` is in the unit of the quantity; it must be positive and finite.
    pub fn for_sums_below(limit: f64) -> Self {
        assert!(limit > 0.0 && limit.is_finite(), "a quantum needs a positive, finite limit, not {limit}");
        let mut top = 1.0_f64;
        while top < limit {
            top *= 2.0;
        }
        while top * 0.5 >= limit {
            top *= 0.5;
        }
        let size = top / 2.0_f64.powi(53);
        // Between 2^52 and 2^53 quanta f64 resolves one quantum, so adding this constant rounds.
        Self { size, magic: 1.5 * 2.0_f64.powi(52) * size }
    }

    /// Its size, in the unit of the quantity.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Nearest multiple to `x`, ties to even, for |x| below a quarter of the limit.
    ///
    /// Rounding is odd, round(−x) = −round(x), so action and reaction stay opposite.
    #[inline(always)]
    pub fn round(&self, x: f64) -> f64 {
        (x + self.magic) - self.magic
    }

    /// Nearest multiple to `x` for any |x| below the limit (slower than [`Quantum::round`]).
    pub fn snap(&self, x: f64) -> f64 {
        (x / self.size).round() * self.size
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_rounded_numbers_do_not_depend_on_their_order() {
        let quantum = Quantum::for_sums_below(1000.0);
        let terms: Vec<f64> = (0..500)
            .map(|k| quantum.round((k as f64 * 0.7321).sin() * (k as f64 * 0.031).exp2().fract()))
            .collect();
        let forward: f64 = terms.iter().sum();
        let backward: f64 = terms.iter().rev().sum();
        let interleaved: f64 = (0..500).map(|k| terms[(k * 37) % 500]).sum();
        assert!(forward == backward && forward == interleaved && forward != 0.0);
        assert_eq!(quantum.round(-0.123), -quantum.round(0.123));
    }
}
