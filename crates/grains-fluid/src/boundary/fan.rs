//! Fans in front of pressure inlets.

/// Pressure rise of a fan over the flow it lets in, by straight lines between points; constant before the first, and as from the
/// last but one point beyond the last.
#[derive(Clone, Debug, PartialEq)]
pub struct FanCurve {
    points: Vec<[f64; 2]>,
}

impl FanCurve {
    /// The curve through points (m³/s, Pa).
    ///
    /// # Errors
    /// Fewer than two points, flows that do not ascend, and a pressure that rises with the flow: that would have several flows or
    /// none.
    pub fn new(points: Vec<[f64; 2]>) -> Result<Self, String> {
        if points.len() < 2 {
            return Err(format!("{} points: a curve has two and more", points.len()));
        }
        for (k, pair) in points.windows(2).enumerate() {
            let [[q0, p0], [q1, p1]] = [pair[0], pair[1]];
            if !(q0 < q1 && [q0, q1, p0, p1].iter().all(|x| x.is_finite())) {
                return Err(format!(
                    "flow {q1} m³/s of point {} must be above {q0}, that of the one before",
                    k + 1
                ));
            }
            if p1 > p0 {
                return Err(format!(
                    "pressure {p1} Pa of point {} is above {p0} Pa, that of the one before: a rise that grows with the flow has \
                     several flows or none; leave the stalled branch out",
                    k + 1
                ));
            }
        }
        Ok(Self { points })
    }

    /// Points of the curve (m³/s, Pa).
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// Pressure rise (Pa) at a flow (m³/s).
    pub fn rise(&self, flow: f64) -> f64 {
        let last = self.points.len() - 1;
        if flow <= self.points[0][0] {
            return self.points[0][1];
        }
        let next = self.points.iter().position(|point| flow < point[0]).unwrap_or(last);
        let [[q0, p0], [q1, p1]] = [self.points[next - 1], self.points[next]];
        p0 + (flow - q0) / (q1 - q0) * (p1 - p0)
    }

    /// The rise p (Pa) with p = rise(Q + G (p − p₀)): of a flow Q (m³/s) at the rise p₀ that grows by G ≥ 0 (m³/(s Pa)) with it.
    pub fn balance(&self, flow: f64, before: f64, gain: f64) -> f64 {
        // The difference of both sides grows with p, so the root lies between p₀ and the rise at Q.
        let wanted = self.rise(flow);
        let [mut low, mut high] = [before.min(wanted), before.max(wanted)];
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            match middle < self.rise(flow + gain * (middle - before)) {
                true => low = middle,
                false => high = middle,
            }
        }
        0.5 * (low + high)
    }
}
