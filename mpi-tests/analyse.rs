//! Analyses of stored states: the same on any number of ranks, and understandable when they cannot be made.

#![allow(clippy::unwrap_used)]

mod common;

use common::{case, folder, replaced, run, run_case};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// All analyses with options that use most of them.
const ANALYSES: [&[&str]; 11] = [
    &["void-fraction", "results", "--cells", "3e5", "--radial", "axis", "--refine", "--crop", "1"],
    &["ranking", "results", "--crop", "0"],
    &["profiles", "results", "--time", "0.1:", "--bins", "7"],
    &["coordination", "results", "--time", "all"],
    &["orientation", "results", "--shape", "dodecahedron", "--time", "0.2"],
    &["run-out", "results", "--direction", "-x", "--length", "0.02", "--time", "all"],
    &["drum", "results", "--time", "0.15:", "--wall", "drum"],
    &["granular-temperature", "results", "--time", "all", "--cell", "0.02"],
    &["mixing", "results", "--time", "0.1:", "--cell", "0.02", "--min", "3"],
    &["flow-rate", "results", "--window", "0.03"],
    &["radial-distribution", "results", "--time", "0.1:", "--bins", "20"],
];

/// The tables and pictures of a folder, by name.
fn files(folder: &Path) -> BTreeMap<String, String> {
    let entries = fs::read_dir(folder).unwrap().flatten();
    entries.map(|e| (e.file_name().into_string().unwrap(), fs::read_to_string(e.path()).unwrap())).collect()
}

/// Values of a column of a table.
fn column(text: &str, name: &str) -> Vec<f64> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let at = lines.next().unwrap().split(',').position(|column| column == name).unwrap();
    lines.map(|line| line.split(',').nth(at).unwrap().parse().unwrap()).collect()
}

#[test]
fn every_analysis_writes_the_same_files_on_one_two_and_three_ranks() {
    let home = folder("analyse_ranks");
    let plane = "[[flow_plane]]\nname = \"middle\"\npoint = [0, 0, -0.01]\nnormal = [0, 0, -1]\n\n[output]";
    run_case(2, &home, &replaced(&case("drum.toml"), "[output]", plane), &[]).succeeded();
    let mut said = Vec::new();
    for ranks in 1..=3 {
        let place = format!("on-{ranks}");
        let outputs = ANALYSES.map(|words| {
            let output =
                run(ranks, &home, &[&["analyse"], words, &["--output", &place]].concat()).succeeded();
            assert!(output.stdout.contains(".csv") && output.stdout.contains(".svg"), "{}", output.text());
            output.stdout.replace(&place, "")
        });
        said.push(outputs);
    }
    let [one, two, three] = [1, 2, 3].map(|ranks| files(&home.join(format!("on-{ranks}"))));
    assert!(one.len() >= 25, "{:?}", one.keys());
    assert_eq!(one, two);
    assert_eq!(one, three);
    assert_eq!(said[0], said[1]);
    assert_eq!(said[0], said[2]);
    for (name, text) in &one {
        match name.ends_with(".svg") {
            true => assert!(text.contains("<svg") && text.contains("</svg>"), "{name}"),
            false => {
                for comment in
                    ["# program: grains-mpi", "# run: results/particles.vtkhdf", "# time: ", "# units: "]
                {
                    assert!(text.contains(comment), "{name}: {text}");
                }
            }
        }
    }
    // A quarter of the states are after the last insertion, of 64 particles.
    assert!(column(&one["coordination.csv"], "particles").ends_with(&[64.0, 64.0]));
    let void = column(&one["void-fraction.csv"], "void_fraction")[0];
    assert!((0.3..1.0).contains(&void), "{void}");
    assert!(column(&one["orientation.csv"], "particles") == [16.0]);
    let index = column(&one["mixing.csv"], "ball_mixing_index");
    assert!(index.iter().all(|m| (-0.5..1.5).contains(m)), "{index:?}");
    // All particles begin above the plane; what the windows show is what passed, less what passed after the last one.
    let passed: f64 = column(&one["flow-rate.csv"], "middle_count_rate").iter().map(|rate| 0.03 * rate).sum();
    assert!((1.0..=64.0).contains(&passed), "{passed}");
}

