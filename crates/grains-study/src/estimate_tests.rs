//! The estimate against models whose answer is known.

use super::*;

/// Observations of a model of two quantities at random places, with noise.
fn observed(
    count: usize,
    noise: f64,
    random: &mut Random,
    model: impl Fn(&[f64]) -> Vec<f64>,
) -> Vec<Observation> {
    (0..count)
        .map(|_| {
            let x: Vec<f64> = (0..2).map(|_| 2.0 * random.uniform() - 1.0).collect();
            let measures = model(&x).iter().map(|value| value + noise * random.normal()).collect();
            Observation { x, measures }
        })
        .collect()
}

fn model(x: &[f64]) -> Vec<f64> {
    vec![5.0 + 2.0 * x[0] + 0.5 * x[1] + 0.3 * x[0] * x[0], 1.0 - 0.5 * x[0] + 1.5 * x[1] - 0.2 * x[0] * x[1]]
}

/// Of 200 trials, in each of which runs scatter and the targets are measured anew, the truth lies as often in the intervals as
/// they say.
#[test]
fn intervals_hold_the_truth_as_often_as_they_say() {
    let (truth, uncertainty) = ([0.2, -0.3], 0.1);
    let mut inside = [[0; 2]; 2];
    let trials = 200;
    for trial in 0..trials {
        let mut random = Random::new(trial, 1);
        let observations = observed(20, 0.2, &mut random, model);
        let targets: Vec<Target> = model(&truth)
            .iter()
            .map(|value| Target { value: value + uncertainty * random.normal(), uncertainty })
            .collect();
        let estimate = Estimate::of(&observations, &targets, trial).unwrap();
        for (i, truth) in truth.iter().enumerate() {
            for (level, [from, to]) in estimate.intervals[i].iter().enumerate() {
                inside[level][i] += u64::from(from <= truth && truth <= to);
            }
        }
    }
    // Binomial deviations are 3.3 % and 1.5 %.
    let [one, two] = inside.map(|counts| counts.map(|count| count as f64 / trials as f64));
    println!("{one:?} and {two:?} inside");
    assert!(one.iter().all(|share| (0.60..=0.78).contains(share)), "{one:?}");
    assert!(two.iter().all(|share| *share > 0.91), "{two:?}");
}

#[test]
fn a_quantity_that_no_measure_tells_is_known_as_such_and_one_beyond_its_range_too() {
    let mut random = Random::new(5, 1);
    let observations = observed(24, 0.01, &mut random, |x| vec![3.0 * x[0]]);
    let estimate = Estimate::of(&observations, &[Target { value: 0.6, uncertainty: 0.05 }], 1).unwrap();
    assert!((estimate.best[0] - 0.2).abs() < 0.02, "{:?}", estimate.best);
    assert!(!estimate.is_unknown(0) && estimate.is_unknown(1), "{:?}", estimate.intervals);
    let estimate = Estimate::of(&observations, &[Target { value: 6.0, uncertainty: 0.05 }], 1).unwrap();
    assert!(
        estimate.is_at_bound(0) && estimate.misfits[0] < -20.0,
        "{:?} {:?}",
        estimate.best,
        estimate.misfits
    );
}

#[test]
fn two_quantities_that_only_their_sum_tells_are_correlated() {
    let mut random = Random::new(6, 1);
    let observations = observed(24, 0.01, &mut random, |x| vec![x[0] + x[1]]);
    let estimate = Estimate::of(&observations, &[Target { value: 0.0, uncertainty: 0.02 }], 1).unwrap();
    assert!(estimate.correlation(0, 1) < -0.98, "{}", estimate.correlation(0, 1));
    assert!(estimate.is_unknown(0) && estimate.is_unknown(1), "{:?}", estimate.intervals);
}

#[test]
fn a_parabola_meets_its_target_twice() {
    let mut random = Random::new(7, 1);
    let observations = observed(24, 0.001, &mut random, |x| vec![x[0] * x[0], x[1]]);
    let target = |value| Target { value, uncertainty: 0.01 };
    let estimate = Estimate::of(&observations, &[target(0.25), target(0.0)], 1).unwrap();
    assert!((estimate.best[0].abs() - 0.5).abs() < 0.02, "{:?}", estimate.best);
    assert!(estimate.others.iter().any(|x| (x[0] + estimate.best[0]).abs() < 0.02), "{:?}", estimate.others);
}

#[test]
fn too_few_observations_are_refused() {
    let mut random = Random::new(8, 1);
    let mut observations = observed(10, 0.1, &mut random, model);
    observations.iter_mut().skip(7).for_each(|o| o.measures[1] = f64::NAN);
    let targets = [Target { value: 5.0, uncertainty: 0.1 }; 2];
    assert!(Estimate::of(&observations, &targets, 1).unwrap_err().contains("7 runs"));
}
