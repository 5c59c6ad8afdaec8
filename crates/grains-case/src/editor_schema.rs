//! The schema in the form that editors need: one mistake is one remark.
//!
//! A validator that meets alternatives (`oneOf`, `anyOf`) reports the failure of each. What the types give is therefore rewritten:
//!
//! * tables told apart by `kind` become `if kind = … then …`, so that only the keys of the kind that is meant are looked at;
//! * words told apart become a list of words (`enum`), whose descriptions go into that of the list;
//! * the alternative `null` goes, as TOML has none.

use serde_json::{Map, Value as Json, json};

/// A schema of the types, rewritten.
pub(crate) fn for_editors(mut schema: Json) -> Json {
    rewrite(&mut schema);
    schema
}

fn rewrite(schema: &mut Json) {
    match schema {
        Json::Object(map) => {
            map.values_mut().for_each(rewrite);
            drop_null(map);
            if let Some(Json::Array(alternatives)) = map.get("anyOf") {
                by_type(map, &alternatives.clone());
            }
            if let Some(Json::Array(alternatives)) = map.get("oneOf") {
                let alternatives = alternatives.clone();
                if alternatives.iter().all(|a| kind_of(a).is_some()) {
                    by_kind(map, &alternatives);
                } else if alternatives.iter().all(|a| a.get("const").is_some()) {
                    by_word(map, &alternatives);
                } else {
                    by_type(map, &alternatives);
                }
            }
        }
        Json::Array(list) => list.iter_mut().for_each(rewrite),
        _ => {}
    }
}

/// The word that tells an alternative from the others.
fn kind_of(alternative: &Json) -> Option<&Json> {
    alternative.get("properties")?.get("kind")?.get("const")
}

/// Takes out the type or the alternative `null`; of one alternative that is left the schema takes over what it lacks.
fn drop_null(map: &mut Map<String, Json>) {
    if let Some(Json::Array(types)) = map.get("type") {
        let others: Vec<Json> = types.iter().filter(|name| **name != "null").cloned().collect();
        if let [only] = &others[..] {
            map.insert("type".into(), only.clone());
        }
    }
    let Some(Json::Array(alternatives)) = map.get("anyOf") else { return };
    let is_null = |a: &Json| a.get("type").is_some_and(|name| name == "null");
    let others: Vec<Json> = alternatives.iter().filter(|a| !is_null(a)).cloned().collect();
    if others.len() == alternatives.len() {
        return;
    }
    match &others[..] {
        [Json::Object(only)] => {
            map.remove("anyOf");
            only.iter().for_each(|(key, value)| {
                map.entry(key).or_insert_with(|| value.clone());
            });
        }
        _ => {
            map.insert("anyOf".into(), others.into());
        }
    }
}

/// `oneOf` of tables with a `kind` each as a table whose keys follow from its `kind`.
fn by_kind(map: &mut Map<String, Json>, alternatives: &[Json]) {
    map.remove("oneOf");
    map.remove("unevaluatedProperties");
    map.remove("additionalProperties");
    let common = map.get("properties").and_then(Json::as_object).cloned().unwrap_or_default();
    let words: Vec<(Json, &str)> = alternatives
        .iter()
        .filter_map(|a| {
            Some((kind_of(a)?.clone(), a.get("description").and_then(Json::as_str).unwrap_or("")))
        })
        .collect();
    let mut properties = common.clone();
    properties.insert("kind".into(), list_of(&words, "Kind; it decides which other keys there are:"));
    let mut required = map.get("required").and_then(Json::as_array).cloned().unwrap_or_default();
    if alternatives.iter().all(|a| requires(a, "kind")) {
        required.push("kind".into());
    }
    let branch = |alternative: &Json| {
        let mut own = alternative.get("properties").and_then(Json::as_object).cloned().unwrap_or_default();
        // Those in common are looked at once, outside.
        own.extend(common.keys().map(|key| (key.clone(), Json::Bool(true))));
        let kind = kind_of(alternative);
        let needed = alternative.get("required").and_then(Json::as_array).cloned().unwrap_or_default();
        let needed: Vec<Json> = needed.into_iter().filter(|key| *key != "kind").collect();
        json!({
            "if": {"properties": {"kind": {"const": kind}}, "required": ["kind"]},
            "then": {"properties": own, "required": needed, "additionalProperties": false}
        })
    };
    map.insert("type".into(), "object".into());
    map.insert("allOf".into(), alternatives.iter().map(branch).collect());
    map.insert("properties".into(), properties.into());
    map.insert("required".into(), required.into());
}

/// `oneOf` of words as a list of words.
fn by_word(map: &mut Map<String, Json>, alternatives: &[Json]) {
    map.remove("oneOf");
    let words: Vec<(Json, &str)> = alternatives
        .iter()
        .map(|a| (a["const"].clone(), a.get("description").and_then(Json::as_str).unwrap_or("")))
        .collect();
    let description = map.get("description").and_then(Json::as_str).unwrap_or("").to_string();
    if let Json::Object(list) = list_of(&words, &description) {
        map.extend(list);
    }
}

/// Alternatives that are words or something that is no text, as either of them by whether a text is there.
fn by_type(map: &mut Map<String, Json>, alternatives: &[Json]) {
    let (words, others): (Vec<&Json>, Vec<&Json>) =
        alternatives.iter().partition(|a| a.get("const").is_some());
    let [other] = others[..] else { return };
    if words.is_empty() || other.get("$ref").is_none() {
        return;
    }
    map.remove("oneOf");
    map.remove("anyOf");
    let text = |a: &Json| (a["const"].clone(), a["description"].as_str().unwrap_or("").to_string());
    let words: Vec<(Json, String)> = words.into_iter().map(text).collect();
    let words: Vec<(Json, &str)> = words.iter().map(|(word, text)| (word.clone(), text.as_str())).collect();
    map.insert("if".into(), json!({"type": "string"}));
    map.insert("then".into(), list_of(&words, "One of these words:"));
    map.insert("else".into(), other.clone());
}

/// Words to choose from, each with its description.
fn list_of(words: &[(Json, &str)], description: &str) -> Json {
    let lines = words.iter().map(|(word, text)| format!("\n- {word}: {}", text.replace('\n', " ")));
    let description = format!("{description}\n{}", lines.collect::<String>());
    json!({"type": "string", "enum": words.iter().map(|(word, _)| word).collect::<Vec<_>>(), "description": description})
}

fn requires(alternative: &Json, key: &str) -> bool {
    let list = alternative.get("required").and_then(Json::as_array);
    list.is_some_and(|list| list.iter().any(|name| name == key))
}
