//! Draws against closed forms, by number and by mass.

use super::Sizes;
use crate::random::Draw;
use grains_case::{Basis, SizeDistribution};
use libm::{erf, exp, log};
use std::f64::consts::{PI, SQRT_2};

const BASES: [Basis; 2] = [Basis::Number, Basis::Mass];

/// Cumulative distribution of sizes.
type Closed = Box<dyn Fn(f64) -> f64>;

/// A cumulative distribution cut at both ends.
fn cut(uncut: impl Fn(f64) -> f64 + 'static, [min, max]: [f64; 2]) -> Closed {
    let [below, above] = [uncut(min), uncut(max)];
    Box::new(move |d| (uncut(d.clamp(min, max)) - below) / (above - below))
}

fn phi(y: f64) -> f64 {
    0.5 * (1.0 + erf(y / SQRT_2))
}

/// Rows of a sieve curve that is steep, flat and steep again.
const ROWS: [[f64; 2]; 6] = [[0.25, 0.0], [0.5, 0.05], [0.71, 0.3], [1.0, 0.3], [1.4, 0.8], [2.0, 1.0]];

fn curve(d: f64) -> f64 {
    let above = ROWS.iter().position(|row| row[0] >= d).unwrap_or(ROWS.len() - 1).max(1);
    let [[a, below], [b, up_to]] = [ROWS[above - 1], ROWS[above]];
    below + (up_to - below) * ((d - a) / (b - a)).clamp(0.0, 1.0)
}

/// Every continuous kind, and its cumulative distribution on its own basis.
fn kinds(by: Basis) -> Vec<(SizeDistribution, Closed)> {
    let (min, max) = (0.4, 2.5);
    let normal = |mean: f64, deviation: f64| {
        let law = SizeDistribution::Normal { by, mean, deviation, min, max };
        (law, cut(move |d| phi((d - mean) / deviation), [min, max]))
    };
    let log_normal = |median: f64, geometric_deviation: f64| {
        let law = SizeDistribution::LogNormal { by, median, geometric_deviation, min, max };
        (law, cut(move |d| phi(log(d / median) / log(geometric_deviation)), [min, max]))
    };
    let weibull = |characteristic: f64, exponent: f64| {
        let law = SizeDistribution::Weibull { by, characteristic, exponent, min, max };
        (law, cut(move |d| 1.0 - exp(-libm::pow(d / characteristic, exponent)), [min, max]))
    };
    let sieve = |min, max| SizeDistribution::Sieve { by, passing: ROWS.to_vec(), path: None, min, max };
    vec![
        (SizeDistribution::Uniform { by, min, max }, cut(|d| d, [min, max])),
        normal(1.0, 0.3),
        normal(2.4, 1.5),
        normal(1.0, 1e-3),
        log_normal(0.8, 1.5),
        log_normal(0.5, 4.0),
        log_normal(1.0, 1.0001),
        weibull(1.2, 3.5),
        weibull(0.9, 0.7),
        weibull(1.0, 3.0),
        weibull(1.1, 300.0),
        (sieve(None, None), Box::new(curve)),
        (sieve(Some(0.6), Some(1.7)), cut(curve, [0.6, 1.7])),
    ]
}

/// Sizes of particles as an insertion draws them.
fn drawn(sizes: &Sizes, count: u64, seed: u64) -> Vec<f64> {
    let mut drawn: Vec<f64> =
        (0..count).map(|id| sizes.quantile(Basis::Number, Draw::new(seed, id, 1).next())).collect();
    drawn.sort_by(f64::total_cmp);
    drawn
}

/// The Kolmogorov-Smirnov distance of weighted sizes, ascending, from a distribution, times the root of their effective number
/// (Σw)²/Σw²: above 1.95 by chance once in a thousand times.
fn distance(sizes: &[f64], weight: impl Fn(f64) -> f64, wanted: impl Fn(f64) -> f64) -> f64 {
    let total: f64 = sizes.iter().map(|&d| weight(d)).sum();
    let squares: f64 = sizes.iter().map(|&d| weight(d).powi(2)).sum();
    let (mut sum, mut largest) = (0.0, 0.0_f64);
    for &d in sizes {
        let before = sum / total;
        sum += weight(d);
        largest = largest.max((wanted(d) - before).abs()).max((sum / total - wanted(d)).abs());
    }
    largest * total / squares.sqrt()
}

