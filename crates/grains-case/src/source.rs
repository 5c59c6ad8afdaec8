//! The text of a case file with the place of every key and value.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::diagnostic::{CaseErrors, Diagnostic};
use crate::slips::{other_format, remedy_of_syntax};

/// A parsed case file that can say where a key path stands.
pub(crate) struct Source<'t> {
    file: &'t str,
    text: &'t str,
    root: Spanned<DeTable<'t>>,
}

/// Where a key path was found.
struct Place {
    /// Bytes of the value, or of the innermost table that exists if the key is absent.
    span: Range<usize>,
    /// Whether `span` is a value other than a table, worth quoting.
    quotable: bool,
}

impl<'t> Source<'t> {
    /// Parses the text; a syntax error is reported with its line and column.
    pub(crate) fn parse(file: &'t str, text: &'t str) -> Result<Self, CaseErrors> {
        let (root, errors) = DeTable::parse_recoverable(text);
        let source = Self { file, text, root };
        if errors.is_empty() {
            return Ok(source);
        }
        if let Some(problem) = other_format(text) {
            return Err(CaseErrors(vec![source.remark(0, String::new(), None, problem.into())]));
        }
        let remarks = errors.iter().map(|error| {
            let start = error.span().map_or(text.len(), |span| span.start);
            let remedy = remedy_of_syntax(source.line_at(start), error.message());
            let message = format!("not valid TOML: {}{remedy}", error.message());
            source.remark(start, String::new(), None, message)
        });
        // The parser resumes after an error, but what follows on the same line is an echo.
        let mut remarks: Vec<_> = remarks.collect();
        remarks.sort_by_key(|r| (r.line, r.column));
        remarks.dedup_by_key(|r| r.line);
        Err(CaseErrors(remarks))
    }

    /// The table of the whole file.
    pub(crate) fn root(&self) -> &DeTable<'t> {
        self.root.get_ref()
    }

    /// A remark about the value at a key path such as `wall[2].motion.axis[0]`.
    pub(crate) fn about(&self, path: &str, message: String) -> Diagnostic {
        let place = self.locate(path);
        let value = place.quotable.then(|| self.quote(&place.span));
        self.remark(place.span.start, path.to_owned(), value, message)
    }

    /// A remark about a byte range of the text that belongs to a key path.
    pub(crate) fn at(&self, span: &Range<usize>, path: &str, quoted: bool, message: String) -> Diagnostic {
        let value = quoted.then(|| self.quote(span));
        self.remark(span.start, path.to_owned(), value, message)
    }

    fn remark(&self, offset: usize, key: String, value: Option<String>, message: String) -> Diagnostic {
        let (line, column) = self.position(offset);
        Diagnostic { file: self.file.to_owned(), line, column, key, value, message }
    }

    /// The text of the line of a byte offset.
    fn line_at(&self, offset: usize) -> &'t str {
        self.text.lines().nth(self.position(offset).0 - 1).unwrap_or("")
    }

    /// Line and column (in characters) of a byte offset, both from 1.
    fn position(&self, offset: usize) -> (usize, usize) {
        let mut end = offset.min(self.text.len());
        while !self.text.is_char_boundary(end) {
            end -= 1;
        }
        let before = &self.text[..end];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }

    /// The text of a value on one line, shortened.
    fn quote(&self, span: &Range<usize>) -> String {
        const LONGEST: usize = 60;
        let text = self.text.get(span.clone()).unwrap_or_default();
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        if words.chars().count() <= LONGEST {
            return words;
        }
        words.chars().take(LONGEST).collect::<String>() + "..."
    }

    fn locate(&self, path: &str) -> Place {
        let mut place = Place { span: self.root.span(), quotable: false };
        let mut parts = path.split(['.', '[']).map(|part| part.trim_end_matches(']'));
        let mut next = parts.next().and_then(|key| self.root.get_ref().get(key));
        while let Some(value) = next {
            let is_section = match value.get_ref() {
                DeValue::Table(_) => true,
                DeValue::Array(list) => list.iter().any(|item| item.get_ref().is_table()),
                _ => false,
            };
            place = Place { span: value.span(), quotable: !is_section };
            let Some(part) = parts.next() else { return place };
            next = match value.get_ref() {
                DeValue::Table(table) => table.get(part),
                DeValue::Array(list) => part.parse::<usize>().ok().and_then(|i| list.get(i)),
                _ => None,
            };
        }
        // The key is absent: its table is where it belongs, but there is no value to quote.
        Place { quotable: false, ..place }
    }
}
