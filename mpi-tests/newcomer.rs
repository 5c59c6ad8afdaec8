//! What a newcomer does first: list the examples, write one, check it, run it, look up commands.

#![allow(clippy::unwrap_used)]

mod common;
mod packages;

use common::results::series;
use common::{ENVIRONMENT, Output, folder, replaced, run, signal, skipped, start};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// What the program says, without mpirun, in a folder.
fn ask(home: &Path, arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_grains-mpi");
    let output = Command::new(program).args(arguments).current_dir(home).envs(ENVIRONMENT).output().unwrap();
    let [stdout, stderr] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    Output { code: output.status.code(), stdout, stderr }
}

/// Every example that is listed can be written once, passes the check without a remark, and runs.
#[test]
fn every_example_is_a_case_of_ones_own_that_runs() {
    let home = folder("newcomer");
    let listed = ask(&home, &["examples"]).succeeded().stdout;
    let names: Vec<&str> =
        listed.lines().take_while(|line| !line.is_empty()).map(|l| l.split(' ').next().unwrap()).collect();
    assert_eq!(names, ["silo", "drum", "bed", "reactor"], "{listed}");
    for name in names {
        let file = format!("{name}.toml");
        let told = ask(&home, &["new", name]).succeeded().stdout;
        assert!(told.contains(&format!("grains-mpi check {file}")), "{told}");
        let again = ask(&home, &["new", name]);
        assert_eq!(again.only_error(4), format!("{file} is there already; give another name"));
        let checked = run(1, &home, &["check", &file]).succeeded();
        assert_eq!(checked.stderr, "", "{name}");
        let text = fs::read_to_string(home.join(&file)).unwrap();
        let end = text.lines().find(|line| line.starts_with("end = ")).unwrap();
        let text = match name {
            "reactor" => replaced(&text, "[60, 30, 30]", "[24, 12, 12]"),
            _ => replaced(&text, end, "end = 0.03"),
        };
        let short = format!("short-{file}");
        fs::write(home.join(&short), text).unwrap();
        run(2, &home, &[&short]).succeeded();
        assert!(series(&home.join("results").join(name)).column("time").len() > 1, "{name}");
    }
    let message = ask(&home, &["new", "sillo"]);
    assert!(message.code == Some(2) && message.stderr.contains("silo"), "{}", message.text());
}

/// A terminal shows one line, which is gone at the end; a file gets lines and no bar.
#[test]
fn a_terminal_shows_a_bar_and_a_file_does_not() {
    let home = folder("newcomer_bar");
    ask(&home, &["new", "silo"]).succeeded();
    let text = fs::read_to_string(home.join("silo.toml")).unwrap();
    let end = text.lines().find(|line| line.starts_with("end = ")).unwrap();
    fs::write(home.join("silo.toml"), replaced(&text, end, "end = 0.01")).unwrap();
    let command = format!("mpirun -n 2 '{}' silo.toml", env!("CARGO_BIN_EXE_grains-mpi"));
    let mut terminal = Command::new("script");
    terminal.args(["-qec", &command, "typescript"]).current_dir(&home).envs(ENVIRONMENT);
    let Ok(output) = terminal.stdin(Stdio::null()).output() else {
        return skipped("a_terminal_shows_a_bar_and_a_file_does_not", "no `script`");
    };
    assert!(output.status.success(), "{output:?}");
    let shown = fs::read_to_string(home.join("typescript")).unwrap();
    let drawn: Vec<&str> = shown.split('\r').filter(|part| part.contains('░')).collect();
    assert!(!drawn.is_empty() && drawn.iter().all(|line| line.contains("of 0.01 s")), "{shown}");
    // What comes after the last one begins by taking it away.
    let (_, rest) = shown.rsplit_once('░').unwrap();
    assert!(rest.contains("\r\u{1b}[K") && rest.contains("time by phase"), "{rest}");
    let log = run(2, &home, &["silo.toml"]).succeeded().stdout;
    assert!(!log.contains('░') && !log.contains('\r') && log.contains("step         0"), "{log}");
}

/// Shells and `man` learn all commands.
#[test]
fn completion_and_manual_page_name_every_command() {
    let home = folder("newcomer_commands");
    let help = ask(&home, &["--help"]).succeeded().stdout;
    assert!(help.starts_with("Granular and particulate flow"), "{help}");
    let commands: Vec<&str> = help
        .lines()
        .skip_while(|line| !line.starts_with("Commands:"))
        .skip(1)
        .take_while(|line| !line.is_empty())
        .map(|line| line.split_whitespace().next().unwrap())
        .collect();
    assert!(commands.len() > 8 && commands.contains(&"new"), "{help}");
    for arguments in
        [&["completions", "bash"][..], &["completions", "zsh"], &["completions", "fish"], &["man"]]
    {
        let text = ask(&home, arguments).succeeded().stdout;
        for command in commands.iter().filter(|command| **command != "help") {
            assert!(text.contains(command), "{arguments:?} do not name {command}");
        }
    }
}

