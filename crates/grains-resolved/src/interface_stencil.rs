//! The interface stencil: velocities next to a surface, extrapolated from the flow outside.

use crate::Subgrid;
use crate::solid_mask::Holders;
use crate::subgrid::Stencil;
use crate::wall::{ClosestPoint, Solids};
use grains_domain::prefetch;
use grains_geometry::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How much further from the velocity of the surface an extrapolated one may be than that of any sample (-).
const MAX_EXTRAPOLATION: f64 = 1.5;
/// Smallest cosine between the normal and that of the surface opposite, reversed.
const FACING: f64 = 0.3;

/// Largest S of an extrapolated velocity (-): with it forces settle wherever ν Δt/Δx² is at most [`MAX_DIFFUSION_NUMBER`].
///
/// Forces that alternate from step to step obey f = κ (L_ii − W L_oi) f, κ = ν Δt/Δx², with L the sum of differences from the
/// neighbours, i the velocities inside, o those in the fluid, and W the weights of the extrapolation.
/// They die out where κ λ < 1 for the largest eigenvalue λ of L_ii − W L_oi.
/// Into a body with a flat side they decay by 1/S per cell, S = −Σ W_io n_o with n_o neighbours of o inside, which gives
/// λ = S + 1/S − 2 for S > 1, and less than 0 otherwise: at most ½ for S = 2.
/// Straight lines and parabolas stay below 0 in any pose.
const MAX_RESPONSE: f64 = 2.0;
/// Samples whose velocities may lie beside the body: further ones lie beyond the neighbours that S counts.
const NEAR: usize = 2;
/// What rounding may make of weights and of S, which is 2 at depths of 0.4 cells: all ranks take one polynomial (-).
const ROUNDING: f64 = 1e-9;
/// Largest ν Δt/Δx² with cubics (-).
pub const MAX_DIFFUSION_NUMBER: f64 = 2.0;

/// How velocities just inside a particle follow those in the fluid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Extrapolation {
    /// Along a cubic through the surface and three points in the fluid: third order, where boundary layers are several cells
    /// thick; the default where all particles are fixed.
    Cubic,
    /// Along a parabola through the surface and two points: steadier; the default where some move.
    Quadratic,
    /// Along a straight line through the surface and one point.
    Linear,
    /// Not at all: they are those of the particle.
    Rigid,
}

/// How a polynomial is chosen.
#[derive(Clone, Copy)]
pub(crate) struct Rule {
    /// Number of points in the fluid.
    samples: usize,
    /// Their distance, in those of the planes between which a cell fits (-).
    spacing: f64,
    /// What the weights may sum to in magnitude, times the number of extrapolated velocities about one in the fluid (-).
    max_weight: f64,
    /// What may come of velocities that are extrapolated themselves: loops among close bodies must not feed themselves (-).
    max_feedback: f64,
    /// S: what the velocities beside extrapolated ones may weigh, times the number of these (-).
    max_response: f64,
}

impl Extrapolation {
    /// How its polynomials are chosen; none if velocities are those of the body.
    ///
    /// Far or few samples are less exact; near and many of them amplify what the grid does not resolve.
    pub(crate) fn rule(self) -> Option<Rule> {
        let rule = |samples, spacing, max_weight, max_feedback, max_response| {
            Some(Rule { samples, spacing, max_weight, max_feedback, max_response })
        };
        match self {
            Self::Rigid => None,
            Self::Linear => rule(1, 1.0, 5.0, 0.25, f64::INFINITY),
            Self::Quadratic => rule(2, 1.0, 5.0, 0.25, f64::INFINITY),
            Self::Cubic => rule(3, 0.8, 12.0, 0.5, MAX_RESPONSE),
        }
    }
}

impl Rule {
    /// The same for the velocity at a place.
    ///
    /// What noise of the flow makes of a velocity in the fluid is shared among those of its neighbours that are extrapolated.
    pub fn at(self, place: usize, subgrid: &Subgrid, holders: Holders) -> Self {
        let mut max = 1;
        for place in subgrid.around(place).filter(|&p| !holders.holds(p)) {
            max = max.max(subgrid.around(place).filter(|&p| holders.holds(p)).count());
        }
        Self { max_weight: self.max_weight / max as f64, ..self }
    }
}

