//! The depth of several contacts together: their norm of order eight.
//!
//! ```text
//! D = (Σ δ_i⁸)^(1/8),   w_i = ∂D/∂δ_i = (δ_i/D)⁷
//! ```
//!
//! A force F(D) shared out as w_i F is the gradient of the potential ∫F dD: it is continuous when contacts begin and
//! end, and conserves energy. One contact has D = δ; N equal ones have D = N^(1/8) δ, so that a linear spring is
//! N^(1/4) times as stiff as one. Square roots make the eighth root, the same on any machine.

/// The norm D of overlaps (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthNorm {
    /// D (m).
    pub depth: f64,
}

impl DepthNorm {
    /// Norm of overlaps (m); negative ones count as zero beside a positive one. Of gaps alone it is the smallest.
    #[inline]
    pub fn of(overlaps: impl Iterator<Item = f64> + Clone) -> Self {
        let deepest = overlaps.clone().fold(f64::NEG_INFINITY, f64::max);
        if deepest <= 0.0 {
            return Self { depth: deepest };
        }
        // Ratios to the deepest cannot underflow together.
        let sum: f64 = overlaps.map(|overlap| eighth_power(overlap.max(0.0) / deepest)).sum();
        Self { depth: deepest * sum.sqrt().sqrt().sqrt() }
    }

    /// Weight w = (δ/D)⁷ of one of the overlaps δ (m).
    #[inline]
    pub fn weight(&self, overlap: f64) -> f64 {
        if self.depth <= 0.0 {
            return if overlap == self.depth { 1.0 } else { 0.0 };
        }
        let ratio = overlap.max(0.0) / self.depth;
        let square = ratio * ratio;
        square * square * square * ratio
    }

    /// How many times as stiff as one contact `count` equal ones are together, N^(1/4).
    pub fn stiffening(count: usize) -> f64 {
        (count as f64).sqrt().sqrt()
    }
}

#[inline]
fn eighth_power(x: f64) -> f64 {
    let square = x * x;
    let fourth = square * square;
    fourth * fourth
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Irregular depths (m).
    fn depths(case: usize) -> Vec<f64> {
        let number = |k: usize| ((case * 13 + k) as f64 * 0.618_033_988_75).fract();
        (0..2 + case % 11).map(|k| 1e-9 + 1e-3 * number(k)).collect()
    }

    /// D is homogeneous, D = Σ w_i δ_i, and w_i is its derivative; a norm of norms is the norm of all.
    #[test]
    fn weights_are_the_gradient() {
        for depths in (0..100).map(depths) {
            let norm = DepthNorm::of(depths.iter().copied());
            let euler: f64 = depths.iter().map(|&d| norm.weight(d) * d).sum();
            assert!((euler / norm.depth - 1.0).abs() < 1e-13);
            let step = 1e-4 * norm.depth;
            for k in (0..depths.len()).filter(|&k| depths[k] > step) {
                let moved = |by: f64| {
                    let one = depths.iter().enumerate().map(|(l, &d)| if l == k { d + by } else { d });
                    DepthNorm::of(one).depth
                };
                let slope = (moved(step) - moved(-step)) / (2.0 * step);
                assert!((slope - norm.weight(depths[k])).abs() < 1e-6);
            }
            let (some, others) = depths.split_at(depths.len() / 2);
            let halves = [some, others].map(|d| DepthNorm::of(d.iter().copied()).depth);
            assert!((DepthNorm::of(halves.into_iter()).depth / norm.depth - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn one_contact_is_itself_and_equal_ones_stiffen() {
        assert_eq!(DepthNorm::of([0.3].into_iter()).depth, 0.3);
        assert_eq!(DepthNorm::of([0.3].into_iter()).weight(0.3), 1.0);
        let four = DepthNorm::of([0.2; 4].into_iter());
        let force: f64 = 4.0 * four.weight(0.2) * four.depth;
        assert!((force / 0.2 / DepthNorm::stiffening(4) - 1.0).abs() < 1e-14);
    }
}
