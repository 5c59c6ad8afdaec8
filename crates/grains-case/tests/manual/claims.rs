//! The ledger of claims is well formed and says what READMEs say; the page of the manual that shows it is current.

use crate::{files, must_be_current, root, text_of};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

const HEAD: &str = "\
<!-- Written by `cargo test -p grains-case --test manual` from cases/ledger.toml; do not edit. -->
# Claims

Each figure that is stated as a result, with its source and what it does not show. [cases/ledger.toml](../cases/ledger.toml) has the
command, the tolerance and the machine of each. `scripts/reproduce ID` runs the command in a folder of its own, reads the figure and compares;
`scripts/reproduce --list` lists all, `scripts/reproduce --cheap 60` repeats those that take a minute or less. Costs are seconds of
the command as READMEs state them or as measured, and a claim beside another may share its command.

Grades: *exact* is a closed form, a law of conservation or the same bits; *theory* a law with assumptions of its own; *experiment* a measurement or a
correlation of such; *other code* a simulation by others; *shown* has nothing to be compared with.
";

/// Grades from the strongest to the weakest.
const GRADES: [&str; 5] = ["exact", "theory", "experiment", "other code", "shown"];

/// One value or several.
#[derive(Deserialize)]
#[serde(untagged)]
enum Words {
    One(String),
    Many(Vec<String>),
}

impl Words {
    fn all(&self) -> &[String] {
        match self {
            Words::One(word) => std::slice::from_ref(word),
            Words::Many(words) => words,
        }
    }
}

/// Seconds, or "unknown".
#[derive(Deserialize)]
#[serde(untagged)]
enum Cost {
    Seconds(f64),
    Word(String),
}

/// A claim with what its case says of all.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Claim {
    id: String,
    statement: String,
    grade: String,
    source: String,
    source_value: Option<Words>,
    figure: Words,
    unit: String,
    tolerance: String,
    command: String,
    no_command: Option<String>,
    result: String,
    file: Option<String>,
    column: Option<String>,
    take: Option<String>,
    scale: Option<f64>,
    cost: Cost,
    machine: String,
    date: String,
    seen: Option<Words>,
    #[serde(rename = "where")]
    places: Vec<String>,
    does_not_show: String,
}

impl Claim {
    fn case(&self) -> &str {
        self.id.split('.').next().unwrap_or_default()
    }
}

/// All claims in the order of the ledger.
fn claims() -> Vec<Claim> {
    let ledger: toml::Table = text_of(&root().join("cases/ledger.toml")).parse().expect("ledger");
    let claims = ledger["claim"].as_array().expect("claims");
    claims.iter().map(|claim| with_defaults(claim.as_table().expect("claim"), &ledger)).collect()
}

/// A claim of the ledger with the keys of its case that it does not have itself.
fn with_defaults(claim: &toml::Table, ledger: &toml::Table) -> Claim {
    let id = claim["id"].as_str().expect("id");
    let case = ledger["case"].get(id.split('.').next().unwrap_or_default());
    let mut whole = case.and_then(|case| case.as_table()).cloned().unwrap_or_default();
    whole.extend(claim.clone());
    whole.try_into().unwrap_or_else(|error| panic!("{id}: {error}"))
}

#[test]
fn the_page_of_claims_is_current() {
    let claims = claims();
    let mut text = HEAD.to_string();
    text += "\n| grade | claims | with a command | repeated | when |\n|---|---|---|---|---|\n";
    for grade in GRADES {
        let of_it: Vec<&Claim> = claims.iter().filter(|claim| claim.grade == grade).collect();
        let with_command = of_it.iter().filter(|claim| !claim.command.is_empty()).count();
        let repeated: Vec<&&Claim> = of_it.iter().filter(|claim| claim.seen.is_some()).collect();
        let days: BTreeSet<&str> = repeated.iter().map(|claim| &*claim.date).collect();
        let days = days.into_iter().collect::<Vec<_>>().join(", ");
        let _ =
            writeln!(text, "| {grade} | {} | {with_command} | {} | {days} |", of_it.len(), repeated.len());
    }
    let mut of_cases: Vec<(&str, Vec<&Claim>)> = Vec::new();
    for claim in &claims {
        match of_cases.last_mut() {
            Some((case, of_it)) if *case == claim.case() => of_it.push(claim),
            _ => of_cases.push((claim.case(), vec![claim])),
        }
    }
    for (case, of_it) in of_cases {
        let page = of_it[0].places.last().expect("a place");
        let page = of_it[0].places.iter().find(|place| place.contains(case)).unwrap_or(page);
        let _ = write!(text, "\n## [{case}](../{page})\n\n");
        text += "| id | claim | here | source | grade | does not show | s | date |\n|---|---|---|---|---|---|---|---|\n";
        of_it.iter().for_each(|claim| text += &row(claim));
    }
    must_be_current("docs/claims.md", &text);
}