/// Extrapolation from the fluid through the surface to a velocity inside: u − u_s = Σ b_k (u(x_k) − u_s), u_s = U + ω × r_s.
#[derive(Clone, Debug, Default)]
pub(crate) struct InterfaceStencil {
    /// From the centre of the body to the surface (m).
    pub foot: Vec3,
    /// b_k (-) of the points in the fluid; of those that there are not, it is 0.
    weights: [f64; 3],
    /// x_k: of each the lowest corner of its cell and the place in that.
    bases: [u32; 3],
    fractions: [[f64; 3]; 3],
    /// The surface opposite, if the profile ends there.
    pub opposite: Option<Box<Opposite>>,
}

/// A point of the surface on the other side of a passage.
#[derive(Clone, Debug)]
pub(crate) struct Opposite {
    /// Place of its body in the list.
    pub body: u32,
    /// From the centre of that body (m).
    pub foot: Vec3,
    /// Weight of its velocity (-).
    pub weight: f64,
}

/// A value that the profile along a normal takes.
#[derive(Clone, Copy)]
enum Sample {
    /// Of the flow, interpolated, so far away (m).
    Flow(f64, Stencil),
    /// Of the surface of a body opposite, so far away (m), at this point from its centre (m).
    Opposite(f64, u32, Vec3),
}

/// Where there is no sample yet.
const NOTHING: Sample = Sample::Opposite(0.0, 0, Vec3::new(0.0, 0.0, 0.0));

/// Up to three values that a profile takes, from the surface on.
struct Samples {
    values: [Sample; 3],
    count: usize,
}

impl Samples {
    fn of(given: impl Iterator<Item = Sample>) -> Self {
        let mut samples = Self { values: [NOTHING; 3], count: 0 };
        for (place, sample) in samples.values.iter_mut().zip(given) {
            *place = sample;
            samples.count += 1;
        }
        samples
    }

    fn all(&self) -> &[Sample] {
        &self.values[..self.count]
    }
}

/// The profiles along the normal at a point of a surface.
pub(crate) struct Profile<'a> {
    pub subgrid: &'a Subgrid,
    pub component: usize,
    pub solids: &'a Solids<'a>,
    /// Who holds the velocities of the component.
    pub holders: Holders<'a>,
    /// The point of the surface (m).
    pub start: Vec3,
    /// The surface point closest to it.
    pub out: ClosestPoint,
    /// How it is chosen.
    pub rule: Rule,
    /// Distance (m) of planes normal to the profile between which a cell fits.
    pub unit: f64,
    /// What is wanted of the powers 1 to 3 of the distance along the normal, in that unit (-): those of a place in the wall, to
    /// extrapolate to it.
    pub wanted: Vec3,
}

