//! The tables of a case file as its schema describes them.

use serde_json::{Map, Value as Json};
use std::collections::BTreeMap;

/// A table of the case file: a section, or what a key holds.
pub struct Table {
    /// Name of its type in the schema, or `case`.
    pub name: String,
    /// Path of keys that leads to it, such as `wall.motion`; empty for the file.
    pub path: String,
    pub description: String,
    /// Keys of all kinds first, then those of each kind.
    pub groups: Vec<Group>,
    /// Whether several may be given.
    pub is_list: bool,
}

/// Keys that stand together: those of one kind, or of all.
pub struct Group {
    pub kind: Option<String>,
    pub description: String,
    pub keys: Vec<Key>,
}

/// A key of a table.
pub struct Key {
    pub name: String,
    pub description: String,
    /// What it takes, such as `3 numbers`.
    pub takes: String,
    /// `None` where no unit is stated.
    pub unit: Option<String>,
    pub is_number: bool,
    pub is_required: bool,
    pub default: Option<Json>,
    pub range: String,
    /// Words to choose from, each with what it says.
    pub words: Vec<(String, String)>,
    /// Names of the types of the tables that it may hold.
    pub tables: Vec<String>,
}

/// The schema and its types by name.
pub struct Schema {
    whole: Json,
}

impl Schema {
    pub fn of_cases() -> Self {
        Self { whole: grains_case::schema() }
    }

