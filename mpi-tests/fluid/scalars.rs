//! Temperature and concentrations that a flow carries among particles.

use super::{assert_close, continued, results_of};
use crate::common::results::{Series, series};
use crate::common::{case, folder, replaced, run_case};
use std::fs;

#[test]
fn scalars_keep_their_sums_and_limits_on_any_ranks_and_wherever_a_run_stops() {
    let (home, text) = (folder("fluid_scalars"), case("heated.toml"));
    let one = results_of(&home, "1", 1, &text);
    let table = series(&one);
    let column = |name: &str| table.column(name);
    for name in ["temperature", "tracer"] {
        let (content, lost) = (column(&format!("{name}_content")), column(&format!("{name}_unaccounted")));
        assert!(content.windows(2).all(|w| w[1] > w[0]), "{name}: {content:?}");
        let largest = content.iter().fold(0.0_f64, |m, x| m.max(*x));
        assert!(lost.iter().all(|x| x.abs() < 1e-11 * largest), "{name}: {lost:?} of {largest}");
    }
    // The pressure solver leaves a little of the volume to the step after.
    let [low, high] = ["tracer_min", "tracer_max"].map(column);
    assert!(low.iter().all(|x| *x > -1e-12) && high.iter().all(|x| *x < 1.0 + 1e-12), "{low:?} {high:?}");
    assert!(*high.last().unwrap() > 0.9, "{high:?}");
    // What came in is what the inlet let in: the tracer through a disc, in the cells whose middle it covers.
    let inlet = 0.6 * 16.0 * (0.02 / 9.0) * (0.018 / 8.0);
    let (times, content) = (column("time"), column("tracer_content"));
    for (time, content) in times.iter().zip(content).skip(1) {
        assert!((content / (inlet * time) - 1.0).abs() < 1e-6, "{content} of {} at {time} s", inlet * time);
    }
    let mut others = [2, 4].map(|ranks| results_of(&home, &ranks.to_string(), ranks, &text)).to_vec();
    others.push(continued(&home, "2", 3, &text));
    let own = home.join("stops");
    fs::create_dir_all(&own).unwrap();
    run_case(2, &own, &text, &["--max-walltime", "0"]).succeeded();
    run_case(1, &own, &text, &["--restart", "latest", "--max-walltime", "0.3"]).succeeded();
    run_case(3, &own, &text, &["--restart", "latest"]).succeeded();
    others.push(own.join("results"));
    for other in &others {
        let found = series(other);
        for name in ["temperature_mean", "temperature_max", "tracer_content", "tracer_max", "fluid_kinetic"] {
            let label = format!("{name} of {}", other.display());
            assert_close(&column(name), &found.column(name), 1e-7, &label);
        }
        for name in ["temperature", "tracer"] {
            let (content, lost) =
                (found.column(&format!("{name}_content")), found.column(&format!("{name}_unaccounted")));
            let largest = content.iter().fold(0.0_f64, |m, x| m.max(*x));
            assert!(lost.iter().all(|x| x.abs() < 1e-11 * largest), "{name}: {lost:?}");
        }
    }
}

/// A scalar that a continued run has and its state has not begins there, with its account; the other ones go on.
#[test]
fn a_scalar_that_is_new_in_a_continued_run_begins_with_its_account() {
    let (home, text) = (folder("fluid_new_scalar"), case("heated.toml"));
    let text = replaced(&text, "end = 0.015", "end = 0.006");
    let text = replaced(&text, "checkpoint = 0.005", "checkpoint = 0.003");
    let whole = series(&results_of(&home, "whole", 2, &text));
    let half = results_of(&home, "half", 2, &replaced(&text, "end = 0.006", "end = 0.003"));
    let dye = "[[fluid.scalar]]\nname = \"dye\"\nkind = \"concentration\"\ndiffusivity = 1e-5\ninitial = \"1 + 20*z\"\n\n\
               [[fluid.scalar.boundary]]\nface = \"-z\"\nkind = \"value\"\nvalue = 1\n\n[output]";
    let own = home.join("dyed");
    fs::create_dir_all(&own).unwrap();
    run_case(3, &own, &replaced(&text, "[output]", dye), &["--restart", half.to_str().unwrap()]).succeeded();
    let dyed = series(&own.join("results"));
    let last = |table: &Series, name: &str| *table.column(name).last().unwrap();
    let (content, lost) = (last(&dyed, "dye_content"), last(&dyed, "dye_unaccounted"));
    assert!(content > 0.0 && lost.abs() < 1e-11 * content, "{lost} of {content}");
    assert!(last(&dyed, "dye_min") > 1.0 - 1e-12 && last(&dyed, "dye_max") < 1.8 + 1e-12);
    for name in ["temperature_content", "tracer_content", "temperature_max"] {
        let (there, here) = (last(&whole, name), last(&dyed, name));
        assert!((here / there - 1.0).abs() < 1e-7, "{name}: {here} instead of {there}");
    }
    assert!(last(&dyed, "temperature_unaccounted").abs() < 1e-11 * last(&dyed, "temperature_content"));
}
