//! Rounding to a binary lattice, on which sums and differences of f64 are exact.

/// The multiples of 2^k: rounding to them makes bounded sums exact and independent of their order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    spacing: f64,
    magic: f64,
}

impl Lattice {
    /// The finest lattice on which every |x| ≤ `limit` and every sum staying below `limit` is exact.
    ///
    /// `limit` is in the unit of the quantity; it must be positive and finite.
    pub fn for_sums_below(limit: f64) -> Self {
        assert!(limit > 0.0 && limit.is_finite(), "a lattice needs a positive, finite limit, not {limit}");
        let mut top = 1.0_f64;
        while top < limit {
            top *= 2.0;
        }
        while top * 0.5 >= limit {
            top *= 0.5;
        }
        let spacing = top / 2.0_f64.powi(53);
        // Between 2^52 and 2^53 spacings f64 resolves one spacing, so adding this constant rounds.
        Self { spacing, magic: 1.5 * 2.0_f64.powi(52) * spacing }
    }

    /// Distance of two lattice points.
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Nearest lattice point of `x`, ties to even, for |x| below a quarter of the limit.
    ///
    /// Rounding is odd, round(−x) = −round(x), so action and reaction stay opposite.
    #[inline(always)]
    pub fn round(&self, x: f64) -> f64 {
        (x + self.magic) - self.magic
    }

    /// Nearest lattice point of `x` for any |x| below the limit (slower than [`Lattice::round`]).
    pub fn snap(&self, x: f64) -> f64 {
        (x / self.spacing).round() * self.spacing
    }
}

/// The box that holds all particles, with the periodicity of its axes.
#[derive(Clone, Debug, PartialEq)]
pub struct GlobalBox {
    /// Lower corner (m).
    pub lower: [f64; 3],
    /// Upper corner (m).
    pub upper: [f64; 3],
    /// Whether an axis is periodic.
    pub periodic: [bool; 3],
    /// Lattice of all positions (m).
    pub lattice: Lattice,
}

impl GlobalBox {
    /// Box between two corners (m), which are moved to the nearest lattice points.
    pub fn new(lower: [f64; 3], upper: [f64; 3], periodic: [bool; 3]) -> Self {
        // Images of particles lie up to one period outside the box.
        let reach =
            (0..3).map(|a| lower[a].abs().max(upper[a].abs()) + upper[a] - lower[a]).fold(0.0, f64::max);
        let lattice = Lattice::for_sums_below(reach);
        let snap = |corner: [f64; 3]| corner.map(|x| lattice.snap(x));
        Self { lower: snap(lower), upper: snap(upper), periodic, lattice }
    }

    /// Length of an axis (m).
    pub fn length(&self, axis: usize) -> f64 {
        self.upper[axis] - self.lower[axis]
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
    fn sums_of_rounded_numbers_do_not_depend_on_their_order() {
        let lattice = Lattice::for_sums_below(1000.0);
        let terms: Vec<f64> = (0..500)
            .map(|k| lattice.round((k as f64 * 0.7321).sin() * (k as f64 * 0.031).exp2().fract()))
            .collect();
        let forward: f64 = terms.iter().sum();
        let backward: f64 = terms.iter().rev().sum();
        let interleaved: f64 = (0..500).map(|k| terms[(k * 37) % 500]).sum();
        assert!(forward == backward && forward == interleaved && forward != 0.0);
        assert_eq!(lattice.round(-0.123), -lattice.round(0.123));
    }

    #[test]
    fn a_period_is_added_exactly_and_separations_are_antisymmetric() {
        let global = GlobalBox::new([-0.3, 0.0, 0.0], [0.7, 0.11, 1e-3], [true, true, false]);
        for k in 0..1000 {
            let x = global.lattice.snap(-0.3 + 0.001 * k as f64 * 0.9991);
            let y = global.lattice.snap(0.69 - 0.0003 * k as f64);
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
