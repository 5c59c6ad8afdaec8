//! Where a row of cells meets a convex part.

use super::bounds::Bounded;
use grains_geometry::Vec3;

/// The middles of a row of cells in the frame of a part: `start + k step`.
pub struct Line {
    pub start: Vec3,
    pub step: Vec3,
}

impl Line {
    /// First and last cell, of the first `count`, that lie in a convex part.
    pub fn inside(&self, bounded: &Bounded, count: usize) -> Option<(usize, usize)> {
        let (low, high) = self.candidates(bounded, count)?;
        let is_in = |k: usize| bounded.part.contains(&(self.start + self.step * k as f64));
        let (low_in, high_in) = (is_in(low), is_in(high));
        let within = match (low_in, high_in) {
            (true, _) => low,
            (_, true) => high,
            _ => Self::search(low, high, is_in)?,
        };
        let bisect = |mut inside: usize, mut outside: usize| {
            while inside.abs_diff(outside) > 1 {
                let middle = (inside + outside) / 2;
                *(if is_in(middle) { &mut inside } else { &mut outside }) = middle;
            }
            inside
        };
        let first = if low_in { low } else { bisect(within, low) };
        let last = if high_in { high } else { bisect(within, high) };
        Some((first, last))
    }

    /// Cells in the box and the ball about the part.
    fn candidates(&self, bounded: &Bounded, count: usize) -> Option<(usize, usize)> {
        let squared = self.step.norm_squared();
        let nearest = -self.start.dot(&self.step) / squared;
        let gap = (self.start + self.step * nearest).norm_squared();
        let radius = bounded.radius;
        let half = ((radius * radius - gap) / squared).max(-1.0);
        if half < 0.0 {
            return None;
        }
        let (mut low, mut high) = (nearest - half.sqrt(), nearest + half.sqrt());
        for a in 0..3 {
            let (half_extent, s, d) = (bounded.half_extents[a], self.start[a], self.step[a]);
            // A row almost along the box: it is inside all along or not at all.
            if d.abs() * count as f64 <= 1e-12 * half_extent {
                if s.abs() > half_extent * (1.0 + 1e-9) {
                    return None;
                }
            } else {
                let (one, other) = ((-half_extent - s) / d, (half_extent - s) / d);
                (low, high) = (low.max(one.min(other)), high.min(one.max(other)));
            }
        }
        let (low, high) = ((low - 1e-6).ceil().max(0.0), (high + 1e-6).floor().min(count as f64 - 1.0));
        (low <= high).then_some((low as usize, high as usize))
    }

    /// A cell inside between two outside: long intervals are met soon, and none is missed.
    pub fn search(low: usize, high: usize, is_in: impl Fn(usize) -> bool) -> Option<usize> {
        let mut stride = (high - low).next_power_of_two();
        while stride > 1 {
            let half = stride / 2;
            if let Some(k) = (low + half..high).step_by(stride).find(|&k| is_in(k)) {
                return Some(k);
            }
            stride = half;
        }
        None
    }
}
