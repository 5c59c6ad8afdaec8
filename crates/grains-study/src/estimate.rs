//! Values of the varied quantities at which surfaces of the measures meet their targets, with their uncertainty.
//!
//! Coordinates x run from −1 to 1 over each range. With surfaces m_j of variance v_j(x), targets t_j and their standard uncertainties
//! σ_j the likelihood is Π exp(−(m_j − t_j)²/2w_j²)/w_j, w_j² = σ_j² + v_j(x), and within the ranges no value is preferred before.
//! The best values are those of the smallest Σ (m_j − t_j)²/w_j², found by SLSQP (Kraft 1988) within the ranges. Their distribution is
//! sampled by the algorithm of Metropolis et al. (1953).

use crate::random::Random;
use crate::study_file::Target;
use crate::surface::{Surface, coefficients};
use nalgebra::{DMatrix, DVector};

/// Runs of one point: its coordinates and the means of its measures over repeats are those of single runs here.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Observation {
    pub x: Vec<f64>,
    pub measures: Vec<f64>,
}

/// What the observations so far say.
#[derive(Clone, Debug)]
pub(crate) struct Estimate {
    pub best: Vec<f64>,
    /// Standard deviations of the coordinates.
    pub deviation: Vec<f64>,
    /// The middle 68.3 % and 95.4 % of each coordinate.
    pub intervals: Vec<[[f64; 2]; 2]>,
    pub covariance: DMatrix<f64>,
    pub surfaces: Vec<Surface>,
    /// Deviation of each measure from its target at the best values, over w_j.
    pub misfits: Vec<f64>,
    /// Places as good as the best, within one in χ², and apart from it, by the surfaces through all runs.
    pub others: Vec<Vec<f64>>,
    /// Observations that the surfaces were fitted to.
    pub used: usize,
    /// Where they lie, to the ends of the ranges where none lies farther out.
    pub region: Vec<[f64; 2]>,
}

/// SLSQP may be given constraints besides bounds; there are none.
type Constraint = fn(&[f64], Option<&mut [f64]>, &mut ()) -> f64;

/// Steps of the sampling.
const STEPS: usize = 20_000;

impl Estimate {
    /// The estimate from observations, of which those with a measure that is no number are left out.
    ///
    /// # Errors
    /// Too few observations.
    pub fn of(observations: &[Observation], targets: &[Target], seed: u64) -> Result<Self, String> {
        let all: Vec<&Observation> =
            observations.iter().filter(|o| o.measures.iter().all(|value| value.is_finite())).collect();
        let first = all.iter().min_by(|a, b| distance_of(a, targets).total_cmp(&distance_of(b, targets)));
        let Some(first) = first else { return Err("no run has given all measures".into()) };
        let whole = Self::around(&first.x, &all, targets, seed, 1.0)?;
        let near = Self::around(&whole.best, &all, targets, seed, 2.0 / 3.0)?;
        // A surface says nothing beyond its runs: if the values may lie there, all runs have their say.
        let estimate = if near.fits_better(&whole) && !near.reaches_edge() { near } else { whole };
        let minima = Model::around(&estimate.best, &all, targets, 1.0)?.minima();
        let is_apart = |x: &[f64]| x.iter().zip(&estimate.best).any(|(a, b)| (a - b).abs() > 0.3);
        let as_good = minima.iter().filter(|(x, value)| value - minima[0].1 < 1.0 && is_apart(x));
        let others = as_good.map(|(x, _)| x.clone()).collect();
        Ok(Self { others, ..estimate })
    }

    /// The estimate from the share of the observations that lie nearest to the best values, which begin at a place.
    fn around(
        place: &[f64],
        all: &[&Observation],
        targets: &[Target],
        seed: u64,
        share: f64,
    ) -> Result<Self, String> {
        let mut best = place.to_vec();
        // The surfaces are those of the neighbourhood of the best values, which they move.
        for _ in 0..2 {
            best = Model::around(&best, all, targets, share)?.minima().swap_remove(0).0;
        }
        let model = Model::around(&best, all, targets, share)?;
        let best = model.minima().swap_remove(0).0;
        let samples = model.samples(&best, seed);
        let (dimensions, count) = (best.len(), samples.len() as f64);
        let mean = samples.iter().fold(DVector::zeros(dimensions), |sum, x| sum + x) / count;
        let covariance =
            samples.iter().map(|x| (x - &mean) * (x - &mean).transpose()).sum::<DMatrix<f64>>() / count;
        let interval = |i: usize| {
            let mut along: Vec<f64> = samples.iter().map(|x| x[i]).collect();
            along.sort_by(f64::total_cmp);
            let at = |share: f64| along[((share * count) as usize).min(along.len() - 1)];
            [[at(0.1587), at(0.8413)], [at(0.0228), at(0.9772)]]
        };
        Ok(Self {
            deviation: (0..dimensions).map(|i| covariance[(i, i)].sqrt()).collect(),
            intervals: (0..dimensions).map(interval).collect(),
            misfits: (model.surfaces.iter().zip(targets)).map(|(m, t)| misfit(m, t, &best, &best)).collect(),
            others: Vec::new(),
            used: model.near.len(),
            region: model.region,
            surfaces: model.surfaces,
            covariance,
            best,
        })
    }