impl Profile<'_> {
    /// Finds the extrapolation to the start of the way, along a polynomial that is 0 on the surface and takes the samples;
    /// false where there is nothing to extrapolate.
    ///
    /// Where bodies hide the last one, the surface opposite takes its place, or the midst of the passage and that surface; or
    /// there are fewer points.
    #[inline(always)]
    pub fn find(&self, found: &mut InterfaceStencil) -> bool {
        let step = self.rule.spacing * self.unit;
        let whole = match self.rule.samples {
            1 => self.whole::<1>(step, found),
            2 => self.whole::<2>(step, found),
            _ => self.whole::<3>(step, found),
        };
        whole || self.partial(step, found)
    }

    /// Finds the extrapolation from as many points in the fluid as are wanted.
    fn whole<const N: usize>(&self, step: f64, found: &mut InterfaceStencil) -> bool {
        let mut samples = [NOTHING; N];
        for (n, place) in samples.iter_mut().enumerate() {
            let Some(sample) = self.flow((n + 1) as f64 * step) else { return false };
            *place = sample;
        }
        self.fit_all(&samples, found)
    }

    /// Finds the extrapolation to the surface opposite, or from fewer points.
    #[cold]
    fn partial(&self, step: f64, found: &mut InterfaceStencil) -> bool {
        let samples = self.rule.samples;
        let flow = Samples::of((1..=samples).map_while(|n| self.flow(n as f64 * step)));
        let flow = flow.all();
        let across = |found: &mut InterfaceStencil| {
            let Some((width, end)) = flow.iter().find_map(|sample| self.opposite(sample)) else {
                return false;
            };
            let before =
                flow.iter().enumerate().take(samples - 1).take_while(|(n, _)| (*n + 1) as f64 * step < width);
            let samples = Samples::of(before.map(|(_, sample)| *sample).chain([end]));
            self.fit(samples.all(), found)
                || self.flow(step.min(0.5 * width)).is_some_and(|midst| self.fit(&[midst, end], found))
        };
        samples > 1 && across(found)
            || (1..samples).rev().any(|n| flow.get(..n).is_some_and(|fewer| self.fit(fewer, found)))
    }

    /// The flow at a distance (m) from the surface.
    #[inline(always)]
    fn flow(&self, distance: f64) -> Option<Sample> {
        let point = self.start + self.out.surface.direction * distance;
        Some(Sample::Flow(distance, self.subgrid.stencil(self.component, &point)?))
    }

    /// Finds the weights of samples with which every polynomial along the normal that is 0 on the surface, and has as many terms as
    /// there are samples, is extrapolated exactly, interpolation included; false if they are too large.
    fn fit(&self, samples: &[Sample], found: &mut InterfaceStencil) -> bool {
        match samples {
            [a] => self.fit_all(&[*a], found),
            [a, b] => self.fit_all(&[*a, *b], found),
            [a, b, c] => self.fit_all(&[*a, *b, *c], found),
            _ => false,
        }
    }

    /// The same for a number of samples that is known: what is found of each stays in registers.
    #[inline(always)]
    fn fit_all<const N: usize>(&self, samples: &[Sample; N], found: &mut InterfaceStencil) -> bool {
        let per_unit = 1.0 / self.unit;
        let cell = self.out.surface.direction.component_mul(&self.subgrid.spacing) * per_unit;
        let strides = self.subgrid.layout.strides();
        let (mut powers, mut hidden, mut response) = ([Vec3::zeros(); N], Vec3::zeros(), Vec3::zeros());
        for n in 0..N {
            powers[n] = match &samples[n] {
                Sample::Opposite(width, ..) => {
                    let y = width * per_unit;
                    Vec3::new(y, y * y, y * y * y)
                }
                Sample::Flow(distance, stencil) => {
                    hidden[n] = stencil.hidden(strides, self.holders);
                    if n < NEAR && self.rule.max_response.is_finite() {
                        response[n] = self.response(stencil);
                    }
                    powers_between(distance * per_unit, stencil, &cell)
                }
            };
        }
        let Some(weights) = solve(&powers, &self.wanted) else { return false };
        if weights.abs().dot(&hidden) > self.rule.max_feedback + ROUNDING
            || weights.abs().sum() > self.rule.max_weight + ROUNDING
            || -weights.dot(&response) > self.rule.max_response + ROUNDING
        {
            return false;
        }
        found.foot = self.out.arm + self.out.surface.direction * self.out.surface.distance;
        found.weights = [0.0; 3];
        found.opposite = None;
        for (n, sample) in samples.iter().enumerate() {
            match *sample {
                Sample::Flow(_, Stencil { base, fractions }) => {
                    found.weights[n] = weights[n];
                    found.bases[n] = base as u32;
                    found.fractions[n] = fractions;
                }
                Sample::Opposite(_, body, foot) => {
                    found.opposite = Some(Box::new(Opposite { body, foot, weight: weights[n] }));
                }
            }
        }
        true
    }

    /// Mean over the fluid's corners of a stencil of the number of their neighbours inside bodies.
    fn response(&self, stencil: &Stencil) -> f64 {
        let strides = self.subgrid.layout.strides();
        let holders = self.holders;
        let of_corner = |(place, weight): (usize, f64)| match holders.holds(place) {
            true => 0.0,
            false => weight * self.subgrid.around(place).filter(|&p| holders.holds(p)).count() as f64,
        };
        stencil.corners(strides).map(of_corner).sum()
    }

    /// Distance (m) to the surface opposite, if a sample of the flow is hidden by it, and that surface.
    ///
    /// It is the tangent plane at the surface point closest to a corner of the sample's cell: of the corner that counts most.
    fn opposite(&self, sample: &Sample) -> Option<(f64, Sample)> {
        let Sample::Flow(_, stencil) = *sample else { return None };
        let along = self.out.surface.direction;
        let mut best: Option<(f64, (f64, Sample))> = None;
        for (place, weight) in stencil.corners(self.subgrid.layout.strides()) {
            if best.is_some_and(|(max, _)| max + ROUNDING >= weight) {
                continue;
            }
            let Some(body) = self.holders.body(place) else { continue };
            let corner = self.subgrid.position(self.component, place);
            let Some(ClosestPoint { arm, surface }) = self.solids.closest_point(body as usize, &corner)
            else {
                continue;
            };
            let facing = -surface.direction.dot(&along);
            let end = corner + surface.direction * surface.distance;
            let width = (self.start - end).dot(&surface.direction) / facing;
            if facing > FACING && width > 0.0 {
                let foot = self.start + along * width - corner + arm;
                best = Some((weight, (width, Sample::Opposite(width, body, foot))));
            }
        }
        best.map(|(_, found)| found)
    }
}

