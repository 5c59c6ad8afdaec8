//! Van der Waals forces against their limits.

use grains_contact::VanDerWaals;

const SMOOTH: VanDerWaals = VanDerWaals { hamaker: 1e-19, asperity: 0.0, inner: 4e-10, outer: 1e-7 };
const ROUGH: VanDerWaals = VanDerWaals { asperity: 1e-8, ..SMOOTH };

#[test]
fn smooth_spheres_attract_as_hamaker_says() {
    let (radius, gap) = (20e-6, 2e-9);
    let shift = |scale: f64| scale / (1e-7_f64 * 1e-7);
    let equal = 1e-19 * radius / 12.0;
    assert!((SMOOTH.pull(gap, 0.5 * radius) / (equal / (gap * gap) - shift(equal)) - 1.0).abs() < 1e-12);
    let plane = 1e-19 * radius / 6.0;
    assert!((SMOOTH.pull(gap, radius) / (plane / (gap * gap) - shift(plane)) - 1.0).abs() < 1e-12);
}

/// Asperities part the spheres: at contact c/(c + R) of the smooth force and that at their own distance are left.
#[test]
fn asperities_take_most_of_the_force() {
    let effective = 10e-6;
    let [smooth, rough] = [SMOOTH, ROUGH].map(|law| VanDerWaals { outer: 1e-5, ..law }.pull(0.0, effective));
    let share = 1e-8 / (1e-8 + 20e-6) + (4e-10_f64 / 1.04e-8).powi(2);
    assert!((rough / smooth / share - 1.0).abs() < 1e-3, "{}", rough / smooth);
    // No asperities, or asperities without end: the smooth force.
    for asperity in [1e-20, 1e4] {
        let law = VanDerWaals { asperity, ..SMOOTH };
        assert!((law.pull(1e-9, effective) / SMOOTH.pull(1e-9, effective) - 1.0).abs() < 1e-8);
    }
}

#[test]
fn the_force_is_continuous_at_both_cut_offs_and_its_work_is_its_integral() {
    let effective = 10e-6;
    for law in [SMOOTH, ROUGH] {
        let max_pull = law.pull(-1e-6, effective);
        assert_eq!(max_pull, law.pull(law.inner, effective));
        assert!((law.pull(law.inner * (1.0 + 1e-9), effective) / max_pull - 1.0).abs() < 1e-8);
        assert_eq!(law.pull(law.outer, effective), 0.0);
        assert!(law.pull(law.outer * (1.0 - 1e-9), effective) < 1e-9 * max_pull);
        for from in [0.0, 1e-9, 3e-8, 2e-7] {
            let steps = 400_000;
            let (low, high): (f64, f64) = (f64::max(from, 1e-14).ln(), law.outer.ln());
            let sum: f64 = (0..steps)
                .map(|i| (low + (high - low) * (f64::from(i) + 0.5) / f64::from(steps)).exp())
                .map(|gap| gap * law.pull(gap, effective))
                .sum();
            let integral = (sum * (high - low) / f64::from(steps)).max(0.0);
            let work = law.work(from, effective);
            assert!((work - integral).abs() <= 1e-4 * integral, "{from}: {work} {integral}");
        }
    }
}
