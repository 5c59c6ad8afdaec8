//! What a file says of its origin.

use hdf5::File;
use hdf5::types::VarLenUnicode;
use std::time::{SystemTime, UNIX_EPOCH};

/// Names and texts: program version, commit, seed, ranks, start, the resolved case.
pub type Metadata = Vec<(String, String)>;

/// Group that holds the metadata as attributes, beside `/VTKHDF`.
pub(crate) const GROUP: &str = "grains-mpi";

/// Now in UTC, as `2026-01-31T12:00:00Z` (ISO 8601).
pub fn utc_now() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    utc(seconds)
}

/// Date and time of a number of seconds since 1970 in the proleptic Gregorian calendar.
fn utc(seconds: u64) -> String {
    let is_leap = |year: u64| year.is_multiple_of(4) && !year.is_multiple_of(100) || year.is_multiple_of(400);
    let (mut day, second) = (seconds / 86_400, seconds % 86_400);
    let mut year = 1970;
    while day >= 365 + u64::from(is_leap(year)) {
        day -= 365 + u64::from(is_leap(year));
        year += 1;
    }
    let february = 28 + u64::from(is_leap(year));
    let mut month = 1;
    for length in [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31] {
        if day < length {
            break;
        }
        day -= length;
        month += 1;
    }
    let (hour, minute) = (second / 3600, second / 60 % 60);
    format!("{year:04}-{month:02}-{:02}T{hour:02}:{minute:02}:{:02}Z", day + 1, second % 60)
}

/// Writes metadata as text attributes of a new group.
pub(crate) fn write_metadata(file: &File, group: &str, metadata: &Metadata) -> hdf5::Result<()> {
    let group = file.create_group(group)?;
    for (name, value) in metadata {
        group.new_attr::<VarLenUnicode>().create(name.as_str())?.write_scalar(&text(value)?)?;
    }
    Ok(())
}

/// The metadata of a file.
pub(crate) fn read_metadata(file: &File) -> hdf5::Result<Metadata> {
    let group = file.group(GROUP)?;
    let text = |name: String| {
        let value = group.attr(&name)?.read_scalar::<VarLenUnicode>()?;
        Ok((name, utf8(value.as_bytes())?))
    };
    group.attr_names()?.into_iter().map(text).collect()
}

/// The text of bytes that may be damaged.
pub(crate) fn utf8(bytes: &[u8]) -> hdf5::Result<String> {
    String::from_utf8(bytes.to_vec()).map_err(|_| "a text is damaged".into())
}

/// A text as HDF5 holds it; it cannot hold the character NUL.
pub(crate) fn text(value: &str) -> hdf5::Result<VarLenUnicode> {
    value.replace('\0', " ").parse().map_err(|_| "a text cannot be stored".into())
}

#[cfg(test)]
mod tests {
    use super::utc;

    #[test]
    fn dates_of_known_seconds() {
        assert_eq!(utc(0), "1970-01-01T00:00:00Z");
        assert_eq!(utc(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(utc(1_000_000_000), "2001-09-09T01:46:40Z");
        assert_eq!(utc(4_107_542_399), "2100-02-28T23:59:59Z");
        assert_eq!(utc(4_107_542_400), "2100-03-01T00:00:00Z");
    }
}