/// By number each particle counts once, by mass with the cube of its size.
#[test]
fn draws_of_every_kind_follow_its_closed_cumulative_distribution_by_number_and_by_mass() {
    for by in BASES {
        for (seed, (given, wanted)) in (1..).zip(kinds(by)) {
            let sizes = drawn(&Sizes::of(&given), 100_000, seed);
            let weight = |d: f64| if by == Basis::Mass { d * d * d } else { 1.0 };
            let distance = distance(&sizes, weight, wanted);
            println!("{distance:.2} {given:?}");
            assert!(distance < 1.95, "{distance} {given:?}");
        }
    }
}

/// Numbers of distributions by mass whose density weighted with d⁻³ has a closed integral.
fn numbers_of_masses() -> Vec<(SizeDistribution, Closed)> {
    let (by, min, max) = (Basis::Mass, 0.4, 2.5);
    let (median, geometric_deviation, characteristic) = (0.9_f64, 1.6_f64, 1.1);
    let deviation = log(geometric_deviation);
    vec![
        (SizeDistribution::Uniform { by, min, max }, cut(|d| -1.0 / (d * d), [min, max])),
        (
            SizeDistribution::LogNormal { by, median, geometric_deviation, min, max },
            // Hatch and Choate (1929): ln d_0 = ln d_3 − 3 ln² σ_g.
            cut(move |d| phi(log(d / median) / deviation + 3.0 * deviation), [min, max]),
        ),
        (
            SizeDistribution::Weibull { by, characteristic, exponent: 6.0, min, max },
            // ∫ t^(−1/2) exp(−t) dt = √π erf(√t) with t = (d/d_63)⁶.
            cut(move |d| PI.sqrt() * erf(libm::pow(d / characteristic, 3.0)), [min, max]),
        ),
    ]
}

#[test]
fn numbers_drawn_of_a_distribution_by_mass_are_its_density_over_the_cube() {
    for (seed, (given, wanted)) in (1..).zip(numbers_of_masses()) {
        let distance = distance(&drawn(&Sizes::of(&given), 100_000, seed), |_| 1.0, wanted);
        assert!(distance < 1.95, "{distance} {given:?}");
    }
}

/// What the table leaves of errors, far below what any number of draws shows.
#[test]
fn quantiles_invert_closed_cumulative_distributions() {
    let error = |sizes: &Sizes, basis: Basis, wanted: &Closed| {
        let fractions = (0..200_000).map(|k| (f64::from(k) + 0.37) / 2e5);
        let error = |u: f64| (wanted(sizes.quantile(basis, u)) - u).abs();
        // The tails, too.
        let tails = (1..52).flat_map(|k| [libm::exp2(-f64::from(k)), 1.0 - libm::exp2(-f64::from(k))]);
        fractions.chain(tails).map(error).fold(0.0, f64::max)
    };
    let own = BASES.into_iter().flat_map(|by| kinds(by).into_iter().map(move |kind| (by, kind)));
    let others = numbers_of_masses().into_iter().map(|kind| (Basis::Number, kind));
    for (basis, (given, wanted)) in own.chain(others) {
        let error = error(&Sizes::of(&given), basis, &wanted);
        println!("{error:.1e} {given:?}");
        assert!(error < 2e-9, "{error:e} {given:?}");
    }
}

/// Two ways to the same thing: a distribution by mass, and the same one by number as drawn from it.
#[test]
fn means_are_those_of_many_quantiles() {
    const COUNT: u32 = 200_000;
    for by in BASES {
        for (given, _) in kinds(by) {
            let sizes = Sizes::of(&given);
            let quantiles = (0..COUNT).map(|k| (f64::from(k) + 0.5) / f64::from(COUNT));
            let drawn: Vec<f64> = quantiles.map(|u| sizes.quantile(Basis::Number, u)).collect();
            let moment = |power: i32| drawn.iter().map(|d| d.powi(power)).sum::<f64>();
            let [number, mass] = [moment(1) / moment(0), moment(4) / moment(3)];
            let [mean, mean_by_mass] = BASES.map(|basis| sizes.mean(basis));
            assert!((mean / number - 1.0).abs() < 1e-5, "{mean} {number} {given:?}");
            assert!((mean_by_mass / mass - 1.0).abs() < 1e-5, "{mean_by_mass} {mass} {given:?}");
        }
    }
}

