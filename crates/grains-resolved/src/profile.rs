//! The profile of the flow along a normal, from which velocities next to a surface are extrapolated.

use crate::Subgrid;
use crate::cell_stencil::{Cells, Stencil};
use crate::extrapolation::Rule;
use crate::interface_stencil::{InterfaceStencil, MAX_SAMPLES, Opposite};
use crate::solid_mask::Holders;
use crate::wall::{ClosestPoint, Solids};
use grains_geometry::Vec3;
use grains_geometry::lanes::{Lanes, Number, Vector};

/// Smallest cosine between the normal and that of the surface opposite, reversed.
const FACING: f64 = 0.3;

/// Samples whose velocities may lie beside the body: further ones lie beyond the neighbours that S counts.
const NEAR: usize = 2;
/// What rounding may make of weights and of S, which is 2 at depths of 0.4 cells: all ranks take one polynomial (-).
const ROUNDING: f64 = 1e-9;

/// Normals at points of surfaces, one or several side by side.
#[derive(Clone, Copy)]
pub(crate) struct Normals<T> {
    /// The points of the surfaces (m).
    pub start: Vector<T>,
    /// Out of the bodies.
    pub direction: Vector<T>,
    /// Distance (m) of planes normal to them between which a cell fits.
    pub unit: T,
    /// What is wanted of the powers 1 to 3 of the distance along them, in that unit (-): those of a place in the body, to
    /// extrapolate to it.
    pub wanted: Vector<T>,
}

impl Normals<Lanes> {
    /// One of them.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Normals<f64> {
        let one = |vector: &Vector<Lanes>| Vector::of(&vector.get(lane));
        Normals {
            start: one(&self.start),
            direction: one(&self.direction),
            unit: self.unit.lane(lane),
            wanted: one(&self.wanted),
        }
    }
}

/// Samples of the flow along normals, with the weights that extrapolate from them.
pub(crate) struct FlowSamples<T, const N: usize> {
    cells: [Cells<T>; N],
    weights: [T; N],
}

impl<T: Number> Normals<T> {
    /// Those through velocities (m) in bodies, with direction and distance (m) of the closest points of the surfaces.
    #[inline(always)]
    pub fn through(
        velocities: &Vector<T>,
        (direction, distance): (&Vector<T>, T),
        subgrid: &Subgrid,
    ) -> Self {
        let unit = pitch(direction, subgrid);
        let depth = -distance / unit;
        Self {
            start: velocities.plus(&direction.times(distance)),
            direction: *direction,
            unit,
            wanted: Vector([depth, depth * depth, depth * depth * depth]),
        }
    }

    /// The extrapolations from as many points in the fluid as are wanted.
    #[inline(always)]
    pub fn samples<const N: usize>(
        &self,
        rule: Rule,
        component: usize,
        subgrid: &Subgrid,
    ) -> FlowSamples<T, N> {
        let zero = T::of(0.0);
        // Maps of arrays would be calls of their own.
        let mut cells = [Cells { base: zero, fractions: [zero; 3], is_there: zero }; N];
        let mut powers = [self.wanted; N];
        let widths = self.widths(subgrid);
        for n in 0..N {
            let y = T::of((n + 1) as f64 * rule.spacing);
            cells[n] = self.cells(self.unit * y, component, subgrid);
            powers[n] = powers_between(y, &cells[n].fractions, &widths);
        }
        FlowSamples { cells, weights: solve(&powers, &self.wanted) }
    }

    /// The cells of velocities at a distance (m) from the surfaces.
    #[inline(always)]
    fn cells(&self, distance: T, component: usize, subgrid: &Subgrid) -> Cells<T> {
        subgrid.cells_about(component, &self.start.plus(&self.direction.times(distance)))
    }

    /// What a cell along each axis adds to the distance, in the unit (-).
    #[inline(always)]
    fn widths(&self, subgrid: &Subgrid) -> Vector<T> {
        self.direction.by_component(&Vector::of(&subgrid.spacing)).times(T::of(1.0) / self.unit)
    }
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
    values: [Sample; MAX_SAMPLES],
    count: usize,
}

impl Samples {
    fn of(given: impl Iterator<Item = Sample>) -> Self {
        let mut samples = Self { values: [NOTHING; MAX_SAMPLES], count: 0 };
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

/// A velocity to which the flow is extrapolated.
#[derive(Clone, Copy)]
pub(crate) struct Target<'a> {
    pub subgrid: &'a Subgrid,
    /// Its place in the arrays.
    pub place: usize,
    /// Who holds the velocities of its component.
    pub holders: Holders<'a>,
    /// How its profile is chosen.
    pub rule: Rule,
    /// The closest point of the surface.
    pub out: &'a ClosestPoint,
}

/// The profile along the normal through a velocity, with what is needed where the flow alone does not give it.
pub(crate) struct Profile<'a> {
    pub target: Target<'a>,
    pub component: usize,
    pub solids: &'a Solids<'a>,
    pub normal: Normals<f64>,
}

