//! An example of each key, as a case that is tested writes it.

use crate::schema_tables::Schema;
use crate::{files, text_of};
use grains_case::Case;
use serde_json::Value as Json;
use std::collections::HashMap;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Where a key stands: its table, the kind of that, and its name.
pub type Place = (String, Option<String>, String);

/// What the good cases write for each key, the shortest of all.
pub fn examples(schema: &Schema) -> HashMap<Place, String> {
    let mut found = Found { schema, examples: HashMap::new(), text: String::new() };
    for file in files("crates/grains-case/tests/good", ".toml") {
        Case::load(&file).unwrap_or_else(|errors| panic!("{errors}"));
        found.text = text_of(&file);
        let text = found.text.clone();
        let tree = DeTable::parse(&text).expect("a case that was read");
        found.table("case", schema.whole(), tree.get_ref());
    }
    found.examples
}

struct Found<'a> {
    schema: &'a Schema,
    examples: HashMap<Place, String>,
    text: String,
}

impl Found<'_> {
    fn table(&mut self, name: &str, schema: &Json, table: &DeTable) {
        let (schema, of_type) = self.schema.resolved(schema);
        let name = of_type.unwrap_or(name);
        if schema.get("properties").is_none() && schema.get("allOf").is_none() {
            let alternatives: Vec<Json> = self.schema.alternatives(schema).into_iter().cloned().collect();
            return alternatives.iter().for_each(|alternative| self.table(name, alternative, table));
        }
        let kind = table.iter().find(|(key, _)| key.get_ref() == "kind");
        let kind = kind.and_then(|(_, value)| value.get_ref().as_str()).map(str::to_string);
        let branches = schema.get("allOf").and_then(Json::as_array).into_iter().flatten();
        let of_kind =
            branches.filter(|branch| branch["if"]["properties"]["kind"]["const"].as_str() == kind.as_deref());
        let layers: Vec<(Option<String>, Json)> = std::iter::once((None, schema.clone()))
            .chain(of_kind.map(|branch| (kind.clone(), branch["then"].clone())))
            .collect();
        for (key, value) in table.iter() {
            let key = key.get_ref().as_ref();
            for (kind, layer) in &layers {
                let property = &layer["properties"][key];
                if property.is_object() && (kind.is_none() || key != "kind") {
                    self.note((name.to_string(), kind.clone(), key.to_string()), value);
                    self.value(&format!("{name}.{key}"), property, value);
                }
            }
        }
    }

    fn value(&mut self, name: &str, schema: &Json, value: &Spanned<DeValue>) {
        match value.get_ref() {
            DeValue::Table(table) => self.table(name, schema, table),
            DeValue::Array(list) => {
                let (resolved, _) = self.schema.resolved(schema);
                let inner = resolved.get("items").into_iter().chain(self.schema.alternatives(resolved));
                let inner: Vec<Json> = inner.cloned().collect();
                for item in list.iter() {
                    inner.iter().for_each(|inner| self.value(name, inner, item));
                }
            }
            _ => {}
        }
    }

    fn note(&mut self, place: Place, value: &Spanned<DeValue>) {
        let text = self.written(&place.2, value);
        let is_better =
            self.examples.get(&place).is_none_or(|there| text.chars().count() < there.chars().count());
        if is_better {
            self.examples.insert(place, text);
        }
    }

    /// The assignment as the file has it, on one line; the header of a table that has one.
    fn written(&self, key: &str, value: &Spanned<DeValue>) -> String {
        let source = |value: &Spanned<DeValue>| self.text[value.span()].to_string();
        let has_header = |value: &Spanned<DeValue>| {
            matches!(value.get_ref(), DeValue::Table(_)) && !source(value).starts_with('{')
        };
        if has_header(value) {
            return format!("[{key}]");
        }
        if let DeValue::Array(list) = value.get_ref()
            && list.iter().next().is_some_and(has_header)
        {
            return format!("[[{key}]]");
        }
        let lines: Vec<String> = source(value)
            .lines()
            .map(|line| line.split(" #").next().unwrap_or(line).trim().to_string())
            .filter(|line| !line.is_empty() && !line.starts_with('#'))
            .collect();
        format!("{key} = {}", lines.join(" "))
    }
}
