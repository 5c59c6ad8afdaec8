//! The manual says what the program knows: generated pages are current, samples are cases, links lead somewhere.
//!
//! `WRITE_MANUAL=1 cargo test -p grains-case --test manual` writes the pages anew.

#[path = "manual/claims.rs"]
mod claims;
#[path = "manual/examples.rs"]
mod examples;
#[path = "manual/gallery.rs"]
mod gallery;
#[path = "manual/key_pages.rs"]
mod key_pages;
#[path = "manual/links.rs"]
mod links;
#[path = "manual/messages.rs"]
mod messages;
#[path = "manual/samples.rs"]
mod samples;
#[path = "manual/schema_tables.rs"]
mod schema_tables;

use std::path::{Path, PathBuf};

/// The root of the repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().expect("root of the repository")
}

/// All files below a folder of the repository whose name ends like this, in order, without results and what is built.
fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    const LEFT_OUT: [&str; 5] = ["target", "results", ".git", "__pycache__", "node_modules"];
    let mut folders = vec![root().join(folder)];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        let entries = std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        for path in entries.map(|entry| entry.expect("entry").path()) {
            let name = path.file_name().expect("name").to_string_lossy().into_owned();
            if path.is_dir() && !LEFT_OUT.contains(&&*name) {
                folders.push(path);
            } else if name.ends_with(ending) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

fn text_of(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A path as the manual names it.
fn shown(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}

/// A generated page of the repository is as it would be written now; with `WRITE_MANUAL` it is written.
fn must_be_current(path: &str, text: &str) {
    let file = root().join(path);
    if std::env::var_os("WRITE_MANUAL").is_some() {
        std::fs::create_dir_all(file.parent().expect("folder")).expect("folder");
        std::fs::write(&file, text).expect("page");
    }
    let there = std::fs::read_to_string(&file).unwrap_or_default();
    let difference = there.lines().zip(text.lines()).find(|(old, new)| old != new);
    assert!(
        there == text,
        "{path} is not what the program knows now; write it anew: WRITE_MANUAL=1 cargo test -p grains-case --test manual\n{difference:?}"
    );
}
