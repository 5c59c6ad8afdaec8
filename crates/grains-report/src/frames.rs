//! Which of the stored states a page holds.

/// The states to take, and of how many particles one is taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Numbers of the stored states, rising.
    pub states: Vec<usize>,
    /// One of so many particles is taken.
    pub one_of: usize,
}

/// States that are taken even if particles must be left out for it.
const FEW: usize = 8;
/// States beyond which a player does not become smoother.
const MANY: usize = 150;
/// Rows that are read at most (particles times states): a bound of the time that a page takes.
const ROWS: usize = 20_000_000;

/// `count` of `stored` states, evenly spaced, the first and the last among them.
pub fn evenly(stored: usize, count: usize) -> Vec<usize> {
    match count.min(stored) {
        0 => Vec::new(),
        1 => vec![stored - 1],
        count => (0..count).map(|k| (k * (stored - 1) + (count - 1) / 2) / (count - 1)).collect(),
    }
}

/// Chooses among states with so many particles each, so that at most `max` of all states are taken.
pub fn choose(particles: &[usize], max: usize) -> Choice {
    let total = |states: &[usize]| states.iter().map(|&k| particles[k]).sum::<usize>();
    let stored = particles.len();
    let fits = |count: &usize, limit: usize| total(&evenly(stored, *count)) <= limit;
    let min = FEW.min(stored);
    let count = (min..=MANY.min(stored)).rev().find(|count| fits(count, max.min(ROWS))).unwrap_or(min);
    let count = (2.min(stored)..=count).rev().find(|count| fits(count, ROWS)).unwrap_or(2.min(stored));
    let states = evenly(stored, count);
    let one_of = total(&states).div_ceil(max.max(1)).max(1);
    Choice { states, one_of }
}

/// Whether a particle is one of those that are taken; ids in a row are as likely as any.
pub fn is_taken(id: u64, one_of: usize) -> bool {
    // The golden ratio spreads ids evenly over all numbers.
    let spread = id.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
    one_of <= 1 || spread.is_multiple_of(one_of as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_evenly_spaced_and_hold_both_ends() {
        assert_eq!(evenly(5, 9), [0, 1, 2, 3, 4]);
        assert_eq!(evenly(101, 3), [0, 50, 100]);
        assert_eq!(evenly(4, 1), [3]);
        assert!(evenly(0, 7).is_empty());
    }

    #[test]
    fn fewer_states_are_taken_before_particles_are_left_out() {
        let all = choose(&[1000; 101], 1_000_000);
        assert_eq!((all.states.len(), all.one_of), (101, 1));
        let few = choose(&[100_000; 101], 1_000_000);
        assert_eq!((few.states.len(), few.one_of), (10, 1));
        let thinned = choose(&[1_000_000; 101], 1_000_000);
        assert_eq!((thinned.states.len(), thinned.one_of), (8, 8));
        let huge = choose(&[50_000_000; 101], 1_000_000);
        assert_eq!((huge.states.len(), huge.one_of), (2, 100));
        let empty = choose(&[], 1_000_000);
        assert_eq!((empty.states.len(), empty.one_of), (0, 1));
    }

    #[test]
    fn a_share_of_the_particles_is_taken() {
        for one_of in [1, 3, 8, 50] {
            let taken = (0..100_000).filter(|&id| is_taken(id, one_of)).count();
            let expected = 100_000 / one_of;
            assert!(taken.abs_diff(expected) <= expected / 10, "{taken} of 1 in {one_of}");
        }
    }
}