impl Target<'_> {
    /// Takes the extrapolation from as many points in the fluid as are wanted, of one among several profiles; false where there is none.
    #[inline(always)]
    pub fn take<T: Number, const N: usize>(
        &self,
        samples: &FlowSamples<T, N>,
        lane: usize,
        found: &mut InterfaceStencil,
    ) -> bool {
        found.clear();
        for n in 0..N {
            let Some(stencil) = samples.cells[n].stencil(lane) else { return false };
            found.add(samples.weights[n].lane(lane), stencil);
        }
        self.accepts(found)
    }

    /// Whether the weights of an extrapolation are not too large; if so, it is from the point of the surface.
    #[inline(always)]
    fn accepts(&self, found: &mut InterfaceStencil) -> bool {
        let strides = self.subgrid.layout.strides();
        let (mut hidden, mut response) = (0.0, 0.0);
        let mut sum = found.opposite().map_or(0.0, |opposite| opposite.weight.abs());
        for (n, (weight, stencil)) in found.fluid().enumerate() {
            sum += weight.abs();
            hidden += weight.abs() * stencil.hidden(strides, self.holders);
            if n < NEAR && self.rule.max_response.is_finite() {
                response -= weight * self.response(&stencil);
            }
        }
        found.foot = self.out.arm + self.out.surface.direction * self.out.surface.distance;
        // None of this holds for weights that are not numbers, of samples that tell nothing.
        self.allows(sum)
            && hidden <= self.rule.max_feedback + ROUNDING
            && response <= self.rule.max_response + ROUNDING
    }

    /// Whether weights may sum to this in magnitude.
    ///
    /// What noise of the flow makes of a velocity in the fluid is shared among those of its neighbours that are extrapolated.
    #[inline(always)]
    fn allows(&self, sum: f64) -> bool {
        let is_allowed = |shared: usize| sum <= self.rule.max_weight / shared as f64 + ROUNDING;
        is_allowed(self.subgrid.neighbours_of_a_velocity()) || is_allowed(self.shared())
    }

    /// Largest number of velocities in bodies about a neighbour of this one in the fluid.
    fn shared(&self) -> usize {
        let (subgrid, holders) = (self.subgrid, self.holders);
        let mut max = 1;
        for place in subgrid.around(self.place).filter(|&p| !holders.holds(p)) {
            max = max.max(subgrid.around(place).filter(|&p| holders.holds(p)).count());
        }
        max
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
}

