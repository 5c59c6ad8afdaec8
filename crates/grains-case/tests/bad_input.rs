//! Every file in `tests/bad` is refused with the messages it asks for; no input makes the reader panic.

use std::path::{Path, PathBuf};

use grains_case::Case;

fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(folder);
    let entries = std::fs::read_dir(&folder).expect("folder of cases");
    let mut files: Vec<_> = entries.map(|entry| entry.expect("entry").path()).collect();
    files.sort();
    files
}

#[test]
fn bad_cases_are_refused_with_the_expected_messages() {
    let files = files("bad");
    assert!(files.len() >= 25);
    let mut failures = Vec::new();
    for path in &files {
        let name = path.file_name().expect("name").to_string_lossy().into_owned();
        let text = std::fs::read_to_string(path).expect("text");
        let expected: Vec<_> = text.lines().filter_map(|line| line.strip_prefix("# expect: ")).collect();
        assert!(!expected.is_empty(), "{name} expects nothing");
        let message = match Case::load(path) {
            Ok(_) => "accepted".to_owned(),
            Err(errors) => errors.to_string(),
        };
        for part in expected.iter().filter(|part| !message.contains(**part)) {
            failures.push(format!("{name}: expected `{part}` in\n{message}\n"));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// One mistake must not draw complaints about other places.
#[test]
fn bad_cases_draw_no_more_remarks_than_mistakes() {
    for path in files("bad") {
        let text = std::fs::read_to_string(&path).expect("text");
        let mistakes = text.lines().filter(|line| line.starts_with("# expect: ")).count();
        let errors = Case::load(&path).expect_err("bad");
        assert!(errors.0.len() <= mistakes, "{errors}");
        let in_order = errors.0.windows(2).all(|pair| pair[0].line <= pair[1].line);
        assert!(in_order && errors.0.iter().all(|error| error.line > 0), "{errors}");
    }
}

#[test]
fn a_missing_case_file_names_its_neighbour() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/good");
    let message = Case::load(folder.join("sillo.toml")).expect_err("missing").to_string();
    assert!(message.contains("did you mean `silo.toml`"), "{message}");
}

/// Deletes, duplicates and spoils every line of the good cases: the answer is Ok or Err, never a panic.
#[test]
fn no_mutation_of_a_good_case_makes_the_reader_panic() {
    const SPOILERS: [&str; 12] = [
        "\"x\"",
        "-1",
        "0",
        "nan",
        "-inf",
        "1e999",
        "[]",
        "{}",
        "true",
        "[[1]]",
        "99999999999999999999",
        "é\"",
    ];
    for path in files("good") {
        let text = std::fs::read_to_string(&path).expect("text");
        let base = path.parent().expect("folder");
        let lines: Vec<&str> = text.lines().collect();
        let mut refused = 0;
        let mut attempt = |index: usize, replacement: &str| {
            let mut mutated = lines.clone();
            mutated[index] = replacement;
            if let Err(errors) = Case::parse(&mutated.join("\n"), "mutated.toml", base) {
                assert!(!errors.0.is_empty() && !errors.to_string().contains("not understood"), "{errors}");
                refused += 1;
            }
        };
        for (index, line) in lines.iter().enumerate() {
            attempt(index, "");
            attempt(index, &format!("{line}\n{line}"));
            attempt(index, &line[..line.floor_char_boundary(line.len() / 2)]);
            if let Some((key, _)) = line.split_once('=') {
                SPOILERS.iter().for_each(|value| attempt(index, &format!("{key}= {value}")));
                attempt(index, &format!("{}x = 1", key.trim()));
            }
        }
        assert!(refused > 3 * lines.len(), "{refused} of {} mutations refused", lines.len());
    }
}

/// The same with every single number and word replaced, nested ones included.
#[test]
fn no_mutation_of_a_single_value_makes_the_reader_panic() {
    for path in files("good") {
        let text = std::fs::read_to_string(&path).expect("text");
        let base = path.parent().expect("folder");
        let is_value = |c: char| c.is_ascii_alphanumeric() || "._+-\"".contains(c);
        let mut start = 0;
        while let Some(offset) = text[start..].find(is_value) {
            let begin = start + offset;
            let end = text[begin..].find(|c| !is_value(c)).map_or(text.len(), |n| begin + n);
            for value in ["-0.0", "1e308", "5e-324", "\"glass\"", "18446744073709551616"] {
                let mutated = format!("{}{value}{}", &text[..begin], &text[end..]);
                if let Ok(case) = Case::parse(&mutated, "mutated.toml", base) {
                    let again = Case::parse(&case.to_toml(), "again.toml", Path::new("/"));
                    assert_eq!(again.as_ref(), Ok(&case), "{value} at byte {begin} of {}", path.display());
                }
            }
            start = end;
        }
    }
}
