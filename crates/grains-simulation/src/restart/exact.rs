//! Exact sums in a checkpoint, beside their totals.

use grains_domain::ExactSum;

/// The words of sums.
pub fn exact_words(sums: &[ExactSum]) -> String {
    let words = sums.iter().flat_map(ExactSum::words);
    words.map(|word| word.to_string()).collect::<Vec<_>>().join(" ")
}

/// Sums of given totals, by their words where these are known and have such totals.
pub fn exact_sums(totals: &[f64], words: &str) -> Vec<ExactSum> {
    let words: Vec<i128> = words.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let of_words = |k: usize| words.as_chunks().0.get(k).map(|words| ExactSum::from_words(*words));
    let of = |(k, total): (usize, &f64)| {
        of_words(k).filter(|sum| sum.total() == *total).unwrap_or_else(|| ExactSum::from(*total))
    };
    totals.iter().enumerate().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_come_back_by_their_words_or_by_their_totals() {
        let mut sum = ExactSum::from(1e6);
        (0..10).for_each(|_| sum += 1e-25);
        let sums = [sum, ExactSum::from(-0.1), ExactSum::default()];
        let totals = sums.map(|sum| sum.total());
        assert_eq!(exact_sums(&totals, &exact_words(&sums)), sums);
        let by_total = totals.map(ExactSum::from);
        assert_ne!(by_total[0], sums[0]);
        for text in ["", "1 2", "1 2 3 4 5 6 7 8 9", "not a number"] {
            assert_eq!(exact_sums(&totals, text), by_total, "{text}");
        }
    }
}
