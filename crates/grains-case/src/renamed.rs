//! Keys and words of earlier versions. A case file that has them is refused with the new name. A case that is stored with
//! results is brought up to date.

use toml::{Table, Value};

/// Section, key of an earlier version, key of today.
const KEYS: [(&str, &str, &str); 4] = [
    ("fluid", "courant", "cfl"),
    ("fluid", "longest_step", "max_dt"),
    ("fluid.coupling", "least_void_fraction", "min_void_fraction"),
    ("fluid.resolved.lubrication", "least_gap", "min_gap"),
];

/// Key with its sections, word of an earlier version, word of today.
const WORDS: [(&str, &str, &str); 1] = [("contact_points.faces", "spread", "patch")];

/// The name that a key of a section has today, if it had this one.
pub(crate) fn key(section: &str, old: &str) -> Option<&'static str> {
    KEYS.iter().find(|(place, name, _)| (*place, *name) == (section, old)).map(|(.., new)| *new)
}

/// The word that a key takes today, if it took this one.
pub(crate) fn word(key: &str, old: &str) -> Option<&'static str> {
    WORDS.iter().find(|(place, name, _)| (*place, *name) == (key, old)).map(|(.., new)| *new)
}

/// Gives the keys and words of a stored case the names of today.
pub fn with_names_of_today(case: &mut Table) {
    for (section, old, new) in KEYS {
        if let Some(Value::Table(table)) = at(case, section)
            && let Some(value) = table.remove(old)
        {
            table.insert(new.into(), value);
        }
    }
    for (key, old, new) in WORDS {
        if let Some(value) = at(case, key).filter(|value| value.as_str() == Some(old)) {
            *value = new.into();
        }
    }
}

/// The value of a key such as `fluid.coupling`.
fn at<'t>(case: &'t mut Table, path: &str) -> Option<&'t mut Value> {
    let (first, rest) = path.split_once('.').unwrap_or((path, ""));
    let value = case.get_mut(first)?;
    rest.split('.').filter(|part| !part.is_empty()).try_fold(value, |value, part| value.get_mut(part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stored_case_gets_the_names_of_today() {
        let mut case: Table = "fluid = { courant = 0.2, coupling = { least_void_fraction = 0.3 } }\ncontact_points.faces = 'spread'"
            .parse()
            .expect("TOML");
        with_names_of_today(&mut case);
        let now: Table =
            "fluid = { cfl = 0.2, coupling = { min_void_fraction = 0.3 } }\ncontact_points.faces = 'patch'"
                .parse()
                .expect("TOML");
        assert_eq!(case, now);
        assert!(KEYS.iter().all(|(section, old, new)| key(section, old) == Some(*new)));
    }
}
