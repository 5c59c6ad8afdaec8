//! Tridiagonal lines in parts, or closed into a ring.
//!
//! Each part is solved with zero beyond its ends; the true solution is x = y − v x₋ − w x₊, with the values x₋, x₊ just
//! before and after the part, and v, w the influence vectors of unit values there. First and last values of all parts give x₋ and
//! x₊ of each: exact. Parts are joined one after the other, and the last to the first.

/// First and last value of the influence vectors v and w of a part, which are subtracted.
type Influence = [[f64; 2]; 2];

/// Where a part is joined to those before it.
#[derive(Clone, Copy, Debug, Default)]
struct Joint {
    /// w of the parts before at their last value, and v of the part at its first.
    meeting: [f64; 2],
    /// w of the parts before at their first value, and v of the part at its last.
    beyond: [f64; 2],
    scale: f64,
    /// Last value before the joint and first after it per unit value before all joined parts and after them (subtracted).
    last: [f64; 2],
    first: [f64; 2],
}

/// What the parts of a line make of one another, whatever the right-hand side.
#[derive(Clone, Debug, Default)]
pub(crate) struct Couplings {
    joints: Vec<Joint>,
    /// First and last value of the closed line from those of its joined parts.
    closing: [[f64; 2]; 2],
    /// Last value before each joint and first after it, with zeros around the joined parts.
    at_joints: Vec<[f64; 2]>,
}

impl Couplings {
    /// Joins so many parts; where a line ends, the influence of what is beyond is zero.
    pub fn join(&mut self, parts: usize, influence: impl Fn(usize) -> Influence) {
        self.joints.clear();
        let [mut v, mut w] = influence(0);
        for part in 1..parts {
            let [next_v, next_w] = influence(part);
            let scale = 1.0 / (1.0 - w[1] * next_v[0]);
            let joint = Joint {
                meeting: [w[1], next_v[0]],
                beyond: [w[0], next_v[1]],
                scale,
                last: [scale * v[1], -scale * w[1] * next_w[0]],
                first: [-scale * next_v[0] * v[1], scale * next_w[0]],
            };
            self.joints.push(joint);
            (v, w) = (
                [v[0] - w[0] * joint.first[0], -next_v[1] * joint.last[0]],
                [-w[0] * joint.first[1], next_w[1] - next_v[1] * joint.last[1]],
            );
        }
        let det = (1.0 + w[0]) * (1.0 + v[1]) - v[0] * w[1];
        self.closing = [[(1.0 + v[1]) / det, -v[0] / det], [-w[1] / det, (1.0 + w[0]) / det]];
    }

    /// Hands the values before and after every part to `put`, from first and last values `y` of the parts.
    pub fn solve(&mut self, y: impl Fn(usize) -> [f64; 2], mut put: impl FnMut(usize, [f64; 2])) {
        self.at_joints.clear();
        let mut joined = y(0);
        for (k, joint) in self.joints.iter().enumerate() {
            let part = y(k + 1);
            let last = joint.scale * (joined[1] - joint.meeting[0] * part[0]);
            let first = joint.scale * (part[0] - joint.meeting[1] * joined[1]);
            self.at_joints.push([last, first]);
            joined = [joined[0] - joint.beyond[0] * first, part[1] - joint.beyond[1] * last];
        }
        let [of_first, of_last] = self.closing;
        let mut after = of_first[0] * joined[0] + of_first[1] * joined[1];
        let before = of_last[0] * joined[0] + of_last[1] * joined[1];
        for (k, (joint, [last, first])) in self.joints.iter().zip(&self.at_joints).enumerate().rev() {
            let last = last - joint.last[0] * before - joint.last[1] * after;
            let first = first - joint.first[0] * before - joint.first[1] * after;
            put(k + 1, [last, after]);
            after = first;
        }
        put(0, [before, after]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_line_and_of_a_ring_meet() {
        // −x_{i−1} + 3 x_i − x_{i+1} = d_i in parts of two cells, each solved by hand.
        let solve = |a: f64, b: f64| [(3.0 * a + b) / 8.0, (a + 3.0 * b) / 8.0];
        let x = [0.3, -1.0, 2.0, 0.7, 5.0, -0.2, 0.9, 1.1, -3.0, 0.4];
        for (count, ring) in [(1, true), (2, true), (4, true), (5, true), (2, false), (4, false), (5, false)]
        {
            let n = 2 * count;
            let at = |i: isize| match ring {
                true => x[i.rem_euclid(n as isize) as usize],
                false if i < 0 || i >= n as isize => 0.0,
                false => x[i as usize],
            };
            let d: Vec<f64> = (0..n as isize).map(|i| 3.0 * at(i) - at(i - 1) - at(i + 1)).collect();
            let mut couplings = Couplings::default();
            couplings.join(count, |k| {
                let v = if ring || k > 0 { solve(-1.0, 0.0) } else { [0.0; 2] };
                let w = if ring || k + 1 < count { solve(0.0, -1.0) } else { [0.0; 2] };
                [v, w]
            });
            let mut seen = 0;
            couplings.solve(
                |k| solve(d[2 * k], d[2 * k + 1]),
                |own, [before, after]| {
                    seen += 1;
                    if ring || own > 0 {
                        assert!((before - at(2 * own as isize - 1)).abs() < 1e-13, "{count} {ring} {own}");
                    }
                    if ring || own + 1 < count {
                        assert!((after - at(2 * own as isize + 2)).abs() < 1e-13, "{count} {ring} {own}");
                    }
                },
            );
            assert_eq!(seen, count);
        }
    }
}
