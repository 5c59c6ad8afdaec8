//! Quantised numbers that change little from state to state.

/// Range that numbers are quantised over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
}

impl Range {
    /// That of numbers, of which those that are not finite do not count; none is [0, 0].
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let finite = values.filter(|x| x.is_finite());
        let (min, max) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        if min <= max { Self { min, max } } else { Self { min: 0.0, max: 0.0 } }
    }

    /// A number as the nearest of `steps + 1` evenly spaced ones; what is not finite is the smallest.
    pub fn quantised(&self, value: f64, steps: u16) -> u16 {
        let width = self.max - self.min;
        let share = if width > 0.0 { (value - self.min) / width } else { 0.0 };
        // A cast takes what is no number for 0.
        (share.clamp(0.0, 1.0) * f64::from(steps)).round() as u16
    }
}

/// A number of 16 bits of each of many things over several states.
///
/// Each state holds what differs from the state before, the low bytes first, then the high bytes: what rests is a row of zeros.
#[derive(Debug)]
pub struct Channel {
    last: Vec<u16>,
    bytes: Vec<u8>,
}

impl Channel {
    /// That of a number of things, all 0 before the first state.
    pub fn new(things: usize) -> Self {
        Self { last: vec![0; things], bytes: Vec::new() }
    }

    /// Adds a state: the things that there are in it, and their numbers; one without a number keeps it.
    pub fn push(&mut self, state: impl Iterator<Item = (usize, Option<u16>)>) {
        let change = |(thing, value): (usize, Option<u16>)| {
            let value = value.unwrap_or(self.last[thing]);
            value.wrapping_sub(std::mem::replace(&mut self.last[thing], value))
        };
        let changes: Vec<u16> = state.map(change).collect();
        self.bytes.extend(changes.iter().map(|x| x.to_le_bytes()[0]));
        self.bytes.extend(changes.iter().map(|x| x.to_le_bytes()[1]));
    }

    /// All states.
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_the_sums_of_their_changes() {
        let states = [[Some(3), Some(65_535)], [Some(3), Some(2)], [None, Some(700)]];
        let mut channel = Channel::new(2);
        states.iter().for_each(|state| channel.push(state.iter().copied().enumerate()));
        let bytes = channel.into_bytes();
        let mut last = [0_u16; 2];
        let found = bytes.chunks(4).map(|state| {
            for (k, value) in last.iter_mut().enumerate() {
                *value = value.wrapping_add(u16::from_le_bytes([state[k], state[2 + k]]));
            }
            last
        });
        assert_eq!(found.collect::<Vec<_>>(), [[3, 65_535], [3, 2], [3, 700]]);
    }

    #[test]
    fn numbers_are_off_by_half_a_step_at_most() {
        let range = Range::of([-2.0, f64::NAN, 6.0, f64::INFINITY].into_iter());
        assert_eq!(range, Range { min: -2.0, max: 6.0 });
        for value in [-2.0, -1.234, 0.0, 5.999, 6.0] {
            let back = range.min + f64::from(range.quantised(value, 65_535)) / 65_535.0 * 8.0;
            assert!((back - value).abs() <= 4.0 / 65_535.0 + 1e-12, "{value} became {back}");
        }
        assert_eq!(range.quantised(f64::NAN, 255), 0);
        assert_eq!(Range::of([7.0].into_iter()).quantised(7.0, 255), 0);
    }
}
