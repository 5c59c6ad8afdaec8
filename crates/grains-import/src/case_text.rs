//! The text of a case: sections with the commands that gave them.

use crate::report::Source;
use serde::Serialize;
use toml::{Table, Value};

/// A section of a case file.
pub(crate) struct Section {
    heading: String,
    notes: Vec<String>,
    table: Table,
}

impl Section {
    /// A section with the keys of what it describes, except those that have their default.
    pub(crate) fn new(heading: &str, content: &impl Serialize) -> Result<Self, String> {
        let table = Table::try_from(content).map_err(|e| format!("{heading}: {e}"))?;
        Ok(Self { heading: heading.to_owned(), notes: Vec::new(), table: without_defaults(table) })
    }

    /// Adds a key, if there is a value.
    pub(crate) fn with(mut self, key: &str, value: Option<impl Into<Value>>) -> Self {
        if let Some(value) = value {
            self.table.insert(key.to_owned(), value.into());
        }
        self
    }

    /// Says from which commands it is.
    pub(crate) fn from<'a>(mut self, sources: impl IntoIterator<Item = &'a Source>) -> Self {
        for source in sources {
            let note = source.to_string();
            if !self.notes.contains(&note) {
                self.notes.push(note);
            }
        }
        self
    }

    /// Whether it has no key.
    pub(crate) fn is_empty(&self) -> bool {
        self.table.is_empty()
    }

    /// Its text, with an empty line before it.
    pub(crate) fn text(&self) -> String {
        let mut text = String::from("\n");
        self.notes.iter().for_each(|note| text.push_str(&format!("# {note}\n")));
        if !self.heading.is_empty() {
            text.push_str(&format!("{}\n", self.heading));
        }
        for (key, value) in in_order(&self.table) {
            text.push_str(&format!("{key} = {}\n", inline(value)));
        }
        text
    }
}

/// Keys in the order in which people read them; those that are not named here come last, by the alphabet.
const ORDER: [&str; 36] = [
    "name",
    "between",
    "kind",
    "path",
    "shape",
    "material",
    "diameter",
    "density",
    "lower",
    "upper",
    "periodic",
    "outlets",
    "point",
    "center",
    "origin",
    "axis",
    "normal",
    "normal_stiffness",
    "effective_modulus",
    "effective_shear_modulus",
    "youngs_modulus",
    "poissons_ratio",
    "restitution",
    "damping",
    "friction",
    "tangential",
    "rolling_friction",
    "rolling",
    "particles",
    "count",
    "batch",
    "start",
    "interval",
    "from",
    "until",
    "place",
];

fn in_order(table: &Table) -> Vec<(&String, &Value)> {
    let rank = |key: &str| ORDER.iter().position(|k| *k == key).unwrap_or(ORDER.len());
    let mut keys: Vec<_> = table.iter().collect();
    keys.sort_by_key(|(key, _)| rank(key));
    keys
}

/// A value on one line, with at most twelve digits of numbers.
fn inline(value: &Value) -> String {
    let list = |items: Vec<String>| items.join(", ");
    match value {
        Value::Float(x) if x.is_finite() => {
            let rounded: f64 = format!("{x:.11e}").parse().unwrap_or(*x);
            Value::Float(rounded).to_string()
        }
        Value::Array(items) => format!("[{}]", list(items.iter().map(inline).collect())),
        Value::Table(table) => {
            let keys = in_order(table).into_iter().map(|(key, value)| format!("{key} = {}", inline(value)));
            format!("{{ {} }}", list(keys.collect()))
        }
        other => other.to_string(),
    }
}

fn without_defaults(table: Table) -> Table {
    let kept = table.into_iter().map(|(key, value)| {
        let value = match value {
            Value::Table(inner) => Value::Table(without_defaults(inner)),
            Value::Array(items) => Value::Array(items.into_iter().map(in_array).collect()),
            other => other,
        };
        (key, value)
    });
    kept.filter(|(key, value)| !is_default(key, value)).collect()
}

fn in_array(value: Value) -> Value {
    match value {
        Value::Table(inner) => Value::Table(without_defaults(inner)),
        other => other,
    }
}

/// Whether a key has the value that it has without a word.
fn is_default(key: &str, value: &Value) -> bool {
    let text = value.to_string();
    match key {
        "start" | "from" | "phase" | "interval" | "rolling_friction" => text == "0.0",
        "end" | "until" | "height" => text == "inf",
        "scale" => text == "1.0" || text == "{ kind = \"constant\" }",
        "value" | "share" | "softening" | "steps_per_contact" => text == "1.0" || key == "steps_per_contact",
        "velocity" | "angular_velocity" | "translate" | "at" => text == "[0.0, 0.0, 0.0]",
        "orientation" => text == "[1.0, 0.0, 0.0, 0.0]",
        "side" => text == "\"inside\"",
        "caps" => text == "true",
        "facets" => text == "96",
        "twisting" => text == "\"none\"",
        "damping" => text == "{ kind = \"restitution\" }",
        "attraction" => text == "{ kind = \"none\" }",
        "normal" => text == "{ kind = \"linear\" }",
        "accept_coarse_dt" => text == "false",
        "attempts" => text == "1000",
        "noise" => text == "0.0",
        _ => false,
    }
}
