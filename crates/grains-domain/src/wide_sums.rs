//! Sums over ranks of whole numbers of 128 bits.

use crate::Transport;

/// Sums over all ranks, modulo 2¹²⁸: signed numbers are given by their bits. Collective.
pub fn sum_wide(numbers: &mut [u128], transport: &impl Transport) {
    in_words(numbers, |words| transport.sum_counts(words));
}

/// Sums over the ranks before this one, modulo 2¹²⁸; collective.
pub fn sum_wide_before(numbers: &mut [u128], transport: &impl Transport) {
    in_words(numbers, |words| transport.counts_before(words));
}

/// Adds numbers up in words of 32 bits, none of which overflows in a sum over up to 2³² ranks.
fn in_words(numbers: &mut [u128], sum: impl FnOnce(&mut [u64])) {
    if numbers.is_empty() {
        return;
    }
    let split = |number: &u128| [0, 32, 64, 96].map(|at| u64::from((number >> at) as u32));
    let mut words: Vec<u64> = numbers.iter().flat_map(split).collect();
    sum(&mut words);
    for (number, words) in numbers.iter_mut().zip(words.as_chunks::<4>().0) {
        let add = |sum: u128, (k, &word): (usize, &u64)| sum.wrapping_add(u128::from(word) << (32 * k));
        *number = words.iter().enumerate().fold(0, add);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SerialTransport;

    #[test]
    fn words_carry_into_each_other_and_signs_come_back() {
        let given = [3_i128, -5, i128::MIN, i128::from(u64::MAX) << 17, -(1 << 96)];
        let mut alone = given.map(i128::cast_unsigned);
        sum_wide(&mut alone, &SerialTransport);
        assert_eq!(alone.map(u128::cast_signed), given);
        // As if a thousand ranks had the same.
        let mut of_many = given.map(i128::cast_unsigned);
        in_words(&mut of_many, |words| words.iter_mut().for_each(|word| *word *= 1000));
        assert_eq!(of_many.map(u128::cast_signed), given.map(|number| number.wrapping_mul(1000)));
        sum_wide_before(&mut of_many, &SerialTransport);
        assert_eq!(of_many, [0; 5]);
    }
}
