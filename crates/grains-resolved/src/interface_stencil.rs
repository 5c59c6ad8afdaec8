//! The interface stencil: velocities next to a surface, extrapolated from the flow outside.

use crate::cell_stencil::Stencil;
use grains_domain::prefetch;
use grains_geometry::Vec3;

/// How much further from the velocity of the surface an extrapolated one may be than that of any sample (-).
const MAX_EXTRAPOLATION: f64 = 1.5;
/// Points in the fluid.
pub(crate) const MAX_SAMPLES: usize = 3;

/// Extrapolation from the fluid through the surface to a velocity inside: u − u_s = Σ b_k (u(x_k) − u_s), u_s = U + ω × r_s.
#[derive(Clone, Debug, Default)]
pub(crate) struct InterfaceStencil {
    /// From the centre of the body to the surface (m).
    pub foot: Vec3,
    /// b_k (-).
    weights: [f64; MAX_SAMPLES],
    /// x_k in the fluid: of each the lowest corner of its cell and the place in that (-); of the surface opposite: the place of its
    /// body in the list and the point from the centre of that (m).
    bases: [u32; MAX_SAMPLES],
    points: [[f64; 3]; MAX_SAMPLES],
    /// How many of these points are in the fluid.
    in_fluid: u8,
    /// Whether the surface opposite comes after them.
    is_passage: bool,
}

/// A point of the surface on the other side of a passage.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Opposite {
    /// Place of its body in the list.
    pub body: u32,
    /// From the centre of that body (m).
    pub foot: Vec3,
    /// Weight of its velocity (-).
    pub weight: f64,
}

impl InterfaceStencil {
    /// Begins anew, without points.
    #[inline(always)]
    pub fn clear(&mut self) {
        (self.in_fluid, self.is_passage) = (0, false);
    }

    /// Adds a point in the fluid with its weight.
    #[inline(always)]
    pub fn add(&mut self, weight: f64, Stencil { base, fractions }: Stencil) {
        let n = usize::from(self.in_fluid);
        (self.weights[n], self.bases[n], self.points[n]) = (weight, base as u32, fractions);
        self.in_fluid += 1;
    }

    /// Ends with the surface opposite.
    pub fn end(&mut self, Opposite { body, foot, weight }: Opposite) {
        let n = usize::from(self.in_fluid);
        (self.weights[n], self.bases[n], self.points[n]) = (weight, body, foot.into());
        self.is_passage = true;
    }

    /// The points in the fluid with their weights.
    #[inline(always)]
    pub fn fluid(&self) -> impl Iterator<Item = (f64, Stencil)> {
        let points = self.bases.iter().zip(&self.points);
        let stencils = points.map(|(&base, &fractions)| Stencil { base: base as usize, fractions });
        self.weights.iter().copied().zip(stencils).take(usize::from(self.in_fluid))
    }

    /// The surface opposite, if the profile ends there.
    #[inline(always)]
    pub fn opposite(&self) -> Option<Opposite> {
        let n = usize::from(self.in_fluid);
        self.is_passage.then(|| Opposite {
            body: self.bases[n],
            foot: self.points[n].into(),
            weight: self.weights[n],
        })
    }

    /// Asks the memory for the velocities at the points in the fluid.
    #[inline]
    pub fn prefetch(&self, velocity: &[f64], [_, sy, sz]: [usize; 3]) {
        for (_, Stencil { base, .. }) in self.fluid() {
            [0, sy, sz, sy + sz].into_iter().for_each(|corner| prefetch(velocity, base + corner));
        }
    }

    /// The velocity (m/s) inside, of that of the surface, of the surface opposite with its weight, and of the fluid.
    ///
    /// It differs from that of the surface by little more than a sample does: boundary layers thinner than a cell are not
    /// extrapolated to the other side with several times their velocity.
    #[inline]
    pub fn extrapolated(
        &self,
        surface: f64,
        opposite: Option<(f64, f64)>,
        velocity: &[f64],
        strides: [usize; 3],
    ) -> f64 {
        let (mut sum, mut max) = (0.0, 0.0_f64);
        let mut add = |weight: f64, sample: f64| {
            let relative = sample - surface;
            sum += weight * relative;
            max = max.max(relative.abs());
        };
        self.fluid().for_each(|(weight, stencil)| add(weight, stencil.mean(strides, velocity)));
        opposite.into_iter().for_each(|(weight, sample)| add(weight, sample));
        surface + sum.clamp(-MAX_EXTRAPOLATION * max, MAX_EXTRAPOLATION * max)
    }
}

#[cfg(test)]
impl InterfaceStencil {
    /// Whether another one extrapolates from the same points with the same weights.
    pub fn is_as(&self, other: &Self) -> bool {
        let opposite = |stencil: &Self| stencil.opposite().map(|o| (o.body, o.foot, o.weight));
        self.foot == other.foot && self.fluid().eq(other.fluid()) && opposite(self) == opposite(other)
    }

    /// What velocities in the fluid add to the extrapolated one.
    pub fn weighted(&self, velocity: &[f64], strides: [usize; 3]) -> f64 {
        self.fluid().map(|(weight, stencil)| weight * stencil.mean(strides, velocity)).sum()
    }
}
