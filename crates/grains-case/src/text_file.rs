//! Text files as other programs leave them: what they hold in place of text in UTF-8, and what to do about it.

use std::io::{Error, ErrorKind};
use std::path::Path;

use crate::check::nearby_file;

/// First bytes of files that hold no text, what these are, and the remedy.
const NO_TEXT: [(&[u8], &str); 5] = [
    (
        b"PK\x03\x04",
        "it is a packed file or a workbook (.zip, .xlsx, .ods); unpack it, or save it as text (.csv)",
    ),
    (b"\x1f\x8b", "it is packed by gzip; unpack it with gunzip"),
    (
        b"\x89HDF\r\n\x1a\n",
        "it is an HDF5 file, as snapshots and checkpoints are; name a text file, such as case.resolved.toml beside it",
    ),
    (
        b"grains-mpi checkpoint",
        "it is a checkpoint, from which --restart goes on; name a text file, such as case.resolved.toml beside it",
    ),
    (b"%PDF", "it is a PDF; name a text file"),
];

/// Marks that begin texts in UTF-16.
const UTF_16: [&[u8]; 2] = [b"\xff\xfe", b"\xfe\xff"];

const OF_UTF_16: &str = "it is text in UTF-16, two bytes per letter, as Windows writes it; save it in UTF-8 (iconv -f utf-16 -t utf-8)";

const OF_ZEROS: &str =
    "it holds bytes of value 0, so it is no text, or was cut off by a full disk; write it anew";

const OLD_LINE_ENDS: &str = "its lines end with a carriage return alone, as on old Macs, so all stand on line 1; save it with the line ends of Unix or Windows";

/// What the first bytes of a file say of one that is no text, and the remedy.
pub fn no_text(bytes: &[u8]) -> Option<&'static str> {
    if UTF_16.iter().any(|mark| bytes.starts_with(mark)) {
        return Some(OF_UTF_16);
    }
    let known = NO_TEXT.iter().find(|(mark, _)| bytes.starts_with(mark));
    known.map(|(_, remedy)| *remedy)
}

/// Reads a text.
///
/// # Errors
/// Why it cannot be read, and what to do, without its name.
pub fn read_text(path: &Path) -> Result<String, String> {
    text_of(std::fs::read(path).map_err(|error| unread(path, &error))?)
}

/// The text that bytes are.
///
/// # Errors
/// What they are instead, and what to do.
pub fn text_of(bytes: Vec<u8>) -> Result<String, String> {
    if let Some(remedy) = no_text(&bytes) {
        return Err(remedy.into());
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let (valid, bytes) = (error.utf8_error().valid_up_to(), error.as_bytes());
        let line = 1 + bytes[..valid].iter().filter(|&&byte| byte == b'\n').count();
        let byte = bytes.get(valid).copied().unwrap_or_default();
        let letter = char::from(byte);
        let letter = if letter.is_alphanumeric() { format!(" (in Latin-1 it is {letter})") } else { String::new() };
        format!(
            "line {line} holds the byte 0x{byte:02x}, which is no text in UTF-8{letter}; save it in UTF-8 (iconv -f latin1 -t utf-8)"
        )
    })?;
    match oddity(&text) {
        Some(remedy) => Err(remedy.into()),
        None => Ok(text),
    }
}

/// What is odd about a text that is valid all the same.
pub fn oddity(text: &str) -> Option<&'static str> {
    let zeros = text.matches('\0').count();
    match text {
        _ if zeros > text.len() / 4 => Some(OF_UTF_16),
        _ if zeros > 0 => Some(OF_ZEROS),
        _ if text.contains('\r') && !text.contains('\n') => Some(OLD_LINE_ENDS),
        _ => None,
    }
}

/// Why a file cannot be opened, with the name of one that may be meant.
pub(crate) fn unread(path: &Path, error: &Error) -> String {
    if path.is_dir() {
        return "it is a folder; name a file in it".into();
    }
    let remedy = match (error.kind(), nearby_file(path)) {
        (ErrorKind::NotFound, Some(name)) => format!("; did you mean `{name}`, which is in that folder?"),
        (ErrorKind::NotFound, None) => "; paths are relative to where the program is started".into(),
        _ => String::new(),
    };
    format!("{error}{remedy}")
}

#[cfg(test)]
mod tests {
    use super::text_of;

    #[test]
    fn what_is_no_text_is_told_with_its_remedy() {
        let utf_16: Vec<u8> = "x = 1\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
        let rows: [(Vec<u8>, &str); 10] = [
            ([b"\xff\xfe", &utf_16[..]].concat(), "UTF-16"),
            (utf_16, "UTF-16"),
            (b"x = 1\n# gr\xf6sse\n".to_vec(), "line 2 holds the byte 0xf6"),
            (b"x = 1\ry = 2\r".to_vec(), "carriage return alone"),
            (b"PK\x03\x04..".to_vec(), "save it as text (.csv)"),
            (b"\x1f\x8b\x08".to_vec(), "gunzip"),
            (b"\x89HDF\r\n\x1a\n".to_vec(), "HDF5"),
            (b"%PDF-1.5".to_vec(), "PDF"),
            (b"x = 1\0".to_vec(), "bytes of value 0"),
            (b"grains-mpi checkpoint\nformat 3\n".to_vec(), "--restart goes on"),
        ];
        for (bytes, words) in rows {
            let message = text_of(bytes).expect_err(words);
            assert!(message.contains(words), "{words}: {message}");
        }
        assert!(text_of("\u{feff}x = 1\r\ny = \"µm\"\r\n".into()).is_ok());
    }
}
