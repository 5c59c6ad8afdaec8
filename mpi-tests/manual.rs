//! The manual beside the program: the tutorial runs as it is written, commands and options exist, columns and arrays are described.

#![allow(clippy::unwrap_used)]

mod common;

use common::{ENVIRONMENT, folder, run};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// A block of code of a page: the words behind its fence, and its lines.
struct Block {
    mark: String,
    lines: Vec<String>,
}

fn blocks(page: &Path) -> Vec<Block> {
    let text = fs::read_to_string(page).unwrap_or_else(|e| panic!("{}: {e}", page.display()));
    let mut found = Vec::new();
    let mut lines = text.lines().map(str::trim_start);
    while let Some(line) = lines.next() {
        if let Some(mark) = line.strip_prefix("```") {
            let inner = lines.by_ref().take_while(|line| *line != "```");
            found.push(Block { mark: mark.to_string(), lines: inner.map(str::to_string).collect() });
        }
    }
    found
}

/// All pages of the manual.
fn pages() -> Vec<PathBuf> {
    let mut folders = vec![root().join("docs")];
    let mut pages = vec![root().join("README.md"), root().join("CONTRIBUTING.md")];
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            match path.extension().and_then(|ending| ending.to_str()) {
                _ if path.is_dir() => folders.push(path),
                Some("md") => pages.push(path),
                _ => {}
            }
        }
    }
    pages
}

/// A folder of programs that is first on the path: the program, and mpirun as tests need it.
fn path_with_program(home: &Path) -> String {
    let programs = home.join("programs");
    fs::create_dir_all(&programs).unwrap();
    std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_grains-mpi"), programs.join("grains-mpi")).unwrap();
    format!("{}:{}", programs.display(), std::env::var("PATH").unwrap())
}

/// Every block of commands of the tutorial succeeds, in order, with a silo of a tenth of the beads, softer and with a gate that opens
/// sooner. What the blocks of text behind them begin their lines with, up to a number, is said.
#[test]
fn the_tutorial_runs_as_it_is_written() {
    let home = folder("manual_tutorial");
    let path = path_with_program(&home);
    let mut said = String::new();
    let mut commands = 0;
    for block in blocks(&root().join("docs/tutorial.md")) {
        match block.mark.split(' ').next().unwrap() {
            "sh" if block.mark.starts_with("sh skip: ") => {}
            "sh" => {
                let text = format!("set -e\n{}\n", block.lines.join("\n"));
                let mut bash = Command::new("bash");
                let output =
                    bash.args(["-c", &text]).current_dir(&home).env("PATH", &path).envs(ENVIRONMENT).output();
                let output = output.unwrap();
                said = String::from_utf8_lossy(&output.stdout).into_owned()
                    + &String::from_utf8_lossy(&output.stderr);
                assert!(output.status.success(), "{text}\n{said}");
                commands += block.lines.len();
                if text.contains("new silo") {
                    make_small(&home.join("silo.toml"));
                }
            }
            "text" => {
                for line in &block.lines {
                    let begin = line.split(|c: char| c.is_ascii_digit()).next().unwrap().trim();
                    let begin = if begin.is_empty() { line.as_str() } else { begin };
                    assert!(said.contains(begin), "`{begin}` of the tutorial is not in\n{said}");
                }
            }
            _ => {}
        }
    }
    assert!(commands > 12, "{commands} commands");
    let read = |name: &str| fs::read_to_string(home.join(name)).unwrap();
    assert_eq!(first_columns(&read("whole.txt")), first_columns(&read("pieces.txt")));
}

/// Step, time, and particles inside, inserted and left of a row.
fn first_columns(row: &str) -> Vec<&str> {
    row.split(',').take(5).collect()
}

fn make_small(case: &Path) {
    let mut text = fs::read_to_string(case).unwrap();
    for (old, new) in [
        ("count = 1500", "count = 150"),
        ("normal_stiffness = 1e5", "normal_stiffness = 1e4"),
        ("until = 0.5", "until = 0.05"),
    ] {
        text = common::replaced(&text, old, new);
    }
    fs::write(case, text).unwrap();
}

