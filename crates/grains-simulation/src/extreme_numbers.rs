//! Cases with one number of any order of magnitude are examined or refused by name: no panic, no hang.

use crate::check::report;
use grains_case::Case;
use std::panic::catch_unwind;
use std::path::Path;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Longest time for one case (s), on a machine that is busy; on a quiet one it takes milliseconds.
const PATIENCE: Duration = Duration::from_secs(60);

/// Byte ranges of the numbers in the values of a TOML text.
fn numbers(text: &str) -> Vec<(usize, usize)> {
    let (mut found, mut begin, mut offset) = (Vec::new(), None, 0);
    for line in text.split_inclusive('\n') {
        let value =
            line.find('=').filter(|_| !line.trim_start().starts_with('#')).map_or(line.len(), |at| at + 1);
        let mut is_quoted = false;
        for (at, c) in line.char_indices().skip_while(|&(at, _)| at < value) {
            is_quoted ^= c == '"';
            let before = line[..at].chars().next_back().unwrap_or(' ');
            let belongs = c.is_ascii_digit() || "+-.eE_".contains(c);
            match begin {
                None if !is_quoted && (c.is_ascii_digit() || c == '-') && " [{,=".contains(before) => {
                    begin = Some(offset + at);
                }
                Some(first) if !belongs => {
                    found.push((first, offset + at));
                    begin = None;
                }
                _ => {}
            }
        }
        offset += line.len();
    }
    found
}

/// What is wrong with how a case is examined, if anything.
fn complaint(text: String) -> Option<String> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        let outcome = catch_unwind(|| {
            let case = Case::parse(&text, "case.toml", Path::new("")).map_err(|e| e.to_string())?;
            report(&case, 1).map_err(|e| e.message)
        });
        let _ = sender.send(match outcome {
            Ok(Ok(_)) => None,
            Ok(Err(message)) if message.starts_with("case.toml:") && !message.contains("NaN") => None,
            Ok(Err(message)) => Some(format!("an error without file and key, or of NaN: {message}")),
            Err(_) => Some("a panic".into()),
        });
    });
    match receiver.recv_timeout(PATIENCE) {
        Ok(complaint) => complaint,
        Err(RecvTimeoutError::Timeout) => Some("a hang".into()),
        Err(RecvTimeoutError::Disconnected) => Some("a thread that ended".into()),
    }
}

#[test]
fn any_order_of_magnitude_is_examined_or_refused_with_file_and_key() {
    let mut complaints = Vec::new();
    for name in ["base", "silo", "drum", "shear", "bed", "gravel"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../mpi-tests/cases").join(name);
        let text = std::fs::read_to_string(path.with_extension("toml")).unwrap();
        for (first, end) in numbers(&text) {
            let old = &text[first..end];
            let is_whole = old.parse::<i64>().is_ok();
            let extremes = ["-1", "1e308", "-1e308", "1e-308", "1e25", "1e9", "-1e12", "1e-9", "1e-25"];
            let whole = ["0", "-1", "10000000000", "9223372036854775807"];
            for new in extremes.iter().chain(whole.iter().filter(|_| is_whole)) {
                let changed = [&text[..first], new, &text[end..]].concat();
                let line = text[..first].lines().count();
                if let Some(complaint) = complaint(changed) {
                    complaints.push(format!("{name}.toml:{line}: {old} -> {new}: {complaint}"));
                }
            }
        }
    }
    assert!(complaints.is_empty(), "{} complaints\n{}", complaints.len(), complaints.join("\n"));
}
