//! TOML files beside the case, read as strictly as it is.

use std::path::Path;

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::Value as Json;

use crate::check::Checker;
use crate::diagnostic::CaseErrors;
use crate::source::Source;
use crate::structure;

/// JSON schema (draft 2020-12) of the files that a type describes, for editors and manuals.
pub fn schema_of<T: JsonSchema>() -> Json {
    structure::schema_of::<T>()
}

/// A file of the type `T`; `file` is its name for messages.
///
/// # Errors
/// Everything that its schema finds wrong, in file order.
pub fn read_toml<T: JsonSchema + DeserializeOwned>(text: &str, file: &str) -> Result<T, CaseErrors> {
    let source = Source::parse(file, text)?;
    let mut checker = Checker::new(&source, Path::new(""));
    let read = structure::read_as(&structure::schema_of_types::<T>(), &mut checker);
    let mut errors = checker.errors;
    errors.sort_by_key(|remark| (remark.line, remark.column));
    read.filter(|_| errors.is_empty()).ok_or(CaseErrors(errors))
}

/// A remark about a key such as `vary.friction.min` of a file, with line and value.
pub fn remark(text: &str, file: &str, key: &str, message: String) -> CaseErrors {
    match Source::parse(file, text) {
        Ok(source) => CaseErrors(vec![source.about(key, message)]),
        Err(errors) => errors,
    }
}
