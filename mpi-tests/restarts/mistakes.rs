//! Mistakes at restarts: what is no checkpoint is refused, and what is seldom meant is warned of when the run begins.

use crate::common::{case, folder, replaced, run_case};
use std::fs;
use std::path::Path;

/// What is no checkpoint, what `--restart` names, and words of the answer.
const NO_CHECKPOINTS: &[(&str, &str, &str)] = &[
    ("a file that is missing", "results/nothing.h5", "`checkpoint-000000000500.h5`: name one of them"),
    ("a folder that is missing", "nowhere/", "or take `--restart latest`"),
    ("a number of a step", "500", "`checkpoint-000000000500.h5`: name one of them"),
    ("latest with a capital", "Latest", "did you mean `--restart latest`?"),
    ("last for latest", "last", "did you mean `--restart latest`?"),
    ("a folder without checkpoints", "empty", "run without --restart"),
    ("snapshots", "results/particles.vtkhdf", "insert.place = { kind = \"file\", path ="),
    ("a time series", "results/series.csv", "checkpoint-STEP.h5"),
    ("a case file", "case.toml", "checkpoint-STEP.h5"),
    ("a file of another program", "other.h5", "it is no checkpoint"),
];

/// What is done, the passage of the case, what stands in its place, the key named, and words of the warning.
const WARNED: &[(&str, &str, &str, &str, &str)] = &[
    ("an end that is reached", "end = 0.02", "end = 0.02", "time.end = 0.02", "no step is made"),
    ("an end before the checkpoint", "end = 0.02", "end = 0.01", "time.end = 0.01", "raise it (s)"),
    (
        "an insertion renamed",
        "name = \"balls\"",
        "name = \"beads\"",
        "insert[0].name = \"beads\"",
        "keep the name \"balls\"",
    ),
    ("fewer particles", "count = 16", "count = 10", "insert[0].count = 10", "none is removed"),
    (
        "a contact three times stiffer",
        "between = [\"glass\", \"wall\"]\nnormal_stiffness = 1e4",
        "between = [\"glass\", \"wall\"]\nnormal_stiffness = 3e4",
        "contact[1].normal_stiffness = 3e4",
        "a bed at rest bursts",
    ),
    (
        "a contact ten times softer",
        "between = [\"glass\", \"glass\"]\nnormal_stiffness = 1e4",
        "between = [\"glass\", \"glass\"]\nnormal_stiffness = 1e3",
        "contact[0].normal_stiffness = 1e3",
        "a bed at rest collapses",
    ),
];

/// Results that reach step 500, in a folder with what is no checkpoint.
fn prepared(name: &str) -> std::path::PathBuf {
    let home = folder(name);
    run_case(1, &home, &case("base.toml"), &[]).succeeded();
    fs::create_dir(home.join("empty")).unwrap();
    fs::write(home.join("other.h5"), "nothing").unwrap();
    home
}

fn later(home: &Path) -> String {
    let text = replaced(&case("base.toml"), "end = 0.02", "end = 0.021");
    fs::write(home.join("case.toml"), &text).unwrap();
    text
}

#[test]
fn what_is_no_checkpoint_is_refused_with_the_name_of_one() {
    let home = prepared("restarts_no_checkpoint");
    let text = later(&home);
    for (what, from, words) in NO_CHECKPOINTS {
        let refused = run_case(2, &home, &text, &["--restart", from]);
        let message = refused.only_error(4);
        println!("| {what} | {message} |");
        assert!(message.contains(from.trim_end_matches('/')) && message.contains(words), "{what}: {message}");
    }
}

#[test]
fn changes_that_are_seldom_meant_are_warned_of_when_a_run_goes_on() {
    let home = prepared("restarts_warned");
    let kept = home.join("kept");
    fs::rename(home.join("results"), &kept).unwrap();
    for (what, old, new, key, words) in WARNED {
        let _ = fs::remove_dir_all(home.join("results"));
        let text = replaced(&case("base.toml"), old, new);
        // The run may fail after the warning.
        let ran = run_case(2, &home, &text, &["--restart", "kept", "--max-walltime", "0"]);
        let warnings: Vec<&str> = ran.stderr.lines().filter(|line| line.starts_with("warning: ")).collect();
        println!("| {what} | {} |", warnings.join("<br>"));
        let is_told = |line: &&str| line.contains(key) && line.contains(words);
        assert!(warnings.iter().any(is_told), "{what}: {}", ran.text());
    }
}

#[test]
fn a_wall_that_is_moved_onto_particles_is_named_with_the_overlap() {
    let home = prepared("restarts_wall");
    let text = replaced(&later(&home), "lower = [0.005, 0.005, 0.005]", "lower = [0.03, 0.005, 0.005]");
    let refused = run_case(2, &home, &text, &["--restart", "latest"]);
    let message = refused.only_error(3);
    assert!(message.contains("differs from that of the checkpoint: wall.box.lower = [0.03"), "{message}");
}

#[test]
fn fields_that_change_are_named_with_their_key() {
    let home = prepared("restarts_fields");
    let text = replaced(&later(&home), "series = 0.001", "series = 0.001\nfields = [\"velocity\"]");
    let refused = run_case(1, &home, &text, &["--restart", "latest"]);
    let message = refused.only_error(4);
    assert!(message.contains("results/particles.vtkhdf") && message.contains("(output.fields"), "{message}");
}

#[test]
fn later_checkpoints_that_an_earlier_one_abandons_are_told() {
    let home = prepared("restarts_earlier");
    let from = "results/checkpoint-000000000250.h5";
    let ran = run_case(1, &home, &later(&home), &["--restart", from]).succeeded();
    let told = ran.stderr.lines().find(|line| line.starts_with("warning: ")).unwrap_or_default();
    assert!(
        told.contains("results: holds a checkpoint of step 500") && told.contains(".abandoned"),
        "{told}"
    );
    assert!(home.join("results/checkpoint-000000000500.h5.abandoned").exists());
}