/// A claim as a row of its case's table.
fn row(claim: &Claim) -> String {
    let in_cell = |text: &str| text.replace('|', "\\|").replace('\n', " ");
    let unit = if claim.unit == "-" { String::new() } else { format!(" {}", claim.unit) };
    let here = format!("{}{unit} ({})", claim.figure.all().join(", "), claim.tolerance);
    let values =
        claim.source_value.as_ref().map_or(String::new(), |value| format!(": {}", value.all().join(", ")));
    let cost = match &claim.cost {
        Cost::Seconds(seconds) => format!("{seconds}"),
        Cost::Word(word) => word.clone(),
    };
    let missing = claim.no_command.as_ref().map_or(String::new(), |why| format!(" No command: {why}."));
    let shown = in_cell(&format!("{}{missing}", claim.does_not_show));
    let repeated = if claim.seen.is_some() { " repeated" } else { "" };
    format!(
        "| `{}` | {} | {} | {} | {} | {shown} | {cost} | {}{repeated} |\n",
        claim.id,
        in_cell(&claim.statement),
        in_cell(&here),
        in_cell(&format!("{}{values}", claim.source)),
        claim.grade,
        claim.date
    )
}

#[test]
fn every_claim_can_be_repeated_or_says_why_not() {
    let mut seen = BTreeSet::new();
    for claim in claims() {
        let id = &claim.id;
        assert!(seen.insert(id.clone()), "{id} is there twice");
        let is_kebab = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "-.".contains(c);
        assert!(id.contains('.') && id.chars().all(is_kebab), "{id} is not CASE.WHAT in lower case");
        assert!(GRADES.contains(&&*claim.grade), "{id}: grade {}", claim.grade);
        let is_number =
            claim.tolerance.trim_end_matches(" %").parse::<f64>().is_ok_and(|number| number > 0.0);
        assert!(is_number || claim.tolerance == "bits", "{id}: tolerance {}", claim.tolerance);
        assert_eq!(
            claim.command.is_empty(),
            claim.no_command.is_some(),
            "{id}: a command, or why there is none"
        );
        let is_read = !claim.result.is_empty() || (claim.file.is_some() && claim.column.is_some());
        assert_eq!(is_read, !claim.command.is_empty(), "{id}: where the figure is read");
        assert!(
            claim.take.as_deref().is_none_or(|take| ["largest", "count", "mean"].contains(&take)),
            "{id}: take"
        );
        assert!(claim.scale.is_none_or(f64::is_normal), "{id}: scale");
        assert!(
            matches!(&claim.cost, Cost::Seconds(s) if *s > 0.0)
                || matches!(&claim.cost, Cost::Word(w) if w == "unknown"),
            "{id}: cost"
        );
        assert!(
            claim.grade == "shown" || claim.case() == "methods" || !claim.source.is_empty(),
            "{id}: a source"
        );
        for text in [&claim.statement, &claim.machine, &claim.does_not_show, &claim.unit] {
            assert!(!text.is_empty(), "{id}: an empty field");
        }
        let date: Vec<&str> = claim.date.split('-').collect();
        assert!(
            date.len() == 3 && date[0].len() == 4 && date.iter().all(|part| part.parse::<u32>().is_ok()),
            "{id}: date {}",
            claim.date
        );
        if let Some(again) = &claim.seen {
            assert_eq!(again.all().len(), claim.figure.all().len(), "{id}: as many figures as before");
        }
        for word in claim.command.split([' ', '"', '\'']) {
            let is_file = ["cases/", "scaling/", "scripts/"].iter().any(|folder| word.starts_with(folder));
            assert!(!is_file || root().join(word).is_file(), "{id}: no file {word}");
        }
    }
}

#[test]
fn every_claim_is_stated_where_the_ledger_says() {
    let mut texts = BTreeMap::new();
    for claim in claims() {
        for place in &claim.places {
            let text =
                texts.entry(place.clone()).or_insert_with(|| text_of(&root().join(place)).replace('−', "-"));
            for figure in claim.figure.all().iter().filter(|figure| *figure != "ok") {
                assert!(is_stated(text, figure), "{}: {place} does not state {figure}", claim.id);
            }
        }
    }
}

/// Whether a figure stands in a text and is no part of a longer one.
fn is_stated(text: &str, figure: &str) -> bool {
    text.match_indices(figure).any(|(at, _)| {
        let before = text[..at].chars().next_back();
        let mut after = text[at + figure.len()..].chars();
        let next = after.next();
        let goes_on = next == Some('.') && after.next().is_some_and(|c| c.is_ascii_digit());
        !before.is_some_and(|c| c.is_ascii_digit() || c == '.')
            && !goes_on
            && !next.is_some_and(|c| c.is_ascii_digit())
    })
}

#[test]
fn every_case_has_a_claim() {
    let claims = claims();
    for readme in files("cases", "README.md") {
        let folder = readme.parent().expect("folder");
        let name = folder.file_name().expect("name").to_string_lossy().into_owned();
        let is_case = folder.parent() == Some(&root().join("cases"));
        assert!(
            !is_case || claims.iter().any(|claim| claim.case() == name),
            "cases/{name} has no claim in cases/ledger.toml"
        );
    }
}