    /// Whether the runs deviate clearly less from a surface than from that of another estimate: that one lacks terms.
    fn fits_better(&self, other: &Self) -> bool {
        self.surfaces.iter().zip(&other.surfaces).any(|(own, other)| own.deviation < 0.7 * other.deviation)
    }

    /// Whether the distribution of a quantity reaches an end of the region of the runs that is none of its range.
    fn reaches_edge(&self) -> bool {
        let reaches = |(&[from, to], [_, [lower, upper]]): (&[f64; 2], &[[f64; 2]; 2])| {
            let margin = 0.03 * (to - from);
            from > -1.0 && *lower < from + margin || to < 1.0 && *upper > to - margin
        };
        self.region.iter().zip(&self.intervals).any(reaches)
    }

    /// Correlation of two quantities.
    pub fn correlation(&self, i: usize, j: usize) -> f64 {
        self.covariance[(i, j)] / (self.deviation[i] * self.deviation[j])
    }

    /// Whether a quantity could be nearly anything: the middle 68 % of its distribution take more than half of its range, where
    /// without any measure they would take 68 %.
    pub fn is_unknown(&self, i: usize) -> bool {
        let [from, to] = self.intervals[i][0];
        to - from > 1.0
    }

    /// Whether a quantity is at an end of its range.
    pub fn is_at_bound(&self, i: usize) -> bool {
        self.best[i].abs() > 1.0 - 1e-3
    }

    /// χ² of the best values.
    pub fn chi_squared(&self) -> f64 {
        self.misfits.iter().map(|misfit| misfit * misfit).sum()
    }
}

fn distance_of(observation: &Observation, targets: &[Target]) -> f64 {
    observation.measures.iter().zip(targets).map(|(m, t)| ((m - t.value) / t.uncertainty).powi(2)).sum()
}

/// The share of the observations that lie nearest to a place, and enough for a surface.
fn nearest<'a>(all: &[&'a Observation], place: &[f64], share: f64) -> Vec<&'a Observation> {
    let count = ((share * all.len() as f64).ceil() as usize).max(coefficients(place.len()) + 4);
    let away = |o: &Observation| o.x.iter().zip(place).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    let mut near = all.to_vec();
    near.sort_by(|a, b| away(a).total_cmp(&away(b)));
    near.truncate(count);
    near
}

/// Where observations lie along each coordinate, to its end where no other lies farther out.
fn region_of(near: &[&Observation], all: &[&Observation]) -> Vec<[f64; 2]> {
    let along = |i: usize| {
        let ends = |list: &[&Observation]| {
            list.iter().map(|o| o.x[i]).fold([1.0_f64, -1.0], |[low, high], x| [low.min(x), high.max(x)])
        };
        let ([low, high], [lowest, highest]) = (ends(near), ends(all));
        [if low > lowest { low } else { -1.0 }, if high < highest { high } else { 1.0 }]
    };
    (0..near[0].x.len()).map(along).collect()
}

/// (m − t)/w, with the variance of the surface at another place.
fn misfit(surface: &Surface, target: &Target, x: &[f64], place: &[f64]) -> f64 {
    (surface.value(x) - target.value) / (target.uncertainty.powi(2) + surface.variance(place)).sqrt()
}

/// Surfaces of all measures, and where they hold.
struct Model<'a> {
    targets: &'a [Target],
    near: Vec<&'a Observation>,
    surfaces: Vec<Surface>,
    region: Vec<[f64; 2]>,
}

