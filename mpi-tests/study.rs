//! Studies: members run once, go on after they were stopped, and run as arrays of jobs; a wrong value is told before anything runs.

#![allow(clippy::unwrap_used)]

mod common;

use common::{ENVIRONMENT, Output, case, folder, replaced, signal};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Child, Command};
use std::time::Duration;

const STUDY: &str = r#"
case = "base.toml"

[vary]
friction = { key = "contact[*].friction", values = [0.1, 0.4] }
restitution = { key = "contact[glass, wall].restitution", values = [0.6, 0.9] }

[measure]
energy = { column = "kinetic_translation", take = "mean", from = 0.1 }
touching = { column = "wall_contacts", analyse = "coordination" }

[run]
jobs = 2
"#;

/// A folder with a short case and a study of four members.
fn prepared(name: &str) -> std::path::PathBuf {
    let home = folder(name);
    let text = replaced(&case("base.toml"), "end = 0.02", "end = 0.4");
    let text = replaced(&text, "checkpoint = 0.01", "checkpoint = 0.2");
    fs::write(home.join("base.toml"), replaced(&text, "particles = 0.01", "particles = 0.1")).unwrap();
    fs::write(home.join("study.toml"), STUDY).unwrap();
    home
}

fn command(home: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_grains-mpi"));
    command.arg("sweep").args(arguments).current_dir(home).envs(ENVIRONMENT);
    command
}

fn sweep(home: &Path, arguments: &[&str]) -> Output {
    output(command(home, arguments).output().unwrap())
}

fn output(output: std::process::Output) -> Output {
    let [stdout, stderr] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    Output { code: output.status.code(), stdout, stderr }
}

/// Rows of the table without what differs from one call to the next: the folders' numbers, wall-clock times and versions.
fn rows(directory: &Path) -> Vec<String> {
    let text = fs::read_to_string(directory.join("table.csv")).unwrap();
    let rows = text.lines().filter(|line| !line.starts_with('#'));
    rows.map(|row| row.split(',').skip(1).take(6).collect::<Vec<_>>().join(",")).collect()
}

/// Waits until a file is there while a process goes on.
fn wait_for(file: &Path, process: &mut Child) {
    while !file.exists() {
        assert!(process.try_wait().unwrap().is_none(), "ended before {} was there", file.display());
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// A second call runs nothing. A study that is stopped by Ctrl-C and goes on has the same table, bit for bit.
#[test]
fn a_study_runs_once_and_goes_on_where_it_was_stopped() {
    let home = prepared("study");
    let first = sweep(&home, &["study.toml"]).succeeded().stdout;
    assert!(first.starts_with("4 of 4 members to run, 2 side by side\n"), "{first}");
    assert!(first.contains("4 members: 4 done"), "{first}");
    let directory = home.join("results/study");
    let found = rows(&directory);
    assert_eq!(found[0], "seed,friction,restitution,energy,touching,state");
    assert!(found.len() == 5 && found[1..].iter().all(|row| row.ends_with(",done")), "{found:?}");
    let energies: Vec<f64> =
        found[1..].iter().map(|row| row.split(',').nth(3).unwrap().parse().unwrap()).collect();
    assert!(energies.iter().all(|e| *e > 0.0) && energies[0] != energies[3], "{energies:?}");
    assert!(fs::read_to_string(directory.join("study.svg")).unwrap().contains("friction"));
    let begun = fs::metadata(directory.join("0001/run/series.csv")).unwrap().modified().unwrap();
    let second = sweep(&home, &["study.toml"]).succeeded().stdout;
    assert!(!second.contains("to run") && rows(&directory) == found, "{second}");
    assert_eq!(fs::metadata(directory.join("0001/run/series.csv")).unwrap().modified().unwrap(), begun);

    fs::write(home.join("again.toml"), STUDY).unwrap();
    let mut stopped =
        command(&home, &["again.toml"]).stdout(fs::File::create(home.join("log")).unwrap()).spawn().unwrap();
    let again = home.join("results/again");
    wait_for(&again.join("0002/run/series.csv"), &mut stopped);
    signal("INT", &[stopped.id()]);
    assert!(stopped.wait().unwrap().success());
    let told = fs::read_to_string(home.join("log")).unwrap();
    assert!(told.contains("stopped; the same command goes on") && told.contains("2 waiting"), "{told}");
    let finished = sweep(&home, &["again.toml"]).succeeded().stdout;
    assert!(finished.contains("4 done"), "{finished}");
    assert_eq!(rows(&again), found);
}

/// The scripts for SLURM run every member in a job of its own and gather them; SLURM is played by two commands.
#[test]
fn a_study_runs_as_an_array_of_jobs() {
    let home = prepared("study_slurm");
    let text = fs::read_to_string(home.join("base.toml")).unwrap();
    fs::write(home.join("base.toml"), replaced(&text, "end = 0.4", "end = 0.15")).unwrap();
    let told = sweep(&home, &["study.toml", "--slurm", "--sbatch", "account=grains"]).succeeded().stdout;
    assert!(told.ends_with("sbatch study-gather.sbatch\n"), "{told}");
    let script = fs::read_to_string(home.join("study.sbatch")).unwrap();
    assert!(
        script.contains("#SBATCH --account=grains\n") && script.contains("--max-walltime 85800"),
        "{script}"
    );
    let commands = home.join("commands");
    fs::create_dir_all(&commands).unwrap();
    let program = env!("CARGO_BIN_EXE_grains-mpi");
    let sbatch = r#"echo "$@" >>submitted
case "$2" in
    --array=*)
        numbers=$(echo "${2#--array=}" | sed 's/%.*//; s/\([0-9]*\)-\([0-9]*\)/\1 \2/' | xargs seq)
        for SLURM_ARRAY_TASK_ID in $numbers; do
            export SLURM_ARRAY_TASK_ID
            bash "$3" >"job-$SLURM_ARRAY_TASK_ID" 2>&1
        done
        echo 7 ;;
    *) bash "$2" >gathered ;;
esac"#;
    let grains = format!("exec {program} \"$@\"");
    for (name, does) in [("srun", "exec \"$@\""), ("sbatch", sbatch), ("grains-mpi", &grains)] {
        fs::write(commands.join(name), format!("#!/bin/bash\n{does}\n")).unwrap();
        fs::set_permissions(commands.join(name), fs::Permissions::from_mode(0o755)).unwrap();
    }
    let path = format!("{}:{}", commands.display(), std::env::var("PATH").unwrap());
    let mut bash = Command::new("bash");
    bash.arg("study-gather.sbatch").current_dir(&home).env("PATH", path).envs(ENVIRONMENT);
    output(bash.output().unwrap()).succeeded();
    let submitted = fs::read_to_string(home.join("submitted")).unwrap();
    let expected = "--parsable --array=1-4%2 study.sbatch\n--dependency=afterany:7 study-gather.sbatch\n";
    assert_eq!(submitted, expected);
    let found = rows(&home.join("results/study"));
    assert!(found.len() == 5 && found[1..].iter().all(|row| row.ends_with(",done")), "{found:?}");
    assert!(fs::read_to_string(home.join("gathered")).unwrap().contains("4 members: 4 done"));
}