/// Commands of the program that any page names are there, with the options that it names; scripts and cases exist.
#[test]
fn commands_of_the_manual_exist() {
    let help = |arguments: &[&str]| {
        let output =
            Command::new(env!("CARGO_BIN_EXE_grains-mpi")).args(arguments).arg("--help").output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        output.status.success().then_some(text)
    };
    let (mut wrong, mut looked_at) = (Vec::new(), 0);
    for page in pages() {
        for block in blocks(&page).into_iter().filter(|block| block.mark.starts_with("sh")) {
            for line in &block.lines {
                let line = line.split(" #").next().unwrap();
                let words: Vec<&str> = line.split_whitespace().collect();
                let missing = words.iter().filter(|word| {
                    ["scripts/", "cases/", "docs/"].iter().any(|folder| word.starts_with(folder))
                        && !root().join(word).exists()
                });
                wrong.extend(missing.map(|word| format!("{}: {word} does not exist", page.display())));
                let Some(at) = words
                    .iter()
                    .rposition(|word| word.ends_with("grains-mpi"))
                    .filter(|&at| at == 0 || words[at - 1] != "-p")
                else {
                    continue;
                };
                let own: Vec<&str> = words[at + 1..]
                    .iter()
                    .take_while(|word| !["||", "|", ">", "&&", "--"].contains(*word))
                    .copied()
                    .collect();
                let Some(&first) = own.first() else { continue };
                looked_at += 1;
                let path: Vec<&str> = match first {
                    "analyse" => own.iter().take(2).copied().collect(),
                    file if file.contains('.') || file.contains('$') || file.contains('/') => vec![],
                    command => vec![command],
                };
                match help(&path) {
                    None => wrong.push(format!("{}: no command `{}`", page.display(), path.join(" "))),
                    Some(text) => {
                        let options = own
                            .iter()
                            .filter(|word| word.starts_with("--"))
                            .map(|word| word.split('=').next().unwrap());
                        let unknown = options.filter(|option| !text.contains(option));
                        wrong.extend(
                            unknown.map(|option| format!("{}: `{line}`: no {option}", page.display())),
                        );
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(looked_at > 25, "{looked_at} commands");
}

/// Cases that together have every column of the time series and every array of particles.
const CASES: [&str; 9] =
    ["wet", "heated", "warm", "warm_bodies", "bonded", "press", "catalyst", "bed", "sheared"];

/// Every column of the time series and every array of particles is on the page of columns with its unit, and nothing else is.
#[test]
fn columns_and_arrays_are_described() {
    let described = rows(&fs::read_to_string(root().join("docs/columns.md")).unwrap());
    let mut met = BTreeSet::new();
    for name in CASES {
        let ranks = if name == "sheared" { 2 } else { 1 };
        let home = folder(&format!("manual_columns_{name}"));
        let text =
            fs::read_to_string(root().join("crates/grains-case/tests/good").join(format!("{name}.toml")))
                .unwrap();
        let data = format!("\"{}/", root().join("crates/grains-case/tests/data").display());
        fs::write(home.join("case.toml"), text.replace("\"../data/", &data)).unwrap();
        run(ranks, &home, &["case.toml", "--max-walltime", "0"]).succeeded();
        let results = results_in(&home.join("results"));
        let series = fs::read_to_string(results.join("series.csv")).unwrap();
        let units = series.lines().find_map(|line| line.strip_prefix("# units: ")).unwrap();
        let columns = series.lines().find(|line| !line.starts_with('#')).unwrap();
        for (column, unit) in columns.split(',').zip(units.split(',')) {
            let row = described.iter().find(|row| row.says(column, unit));
            met.insert(
                row.unwrap_or_else(|| panic!("docs/columns.md lacks `{column}` ({unit}) of {name}"))
                    .pattern
                    .clone(),
            );
        }
        let particles = hdf5::File::open(results.join("particles.vtkhdf")).unwrap();
        for array in particles.group("VTKHDF/PointData").unwrap().member_names().unwrap() {
            let row = described.iter().find(|row| row.is_of(&array));
            met.insert(
                row.unwrap_or_else(|| panic!("docs/columns.md lacks the array `{array}` of {name}"))
                    .pattern
                    .clone(),
            );
        }
    }
    assert!(met.len() > 100, "{} columns met", met.len());
}

/// The folder of results, whatever the case calls it.
fn results_in(folder: &Path) -> PathBuf {
    if folder.join("series.csv").exists() {
        return folder.to_path_buf();
    }
    let mut inner = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    inner.find(|path| path.join("series.csv").exists()).unwrap()
}

/// A column or array of the page, with NAME for what the case names.
struct Row {
    pattern: String,
    units: String,
}

impl Row {
    fn is_of(&self, name: &str) -> bool {
        match self.pattern.split_once("NAME") {
            Some((before, after)) => {
                name.len() > before.len() + after.len() && name.starts_with(before) && name.ends_with(after)
            }
            None => self.pattern == name,
        }
    }

    fn says(&self, column: &str, unit: &str) -> bool {
        self.is_of(column) && self.units.split(',').any(|known| known.trim() == unit)
    }
}

/// The rows of all tables of the page: one for each name in the first cell, with the units of the second.
fn rows(page: &str) -> Vec<Row> {
    let cells = page.lines().filter_map(|line| line.strip_prefix("| "));
    cells
        .flat_map(|line| {
            let mut cells = line.split(" |").map(str::trim);
            let (names, units) =
                (cells.next().unwrap_or_default(), cells.next().unwrap_or_default().trim_start_matches("| "));
            let names: Vec<String> = names.split('`').skip(1).step_by(2).map(str::to_string).collect();
            let units = units.to_string();
            names.into_iter().map(move |pattern| Row { pattern, units: units.clone() })
        })
        .collect()
}
