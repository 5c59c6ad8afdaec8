//! The order in which contacts are worked off.

/// Place of a contact in the order of a step: a hash of what identifies it on any rank and in any image.
///
/// Two words of 53 bits, which a message of f64 carries exactly: two contacts agree with a chance of 1e-32.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Key(u64, u64);

impl Key {
    /// After every contact.
    pub(crate) const NONE: Key = Key(1 << 53, 0);

    /// Key of two particles, the one of lower identity first, and their parts.
    pub(crate) fn of_pair(ids: [u64; 2], parts: [u16; 2]) -> Self {
        Self::of([ids[0], ids[1], u64::from(parts[0]) << 16 | u64::from(parts[1]), 0])
    }

    /// Key of a particle's part and an element of a wall's surface, met through a periodic image.
    pub(crate) fn of_wall(id: u64, [wall, surface, part]: [u16; 3], element: u32, image: u8) -> Self {
        let place = u64::from(wall) << 32 | u64::from(surface) << 16 | u64::from(part);
        Self::of([id, place, u64::from(element), 1 + u64::from(image)])
    }

    fn of(words: [u64; 4]) -> Self {
        let chain = |seed: u64| words.iter().fold(seed, |hash, &word| mix(hash ^ word)) >> 11;
        Self(chain(0x243f_6a88_85a3_08d3), chain(0x1319_8a2e_0370_7344))
    }

    /// 53 bits of it.
    pub(crate) fn bits(self) -> u64 {
        self.0
    }

    /// The key as numbers of a message.
    pub(crate) fn numbers(self) -> [f64; 2] {
        [self.0 as f64, self.1 as f64]
    }

    /// The key written by [`Key::numbers`].
    pub(crate) fn from_numbers(numbers: [f64; 2]) -> Self {
        Self(numbers[0] as u64, numbers[1] as u64)
    }
}

/// Finaliser of SplitMix64 after a step of its sequence: a bijection that spreads every bit over all others.
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_differ_survive_a_message_and_come_before_none() {
        let mut keys: Vec<Key> = (0..100)
            .flat_map(|a| (a + 1..100).map(move |b| Key::of_pair([a, b], [0, 0])))
            .chain((0..100).map(|id| Key::of_wall(id, [0, 0, 0], 0, 13)))
            .chain((0..100).map(|part| Key::of_pair([0, 1], [1, part])))
            .collect();
        let count = keys.len();
        assert!(keys.iter().all(|&k| k < Key::NONE && Key::from_numbers(k.numbers()) == k));
        assert_eq!(Key::from_numbers(Key::NONE.numbers()), Key::NONE);
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), count);
    }
}
