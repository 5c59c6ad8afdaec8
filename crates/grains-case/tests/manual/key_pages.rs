//! The pages of the manual on the keys of a case file.

use crate::examples::{Place, examples};
use crate::schema_tables::{Group, Key, Schema, Table, short};
use crate::{files, must_be_current, shown, text_of};
use serde_json::Value as Json;
use std::collections::HashMap;
use std::fmt::Write;

const HEAD: &str = "<!-- Written by `cargo test -p grains-case --test manual` from the schema of the case file; do not edit. -->\n";
const COLUMNS: &str = "\n| key | takes | unit | default | range | what |\n|---|---|---|---|---|---|\n";

#[test]
fn the_pages_of_keys_are_current() {
    let schema = Schema::of_cases();
    let (tables, examples) = (schema.tables(), examples(&schema));
    let manual = Manual { tables: &tables, examples: &examples };
    let mut pages = vec![("README".to_string(), manual.first_page())];
    let sections = tables.iter().filter(|table| !table.path.is_empty() && !table.path.contains('.'));
    pages.extend(sections.map(|section| (section.path.clone(), manual.page(section))));
    for (name, text) in &pages {
        must_be_current(&format!("docs/keys/{name}.md"), text);
    }
    for file in files("docs/keys", ".md") {
        let name = file.file_stem().expect("name").to_string_lossy().into_owned();
        assert!(pages.iter().any(|(page, _)| *page == name), "{} is of no section", shown(&file));
    }
}

/// Every key has a description, a unit or none by its nature, a default or need, and an example that is read by a test.
#[test]
fn every_key_is_described_in_full() {
    let schema = Schema::of_cases();
    let (tables, examples) = (schema.tables(), examples(&schema));
    let mut lacking = Vec::new();
    for table in &tables {
        for (group, key) in
            table.groups.iter().flat_map(|group| group.keys.iter().map(move |key| (group, key)))
        {
            let place = (table.name.clone(), group.kind.clone(), key.name.clone());
            let name = format!("{} {:?} `{}`", table.path, group.kind, key.name);
            if key.description.trim().len() < 5 {
                lacking.push(format!("{name} has no description"));
            }
            if key.is_number && key.unit.is_none() && key.tables.is_empty() {
                lacking.push(format!("{name} has no unit: {}", key.description));
            }
            if key.words.iter().any(|(_, says)| says.is_empty()) && key.words.len() > 1 {
                lacking.push(format!("{name} does not say what its words mean: {:?}", key.words));
            }
            if !examples.contains_key(&place) && of_another(&tables, table, group).is_none() {
                lacking.push(format!("{name} is in no case of tests/good"));
            }
        }
    }
    let keys: usize = tables.iter().flat_map(|table| &table.groups).map(|group| group.keys.len()).sum();
    assert!(keys > 450, "{keys} keys");
    assert!(lacking.is_empty(), "{}", lacking.join("\n"));
}

/// The table met before whose keys of the same kind are the same.
fn of_another<'a>(tables: &'a [Table], table: &Table, group: &Group) -> Option<&'a Table> {
    group.kind.as_ref()?;
    let is_same = |other: &&Group| {
        let names = |group: &Group| group.keys.iter().map(|key| key.name.clone()).collect::<Vec<_>>();
        other.kind == group.kind && other.description == group.description && names(other) == names(group)
    };
    let before = tables.iter().take_while(|other| other.name != table.name);
    before.into_iter().find(|other| other.groups.iter().any(|other| is_same(&other)))
}

struct Manual<'a> {
    tables: &'a [Table],
    examples: &'a HashMap<Place, String>,
}

