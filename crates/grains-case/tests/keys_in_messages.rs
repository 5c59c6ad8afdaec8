//! Every case key that a message of the program names is one of the format: remedies can be followed.

#![allow(clippy::unwrap_used)]

use serde_json::Value as Json;
use std::fs;
use std::path::{Path, PathBuf};

/// What follows a section's name and a dot in the names of files.
const ENDINGS: [&str; 7] = ["rs", "toml", "csv", "vtkhdf", "xdmf", "h5", "json"];

/// A word of a message that looks like a key, `a.b.c`; `{}` where the program puts in a part of it.
type Word = Vec<String>;

#[test]
fn every_key_in_a_message_is_in_the_schema() {
    let schema = grains_case::schema();
    let (mut wrong, mut looked_at) = (Vec::new(), 0);
    for file in sources() {
        let text = fs::read_to_string(&file).unwrap();
        for literal in literals(without_tests(&text)) {
            for word in dotted(&literal).into_iter().chain(tables(&literal)) {
                if has_child(&schema, &schema, &word[0]) && !ENDINGS.contains(&word[word.len() - 1].as_str())
                {
                    looked_at += 1;
                    if !leads_somewhere(&schema, vec![&schema], &word) {
                        wrong.push(format!("{}: {}", file.display(), word.join(".")));
                    }
                }
            }
            for word in assigned(&literal) {
                looked_at += 1;
                if !is_anywhere(&schema, &word) {
                    wrong.push(format!("{}: {word} = ", file.display()));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(looked_at > 200, "only {looked_at} words look like keys");
}

#[test]
fn a_key_that_is_none_is_found() {
    let schema = grains_case::schema();
    let is_key = |word: &str| {
        let word: Word = word.split('.').map(str::to_owned).collect();
        leads_somewhere(&schema, vec![&schema], &word)
    };
    for none in ["fluid.courant", "fluid.dt", "fluid.coupling.min_void", "time.steps", "wall.motion.speed"] {
        assert!(!is_key(none), "{none}");
    }
    for key in
        ["fluid.cfl", "fluid.coupling.kernel.half_width", "wall.motion.frequency", "insert.place.window.kind"]
    {
        assert!(is_key(key), "{key}");
    }
    let text = "// \"fluid.cfl\"\nlet a = \"lower fluid.cfl, or wall[{i}].motion.{key} of fluid.vtkhdf\"; 'x' \"[[fluid.boundary]] dt = 3\"";
    let found = literals(text);
    assert_eq!(
        dotted(&found[0]),
        [vec!["fluid", "cfl"], vec!["wall", "motion", "{}"], vec!["fluid", "vtkhdf"]]
    );
    assert_eq!(tables(&found[1]), [vec!["fluid", "boundary"]]);
    assert_eq!(assigned("set kind = \\\"cube\\\", x = {x}, retry = true"), ["kind", "retry"]);
}

/// All sources of the program but its tests.
fn sources() -> Vec<PathBuf> {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    // Files of studies have keys of their own.
    let of_cases = |path: &PathBuf| !path.ends_with("grains-study");
    let crates = fs::read_dir(crates).unwrap().map(|entry| entry.unwrap().path());
    let mut folders: Vec<PathBuf> = crates.filter(of_cases).map(|path| path.join("src")).collect();
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).into_iter().flatten() {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs")
                && !name.ends_with("tests")
                && name != "extreme_numbers"
            {
                files.push(path);
            }
        }
    }
    assert!(files.len() > 200, "{} files", files.len());
    files
}

/// A source up to its unit tests, which are at its end.
fn without_tests(text: &str) -> &str {
    text.split("\n#[cfg(test)]\n").next().unwrap_or(text)
}

/// The string literals of a source, comments left out, as they are written.
fn literals(text: &str) -> Vec<String> {
    let bytes = text.as_bytes();
    let (mut found, mut i) = (Vec::new(), 0);
    while i < bytes.len() {
        match bytes[i] {
            b'/' if bytes.get(i + 1) == Some(&b'/') => {
                i += text[i..].find('\n').unwrap_or(text.len() - i);
            }
            b'r' if text[i..].starts_with("r#\"") => {
                let end = text[i + 3..].find("\"#").unwrap();
                found.push(text[i + 3..i + 3 + end].to_owned());
                i += end + 5;
            }
            b'\'' => {
                // A character, not a lifetime.
                let escaped = bytes.get(i + 1) == Some(&b'\\');
                let close = if escaped { text[i + 3..].find('\'').map(|k| k + 3) } else { Some(2) };
                i += match close {
                    Some(k) if bytes.get(i + k) == Some(&b'\'') => k + 1,
                    _ => 1,
                };
            }
            b'"' => {
                let start = i + 1;
                i = start;
                while bytes[i] != b'"' {
                    i += if bytes[i] == b'\\' { 2 } else { 1 };
                }
                found.push(text[start..i].to_owned());
                i += 1;
            }
            _ => i += 1,
        }
    }
    found
}

fn is_of_word(c: char) -> bool {
    c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_'
}

/// Words such as `fluid.cfl` or `wall[{i}].motion.{key}`, without what is in brackets.
fn dotted(literal: &str) -> Vec<Word> {
    let plain = without_brackets(literal);
    let mut words = Vec::new();
    for piece in plain.split(|c: char| !(is_of_word(c) || c == '.' || c == '{' || c == '}')) {
        let piece = piece.trim_matches('.');
        let starts_right = piece.starts_with(|c: char| c.is_ascii_lowercase());
        let parts: Word = piece
            .split('.')
            .map(|part| if part.contains('{') { "{}".into() } else { part.to_owned() })
            .collect();
        if starts_right && parts.len() > 1 && parts.iter().all(|part| !part.is_empty()) {
            words.push(parts);
        }
    }
    words
}

/// A text without what stands in brackets right after a word: `[0]`, `[{i}]`.
fn without_brackets(literal: &str) -> String {
    let (mut out, mut rest) = (String::new(), literal);
    while let Some(open) = rest.find('[') {
        out += &rest[..open];
        rest = &rest[open..];
        match rest.find(']') {
            Some(close) if out.ends_with(is_of_word) => rest = &rest[close + 1..],
            _ => {
                out.push(' ');
                rest = &rest[1..];
            }
        }
    }
    out + rest
}

/// Tables such as `[[fluid.boundary]]` and `[stop]`.
fn tables(literal: &str) -> Vec<Word> {
    let mut words = Vec::new();
    for (open, _) in literal.match_indices('[') {
        let inner = &literal[open + 1..];
        let Some((name, _)) = inner.split_once(']') else { continue };
        let is_apart = !literal[..open].ends_with(is_of_word);
        if is_apart
            && name.starts_with(|c: char| c.is_ascii_lowercase())
            && name.chars().all(|c| is_of_word(c) || c == '.')
        {
            words.push(name.split('.').map(str::to_owned).collect());
        }
    }
    words
}

/// Words that get a value of TOML which is no number: `kind = "cube"`, `retry = true`, `velocity = [0, 0, 0]`.
fn assigned(literal: &str) -> Vec<String> {
    let mut words = Vec::new();
    for (at, _) in literal.match_indices(" = ") {
        let value = &literal[at + 3..];
        if !["\\\"", "\"", "true", "false", "[", "{{"].iter().any(|start| value.starts_with(start)) {
            continue;
        }
        let before = without_brackets(&literal[..at]);
        let word: String = before.chars().rev().take_while(|c| is_of_word(*c)).collect();
        let is_alone = !before[..before.len() - word.len()].ends_with(['.', '}', '`']);
        if is_alone && !word.is_empty() {
            words.push(word.chars().rev().collect());
        }
    }
    words
}

/// A schema with all that it refers to, combines or lists.
fn with_parts<'a>(root: &'a Json, schema: &'a Json) -> Vec<&'a Json> {
    let (mut all, mut open) = (Vec::new(), vec![schema]);
    while let Some(schema) = open.pop() {
        all.push(schema);
        if let Some(reference) = schema.get("$ref").and_then(Json::as_str) {
            open.extend(root.pointer(reference.trim_start_matches('#')));
        }
        for one in ["items", "then", "else", "additionalProperties"] {
            open.extend(schema.get(one));
        }
        for many in ["oneOf", "anyOf", "allOf", "prefixItems"] {
            open.extend(schema.get(many).and_then(Json::as_array).into_iter().flatten());
        }
    }
    all
}

fn children<'a>(root: &'a Json, schema: &'a Json, name: &str) -> Vec<&'a Json> {
    with_parts(root, schema).into_iter().filter_map(|part| part.get("properties")?.get(name)).collect()
}

fn has_child(root: &Json, schema: &Json, name: &str) -> bool {
    !children(root, schema, name).is_empty()
}

/// Whether a path leads somewhere; a part that the program puts in may be anything that is there.
fn leads_somewhere(root: &Json, from: Vec<&Json>, word: &[String]) -> bool {
    match word.split_first() {
        None => !from.is_empty(),
        Some((first, _)) if first == "{}" => !from.is_empty(),
        Some((first, rest)) => {
            let next: Vec<&Json> =
                from.into_iter().flat_map(|schema| children(root, schema, first)).collect();
            !next.is_empty() && leads_somewhere(root, next, rest)
        }
    }
}

/// Whether a key is in any table.
fn is_anywhere(schema: &Json, key: &str) -> bool {
    match schema {
        Json::Object(map) => {
            map.get("properties").is_some_and(|keys| keys.get(key).is_some())
                || map.values().any(|value| is_anywhere(value, key))
        }
        Json::Array(list) => list.iter().any(|value| is_anywhere(value, key)),
        _ => false,
    }
}
