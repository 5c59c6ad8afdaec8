//! What differs between the case of a checkpoint and that of the run that continues it.
//!
//! Cases are compared as trees of keys in which tables are known by their names, and input files by their content.

use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;
use toml::{Table, Value};

/// A key whose value differs.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// Keys from the section on; of an entry of a list its name.
    pub key: Vec<String>,
    /// Value in the checkpoint's case, if it has one.
    pub before: Option<Value>,
    /// Value now, if there is one.
    pub now: Option<Value>,
}

impl Change {
    /// Whether the key begins so.
    pub fn is_within(&self, keys: &[&str]) -> bool {
        self.key.len() >= keys.len() && self.key.iter().zip(keys).all(|(own, key)| own == key)
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let key = self.key.join(".");
        match (&self.before, &self.now) {
            (Some(Value::Table(_)) | None, None) => write!(f, "{key} is gone"),
            (None, Some(Value::Table(_))) => write!(f, "{key} is new"),
            (before, now) => {
                let text =
                    |value: &Option<Value>| value.as_ref().map_or("not given".into(), Value::to_string);
                write!(f, "{key} = {}, was {}", text(now), text(before))
            }
        }
    }
}

/// Keys under which cases name input files.
const INPUT: &str = "path";

/// SHA-256 of a content, as `sha256sum` shows it.
fn sha256(content: &[u8]) -> String {
    Sha256::digest(content).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of a case with its input files, wherever these and its results lie.
///
/// # Errors
/// A text that is no case.
pub fn identity(case: &str, inputs: &str) -> Result<String, String> {
    let mut known = known(case, inputs)?;
    if let Some(Value::Table(output)) = known.get_mut("output") {
        output.remove("directory");
    }
    Ok(sha256(known.to_string().as_bytes()))
}

/// A line with SHA-256 and path of each input file of a case, as a checkpoint holds them and as `sha256sum -c` reads them.
///
/// # Errors
/// A file that cannot be read.
pub fn inputs(case: &str) -> Result<String, String> {
    let mut paths = Vec::new();
    for_each_input(&mut Value::Table(tree(case)?), &mut |path| paths.push(path.clone()));
    paths.sort();
    paths.dedup();
    let line = |path: String| {
        let bytes = std::fs::read(Path::new(&path)).map_err(|e| format!("{path}: {e}"))?;
        Ok(format!("{}  {path}\n", sha256(&bytes)))
    };
    paths.into_iter().map(line).collect()
}

/// A case as a tree, its input files replaced by their hashes as of [`inputs`].
///
/// # Errors
/// A text that is no case.
pub fn known(case: &str, inputs: &str) -> Result<Table, String> {
    let sums: BTreeMap<&str, &str> =
        inputs.lines().filter_map(|line| line.split_once("  ")).map(|(sum, path)| (path, sum)).collect();
    let mut root = Value::Table(tree(case)?);
    for_each_input(&mut root, &mut |path| {
        if let Some(sum) = sums.get(path.as_str()) {
            *path = format!("content {sum}");
        }
    });
    match root {
        Value::Table(table) => Ok(table),
        _ => Err("no table".into()),
    }
}

fn tree(case: &str) -> Result<Table, String> {
    let mut tree = case.parse::<Table>().map_err(|e| e.to_string())?;
    grains_case::with_names_of_today(&mut tree);
    Ok(tree)
}

fn for_each_input(value: &mut Value, found: &mut impl FnMut(&mut String)) {
    match value {
        Value::Table(table) => {
            for (key, value) in table.iter_mut() {
                match value {
                    Value::String(path) if key == INPUT => found(path),
                    value => for_each_input(value, found),
                }
            }
        }
        Value::Array(list) => list.iter_mut().for_each(|value| for_each_input(value, found)),
        _ => {}
    }
}

/// Names of the entries of a section such as `wall`, in their order.
pub fn names(case: &Table, section: &str) -> Vec<String> {
    let list = case.get(section).and_then(Value::as_array).into_iter().flatten();
    list.filter_map(name).collect()
}

/// What an entry of a list is known by: its name, or the materials it is between.
fn name(entry: &Value) -> Option<String> {
    let table = entry.as_table()?;
    match (table.get("name"), table.get("between")) {
        (Some(Value::String(name)), _) => Some(name.clone()),
        (_, Some(Value::Array(pair))) => {
            let mut pair: Vec<&str> = pair.iter().filter_map(Value::as_str).collect();
            pair.sort_unstable();
            Some(pair.join("-"))
        }
        _ => None,
    }
}

/// All that differs between two trees; the order of entries that have names does not count.
pub fn changes(before: &Table, now: &Table) -> Vec<Change> {
    let mut found = Vec::new();
    compare_tables(&mut Vec::new(), before, now, &mut found);
    found
}

fn compare_tables(key: &mut Vec<String>, before: &Table, now: &Table, found: &mut Vec<Change>) {
    let own = before.keys().chain(now.keys().filter(|key| !before.contains_key(*key)));
    for name in own {
        key.push(name.clone());
        compare(key, before.get(name), now.get(name), found);
        key.pop();
    }
}

fn compare(key: &mut Vec<String>, before: Option<&Value>, now: Option<&Value>, found: &mut Vec<Change>) {
    if before == now {
        return;
    }
    // A list that is not there has no entries.
    let entries = |value: Option<&Value>| match value {
        None => Some(Table::new()),
        Some(Value::Array(list)) => list.iter().map(|entry| Some((name(entry)?, entry.clone()))).collect(),
        _ => None,
    };
    match (before, now) {
        (Some(Value::Table(before)), Some(Value::Table(now))) => compare_tables(key, before, now, found),
        _ => match (entries(before), entries(now)) {
            (Some(before), Some(now)) if !before.is_empty() || !now.is_empty() => {
                compare_tables(key, &before, &now, found);
            }
            _ => found.push(Change { key: key.clone(), before: before.cloned(), now: now.cloned() }),
        },
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::{changes, identity, inputs, known, names};

    const CASE: &str = r#"
[time]
end = 1.0
[[contact]]
between = ["a", "b"]
friction = 0.5
[[wall]]
name = "floor"
kind = "plane"
[[wall]]
name = "gate"
until = 0.5
"#;

    #[test]
    fn changes_are_told_by_key_and_name_whatever_the_order() {
        let before = known(CASE, "").unwrap();
        assert_eq!(names(&before, "wall"), ["floor", "gate"]);
        let other = r#"
[time]
end = 2.0
[[contact]]
between = ["b", "a"]
friction = 0.5
[[wall]]
name = "lid"
kind = "plane"
[[wall]]
name = "gate"
until = 0.25
[wall.motion]
kind = "rotation"
[[wall]]
name = "floor"
kind = "plane"
[fluid]
density = 1.0
"#;
        let found = changes(&before, &known(other, "").unwrap());
        let mut texts: Vec<String> = found.iter().map(ToString::to_string).collect();
        texts.sort();
        let wanted = [
            r#"contact.a-b.between = ["b", "a"], was ["a", "b"]"#,
            "fluid is new",
            "time.end = 2.0, was 1.0",
            "wall.gate.motion is new",
            "wall.gate.until = 0.25, was 0.5",
            "wall.lid is new",
        ];
        assert_eq!(texts, wanted);
        assert!(found.iter().any(|change| change.is_within(&["wall", "gate", "until"])));
        assert_eq!(changes(&before, &before), []);
    }

    #[test]
    fn hashes_are_those_of_sha256sum() {
        let empty = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
        assert_eq!(super::sha256(b""), empty);
    }

    #[test]
    fn inputs_are_known_by_content() {
        let folder = std::env::temp_dir().join(format!("grains-inputs-{}", std::process::id()));
        let case_of = |name: &str, text: &str| {
            std::fs::create_dir_all(folder.join(name)).unwrap();
            let path = folder.join(name).join("mesh.stl");
            std::fs::write(&path, text).unwrap();
            let case = format!("[[wall]]\nname = \"m\"\npath = {:?}\n", path.display().to_string());
            let inputs = inputs(&case).unwrap();
            (known(&case, &inputs).unwrap(), identity(&case, &inputs).unwrap())
        };
        let (first, identity) = case_of("here", "solid");
        let (elsewhere, same) = case_of("there", "solid");
        assert_eq!((changes(&first, &elsewhere), &same), (vec![], &identity));
        let (other, another) = case_of("here", "solid!");
        assert_ne!(identity, another);
        let [change] = &changes(&first, &other)[..] else { panic!("one change") };
        assert!(change.to_string().starts_with("wall.m.path = \"content "), "{change}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
