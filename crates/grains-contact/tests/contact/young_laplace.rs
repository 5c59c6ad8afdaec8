//! Bridges of liquid between two equal spheres, from the Young-Laplace equation.
//!
//! Lengths in sphere radii, forces in 2π R γ. The meridian r(x) has constant mean curvature, of which r cos α + k r² = E is
//! the first integral: α its slope, k half the suction, E = F/(2π γ). It leaves the neck r0 with α = 0 and meets the sphere
//! at the filling angle β with α = π/2 − β − θ.

use std::f64::consts::PI;

/// One meridian, by its filling angle β and the span from the neck to where it meets the sphere.
struct Meridian {
    filling: f64,
    neck: f64,
    span: f64,
    suction: f64,
}

impl Meridian {
    /// k from E = r0 + k r0² at the neck and E = r sin(β + θ) + k r² at the sphere, r = sin β.
    fn new(filling: f64, angle: f64, span: f64) -> Self {
        let wetted = filling.sin();
        let neck = wetted - span;
        let suction = (neck - wetted * (filling + angle).sin()) / (span * (wetted + neck));
        Self { filling, neck, span, suction }
    }

    /// E (-).
    fn scaled_force(&self) -> f64 {
        self.neck * (1.0 + self.suction * self.neck)
    }

    /// ∫ dx and ∫ π r² dx from the neck to the sphere.
    ///
    /// dx/dr = c/√(1 − c²), c = cos α = E/r − k r, 1 − c = (r − r0)(1 + k (r + r0))/r: smooth in t of r = r0 + span t².
    fn halves(&self) -> [f64; 2] {
        const PANELS: u32 = 80;
        let offset = 0.6_f64.sqrt();
        let mut sums = [0.0; 2];
        for panel in 0..PANELS {
            for (at, weight) in [(-offset, 5.0), (0.0, 8.0), (offset, 5.0)] {
                let t = (f64::from(panel) + 0.5 + 0.5 * at) / f64::from(PANELS);
                let r = self.neck + self.span * t * t;
                let cosine = self.scaled_force() / r - self.suction * r;
                let rest = self.span * (1.0 + self.suction * (r + self.neck)) / r * (1.0 + cosine);
                let dx = cosine / rest.sqrt() * 2.0 * self.span * weight / (18.0 * f64::from(PANELS));
                sums[0] += dx;
                sums[1] += PI * r * r * dx;
            }
        }
        sums
    }

    fn gap(&self) -> f64 {
        2.0 * (self.halves()[0] - (1.0 - self.filling.cos()))
    }

    fn volume(&self) -> f64 {
        let height = 1.0 - self.filling.cos();
        2.0 * (self.halves()[1] - PI * height * height * (1.0 - height / 3.0))
    }

    /// The meridian of a volume with the smallest filling angle, its span this part of the wetted radius, if there is one.
    fn with_volume(part: f64, angle: f64, volume: f64) -> Option<Self> {
        let at = |filling: f64| Self::new(filling, angle, part * filling.sin());
        let mut high = 0.01;
        while at(high).volume() < volume {
            high *= 1.05;
            if high + angle > 0.5 * PI {
                return None;
            }
        }
        let mut low = high / 1.05;
        for _ in 0..46 {
            let middle = 0.5 * (low + high);
            *(if at(middle).volume() < volume { &mut low } else { &mut high }) = middle;
        }
        Some(at(low))
    }
}

/// The bridges of one volume and contact angle (rad), which become thinner in the neck from contact to the widest gap.
///
/// The filling angle falls at first and grows again before rupture; the neck over the wetted radius falls all the way.
pub struct Bridges {
    angle: f64,
    volume: f64,
    last_stable: f64,
}

impl Bridges {
    pub fn new(angle: f64, volume: f64) -> Self {
        let mut bridges = Self { angle, volume, last_stable: 0.0 };
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let (mut low, mut high) = (1e-3, 0.97);
        for _ in 0..45 {
            let (left, right) = (high - golden * (high - low), low + golden * (high - low));
            if bridges.gap(left) > bridges.gap(right) {
                high = right;
            } else {
                low = left;
            }
        }
        bridges.last_stable = 0.5 * (low + high);
        bridges
    }

    /// Gap where the span is this part of the wetted radius; below −2, growing with it, where there is no such bridge.
    fn gap(&self, part: f64) -> f64 {
        Meridian::with_volume(part, self.angle, self.volume).map_or(part - 3.0, |m| m.gap())
    }

    /// The widest gap.
    pub fn rupture_distance(&self) -> f64 {
        self.gap(self.last_stable)
    }

    /// F/(2π R γ) of the stable bridge over a gap up to that of rupture.
    pub fn scaled_force(&self, gap: f64) -> f64 {
        let (mut low, mut high) = (1e-3, self.last_stable);
        for _ in 0..45 {
            let middle = 0.5 * (low + high);
            *(if self.gap(middle) < gap { &mut low } else { &mut high }) = middle;
        }
        Meridian::with_volume(high, self.angle, self.volume).map_or(f64::NAN, |m| m.scaled_force())
    }
}
