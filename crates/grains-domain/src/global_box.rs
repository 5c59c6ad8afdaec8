//! The box that holds all particles.

use crate::quantum::Quantum;

/// The box that holds all particles, with the periodicity of its axes.
#[derive(Clone, Debug, PartialEq)]
pub struct GlobalBox {
    /// Lower corner (m).
    pub lower: [f64; 3],
    /// Upper corner (m).
    pub upper: [f64; 3],
    /// Whether an axis is periodic.
    pub periodic: [bool; 3],
    /// Quantum of all positions (m).
    pub quantum: Quantum,
}

impl GlobalBox {
    /// Box between two corners (m), which are moved to the nearest multiples of the quantum.
    pub fn new(lower: [f64; 3], upper: [f64; 3], periodic: [bool; 3]) -> Self {
        // Images of particles lie up to one period outside the box.
        let reach =
            (0..3).map(|a| lower[a].abs().max(upper[a].abs()) + upper[a] - lower[a]).fold(0.0, f64::max);
        let quantum = Quantum::for_sums_below(reach);
        let snap = |corner: [f64; 3]| corner.map(|x| quantum.snap(x));
        Self { lower: snap(lower), upper: snap(upper), periodic, quantum }
    }

    /// Length of an axis (m).
    pub fn length(&self, axis: usize) -> f64 {
        self.upper[axis] - self.lower[axis]
    }

    /// Its eight corners (m).
    pub fn corners(&self) -> [[f64; 3]; 8] {
        std::array::from_fn(|k| {
            std::array::from_fn(|a| if k >> a & 1 == 0 { self.lower[a] } else { self.upper[a] })
        })
    }

    /// Position moved by whole periods into the box (m); exact.
    pub fn wrap(&self, position: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| if self.periodic[a] { self.wrap_along(a, position[a]) } else { position[a] })
    }

    /// Coordinate moved by whole periods into the box along a periodic axis (m); exact.
    ///
    /// One that is no number or absurdly far away stays where it is.
    pub fn wrap_along(&self, axis: usize, mut x: f64) -> f64 {
        const FAR: f64 = 1e3;
        let length = self.length(axis);
        if (x - self.lower[axis]).abs() > FAR * length {
            return x;
        }
        while x < self.lower[axis] {
            x += length;
        }
        while x >= self.upper[axis] {
            x -= length;
        }
        x
    }

    /// Whether a position lies in the half-open box.
    pub fn contains(&self, position: [f64; 3]) -> bool {
        (0..3).all(|a| position[a] >= self.lower[a] && position[a] < self.upper[a])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_period_is_added_exactly_and_separations_are_antisymmetric() {
        let global = GlobalBox::new([-0.3, 0.0, 0.0], [0.7, 0.11, 1e-3], [true, true, false]);
        for k in 0..1000 {
            let x = global.quantum.snap(-0.3 + 0.001 * k as f64 * 0.9991);
            let y = global.quantum.snap(0.69 - 0.0003 * k as f64);
            let length = global.length(0);
            assert_eq!((x + length) - length, x);
            assert_eq!((y - length) - x, -(x + length - y));
        }
        assert_eq!(global.wrap([0.7, -0.01, 5.0])[0], global.lower[0]);
    }

    #[test]
    fn wrapping_moves_by_whole_periods_and_ends_for_any_number() {
        let global = GlobalBox::new([-1.0, 0.0, 0.0], [1.0, 3.0, 1.0], [true, true, false]);
        assert_eq!(global.wrap([1.0, -0.5, 7.0]), [-1.0, 2.5, 7.0]);
        assert_eq!(global.wrap([-5.5, 6.25, 0.0]), [0.5, 0.25, 0.0]);
        assert_eq!(global.wrap([1e300, f64::INFINITY, 0.0]), [1e300, f64::INFINITY, 0.0]);
        assert!(global.wrap([f64::NAN; 3])[0].is_nan());
    }
}
