//! What a file says of its origin.

use hdf5::File;
use hdf5::types::VarLenUnicode;
use std::time::SystemTime;

/// Names and texts: program version, commit, seed, ranks, start, the resolved case.
pub type Metadata = Vec<(String, String)>;

/// Group that holds the metadata as attributes, beside `/VTKHDF`.
pub(crate) const GROUP: &str = "grains-mpi";

/// Now in UTC, as `2026-01-31T12:00:00Z` (ISO 8601).
pub fn utc_now() -> String {
    humantime::format_rfc3339_seconds(SystemTime::now()).to_string()
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
