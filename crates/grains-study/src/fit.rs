//! The search for values at which the measures meet their targets.
//!
//! A Latin hypercube begins it. In each round surfaces of second order are fitted to the measures, new
//! best values follow from them ([`crate::estimate`]), and runs at and around those join the rest. It ends when the best values move by less than half
//! their uncertainty and the surfaces add less than a quarter to the variance of the targets, or when no more runs are allowed.

use crate::design::{Values, at, latin_hypercube};
use crate::estimate::{Estimate, Observation};
use crate::random::Random;
use crate::study_file::{Range, Study, Target};
use crate::surface::coefficients;
use nalgebra::{DMatrix, DVector};

/// Points with which the search begins.
pub(crate) fn initial_points(study: &Study) -> usize {
    study.design.samples.unwrap_or(coefficients(study.ranges().len()) + 4)
}

/// Why a search has ended, or that it goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Verdict {
    /// More runs are needed.
    GoesOn,
    /// The best values stay where they are.
    Settled,
    /// No more runs are allowed.
    RunsSpent,
}

/// The state of a search: its estimates, one a round.
pub(crate) struct Search<'s> {
    study: &'s Study,
    ranges: Vec<(&'s str, Range)>,
    /// Names of the measures that have targets, and these.
    pub targets: Vec<(String, Target)>,
    /// Estimates with the numbers of runs that they rest on.
    pub estimates: Vec<(usize, Estimate)>,
}

impl<'s> Search<'s> {
    /// A search that begins.
    pub fn new(study: &'s Study) -> Self {
        let targets = study
            .fit
            .iter()
            .flat_map(|fit| &fit.target)
            .map(|(name, target)| (name.clone(), *target))
            .collect();
        Self { study, ranges: study.ranges(), targets, estimates: Vec::new() }
    }

    /// The points of the first round.
    pub fn first(&self) -> Vec<Values> {
        let shares = latin_hypercube(self.ranges.len(), initial_points(self.study), self.study.design.seed);
        shares.iter().map(|shares| self.at(shares)).collect()
    }

    /// Coordinates from −1 to 1 of values.
    pub fn coordinates(&self, values: &Values) -> Vec<f64> {
        let share = |(name, range): &(&str, Range)| {
            let value = values.get(*name).and_then(toml::Value::as_float).unwrap_or(range.min);
            2.0 * range.share(value) - 1.0
        };
        self.ranges.iter().map(share).collect()
    }

    /// Values at coordinates from −1 to 1.
    pub fn values(&self, x: &[f64]) -> Values {
        let shares: Vec<f64> = x.iter().map(|x| 0.5 * (x + 1.0)).collect();
        self.at(&shares)
    }

    /// Values at shares of the ranges, with those that have one value alone.
    fn at(&self, shares: &[f64]) -> Values {
        let constants = self.study.vary.iter().filter(|(_, vary)| vary.range().is_none());
        let constants =
            constants.filter_map(|(name, vary)| Some((name.clone(), vary.values.first()?.clone())));
        at(&self.ranges, shares).into_iter().chain(constants).collect()
    }

    /// Learns from all runs so far.
    ///
    /// # Errors
    /// Too few runs that have all measures.
    pub fn learn(&mut self, observations: &[Observation]) -> Result<Verdict, String> {
        let targets: Vec<Target> = self.targets.iter().map(|(_, target)| *target).collect();
        let now = Estimate::of(observations, &targets, self.study.design.seed)?;
        let is_settled = self.estimates.last().is_some_and(|(_, before)| is_settled(before, &now, &targets));
        self.estimates.push((observations.len(), now));
        let next = (self.ranges.len() + 1) * self.study.design.repeats;
        let allowed = self.study.fit.as_ref().map_or(0, |fit| fit.max_runs);
        Ok(match (is_settled, observations.len() + next > allowed) {
            (true, _) => Verdict::Settled,
            (false, true) => Verdict::RunsSpent,
            (false, false) => Verdict::GoesOn,
        })
    }

