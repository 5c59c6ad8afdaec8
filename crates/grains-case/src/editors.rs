//! The schema as editors want it: every mistake is met by one rule.
//!
//! That of the types offers alternatives, and an editor reports a mistake once for each that does not fit. Here the
//! alternative is chosen by `kind`, words are a list, and the keys of a table are listed in one place.

use serde_json::{Map, Value as Json, json};

/// JSON schema (draft 2020-12) of the case file, for editors and manuals.
pub fn schema() -> Json {
    let mut schema = crate::structure::schema();
    reshape(&mut schema);
    schema
}

fn reshape(schema: &mut Json) {
    match schema {
        Json::Object(map) => {
            map.values_mut().for_each(reshape);
            drop_null(map);
            list_words(map);
            choose_by_kind(map);
        }
        Json::Array(list) => list.iter_mut().for_each(reshape),
        _ => (),
    }
}

/// TOML has no null: of a key that may be absent remains what it may be.
fn drop_null(map: &mut Map<String, Json>) {
    let is_null = |schema: &Json| schema["type"] == "null";
    if let Some(Json::Array(alternatives)) = map.get("anyOf")
        && let [one, null] = &alternatives[..]
        && is_null(null)
        && let Json::Object(one) = one.clone()
    {
        map.remove("anyOf");
        for (key, value) in one {
            map.entry(key).or_insert(value);
        }
    }
    if let Some(Json::Array(types)) = map.get("type")
        && let [one, null] = &types[..]
        && *null == "null"
    {
        let one = one.clone();
        map.insert("type".into(), one);
    }
}

/// Alternatives of single words become a list of them, their descriptions where taplo looks for them.
fn list_words(map: &mut Map<String, Json>) {
    let Some(Json::Array(alternatives)) = map.get("oneOf") else { return };
    let words: Vec<Json> = alternatives.iter().filter_map(|schema| schema.get("const").cloned()).collect();
    if words.len() < alternatives.len() {
        return;
    }
    let said: Vec<Json> = alternatives.iter().map(|schema| schema["description"].clone()).collect();
    map.remove("oneOf");
    map.insert("type".into(), "string".into());
    map.insert("enum".into(), words.into());
    map.insert("x-taplo".into(), json!({"docs": {"enumValues": said}}));
}

/// Alternatives told apart by `kind` become a condition each, and a list of all their keys.
///
/// A key of no alternative is refused by the list; one of another kind by the condition.
fn choose_by_kind(map: &mut Map<String, Json>) {
    let Some(Json::Array(alternatives)) = map.get("oneOf") else { return };
    let kind_of = |schema: &Json| schema["properties"]["kind"].get("const").cloned();
    let kinds: Vec<Json> = alternatives.iter().filter_map(kind_of).collect();
    if kinds.len() < alternatives.len() {
        return;
    }
    let Some(Json::Array(alternatives)) = map.remove("oneOf") else { return };
    let own = |schema: &Json| schema["properties"].as_object().cloned().unwrap_or_default();
    let said: Vec<Json> = alternatives.iter().map(|schema| schema["description"].clone()).collect();
    let shared = map.get("properties").and_then(Json::as_object).cloned().unwrap_or_default();
    let mut all = shared.clone();
    for (key, value) in alternatives.iter().flat_map(own) {
        // What it must be is the business of the condition.
        all.entry(key)
            .or_insert_with(|| value.get("description").map_or(json!({}), |d| json!({"description": d})));
    }
    all.insert(
        "kind".into(),
        json!({"type": "string", "enum": kinds, "x-taplo": {"docs": {"enumValues": said}}}),
    );
    let conditions = alternatives.iter().zip(&kinds).map(|(schema, kind)| {
        let mut properties = own(schema);
        properties.remove("kind");
        let known: Vec<String> = properties.keys().cloned().collect();
        let is_foreign =
            |key: &&String| *key != "kind" && !shared.contains_key(*key) && !known.contains(*key);
        let foreign: Vec<String> = all.keys().filter(is_foreign).cloned().collect();
        properties.extend(foreign.into_iter().map(|key| (key, Json::Bool(false))));
        let required = schema["required"].as_array().cloned().unwrap_or_default();
        let required: Vec<Json> = required.into_iter().filter(|key| *key != "kind").collect();
        json!({
            "if": {"properties": {"kind": {"const": kind}}, "required": ["kind"]},
            "then": {"properties": properties, "required": required}
        })
    });
    let conditions: Vec<Json> = conditions.collect();
    map.insert("allOf".into(), conditions.into());
    map.insert("type".into(), "object".into());
    map.insert("properties".into(), all.into());
    map.remove("unevaluatedProperties");
    map.insert("additionalProperties".into(), false.into());
    let mut required = map.get("required").and_then(Json::as_array).cloned().unwrap_or_default();
    if !required.contains(&json!("kind")) {
        required.push("kind".into());
    }
    map.insert("required".into(), required.into());
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether anything in a schema has more than one alternative that is a table.
    fn tables_by_trial(schema: &Json, place: &str, found: &mut Vec<String>) {
        match schema {
            Json::Object(map) => {
                for word in ["oneOf", "anyOf"] {
                    let alternatives = map.get(word).and_then(Json::as_array).cloned().unwrap_or_default();
                    let is_open = |s: &&Json| {
                        s.get("$ref").is_some() || s.get("properties").is_some() || s["type"] == "null"
                    };
                    if alternatives.iter().filter(is_open).count() > 0 {
                        found.push(place.to_string());
                    }
                }
                map.iter().for_each(|(key, value)| tables_by_trial(value, &format!("{place}/{key}"), found));
            }
            Json::Array(list) => list.iter().for_each(|value| tables_by_trial(value, place, found)),
            _ => (),
        }
    }

    #[test]
    fn no_table_is_found_by_trying_alternatives() {
        let (mut before, mut after) = (Vec::new(), Vec::new());
        tables_by_trial(&crate::structure::schema(), "", &mut before);
        tables_by_trial(&schema(), "", &mut after);
        assert!(before.len() > 15 && after.is_empty(), "{before:?} and then {after:?}");
    }

    #[test]
    fn a_kind_has_its_own_keys_and_refuses_those_of_others() {
        let shape = &schema()["$defs"]["Shape"];
        assert_eq!(shape["additionalProperties"], false);
        assert!(shape["properties"]["radius"].is_object() && shape["properties"]["radios"].is_null());
        let of = |kind: &str| {
            let conditions = shape["allOf"].as_array().into_iter().flatten();
            let of_kind = |c: &&Json| c["if"]["properties"]["kind"]["const"] == kind;
            conditions.into_iter().find(of_kind).map(|c| c["then"].clone()).unwrap_or_default()
        };
        assert_eq!(of("sphere")["required"], json!(["radius"]));
        assert_eq!(of("sphere")["properties"]["semi_axes"], false);
        assert!(of("superellipsoid")["properties"]["semi_axes"].is_object());
        assert!(of("sphere")["properties"].get("name").is_none());
    }
}
