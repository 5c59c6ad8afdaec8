//! Links of all Markdown files of the repository, and the table of contents of the manual.

use crate::{files, root, shown, text_of};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

#[test]
fn every_link_leads_somewhere() {
    let pages = files("", ".md");
    let mut anchors: HashMap<PathBuf, HashSet<String>> = HashMap::new();
    let (mut broken, mut looked_at) = (Vec::new(), 0);
    for page in &pages {
        let text = text_of(page);
        for target in targets(&text).into_iter().filter(|target| !target.contains("://")) {
            looked_at += 1;
            let (path, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let file = match path {
                "" => page.clone(),
                path => page.parent().expect("folder").join(path),
            };
            let is_there = file.exists() && !path.starts_with('/');
            let has_anchor = anchor.is_empty()
                || !is_there
                || anchors
                    .entry(file.clone())
                    .or_insert_with(|| anchors_of(&text_of(&file)))
                    .contains(anchor);
            if !is_there || !has_anchor {
                broken.push(format!("{}: {target}", shown(page)));
            }
        }
    }
    assert!(broken.is_empty(), "links that lead nowhere:\n{}", broken.join("\n"));
    assert!(looked_at > 300, "only {looked_at} links");
}

/// The manual leads to every page of docs, to every case, and to nothing twice.
#[test]
fn the_table_of_contents_is_complete() {
    let summary = root().join("docs/SUMMARY.md");
    let listed: Vec<PathBuf> = targets(&text_of(&summary))
        .iter()
        .map(|target| {
            summary
                .parent()
                .expect("docs")
                .join(target)
                .canonicalize()
                .unwrap_or_else(|e| panic!("{target}: {e}"))
        })
        .collect();
    let cases = files("cases", "README.md");
    for page in files("docs", ".md").iter().chain(&cases).filter(|page| !page.ends_with("SUMMARY.md")) {
        assert!(listed.contains(page), "docs/SUMMARY.md lacks {}", shown(page));
    }
    let once: HashSet<&PathBuf> = listed.iter().collect();
    assert_eq!(once.len(), listed.len(), "docs/SUMMARY.md names a page twice");
}

/// What the links and pictures of a page lead to, without code.
pub fn targets(text: &str) -> Vec<String> {
    let text = without_code(text);
    let mut found = Vec::new();
    for (opening, closing) in [("](", ')'), ("src=\"", '"'), ("href=\"", '"')] {
        for (begin, _) in text.match_indices(opening) {
            let rest = &text[begin + opening.len()..];
            let end = rest.find(closing).unwrap_or(0);
            found.push(rest[..end].split(" \"").next().unwrap_or_default().to_string());
        }
    }
    found
}

/// The text without blocks of code and without code in lines, which may look like links.
fn without_code(text: &str) -> String {
    let mut is_code = false;
    let mut kept = String::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            is_code = !is_code;
        } else if !is_code {
            kept.extend(line.split('`').step_by(2));
            kept.push('\n');
        }
    }
    kept
}

/// Anchors that headings of a page get.
fn anchors_of(text: &str) -> HashSet<String> {
    let mut is_code = false;
    let mut counts: HashMap<String, usize> = HashMap::new();
    let mut anchors = HashSet::new();
    for line in text.lines() {
        is_code ^= line.trim_start().starts_with("```");
        let title = line.trim_start_matches('#');
        if is_code || title.len() == line.len() || !title.starts_with(' ') {
            continue;
        }
        let words = title.trim().to_lowercase();
        let kept = words.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        let anchor: String = kept.map(|c| if c == ' ' { '-' } else { c }).collect();
        let count = counts.entry(anchor.clone()).or_insert(0);
        anchors.insert(if *count == 0 { anchor } else { format!("{anchor}-{count}") });
        *count += 1;
    }
    anchors
}

#[test]
fn links_and_anchors_are_found() {
    let text = "# A `b` [[c]] — d_e\n[x](y.md#z) `[no](no)` ![p](p.png \"t\")\n```sh\n# no\n[no](no)\n```\n## Twice\n## Twice\n";
    assert_eq!(targets(text), ["y.md#z", "p.png"]);
    let expected = ["a-b-c--d_e", "twice", "twice-1"].map(str::to_string);
    assert_eq!(anchors_of(text), HashSet::from(expected));
    assert!(Path::new(&root()).join("docs/SUMMARY.md").exists());
}
