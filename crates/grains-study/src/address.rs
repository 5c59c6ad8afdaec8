//! Where a key of a case stands: `contact[bead, wall].friction`, `insert[0].seed`, `wall.plate.motion.velocity[2]`.
//!
//! Sections that a case has several times are lists. Brackets hold a number counted from 0, the name of an entry, the two
//! materials of a contact or bond in either order, or `*` for all entries. A name without dots may also follow a dot.

use grains_case::closest;
use toml_edit::{DocumentMut, Item, TableLike, Value};

/// A key of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Address {
    written: String,
    parts: Vec<Part>,
}

#[derive(Clone, Debug, PartialEq)]
enum Part {
    Key(String),
    Entry(String),
}

impl Address {
    /// Reads an address.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut parts = Vec::new();
        let mut rest = text.trim();
        while !rest.is_empty() {
            if let Some(inside) = rest.strip_prefix('[') {
                let Some((entry, after)) = inside.split_once(']') else {
                    return Err("has a bracket that is not closed".into());
                };
                parts.push(Part::Entry(entry.trim().to_owned()));
                rest = after;
            } else {
                let key = if parts.is_empty() { rest } else { rest.strip_prefix('.').unwrap_or("") };
                let end = key.find(['.', '[']).unwrap_or(key.len());
                if end == 0 {
                    return Err("has an empty part; an example is `contact[bead, wall].friction`".into());
                }
                parts.push(Part::Key(key[..end].trim().to_owned()));
                rest = &key[end..];
            }
        }
        match parts.first() {
            Some(Part::Key(_)) => Ok(Self { written: text.to_owned(), parts }),
            _ => Err("must begin with a key of the case, as in `contact[bead, wall].friction`".into()),
        }
    }

    /// Gives the key a value; one that is absent is added, and the check of the case says whether it may be.
    ///
    /// # Errors
    /// A part that is not there, with near names.
    pub fn set(&self, case: &mut DocumentMut, value: &Value) -> Result<(), String> {
        set_in_table(case.as_table_mut(), &self.parts, value)
            .map_err(|problem| format!("{}: {problem}", self.written))
    }
}

fn set_in_table(table: &mut dyn TableLike, parts: &[Part], value: &Value) -> Result<(), String> {
    let Some((Part::Key(key), rest)) = parts.split_first() else {
        let here: Vec<&str> = table.iter().map(|(key, _)| key).collect();
        return Err(format!("a table has no entries in brackets; its keys are {}", here.join(", ")));
    };
    if rest.is_empty() {
        let mut value = value.clone();
        match table.get_mut(key).and_then(Item::as_value_mut) {
            Some(old) => {
                *value.decor_mut() = old.decor().clone();
                *old = value;
            }
            None => {
                check_section(key, table.get(key), &value)?;
                table.insert(key, Item::Value(value));
            }
        }
        return Ok(());
    }
    if table.get(key).is_none() {
        let known: Vec<&str> = table.iter().map(|(key, _)| key).collect();
        let is_list = matches!(rest[0], Part::Entry(_));
        let near = closest(key, known.iter().copied());
        if let (true, _) | (_, Some(_)) = (is_list, near) {
            let meant = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
            return Err(format!("the case has no `{key}` there{meant} (there: {})", known.join(", ")));
        }
        table.insert(key, Item::Value(Value::InlineTable(Default::default())));
    }
    match table.get_mut(key) {
        Some(item) => set_in_item(item, key, rest, value),
        None => Ok(()),
    }
}

/// Refuses a value in the place of a section.
fn check_section(key: &str, old: Option<&Item>, value: &Value) -> Result<(), String> {
    let keys = match old {
        Some(Item::Table(table)) if !value.is_inline_table() => table.iter().map(|(key, _)| key).collect(),
        Some(Item::ArrayOfTables(list)) if !value.is_array() => vec![match list.len() {
            0 => "none",
            _ => "[0]",
        }],
        _ => return Ok(()),
    };
    let first = keys.first().copied().unwrap_or_default();
    let example = if first.starts_with('[') { format!("{key}{first}.KEY") } else { format!("{key}.{first}") };
    Err(format!("`{key}` is a section, not a value; name a key in it, such as `{example}`"))
}

fn set_in_item(item: &mut Item, key: &str, parts: &[Part], value: &Value) -> Result<(), String> {
    match item {
        Item::ArrayOfTables(list) => {
            let tables: Vec<&dyn TableLike> = list.iter().map(|table| table as &dyn TableLike).collect();
            let chosen = entries(&tables, tables.len(), key, &parts[0])?;
            for index in chosen {
                if let Some(table) = list.get_mut(index) {
                    set_in_table(table, &parts[1..], value)?;
                }
            }
            Ok(())
        }
        Item::Value(inner) => set_in_value(inner, key, parts, value),
        Item::Table(table) => set_in_table(table, parts, value),
        Item::None => Ok(()),
    }
}

