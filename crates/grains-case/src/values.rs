//! Single values against their schema: type, choice, range and plausibility.

use serde_json::Value as Json;
use toml::de::DeValue;

/// First paragraph of a description, on one line.
pub(crate) fn summary(description: Option<&Json>) -> Option<String> {
    let text = description?.as_str()?;
    let paragraph = text.split("\n\n").next().unwrap_or(text);
    Some(paragraph.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// `"a", "b" or "c"`.
pub(crate) fn words(list: &[&str]) -> String {
    let quoted: Vec<String> = list.iter().map(|word| format!("\"{word}\"")).collect();
    match quoted.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => quoted.concat(),
    }
}

/// Whether a schema's `type` (a name or a list of names) admits a type.
pub(crate) fn accepts(types: Option<&Json>, name: &str) -> bool {
    match types {
        Some(Json::String(one)) => one == name,
        Some(Json::Array(several)) => several.iter().any(|one| one == name),
        _ => false,
    }
}

/// JSON's name for the type of a TOML value.
fn type_of(value: &DeValue) -> &'static str {
    match value {
        DeValue::String(_) => "string",
        DeValue::Integer(_) => "integer",
        DeValue::Float(_) => "number",
        DeValue::Boolean(_) => "boolean",
        DeValue::Datetime(_) => "date",
        DeValue::Array(_) => "array",
        DeValue::Table(_) => "object",
    }
}

fn type_in_words(name: &str) -> &'static str {
    match name {
        "string" => "a text in quotes",
        "integer" => "a whole number",
        "number" => "a number",
        "boolean" => "true or false",
        "array" => "a list in brackets",
        "object" => "a table",
        _ => "a date",
    }
}

/// The words a schema admits.
fn choices(schema: &Json) -> Vec<&str> {
    let listed = schema.get("enum").and_then(Json::as_array).into_iter().flatten();
    listed.chain(schema.get("const")).filter_map(Json::as_str).collect()
}

/// The alternative of a type without `kind` that a value belongs to, or what it should have been.
pub(crate) fn choose<'a>(alternatives: &[&'a Json], value: &DeValue) -> Result<&'a Json, String> {
    let known: Vec<&str> = alternatives.iter().flat_map(|schema| choices(schema)).collect();
    let name = type_of(value);
    let is_meant = |schema: &&&Json| match value {
        // A text without choices is any text: a formula.
        DeValue::String(word) => {
            let words = choices(schema);
            words.contains(&word.as_ref()) || words.is_empty() && accepts(schema.get("type"), name)
        }
        _ => accepts(schema.get("type"), name) || name == "integer" && accepts(schema.get("type"), "number"),
    };
    if let Some(schema) = alternatives.iter().find(is_meant) {
        return Ok(schema);
    }
    let others = alternatives.iter().filter(|schema| choices(schema).is_empty());
    let others: Vec<&str> = others.filter_map(|s| s.get("type")?.as_str()).map(type_in_words).collect();
    match value {
        DeValue::String(word) => {
            let or = if others.is_empty() { String::new() } else { format!(", or {}", others.join(", ")) };
            Err(crate::diagnostic::unknown("value", word, &known) + &or + &unquote(word))
        }
        _ => {
            let list = [words(&known)].into_iter().chain(others.iter().map(|s| s.to_string()));
            Err(format!("must be {}, not {}", list.collect::<Vec<_>>().join(" or "), type_in_words(name)))
        }
    }
}

/// Advice for a number that was written as text.
fn unquote(word: &str) -> String {
    let number = word.trim();
    if number.parse::<f64>().is_ok() {
        return format!("; write {number} without quotes");
    }
    let digits = number.find(|c: char| !(c.is_ascii_digit() || ".+-eE_".contains(c))).unwrap_or(0);
    let digits = number[..digits].trim_end_matches(['e', 'E']);
    if digits.parse::<f64>().is_ok() {
        return "; write the number alone, without quotes and unit, in SI units".into();
    }
    String::new()
}

