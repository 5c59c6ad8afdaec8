//! What a newcomer does first: list the examples, write one, check it, run it, look up commands.

#![allow(clippy::unwrap_used)]

mod common;

use common::results::series;
use common::{folder, replaced, run};
use std::fs;

/// Every example that is listed can be written once, passes the check without a remark, and runs.
#[test]
fn every_example_is_a_case_of_ones_own_that_runs() {
    let home = folder("newcomer");
    let listed = run(2, &home, &["examples"]).succeeded().stdout;
    let names: Vec<&str> =
        listed.lines().take_while(|line| !line.is_empty()).map(|l| l.split(' ').next().unwrap()).collect();
    assert_eq!(names, ["silo", "drum", "bed", "reactor"], "{listed}");
    for name in names {
        let file = format!("{name}.toml");
        let told = run(1, &home, &["new", name]).succeeded().stdout;
        assert!(told.contains(&format!("grains-mpi check {file}")), "{told}");
        let again = run(1, &home, &["new", name]);
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
    let message = run(1, &home, &["new", "sillo"]);
    assert!(message.code == Some(2) && message.stderr.contains("silo"), "{}", message.text());
}

/// Shells and `man` learn all commands.
#[test]
fn completion_and_manual_page_name_every_command() {
    let home = folder("newcomer_commands");
    // mpirun offers a terminal, on which help is bold.
    let help = run(1, &home, &["--help"]).succeeded().stdout;
    let help = ["\u{1b}[0m", "\u{1b}[1m", "\u{1b}[4m"].iter().fold(help, |text, code| text.replace(code, ""));
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
        let text = run(1, &home, arguments).succeeded().stdout;
        for command in commands.iter().filter(|command| **command != "help") {
            assert!(text.contains(command), "{arguments:?} do not name {command}");
        }
    }
}
