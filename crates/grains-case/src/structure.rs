//! Reads the spanned TOML tree along the JSON schema of the format: keys, types, choices and ranges.
//!
//! serde would stop at the first mistake; here all of them are reported, each at its place, and what
//! is left is a clean tree that serde takes without complaint.

use std::sync::OnceLock;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value as Json;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use crate::check::Checker;
use crate::diagnostic::{closest, unknown};
use crate::editor_schema::for_editors;
use crate::raw::RawCase;
use crate::renamed;
use crate::values;

/// JSON schema (draft 2020-12) of the case file, generated from the types; for editors and manuals.
pub fn schema() -> Json {
    schema_of::<RawCase>()
}

/// The schema of a type in the form that editors need.
pub(crate) fn schema_of<T: JsonSchema>() -> Json {
    for_editors(schema_of_types::<T>())
}

/// The schema as the types give it, with alternatives.
pub(crate) fn schema_of_types<T: JsonSchema>() -> Json {
    let mut schema = schemars::schema_for!(T).to_value();
    remove_null_defaults(&mut schema);
    schema
}

/// JSON has no infinity: such a default would appear as a null that the schema itself forbids.
fn remove_null_defaults(schema: &mut Json) {
    match schema {
        Json::Object(map) => {
            if map.get("default").is_some_and(Json::is_null) {
                map.remove("default");
            }
            map.values_mut().for_each(remove_null_defaults);
        }
        Json::Array(list) => list.iter_mut().for_each(remove_null_defaults),
        _ => {}
    }
}

/// The schema for a case with or without a fluid: without one, what the schema asks for then are lists that must not be
/// empty. Made once.
fn schema_for_reading(has_fluid: bool) -> &'static Json {
    static SCHEMAS: OnceLock<[Json; 2]> = OnceLock::new();
    let schemas = SCHEMAS.get_or_init(|| {
        let with_fluid = schema_of_types::<RawCase>();
        let mut without = with_fluid.clone();
        let keys = without["then"]["required"].as_array().cloned().unwrap_or_default();
        for key in keys.iter().filter_map(Json::as_str) {
            without["properties"][key]["minItems"] = 1.into();
        }
        if let Some(required) = without["required"].as_array_mut() {
            required.extend(keys);
        }
        [without, with_fluid]
    });
    &schemas[usize::from(has_fluid)]
}

/// The case as written, or `None` if it is too broken to be looked at further; either way all remarks
/// are left with the checker.
pub(crate) fn read(checker: &mut Checker) -> Option<RawCase> {
    read_as(schema_for_reading(checker.source.root().contains_key("fluid")), checker)
}

/// What the schema of a type says of the whole file; remarks are left with the checker.
pub(crate) fn read_as<T: DeserializeOwned>(schema: &Json, checker: &mut Checker) -> Option<T> {
    let source = checker.source;
    let mut reader = Reader { schema, checker };
    let tree = reader.read_table(&reader.layers_of(schema), source.root(), 0..0, "")?;
    match T::deserialize(tree) {
        Ok(raw) => Some(raw),
        Err(error) => {
            // The schema comes from the same types, so this only happens where it says less than they do.
            checker.error("", format!("not understood: {}", error.message()));
            None
        }
    }
}

/// The schemas that all apply to one value, the most specific description first.
struct Layers<'a> {
    schemas: Vec<&'a Json>,
    /// Keys of the variants that were not chosen, with the name of their kind.
    foreign: Vec<(&'a str, &'a str)>,
    /// Whether `kind` is absent or unknown, so that keys of any variant must pass.
    is_kind_unknown: bool,
}