    /// The points of the next round: the best values, and as many around them as there are quantities, twice as far as these are
    /// uncertain and a tenth of their range at least.
    pub fn next(&self) -> Vec<Values> {
        let Some((_, last)) = self.estimates.last() else { return Vec::new() };
        let dimensions = last.best.len();
        let spread = &last.covariance * 4.0 + DMatrix::identity(dimensions, dimensions) * 0.04;
        let root = spread.cholesky().map(|root| root.l());
        let root = root.unwrap_or_else(|| DMatrix::identity(dimensions, dimensions) * 0.1);
        let mut random = Random::new(self.study.design.seed, 2000 + self.estimates.len() as u64);
        let around = |_| {
            let normals = DVector::from_fn(dimensions, |_, _| random.normal());
            let x = DVector::from_column_slice(&last.best) + &root * normals;
            x.iter().map(|c| c.clamp(-1.0, 1.0)).collect::<Vec<f64>>()
        };
        let places: Vec<Vec<f64>> =
            std::iter::once(last.best.clone()).chain((0..dimensions).map(around)).collect();
        places.iter().map(|x| self.values(x)).collect()
    }
}

/// Whether an estimate stays where the one before was, and more runs would not make it much better.
fn is_settled(before: &Estimate, now: &Estimate, targets: &[Target]) -> bool {
    let stays = (0..now.best.len()).all(|i| (now.best[i] - before.best[i]).abs() < 0.5 * now.deviation[i]);
    let is_known = |(surface, target): (&crate::surface::Surface, &Target)| {
        surface.variance(&now.best) < 0.25 * target.uncertainty.powi(2)
    };
    stays && now.surfaces.iter().zip(targets).all(is_known)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A study of two quantities, one of them over three decades.
    fn study() -> Study {
        let text = "case = \"a.toml\"\n[vary]\na = { key = \"x\", min = 0, max = 1 }\nb = { key = \"y\", min = 1e-3, max = 1, log = true }\n[measure]\np = { column = \"p\" }\nq = { column = \"q\" }\n[fit]\nmax_runs = 40\ntarget = { p = { value = 1.2, uncertainty = 0.03 }, q = { value = -1.1, uncertainty = 0.05 } }\n";
        Study::parse(text, "s.toml").unwrap()
    }

    /// A search over a model that is no polynomial and scatters. The answer is a = 0.6, b = 10^−1.5.
    fn searched(seed: u64) -> (Values, Estimate, Verdict, usize) {
        let mut study = study();
        study.design.seed = seed;
        let mut search = Search::new(&study);
        let mut random = Random::new(seed, 9);
        let mut model = |values: &Values| {
            let (a, b) = (values["a"].as_float().unwrap(), values["b"].as_float().unwrap().log10());
            let p = (1.5 * a).tanh() / 0.9_f64.tanh() * 1.2 + 0.2 * (b + 1.5);
            let q = -1.1 + 0.8 * ((b + 1.5) / 1.2).sin() - 0.5 * (a - 0.6);
            vec![p + 0.03 * random.normal(), q + 0.05 * random.normal()]
        };
        let mut observations = Vec::new();
        let mut points = search.first();
        loop {
            observations
                .extend(points.iter().map(|v| Observation { x: search.coordinates(v), measures: model(v) }));
            let verdict = search.learn(&observations).unwrap();
            if verdict != Verdict::GoesOn {
                let (runs, last) = search.estimates.pop().unwrap();
                return (search.values(&last.best), last, verdict, runs);
            }
            points = search.next();
        }
    }

    #[test]
    fn the_search_finds_known_values_within_its_uncertainty() {
        let (mut inside, mut settled) = ([0, 0], 0);
        for seed in 0..30 {
            let (values, estimate, verdict, runs) = searched(seed);
            assert!(runs <= 40);
            settled += u32::from(verdict == Verdict::Settled);
            let truth = [2.0 * 0.6 - 1.0, 2.0 * (3.0 - 1.5) / 3.0 - 1.0];
            for (i, truth) in truth.iter().enumerate() {
                assert!(
                    (estimate.best[i] - truth).abs() < 5.0 * estimate.deviation[i],
                    "seed {seed}: {values:?}"
                );
                let [_, [from, to]] = estimate.intervals[i];
                inside[i] += u32::from(from <= *truth && *truth <= to);
            }
        }
        assert!(inside.iter().all(|&count| count >= 26), "{inside:?} of 30 within 95 %");
        assert!(settled >= 15, "{settled} of 30 settled");
    }

    #[test]
    fn a_search_is_the_same_when_it_is_replayed() {
        let (first, second) = (searched(3), searched(3));
        assert_eq!((first.0, first.3), (second.0, second.3));
    }
}
