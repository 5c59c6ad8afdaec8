//! The collector of errors and warnings, and the checks that many sections share.

use std::path::{Path, PathBuf};

use crate::diagnostic::{Diagnostic, closest, unknown};
use crate::source::Source;
use crate::vector::unit;

/// The names defined in a case, in the order of their indices.
pub(crate) struct Names {
    pub materials: Vec<String>,
    pub shapes: Vec<String>,
    pub flow_planes: Vec<String>,
}

/// Collects what is wrong with a case.
///
/// After an error a check returns some value of the right type, so that the remaining checks can run;
/// it never reaches a [`crate::Case`], which is only built without errors.
pub(crate) struct Checker<'s> {
    pub source: &'s Source<'s>,
    base: &'s Path,
    pub errors: Vec<Diagnostic>,
    pub warnings: Vec<Diagnostic>,
}

impl<'s> Checker<'s> {
    /// A checker of a case file in the folder `base`.
    pub(crate) fn new(source: &'s Source<'s>, base: &'s Path) -> Self {
        Self { source, base, errors: Vec::new(), warnings: Vec::new() }
    }

    pub(crate) fn error(&mut self, path: &str, message: String) {
        self.errors.push(self.source.about(path, message));
    }

    pub(crate) fn warn(&mut self, path: &str, message: String) {
        self.warnings.push(self.source.about(path, message));
    }

    pub(crate) fn error_count(&self) -> usize {
        self.errors.len()
    }

    /// The names of a section, each usable as a column heading and given once.
    pub(crate) fn names(&mut self, section: &str, names: Vec<String>) -> Vec<String> {
        for (i, name) in names.iter().enumerate() {
            let path = format!("{section}[{i}].name");
            let is_awkward = |c: char| c.is_control() || "/\\,;#\"'`".contains(c);
            if name.trim().is_empty() || name.trim() != name || name.contains(is_awkward) {
                self.error(
                    &path,
                    "names head columns of tables: use letters, digits, spaces inside, `_`, `-`, `.`".into(),
                );
            } else if let Some(first) = names[..i].iter().position(|other| other == name) {
                self.error(&path, format!("already the name of {section}[{first}]; choose another"));
            }
        }
        names
    }

    /// The index of a name, or an error with the one probably meant.
    pub(crate) fn reference(&mut self, path: &str, name: &str, what: &str, known: &[String]) -> usize {
        if let Some(index) = known.iter().position(|other| other == name) {
            return index;
        }
        let list: Vec<&str> = known.iter().map(String::as_str).collect();
        self.error(path, unknown(what, name, &list));
        0
    }

    /// The direction scaled to unit length.
    pub(crate) fn direction<const N: usize>(&mut self, path: &str, vector: [f64; N]) -> [f64; N] {
        unit(vector).unwrap_or_else(|| {
            self.error(path, "has no direction; at least one component must differ from 0".into());
            vector
        })
    }

    /// Two opposite corners `path.lower` and `path.upper`.
    pub(crate) fn ordered_corners(&mut self, path: &str, lower: [f64; 3], upper: [f64; 3]) {
        for axis in 0..3 {
            if lower[axis] >= upper[axis] {
                self.error(
                    &format!("{path}.upper[{axis}]"),
                    format!("must be above lower[{axis}] = {} m", lower[axis]),
                );
            }
        }
    }

    /// An end (s) that must come after the start `(key, time)`.
    pub(crate) fn ordered_times(&mut self, path: &str, start: (&str, f64), end: f64) {
        if start.1 >= end {
            self.error(path, format!("must be after {} = {} s", start.0, start.1));
        }
    }

    /// The full path of a file that must exist and have one of the extensions.
    pub(crate) fn file(&mut self, key: &str, path: &Path, extensions: &[&str]) -> PathBuf {
        let joined = self.base.join(path);
        let full = std::fs::canonicalize(&joined).or_else(|_| std::path::absolute(&joined)).unwrap_or(joined);
        let extension = full.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        if full.is_dir() {
            self.error(key, format!("{} is a folder; name a file", full.display()));
        } else if !full.is_file() {
            let near = nearby_file(&full)
                .map_or(String::new(), |name| format!("; did you mean `{name}`, which is there?"));
            self.error(
                key,
                format!(
                    "no such file; looked for {}, as paths are relative to the case file{near}",
                    full.display()
                ),
            );
        } else if !extensions.contains(&extension.as_str()) {
            let list = extensions.iter().map(|e| format!(".{e}")).collect::<Vec<_>>().join(", ");
            self.error(key, format!("unknown kind of file; it must end in one of {list}"));
        }
        full
    }
}

/// A file of the same folder whose name is close to that of the missing one.
pub(crate) fn nearby_file(missing: &Path) -> Option<String> {
    let wanted = missing.file_name()?.to_string_lossy().into_owned();
    let folder = missing.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut present: Vec<String> = std::fs::read_dir(folder)
        .ok()?
        .flatten()
        .filter(|entry| entry.path().is_file())
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    // The order of a folder is arbitrary; that of the answer must not be.
    present.sort();
    closest(&wanted, present.iter().map(String::as_str)).map(str::to_owned)
}
