//! Messages about a case file: file, line, key, value, cause and remedy.

use std::fmt;

/// One remark about a case file or a file it names.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// File as the user named it.
    pub file: String,
    /// Line, counted from 1; 0 when the remark concerns the file as a whole.
    pub line: usize,
    /// Column in characters, counted from 1; 0 when only the line is known.
    pub column: usize,
    /// Key path, as in `wall[2].restitution`; empty for a syntax error.
    pub key: String,
    /// The value as written, if there is one.
    pub value: Option<String>,
    /// What is wrong and what to do about it.
    pub message: String,
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.file)?;
        if self.line > 0 {
            write!(f, "{}:", self.line)?;
        }
        if self.column > 0 {
            write!(f, "{}:", self.column)?;
        }
        match (self.key.as_str(), &self.value) {
            ("", _) => write!(f, " {}", self.message),
            (key, None) => write!(f, " {key}: {}", self.message),
            (key, Some(value)) => write!(f, " {key} = {value}: {}", self.message),
        }
    }
}

/// Everything found wrong with a case, in file order; displayed one remark per line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
pub struct CaseErrors(
    /// The remarks, never empty.
    pub Vec<Diagnostic>,
);

impl CaseErrors {
    /// One remark about a file as a whole.
    pub(crate) fn of_file(file: &str, message: String) -> Self {
        Self(vec![Diagnostic {
            file: file.to_owned(),
            line: 0,
            column: 0,
            key: String::new(),
            value: None,
            message,
        }])
    }
}

/// The known word the writer most likely meant, if one is close enough.
pub fn closest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = word.to_lowercase();
    known
        .into_iter()
        .map(|candidate| (strsim::jaro_winkler(&lower, &candidate.to_lowercase()), candidate))
        .filter(|(likeness, _)| *likeness > 0.8)
        // The first of equals wins, so the answer does not depend on anything but the list.
        .fold(None, |best: Option<(f64, &str)>, next| match best {
            Some(kept) if kept.0 >= next.0 => Some(kept),
            _ => Some(next),
        })
        .map(|(_, candidate)| candidate)
}

/// The message about an unknown word: the one probably meant, and all that are known.
pub(crate) fn unknown(what: &str, word: &str, known: &[&str]) -> String {
    let list = known.iter().map(|k| format!("`{k}`")).collect::<Vec<_>>().join(", ");
    let meant = match closest(word, known.iter().copied()) {
        Some(candidate) => format!("; did you mean `{candidate}`?"),
        None => String::new(),
    };
    let list = if list.is_empty() { "none".to_owned() } else { list };
    format!("unknown {what}{meant} (known {what}s: {list})")
}

/// A computed number for a message, with six digits.
pub(crate) fn rounded(number: f64) -> f64 {
    format!("{number:.5e}").parse().unwrap_or(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_is_recognised_and_a_stranger_is_not() {
        assert_eq!(closest("restitutoin", ["friction", "restitution"]), Some("restitution"));
        assert_eq!(closest("Glass", ["steel", "glass"]), Some("glass"));
        assert_eq!(closest("viscosity", ["radius", "edges"]), None);
    }

    #[test]
    fn the_line_reads_file_line_column_key_value_message() {
        let remark = Diagnostic {
            file: "a.toml".into(),
            line: 3,
            column: 7,
            key: "seed".into(),
            value: Some("-1".into()),
            message: "must be at least 0".into(),
        };
        assert_eq!(remark.to_string(), "a.toml:3:7: seed = -1: must be at least 0");
    }
}