#[test]
fn a_checkpoint_is_analysed_like_the_snapshot_of_its_time() {
    let home = folder("analyse_checkpoint");
    run_case(2, &home, &case("drum.toml"), &[]).succeeded();
    let mut saved: Vec<_> = fs::read_dir(home.join("results")).unwrap().flatten().map(|e| e.path()).collect();
    saved.retain(|p| p.extension().is_some_and(|e| e == "h5"));
    saved.sort();
    let last = saved.last().unwrap().to_str().unwrap();
    for what in ["drum", "profiles", "granular-temperature"] {
        run(2, &home, &["analyse", what, last, "--output", "a"]).succeeded();
        run(1, &home, &["analyse", what, "results", "--time", "0.24", "--output", "b"]).succeeded();
    }
    let without_origin = |name: &str| {
        let all = files(&home.join(name));
        let text =
            |text: &str| text.lines().filter(|l| !l.starts_with("# run")).collect::<Vec<_>>().join("\n");
        all.into_iter().map(|(name, content)| (name, text(&content))).collect::<BTreeMap<_, _>>()
    };
    let (a, b) = (without_origin("a"), without_origin("b"));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for name in ["drum.csv", "profiles-axial.csv", "granular-temperature.csv"] {
        for (one, other) in a[name].split([',', '\n']).zip(b[name].split([',', '\n'])) {
            // Radius over bounding radius may differ in the last bit from the scale that was stored.
            let [x, y] = [one, other].map(|word| word.parse::<f64>().ok());
            let close =
                |x: f64, y: f64| (x - y).abs() <= 1e-12 * x.abs().max(y.abs()) || x.is_nan() && y.is_nan();
            assert!(x.zip(y).map_or(one == other, |(x, y)| close(x, y)), "{name}: {one}, {other}");
        }
    }
    let refused = run(1, &home, &["analyse", "coordination", last]);
    assert!(refused.only_error(2).contains("particles.vtkhdf"), "{}", refused.text());
}

#[test]
fn what_cannot_be_analysed_is_said_with_the_key_or_option() {
    let home = folder("analyse_refused");
    let text = replaced(&case("drum.toml"), "series = 0.003", "series = 0.003\nfields = [\"velocity\"]");
    let text = replaced(&text, "end = 0.24", "end = 0.08");
    run_case(1, &home, &text, &[]).succeeded();
    fs::write(home.join("no.vtkhdf"), "nothing").unwrap();
    let refusals: [(&[&str], i32, &str); 7] = [
        (
            &["drum", "results"],
            2,
            "`material`, which `analyse drum` needs: add \"material\" to output.fields",
        ),
        (&["coordination", "results"], 2, "`coordination`"),
        (&["profiles", "results", "--time", "7:8"], 2, "--time"),
        (&["void-fraction", "nowhere"], 4, "nowhere: does not exist"),
        (&["void-fraction", "no.vtkhdf"], 4, "no.vtkhdf: cannot be read as snapshots"),
        (&["void-fraction", "results", "--upper", "0,0,9", "--time", "first"], 2, "--upper"),
        (&["orientation", "results", "--shape", "cube"], 2, "it has ball, dodecahedron"),
    ];
    for (words, code, part) in refusals {
        for ranks in [1, 2] {
            let refused = run(ranks, &home, &[&["analyse"], words].concat());
            assert!(refused.only_error(code).contains(part), "{words:?}: {}", refused.text());
        }
    }
    // Before the first insertion there are no particles; that is no error.
    for what in ["void-fraction", "ranking", "profiles", "granular-temperature"] {
        run(2, &home, &["analyse", what, "results", "--time", "first", "--output", "none"]).succeeded();
    }
    assert!(!home.join("results/analysis").exists());
}