/// A value of the type its schemas ask for, with a doubt if it is unlikely.
///
/// # Errors
/// Why the value is not allowed.
pub(crate) fn scalar(
    schemas: &[&Json],
    value: &DeValue,
    path: &str,
) -> Result<(toml::Value, Option<String>), String> {
    let find = |keyword: &str| schemas.iter().find_map(|schema| schema.get(keyword));
    let types = find("type");
    match value {
        DeValue::String(word) if accepts(types, "string") => {
            let known: Vec<&str> = schemas.iter().flat_map(|schema| choices(schema)).collect();
            if !known.is_empty() && !known.contains(&word.as_ref()) {
                return Err(crate::diagnostic::unknown("value", word, &known));
            }
            Ok((toml::Value::String(word.to_string()), None))
        }
        DeValue::Boolean(flag) if accepts(types, "boolean") => Ok((toml::Value::Boolean(*flag), None)),
        DeValue::Integer(digits) if accepts(types, "integer") => {
            let number = i64::from_str_radix(digits.as_str(), digits.radix())
                .map_err(|_| format!("must not exceed {}", i64::MAX))?;
            check_range(schemas, number as f64).map(|doubt| (toml::Value::Integer(number), doubt))
        }
        DeValue::Integer(digits) if accepts(types, "number") => {
            let number = i64::from_str_radix(digits.as_str(), digits.radix()).map(|n| n as f64);
            let number = number.or_else(|_| digits.as_str().parse()).map_err(|_| "not a number")?;
            check_range(schemas, number).map(|doubt| (toml::Value::Float(number), doubt))
        }
        DeValue::Float(digits) if accepts(types, "number") => {
            let number: f64 = digits.as_str().parse().map_err(|_| "not a number")?;
            check_range(schemas, number).map(|doubt| (toml::Value::Float(number), doubt))
        }
        _ => Err(wrong_type(types, value, path)),
    }
}

fn wrong_type(types: Option<&Json>, value: &DeValue, path: &str) -> String {
    let wanted = match types {
        Some(Json::String(one)) => one.as_str(),
        Some(Json::Array(several)) => several.iter().filter_map(Json::as_str).next().unwrap_or(""),
        _ => "",
    };
    if let ("integer", DeValue::Float(_)) = (wanted, value) {
        return "must be a whole number; write it without point and exponent".into();
    }
    let section: String =
        path.split(['[', '.']).filter(|part| !part.ends_with(']')).collect::<Vec<_>>().join(".");
    let remedy = match (wanted, value) {
        ("number" | "integer", DeValue::String(word)) => unquote(word),
        ("array", DeValue::Table(_)) => format!("; write [[{section}]] for each"),
        ("object", DeValue::Array(_)) => format!("; write [{section}], once"),
        _ => String::new(),
    };
    format!("must be {}, not {}{remedy}", type_in_words(wanted), type_in_words(type_of(value)))
}

/// Largest number of a case, and smallest one that must be positive; their products and powers stay within those of f64.
const LARGEST: f64 = 1e30;
const SMALLEST: f64 = 1e-30;

/// Checks a number against the bounds of its schemas; returns a doubt if it is allowed but unlikely.
fn check_range(schemas: &[&Json], number: f64) -> Result<Option<String>, String> {
    let find = |keyword: &str| schemas.iter().find_map(|schema| schema.get(keyword));
    let bound = |keyword| find(keyword).and_then(Json::as_f64);
    if !number.is_finite() {
        let may_be_infinite = find("x-infinite").is_some() && number == f64::INFINITY;
        return if may_be_infinite { Ok(None) } else { Err("must be a finite number".into()) };
    }
    if number.abs() > LARGEST {
        return Err(format!(
            "beyond {LARGEST:e}: no quantity in SI units is that large: mend the exponent or the unit"
        ));
    }
    let (at_least, above) = (bound("minimum"), bound("exclusiveMinimum"));
    if above == Some(0.0) && number > 0.0 && number < SMALLEST {
        return Err(format!(
            "below {SMALLEST:e}: no quantity in SI units is that small: mend the exponent or the unit"
        ));
    }
    let (at_most, below) = (bound("maximum"), bound("exclusiveMaximum"));
    let is_allowed = at_least.is_none_or(|b| number >= b)
        && above.is_none_or(|b| number > b)
        && at_most.is_none_or(|b| number <= b)
        && below.is_none_or(|b| number < b);
    if !is_allowed {
        let lower = above.map(|b| ("(", "above", b)).or(at_least.map(|b| ("[", "at least", b)));
        let upper = below.map(|b| (")", "below", b)).or(at_most.map(|b| ("]", "at most", b)));
        return Err(match (lower, upper) {
            (Some((open, _, a)), Some((close, _, b))) => format!("must be in {open}{a}, {b}{close}"),
            (Some((_, word, b)), None) | (None, Some((_, word, b))) => format!("must be {word} {b}"),
            (None, None) => "not allowed".into(),
        });
    }
    let plausible = find("x-plausible").and_then(Json::as_array).map(Vec::as_slice);
    let Some([low, high]) = plausible else { return Ok(None) };
    let (low, high) = (low.as_f64().unwrap_or(f64::MIN), high.as_f64().unwrap_or(f64::MAX));
    let is_usual = low <= number && number <= high;
    Ok((!is_usual).then(|| format!("unusual, mostly between {low:?} and {high:?}: check its unit")))
}