fn set_in_value(inner: &mut Value, key: &str, parts: &[Part], value: &Value) -> Result<(), String> {
    let Some(part) = parts.first() else {
        let mut value = value.clone();
        *value.decor_mut() = inner.decor().clone();
        *inner = value;
        return Ok(());
    };
    match inner {
        Value::InlineTable(table) => set_in_table(table, parts, value),
        Value::Array(list) => {
            let all_tables: Option<Vec<&dyn TableLike>> =
                list.iter().map(|v| v.as_inline_table().map(|table| table as &dyn TableLike)).collect();
            let chosen = entries(&all_tables.unwrap_or_default(), list.len(), key, part)?;
            for index in chosen {
                if let Some(entry) = list.get_mut(index) {
                    set_in_value(entry, key, &parts[1..], value)?;
                }
            }
            Ok(())
        }
        _ => Err(format!("`{key}` is a single value, so nothing can follow it")),
    }
}

/// Numbers of the entries of a list that a part means.
fn entries(tables: &[&dyn TableLike], count: usize, key: &str, part: &Part) -> Result<Vec<usize>, String> {
    let (Part::Entry(word) | Part::Key(word)) = part;
    if word == "*" {
        return Ok((0..count).collect());
    }
    if let Ok(index) = word.parse::<usize>() {
        return if index < count {
            Ok(vec![index])
        } else {
            Err(format!("`{key}` has {count} entries, counted from 0, and no [{index}]"))
        };
    }
    let wanted = in_order(word.split(',').map(str::trim));
    let found: Vec<usize> = (0..tables.len())
        .filter(|&i| name(tables[i]).is_some_and(|name| in_order(name.split(", ")) == wanted))
        .collect();
    if !found.is_empty() {
        return Ok(found);
    }
    let names: Vec<String> = tables.iter().filter_map(|table| name(*table)).collect();
    let meant = closest(word, names.iter().map(String::as_str))
        .map_or(String::new(), |near| format!("; did you mean `{near}`?"));
    let list = if names.is_empty() {
        format!("numbers below {count}")
    } else {
        names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ")
    };
    Err(format!("`{key}` has no entry `{word}`{meant} (there: {list})"))
}

fn in_order<'a>(words: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut words: Vec<&str> = words.collect();
    words.sort_unstable();
    words
}

/// What an entry is called: its name, or its two materials.
fn name(table: &dyn TableLike) -> Option<String> {
    if let Some(name) = table.get("name").and_then(Item::as_str) {
        return Some(name.to_owned());
    }
    let between = table.get("between")?.as_array()?;
    Some(between.iter().filter_map(Value::as_str).collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CASE: &str = r#"# A case.
[time]
end = 1 # s
[[contact]]
between = ["bead", "wall"]
friction = 0.3
[[contact]]
between = ["bead", "bead"]
friction = 0.4 # of glass
[[insert]]
name = "fill"
particles = [{ shape = "bead", diameter = { kind = "uniform", min = 1e-3, max = 2e-3 } }]
[[wall]]
name = "plate 1.5"
motion = { kind = "translation", velocity = [2, 0, 0] }
"#;

    fn set(address: &str, value: impl Into<Value>) -> Result<String, String> {
        let mut case: DocumentMut = CASE.parse().unwrap();
        Address::parse(address)?.set(&mut case, &value.into())?;
        Ok(case.to_string())
    }

    fn replaced(old: &str, new: &str) -> Result<String, String> {
        assert_eq!(CASE.matches(old).count(), 1);
        Ok(CASE.replace(old, new))
    }

    #[test]
    fn every_kind_of_address_finds_its_key_and_leaves_the_rest_as_it_is() {
        assert_eq!(set("time.end", 2.5), replaced("end = 1 #", "end = 2.5 #"));
        let friction = replaced("friction = 0.3", "friction = 0.1");
        assert_eq!(set("contact[wall,bead].friction", 0.1), friction);
        assert_eq!(set("contact[0].friction", 0.1), friction);
        assert_eq!(set("contact[*].friction", 0.1), Ok(friction.unwrap().replace("0.4 #", "0.1 #")));
        assert_eq!(
            set("insert.fill.particles[0].diameter.min", 5e-4),
            replaced("min = 1e-3", "min = 0.0005")
        );
        assert_eq!(set("wall[plate 1.5].motion.velocity[0]", 3), replaced("[2, 0, 0]", "[3, 0, 0]"));
    }

    #[test]
    fn an_absent_key_is_added() {
        let text = set("contact[bead, bead].rolling_friction", 0.05).unwrap();
        assert!(text.contains("friction = 0.4 # of glass\nrolling_friction = 0.05\n"), "{text}");
        let text = set("contact[1].rolling.kind", "spring").unwrap();
        assert!(text.contains("rolling = { kind = \"spring\" }"), "{text}");
    }

    #[test]
    fn what_is_not_there_is_told_with_what_is_near() {
        let refused = |address: &str| set(address, 1).unwrap_err();
        assert!(refused("contact[bead, wal].friction").contains("did you mean `bead, wall`?"));
        assert!(refused("contacts[0].friction").contains("did you mean `contact`?"));
        assert!(refused("insert[1].count").contains("`insert` has 1 entries, counted from 0, and no [1]"));
        assert!(refused("wall[plat].until").contains("(there: `plate 1.5`)"));
        assert!(refused("contact[0.friction").contains("not closed"));
        assert!(refused("[0].friction").contains("must begin with a key"));
        assert!(refused("time..end").contains("empty part"));
        assert!(refused("time.end.now").contains("nothing can follow"));
    }
}