#[test]
fn a_drawn_population_has_the_mass_fractions_of_its_sieve_table() {
    let passing = ROWS.to_vec();
    let given = SizeDistribution::Sieve { by: Basis::Mass, passing, path: None, min: None, max: None };
    let sizes = drawn(&Sizes::of(&given), 1_000_000, 7);
    let mass = |sizes: &[f64]| sizes.iter().map(|d| d * d * d).sum::<f64>();
    let total = mass(&sizes);
    for [size, fraction] in ROWS {
        let found = mass(&sizes[..sizes.partition_point(|d| *d < size)]) / total;
        println!("{size} {fraction} {found:.5}");
        // The largest sizes are one in a hundred: the standard error of their mass is 0.3 %.
        assert!((found - fraction).abs() < 5e-3, "{size}: {found} instead of {fraction}");
    }
    assert!(sizes.iter().all(|d| (0.25..=2.0).contains(d) && !(0.7101..0.9999).contains(d)));
}

#[test]
fn a_table_by_mass_draws_each_size_as_often_as_its_share_over_its_cube() {
    let (values, shares) = (vec![2.0, 0.5, 1.0, 3.0], vec![8.0, 0.125, 3.0, 0.0]);
    let of = |by: Basis| {
        Sizes::of(&SizeDistribution::Table { by, values: values.clone(), shares: shares.clone() })
    };
    let count =
        |sizes: &Sizes, value: f64| drawn(sizes, 100_000, 7).iter().filter(|d| **d == value).count() as f64;
    // By mass 1, 1 and 3 particles in 5, by number 8, 0.125 and 3 in 11.125.
    let [by_number, by_mass] = BASES.map(of);
    for (value, mass, number) in
        [(2.0, 0.2, 8.0 / 11.125), (0.5, 0.2, 0.125 / 11.125), (1.0, 0.6, 3.0 / 11.125)]
    {
        assert!((count(&by_mass, value) / 1e5 - mass).abs() < 5e-3, "{value}");
        assert!((count(&by_number, value) / 1e5 - number).abs() < 5e-3, "{value}");
    }
    assert_eq!(by_mass.quantile(Basis::Mass, 0.005), 0.5);
    assert_eq!(by_mass.quantile(Basis::Mass, 0.99), 2.0);
}

/// Sizes of any spread, cut anywhere: all draws are between the cut-offs, and larger numbers give larger sizes.
#[test]
fn draws_of_extreme_distributions_stay_between_the_cut_offs_and_ascend() {
    let mut draw = Draw::new(1, 2, 3);
    for _ in 0..300 {
        let by = BASES[usize::from(draw.next() < 0.5)];
        let mut ratio = |decades: f64| libm::pow(10.0, decades * draw.next());
        let (middle, spread) = (1e-9 * ratio(12.0), 1e-8 * ratio(14.0));
        let (min, max) = (middle / ratio(3.0), middle * ratio(3.0));
        for given in [
            SizeDistribution::Uniform { by, min, max },
            SizeDistribution::Normal { by, mean: middle, deviation: spread * middle, min, max },
            SizeDistribution::LogNormal { by, median: middle, geometric_deviation: 1.0 + spread, min, max },
            SizeDistribution::Weibull { by, characteristic: middle, exponent: 1.0 / spread, min, max },
        ] {
            let sizes = Sizes::of(&given);
            for basis in BASES {
                let mean = sizes.mean(basis);
                assert!(min * (1.0 - 1e-12) <= mean && mean <= max * (1.0 + 1e-12), "{mean} {given:?}");
                let mut last = min;
                for k in 0..1000 {
                    let size = sizes.quantile(basis, f64::from(k) / 1000.0);
                    assert!(last <= size && size <= max, "{size} after {last} of {given:?}");
                    last = size;
                }
            }
        }
    }
}