    /// What a reference stands for, and the name of its type.
    pub fn resolved<'a>(&'a self, mut schema: &'a Json) -> (&'a Json, Option<&'a str>) {
        let mut name = None;
        while let Some(reference) = schema.get("$ref").and_then(Json::as_str) {
            let last = reference.rsplit('/').next().expect("name");
            schema = &self.whole["$defs"][last];
            name = Some(last);
        }
        (schema, name)
    }

    pub fn whole(&self) -> &Json {
        &self.whole
    }

    /// Schemas of which a value satisfies one.
    pub fn alternatives<'a>(&'a self, schema: &'a Json) -> Vec<&'a Json> {
        let lists = ["anyOf", "oneOf"].iter().filter_map(|word| schema.get(*word)?.as_array()).flatten();
        let branches = ["then", "else"].iter().filter_map(|word| schema.get(*word));
        lists.chain(branches.filter(|branch| branch.get("required").is_none())).collect()
    }

    /// All tables in the order in which a reader meets them; each type once.
    pub fn tables(&self) -> Vec<Table> {
        let mut tables = Vec::new();
        self.visit("case", "", &self.whole, false, &mut tables);
        tables
    }

    fn visit(&self, name: &str, path: &str, schema: &Json, is_list: bool, tables: &mut Vec<Table>) {
        let (schema, of_type) = self.resolved(schema);
        let name = of_type.unwrap_or(name);
        if tables.iter().any(|table| table.name == name) {
            return;
        }
        let common = Group {
            kind: None,
            description: String::new(),
            keys: self.keys(schema.get("properties"), schema.get("required")),
        };
        let branches = schema.get("allOf").and_then(Json::as_array).into_iter().flatten();
        let of_kinds = branches.filter_map(|branch| {
            let kind = branch["if"]["properties"]["kind"]["const"].as_str()?;
            let mut keys = self.keys(branch["then"].get("properties"), branch["then"].get("required"));
            keys.retain(|key| key.name != "kind");
            let description = words_of(&schema["properties"]["kind"]).remove(kind).unwrap_or_default();
            Some(Group { kind: Some(kind.to_string()), description, keys })
        });
        let groups: Vec<Group> = std::iter::once(common).chain(of_kinds).collect();
        let description = schema.get("description").and_then(Json::as_str).unwrap_or_default().to_string();
        tables.push(Table { name: name.to_string(), path: path.to_string(), description, groups, is_list });
        let mut inner: Vec<(&String, &Json)> = properties(schema).collect();
        // Motions are those of walls first.
        inner.sort_by_key(|(key, _)| (key.as_str() != "wall", key.as_str() == "insert"));
        for (key, value) in inner {
            let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
            self.visit_value(&format!("{name}.{key}"), &path, value, false, tables);
        }
    }

    /// Visits the tables that a value may be or hold.
    fn visit_value(&self, name: &str, path: &str, schema: &Json, is_list: bool, tables: &mut Vec<Table>) {
        let (resolved, _) = self.resolved(schema);
        if resolved.get("properties").is_some() || resolved.get("allOf").is_some() {
            self.visit(name, path, schema, is_list, tables);
        } else if let Some(items) = resolved.get("items").filter(|items| items.is_object()) {
            self.visit_value(name, path, items, true, tables);
        } else {
            for alternative in self.alternatives(resolved) {
                self.visit_value(name, path, alternative, is_list, tables);
            }
        }
    }

    fn keys(&self, properties: Option<&Json>, required: Option<&Json>) -> Vec<Key> {
        let required: Vec<&str> =
            required.and_then(Json::as_array).into_iter().flatten().filter_map(Json::as_str).collect();
        let properties = properties.and_then(Json::as_object).into_iter().flatten();
        let own = properties.filter(|(_, schema)| schema.is_object());
        own.map(|(name, schema)| self.key(name, schema, required.contains(&&**name))).collect()
    }

    fn key(&self, name: &str, schema: &Json, is_required: bool) -> Key {
        let (resolved, _) = self.resolved(schema);
        let text = schema.get("description").or(resolved.get("description"));
        let text = text.and_then(Json::as_str).unwrap_or_default();
        let mut words = words_of(schema);
        for place in std::iter::once(resolved).chain(self.alternatives(resolved)).chain(resolved.get("items"))
        {
            words.extend(words_of(self.resolved(place).0));
        }
        let description = text.split("\n\n- ").next().unwrap_or(text).trim_end_matches(':').to_string();
        let mut tables = Vec::new();
        self.tables_in(schema, &mut tables);
        Key {
            name: name.to_string(),
            unit: unit_of(&description),
            description,
            takes: self.takes(schema),
            is_number: self.is_number(schema),
            is_required,
            default: schema.get("default").cloned(),
            range: self.range(schema),
            words: words.into_iter().collect(),
            tables,
        }
    }

    fn tables_in(&self, schema: &Json, tables: &mut Vec<String>) {
        let (resolved, name) = self.resolved(schema);
        if resolved.get("properties").is_some() || resolved.get("allOf").is_some() {
            tables.extend(name.map(str::to_string));
        } else {
            let inner = resolved.get("items").into_iter().chain(self.alternatives(resolved));
            inner.for_each(|inner| self.tables_in(inner, tables));
        }
    }

    fn is_number(&self, schema: &Json) -> bool {
        let (schema, _) = self.resolved(schema);
        let kind = schema.get("type").and_then(Json::as_str);
        let inner = schema.get("items").into_iter().chain(self.alternatives(schema));
        matches!(kind, Some("number" | "integer"))
            || inner.into_iter().any(|inner| inner.is_object() && self.is_number(inner))
    }

    /// What a value is, in a few words.
    fn takes(&self, schema: &Json) -> String {
        let (schema, name) = self.resolved(schema);
        if schema.get("enum").is_some() || schema.get("const").is_some() {
            return "word".into();
        }
        if schema.get("properties").is_some() || schema.get("allOf").is_some() {
            return "table".into();
        }
        match schema.get("type").and_then(Json::as_str) {
            Some("array") => self.list(schema),
            Some("string") if name == Some("Formula") => "formula".into(),
            Some("string") => "text".into(),
            Some("boolean") => "true or false".into(),
            Some("integer") => "whole number".into(),
            Some(other) => other.to_string(),
            None => {
                let mut each: Vec<String> =
                    self.alternatives(schema).into_iter().map(|one| self.takes(one)).collect();
                each.dedup();
                each.join(" or ")
            }
        }
    }

    fn list(&self, schema: &Json) -> String {
        let [min, max] = ["minItems", "maxItems"].map(|word| schema.get(word).and_then(Json::as_u64));
        let inner = self.takes(&schema["items"]);
        let several = match inner.as_str() {
            "true or false" => "truth values".to_string(),
            "text" => "texts".to_string(),
            text if text.contains(" or ") => format!("values: {text}"),
            text if text.starts_with("list") => text.replacen("list", "lists", 1),
            text if text.starts_with(|c: char| c.is_ascii_digit()) => format!("rows of {text}"),
            text => format!("{text}s"),
        };
        match (min, max) {
            (Some(min), Some(max)) if min == max => format!("{min} {several}"),
            (Some(min), _) if min > 0 => format!("list of {several}, {min} or more"),
            _ => format!("list of {several}"),
        }
    }

    /// What a number may be, and outside of what the program warns.
    fn range(&self, schema: &Json) -> String {
        let (schema, _) = self.resolved(schema);
        let bound = |word: &str| schema.get(word).filter(|bound| bound.is_number()).map(short);
        let format = |sign: &str, word: &str| bound(word).map(|bound| format!("{sign} {bound}"));
        let mut parts = Vec::new();
        match (bound("minimum"), bound("maximum")) {
            (Some(min), Some(max)) => parts.push(format!("{min} to {max}")),
            _ => parts.extend(
                [
                    format(">", "exclusiveMinimum"),
                    format("≥", "minimum"),
                    format("<", "exclusiveMaximum"),
                    format("≤", "maximum"),
                ]
                .into_iter()
                .flatten(),
            ),
        }
        let mut range = parts.join(", ");
        if let Some([min, max]) = schema.get("x-plausible").and_then(Json::as_array).map(Vec::as_slice) {
            range += &format!(
                "{}usual {} to {}",
                if range.is_empty() { "" } else { "; " },
                short(min),
                short(max)
            );
        }
        if schema.get("x-infinite").is_some() {
            range += " or inf";
        }
        if range.is_empty() {
            let inner = schema.get("items").into_iter().chain(self.alternatives(schema));
            let each = inner.filter(|inner| inner.is_object()).map(|inner| self.range(inner));
            return each.filter(|range| !range.is_empty()).collect::<Vec<_>>().join("; ");
        }
        range
    }
}