#[test]
fn resolved_flows_are_analysed_alike_on_any_number_of_ranks() {
    let (array, packed) = (folder("analyse_array"), folder("analyse_packed"));
    run_case(2, &array, &case("array.toml"), &[]).succeeded();
    run_case(2, &packed, &case("packed.toml"), &[]).succeeded();
    let analyses: [(&Path, &[&str]); 3] = [
        (&array, &["friction", "results"]),
        (&packed, &["bed", "results", "--crop", "0.5,0.6m", "--time", "0.1:"]),
        (&packed, &["ergun", "results", "results", "--crop", "0"]),
    ];
    for (home, words) in analyses {
        let said = [1, 2, 3].map(|ranks| {
            let place = format!("{}-on-{ranks}", words[0]);
            let output = run(ranks, home, &[&["analyse"], words, &["--output", &place]].concat()).succeeded();
            output.stdout.replace(&place, "")
        });
        let [one, two, three] = [1, 2, 3].map(|ranks| files(&home.join(format!("{}-on-{ranks}", words[0]))));
        assert!(
            one == two && one == three && said[0] == said[1] && said[0] == said[2],
            "{words:?}: {said:?}"
        );
    }
    let table = |home: &Path, path: &str| fs::read_to_string(home.join(path)).unwrap();
    let friction = table(&array, "friction-on-1/friction.csv");
    let last = |name: &str| *column(&friction, name).last().unwrap();
    // Six rows, of a solid fraction of an eighth: the drag is some times that of one sphere alone.
    assert_eq!(column(&friction, "time").len(), 6);
    assert!(
        (last("solid_fraction") - 0.125).abs() < 1e-12 && (4.0..5.0).contains(&last("friction")),
        "{friction}"
    );
    let bed = table(&packed, "bed-on-1/bed.csv");
    let [first, second] = ["alpha", "tortuosity"].map(|name| column(&bed, name));
    assert!(first.len() == 2 && first.iter().all(|alpha| (100.0..300.0).contains(alpha)), "{bed}");
    assert!(second.iter().all(|tortuosity| (1.0..1.3).contains(tortuosity)), "{bed}");
    // By continuity that of the inlet, though the flow goes down.
    assert!((column(&bed, "superficial_velocity")[1] / 0.01 - 1.0).abs() < 1e-9, "{bed}");
    assert_eq!(column(&table(&packed, "bed-on-1/bed-axial.csv"), "void_fraction").len(), 2 * 48);
    let ergun = table(&packed, "ergun-on-1/ergun-fit.csv");
    assert!(column(&ergun, "runs") == [2.0] && column(&ergun, "beta")[0].is_nan(), "{ergun}");
}

#[test]
fn what_resolved_flows_need_is_said_with_the_remedy() {
    let (array, packed) = (folder("analyse_no_drive"), folder("analyse_no_field"));
    run_case(1, &array, &case("array.toml"), &[]).succeeded();
    let without =
        replaced(&case("packed.toml"), "[output]", "[fluid.output]\nfields = [\"velocity\"]\n\n[output]");
    run_case(1, &packed, &replaced(&without, "end = 0.2", "end = 0.1"), &[]).succeeded();
    let dry = folder("analyse_dry");
    run_case(1, &dry, &replaced(&case("drum.toml"), "end = 0.24", "end = 0.02"), &[]).succeeded();
    let refusals: [(&Path, &[&str], i32, &str); 6] = [
        (&dry, &["bed", "results"], 2, "give a run of one with `fluid.resolved`"),
        (&dry, &["friction", "results"], 2, "which `analyse friction` needs"),
        (&packed, &["bed", "results"], 2, "add \"pressure\" to fluid.output.fields"),
        (&packed, &["friction", "results"], 2, "`fluid.drive` along a periodic axis"),
        (&array, &["bed", "results"], 2, "periodic along x"),
        (&array, &["ergun", "results", "nowhere"], 2, "periodic along x"),
    ];
    for (home, words, code, part) in refusals {
        for ranks in [1, 2] {
            let refused = run(ranks, home, &[&["analyse"], words].concat());
            assert!(refused.only_error(code).contains(part), "{words:?}: {}", refused.text());
        }
    }
    fs::remove_file(packed.join("results/fluid.vtkhdf")).unwrap();
    fs::remove_file(array.join("results/series.csv")).unwrap();
    let refused = run(2, &packed, &["analyse", "bed", "results"]);
    assert!(refused.only_error(4).contains("fluid.output.interval above 0"), "{}", refused.text());
    let refused = run(2, &array, &["analyse", "friction", "results"]);
    assert!(refused.only_error(4).contains("output.series > 0"), "{}", refused.text());
}
