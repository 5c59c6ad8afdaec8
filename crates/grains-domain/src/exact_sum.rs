//! Sums of numbers of any size that have no order.

use crate::{Transport, sum_wide};
use std::ops::AddAssign;

/// Bits of a word below those of the one before.
const BITS: i32 = 80;
/// Exponents of what the words count: 2⁻³⁰, 2⁻¹¹⁰ and 2⁻¹⁹⁰.
const EXPONENTS: [i32; 3] = [-30, -30 - BITS, -30 - 2 * BITS];

/// A sum that is the same whatever the order of its terms, and on whichever ranks these are added: of multiples of 2⁻¹⁹⁰, to which terms
/// are cut.
///
/// It holds 2⁴⁶ terms of up to 2⁵⁰, and is exact for every term above 2⁻¹³⁷. With a term that is infinite or no number its total is none either.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExactSum {
    words: [i128; 3],
    /// Number of terms that are infinite or no numbers.
    not_finite: u64,
}

impl PartialEq for ExactSum {
    fn eq(&self, other: &Self) -> bool {
        (self.words(), self.not_finite) == (other.words(), other.not_finite)
    }
}

impl Eq for ExactSum {}

impl ExactSum {
    /// The sum, rounded once or twice in the same way for the same terms.
    pub fn total(&self) -> f64 {
        if self.not_finite > 0 {
            return f64::NAN;
        }
        let carried = self.carried();
        let of_word = |(word, exponent): (&i128, &i32)| *word as f64 * 2.0_f64.powi(*exponent);
        carried.words.iter().zip(&EXPONENTS).rev().map(of_word).fold(0.0, |sum, x| sum + x)
    }

    /// Adds a product, which is not rounded if both factors are above 2⁻⁴².
    pub fn add_product(&mut self, a: f64, b: f64) {
        let product = a * b;
        *self += product;
        *self += libm::fma(a, b, -product);
    }

    /// Adds another sum.
    pub fn add(&mut self, other: &Self) {
        let (own, other) = (self.carried(), other.carried());
        self.words = std::array::from_fn(|k| own.words[k].wrapping_add(other.words[k]));
        self.not_finite += other.not_finite;
    }

    /// The sum of finite terms as whole numbers, the same for the same terms.
    pub fn words(&self) -> [i128; 3] {
        self.carried().words
    }

    /// The sum of these words.
    pub fn from_words(words: [i128; 3]) -> Self {
        Self { words, not_finite: 0 }.carried()
    }

    /// The same sum, all words of which but the first are not negative and below 2⁸⁰.
    fn carried(&self) -> Self {
        let mut words = self.words;
        for k in [2, 1] {
            words[k - 1] = words[k - 1].wrapping_add(words[k] >> BITS);
            words[k] &= (1 << BITS) - 1;
        }
        Self { words, ..*self }
    }
}

impl AddAssign<f64> for ExactSum {
    #[inline]
    fn add_assign(&mut self, x: f64) {
        if !x.is_finite() {
            self.not_finite += 1;
            return;
        }
        let mut rest = x * 2.0_f64.powi(-EXPONENTS[0]);
        for word in &mut self.words {
            let whole = rest.trunc();
            *word = word.wrapping_add(whole as i128);
            rest = (rest - whole) * 2.0_f64.powi(BITS);
            if rest == 0.0 {
                return;
            }
        }
    }
}

impl From<f64> for ExactSum {
    fn from(x: f64) -> Self {
        let mut sum = Self::default();
        sum += x;
        sum
    }
}

/// Adds up sums over all ranks; collective.
pub fn sum_exact(sums: &mut [ExactSum], transport: &impl Transport) {
    let numbers = |sum: &ExactSum| {
        let [a, b, c] = sum.words().map(i128::cast_unsigned);
        [a, b, c, sum.not_finite.into()]
    };
    let mut all: Vec<u128> = sums.iter().flat_map(numbers).collect();
    sum_wide(&mut all, transport);
    for (sum, [a, b, c, not_finite]) in sums.iter_mut().zip(all.as_chunks::<4>().0) {
        let words = [a, b, c].map(|word| word.cast_signed());
        *sum = ExactSum { not_finite: *not_finite as u64, ..ExactSum::from_words(words) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SerialTransport;

    /// Terms of magnitudes from 1e-25 to 1e12, of both signs.
    fn terms() -> Vec<f64> {
        let mut state = 9_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..20_000).map(|_| (next() - 0.5) * 10.0_f64.powi((37.0 * next()) as i32 - 25)).collect()
    }

    fn sum<'a>(terms: impl Iterator<Item = &'a f64>) -> ExactSum {
        let mut sum = ExactSum::default();
        terms.for_each(|x| sum += *x);
        sum
    }

    #[test]
    fn sums_have_no_order_and_no_cuts() {
        let terms = terms();
        let whole = sum(terms.iter());
        assert_eq!(whole, sum(terms.iter().rev()));
        assert_ne!(whole, sum(terms[1..].iter()));
        for cut in [1, 777, 19_999] {
            let (front, back) = terms.split_at(cut);
            let mut joined = ExactSum::from_words(sum(front.iter()).words());
            joined.add(&sum(back.iter()));
            assert_eq!((joined, joined.total()), (whole, whole.total()));
        }
        let mut alone = [whole];
        sum_exact(&mut alone, &SerialTransport);
        assert_eq!(alone[0], whole);
    }

    #[test]
    fn sums_are_right_and_small_terms_are_not_lost() {
        // What is taken away again leaves the small ones.
        let terms = terms();
        let (large, small): (Vec<f64>, Vec<f64>) = terms.iter().partition(|x| x.abs() > 1e-10);
        let mut both = sum(terms.iter());
        large.iter().for_each(|x| both += -x);
        let plain: f64 = small.iter().sum();
        assert!((both.total() - plain).abs() < 1e-14 * small.iter().map(|x| x.abs()).sum::<f64>());
        let mut many = ExactSum::from(1e6);
        (0..1_000_000).for_each(|_| many += 0.1);
        assert!((many.total() - 1_100_000.0).abs() < 1e-9, "{}", many.total());
        assert_eq!(ExactSum::from(-3.25e-7).total(), -3.25e-7);
    }

    #[test]
    fn what_is_no_number_is_not_lost() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut terms = terms();
            terms[77] = bad;
            let (front, back) = terms.split_at(700);
            let mut joined = [sum(back.iter())];
            joined[0].add(&sum(front.iter()));
            sum_exact(&mut joined, &SerialTransport);
            assert!(joined[0].total().is_nan() && !sum(back.iter()).total().is_nan());
            let mut product = ExactSum::default();
            product.add_product(bad, 2.0);
            assert!(product.total().is_nan() && ExactSum::from(bad).total().is_nan());
        }
    }

    #[test]
    fn products_may_be_added_in_parts() {
        let terms: Vec<f64> =
            terms().iter().map(|x| (x * 2.0_f64.powi(60)).round() * 2.0_f64.powi(-60)).collect();
        let dt = 1.234_567e-6;
        for cut in [0, 5, 64, 200] {
            // Partial sums of few enough terms are exact, as flows of heat from a wall are.
            let small: Vec<f64> = terms.iter().copied().filter(|x| x.abs() < 1e-5).take(256).collect();
            let (front, back) = small.split_at(cut);
            let (mut whole, mut parts) = (ExactSum::default(), ExactSum::default());
            whole.add_product(dt, small.iter().sum());
            parts.add_product(dt, front.iter().sum());
            parts.add_product(dt, back.iter().sum());
            assert_eq!(whole, parts);
        }
    }
}