impl<'a> Model<'a> {
    fn around(
        place: &[f64],
        all: &[&'a Observation],
        targets: &'a [Target],
        share: f64,
    ) -> Result<Self, String> {
        let near = nearest(all, place, share);
        let fit = |j: usize| {
            let points: Vec<(&[f64], f64)> = near.iter().map(|o| (&o.x[..], o.measures[j])).collect();
            Surface::fit(&points)
        };
        let surfaces: Option<Vec<Surface>> = (0..targets.len()).map(fit).collect();
        let surfaces = surfaces.ok_or_else(|| {
            format!(
                "{} runs with all measures are too few, or lie too regularly, for surfaces of second order; {} at least",
                all.len(),
                coefficients(place.len()) + 2
            )
        })?;
        Ok(Self { targets, region: region_of(&near, all), near, surfaces })
    }

    /// Places of least Σ misfit² with their values, the lowest first, those that coincide once.
    fn minima(&self) -> Vec<(Vec<f64>, f64)> {
        let mut starts = self.near.clone();
        starts.sort_by(|a, b| distance_of(a, self.targets).total_cmp(&distance_of(b, self.targets)));
        let mut found: Vec<(Vec<f64>, f64)> = Vec::new();
        for start in starts.iter().take(6) {
            let (x, value) = self.minimise(&start.x);
            let is_known =
                |other: &(Vec<f64>, f64)| other.0.iter().zip(&x).all(|(a, b)| (a - b).abs() < 0.02);
            if !found.iter().any(is_known) {
                found.push((x, value));
            }
        }
        found.sort_by(|a, b| a.1.total_cmp(&b.1));
        found
    }

    /// The minimum that is reached from a place.
    fn minimise(&self, start: &[f64]) -> (Vec<f64>, f64) {
        let mut best = (start.to_vec(), f64::INFINITY);
        // Weights are those of the minimum, which is known better after a first search.
        for _ in 0..2 {
            let place = best.0.clone();
            let sum = |x: &[f64], gradient: Option<&mut [f64]>, _: &mut ()| {
                let measures = || self.surfaces.iter().zip(self.targets);
                let misfits: Vec<f64> = measures().map(|(m, t)| misfit(m, t, x, &place)).collect();
                if let Some(gradient) = gradient {
                    gradient.fill(0.0);
                    for ((surface, target), misfit) in measures().zip(&misfits) {
                        let weight = (target.uncertainty.powi(2) + surface.variance(&place)).sqrt();
                        let slopes = surface.gradient(x);
                        gradient
                            .iter_mut()
                            .zip(slopes)
                            .for_each(|(sum, slope)| *sum += 2.0 * misfit * slope / weight);
                    }
                }
                misfits.iter().map(|misfit| misfit * misfit).sum()
            };
            let bounds: Vec<(f64, f64)> = self.region.iter().map(|&[from, to]| (from, to)).collect();
            let none: [Constraint; 0] = [];
            let tolerances = slsqp::StopTols { ftol_rel: 1e-12, xtol_rel: 1e-8, ..Default::default() };
            let ended = slsqp::minimize(sum, &best.0, &bounds, &none, (), 300, Some(tolerances));
            // A search that ends early has come nearer all the same.
            let (x, value) = match ended {
                Ok((_, x, value)) | Err((_, x, value)) => (x, value),
            };
            if !value.is_finite() {
                break;
            }
            best = (x.iter().zip(&self.region).map(|(c, [from, to])| c.clamp(*from, *to)).collect(), value);
        }
        best
    }

    /// Draws from the distribution of the coordinates.
    fn samples(&self, best: &[f64], seed: u64) -> Vec<DVector<f64>> {
        let dimensions = best.len();
        let log_likelihood = |x: &DVector<f64>| -> f64 {
            if x.iter().zip(&self.region).any(|(c, [from, to])| c < from || c > to) {
                return f64::NEG_INFINITY;
            }
            let of = |(surface, target): (&Surface, &Target)| {
                let [value, variance] = surface.value_and_variance(x.as_slice());
                let variance = target.uncertainty.powi(2) + variance;
                -0.5 * ((value - target.value).powi(2) / variance + variance.ln())
            };
            self.surfaces.iter().zip(self.targets).map(of).sum()
        };
        // Curvature of the likelihood, and that of a distribution that is uniform over the range.
        let mut curvature = DMatrix::identity(dimensions, dimensions) * 3.0;
        for (surface, target) in self.surfaces.iter().zip(self.targets) {
            let slope = DVector::from_vec(surface.gradient(best));
            curvature += &slope * slope.transpose() / (target.uncertainty.powi(2) + surface.variance(best));
        }
        let root = curvature.try_inverse().and_then(DMatrix::cholesky).map(|root| root.l());
        let root = root.unwrap_or_else(|| DMatrix::identity(dimensions, dimensions) * 0.1);
        let step = 2.4 / (dimensions as f64).sqrt();
        let mut random = Random::new(seed, 77);
        let mut here = DVector::from_column_slice(best);
        let mut likelihood = log_likelihood(&here);
        let mut kept = Vec::with_capacity(STEPS);
        for _ in 0..STEPS {
            let normals = DVector::from_fn(dimensions, |_, _| random.normal());
            let next = &here + step * (&root * normals);
            let next_likelihood = log_likelihood(&next);
            if random.uniform().ln() < next_likelihood - likelihood {
                (here, likelihood) = (next, next_likelihood);
            }
            kept.push(here.clone());
        }
        kept
    }
}

#[cfg(test)]
#[path = "estimate_tests.rs"]
mod tests;