/// The passage of a study, what stands in its place, and words of the answer.
const WRONG: &[(&str, &str, &[&str])] = &[
    ("[0.1, 0.4]", "[0.1, 0.1]", &["vary.friction.values[1] = 0.1", "design.repeats"]),
    ("[0.1, 0.4]", "[0,1, 0,4]", &["vary.friction.values[2] = 0", "decimals have a point"]),
    ("contact[*].friction", "time", &["vary.friction.key = \"time\"", "is a section", "`time.end`"]),
    ("contact[*].friction", "contact", &["vary.friction.key = \"contact\"", "`contact[0].KEY`"]),
    ("contact[glass, wall].restitution", "contact[1].friction", &["vary.restitution", "vary each key once"]),
    ("contact[glass, wall].restitution", "contact[*].friction", &["vary.restitution", "vary each key once"]),
    ("contact[*].friction", "output.directory", &["vary.friction", "a folder of its own", "`directory`"]),
    (
        "jobs = 2",
        "jobs = 2\n[design]\nrepeats = 2\n[vary.draw]\nkey = \"seed\"\nvalues = [1, 2]",
        &["design.repeats = 2", "vary.draw"],
    ),
    (
        "analyse = \"coordination\"",
        "analyse = \"coordinaton\"",
        &["measure.touching.analyse", "analyse --help"],
    ),
    ("from = 0.1", "from = 5", &["measure.energy.from = 5", "time.end"]),
    (
        "column = \"kinetic_translation\", take = \"mean\", from = 0.1",
        "command = [\"no-such-program\"]",
        &["measure.energy.command", "install it"],
    ),
    (
        "contact[*].friction\", values = [0.1, 0.4] }\nrestitution = { key = \"contact[glass, wall].restitution\", values = [0.6, 0.9] }",
        "insert[0].count\", min = 8, max = 15 }\n[design]\nsamples = 3",
        &["insert[0].count", "a range gives no whole numbers"],
    ),
    ("base.toml", "wrong.toml", &["a study, not a case", "grains-mpi sweep"]),
    ("base.toml", "bse.toml", &["case = \"bse.toml\"", "no such file"]),
];

/// Wrong studies are refused before anything runs, each with one message that says where and what.
#[test]
fn a_wrong_study_is_told_before_anything_runs() {
    let home = prepared("study_wrong");
    let refused = |old: &str, new: &str, wanted: &[&str]| {
        fs::write(home.join("wrong.toml"), replaced(STUDY, old, new)).unwrap();
        let said = sweep(&home, &["wrong.toml"]);
        let message = said.only_error(2).to_owned();
        assert!(wanted.iter().all(|part| message.contains(part)), "{message}");
        assert!(!home.join("results/wrong/0001/run").exists());
    };
    refused("jobs = 2", "job = 2", &["wrong.toml:13:1: run.job: unknown key; did you mean `jobs`?"]);
    refused(
        "contact[glass, wall]",
        "contact[glas, wall]",
        &["vary.restitution.key", "did you mean `glass, wall`?"],
    );
    refused(
        "[0.1, 0.4]",
        "[0.1, -0.4]",
        &["friction = -0.4", "base.toml:23:12: contact[0].friction = -0.4", "must be"],
    );
    refused("].restitution", "].restitutoin", &["unknown key; did you mean `restitution`?"]);
    refused("values = [0.6, 0.9]", "min = 0.6, max = 0.9", &["design.samples: missing key"]);
    for (old, new, wanted) in WRONG {
        refused(old, new, wanted);
    }
}