impl Manual<'_> {
    fn table(&self, name: &str) -> &Table {
        self.tables.iter().find(|table| table.name == name).unwrap_or_else(|| panic!("no table {name}"))
    }

    /// What stands outside of sections, and which sections there are.
    fn first_page(&self) -> String {
        let case = self.table("case");
        let mut text = format!("{HEAD}# All keys\n\n{FIRST}\n## Keys before the first section\n{COLUMNS}");
        let (plain, sections): (Vec<&Key>, Vec<&Key>) =
            case.groups[0].keys.iter().partition(|key| key.tables.is_empty());
        plain.into_iter().for_each(|key| text += &self.row(case, &case.groups[0], key));
        text += "\n## Sections\n\n| section | what |\n|---|---|\n";
        for key in sections {
            let table = self.table(&key.tables[0]);
            let need = if key.is_required { " Required." } else { "" };
            let _ = writeln!(
                text,
                "| [`{}`]({}.md) | {}{need} |",
                headed(table),
                key.name,
                in_table(&key.description)
            );
        }
        text
    }

    /// A section with all tables that are first met in it.
    fn page(&self, section: &Table) -> String {
        let mut text = format!("{HEAD}# Keys of `{}`\n\n{}\n", headed(section), prose(&section.description));
        let inner = format!("{}.", section.path);
        for table in
            self.tables.iter().filter(|table| table.path == section.path || table.path.starts_with(&inner))
        {
            if table.path != section.path {
                let _ = write!(text, "\n## {}\n\n{}\n", table.path, prose(&table.description));
            }
            self.write_groups(table, &mut text);
        }
        text
    }

    fn write_groups(&self, table: &Table, text: &mut String) {
        let mut as_elsewhere: Vec<(String, &Table)> = Vec::new();
        for group in &table.groups {
            if let Some(other) = of_another(self.tables, table, group) {
                as_elsewhere.push((group.kind.clone().unwrap_or_default(), other));
                continue;
            }
            match &group.kind {
                Some(kind) => {
                    let _ = write!(text, "\n### kind = \"{kind}\"\n\n{}\n", prose(&group.description));
                }
                None if group.keys.is_empty() => continue,
                None => {}
            }
            if !group.keys.is_empty() {
                *text += COLUMNS;
                group.keys.iter().for_each(|key| *text += &self.row(table, group, key));
            }
        }
        if let Some((_, other)) = as_elsewhere.first() {
            let kinds: Vec<String> = as_elsewhere.iter().map(|(kind, _)| format!("`\"{kind}\"`")).collect();
            let _ = write!(
                text,
                "\nKinds with the keys that they have in {}: {}.\n",
                link(other),
                kinds.join(", ")
            );
        }
    }

    fn row(&self, table: &Table, group: &Group, key: &Key) -> String {
        let place = (table.name.clone(), group.kind.clone(), key.name.clone());
        let mut what = in_table(&key.description);
        for (word, says) in key.words.iter().filter(|_| key.name != "kind") {
            let _ = write!(what, "<br>`\"{word}\"`: {}", in_table(says));
        }
        if let Some(example) =
            self.examples.get(&place).filter(|text| key.name != "kind" && !text.starts_with('['))
        {
            let text: String = match example.char_indices().nth(110) {
                Some((end, _)) => format!("{} …", &example[..end]),
                None => example.clone(),
            };
            let _ = write!(what, "<br>Example: `{}`", text.replace('|', "\\|"));
        }
        let takes = match key.tables.iter().map(|name| link(self.table(name))).collect::<Vec<_>>() {
            tables if tables.is_empty() => key.takes.clone(),
            tables => format!("{}: {}", key.takes, tables.join(" or ")),
        };
        let default = match &key.default {
            _ if key.is_required => "required".to_string(),
            Some(Json::Array(all)) if all.len() > 4 && all.len() == key.words.len() => "all".to_string(),
            Some(default) => match toml_of(default) {
                long if long.len() > 60 => "as in its table".to_string(),
                text => format!("`{text}`"),
            },
            None if key.description.contains("efault") => "as it says".to_string(),
            None => "none".to_string(),
        };
        let unit = key.unit.clone().unwrap_or_default();
        format!(
            "| `{}` | {takes} | {} | {default} | {} | {what} |\n",
            key.name,
            in_table(&unit),
            in_table(&key.range)
        )
    }
}

