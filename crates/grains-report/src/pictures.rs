//! Pictures of analyses beside the results.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use std::fs;
use std::path::Path;

/// Bytes of all pictures.
const BYTES: usize = 1_000_000;

/// A picture as the page shows it.
#[derive(Debug, Serialize)]
pub struct Picture {
    /// Folder and file.
    name: String,
    /// The picture itself, as an address.
    data: String,
}

/// Pictures in the folders of analyses of a run, and the names of those that would make the page too large.
pub fn read(directory: &Path) -> (Vec<Picture>, Vec<String>) {
    let (mut pictures, mut left_out, mut bytes) = (Vec::new(), Vec::new(), 0);
    for folder in sorted(directory).into_iter().filter(|name| name.starts_with("analysis")) {
        for file in sorted(&directory.join(&folder)) {
            let kind = match file.rsplit_once('.') {
                Some((_, "svg")) => "svg+xml",
                Some((_, "png")) => "png",
                _ => continue,
            };
            let name = format!("{folder}/{file}");
            let path = directory.join(&name);
            let size = fs::metadata(&path).map_or(0, |metadata| metadata.len() as usize);
            if bytes + size > BYTES {
                left_out.push(name);
            } else if let Ok(picture) = fs::read(&path) {
                bytes += size;
                pictures.push(Picture {
                    name,
                    data: format!("data:image/{kind};base64,{}", STANDARD.encode(picture)),
                });
            }
        }
    }
    (pictures, left_out)
}

/// Names in a directory.
fn sorted(directory: &Path) -> Vec<String> {
    let entries = fs::read_dir(directory).into_iter().flatten();
    let mut names: Vec<String> =
        entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
    names.sort();
    names
}
