//! The page of the manual on what is refused of a case file: the messages of the bad cases.

use crate::{files, must_be_current, shown, text_of};
use grains_case::Case;
use std::collections::BTreeMap;
use std::fmt::Write;

const HEAD: &str = "\
<!-- Written by `cargo test -p grains-case --test manual` from crates/grains-case/tests/bad; do not edit. -->
# All messages

## Refused of a case file

Every row is what the program says of a case that a test refuses; the last column has that case. A message begins with file, line and
column, then key and value: `case.toml:29:1: contact[0].restitutoin: unknown key; did you mean \"restitution\"?` All mistakes
of a file are told at once. [Messages and remedies](how-to/troubleshooting.md) says what to do about those that are met often.
";

const OF_RUNS: &str = "
## Errors of runs

Each ends the run on all ranks with one message. `…` stands for what the run puts in: particle, place, time, value.
";

/// Crates whose errors end runs, and what these are about.
const CRATES: [(&str, &str); 7] = [
    ("grains-dem", "Particles, contacts, bonds"),
    ("grains-fluid", "Fluid"),
    ("grains-resolved", "Fluid around particles"),
    ("grains-coupling", "Fluid among particles"),
    ("grains-geometry", "Shapes and meshes"),
    ("grains-domain", "Domain and ranks"),
    ("grains-output", "Files"),
];

#[test]
fn the_page_of_messages_is_current() {
    let mut rows: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for file in files("crates/grains-case/tests/bad", ".toml") {
        let errors = Case::load(&file).expect_err("a bad case");
        let name = file.file_stem().expect("name").to_string_lossy().into_owned();
        for error in &errors.0 {
            let section = error.key.split(['.', '[']).next().unwrap_or_default();
            // Places of files differ from machine to machine.
            let message = error.message.replace(&*shown_folder(), "…");
            let message = message.replace('|', "\\|").replace('<', "&lt;").replace('*', "\\*");
            let value = error
                .value
                .as_ref()
                .filter(|value| value.len() < 40)
                .map_or(String::new(), |v| format!(" = {v}"));
            let key = if error.key.is_empty() {
                String::new()
            } else {
                format!("`{}{}`", error.key, value.replace('|', "\\|"))
            };
            let row = format!("| {key} | {message} | [{}](../{}) |\n", name.replace('_', " "), shown(&file));
            rows.entry(section.to_string()).or_default().push(row);
        }
    }
    let mut text = HEAD.to_string();
    for (section, mut rows) in rows {
        let title = if section.is_empty() { "The file as a whole" } else { &section };
        rows.sort();
        let _ = write!(text, "\n### {title}\n\n| key | message | case |\n|---|---|---|\n{}", rows.concat());
    }
    text += OF_RUNS;
    for (name, about) in CRATES {
        let sources = files(&format!("crates/{name}/src"), ".rs");
        let mut messages: Vec<String> = sources.iter().flat_map(|file| errors_of(&text_of(file))).collect();
        messages.dedup();
        if !messages.is_empty() {
            let lines = messages.iter().map(|message| format!("* {message}\n"));
            let _ = write!(text, "\n### {about}\n\n{}", lines.collect::<String>());
        }
    }
    must_be_current("docs/messages.md", &text);
}

/// The messages of the errors that a source declares, `…` where a value goes.
fn errors_of(source: &str) -> Vec<String> {
    let literal = |rest: &str| {
        let mut message = String::new();
        let mut letters = rest.trim_start().strip_prefix('"')?.chars();
        loop {
            match letters.next()? {
                '"' => break Some(message),
                '\\' => match letters.next()? {
                    // The literal goes on behind the blanks of the next line.
                    '\n' => letters = letters.as_str().trim_start().chars(),
                    other => message.push(other),
                },
                '{' => {
                    letters.by_ref().find(|c| *c == '}');
                    message.push('…');
                }
                other => message.push(other),
            }
        }
    };
    let found = source.split("#[error(").skip(1).filter_map(literal);
    found
        .filter(|message| message.len() > 20)
        .map(|message| message.replace('<', "&lt;").replace('*', "\\*"))
        .collect()
}

#[test]
fn messages_of_errors_are_read_from_sources() {
    let source = "#[error(\n    \"particle {id} is {x:.3e} m \\\n     off: \\\"a\\\"\"\n)]\nA, #[error(transparent)] B";
    assert_eq!(errors_of(source), ["particle … is … m off: \"a\""]);
}

/// The folder of the bad cases as messages name it, and what is above it.
fn shown_folder() -> String {
    crate::root().join("crates/grains-case/tests").display().to_string()
}