const FIRST: &str = "\
These pages list every key of a case file. They are written from the schema by which the program reads cases, which
`grains-mpi schema` prints. The examples are lines of cases that a test reads.

* *takes*: what kind of value. A number may be written `1`, `1.0` or `1e0`. A formula is a text in x, y, z and t, such as `\"0.1*sin(2*pi*t)\"`.
* *unit*: all quantities are SI; `-` is none.
* *default*: what holds where the key is absent. A `required` key has none. `none` says that nothing is then set.
* *range*: what is refused outside, and after *usual* what draws a warning outside.
";

/// How a section is headed in a file.
fn headed(table: &Table) -> String {
    if table.is_list { format!("[[{}]]", table.path) } else { format!("[{}]", table.path) }
}

/// A link to where a table is described.
fn link(table: &Table) -> String {
    match table.path.split_once('.') {
        None => format!("[`{}`]({}.md)", headed(table), table.path),
        Some((section, _)) => {
            let anchor: String = table.path.to_lowercase().chars().filter(|c| *c != '.').collect();
            format!("[`{}`]({section}.md#{anchor})", table.path)
        }
    }
}

/// Text of a description as Markdown.
fn prose(text: &str) -> String {
    text.replace("\n\n", " ").replace('\n', " ").replace('<', "&lt;").replace('*', "\\*")
}

/// The same in the cell of a table.
fn in_table(text: &str) -> String {
    prose(text).replace('|', "\\|")
}

/// A value as a case file writes it.
fn toml_of(value: &Json) -> String {
    match value {
        Json::Object(table) if table.is_empty() => "{}".to_string(),
        Json::Object(table) => {
            let keys: Vec<String> =
                table.iter().map(|(key, value)| format!("{key} = {}", toml_of(value))).collect();
            format!("{{ {} }}", keys.join(", "))
        }
        Json::Array(list) => format!("[{}]", list.iter().map(toml_of).collect::<Vec<_>>().join(", ")),
        Json::Number(_) => short(value),
        other => other.to_string(),
    }
}

const FORMER: [&str; 3] = ["fluid.courant", "fluid.longest_step", "fluid.coupling.least_void_fraction"];

/// Keys that the manual names by their path, such as `fluid.coupling.drag`, are keys.
#[test]
fn keys_named_in_the_manual_exist() {
    let tables = Schema::of_cases().tables();
    let (mut wrong, mut looked_at) = (Vec::new(), 0);
    for page in files("docs", ".md") {
        let text = text_of(&page);
        for code in text.split('`').skip(1).step_by(2) {
            let words: Vec<&str> = code.split('.').collect();
            let is_word =
                |word: &&str| !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c == '_');
            let is_section = tables.iter().any(|table| table.path == words[0]);
            let is_file = words
                .last()
                .is_some_and(|last| ["md", "toml", "csv", "vtkhdf", "xdmf", "rs", "py"].contains(last));
            // Names of earlier versions are told as such.
            let is_former = FORMER.contains(&code);
            if is_former || words.len() < 2 || !words.iter().all(is_word) || !is_section || is_file {
                continue;
            }
            looked_at += 1;
            if !leads_somewhere(&tables, "case", &words) {
                wrong.push(format!("{}: {code}", shown(&page)));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(looked_at > 30, "{looked_at} keys");
}

/// Whether words lead from a table to a key.
fn leads_somewhere(tables: &[Table], name: &str, words: &[&str]) -> bool {
    let Some((first, rest)) = words.split_first() else { return true };
    let table = tables.iter().find(|table| table.name == name).expect("table");
    let keys = table.groups.iter().flat_map(|group| &group.keys).filter(|key| key.name == *first);
    keys.into_iter()
        .any(|key| rest.is_empty() || key.tables.iter().any(|inner| leads_somewhere(tables, inner, rest)))
}