/// A run tells from elsewhere how far it is, leaves when it is asked to, and goes on from there.
#[test]
fn a_run_is_watched_and_stopped_from_elsewhere() {
    let home = folder("newcomer_control");
    ask(&home, &["new", "silo"]).succeeded();
    let asked = |what: &str| ask(&home, &[what, "results/silo"]);
    assert!(asked("stop").only_error(4).starts_with("no run writes to results/silo"));
    assert!(asked("status").only_error(4).starts_with("results/silo/status.json: "));
    let text = fs::read_to_string(home.join("silo.toml")).unwrap();
    fs::write(home.join("silo.toml"), replaced(&text, "end = 4 ", "end = 400 ")).unwrap();
    let mut running = start(2, &home, &["silo.toml"], 0);
    running.wait_until("told anything", || home.join("results/silo/status.json").exists());
    let told = asked("status").succeeded().stdout;
    assert!(
        told.starts_with("results/silo: running\nt = ") && told.contains("of 400 s, 1500 particles"),
        "{told}"
    );
    assert!(asked("stop").succeeded().stdout.contains("asked to"));
    let ended = running.wait().succeeded();
    assert!(ended.stdout.contains("continue with --restart latest"), "{}", ended.text());
    assert!(asked("status").stdout.starts_with("results/silo: stopped by request"));
    // What was asked of one run is not asked of the next; a run that is killed is no longer said to run.
    fs::write(home.join("results/silo/.stop"), "").unwrap();
    // Without a series too.
    let text = fs::read_to_string(home.join("silo.toml")).unwrap();
    fs::write(home.join("silo.toml"), replaced(&text, "series = 0.01 ", "series = 0 ")).unwrap();
    let mut running = start(2, &home, &["silo.toml", "--restart", "latest"], 0);
    running.wait_until("told anything", || asked("status").stdout.contains(": running"));
    signal("KILL", &running.ranks());
    assert_ne!(running.wait().code, Some(0));
    assert!(asked("status").stdout.starts_with("results/silo: ended without a word"));
}

/// The script that SLURM gets runs the case, passes its signal on, submits itself while the run is not done, and goes on from the
/// checkpoint; SLURM is played by two commands.
#[test]
fn a_slurm_script_goes_on_until_the_run_has_ended() {
    let home = folder("newcomer_slurm");
    ask(&home, &["new", "silo"]).succeeded();
    let text = fs::read_to_string(home.join("silo.toml")).unwrap();
    fs::write(home.join("silo.toml"), replaced(&text, "end = 4 ", "end = 0.6 ")).unwrap();
    let made = ["slurm", "silo.toml", "--ranks", "2", "--minutes", "60", "--sbatch", "account=grains"];
    ask(&home, &made).succeeded();
    let script = fs::read_to_string(home.join("silo.sbatch")).unwrap();
    assert!(
        script.contains("#SBATCH --ntasks=2\n") && script.contains("#SBATCH --account=grains\n"),
        "{script}"
    );
    assert!(script.contains("--max-walltime 3240"), "{script}");
    let commands = home.join("commands");
    fs::create_dir_all(&commands).unwrap();
    let program = env!("CARGO_BIN_EXE_grains-mpi");
    let played = [
        // As SLURM does, srun passes the signal on to all ranks.
        ("srun", format!("shift\nexec mpirun --allow-run-as-root --oversubscribe -n 2 {program} \"$@\"")),
        ("sbatch", "echo \"$@\" >>submitted".to_string()),
    ];
    for (name, does) in played {
        let path = commands.join(name);
        fs::write(&path, format!("#!/bin/bash\n{does}\n")).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    }
    let path = format!("{}:{}", commands.display(), std::env::var("PATH").unwrap());
    let job = || {
        let mut bash = Command::new("bash");
        bash.arg("silo.sbatch").current_dir(&home).env("PATH", &path).envs(ENVIRONMENT);
        bash.stdout(fs::File::create(home.join("job.log")).unwrap()).spawn().unwrap()
    };
    let mut first = job();
    while !home.join("results/silo/status.json").exists() {
        assert!(first.try_wait().unwrap().is_none(), "{}", fs::read_to_string(home.join("job.log")).unwrap());
        std::thread::sleep(Duration::from_millis(20));
    }
    signal("USR1", &[first.id()]);
    assert!(first.wait().unwrap().success());
    let submitted = || fs::read_to_string(home.join("submitted")).unwrap_or_default();
    assert_eq!(submitted(), "silo.sbatch\n", "{}", fs::read_to_string(home.join("job.log")).unwrap());
    // Who asks a run to stop does not want a next job.
    let mut second = job();
    while !ask(&home, &["status", "results/silo"]).stdout.contains(": running") {
        assert!(
            second.try_wait().unwrap().is_none(),
            "{}",
            fs::read_to_string(home.join("job.log")).unwrap()
        );
    }
    ask(&home, &["stop", "results/silo"]).succeeded();
    assert!(second.wait().unwrap().success());
    assert!(ask(&home, &["status", "results/silo"]).stdout.contains("stopped by request"));
    assert_eq!(submitted(), "silo.sbatch\n");
    assert!(job().wait().unwrap().success());
    assert_eq!(submitted(), "silo.sbatch\n");
    let times = series(&home.join("results/silo"));
    let times = times.column("time");
    assert!(times[0] == 0.0 && times.windows(2).all(|w| w[1] > w[0]), "{times:?}");
    assert!((times[times.len() - 1] - 0.6).abs() < 1e-4, "{times:?}");
}
