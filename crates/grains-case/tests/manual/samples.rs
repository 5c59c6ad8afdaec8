//! Samples of case files in the manual: every key of them is one of the format, with a value that it takes.

use crate::{files, root, shown, text_of};
use grains_case::Case;

/// What fragments of a case may lack.
const LACKING: [&str; 5] = ["missing", "unknown material", "unknown shape", "no such file", "no contact law"];

#[test]
fn samples_are_parts_of_cases() {
    let mut pages = files("docs", ".md");
    // Studies have files of their own.
    pages.retain(|page| !page.ends_with("studies.md"));
    pages.push(root().join("README.md"));
    let folder = root().join("crates/grains-case/tests/good");
    let (mut wrong, mut looked_at) = (Vec::new(), 0);
    for page in &pages {
        for (line, sample) in samples(&text_of(page)) {
            looked_at += 1;
            let name = format!("{}:{line}", shown(page));
            let is_whole = sample.contains("[domain]") && sample.contains("[time]");
            if let Err(errors) = Case::parse(&sample, &name, &folder) {
                let is_allowed =
                    |message: &str| !is_whole && LACKING.iter().any(|what| message.contains(what));
                let errors = errors.0.iter().filter(|error| !is_allowed(&error.message));
                wrong.extend(errors.map(ToString::to_string));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(looked_at > 20, "only {looked_at} samples");
}

/// The samples of a page, each with its line. In one that is marked "toml each TABLE" every line is a sample of its own, of keys of
/// that table.
fn samples(text: &str) -> Vec<(usize, String)> {
    let mut found: Vec<(usize, String)> = Vec::new();
    let mut lines = text.lines().enumerate();
    while let Some((k, line)) = lines.next() {
        let Some(mark) = line.trim_start().strip_prefix("```toml") else { continue };
        let inner: Vec<&str> =
            lines.by_ref().map(|(_, line)| line).take_while(|line| line.trim_start() != "```").collect();
        match mark.trim().strip_prefix("each ") {
            Some(table) => {
                let header = |line: &str| format!("{}\n{line}\n", headers(table));
                let lines = inner.iter().enumerate().filter(|(_, line)| !line.is_empty());
                found.extend(lines.map(|(i, line)| (k + i + 2, header(line))));
            }
            None => found.push((k + 1, inner.join("\n"))),
        }
    }
    found
}

/// The headers of the tables that lead to a table of the fluid or of lists.
fn headers(table: &str) -> String {
    let outer = if table.starts_with("fluid.") { "[fluid]\n" } else { "" };
    format!("{outer}[[{table}]]")
}

#[test]
fn a_wrong_sample_is_found() {
    let text =
        "```toml\n[time]\nend = 1\n```\n\n```toml each fluid.scalar\nname = \"a\"\nkind = \"heat\"\n```\n";
    let found = samples(text);
    assert_eq!(found.len(), 3);
    assert_eq!(found[2], (8, "[fluid]\n[[fluid.scalar]]\nkind = \"heat\"\n".to_string()));
    let errors = Case::parse(&found[2].1, "sample", &root()).expect_err("wrong");
    assert!(
        errors.0.iter().any(|error| error.key.ends_with("kind") && !error.message.contains("missing")),
        "{errors}"
    );
}

/// Samples of Rust stand word for word in the file that the line before them links, which a test builds.
#[test]
fn samples_of_rust_are_those_of_built_files() {
    let squeezed = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut looked_at = 0;
    for page in files("docs", ".md") {
        let text = text_of(&page);
        let parts: Vec<&str> = text.split("```").collect();
        for (before, sample) in parts.iter().zip(&parts[1..]).step_by(2) {
            let Some(sample) = sample.strip_prefix("rust\n") else { continue };
            looked_at += 1;
            let links = crate::links::targets(before.trim_end().rsplit("\n\n").next().unwrap_or_default());
            let file = links.last().unwrap_or_else(|| panic!("{}: no link before\n{sample}", shown(&page)));
            let source = text_of(&page.parent().expect("folder").join(file));
            assert!(
                squeezed(&source).contains(&squeezed(sample)),
                "{}: {file} has no\n{sample}",
                shown(&page)
            );
        }
    }
    assert!(looked_at >= 4, "{looked_at} samples");
}
