//! A share of the lines of a CSV file: readers that divide a file among them read each line once.

use std::fs::File;
use std::io::{BufRead, BufReader, Error, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

use crate::diagnostic::CaseErrors;
use crate::text_file::{oddity, read_text, unread};

/// Consecutive lines of a CSV file and the header they stand under.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CsvShare {
    /// Line of the header in the file, from 1.
    pub(crate) header_line: usize,
    /// Names of the columns.
    pub(crate) header: String,
    /// The lines, the header among them if it lies there.
    pub(crate) text: String,
}

impl CsvShare {
    /// Reads share `k` of `n`: the lines that begin in the k-th of n equal parts of the file, counted in bytes.
    ///
    /// # Errors
    /// A file that cannot be read, or is no text in UTF-8.
    pub fn read(path: &Path, (k, n): (usize, usize)) -> Result<Self, CaseErrors> {
        let read = || -> Result<Self, Error> {
            let mut file = BufReader::new(File::open(path)?);
            let (header_line, header) = header(&mut file)?;
            let size = file.get_ref().metadata()?.len();
            let at = |k: usize| (u128::from(size) * k as u128 / n as u128) as u64;
            let text = lines_between(&mut file, at(k), at(k + 1))?;
            Ok(Self { header_line, header, text })
        };
        let share = read().map_err(|error| match error.kind() {
            // What it is instead is seen from the whole of it.
            ErrorKind::InvalidData => read_text(path).err().unwrap_or_else(|| error.to_string()),
            _ => unread(path, &error),
        });
        let checked = share.and_then(|share| match oddity(&share.header) {
            Some(problem) => Err(problem.into()),
            None => Ok(share),
        });
        checked.map_err(|error| {
            let message = format!("cannot read the particle file: {error}");
            CaseErrors::of_file(&path.display().to_string(), message)
        })
    }

    /// The whole of a text.
    pub fn of_text(text: &str) -> Self {
        let mut bytes = text.as_bytes();
        let (header_line, header) = header(&mut bytes).unwrap_or((1, String::new()));
        Self { header_line, header, text: text.to_owned() }
    }

    /// Rows under a header that is the first line of the file, or of what stands for it.
    pub fn of_rows(header: String, rows: String) -> Self {
        Self { header_line: 1, header, text: rows }
    }

    /// Names of the columns.
    pub(crate) fn columns(&self) -> Vec<&str> {
        fields(&self.header)
    }

    /// Rows below the header, `lines_before` lines of the file before this share: their lines in the file, and their fields.
    pub(crate) fn rows(&self, lines_before: usize) -> impl Iterator<Item = (usize, Vec<&str>)> {
        let lines = self.text.lines().enumerate().map(move |(i, text)| (lines_before + i + 1, text.trim()));
        let rows = lines.filter(|(line, text)| *line > self.header_line && is_row(text));
        rows.map(|(line, text)| (line, fields(text)))
    }

    /// Number of lines, empty ones and comments included.
    pub fn lines(&self) -> usize {
        self.text.lines().count()
    }
}

/// The fields of a line, without blanks and quotes.
fn fields(line: &str) -> Vec<&str> {
    line.split(',').map(|field| field.trim().trim_matches('"')).collect()
}

/// Whether a line, trimmed, holds something else than a comment.
fn is_row(line: &str) -> bool {
    !line.is_empty() && !line.starts_with('#')
}

/// Number and text of the first row of a file; number 1 and nothing if it has none.
fn header(file: &mut impl BufRead) -> Result<(usize, String), Error> {
    for (number, line) in (1..).zip(file.lines()) {
        let line = line?;
        let line = line.trim_start_matches('\u{feff}').trim();
        if is_row(line) {
            return Ok((number, line.to_owned()));
        }
    }
    Ok((1, String::new()))
}

/// The lines that begin from byte `start` on and before byte `end`.
fn lines_between(file: &mut (impl BufRead + Seek), start: u64, end: u64) -> Result<String, Error> {
    let mut bytes = Vec::new();
    let mut begin = start;
    // A line begins after a line end, which may be the byte before.
    file.seek(SeekFrom::Start(start.saturating_sub(1)))?;
    if start > 0 {
        begin = start - 1 + file.skip_until(b'\n')? as u64;
    }
    if begin < end {
        file.by_ref().take(end - begin).read_to_end(&mut bytes)?;
        if bytes.last().is_some_and(|&byte| byte != b'\n') {
            file.read_until(b'\n', &mut bytes)?;
        }
    }
    String::from_utf8(bytes).map_err(|_| Error::new(ErrorKind::InvalidData, "it is no text in UTF-8"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    #[test]
    fn shares_hold_every_line_once_whatever_their_number() {
        for text in ["# beads\n\nx,y,z\n1,2,3\n\n4.25,5,6\r\n7,8,9", "x,y,z\n", "\n\n\n", "one line", ""] {
            let size = text.len() as u64;
            for n in 1..=size + 3 {
                let cut = |k: u64| size * k / n;
                let share = |k| lines_between(&mut Cursor::new(text), cut(k), cut(k + 1)).unwrap();
                let shares: Vec<String> = (0..n).map(share).collect();
                assert_eq!(shares.concat(), text, "{n} shares");
                assert_eq!(shares.iter().map(|s| s.lines().count()).sum::<usize>(), text.lines().count());
            }
        }
        let found = header(&mut Cursor::new("\u{feff}# beads\n\n x,y,z \n1,2,3\n")).unwrap();
        assert_eq!(found, (3, "x,y,z".to_owned()));
    }

    #[test]
    fn rows_know_their_lines_among_blank_ones_and_comments() {
        let text = "# beads\n\n x, \"y\" ,z\r\n1,2,3\n\n   \n  # more\n 4.25 ,\"5\",6\r\n\n7,8\n9,10,11";
        let share = CsvShare::of_text(text);
        assert_eq!(share.columns(), ["x", "y", "z"]);
        let rows: Vec<(usize, Vec<&str>)> = share.rows(0).collect();
        let wanted = [
            (4, vec!["1", "2", "3"]),
            (8, vec!["4.25", "5", "6"]),
            (10, vec!["7", "8"]),
            (11, vec!["9", "10", "11"]),
        ];
        assert_eq!(rows, wanted);
    }
}