impl<'a> Layers<'a> {
    fn find(&self, keyword: &str) -> Option<&'a Json> {
        self.schemas.iter().find_map(|schema| schema.get(keyword))
    }

    /// The schema of a key; of a table whose keys are names it is that of all of them.
    fn property(&self, key: &str) -> Option<&'a Json> {
        let named = self.schemas.iter().find_map(|schema| schema.get("properties")?.get(key));
        named.or_else(|| self.find("additionalProperties").filter(|schema| schema.is_object()))
    }

    /// Keys in the order of the schemas, own keys before those of a variant.
    fn keys(&self) -> Vec<&'a str> {
        let maps = self.schemas.iter().filter_map(|schema| schema.get("properties")?.as_object());
        maps.flat_map(|map| map.keys().map(String::as_str)).collect()
    }

    fn required(&self) -> impl Iterator<Item = &'a str> {
        let lists = self.schemas.iter().filter_map(|schema| schema.get("required")?.as_array());
        lists.flatten().filter_map(Json::as_str)
    }
}

struct Reader<'a, 's, 'c> {
    schema: &'a Json,
    checker: &'c mut Checker<'s>,
}

type Span = std::ops::Range<usize>;

impl<'a> Reader<'a, '_, '_> {
    fn error(&mut self, span: &Span, path: &str, quoted: bool, message: String) {
        let remark = self.checker.source.at(span, path, quoted, message);
        self.checker.errors.push(remark);
    }