/// All keys of a table, of all kinds, with their schemas.
fn properties(schema: &Json) -> impl Iterator<Item = (&String, &Json)> {
    let branches = schema.get("allOf").and_then(Json::as_array).into_iter().flatten();
    let maps = std::iter::once(schema).chain(branches.filter_map(|branch| branch.get("then")));
    let maps = maps.filter_map(|map| map.get("properties").and_then(Json::as_object));
    maps.flat_map(Map::iter).filter(|(_, schema)| schema.is_object())
}

/// Words of a choice and what each says: lines `- "word": text` of its description.
fn words_of(schema: &Json) -> BTreeMap<String, String> {
    let Some(list) = schema.get("enum").and_then(Json::as_array) else { return BTreeMap::new() };
    let text = schema.get("description").and_then(Json::as_str).unwrap_or_default();
    let said = |word: &str| {
        let begin = format!("- \"{word}\": ");
        text.lines().find_map(|line| line.strip_prefix(&begin)).unwrap_or_default().to_string()
    };
    list.iter().filter_map(Json::as_str).map(|word| (word.to_string(), said(word))).collect()
}

/// The unit in a description: the first parentheses that hold one.
fn unit_of(description: &str) -> Option<String> {
    let is_unit = |text: &str| {
        const UNITS: [&str; 16] = [
            "m",
            "s",
            "kg",
            "N",
            "Pa",
            "K",
            "J",
            "W",
            "rad",
            "mol",
            "Hz",
            "1",
            "cells",
            "diameters",
            "-",
            "per",
        ];
        let begins = text.split(|c: char| !(c.is_alphanumeric() || c == '-')).next().unwrap_or_default();
        let begins = begins.trim_end_matches(['²', '³', 'ⁿ']);
        UNITS.contains(&begins) && !text.contains(['=', '−'])
    };
    let mut rest = description;
    while let Some(begin) = rest.find('(') {
        let mut depth = 0;
        let end = rest[begin..].find(|c: char| {
            depth += i32::from(c == '(') - i32::from(c == ')');
            depth == 0
        })?;
        let inner = &rest[begin + 1..begin + end];
        if is_unit(inner) {
            return Some(inner.replace('\n', " "));
        }
        rest = &rest[begin + 1..];
    }
    None
}

/// A number as one would write it.
pub fn short(number: &Json) -> String {
    match number.as_f64() {
        // Six digits of what is no round number.
        Some(x) => {
            let x = format!("{x:.5e}").parse().unwrap_or(x);
            if x != 0.0 && !(1e-3..1e5).contains(&f64::abs(x)) { format!("{x:e}") } else { format!("{x}") }
        }
        None => number.to_string(),
    }
}