impl InterfaceStencil {
    /// The points in the fluid with their weights.
    #[inline]
    fn fluid(&self) -> impl Iterator<Item = (f64, Stencil)> {
        let points = self.bases.iter().zip(&self.fractions);
        let stencils = points.map(|(&base, &fractions)| Stencil { base: base as usize, fractions });
        self.weights.iter().copied().zip(stencils).filter(|(weight, _)| *weight != 0.0)
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

/// The weights b with Σ b_n p_nk = w_k, of as many powers k as there are columns p_n; none where there are no such.
#[inline(always)]
fn solve(columns: &[Vec3], wanted: &Vec3) -> Option<Vec3> {
    let (determinant, weights) = match *columns {
        [p] => (p.x, Vec3::new(wanted.x, 0.0, 0.0)),
        [p, q] => {
            let cross = |a: &Vec3, b: &Vec3| a.x * b.y - a.y * b.x;
            (cross(&p, &q), Vec3::new(cross(wanted, &q), cross(&p, wanted), 0.0))
        }
        [p, q, r] => {
            let volume = |a: &Vec3, b: &Vec3, c: &Vec3| a.dot(&b.cross(c));
            let weights = Vec3::new(volume(wanted, &q, &r), volume(&p, wanted, &r), volume(&p, &q, wanted));
            (volume(&p, &q, &r), weights)
        }
        _ => return None,
    };
    (determinant != 0.0).then(|| weights * (1.0 / determinant))
}

/// What multilinear interpolation makes of y, y², y³ at y, the distance along a normal: their means over corners whose coordinates
/// are independent of each other, with what a cell along each axis adds to y.
#[inline(always)]
fn powers_between(y: f64, stencil: &Stencil, cell: &Vec3) -> Vec3 {
    let (mut variance, mut third) = (0.0, 0.0);
    // Where the flow does not vary, the fraction is 0.
    for (t, step) in stencil.fractions.iter().zip(cell.iter()) {
        let spread = t * (1.0 - t) * step * step;
        variance += spread;
        third += spread * (1.0 - 2.0 * t) * step;
    }
    Vec3::new(y, y * y + variance, y * y * y + 3.0 * y * variance + third)
}

/// Distance (m) of two parallel planes between which a cell fits.
pub(crate) fn pitch(normal: &Vec3, subgrid: &Subgrid) -> f64 {
    (0..3).filter(|&a| subgrid.active[a]).map(|a| normal[a].abs() * subgrid.spacing[a]).sum()
}

#[cfg(test)]
impl InterfaceStencil {
    /// What velocities in the fluid add to the extrapolated one.
    pub fn weighted(&self, velocity: &[f64], strides: [usize; 3]) -> f64 {
        self.fluid().map(|(weight, stencil)| weight * stencil.mean(strides, velocity)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Random;

    #[test]
    fn weights_give_as_many_powers_as_there_are_samples() {
        let mut random = Random(3);
        for k in 0..300 {
            // Samples up to 3 and 0.8 or more apart, as those of profiles are.
            let at = |n: usize, shift: f64| (n as f64 + 1.0) * 0.8 + 0.2 * shift;
            let columns = [0, 1, 2].map(|n| {
                let y = at(n, random.next());
                Vec3::new(y, y * y + 0.2 * random.next(), y * y * y + random.next())
            });
            let wanted = Vec3::from_fn(|_, _| 2.0 * random.next() - 1.0);
            let count = 1 + k % 3;
            let weights = solve(&columns[..count], &wanted).unwrap();
            let found: Vec3 = columns.iter().zip(&weights).map(|(column, weight)| column * *weight).sum();
            let error = (found - wanted).rows(0, count).amax();
            assert!(error < 1e-11, "{columns:?} {wanted:?} {weights:?}");
            assert!(weights.iter().skip(count).all(|weight| *weight == 0.0));
        }
        assert!(solve(&[Vec3::new(1.0, 2.0, 0.0), Vec3::new(2.0, 4.0, 1.0)], &Vec3::x()).is_none());
    }
}