impl Profile<'_> {
    /// Finds the extrapolation to the start of the way, along a polynomial that is 0 on the surface and takes the samples;
    /// false where there is nothing to extrapolate.
    pub fn find(&self, found: &mut InterfaceStencil) -> bool {
        let whole = match self.target.rule.samples {
            1 => self.target.take(&self.samples::<1>(), 0, found),
            2 => self.target.take(&self.samples::<2>(), 0, found),
            _ => self.target.take(&self.samples::<3>(), 0, found),
        };
        whole || self.partial(found)
    }

    /// The samples that are wanted.
    fn samples<const N: usize>(&self) -> FlowSamples<f64, N> {
        self.normal.samples(self.target.rule, self.component, self.target.subgrid)
    }

    /// Finds the extrapolation where [`Target::take`] takes none: from the cells that it found.
    ///
    /// Where bodies hide the last one, the surface opposite takes its place, or the midst of the passage and that surface; or
    /// there are fewer points.
    #[cold]
    pub fn partial(&self, found: &mut InterfaceStencil) -> bool {
        let (samples, step) = (self.target.rule.samples, self.target.rule.spacing * self.normal.unit);
        let cells = found.fluid().enumerate();
        let flow = Samples::of(cells.map(|(n, (_, stencil))| Sample::Flow((n + 1) as f64 * step, stencil)));
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
    fn flow(&self, distance: f64) -> Option<Sample> {
        let cell = self.normal.cells(distance, self.component, self.target.subgrid);
        Some(Sample::Flow(distance, cell.stencil(0)?))
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

    fn fit_all<const N: usize>(&self, samples: &[Sample; N], found: &mut InterfaceStencil) -> bool {
        let widths = self.normal.widths(self.target.subgrid);
        let powers = samples.each_ref().map(|sample| match sample {
            Sample::Opposite(distance, ..) => {
                let y = distance / self.normal.unit;
                Vector([y, y * y, y * y * y])
            }
            Sample::Flow(distance, stencil) => {
                powers_between(distance / self.normal.unit, &stencil.fractions, &widths)
            }
        });
        let weights = solve(&powers, &self.normal.wanted);
        found.clear();
        for (sample, weight) in samples.iter().zip(weights) {
            match *sample {
                Sample::Flow(_, stencil) => found.add(weight, stencil),
                Sample::Opposite(_, body, foot) => found.end(Opposite { body, foot, weight }),
            }
        }
        self.target.accepts(found)
    }

    /// Distance (m) to the surface opposite, if a sample of the flow is hidden by it, and that surface.
    ///
    /// It is the tangent plane at the surface point closest to a corner of the sample's cell: of the corner with the largest weight.
    fn opposite(&self, sample: &Sample) -> Option<(f64, Sample)> {
        let Sample::Flow(_, stencil) = *sample else { return None };
        let Target { subgrid, holders, .. } = self.target;
        let along = self.target.out.surface.direction;
        let start = Vec3::from(self.normal.start.0);
        let mut best: Option<(f64, (f64, Sample))> = None;
        for (place, weight) in stencil.corners(subgrid.layout.strides()) {
            if best.is_some_and(|(max, _)| max + ROUNDING >= weight) {
                continue;
            }
            let Some(body) = holders.body(place) else { continue };
            let corner = subgrid.position(self.component, place);
            let Some(ClosestPoint { arm, surface }) = self.solids.closest_point(body as usize, &corner)
            else {
                continue;
            };
            let facing = -surface.direction.dot(&along);
            let end = corner + surface.direction * surface.distance;
            let width = (start - end).dot(&surface.direction) / facing;
            if facing > FACING && width > 0.0 {
                let foot = start + along * width - corner + arm;
                best = Some((weight, (width, Sample::Opposite(width, body, foot))));
            }
        }
        best.map(|(_, found)| found)
    }
}

/// The weights b with Σ b_n p_nk = w_k, of as many powers k as there are columns p_n; no finite ones where there are no such.
#[inline(always)]
fn solve<T: Number, const N: usize>(columns: &[Vector<T>; N], wanted: &Vector<T>) -> [T; N] {
    let zero = T::of(0.0);
    let cross = |Vector(a): &Vector<T>, Vector(b): &Vector<T>| a[0] * b[1] - a[1] * b[0];
    let volume = |a: &Vector<T>, b: &Vector<T>, c: &Vector<T>| a.dot(&b.cross(c));
    let (determinant, weights) = match columns.as_slice() {
        [p] => (p.0[0], [wanted.0[0], zero, zero]),
        [p, q] => (cross(p, q), [cross(wanted, q), cross(p, wanted), zero]),
        [p, q, r] => (volume(p, q, r), [volume(wanted, q, r), volume(p, wanted, r), volume(p, q, wanted)]),
        _ => (zero, [zero; 3]),
    };
    let per_determinant = T::of(1.0) / determinant;
    let mut found = [zero; N];
    for (found, weight) in found.iter_mut().zip(weights) {
        *found = weight * per_determinant;
    }
    found
}

/// What multilinear interpolation makes of y, y², y³ at y, the distance along a normal: their means over corners whose coordinates
/// are independent of each other, with what a cell along each axis adds to y.
#[inline(always)]
fn powers_between<T: Number>(y: T, fractions: &[T; 3], Vector(widths): &Vector<T>) -> Vector<T> {
    let (one, two, three) = (T::of(1.0), T::of(2.0), T::of(3.0));
    let (mut variance, mut third) = (T::of(0.0), T::of(0.0));
    // Where the flow does not vary, the fraction is 0.
    for (&t, &width) in fractions.iter().zip(widths) {
        let spread = t * (one - t) * width * width;
        variance = variance + spread;
        third = third + spread * (one - two * t) * width;
    }
    Vector([y, y * y + variance, y * y * y + three * y * variance + third])
}

/// Distance (m) of two parallel planes between which a cell fits.
#[inline(always)]
pub(crate) fn pitch<T: Number>(Vector(normal): &Vector<T>, subgrid: &Subgrid) -> T {
    let along = |a: usize| if subgrid.active[a] { subgrid.spacing[a] } else { 0.0 };
    let mut sum = T::of(0.0);
    for (a, component) in normal.iter().enumerate() {
        sum = sum + component.abs() * T::of(along(a));
    }
    sum
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
            let vectors = columns.each_ref().map(Vector::<f64>::of);
            let count = 1 + k % 3;
            let wanted_of_them = Vector::of(&wanted);
            let weights = match count {
                1 => solve(&[vectors[0]], &wanted_of_them).to_vec(),
                2 => solve(&[vectors[0], vectors[1]], &wanted_of_them).to_vec(),
                _ => solve(&vectors, &wanted_of_them).to_vec(),
            };
            let found: Vec3 = columns.iter().zip(&weights).map(|(column, weight)| column * *weight).sum();
            let error = (found - wanted).rows(0, count).amax();
            assert!(error < 1e-11, "{columns:?} {wanted:?} {weights:?}");
        }
        let parallel = [Vector([1.0, 2.0, 0.0]), Vector([2.0, 4.0, 1.0])];
        assert!(solve(&parallel, &Vector([1.0, 0.0, 0.0])).iter().all(|weight| !weight.is_finite()));
    }
}
