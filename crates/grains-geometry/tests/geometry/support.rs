//! Helpers of the tests.
use grains_geometry::{Rotation, Vec3};

/// Reproducible numbers (xorshift).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// In [low, high).
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Components in [-1, 1).
    pub fn vector(&mut self) -> Vec3 {
        Vec3::from_fn(|_, _| self.range(-1.0, 1.0))
    }

    /// On the unit sphere.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vector();
            if v.norm() > 0.1 && v.norm() < 1.0 {
                return v.normalize();
            }
        }
    }

    pub fn rotation(&mut self) -> Rotation {
        Rotation::from_scaled_axis(self.direction() * self.range(0.0, std::f64::consts::PI))
    }

    /// Index below n.
    pub fn index(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }
}

/// Asserts |a - b| <= tolerance |b|.
#[track_caller]
pub fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs(), "{a:e} differs from {b:e} by more than {tolerance:e}");
}