    /// The schema a `$ref` stands for.
    fn target(&self, schema: &'a Json) -> &'a Json {
        let name = schema.get("$ref").and_then(Json::as_str).and_then(|r| r.strip_prefix("#/$defs/"));
        name.and_then(|name| self.schema.get("$defs")?.get(name)).unwrap_or(schema)
    }

    /// The schema with the one it refers to; alternatives are not looked at.
    fn layers_of(&self, schema: &'a Json) -> Layers<'a> {
        let target = self.target(schema);
        let schemas = if std::ptr::eq(target, schema) { vec![schema] } else { vec![schema, target] };
        Layers { schemas, foreign: Vec::new(), is_kind_unknown: false }
    }

    /// The alternatives of a value, `null` (an absent key) left out.
    fn alternatives(&self, layers: &Layers<'a>) -> Vec<&'a Json> {
        let list = layers.find("oneOf").or_else(|| layers.find("anyOf")).and_then(Json::as_array);
        let is_null = |schema: &&Json| schema.get("type").and_then(Json::as_str) == Some("null");
        list.into_iter().flatten().filter(|schema| !is_null(schema)).collect()
    }

    fn read(
        &mut self,
        schema: &'a Json,
        value: &Spanned<DeValue>,
        path: &str,
        doc: &str,
    ) -> Option<toml::Value> {
        if schema.as_bool() == Some(true) {
            return toml::Value::deserialize(ValueDeserializer::from(value.clone())).ok();
        }
        let mut layers = self.layers_of(schema);
        let doc = values::summary(layers.find("description")).unwrap_or_else(|| doc.to_owned());
        let mut alternatives = self.alternatives(&layers);
        if let [only] = alternatives[..] {
            layers.schemas.extend(self.layers_of(only).schemas);
            alternatives =
                self.alternatives(&Layers { schemas: vec![self.target(only)], ..self.layers_of(only) });
        }
        let span = value.span();
        if let Some(new) = value.get_ref().as_str().and_then(|old| renamed::word(path, old)) {
            self.error(&span, path, true, format!("renamed to \"{new}\""));
            return None;
        }
        if alternatives.iter().any(|schema| self.kind_of(schema).is_some()) {
            let DeValue::Table(table) = value.get_ref() else {
                let message = explain("must be a table that begins { kind = ... }".into(), &doc);
                self.error(&span, path, true, message);
                return None;
            };
            self.choose_kind(&mut layers, &alternatives, table, &span, path);
            return self.read_table(&layers, table, span, path);
        }
        // Words, or a table that its kind tells apart.
        if let (DeValue::Table(_), Some(tables)) = (value.get_ref(), self.tables_among(&alternatives)) {
            return self.read(tables, value, path, &doc);
        }
        if !alternatives.is_empty() {
            match values::choose(&alternatives, value.get_ref()) {
                Ok(schema) => layers.schemas.push(schema),
                Err(message) => {
                    self.error(&span, path, true, explain(message, &doc));
                    return None;
                }
            }
        }
        match value.get_ref() {
            DeValue::Table(table) if values::accepts(layers.find("type"), "object") => {
                self.read_table(&layers, table, span, path)
            }
            DeValue::Array(list) if values::accepts(layers.find("type"), "array") => {
                self.read_array(&layers, list, &span, path, &doc)
            }
            other => self.read_scalar(&layers, other, &span, path, &doc),
        }
    }

    /// The alternative that stands for tables with a `kind`.
    fn tables_among(&self, alternatives: &[&'a Json]) -> Option<&'a Json> {
        let has_kinds = |schema: &&&'a Json| {
            self.alternatives(&self.layers_of(schema)).iter().any(|inner| self.kind_of(inner).is_some())
        };
        alternatives.iter().find(has_kinds).copied()
    }

    /// The value of `kind` that selects a variant.
    fn kind_of(&self, variant: &'a Json) -> Option<&'a str> {
        self.target(variant).get("properties")?.get("kind")?.get("const")?.as_str()
    }

    /// Adds the variant that `kind` names to the layers, or reports that it names none.
    fn choose_kind(
        &mut self,
        layers: &mut Layers<'a>,
        variants: &[&'a Json],
        table: &DeTable,
        span: &Span,
        path: &str,
    ) {
        let kinds: Vec<&str> = variants.iter().filter_map(|v| self.kind_of(v)).collect();
        let written = table.get("kind");
        let name = written.and_then(|kind| kind.get_ref().as_str());
        for variant in variants {
            let Some(kind) = self.kind_of(variant) else { continue };
            let target = self.target(variant);
            if name == Some(kind) {
                layers.schemas.push(target);
            } else if let Some(properties) = target.get("properties").and_then(Json::as_object) {
                layers.foreign.extend(properties.keys().map(|key| (key.as_str(), kind)));
            }
        }
        layers.is_kind_unknown = !name.is_some_and(|name| kinds.contains(&name));
        if layers.is_kind_unknown {
            let path = join(path, "kind");
            match (written, name) {
                (Some(kind), Some(name)) => {
                    self.error(&kind.span(), &path, true, unknown("kind", name, &kinds));
                }
                (Some(kind), None) => {
                    let message = format!("must be a word in quotes: {}", values::words(&kinds));
                    self.error(&kind.span(), &path, true, message);
                }
                _ => self.error(span, &path, false, format!("missing key; one of {}", values::words(&kinds))),
            }
        }
    }

    fn read_table(
        &mut self,
        layers: &Layers<'a>,
        table: &DeTable,
        span: Span,
        path: &str,
    ) -> Option<toml::Value> {
        let mut tree = toml::Table::new();
        let mut is_complete = !layers.is_kind_unknown;
        let mut meant: Vec<&str> = Vec::new();
        for (key, value) in table.iter() {
            let new_name = renamed::key(path, key.get_ref());
            let path = join(path, key.get_ref());
            if let Some(schema) = layers.property(key.get_ref()) {
                match self.read(schema, value, &path, "") {
                    Some(value) => drop(tree.insert(key.get_ref().to_string(), value)),
                    None => is_complete = false,
                }
            } else if let Some(new_name) = new_name {
                self.error(&key.span(), &path, false, format!("renamed to `{new_name}`"));
                is_complete &= path.contains('.');
            } else if !(layers.is_kind_unknown && is_foreign(layers, key.get_ref())) {
                meant.extend(closest(key.get_ref(), layers.keys()));
                let place = self.place_of(&path, key.get_ref());
                let message = unknown_key(layers, key.get_ref(), table) + &place;
                self.error(&key.span(), &path, false, message);
                // A section that goes unread would draw false complaints about what it defines.
                is_complete &= path.contains('.');
            }
        }
        for key in layers.required() {
            if !table.contains_key(key) && key != "kind" {
                is_complete = false;
                if !meant.contains(&key) {
                    let doc = layers.property(key).and_then(|p| values::summary(p.get("description")));
                    let message = explain("missing key".into(), &doc.unwrap_or_default());
                    self.error(&span, &join(path, key), false, message);
                }
            }
        }
        is_complete.then_some(toml::Value::Table(tree))
    }

    /// Where a key belongs that stands in a wrong section, if in one place alone.
    fn place_of(&self, path: &str, key: &str) -> String {
        if path.matches('.').count() != 1 && path != key {
            return String::new();
        }
        let sections = self.layers_of(self.schema);
        if path != key && ["gravity", "name", "seed"].contains(&key) && sections.property(key).is_some() {
            return format!("; `{key}` stands before the first section");
        }
        let holds = |name: &&str| {
            let schema = sections.property(name).map(|schema| self.layers_of(schema));
            schema.is_some_and(|layers| layers.schemas.iter().any(|s| has_property(s, key)))
        };
        match sections.keys().into_iter().filter(holds).collect::<Vec<_>>()[..] {
            [section] => format!("; `{key}` is a key of [{section}]"),
            _ => String::new(),
        }
    }

    fn read_array(
        &mut self,
        layers: &Layers<'a>,
        list: &[Spanned<DeValue>],
        span: &Span,
        path: &str,
        doc: &str,
    ) -> Option<toml::Value> {
        let limit = |keyword| layers.find(keyword).and_then(Json::as_u64).map(|n| n as usize);
        let (min, max) = (limit("minItems").unwrap_or(0), limit("maxItems").unwrap_or(usize::MAX));
        if list.len() < min || list.len() > max {
            let word = if min == 1 { "entry" } else { "entries" };
            let wanted = if min == max { "" } else { "at least " }.to_owned() + &format!("{min} {word}");
            let message = explain(format!("must have {wanted}, not {}", list.len()), doc);
            self.error(span, path, true, message);
            return None;
        }
        let Some(schema) = layers.find("items") else { return Some(toml::Value::Array(Vec::new())) };
        let items: Vec<_> = (list.iter().enumerate())
            .map(|(i, item)| self.read(schema, item, &format!("{path}[{i}]"), doc))
            .collect();
        items.into_iter().collect::<Option<_>>().map(toml::Value::Array)
    }

    fn read_scalar(
        &mut self,
        layers: &Layers<'a>,
        value: &DeValue,
        span: &Span,
        path: &str,
        doc: &str,
    ) -> Option<toml::Value> {
        match values::scalar(&layers.schemas, value, path) {
            Ok((value, None)) => Some(value),
            Ok((value, Some(doubt))) => {
                let remark = self.checker.source.at(span, path, true, explain(doubt, doc));
                self.checker.warnings.push(remark);
                Some(value)
            }
            Err(message) => {
                let is_section = matches!(value, DeValue::Table(_) | DeValue::Array(_));
                self.error(span, path, !is_section, explain(message, doc));
                None
            }
        }
    }
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// The message with the description of its key.
fn explain(message: String, doc: &str) -> String {
    if doc.is_empty() { message } else { format!("{message}. {doc}") }
}

fn is_foreign(layers: &Layers<'_>, key: &str) -> bool {
    key == "kind" || layers.foreign.iter().any(|(other, _)| *other == key)
}

/// Whether a schema itself has a key.
fn has_property(schema: &Json, key: &str) -> bool {
    schema.get("properties").is_some_and(|properties| properties.get(key).is_some())
}

/// The message about a key that the chosen variant does not have.
fn unknown_key(layers: &Layers<'_>, key: &str, table: &DeTable) -> String {
    let owners = layers.foreign.iter().filter(|(other, _)| *other == key);
    let owners: Vec<&str> = owners.map(|(_, kind)| *kind).collect();
    let mut keys = layers.keys();
    match table.get("kind").and_then(|kind| kind.get_ref().as_str()) {
        Some(kind) if !owners.is_empty() => {
            keys.retain(|key| *key != "kind");
            let known = keys.join("`, `");
            let owners = values::words(&owners);
            format!("not a key of kind \"{kind}\" but of {owners} (known keys: `{known}`)")
        }
        _ => unknown("key", key, &keys),
    }
}
